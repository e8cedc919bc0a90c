//! Starts of a basin per second on one thread, and how much of their time is not evaluation of the
//! field: the same starts with a field that is evaluated twice take longer by what it takes once.

use std::hint::black_box;
use std::time::Instant;

use numerics::SplitMix;
use stickslip::analysis::{RecurrenceSettings, basin};
use stickslip::{Filippov, Method, Options, Scalar, Side, State};

const STARTS: usize = 3600;
const ROUNDS: usize = 9;

/// `x'' = -x - 0.1 x' - F`, a block on a belt, the friction decaying with slip speed: the example
/// of bSTAB (Stender & Hoffmann, *Nonlinear Dyn.* 107 (2022) 1451), its field evaluated so many
/// `TIMES`.
struct Block<const TIMES: usize>;

const SPEED: f64 = 1.5;

impl<const TIMES: usize> Filippov<2> for Block<TIMES> {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        // That of the other side: the same work, which the compiler can not take for the same
        // value.
        for _ in 1..TIMES {
            black_box(field(side.opposite(), x));
        }
        field(side, x)
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - SPEED
    }
}

#[inline(always)]
fn field<T: Scalar>(side: Side, x: &[T; 2]) -> [T; 2] {
    let slip = (x[1] - SPEED) * side.sign();
    let friction = ((slip * -2.0).exp() * 0.5 + 0.5) * side.sign();
    [x[1], -x[0] - x[1] * 0.1 - friction]
}

/// Seconds for each start.
fn time<const TIMES: usize>(options: &Options) -> f64 {
    let mut random = SplitMix::new(16);
    let starts: Vec<State<2>> = (0..STARTS)
        .map(|_| [random.between(-2.0, 2.0), random.between(0.0, 2.0)].into())
        .collect();
    let settings = RecurrenceSettings::within(2000.0);
    let begin = Instant::now();
    let found =
        basin(&Block::<TIMES>, starts, &settings, options).expect("starts that are allowed");
    let elapsed = begin.elapsed().as_secs_f64();
    assert_eq!(found.attractors.len(), 2, "the fixed point and the cycle");
    elapsed / STARTS as f64
}

fn least(times: impl Iterator<Item = f64>) -> f64 {
    times.fold(f64::INFINITY, f64::min)
}

fn main() {
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    for (name, method) in [("Taylor", Method::Taylor), ("Dop853", Method::Dop853)] {
        let options = Options::tol(1e-8).method(method);
        // In turns, so that whatever else the machine does meets both alike.
        let rounds: Vec<[f64; 2]> = one.install(|| {
            (0..ROUNDS)
                .map(|_| [time::<1>(&options), time::<2>(&options)])
                .collect()
        });
        let [once, twice] = [0, 1].map(|k| least(rounds.iter().map(|round| round[k])));
        println!(
            "basin of {STARTS} starts, {name}: {:.0} a second, {:.0} % of the time outside the \
                field",
            once.recip(),
            100.0 * (1.0 - (twice - once) / once)
        );
    }
}
