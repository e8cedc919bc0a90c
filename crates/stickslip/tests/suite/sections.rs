//! User-defined events and Poincaré maps compared with closed forms: circles, cycles of known
//! period, and differences.

use std::f64::consts::PI;

use numerics::SplitMix;
use stickslip::Direction::{Both, Falling, Rising};
use stickslip::analysis::{PoincareMap, multipliers};
use stickslip::dynamics::{Matrix, Section, Vector};
use stickslip::{
    Direction, Ending, Error, EventFunctions, EventRecord, Method, Mode, Options, Orbit, Scalar,
    Side, State, StepRecord, math,
};

use crate::any_system::{monodromy, periodic_orbit, solve, solve_with_events};
use crate::blocks::Block;
use crate::compiled::Compiled;
use crate::den_hartog::DenHartog;
use crate::solver::systems::{Floor, decaying_friction};

/// Choice of one event function, so that the search is compiled once for all of them.
#[derive(Clone, Copy)]
pub enum Function {
    /// A component of the state minus a level.
    Level(usize, f64),
    /// `sin ωt`, with this ω.
    Wave(f64),
    /// `sin (ω x + 0.1)` of the first component, with this ω.
    Fine(f64),
    /// A fall through zero at this time, with a narrow bump 0.2 later.
    Bump(f64),
    /// A resonance of width 1 in time about a centre, over this width, less half its height.
    Resonance(f64, f64),
    /// The product of the first and the last component, minus a level.
    Product(f64),
    /// A combination of time, first and last component and one, declared as affine or not.
    Combination([f64; 4], bool),
}

/// Event functions, the directions searched for, and the terminal event.
pub struct EventSet<const E: usize> {
    functions: [Function; E],
    directions: [Direction; E],
    terminal: Option<usize>,
}

impl<const N: usize, const E: usize> EventFunctions<N> for EventSet<E> {
    fn count(&self) -> usize {
        E
    }
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T {
        match self.functions[number] {
            Function::Level(i, level) => x[i] - level,
            Function::Wave(omega) => (t * omega).sin(),
            Function::Fine(omega) => (x[0] * omega + 0.1).sin(),
            Function::Bump(fall) => {
                let late = (t - (fall + 0.2)) * 1e3;
                -t + fall + (-late * late).exp() * 2.0
            }
            Function::Resonance(centre, width) => {
                let off = (t - centre) / width;
                (off * off + 1.0).recip() - 0.5
            }
            Function::Product(level) => x[0] * x[N - 1] - level,
            Function::Combination([in_time, first, last, one], _) => {
                t * in_time + x[0] * first + x[N - 1] * last + one
            }
        }
    }
    fn direction(&self, number: usize) -> Direction {
        self.directions[number]
    }
    fn is_terminal(&self, number: usize) -> bool {
        self.terminal == Some(number)
    }
    fn is_affine(&self, number: usize) -> bool {
        use Function::{Combination, Level};
        matches!(self.functions[number], Level(..) | Combination(_, true))
    }
}

fn watch(function: Function, direction: Direction) -> EventSet<1> {
    EventSet {
        functions: [function],
        directions: [direction],
        terminal: None,
    }
}

/// Runge–Kutta steps, Taylor steps, short and fixed steps, with the allowed error of event times.
fn methods() -> [(Options, f64); 4] {
    let slopes = Options::tol(1e-14);
    [
        (slopes, 1e-12),
        (slopes.method(Method::Taylor), 1e-12),
        (Options::default().longest_step(0.02), 1e-12),
        (Options::default().method(Method::Rk4 { step: 1e-3 }), 1e-11),
    ]
}

/// From 3 at rest [`Floor`]'s circles have radii 2.6, 1.8, 1 and 0.2 about ±0.4, half a turn each.
/// Then it rests at -0.2.
const START: [f64; 2] = [3.0, 0.0];

/// Times and directions of its passages through 1.
fn passes_one() -> [(f64, Direction); 3] {
    [
        (math::acos(0.6 / 2.6), Falling),
        (PI + math::acos(-1.4 / 1.8), Rising),
        (2.0 * PI + math::acos(0.6), Falling),
    ]
}

