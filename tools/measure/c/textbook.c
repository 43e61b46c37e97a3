/* Methods for q'' = g(q) from their formulas; all but GLM by an author who had not read the engine.

   y holds the values of the method one after the other, (q, p) in each; run() makes `steps` steps
   and returns the evaluations, or -1. With -DCOMPENSATED, q and p (and with several values all that
   do not oscillate) are summed after Kahan. Whether products and sums are fused is an option of the
   compiler. HNW: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I; HLW: Hairer,
   Lubich, Wanner, Geometric Numerical Integration. */
#include "problems.h"

#define EACH for (int c = 0; c < M; c++)

#ifdef COMPENSATED
#define LOST(x) double x[M] = {0}
#define ADD(x, lost, term) do { \
    double term_ = (term) + (lost), sum_ = (x) + term_; \
    (lost) = term_ - (sum_ - (x)); \
    (x) = sum_; \
} while (0)
#else
#define LOST(x) enum { x = 0 }
#define ADD(x, lost, term) ((x) += (term))
#endif
#ifdef COMPENSATED
#define OF(lost) lost[c]
#else
#define OF(lost) lost
#endif

static long finished(const double *restrict y, int n, long evaluations)
{
    for (int c = 0; c < n; c++)
        if (!isfinite(y[c]))
            return -1;
    return evaluations;
}

#if defined VERLET
/* Leapfrog, HLW I (1.17): velocities between the points, here times h. */
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], u[M], g[M];
    LOST(lost_q);
    LOST(lost_u);
    EACH q[c] = y[c];
    force(q, par, g);
    EACH u[c] = h * y[M + c] + h * h / 2 * g[c];
    for (long n = 0; n < steps; n++) {
        EACH ADD(q[c], OF(lost_q), u[c]);
        force(q, par, g);
        EACH ADD(u[c], OF(lost_u), h * h * g[c]);
    }
    EACH {
        y[c] = q[c];
        y[M + c] = (u[c] - h * h / 2 * g[c]) / h;
    }
    return finished(y, D, steps);
}

