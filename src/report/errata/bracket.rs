//! Misprints of Eqs. (27) and (28), of the time's unit, and of the abstract on model 3.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::{Erratum, count, erratum, number};
use crate::report::evidence::EvidenceError;
use stickslip::error::Error;
use stickslip::filippov::{Observer, Options, StepRecord, run, solve};
use stickslip::models::{BlockAndBracket, Caption, Reading, Rig, Unloading};
use stickslip::system::State;

const TOLERANCE: f64 = 1e-10;
/// A component beyond this has diverged.
const DIVERGED: f64 = 1e3;
/// The published series begins here (t): what has diverged by then is in no figure.
const SERIES_FROM: f64 = 3000.0;
/// The figures and their captions.
const FIGURES: [(&str, Caption); 3] = [
    ("Fig. 10", Caption::FIG10),
    ("Fig. 11", Caption::FIG11),
    ("Fig. 12", Caption::FIG12),
];

pub(super) fn errata() -> Result<Vec<Erratum>, EvidenceError> {
    Ok(vec![
        signs()?,
        friction_counted_twice()?,
        unit_of_time()?,
        four_states()?,
    ])
}

/// What becomes of the equations in one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    /// A component passes the bound at this time.
    Diverges(f64),
    /// None does; the largest component.
    Bounded(f64),
}

/// Keeps the largest component.
struct Largest(f64);

impl Observer<4> for Largest {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.0 = self.0.max(step.x_end.amax());
        ControlFlow::Continue(())
    }
}

fn outcome(caption: &Caption, reading: &Reading) -> Result<Outcome, Error> {
    let model = BlockAndBracket::from_caption(caption, reading)?;
    let options = Options::tol(TOLERANCE).escape(DIVERGED);
    let mut largest = Largest(0.0);
    let start = State::from(caption.start);
    let run = run(&model, 0.0, start, SERIES_FROM, &options, &mut largest);
    match run.map_err(Error::from) {
        Ok(_) => Ok(Outcome::Bounded(largest.0)),
        Err(Error::Escaped { t, .. }) => Ok(Outcome::Diverges(t)),
        Err(error) => Err(error),
    }
}

fn signs() -> Result<Erratum, Error> {
    let jobs: Vec<(&str, Caption, Reading)> = FIGURES
        .into_iter()
        .flat_map(|(name, caption)| {
            [Reading::as_printed(), Reading::exact()].map(|reading| (name, caption, reading))
        })
        .collect();
    let found = jobs
        .par_iter()
        .map(|(_, caption, reading)| outcome(caption, reading))
        .collect::<Result<Vec<Outcome>, Error>>()?;
    let mut shown = Vec::new();
    let mut holds = true;
    for ((name, _), pair) in FIGURES.into_iter().zip(found.chunks_exact(2)) {
        for (which, one) in ["as printed", "corrected"].into_iter().zip(pair) {
            shown.push(match one {
                Outcome::Diverges(t) => number(
                    format!("{name}, {which}: a component passes {DIVERGED} at t"),
                    *t,
                    "t",
                ),
                Outcome::Bounded(size) => number(
                    format!("{name}, {which}: largest component until t = {SERIES_FROM}"),
                    *size,
                    "1",
                ),
            });
        }
        holds &= matches!(pair, [Outcome::Diverges(_), Outcome::Bounded(_)]);
    }
    Ok(erratum(
        "Eq. (27)",
        "in the second row x3 and T(v) enter the bracket with a minus sign",
        "with a plus sign: the spring between block and bracket is stretched by x1 + x3, and friction opposes slip",
        shown,
        holds,
    ))
}

/// A block and a bracket in SI units, undamped as in the captions.
fn rig(gravity: f64, stiffness: f64) -> Rig {
    Rig {
        mass: 1.0,
        inertia: 0.5,
        arm: 0.7,
        k1: 2.0 * stiffness,
        k2: stiffness,
        k3: 0.9 * stiffness,
        c1: 0.0,
        c2: 0.0,
        gravity,
        mu0: 0.7,
        delta: 0.1,
        belt_speed: 0.2,
    }
}

/// Time over which the rig is followed, in units of 1/ω.
const RIG_SPAN: f64 = 40.0;

/// The state of a rig after [`RIG_SPAN`], in the units of Eq. (27).
fn of_rig(rig: &Rig, start: &State<4>) -> Result<State<4>, Error> {
    let (length, time) = (rig.length_unit(), rig.time_unit());
    let units = State::from([length, length / time, length, length / time]);
    let x = start.component_mul(&units);
    let end = solve(rig, 0.0, x, RIG_SPAN * time, &Options::tol(1e-12))?;
    Ok(end.x_end.component_div(&units))
}

