//! What sort of motion an orbit is, by its returns to `x₂ = 0` from above.

use std::fmt;
use std::str::FromStr;

use super::trajectory::Outcome;
use crate::math;

/// The verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// All returns repeat after so many, at most [`LONGEST`].
    Periodic(usize),
    /// Nothing repeats, and returns that are close stay close.
    QuasiPeriodic,
    /// Nothing repeats, and returns that are close part.
    Chaotic,
    /// Too few returns to tell.
    Rest,
    /// It leaves for infinity.
    Escaped,
    /// It could not be followed.
    Failed,
}

/// Longest period that is looked for, in returns.
pub const LONGEST: usize = 16;
/// Returns closer than this fraction of the section's extent count as equal.
const EQUAL: f64 = 1e-3;
/// Fewer returns tell nothing.
const FEWEST: usize = 3 * LONGEST;
/// Neighbouring returns are compared again so many returns later.
const AHEAD: usize = 20;
/// Mean logarithm of the distances' growth until then above which the motion is chaotic.
const PARTED: f64 = 1.0;
/// Returns looked at.
const MOST: usize = 2000;

impl Class {
    /// Whether it is what the paper says of figure 10, 11 or 12 (0, 1, 2). Any period passes for Fig. 10's "two-periodic".
    pub fn is_published(self, figure: usize) -> bool {
        matches!(
            (figure, self),
            (0, Class::Periodic(_)) | (1, Class::QuasiPeriodic) | (2, Class::Chaotic)
        )
    }

    /// The verdict on an orbit.
    pub fn of(outcome: &Outcome) -> Class {
        match outcome {
            Outcome::Bounded(trajectory) => of_section(&trajectory.section),
            Outcome::Escaped => Class::Escaped,
            Outcome::Failed | Outcome::Interrupted => Class::Failed,
        }
    }
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).fold(0.0, |most: f64, i| most.max((a[i] - b[i]).abs()))
}

fn of_section(section: &[[f64; 3]]) -> Class {
    let section = &section[..section.len().min(MOST)];
    if section.len() < FEWEST {
        return Class::Rest;
    }
    // Every component of the state is of the same order, and a section of one point has no extent of its own.
    let extent = section
        .iter()
        .flatten()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    let repeats = |&k: &usize| {
        (k..section.len()).all(|i| distance(&section[i], &section[i - k]) <= EQUAL * extent)
    };
    if let Some(period) = (1..=LONGEST).find(repeats) {
        return Class::Periodic(period);
    }
    let last = section.len() - AHEAD;
    let (mut sum, mut count) = (0.0, 0usize);
    for i in 0..last {
        let nearest = (0..last)
            .filter(|&j| i.abs_diff(j) > 2)
            .map(|j| (distance(&section[i], &section[j]), j))
            .min_by(|one, other| one.0.total_cmp(&other.0));
        let Some((before, j)) = nearest else { continue };
        let after = distance(&section[i + AHEAD], &section[j + AHEAD]);
        if before > 0.0 && after > 0.0 {
            sum += math::ln(after / before);
            count += 1;
        }
    }
    if count > 0 && sum > PARTED * count as f64 {
        Class::Chaotic
    } else {
        Class::QuasiPeriodic
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Class::Periodic(k) => write!(f, "periodic {k}"),
            Class::QuasiPeriodic => write!(f, "quasi-periodic"),
            Class::Chaotic => write!(f, "chaotic"),
            Class::Rest => write!(f, "rest"),
            Class::Escaped => write!(f, "escaped"),
            Class::Failed => write!(f, "failed"),
        }
    }
}

impl FromStr for Class {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "quasi-periodic" => Ok(Class::QuasiPeriodic),
            "chaotic" => Ok(Class::Chaotic),
            "rest" => Ok(Class::Rest),
            "escaped" => Ok(Class::Escaped),
            "failed" => Ok(Class::Failed),
            _ => text
                .strip_prefix("periodic ")
                .and_then(|k| k.parse().ok())
                .map(Class::Periodic)
                .ok_or(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(mut next: impl FnMut(usize) -> [f64; 3]) -> Class {
        let points: Vec<[f64; 3]> = (0..600).map(&mut next).collect();
        of_section(&points)
    }

    #[test]
    fn the_classes_are_told_apart() {
        let three = |i: usize| [[0.3, 0.5, 0.1][i % 3], 1.0, 0.0];
        assert_eq!(section(three), Class::Periodic(3));
        // A point of the section determines the next: on a circle it takes both coordinates.
        let circle = |i: usize| [math::cos(i as f64), math::sin(i as f64), 0.0];
        assert_eq!(section(circle), Class::QuasiPeriodic);
        let mut x = 0.3;
        let logistic = |_| {
            x = 4.0 * x * (1.0 - x);
            [x, 1.0, 0.0]
        };
        assert_eq!(section(logistic), Class::Chaotic);
        assert_eq!(of_section(&[[0.0; 3]; 3]), Class::Rest);
    }
}
