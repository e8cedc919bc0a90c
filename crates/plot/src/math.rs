//! Elementary functions with the same bits on every platform; see `clippy.toml`.

pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

pub(crate) fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// `10^n`: multiplications only (and one division for `n < 0`), in a fixed order.
pub(crate) fn power_of_ten(n: i32) -> f64 {
    let mut base: f64 = 10.0;
    let mut left = n.unsigned_abs();
    let mut product = 1.0;
    while left > 0 {
        if left & 1 == 1 {
            product *= base;
        }
        base *= base;
        left >>= 1;
    }
    if n < 0 { 1.0 / product } else { product }
}
