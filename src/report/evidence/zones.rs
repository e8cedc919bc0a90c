//! The stick zones of model 2: their location, their motion, what they attract, and the motion of
//! bodies beside the curves of Fig. 7.

use rayon::prelude::*;

use super::stick_phases::TangentSet;
use crate::figures::fig07::Oscillation as Drawn;
use crate::figures::rows::Value;
use crate::numbers::{bisect, change_points, extent, largest, not_found};
use crate::paper::reading::Reading::Exact;
use crate::report::belt_positions;
use crate::report::digits::small;
use crate::report::errata::Proof;
use crate::report::finding::{Finding, statement};
use crate::report::scan::{Class, PARAMETERS, Point, StickSlip, starts};
use crate::text::joined;
use stickslip::models::ForcedOscillator;
use stickslip::{Error, Fate, Filippov, Mode, Options, Side, State, fate, solve};

/// Range of positions relative to the support (m), half as far again as the outermost tangent
/// point, and number of positions tested: a hundred in the narrowest zone.
const REACH: f64 = 1.6;
const POSITIONS_TESTED: u32 = 1600;
/// Differences within this count as zero (m): the last digits of a bisected position.
const ROUNDING: f64 = 1e-12;

/// Positions x1 (m), ascending, at which stick begins or ends along Σ at time `t` (s).
fn stick_ends(model: &ForcedOscillator, t: f64) -> Vec<f64> {
    let sticks = |x1: f64| fate(model, t, &State::from([x1, model.belt_speed])) == Fate::Stick;
    // Off round numbers, at which zones end for round parameters.
    let place = |k: u32| REACH * (2.0 * f64::from(k) / f64::from(POSITIONS_TESTED) - 1.0) + 1.3e-4;
    let offset = model.support(t);
    change_points((0..=POSITIONS_TESTED).map(|k| offset + place(k)), sticks)
}

/// Factor by which [`location`] changes each parameter.
const FACTOR: f64 = 1.05;
const NAMED: [&str; 3] = ["k1", "k2", "mu0"];
const OTHERS: [&str; 3] = ["m", "vp", "delta"];

/// Smallest and largest displacement (m) of the ends when each parameter is changed. It is infinite
/// if the number of zones changes.
fn shifts(model: &ForcedOscillator, of: [&'static str; 3]) -> [(&'static str, (f64, f64)); 3] {
    let ends = stick_ends(model, 0.0);
    of.map(|name| {
        let mut other = *model;
        for (_, _, of) in PARAMETERS.iter().filter(|one| one.0 == name) {
            *of(&mut other) *= FACTOR;
        }
        let others = stick_ends(&other, 0.0);
        if others.len() != ends.len() {
            return (name, (f64::INFINITY, f64::INFINITY));
        }
        let shifts = ends.iter().zip(&others).map(|(a, b)| (a - b).abs());
        (name, extent(shifts))
    })
}

/// `s4.zone_location`: the parameters on which the location of the stick zones depends.
pub(super) fn location(model: &ForcedOscillator) -> Vec<Finding> {
    let ends = stick_ends(model, 0.0).len();
    let (named, others) = (shifts(model, NAMED), shifts(model, OTHERS));
    let moves = named.iter().all(|(_, (least, _))| *least > ROUNDING);
    let what = "the place of the stick zones depends on k1, k2 and mu0";
    let each = |(name, (_, most)): (&str, (f64, f64))| format!("{name} {}", small(most));
    let [named, others] = [named, others].map(|of| joined(of.map(each), ", "));
    let percent = 100.0 * (FACTOR - 1.0);
    let line = format!(
        "each parameter {percent:.0} % larger moves the {ends} ends of the zones by up to (m): \
            {named}; not named and without influence: {others}"
    );
    vec![statement(Exact, [(what, ends > 0 && moves)], line)]
}

/// Times in one forcing period, including a quarter and three quarters of it.
const TIMES: u32 = 48;

