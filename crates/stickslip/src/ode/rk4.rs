//! The classical Runge–Kutta method of order 4.

use super::tableau::{Coefficients, Embedded, RungeKutta, row, rows};

/// Kutta's method of order 4 with a fixed step and the cubic Hermite interpolant.
#[derive(Clone, Copy, Debug)]
pub struct Rk4;

impl RungeKutta for Rk4 {
    const NAME: &'static str = "RK4";
    const ORDER: u32 = 4;
    const COEFFICIENTS: Coefficients = Coefficients {
        stages: 4,
        dense_stages: 0,
        c: row(&[(1, 0.5), (2, 0.5), (3, 1.0), (4, 1.0)]),
        a: rows(&[&[], &[(0, 0.5)], &[(1, 0.5)], &[(2, 1.0)]]),
        b: row(&[
            (0, 1.0 / 6.0),
            (1, 1.0 / 3.0),
            (2, 1.0 / 3.0),
            (3, 1.0 / 6.0),
        ]),
        d: [[0.0; 16]; 4],
    };
    const EMBEDDED: Option<Embedded> = None;
}
