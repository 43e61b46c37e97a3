
static const double ah[] = { 0.5, 1.0 };
static const double b3[] = { -1.0, 2.0 };  /* b21 is ah[0] */
static const double c1 = 1.0 / 6.0;
static const double c2 = 2.0 / 3.0;
static const double c3 = 1.0 / 6.0;
static const double ec[] = { 0.0, 1.0 / 6.0, -1.0 / 3.0, 1.0 / 6.0 };
static unsigned int
kutta_order (void *vstate)
{
  return 3;
}
