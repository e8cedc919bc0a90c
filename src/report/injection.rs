//! The two defects that survive the listing's limit, put into the event-exact solver; and what the stated model does there.

use crate::paper::listing::{self, Defects, Direction, ListingError, Params, Setup};
use crate::paper::slip_times_three::{self, SlipTimesThree};
use stickslip::analysis::{Visibility, visibility};
use stickslip::error::Error;
use stickslip::filippov::{Options, Phase, TransitionKind, normal_component, solve};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Filippov, Mode, Side, State};

const TOLERANCE: f64 = 1e-13;
/// End of the runs (s), the listing's own.
const END: f64 = 63.3;
/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
const ESCAPE: f64 = 10.0;
/// Lengths of stick phases two periods apart that differ by no more are the same (m).
const SAME_LENGTH: f64 = 1e-6;

/// The settled motion with both defects injected.
#[derive(Clone, Debug, PartialEq)]
pub struct Injection {
    /// Lengths of the two stick phases (m), then their durations (s).
    pub numbers: [f64; 4],
    /// Stick phases in the last two forcing periods.
    pub sticks: usize,
    /// Whether they repeat after two forcing periods and not after one.
    pub period_two: bool,
    /// Crossings of Σ without stick at negative positions in two forcing periods.
    pub deflections: usize,
    /// Stick phases in the last two forcing periods that end at a visible tangent point of the stated model.
    pub visible_exits: usize,
    /// What becomes of the published start with only the one-sided exit injected: stick phases in the last two periods, or the
    /// error that the run ends with.
    pub exit_alone: Result<usize, Error>,
}

/// Ends of stick phases of the stated model itself, on the way from many starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exits {
    /// Stick phases that ended.
    pub all: usize,
    /// Those that ended at a visible tangent point.
    pub visible: usize,
}

impl Injection {
    /// Runs both.
    ///
    /// # Errors
    /// Those of [`slip_times_three::run`]; [`Error::NotFound`] if no two stick phases are left.
    pub fn compute() -> Result<Injection, Error> {
        let model = ForcedOscillator::default();
        let zones = model.stick_zones()?;
        let start = State::from([Params::default().x1, model.belt_speed]);
        let options = Options::tol(TOLERANCE).escape(ESCAPE);
        let both = slip_times_three::run(&model, &zones, start, END, &options)?;
        let numbers = both.four_numbers(model.period()).ok_or(Error::NotFound {
            what: "a pair of stick phases",
            t: 0.0,
            span: END,
        })?;
        let alone = slip_times_three::run_hastened(1.0, &model, &zones, start, END, &options);
        let span = 1.99 * model.period();
        // A phase exactly two periods before the last belongs to the pattern before.
        let sticks = sticks_until(&both, END, span);
        let end = sticks.last().map_or(0.0, |phase| phase.t_end);
        let before = sticks_until(&both, end - span, span);
        let near = |a: &Phase<2>, b: &Phase<2>| {
            (a.displacement()[0] - b.displacement()[0]).abs() <= SAME_LENGTH
        };
        let repeats =
            sticks.len() == before.len() && sticks.iter().zip(&before).all(|(a, b)| near(a, b));
        let alternates = sticks.windows(2).any(|pair| !near(&pair[0], &pair[1]));
        let slips = |phase: &Phase<2>| matches!(phase.mode, Mode::Slip(_));
        let deflections = both
            .phases
            .windows(2)
            .filter(|pair| slips(&pair[0]) && slips(&pair[1]))
            .map(|pair| (pair[1].t_start, pair[1].x_start[0]))
            .filter(|&(t, x1)| t > end - span && t <= end && x1 < 0.0)
            .count();
        Ok(Injection {
            numbers,
            sticks: sticks.len(),
            period_two: repeats && alternates,
            deflections,
            visible_exits: sticks
                .iter()
                .filter(|phase| leaves_visibly(&model, phase.t_end, &phase.x_end))
                .count(),
            exit_alone: alone.map(|run| {
                let recent = END - 2.0 * model.period();
                let stick = |phase: &&Phase<2>| phase.mode == Mode::Stick && phase.t_end > recent;
                run.phases.iter().filter(stick).count()
            }),
        })
    }
}

/// How far the settled crossings of the listing with all its defects mended, at the printed step, are from those of the event-exact
/// orbit at `left` (upwards) and `right` (downwards), m: whether it may stand for an accurate solver.
///
/// # Errors
/// [`ListingError`] if the listing cannot run.
pub fn mended_listing_error(left: f64, right: f64) -> Result<f64, ListingError> {
    let outcome = listing::run(&Setup {
        defects: Defects::MENDED,
        ..Setup::default()
    })?;
    let last = |direction: Direction| {
        let mut crossings = outcome.crossings.iter().rev();
        crossings.find(|crossing| crossing.direction == direction)
    };
    let off = |direction, exact: f64| {
        last(direction).map_or(f64::INFINITY, |found| (found.at.x1 - exact).abs())
    };
    Ok(off(Direction::Up, left).max(off(Direction::Down, right)))
}

/// The stick phases that end within `span` before the end of the last one up to `until`.
fn sticks_until(run: &SlipTimesThree, until: f64, span: f64) -> Vec<Phase<2>> {
    let sticks = run.phases.iter().filter(|phase| phase.mode == Mode::Stick);
    let ended: Vec<Phase<2>> = sticks
        .filter(|phase| phase.t_end <= until)
        .copied()
        .collect();
    let end = ended.last().map_or(until, |phase| phase.t_end);
    let recent = |phase: &Phase<2>| phase.t_end > end - span;
    ended.into_iter().filter(recent).collect()
}

/// Whether the field that is tangent at a point of Σ, the one with the lesser normal component, is visibly so.
fn leaves_visibly(model: &ForcedOscillator, t: f64, x: &State<f64, 2>) -> bool {
    let normal = |side: Side| normal_component(model, t, x, &model.field(side, t, x)).abs();
    let side = if normal(Side::Below) < normal(Side::Above) {
        Side::Below
    } else {
        Side::Above
    };
    visibility(model, side, t, x) == Visibility::Visible
}

/// Starts of [`Exits::compute`].
const STARTS: (u32, u32) = (13, 9);
/// Forcing periods that each is followed over: stick phases occur on the way only.
const FOLLOWED: f64 = 10.0;

impl Exits {
    /// Follows a grid of starts in the stated model and looks at every end of a stick phase.
    ///
    /// # Errors
    /// Those of [`solve`] except an escape.
    pub fn compute() -> Result<Exits, Error> {
        let model = ForcedOscillator::default();
        let options = Options::tol(TOLERANCE).escape(ESCAPE);
        let mut exits = Exits::default();
        for i in 0..STARTS.0 {
            for j in 0..STARTS.1 {
                let part = |k: u32, of: u32| 2.0 * f64::from(k) / f64::from(of - 1) - 1.0;
                let x = State::from([1.2 * part(i, STARTS.0), 2.0 * part(j, STARTS.1)]);
                let orbit = match solve(&model, 0.0, x, FOLLOWED * model.period(), &options) {
                    Ok(orbit) => orbit,
                    Err(failure) if matches!(failure.error, Error::Escaped { .. }) => {
                        *failure.orbit
                    }
                    Err(failure) => return Err(failure.into()),
                };
                for at in &orbit.transitions {
                    if let (TransitionKind::StickExit, Mode::Slip(side)) = (at.kind, at.to) {
                        exits.all += 1;
                        let seen = visibility(&model, side, at.t, &at.x);
                        exits.visible += usize::from(seen == Visibility::Visible);
                    }
                }
            }
        }
        Ok(exits)
    }
}
