// Kepler's problem, e = 0.2, with an exported stepper: FILE_ includes it, NAME is its namespace.
#include FILE_
#include <cstdio>
#include <cstdlib>
using Vector = std::vector<double>;
static Vector force(const Vector &q) {
  const double r = std::sqrt(q[0] * q[0] + q[1] * q[1]);
  return {-q[0] / (r * r * r), -q[1] / (r * r * r)};
}
int main(int, char **arguments) {
  const double h = std::atof(arguments[1]);
  const long steps = std::atol(arguments[2]);
#ifdef PAIR
  const auto end = NAME::integrate([](const Vector &p) { return p; }, force, h, steps,
                                   {0.8, 0}, {0, std::sqrt(1.5)});
  const Vector y{end[0][0], end[0][1], end[1][0], end[1][1]};
#else
  const auto f = [](double, const Vector &y) {
    const Vector k = force(y);
    return Vector{y[2], y[3], k[0], k[1]};
  };
  const Vector y = NAME::integrate(f, 0, h, steps, {0.8, 0, 0, std::sqrt(1.5)});
#endif
  std::printf("%.17g %.17g %.17g %.17g\n", y[0], y[1], y[2], y[3]);
}
