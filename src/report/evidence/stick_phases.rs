//! The stick phases that a grid of starts goes through, in the stated model and in the listing, and
//! the set (24) of tangent points.

use rayon::prelude::*;

use crate::figures::fig08;
use crate::numbers::{bisect, largest};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defect, Defects, Instant, ListingError, Run, Setup, StickPhase, run};
use crate::paper::published::{Claims, PublishedError};
use crate::report::{ReportError, stick_exits, until_escape};
use stickslip::analysis::{Visibility, visibility};
use stickslip::models::ForcedOscillator;
use stickslip::{Error, Orbit, State};

/// Starts in position and in velocity.
const STARTS: (u32, u32) = (13, 9);
/// Forcing periods that each is followed over: stick phases occur on the way only.
const FOLLOWED: f64 = 10.0;
pub(super) const TOLERANCE: f64 = 1e-13;
/// A stick phase of the listing no longer than ten of its steps (s) is chatter: it leaves a zone's
/// end on the wrong side, is thrown back and sticks again, thousands of times.
const CHATTER: f64 = 1e-3;
/// The starts, none of them at the belt's speed.
pub(super) fn starts() -> Vec<State<2>> {
    fig08::starts(STARTS.0, STARTS.1)
}

/// The orbit from `(t0, x)` over [`FOLLOWED`] forcing periods, as far as it goes before it escapes.
pub(super) fn follow(model: &ForcedOscillator, t0: f64, x: State<2>) -> Result<Orbit<2>, Error> {
    Ok(until_escape(model, (t0, x), FOLLOWED * model.period(), TOLERANCE)?.0)
}

/// Time (s) and position (m).
pub(super) type At = (f64, f64);

/// A complete stick phase of the stated model.
#[derive(Clone, Copy)]
pub(super) struct Stick {
    pub(super) entry: At,
    pub(super) exit: At,
    /// Largest difference of the velocity from the belt's (m/s), at both ends and in the middle of
    /// every step.
    pub(super) speed_error: f64,
    /// Whether the field that takes over is visibly tangent where it ends; time counted in the
    /// derivative.
    pub(super) visible: bool,
}

/// Stick phases of the listing: those that last longer than [`CHATTER`], in the order of the
/// starts, and how many others there are.
pub(super) struct OfListing {
    pub(super) phases: Vec<StickPhase>,
    pub(super) chatter: usize,
}

/// What a grid of starts goes through: shared by the statements on stick phases.
pub(super) struct Followed {
    pub(super) model: Vec<Stick>,
    /// The listing as printed, and with both ends of the zone tested.
    pub(super) listing: OfListing,
    pub(super) both_ends_tested: OfListing,
    /// The settled motion of the listing as printed: that of Fig. 8.
    pub(super) fig08: Run,
    pub(super) set: TangentSet,
}

impl Followed {
    /// Follows all starts; an escape is no error.
    pub(super) fn compute() -> Result<Followed, ReportError> {
        let model = ForcedOscillator::default();
        let both = Defects::AS_PRINTED.flipped(Defect::OneSidedExit);
        Ok(Followed {
            model: of_model(&model)?,
            listing: of_listing(&model, Defects::AS_PRINTED)?,
            both_ends_tested: of_listing(&model, both)?,
            fig08: run(&Setup::default())?,
            set: TangentSet::published()?,
        })
    }
}

pub(super) fn of_model(model: &ForcedOscillator) -> Result<Vec<Stick>, Error> {
    let runs = starts().into_par_iter().map(|x| of_start(model, x));
    let runs = runs.collect::<Result<Vec<_>, Error>>()?;
    Ok(runs.into_iter().flatten().collect())
}

