//! Comparisons that a tape relies on, and where they come out otherwise.

use super::TaylorStepper;
use super::piece::Piece;
use crate::taylor::roots::{first_zero, value_and_slope};

impl<const N: usize> TaylorStepper<N> {
    /// Whether a comparison that the tape relies on comes out otherwise now.
    pub(super) fn compares_otherwise(&self, index: usize) -> bool {
        let tape = &self.tapes[index];
        tape.choices.iter().any(|choice| {
            let at = |k| self.series.combination(tape, choice, k);
            // Rounding may leave the start of a branch just off it.
            at(0) < 0.0 && !(at(1) > 0.0 && -at(0) <= 1e-12 * at(1))
        })
    }

    /// Where in the step, before the part `before`, a comparison that the tape relies on first comes out otherwise: a little behind
    /// the place where the two are equal, so that the next recording sees it.
    pub(super) fn first_kink(&self, index: usize, piece: &Piece<N>, before: f64) -> Option<f64> {
        let tape = &self.tapes[index];
        let mut first: Option<f64> = None;
        for choice in &tape.choices {
            let c = piece.polynomial(&self.series, tape, choice);
            let c = &c[..=self.order];
            // Two that are equal throughout come out the same throughout.
            let Some(start) = c.iter().position(|&c| c != 0.0) else {
                continue;
            };
            let rises = start == 0 && c[0] < 0.0;
            let c_left = &c[if rises { 1 } else { start }..];
            let s = if c_left[0] <= 0.0 {
                0.0
            } else {
                match first_zero(c_left) {
                    Some(s) => s,
                    None => continue,
                }
            };
            let size: f64 = c.iter().map(|c| c.abs()).sum();
            let mut behind = s;
            // At least something, where the step begins at time zero.
            let mut more = 4.0 * f64::EPSILON * (s + (piece.t / piece.h).abs()).max(1.0);
            while behind < 1.0 && value_and_slope(c, behind).0 > -8.0 * f64::EPSILON * size {
                behind = s + more;
                more *= 2.0;
            }
            if behind < first.unwrap_or(before) {
                first = Some(behind);
            }
        }
        first
    }
}
