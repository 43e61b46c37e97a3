
void getButcherTableau_SWAPPED(BUTCHER_TABLEAU* tableau)
{
  tableau->nStages = 2;
  tableau->order_b = 2;
  tableau->order_bt = 1;
  const double c[] = {0.0, 1.0};
  const double A[] = {0.0, 0.0,
                      1.0, 0.0};
  const double b[] = {1., 0.};
  const double bt[] = {.5, 0.5};
  setButcherTableau(tableau, c, A, b, bt);
}
