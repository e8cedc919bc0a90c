//! A user-defined oscillator: two functions, and the events along its orbit.

use stickslip::{Error, Filippov, Options, Scalar, Side, solve};

/// A block on a belt, held by a spring; friction decays with slip speed.
struct Block {
    belt_speed: f64,
}

impl Filippov<2> for Block {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip_speed = (x[1] - self.belt_speed) * side.sign();
        let friction = T::constant(side.sign()) / (slip_speed + 1.0);
        [x[1], -x[0] - friction]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.belt_speed
    }
}

fn main() -> Result<(), Error> {
    let block = Block { belt_speed: 0.2 };
    let start = [0.04, -0.01];
    let orbit = solve(&block, 0.0, start, 40.0, &Options::tol(1e-12))?;
    for at in &orbit.transitions {
        println!("{:?} at t = {:.6}, x = {:.6}", at.kind, at.t, at.x[0]);
    }
    for stick in orbit.sticks() {
        println!(
            "stick for {:.6} over {:.6}",
            stick.duration(),
            stick.displacement()[0]
        );
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
