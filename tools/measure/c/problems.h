/* Forces of four problems q'' = g(q), M positions each; compile with -DKEPLER, -DHENON_HEILES,
   -DOUTER or -DPENDULUM. par: nothing; the cubic coefficient; the gravitational constant and six
   masses; nothing. */
#include <math.h>

#if defined KEPLER
enum { M = 2 };
static inline void force(const double *restrict q, const double *restrict par, double *restrict g)
{
    double r2 = q[0] * q[0] + q[1] * q[1];
    double w = -1 / (r2 * sqrt(r2));
    g[0] = w * q[0];
    g[1] = w * q[1];
    (void)par;
}
#elif defined HENON_HEILES
enum { M = 2 };
static inline void force(const double *restrict q, const double *restrict par, double *restrict g)
{
    g[0] = -q[0] - 2 * q[0] * q[1];
    g[1] = -q[1] - q[0] * q[0] - 3 * par[0] * q[1] * q[1];
}
#elif defined OUTER
enum { M = 18 };
static inline void force(const double *restrict q, const double *restrict par, double *restrict g)
{
    const double *mass = par + 1;
    for (int c = 0; c < M; c++)
        g[c] = 0;
    for (int i = 0; i < M / 3; i++)
        for (int j = 0; j < i; j++) {
            double dx = q[3 * i] - q[3 * j];
            double dy = q[3 * i + 1] - q[3 * j + 1];
            double dz = q[3 * i + 2] - q[3 * j + 2];
            double r2 = dx * dx + dy * dy + dz * dz;
            double w = par[0] / (r2 * sqrt(r2));
            double wi = w * mass[i], wj = w * mass[j];
            g[3 * i] -= wj * dx;
            g[3 * i + 1] -= wj * dy;
            g[3 * i + 2] -= wj * dz;
            g[3 * j] += wi * dx;
            g[3 * j + 1] += wi * dy;
            g[3 * j + 2] += wi * dz;
        }
}
#elif defined PENDULUM
enum { M = 1 };
static inline void force(const double *restrict q, const double *restrict par, double *restrict g)
{
    g[0] = -sin(q[0]);
    (void)par;
}
#endif

enum { D = 2 * M };

/* Sum of M terms: four partial sums where there are many, in the order of the generated kernels. */
static inline double total(const double *restrict t)
{
    if (M <= 2)
        return M == 2 ? t[0] + t[M - 1] : t[0];
    double a = 0, b = 0, c = 0, d = 0;
    int k = 0;
    for (; k + 4 <= M; k += 4) {
        a += t[k];
        b += t[k + 1];
        c += t[k + 2];
        d += t[k + 3];
    }
    return ((a + b) + c) + ((d + t[M - 2]) + t[M - 1]);
}

/* y + u into y, what rounding took from it into e; returns a sum that is finite if y is. */
static inline double add(double *restrict y, double *restrict e, const double *restrict u, int n)
{
    double check = 0;
    for (int c = 0; c < n; c++) {
        double sum = y[c] + u[c];
        e[c] = u[c] - (sum - y[c]);
        y[c] = sum;
        check += sum;
    }
    return check;
}

/* L = h f(y + a) of an explicit stage, f = (p, g(q)) */
static inline void stage(
    const double *restrict y, const double *restrict a, const double *restrict par, double h,
    double *restrict L)
{
    double Y[D], g[M];
    for (int c = 0; c < D; c++)
        Y[c] = y[c] + a[c];
    force(Y, par, g);
    for (int c = 0; c < M; c++) {
        L[c] = h * Y[M + c];
        L[M + c] = h * g[c];
    }
}

/* When the iteration of a stage ends; returns 1 to end it, -1 where it failed, else 0. */
static inline int settled(double change, double size, double *last, int *stalls, int rounds)
{
    if (rounds > 0 && !(0x1p-64 * size < change && change < *last)) {
        if (change <= 0x1p-47 * size)
            return 1;
        if (++*stalls > 8 || !(change < 1e300))
            return change <= 0x1p-30 * size ? 1 : -1;
    }
    if (rounds >= 200)
        return -1;
    *last = rounds > 0 ? change : 1e300;
    return 0;
}
