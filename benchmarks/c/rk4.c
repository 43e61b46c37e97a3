/* The classical Runge-Kutta method, compensated summation with the rounding residue of its weights. */
#include "problems.h"

static const double WEIGHT[2] = {1.0 / 6, 1.0 / 3};
static const double RESIDUE[2] = {9.25185853854297e-18, 1.850371707708594e-17};

long run(double *restrict y0, const double *restrict par, double h, long steps)
{
    double y[D], e[D] = {0}, a[D], u[D], L0[D], L1[D], L2[D], L3[D];
    for (int c = 0; c < D; c++)
        y[c] = y0[c];
    for (long n = 0; n < steps; n++) {
        stage(y, e, par, h, L0);
        for (int c = 0; c < D; c++)
            a[c] = e[c] + 0.5 * L0[c];
        stage(y, a, par, h, L1);
        for (int c = 0; c < D; c++)
            a[c] = e[c] + 0.5 * L1[c];
        stage(y, a, par, h, L2);
        for (int c = 0; c < D; c++)
            a[c] = e[c] + L2[c];
        stage(y, a, par, h, L3);
        for (int c = 0; c < D; c++)
            u[c] = e[c] + (RESIDUE[0] * L0[c] + RESIDUE[1] * L1[c] + RESIDUE[1] * L2[c]
                + RESIDUE[0] * L3[c] + WEIGHT[0] * L0[c] + WEIGHT[1] * L1[c] + WEIGHT[1] * L2[c]
                + WEIGHT[0] * L3[c]);
        if (!(fabs(add(y, e, u, D)) < 1e300))
            return -1;
    }
    for (int c = 0; c < D; c++)
        y0[c] = y[c];
    return 4 * steps;
}
