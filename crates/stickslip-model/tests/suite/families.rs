//! Periodic orbits that are not isolated: attractors, branches and exponents.

use stickslip::Options;
use stickslip::analysis::{Spectrum, SpectrumOptions, basin, lyapunov_spectrum};
use stickslip_model::study::recurrence;

use crate::run::{branch, options, system};

/// Without damping every swing has its own period: a family over the energy.
const PENDULUM: &str = include_str!("../data/pendulum.toml");

/// A block on a floor that shakes: its position does not matter.
const FLOOR: &str = r#"
name = "block on a shaken floor"
[time]
end = 40
period = "1"
[states]
x = "m"
v = "m/s"
[contacts.floor]
boundary = "v"
friction = "2"
[field]
x = "v"
v = "4*pi^2*sin(2*pi*t) - friction(floor)"
[start]
x = 0
v = 10
"#;

#[test]
fn orbits_of_a_family_are_one_attractor_with_its_dimension() {
    let grid = |[x, width]: [f64; 2], [v, height]: [f64; 2]| -> Vec<[f64; 2]> {
        let place = |k: usize| [(k % 4) as f64 + 0.5, (k / 4) as f64 + 0.5];
        let start = |[column, row]: [f64; 2]| [x + width * column / 4.0, v + height * row / 3.0];
        (0..12).map(|k| start(place(k))).collect()
    };
    let options = Options {
        most_events: 200_000,
        ..Options::tol(1e-10)
    };
    for (text, starts) in [
        (PENDULUM, grid([0.5, 2.0], [-0.5, 1.0])),
        (FLOOR, grid([-2.0, 4.0], [-2.0, 4.0])),
    ] {
        let system = system(text);
        let settings = recurrence(&system, 2000.0);
        let found = basin(system.dynamics(), starts, &settings, &options.escape(1e6)).unwrap();
        let [attractor] = &found.attractors[..] else {
            panic!("{:?}", found.attractors);
        };
        assert_eq!((found.share(0).starts, attractor.family), (12, Some(1)));
    }
}

/// For each value the nearest orbit is continued to the ends of the range, without special points.
#[test]
fn a_family_is_followed_along_a_parameter() {
    let pendulum = system(PENDULUM);
    let found = branch(&pendulum, ("g", 0.5, 2.0), &options("taylor"));
    assert_eq!(found.ends().map(|end| end.word), ["range", "range"]);
    assert!(found.special.is_empty(), "{:?}", found.special);
}

fn spectrum(text: &str, start: &[f64], settings: SpectrumOptions) -> Spectrum {
    let system = system(text);
    let settings = settings.solver(options("taylor"));
    lyapunov_spectrum(system.dynamics(), (0.0, start), &settings).unwrap()
}

/// Both exponents are zero. Neighbours separate linearly in time, which leaves a logarithm, and
/// blocks whose rates fall one after the other are as uncertain as correlated ones.
#[test]
fn exponents_without_damping_are_zero_to_their_uncertainty() {
    let found = spectrum(PENDULUM, &[2.0, 0.0], SpectrumOptions::default());
    for (exponent, &uncertainty) in found.exponents.iter().zip(&found.uncertainties) {
        let value = exponent.value();
        assert!(value.abs() <= uncertainty && uncertainty < 1e-2, "{value}");
    }
    let first = (found.exponents[0].value(), found.uncertainties[0]);
    assert!(
        (first.0 - 0.0012).abs() < 5e-5 && (first.1 - 6e-3).abs() < 5e-4,
        "{first:?}"
    );
}

/// A block at rest has a zero exponent: its position does not matter.
#[test]
fn the_exponent_of_what_rests_has_an_uncertainty() {
    let still = FLOOR.replace("4*pi^2*sin(2*pi*t)", "0");
    let still = still.replace("period = \"1\"", "");
    let found = spectrum(&still, &[0.0, 0.1], SpectrumOptions::over(200.0, 50.0));
    assert_eq!(found.exponents[0].value(), 0.0);
    assert!(found.exponents[0].std_error().unwrap() < 1e-12);
    assert!(found.uncertainties.iter().all(|one| one.is_finite()));
}
