//! The orbits, the tangent points and the cycle.

use crate::figures::{crossing, normals, phase_plane};
use crate::numbers::{change_points, not_found};
use crate::paper::TOLERANCE;
use crate::paper::models::{BeltOscillator, BeltTangency};
use crate::terminal::ProgramError;
use stickslip::analysis::{PeriodicOrbit, multipliers};
use stickslip::scalar::Dual;
use stickslip::{Error, Filippov, Mode, Options, Scalar, Side, State, Transition, solve};

/// The limit cycle.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// Period (s).
    pub period: f64,
    /// Nontrivial Floquet multiplier.
    pub multiplier: f64,
    /// Position of the upward crossing of Σ (m).
    pub left: f64,
    /// Position of the downward crossing of Σ (m).
    pub right: f64,
    /// Accelerations on either side of Σ at the upward crossing: below, above (m/s²).
    pub kink: [f64; 2],
    /// Stick phases in one period.
    pub sticks: usize,
    /// The cycle as a curve `(x1, x2)`.
    pub curve: Vec<(f64, f64)>,
}

/// Content of the figure.
#[derive(Clone, Debug)]
pub struct Data {
    /// The model.
    pub model: BeltOscillator,
    /// Positions (m) where σ, the product of the two fields' normal components on Σ, is stationary.
    /// The largest comes first.
    pub stationary: Vec<f64>,
    /// The friction amplitudes at which σ vanishes there (N).
    pub critical_mu0: Vec<f64>,
    /// Six tangent points, largest first.
    pub tangents: Vec<BeltTangency>,
    /// Stick zones as intervals of x1.
    pub zones: Vec<(f64, f64)>,
    /// Starts of the orbits: the tangent points, then the other starts.
    pub starts: Vec<(f64, f64)>,
    /// Orbits from the starts, as curves.
    pub orbits: Vec<Vec<(f64, f64)>>,
    /// Whether each orbit has a stick phase.
    pub sticks: Vec<bool>,
    /// The cycle.
    pub cycle: Cycle,
}

/// Length of the drawn orbits (s): about two oscillations. After that they cannot be distinguished
/// from the cycle.
const DRAWN_TIME: f64 = 16.0;
/// Time after which an orbit is near enough to the cycle for Newton's iteration (s).
const SETTLING_TIME: f64 = 60.0;
/// Starts besides the tangent points: inside the cycle below the belt's speed, and outside the
/// cycle above it.
const FURTHER_STARTS: [(f64, f64); 2] = [(-0.4, 0.4), (-0.6, 1.5)];

pub(super) fn compute() -> Result<Data, ProgramError> {
    let model = BeltOscillator::default();
    let options = Options::tol(TOLERANCE);
    let tangents = model.tangent_points()?;
    let on_belt = tangents.iter().map(|at| (at.position, model.belt_speed));
    let starts: Vec<(f64, f64)> = on_belt.chain(FURTHER_STARTS).collect();
    let (mut orbits, mut sticks) = (Vec::new(), Vec::new());
    for &(x1, x2) in &starts {
        let orbit = solve(&model, 0.0, State::from([x1, x2]), DRAWN_TIME, &options)?;
        sticks.push(orbit.sticks().next().is_some());
        orbits.push(phase_plane(&orbit));
    }
    let stationary = stationary(&model);
    // For a body at rest on the belt, friction has opposite signs on the two sides. So the mean of
    // the two normal components is the spring's acceleration.
    let spring = |x1: f64| {
        let [below, above] = normals(&model, 0.0, &[x1, model.belt_speed]);
        0.5 * (below + above)
    };
    Ok(Data {
        critical_mu0: stationary.iter().map(|&x1| spring(x1)).collect(),
        stationary,
        model,
        tangents,
        zones: model.stick_zones()?,
        starts,
        sticks,
        orbits,
        cycle: cycle(&model, &options)?,
    })
}

/// The zeros of ∂σ/∂x₁ (Eq. 11) on Σ. They are bracketed on a grid without zeros and bisected to
/// the last bit.
fn stationary(model: &BeltOscillator) -> Vec<f64> {
    let slope = |x1: f64| {
        let x = [Dual::new(x1, 1.0), Dual::new(model.belt_speed, 0.0)];
        let [below, above] = normals(model, Dual::constant(0.0), &x);
        (below * above).eps
    };
    let grid = (0..=300).rev().map(|k| 1.507 - 0.01 * f64::from(k));
    let mut zeros = change_points(grid, |x1| slope(x1) < 0.0);
    zeros.reverse();
    zeros
}

fn cycle(model: &BeltOscillator, options: &Options) -> Result<Cycle, Error> {
    let start = State::from([0.0, model.belt_speed]);
    let settled = solve(model, 0.0, start, SETTLING_TIME, options)?;
    let upward = |at: &&Transition<2>| at.to == Mode::Slip(Side::Above);
    let crossings: Vec<f64> = settled
        .transitions
        .iter()
        .filter(upward)
        .map(|at| at.t)
        .collect();
    let [.., before, last] = crossings[..] else {
        return Err(not_found("two upward crossings of Σ", 0.0, SETTLING_TIME));
    };
    // Off Σ, a tenth of an oscillation before the crossing.
    let guess = settled.at(last - 0.1 * (last - before))?;
    let orbit = PeriodicOrbit::near(model, guess, last - before, options)?;
    let turn = solve(model, 0.0, &orbit.x, orbit.period, options)?;
    let (up, down) = (crossing(&turn, Side::Above)?, crossing(&turn, Side::Below)?);
    let acceleration = |side| model.field(side, up.t, up.x.as_ref())[1];
    Ok(Cycle {
        period: orbit.period,
        multiplier: multipliers(&orbit.monodromy)[1].re,
        left: up.x[0],
        right: down.x[0],
        kink: [Side::Below, Side::Above].map(acceleration),
        sticks: turn.sticks().count(),
        curve: phase_plane(&turn),
    })
}
