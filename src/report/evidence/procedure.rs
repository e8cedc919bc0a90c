//! Statements on the procedure and its parameters: its order, its estimates of the transitions, and
//! whether numbers that the paper gives twice agree.

use crate::figures::rows::Part;
use crate::numbers::{ROUNDING, extent, largest};
use crate::paper::listing::{Defect, Defects, Setup, run_with};
use crate::paper::models::{Caption, ForcedOscillator};
use crate::paper::reading::Reading::{AsPrinted, Exact};
use crate::report::finding::{Finding, statement};
use crate::text::joined;
use numerics::PowerLaw;

/// Time (s) of a slip phase in which orders are measured: a whole number of all steps, and in place
/// three times as long, before Σ is met.
const SLIP_TIME: f64 = 0.1;
/// Steps (s) at which orders are measured, and that of the reference.
const STEPS: [f64; 4] = [1e-2, 5e-3, 2.5e-3, 1.25e-3];
const REFERENCE_STEP: f64 = 1e-5;

/// The state after [`SLIP_TIME`] by the listing.
fn after(defects: Defects, h: f64) -> [f64; 2] {
    let setup = Setup {
        start: [0.0, 0.0, -1.0],
        h,
        window_start: 0.0,
        end: SLIP_TIME,
        ..Setup::with(defects)
    };
    let mut state = [f64::NAN; 2];
    run_with(&setup, |sample| {
        if sample.t < SLIP_TIME + 0.5 * h {
            state = [sample.x1, sample.x2];
        }
    });
    state
}

/// Order at which the listing's slip steps approach the stated motion.
fn order(defects: Defects) -> f64 {
    let reference = after(Defects::MENDED, REFERENCE_STEP);
    let off = |h| {
        let at = after(defects, h);
        largest([0, 1].map(|i| (at[i] - reference[i]).abs()))
    };
    PowerLaw::through(STEPS.into_iter().map(|h| (h, off(h)))).exponent
}

/// `s3.order`: the order of the slip steps of the Appendix's program.
pub(super) fn order_of_steps() -> Vec<Finding> {
    let printed = order(Defects::AS_PRINTED);
    let frozen = order(Defects::MENDED.flipped(Defect::FrozenForcing));
    let mended = order(Defects::MENDED);
    let is_four = |order: f64| (order - 4.0).abs() < 0.3;
    let what = "the slip steps of the program approach the motion with order four";
    let line = format!(
        "observed order of a slip phase of the listing: {printed:.2} as printed, for the stages \
         overwrite the state; {frozen:.2} with that mended and the forcing frozen; {mended:.2} \
         with both mended. A textbook's classical Runge–Kutta step has order four by definition: \
         the text alone leaves nothing to test"
    );
    vec![statement(AsPrinted, [(what, is_four(printed))], line)]
}

/// `s4.listing_parameters`: the frequency and the window of the listing against the text.
pub(super) fn listing_parameters(setup: &Setup, text: &ForcedOscillator) -> Vec<Finding> {
    let listing = setup.model.omega;
    let window = setup.end - setup.window_start;
    let pattern = 2.0 * text.period();
    let parts = [
        (
            "ω = 3π/2.4728 of the text is 3π/2/1.2364 of the listing",
            (text.omega - listing).abs() <= ROUNDING * listing,
        ),
        (
            "the window of the listing, N − N0 steps, holds the two forcing periods of Fig. 8",
            window >= pattern,
        ),
    ];
    let line = format!(
        "ω = {:.6} 1/s in the text, {listing:.6} 1/s in the listing; the window of {window:.4} s \
         is {:.1} ms longer than two forcing periods",
        text.omega,
        1e3 * (window - pattern)
    );
    vec![statement(Exact, parts, line)]
}

/// `s5.one_rig`: ξ3/ξ1 = m r²/J is one number for one rig.
pub(super) fn one_rig(captions: &[Caption; 3]) -> Vec<Finding> {
    // Half a unit of the third decimal, as printed.
    let half = 5e-4;
    let ratio =
        |xi: &Caption, sign: f64| (xi.numbers[2] + sign * half) / (xi.numbers[0] - sign * half);
    let (_, least) = extent(captions.iter().map(|xi| ratio(xi, -1.0)));
    let (most, _) = extent(captions.iter().map(|xi| ratio(xi, 1.0)));
    let parts = [(
        "the captions of Figs. 10–12 have one ratio ξ3/ξ1 = m r²/J within their rounding",
        least <= most,
    )];
    let ratios = captions
        .each_ref()
        .map(|xi| format!("{:.4}", ratio(xi, 0.0)));
    let line = format!(
        "ξ3/ξ1 is {} in Figs. 10, 11, 12; all three allow {least:.4} to {most:.4}",
        joined(ratios, ", ")
    );
    vec![statement(Exact, parts, line)]
}

/// Stick phases of the stated model that end at a lower end of a zone, which Sect. 3 does not test,
/// of all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowerEnds {
    /// Phases that end at a lower end.
    pub missed: usize,
    /// All.
    pub all: usize,
}

impl LowerEnds {
    /// Part of `abstract.good_estimations`.
    pub(in crate::report) fn part(self) -> Part {
        let what = "release where the lower end of a moving zone overtakes the body";
        (what, self.missed == 0)
    }

    /// Describes the count in words.
    pub(in crate::report) fn sentence(self) -> String {
        let LowerEnds { missed, all } = self;
        format!(
            "{missed} of {all} stick phases of the stated model from a grid of starts end at a \
             lower end, which Sect. 3 (x1^(i+1) > x1,0^(k)) does not test"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_order_is_nought_in_place_one_with_frozen_forcing_and_four_mended() {
        let found = order_of_steps();
        assert!(!found[0].agrees);
        let orders = [
            Defects::AS_PRINTED,
            Defects::MENDED.flipped(Defect::FrozenForcing),
            Defects::MENDED,
        ];
        for (defects, wanted) in orders.into_iter().zip([0.0, 1.0, 4.0]) {
            let order = order(defects);
            assert!((order - wanted).abs() < 0.2, "{order} is not {wanted}");
        }
    }

    #[test]
    fn a_caption_of_another_rig_is_noticed() {
        assert!(one_rig(&Caption::ALL)[0].agrees);
        let mut other = Caption::ALL;
        other[1].numbers[2] += 5e-3;
        assert!(!one_rig(&other)[0].agrees);
    }

    #[test]
    fn another_frequency_or_window_in_the_listing_is_noticed() {
        let text = ForcedOscillator::default();
        let agrees = |listing: Setup| listing_parameters(&listing, &text)[0].agrees;
        let printed = Setup::default();
        assert!(agrees(printed));
        // One unit of the last decimal of w, and two periods that no longer fit.
        let mut other = printed;
        other.model.omega = 3.0 * PI / 2.0 / 1.2365;
        assert!(!agrees(other));
        let window_start = printed.window_start + 0.1;
        assert!(!agrees(Setup {
            window_start,
            ..printed
        }));
    }
}