/// Motion of the stick zone over a forcing period.
#[derive(Clone, Debug, PartialEq)]
pub struct Oscillation {
    /// Whether the zone has six ends at all times.
    six_ends: bool,
    /// Largest difference of an end, bisected along Σ by the test for sticking, from `z_k + A
    /// sin(ωt)` (m).
    largest_difference: f64,
    /// The ends at time 0 (m), ascending. The support then has no displacement.
    pub at_rest: Vec<f64>,
    /// Travel of the uppermost end along x1 (m), and twice the amplitude A of the support (m).
    travel_x1: f64,
    twice_amplitude: f64,
    /// Travel of Σ, and of the zone in it, along x2 (m/s): the velocity at which the boundary
    /// function vanishes at the zone's ends.
    travel_x2: f64,
}

impl Oscillation {
    /// Bisects along Σ at all times.
    pub(super) fn of(model: &ForcedOscillator, set: &TangentSet) -> Oscillation {
        let times = (0..TIMES).into_par_iter();
        let over_time: Vec<(f64, Vec<f64>)> = times
            .map(|k| {
                let t = model.period() * f64::from(k) / f64::from(TIMES);
                (t, stick_ends(model, t))
            })
            .collect();
        // Time, end, and tangent point.
        let mut ends = Vec::new();
        for (t, of_time) in &over_time {
            let numbered = of_time.iter().rev().zip(set.0);
            ends.extend(numbered.map(|(end, z)| (*t, *end, z)));
        }
        let travel = |(low, high): (f64, f64)| high - low;
        let last = over_time
            .iter()
            .filter_map(|(_, ends)| ends.last().copied());
        // The velocity (m/s) at which the boundary function vanishes for a position.
        let speed = |&(t, x1, _): &(f64, f64, f64)| {
            bisect(-10.0, 10.0, |x2| model.boundary(t, &[x1, x2]) >= 0.0)
        };
        let off = |&(t, end, z): &(f64, f64, f64)| (end - (z + model.support(t))).abs();
        Oscillation {
            six_ends: over_time.iter().all(|(_, ends)| ends.len() == 6),
            largest_difference: largest(ends.iter().map(off)),
            travel_x1: travel(extent(last)),
            twice_amplitude: 2.0 * model.amplitude,
            travel_x2: travel(extent(ends.iter().map(speed))),
            at_rest: over_time
                .into_iter()
                .next()
                .map_or_else(Vec::new, |one| one.1),
        }
    }

    /// `s4.zone_oscillates`.
    pub(super) fn zone(&self) -> Vec<Finding> {
        let Oscillation {
            travel_x1,
            travel_x2,
            twice_amplitude,
            ..
        } = self;
        let moves = self.six_ends && self.largest_difference <= ROUNDING && self.along_x1();
        let parts = [
            ("the tangent points move by A sin(ωt)", moves),
            ("the zone oscillates along x2", *travel_x2 > ROUNDING),
        ];
        let difference = small(self.largest_difference);
        let line = format!(
            "ends of the stick zone bisected along Σ at {TIMES} times of a period: within \
             {difference} m of z_k + A sin(ωt); they travel {travel_x1:.4} m along x1, twice A \
             being {twice_amplitude:.4} m, and {travel_x2} m/s along x2"
        );
        vec![statement(Exact, parts, line)]
    }

    fn along_x1(&self) -> bool {
        (self.travel_x1 - self.twice_amplitude).abs() <= ROUNDING
    }

    /// `s6.oscillating_boundary`.
    pub(super) fn boundary(&self) -> Vec<Finding> {
        let (boundary, zone) = (self.travel_x2, self.travel_x1);
        let what = "the harmonic excitation moves the stick zone in it";
        let parts = [
            ("the boundary of discontinuity oscillates", boundary > 0.0),
            (what, zone > 0.0),
        ];
        let line = format!(
            "over a forcing period Σ travels {boundary} m/s along x2; the stick zone in it travels \
                {zone:.4} m along x1"
        );
        vec![statement(Exact, parts, line)]
    }

