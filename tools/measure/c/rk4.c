/* The classical Runge-Kutta method in Nystrom's form, compensated summation; what rounding takes from
   the weights of p is put back as one multiple of the first slope. */
#include "problems.h"

static const double WEIGHT[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
static const double RESIDUE[4] = {
    9.25185853854297e-18, 1.850371707708594e-17, 1.850371707708594e-17, 9.25185853854297e-18};

static const double SPLITTER = 134217729.0;

static double upper(double x)
{
    double wide = SPLITTER * x;
    return wide - (wide - x);
}

long run(double *restrict y0, const double *restrict par, double h, long steps)
{
    double q[M], p[M], eq[M] = {0}, ep[M] = {0}, uq[M], up[M], Q[M], F0[M], F1[M], F2[M], F3[M];
    double half = h * 0.5, quarter = (h * h) * 0.25, second = (h * h) * 0.5;
    double sixth = (h * h) * (1.0 / 6), w[4], lost = 0;
    double high = upper(h), low = h - high;
    for (int j = 0; j < 4; j++) {
        double a = upper(WEIGHT[j]), b = WEIGHT[j] - a;
        w[j] = h * WEIGHT[j];
        lost = lost + (((high * a - w[j]) + high * b + low * a) + low * b + h * RESIDUE[j]);
    }
    for (int c = 0; c < M; c++) {
        q[c] = y0[c];
        p[c] = y0[M + c];
    }
    for (long n = 0; n < steps; n++) {
        force(q, par, F0);
        for (int c = 0; c < M; c++)
            Q[c] = q[c] + half * p[c];
        force(Q, par, F1);
        for (int c = 0; c < M; c++)
            Q[c] = (q[c] + half * p[c]) + quarter * F0[c];
        force(Q, par, F2);
        for (int c = 0; c < M; c++)
            Q[c] = (q[c] + h * p[c]) + second * F1[c];
        force(Q, par, F3);
        for (int c = 0; c < M; c++) {
            uq[c] = eq[c] + h * p[c] + sixth * F0[c] + sixth * F1[c] + sixth * F2[c];
            up[c] = ep[c] + lost * F0[c] + w[0] * F0[c] + w[1] * F1[c] + w[2] * F2[c] + w[3] * F3[c];
        }
        if (!(fabs(add(q, eq, uq, M) + add(p, ep, up, M)) < 1e300))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y0[c] = q[c];
        y0[M + c] = p[c];
    }
    return 4 * steps;
}
