//! Misprints of Sects. 2 to 4: friction as a coefficient, critical points, the Hénon steps, signs
//! of friction and springs.

use rayon::prelude::*;

use super::proof::Proof;
use crate::figures::normals;
use crate::figures::rows::Value;
use crate::numbers::extent;
use crate::paper::TOLERANCE;
use crate::paper::claim_id::ClaimId;
use crate::paper::models::{BeltOscillator, ForcedOscillator, Unchecked};
use crate::paper::published::Claims;
use crate::report::accuracy::{Accuracy, EventErrors};
use crate::report::{belt_positions, tangent_at, until_escape};
use numerics::bisect;
use stickslip::{Ending, Error, Fate, State, fate};

/// Positions between the outer tangent points that are tested for sticking. The results are ratios
/// over the same positions, so their number does not matter.
const POSITIONS_TESTED: u32 = 400;

/// The smallest μ0 (N) for which a body on the belt of model 1 sticks at all positions between the
/// outer tangent points, by bisection.
fn least_holding(model: &BeltOscillator) -> f64 {
    let reach = (model.k1 / model.k2).sqrt();
    let holds = |mu0: f64| {
        let model = BeltOscillator { mu0, ..*model };
        (0..=POSITIONS_TESTED).all(|k| {
            let part = 2.0 * f64::from(k) / f64::from(POSITIONS_TESTED) - 1.0;
            let x = State::from([reach * part, model.belt_speed]);
            fate(&model, 0.0, &x) == Fate::Stick
        })
    };
    bisect(0.0, 10.0, holds)
}

/// A coefficient would scale with the mass and not with the spring.
pub(super) fn unit_of_mu0() -> Proof {
    let printed = BeltOscillator::default();
    let plain = least_holding(&printed);
    let stiffer = least_holding(&BeltOscillator {
        k1: 2.0,
        k2: 2.0,
        ..printed
    });
    let heavier = least_holding(&BeltOscillator {
        mass: 2.0,
        ..printed
    });
    let (stiffer, heavier) = (stiffer / plain, heavier / plain);
    let holds = (stiffer - 2.0).abs() < 1e-9 && (heavier - 1.0).abs() < 1e-9;
    Proof::new("unit_of_mu0", [plain, stiffer, heavier], holds)
}

/// Eq. (12) gives the points where σ is stationary, and calls them tangent points.
pub(super) fn critical_points(claims: &Claims) -> Proof {
    let model = BeltOscillator::default();
    let points = claims.of(ClaimId::Eq12CriticalPoints).values();
    let mut least_sigma = f64::INFINITY;
    let (mut tangent, mut sticks, mut slips) = (0, 0, 0);
    for &x1 in points {
        let x = State::from([x1, model.belt_speed]);
        let [below, above] = normals(&model, 0.0, x.as_ref());
        least_sigma = least_sigma.min((below * above).abs());
        tangent += usize::from(tangent_at(&model, x1).is_some());
        match fate(&model, 0.0, &x) {
            Fate::Stick => sticks += 1,
            Fate::Slip(_) => slips += 1,
            Fate::Repelling => {}
        }
    }
    let counts = [points.len(), tangent, sticks, slips].map(Value::from);
    let shown = counts.into_iter().chain([least_sigma.into()]);
    let holds = !points.is_empty() && tangent == 0 && least_sigma > 1e-6;
    Proof::new("critical_points", shown, holds)
}

/// Eq. (13) also has a negative value of μ0, at which the continuous stick zone is said to exist as
/// well.
pub(super) fn negative_friction(claims: &Claims) -> Proof {
    let values = claims.of(ClaimId::Eq13CriticalMu0).values();
    let along = |mu0: f64| {
        let model = BeltOscillator {
            mu0,
            ..BeltOscillator::default()
        };
        let states = belt_positions(2.0 / 3f64.sqrt(), POSITIONS_TESTED, model.belt_speed);
        let fates: Vec<Fate> = states.map(|x| fate(&model, 0.0, &x)).collect();
        let of = |fate| fates.iter().filter(|one| **one == fate).count();
        (of(Fate::Stick), of(Fate::Repelling))
    };
    let (negative, positive) = extent(values.iter().copied());
    let (sticks, repels) = (along(positive), along(negative));
    let holds = sticks.0 == POSITIONS_TESTED as usize && repels == (0, POSITIONS_TESTED as usize);
    let shown = [sticks.0, repels.0, repels.1];
    Proof::new("negative_friction", shown, holds)
}

pub(super) fn step_from_above(accuracy: &Accuracy) -> Proof {
    let [_, text] = &accuracy.text;
    let [_, stated] = &accuracy.stated;
    let listing = &accuracy.printed_sign;
    let holds = !text.is_accurate() && !listing.is_accurate() && stated.is_accurate();
    let shown = [text, listing, stated].map(|one| one.at_printed_step);
    Proof::new("step_from_above", shown, holds)
}