fn of_start(model: &ForcedOscillator, x: State<2>) -> Result<Vec<Stick>, Error> {
    let orbit = follow(model, 0.0, x)?;
    let mut sticks = Vec::new();
    for (at, side, phase) in stick_exits(&orbit) {
        let steps = orbit.steps.iter();
        let within = steps.filter(|one| one.t_start >= phase.t_start && one.t_end <= phase.t_end);
        let states = within.flat_map(|step| {
            let middle = step.dense.at_time(0.5 * (step.t_start + step.t_end));
            [step.x_start, middle, step.x_end]
        });
        sticks.push(Stick {
            entry: (phase.t_start, phase.x_start[0]),
            exit: (at.t, at.x[0]),
            speed_error: largest(states.map(|x| (x[1] - model.belt_speed).abs())),
            visible: visibility(model, side, at.t, &at.x) == Visibility::Visible,
        });
    }
    Ok(sticks)
}

fn of_listing(model: &ForcedOscillator, defects: Defects) -> Result<OfListing, ListingError> {
    let of_start = |x: State<2>| {
        run(&Setup {
            defects,
            end: FOLLOWED * model.period(),
            window_start: 0.0,
            ..Setup::starting(0.0, x[0], x[1])
        })
    };
    let runs = starts().into_par_iter().map(of_start);
    let runs = runs.collect::<Result<Vec<Run>, ListingError>>()?;
    let all = runs.into_iter().flat_map(|run| run.phases);
    let (phases, chatter): (Vec<_>, Vec<_>) =
        all.partition(|phase| phase.stick.duration() > CHATTER);
    let chatter = chatter.len();
    Ok(OfListing { phases, chatter })
}

/// Begins and ends of the listing's stick phases.
pub(super) fn ends(phases: &[StickPhase]) -> impl Iterator<Item = (At, At)> {
    let at = |at: Instant| (at.t, at.x1);
    let sticks = phases.iter().map(|one| one.stick);
    sticks.map(move |stick| (at(stick.entry), at(stick.exit)))
}

/// The six tangent points of Eq. (24) at rest (m), numbered from the largest down as the paper
/// does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TangentSet(pub(super) [f64; 6]);

impl TangentSet {
    /// As published.
    pub(super) fn published() -> Result<TangentSet, PublishedError> {
        let claim = Claims::committed()?.of(ClaimId::Eq24TangentPoints);
        let mut values = claim.values().to_vec();
        values.sort_by(|one, other| other.total_cmp(one));
        let value = |k| values.get(k).copied().unwrap_or(f64::NAN);
        Ok(TangentSet(std::array::from_fn(value)))
    }

    /// Distances (m) of a body at `x1` from the points moved by the support at `t`.
    pub(super) fn gaps(&self, model: &ForcedOscillator, (t, x1): At) -> [f64; 6] {
        let offset = model.support(t);
        self.0.map(|z| x1 - (z + offset))
    }

    /// Number, counted from 0, of the moved point nearest to a body, and its distance (m).
    pub(super) fn nearest(&self, model: &ForcedOscillator, at: At) -> (usize, f64) {
        let gaps = self.gaps(model, at).map(f64::abs).into_iter().enumerate();
        let nearest = gaps.min_by(|one, other| one.1.total_cmp(&other.1));
        nearest.unwrap_or((0, f64::INFINITY))
    }

    /// When (s) a body that rides the belt from `(t, x1)` first meets one of the moved points, by
    /// that equation alone; nothing within `span`.
    pub(super) fn first_meeting(
        &self,
        model: &ForcedOscillator,
        (t, x1): At,
        span: f64,
    ) -> Option<f64> {
        // A gap changes by less than its own size over such a part of the forcing period.
        let part = model.period() / 2000.0;
        let ahead = |later: f64| {
            let gaps = self.gaps(model, (t + later, x1 + model.belt_speed * later));
            gaps.map(|gap| gap > 0.0)
        };
        let start = ahead(0.0);
        let steps = (span / part).ceil() as u32;
        let after = (1..=steps).find(|&k| ahead(f64::from(k) * part) != start)?;
        let (low, high) = (f64::from(after - 1) * part, f64::from(after) * part);
        Some(t + bisect(low, high, |later| ahead(later) != start))
    }
}
