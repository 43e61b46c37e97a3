#include "tableaux.hh"
static const double rk_a[4][4] = {{0}, {0.5}, {0, 0.5}, {0, 0, 1}};
static const double rk_b[4] = {1.0/6, 1.0/3, 1.0/3, 1.0/6};
static const double rk_c[4] = {0, 0.5, 0.5, 1};
ButcherTableau classic() { return ButcherTableau("classic", rk_a, rk_b, rk_c); }
