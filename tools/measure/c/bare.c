/* The force alone, n times, each time where the last one led: what no integrator can undercut as
   long as its evaluations follow one another. */
#include "problems.h"

long run(double *restrict y, const double *restrict par, double h, long n)
{
    double q[M], g[M];
    for (int c = 0; c < M; c++)
        q[c] = y[c];
    for (long k = 0; k < n; k++) {
        force(q, par, g);
        for (int c = 0; c < M; c++)
            q[c] += h * g[c];
    }
    for (int c = 0; c < M; c++)
        y[c] = q[c];
    return n;
}
