//! Where orbits start.

use stickslip::error::Error;
use stickslip::models::ForcedOscillator;
use stickslip::system::State;

/// Positions of the starts, in units of √(k1/k2), beyond which the spring drives bodies away; symmetrical.
const POSITIONS: usize = 9;
/// Their outermost.
const REACH: f64 = 1.2;
/// Velocities of the starts (m/s); the belt's speed comes on top.
const VELOCITIES: [f64; 4] = [-1.6, -0.8, 0.0, 1.2];

/// Starts: a grid, points on the belt, and the ends of the stick zones, of which one is the paper's start.
pub(in crate::report) fn starts(model: &ForcedOscillator) -> Result<Vec<State<2>>, Error> {
    let unit = (model.k1 / model.k2).sqrt();
    let speeds = || VELOCITIES.into_iter().chain([model.belt_speed]);
    let middle = (POSITIONS / 2) as f64;
    let mut all: Vec<State<2>> = (0..POSITIONS)
        .map(|k| unit * REACH * (k as f64 - middle) / middle)
        .flat_map(|x1| speeds().map(move |x2| State::from([x1, x2])))
        .collect();
    for (lower, upper) in model.stick_zones()? {
        all.extend([lower, upper].map(|z| State::from([z, model.belt_speed])));
    }
    Ok(all)
}
