/* Stormer-Verlet, kick - drift - kick, the last force kept, compensated summation. */
#include "problems.h"

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], eq[M] = {0}, ep[M] = {0}, g[M], uq[M], up[M], Q[M];
    double half = h * 0.5;
    for (int c = 0; c < M; c++) {
        q[c] = y[c];
        p[c] = y[M + c];
    }
    force(q, par, g);
    for (long n = 0; n < steps; n++) {
        for (int c = 0; c < M; c++) {
            up[c] = ep[c] + half * g[c];
            uq[c] = eq[c] + h * (p[c] + up[c]);
            Q[c] = q[c] + uq[c];
        }
        force(Q, par, g);
        for (int c = 0; c < M; c++)
            up[c] += half * g[c];
        if (!(fabs(add(q, eq, uq, M) + add(p, ep, up, M)) < 1e300))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return steps;
}
