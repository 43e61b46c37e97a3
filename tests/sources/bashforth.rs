/// Adams-Bashforth coefficients, order 4
pub const AB4: [f64; 4] = [55.0/24.0, -59.0/24.0, 37.0/24.0, -9.0/24.0];
/// Adams-Bashforth coefficients, order 5
pub const AB5: [f64; 5] = [1901.0/720.0, -2774.0/720.0, 2616.0/720.0, -1274.0/720.0, 251.0/720.0];
/// Adams-Moulton order 4
pub const AM4: [f64; 4] = [9.0/24.0, 19.0/24.0, -5.0/24.0, 1.0/24.0];
