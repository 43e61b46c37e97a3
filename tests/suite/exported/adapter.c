/* An exported stepper as an adapter of the conformance suite: f over the pipe of docs/adapters.md.
   NAME is the stepper's prefix, TITLE the method's name, ROWS how many values it carries. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define CALL(function) JOIN(NAME, function)
enum { MOST = 4096, LINE = 1 << 17 };
static char line[LINE];
typedef void (*rhs)(double, const double *, double *, void *);
#ifdef IMPLICIT
#define FLAG , int *
#define GIVE , &newton
static int newton;
#else
#define FLAG
#define GIVE
#endif
int CALL(_start)(rhs, void *, int, double, double, const double *, double * FLAG);
int CALL(_step)(rhs, void *, int, double, double, double * FLAG);
int CALL(_finish)(rhs, void *, int, double, double, const double *, double * FLAG);

static int numbers(const char *key, double *out) {
  int n = 0;
  const char *p = strstr(line, key);
  if (!p) return 0;
  p += strlen(key);
  int list = strspn(p, " ") && p[strspn(p, " ")] == '[';
  for (p += strspn(p, " ["); n < MOST; p += strspn(p, ", ")) {
    char *end;
    out[n] = strtod(p, &end);
    if (end == p) break;
    n++, p = end;
    if (!list) break;
  }
  return n;
}

static void list(const double *x, int n) {
  for (int k = 0; k < n; k++) printf("%s%.17g", k ? ", " : "[", x[k]);
  puts("]}");
  fflush(stdout);
}

static void f(double t, const double *y, double *out, void *data) {
  int d = *(int *)data;
  printf("{\"ask\": \"f\", \"t\": %.17g, \"y\": ", t);
  list(y, d);
  if (!fgets(line, LINE, stdin)) exit(1);
  numbers("\"values\":", out);
}

int main(void) {
  static double x[2 * MOST], y[MOST];
  while (fgets(line, LINE, stdin)) {
    double t = 0, h = 0, columns = 0;
    int start = strstr(line, "\"start\"") != NULL, finish = strstr(line, "\"finish\"") != NULL;
    if (strstr(line, "\"describe\"")) {
      printf("{\"methods\": [\"%s\"], \"offers\": [%s]}\n", TITLE, OFFERS);
      fflush(stdout);
      continue;
    }
    numbers("\"t\":", &t), numbers("\"h\":", &h), numbers("\"columns\":", &columns);
    int d = (int)columns, n = ROWS * d, status;
    if (n < 1 || n > MOST) return 1;
    memset(x, 0, sizeof x);
    if (start) {
      numbers("\"y0\":", y);
      status = CALL(_start)(f, &d, d, t, h, y, x GIVE);
    } else if (finish) {
      numbers("\"values\":", x);
      status = CALL(_finish)(f, &d, d, t, h, x, y GIVE);
    } else {
      numbers("\"values\":", x);
      status = CALL(_step)(f, &d, d, t, h, x GIVE);
    }
    if (status) {
      printf("{\"error\": \"the stepper returned %d\"}\n", status);
      fflush(stdout);
      continue;
    }
    printf("{\"values\": ");
    list(finish ? y : x, finish ? d : n);
  }
  return 0;
}
