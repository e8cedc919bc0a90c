//! What becomes of all starts at one set of parameters.

use super::class::Class;
use super::stick_slip::StickSlip;
use crate::paper::pattern::two_periodic;
use stickslip::analysis::{Destination, destination};
use stickslip::error::Error;
use stickslip::filippov::{AtRepelling, Options, TransitionKind, solve};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Mode, State, Unchecked};

/// Forcing periods that a start is followed over.
const FOLLOWED: usize = 60;
/// States a pattern apart that are this near count as equal.
const CLOSENESS: f64 = 1e-5;
/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
const ESCAPE: f64 = 10.0;
const TOLERANCE: f64 = 1e-9;

/// What becomes of all starts at one set of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Factor that the printed value is multiplied by.
    pub factor: f64,
    /// The value.
    pub value: f64,
    /// How many starts lead to each class, in the order of [`Class::ALL`].
    pub counts: [usize; 5],
    /// The stick–slip motions found, each once.
    pub stick_slip: Vec<StickSlip>,
}

impl Point {
    /// Follows all starts in a model that has `value` in the place of one parameter, `factor` times the printed one.
    ///
    /// # Errors
    /// Those of [`solve`] except an escape.
    pub(in crate::report) fn compute(
        model: &ForcedOscillator,
        starts: &[State<2>],
        factor: f64,
        value: f64,
    ) -> Result<Point, Error> {
        // A spring that pulls back for large stretches lets nobody go, however fast.
        let pushes_out = model.k2 > 0.0;
        let options = Options::tol(TOLERANCE)
            .escape(if pushes_out { ESCAPE } else { 100.0 * ESCAPE })
            .at_repelling(AtRepelling::GoAbove);
        let mut counts = [0; 5];
        let mut stick_slip: Vec<StickSlip> = Vec::new();
        for &x in starts {
            let end = settled(model, x, &options)?;
            let class = match end {
                Destination::Escapes { .. } => Class::Escape,
                Destination::Unsettled => Class::Unsettled,
                Destination::Periodic { sticks: 0, .. } => Class::SlipOnly,
                Destination::Periodic { period, x, sticks } => {
                    let motion = StickSlip {
                        period,
                        lengths: lengths(model, &x, period, &options)?,
                    };
                    if !stick_slip.iter().any(|known| known.is(&motion)) {
                        stick_slip.push(motion);
                    }
                    if two_periodic(sticks, period) {
                        Class::StickSlipTwo
                    } else {
                        Class::StickSlip
                    }
                }
            };
            counts[class as usize] += 1;
        }
        Ok(Point {
            factor,
            value,
            counts,
            stick_slip,
        })
    }

    /// Of the stick–slip motions the one nearest to the published lengths that `allowed` lets pass, and its distance.
    pub fn nearest(
        &self,
        published: [f64; 2],
        allowed: impl Fn(&StickSlip) -> bool,
    ) -> Option<(&StickSlip, f64)> {
        self.stick_slip
            .iter()
            .filter(|motion| allowed(motion))
            .map(|motion| (motion, motion.distance(published)))
            .min_by(|one, other| one.1.total_cmp(&other.1))
    }
}

/// Where a start ends up. A motion with stick is followed on, for one that comes near its neighbour of half the period slowly is
/// easily taken for one of twice the period.
fn settled(
    model: &ForcedOscillator,
    x: State<2>,
    options: &Options,
) -> Result<Destination<2>, Error> {
    // Friction of the other sign is among the variants.
    let follow = |x, periods, closeness| {
        destination(
            &Unchecked(model),
            (0.0, x),
            model.period(),
            periods,
            closeness,
            options,
        )
    };
    match follow(x, FOLLOWED, CLOSENESS)? {
        Destination::Periodic { sticks, x, .. } if sticks > 0 => {
            follow(x, 4 * FOLLOWED, 0.1 * CLOSENESS)
        }
        end => Ok(end),
    }
}

/// Lengths of the stick phases that end within one pattern of a periodic motion (m), the longest first.
fn lengths(
    model: &ForcedOscillator,
    x: &State<2>,
    period: usize,
    options: &Options,
) -> Result<Vec<f64>, Error> {
    let pattern = period as f64 * model.period();
    // A phase that has begun when the first pattern begins is whole in the second.
    let orbit = solve(&Unchecked(model), 0.0, *x, 2.0 * pattern, options)?;
    let exits = orbit
        .transitions
        .iter()
        .filter(|at| at.kind == TransitionKind::StickExit);
    let ends: Vec<f64> = exits.map(|at| at.t).filter(|&t| t > pattern).collect();
    let mut lengths: Vec<f64> = orbit
        .phases
        .iter()
        .filter(|phase| phase.mode == Mode::Stick && ends.contains(&phase.t_end))
        .map(|phase| phase.displacement()[0])
        .collect();
    lengths.sort_by(|one, other| other.total_cmp(one));
    Ok(lengths)
}
