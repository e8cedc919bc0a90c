//! The class of a motion, decided by its section and its exponents.

use std::fmt;

use crate::analysis::{Exponent, Spectrum};
use crate::math;

/// Points of the section nearer than this, as a fraction of its extent, count as one.
const SAME: f64 = 1e-5;
/// More distinct points than this are no periodic motion anybody would name.
const MOST: usize = 64;
/// A vector may have grown by so much over a broken number of turns without a rate of growth.
const END_EFFECT: f64 = 30.0;
/// Standard errors within which an exponent counts as zero.
const STANDARD_ERRORS: f64 = 4.0;

/// A class of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Closes after so many turns of the block.
    Periodic(usize),
    /// Fills a torus: no closing, no growth, two exponents zero.
    QuasiPeriodic,
    /// Nearby orbits separate: the first exponent is positive.
    Chaotic,
    /// None of these can be told.
    Undecided,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Class::Periodic(1) => f.write_str("periodic"),
            Class::Periodic(2) => f.write_str("two-periodic"),
            Class::Periodic(turns) => write!(f, "{turns}-periodic"),
            Class::QuasiPeriodic => f.write_str("quasi-periodic"),
            Class::Chaotic => f.write_str("chaotic"),
            Class::Undecided => f.write_str("undecided"),
        }
    }
}

/// What the class is decided by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Points of the section `x₂ = 0`, `x₂` falling: where the block turns back.
    pub returns: usize,
    /// How many of them are distinct.
    pub distinct: usize,
    /// Mean time between them.
    pub return_time: f64,
    /// Exponents that are zero within their error.
    pub zeros: usize,
    /// Whether the first exponent is positive beyond its error.
    pub positive: bool,
}

impl Evidence {
    pub(super) fn gather(section: &[(f64, [f64; 4])], spectrum: &Spectrum<4>) -> Self {
        let return_time = match section {
            [(first, _), .., (last, _)] => (last - first) / (section.len() - 1) as f64,
            _ => f64::INFINITY,
        };
        Self {
            returns: section.len(),
            distinct: distinct(section),
            return_time,
            zeros: spectrum
                .exponents
                .iter()
                .filter(|exponent| exponent.value().abs() <= uncertainty(exponent, spectrum))
                .count(),
            positive: spectrum
                .exponents
                .first()
                .is_some_and(|exponent| exponent.value() > uncertainty(exponent, spectrum)),
        }
    }

    /// The class this is evidence of.
    pub fn class(&self) -> Class {
        // Several turns of each kind, so that a pattern has repeated.
        if self.distinct <= MOST.min(self.returns / 4) && !self.positive {
            Class::Periodic(self.distinct)
        } else if self.positive {
            Class::Chaotic
        } else if self.zeros == 2 {
            Class::QuasiPeriodic
        } else {
            Class::Undecided
        }
    }
}

/// How far from zero an exponent may be found that is zero.
fn uncertainty(exponent: &Exponent, spectrum: &Spectrum<4>) -> f64 {
    let scatter = STANDARD_ERRORS * exponent.std_error().unwrap_or(0.0);
    scatter.max(math::ln(END_EFFECT) / spectrum.duration)
}

/// Points of the section that are not within [`SAME`] of an earlier one.
fn distinct(section: &[(f64, [f64; 4])]) -> usize {
    let extent = (0..4)
        .map(|i| {
            let values = || section.iter().map(|(_, x)| x[i]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max);
    let size = section
        .iter()
        .flat_map(|(_, x)| x.iter())
        .fold(0.0_f64, |size, v| size.max(v.abs()));
    let near = SAME * extent.max(size);
    let mut kept: Vec<&[f64; 4]> = Vec::new();
    for (_, x) in section {
        let known = kept
            .iter()
            .any(|other| (0..4).all(|i| (x[i] - other[i]).abs() <= near));
        if !known {
            kept.push(x);
        }
    }
    kept.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(distinct: usize, zeros: usize, positive: bool) -> Evidence {
        Evidence {
            returns: 1000,
            distinct,
            return_time: 6.0,
            zeros,
            positive,
        }
    }

    #[test]
    fn classes_follow_from_the_evidence() {
        let class = |distinct, zeros, positive| evidence(distinct, zeros, positive).class();
        assert_eq!(class(1, 1, false).to_string(), "periodic");
        assert_eq!(class(2, 1, false).to_string(), "two-periodic");
        assert_eq!(class(3, 1, false).to_string(), "3-periodic");
        assert_eq!(class(990, 2, false), Class::QuasiPeriodic);
        assert_eq!(class(990, 1, true), Class::Chaotic);
        assert_eq!(class(990, 1, false), Class::Undecided);
        let short = Evidence {
            returns: 3,
            ..evidence(1, 1, false)
        };
        assert_eq!(short.class(), Class::Undecided);
    }

    #[test]
    fn points_that_repeat_count_once() {
        let section: Vec<(f64, [f64; 4])> = (0..9)
            .map(|k| {
                let t = f64::from(k);
                (t, [f64::from(k % 3), 0.0, 1.0, 1e-9 * t])
            })
            .collect();
        assert_eq!(distinct(&section), 3);
        assert_eq!(distinct(&[]), 0);
    }
}