#[test]
fn a_level_is_passed_when_the_circles_say() {
    for (options, allowed) in methods() {
        let level = watch(Function::Level(0, 1.0), Both);
        let found = solve_with_events(&Floor, &level, 0.0, START, 20.0, &options).unwrap();
        assert_eq!(found.events.len(), 3);
        for (event, (t, direction)) in found.events.iter().zip(passes_one()) {
            assert!((event.t - t).abs() < allowed, "{} {t}", event.t);
            assert_eq!((event.number, event.direction), (0, direction));
            assert!((event.x[0] - 1.0).abs() < 1e-15, "{}", event.x);
            assert!((event.rate - event.x[1]).abs() < 1e-15);
            let side = if event.rate < 0.0 {
                Side::Below
            } else {
                Side::Above
            };
            assert_eq!(event.mode, Mode::Slip(side));
        }
        // Watching does not change the run.
        let alone = solve(&Floor, 0.0, START, 20.0, &options).unwrap();
        let events = found.events.clone();
        assert_eq!(found, Orbit { events, ..alone });
    }
}

#[test]
fn only_the_direction_asked_for_is_reported() {
    for direction in [Rising, Falling] {
        let level = watch(Function::Level(0, 1.0), direction);
        let options = Options::default();
        let found = solve_with_events(&Floor, &level, 0.0, START, 20.0, &options).unwrap();
        let asked = passes_one().iter().filter(|one| one.1 == direction).count();
        assert_eq!(found.events.len(), asked);
        assert!(
            found
                .events
                .iter()
                .all(|event| event.direction == direction)
        );
    }
}

#[test]
fn a_terminal_event_ends_the_run_there() {
    for (options, allowed) in methods() {
        let events = EventSet {
            functions: [Function::Wave(1.0), Function::Level(0, 1.0)],
            directions: [Both, Rising],
            terminal: Some(1),
        };
        let found = solve_with_events(&Floor, &events, 0.0, START, 20.0, &options).unwrap();
        // The sine vanishes where the first circle ends. Its zero at the start is not an event.
        let reported: Vec<_> = found.events.iter().map(|event| event.number).collect();
        assert_eq!(reported, [0, 1]);
        let last = found.events[1];
        assert!((last.t - passes_one()[1].0).abs() < allowed);
        let orbit = &found;
        assert_eq!(orbit.ending, Ending::Stopped);
        assert_eq!((orbit.t_end, orbit.x_end), (last.t, last.x));
        let phase = orbit.phases.last().unwrap();
        assert_eq!(
            (phase.t_end, phase.x_end, phase.mode),
            (last.t, last.x, last.mode)
        );
        assert_eq!((orbit.phases.len(), orbit.transitions.len()), (2, 1));
        assert_eq!(orbit.at(last.t), Ok(last.x));
    }
}

#[test]
fn many_zeros_in_one_step_are_reported_in_order() {
    let events = EventSet {
        functions: [Function::Wave(40.0), Function::Wave(41.0)],
        directions: [Both, Both],
        terminal: None,
    };
    for options in [
        Options::tol(1e-10),
        Options::tol(1e-10).method(Method::Taylor),
    ] {
        let found = solve_with_events(&Floor, &events, 0.0, START, 10.0, &options).unwrap();
        assert!(found.events.is_sorted_by_key(|event| event.t));
        let within = |step: &StepRecord<2>| {
            let is_in = |event: &&EventRecord<2>| (step.t_start..step.t_end).contains(&event.t);
            found.events.iter().filter(is_in).count()
        };
        let most = found.steps.iter().map(within).max().unwrap();
        assert!(most > 3, "{most}");
        let mut times = [Vec::new(), Vec::new()];
        for event in &found.events {
            times[event.number].push(event.t);
        }
        for (times, omega) in times.iter().zip([40.0, 41.0]) {
            assert_eq!(times.len(), (10.0 * omega / PI) as usize);
            for (k, t) in times.iter().enumerate() {
                let exact = (k + 1) as f64 * PI / omega;
                assert!((t - exact).abs() < 1e-14, "{t} {exact}");
            }
        }
    }
}

#[test]
fn pairs_of_zeros_are_seen_and_misses_are_not() {
    // The velocity has its minimum, -2.6, after a quarter of a turn.
    for (options, _) in &methods()[..2] {
        for gap in [1e-4, 1e-8, 1e-10] {
            let level = |by: f64| watch(Function::Level(1, -2.6 + by), Both);
            let hit = solve_with_events(&Floor, &level(gap), 0.0, START, 3.0, options).unwrap();
            let half = math::acos(1.0 - gap / 2.6);
            let times: Vec<_> = hit.events.iter().map(|event| event.t).collect();
            assert_eq!(times.len(), 2);
            for (t, exact) in times.iter().zip([0.5 * PI - half, 0.5 * PI + half]) {
                // Rounding of the level over the rate.
                assert!((t - exact).abs() < 1e-14 / half, "{t} {exact}");
            }
            let missed = solve_with_events(&Floor, &level(-gap), 0.0, START, 3.0, options).unwrap();
            assert_eq!(missed.events, []);
        }
    }
}

