//! The listing's run, its limit, the exact orbit and the fate of a grid of starts.

use rayon::prelude::*;

use super::Fig08;
use crate::figures::FigureError;
use crate::figures::FigureSpec;
use crate::numbers::missing;
use crate::paper::listing::{self, Params, Sample, Setup};
use crate::paper::pattern::{Pattern, two_periodic};
use crate::paper::slip_times_three::{self, Injected};
use stickslip::analysis::{Destination, destination, multipliers, periodic_orbit_forced};
use stickslip::error::Error;
use stickslip::filippov::{Options, TransitionKind, solve};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Mode, Side, State};

/// The listing's settled motion.
#[derive(Clone, Debug)]
pub struct AsPrinted {
    /// What it settles on.
    pub pattern: Pattern,
    /// Where the body sticks in the plotted window: time and position at the start and at the end
    /// of each stretch.
    pub stuck: Vec<[(f64, f64); 2]>,
    /// Part of the time in stick phases, in the plotted window, in which the body is in no stick
    /// zone.
    pub outside_zones: f64,
    /// The plotted window: time, position, velocity.
    pub trajectory: Vec<(f64, f64, f64)>,
}

/// The stated model's attractor.
#[derive(Clone, Debug)]
pub struct Exact {
    /// What it settles on.
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

/// Where a grid of starts ends up, in parts of all.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shares {
    /// Starts in the grid.
    pub starts: usize,
    /// The slip-only orbit of one period.
    pub slip_only: f64,
    /// Any periodic motion with stick.
    pub stick_slip: f64,
    /// Of these the motions of the caption's kind, [`two_periodic`].
    pub stick_slip_two: f64,
    /// Any other periodic motion without stick.
    pub other: f64,
    /// Escape.
    pub escapes: f64,
    /// No periodic motion found.
    pub unsettled: f64,
}

/// What the figure shows.
#[derive(Clone, Debug)]
pub struct Data {
    /// The model.
    pub model: ForcedOscillator,
    /// Stick zones (lower end, upper end) in z (m).
    pub zones: Vec<(f64, f64)>,
    /// The listing's step (s).
    pub step: f64,
    /// The listing.
    pub as_printed: AsPrinted,
    /// The listing's limit.
    pub slip_times_three: Pattern,
    /// The stated model.
    pub exact: Exact,
    /// Where its starts end up.
    pub shares: Shares,
}

const TOLERANCE: f64 = 1e-13;
/// End of the runs that let the motion settle (s), the listing's own.
const SETTLED: f64 = 63.3;
/// Forcing periods in the picture.
const SHOWN: f64 = 2.0;
/// Forcing periods in which a pattern of any length shows itself.
const REPEATED: f64 = 24.0;

pub(super) fn compute() -> Result<Data, FigureError> {
    let model = ForcedOscillator::default();
    let zones = model.stick_zones().map_err(Fig08::failed)?;
    let options = Options::tol(TOLERANCE);
    let limit = slip_times_three::settled(Injected::BOTH).map_err(Fig08::failed)?;
    Ok(Data {
        step: Setup::default().h,
        as_printed: as_printed(&model, &zones)?,
        slip_times_three: limit,
        exact: exact(&model, &options).map_err(Fig08::failed)?,
        shares: shares(&model).map_err(Fig08::failed)?,
        model,
        zones,
    })
}

fn as_printed(model: &ForcedOscillator, zones: &[(f64, f64)]) -> Result<AsPrinted, FigureError> {
    let mut trajectory = Vec::new();
    let mut stuck: Vec<[(f64, f64); 2]> = Vec::new();
    let mut sticking = false;
    let (mut steps_stuck, mut steps_outside) = (0_u32, 0_u32);
    let keep = |sample: &Sample| {
        if !sample.in_window {
            return;
        }
        trajectory.push((sample.t, sample.x1, sample.x2));
        let here = (sample.t, sample.x1);
        let sticks = sample.mode == Mode::Stick;
        if sticks {
            let z = sample.x1 - model.support(sample.t);
            steps_stuck += 1;
            steps_outside +=
                u32::from(!zones.iter().any(|&(lower, upper)| lower <= z && z <= upper));
        }
        match stuck.last_mut() {
            Some(stretch) if sticking => stretch[1] = here,
            _ if sticks => stuck.push([here, here]),
            _ => {}
        }
        sticking = sticks;
    };
    let run = listing::run_with(&Setup::default(), keep).map_err(Fig08::failed)?;
    let pattern = Pattern::of_listing(&run).ok_or_else(|| {
        Fig08::failed(missing(
            "a motion of the listing that repeats",
            0.0,
            SETTLED,
        ))
    })?;
    Ok(AsPrinted {
        pattern,
        stuck,
        outside_zones: f64::from(steps_outside) / f64::from(steps_stuck.max(1)),
        trajectory,
    })
}