/// Sect. 3 takes the step from the position after the step that it repeats.
pub(super) fn release_step(accuracy: &Accuracy) -> Proof {
    let belt = &accuracy.release.belt;
    let [.., printed] = &belt.printed_step;
    let holds = !printed.is_accurate() && belt.from_after.is_exact() && belt.corrected.is_exact();
    let shown = [printed, &belt.from_after, &belt.corrected].map(|one| one.at_printed_step);
    Proof::new("release_step", shown, holds)
}

/// Eq. (15) takes an acceleration for a velocity. On the belt that acceleration vanishes where the
/// step ends.
pub(super) fn time_in_stick(accuracy: &Accuracy) -> Proof {
    let release = &accuracy.release;
    let [below, above] = &release.belt.literal;
    let corrected = &release.belt.corrected;
    let is_accurate = release.forced.corrected.is_accurate();
    let off = |errors: &EventErrors| Value::from(errors.at_printed_step);
    let shown = [
        off(below),
        off(above),
        off(corrected),
        if is_accurate { "yes" } else { "no" }.into(),
        off(&release.forced.corrected),
        off(&release.moving),
    ];
    let holds = corrected.is_accurate()
        && !release.belt.literal_better().is_accurate()
        && release.moving.is_accurate();
    Proof::new("time_in_stick", shown, holds)
}

/// Forcing periods over which starts are integrated: long enough for stick and for escape.
const PERIODS_FOLLOWED: f64 = 6.0;

/// Starts of both models: positions (m) and velocities (m/s).
fn starts() -> Vec<State<2>> {
    let positions = (0..9).map(|k| 0.25 * f64::from(k) - 1.0);
    positions
        .flat_map(|x1| [-0.8, 0.0, 0.4, 0.8].map(|x2| State::from([x1, x2])))
        .collect()
}

/// Number of stick phases of model 2 from all starts, and of orbits that end where Σ repels.
fn sticks_and_ends(model: &ForcedOscillator) -> Result<(usize, usize), Error> {
    let span = PERIODS_FOLLOWED * model.period();
    let counts = starts().into_par_iter().map(|x| {
        // Friction of the other sign is the subject.
        let (orbit, _) = until_escape(&Unchecked(model), (0.0, x), span, TOLERANCE)?;
        let ends = usize::from(orbit.ending == Ending::Repelling);
        Ok((orbit.sticks().count(), ends))
    });
    let sum = |one: (usize, usize), other: (usize, usize)| (one.0 + other.0, one.1 + other.1);
    counts.try_reduce(|| (0, 0), |one, other| Ok(sum(one, other)))
}

pub(super) fn sign_of_friction() -> Result<Proof, Error> {
    let model = ForcedOscillator::default();
    let printed = ForcedOscillator {
        mu0: -model.mu0,
        ..model
    };
    let (with_plus, with_minus) = (sticks_and_ends(&printed)?, sticks_and_ends(&model)?);
    let shown = [starts().len(), with_plus.0, with_plus.1, with_minus.0];
    let holds = with_plus.0 == 0 && with_plus.1 > 0 && with_minus.0 > 0;
    Ok(Proof::new("sign_of_friction", shown, holds))
}

pub(super) fn spring_signs() -> Result<Proof, Error> {
    let first = BeltOscillator::default();
    // The same mass, belt and friction without forcing: only the spring differs.
    let second = ForcedOscillator {
        mass: first.mass,
        belt_speed: first.belt_speed,
        amplitude: 0.0,
        ..ForcedOscillator::default()
    };
    let mut sigma = 0.0_f64;
    for k in -150..=150 {
        let x = [f64::from(k) / 100.0, first.belt_speed];
        let (one, other) = (normals(&first, 0.0, &x), normals(&second, 0.0, &x));
        sigma = sigma.max((one[0] * one[1] - other[0] * other[1]).abs());
    }
    let span = PERIODS_FOLLOWED * ForcedOscillator::default().period();
    let (mut escapes_first, mut escapes_second) = (0, 0);
    for x in starts() {
        escapes_first += usize::from(until_escape(&first, (0.0, x), span, TOLERANCE)?.1);
        escapes_second += usize::from(until_escape(&second, (0.0, x), span, TOLERANCE)?.1);
    }
    let counts = [starts().len(), escapes_first, escapes_second].map(Value::from);
    let shown = std::iter::once(sigma.into()).chain(counts);
    let holds = sigma < 1e-14 && escapes_first == 0 && escapes_second > 0;
    Ok(Proof::new("spring_signs", shown, holds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn critical_points_are_tangent_at_the_critical_friction() {
        // Otherwise the erratum would not hold.
        let model = BeltOscillator {
            mu0: 2.0 / (3.0 * 3f64.sqrt()),
            ..BeltOscillator::default()
        };
        assert!(tangent_at(&model, 1.0 / 3f64.sqrt()).is_some());
    }
}