/// Affine functions are found on the solution itself, others by calls; both find the same.
#[test]
fn a_function_has_the_zeros_that_it_has_without_being_declared_as_affine() {
    let mut draw = SplitMix::new(1963);
    let mut count = 0;
    for round in 0..60 {
        let mut slope = |zero: bool| match zero {
            true => 0.0,
            false => draw.between(-1.0, 1.0),
        };
        let slopes = [
            slope(round % 3 > 0),
            slope(round % 4 == 1),
            slope(round % 4 == 2),
        ];
        let of = |one: f64, is_declared| {
            Function::Combination([0.1 * slopes[0], slopes[1], slopes[2], one], is_declared)
        };
        // Two with the same slopes.
        let ones = [draw.between(-1.5, 1.5), draw.between(-1.5, 1.5)];
        for (options, allowed) in &methods()[..2] {
            let found = [true, false].map(|is_declared| {
                let events = EventSet {
                    functions: ones.map(|one| of(one, is_declared)),
                    directions: [Both, Both],
                    terminal: None,
                };
                let found = solve_with_events(&Floor, &events, 0.0, START, 12.0, options).unwrap();
                found.events
            });
            let [declared, called] = &found;
            assert_eq!(declared.len(), called.len(), "{round}");
            for (one, other) in declared.iter().zip(called) {
                assert_eq!((one.number, one.mode), (other.number, other.mode));
                assert_eq!(one.direction, other.direction);
                assert!((one.rate - other.rate).abs() < 1e-12, "{round}");
                // Rounding of the function over the rate.
                assert!(
                    (one.t - other.t).abs() * one.rate.abs() < *allowed,
                    "{round}"
                );
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count}");
}

#[test]
fn a_block_that_sticks_passes_places_with_the_belt() {
    let belt = decaying_friction();
    for (options, allowed) in methods() {
        let places = EventSet {
            functions: [Function::Level(0, 0.3), Function::Level(0, 0.7)],
            directions: [Both, Both],
            terminal: None,
        };
        let found = solve_with_events(&belt, &places, 0.0, [0.0, 0.2], 4.9, &options).unwrap();
        let reported: Vec<_> = found.events.iter().map(|e| (e.number, e.mode)).collect();
        assert_eq!(reported, [(0, Mode::Stick), (1, Mode::Stick)]);
        for (event, t) in found.events.iter().zip([1.5, 3.5]) {
            assert!((event.t - t).abs() < allowed, "{}", event.t);
            assert_eq!(event.x[1], 0.2);
        }
    }
}

#[test]
fn a_zero_at_the_very_end_of_a_phase_is_reported_once_before_it() {
    for (options, _) in methods() {
        // The boundary function itself: zero half a turn apart, until the block stays at rest.
        let turns = watch(Function::Level(1, 0.0), Both);
        let found = solve_with_events(&Floor, &turns, 0.0, START, 20.0, &options).unwrap();
        let reported: Vec<_> = found.events.iter().map(|e| (e.t, e.direction)).collect();
        let ends: Vec<_> = found.transitions.iter().map(|at| at.t).collect();
        assert_eq!(ends.len(), 4);
        let ways = [Rising, Falling, Rising, Falling];
        assert_eq!(reported, ends.into_iter().zip(ways).collect::<Vec<_>>());
        for (event, phase) in found.events.iter().zip(&found.phases) {
            assert_eq!((event.mode, event.x), (phase.mode, phase.x_end));
        }
    }
}

#[test]
fn a_function_that_is_zero_during_stick_passes_at_its_ends() {
    let belt = decaying_friction();
    for (options, _) in methods() {
        let on_belt = watch(Function::Level(1, 0.2), Both);
        let found = solve_with_events(&belt, &on_belt, 0.0, [0.04, -0.01], 30.0, &options).unwrap();
        let reported: Vec<_> = found.events.iter().map(|event| event.direction).collect();
        assert!(reported.len() >= 6);
        assert!(
            reported
                .iter()
                .step_by(2)
                .all(|direction| *direction == Rising)
        );
        assert!(
            reported
                .iter()
                .skip(1)
                .step_by(2)
                .all(|direction| *direction == Falling)
        );
        for (event, at) in found.events.iter().zip(&found.transitions) {
            assert!((event.t - at.t).abs() < 1e-6, "{} {}", event.t, at.t);
        }
        // It leaves with zero rate, so that rounding hides it for a while; it returns with a
        // nonzero rate.
        for (event, at) in found.events.iter().zip(&found.transitions).step_by(2) {
            assert_eq!(event.t, at.t);
        }
    }
}

#[test]
fn no_zero_of_a_function_far_faster_than_the_steps_is_missed() {
    let events = EventSet {
        functions: [Function::Wave(600.0), Function::Fine(1000.0)],
        directions: [Both, Both],
        terminal: None,
    };
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-12).method(method);
        let found = solve_with_events(&Floor, &events, 0.0, START, 20.0, &options).unwrap();
        let count = |number| found.events.iter().filter(|at| at.number == number).count();
        assert_eq!(count(0), (600.0 * 20.0 / PI) as usize, "{method:?}");
        let fine = |k: u32| {
            let x = found.at(f64::from(k) * 5e-5).unwrap();
            math::sin(x[0] * 1000.0 + 0.1) > 0.0
        };
        let changes = (0..400_000).filter(|&k| fine(k) != fine(k + 1)).count();
        assert_eq!(count(1), changes, "{method:?}");
    }
}

