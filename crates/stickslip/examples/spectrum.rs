//! A Lyapunov spectrum from the equations: for a limit cycle with stick, one exponent is zero and
//! one direction is annihilated.

#[path = "common/belt.rs"]
mod belt;

use belt::Belt;
use stickslip::Error;
use stickslip::analysis::{SpectrumOptions, lyapunov_spectrum};

fn main() -> Result<(), Error> {
    let belt = Belt { speed: 0.2 };
    let settings = SpectrumOptions::over(50.0, 500.0);
    let spectrum = lyapunov_spectrum(&belt, (0.0, [0.5, 0.1]), &settings)?;
    for (number, exponent) in spectrum.exponents.iter().enumerate() {
        println!("exponent {}: {:.6}", number + 1, exponent.value());
    }
    println!("{} entries into stick", spectrum.stick_entries);
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("runs");
}
