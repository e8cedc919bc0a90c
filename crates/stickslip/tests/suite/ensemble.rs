//! Many orbits computed together have the same bits as single ones.

use std::ops::ControlFlow;

use stickslip::{
    Counters, Failure, Filippov, Method, Observer, Options, Scalar, Side, Start, State, StepRecord,
    Summary, Transition, ensemble, run,
};

use crate::any_system::Oscillator;
use crate::blocks::{Block, Bracket};

const T_END: f64 = 10.0;

/// Both starts and parameters vary.
fn start(k: usize) -> Start<Oscillator, 2> {
    let part = k as f64 / 6000.0;
    let system = Oscillator::Belt(CompiledBlock(Block::on_belt(0.2 + 0.4 * part)));
    // One of them cannot start.
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

/// An error as its message, since an error with a NaN is not equal to itself.
type Outcome = (usize, usize, Result<(u64, [u64; 2], Counters), String>);

fn bits(
    k: usize,
    count: &RunRecorder,
    outcome: Result<Summary<2>, Failure<Summary<2>>>,
) -> Outcome {
    let end = |end: Summary<2>| {
        (
            end.t.to_bits(),
            [0, 1].map(|i| end.x[i].to_bits()),
            end.counters,
        )
    };
    let ending = outcome.map(end).map_err(|error| error.to_string());
    (k, count.transitions, ending)
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
            |_| RunRecorder::ignoring_steps(),
            |k, count, outcome| {
                all.push(bits(k, &count, outcome));
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
                let (one, mut count) = (start(k), RunRecorder::ignoring_steps());
                let outcome = run(&one.system, one.t, one.x, T_END, &options, &mut count);
                bits(k, &count, outcome)
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
        // More threads than there is work for.
        assert!(
            alone[..300] == together(8, &options, 300),
            "{method:?}, eight threads"
        );
    }
}

#[test]
fn it_ends_when_asked_and_asks_for_two_waves_at_most() {
    let mut reported = 0;
    let asked = std::cell::Cell::new(0);
    let endless = (0..).inspect(|k| asked.set(*k + 1)).map(start);
    ensemble(
        endless,
        1.0,
        &Options::tol(1e-6),
        |_| RunRecorder::ignoring_steps(),
        |k, _, _| {
            reported += 1;
            if k == 5000 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    );
    assert_eq!((reported, asked.get()), (5001, 2 * 4096));
}

/// Records the bits of every step and transition; stops the run at transition number `last`.
#[derive(Clone, Default, PartialEq, Debug)]
struct RunRecorder {
    bits: Vec<u64>,
    transitions: usize,
    last: usize,
    ignores_steps: bool,
}

impl RunRecorder {
    fn ignoring_steps() -> Self {
        RunRecorder {
            ignores_steps: true,
            ..RunRecorder::default()
        }
    }
}

impl<const N: usize> Observer<N> for RunRecorder {
    fn watches_steps(&self) -> bool {
        !self.ignores_steps
    }
    fn step(&mut self, step: &StepRecord<N>) -> ControlFlow<()> {
        let middle = step.dense.at(0.5);
        let numbers = [step.t_end].into_iter();
        let numbers = numbers.chain(step.x_end.iter().chain(middle.iter()).copied());
        self.bits.extend(numbers.map(f64::to_bits));
        ControlFlow::Continue(())
    }
    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        self.bits.push(at.t.to_bits());
        self.bits.push(at.residual.to_bits());
        self.transitions += 1;
        if self.transitions == self.last {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Every orbit has the same steps, transitions and end as alone, watched or not. Every seventh is
/// stopped early.
fn assert_as_alone<S: Filippov<N> + PartialEq + Send + Sync, const N: usize>(
    start: &dyn Fn(usize) -> Start<S, N>,
    number: usize,
    t_end: f64,
    options: &Options,
) {
    for ignores_steps in [false, true] {
        assert_as_alone_if(ignores_steps, start, number, t_end, options);
    }
}

fn assert_as_alone_if<S: Filippov<N> + PartialEq + Send + Sync, const N: usize>(
    ignores_steps: bool,
    start: &dyn Fn(usize) -> Start<S, N>,
    number: usize,
    t_end: f64,
    options: &Options,
) {
    let observer = |k: usize| RunRecorder {
        last: if k % 7 == 3 { 2 } else { 0 },
        ignores_steps,
        ..RunRecorder::default()
    };
    let outcome = |outcome: Result<Summary<N>, Failure<Summary<N>>>| {
        outcome
            .map(|end| {
                let x: Vec<u64> = end.x.iter().map(|x| x.to_bits()).collect();
                (end.ending, end.t.to_bits(), x, end.counters)
            })
            .map_err(|failure| (failure.to_string(), failure.partial.t.to_bits()))
    };
    let (mut reported, mut events) = (0, 0);
    ensemble(
        (0..number).map(start),
        t_end,
        options,
        observer,
        |k, found, end| {
            let (one, mut alone) = (start(k), observer(k));
            let end_alone = run(&one.system, one.t, one.x, t_end, options, &mut alone);
            assert_eq!(outcome(end), outcome(end_alone), "orbit {k}");
            assert!(found == alone, "orbit {k}: steps or transitions");
            reported += 1;
            events += found.transitions;
            ControlFlow::Continue(())
        },
    );
    assert_eq!(reported, number);
    assert!(events > number, "{events} events");
}

#[test]
fn orbits_side_by_side_branch_stop_and_fail_each_on_its_own() {
    let options = Options::tol(1e-9).method(Method::Taylor);
    // A clipped normal force, stick and slip, parameters that change every thirty orbits, and one
    // orbit that escapes.
    let bracket = |k: usize| {
        let part = k as f64 / 300.0;
        let unloading = 0.3 * (k / 30) as f64;
        let system = Bracket { unloading };
        let x = State::from([0.1, 0.1 + part, 0.1, if k == 77 { 1e9 } else { 0.1 }]);
        Start { system, t: 0.0, x }
    };
    assert_as_alone(&bracket, 300, 20.0, &options);
    assert_as_alone(&interpreted(bracket), 300, 20.0, &options);
    assert_same_orbits(&bracket, 300, 20.0, &options);
}

/// Oscillators with a kink in the spring. Their fields end at an edge in several ways, or branch by
/// comparison or by a value that they read. One has a curved boundary that ends at the edge.
#[derive(Clone, Copy, PartialEq)]
pub struct Edge {
    edge: f64,
    kind: usize,
}

impl Filippov<2> for Edge {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let room = -x[0] + self.edge;
        let push = match self.kind {
            0 => room.sqrt(),
            1 => room.ln() * 0.1,
            2 => T::constant(0.01) / room,
            3 => (x[0] * x[0] + x[1] * x[1]).sqrt(),
            4 => (x[0] * 1e3 * self.edge).exp() * 1e-30,
            6 => (x[1] * 30.0).min(x[0] * x[0]).abs(),
            7 => room * 0.1,
            _ if x[1].value() < 0.3 => T::constant(0.0),
            _ => T::constant(0.1),
        };
        [x[1], -x[0] * side.sign() * 0.5 - x[0] + push * 0.1]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        if self.kind < 7 {
            return x[0] - 0.1;
        }
        x[0] * x[0] + x[1] - 0.2 + (-x[0] + self.edge).sqrt() * 1e-3
    }
}

#[test]
fn fields_that_end_or_read_values_have_the_bits_of_one_alone_too() {
    let options = Options::tol(1e-7).method(Method::Taylor);
    let start = |k: usize| Start {
        system: Oscillator::Edge(Edge {
            edge: 0.4 + 0.05 * (k / 80 * 2 + k % 2) as f64,
            kind: k / 10 % 8,
        }),
        t: 0.0,
        x: State::from([0.2, 0.004 * k as f64]),
    };
    assert_as_alone(&start, 300, 15.0, &options);
    assert_as_alone(&interpreted(start), 300, 15.0, &options);
    assert_same_orbits(&start, 300, 15.0, &options);
}

/// Oscillates through a boundary that bends too sharply for a series from far away. The second
/// state stays at rest.
#[derive(Clone, Copy, PartialEq)]
pub struct Steep {
    steepness: f64,
    is_bell: bool,
}

impl Filippov<2> for Steep {
    fn field<T: Scalar>(&self, _side: Side, t: T, _x: &[T; 2]) -> [T; 2] {
        [t.cos(), T::zero()]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        let far = x[0] * self.steepness;
        if self.is_bell {
            (-(far * far)).exp() - 0.5
        } else {
            far.tanh() + 0.5
        }
    }
}

#[test]
fn steps_whose_ends_show_what_series_do_not_have_the_bits_of_one_alone_too() {
    let options = Options::tol(1e-7).method(Method::Taylor);
    let start = |k: usize| Start {
        system: Oscillator::Steep(Steep {
            steepness: [20.0, 200.0, 2000.0][k / 40 % 3],
            is_bell: k >= 120,
        }),
        t: 0.0,
        x: State::from([0.6 - 0.01 * (k % 120) as f64, 0.0]),
    };
    assert_as_alone(&start, 240, 15.0, &options);
    assert_as_alone(&interpreted(start), 240, 15.0, &options);
    assert_same_orbits(&start, 240, 15.0, &options);
}

/// A block by its compiled functions, not by formulas.
#[derive(Clone, Copy, PartialEq)]
pub struct CompiledBlock(pub Block);

impl Filippov<2> for CompiledBlock {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        self.0.field(side, t, x)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        self.0.boundary(t, x)
    }
}

/// A system that declares its functions to be interpreted.
#[derive(Clone, Copy, PartialEq)]
struct Interpreted<S>(S);

fn interpreted<S: Copy, const N: usize>(
    start: impl Fn(usize) -> Start<S, N>,
) -> impl Fn(usize) -> Start<Interpreted<S>, N> {
    move |k| {
        let Start { system, t, x } = start(k);
        let system = Interpreted(system);
        Start { system, t, x }
    }
}

impl<S: Filippov<N>, const N: usize> Filippov<N> for Interpreted<S> {
    const INTERPRETED: bool = true;

    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; N]) -> [T; N] {
        self.0.field(side, t, x)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.0.boundary(t, x)
    }
    fn contact<T: Scalar>(&self, t: T, x: &[T; N]) -> Option<T> {
        self.0.contact(t, x)
    }
}

