//! Eight blocks on a belt, joined by springs (Burridge & Knopoff, *Bull. Seismol. Soc. Am.* 57
//! (1967) 341): a block that slips loads its neighbours, which may follow.

use std::time::Instant;

use stickslip::{Contacts, Error, Method, Mode, Options, Scalar, Several, Side, State, solve};

/// Number of blocks, and of states: positions, then velocities.
const M: usize = 8;
const N: usize = 2 * M;

const BELT_SPEED: f64 = 0.05;
/// Springs between neighbours, and from each block to the support.
const COUPLING: f64 = 0.5;
const LEAF: f64 = 1.0;
/// Static friction, and the rate at which friction weakens with the slip speed.
const FRICTION: f64 = 1.0;
const WEAKENING: f64 = 3.0;

struct Chain;

impl Contacts<N, M> for Chain {
    #[inline(always)]
    fn field<T: Scalar>(&self, sides: &[Side; M], _t: T, x: &[T; N]) -> [T; N] {
        let mut rate = *x;
        for i in 0..M {
            let v = x[M + i];
            let slip_speed = (v - BELT_SPEED) * sides[i].sign();
            let friction = (slip_speed * WEAKENING + 1.0).recip() * FRICTION;
            let mut force = -x[i] * LEAF - friction * sides[i].sign();
            if i > 0 {
                force = force + (x[i - 1] - x[i]) * COUPLING;
            }
            if i + 1 < M {
                force = force + (x[i + 1] - x[i]) * COUPLING;
            }
            (rate[i], rate[M + i]) = (v, force);
        }
        rate
    }
    #[inline(always)]
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; N]) -> [T; M] {
        let mut h = [x[0]; M];
        for i in 0..M {
            h[i] = x[M + i] - BELT_SPEED;
        }
        h
    }
}

/// One character per contact: `=` holds, `<` slips back, `>` slips ahead of the belt.
fn picture(modes: &[Mode; M]) -> String {
    let character = |mode: &Mode| match mode {
        Mode::Stick => '=',
        Mode::Slip(Side::Below) => '<',
        Mode::Slip(Side::Above) => '>',
    };
    modes.iter().map(character).collect()
}

fn main() -> Result<(), Error> {
    // All blocks stick, each slightly offset from its neighbours.
    let start = State::from_fn(|i, _| match i {
        0..M => 0.05 * stickslip::math::sin(5.0 * (i + 1) as f64),
        _ => BELT_SPEED,
    });
    for method in [Method::Dop853, Method::Taylor] {
        let begin = Instant::now();
        let options = Options::default().method(method);
        let orbit = solve(&Several(Chain), 0.0, start, 100.0, &options)?;
        let time = begin.elapsed();
        // Avalanches: the blocks that have slipped between two times at which all hold.
        let (mut slipped, mut sizes) = ([false; M], Vec::new());
        for at in &orbit.transitions {
            if method == Method::Dop853 {
                let slipping = at.to.iter().filter(|&&mode| mode != Mode::Stick).count();
                let (t, kind, contact) = (at.t, at.kind, at.contact);
                println!(
                    "t = {t:12.8}  block {contact}  {}  {slipping} slip  {kind:?}",
                    picture(&at.to)
                );
            }
            for (slipped, mode) in slipped.iter_mut().zip(at.to) {
                *slipped |= mode != Mode::Stick;
            }
            if at.to == [Mode::Stick; M] {
                sizes.push(slipped.iter().filter(|&&slipped| slipped).count());
                slipped = [false; M];
            }
        }
        let steps = orbit.counters.steps;
        println!(
            "{method:?}: {} events, avalanches of {sizes:?} blocks; {steps} steps, {:.1?} a step",
            orbit.transitions.len(),
            time / steps.max(1) as u32
        );
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
