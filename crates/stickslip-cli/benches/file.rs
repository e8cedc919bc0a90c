//! Time that a system from a file takes, over that of the same one compiled. The runs take turns,
//! so that whatever else the machine does meets both alike.

#[path = "../../stickslip-model/tests/suite/blocks.rs"]
mod blocks;

use std::hint::black_box;
use std::time::{Duration, Instant};

use blocks::Block;
use stickslip::{Filippov, Method, Options, State, run};
use stickslip_model::file::System;
use stickslip_model::file::SystemFile;
use stickslip_model::kernel::{follow, ignore};

/// Time that each orbit is followed for.
const SPAN: f64 = 100.0;

/// Runs of each kind for a ratio.
const TURNS: usize = 21;

fn methods() -> [(&'static str, Options); 2] {
    [
        ("taylor", Options::tol(1e-12).method(Method::Taylor)),
        ("order 8", Options::tol(1e-12).method(Method::Dop853)),
    ]
}

fn shipped(name: &str) -> System {
    let file = SystemFile::open(name).unwrap_or_else(|error| panic!("{error}"));
    file.with(&[]).unwrap_or_else(|error| panic!("{error}"))
}

fn from_file(system: &System, x: &[f64], options: &Options) -> f64 {
    follow(system.dynamics(), (0.0, x), SPAN, options, &[], &mut ignore)
        .map_or(f64::NAN, |ended| ended.x[0])
}

fn compiled<S: Filippov<N>, const N: usize>(system: &S, x: &[f64], options: &Options) -> f64 {
    let x = State::<N>::from_fn(|i, _| x[i]);
    run(system, 0.0, x, SPAN, options, &mut ()).map_or(f64::NAN, |summary| summary.x[0])
}

fn compare<S: Filippov<N>, const N: usize>(name: &str, x: &[f64], system: &S) {
    let file = shipped(name);
    for (method, options) in methods() {
        assert!((from_file(&file, x, &options) - compiled(system, x, &options)).abs() < 1e-9);
        let mut times = [const { Vec::new() }; 2];
        for _ in 0..TURNS {
            times[0].push(timed(|| compiled(system, black_box(x), &options)));
            times[1].push(timed(|| from_file(&file, black_box(x), &options)));
        }
        let [compiled, file] = times.map(middle);
        println!(
            "{name}, {method}: file over compiled {:.2}",
            file / compiled
        );
    }
}

/// Seconds of one run, from as many as fill some milliseconds.
fn timed(mut run: impl FnMut() -> f64) -> f64 {
    let begin = Instant::now();
    let mut count = 0;
    while begin.elapsed() < Duration::from_millis(20) {
        black_box(run());
        count += 1;
    }
    begin.elapsed().as_secs_f64() / f64::from(count)
}

fn middle(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    compare("leine", &[0.5, 0.1], &Block::LEINE);
    compare("basins", &[0.5, 0.1], &Block::BASINS);
    compare("den-hartog", &[0.5, 0.1], &Block::DEN_HARTOG);
}