    /// The direction in which the zone is said to oscillate.
    pub(super) fn direction(&self) -> Proof {
        let (x1, x2) = (self.travel_x1, self.travel_x2);
        let which = match (x1 > 0.0, x2 > 0.0) {
            (true, true) => "both",
            (true, false) => "x1",
            (false, true) => "x2",
            (false, false) => "neither",
        };
        let travels = [x1, self.twice_amplitude, x2].map(Value::from);
        let shown = travels.into_iter().chain([which.into()]);
        Proof::new("direction", shown, self.along_x1() && x2 == 0.0)
    }
}

/// Number of positions in the wide zone, and of values of friction up to the critical one, both
/// equidistant.
const OF_ZONE: u32 = 400;
const VALUES: u32 = 25;

/// Forcing periods and stick phases of a stick–slip cycle.
type Cycle = (usize, usize);
/// The distinct cycles at one friction, and the number of starts that lead to them.
type Cycles = (Vec<Cycle>, usize);

/// Model 2 with the mass and the belt's speed of Fig. 7.
fn of_fig07() -> ForcedOscillator {
    ForcedOscillator {
        mass: 1.0,
        belt_speed: 1.0,
        ..ForcedOscillator::default()
    }
}

/// `s4.zone_attracts`: whether the wide stick zone attracts, and whether stick–slip cycles arise
/// below the critical friction.
pub(super) fn attracts() -> Result<Vec<Finding>, Error> {
    let (fig07, fig08) = (of_fig07(), ForcedOscillator::default());
    let sweeps = [Sweep::of("Fig. 7", &fig07)?, Sweep::of("Fig. 8", &fig08)?];
    Ok(statement_findings(zone(&fig07), &sweeps))
}

fn statement_findings((attracting, least_pull): (usize, f64), sweeps: &[Sweep]) -> Vec<Finding> {
    let any = |holds: fn(&Sweep) -> bool| sweeps.iter().any(holds);
    let parts = [
        (
            "at the critical friction both fields face each other on the whole zone",
            attracting == OF_ZONE as usize,
        ),
        (
            "below it, at some mu0, there are stick–slip cycles",
            any(|sweep| sweep.with_cycles() > 0),
        ),
        (
            "they are what the attraction results in: at most of the values tried",
            any(|sweep| 2 * sweep.with_cycles() > sweep.points.len()),
        ),
        (
            "they appear, vanish or change with mu0",
            any(|sweep| sweep.births_and_deaths() + sweep.cycle_changes() > 0),
        ),
    ];
    let each = sweeps.iter().map(|sweep| {
        let (caption, starts, critical) = (sweep.caption, sweep.starts, sweep.at_critical.1);
        let (cycles, values) = (sweep.with_cycles(), sweep.points.len());
        let (births, changes) = (sweep.births_and_deaths(), sweep.cycle_changes());
        format!(
            "with the parameters of {caption} stick–slip cycles at {cycles} of {values} values \
             below it ({starts} starts each), which between neighbours appear or vanish {births} \
             times and change period or number of sticks {changes} times; at the critical friction \
             itself, which is another reading of the sentence, {critical} starts lead to one"
        )
    });
    let (pull, each) = (small(least_pull), joined(each, "; "));
    let line = format!(
        "at the critical friction {attracting} of {OF_ZONE} places of the zone attract, the weaker \
         field by {pull} m/s² where it is weakest; “strongly” is not tested, for the paper gives \
         no measure; {each}"
    );
    vec![statement(Exact, parts, line)]
}

/// Critical friction (N), Eq. (23).
pub(super) fn critical(model: &ForcedOscillator) -> f64 {
    2.0 * model.k1 / 3.0 * (model.k1 / (3.0 * model.k2)).sqrt()
}

