/* The order 6 method g6245 in sweep form: four values, V = diag(1, rotation by 90 degrees, -1), five
   stages, the first and the last explicit. With w = V y + u, stage i is w . U_i + m_i L and then
   u += R_i L, L = h d_i f. Fixed point to round-off, polynomial prediction. */
#include "problems.h"

#define A1 0.813115628181743
#define A2 0.8139856825966233
#define A3 0.5689725092354474
#define B1 0.3312693299999692
#define B2 0.6324602883634135
#define B3 0.05977077755214473
#define C2 1.321107526527303
#define C3 0.3468790807285535
#define M1 0.24691358024691365
#define M2 -0.312500000000001
static const double WEIGHT[5] = {
    0.09166666666666658, 0.675, -0.5333333333333333, 0.675, 0.09166666666666666};

typedef double vector[D];

/* L = h f(y + (a + m L)) by rounds on the positions Q = b + (m h)^2 g from the guess in the right half
   of L; returns how many rounds, or -1. */
static inline int implicit_stage(
    const double *restrict y, const double *restrict a, const double *restrict par, double h,
    double m, double *restrict L)
{
    double Y[M], N[M], b[M], g[M], t[M], k = (m * h) * (m * h), inverse = 1.0 / h;
    for (int c = 0; c < M; c++) {
        g[c] = inverse * L[M + c];
        b[c] = y[c] + (a[c] + m * (h * (y[M + c] + a[M + c])));
    }
    for (int c = 0; c < M; c++)
        t[c] = fabs(y[c]) + fabs(L[c]);
    double size = total(t), last = 1e300;
    int stalls = 0, rounds = 0;
    for (;;) {
        for (int c = 0; c < M; c++)
            N[c] = b[c] + k * g[c];
        double change = 0;
        if (rounds > 0) {
            for (int c = 0; c < M; c++)
                t[c] = fabs(N[c] - Y[c]);
            change = total(t);
        }
        int end = settled(change, size, &last, &stalls, rounds);
        if (end) {
            for (int c = 0; c < M; c++) {
                L[M + c] = h * g[c];
                L[c] = h * (y[M + c] + (a[M + c] + m * L[M + c]));
            }
            return end < 0 ? -1 : rounds;
        }
        rounds++;
        for (int c = 0; c < M; c++)
            Y[c] = N[c];
        force(Y, par, g);
    }
}

long run(double *restrict x, const double *restrict par, double h, long steps)
{
    vector y0, y1, y2, y3, e0 = {0}, e1 = {0}, e2 = {0}, e3 = {0};
    vector u0, u1, u2, u3, a, L0, L1, L2, L3, L4;
    double hd[5], g[M];
    long evaluations = 0;
    for (int i = 0; i < 5; i++)
        hd[i] = h * WEIGHT[i];
    for (int c = 0; c < D; c++) {
        y0[c] = x[c];
        y1[c] = x[D + c];
        y2[c] = x[2 * D + c];
        y3[c] = x[3 * D + c];
    }
    force(y0, par, g);
    for (int c = 0; c < D; c++) {
        double slope = c < M ? y0[M + c] : g[c - M];
        L0[c] = hd[0] * slope;
        L1[c] = hd[1] * slope;
        L2[c] = hd[2] * slope;
        L3[c] = hd[3] * slope;
    }
    for (long n = 0; n < steps; n++) {
        int rounds[3];
        for (int c = 0; c < D; c++)
            a[c] = e0[c] + A1 * y2[c] - A2 * y1[c] - A3 * y3[c];
        stage(y0, a, par, hd[0], L0);
        for (int c = 0; c < D; c++) {
            u0[c] = e0[c] + L0[c];
            u1[c] = -e2[c] + A1 * L0[c];
            u2[c] = e1[c] + A2 * L0[c];
            u3[c] = -e3[c] + A3 * L0[c];
            a[c] = u0[c] + B1 * (-y2[c] + u1[c]) + B2 * (y1[c] + u2[c]) + B3 * (-y3[c] + u3[c]);
        }
        for (int c = M; c < D; c++)
            L1[c] = 24.545454545454568 * L0[c] - 5.0 * L3[c] - 3.375000000000001 * L2[c];
        rounds[0] = implicit_stage(y0, a, par, hd[1], M1, L1);
        for (int c = 0; c < D; c++) {
            u0[c] += L1[c];
            u1[c] -= B1 * L1[c];
            u2[c] -= B2 * L1[c];
            u3[c] += B3 * L1[c];
            a[c] = u0[c] + C2 * (y1[c] + u2[c]) + C3 * (-y3[c] + u3[c]);
        }
        for (int c = M; c < D; c++)
            L2[c] = -1.4814814814814816 * L1[c] + 7.2727272727272805 * L0[c]
                - 0.2962962962962963 * L3[c];
        rounds[1] = implicit_stage(y0, a, par, hd[2], M2, L2);
        for (int c = 0; c < D; c++) {
            u0[c] += L2[c];
            u2[c] -= C2 * L2[c];
            u3[c] += C3 * L2[c];
            a[c] = u0[c] - B1 * (-y2[c] + u1[c]) + B2 * (y1[c] + u2[c]) + B3 * (-y3[c] + u3[c]);
        }
        for (int c = M; c < D; c++)
            L3[c] = -3.374999999999999 * L2[c] - 1.9999999999999993 * L1[c]
                + 2.4545454545454564 * L0[c];
        rounds[2] = implicit_stage(y0, a, par, hd[3], M1, L3);
        if (rounds[0] < 0 || rounds[1] < 0 || rounds[2] < 0)
            return -1;
        evaluations += 2 + rounds[0] + rounds[1] + rounds[2];
        for (int c = 0; c < D; c++) {
            u0[c] += L3[c];
            u1[c] += B1 * L3[c];
            u2[c] -= B2 * L3[c];
            u3[c] += B3 * L3[c];
            a[c] = u0[c] + A1 * (-y2[c] + u1[c]) - A2 * (y1[c] + u2[c]) + A3 * (-y3[c] + u3[c]);
        }
        stage(y0, a, par, hd[4], L4);
        for (int c = 0; c < D; c++) {
            u0[c] += L4[c];
            u1[c] -= A1 * L4[c];
            u2[c] += A2 * L4[c];
            u3[c] += A3 * L4[c];
            double turned = y1[c];
            y1[c] = -y2[c];
            y2[c] = turned;
            y3[c] = -y3[c];
        }
        double check = add(y0, e0, u0, D) + add(y1, e1, u1, D) + add(y2, e2, u2, D)
            + add(y3, e3, u3, D);
        if (!(fabs(check) < 1e300))
            return -1;
    }
    for (int c = 0; c < D; c++) {
        x[c] = y0[c];
        x[D + c] = y1[c];
        x[2 * D + c] = y2[c];
        x[3 * D + c] = y3[c];
    }
    return evaluations;
}
