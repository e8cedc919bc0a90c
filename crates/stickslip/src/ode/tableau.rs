//! Runge–Kutta methods as data.

/// Room for stages: 12 of DOP853, its slope at the end, and 3 for the dense output.
pub const MAX_STAGES: usize = 16;

/// The coefficients of an explicit Runge–Kutta method in the usual notation (c | A, b), with those
/// of its dense output.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    /// Stages of the step itself. Slot `stages` holds the slope at the end of the step.
    pub stages: usize,
    /// Further stages that only the dense output needs, in slots `stages + 1 ..`.
    pub dense_stages: usize,
    /// Nodes: stage `i` is taken at time `t + c[i] h`.
    pub c: [f64; MAX_STAGES],
    /// `a[i][j]`: weight of slope `j` in the state of stage `i`; zero for `j >= i`.
    pub a: [[f64; MAX_STAGES]; MAX_STAGES],
    /// Weights of the solution.
    pub b: [f64; MAX_STAGES],
    /// Weights of coefficients 5 to 8 of the dense output; zero for a cubic Hermite interpolant.
    pub d: [[f64; MAX_STAGES]; 4],
}

/// Weights from which DOP853 estimates its error.
#[derive(Clone, Copy, Debug)]
pub struct Embedded {
    /// Error estimate of order 5.
    pub e5: [f64; MAX_STAGES],
    /// Solution of order 3. Its difference from the step's own is the second estimate.
    pub third_order: [f64; MAX_STAGES],
}

/// An explicit Runge–Kutta method. Its data define the generic step, the dense output and the Hénon
/// step. The type of the data is not exported: the methods are those of [`crate::ode`].
pub trait RungeKutta {
    /// Name in messages.
    const NAME: &'static str;
    /// Order of the solution.
    const ORDER: u32;
    /// The data.
    const COEFFICIENTS: Coefficients;
    /// Error estimate; `None` for a method with fixed steps.
    const EMBEDDED: Option<Embedded>;
}

/// A full row from its nonzero entries.
pub(super) const fn row(entries: &[(usize, f64)]) -> [f64; MAX_STAGES] {
    let mut full = [0.0; MAX_STAGES];
    let mut i = 0;
    while i < entries.len() {
        full[entries[i].0] = entries[i].1;
        i += 1;
    }
    full
}

/// The full matrix from the nonzero entries of its rows.
pub(super) const fn rows(entries: &[&[(usize, f64)]]) -> [[f64; MAX_STAGES]; MAX_STAGES] {
    let mut full = [[0.0; MAX_STAGES]; MAX_STAGES];
    let mut i = 0;
    while i < entries.len() {
        full[i] = row(entries[i]);
        i += 1;
    }
    full
}
