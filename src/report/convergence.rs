//! The listing as printed for decreasing steps, compared with its limit in the event-exact solver.

use numerics::PowerLaw;
use rayon::prelude::*;

use super::digits::Agreement;
use super::matrix::{ComparedRun, four_digits};
use crate::numbers::{extent, largest};
use crate::paper::listing::{Defects, PRINTED_STEP};
use crate::paper::published::{Claims, LAST_DIGIT};
use crate::text::joined;

/// Steps (s), from ten times the printed one to a hundredth of it. The finest take longest and come
/// first.
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
/// Steps below this (s) are fine. They test the bound obtained from the others.
const FINE_STEP: f64 = PRINTED_STEP / 10.0;
/// Allowed deviation of a fitted slope from one for first order. The error scatters between zero
/// and its bound, so that slopes over three decades have standard errors of 0.1 to 0.15. An order
/// of one half or of two is off by 0.5 or more.
pub const SLOPE_TOLERANCE: f64 = 0.25;
/// Number of steps around the printed one, half a per cent apart, with the printed one in the
/// middle.
const NEIGHBOURS: usize = 21;
/// Largest relative difference of these from the printed step. The 600 000 steps of a run then meet
/// Σ at any phase.
pub const NEIGHBOUR_RANGE: f64 = 0.05;

/// Number of runs.
pub const RUNS: usize = STEPS.len() + NEIGHBOURS;

/// Convergence of one of the four numbers as the step goes to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// The bound C of |error| ≤ C h (m/s for a length, 1 for a duration). It is the largest
    /// |error|/h over all steps except the printed one, including those around it.
    pub bound: f64,
    /// Order over the steps of at least 1e-5 s.
    pub coarse: f64,
    /// Order over the finer steps.
    pub fine: f64,
    /// Slope of log|error| against log h by least squares, over the steps that span three decades,
    /// without the printed one.
    pub slope: f64,
    /// Standard error of that slope.
    pub slope_error: f64,
}

impl Approach {
    /// Fits signed errors at steps, `(h, error)`. `decades` span three decades, `around` surround
    /// the printed step, which is left out.
    pub fn fit(decades: &[(f64, f64)], around: &[(f64, f64)]) -> Approach {
        let others = |errors: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let not_printed = |at: &&(f64, f64)| at.0 != PRINTED_STEP;
            errors.iter().filter(not_printed).copied().collect()
        };
        let decades = others(decades);
        let all = [decades.clone(), others(around)].concat();
        let largest_ratio = |keep: fn(f64) -> bool| {
            let selected = all.iter().filter(|at| keep(at.0));
            largest(selected.map(|(h, e)| (e / h).abs()))
        };
        let sizes: Vec<(f64, f64)> = decades.iter().map(|&(h, e)| (h, e.abs())).collect();
        let law = PowerLaw::through(sizes.iter().copied());
        Approach {
            bound: largest_ratio(|_| true),
            coarse: largest_ratio(|h| h >= FINE_STEP),
            fine: largest_ratio(|h| h < FINE_STEP),
            slope: law.exponent,
            slope_error: law.std_error,
        }
    }

    /// Whether the errors vanish at first order. The slope must be near one, and the errors of fine
    /// steps must be within the bound of the others.
    pub fn first_order(&self) -> bool {
        (self.slope - 1.0).abs() <= SLOPE_TOLERANCE && self.fine <= self.coarse
    }
}

/// Convergence of the listing's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The limit: the result of the event-exact solver with slips three times too fast and the exit
    /// tested at one end.
    pub limit: [f64; 4],
    /// Agreement of the limit with the published numbers. These digits are due to the continuous
    /// cause, the others to the step.
    pub limit_digits: [Agreement; 4],
    /// Runs over three decades of steps, in ascending order.
    pub steps: Vec<ComparedRun>,
    /// Around the printed step, in ascending order.
    pub around: Vec<ComparedRun>,
    /// Convergence of each number to the limit.
    pub approach: [Approach; 4],
    /// Convergence of each number to the listing's own value at the finest step, over the other
    /// steps. It does not depend on the injected solver.
    pub own_approach: [Approach; 4],
}

