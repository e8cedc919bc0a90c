//! Numbers, states and modes in words.

use serde::Serialize;
use serde_json::{Value as Json, json};
use stickslip::dynamics::Modes;
use stickslip::error::readable;
use stickslip::math;
use stickslip_model::file::System;

/// A number that reads back bit for bit.
pub(super) fn exact(value: f64) -> String {
    format!("{value:?}")
}

/// Rounds a number to significant digits.
fn to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// Rounds a number to its significant digits: the rounding is larger than the uncertainty.
pub(crate) fn significant_digits(value: f64, uncertainty: f64) -> f64 {
    const MOST: f64 = 12.0;
    let digits = 1.0 + math::log10(value.abs() / (2.0 * uncertainty)).floor();
    to_digits(value, digits.clamp(1.0, MOST) as usize)
}

/// A number with its uncertainty, without further digits.
pub(crate) fn within(value: f64, uncertainty: f64) -> String {
    const MOST: f64 = 16.0;
    if !(uncertainty > 0.0 && uncertainty.is_finite()) {
        return format!("about {}", readable(to_digits(value, 4)));
    }
    let decimals = (1.0 - math::log10(uncertainty).floor()).max(0.0);
    if decimals > MOST {
        let digits = math::log10(value.abs()).floor() - math::log10(uncertainty).floor();
        let digits = (1.0 + digits).clamp(0.0, MOST) as usize;
        return format!("{value:.digits$e} ± {uncertainty:.0e}");
    }
    let text = format!("{value:.0$}", decimals as usize);
    // Zero after rounding has no sign.
    let is_zero = text
        .bytes()
        .all(|digit| matches!(digit, b'-' | b'0' | b'.'));
    let text = if is_zero {
        text.trim_start_matches('-')
    } else {
        &text
    };
    format!("{text} ± {uncertainty:.0e}")
}

/// A located value, without digits beyond its uncertainty.
pub(crate) fn place(value: f64, uncertainty: f64) -> String {
    if uncertainty <= 1e-12 * value.abs() {
        readable(value)
    } else {
        within(value, uncertainty)
    }
}

/// A complex number, by its parts, with its uncertainty and without further digits.
pub(crate) fn complex_within([re, im]: [f64; 2], uncertainty: f64) -> String {
    // Without an estimate, as a number without one.
    let is_known = uncertainty.is_finite();
    let within = if is_known {
        uncertainty
    } else {
        1e-4 * math::hypot(re, im)
    };
    let [re, size] = [re, im.abs()].map(|part| readable(significant_digits(part, within)));
    let sign = if im < 0.0 { "-" } else { "+" };
    match is_known {
        true => format!("{re} {sign} {size} i ± {uncertainty:.0e}"),
        false => format!("about {re} {sign} {size} i"),
    }
}

/// Number of characters that a line shows at either end of a text that is longer than both. Chosen:
/// some ten rows of a terminal.
const SHOWN_CHARACTERS: usize = 1000;

/// A text with the number of characters left out in the middle, where it has very many.
pub(super) fn shortened(text: String) -> String {
    let count = text.chars().count();
    let left_out = count.saturating_sub(2 * SHOWN_CHARACTERS);
    if left_out == 0 {
        return text;
    }
    let begin: String = text.chars().take(SHOWN_CHARACTERS).collect();
    let end: String = text.chars().skip(count - SHOWN_CHARACTERS).collect();
    format!("{begin} … ({left_out} characters left out) … {end}")
}

/// A state as text, to the digits that hold where a point of an attractor is known to a millionth
/// of a component's size ([`RecurrenceSettings::closeness`]).
///
/// [`RecurrenceSettings::closeness`]: stickslip::analysis::RecurrenceSettings::closeness
pub(crate) fn state_words(x: &[f64]) -> String {
    const DIGITS: usize = 7;
    // Less is rounding of the other components.
    let least = 1e-13 * x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let rounded = |x: f64| {
        if x.abs() <= least {
            0.0
        } else {
            to_digits(x, DIGITS)
        }
    };
    let x: Vec<String> = x.iter().map(|&x| readable(rounded(x))).collect();
    format!("({})", x.join(", "))
}

/// The name of an input.
pub(crate) fn input_name(system: &System, input: usize) -> String {
    system.contact_name(system.contacts() + system.file.jumps.len() + input)
}

/// Values for each state, by name.
pub(crate) fn by_state(system: &System, of_each: &[impl Serialize]) -> Json {
    let states = system.file.states.iter().zip(of_each);
    let map = states.map(|(state, value)| (state.name.clone(), json!(value)));
    Json::Object(map.collect())
}

/// A sequence of phases of an orbit, with the meaning of the letters. `None` for a system without
/// contacts and jumps.
pub(crate) fn explained(system: &System, modes: &[Modes]) -> Option<String> {
    let key = match (system.contacts(), system.file.jumps.len()) {
        (0, 0) => return None,
        (0, _) => "the jumps that end the phases",
        (_, 0) => "- below, + above, S stick",
        _ => "- below, + above, S stick; in brackets the jump that ends the phase",
    };
    Some(format!("{}  ({key})", system.sequence(modes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complex_numbers_without_an_estimate_say_about() {
        let value = [0.123456789, -0.5];
        assert_eq!(complex_within(value, 1e-6), "0.12346 - 0.5 i ± 1e-6");
        assert_eq!(complex_within(value, f64::NAN), "about 0.1235 - 0.5 i");
    }

    #[test]
    fn states_have_the_digits_that_hold_in_any_unit() {
        assert_eq!(state_words(&[0.978136874321, 0.0]), "(0.9781369, 0)");
        assert_eq!(state_words(&[-1.5e-7, 2.25]), "(-1.5e-7, 2.25)");
        assert_eq!(state_words(&[1.0, -3e-17]), "(1, 0)");
    }
}
