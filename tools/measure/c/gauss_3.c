/* Gauss with three stages, increments L_i = h b_i f(Y_i), Y_i = y + (e + sum mu_ij L_j) with
   mu_ij + mu_ji = 1 exactly, fixed point to round-off from the polynomial through the last step. */
#include "problems.h"

static const double MU[3][3] = {
    {0.5, -0.08094750193111255, 0.03524199845511},
    {1.0809475019311126, 0.5, -0.08094750193111255},
    {0.96475800154489, 1.0809475019311126, 0.5},
};
static const double GUESS[3][3] = {
    {2.0423388845975277, -0.9391805448271527, 0.4603499871259164},
    {7.398924451310621, -5.666666666666666, 3.267742215356044},
    {8.20631667954075, -7.394152788506182, 4.624327782069139},
};
static const double B[3] = {0.2777777777777778, 0.4444444444444444, 0.2777777777777778};

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], eq[M] = {0}, ep[M] = {0}, g[M], uq[M], up[M], t[M];
    double Lq[3][M], Lp[3][M], K[3][M], Y[3][M], N[3][M];
    double hb[3] = {h * B[0], h * B[1], h * B[2]};
    long evaluations = 0;
    for (int c = 0; c < M; c++) {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    force(q, par, g);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < M; c++) {
            Lq[i][c] = h * B[i] * p[c];
            Lp[i][c] = h * B[i] * g[c];
        }
    for (long n = 0; n < steps; n++) {
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < M; c++)
                K[i][c] = Lp[i][c];
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < M; c++)
                Lp[i][c] = GUESS[i][0] * K[2][c] + GUESS[i][1] * K[1][c] + GUESS[i][2] * K[0][c];
        for (int c = 0; c < M; c++)
            t[c] = fabs(q[c]) + fabs(Lq[0][c]) + fabs(Lq[1][c]) + fabs(Lq[2][c]);
        double size = total(t), last = 1e300;
        int stalls = 0, rounds = 0;
        for (;;) {
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < M; c++)
                    Lq[i][c] = hb[i] * (p[c] + ((ep[c] + MU[i][0] * Lp[0][c])
                        + (MU[i][1] * Lp[1][c] + MU[i][2] * Lp[2][c])));
            for (int i = 0; i < 3; i++)
                for (int c = 0; c < M; c++)
                    N[i][c] = q[c] + ((eq[c] + MU[i][0] * Lq[0][c])
                        + (MU[i][1] * Lq[1][c] + MU[i][2] * Lq[2][c]));
            double change = 0;
            if (rounds > 0) {
                for (int c = 0; c < M; c++)
                    t[c] = fabs(N[0][c] - Y[0][c]) + fabs(N[1][c] - Y[1][c])
                        + fabs(N[2][c] - Y[2][c]);
                change = total(t);
            }
            int end = settled(change, size, &last, &stalls, rounds);
            if (end < 0)
                return -1;
            if (end)
                break;
            rounds++;
            for (int i = 0; i < 3; i++) {
                for (int c = 0; c < M; c++)
                    Y[i][c] = N[i][c];
                force(Y[i], par, g);
                for (int c = 0; c < M; c++)
                    Lp[i][c] = hb[i] * g[c];
            }
        }
        evaluations += 3 * rounds;
        for (int c = 0; c < M; c++) {
            uq[c] = eq[c] + (Lq[0][c] + Lq[1][c] + Lq[2][c]);
            up[c] = ep[c] + (Lp[0][c] + Lp[1][c] + Lp[2][c]);
        }
        if (!(fabs(add(q, eq, uq, M) + add(p, ep, up, M)) < 1e300))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return evaluations;
}