impl Convergence {
    /// Runs the listing as printed at all steps and calls `tick` after each.
    pub fn compute(claims: &Claims, limit: [f64; 4], tick: &(dyn Fn() + Sync)) -> Convergence {
        let middle = (NEIGHBOURS / 2) as f64;
        let around = (0..NEIGHBOURS)
            .map(|k| PRINTED_STEP * (1.0 + NEIGHBOUR_RANGE * (k as f64 - middle) / middle));
        let all: Vec<f64> = STEPS.into_iter().chain(around).collect();
        let run = |&h: &f64| {
            let cell = ComparedRun::run(claims, Defects::AS_PRINTED, h);
            tick();
            cell
        };
        let runs = all.par_iter().with_max_len(1).map(run);
        let mut steps: Vec<ComparedRun> = runs.collect();
        let around = steps.split_off(STEPS.len());
        Convergence::new(limit, four_digits(claims, &limit), steps, around)
    }

    /// Compares runs of the listing, in ascending order of their steps, with a limit.
    pub fn new(
        limit: [f64; 4],
        limit_digits: [Agreement; 4],
        steps: Vec<ComparedRun>,
        around: Vec<ComparedRun>,
    ) -> Convergence {
        let own = steps.first().and_then(|finest| finest.numbers);
        let finest = steps.first().map_or(0.0, |finest| finest.h);
        let own_errors = |steps: &[ComparedRun], i: usize| -> Vec<(f64, f64)> {
            let limit = own.unwrap_or([f64::NAN; 4]);
            // The finest step has its own step error, so that a difference is compared with the sum
            // of both steps.
            let errors = errors(steps, &limit, i).into_iter();
            errors.map(|(h, e)| (h, e * h / (h + finest))).collect()
        };
        let coarser = steps.get(1..).unwrap_or_default();
        let to_limit = |steps: &[ComparedRun], i| errors(steps, &limit, i);
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
    pub fn finest(&self) -> Option<&ComparedRun> {
        self.steps.first()
    }

    /// The listing at the printed step.
    pub fn printed(&self) -> Option<&ComparedRun> {
        self.steps.iter().find(|at| at.h == PRINTED_STEP)
    }

    /// Number of steps around the printed one that give the printed digits of all four numbers.
    pub fn steps_that_give_digits(&self) -> usize {
        self.around.iter().filter(|at| at.gives_digits()).count()
    }

    /// Range of number `i`, from 0, over the steps around the printed one.
    pub fn moved_around(&self, i: usize) -> f64 {
        let numbers = self.around.iter().filter_map(|at| Some(at.numbers?[i]));
        let (low, high) = extent(numbers);
        high - low
    }

    /// The convergence of the numbers, and the effect of the alignment of the grid of steps.
    pub fn sentence(&self) -> String {
        let each = |of: fn(&Approach) -> String| joined(self.approach.iter().map(of), ", ");
        let [coarsest, finest] =
            [self.steps.last(), self.finest()].map(|at| at.map_or(0.0, |at| at.h));
        let bounds = each(|one| format!("{:.1}", one.bound));
        let slopes = each(|one| format!("{:.2} ± {:.2}", one.slope, one.slope_error));
        let moved = (0..4).map(|i| format!("{:.1}", self.moved_around(i) / LAST_DIGIT));
        let (moved, around) = (joined(moved, ", "), self.around.len());
        let (percent, with_digits) = (100.0 * NEIGHBOUR_RANGE, self.steps_that_give_digits());
        let give = if with_digits == 1 { "gives" } else { "give" };
        let limit = joined(self.limit_digits, ", ");
        format!(
            "From h = {coarsest:e} to {finest:e} s the listing's four numbers stay within {bounds} \
             h of the limit; the printed step is left out of this fit. The slopes of log |error| \
             against log h are {slopes}. The error scatters between zero and that bound with the \
             phase at which the grid of steps meets Σ: {around} steps within {percent} % of the \
             printed one move the numbers by {moved} units of 1e-4, and {with_digits} of them \
             {give} all four to all printed digits. The limit has {limit} of the printed digits."
        )
    }
}

/// Steps (s) and distances of number `i`, from 0, from the limit.
pub(super) fn distances(steps: &[ComparedRun], limit: &[f64; 4], i: usize) -> Vec<(f64, f64)> {
    let signed = errors(steps, limit, i).into_iter();
    signed.map(|(h, e)| (h, e.abs())).collect()
}

/// Steps (s) and signed errors of number `i`.
fn errors(steps: &[ComparedRun], limit: &[f64; 4], i: usize) -> Vec<(f64, f64)> {
    let of = |at: &ComparedRun| Some((at.h, at.numbers?[i] - limit[i]));
    steps.iter().filter_map(of).collect()
}
