//! Many orbits at once have the bits of one at a time.

use std::ops::ControlFlow;

use stickslip::models::BeltOscillator;
use stickslip::{
    Counters, Error, Method, Observer, Options, Start, State, Summary, Transition, ensemble, run,
};

const T_END: f64 = 10.0;

/// Starts and parameters both change.
fn start(k: usize) -> Start<BeltOscillator, 2> {
    let part = k as f64 / 6000.0;
    let system = BeltOscillator {
        belt_speed: 0.2 + 0.4 * part,
        ..BeltOscillator::default()
    };
    // One that cannot begin among the others.
    let x = if k == 4321 {
        f64::NAN
    } else {
        1.7 * part - 0.8
    };
    Start {
        system,
        t: 0.0,
        x: State::from([x, 1.0 - part]),
    }
}

/// Counts transitions.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
struct Count(usize);
impl Observer<2> for Count {
    fn transition(&mut self, _: &Transition<2>) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

/// An error as its message: one with a NaN in it equals nothing.
type Outcome = (usize, usize, Result<(u64, [u64; 2], Counters), String>);

fn bits(k: usize, count: Count, outcome: Result<Summary<2>, Error>) -> Outcome {
    let end = |end: Summary<2>| {
        (
            end.t.to_bits(),
            [0, 1].map(|i| end.x[i].to_bits()),
            end.counters,
        )
    };
    let ending = outcome.map(end).map_err(|error| error.to_string());
    (k, count.0, ending)
}

fn together(threads: usize, options: &Options, number: usize) -> Vec<Outcome> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    let mut all = Vec::new();
    pool.install(|| {
        ensemble(
            (0..number).map(start),
            T_END,
            options,
            |_| Count::default(),
            |k, count, outcome| {
                all.push(bits(k, count, outcome));
                ControlFlow::Continue(())
            },
        );
    });
    all
}

#[test]
fn the_bits_are_those_of_one_at_a_time_in_order() {
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-9).method(method);
        // More than one wave.
        let number = 6000;
        let alone: Vec<Outcome> = (0..number)
            .map(|k| {
                let (one, mut count) = (start(k), Count::default());
                let outcome = run(&one.system, one.t, one.x, T_END, &options, &mut count);
                bits(k, count, outcome)
            })
            .collect();
        assert!(alone.iter().filter(|one| one.2.is_err()).count() == 1);
        assert!(
            alone == together(1, &options, number),
            "{method:?}, one thread"
        );
        assert!(
            alone == together(2, &options, number),
            "{method:?}, two threads"
        );
    }
}

#[test]
fn it_ends_when_told_and_asks_for_two_waves_at_most() {
    let mut told = 0;
    let asked = std::cell::Cell::new(0);
    let endless = (0..).inspect(|k| asked.set(*k + 1)).map(start);
    ensemble(
        endless,
        1.0,
        &Options::tol(1e-6),
        |_| (),
        |k, (), _| {
            told += 1;
            if k == 5000 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    );
    assert_eq!((told, asked.get()), (5001, 2 * 4096));
}
