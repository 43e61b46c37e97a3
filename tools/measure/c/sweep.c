/* Explicit pairs and splittings in sweep form: at P_i (where q' = p is evaluated) q moves, at Q_j
   (where the force is) p moves. The table of the method, written by compare_c.py, is

       #define VALUES 2
       #define TABLE P(0, b0, w0) Q(0, c0, v0) P(1, b1, w1) ...

   with numbers in hexadecimal, so that all stages stand one after the other, weights are constants
   and a coupling of zero costs nothing. A pair (VALUES 2) carries a second value of q and of p,
   whose sign changes from step to step, and sees q + w q2; a splitting carries none. Each value is
   kept as value + e, e what rounding took from it, and a step adds its increments to e first. */
#include "problems.h"
#include "table.h"

/* What the next stage sees: value + (u + w d2), where d2 is -value2 and what was added to it. What
   rounding took from the values is below the rounding of the product, and left out until then. */
static inline void seen(
    double *restrict Y, const double *restrict y, const double *restrict u,
    const double *restrict d2, double w, int begun)
{
    for (int c = 0; c < M; c++)
        Y[c] = w == 0 ? (begun ? y[c] + u[c] : y[c])
            : begun   ? y[c] + (u[c] + w * d2[c])
                      : y[c] + w * d2[c];
}

static inline void moved(
    double *restrict u, double *restrict u2, double *restrict d2, const double *restrict f,
    double hb, double w)
{
    for (int c = 0; c < M; c++) {
        double L = hb * f[c];
        u[c] += L;
        if (w != 0) {
            u2[c] += w * L;
            d2[c] += w * L;
        }
    }
}

/* The second value changes its sign: -y2 + u2 into y2, what rounding took from it into e2. */
static inline double turned(double *restrict y2, double *restrict e2, const double *restrict u2)
{
    double check = 0;
    for (int c = 0; c < M; c++) {
        double sum = u2[c] - y2[c];
        e2[c] = u2[c] - (sum + y2[c]);
        y2[c] = sum;
        check += sum;
    }
    return check;
}

long run(double *restrict y, const double *restrict par, double h, long steps)
{
    double q[M], p[M], q2[M] = {0}, p2[M] = {0};
    double eq[M] = {0}, ep[M] = {0}, eq2[M] = {0}, ep2[M] = {0};
    double uq[M], up[M], uq2[M], up2[M], dq2[M], dp2[M], Y[M], g[M], hb[64], hc[64];
    for (int c = 0; c < M; c++) {
        q[c] = y[c];
        p[c] = y[M + c];
        if (VALUES == 2) {
            q2[c] = y[D + c];
            p2[c] = y[D + M + c];
        }
    }
#define P(i, b, w) hb[i] = h * b;
#define Q(j, c, v) hc[j] = h * c;
    TABLE
#undef P
#undef Q
    long forces = 0;
    for (long n = 0; n < steps; n++) {
        int begun_q = 0, begun_p = 0;
        for (int c = 0; c < M; c++) {
            uq[c] = eq[c];
            up[c] = ep[c];
            uq2[c] = -eq2[c];
            up2[c] = -ep2[c];
            dq2[c] = -q2[c];
            dp2[c] = -p2[c];
        }
#define P(i, b, w)                           \
    seen(Y, p, up, dp2, w, begun_p);         \
    moved(uq, uq2, dq2, Y, hb[i], w);        \
    begun_q = 1;
#define Q(j, c, v)                           \
    seen(Y, q, uq, dq2, v, begun_q);         \
    force(Y, par, g);                        \
    moved(up, up2, dp2, g, hc[j], v);        \
    forces++;                                \
    begun_p = 1;
        TABLE
        double check = add(q, eq, uq, M) + add(p, ep, up, M);
        if (VALUES == 2)
            check += turned(q2, eq2, uq2) + turned(p2, ep2, up2);
        if (!(fabs(check) < 1e300))
            return -1;
    }
    for (int c = 0; c < M; c++) {
        y[c] = q[c];
        y[M + c] = p[c];
        if (VALUES == 2) {
            y[D + c] = q2[c];
            y[D + M + c] = p2[c];
        }
    }
    return forces;
}
