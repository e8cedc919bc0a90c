//! What the figures of several commands have in common.

use std::cmp::Reverse;

use plot::*;
use stickslip_kernels::file::System;

/// The colour of starts that lead to no attractor, by the word for what they do: none of those of
/// attractors.
fn colour_of_none(word: &str) -> Color {
    match word {
        "escape" => LIGHT_GREY,
        "undecided" => MID_GREY,
        "failure" => BLACK,
        // Ends where there is no unique future.
        _ => LIGHT_ORANGE,
    }
}

/// Colours of kinds of attractors, in the order of their sizes.
const BY_SIZE: [Color; 6] = [BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION];

/// One entry of a legend, and the numbers of the kinds that it is for.
pub(super) struct Class {
    pub(super) kinds: Vec<usize>,
    pub(super) colour: Color,
    pub(super) legend: String,
}

/// Kinds of attractors as entries of a legend, the largest first and the smallest together.
/// Outcomes that are no attractor follow, each by itself.
/// `size` is that of an attractor, `none` the word for what is none.
pub(super) fn by_size<T>(
    all: &[T],
    size: impl Fn(&T) -> usize,
    none: impl Fn(&T) -> Option<&str>,
    legend: impl Fn(&T) -> String,
    together: impl Fn(&[usize]) -> String,
) -> Vec<Class> {
    let class = |kind: usize, colour: Color| Class {
        kinds: vec![kind],
        colour,
        legend: legend(&all[kind]),
    };
    let mut order: Vec<usize> = (0..all.len()).collect();
    // A stable sort: equal ones stay in the order of their numbers.
    order.sort_by_key(|&kind| Reverse(size(&all[kind])));
    let (attractors, others): (Vec<usize>, Vec<usize>) = order
        .into_iter()
        .partition(|&kind| none(&all[kind]).is_none());
    let (shown, rest) = attractors.split_at(attractors.len().min(BY_SIZE.len()));
    let shown = shown.iter().zip(BY_SIZE);
    let mut classes: Vec<Class> = shown.map(|(&kind, colour)| class(kind, colour)).collect();
    match *rest {
        [] => {}
        [one] => classes.push(class(one, GREY)),
        _ => classes.push(Class {
            kinds: rest.to_vec(),
            colour: GREY,
            legend: together(rest),
        }),
    }
    classes.extend(others.into_iter().map(|kind| {
        let word = none(&all[kind]).unwrap_or_default();
        class(kind, colour_of_none(word))
    }));
    classes
}

/// Names of letters.
const GREEK: [(&str, &str); 21] = [
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("epsilon", "ε"),
    ("zeta", "ζ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("kappa", "κ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("xi", "ξ"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("chi", "χ"),
    ("psi", "ψ"),
    ("omega", "ω"),
];

/// Words of which nothing is mark-up, with minus signs.
pub(super) fn plain(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        if "*_^\\{}".contains(c) {
            escaped.push('\\');
        }
        escaped.push(if c == '-' { '−' } else { c });
    }
    escaped
}

/// A name in mathematics: italic, digits and what follows `_` below the line, Greek letters for
/// their names.
pub(super) fn symbol(name: &str) -> String {
    let (letters, index) = match name.split_once('_') {
        Some((letters, index)) if !letters.is_empty() => (letters, index),
        _ => name.split_at(name.trim_end_matches(|c: char| c.is_ascii_digit()).len()),
    };
    let greek = GREEK.iter().find(|(name, _)| *name == letters);
    let letters = greek.map_or_else(|| plain(letters), |(_, letter)| (*letter).to_owned());
    if index.is_empty() {
        format!("*{letters}*")
    } else {
        format!("*{letters}*_{{{}}}", plain(index))
    }
}

/// A symbol with its unit.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    let symbol = symbol(name);
    if unit.is_empty() || unit == "1" {
        return symbol;
    }
    // A unit is a product of powers; the page has no signs to be read as mark-up in it but these.
    let unit = unit.replace('\\', "").replace('*', "·").replace('_', "\\_");
    format!("{symbol}, {unit}")
}

/// The unit of time.
pub(super) fn time_label(system: &System) -> String {
    with_unit("t", system.file.time.unit.as_deref().unwrap_or_default())
}

/// A parameter, with its unit.
pub(super) fn parameter_label(system: &System, name: &str) -> String {
    let mut parameters = system.file.parameters.iter();
    let known = parameters.find(|parameter| parameter.name == name);
    with_unit(name, known.map_or("", |parameter| &parameter.unit))
}

/// The axis of a parameter under panels above one another; it has label and numbers in the last.
pub(super) fn parameter_axis(
    system: &System,
    name: &str,
    (low, high): (f64, f64),
    is_last: bool,
) -> Axis {
    if is_last {
        Axis::new(&parameter_label(system, name), low, high)
    } else {
        Axis::new("", low, high).bare()
    }
}

/// Words for what is measured in time, with its unit to a power.
pub(super) fn in_time(system: &System, words: &str, power: &str) -> String {
    match system.file.time.unit.as_deref().unwrap_or_default() {
        "" => words.to_owned(),
        unit => format!("{words}, {unit}{power}"),
    }
}

/// An axis for values, with a little room at both ends.
pub(super) fn axis(label: &str, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = extremes(values);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    // What differs by rounding only has one value.
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-6);
    let room = if high - low > least {
        0.05 * (high - low)
    } else {
        0.5 * low.abs().max(1.0)
    };
    Axis::new(label, low - room, high + room)
}

/// The least and the greatest of the values that are finite; infinite, and the greater one first,
/// where there are none.
pub(super) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_letters_are_letters_and_other_names_stay() {
        assert_eq!(symbol("mu0"), "*μ*_{0}");
        assert_eq!(symbol("mu_v"), "*μ*_{v}");
        assert_eq!(symbol("omega"), "*ω*");
        assert_eq!(symbol("mus"), "*mus*");
        assert_eq!(symbol("x1"), "*x*_{1}");
    }
}
