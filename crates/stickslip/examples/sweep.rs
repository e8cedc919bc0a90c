//! A parameter sweep, as CSV on standard output: the fraction of time in stick against the belt's
//! speed.

use stickslip::models::BeltOscillator;
use stickslip::{Error, Options, solve};

fn main() -> Result<(), Error> {
    println!("belt_speed,stick_share,transitions");
    for k in 1..=20 {
        let belt = BeltOscillator {
            belt_speed: 0.1 * f64::from(k),
            ..BeltOscillator::default()
        };
        let orbit = solve(&belt, 0.0, [0.5, 0.1], 100.0, &Options::default())?;
        let stuck: f64 = orbit.sticks().map(|stick| stick.duration()).sum();
        let share = stuck / (orbit.t_end - orbit.t_start);
        println!("{},{share},{}", belt.belt_speed, orbit.transitions.len());
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