#[test]
fn a_narrow_bump_behind_a_zero_is_seen() {
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-12).method(method);
        for fall in [0.21, 0.5, 0.93] {
            let bump = watch(Function::Bump(fall), Both);
            let found = solve_with_events(&Floor, &bump, 0.0, START, 2.0, &options).unwrap();
            let times: Vec<f64> = found.events.iter().map(|event| event.t).collect();
            assert_eq!(times.len(), 3, "{method:?}: {times:?}");
            assert!((times[0] - fall).abs() < 1e-12, "{method:?}: {times:?}");
            assert!(times[1..].iter().all(|t| (t - fall - 0.2).abs() < 2e-3));
        }
    }
}

#[test]
fn a_resonance_is_seen_however_narrow() {
    let mut draw = SplitMix::new(1967);
    for _ in 0..150 {
        let (centre, width) = (draw.between(0.6, 11.0), math::exp(draw.between(-8.0, -0.7)));
        let resonance = watch(Function::Resonance(centre, width), Both);
        let options = Options::tol(1e-12).method(Method::Taylor);
        let found = solve_with_events(&Floor, &resonance, 0.0, START, 12.0, &options).unwrap();
        let times: Vec<f64> = found.events.iter().map(|event| event.t).collect();
        assert_eq!(times.len(), 2, "{centre} {width}: {times:?}");
        for (t, exact) in times.iter().zip([centre - width, centre + width]) {
            assert!((t - exact).abs() < 1e-12, "{centre} {width}: {t}");
        }
    }
}

/// Over Taylor steps products have a series, over Runge-Kutta steps they have not.
#[test]
fn products_have_the_zeros_that_they_have_by_the_other_method() {
    let mut draw = SplitMix::new(1968);
    let mut count = 0;
    for _ in 0..40 {
        let level = draw.between(-1.6, 1.6);
        let product = EventSet {
            functions: [Function::Product(level), Function::Product(level + 0.3)],
            directions: [Both, Both],
            terminal: None,
        };
        let [taylor, other] = [Method::Taylor, Method::Dop853].map(|method| {
            let options = Options::tol(1e-13).method(method);
            solve_with_events(&Floor, &product, 0.0, START, 12.0, &options).unwrap()
        });
        assert_eq!(taylor.events.len(), other.events.len(), "{level}");
        for (one, other) in taylor.events.iter().zip(&other.events) {
            assert_eq!((one.number, one.direction), (other.number, other.direction));
            assert!((one.t - other.t).abs() * one.rate.abs() < 1e-11, "{level}");
            let level = level + 0.3 * one.number as f64;
            assert!((one.x[0] * one.x[1] - level).abs() < 1e-14, "{level}");
            assert!((one.rate - other.rate).abs() < 1e-9);
            count += 1;
        }
    }
    assert!(count > 100, "{count}");
}

#[test]
fn a_zero_at_the_end_of_the_run_is_reported() {
    let wave = watch(Function::Wave(PI), Both);
    let options = Options::default();
    let found = solve_with_events(&Floor, &wave, 0.0, START, 2.0, &options).unwrap();
    let reported: Vec<_> = found.events.iter().map(|event| event.t).collect();
    assert_eq!(reported.len(), 2);
    assert!((reported[0] - 1.0).abs() < 1e-15 && (reported[1] - 2.0).abs() < 1e-15);
}

