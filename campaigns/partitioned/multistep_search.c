/* Symmetric multistep methods sum a_i v_{n-i} = h sum b_i k(q_{n-i}), q_{n+1} = q_n + h v_n, started
 * from a reference; the inner loops of multistep_search.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { KEPLER, HENON_HEILES, PENDULUM, TODA };
enum { MOST = 32, STAGES = 17, ORDER = 8 };

#define FORCE(T, NAME, SQRT, EXP, SIN)                                                             \
    static void NAME(int kind, int d, const T *q, T *f)                                            \
    {                                                                                              \
        if (kind == KEPLER) {                                                                      \
            T r2 = q[0] * q[0] + q[1] * q[1], r3 = 1 / (r2 * SQRT(r2));                            \
            f[0] = -q[0] * r3;                                                                     \
            f[1] = -q[1] * r3;                                                                     \
        } else if (kind == HENON_HEILES) {                                                         \
            f[0] = -q[0] - 2 * q[0] * q[1];                                                        \
            f[1] = -q[1] - q[0] * q[0] + q[1] * q[1];                                              \
        } else if (kind == PENDULUM) {                                                             \
            f[0] = -SIN(q[0]);                                                                     \
        } else {                                                                                   \
            T first = EXP(q[d - 1] - q[0]), before = first;                                        \
            for (int i = 0; i < d; i++) {                                                          \
                T next = i + 1 < d ? EXP(q[i] - q[i + 1]) : first;                                 \
                f[i] = before - next;                                                              \
                before = next;                                                                     \
            }                                                                                      \
        }                                                                                          \
    }
FORCE(double, force, sqrt, exp, sin)
FORCE(long double, long_force, sqrtl, expl, sinl)

/* Kahan and Li's composition of order 8. */
static const long double W[9] = {
    0.130202483088890080878817632809354147330815171467L,
    0.561162981775108384561964407706319781355549380079L,
    -0.3894749626448464486408078860L,
    0.158841906555155600896210745377276253302606306410L,
    -0.395903894133237577336231537948194456571331279341L,
    0.184539640978315707091832540911129770340904622641L,
    0.258374387686322047293979109416956180032464370676L,
    0.295011723609310298870966241394517617990313076884L,
    0};

void reference(int kind, int d, long double *q, long double *p, long double h, long steps)
{
    long double f[MOST], rest = 1;
    for (int i = 0; i < 8; i++)
        rest -= 2 * W[i];
    for (long n = 0; n < steps; n++)
        for (int i = 0; i < STAGES; i++) {
            long double g = h * (i == 8 ? rest : W[i < 8 ? i : 16 - i]);
            for (int c = 0; c < d; c++)
                q[c] += g / 2 * p[c];
            long_force(kind, d, q, f);
            for (int c = 0; c < d; c++) {
                p[c] += g * f[c];
                q[c] += g / 2 * p[c];
            }
        }
}

void solution(int kind, int d, const double *q0, const double *p0, double t, long steps, double *end)
{
    long double q[MOST], p[MOST];
    for (int c = 0; c < d; c++) {
        q[c] = q0[c];
        p[c] = p0[c];
    }
    reference(kind, d, q, p, (long double)t / steps, steps);
    for (int c = 0; c < d; c++)
        end[c] = (double)q[c];
}

/* The difference of order ORDER of the values at step n and before it, in a ring of rows. */
static double roughness(int d, const double *values, long ring, int stride, long n)
{
    static const double binomial[ORDER + 1] = {1, -8, 28, -56, 70, -56, 28, -8, 1};
    double size = 0;
    for (int c = 0; c < d; c++) {
        double rough = 0;
        for (int i = 0; i <= ORDER; i++)
            rough += binomial[i] * values[((n - i) % ring) * stride + c];
        size += rough * rough;
    }
    return sqrt(size);
}

/* The largest roughness in the first and in the last 2,000 of so many steps. */
static void watch(int d, const double *values, long ring, int stride, long n, long steps,
                  double *first, double *last)
{
    if (n < 2000 || n > steps - 2000) {
        double *most = n < 2000 ? first : last;
        *most = fmax(*most, roughness(d, values, ring, stride, n));
    }
}

/* Positions after `steps` steps; returns the growth of the roughness of v, the size of its eighth
 * difference in the last 2,000 steps over that in the first, and infinity for a lost orbit. */
double run(int kind, int d, int k, const double *a, const double *b, const double *q0,
           const double *p0, double h, long steps, int substeps, double *end)
{
    long ring = k + ORDER + 2;
    double *v = calloc((size_t)ring * d, sizeof *v), *f = calloc((size_t)ring * d, sizeof *f);
    double q[MOST], e[MOST], first = 0, last = 0;
    long double Q[MOST], P[MOST], F[MOST];
    int lost = 0;
    for (int c = 0; c < d; c++) {
        Q[c] = q0[c];
        P[c] = p0[c];
    }
    for (int n = 0; n < k; n++) {
        long double before[MOST];
        memcpy(before, Q, sizeof before);
        long_force(kind, d, Q, F);
        reference(kind, d, Q, P, (long double)h / substeps, substeps);
        for (int c = 0; c < d; c++) {
            f[n * d + c] = (double)F[c];
            v[n * d + c] = (double)((Q[c] - before[c]) / h);
        }
    }
    for (int c = 0; c < d; c++) {
        q[c] = (double)Q[c];
        e[c] = (double)(Q[c] - q[c]);
    }
    for (long n = k; n < steps && !lost; n++) {
        double *vn = v + (n % ring) * d;
        force(kind, d, q, f + (n % ring) * d);
        for (int c = 0; c < d; c++) {
            double sum = 0;
            for (int i = 0; i < k; i++)
                sum += b[i] * f[((n - i) % ring) * d + c];
            sum *= h;
            for (int i = 1; i <= k; i++)
                sum -= a[i] * v[((n - i) % ring) * d + c];
            vn[c] = sum;
            double more = h * sum + e[c], next = q[c] + more;
            e[c] = more - (next - q[c]);
            q[c] = next;
        }
        if (n > k + ORDER)
            watch(d, v, ring, d, n, steps, &first, &last);
        lost = !(fabs(q[0]) < 1e4);
    }
    memcpy(end, q, sizeof(double) * d);
    free(v);
    free(f);
    return lost ? INFINITY : last / (first + 1e-13);
}