/// Computes the orbit of a start as it is and with functions declared to be interpreted. Both must
/// have the same steps and transitions.
fn assert_same_orbits<S: Filippov<N> + Copy, const N: usize>(
    start: &dyn Fn(usize) -> Start<S, N>,
    number: usize,
    t_end: f64,
    options: &Options,
) {
    let mut transitions = 0;
    for k in 0..number {
        let Start { system, t, x } = start(k);
        let (mut of_calls, mut repeated) = (RunRecorder::default(), RunRecorder::default());
        let wanted = run(&system, t, x, t_end, options, &mut of_calls);
        let found = run(&Interpreted(system), t, x, t_end, options, &mut repeated);
        assert_eq!(of_calls.transitions, repeated.transitions, "orbit {k}");
        transitions += repeated.transitions;
        match (wanted, found) {
            (Ok(wanted), Ok(found)) => {
                assert_eq!(wanted.counters.steps, found.counters.steps, "orbit {k}");
                let apart = (wanted.x - found.x).amax() / wanted.x.amax().max(1.0);
                assert!(apart < 1e-13, "orbit {k}: {apart:e} apart");
            }
            (wanted, found) => {
                let message =
                    |failed: Result<_, Failure<_>>| failed.map(drop).unwrap_err().to_string();
                assert_eq!(message(wanted), message(found), "orbit {k}");
            }
        }
    }
    assert!(transitions > number, "{transitions} transitions");
}
