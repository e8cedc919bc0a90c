//! A step far from all events computes its dense output on demand. The orbit and the solution
//! inside each step do not depend on who asks.

use std::ops::ControlFlow;

use stickslip::{Integration, Observer, Progress, StepRecord, Summary};

use super::tol;
use crate::any_system::{run, solve};
use crate::blocks::Block;
use crate::compiled::Compiled;

/// The numbered steps for which `asks` requests the dense output, and the end.
fn follow<S: Compiled<2>>(
    system: &S,
    start: [f64; 2],
    t_end: f64,
    tolerance: f64,
    asks: impl Fn(usize) -> bool,
) -> (Vec<(usize, StepRecord<2>)>, Summary<2>) {
    let (system, mut asked, mut number) = (system.any(), Vec::new(), 0);
    let mut integration =
        Integration::new(&system, 0.0, start, t_end, &tol(tolerance)).expect("starts");
    loop {
        match integration.step().expect("runs") {
            Progress::Step => {
                if asks(number) {
                    asked.push((number, integration.last_step()));
                }
                number += 1;
            }
            Progress::End(summary) => return (asked, summary),
            Progress::PhaseEnd(_) | Progress::Transition(_) => {}
        }
    }
}

fn assert_same_for_all<S: Compiled<2>>(system: &S, start: [f64; 2], t_end: f64, tolerance: f64) {
    let orbit = solve(system, 0.0, start, t_end, &tol(tolerance)).expect("runs");
    for every in [1, 2, 3, 7] {
        let (asked, end) = follow(system, start, t_end, tolerance, |number| {
            number % every == 0
        });
        assert_eq!(asked.len(), orbit.steps.len().div_ceil(every));
        assert_eq!((end.t, end.x), (orbit.t_end, orbit.x_end));
        for (number, step) in asked {
            assert_eq!(step, orbit.steps[number], "step {number}, every {every}");
        }
    }
    let (_, end) = follow(system, start, t_end, tolerance, |_| false);
    let (calls, all) = (end.counters.field_calls, orbit.counters.field_calls);
    assert_eq!((end.t, end.x), (orbit.t_end, orbit.x_end));
    assert!(calls < all, "{calls} calls, {all} for all");
    let unwatched = run(system, 0.0, start, t_end, &tol(tolerance), &mut ()).expect("runs");
    assert_eq!(unwatched, end);
    let mut unwatched = NeverWatches;
    let blind = run(system, 0.0, start, t_end, &tol(tolerance), &mut unwatched).expect("runs");
    assert_eq!(blind, end);
}

/// Declares that it does not watch steps, and so receives none.
struct NeverWatches;

impl Observer<2> for NeverWatches {
    fn step(&mut self, _: &StepRecord<2>) -> ControlFlow<()> {
        panic!("it did not ask for steps");
    }
    fn watches_steps(&self) -> bool {
        false
    }
}

#[test]
fn whoever_asks_the_orbit_and_its_steps_are_the_same() {
    let belt = Block::on_belt(0.4);
    for tolerance in [1e-4, 1e-8, 1e-12] {
        assert_same_for_all(&belt, [0.5, 1.5], 30.0, tolerance);
        assert_same_for_all(&Block::shaken(), [0.0, 0.0], 20.0, tolerance);
    }
}

/// Three calls fewer for every step far from all events, of a step's fifteen, and for a few
/// rejected steps.
#[test]
fn whoever_does_not_ask_saves_calls_of_the_field() {
    let belt = Block::on_belt(0.4);
    let start = [0.5, 1.5];
    let calls = |asks: bool| {
        let (_, end) = follow(&belt, start, 30.0, 1e-12, |_| asks);
        end.counters.field_calls as f64
    };
    let saved = 1.0 - calls(false) / calls(true);
    assert!((0.1..0.2).contains(&saved), "{saved} saved");
    // The cost of all dense outputs does not depend on who asks.
    let all = solve(&belt, 0.0, start, 30.0, &tol(1e-12)).expect("runs");
    assert_eq!(calls(true), all.counters.field_calls as f64);
}
