
class Pair : public Stepper
{
  public:
    G4int IntegratorOrder() const override { return 2; }
};
void Pair::Step()
{
    const double b21 = 1./2., b31 = 0., b32 = 3./4., b41 = 2./9., b42 = 1./3., b43 = 4./9.,
                 dc1 = b41 - 7./24., dc2 = b42 - 1./4., dc3 = b43 - 1./3., dc4 = -1./8.;
}
void Pair::Interpolate()
{
    const double b1 = tau, c1 = 7.;
}
