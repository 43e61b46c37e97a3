//! Symplectic integrators for the N-body problem.
/// Coefficients (c_i, d_i) of Ruth's third-order method.
pub const RUTH3: [(f64, f64); 3] = [(1.0, -1.0/24.0), (-2.0/3.0, 3.0/4.0), (2.0/3.0, 7.0/24.0)];
/// McLachlan-Atela 4th order
pub const A4: [f64; 4] = [0.5153528374311229364, -0.085782019412973646, 0.4415830236164665242, 0.1288461583653841854];
pub const B4: [f64; 4] = [0.1344961992774310892, -0.2248198030794208058, 0.7563200005156682911, 0.3340036032863214255];
