// Runge-Kutta methods with few registers: what stands left of the names of a row is b
struct Two {
  int order() const { return 3; }
  void step() {
    const double a21 = 8. / 15, a32 = 5. / 12;
    const double b1 = 1. / 4, b2 = 0., b3 = 3. / 4;
    const double c2 = a21, c3 = b1 + a32;
  }
};
