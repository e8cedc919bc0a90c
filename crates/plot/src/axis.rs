//! An axis: range, ticks, label.

use super::rich;
use crate::error::PlotError;

/// A linear axis.
#[derive(Clone, Debug)]
pub struct Axis {
    pub(super) label: String,
    pub(super) min: f64,
    pub(super) max: f64,
    ticks: Ticks,
    minor: usize,
    pub(super) numbered: bool,
    /// The value at a place on the axis.
    pub(super) value: fn(f64) -> f64,
}

#[derive(Clone, Debug)]
enum Ticks {
    Step(f64),
    At(Vec<(f64, String)>),
}

impl From<f64> for Ticks {
    fn from(step: f64) -> Self {
        Ticks::Step(step)
    }
}

/// Approximate number of intervals of an axis with automatic ticks.
const AUTO_INTERVALS: f64 = 5.0;

impl Axis {
    /// An axis from `min` to `max` with a label in markup, such as `*x*_1, m`.
    /// Ticks are chosen automatically.
    pub fn new(label: &str, min: f64, max: f64) -> Self {
        Self {
            label: label.to_owned(),
            min,
            max,
            ticks: Ticks::Step(nice_step((max - min) / AUTO_INTERVALS)),
            minor: 1,
            numbered: true,
            value: |place| place,
        }
    }

    /// An axis of decimal logarithms, numbered by powers of ten.
    /// Where it holds fewer than two of them, it is numbered by the logarithms.
    pub fn decades(label: &str, (low, high): (f64, f64)) -> Self {
        /// Most intervals between numbers: more would crowd a panel.
        const MOST: i64 = 8;
        let (first, last) = (low.ceil() as i64, high.floor() as i64);
        if last - first < 1 {
            return Axis::new(&format!("log_{{10}} {label}"), low, high);
        }
        let every = (last - first) / MOST + 1;
        let powers = (first..=last).filter(|power| power % every == 0);
        let powers = powers.map(|power| power as f64);
        let ticks = powers.map(|power| (power, format!("10^{{{}}}", number(power, 0))));
        let axis = Axis::new(label, low, high).ticks(ticks);
        axis.value(crate::math::exp10)
    }

    setters! {
        /// Ticks at multiples of a step.
        step: f64 => ticks;
        /// Number of intervals between two ticks, separated by short ticks; 1 for none.
        minor: usize => minor;
    }

    /// Ticks at the given values, with labels in markup. A tick with an empty label has no number.
    pub fn ticks<S: Into<String>>(mut self, ticks: impl IntoIterator<Item = (f64, S)>) -> Self {
        let ticks = ticks.into_iter().map(|(v, text)| (v, text.into()));
        self.ticks = Ticks::At(ticks.collect());
        self
    }

    /// The value at a place, for an axis that shows a function of it. Exported curves have values.
    pub fn value(mut self, value: fn(f64) -> f64) -> Self {
        self.value = value;
        self
    }

    /// Ticks without numbers, for a panel that shares the axis of its neighbour.
    pub fn bare(mut self) -> Self {
        self.numbered = false;
        self
    }

    /// # Errors
    /// [`PlotError::Axis`] unless `min < max` and both are finite.
    pub(super) fn check(&self) -> Result<(), PlotError> {
        if self.min < self.max && (self.max - self.min).is_finite() {
            Ok(())
        } else {
            Err(PlotError::Axis {
                label: rich::plain(&self.label),
                min: self.min,
                max: self.max,
            })
        }
    }

    /// Places and labels of the long ticks.
    pub(super) fn major(&self) -> Vec<(f64, String)> {
        match &self.ticks {
            Ticks::At(ticks) => {
                let inside = ticks.iter().filter(|(v, _)| self.holds(*v));
                inside.cloned().collect()
            }
            Ticks::Step(step) => {
                let places = self.multiples(*step);
                let texts = numbers(&places, *step);
                places.into_iter().zip(texts).collect()
            }
        }
    }

    /// Places of the short ticks.
    pub(super) fn minor_ticks(&self) -> Vec<f64> {
        match &self.ticks {
            Ticks::Step(step) if self.minor > 1 => self.multiples(step / self.minor as f64),
            _ => vec![],
        }
    }

