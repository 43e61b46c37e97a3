#include <stdio.h>

#include "method.c"
#include "rhs.h"

#define JOIN(a, b) a##b
#define INTEGRATE(name) JOIN(name, _integrate)

int main(void) {
  double y[dimension];
  for (int i = 0; i < dimension; i++) y[i] = initial[i];
  int status = INTEGRATE(METHOD)(rhs, NULL, dimension, 0.0, 0.05, 200, y);
  for (int i = 0; i < dimension; i++) printf("%.12f ", y[i]);
  printf("\n");
  return status;
}