enum { VALUES = 16 };

/* Turn the pairs of the values of all components. */
static void turn_values(int d, int m, const double *turns, double x[][MOST])
{
    for (int j = 0; j < m; j++)
        for (int c = 0; c < d; c++) {
            double u = x[1 + 2 * j][c], v = x[2 + 2 * j][c];
            x[1 + 2 * j][c] = turns[2 * j] * u - turns[2 * j + 1] * v;
            x[2 + 2 * j][c] = turns[2 * j + 1] * u + turns[2 * j] * v;
        }
}

/* Two kicks a step, with the output in the middle of the first: see two_kicks_search.py. */

static double energy(int kind, int d, const double *q, const double *p)
{
    double sum = 0;
    for (int c = 0; c < d; c++)
        sum += p[c] * p[c] / 2;
    if (kind == KEPLER)
        return sum - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
    if (kind == HENON_HEILES)
        return sum + (q[0] * q[0] + q[1] * q[1]) / 2 + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3;
    if (kind == PENDULUM)
        return sum - cos(q[0]);
    for (int i = 0; i < d; i++)
        sum += exp(q[i] - q[i + 1 < d ? i + 1 : 0]);
    return sum;
}

/* Forces at the points t + i spacing h, |i| <= reach, from positions and velocities at t. */
static void forces_around(int kind, int d, const double *q0, const double *p0, double gap, int reach,
                          int substeps, long double f[][MOST])
{
    for (int way = -1; way <= 1; way += 2) {
        long double q[MOST], p[MOST];
        for (int c = 0; c < d; c++) {
            q[c] = q0[c];
            p[c] = p0[c];
        }
        long_force(kind, d, q, f[reach]);
        for (int i = 1; i <= reach; i++) {
            reference(kind, d, q, p, way * (long double)gap / substeps, substeps);
            long_force(kind, d, q, f[reach + way * i]);
        }
    }
}

/* State after so many steps of length h. rows: the values but the first from the 2 reach + 1 forces
 * around the start, spacing h apart. weights: of the drift to the second kick, of the drift to the
 * end, and of the velocity, 3 rows. kicks: 2 rows, of the first, half of which is made at either end
 * of the step, and of the second, after the turns. errors: largest error of the energy, relative, in
 * samples of every so many steps. Returns the growth of the roughness of the first drift. */
double two_kicks(int kind, int d, int m, const double *rows, int reach, double spacing,
                 const double *weights, const double *kicks, const double *turns, const double *q0,
                 const double *p0, double h, long steps, long every, int substeps, double *end,
                 double *errors)
{
    int r = 1 + 2 * m, lost = 0;
    double x[VALUES][MOST], q[MOST], e[MOST], p[MOST], f[MOST], past[ORDER + 1][MOST] = {{0}};
    double first = 0, last = 0, H = energy(kind, d, q0, p0), most_energy = 0;
    long double around[2 * VALUES][MOST];
    forces_around(kind, d, q0, p0, spacing * h, reach, substeps, around);
    for (int c = 0; c < d; c++) {
        double sum = p0[c];
        for (int a = 1; a < r; a++) {
            long double value = 0;
            for (int i = 0; i < 2 * reach + 1; i++)
                value += rows[(a - 1) * (2 * reach + 1) + i] * around[i][c];
            x[a][c] = (double)(h * value);
            sum -= weights[2 * r + a] * x[a][c];
        }
        x[0][c] = sum;
        q[c] = q0[c];
        e[c] = 0;
    }
    force(kind, d, q, f);
    for (long n = 1; n <= steps && !lost; n++) {
        for (int a = 0; a < r; a++)
            for (int c = 0; c < d; c++)
                x[a][c] += h / 2 * kicks[a] * f[c];
        for (int i = 0; i < 2; i++) {
            for (int c = 0; c < d; c++) {
                double sum = 0;
                for (int a = 0; a < r; a++)
                    sum += weights[i * r + a] * x[a][c];
                if (i == 0)
                    past[n % (ORDER + 1)][c] = sum;
                double more = h * sum + e[c], next = q[c] + more;
                e[c] = more - (next - q[c]);
                q[c] = next;
            }
            force(kind, d, q, f);
            if (i == 0)
                turn_values(d, m, turns, x);
            for (int a = 0; a < r; a++)
                for (int c = 0; c < d; c++)
                    x[a][c] += i ? h / 2 * kicks[a] * f[c] : h * kicks[r + a] * f[c];
        }
        if (every && n % every == 0) {
            for (int c = 0; c < d; c++) {
                p[c] = 0;
                for (int a = 0; a < r; a++)
                    p[c] += weights[2 * r + a] * x[a][c];
            }
            most_energy = fmax(most_energy, fabs((energy(kind, d, q, p) - H) / H));
        }
        if (n > ORDER)
            watch(d, past[0], ORDER + 1, MOST, n, steps, &first, &last);
        lost = !(fabs(q[0]) < 1e4);
    }
    memcpy(end, q, sizeof(double) * d);
    *errors = lost ? INFINITY : most_energy;
    return lost ? INFINITY : last / (first + 1e-13);
}
