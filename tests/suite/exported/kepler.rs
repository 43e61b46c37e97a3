// Kepler's problem, e = 0.2, with an exported stepper in the module `stepper` beside this file.
mod stepper;

fn force(q: &[f64], out: &mut [f64]) {
    let r = (q[0] * q[0] + q[1] * q[1]).sqrt();
    out[0] = -q[0] / (r * r * r);
    out[1] = -q[1] / (r * r * r);
}

#[cfg(pair)]
fn end(h: f64, steps: u64) -> Vec<f64> {
    let dq = |p: &[f64], out: &mut [f64]| out.copy_from_slice(p);
    let (q, p) = stepper::integrate(&dq, &force, h, steps, &[0.8, 0.0], &[0.0, 1.5f64.sqrt()])
        .expect("a step failed");
    [q, p].concat()
}

#[cfg(not(pair))]
fn end(h: f64, steps: u64) -> Vec<f64> {
    let f = |_t: f64, y: &[f64], out: &mut [f64]| {
        out[0] = y[2];
        out[1] = y[3];
        force(y, &mut out[2..]);
    };
    stepper::integrate(&f, 0.0, h, steps, &[0.8, 0.0, 0.0, 1.5f64.sqrt()]).expect("a step failed")
}

fn main() {
    let given: Vec<String> = std::env::args().collect();
    let y = end(given[1].parse().unwrap(), given[2].parse().unwrap());
    println!("{:e} {:e} {:e} {:e}", y[0], y[1], y[2], y[3]);
}
