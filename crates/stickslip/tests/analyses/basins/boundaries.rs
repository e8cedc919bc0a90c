//! Entropy and dimension of boundaries that are known.

use std::f64::consts::{LN_2, PI};

use numerics::SplitMix;
use stickslip::analysis::{
    Attractors, BasinEntropy, RecurrenceSettings, UncertaintyExponent, attractor, basin,
};
use stickslip::{Error, Options, math};

use super::{WELLS, system};

/// Entropy of two parts.
fn entropy(p: f64) -> f64 {
    -p * math::ln(p) - (1.0 - p) * math::ln(1.0 - p)
}

/// A straight boundary cuts boxes at any place. The mean over all places is 1/2 in the limit of
/// small cells; with 20 cells along a side, it is a sum.
#[test]
fn the_boundary_entropy_of_straight_boundaries_is_a_half() {
    let side = 20;
    let mean = (1..side).map(|k| entropy(f64::from(k) / 20.0)).sum::<f64>() / 19.0;
    assert!((mean - 0.5).abs() < 0.03);
    let (mut errors, mut squares, mut values) = (0.0, 0.0, 0.0);
    let random = &mut SplitMix::new(5);
    for _ in 0..40 {
        // Stripes of irrational width, in columns of 400.
        let first = 40.0 * random.uniform();
        let stripe = |x: usize| ((x as f64 - first) / (23.0 * 2f64.sqrt())).floor() as i64 & 1;
        let reached: Vec<usize> = (0..400 * 40).map(|k| stripe(k % 400) as usize).collect();
        let found = BasinEntropy::of(&reached, &[40, 400], 20).unwrap();
        assert_eq!(found.boxes, 40);
        let (value, error) = (
            found.boundary_entropy.unwrap(),
            found.boundary_entropy_error.unwrap(),
        );
        assert!((value - mean).abs() < 4.0 * error, "{found:?}");
        assert!(!found.shows_fractal());
        values += value / 40.0;
        errors += error / 40.0;
        squares += (value - mean) * (value - mean) / 40.0;
    }
    assert!((values - mean).abs() < 0.01, "{values} {mean}");
    let ratio = errors / squares.sqrt();
    assert!((0.7..1.5).contains(&ratio), "{ratio}");
}

/// Starts that lead anywhere with the same probability: the entropy of each box is ln 3, less
/// 2/(2 n) from counting n starts (Miller, 1955).
#[test]
fn intermingled_basins_have_the_largest_entropy_and_the_exponent_zero() {
    let random = &mut SplitMix::new(11);
    let reached: Vec<usize> = (0..256 * 256)
        .map(|_| (3.0 * random.uniform()) as usize)
        .collect();
    let found = BasinEntropy::of(&reached, &[256, 256], 16).unwrap();
    assert_eq!(found.boundary_boxes, 256);
    assert_eq!(found.boundary_entropy, Some(found.entropy));
    let expected = math::ln(3.0) - 1.0 / 256.0;
    let off = (found.entropy - expected).abs();
    assert!(off < 4.0 * found.entropy_error, "{found:?}");
    assert!(found.entropy_error < 1e-3 && found.shows_fractal());
    let found = UncertaintyExponent::of(&reached, &[256, 256]).unwrap();
    let found = found.unwrap();
    assert!(found.exponent.abs() < 3.0 * found.std_error, "{found:?}");
    assert!(found.std_error < 0.01, "{found:?}");
}

#[test]
fn smooth_boundaries_have_the_dimension_of_a_curve() {
    // A disc.
    let reached: Vec<usize> = (0..400 * 400)
        .map(|k| {
            let (x, y) = ((k % 400) as f64 - 180.3, (k / 400) as f64 - 210.7);
            usize::from(x * x + y * y < 100.0 * 100.0)
        })
        .collect();
    let found = UncertaintyExponent::of(&reached, &[400, 400])
        .unwrap()
        .unwrap();
    assert!(
        (found.dimension - 1.0).abs() < 2.0 * found.std_error,
        "{found:?}"
    );
    assert!(found.std_error < 0.03, "{found:?}");
    // The equilibria of a system, with the boundary x = y²/3.
    let system = system(&WELLS, 0.0);
    let place = |k: usize| -2.0 + 4.0 * (k as f64 + 0.5) / 64.0;
    let starts = (0..64 * 64).map(|k| [place(k % 64), place(k / 64)]);
    let (settings, options) = (RecurrenceSettings::within(200.0), Options::tol(1e-9));
    let found = basin(system.dynamics(), starts, &settings, &options).unwrap();
    let known = (0..64 * 64).map(|k| 3.0 * place(k % 64) > place(k / 64) * place(k / 64));
    assert!(known.map(usize::from).eq(found.reached.iter().copied()));
    let exponent = UncertaintyExponent::of(&found.reached, &[64, 64]).unwrap();
    let exponent = exponent.unwrap();
    assert!((exponent.exponent - 1.0).abs() < 0.05, "{exponent:?}");
}

/// The side to which a start leaves the middle third: x is tripled once in a unit of time, and its
/// fraction kept, until it lies in (1/3, 2/3). The boundary is Cantor's set with the middles of
/// its gaps.
fn side(mut x: f64) -> usize {
    while !(1.0 / 3.0..2.0 / 3.0).contains(&x) {
        x = 3.0 * x - (3.0 * x).floor();
    }
    usize::from(x > 0.5)
}

