//! The listing as printed for smaller and smaller steps, against its limit in the event-exact
//! solver.

use rayon::prelude::*;
use stickslip::statistics::PowerLaw;

use super::digits::Agreement;
use super::matrix::{Cell, four_digits};
use crate::numbers::{extent, largest};
use crate::paper::listing::Defects;
use crate::paper::published::Claims;
use crate::text::joined;

/// Steps (s), from ten times the printed one to a hundredth of it. The finest come first, since
/// they take longest.
const STEPS: [f64; 16] = [
    1e-6,
    2.5e-6,
    5e-6,
    1e-5,
    1.5e-5,
    2.5e-5,
    3.5e-5,
    5e-5,
    7e-5,
    PRINTED_STEP,
    1.5e-4,
    2.5e-4,
    3.5e-4,
    5e-4,
    7e-4,
    1e-3,
];
/// Steps below this are fine ones (s), finer than a tenth of the printed one: the bound found on
/// the others is tried on them.
pub const FINE: f64 = 0.99e-5;
/// A fitted slope that is no further from one means first order. The error scatters between nothing
/// and its bound, so that a slope over three decades is not known much better.
pub const SLOPE_OFF: f64 = 0.25;
/// Steps around the printed one, the printed one in the middle, half a per cent apart.
const AROUND: usize = 21;
/// They reach this far to either side of it, as a fraction: far enough that the grid of steps meets
/// Σ anywhere.
pub const REACH: f64 = 0.05;
/// The printed step (s).
pub const PRINTED_STEP: f64 = 1e-4;

/// Runs made.
pub const RUNS: usize = STEPS.len() + AROUND;

/// How one of the four numbers approaches a limit as the step goes to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// The bound C of |error| ≤ C h: the largest |error|/h over all steps but the printed one,
    /// those around it too (m/s for a length, 1 for a duration).
    pub bound: f64,
    /// The same over the steps from 1e-5 s on.
    pub coarse: f64,
    /// The same over the finer steps.
    pub fine: f64,
    /// Slope of log|error| against log h over the steps that span three decades, the printed one
    /// left out, by least squares.
    pub slope: f64,
    /// Standard error of that slope.
    pub slope_error: f64,
}

impl Approach {
    /// Fits errors (with their signs) at steps, `(h, error)`: `decades` are those that span three
    /// decades, `around` those around the printed one; the printed one is left out.
    pub fn fit(decades: &[(f64, f64)], around: &[(f64, f64)]) -> Approach {
        let others = |errors: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let not_printed = |at: &&(f64, f64)| at.0 != PRINTED_STEP;
            errors.iter().filter(not_printed).copied().collect()
        };
        let decades = others(decades);
        let all = [decades.clone(), others(around)].concat();
        let most = |keep: fn(f64) -> bool| {
            let kept = all.iter().filter(|at| keep(at.0));
            largest(kept.map(|(h, e)| (e / h).abs()))
        };
        let sizes: Vec<(f64, f64)> = decades.iter().map(|&(h, e)| (h, e.abs())).collect();
        let law = PowerLaw::through(sizes.iter().copied());
        Approach {
            bound: most(|_| true),
            coarse: most(|h| h >= FINE),
            fine: most(|h| h < FINE),
            slope: law.exponent,
            slope_error: law.std_error,
        }
    }

    /// Whether the errors vanish at first order: their slope is one within a quarter, and the finer
    /// steps keep within the bound that was found without them.
    pub fn first_order(&self) -> bool {
        (self.slope - 1.0).abs() <= SLOPE_OFF && self.fine <= self.coarse
    }
}

/// How the listing's numbers approach their limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The limit: what the event-exact solver gives with slips three times too fast and the exit
    /// tested at one end.
    pub limit: [f64; 4],
    /// How far the limit agrees with the published numbers: these digits come from the continuous
    /// cause, the others from the step.
    pub limit_digits: [Agreement; 4],
    /// Over three decades of steps, in ascending order.
    pub steps: Vec<Cell>,
    /// Around the printed step.
    pub around: Vec<Cell>,
    /// How each number approaches the limit.
    pub approach: [Approach; 4],
    /// How each number approaches what the listing itself gives at the finest step, over the other
    /// steps; nothing of the injected solver is in it.
    pub own_approach: [Approach; 4],
}

