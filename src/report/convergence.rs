//! The listing as printed for smaller and smaller steps, against its limit in the event-exact solver.

use rayon::prelude::*;

use super::digits::Agreement;
use super::matrix::{MatrixError, four_claims, four_digits};
use crate::paper::listing::{Motion, Setup, run};
use stickslip::math;

/// Steps (s), from ten times the printed one to a tenth of it.
const STEPS: [f64; 13] = [
    1e-3, 7e-4, 5e-4, 3.5e-4, 2.5e-4, 1.5e-4, 1e-4, 7e-5, 5e-5, 3.5e-5, 2.5e-5, 1.5e-5, 1e-5,
];
/// Steps around the printed one, the printed one in the middle.
const AROUND: usize = 21;
/// They reach this far to either side of it, as a fraction.
const REACH: f64 = 0.05;
/// The printed step (s).
pub const PRINTED_STEP: f64 = 1e-4;

/// Runs made.
pub const RUNS: usize = STEPS.len() + AROUND;

/// The listing at one step.
#[derive(Clone, Debug, PartialEq)]
pub struct AtStep {
    /// Step (s).
    pub h: f64,
    /// Lengths of the two stick phases (m), then their durations (s).
    pub numbers: Option<[f64; 4]>,
    /// Class of the settled motion.
    pub motion: Motion,
    /// How far the numbers agree with the published ones.
    pub digits: Option<[Agreement; 4]>,
}

impl AtStep {
    /// Whether all four numbers have all printed digits.
    pub fn gives_digits(&self) -> bool {
        self.digits
            .is_some_and(|digits| digits.iter().all(|one| one.complete()))
    }
}

/// How the listing's numbers approach their limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The limit: what the event-exact solver gives with slips three times too fast and the exit tested at one end.
    pub limit: [f64; 4],
    /// How far the limit agrees with the published numbers: these digits come from the continuous cause, the others
    /// from the step.
    pub limit_digits: [Agreement; 4],
    /// Over two decades of steps.
    pub steps: Vec<AtStep>,
    /// Around the printed step.
    pub around: Vec<AtStep>,
    /// Slopes of log|error| against log h over `steps`, by least squares.
    pub orders: [f64; 4],
    /// Largest |error|/h over `steps`.
    pub largest_per_step: [f64; 4],
}

impl Convergence {
    /// Runs the listing as printed at all steps and calls `tick` after each.
    ///
    /// # Errors
    /// [`MatrixError`] if the setup or the table of claims is not sound.
    pub fn compute(limit: [f64; 4], tick: &(dyn Fn() + Sync)) -> Result<Convergence, MatrixError> {
        let claims = four_claims()?;
        let middle = (AROUND / 2) as f64;
        let around =
            (0..AROUND).map(|k| PRINTED_STEP * (1.0 + REACH * (k as f64 - middle) / middle));
        let all: Vec<f64> = STEPS.into_iter().chain(around).collect();
        let mut steps: Vec<AtStep> = all
            .par_iter()
            .map(|&h| -> Result<AtStep, MatrixError> {
                let outcome = run(&Setup {
                    h,
                    ..Setup::default()
                })?;
                tick();
                let numbers = outcome.four_numbers();
                Ok(AtStep {
                    h,
                    numbers,
                    motion: outcome.motion,
                    digits: numbers.map(|numbers| four_digits(&claims, &numbers)),
                })
            })
            .collect::<Result<_, _>>()?;
        let around = steps.split_off(STEPS.len());
        Ok(Convergence {
            limit,
            limit_digits: four_digits(&claims, &limit),
            orders: std::array::from_fn(|i| order(&errors(&steps, &limit, i))),
            largest_per_step: std::array::from_fn(|i| {
                let per_step = errors(&steps, &limit, i).into_iter().map(|(h, e)| e / h);
                per_step.fold(0.0, f64::max)
            }),
            steps,
            around,
        })
    }

    /// Steps (s) and errors of number `i`, from 0.
    pub fn errors(&self, i: usize) -> Vec<(f64, f64)> {
        errors(&self.steps, &self.limit, i)
    }

    /// How many of the steps around the printed one give all four numbers.
    pub fn steps_that_give_digits(&self) -> usize {
        self.around.iter().filter(|at| at.gives_digits()).count()
    }

    /// Which digits come from where.
    pub fn sentence(&self) -> String {
        let digits: Vec<String> = self.limit_digits.iter().map(Agreement::to_string).collect();
        let orders: Vec<String> = self.orders.iter().map(|o| format!("{o:.2}")).collect();
        let worst = self.largest_per_step.iter().copied().fold(0.0, f64::max);
        format!(
            "As the step goes to zero the listing's four numbers approach the limit with orders {}, never further from it than {worst:.1} h; \
             the limit has {} of the printed digits. The rest is the step's: of {} steps within {} % of the printed one, {} give all four \
             numbers to all digits.",
            orders.join(", "),
            digits.join(", "),
            self.around.len(),
            100.0 * REACH,
            self.steps_that_give_digits()
        )
    }
}

fn errors(steps: &[AtStep], limit: &[f64; 4], i: usize) -> Vec<(f64, f64)> {
    let of = |at: &AtStep| Some((at.h, (at.numbers?[i] - limit[i]).abs()));
    steps.iter().filter_map(of).collect()
}

/// Least-squares slope of the logarithms.
pub(super) fn order(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point.1 > 0.0)
        .map(|&(h, e)| (math::ln(h), math::ln(e)))
        .collect();
    let n = logs.len() as f64;
    let (x, y) = (
        logs.iter().map(|p| p.0).sum::<f64>() / n,
        logs.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let above: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let below: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    above / below
}
