/* The classical Runge-Kutta method in C, and around it what the conformance suite asks on stdin and
   is answered on stdout: `describe` and `step`. It asks back for f(t, y). With the argument `slip`
   the weights of the second and the fourth stage are exchanged.
   cc -O2 -o rk4 rk4.c ; glmref conformance cmd:./rk4 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64 }; /* components */
static char *line;
static size_t room;

/* The numbers of the array (or the number) after a key; returns how many. */
static int numbers(const char *key, double *out, int most) {
  const char *p = strstr(line, key);
  int n = 0;
  if (!p) return 0;
  for (p += strlen(key); *p && *p != ']' && n < most;) {
    char *end;
    double x = strtod(p, &end);
    if (end == p) { p++; continue; }
    out[n++] = x;
    p = end;
    if (*p != ',' || strncmp(p, ", \"", 3) == 0) break;
  }
  return n;
}

static void list(const double *x, int d) {
  printf("[");
  for (int i = 0; i < d; i++) printf("%s%.17g", i ? ", " : "", x[i]);
  printf("]}\n");
  fflush(stdout);
}

static void f(double t, const double *y, int d, double *out) {
  printf("{\"ask\": \"f\", \"t\": %.17g, \"y\": ", t);
  list(y, d);
  if (getline(&line, &room, stdin) < 0 || numbers("\"values\":", out, d) != d) exit(3);
}

/* One step of the method, as in a text book. */
static void rk4(double t, double *y, int d, double h, const double *b) {
  static const double c[] = {0, 0.5, 0.5, 1};
  double k[4][MOST], stage[MOST];
  for (int i = 0; i < 4; i++) {
    for (int e = 0; e < d; e++) stage[e] = y[e] + (i ? h * c[i] * k[i - 1][e] : 0);
    f(t + c[i] * h, stage, d, k[i]);
  }
  for (int e = 0; e < d; e++)
    for (int i = 0; i < 4; i++) y[e] += h * b[i] * k[i][e];
}

int main(int count, char **words) {
  double b[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  if (count > 1 && !strcmp(words[1], "slip")) b[1] = 1.0 / 6, b[3] = 1.0 / 3;
  while (getline(&line, &room, stdin) >= 0) {
    if (strstr(line, "\"describe\"")) {
      printf("{\"methods\": [\"rk4\"], \"offers\": [\"step\"]}\n");
      fflush(stdout);
      continue;
    }
    double t = 0, h = 0, y[MOST];
    numbers("\"t\":", &t, 1);
    numbers("\"h\":", &h, 1);
    int d = numbers("\"values\":", y, MOST);
    rk4(t, y, d, h, b);
    printf("{\"values\": ");
    list(y, d);
  }
  return 0;
}
