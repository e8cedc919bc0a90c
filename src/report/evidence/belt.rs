//! Bodies on the belt of model 1: `s2.inner_points`, at the critical friction ±1/√3 are tangent
//! points inside the stick zone; `fig04.no_stick`, how many starts stick before they settle.

use rayon::prelude::*;

use crate::figures::fig04::{Cycle, kind};
use crate::numbers::ROUNDING;
use crate::paper::TOLERANCE;
use crate::paper::models::BeltOscillator;
use crate::paper::reading::Reading::Exact;
use crate::report::digits::small;
use crate::report::finding::{Finding, statement};
use crate::report::tangent_at;
use stickslip::{Error, Mode, Options, State, solve};

/// Start on the belt (m): left of both inner points, inside the zone.
const START: f64 = -0.9;
/// Relative excess of friction over the critical value. At the critical value itself, rounding
/// decides at the inner points. The largest moves the outer point by less than [`ROUNDING`].
const EXCESSES: [f64; 4] = [0.0, 1e-15, 1e-14, 1e-13];

/// A ride on the belt until the body slips.
#[derive(Clone, Copy)]
struct Ride {
    /// Relative excess of friction over the critical value.
    excess: f64,
    /// Position of the release (m), and distance travelled until then (m).
    released_at: f64,
    length: f64,
}

impl Ride {
    /// Whether the body passes both inner points and is released at the outer one.
    fn goes_through(&self) -> bool {
        START + self.length > inner() && (self.released_at - 2.0 * inner()).abs() <= ROUNDING
    }
}

/// The upper of the inner points (m). The outer ones are at twice its distance.
fn inner() -> f64 {
    1.0 / 3f64.sqrt()
}

pub(super) fn inner_points() -> Result<Vec<Finding>, Error> {
    let rides: Vec<Ride> = EXCESSES.into_iter().map(ride).collect::<Result<_, _>>()?;
    Ok(statement_findings(&rides, ride(-0.01)?))
}

/// Judges the statement by rides at the critical friction and above, and by one below it.
fn statement_findings(rides: &[Ride], below: Ride) -> Vec<Finding> {
    let at_points = |excess| {
        let model = with_friction(excess);
        [-inner(), inner()].map(|x1| tangent_at(&model, x1))
    };
    let (tangent, at_half) = (at_points(0.0), at_points(-0.5));
    // The smallest excess above which every body passes both points.
    let through = rides.iter().rev().take_while(|ride| ride.goes_through());
    let least = through.last();
    let parts = [
        (
            "±1/√3 are tangent points at the critical friction",
            tangent.iter().all(Option::is_some) && at_half.iter().all(Option::is_none),
        ),
        (
            "they lie inside the stick zone: a body on the belt rides through both to the outer \
                point",
            least.is_some() && !below.goes_through(),
        ),
    ];
    let [left, right] = tangent.map(|visibility| visibility.map_or("no", kind));
    let friction = match least.map(|ride| ride.excess) {
        Some(0.0) => "at the critical friction itself".to_owned(),
        Some(excess) => format!("friction exceeding the critical one by {excess:.0e} of it"),
        None => "at the largest friction tried".to_owned(),
    };
    let released = least.or(rides.last());
    let released = released.map_or(f64::NAN, |ride| ride.released_at);
    let (off, before) = (small((released - 2.0 * inner()).abs()), below.released_at);
    let line = format!(
        "at the critical friction a field is tangent at −1/√3 ({left}) and at 1/√3 ({right}); from \
         x1 = {START} m on the belt, {friction}, the body is released at {released:.6} m, {off} m \
         from 2/√3; at friction a hundredth below critical at {before:.6} m"
    );
    vec![statement(Exact, parts, line)]
}

/// Positions (m) and velocities (m/s) of the starts on their way to the cycle, to either side of 0,
/// at the middles of equal parts, and the extent in both. None is at the belt's speed.
const START_GRID: (u32, u32) = (10, 6);
const START_REACH: f64 = 1.5;
/// Time (s) after which an orbit cannot be distinguished from the cycle.
const SETTLING_TIME: f64 = 60.0;

/// Number of starts, and of those that stick before they settle.
fn sticking(model: &BeltOscillator) -> Result<(usize, usize), Error> {
    let middle = |k: u32, of: u32| START_REACH * (2.0 * (f64::from(k) + 0.5) / f64::from(of) - 1.0);
    let (positions, velocities) = START_GRID;
    let starts = (0..positions * velocities).into_par_iter().map(|k| {
        let (i, j) = (k / velocities, k % velocities);
        let start = State::from([middle(i, positions), middle(j, velocities)]);
        let orbit = solve(model, 0.0, start, SETTLING_TIME, &Options::tol(TOLERANCE))?;
        Ok(orbit.sticks().next().is_some())
    });
    let sticks = starts.collect::<Result<Vec<bool>, Error>>()?;
    Ok((sticks.len(), sticks.into_iter().filter(|one| *one).count()))
}

/// `fig04.no_stick`: stick on the cycle, and on the way to it.
pub(super) fn no_stick(cycle: &Cycle) -> Result<Vec<Finding>, Error> {
    let (starts, sticking) = sticking(&BeltOscillator::default())?;
    let parts = [
        ("the limit cycle has no stick phase", cycle.sticks == 0),
        ("no start of a grid sticks on its way to it", sticking == 0),
    ];
    let line = format!(
        "{sticking} of {starts} starts, a grid up to {START_REACH} m and m/s, stick to the belt \
         before they settle. In another reading, of the periodic solution alone, the sentence \
         holds; but it says “in the considered system”, and the text goes on to the transient \
         trajectory"
    );
    Ok(vec![statement(Exact, parts, line)])
}

fn with_friction(excess: f64) -> BeltOscillator {
    BeltOscillator {
        mu0: 2.0 / (3.0 * 3f64.sqrt()) * (1.0 + excess),
        ..BeltOscillator::default()
    }
}

fn ride(excess: f64) -> Result<Ride, Error> {
    let model = with_friction(excess);
    let start = State::from([START, model.belt_speed]);
    let end = 2.0 * 4.0 / 3f64.sqrt() / model.belt_speed;
    let orbit = solve(&model, 0.0, start, end, &Options::tol(TOLERANCE))?;
    let first = orbit.phases.first();
    let first = first.filter(|phase| phase.mode == Mode::Stick);
    Ok(Ride {
        excess,
        released_at: first.map_or(START, |phase| phase.x_end[0]),
        length: first.map_or(0.0, |phase| phase.displacement()[0]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_body_rides_through_both_inner_points() {
        assert_eq!(inner_points().unwrap()[0].parts(), [true, true]);
    }

    #[test]
    fn most_starts_stick_and_none_does_without_friction() {
        let (starts, sticking_ones) = sticking(&BeltOscillator::default()).unwrap();
        assert!(
            2 * sticking_ones > starts && sticking_ones < starts,
            "{sticking_ones}"
        );
        let without = BeltOscillator {
            mu0: 0.0,
            ..BeltOscillator::default()
        };
        assert_eq!(sticking(&without).unwrap().1, 0);
    }

    #[test]
    fn below_the_critical_friction_it_is_released_before() {
        let below = ride(-0.01).unwrap();
        assert!(below.released_at < inner());
        // With such rides, the statement would fail.
        assert!(!statement_findings(&[below], below)[0].parts()[1]);
    }
}
