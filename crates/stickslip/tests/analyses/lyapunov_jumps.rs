//! Spectra of systems whose jumps set several states to constants.

use stickslip::analysis::{Exponent, Spectrum, SpectrumOptions, lyapunov_spectrum};
use stickslip::{Error, Options, math};
use stickslip_model::file::{Interface, Source, System, SystemFile};

pub fn system(text: &str) -> System {
    let source = Source {
        name: "system.toml".to_owned(),
        text: text.to_owned(),
    };
    SystemFile::parse(source).unwrap().with(&[]).unwrap()
}

/// The spectrum over 20 units of time, after a check that its first exponent is the largest one
/// measured alone.
fn spectrum(text: &str, start: &[f64], transient: f64) -> Spectrum {
    let system = system(text);
    let settings = SpectrumOptions::over(transient, 20.0).solver(Options::tol(1e-12));
    let found = lyapunov_spectrum(system.dynamics(), (0.0, start), &settings).unwrap();
    let alone = Exponent::largest(system.dynamics(), (0.0, start), &settings).unwrap();
    assert!(
        alone == found.exponents[0] || (alone.value() - found.exponents[0].value()).abs() < 1e-12,
        "{alone:?} {found:?}"
    );
    assert!(found.defect().abs() < 1e-11, "{found:?}");
    found
}

/// All directions across the flow are lost at the jump, and the flow's own is neutral.
#[test]
fn a_jump_that_sets_all_states_leaves_the_direction_of_the_flow() {
    for (states, fields, set, start) in [
        ("y = \"\"", "y = \"-y + s\"", "y = \"2\"", vec![0.0, 1.0]),
        (
            "y = \"\"\nz = \"\"",
            "y = \"z + s\"\nz = \"-y\"",
            "y = \"2\", z = \"1\"",
            vec![0.0, 1.0, 0.5],
        ),
    ] {
        let text = format!(
            "name = \"sawtooth\"\n[states]\ns = \"\"\n{states}\n[field]\ns = \"1\"\n{fields}\n\
             [jumps.back]\nwhen = \"s - 1\"\ndirection = \"rising\"\nset = {{ s = \"0\", {set} }}\n"
        );
        let found = spectrum(&text, &start, 80.5);
        assert!(found.exponents[0].value().abs() < 1e-12, "{found:?}");
        assert_eq!(found.annihilated(), start.len() - 1, "{found:?}");
    }
}

/// A map may shrink so strongly that its determinant is rounding, and annihilate nothing.
#[test]
fn a_jump_that_shrinks_strongly_annihilates_nothing() {
    let text = "name = \"shrinks\"\n[states]\ns = \"\"\np = \"\"\nq = \"\"\n[field]\ns = \"1\"\n\
                p = \"0\"\nq = \"0\"\n[jumps.back]\nwhen = \"s - 1\"\ndirection = \"rising\"\n\
                set = { s = \"0\", p = \"1e-7*p\", q = \"1e-8*q\" }\n";
    let found = spectrum(text, &[0.0, 0.3, 0.2], 80.5);
    for (exponent, factor) in found.exponents.iter().zip([1.0, 1e-7, 1e-8]) {
        assert!(
            (exponent.value() - math::ln(factor)).abs() < 1e-8,
            "{found:?}"
        );
    }
}

/// The saltation matrix is zero, as the field is zero after the jump.
#[test]
fn a_jump_into_an_equilibrium_annihilates_all_directions() {
    let text = "name = \"fall\"\n[states]\nx = \"\"\ny = \"\"\n[field]\nx = \"x\"\ny = \"-2*y\"\n\
                [jumps.end]\nwhen = \"x - 1\"\ndirection = \"rising\"\n\
                set = { x = \"0\", y = \"0\" }\n";
    let found = spectrum(text, &[0.1, 1.0], 0.0);
    assert_eq!(found.exponents, [Exponent::Annihilated; 2]);
    assert_eq!(found.collapses, 2);
    // If that happens during the transient, the exponents are those of the equilibrium.
    let found = spectrum(text, &[0.1, 1.0], 5.0);
    let values: Vec<f64> = found.exponents.iter().map(Exponent::value).collect();
    assert!(
        (values[0] - 1.0).abs() < 1e-11 && (values[1] + 2.0).abs() < 1e-11,
        "{values:?}"
    );
}

