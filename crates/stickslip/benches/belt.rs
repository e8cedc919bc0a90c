//! Speed of the solver on a block on a belt beside the floor under it: as many calls of the same
//! field, each fed by the one before, as the stages of a Runge–Kutta step are. The ratio of the two
//! is what the driver, the step-size control, the dense output and the search for events cost. Both
//! are measured in the same run, and the ratio at the end in alternation, so that a machine whose
//! speed drifts does not matter.

#[path = "../examples/common/belt.rs"]
mod belt;

use std::hint::black_box;
use std::time::{Duration, Instant};

use belt::Belt;
use stickslip::{Filippov, Method, Options, Side, State, run, solve};

const T_END: f64 = 30.0;

fn start() -> State<2> {
    State::from([0.5, 1.5])
}

/// Integrates once and returns the number of field calls (0 would mean a failure, which the callers
/// refuse).
fn integrate(model: &Belt) -> u64 {
    run(model, 0.0, start(), T_END, &Options::tol(1e-12), &mut ())
        .map_or(0, |summary| summary.counters.field_calls)
}

/// Events of the same run to thirty digits.
fn reference() -> Vec<f64> {
    let table = include_str!("../../../data/references/belt_sensitive.csv");
    table
        .lines()
        .filter_map(|line| line.split(',').nth(3)?.parse().ok())
        .collect()
}

/// Time and largest error of the event times at each tolerance, by slopes and by series.
fn report_methods(model: &Belt) {
    const ROUNDS: u32 = 200;
    let exact = reference();
    for method in [Method::Dop853, Method::Taylor] {
        for exponent in [9, 11, 13, 14, 15] {
            let options = Options::tol(stickslip::math::powi(0.1, exponent)).method(method);
            let orbit = solve(model, 0.0, start(), T_END, &options).expect("runs");
            assert_eq!(orbit.transitions.len(), exact.len());
            let errors = orbit.transitions.iter().zip(&exact);
            let error = errors.fold(0.0, |worst, (e, t)| f64::max(worst, (e.t - t).abs()));
            let mut best = Duration::MAX;
            for _ in 0..ROUNDS {
                let begin = Instant::now();
                black_box(run(
                    black_box(model),
                    0.0,
                    start(),
                    T_END,
                    &options,
                    &mut (),
                ))
                .expect("runs");
                best = best.min(begin.elapsed());
            }
            println!("belt: {method:?} at 1e-{exponent}: {best:.1?}, events exact to {error:.1e}");
        }
    }
}

/// Calls the field so many times in a dependent chain.
fn chain(model: &Belt, calls: u64) -> State<2> {
    let base = State::from([0.5, 0.2]);
    let mut x = start();
    for _ in 0..calls {
        x = base + State::from(model.field(Side::Below, 0.0, x.as_ref())) * 1e-3;
    }
    x
}

fn main() {
    let model = black_box(Belt { speed: 0.4 });
    let calls = integrate(&model);
    assert!(calls > 0, "the run failed");
    report_ratio(&model, calls);
    report_methods(&model);
}

/// Median over alternating measurements of the two.
fn report_ratio(model: &Belt, calls: u64) {
    const ROUNDS: usize = 101;
    const EACH: u32 = 20;
    let time = |work: &mut dyn FnMut()| -> Duration {
        let begin = Instant::now();
        for _ in 0..EACH {
            work();
        }
        begin.elapsed() / EACH
    };
    let mut rounds: Vec<(f64, Duration, Duration)> = (0..ROUNDS)
        .map(|_| {
            let whole = time(&mut || {
                black_box(integrate(black_box(model)));
            });
            let floor = time(&mut || {
                black_box(chain(black_box(model), calls));
            });
            (whole.as_secs_f64() / floor.as_secs_f64(), whole, floor)
        })
        .collect();
    rounds.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (ratio, whole, floor) = rounds[ROUNDS / 2];
    println!(
        "belt: {whole:.1?} for {calls} field calls, floor {floor:.1?}: {ratio:.2} times the floor \
         (middle of {ROUNDS} alternating rounds; from {:.2} to {:.2})",
        rounds[0].0,
        rounds[ROUNDS - 1].0
    );
}
