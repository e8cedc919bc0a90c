//! The answer in words.

use super::{Scan, VALUES};
use stickslip::math;

impl Scan {
    /// The answer in words.
    pub fn sentence(&self) -> String {
        let Some(printed) = self.printed() else {
            return "Nothing was scanned.".into();
        };
        let [escape, slip_only, other, two, unsettled] = printed.counts;
        let mut text = format!(
            "At the printed parameters {} of {} starts lead to a stick–slip motion ({slip_only} slip only, {escape} escape, {unsettled} \
             unsettled).",
            other + two,
            self.starts
        );
        let ranges: Vec<String> = self
            .period_two()
            .into_iter()
            .filter_map(|(parameter, factors)| {
                let (first, last) = (factors.first()?, factors.last()?);
                Some(format!(
                    "{} (at {} of {VALUES} factors, from {first:.3} to {last:.3})",
                    parameter.name(),
                    factors.len()
                ))
            })
            .collect();
        text += &if ranges.is_empty() {
            " Changing one parameter by up to a factor of two, no stick–slip of period two appears."
                .to_owned()
        } else {
            format!(
                " Changing one parameter by up to a factor of two ({VALUES} factors, {:.1} % apart; narrower windows would be missed), stick–slip of \
                 period two appears for {}.",
                100.0 * (math::pow(4.0, 1.0 / (VALUES - 1) as f64) - 1.0),
                ranges.join(", ")
            )
        };
        for (what, found) in [
            ("of period two", self.nearest(|motion| motion.period == 2)),
            ("of any period", self.nearest(|_| true)),
        ] {
            if let Some(found) = found {
                let lengths: Vec<String> = found
                    .motion
                    .lengths
                    .iter()
                    .take(2)
                    .map(|l| format!("{l:.4}"))
                    .collect();
                let off = if found.distance.is_finite() {
                    format!("off by {:.0} %", 100.0 * found.distance)
                } else {
                    "where two are published".to_owned()
                };
                text += &format!(
                    " Nearest {what}: {} x {:.3}, period {}, stick phases in it {}, the longest {} m, {off}.",
                    found.parameter.name(),
                    found.point.factor,
                    found.motion.period,
                    found.motion.lengths.len(),
                    lengths.join(" and "),
                );
            }
        }
        text
    }
}