/// Number of attracting positions, and the smallest attraction (m/s²) along the zone, at the
/// critical friction.
fn zone(model: &ForcedOscillator) -> (usize, f64) {
    let model = ForcedOscillator {
        mu0: critical(model),
        ..*model
    };
    let outer = 2.0 * (model.k1 / (3.0 * model.k2)).sqrt();
    let (mut attracting, mut least) = (0, f64::INFINITY);
    for x in belt_positions(outer, OF_ZONE, model.belt_speed) {
        attracting += usize::from(fate(&model, 0.0, &x) == Fate::Stick);
        for side in [Side::Below, Side::Above] {
            least = least.min(-side.sign() * model.field(side, 0.0, x.as_ref())[1]);
        }
    }
    (attracting, least)
}

/// A sweep of μ0 below its critical value with the other parameters of one caption.
struct Sweep {
    caption: &'static str,
    /// Starts at each value.
    starts: usize,
    /// Cycles at each value, ascending, including the critical friction.
    points: Vec<Cycles>,
    at_critical: Cycles,
}

impl Sweep {
    fn of(caption: &'static str, model: &ForcedOscillator) -> Result<Sweep, Error> {
        let at = |k: u32| -> Result<Cycles, Error> {
            let ratio = f64::from(k) / f64::from(VALUES);
            let mu0 = ratio * critical(model);
            let model = ForcedOscillator { mu0, ..*model };
            let point = Point::compute(&model, &starts(&model)?, ratio, mu0)?;
            let cycle = |motion: &StickSlip| (motion.period, motion.lengths.len());
            let mut cycles: Vec<Cycle> = point.stick_slip.iter().map(cycle).collect();
            cycles.sort_unstable();
            let of = |class: Class| point.counts[class as usize];
            Ok((cycles, of(Class::StickSlip) + of(Class::StickSlipTwo)))
        };
        let points = (1..=VALUES).into_par_iter().map(at);
        let mut points = points.collect::<Result<Vec<Cycles>, Error>>()?;
        let at_critical = points.pop();
        Ok(Sweep {
            caption,
            starts: starts(model)?.len(),
            at_critical: at_critical.ok_or_else(|| not_found("a value of friction", 0.0, 0.0))?,
            points,
        })
    }

    /// Number of values with a stick–slip cycle.
    fn with_cycles(&self) -> usize {
        let with = self.points.iter().filter(|(cycles, _)| !cycles.is_empty());
        with.count()
    }

    fn neighbours(&self, are: fn(&[Cycle], &[Cycle]) -> bool) -> usize {
        let pairs = self.points.windows(2);
        pairs.filter(|pair| are(&pair[0].0, &pair[1].0)).count()
    }

    /// Number of neighbouring values of which one has cycles and the other has none: there cycles
    /// appear or vanish.
    fn births_and_deaths(&self) -> usize {
        self.neighbours(|one, other| one.is_empty() != other.is_empty())
    }

    /// Number of neighbouring values, both with cycles, whose cycles differ in period or number of
    /// stick phases.
    fn cycle_changes(&self) -> usize {
        self.neighbours(|one, other| !one.is_empty() && !other.is_empty() && one != other)
    }
}

/// Distances from the curves (m).
const DISTANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Equidistant times of the drawn curve, without the first and the last.
const BESIDE_TIMES: usize = 24;
/// Length of the runs (s). Only the first phase matters.
const SPAN: f64 = 1e-2;
/// Tolerance: errors of a run stay far below the differences that decide here.
const TOLERANCE: f64 = 1e-13;

/// Bodies at one distance from the curves.
#[derive(Default)]
struct BodiesBesideCurves {
    /// The distance (m).
    distance: f64,
    /// Bodies placed inside a zone, and as many outside.
    pairs: usize,
    /// Bodies inside that stick, and bodies outside that slip.
    inside_sticks: usize,
    outside_slips: usize,
}