impl Convergence {
    /// Runs the listing as printed at all steps and calls `tick` after each.
    pub fn compute(claims: &Claims, limit: [f64; 4], tick: &(dyn Fn() + Sync)) -> Convergence {
        let middle = (AROUND / 2) as f64;
        let around =
            (0..AROUND).map(|k| PRINTED_STEP * (1.0 + REACH * (k as f64 - middle) / middle));
        let all: Vec<f64> = STEPS.into_iter().chain(around).collect();
        let run = |&h: &f64| {
            let cell = Cell::run(claims, Defects::AS_PRINTED, h);
            tick();
            cell
        };
        let runs = all.par_iter().with_max_len(1).map(run);
        let mut steps: Vec<Cell> = runs.collect();
        let around = steps.split_off(STEPS.len());
        Convergence::new(limit, four_digits(claims, &limit), steps, around)
    }

    /// Sets runs of the listing, in ascending order of their steps, against a limit.
    pub fn new(
        limit: [f64; 4],
        limit_digits: [Agreement; 4],
        steps: Vec<Cell>,
        around: Vec<Cell>,
    ) -> Convergence {
        let own = steps.first().and_then(|finest| finest.numbers);
        let finest = steps.first().map_or(0.0, |finest| finest.h);
        let own_errors = |steps: &[Cell], i: usize| -> Vec<(f64, f64)> {
            let limit = own.unwrap_or([f64::NAN; 4]);
            // The finest step errs by its own part of the bound, so that a difference is held
            // against both steps.
            let errors = errors(steps, &limit, i).into_iter();
            errors.map(|(h, e)| (h, e * h / (h + finest))).collect()
        };
        let coarser = steps.get(1..).unwrap_or_default();
        let to_limit = |steps: &[Cell], i| errors(steps, &limit, i);
        let fit = |i| Approach::fit(&to_limit(&steps, i), &to_limit(&around, i));
        let own = |i| Approach::fit(&own_errors(coarser, i), &own_errors(&around, i));
        Convergence {
            limit,
            limit_digits,
            approach: std::array::from_fn(fit),
            own_approach: std::array::from_fn(own),
            steps,
            around,
        }
    }

    /// The listing at the finest step.
    pub fn finest(&self) -> Option<&Cell> {
        self.steps.first()
    }

    /// The listing at the printed step.
    pub fn printed(&self) -> Option<&Cell> {
        self.steps.iter().find(|at| at.h == PRINTED_STEP)
    }

    /// The largest of the four bounds.
    pub fn largest_bound(&self) -> f64 {
        largest(self.approach.iter().map(|one| one.bound))
    }

    /// How many of the steps around the printed one give all four numbers.
    pub fn steps_that_give_digits(&self) -> usize {
        self.around.iter().filter(|at| at.gives_digits()).count()
    }

    /// By how much the steps around the printed one move number `i`, from 0.
    pub fn moved_around(&self, i: usize) -> f64 {
        let numbers = self.around.iter().filter_map(|at| Some(at.numbers?[i]));
        let (low, high) = extent(numbers);
        high - low
    }

    /// How the numbers approach the limit, and what the alignment of the grid of steps does.
    pub fn sentence(&self) -> String {
        let each = |of: fn(&Approach) -> String| joined(self.approach.iter().map(of), ", ");
        let [coarsest, finest] =
            [self.steps.last(), self.finest()].map(|at| at.map_or(0.0, |at| at.h));
        let bounds = each(|one| format!("{:.1}", one.bound));
        let slopes = each(|one| format!("{:.2} ± {:.2}", one.slope, one.slope_error));
        let moved = (0..4).map(|i| format!("{:.1}", self.moved_around(i) / 1e-4));
        let (moved, around) = (joined(moved, ", "), self.around.len());
        let (percent, with_digits) = (100.0 * REACH, self.steps_that_give_digits());
        let give = if with_digits == 1 { "gives" } else { "give" };
        let limit = joined(self.limit_digits, ", ");
        format!(
            "From h = {coarsest:e} to {finest:e} s the listing's four numbers keep within {bounds} \
             h of the limit, the printed step left out of this fit; the slopes of log |error| \
             against log h are {slopes}. Where the grid of steps meets Σ scatters the error \
             between nothing and that bound: {around} steps within {percent} % of the printed one \
             move the numbers by {moved} units of 1e-4, and {with_digits} of them {give} all four \
             to all printed digits. The limit has {limit} of the printed digits."
        )
    }
}

/// Steps (s) and distances of number `i`, from 0, from the limit.
pub(super) fn distances(steps: &[Cell], limit: &[f64; 4], i: usize) -> Vec<(f64, f64)> {
    let signed = errors(steps, limit, i).into_iter();
    signed.map(|(h, e)| (h, e.abs())).collect()
}

/// Steps (s) and errors of number `i`, with their signs.
fn errors(steps: &[Cell], limit: &[f64; 4], i: usize) -> Vec<(f64, f64)> {
    let of = |at: &Cell| Some((at.h, at.numbers?[i] - limit[i]));
    steps.iter().filter_map(of).collect()
}
