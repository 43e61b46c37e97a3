package integrator;

/** Strong stability preserving Runge-Kutta method in the form of Shu and Osher. */
public final class Ssp33 {
  private static final int ORDER = 3;
  private static final double[][] ALPHA = {
    {1.0},
    {3.0 / 4, 1.0 / 4},
    {1.0 / 3, 0.0, 2.0 / 3},
  };
  private static final double[][] BETA = {
    {1.0},
    {0.0, 1.0 / 4},
    {0.0, 0.0, 2.0 / 3},
  };
}