/// `fig07b.oscillation`: bodies placed on Σ just beside the drawn curves stick on one side of them
/// and slip on the other.
pub(super) fn beside_curves(
    model: &ForcedOscillator,
    drawn: &Drawn,
) -> Result<Vec<Finding>, Error> {
    let all = drawn.times.len();
    let every = (all / (BESIDE_TIMES + 1)).max(1);
    let times: Vec<usize> = (1..=BESIDE_TIMES)
        .map(|k| k * every)
        .filter(|&k| k < all)
        .collect();
    let beside = DISTANCES
        .into_par_iter()
        .map(|distance| at_distance(model, drawn, &times, distance))
        .collect::<Result<Vec<BodiesBesideCurves>, Error>>()?;
    let curves = drawn.positions.len();
    let all = |right: fn(&BodiesBesideCurves) -> usize| {
        let holds = |one: &BodiesBesideCurves| one.pairs > 0 && right(one) == one.pairs;
        curves == 6 && beside.iter().all(holds)
    };
    let sticks = all(|one| one.inside_sticks);
    let slips = all(|one| one.outside_slips);
    let parts = [
        ("bodies put just inside the drawn curves stick", sticks),
        ("bodies put just outside slip", slips),
    ];
    let distances = beside.iter().map(|one| {
        let (distance, pairs) = (one.distance, one.pairs);
        let (inside, outside) = (one.inside_sticks, one.outside_slips);
        format!(
            "{distance:.0e} m: {inside} of {pairs} inside stick, {outside} of {pairs} outside slip"
        )
    });
    let (times, distances) = (times.len(), joined(distances, "; at "));
    let line = format!(
        "model 2 integrated from Σ beside the {curves} drawn curves at {times} times of two \
            periods; at {distances}"
    );
    Ok(vec![statement(Exact, parts, line)])
}

fn at_distance(
    model: &ForcedOscillator,
    drawn: &Drawn,
    times: &[usize],
    distance: f64,
) -> Result<BodiesBesideCurves, Error> {
    let mut beside = BodiesBesideCurves {
        distance,
        ..BodiesBesideCurves::default()
    };
    for (number, positions) in drawn.positions.iter().enumerate() {
        // The curves are drawn from the largest down: upper end, lower end, upper end, …
        let inward = if number % 2 == 0 { -distance } else { distance };
        let places = |&k: &usize| Some((*drawn.times.get(k)?, *positions.get(k)?));
        for (t, x1) in times.iter().filter_map(places) {
            beside.pairs += 1;
            beside.inside_sticks += usize::from(sticks(model, t, x1 + inward)?);
            beside.outside_slips += usize::from(!sticks(model, t, x1 - inward)?);
        }
    }
    Ok(beside)
}

