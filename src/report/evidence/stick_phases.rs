//! The stick phases from a grid of starts, in the stated model and in the listing, and the set (24)
//! of tangent points.

use rayon::prelude::*;

use crate::figures::fig08;
use crate::numbers::largest;
use crate::paper::TOLERANCE;
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{
    Defect, Defects, Instant, PRINTED_STEP, Run, Setup, Stick, StickPhase, run,
};
use crate::paper::models::{ForcedOscillator, visibility};
use crate::paper::published::Claims;
use crate::report::{stick_exits, until_escape};
use numerics::bisect;
use stickslip::{Error, Orbit, State, Visibility};

/// Number of positions and velocities of the starts. No row has the belt's speed.
const START_GRID: (u32, u32) = (13, 9);
/// Forcing periods over which each start is integrated. Stick phases occur only in the transient.
const PERIODS_FOLLOWED: f64 = 10.0;
/// Sampling times per forcing period, between which a tangent point moves by less than a hundredth
/// of a zone.
pub(super) const SAMPLES_PER_PERIOD: f64 = 2000.0;
/// A stick phase of the listing no longer than ten of its steps (s) is chatter. The body leaves a
/// zone's end on the wrong side, returns and sticks again, thousands of times.
const CHATTER: f64 = 10.0 * PRINTED_STEP;

/// The starts, none of them at the belt's speed.
pub(super) fn starts() -> Vec<State<2>> {
    fig08::starts(START_GRID.0, START_GRID.1)
}

/// The orbit from `(t0, x)` over [`PERIODS_FOLLOWED`] forcing periods, or until it escapes.
pub(super) fn follow(model: &ForcedOscillator, t0: f64, x: State<2>) -> Result<Orbit<2>, Error> {
    Ok(until_escape(model, (t0, x), PERIODS_FOLLOWED * model.period(), TOLERANCE)?.0)
}

/// A complete stick phase of the stated model.
#[derive(Clone, Copy)]
pub(super) struct ModelPhase {
    pub(super) stick: Stick,
    /// Largest difference of the velocity from the belt's (m/s), at both ends and in the middle of
    /// every step.
    pub(super) speed_error: f64,
    /// Whether the field that applies after the phase is visibly tangent at its end. The derivative
    /// includes the time.
    pub(super) visible: bool,
}

/// Stick phases of the listing that last longer than [`CHATTER`], in the order of the starts, and
/// the number of others.
pub(super) struct ListingPhases {
    pub(super) phases: Vec<StickPhase>,
    pub(super) chatter: usize,
}

impl ListingPhases {
    pub(super) fn sticks(&self) -> impl Iterator<Item = Stick> {
        self.phases.iter().map(|phase| phase.stick)
    }
}

/// The stick phases from a grid of starts, shared by the statements on them.
pub(super) struct GridPhases {
    pub(super) model: Vec<ModelPhase>,
    /// The listing as printed, and with both ends of the zone tested.
    pub(super) listing: ListingPhases,
    pub(super) both_ends_tested: ListingPhases,
    /// The listing as printed from its own start, which settles on the motion of Fig. 8.
    pub(super) fig08: Run,
    pub(super) set: TangentSet,
}

impl GridPhases {
    /// Integrates all starts. An escape is not an error.
    pub(super) fn compute(claims: &Claims) -> Result<GridPhases, Error> {
        let model = ForcedOscillator::default();
        let both = Defects::AS_PRINTED.flipped(Defect::OneSidedExit);
        Ok(GridPhases {
            model: of_model(&model)?,
            listing: of_listing(&model, Defects::AS_PRINTED),
            both_ends_tested: of_listing(&model, both),
            fig08: run(&Setup::default()),
            set: TangentSet::published(claims),
        })
    }

    /// The stick phases of Fig. 8's motion.
    pub(super) fn of_fig08(&self) -> impl ExactSizeIterator<Item = Stick> {
        self.fig08.settled_phases().iter().map(|phase| phase.stick)
    }
}

