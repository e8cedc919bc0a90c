//! More than two states: a block whose friction coefficient wears as it slips, stepped by hand.

use stickslip::{Error, Filippov, Integration, Options, Progress, Scalar, Side};

/// Position, velocity and friction coefficient.
struct Wearing;

impl Filippov<3> for Wearing {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        let slip_speed = (x[1] - 0.3) * side.sign();
        let wear = -(x[2] - 0.2) * slip_speed * 0.05;
        [x[1], -x[0] - x[2] * side.sign(), wear]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[1] - 0.3
    }
}

fn main() -> Result<(), Error> {
    let start = [0.0, 0.0, 0.6];
    let mut integration = Integration::new(&Wearing, 0.0, start, 60.0, &Options::default())?;
    loop {
        match integration.step()? {
            Progress::Transition(at) => {
                println!("{:?} at t = {:.4}, friction {:.6}", at.kind, at.t, at.x[2]);
            }
            Progress::Step | Progress::PhaseEnd(_) => {}
            Progress::End(summary) => {
                println!(
                    "{:?} after {} steps",
                    summary.ending, summary.counters.steps
                );
                return Ok(());
            }
        }
    }
}

#[test]
fn it_runs() {
    main().expect("runs");
}
