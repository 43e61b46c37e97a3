/* Four methods for q'' = g(q), each as a textbook states it, in an order of operations of its own.

   -DVERLET: kick and drift in turn, the half drifts of neighbouring steps as one.
   -DRK4: the classical Runge-Kutta method with slopes k1..k4 of y = (q, p).
   -DGAUSS: Gauss with three stages; all slopes of p from those before until they stand still, the
     first ones from the polynomial through the last step's.
   -DPAIR: table.h holds PASSES and STAGES; the values are q1, p1, q2, p2 and the stages come in
     turn, as in an explicit partitioned general linear method.

   With -DCOMPENSATED sums over steps are compensated (Kahan). */
#include "problems.h"

#ifdef COMPENSATED
#define ADD(x, e, dx) do { double u_ = (dx) + (e), s_ = (x) + u_; (e) = u_ - (s_ - (x)); (x) = s_; } while (0)
#else
#define ADD(x, e, dx) ((x) += (dx))
#endif

static int finite_sum(const double *q, const double *p)
{
    double sum = 0;
    for (int c = 0; c < M; c++)
        sum += q[c] + p[c];
    return fabs(sum) < 1e300;
}

#if defined VERLET
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], eq[M] = {0}, ep[M] = {0}, g[M];
    for (int c = 0; c < M; c++) {
        p[c] = y[M + c];
        q[c] = y[c] + 0.5 * h * p[c];
    }
    for (long n = 0; n < steps; n++) {
        force(q, par, g);
        for (int c = 0; c < M; c++) {
            ADD(p[c], ep[c], h * g[c]);
            ADD(q[c], eq[c], h * p[c]);
        }
        if (!finite_sum(q, p))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c] - 0.5 * h * p[c];
        y[M + c] = p[c];
    }
    return steps;
}
#elif defined RK4
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], eq[M] = {0}, ep[M] = {0};
    double Q[M], k1[M], k2[M], k3[M], k4[M], p2[M], p3[M], p4[M];
    for (int c = 0; c < M; c++) {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    for (long n = 0; n < steps; n++) {
        force(q, par, k1);
        for (int c = 0; c < M; c++) {
            Q[c] = q[c] + h / 2 * p[c];
            p2[c] = p[c] + h / 2 * k1[c];
        }
        force(Q, par, k2);
        for (int c = 0; c < M; c++) {
            Q[c] = q[c] + h / 2 * p2[c];
            p3[c] = p[c] + h / 2 * k2[c];
        }
        force(Q, par, k3);
        for (int c = 0; c < M; c++) {
            Q[c] = q[c] + h * p3[c];
            p4[c] = p[c] + h * k3[c];
        }
        force(Q, par, k4);
        for (int c = 0; c < M; c++) {
            ADD(q[c], eq[c], h / 6 * (p[c] + 2 * (p2[c] + p3[c]) + p4[c]));
            ADD(p[c], ep[c], h / 6 * (k1[c] + 2 * (k2[c] + k3[c]) + k4[c]));
        }
        if (!finite_sum(q, p))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return 4 * steps;
}
#elif defined GAUSS
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    const double r = sqrt(15.0);
    const double a[3][3] = {
        {5.0 / 36, 2.0 / 9 - r / 15, 5.0 / 36 - r / 30},
        {5.0 / 36 + r / 24, 2.0 / 9, 5.0 / 36 - r / 24},
        {5.0 / 36 + r / 30, 2.0 / 9 + r / 15, 5.0 / 36}};
    const double b[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18}, c3[3] = {0.5 - r / 10, 0.5, 0.5 + r / 10};
    double q[M], p[M], eq[M] = {0}, ep[M] = {0}, k[3][M], old[3][M], Q[3][M], last[3][M], w[3][3];
    double aa[3][3], ba[3];
    long evaluations = 0;
    for (int i = 0; i < 3; i++) {
        ba[i] = 0;
        for (int j = 0; j < 3; j++) {
            aa[i][j] = 0;
            for (int l = 0; l < 3; l++)
                aa[i][j] += a[i][l] * a[l][j];
            w[i][j] = 1; /* the polynomial through the old slopes at 1 + c_i */
            for (int l = 0; l < 3; l++)
                if (l != j)
                    w[i][j] *= (1 + c3[i] - c3[l]) / (c3[j] - c3[l]);
        }
        for (int l = 0; l < 3; l++)
            ba[i] += b[l] * a[l][i];
    }
    for (int c = 0; c < M; c++) {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    force(q, par, old[0]);
    for (int c = 0; c < M; c++)
        old[1][c] = old[2][c] = old[0][c];
    for (long n = 0; n < steps; n++) {
        double before = 1e300;
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < M; c++)
                k[i][c] = w[i][0] * old[0][c] + w[i][1] * old[1][c] + w[i][2] * old[2][c];
        for (int round = 0;; round++) {
            double change = 0, size = 0;
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < M; c++) {
                    Q[i][c] = q[c] + (h * c3[i] * p[c]
                        + h * h * (aa[i][0] * k[0][c] + aa[i][1] * k[1][c] + aa[i][2] * k[2][c]));
                    if (round)
                        change += fabs(Q[i][c] - last[i][c]);
                    size += fabs(Q[i][c]);
                    last[i][c] = Q[i][c];
                }
            if (round && (change == 0 || (change >= before && change <= 1e-14 * size)))
                break;
            if (round)
                before = change;
            if (round > 100)
                return -1;
            for (int i = 0; i < 3; i++)
                force(Q[i], par, k[i]);
            evaluations += 3;
        }
        for (int c = 0; c < M; c++) {
            ADD(q[c], eq[c], h * p[c] + h * h * (ba[0] * k[0][c] + ba[1] * k[1][c] + ba[2] * k[2][c]));
            ADD(p[c], ep[c], h * (b[0] * k[0][c] + b[1] * k[1][c] + b[2] * k[2][c]));
            for (int i = 0; i < 3; i++)
                old[i][c] = k[i][c];
        }
        if (!finite_sum(q, p))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return evaluations;
}
#elif defined PAIR
/* table.h: STAGES lists Q(i) and P(i) in order, PQ, PP, PA, ... the numbers of the method:
   Q_i = U[i][0] q1 + U[i][1] q2 + h sum A[i][j] P_j and so on, V = diag(1, -1). */
