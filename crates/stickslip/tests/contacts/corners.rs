//! Corners where two contacts come to zero together, compared with all motions that are consistent.

use numerics::SplitMix;
use stickslip::error::ContactFault;
use stickslip::{
    Contacts, Ending, Error, Method, Mode, Options, Orbit, Scalar, Several, Side, solve,
};

use super::two_states::TwoStates;

/// `x_i' = drift_i + Σ effect_ij sgn x_j`.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    drift: [f64; 2],
    effect: [[f64; 2]; 2],
}

impl Corner {
    /// Rates with these sides, or weights between them.
    fn rates(&self, sides: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| {
            self.drift[i] + self.effect[i][0] * sides[0] + self.effect[i][1] * sides[1]
        })
    }

    fn solve(&self, start: [f64; 2], options: &Options) -> Result<Orbit<2, [Mode; 2]>, Error> {
        let system = Several(TwoStates::Corner(*self));
        solve(&system, 0.0, start, 1.2, options).map_err(|failure| failure.error)
    }
}

impl Contacts<2, 2> for Corner {
    fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, _x: &[T; 2]) -> [T; 2] {
        self.rates(sides.map(Side::sign)).map(T::constant)
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 2] {
        *x
    }
}

const SLIPS: [Mode; 2] = [Mode::Slip(Side::Below), Mode::Slip(Side::Above)];

/// Distance from its bound at which a rate or a weight decides.
const CLEAR: f64 = 1e-6;

/// All modes of the corner in which every contact that leaves moves to its side, and every contact
/// that holds is held by a weight between its sides. `None` if rounding would decide.
fn consistent(corner: &Corner) -> Option<Vec<[Mode; 2]>> {
    let [a, b] = corner.effect;
    let mut found = Vec::new();
    for first in [SLIPS[0], Mode::Stick, SLIPS[1]] {
        for second in [SLIPS[0], Mode::Stick, SLIPS[1]] {
            let modes = [first, second];
            let mut sides = modes.map(|mode| match mode {
                Mode::Slip(side) => side.sign(),
                Mode::Stick => 0.0,
            });
            let rates = corner.rates(sides);
            match modes {
                [Mode::Stick, Mode::Stick] => {
                    let determinant = a[0] * b[1] - a[1] * b[0];
                    sides = [
                        (a[1] * rates[1] - b[1] * rates[0]) / determinant,
                        (b[0] * rates[0] - a[0] * rates[1]) / determinant,
                    ];
                }
                [Mode::Stick, _] => sides[0] = -rates[0] / a[0],
                [_, Mode::Stick] => sides[1] = -rates[1] / b[1],
                _ => {}
            }
            let rates = corner.rates(sides);
            // A contact that no side moves is held by none, whatever its weight.
            let mut margin = f64::INFINITY;
            for i in 0..2 {
                margin = margin.min(match modes[i] {
                    Mode::Slip(side) => rates[i] * side.sign(),
                    Mode::Stick if sides[i].is_finite() => 1.0 - f64::abs(sides[i]),
                    Mode::Stick => -1.0,
                });
            }
            if margin.abs() < CLEAR {
                return None;
            }
            if margin > 0.0 {
                found.push(modes);
            }
        }
    }
    Some(found)
}

/// Corners of which some contacts have no effect on their own rates.
fn random(draw: &mut SplitMix) -> (Corner, Vec<[Mode; 2]>) {
    loop {
        let mut effect = [[0.0; 2]; 2];
        for entry in effect.as_flattened_mut() {
            *entry = if draw.between(0.0, 1.0) < 0.2 {
                0.0
            } else {
                draw.between(-2.0, 2.0)
            };
        }
        let drift = std::array::from_fn(|_| draw.between(-1.0, 1.0));
        let corner = Corner { drift, effect };
        if let Some(found) = consistent(&corner) {
            return (corner, found);
        }
    }
}

fn methods() -> [Options; 2] {
    [
        Options::tol(1e-10),
        Options::tol(1e-10).method(Method::Taylor),
    ]
}

#[test]
fn a_corner_is_refused_exactly_where_several_motions_are_consistent() {
    let mut draw = SplitMix::new(60);
    let (mut refused, mut left, mut held, mut arrivals) = (0, 0, 0, 0);
    for number in 0..600 {
        let (corner, found) = random(&mut draw);
        let options = &methods()[number % 2];
        let check = |run: Result<Orbit<2, [Mode; 2]>, Error>, phase: usize, at: f64| {
            let what = format!("{number}: {corner:?}: {found:?}");
            match (run, &found[..]) {
                (Ok(orbit), [one]) => assert_eq!(orbit.phases[phase].mode, *one, "{what}"),
                (
                    Err(Error::Contacts {
                        t,
                        fault: ContactFault::NoUniqueMode { candidates, .. },
                        ..
                    }),
                    _,
                ) => {
                    assert!(found.len() > 1 && (t - at).abs() < 1e-9, "{what}: {t}");
                    assert_eq!(candidates.len(), found.len(), "{what}");
                }
                (Ok(orbit), _) => panic!("{what}: {:?}", orbit.phases[phase].mode),
                (Err(error), _) => panic!("{what}: {error}"),
            }
        };
        check(corner.solve([0.0; 2], options), 0, 0.0);
        refused += usize::from(found.len() > 1);
        held += usize::from(found == [[Mode::Stick; 2]]);
        left += usize::from(found.len() == 1 && !found[0].contains(&Mode::Stick));
        // From each quadrant that leads both contacts to zero at t = 1.
        for sides in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let rates = corner.rates(sides);
            if (0..2).all(|i| rates[i] * sides[i] < -0.01) {
                arrivals += 1;
                check(corner.solve(rates.map(|rate| -rate), options), 1, 1.0);
            }
        }
    }
    assert!(
        refused > 50 && left > 50 && held > 50,
        "{refused} {left} {held}"
    );
    assert!(arrivals > 200, "{arrivals}");
}

#[test]
fn a_corner_that_each_contact_leads_the_other_away_from_has_three_motions() {
    let corner = Corner {
        drift: [0.0; 2],
        effect: [[0.0, -1.0], [-1.0, 0.0]],
    };
    for options in methods() {
        for start in [[0.0; 2], [1.0, 1.0]] {
            let error = corner.solve(start, &options).unwrap_err();
            let Error::Contacts {
                t,
                fault: ContactFault::NoUniqueMode { candidates, .. },
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert!(candidates.len() == 3, "{candidates:?}");
            assert!((t - start[0]).abs() < 1e-9, "{t}");
        }
    }
}

/// Below what the tolerance resolves, but it does not shrink: a closed square.
#[test]
fn a_motion_below_the_tolerance_that_goes_on_is_followed() {
    let corner = Corner {
        drift: [0.0; 2],
        effect: [[0.0, 1.0], [-1.0, 0.0]],
    };
    let system = Several(TwoStates::Corner(corner));
    for options in methods() {
        let orbit = solve(&system, 0.0, [1e-9, 0.0], 1e-6, &options).unwrap();
        assert_eq!(orbit.ending, Ending::EndTime);
        let turns = orbit.transitions.len();
        assert!((995..=1000).contains(&turns), "{turns}");
        let size = orbit.x_end[0].abs() + orbit.x_end[1].abs();
        assert!((size - 1e-9).abs() < 1e-14, "{size:e}");
    }
}
