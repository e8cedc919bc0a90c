//! The largest Lyapunov exponent of an attractor, in tables.

use stickslip::analysis::Exponent;
use stickslip_model::study::largest::numbers;

use crate::render::Table;

/// Adds columns for the value, its standard error and its uncertainty to a table. Cells without a
/// value are empty.
pub(super) fn columns<'a, R>(
    table: Table<'a, R>,
    duration: f64,
    of: impl Fn(&R) -> Option<Exponent> + Copy + 'a,
) -> Table<'a, R> {
    let numbers = move |row: &R| numbers(of(row), duration);
    table
        .column("lambda1", move |row| numbers(row)[0])
        .column("std_error", move |row| numbers(row)[1])
        .column("uncertainty", move |row| numbers(row)[2])
}

#[cfg(test)]
mod tests {
    use super::super::sweeping::{from_content, to_content};
    use super::*;

    #[test]
    fn numbers_without_bound_are_read_again() {
        for number in [
            0.1,
            -0.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MIN_POSITIVE,
        ] {
            let one = Exponent::Finite {
                value: number,
                std_error: -number,
            };
            let read: Exponent = from_content(&to_content(&one).unwrap()).unwrap();
            assert_eq!(read, one);
        }
        let undefined: f64 = from_content(&to_content(&f64::NAN).unwrap()).unwrap();
        assert!(undefined.is_nan());
    }
}
