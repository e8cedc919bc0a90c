//! The listing's run, its limit, the exact orbit, and the attractors of a grid of starts.

use rayon::prelude::*;

use crate::destination::{Destination, destination};
use crate::figures::{crossing, time_curve};
use crate::numbers::not_found;
use crate::paper::listing::{self, END, Motion, Sample, Setup, Stick};
use crate::paper::models::ForcedOscillator;
use crate::paper::pattern::{Pattern, two_periodic};
use crate::paper::published::LAST_DIGIT;
use crate::paper::slip_times_three::{self, InjectedDefects};
use crate::paper::{SETTLING_TOLERANCE, TOLERANCE, bounded};
use crate::terminal::ProgramError;
use stickslip::analysis::{PeriodicOrbit, multipliers};
use stickslip::{Error, Mode, Options, Side, State, solve};

/// The listing's settled motion.
#[derive(Clone, Debug)]
pub struct ListingMotion {
    /// Pattern.
    pub pattern: Pattern,
    /// The complete stick phases of the trajectory.
    pub stuck: Vec<Stick>,
    /// Fraction of the stick time in the plotted window during which the body is in no stick zone.
    pub outside_zones: f64,
    /// Two forcing periods of the settled motion, begun shortly before the longest stick phase, so
    /// that no phase is cut: time, position, velocity.
    pub trajectory: Vec<(f64, f64, f64)>,
    /// The listing's start: position and velocity.
    pub start: (f64, f64),
}

/// The stated model's attractor.
#[derive(Clone, Debug)]
pub struct StatedMotion {
    /// Pattern.
    pub pattern: Pattern,
    /// Position of the upward crossing (m).
    pub left: f64,
    /// Position of the downward crossing (m).
    pub right: f64,
    /// Time spent below the belt's speed in one period (s).
    pub below: f64,
    /// Time spent above it (s).
    pub above: f64,
    /// Moduli of the Floquet multipliers, the larger first.
    pub multipliers: [f64; 2],
    /// Two periods of it: time, position, velocity.
    pub trajectory: Vec<(f64, f64, f64)>,
}

/// Fractions of a grid of starts by attractor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shares {
    /// Starts in the grid.
    pub starts: usize,
    /// The slip-only orbit of one period.
    pub slip_only: f64,
    /// Any periodic motion with stick.
    pub stick_slip: f64,
    /// Motions of the caption's kind among these, [`two_periodic`].
    pub stick_slip_two: f64,
    /// Any other periodic motion without stick.
    pub other: f64,
    /// Orbits that escape.
    pub escapes: f64,
    /// Orbits without a periodic motion.
    pub unsettled: f64,
}

/// Content of the figure.
#[derive(Clone, Debug)]
pub struct Data {
    /// The model.
    pub model: ForcedOscillator,
    /// Stick zones (lower end, upper end) in z (m).
    pub zones: Vec<(f64, f64)>,
    /// The listing.
    pub as_printed: ListingMotion,
    /// The listing's limit.
    pub slip_times_three: Pattern,
    /// The stated model.
    pub exact: StatedMotion,
    /// Attractors of its starts.
    pub shares: Shares,
}

/// Forcing periods drawn: the published pattern.
const PERIODS_SHOWN: f64 = 2.0;
/// Time before the longest stick phase at which the listing's drawn trajectory begins (s).
const LEAD: f64 = 0.1;
/// Forcing periods in which a pattern of any length repeats: three times the longest.
const PERIODS_COMPARED: f64 = 3.0 * Motion::LONGEST_PATTERN as f64;

pub(super) fn compute() -> Result<Data, ProgramError> {
    let model = ForcedOscillator::default();
    let zones = model.stick_zones()?;
    let options = Options::tol(TOLERANCE);
    Ok(Data {
        as_printed: as_printed(&model, &zones)?,
        slip_times_three: slip_times_three::settled(InjectedDefects::BOTH)?,
        exact: exact(&model, &options)?,
        shares: shares(&model)?,
        model,
        zones,
    })
}

