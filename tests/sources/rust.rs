
const SQRT_3: f64 = 1.732050808;
pub(crate) const HEUN_2_A: [[f64; 2]; 2] = [
    [0.0, 0.0],
    [1.0, 0.0],
];
pub(crate) const HEUN_2_B: [f64; 2] = [1.0 / 2.0, 1.0 / 2.0]; // a comment
impl<T: Real> ButcherTableau<T, 2> {
    /// - Primary order: 4
    pub fn gauss() -> Self {
        let mut c = [0.0; 2];
        let mut a = [[0.0; 2]; 2];
        let sqrt3_6 = SQRT_3 / 6.0;
        c[0] = 0.5 - sqrt3_6;
        c[1] = 0.5 + sqrt3_6;
        a[0][0] = 0.25;
        a[0][1] = 0.25 - sqrt3_6;
        a[1][0] = 0.25 + sqrt3_6;
        a[1][1] = 0.2_5;
        let b = [0.5, 0.5];
        let a = a.map(|row| row.map(|x| T::from_f64(x).unwrap()));
        Self { c, a, b }
    }
    pub fn other() -> f64 {
        let a = 1.0;
        a
    }
}
