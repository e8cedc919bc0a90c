//! Shared parts of the figures of several commands.

use std::cmp::Reverse;

use plot::*;
use stickslip_model::file::System;

/// Colour of starts that lead to no attractor, by the word for their outcome. It differs from the
/// colours of attractors.
fn colour_of_none(word: &str) -> Color {
    match word {
        "escape" => LIGHT_GREY,
        "undecided" => MID_GREY,
        "failure" => BLACK,
        // Runs that end where the future is not unique.
        _ => LIGHT_ORANGE,
    }
}

/// Colours of kinds of attractors, by decreasing size.
const BY_SIZE: [Color; 6] = [BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION];

/// An entry of a legend, and the indices of the kinds that it covers.
pub(super) struct Class {
    pub(super) kinds: Vec<usize>,
    pub(super) colour: Color,
    pub(super) legend: String,
}

/// Groups kinds of attractors into entries of a legend: the largest first, the smallest together.
/// Outcomes that are no attractor follow separately. `size` is the size of a kind, `none` the word
/// for an outcome that is no attractor.
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
    // A stable sort keeps kinds of equal size in the order of their indices.
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

/// Greek letters by name.
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

/// Escapes markup, and replaces hyphens by minus signs.
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

/// A name as a mathematical symbol: italic, with Greek letters for their names. Digits and what
/// follows `_` are subscripts.
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
    // A unit is a product of powers. Only these of its characters could be read as markup.
    let unit = unit.replace('\\', "").replace('*', "·").replace('_', "\\_");
    format!("{symbol}, {unit}")
}

/// Label of the time axis, with its unit.
pub(super) fn time_label(system: &System) -> String {
    with_unit("t", system.file.time.unit.as_deref().unwrap_or_default())
}

/// Label of a parameter, with its unit.
pub(super) fn parameter_label(system: &System, name: &str) -> String {
    let mut parameters = system.file.parameters.iter();
    let known = parameters.find(|parameter| parameter.name == name);
    with_unit(name, known.map_or("", |parameter| &parameter.unit))
}

/// The parameter axis of stacked panels. Only the last panel has its label and numbers.
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

/// Label of a quantity measured in a power of the unit of time.
pub(super) fn in_time(system: &System, words: &str, power: &str) -> String {
    match system.file.time.unit.as_deref().unwrap_or_default() {
        "" => words.to_owned(),
        unit => format!("{words}, {unit}{power}"),
    }
}

/// An axis that covers the values, with a margin at both ends.
pub(super) fn axis(label: &str, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = extremes(values);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    // Values that differ only by rounding count as equal.
    let least = 1e-9 * low.abs().max(high.abs()).max(1e-6);
    let room = if high - low > least {
        0.05 * (high - low)
    } else {
        0.5 * low.abs().max(1.0)
    };
    Axis::new(label, low - room, high + room)
}

/// Minimum and maximum of the finite values; (∞, −∞) if there are none.
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