fn exact(model: &ForcedOscillator, options: &Options) -> Result<Exact, Error> {
    let period = model.period();
    let start = State::from([Params::default().x1, model.belt_speed]);
    let whole = (SETTLED / period).floor() * period;
    let settled = solve(model, 0.0, start, whole, options)?;
    let orbit = periodic_orbit_forced(model, 0.0, settled.x_end, period, options)?;
    let turns = solve(model, 0.0, &orbit.x, SHOWN * period, options)?;
    let many = solve(model, 0.0, &orbit.x, REPEATED * period, options)?;
    let pattern = Pattern::of_phases(&many.phases, many.t_end, period);
    let pattern =
        pattern.ok_or_else(|| missing("a motion that repeats", 0.0, REPEATED * period))?;
    let crossing = |to: Side| {
        let mut transitions = turns.transitions.iter();
        let first =
            transitions.find(|at| at.kind == TransitionKind::Crossing && at.to == Mode::Slip(to));
        first.ok_or_else(|| missing("a crossing of Σ", 0.0, SHOWN * period))
    };
    let (up, down) = (crossing(Side::Above)?, crossing(Side::Below)?);
    let sizes = multipliers(&orbit.monodromy);
    let mut multipliers = [0, 1].map(|k| stickslip::math::hypot(sizes[k].re, sizes[k].im));
    multipliers.sort_by(|one, other| other.total_cmp(one));
    let above = (down.t - up.t).rem_euclid(period);
    Ok(Exact {
        pattern,
        left: up.x[0],
        right: down.x[0],
        below: period - above,
        above,
        multipliers,
        trajectory: crate::figures::curve3(&turns),
    })
}

/// Starts in position and in velocity.
const GRID: (u32, u32) = (61, 41);
/// Outermost of them on either side (m, m/s).
pub const REACH: [f64; 2] = [1.2, 2.0];
/// Forcing periods that a start is followed over.
pub const FOLLOWED: usize = 40;
/// States a pattern apart that are this near count as equal.
const CLOSENESS: f64 = 1e-4;
/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
const ESCAPE: f64 = 10.0;

fn shares(model: &ForcedOscillator) -> Result<Shares, Error> {
    let (columns, rows) = GRID;
    let options = Options::tol(1e-9).escape(ESCAPE);
    let starts: Vec<State<2>> = (0..columns)
        .flat_map(|i| {
            (0..rows).map(move |j| {
                let part = |k: u32, of: u32| f64::from(k) / f64::from(of - 1);
                let at = |r: f64, part: f64| -r + 2.0 * r * part;
                State::from([at(REACH[0], part(i, columns)), at(REACH[1], part(j, rows))])
            })
        })
        .collect();
    let (period, periods) = (model.period(), FOLLOWED);
    let end = |&x: &State<2>| destination(model, (0.0, x), period, periods, CLOSENESS, &options);
    let ends = starts.par_iter().map(end);
    let ends = ends.collect::<Result<Vec<_>, Error>>()?;
    let each = 1.0 / starts.len() as f64;
    let share = |is: fn(&Destination) -> bool| {
        let count = ends.iter().filter(|end| is(end)).count();
        count as f64 * each
    };
    use Destination::{Escapes, Periodic, Unsettled};
    let slip_only = share(|end| {
        matches!(
            end,
            Periodic {
                sticks: 0,
                period: 1,
                ..
            }
        )
    });
    Ok(Shares {
        starts: starts.len(),
        slip_only,
        other: share(|end| {
            matches!(
                end,
                Periodic {
                    sticks: 0,
                    period: 2..,
                    ..
                }
            )
        }),
        stick_slip: share(|end| matches!(end, Periodic { sticks: 1.., .. })),
        stick_slip_two: share(
            |end| matches!(end, Periodic { sticks, period, .. } if two_periodic(*sticks, *period)),
        ),
        escapes: share(|end| matches!(end, Escapes { .. })),
        unsettled: share(|end| matches!(end, Unsettled)),
    })
}