#include "table.h"
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[2][M], p[2][M], eq[2][M] = {{0}}, ep[2][M] = {{0}}, Pv[NP][M], F[NQ][M], Q[M];
    double haq[NQ][NP], hap[NP][NQ], hbq[2][NP], hbp[2][NQ];
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < M; c++) {
            q[k][c] = y[k * D + c];
            p[k][c] = y[k * D + M + c];
        }
    for (int i = 0; i < NQ; i++)
        for (int j = 0; j < NP; j++) {
            haq[i][j] = h * AQ[i][j];
            hap[j][i] = h * AP[j][i];
        }
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < NP; j++)
            hbq[k][j] = h * BQ[k][j];
        for (int i = 0; i < NQ; i++)
            hbp[k][i] = h * BP[k][i];
    }
    for (long n = 0; n < steps; n++) {
#define QSTAGE(i) \
    for (int c = 0; c < M; c++) { \
        double s = 0; \
        for (int j = 0; j < NP; j++) if (AQ[i][j] != 0) s += haq[i][j] * Pv[j][c]; \
        Q[c] = UQ[i][0] * q[0][c] + (UQ[i][1] * q[1][c] + s); \
    } \
    force(Q, par, F[i]);
#define PSTAGE(i) \
    for (int c = 0; c < M; c++) { \
        double s = 0; \
        for (int j = 0; j < NQ; j++) if (AP[i][j] != 0) s += hap[i][j] * F[j][c]; \
        Pv[i][c] = UP[i][0] * p[0][c] + (UP[i][1] * p[1][c] + s); \
    }
        STAGES
        for (int c = 0; c < M; c++) {
            double dq = 0, dp = 0, dq2 = 0, dp2 = 0;
            for (int j = 0; j < NP; j++) { dq += hbq[0][j] * Pv[j][c]; dq2 += hbq[1][j] * Pv[j][c]; }
            for (int j = 0; j < NQ; j++) { dp += hbp[0][j] * F[j][c]; dp2 += hbp[1][j] * F[j][c]; }
            q[1][c] = -q[1][c]; eq[1][c] = -eq[1][c];
            p[1][c] = -p[1][c]; ep[1][c] = -ep[1][c];
            ADD(q[0][c], eq[0][c], dq);
            ADD(p[0][c], ep[0][c], dp);
            ADD(q[1][c], eq[1][c], dq2);
            ADD(p[1][c], ep[1][c], dp2);
        }
        if (!finite_sum(q[0], p[0]))
            return -1;
    }
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < M; c++) {
            y[k * D + c] = q[k][c];
            y[k * D + M + c] = p[k][c];
        }
    return NQ * steps;
}
#endif
