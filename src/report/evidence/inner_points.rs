//! `s2.inner_points`: the points ±1/√3 at the critical friction of model 1.

use super::{Evidence, Part, small};
use stickslip::analysis::{Visibility, tangency};
use stickslip::error::Error;
use stickslip::filippov::{Options, solve};
use stickslip::models::BeltOscillator;
use stickslip::system::{Mode, Side, State};

const TOLERANCE: f64 = 1e-13;
/// Start of the rides (m): between the lower outer point and the lower inner one.
const START: f64 = -0.9;
/// A ride ends at the outer point when it does so within this (m).
const AT: f64 = 1e-9;
/// Relative excesses of friction over the critical value, in the order in which they are tried.
const EXCESSES: [f64; 4] = [0.0, 1e-15, 1e-12, 1e-9];

/// A body put on the belt to the left of both inner points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ride {
    /// By how much friction exceeds the critical value, relative to it.
    pub excess: f64,
    /// Where the first stick phase ends (m).
    pub released_at: f64,
    /// Length of that phase (m); zero if the body does not stick.
    pub length: f64,
}

/// The inner points, and bodies that ride through them.
#[derive(Clone, Debug, PartialEq)]
pub struct InnerPoints {
    /// Position of the inner points (m), 1/√3, and of the outer ones, 2/√3.
    pub inner: f64,
    /// See `inner`.
    pub outer: f64,
    /// How the tangent field lies at −1/√3 and at 1/√3 at the critical friction; nothing where none is tangent.
    pub tangent: [Option<Visibility>; 2],
    /// Whether any field is tangent there at half the critical friction.
    pub tangent_at_half: bool,
    /// Rides at friction of no excess and more.
    pub rides: Vec<Ride>,
    /// A ride with friction a hundredth below the critical value.
    pub below_critical: Ride,
}

impl InnerPoints {
    /// Puts bodies on the belt.
    ///
    /// # Errors
    /// Those of [`solve`].
    pub fn compute() -> Result<InnerPoints, Error> {
        let inner = 1.0 / 3f64.sqrt();
        Ok(InnerPoints {
            inner,
            outer: 2.0 * inner,
            tangent: [-inner, inner].map(|x1| tangent_at(&with_friction(0.0), x1)),
            tangent_at_half: [-inner, inner]
                .into_iter()
                .any(|x1| tangent_at(&with_friction(-0.5), x1).is_some()),
            rides: EXCESSES.into_iter().map(ride).collect::<Result<_, _>>()?,
            below_critical: ride(-0.01)?,
        })
    }

    /// Whether a ride goes through both inner points and ends at the outer one.
    pub fn rides_through(&self, ride: &Ride) -> bool {
        START + ride.length > self.inner && (ride.released_at - self.outer).abs() <= AT
    }

    /// Least excess of friction from which on every ride goes through.
    pub fn least_excess(&self) -> Option<f64> {
        let through = self
            .rides
            .iter()
            .rev()
            .take_while(|ride| self.rides_through(ride));
        through.last().map(|ride| ride.excess)
    }
}

/// Model 1 with the critical friction of Eq. (13) exceeded by so much.
fn with_friction(excess: f64) -> BeltOscillator {
    BeltOscillator {
        mu0: 2.0 / (3.0 * 3f64.sqrt()) * (1.0 + excess),
        ..BeltOscillator::default()
    }
}

fn tangent_at(model: &BeltOscillator, x1: f64) -> Option<Visibility> {
    let x = State::from([x1, model.belt_speed]);
    [Side::Below, Side::Above]
        .into_iter()
        .find_map(|side| tangency(model, side, 0.0, &x))
}

fn ride(excess: f64) -> Result<Ride, Error> {
    let model = with_friction(excess);
    let start = State::from([START, model.belt_speed]);
    // Twice the time that the belt takes from one outer point to the other.
    let end = 2.0 * 4.0 / 3f64.sqrt() / model.belt_speed;
    let orbit = solve(&model, 0.0, start, end, &Options::tol(TOLERANCE))?;
    let first = orbit
        .phases
        .first()
        .filter(|phase| phase.mode == Mode::Stick);
    Ok(Ride {
        excess,
        released_at: first.map_or(START, |phase| phase.x_end[0]),
        length: first.map_or(0.0, |phase| phase.displacement()[0]),
    })
}

impl Evidence for InnerPoints {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "±1/√3 are tangent points at the critical friction",
                holds: self.tangent.iter().all(Option::is_some) && !self.tangent_at_half,
            },
            Part {
                what: "they lie inside the stick zone: a body on the belt rides through both to the outer point",
                holds: self.least_excess().is_some() && !self.rides_through(&self.below_critical),
            },
        ]
    }

    fn line(&self) -> String {
        let kind = |found: Option<Visibility>| match found {
            Some(Visibility::Visible) => "visible",
            Some(Visibility::Invisible) => "invisible",
            Some(Visibility::Degenerate) => "degenerate",
            None => "no",
        };
        let least = self.least_excess();
        let ride = self
            .rides
            .iter()
            .find(|ride| Some(ride.excess) == least)
            .or(self.rides.last());
        format!(
            "at the critical friction a field is tangent at −1/√3 ({}) and at 1/√3 ({}); from x1 = {START} m on the belt, {}, the body \
             is released at {:.6} m, {} m from 2/√3; at friction a hundredth below critical at {:.6} m",
            kind(self.tangent[0]),
            kind(self.tangent[1]),
            match least {
                Some(0.0) => "at the critical friction itself".to_owned(),
                Some(excess) =>
                    format!("friction exceeding the critical one by {excess:.0e} of it"),
                None => "at the largest friction tried".to_owned(),
            },
            ride.map_or(f64::NAN, |ride| ride.released_at),
            small(ride.map_or(f64::NAN, |ride| (ride.released_at - self.outer).abs())),
            self.below_critical.released_at,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn the_body_rides_through_both_inner_points() {
        let found = InnerPoints::compute().unwrap();
        assert_eq!(found.support(), Support::Whole, "{found:?}");
    }

    #[test]
    fn below_the_critical_friction_it_is_released_before() {
        let found = InnerPoints::compute().unwrap();
        assert!(found.below_critical.released_at < found.inner);
        // Were the rides so, the statement would fail.
        let spoilt = InnerPoints {
            rides: vec![found.below_critical],
            ..found
        };
        assert!(!spoilt.parts()[1].holds);
    }
}
