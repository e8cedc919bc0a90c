//! The transition function, its oscillating zeros and their bifurcation.

use crate::paper::models::ForcedOscillator;
use crate::paper::models::cubic::{Cubic, TangentPoint};
use crate::terminal::ProgramError;
use numerics::bisect;
use stickslip::Error;

/// The data of the figure. The drawn curves are for `k₁ = 1 N/m`, `k₂ = 1 N/m³`, as in the paper.
#[derive(Clone, Debug)]
pub struct Data {
    /// The spring.
    pub spring: Cubic,
    /// Critical `μ₀` for the spring, Eq. (23), N.
    pub critical: f64,
    /// (a) `σ(z)` without friction.
    pub without_friction: SigmaGraph,
    /// (a) `σ(z)` with critical friction.
    pub with_critical: SigmaGraph,
    /// (b) The zones over time.
    pub oscillation: TangentPointMotion,
    /// (c) Tangent points against `μ₀`.
    pub branches: Branches,
    /// Another spring, with `k₁ ≠ k₂`. For the paper's own, Eqs. (22) and (23) coincide with Eqs.
    /// (12) and (13).
    pub unequal: Cubic,
    /// Zeros of its `∂σ/∂z` by scan and bisection, m, ascending, for comparison with Eq. (22).
    pub stationary: Vec<f64>,
}

/// A graph of `σ` and its zeros.
#[derive(Clone, Debug)]
pub struct SigmaGraph {
    /// Friction coefficient.
    pub mu0: f64,
    /// `(z, σ)`, m and m²/s⁴, for `m = 1 kg`.
    pub graph: Vec<(f64, f64)>,
    /// The zeros.
    pub zeros: Vec<TangentPoint>,
    /// Intervals where `σ < 0`, m.
    pub zones: Vec<(f64, f64)>,
}

/// The tangent points as they move with the support of the spring.
#[derive(Clone, Debug)]
pub struct TangentPointMotion {
    /// The oscillator of Fig. 8.
    pub model: ForcedOscillator,
    /// The six tangent points without forcing, m.
    pub points: Vec<f64>,
    /// Times, s.
    pub times: Vec<f64>,
    /// Positions `zₖ + A sin(ωt)` at these times, m, in the order of the points.
    pub positions: Vec<Vec<f64>>,
}

/// Tangent points against friction.
#[derive(Clone, Debug)]
pub struct Branches {
    /// The six branches up to the critical friction, `(μ₀, z)`, in the paper's numbering.
    pub below: Vec<Vec<(f64, f64)>>,
    /// The two branches above it.
    pub above: Vec<Vec<(f64, f64)>>,
    /// Number of tangent points at `μ₀ = 0`, below, at, and above the critical value.
    pub counts: [usize; 4],
}

/// Range of `z` shown in (a), m.
pub(super) const Z_MAX: f64 = 1.35;
/// Forcing periods shown in (b).
const PERIODS_SHOWN: f64 = 2.0;

pub(super) fn compute() -> Result<Data, ProgramError> {
    let spring = Cubic::new(1.0, 1.0)?;
    let critical = spring.critical_mu0();
    let unequal = Cubic::new(3.0, 12.0)?;
    Ok(Data {
        spring,
        critical,
        without_friction: transition(&spring, 0.0)?,
        with_critical: transition(&spring, critical)?,
        oscillation: oscillation(&spring)?,
        branches: branches(&spring, critical)?,
        stationary: stationary(&unequal),
        unequal,
    })
}

fn transition(spring: &Cubic, mu0: f64) -> Result<SigmaGraph, Error> {
    Ok(SigmaGraph {
        mu0,
        graph: grid(-Z_MAX, Z_MAX, 1000)
            .map(|z| (z, spring.sigma(z, mu0, 1.0)))
            .collect(),
        zeros: spring.tangent_points(mu0)?,
        zones: spring.stick_zones(mu0)?,
    })
}

fn oscillation(spring: &Cubic) -> Result<TangentPointMotion, Error> {
    let model = ForcedOscillator::default();
    let points = spring.tangent_points(model.mu0)?;
    let points: Vec<f64> = points.iter().map(|point| point.z).collect();
    let times: Vec<f64> = grid(0.0, PERIODS_SHOWN * model.period(), 600).collect();
    let over_time = |z: &f64| times.iter().map(|t| z + model.support(*t)).collect();
    Ok(TangentPointMotion {
        positions: points.iter().map(over_time).collect(),
        model,
        points,
        times,
    })
}

fn branches(spring: &Cubic, critical: f64) -> Result<Branches, Error> {
    let mut below = vec![Vec::new(); 6];
    // Two branches meet at the critical value like a square root. Equal steps of that root sample
    // them evenly.
    for s in grid(0.0, 1.0, 400) {
        let mu0 = critical * s * (2.0 - s);
        let mut branch = below.iter_mut();
        for point in spring.tangent_points(mu0)? {
            for branch in branch.by_ref().take(point.multiplicity.into()) {
                branch.push((mu0, point.z));
            }
        }
    }
    let mut above = vec![Vec::new(); 2];
    for mu0 in grid(critical, 2.0 * critical, 200) {
        let points = spring.tangent_points(mu0)?;
        let outer = points.first().into_iter().chain(points.last());
        for (branch, point) in above.iter_mut().zip(outer) {
            branch.push((mu0, point.z));
        }
    }
    let count =
        |part: f64| -> Result<usize, Error> { Ok(spring.tangent_points(part * critical)?.len()) };
    Ok(Branches {
        below,
        above,
        counts: [count(0.0)?, count(0.5)?, count(1.0)?, count(1.5)?],
    })
}

/// Zeros of `∂σ/∂z` in `[-2, 2]`: grid points where it vanishes, and sign changes between grid
/// points, bisected to neighbouring numbers.
fn stationary(spring: &Cubic) -> Vec<f64> {
    let slope = |z| spring.sigma_slope(z, 1.0);
    let points: Vec<f64> = grid(-2.0, 2.0, 400).collect();
    let mut zeros = Vec::new();
    for pair in points.windows(2) {
        let (left, right) = (slope(pair[0]), slope(pair[1]));
        if left == 0.0 {
            zeros.push(pair[0]);
        } else if left * right < 0.0 {
            zeros.push(bisect(pair[0], pair[1], |z| slope(z) * right > 0.0));
        }
    }
    zeros
}

/// `intervals + 1` numbers from `from` to `to`.
fn grid(from: f64, to: f64, intervals: u32) -> impl Iterator<Item = f64> {
    (0..=intervals).map(move |i| {
        let s = f64::from(i) / f64::from(intervals);
        from * (1.0 - s) + to * s
    })
}