#elif defined RK4
/* The classical method for q'' = g(q): HNW II.14, the stages of the velocity inserted. */
long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], Q[M], a[M], b[M], k1[M], k2[M], k3[M], k4[M];
    LOST(lost_q);
    LOST(lost_p);
    EACH {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    for (long n = 0; n < steps; n++) {
        force(q, par, k1);
        EACH Q[c] = a[c] = q[c] + h / 2 * p[c];
        force(Q, par, k2);
        EACH Q[c] = a[c] + h * h / 4 * k1[c];
        force(Q, par, k3);
        EACH b[c] = q[c] + h * p[c];
        EACH Q[c] = b[c] + h * h / 2 * k2[c];
        force(Q, par, k4);
        EACH {
            double middle = k2[c] + k3[c];
            ADD(q[c], OF(lost_q), h * p[c] + h * h / 6 * (k1[c] + middle));
            ADD(p[c], OF(lost_p), h / 6 * (k1[c] + k4[c] + 2 * middle));
        }
    }
    EACH {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return finished(y, D, 4 * steps);
}

#elif defined GAUSS
/* Gauss, three stages, HLW II (1.20), as Nystrom's method: Q_i = q + h c_i p + h^2 sum (A A)_ij g_j
   by fixed point, HLW VIII.6, from the parabola through the three forces of the step before, until
   the positions do not change any more or no longer come closer. */
enum { S = 3 };

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    const double r = sqrt(15);
    const double node[S] = {(5 - r) / 10, 0.5, (5 + r) / 10}, b[S] = {5. / 18, 4. / 9, 5. / 18};
    const double a[S][S] = {
        {5. / 36, 2. / 9 - r / 15, 5. / 36 - r / 30},
        {5. / 36 + r / 24, 2. / 9, 5. / 36 - r / 24},
        {5. / 36 + r / 30, 2. / 9 + r / 15, 5. / 36}};
    double aa[S][S], hb[S], qb[S], next[S][S];
    for (int i = 0; i < S; i++) {
        hb[i] = h * b[i];
        qb[i] = h * h * b[i] * (1 - node[i]);
        for (int j = 0; j < S; j++) {
            double sum = 0, product = 1;
            for (int k = 0; k < S; k++) {
                sum += a[i][k] * a[k][j];
                if (k != j)
                    product *= (1 + node[i] - node[k]) / (node[j] - node[k]);
            }
            aa[i][j] = h * h * sum;
            next[i][j] = product; /* Lagrange polynomials of the last step in this one */
        }
    }
    double q[M], p[M], g[S][M], Q[S][M], base[S][M];
    long evaluations = 0;
    LOST(lost_q);
    LOST(lost_p);
    EACH {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    force(q, par, g[0]);
    EACH g[1][c] = g[2][c] = g[0][c];
    for (long n = 0; n < steps; n++) {
        double size = 0, last = INFINITY;
        EACH {
            double first = g[0][c], second = g[1][c], third = g[2][c];
            for (int i = 0; i < S; i++) {
                g[i][c] = next[i][0] * first + next[i][1] * second + next[i][2] * third;
                base[i][c] = q[c] + h * node[i] * p[c];
                Q[i][c] = INFINITY;
            }
            size = fmax(size, fabs(q[c]));
        }
        for (int round = 0;; round++) {
            double change = 0;
            for (int i = 0; i < S; i++)
                EACH {
                    double to = base[i][c] + (aa[i][0] * g[0][c] + aa[i][1] * g[1][c] + aa[i][2] * g[2][c]);
                    double by = fabs(to - Q[i][c]);
                    change = by > change ? by : change;
                    Q[i][c] = to;
                }
            if (change == 0 || (change >= last && change < 1e-14 * size))
                break;
            if (round == 100 || change != change)
                return -1;
            last = change;
            for (int i = 0; i < S; i++)
                force(Q[i], par, g[i]);
            evaluations += S;
        }
        EACH {
            ADD(q[c], OF(lost_q), h * p[c] + (qb[0] * g[0][c] + qb[1] * g[1][c] + qb[2] * g[2][c]));
            ADD(p[c], OF(lost_p), hb[0] * g[0][c] + hb[1] * g[1][c] + hb[2] * g[2][c]);
        }
    }
    EACH {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return finished(y, D, evaluations);
}

#elif defined PAIR
/* An explicit pair of general linear methods with V = diag(1, -1) for q' = p, p' = g(q):
   Q_i = q_1 + u_i q_2 + h sum a_ij P_j, P_i = p_1 + u_i' p_2 + h sum a_ij' g(Q_j), and after them
   q_k = +-q_k + h sum b_kj P_j, p_k = +-p_k + h sum b_kj' g(Q_j). table.h has the weights and the
   stages in their order; what is not known yet has the weight 0, and such terms stand in no program. */
#include "table.h"

#define SUM(weight, n, F) ({ \
    double sum_ = 0; \
    _Pragma("GCC unroll 32") for (int j_ = 0; j_ < n; j_++) if (weight[j_] != 0) sum_ += weight[j_] * F[j_][c]; \
    sum_; \
})

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[2][M], p[2][M], P[NP][M], G[NQ][M], Q[M];
    LOST(lost_q1);
    LOST(lost_q2);
    LOST(lost_p1);
    LOST(lost_p2);
    for (int k = 0; k < 2; k++)
        EACH {
            q[k][c] = y[k * D + c];
            p[k][c] = y[k * D + M + c];
        }
    for (long n = 0; n < steps; n++) {
#define QSTAGE(i) \
    EACH Q[c] = q[0][c] + UQ[i][1] * q[1][c] + h * SUM(AQ[i], NP, P); \
    force(Q, par, G[i]);
#define PSTAGE(i) \
    EACH P[i][c] = p[0][c] + UP[i][1] * p[1][c] + h * SUM(AP[i], NQ, G);
        STAGES
        EACH {
            q[1][c] = -q[1][c];
            p[1][c] = -p[1][c];
#ifdef COMPENSATED
            lost_q2[c] = -lost_q2[c];
            lost_p2[c] = -lost_p2[c];
#endif
            ADD(q[0][c], OF(lost_q1), h * SUM(BQ[0], NP, P));
            ADD(q[1][c], OF(lost_q2), h * SUM(BQ[1], NP, P));
            ADD(p[0][c], OF(lost_p1), h * SUM(BP[0], NQ, G));
            ADD(p[1][c], OF(lost_p2), h * SUM(BP[1], NQ, G));
        }
    }
    for (int k = 0; k < 2; k++)
        EACH {
            y[k * D + c] = q[k][c];
            y[k * D + M + c] = p[k][c];
        }
    return finished(y, 2 * D, NQ * steps);
}

