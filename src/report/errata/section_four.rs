//! Misprints of Sect. 4: signs of friction and springs, lengths and durations, regions and directions.

use rayon::prelude::*;

use super::{Erratum, count, erratum, number, word};
use crate::report::evidence::{Arcs, EvidenceError, Start, Way, ZoneOscillates};
use crate::report::statements::Statements;
use stickslip::error::Error;
use stickslip::filippov::{Options, solve};
use stickslip::models::{BeltOscillator, ForcedOscillator};
use stickslip::orbit::{Ending, Orbit};
use stickslip::system::{Filippov, Side, State, Unchecked};

/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
const ESCAPE: f64 = 10.0;
const TOLERANCE: f64 = 1e-12;
/// Forcing periods that starts are followed over.
const FOLLOWED: f64 = 6.0;

pub(super) fn errata(statements: &Statements) -> Result<Vec<Erratum>, EvidenceError> {
    Ok(vec![
        sign_of_friction()?,
        spring_signs()?,
        lengths_and_durations(&statements.way),
        start_of_fig08(&statements.start),
        regions_of_arcs(&statements.arcs),
        direction_of_oscillation(&statements.zone_oscillates),
    ])
}

/// Starts of both models: positions (m) and velocities (m/s).
fn starts() -> Vec<State<2>> {
    let positions = (0..9).map(|k| 0.25 * f64::from(k) - 1.0);
    positions
        .flat_map(|x1| [-0.8, 0.0, 0.4, 0.8].map(|x2| State::from([x1, x2])))
        .collect()
}

/// The orbit as far as it goes before it escapes, and whether it does.
fn follow<S: Filippov<2>>(system: &S, x: State<2>, span: f64) -> Result<(Orbit<2>, bool), Error> {
    match solve(
        system,
        0.0,
        x,
        span,
        &Options::tol(TOLERANCE).escape(ESCAPE),
    ) {
        Ok(orbit) => Ok((orbit, false)),
        Err(failure) if matches!(failure.error, Error::Escaped { .. }) => {
            Ok((*failure.reached, true))
        }
        Err(failure) => Err(failure.into()),
    }
}

/// Stick phases of model 2 from all starts, and orbits that end where Σ repels.
fn sticks_and_ends(model: &ForcedOscillator) -> Result<(usize, usize), Error> {
    let found = starts()
        .into_par_iter()
        .map(|x| {
            // Friction of the other sign is what is asked about.
            let (orbit, _) = follow(&Unchecked(model), x, FOLLOWED * model.period())?;
            Ok((
                orbit.sticks().count(),
                usize::from(orbit.ending == Ending::Repelling),
            ))
        })
        .collect::<Result<Vec<(usize, usize)>, Error>>()?;
    Ok(found
        .into_iter()
        .fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1)))
}

fn sign_of_friction() -> Result<Erratum, Error> {
    let model = ForcedOscillator::default();
    let printed = ForcedOscillator {
        mu0: -model.mu0,
        ..model
    };
    let (with_plus, with_minus) = (sticks_and_ends(&printed)?, sticks_and_ends(&model)?);
    Ok(erratum(
        "Eq. (17)",
        "friction enters with +T(v)",
        "-T(v), as in Eq. (4), Eq. (18) and the listing",
        vec![
            count("starts followed", starts().len()),
            count("stick phases with +T", with_plus.0),
            count(
                "orbits with +T that end where both fields lead away from Σ",
                with_plus.1,
            ),
            count("stick phases with -T", with_minus.0),
        ],
        with_plus.0 == 0 && with_plus.1 > 0 && with_minus.0 > 0,
    ))
}

fn spring_signs() -> Result<Erratum, Error> {
    let first = BeltOscillator::default();
    // The same mass, belt and friction, and no forcing: what differs is the spring.
    let second = ForcedOscillator {
        mass: first.mass,
        belt_speed: first.belt_speed,
        amplitude: 0.0,
        ..ForcedOscillator::default()
    };
    let mut sigma = 0.0_f64;
    for k in -150..=150 {
        let x = [f64::from(k) / 100.0, first.belt_speed];
        let product = |below: f64, above: f64| below * above;
        let one = |side| first.field(side, 0.0, &x)[1];
        let other = |side| second.field(side, 0.0, &x)[1];
        let difference = product(one(Side::Below), one(Side::Above))
            - product(other(Side::Below), other(Side::Above));
        sigma = sigma.max(difference.abs());
    }
    let span = FOLLOWED * ForcedOscillator::default().period();
    let (mut escapes_first, mut escapes_second) = (0, 0);
    for x in starts() {
        escapes_first += usize::from(follow(&first, x, span)?.1);
        escapes_second += usize::from(follow(&second, x, span)?.1);
    }
    Ok(erratum(
        "Eq. (1) against Eq. (17)",
        "the springs of the two models have opposite signs, without a word: a double well in the first, a softening spring that \
         lets bodies escape in the second",
        "sigma, the only function both share, cannot tell them apart; the dynamics can",
        vec![
            number("largest difference of sigma, |z| <= 1.5", sigma, "m²/s⁴"),
            count(
                "starts followed without forcing, all else equal",
                starts().len(),
            ),
            count(
                "those that escape with the spring of Eq. (1)",
                escapes_first,
            ),
            count(
                "those that escape with the spring of Eq. (17)",
                escapes_second,
            ),
        ],
        sigma < 1e-14 && escapes_first == 0 && escapes_second > 0,
    ))
}