fn as_printed(
    model: &ForcedOscillator,
    zones: &[(f64, f64)],
) -> Result<ListingMotion, ProgramError> {
    let setup = Setup::default();
    let span = PERIODS_SHOWN * model.period();
    let mut samples = Vec::new();
    let (mut steps_stuck, mut steps_outside) = (0_u32, 0_u32);
    let keep = |sample: &Sample| {
        if sample.t >= setup.window_start - span {
            samples.push((sample.t, sample.x1, sample.x2));
        }
        if sample.in_window && sample.mode == Mode::Stick {
            let z = sample.x1 - model.support(sample.t);
            steps_stuck += 1;
            steps_outside +=
                u32::from(!zones.iter().any(|&(lower, upper)| lower <= z && z <= upper));
        }
    };
    let run = listing::run_with(&setup, keep);
    let what = "a motion of the listing that repeats";
    let pattern = Pattern::of_listing(&run).ok_or_else(|| not_found(what, 0.0, END))?;
    let longest = pattern.pattern_sticks();
    let longest = longest.max_by(|one, other| one.length().total_cmp(&other.length()));
    let end = samples.last().map_or(END, |last| last.0);
    let latest = end - span;
    let begin = longest.map_or(latest, |stick| stick.entry.t - LEAD);
    let begin = if begin > latest { begin - span } else { begin };
    let is_shown = |t: f64| begin <= t && t <= begin + span;
    let stuck = run.phases.iter().map(|phase| phase.stick);
    let [start_x1, start_x2] = setup.state().into();
    Ok(ListingMotion {
        pattern,
        stuck: stuck
            .filter(|one| is_shown(one.entry.t) && is_shown(one.exit.t))
            .collect(),
        outside_zones: f64::from(steps_outside) / f64::from(steps_stuck.max(1)),
        trajectory: samples.into_iter().filter(|at| is_shown(at.0)).collect(),
        start: (start_x1, start_x2),
    })
}

fn exact(model: &ForcedOscillator, options: &Options) -> Result<StatedMotion, Error> {
    let period = model.period();
    let start = Setup::default().state();
    let whole_periods = (END / period).floor() * period;
    let settled = solve(model, 0.0, start, whole_periods, options)?;
    let orbit = PeriodicOrbit::near_forced(model, 0.0, settled.x_end, period, options)?;
    let turns = solve(model, 0.0, &orbit.x, PERIODS_SHOWN * period, options)?;
    let many = solve(model, 0.0, &orbit.x, PERIODS_COMPARED * period, options)?;
    let pattern = Pattern::of_phases(&many.phases, many.t_end, period);
    let pattern = pattern
        .ok_or_else(|| not_found("a motion that repeats", 0.0, PERIODS_COMPARED * period))?;
    let (up, down) = (
        crossing(&turns, Side::Above)?,
        crossing(&turns, Side::Below)?,
    );
    let sizes = multipliers(&orbit.monodromy);
    let mut multipliers = [0, 1].map(|k| stickslip::math::hypot(sizes[k].re, sizes[k].im));
    multipliers.sort_by(|one, other| other.total_cmp(one));
    let above = (down.t - up.t).rem_euclid(period);
    Ok(StatedMotion {
        pattern,
        left: up.x[0],
        right: down.x[0],
        below: period - above,
        above,
        multipliers,
        trajectory: time_curve(&turns),
    })
}

/// Number of positions and velocities of the starts. They are chosen: 2501 starts give shares to
/// about one per cent.
const START_GRID: (u32, u32) = (61, 41);
/// Largest position and velocity of a start (m, m/s): beyond the outer tangent points and the
/// settled motion. Other windows have other shares, which the report says.
pub const START_RANGE: [f64; 2] = [1.2, 2.0];
/// Forcing periods over which a start is integrated: the length of the listing's run.
pub const PERIODS_FOLLOWED: usize = 40;

/// A grid of starts with its corners at [`START_RANGE`].
pub(crate) fn starts(columns: u32, rows: u32) -> Vec<State<2>> {
    let part = |k: u32, of: u32| 2.0 * f64::from(k) / f64::from(of - 1) - 1.0;
    let at = |i, j| {
        State::from([
            START_RANGE[0] * part(i, columns),
            START_RANGE[1] * part(j, rows),
        ])
    };
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| at(i, j)));
    all.collect()
}

fn shares(model: &ForcedOscillator) -> Result<Shares, Error> {
    let options = bounded(SETTLING_TOLERANCE);
    let starts = starts(START_GRID.0, START_GRID.1);
    let (period, periods) = (model.period(), PERIODS_FOLLOWED);
    // States one pattern apart are equal to the paper's last digit.
    let end = |&x: &State<2>| destination(model, (0.0, x), period, periods, LAST_DIGIT, &options);
    let ends = starts.par_iter().map(end);
    let ends = ends.collect::<Result<Vec<_>, Error>>()?;
    let each = 1.0 / starts.len() as f64;
    let share = |is: &dyn Fn(&Destination) -> bool| {
        let count = ends.iter().filter(|end| is(end)).count();
        count as f64 * each
    };
    let periodic = |is: fn(usize, usize) -> bool| {
        share(&|end| {
            matches!(
                end,
                Destination::Periodic { sticks, period, .. } if is(*sticks, *period)
            )
        })
    };
    Ok(Shares {
        starts: starts.len(),
        slip_only: periodic(|sticks, period| sticks == 0 && period == 1),
        other: periodic(|sticks, period| sticks == 0 && period > 1),
        stick_slip: periodic(|sticks, _| sticks > 0),
        stick_slip_two: periodic(two_periodic),
        escapes: share(&|end| matches!(end, Destination::Escapes { .. })),
        unsettled: share(&|end| matches!(end, Destination::Unsettled)),
    })
}
