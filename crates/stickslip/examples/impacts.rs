//! Jumps of the state: a driven block with dry friction that strikes a wall, its events, and the
//! multipliers of its periodic orbit.

use std::f64::consts::TAU;

use stickslip::analysis::{PeriodicOrbit, multipliers};
use stickslip::dynamics::{AsDynamics, Jumps, Moment, RecordedOrbit, Sampling, WithJumps};
use stickslip::{Direction, Error, Filippov, Options, Scalar, Side, TransitionKind};

/// A block on the floor, held by a spring and driven with period 2π.
struct Block;

impl Filippov<2> for Block {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let friction = T::constant(0.1 * side.sign());
        [x[1], -x[0] * 4.0 - friction + t.cos() * 3.0]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1]
    }
    fn period<T: Scalar>(&self, _x: &[T; 2]) -> Option<T> {
        Some(T::constant(TAU))
    }
}

/// A wall at 1/2, from which the block comes back with 0.7 of its speed.
struct Wall;

impl Jumps<2> for Wall {
    fn count(&self) -> usize {
        1
    }
    fn direction(&self, _jump: usize) -> Direction {
        Direction::Falling
    }
    fn when<T: Scalar>(&self, _jump: usize, _t: T, x: &[T; 2]) -> T {
        -x[0] + 0.5
    }
    fn set<T: Scalar>(&self, _jump: usize, _t: T, x: &[T; 2]) -> [T; 2] {
        [T::constant(0.5), x[1] * -0.7]
    }
}

fn main() -> Result<(), Error> {
    let block = WithJumps {
        system: Block,
        jumps: Wall,
    };
    let system = block.dynamics();
    let (t, x) = (0.0, vec![0.0, 0.0].into());
    let options = Options::tol(1e-12);
    // A transient, and the impacts of the last period.
    let last = 40.0 * TAU;
    let (start, nowhere) = (Moment { t, x }, Sampling::Nowhere);
    let (orbit, ended) = RecordedOrbit::solve(&*system, &start, last, &options, &[], nowhere)?;
    ended?;
    for event in orbit.events.iter().filter(|event| event.t() > last - TAU) {
        if event
            .transition()
            .is_some_and(|at| at.kind == TransitionKind::Jump)
        {
            let (before, after) = (event.before()[1], event.after()[1]);
            println!(
                "impact at t = {:.6}: {before:.6} to {after:.6}",
                event.t() - last + TAU
            );
        }
    }
    let cycle = PeriodicOrbit::near_forced(&block, 0.0, &orbit.end.x, TAU, &options)?;
    for multiplier in multipliers(&cycle.monodromy) {
        println!("multiplier {:.6}", multiplier.norm());
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
