/* The force of N bodies on each other, q laid out as (x, y, z) of each body; -DPAIRS: every pair once,
   as the engine's loop; else the pulled body inside, positions apart by direction, which the compiler
   packs into vectors: every pair twice, and the same sums in the same order. */
#include <math.h>

void force(const double *restrict q, const double *restrict mass, double *restrict g, long n)
{
#ifdef PAIRS
    for (long c = 0; c < 3 * n; c++)
        g[c] = 0;
    for (long i = 0; i < n; i++)
        for (long j = 0; j < i; j++) {
            double dx = q[3 * i] - q[3 * j];
            double dy = q[3 * i + 1] - q[3 * j + 1];
            double dz = q[3 * i + 2] - q[3 * j + 2];
            double r2 = dx * dx + dy * dy + dz * dz;
            double w = 1 / (r2 * sqrt(r2)), wi = w * mass[i], wj = w * mass[j];
            g[3 * i] -= wj * dx;
            g[3 * i + 1] -= wj * dy;
            g[3 * i + 2] -= wj * dz;
            g[3 * j] += wi * dx;
            g[3 * j + 1] += wi * dy;
            g[3 * j + 2] += wi * dz;
        }
#else
    double x[n], y[n], z[n], a[n], b[n], c[n];
    for (long i = 0; i < n; i++) {
        x[i] = q[3 * i];
        y[i] = q[3 * i + 1];
        z[i] = q[3 * i + 2];
        a[i] = b[i] = c[i] = 0;
    }
    for (long j = 0; j < n; j++) {
        double xj = x[j], yj = y[j], zj = z[j], m = mass[j];
        for (long i = 0; i < n; i++) {
            double dx = x[i] - xj, dy = y[i] - yj, dz = z[i] - zj;
            double r2 = dx * dx + dy * dy + dz * dz + (i == j); /* itself: at no distance, no force */
            double w = 1 / (r2 * sqrt(r2)) * m;
            a[i] -= w * dx;
            b[i] -= w * dy;
            c[i] -= w * dz;
        }
    }
    for (long i = 0; i < n; i++) {
        g[3 * i] = a[i];
        g[3 * i + 1] = b[i];
        g[3 * i + 2] = c[i];
    }
#endif
}

/* Evaluations one after the other, each a little beside the result of the one before. */
long run(double *restrict q, const double *restrict mass, double n, long times)
{
    long bodies = (long)n;
    double g[3 * bodies];
    for (long k = 0; k < times; k++) {
        force(q, mass, g, bodies);
        for (long c = 0; c < 3 * bodies; c++)
            q[c] += 1e-9 * g[c];
    }
    return times;
}
