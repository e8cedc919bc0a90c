//! What a known divergence says of a spectrum, in words.

use serde_json::{Value, json};

use super::report::short;
use stickslip::analysis::data_spectrum::{Balance, DataSpectrum};

/// For the table.
pub(super) fn line(spectrum: &DataSpectrum, divergence: f64, balance: &Balance) -> String {
    let (sum, stderr) = spectrum.sum;
    match *balance {
        Balance::Whole { agrees, .. } => format!(
            "The exponents add up to {} ± {}, {} the divergence {}.\n",
            short(sum),
            short(stderr),
            if agrees { "as does" } else { "unlike" },
            short(divergence)
        ),
        Balance::Rest {
            exponents,
            sum,
            stderr,
        } => format!(
            "With the divergence {} the {} that the data do not tell must {} {} ± {}.\n",
            short(divergence),
            if exponents == 1 {
                "exponent".to_owned()
            } else {
                format!("{exponents} exponents")
            },
            if exponents == 1 { "be" } else { "add up to" },
            short(sum),
            short(stderr)
        ),
        Balance::Unknown => {
            "The exponents have no sum to hold against the divergence.\n".to_owned()
        }
    }
}

/// If the two differ.
pub(super) fn warning(
    spectrum: &DataSpectrum,
    divergence: f64,
    balance: &Balance,
) -> Option<String> {
    match *balance {
        Balance::Whole {
            excess,
            stderr,
            agrees: false,
        } => Some(format!(
            "the exponents add up to {}, which is {} ± {} from the divergence {}: the columns are not the state, --dt is not the time \
             between two lines, or one of the exponents is off: try more points or a smaller --step",
            short(spectrum.sum.0),
            short(excess),
            short(stderr),
            short(divergence)
        )),
        _ => None,
    }
}

/// For JSON.
pub(super) fn value(balance: &Balance) -> Value {
    match *balance {
        Balance::Whole {
            excess,
            stderr,
            agrees,
        } => json!({ "excess": excess, "stderr": stderr, "agrees": agrees }),
        Balance::Rest {
            exponents,
            sum,
            stderr,
        } => json!({ "others": exponents, "sum_of_others": sum, "stderr": stderr }),
        Balance::Unknown => Value::Null,
    }
}
