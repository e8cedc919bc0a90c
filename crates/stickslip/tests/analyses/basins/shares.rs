//! Shares of basins along a parameter.

use std::ops::ControlFlow;

use stickslip::analysis::{AttractorKind, RecurrenceSettings, SharesAt};
use stickslip::{Options, math};

use super::system;

/// Shares along values of p, of the starts in the middles of so many cells from -2 to 2.
fn along(rate: &str, values: &[f64], cells: usize, low: f64, high: f64) -> Vec<SharesAt> {
    let (settings, options) = (
        RecurrenceSettings::within(500.0),
        Options::tol(1e-10).escape(1e6),
    );
    let start = |k: usize| [low + (high - low) * (k as f64 + 0.5) / cells as f64];
    let mut found: Vec<SharesAt> = Vec::new();
    let mut earlier = None;
    for &value in values {
        let here = system(&[("x", rate)], value);
        let before = earlier
            .as_ref()
            .map(|system: &stickslip_model::file::System| {
                (system.dynamics(), found.last().unwrap())
            });
        let next = SharesAt::of(
            here.dynamics(),
            value,
            (0..cells).map(start),
            before,
            (&settings, &options),
            || ControlFlow::Continue(()),
        );
        found.push(next.unwrap().unwrap());
        earlier = Some(here);
    }
    found
}

/// Share of a band, if it is there.
fn share(at: &SharesAt, band: usize) -> Option<f64> {
    let number = at.bands.iter().position(|one| *one == band)?;
    Some(at.share(number).part)
}

/// Equilibria at -1 and 1 with the boundary at p: of starts from -2 to 2, (p + 2)/4 go to -1.
#[test]
fn shares_move_with_the_boundary_between_two_attractors() {
    let values: Vec<f64> = (0..9).map(|k| -0.8 + 0.2 * f64::from(k)).collect();
    let found = along("-(x + 1)*(x - p)*(x - 1)", &values, 1000, -2.0, 2.0);
    for at in &found {
        assert_eq!(at.bands, [0, 1]);
        let wanted = 0.25 * (at.parameter + 2.0);
        assert!((share(at, 0).unwrap() - wanted).abs() < 1.1e-3, "{at:?}");
        let error = at.share(0).std_error;
        assert!((error - (wanted * (1.0 - wanted) / 1000.0).sqrt()).abs() < 1e-4);
    }
}

/// x' = p + x - x³ has a fold at p = ±2/√27: the lower equilibrium ends at the upper one of them,
/// the upper one begins at the lower one.
#[test]
fn attractors_that_end_and_begin_have_bands_of_their_own() {
    let values: Vec<f64> = (0..21).map(|k| -1.0 + 0.1 * f64::from(k)).collect();
    let found = along("p + x - x^3", &values, 400, -2.0, 2.0);
    let fold = 2.0 / 27f64.sqrt();
    for at in &found {
        let p = at.parameter;
        let is_there = [p < fold, p > -fold];
        for (band, is_there) in is_there.into_iter().enumerate() {
            assert_eq!(share(at, band).is_some(), is_there, "{p}: {:?}", at.bands);
        }
        if is_there == [true, true] {
            // The middle root, by Viète's trigonometric form.
            let angle = math::acos(1.5 * 3f64.sqrt() * p) / 3.0;
            let middle = 2.0 / 3f64.sqrt() * math::cos(angle - std::f64::consts::TAU / 3.0);
            let wanted = 0.25 * (middle + 2.0);
            assert!(
                (share(at, 0).unwrap() - wanted).abs() < 3e-3,
                "{p}: {middle} {at:?}"
            );
        }
    }
    assert_eq!(found.last().unwrap().known_bands, 2);
    // All starts lead to the upper one as soon as it is there. The lower one is still followed.
    let found = along("p + x - x^3", &[-0.5, 0.0, 0.3, 0.5], 10, 1.0, 2.0);
    let bands: Vec<&[usize]> = found.iter().map(|at| at.bands.as_slice()).collect();
    assert_eq!(bands, [&[0][..], &[1, 0], &[1, 0], &[1]]);
    assert_eq!(found[1].starts, [10, 0]);
}

/// x' = √(x² + 1) - p escapes beyond its upper equilibrium √(p² - 1), and from everywhere for
/// p < 1.
#[test]
fn escape_has_a_band_and_is_no_attractor() {
    let found = along("sqrt(x^2 + 1) - p", &[2.0, 1.5, 0.5], 400, -2.0, 2.0);
    for at in &found {
        let mut kinds = at.attractors.iter();
        let escapes = kinds.position(|one| one.kind == AttractorKind::Escape);
        let escapes = escapes.unwrap();
        let wanted = match at.parameter {
            p if p > 1.0 => 0.25 * (2.0 - (p * p - 1.0).sqrt()),
            _ => 1.0,
        };
        assert!((at.share(escapes).part - wanted).abs() < 3e-3, "{at:?}");
        assert_eq!(at.bands[escapes], 1);
    }
}

/// r' = -r (s - p - 1/2)(s - p - 1) for s = r² has an unstable cycle at s = p + 1/2 and a stable
/// one at p + 1. The stable one at p = 0 lies inside the unstable one at p = 1, and an orbit leads
/// from there to the focus. Only the way back connects the two stable ones.
#[test]
fn a_cycle_keeps_its_band_where_only_the_way_back_leads_to_it() {
    let (settings, options) = (RecurrenceSettings::within(3000.0), Options::tol(1e-9));
    let part = "0.2*(x^2 + y^2 - p - 0.5)*(x^2 + y^2 - p - 1)";
    let (x, y) = (format!("-x*{part} - y"), format!("-y*{part} + x"));
    let here = |p: f64| system(&[("x", &x), ("y", &y)], p);
    let starts = [[0.0, 0.05], [0.0, 3.0]];
    let go_on = || ControlFlow::Continue(());
    let how = (&settings, &options);
    let (one, other) = (here(0.0), here(1.0));
    type Before<'a> = Option<(&'a stickslip::dynamics::DynamicsRef<'a>, &'a SharesAt)>;
    let none: Before<'_> = None;
    let first = SharesAt::of(one.dynamics(), 0.0, starts, none, how, go_on)
        .unwrap()
        .unwrap();
    let before: Before<'_> = Some((one.dynamics(), &first));
    let next = SharesAt::of(other.dynamics(), 1.0, starts, before, how, go_on)
        .unwrap()
        .unwrap();
    assert_eq!(
        (&first.bands, &next.bands),
        (&vec![0, 1], &vec![0, 1]),
        "{first:?} {next:?}"
    );
}
