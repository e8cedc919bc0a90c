//! Other readings of the equations.

use super::point::Point;
use super::starts::starts;
use stickslip::error::Error;
use stickslip::models::ForcedOscillator;

/// The model as Eq. (17) prints it, with friction that drives slip on (it has the sign of a negative `mu0` here; where a
/// start could go either way it goes up), and with the spring of Eq. (4), the opposite of Eq. (17)'s.
pub(super) fn variants() -> Result<Vec<(&'static str, Point)>, Error> {
    let printed = ForcedOscillator::default();
    let starts = starts(&printed)?;
    let reversed = ForcedOscillator {
        mu0: -printed.mu0,
        ..printed
    };
    let double_well = double_well();
    Ok(vec![
        (
            "+T as Eq. (17) prints it",
            Point::compute(&reversed, &starts, 1.0, reversed.mu0)?,
        ),
        (
            "spring of Eq. (4)",
            Point::compute(&double_well, &starts, 1.0, double_well.k1)?,
        ),
    ])
}

/// The printed model with the spring of Eq. (4), the opposite of Eq. (17)'s.
pub(super) fn double_well() -> ForcedOscillator {
    let printed = ForcedOscillator::default();
    ForcedOscillator {
        k1: -printed.k1,
        k2: -printed.k2,
        ..printed
    }
}