fn lengths_and_durations(way: &Way) -> Erratum {
    let mut rows = Vec::new();
    for (n, (published, listing)) in (1..).zip(way.published.into_iter().zip(way.listing)) {
        let (published_name, listing_name): (String, String) = (
            format!("published duration {n} less length {n}/vp"),
            format!("the same of the listing's run, phase {n}"),
        );
        rows.push(number(published_name, published, "s"));
        rows.push(number(listing_name, listing, "s"));
    }
    let (phases, largest) = way.model;
    let explained = "largest difference that rounding of print explains";
    rows.push(number(explained, way.rounding, "s"));
    rows.push(count("stick phases of the stated model", phases));
    rows.push(number("largest difference among them", largest, "s"));
    let both = way.published.into_iter().chain(way.listing);
    erratum(
        "Sect. 4.2",
        "the stick phases' durations are longer than their lengths over the belt's speed",
        "equal: the body rides the belt",
        rows,
        both.fold(f64::INFINITY, f64::min) > way.rounding && way.holds_in_the_model(),
    )
}

fn start_of_fig08(start: &Start) -> Erratum {
    let mut rows = Vec::new();
    for (name, from) in [("caption", &start.captioned), ("listing", &start.listed)] {
        let release = format!("first release of the listing from the {name}'s start");
        rows.push(number(
            format!("x1 at the start by the {name}"),
            from.x1,
            "m",
        ));
        rows.push(number(release, from.first_release, "s"));
        rows.push(count(
            "published numbers it settles on from there",
            from.digits,
        ));
    }
    let apart = start.captioned.first_release - start.listed.first_release;
    erratum(
        "Fig. 8 caption",
        "the start is the third tangent point",
        "the listing starts from T[3], the fourth; the orbits differ until they settle",
        rows,
        apart.abs() > 1e-3,
    )
}

fn regions_of_arcs(arcs: &Arcs) -> Erratum {
    erratum(
        "Sect. 4.2",
        "S1 holds the upper arcs of the trajectory and S2 the lower ones",
        "S1 = {x2 < vp} holds the lower ones, S2 the upper",
        vec![
            number(
                "listing: largest velocity in S1",
                arcs.listing.highest_in_s1,
                "m/s",
            ),
            number("least velocity in S2", arcs.listing.lowest_in_s2, "m/s"),
            number(
                "stated model: largest velocity in S1",
                arcs.model.highest_in_s1,
                "m/s",
            ),
            number("least velocity in S2", arcs.model.lowest_in_s2, "m/s"),
        ],
        !arcs.listing.s1_is_upper() && !arcs.model.s1_is_upper(),
    )
}

fn direction_of_oscillation(found: &ZoneOscillates) -> Erratum {
    erratum(
        "Sect. 4.2",
        "the stick zone oscillates along x2",
        "along x1: on the discontinuity zone x2 is always vp",
        vec![
            number(
                "travel of the zone's end in x1 over a period",
                found.travel_x1,
                "m",
            ),
            number("twice the amplitude A", found.twice_amplitude, "m"),
            number("travel in x2", found.travel_x2, "m/s"),
            word(
                "which of them oscillates",
                match (found.travel_x1 > 0.0, found.travel_x2 > 0.0) {
                    (true, true) => "both",
                    (true, false) => "x1",
                    (false, true) => "x2",
                    (false, false) => "neither",
                },
            ),
        ],
        (found.travel_x1 - found.twice_amplitude).abs() < 1e-12 && found.travel_x2 == 0.0,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Followed;

    #[test]
    fn friction_with_the_other_sign_is_what_decides() {
        let found = sign_of_friction().unwrap();
        assert!(found.holds, "{found:?}");
    }

    #[test]
    fn springs_lengths_and_starts_hold() {
        for found in [
            spring_signs().unwrap(),
            lengths_and_durations(&Way::compute(&Followed::compute().unwrap()).unwrap()),
            start_of_fig08(&Start::compute().unwrap()),
        ] {
            assert!(found.holds, "{found:?}");
        }
    }

    #[test]
    fn a_zone_that_moved_in_x2_would_be_no_misprint() {
        let found = ZoneOscillates::compute().unwrap();
        assert!(direction_of_oscillation(&found).holds);
        let other = ZoneOscillates {
            travel_x2: 0.1,
            ..found
        };
        assert!(!direction_of_oscillation(&other).holds);
    }
}
