//! An axis: range, ticks, label.

use super::{PlotError, rich};

/// A linear axis.
#[derive(Clone, Debug)]
pub struct Axis {
    pub(super) label: String,
    pub(super) min: f64,
    pub(super) max: f64,
    ticks: Ticks,
    minor: usize,
    decimals: Option<usize>,
    pub(super) numbered: bool,
}

#[derive(Clone, Debug)]
enum Ticks {
    Auto,
    Step(f64),
    At(Vec<(f64, String)>),
}

/// How many intervals an axis left to itself is divided into, about.
const AUTO_INTERVALS: f64 = 5.0;

impl Axis {
    /// An axis from `min` to `max` with a label in markup, such as `*x*_1, m`. Ticks are chosen automatically.
    pub fn new(label: &str, min: f64, max: f64) -> Self {
        Self {
            label: label.to_owned(),
            min,
            max,
            ticks: Ticks::Auto,
            minor: 1,
            decimals: None,
            numbered: true,
        }
    }

    /// An axis of decimal logarithms, numbered by powers of ten; by the logarithms themselves where it holds fewer than two.
    pub fn decades(label: &str, (low, high): (f64, f64)) -> Self {
        const MOST: i64 = 8;
        let (first, last) = (low.ceil() as i64, high.floor() as i64);
        if last - first < 1 {
            return Axis::new(&format!("log_{{10}} {label}"), low, high);
        }
        let every = (last - first) / MOST + 1;
        let ticks: Vec<(f64, String)> = (first..=last)
            .filter(|power| power % every == 0)
            .map(|power| (power as f64, format!("10^{{{}}}", number(power as f64, 0))))
            .collect();
        let ticks: Vec<(f64, &str)> = ticks.iter().map(|(v, text)| (*v, text.as_str())).collect();
        Axis::new(label, low, high).ticks(&ticks)
    }

    /// Ticks at multiples of `step`.
    pub fn step(mut self, step: f64) -> Self {
        self.ticks = Ticks::Step(step);
        self
    }

    /// Ticks at the values given, with labels in markup (an empty one leaves the tick bare).
    pub fn ticks(mut self, ticks: &[(f64, &str)]) -> Self {
        self.ticks = Ticks::At(
            ticks
                .iter()
                .map(|(v, text)| (*v, (*text).to_owned()))
                .collect(),
        );
        self
    }

    /// Intervals the space between two ticks is divided into by short ticks; 1 for none.
    pub fn minor(mut self, intervals: usize) -> Self {
        self.minor = intervals;
        self
    }

    /// Digits after the decimal point; by default as many as the step has.
    pub fn decimals(mut self, decimals: usize) -> Self {
        self.decimals = Some(decimals);
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
        if self.min.is_finite() && self.max.is_finite() && self.min < self.max {
            Ok(())
        } else {
            Err(PlotError::Axis {
                label: rich::plain(&self.label),
                min: self.min,
                max: self.max,
            })
        }
    }

    /// Distance between the long ticks, where their places are not given.
    fn tick_step(&self) -> f64 {
        match self.ticks {
            Ticks::Step(step) => step,
            _ => nice_step((self.max - self.min) / AUTO_INTERVALS),
        }
    }

    /// Places and labels of the long ticks.
    pub(super) fn major(&self) -> Vec<(f64, String)> {
        if let Ticks::At(ticks) = &self.ticks {
            let inside = ticks.iter().filter(|(v, _)| self.holds(*v));
            return inside.cloned().collect();
        }
        let step = self.tick_step();
        let decimals = self.decimals.unwrap_or_else(|| decimals_of(step));
        let places = self.multiples(step).into_iter();
        places.map(|v| (v, number(v, decimals))).collect()
    }

    /// Places of the short ticks.
    pub(super) fn minor_ticks(&self) -> Vec<f64> {
        if self.minor < 2 || matches!(self.ticks, Ticks::At(_)) {
            return vec![];
        }
        self.multiples(self.tick_step() / self.minor as f64)
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

/// The largest of 1, 2, 5 × 10ⁿ that is not above `rough`, or half a decade more where that is nearer.
fn nice_step(rough: f64) -> f64 {
    let power = power_of_ten(libm::log10(rough).floor() as i32);
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

/// `10^n`: multiplications only (and one division for `n < 0`), in a fixed order.
fn power_of_ten(n: i32) -> f64 {
    let mut base: f64 = 10.0;
    let mut left = n.unsigned_abs();
    let mut product = 1.0;
    while left > 0 {
        if left & 1 == 1 {
            product *= base;
        }
        base *= base;
        left >>= 1;
    }
    if n < 0 { 1.0 / product } else { product }
}

/// Digits after the decimal point needed to write `step`.
fn decimals_of(step: f64) -> usize {
    (0..10)
        .find(|d| {
            let scaled = step * power_of_ten(*d as i32);
            (scaled - scaled.round()).abs() < 1e-6
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
    fn given_ticks_outside_the_range_are_left_out() {
        let axis = Axis::new("x", 0.0, 1.0).ticks(&[(0.5, "half"), (2.0, "two")]);
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
            "axis 'x1' runs from 1 to 1: both ends must be finite and min < max"
        );
    }
}
