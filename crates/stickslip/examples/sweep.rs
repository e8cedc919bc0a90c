//! A parameter sweep, as CSV on standard output: the fraction of time in stick against the belt's
//! speed.

#[path = "common/belt.rs"]
mod belt;

use belt::Belt;
use stickslip::{Error, Options, solve};

fn main() -> Result<(), Error> {
    println!("belt_speed,stick_share,transitions");
    for k in 1..=20 {
        let speed = 0.1 * f64::from(k);
        let belt = Belt { speed };
        let orbit = solve(&belt, 0.0, [0.5, 0.1], 100.0, &Options::default())?;
        let stuck: f64 = orbit.sticks().map(|stick| stick.duration()).sum();
        let share = stuck / (orbit.t_end - orbit.t_start);
        println!("{},{share},{}", belt.speed, orbit.transitions.len());
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
