//! Exponents with their uncertainties: equal ones, and measurements that end early.

use stickslip::analysis::{Exponent, Spectrum, SpectrumOptions, lyapunov_spectrum};
use stickslip::{Error, Options, math};

use crate::lyapunov_jumps::system;

/// Checks that the value of an exponent is within its uncertainty.
fn covers(spectrum: &Spectrum, number: usize, value: f64) {
    let (found, uncertainty) = (
        spectrum.exponents[number].value(),
        spectrum.uncertainties[number],
    );
    assert!(
        (found - value).abs() <= uncertainty,
        "{number}: {found} ± {uncertainty}, not {value}"
    );
}

/// Eight equal decays in a chain, and an oscillator whose sign drives the first of them on request.
fn chain(drive: &str) -> Spectrum {
    let numbers = 1..=8;
    let states: String = numbers.clone().map(|k| format!("x{k} = \"\"\n")).collect();
    let fields = numbers.map(|k| match k {
        1 => format!("x1 = \"-5*x1{drive}\"\n"),
        k => format!("x{k} = \"-5*x{k} + 5*x{}\"\n", k - 1),
    });
    let fields: String = fields.collect();
    let contact = match drive {
        "" => "",
        _ => "[contacts.c]\nboundary = \"q\"\n",
    };
    let text = format!(
        "name = \"chain\"\n[states]\nq = \"\"\np = \"\"\n{states}{contact}\
         [field]\nq = \"p\"\np = \"-q\"\n{fields}"
    );
    let start = [[1.0, 0.0].as_slice(), &[1.0; 8]].concat();
    let settings = SpectrumOptions::over(40.0, 400.0);
    lyapunov_spectrum(system(&text).dynamics(), (0.0, &*start), &settings).unwrap()
}

#[test]
fn exponents_of_a_chain_of_equal_ones_are_as_uncertain_as_rounding_leaves_them() {
    for drive in ["", " + by_side(c, -1, 1)"] {
        let found = chain(drive);
        covers(&found, 0, 0.0);
        covers(&found, 1, 0.0);
        assert!(found.uncertainties[1] < 0.01, "{:?}", found.uncertainties);
        for number in 2..10 {
            covers(&found, number, -5.0);
            let uncertainty = found.uncertainties[number];
            // Seven times ln(30)/400 is 0.06, and the root of rounding times the coupling 0.06. The
            // second frame is disturbed by more, for a chain of all ten states. Along the axes only
            // components are rounded, which a chain keeps apart.
            let most = if drive.is_empty() { 0.2 } else { 1.0 };
            assert!(
                (0.05..most).contains(&uncertainty),
                "{drive}: {uncertainty}"
            );
        }
    }
}

/// A focus on a boundary where fields agree: turns on its two sides last `π` and `2π/√3`, and the
/// orbit shrinks by `exp(-π/√3)` on one of them.
const DECAY: &str = "name = \"decay\"\n[states]\nx = \"\"\ny = \"\"\n\
                     [contacts.c]\nboundary = \"x\"\n\
                     [field]\nx = \"y - by_side(c, 0, x)\"\ny = \"-x\"\n";

#[test]
fn a_decay_to_an_equilibrium_on_the_boundary_is_measured_to_its_end() {
    let system = system(DECAY);
    let rate = -(2.0 - 3f64.sqrt());
    // Its absolute tolerance is reached after a time of 103, and 1e-250 after the whole.
    for tolerance in [1e-12, 1e-9] {
        let settings = SpectrumOptions::over(200.0, 2000.0).solver(Options::tol(tolerance));
        let found = lyapunov_spectrum(system.dynamics(), (0.0, [1.0, 0.0]), &settings).unwrap();
        assert_eq!((&found.ended, found.duration), (&None, 2000.0));
        for number in 0..2 {
            covers(&found, number, rate);
            // Turns that are not whole leave less than a logarithm of 1 in the sum.
            let off = (found.exponents[number].value() - rate).abs();
            assert!(off < 1.0 / 2000.0, "{found:?}");
            assert!(found.uncertainties[number] < 0.01, "{found:?}");
        }
    }
}

#[test]
fn a_decay_to_another_equilibrium_on_the_boundary_is_lost_where_rounding_decides() {
    // The same about (0, 1): states are rounded to 1e-16 there.
    let text = DECAY.replace("\"y - by", "\"y - 1 - by");
    let settings = SpectrumOptions::over(200.0, 2000.0).solver(Options::tol(1e-12));
    let system = system(&text);
    let found = lyapunov_spectrum(system.dynamics(), (0.0, [1.0, 1.0]), &settings).unwrap();
    assert!(
        matches!(found.ended, Some(Error::Shrunk { t, .. }) if (80.0..125.0).contains(&t)),
        "{:?}",
        found.ended
    );
    assert!(found.duration > 40.0, "{}", found.duration);
    covers(&found, 0, -(2.0 - 3f64.sqrt()));
}

#[test]
fn a_measurement_that_ends_early_keeps_what_was_measured() {
    let text =
        "name = \"growth\"\n[states]\nx = \"\"\ny = \"\"\n[field]\nx = \"0.1*x\"\ny = \"-y\"\n";
    let system = system(text);
    let options = Options {
        escape: 1e6,
        ..Options::default()
    };
    let end = 10.0 * math::ln(1e6);
    for (transient, least) in [(20.0, 0.8), (130.0, 0.4), (500.0, 0.4)] {
        let settings = SpectrumOptions::over(transient, 1000.0).solver(options);
        let start = (0.0, [1.0, 1.0]);
        let found = lyapunov_spectrum(system.dynamics(), start, &settings).unwrap();
        assert!(matches!(found.ended, Some(Error::Escaped { .. })));
        assert!((least * end..end).contains(&found.duration), "{found:?}");
        assert!((found.exponents[0].value() - 0.1).abs() < 1e-6, "{found:?}");
        // The largest exponent alone is a number, which could not say so.
        let alone = Exponent::largest(system.dynamics(), start, &settings);
        assert!(matches!(alone, Err(Error::Escaped { .. })));
        assert_ne!(found.exponents[0], Exponent::Annihilated);
    }
}