/// Whether a body placed on the belt there sticks at first.
fn sticks(model: &ForcedOscillator, t: f64, x1: f64) -> Result<bool, Error> {
    let x = State::from([x1, model.belt_speed]);
    let orbit = solve(model, t, x, t + SPAN, &Options::tol(TOLERANCE))?;
    let first = orbit.phases.first();
    Ok(first.is_some_and(|phase| phase.mode == Mode::Stick))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::fig07::FIG07;
    use crate::paper::published::Claims;

    fn published() -> TangentSet {
        TangentSet::published(Claims::committed().unwrap())
    }

    /// Friction that drives the body.
    fn driving() -> ForcedOscillator {
        let model = ForcedOscillator::default();
        ForcedOscillator {
            mu0: -model.mu0,
            ..model
        }
    }

    #[test]
    fn springs_and_friction_move_the_zones_and_nothing_else_does() {
        let model = ForcedOscillator::default();
        assert_eq!(location(&model)[0].parts(), [true]);
        let others = shifts(&model, OTHERS);
        assert!(others.iter().all(|one| one.1.1 <= ROUNDING), "{others:?}");
        assert_eq!(stick_ends(&model, 0.0).len(), 6);
        assert_eq!(location(&driving())[0].parts(), [false]);
    }

    #[test]
    fn the_zone_moves_along_x1_and_not_along_x2() {
        let (model, set) = (ForcedOscillator::default(), published());
        let found = Oscillation::of(&model, &set);
        assert_eq!(found.zone()[0].parts(), [true, false], "{found:?}");
        assert_eq!(found.boundary()[0].parts(), [false, true]);
        assert!(found.direction().holds);
        let along_x2 = Oscillation {
            travel_x2: 0.1,
            ..found.clone()
        };
        assert!(!along_x2.direction().holds);
        let at_rest = Oscillation {
            travel_x1: 0.0,
            ..found
        };
        assert_eq!(at_rest.boundary()[0].parts(), [false, false]);
    }

    #[test]
    fn another_friction_or_a_displaced_point_is_seen() {
        let (model, mut set) = (ForcedOscillator::default(), published());
        let moves = |model: &ForcedOscillator, set: &TangentSet| {
            Oscillation::of(model, set).zone()[0].parts()[0]
        };
        let stronger = ForcedOscillator {
            mu0: 1.001 * model.mu0,
            ..model
        };
        assert!(!moves(&stronger, &set));
        assert!(!Oscillation::of(&driving(), &set).six_ends);
        set.0[3] += 1e-9;
        assert!(!moves(&model, &set));
    }

    #[test]
    fn friction_that_drives_attracts_nowhere() {
        let model = ForcedOscillator::default();
        let (attracting, pull) = zone(&model);
        assert!(attracting == OF_ZONE as usize && pull > 0.0);
        let driving = ForcedOscillator {
            mu0: -critical(&model),
            ..model
        };
        let x = State::from([0.3, model.belt_speed]);
        assert_eq!(fate(&driving, 0.0, &x), Fate::Repelling);
    }

    #[test]
    fn cycles_arise_below_the_critical_friction_and_not_at_it() {
        let (fig07, fig08) = (of_fig07(), ForcedOscillator::default());
        let of_fig08 = Sweep::of("Fig. 8", &fig08).unwrap();
        assert!(of_fig08.with_cycles() > 0 && of_fig08.at_critical.0.is_empty());
        let of_fig07 = Sweep::of("Fig. 7", &fig07).unwrap();
        assert_eq!(of_fig07.with_cycles(), 0);
        // Without the parameters of Fig. 8 only the zone remains.
        let alone = statement_findings(zone(&fig07), &[of_fig07]);
        assert_eq!(alone[0].parts(), [true, false, false, false]);
        let both = statement_findings(zone(&fig07), &[of_fig08])[0].parts();
        assert!(both[1] && both.contains(&false), "{both:?}");
    }

    #[test]
    fn changes_are_between_neighbours_that_both_have_cycles() {
        let sweep = |points: &[&[Cycle]]| Sweep {
            caption: "a test",
            starts: 1,
            points: points.iter().map(|cycles| (cycles.to_vec(), 1)).collect(),
            at_critical: (Vec::new(), 0),
        };
        let same = sweep(&[&[(1, 1)], &[(1, 1)], &[]]);
        let found = (
            same.with_cycles(),
            same.cycle_changes(),
            same.births_and_deaths(),
        );
        assert_eq!(found, (2, 0, 1));
        assert_eq!(sweep(&[&[(1, 1)], &[(2, 2)]]).cycle_changes(), 1);
    }

    fn sticks_and_slips(model: &ForcedOscillator, drawn: &Drawn) -> Vec<bool> {
        beside_curves(model, drawn).unwrap()[0].parts()
    }

    #[test]
    fn the_drawn_curves_part_stick_from_slip_and_displaced_ones_do_not() {
        let model = ForcedOscillator::default();
        let mut drawn = FIG07.compute().unwrap().oscillation;
        assert_eq!(sticks_and_slips(&model, &drawn), [true, true]);
        let antiphase = ForcedOscillator {
            amplitude: -model.amplitude,
            ..model
        };
        assert_eq!(sticks_and_slips(&antiphase, &drawn), [false, false]);
        for x1 in &mut drawn.positions[2] {
            *x1 += 1e-5;
        }
        let displaced = sticks_and_slips(&model, &drawn);
        assert!(displaced.contains(&true) && displaced.contains(&false));
    }
}
