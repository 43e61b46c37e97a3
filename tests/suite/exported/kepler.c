/* Kepler's problem, e = 0.2, with an exported stepper: NAME is its prefix, PAIR for pairs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define INTEGRATE JOIN(NAME, _integrate)
static void force(const double *q, double *out) {
  double r = sqrt(q[0] * q[0] + q[1] * q[1]);
  out[0] = -q[0] / (r * r * r), out[1] = -q[1] / (r * r * r);
}
#ifdef PAIR
typedef void (*rhs)(const double *, double *, void *);
int INTEGRATE(rhs, rhs, void *, int, double, long, double *);
static void dq(const double *p, double *out, void *data) {
  (void)data, out[0] = p[0], out[1] = p[1];
}
static void dp(const double *q, double *out, void *data) { (void)data, force(q, out); }
#else
typedef void (*rhs)(double, const double *, double *, void *);
int INTEGRATE(rhs, void *, int, double, double, long, double *);
static void f(double t, const double *y, double *out, void *data) {
  (void)t, (void)data, out[0] = y[2], out[1] = y[3], force(y, out + 2);
}
#endif
int main(int count, char **arguments) {
  double h = atof(arguments[count - 2]), y[4] = {0.8, 0, 0, sqrt(1.5)};
  long steps = atol(arguments[count - 1]);
#ifdef PAIR
  int status = INTEGRATE(dq, dp, NULL, 2, h, steps, y);
#else
  int status = INTEGRATE(f, NULL, 4, 0, h, steps, y);
#endif
  printf("%.17g %.17g %.17g %.17g\n", y[0], y[1], y[2], y[3]);
  return status;
}