/// Newton's law in SI units against the two ways to write the normal force with ξ6.
fn friction_counted_twice() -> Result<Erratum, EvidenceError> {
    let rig = rig(9.81, 1.0);
    let start = State::from([0.0, 0.01, 0.0, -0.05]);
    let newton = of_rig(&rig, &start)?;
    let plain = rig.nondimensional();
    // The captions' sixth and seventh numbers for this rig.
    let caption = |model: &BlockAndBracket| Caption {
        numbers: [
            model.coupling,
            0.0,
            model.mobility,
            model.bracket_stiffness,
            0.0,
            rig.mu0,
            rig.mu0 * rig.k3 / rig.k2,
            model.delta,
            model.belt_speed,
        ],
        start: start.into(),
    };
    let caption = caption(&plain);
    let with = |unloading| -> Result<f64, EvidenceError> {
        let reading = Reading {
            unloading,
            ..Reading::exact()
        };
        let model = BlockAndBracket::from_caption(&caption, &reading)?;
        let end = solve(&model, 0.0, start, RIG_SPAN, &Options::tol(1e-12))?;
        Ok((end.x_end - newton).amax())
    };
    let (printed, corrected) = (with(Unloading::Plain)?, with(Unloading::OverMu0)?);
    Ok(erratum(
        "Eq. (28)",
        "friction is mu0 (1 - xi6 x3 - xi7 x4), although xi6 and xi7 hold a factor mu0 already",
        "mu0 - xi6 x3 - xi7 x4",
        vec![
            number(
                "a rig in SI units against Eqs. (27), (28) as printed, signs mended: states differ by",
                printed,
                "mg/k2",
            ),
            number("against the corrected form", corrected, "mg/k2"),
        ],
        corrected < 1e-6 && printed > 1e-3,
    ))
}

/// Two rigs of other time units have the same Eq. (27).
fn unit_of_time() -> Result<Erratum, EvidenceError> {
    let slow = rig(9.81, 1.0);
    // Four times the stiffness and, so that the length unit stays, four times gravity; speeds double.
    let fast = Rig {
        belt_speed: 2.0 * slow.belt_speed,
        delta: 0.5 * slow.delta,
        ..rig(4.0 * 9.81, 4.0)
    };
    let start = State::from([0.0, 0.01, 0.0, -0.05]);
    let apart = (of_rig(&slow, &start)? - of_rig(&fast, &start)?).amax();
    let ratio = slow.time_unit() / fast.time_unit();
    Ok(erratum(
        "Sect. 5.2",
        "the series is saved over (3–12)·10³ s",
        "Eq. (27) counts time in units of 1/ω: its series is (3–12)·10³ such units long, and its exponents are per unit",
        vec![
            number(
                "duration of one unit, a rig with ω² = 3 N/m over 1 kg",
                slow.time_unit(),
                "s",
            ),
            number(
                "the same with four times the stiffness",
                fast.time_unit(),
                "s",
            ),
            number(
                format!(
                    "states of the two, of one and the same Eq. (27), differ after {RIG_SPAN} units by"
                ),
                apart,
                "mg/k2",
            ),
        ],
        (ratio - 2.0).abs() < 1e-12 && apart < 1e-6,
    ))
}

/// Time over which the states of model 3 are sampled.
const SAMPLED: f64 = 1000.0;
const SAMPLES: u32 = 4000;
/// A direction is there when the states spread along it by more than this part of their largest spread.
const PART: f64 = 1e-2;

/// Spreads (standard deviations) of the sampled states along their principal directions, the largest first.
fn spreads(caption: &Caption) -> Result<[f64; 4], EvidenceError> {
    let model = BlockAndBracket::from_caption(caption, &Reading::exact())?;
    let options = Options::tol(TOLERANCE);
    let orbit = solve(&model, 0.0, State::from(caption.start), SAMPLED, &options)?;
    let times = (0..SAMPLES).map(|k| SAMPLED * f64::from(k) / f64::from(SAMPLES));
    let states = orbit.sample(times)?;
    let n = f64::from(SAMPLES);
    let mean = states.iter().fold(State::<4>::zeros(), |sum, x| sum + x) / n;
    let covariance = states
        .iter()
        .map(|x| (x - mean) * (x - mean).transpose())
        .fold(
            stickslip::nalgebra::SMatrix::<f64, 4, 4>::zeros(),
            |sum, one| sum + one,
        )
        / n;
    let mut values: [f64; 4] = covariance.symmetric_eigenvalues().into();
    values.sort_by(|one, other| other.total_cmp(one));
    Ok(values.map(|value| value.max(0.0).sqrt()))
}

fn four_states() -> Result<Erratum, EvidenceError> {
    let mut shown = Vec::new();
    let mut holds = true;
    for (name, caption) in FIGURES {
        let spreads = spreads(&caption)?;
        let directions = spreads
            .iter()
            .filter(|one| **one > PART * spreads[0])
            .count();
        shown.push(count(
            format!("{name}: directions along which the states spread, of which a two-dimensional system has 2"),
            directions,
        ));
        shown.push(number(
            format!("{name}: least spread over the largest"),
            spreads[3] / spreads[0],
            "1",
        ));
        holds &= directions > 2;
    }
    Ok(erratum(
        "Abstract",
        "Lyapunov exponents of a two-dimensional system",
        "of a system with two degrees of freedom, whose state has four components",
        shown,
        holds,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_signs_diverge() {
        let found = signs().unwrap();
        assert!(found.holds, "{found:?}");
    }

    #[test]
    fn newtons_law_decides_how_friction_is_written() {
        let found = friction_counted_twice().unwrap();
        assert!(found.holds, "{found:?}");
    }

    #[test]
    fn the_same_equations_run_at_two_paces() {
        let found = unit_of_time().unwrap();
        assert!(found.holds, "{found:?}");
        // With the belt of the slow rig the fast one is another system.
        let slow = rig(9.81, 1.0);
        let other = rig(4.0 * 9.81, 4.0);
        let start = State::from([0.0, 0.01, 0.0, -0.05]);
        let apart = of_rig(&slow, &start).unwrap() - of_rig(&other, &start).unwrap();
        assert!(apart.amax() > 1e-3);
    }

    #[test]
    fn four_directions_are_there() {
        let found = four_states().unwrap();
        assert!(found.holds, "{found:?}");
    }
}
