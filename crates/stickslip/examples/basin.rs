//! The basins of a friction oscillator's two attractors, on all cores: a fixed point and a
//! stick-slip cycle.

use stickslip::analysis::{RecurrenceSettings, basin};
use stickslip::{Error, Filippov, Method, Options, Scalar, Side, State};

/// `x'' = -x - 0.1 x' - F`, a block on a belt of speed `speed`; the friction decays with slip
/// speed. The example of bSTAB, Stender & Hoffmann, *Nonlinear Dyn.* 107 (2022) 1451.
struct Block {
    speed: f64,
}

impl Filippov<2> for Block {
    #[inline(always)]
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
        let slip = (x[1] - self.speed) * side.sign();
        let friction = ((slip * -2.0).exp() * 0.5 + 0.5) * side.sign();
        [x[1], -x[0] - x[1] * 0.1 - friction]
    }

    #[inline(always)]
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[1] - self.speed
    }
}

/// Number of starts in each direction.
const GRID: usize = 60;

fn main() -> Result<(), Error> {
    let at = |k: usize| (k as f64 + 0.5) / GRID as f64;
    let starts =
        (0..GRID * GRID).map(|k| State::from([4.0 * at(k % GRID) - 2.0, 2.0 * at(k / GRID)]));
    let settings = RecurrenceSettings::within(2000.0);
    let options = Options::tol(1e-8).method(Method::Taylor);
    let found = basin(&Block { speed: 1.5 }, starts, &settings, &options)?;
    for (number, attractor) in found.attractors.iter().enumerate() {
        println!(
            "{:.4} of the starts: {}",
            found.share(number).part,
            attractor.kind
        );
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
