//! The stick phases that a grid of starts goes through, in the stated model and in the listing.

use rayon::prelude::*;

use super::EvidenceError;
use super::grid::{FOLLOWED, follow, starts};
use crate::paper::listing::{Defect, Defects, ListingError, Params, Run, Setup, StickPhase, run};
use stickslip::analysis::{Visibility, visibility};
use stickslip::error::Error;
use stickslip::filippov::TransitionKind;
use stickslip::models::ForcedOscillator;
use stickslip::system::{Mode, State};

/// A stick phase of the listing no longer than ten of its steps (s) is chatter: it leaves a zone's end on the wrong side, is thrown back
/// and sticks again, thousands of times.
const CHATTER: f64 = 1e-3;

/// A complete stick phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stick {
    /// Time (s) and position (m) at its begin.
    pub entry: (f64, f64),
    /// The same at its end.
    pub exit: (f64, f64),
    /// Largest difference of the velocity from the belt's (m/s), at both ends and in the middle of every step.
    pub speed_error: f64,
    /// Whether the field that takes over is visibly tangent where it ends; time counted in the derivative.
    pub visible: bool,
}

/// What a grid of starts goes through: shared by the statements on stick phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Stick phases of the stated model.
    pub(super) model: Vec<Stick>,
    /// Stick phases of the listing as printed.
    pub(super) listing: OfListing,
    /// Those of the listing with both ends of the zone tested.
    pub(super) both_ends_tested: OfListing,
}

/// Stick phases of the listing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OfListing {
    /// Those that last longer than [`CHATTER`], in the order of the starts.
    pub phases: Vec<StickPhase>,
    /// How many others there are.
    pub chatter: usize,
}

impl Followed {
    /// Follows all starts over ten forcing periods in the stated model and in the listing.
    ///
    /// # Errors
    /// [`EvidenceError`] of the first run that fails; an escape is none.
    pub fn compute() -> Result<Followed, EvidenceError> {
        let model = ForcedOscillator::default();
        let both = Defects::AS_PRINTED.flipped(Defect::OneSidedExit);
        Ok(Followed {
            model: of_model(&model)?,
            listing: of_listing(&model, Defects::AS_PRINTED)?,
            both_ends_tested: of_listing(&model, both)?,
        })
    }
}

/// Those of the stated model from all starts, each followed over [`FOLLOWED`] forcing periods.
pub(super) fn of_model(model: &ForcedOscillator) -> Result<Vec<Stick>, Error> {
    let runs = starts()
        .into_par_iter()
        .map(|x| of_start(model, x))
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(runs.into_iter().flatten().collect())
}

fn of_start(model: &ForcedOscillator, x: State<2>) -> Result<Vec<Stick>, Error> {
    let orbit = follow(model, 0.0, x)?;
    let mut sticks = Vec::new();
    for at in &orbit.transitions {
        let (TransitionKind::StickExit, Mode::Slip(side)) = (at.kind, at.to) else {
            continue;
        };
        let Some(phase) = orbit.sticks().find(|phase| phase.t_end == at.t) else {
            continue;
        };
        let steps = orbit
            .steps
            .iter()
            .filter(|step| step.t_start >= phase.t_start && step.t_end <= phase.t_end);
        let speed_error = steps
            .flat_map(|step| {
                let middle = step.dense.at_time(0.5 * (step.t_start + step.t_end));
                [step.x_start, middle, step.x_end]
            })
            .map(|x| (x[1] - model.belt_speed).abs())
            .fold(0.0, f64::max);
        sticks.push(Stick {
            entry: (phase.t_start, phase.x_start[0]),
            exit: (at.t, at.x[0]),
            speed_error,
            visible: visibility(model, side, at.t, &at.x) == Visibility::Visible,
        });
    }
    Ok(sticks)
}

/// Those of the listing with these defects, from the same starts over the same time.
fn of_listing(model: &ForcedOscillator, defects: Defects) -> Result<OfListing, ListingError> {
    let runs = starts()
        .into_par_iter()
        .map(|x| {
            let params = Params {
                x1: x[0],
                x2: x[1],
                ..Params::default()
            };
            run(&Setup {
                params,
                defects,
                end: FOLLOWED * model.period(),
                window_start: 0.0,
                ..Setup::default()
            })
        })
        .collect::<Result<Vec<Run>, ListingError>>()?;
    let all = runs.into_iter().flat_map(|run| run.phases);
    let (phases, chatter): (Vec<_>, Vec<_>) = all.partition(|phase| phase.duration() > CHATTER);
    Ok(OfListing {
        phases,
        chatter: chatter.len(),
    })
}
