//! Time per orbit of an ensemble on one thread and on two, against a loop over single runs;
//! measured in alternation.

#[path = "../examples/common/belt.rs"]
mod belt;

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

use belt::Belt;
use stickslip::{Method, Options, Start, State, ensemble, run};

const ORBITS: usize = 100_000;
const ROUNDS: usize = 3;
const T_END: f64 = 30.0;

fn main() {
    let belt = Belt { speed: 0.4 };
    let options = Options::tol(1e-12).method(Method::Taylor);
    let x = |k: usize| State::from([2.0 * k as f64 / ORBITS as f64 - 1.0, 1.0]);
    let together = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let starts = (0..ORBITS).map(|k| Start {
            system: &belt,
            t: 0.0,
            x: x(k),
        });
        pool.expect("threads").install(|| {
            ensemble(
                starts,
                T_END,
                &options,
                |_| (),
                |_, (), outcome| {
                    black_box(outcome.is_ok());
                    ControlFlow::Continue(())
                },
            );
        });
    };
    let time = |work: &dyn Fn()| {
        let begin = Instant::now();
        work();
        begin.elapsed().as_secs_f64() / ORBITS as f64
    };
    let mut rounds: Vec<[f64; 3]> = (0..ROUNDS)
        .map(|_| {
            let alone = time(&|| {
                for k in 0..ORBITS {
                    black_box(run(&belt, 0.0, x(k), T_END, &options, &mut ()).is_ok());
                }
            });
            [alone, time(&|| together(1)), time(&|| together(2))]
        })
        .collect();
    rounds.sort_by(|one, other| (one[1] / one[2]).total_cmp(&(other[1] / other[2])));
    let [alone, one, two] = rounds[ROUNDS / 2].map(|seconds| 1e6 * seconds);
    println!(
        "ensemble of {ORBITS}: {alone:.1} µs an orbit alone, {one:.1} µs together on one thread \
            ({:.2} times), {two:.1} µs on two ({:.2} times as fast)",
        one / alone,
        one / two
    );
}