#[test]
fn a_run_that_fails_keeps_the_events_before() {
    let belt = Block::on_belt(1.0);
    let place = watch(Function::Level(0, 0.7), Rising);
    let options = Options::default().escape(1.0);
    let failure = solve_with_events(&belt, &place, 0.0, [0.5, 0.9], 50.0, &options).unwrap_err();
    assert!(matches!(failure.error, Error::Escaped { .. }), "{failure}");
    let reported: Vec<_> = failure.partial.events.iter().map(|event| event.t).collect();
    assert_eq!(reported.len(), 1);
    assert!(reported[0] < failure.partial.t_end);
    let failure = solve_with_events(&belt, &place, 0.0, [0.5, 0.9], -1.0, &options).unwrap_err();
    assert!(matches!(failure.error, Error::Interval { .. }), "{failure}");
    assert_eq!(failure.partial.events, []);
}

/// Period of the cycle of [`decaying_friction`].
const PERIOD: f64 = 9.230_770_458_082_98;

#[test]
fn the_cycle_with_stick_returns_after_its_period_and_forgets_where_it_was() {
    let belt = decaying_friction();
    for (options, allowed) in methods() {
        let system = belt.any();
        for (direction, mode) in [(Rising, Mode::Stick), (Falling, Mode::Slip(Side::Below))] {
            let section = watch(Function::Level(0, 0.5), direction);
            let start = (0.0, [0.04, -0.01]);
            let mut map = PoincareMap::new(&system, &section, start, 20.0, &options).unwrap();
            let mut last = map.by_ref().nth(1).unwrap().unwrap();
            for number in 3..6 {
                let (next, derivative) = map.step_with_derivative().unwrap();
                assert_eq!((next.number, next.mode), (number, mode.into()));
                assert!(
                    (next.t - last.t - PERIOD).abs() < 10.0 * allowed,
                    "{}",
                    next.t - last.t
                );
                assert!((&next.x - &last.x).amax() < 10.0 * allowed);
                assert!(derivative.amax() < 1e-9, "{derivative}");
                assert_eq!(
                    (map.time(), map.state(), map.number()),
                    (next.t, &next.x, number)
                );
                last = next;
            }
        }
    }
}

/// The first return to a plane from a start, and its derivative.
fn first_return<S: Compiled<2>>(
    system: &S,
    section: &Section,
    start: State<2>,
    options: &Options,
) -> (Vector, Matrix) {
    let (any, section) = (system.dynamics(), section.clone());
    let mut map = PoincareMap::at_run_time(&*any, section, (0.0, start), 30.0, options).unwrap();
    let (first, derivative) = map.step_with_derivative().unwrap();
    (first.x, derivative)
}

#[test]
fn the_derivative_is_that_of_differences() {
    const CHANGE: f64 = 1e-5;
    // Across Σ twice, and across a plane that is not a level of either component.
    let belt = Block::on_belt(1.0);
    let normal = Vector::from(vec![1.0, 0.3]);
    let section = Section::Plane {
        point: vec![0.1, 0.0].into(),
        normal: normal.clone(),
        direction: Rising,
    };
    for options in [
        Options::tol(1e-14),
        Options::tol(1e-14).method(Method::Taylor),
    ] {
        let start = State::from([0.5, 1.5]);
        let (_, found) = first_return(&belt, &section, start, &options);
        for j in 0..2 {
            let moved = |by: f64| {
                let mut x = start;
                x[j] += by;
                first_return(&belt, &section, x, &options).0
            };
            let near = moved(CHANGE) - moved(-CHANGE);
            let far = moved(2.0 * CHANGE) - moved(-2.0 * CHANGE);
            let slope = (near * 8.0 - far) / (12.0 * CHANGE);
            let off = (found.column(j) - &slope).amax();
            assert!(off < 1e-7 * found.amax().max(1.0), "{found} {slope}");
        }
        // The start leads into the section.
        assert!((normal.transpose() * &found).amax() < 1e-13 * found.amax());
    }
}

