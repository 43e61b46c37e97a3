/* The method of a vector file as an adapter: coefficients from the file, f over the pipe.
   cc -O1 -o glm glm.c -lm ; python -m glmref.conformance "cmd:./glm data/vectors/thesis-3-8.json" */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
enum { S = 8, R = 8, D = 64, LINE = 1 << 16 };
static char line[LINE], file[1 << 20], name[64];
static double A[S * S], U[S * R], B[R * S], V[R * R], c[S], SA[S * S], SB[R * S], su[R];
static int s, r, m; /* stages, values, stages of the starting method */
/* Numbers, quoted or not, of the array after a key; how many there are. */
static int numbers(const char *text, const char *key, double *out) {
  int n = 0, depth = 0;
  const char *p = text ? strstr(text, key) : NULL;
  if (!p) return 0;
  for (p += strlen(key); *p && !(n && depth == 0); p++) {
    char *end;
    depth += (*p == '[') - (*p == ']');
    if (strchr("-0123456789", *p)) out[n++] = strtod(p, &end), p = end - 1;
  }
  return n;
}
/* The end of a line we send: a list. */
static void list(const double *x, int n) {
  for (int k = 0; k < n; k++) printf("%s%.17g", k ? ", " : "[", x[k]);
  puts("]}");
  fflush(stdout);
}
/* Ask for f(t, y). */
static void f(double t, const double *y, int d, double *out) {
  printf("{\"ask\": \"f\", \"t\": %.17g, \"y\": ", t);
  list(y, d);
  if (!fgets(line, LINE, stdin)) exit(1);
  numbers(line, "\"values\":", out);
}
/* Y = h A f(Y) + U y, one stage after the other; with a diagonal entry by fixed-point steps. */
static void stages(const double *a, const double *u, const double *cc, int n, int rows, double t,
                   double h, const double *y, int d, double *Y, double *F) {
  for (int i = 0; i < n; i++) {
    double base[D], *k = F + i * d;
    for (int e = 0; e < d; e++) {
      base[e] = 0;
      for (int j = 0; j < rows; j++) base[e] += u[i * rows + j] * y[j * d + e];
      for (int j = 0; j < i; j++) base[e] += h * a[i * n + j] * F[j * d + e];
    }
    memcpy(Y + i * d, base, d * sizeof(double));
    f(t + cc[i] * h, base, d, k);
    for (int round = 0; a[i * n + i] != 0 && round < 100; round++) {
      double change = 0;
      for (int e = i * d; e < i * d + d; e++) {
        double old = Y[e];
        Y[e] = base[e - i * d] + h * a[i * n + i] * F[e];
        change = fmax(change, fabs(Y[e] - old));
      }
      if (change > 0) f(t + cc[i] * h, Y + i * d, d, k);
      else break;
    }
  }
}

static void combine(const double *b, const double *v, int n, int rows, double h, const double *F,
                    const double *y, int d, double *out) {
  for (int i = 0; i < r * d; i++) {
    out[i] = 0;
    for (int j = 0; j < rows; j++) out[i] += v[i / d * rows + j] * y[j * d + i % d];
    for (int j = 0; j < n; j++) out[i] += h * b[i / d * n + j] * F[j * d + i % d];
  }
}

int main(int count, char **arguments) {
  FILE *in = fopen(count > 1 ? arguments[1] : "", "r");
  double Y[S * D], F[S * D], y[R * D], out[R * D], one[S], sc[S] = {0};
  if (!in || !fread(file, 1, sizeof file - 1, in)) return 1;
  sscanf(strstr(file, "\"method\":"), "\"method\": \"%63[^\"]", name);
  s = numbers(file, "\"c\":", c), r = numbers(file, "\"U\":", U) / s;
  numbers(file, "\"A\":", A), numbers(file, "\"B\":", B), numbers(file, "\"V\":", V);
  char *start = strstr(file, "\"starting\":");
  m = (int)lround(sqrt(numbers(start, "\"A\":", SA)));
  numbers(start, "\"B\":", SB), numbers(start, "\"u\":", su);
  for (int i = 0; i < m * m; i++) sc[i / m] += SA[i], one[i / m] = 1;
  while (fgets(line, LINE, stdin)) {
    int stage = strstr(line, "\"stages\"") != NULL, begin = strstr(line, "\"start\"") != NULL;
    if (strstr(line, "\"describe\"")) {
      printf("{\"offers\": [\"step\", \"stages\"%s], ", m ? ", \"start\"" : "");
      printf("\"methods\": [\"%s\"]}\n", name), fflush(stdout);
      continue;
    }
    double t, h, columns;
    numbers(line, "\"t\":", &t), numbers(line, "\"h\":", &h);
    int d = numbers(line, "\"columns\":", &columns) ? (int)columns : 0;
    if (d > D) return 1; /* more components than there is room for */
    numbers(line, begin ? "\"y0\":" : "\"values\":", y);
    if (begin) stages(SA, one, sc, m, 1, t, h, y, d, Y, F), combine(SB, su, m, 1, h, F, y, d, out);
    else stages(A, U, c, s, r, t, h, y, d, Y, F), combine(B, V, s, r, h, F, y, d, out);
    printf("{\"values\": ");
    list(stage ? Y : out, (stage ? s : r) * d);
  }
  return 0;
}
