//! What was asked for and changes nothing.

use super::Arguments;
use super::findings::Findings;
use stickslip::analysis::data_spectrum::Neighbourhood;

/// A note for each option without effect, with what would have one.
pub(super) fn without_effect(arguments: &Arguments, findings: &Findings) -> Vec<String> {
    let notes = [
        radius(arguments, findings),
        degree(arguments, findings),
        ridge(arguments, findings),
        delay(arguments, findings),
        affine(arguments, findings),
        divergence(arguments, findings),
        references(arguments, findings),
    ];
    notes.into_iter().flatten().collect()
}

/// What is extrapolated comes from so many nearest points, and of Eq. (25) a ball of as few as many neighbours, too.
fn radius(arguments: &Arguments, findings: &Findings) -> Option<String> {
    arguments.eps?;
    let spectrum = &findings.spectrum;
    let Neighbourhood::Ball { min, max, .. } = spectrum.settings.neighbours else {
        return None;
    };
    let range = format!(
        "a range such as --neighbours {min}-{}",
        max.saturating_mul(2)
    );
    // With a range it decides how many of them there are, and where chains begin.
    (min == max).then(|| match spectrum.sizes {
        Some(_) => format!(
            "--eps changes no extrapolated exponent, which comes from nearest points, however far; it only says which points are called starved: \
             give other --neighbours than {min}, or --estimator sano-sawada with {range}"
        ),
        None => format!(
            "--eps changes no neighbour where the fewest and the most are both {min}; it only says which points are called starved: \
             give {range}"
        ),
    })
}

fn degree(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let is_idle = arguments.degree.is_some() && findings.spectrum.sizes.is_none();
    is_idle.then(|| {
        "--degree changes nothing where nothing is extrapolated: the maps of Eqs. (25) and (26) are linear".to_owned()
    })
}

fn ridge(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let is_idle = arguments.ridge > 0.0 && findings.spectrum.sizes.is_some();
    is_idle.then(|| {
        "--ridge changes no extrapolated exponent, only the fits of Eq. (25) beside it: give --estimator sano-sawada, or leave it out".to_owned()
    })
}

/// Nothing is delayed by it.
fn delay(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let delay = arguments.delay.filter(|_| findings.embedded.is_none())?;
    Some(if arguments.dimension == Some(1) {
        format!(
            "--delay {delay} changes nothing with --dimension 1, which takes the columns as they are: give --dimension 2 or more, or \
             leave it out"
        )
    } else {
        format!(
            "--delay {delay} changes nothing, as less than 1 % of the nearest neighbours are false without delayed values: give --dimension 2 or \
             more, or leave it out"
        )
    })
}

fn affine(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let is_idle = arguments.affine && findings.embedded.is_some();
    is_idle.then(|| {
        "--affine changes nothing with delayed values, whose maps are affine anyway".to_owned()
    })
}

fn divergence(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let is_idle = arguments.divergence.is_some() && findings.embedded.is_some();
    is_idle.then(|| {
        "--divergence changes nothing with delayed values, some of whose exponents may be none of the system's".to_owned()
    })
}

fn references(arguments: &Arguments, findings: &Findings) -> Option<String> {
    let there = findings.spectrum.references;
    let asked = arguments.references.filter(|&asked| asked > there)?;
    Some(format!(
        "--references {asked} changes nothing: there are {there}, and all are used"
    ))
}
