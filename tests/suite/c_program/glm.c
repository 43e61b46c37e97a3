/* The method of a vector file as an adapter: coefficients from the file, f over the pipe. Explicit
   and diagonally implicit methods of any size; others are refused with a sentence.
   cc -O1 -o glm glm.c -lm ; python -m glmref.conformance "cmd:./glm data/vectors/thesis-3-8.json" */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static char *line, *file;
static size_t room;
static double *A, *U, *B, *V, *c, *SA, *SB, *su;
static int s, r, m; /* stages, values, stages of the starting method */
/* Numbers, quoted or not, of the array after a key: how many there are; at most `most` are kept. */
static int numbers(const char *text, const char *key, double *out, int most) {
  int n = 0, depth = 0, ended = 0;
  const char *p = text ? strstr(text, key) : NULL;
  for (p += p ? strlen(key) : 0; p && *p && !ended; p++) {
    depth += (*p == '[') - (*p == ']');
    if (*p && strchr("-0123456789", *p)) {
      char *end;
      double x = strtod(p, &end);
      if (n++ < most) out[n - 1] = x;
      p = end - 1;
    } else if (*p != ']') continue;
    ended = depth <= 0;
  }
  return n;
}
/* The numbers after a key in memory of their own, with room for at least one. */
static double *array(const char *text, const char *key, int *n) {
  *n = numbers(text, key, NULL, 0);
  double *out = calloc(*n ? *n : 1, sizeof(double));
  if (!out) exit(3);
  numbers(text, key, out, *n);
  return out;
}
/* The end of a line we send: a list. */
static void list(const double *x, int n) {
  printf("[");
  for (int k = 0; k < n; k++) printf("%s%.17g", k ? ", " : "", x[k]);
  puts("]}"), fflush(stdout);
}
/* Ask for f(t, y). */
static void f(double t, const double *y, int d, double *out) {
  printf("{\"ask\": \"f\", \"t\": %.17g, \"y\": ", t), list(y, d);
  if (getline(&line, &room, stdin) < 0 || numbers(line, "\"values\":", out, d) != d) exit(3);
}
/* Y = h A f(Y) + U y, one stage after the other; with a diagonal entry by fixed-point steps. */
static void stages(const double *a, const double *u, const double *cc, int n, int rows, double t,
                   double h, const double *y, int d, double *Y, double *F, double *base) {
  for (int i = 0; i < n; i++) {
    for (int e = 0; e < d; e++) {
      base[e] = 0;
      for (int j = 0; j < rows; j++) base[e] += u[i * rows + j] * y[j * d + e];
      for (int j = 0; j < i; j++) base[e] += h * a[i * n + j] * F[j * d + e];
      Y[i * d + e] = base[e];
    }
    f(t + cc[i] * h, base, d, F + i * d);
    for (int round = 0, moved = a[i * n + i] != 0; moved && round < 100; round++) {
      moved = 0;
      for (int e = 0; e < d; e++) {
        double next = base[e] + h * a[i * n + i] * F[i * d + e];
        moved |= next != Y[i * d + e];
        Y[i * d + e] = next;
      }
      if (moved) f(t + cc[i] * h, Y + i * d, d, F + i * d);
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
/* Read the file; return what makes it one that this program does not run, or NULL. */
static const char *unfit(const char *path) {
  FILE *in = fopen(path, "r");
  size_t size = 0;
  if (!in || getdelim(&file, &size, 0, in) < 0) return "the vector file cannot be read";
  if (strstr(file, "\"q\":")) return "a partitioned method: this program runs single methods";
  int a, u, b, v, sa, sb, uu;
  c = array(file, "\"c\":", &s), A = array(file, "\"A\":", &a), U = array(file, "\"U\":", &u);
  B = array(file, "\"B\":", &b), V = array(file, "\"V\":", &v), r = s ? u / s : 0;
  if (!r || a != s * s || u != s * r || b != r * s || v != r * r) return "no vector file of a method";
  for (int i = 0; i < a; i++)
    if (i % s > i / s && A[i] != 0) return "a stage needs later ones: they are to be solved together";
  const char *start = strstr(file, "\"starting\":");
  SA = array(start, "\"A\":", &sa), SB = array(start, "\"B\":", &sb), su = array(start, "\"u\":", &uu);
  m = uu ? sb / uu : 0;
  for (int i = 0; i < sa; i++)
    if (sa != m * m || (i % m > i / m && SA[i] != 0)) return "the starting method is implicit";
  return NULL;
}

int main(int count, char **arguments) {
  const char *why = unfit(count > 1 ? arguments[1] : "");
  int n = s > m ? s : m, before = -1;
  double *one = calloc(n + 1, sizeof(double)), *sc = calloc(n + 1, sizeof(double)), *work = NULL;
  for (int i = 0; !why && i < m * m; i++) sc[i / m] += SA[i], one[i / m] = 1;
  while (getline(&line, &room, stdin) >= 0) {
    int stage = strstr(line, "\"stages\"") != NULL, begin = strstr(line, "\"start\"") != NULL;
    if (why || strstr(line, "\"describe\"")) {
      const char *name = why ? "" : strstr(file, "\"method\":") + 10;
      if (why) printf("{\"error\": \"%s\"}\n", why);
      else printf("{\"offers\": [\"step\", \"stages\"%s], \"methods\": [%.*s]}\n",
                  m ? ", \"start\"" : "", (int)strcspn(name, ",\n"), name);
      fflush(stdout);
      continue;
    }
    double t = 0, h = 0, columns = 0;
    numbers(line, "\"t\":", &t, 1), numbers(line, "\"h\":", &h, 1);
    numbers(line, "\"columns\":", &columns, 1);
    int d = (int)columns;
    if (d < 1) return 3;
    if (d > before) work = realloc(work, (2 * n + 2 * r + 1) * (size_t)d * sizeof(double)), before = d;
    if (!work) return 3;
    double *Y = work, *F = Y + n * d, *y = F + n * d, *out = y + r * d, *base = out + r * d;
    if (numbers(line, begin ? "\"y0\":" : "\"values\":", y, r * d) != (begin ? 1 : r) * d) return 3;
    if (begin) stages(SA, one, sc, m, 1, t, h, y, d, Y, F, base), combine(SB, su, m, 1, h, F, y, d, out);
    else stages(A, U, c, s, r, t, h, y, d, Y, F, base), combine(B, V, s, r, h, F, y, d, out);
    printf("{\"values\": "), list(stage ? Y : out, (stage ? s : r) * d);
  }
  return 0;
}