/// Of four directions the jump keeps the flow's and one that it halves in every unit of time.
#[test]
fn a_jump_that_sets_two_states_annihilates_two_directions() {
    let text = "name = \"two\"\n[states]\ns = \"\"\nx = \"\"\ny = \"\"\nz = \"\"\n[field]\n\
                s = \"1\"\nx = \"y\"\ny = \"-x\"\nz = \"0.3*z\"\n\
                [jumps.back]\nwhen = \"s - 1\"\ndirection = \"rising\"\n\
                set = { s = \"0\", x = \"0\", y = \"1\", z = \"0.5*z\" }\n";
    let found = spectrum(text, &[0.0, 0.3, 0.2, 1.0], 80.5);
    let values: Vec<f64> = found.exponents.iter().map(Exponent::value).collect();
    let exact = 0.3 - math::ln(2.0);
    assert!(
        values[0].abs() < 1e-12 && (values[1] - exact).abs() < 1e-9,
        "{values:?}"
    );
    assert_eq!(found.annihilated(), 2, "{found:?}");
}

/// An orbit that a jump stops is measured up to the stop, and without time before it not at all.
#[test]
fn an_orbit_that_a_jump_stops_is_measured_up_to_the_stop() {
    let text = "name = \"stops\"\n[states]\ns = \"\"\nx = \"\"\n[field]\ns = \"1\"\nx = \"-x\"\n\
                [jumps.off]\nwhen = \"s - 5\"\ndirection = \"rising\"\nstop = true\n";
    let system = system(text);
    // The stop comes in the transient, in the measured time, and after two of its blocks.
    for (transient, duration) in [(20.0, 100.0), (1.0, 100.0), (0.0, 10.0)] {
        let settings = SpectrumOptions::over(transient, duration);
        let found = |s: f64| {
            let start = [s, 1.0];
            lyapunov_spectrum(system.dynamics(), (0.0, &start[..]), &settings)
        };
        let spectrum = found(0.0).unwrap();
        let Some(Error::Stopped { t, .. }) = spectrum.ended else {
            panic!("{spectrum:?}");
        };
        assert!((t - 5.0).abs() < 1e-9, "{t}");
        assert!(spectrum.duration > 2.0, "{spectrum:?}");
        for (exponent, exact) in spectrum.exponents.iter().zip([0.0, -1.0]) {
            assert!((exponent.value() - exact).abs() < 0.01, "{spectrum:?}");
            assert!(exponent.std_error().unwrap() < 0.01, "{spectrum:?}");
        }
        let refused = found(5.0);
        assert!(
            matches!(refused, Err(Error::Stopped { t: 0.0, .. })),
            "{refused:?}"
        );
        let largest = Exponent::largest(system.dynamics(), (0.0, [0.0, 1.0]), &settings);
        assert!(matches!(largest, Err(Error::Stopped { .. })), "{largest:?}");
    }
}

#[test]
fn a_jump_that_another_one_sets_off_is_named_where_the_field_changes_at_it() {
    let text = "name = \"chain\"\n[states]\ns = \"\"\nx = \"\"\n[field]\ns = \"1\"\nx = \"-x\"\n\
                [jumps.tick]\nwhen = \"s - 1\"\ndirection = \"rising\"\n\
                set = { s = \"0\", x = \"x + 1\" }\n\
                [jumps.drop]\nwhen = \"x - 1.5\"\ndirection = \"rising\"\nset = { x = \"0.1\" }\n";
    let system = system(text);
    let settings = SpectrumOptions::over(0.0, 20.0);
    let spectrum = lyapunov_spectrum(system.dynamics(), (0.0, &[0.0, 1.0][..]), &settings);
    let error = spectrum.unwrap().ended.unwrap();
    assert!(
        matches!(error, Error::ChainedJumps { jump: 1, .. }),
        "{error}"
    );
    let words = Rust.words(&error, Some(&system));
    assert!(
        words.starts_with("the jump `drop` follows another one"),
        "{words}"
    );
}

/// Options by their names in Rust.
struct Rust;

impl Interface for Rust {
    fn name(&self, option: &str) -> String {
        option.to_owned()
    }
    fn choice(&self, option: &str, _words: &[&str]) -> String {
        option.to_owned()
    }
    fn value(&self, option: &str, value: f64) -> String {
        format!("{option} = {value}")
    }
    fn nearer(&self) -> &'static str {
        ""
    }
}