#[test]
fn cantor_s_set_has_its_dimension() {
    // No number of points is a multiple of 3, so that no gap is a number of steps.
    let line = |points: usize| -> Vec<usize> {
        let place = |k: usize| (k as f64 + 0.5) / points as f64;
        (0..points).map(|k| side(place(k))).collect()
    };
    let exponent = 1.0 - LN_2 / math::ln(3.0);
    let found = UncertaintyExponent::of(&line(20_000), &[20_000])
        .unwrap()
        .unwrap();
    assert!(
        (found.exponent - exponent).abs() < 2.0 * found.std_error,
        "{found:?}"
    );
    assert!(found.std_error < 0.05, "{found:?}");
    assert!((found.dimension + found.exponent - 1.0).abs() < 1e-15);
    // In the plane, with all y: the dimension is one more.
    let row = line(1000);
    let plane: Vec<usize> = (0..1000).flat_map(|_| row.iter().copied()).collect();
    let found = UncertaintyExponent::of(&plane, &[1000, 1000])
        .unwrap()
        .unwrap();
    assert!(
        (found.dimension - 2.0 + exponent).abs() < 2.0 * found.std_error,
        "{found:?}"
    );
    assert!(found.std_error < 0.1, "{found:?}");
}

/// The same by a system: a clock triples x until it lies in the middle third, where it is set to
/// the middle of one half.
#[test]
fn cantor_s_set_bounds_the_basins_of_a_system() {
    let text = "name = \"thirds\"\n[states]\nx = \"\"\nc = \"\"\n[field]\nx = \"0\"\nc = \"1\"\n\
                [jumps.clock]\nwhen = \"c - 1\"\ndirection = \"rising\"\n\
                set = { c = \"0\", x = \"if(x < 1/3, 3*x, if(x > 2/3, 3*x - 2, \
                if(x < 1/2, 5/12, 7/12)))\" }\n";
    let system = crate::lyapunov_jumps::system(text);
    let place = |k: usize| (k as f64 + 0.5 + 1e-3 * 2f64.sqrt()) / 729.0;
    let starts = (0..729).map(|k| [place(k), 0.0]);
    let (settings, options) = (RecurrenceSettings::within(300.0), Options::tol(1e-9));
    let found = basin(system.dynamics(), starts, &settings, &options).unwrap();
    assert_eq!(found.attractors.len(), 2);
    let first = side(place(0));
    let known = (0..729).map(|k| usize::from(side(place(k)) != first));
    assert!(known.eq(found.reached.iter().copied()));
}

#[test]
fn grids_that_do_not_fit_are_refused_with_the_bound() {
    let reached = vec![0; 100];
    for (shape, side) in [
        (vec![10, 10], 3),
        (vec![10, 10], 10),
        (vec![10, 10], 1),
        (vec![9, 10], 5),
    ] {
        let error = BasinEntropy::of(&reached, &shape, side).unwrap_err();
        assert!(matches!(error, Error::Option { .. }), "{error}");
    }
    let error = UncertaintyExponent::of(&reached, &[10, 10]).unwrap_err();
    assert!(error.to_string().contains("64 starts"), "{error}");
    let found = BasinEntropy::of(&reached, &[10, 10], 5).unwrap();
    assert_eq!((found.entropy, found.boundary_entropy), (0.0, None));
    assert_eq!(
        UncertaintyExponent::of(&vec![0; 4096], &[64, 64]).unwrap(),
        None
    );
}

/// Terms of the field cancel near 0. All of an interval is an equilibrium there, to rounding.
#[test]
fn an_equilibrium_where_terms_cancel_is_one_attractor() {
    for (rate, other) in [
        ("-((x + 1) - 1)", "-y"),
        ("-((x + 1e6) - 1e6)", "-((y - 0.3) + 0.3)"),
    ] {
        let system = system(&[("x", rate), ("y", other)], 0.0);
        for options in [
            Options::tol(1e-12),
            Options {
                atol: 1e-280.into(),
                ..Options::tol(1e-9)
            },
        ] {
            let settings = RecurrenceSettings::within(200.0);
            let mut known = Attractors::new(system.dynamics(), &settings, &options);
            for k in 0..40 {
                let start = [0.1 * f64::from(k) - 1.93, 0.4];
                let found = attractor(system.dynamics(), start, &settings, &options).unwrap();
                known.number(found);
            }
            assert_eq!(known.all().len(), 1, "{rate}: {:?}", known.all()[1].points);
        }
    }
    // Equilibria that the field resolves are two.
    let text = "-1e24*(x - 1e-12)*x*(x + 1e-12)";
    let system = system(&[("x", text)], 0.0);
    let (settings, options) = (RecurrenceSettings::within(200.0), Options::tol(1e-15));
    let starts = [[-2e-12], [2e-12], [-3e-13], [3e-13]];
    let found = basin(system.dynamics(), starts, &settings, &options).unwrap();
    assert_eq!(found.reached, [0, 1, 0, 1]);
}

/// A pendulum that has turned over many times hangs at another angle, however many: a step of the
/// way from well to well leads through others.
#[test]
fn wells_far_apart_are_distinct() {
    let system = system(&[("x", "v"), ("v", "-sin(x) - 0.5*v")], 0.0);
    let (settings, options) = (RecurrenceSettings::within(200.0), Options::tol(1e-12));
    let wells = [0.0, 1.0, 20.0, 64.0, 128.0, 1e4];
    let starts = wells.map(|turns| [2.0 * PI * turns + 0.1, 0.0]);
    let found = basin(system.dynamics(), starts, &settings, &options).unwrap();
    assert_eq!(found.reached, [0, 1, 2, 3, 4, 5]);
}
