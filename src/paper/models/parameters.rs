//! Checks of model parameters.

use stickslip::Error;

fn require(good: bool, name: &'static str, value: f64, bound: &'static str) -> Result<f64, Error> {
    if good {
        Ok(value)
    } else {
        Err(Error::Parameter { name, value, bound })
    }
}

pub(super) fn finite(name: &'static str, value: f64) -> Result<f64, Error> {
    require(value.is_finite(), name, value, "finite")
}

pub(super) fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    let good = value > 0.0 && value.is_finite();
    require(good, name, value, "positive and finite")
}

pub(super) fn not_negative(name: &'static str, value: f64) -> Result<f64, Error> {
    let good = value >= 0.0 && value.is_finite();
    require(good, name, value, "finite and at least 0")
}
