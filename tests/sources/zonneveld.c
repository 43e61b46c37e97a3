/* embedded Runge-Kutta pair, order 4(3) */
#include "ode.h"
typedef struct { int stages, order; double a[10]; double w[5]; double t[5]; double low[5]; } tab_t;
static const tab_t zonneveld = {
  .stages = 5, .order = 4,
  .a = { 0.5,
         0.0, 0.5,
         0.0, 0.0, 1.0,
         5./32, 7./32, 13./32, -1./32 },
  .w = { 1./6, 1./3, 1./3, 1./6, 0.0 },
  .t = { 0.0, 0.5, 0.5, 1.0, 0.75 },
  .low = { -0.5, 7./3, 7./3, 13./6, -16./3 },
};
