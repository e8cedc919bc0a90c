//! Cost of a step as the number of contacts grows: chains of one to eight blocks on a belt, joined
//! by springs, with friction that weakens with the slip speed. Every number is compared with that
//! of one block in the same run.

use std::hint::black_box;
use std::time::{Duration, Instant};

use stickslip::Switched;
use stickslip::{Contacts, Method, Options, Scalar, Several, Side, State, Summary, run};

const COUPLING: f64 = 0.5;
const WEAKENING: f64 = 3.0;

/// Blocks on a belt of this speed.
struct Chain<const M: usize> {
    belt_speed: f64,
}

/// States are positions, then velocities.
macro_rules! chain {
    ($($m:literal, $n:literal;)*) => {$(
        impl Contacts<$n, $m> for Chain<$m> {
            #[inline(always)]
            fn field<T: Scalar>(&self, sides: &[Side; $m], _t: T, x: &[T; $n]) -> [T; $n] {
                let mut rate = *x;
                for i in 0..$m {
                    let v = x[$m + i];
                    let slip_speed = (v - self.belt_speed) * sides[i].sign();
                    let friction = (slip_speed * WEAKENING + 1.0).recip() * sides[i].sign();
                    let mut force = -x[i] - friction;
                    if i > 0 {
                        force = force + (x[i - 1] - x[i]) * COUPLING;
                    }
                    if i + 1 < $m {
                        force = force + (x[i + 1] - x[i]) * COUPLING;
                    }
                    (rate[i], rate[$m + i]) = (v, force);
                }
                rate
            }
            #[inline(always)]
            fn boundaries<T: Scalar>(&self, _t: T, x: &[T; $n]) -> [T; $m] {
                let mut h = [x[0]; $m];
                for i in 0..$m {
                    h[i] = x[$m + i] - self.belt_speed;
                }
                h
            }
        }
    )*};
}

chain! {
    1, 2;
    2, 4;
    4, 8;
    8, 16;
}

/// Motion of the blocks.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// All slip, on a fast belt.
    Slip,
    /// All stick, on a slow one.
    Stick,
    /// Both by turns, with events.
    StickSlip,
}

/// One run of a chain.
fn integrate<const M: usize, const N: usize>(motion: Motion, method: Method) -> Summary<N>
where
    Several<Chain<M>>: Switched<N, M>,
{
    let (belt_speed, t_end) = match motion {
        Motion::Slip => (5.0, 4.0),
        Motion::Stick => (0.05, 4.0),
        Motion::StickSlip => (0.05, 100.0),
    };
    let mut options = Options::tol(1e-10).method(method);
    // Steps of one length for any number of blocks, where nothing else limits them.
    if !matches!(motion, Motion::StickSlip) {
        options.longest_step = 0.05;
        options.first_step = Some(0.05);
    }
    let start = State::from_fn(|i, _| match motion {
        _ if i < M => 0.05 * stickslip::math::sin(5.0 * (i + 1) as f64),
        Motion::Slip => 0.0,
        Motion::Stick | Motion::StickSlip => belt_speed,
    });
    let chain = Several(Chain::<M> { belt_speed });
    run(&chain, 0.0, black_box(start), t_end, &options, &mut ()).expect("runs")
}

/// The least time of some rounds.
fn least_time<R>(mut work: impl FnMut() -> R) -> Duration {
    const ROUNDS: u32 = 100;
    let timed = (0..ROUNDS).map(|_| {
        let begin = Instant::now();
        black_box(work());
        begin.elapsed()
    });
    timed.min().unwrap_or_default()
}

/// Prints a line for a number of blocks; returns seconds a step.
fn report<const M: usize, const N: usize>(
    motion: Motion,
    method: Method,
    of_one: Option<f64>,
) -> f64
where
    Several<Chain<M>>: Switched<N, M>,
{
    let counters = integrate::<M, N>(motion, method).counters;
    let time = least_time(|| integrate::<M, N>(motion, method)).as_secs_f64();
    let per_step = time / counters.steps as f64;
    println!(
        "chain: {motion:?}, {method:?}, {M} blocks: {} steps, {} events, {:.1} field calls a step, \
         {:.2} us a step, {:.0} ns a field call, {:.1} times one block's step",
        counters.steps,
        counters.events,
        counters.field_calls as f64 / counters.steps as f64,
        1e6 * per_step,
        1e9 * time / counters.field_calls as f64,
        per_step / of_one.unwrap_or(per_step),
    );
    per_step
}

fn main() {
    for method in [Method::Dop853, Method::Taylor] {
        for motion in [Motion::Slip, Motion::Stick, Motion::StickSlip] {
            let of_one = Some(report::<1, 2>(motion, method, None));
            report::<2, 4>(motion, method, of_one);
            report::<4, 8>(motion, method, of_one);
            report::<8, 16>(motion, method, of_one);
        }
    }
}
