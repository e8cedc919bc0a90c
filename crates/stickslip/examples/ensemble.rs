//! An ensemble: a thousand starts on all cores, integrated by vectorised Taylor series, and the
//! time that each orbit spends in stick.

#[path = "common/belt.rs"]
mod belt;

use std::ops::ControlFlow;

use belt::Belt;
use stickslip::{Method, Mode, Observer, Options, Phase, Start, State, ensemble};

/// Time spent sticking.
#[derive(Default)]
struct Stuck(f64);

impl Observer<2> for Stuck {
    fn phase(&mut self, phase: &Phase<2>) -> ControlFlow<()> {
        if phase.mode == Mode::Stick {
            self.0 += phase.duration();
        }
        ControlFlow::Continue(())
    }
}

fn main() {
    let belt = Belt { speed: 0.4 };
    let starts = (0..1000).map(|k| Start {
        system: &belt,
        t: 0.0,
        x: State::from([0.002 * f64::from(k) - 1.0, 1.0]),
    });
    let options = Options::tol(1e-10).method(Method::Taylor);
    let (mut finished, mut most) = (0, 0.0_f64);
    ensemble(
        starts,
        30.0,
        &options,
        |_| Stuck::default(),
        |_number, stuck, outcome| {
            if outcome.is_ok() {
                finished += 1;
                most = most.max(stuck.0);
            }
            ControlFlow::Continue(())
        },
    );
    println!("{finished} orbits; the longest of them stuck for {most:.6} of 30 time units");
}

#[test]
fn it_runs() {
    main();
}
