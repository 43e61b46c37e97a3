
/** Field version: a[0][0] = 3 in a comment. */
public class GillFieldIntegrator<T> extends Fixed<T> {
    private static final double Q = FastMath.sqrt(2);
    @Override
    public T[] getC() {
        final T[] c = MathArrays.buildArray(getField(), 3);
        c[0] = fraction(1, 2);
        c[1] = c[0];
        c[2] = getField().getOne();
        return c;
    }
    @Override
    public T[][] getA() {
        final T   two     = getField().getZero().add(2);
        final T   sqrtTwo = two.sqrt();
        final T[][] a = MathArrays.buildArray(getField(), 3, -1);
        for (int i = 0; i < a.length; ++i) {
            a[i] = MathArrays.buildArray(getField(), i + 1);
        }
        a[0][0] = fraction(1, 2);
        a[ 1][ 0] = sqrtTwo.subtract(1).multiply(0.5);
        a[1][1] = sqrtTwo.subtract(2).multiply(-0.5);
        a[2][0] = getField().getZero();
        a[2][1] = sqrtTwo.multiply(-0.5);
        a[2][2] = sqrtTwo.multiply(0.5).add(1);
        return a;
    }
    @Override
    public T[] getB() {
        final T[] b = MathArrays.buildArray(getField(), 4);
        b[0] = fraction(1, 6);
        b[1] = a(0);
        return b;
    }
}