    fn multiples(&self, step: f64) -> Vec<f64> {
        if !(step > 0.0 && step.is_finite()) {
            return vec![];
        }
        // Half a thousandth of a step of slack: 0.3/0.1 is a little less than 3.
        let first = (self.min / step - 5e-4).ceil() as i64;
        let last = (self.max / step + 5e-4).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    fn holds(&self, v: f64) -> bool {
        let slack = 5e-4 * (self.max - self.min);
        self.min - slack <= v && v <= self.max + slack
    }
}

/// The number among 1, 2, 5 × 10ⁿ that is nearest to `rough`.
fn nice_step(rough: f64) -> f64 {
    let power = crate::math::power_of_ten(crate::math::log10(rough).floor() as i32);
    let mantissa = rough / power;
    let nice = if mantissa < 1.5 {
        1.0
    } else if mantissa < 3.5 {
        2.0
    } else if mantissa < 7.5 {
        5.0
    } else {
        10.0
    };
    nice * power
}

/// Longest number on an axis that is written out, in characters.
const LONGEST: usize = 10;

/// Numbers at multiples of a step. Long ones have a common power of ten if that makes them shorter,
/// or if they are small.
fn numbers(places: &[f64], step: f64) -> Vec<String> {
    let longest = |texts: &[String]| texts.iter().map(|text| text.chars().count()).max();
    let decimals = decimals_of(step);
    let plain: Vec<String> = places.iter().map(|&v| number(v, decimals)).collect();
    if longest(&plain) <= Some(LONGEST) {
        return plain;
    }
    let most = places.iter().fold(step, |most, v| most.max(v.abs()));
    let power = (crate::math::log10(most) + 1e-9).floor();
    let scale = crate::math::power_of_ten(power as i32);
    let decimals = decimals_of(step / scale);
    let scaled = places.iter().map(|&v| match number(v / scale, decimals) {
        _ if v == 0.0 => "0".to_owned(),
        text => format!("{text}·10^{{{}}}", number(power, 0)),
    });
    let scaled: Vec<String> = scaled.collect();
    if power < -4.0 || longest(&scaled) < longest(&plain) {
        scaled
    } else {
        plain
    }
}

/// Digits after the decimal point needed to write `step`.
fn decimals_of(step: f64) -> usize {
    (0..10)
        .find(|d| {
            let scaled = step * crate::math::power_of_ten(*d as i32);
            scaled > 0.5 && (scaled - scaled.round()).abs() < 1e-6
        })
        .unwrap_or(10)
}

/// A number for a label: fixed digits, a true minus sign, no negative zero.
pub fn number(v: f64, decimals: usize) -> String {
    let text = format!("{v:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.major().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_fall_on_multiples() {
        let axis = Axis::new("x", -0.3, 0.3).step(0.1);
        assert_eq!(
            labels(&axis),
            ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]
        );
    }

    #[test]
    fn automatic_steps_are_one_two_five() {
        assert_eq!(
            labels(&Axis::new("x", 0.0, 10.0)),
            ["0", "2", "4", "6", "8", "10"]
        );
        assert_eq!(
            labels(&Axis::new("x", 0.0, 0.5)),
            ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(
            labels(&Axis::new("x", -3.0, 3.0)),
            ["−3", "−2", "−1", "0", "1", "2", "3"]
        );
    }

    #[test]
    fn long_numbers_have_powers_of_ten() {
        let texts = |min, max| labels(&Axis::new("x", min, max));
        let powers = |numbers: [&str; 3], power: &str| {
            numbers.map(|number| match number {
                "0" => "0".to_owned(),
                _ => format!("{number}·10^{{{power}}}"),
            })
        };
        assert_eq!(texts(0.0, 1e217)[..3], powers(["0", "0.2", "0.4"], "217"));
        assert_eq!(
            texts(-2e-15, 1e-15)[..3],
            powers(["−2.0", "−1.5", "−1.0"], "−15")
        );
        assert_eq!(texts(0.0, 2e9)[4..], ["2000000000"]);
        // A power of ten would not make these shorter.
        assert_eq!(texts(1e12, 1e12 + 10.0)[1], "1000000000002");
    }

    #[test]
    fn given_ticks_outside_the_range_are_left_out() {
        let axis = Axis::new("x", 0.0, 1.0).ticks([(0.5, "half"), (2.0, "two")]);
        assert_eq!(labels(&axis), ["half"]);
    }

    #[test]
    fn negative_zero_has_no_sign() {
        assert_eq!(number(-0.001, 1), "0.0");
        assert_eq!(number(-1.5, 1), "−1.5");
    }

    #[test]
    fn an_empty_range_is_refused_with_its_numbers() {
        let error = Axis::new("*x*_1", 1.0, 1.0).check().unwrap_err();
        assert_eq!(
            error.to_string(),
            "axis 'x1' runs from 1.0 to 1.0: its length must be positive and finite"
        );
    }
}