#elif defined MULTISTEP
/* A symmetric multistep method in partial fractions: q moves by h v, v = s + sum alpha_k (x_k - z_k);
   the force is added to s and to x_k' = 2 cos(theta_k) x_k - z_k, z_k' = x_k. Between the points s
   and x hold the whole kick of the last force, at the points half of it. */
#include "table.h"

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], s[M], x[PAIRS][M], z[PAIRS][M], g[M];
    LOST(lost_q);
    LOST(lost_s);
    EACH q[c] = y[c];
    force(q, par, g);
    EACH s[c] = y[M + c] + h / 2 * g[c];
    for (int k = 0; k < PAIRS; k++)
        EACH {
            x[k][c] = y[(2 * k + 1) * D + M + c] + h / 2 * g[c];
            z[k][c] = y[(2 * k + 2) * D + M + c];
        }
    for (long n = 0; n < steps; n++) {
        EACH {
            double v = s[c];
            for (int k = 0; k < PAIRS; k++)
                v += ALPHA[k] * (x[k][c] - z[k][c]);
            ADD(q[c], OF(lost_q), h * v);
        }
        force(q, par, g);
        EACH {
            double kick = h * g[c];
            ADD(s[c], OF(lost_s), kick);
            for (int k = 0; k < PAIRS; k++) {
                double to = (TWICE[k] * x[k][c] - z[k][c]) + kick;
                z[k][c] = x[k][c];
                x[k][c] = to;
            }
        }
    }
    EACH {
        y[c] = q[c];
        y[M + c] = s[c] - h / 2 * g[c];
    }
    return finished(y, D, steps);
}

#elif defined TWO_KICKS
/* A symmetric multivalue method with two kicks a step, see glmref.derive.multistep.TwoKicks: q moves
   by h/2 v, v a sum over the values, before and after the force in the middle; the pairs are turned
   between. Between the points s and x hold the whole kick of the last force, at the points half. */
#include "table.h"

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], s[M], x[PAIRS][M], z[PAIRS][M], g[M];
    LOST(lost_q);
    LOST(lost_s);
    EACH q[c] = y[c];
    force(q, par, g);
    EACH s[c] = y[M + c] + h / 2 * (W * g[c]);
    for (int k = 0; k < PAIRS; k++)
        EACH {
            x[k][c] = y[(2 * k + 1) * D + M + c] + h / 2 * g[c];
            z[k][c] = y[(2 * k + 2) * D + M + c];
        }
    for (long n = 0; n < steps; n++) {
        EACH {
            double v = s[c];
            for (int k = 0; k < PAIRS; k++)
                v += FIRST_X[k] * x[k][c] + FIRST_Z[k] * z[k][c];
            ADD(q[c], OF(lost_q), h / 2 * v);
        }
        force(q, par, g);
        EACH {
            double kick = h * g[c], v = 0;
            ADD(s[c], OF(lost_s), (1 - W) * kick);
            for (int k = 0; k < PAIRS; k++) {
                double to = (TWICE[k] * x[k][c] - z[k][c]) + KICK_X[k] * kick;
                z[k][c] = x[k][c] + KICK_Z[k] * kick;
                x[k][c] = to;
                v += SECOND_X[k] * to + SECOND_Z[k] * z[k][c];
            }
            ADD(q[c], OF(lost_q), h / 2 * (s[c] + v));
        }
        force(q, par, g);
        EACH {
            double kick = h * g[c];
            ADD(s[c], OF(lost_s), W * kick);
            for (int k = 0; k < PAIRS; k++)
                x[k][c] += kick;
        }
    }
    EACH {
        y[c] = q[c];
        y[M + c] = s[c] - h / 2 * (W * g[c]);
    }
    return finished(y, D, steps);
}

#elif defined GLM
/* A general linear method with diagonally implicit stages, Butcher, Numerical Methods for Ordinary
   Differential Equations, 5: Y_i = sum u_ij y_j + h sum a_ij F_j, then y_i = sum v_ij y_j +
   h sum b_ij F_j. For q'' = g(q) a stage with a = a_ii is Q = b + (h a)^2 g(Q), by fixed point from
   the parabola through the three latest forces at different times, up to the end that GAUSS has.
   Values that V multiplies by 1 or -1 are compensated. table.h has A, U, B, V and C. */
