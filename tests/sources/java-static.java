
public class KuttaIntegrator {
    static final double[] STATIC_E = { 1.0, -1.0, 0.25, 0.0 };
    public double[] getC() {
        return new double[] { 1.0/2.0, 1.0, 1.0 };
    }
    public double[][] getA() {
        return new double[][] { {1.0/2.0}, {-1.0, 2.0}, {1.0/6.0, 2.0/3.0, 1.0/6.0} };
    }
    public double[] getB() {
        return new double[] { 1.0/6.0, 2.0/3.0, 1.0/6.0, 0.0 };
    }
    public int getOrder() { return 3; }
}