#[test]
fn on_a_cycle_it_has_the_cycle_s_multiplier() {
    let belt = Block::on_belt(1.0);
    let options = Options::tol(1e-13);
    let cycle = periodic_orbit(&belt, [-0.27, -0.73], 7.7, &options).unwrap();
    let [_, other]: [_; 2] = multipliers(&cycle.monodromy).try_into().unwrap();
    let section = Section::Plane {
        point: cycle.x.clone(),
        normal: vec![1.0, 0.0].into(),
        direction: Both,
    };
    let system = belt.dynamics();
    let start = (0.0, &cycle.x);
    let mut map = PoincareMap::at_run_time(&*system, section, start, 20.0, &options).unwrap();
    // The block passes the position once in each direction.
    let (_, half) = map.step_with_derivative().unwrap();
    let (back, rest) = map.step_with_derivative().unwrap();
    assert!((back.x - cycle.x).amax() < 1e-10);
    assert!((back.t - cycle.period).abs() < 1e-10);
    let turn = rest * half;
    assert!((turn.trace() - other.re).abs() < 1e-9, "{turn} {other}");
    assert!(turn.determinant().abs() < 1e-12);
}

#[test]
fn an_exit_at_a_tangent_point_passes_a_section_that_is_the_boundary_with_no_derivative() {
    let mut derivatives = 0;
    for speed in [0.1, 0.15, 0.2, 0.25, 0.3, 0.35] {
        let belt = Block {
            belt_speed: speed,
            ..decaying_friction()
        };
        let section = watch(Function::Level(1, speed), Both);
        for (options, _) in methods() {
            let system = belt.any();
            let start = (0.0, [0.04, speed - 0.21]);
            let mut map = PoincareMap::new(&system, &section, start, 20.0, &options).unwrap();
            // It enters stick with a nonzero rate and leaves it with a rate of rounding size.
            let (entry, derivative) = map.step_with_derivative().unwrap();
            assert_eq!(entry.mode, Mode::Slip(Side::Below));
            assert!(derivative.amax() > 0.1);
            let exit = map.step_with_derivative();
            assert!(
                matches!(exit, Err(Error::TangentSingular { .. })),
                "{exit:?}"
            );
            // It is still a return, and the next derivative starts there.
            assert_eq!(map.number(), 2);
            let left = (map.time(), map.state().clone());
            let Ok((_, derivative)) = map.step_with_derivative() else {
                continue;
            };
            let mut again = PoincareMap::new(&system, &section, left, 20.0, &options).unwrap();
            let (_, anew) = again.step_with_derivative().unwrap();
            assert!((&derivative - &anew).amax() < 1e-8, "{derivative} {anew}");
            derivatives += 1;
        }
    }
    assert!(derivatives >= 6, "{derivatives}");
}

#[test]
fn a_strobe_is_a_section_of_time() {
    let system = DenHartog {
        frequency: 0.7,
        friction: 0.2,
    };
    let period = 2.0 * PI / 0.7;
    let options = Options::tol(1e-13);
    // A map ignores that an event is terminal.
    let strobe = EventSet {
        terminal: Some(0),
        ..watch(Function::Wave(0.7), Rising)
    };
    let any = system.any();
    let start = [1.0, 0.3];
    let mut map = PoincareMap::new(&any, &strobe, (0.0, start), 20.0, &options).unwrap();
    for k in 1..4 {
        let from = map.state().clone();
        let t0 = map.time();
        let (next, derivative) = map.step_with_derivative().unwrap();
        assert!((next.t - f64::from(k) * period).abs() < 1e-14 * next.t);
        let exact = monodromy(&system, t0, from, next.t, &options).unwrap();
        assert!((next.x - exact.summary.x).amax() < 1e-10);
        assert!((derivative - exact.matrix).amax() < 1e-9);
    }
}

#[test]
fn where_there_is_no_return_the_map_says_so_and_ends() {
    let level = watch(Function::Level(0, 1.0), Rising);
    let system = Floor.any();
    let options = Options::default();
    let mut map = PoincareMap::new(&system, &level, (0.0, START), 30.0, &options).unwrap();
    let first = map.next().unwrap().unwrap();
    assert_eq!(first.number, 1);
    let error = map.next().unwrap().unwrap_err();
    let Error::NotFound { t, span, .. } = error else {
        panic!("{error}");
    };
    assert_eq!((t, span), (first.t, 30.0));
    assert!(map.next().is_none());
    // Shorter than the return time.
    let mut map = PoincareMap::new(&system, &level, (0.0, START), 5.0, &options).unwrap();
    assert!(matches!(map.step(), Err(Error::NotFound { .. })));
    for longest in [0.0, f64::NAN, f64::INFINITY] {
        let refused = PoincareMap::new(&system, &level, (0.0, START), longest, &options);
        assert!(matches!(
            refused.err(),
            Some(Error::Option {
                name: "longest",
                ..
            })
        ));
    }
}