#include "table.h"

#define SUM(weight, n, F) ({ \
    double sum_ = 0; \
    _Pragma("GCC unroll 32") for (int j_ = 0; j_ < n; j_++) if (weight[j_] != 0) sum_ += weight[j_] * F[j_][c]; \
    sum_; \
})
#define EVERY(i, n) _Pragma("GCC unroll 32") for (int i = 0; i < n; i++)

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[R][M], p[R][M], lost_q[R][M] = {0}, lost_p[R][M] = {0}, P[S][M], G[S][M];
    double predict[S][S] = {{0}}, time[S];
    long evaluations = 0;
    for (int i = 0; i < S; i++) {
        int node[3], nodes = 0;
        for (int back = 0; back < S && nodes < 3; back++) {
            int j = back < i ? i - 1 - back : S - 1 - (back - i), fresh = 1;
            time[j] = back < i ? C[j] : C[j] - 1;
            for (int k = 0; k < nodes; k++)
                fresh &= time[node[k]] != time[j];
            if (fresh)
                node[nodes++] = j;
        }
        for (int k = 0; k < nodes; k++) {
            predict[i][node[k]] = 1;
            for (int l = 0; l < nodes; l++)
                if (l != k)
                    predict[i][node[k]] *= (C[i] - time[node[l]]) / (time[node[k]] - time[node[l]]);
        }
    }
    for (int k = 0; k < R; k++)
        EACH {
            q[k][c] = y[k * D + c];
            p[k][c] = y[k * D + M + c];
        }
    force(q[0], par, G[0]);
    for (int i = 1; i < S; i++)
        EACH G[i][c] = G[0][c];
    for (long n = 0; n < steps; n++) {
        double size = 0;
        EACH size = fmax(size, fabs(q[0][c]));
        EVERY(i, S) {
            double Q[M], base[M], ha = h * A[i][i];
            EACH {
                Q[c] = SUM(U[i], R, q) + h * SUM(A[i], i, P);
                P[i][c] = SUM(U[i], R, p) + h * SUM(A[i], i, G);
                base[c] = Q[c] + ha * P[i][c];
            }
            if (A[i][i] == 0) {
                force(Q, par, G[i]);
                evaluations++;
                continue;
            }
            double last = INFINITY, guess[M];
            EACH {
                guess[c] = 0;
                EVERY(j, S) if (predict[i][j] != 0) guess[c] += predict[i][j] * G[j][c];
                Q[c] = INFINITY;
            }
            EACH G[i][c] = guess[c];
            for (int round = 0;; round++) {
                double change = 0;
                EACH {
                    double to = base[c] + ha * ha * G[i][c], by = fabs(to - Q[c]);
                    change = by > change ? by : change;
                    Q[c] = to;
                }
                if (change == 0 || (change >= last && change < 1e-14 * size))
                    break;
                if (round == 100 || change != change)
                    return -1;
                last = change;
                force(Q, par, G[i]);
                evaluations++;
            }
            EACH P[i][c] += ha * G[i][c];
        }
        EACH {
            double to_q[R], to_p[R];
            EVERY(k, R) {
                to_q[k] = SUM(V[k], R, q);
                to_p[k] = SUM(V[k], R, p);
            }
            EVERY(k, R) {
                q[k][c] = to_q[k];
                p[k][c] = to_p[k];
                if (V[k][k] == 1 || V[k][k] == -1) {
                    lost_q[k][c] *= V[k][k];
                    lost_p[k][c] *= V[k][k];
                    ADD(q[k][c], lost_q[k][c], h * SUM(B[k], S, P));
                    ADD(p[k][c], lost_p[k][c], h * SUM(B[k], S, G));
                } else {
                    q[k][c] += h * SUM(B[k], S, P);
                    p[k][c] += h * SUM(B[k], S, G);
                }
            }
        }
    }
    for (int k = 0; k < R; k++)
        EACH {
            y[k * D + c] = q[k][c];
            y[k * D + M + c] = p[k][c];
        }
    return finished(y, R * D, evaluations);
}
#endif
