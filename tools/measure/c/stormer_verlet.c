/* Stormer-Verlet, kick - drift - kick, the two half kicks between steps as one, compensated; a is
   what q moves by in the coming step, (e + h p) + h (h g). */
#include "problems.h"

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], a[M], ep[M], g[M], up[M];
    double half = 0.5 * h;
    for (int c = 0; c < M; c++)
        q[c] = y[c];
    force(q, par, g);
    for (int c = 0; c < M; c++) {
        double more = half * g[c];
        p[c] = y[M + c] + more;
        double share = p[c] - y[M + c];
        ep[c] = (y[M + c] - (p[c] - share)) + (more - share);
        a[c] = h * p[c];
    }
    for (long n = 0; n < steps; n++) {
        double check = 0;
        for (int c = 0; c < M; c++) {
            double moved = q[c] + a[c];
            a[c] = (a[c] - (moved - q[c])) + h * p[c];
            q[c] = moved;
            check += moved;
        }
        force(q, par, g);
        for (int c = 0; c < M; c++) {
            a[c] += h * (h * g[c]);
            up[c] = ep[c] + h * g[c];
        }
        if (!(fabs(check + add(p, ep, up, M)) < 1e300))
            return -1;
    }
    for (int c = 0; c < M; c++)
        p[c] += ep[c] - half * g[c];
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
    }
    return steps;
}
