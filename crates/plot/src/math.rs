//! Elementary functions with the same bits on every platform; see `clippy.toml`.

pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

pub(crate) fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// `10^n`: the number that is nearest to it.
pub(crate) fn power_of_ten(n: i32) -> f64 {
    format!("1e{n}").parse().unwrap_or(f64::NAN)
}

/// `10^x`.
pub(crate) fn exp10(x: f64) -> f64 {
    libm::exp10(x)
}