pub(super) fn of_model(model: &ForcedOscillator) -> Result<Vec<ModelPhase>, Error> {
    let runs = starts().into_par_iter().map(|x| of_start(model, x));
    let runs = runs.collect::<Result<Vec<_>, Error>>()?;
    Ok(runs.into_iter().flatten().collect())
}

fn of_start(model: &ForcedOscillator, x: State<2>) -> Result<Vec<ModelPhase>, Error> {
    let orbit = follow(model, 0.0, x)?;
    let phases = stick_exits(&orbit).map(|(at, side, phase)| {
        let steps = orbit.steps.iter();
        let within = steps.filter(|one| one.t_start >= phase.t_start && one.t_end <= phase.t_end);
        let states = within.flat_map(|step| {
            let middle = step.dense.at_time(0.5 * (step.t_start + step.t_end));
            [step.x_start, middle, step.x_end]
        });
        ModelPhase {
            stick: Stick::of(phase),
            speed_error: largest(states.map(|x| (x[1] - model.belt_speed).abs())),
            visible: visibility(model, side, at.t, &at.x) == Visibility::Visible,
        }
    });
    Ok(phases.collect())
}

fn of_listing(model: &ForcedOscillator, defects: Defects) -> ListingPhases {
    let of_start = |x: State<2>| {
        run(&Setup {
            start: [0.0, x[0], x[1]],
            defects,
            end: PERIODS_FOLLOWED * model.period(),
            window_start: 0.0,
            ..Setup::default()
        })
    };
    let runs: Vec<Run> = starts().into_par_iter().map(of_start).collect();
    let all = runs.into_iter().flat_map(|run| run.phases);
    let (phases, chatter): (Vec<_>, Vec<_>) =
        all.partition(|phase| phase.stick.duration() > CHATTER);
    let chatter = chatter.len();
    ListingPhases { phases, chatter }
}

/// The six tangent points of Eq. (24) without forcing (m), numbered from the largest as in the
/// paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TangentSet(pub(super) [f64; 6]);

impl TangentSet {
    /// The published set.
    pub(super) fn published(claims: &Claims) -> TangentSet {
        let mut values = claims.of(ClaimId::Eq24TangentPoints).values().to_vec();
        values.sort_by(|one, other| other.total_cmp(one));
        let value = |k| values.get(k).copied().unwrap_or(f64::NAN);
        TangentSet(std::array::from_fn(value))
    }

    /// Distances (m) of a body from the points displaced by the support.
    pub(super) fn gaps(&self, model: &ForcedOscillator, at: Instant) -> [f64; 6] {
        let offset = model.support(at.t);
        self.0.map(|z| at.x1 - (z + offset))
    }

    /// Index of the displaced point nearest to a body, from 0, and its distance (m).
    pub(super) fn nearest(&self, model: &ForcedOscillator, at: Instant) -> (usize, f64) {
        let gaps = self.gaps(model, at).map(f64::abs).into_iter().enumerate();
        let nearest = gaps.min_by(|one, other| one.1.total_cmp(&other.1));
        nearest.unwrap_or((0, f64::INFINITY))
    }

    /// Time (s) at which a body that rides the belt from `begin` first meets a displaced point, by
    /// that equation alone. `None` if not within `span`.
    pub(super) fn first_meeting(
        &self,
        model: &ForcedOscillator,
        begin: Instant,
        span: f64,
    ) -> Option<f64> {
        let part = model.period() / SAMPLES_PER_PERIOD;
        let ahead = |later: f64| {
            let at = Instant {
                t: begin.t + later,
                x1: begin.x1 + model.belt_speed * later,
            };
            self.gaps(model, at).map(|gap| gap > 0.0)
        };
        let start = ahead(0.0);
        let steps = (span / part).ceil() as u32;
        let after = (1..=steps).find(|&k| ahead(f64::from(k) * part) != start)?;
        let (low, high) = (f64::from(after - 1) * part, f64::from(after) * part);
        Some(begin.t + bisect(low, high, |later| ahead(later) != start))
    }
}
