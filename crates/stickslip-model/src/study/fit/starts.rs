//! Starts of a search that fill the bounds.

use rayon::prelude::*;
use stickslip::dynamics::Vector;

use super::FitError;
use super::problem::FitProblem;
use super::statistics::halton;

impl FitProblem<'_> {
    /// The best of `count` starts that fill the bounds evenly, and the given one, by rising cost.
    pub(super) fn best_starts(
        &self,
        given: &Vector,
        count: usize,
        best: usize,
    ) -> Result<Vec<Vector>, FitError> {
        for one in &self.unknowns.0 {
            if !(one.bounds.1 - one.bounds.0).is_finite() {
                return Err(FitError::Request(format!(
                    "`{}` has no bounds to search within: give a lowest and a highest value",
                    one.name
                )));
            }
        }
        let place = |k: usize| {
            let parts = self.unknowns.0.iter().enumerate().map(|(i, one)| {
                let (low, high) = one.bounds;
                low + (high - low) * halton(k + 1, i)
            });
            Vector::from_iterator(self.unknowns.len(), parts)
        };
        let starts: Vec<Vector> = std::iter::once(given.clone())
            .chain((0..count).map(place))
            .collect();
        let costs: Vec<Option<f64>> = starts
            .par_iter()
            .map(|x| self.cost(x).filter(|cost| cost.is_finite()))
            .collect();
        self.check_interrupt()?;
        let mut rated: Vec<(f64, Vector)> = costs
            .into_iter()
            .zip(starts)
            .filter_map(|(cost, x)| Some((cost?, x)))
            .collect();
        // A stable sort: equal ones stay in order.
        rated.sort_by(|one, other| one.0.total_cmp(&other.0));
        rated.truncate(best);
        match rated.is_empty() {
            true => Err(FitError::NoStart { count: count + 1 }),
            false => Ok(rated.into_iter().map(|(_, x)| x).collect()),
        }
    }
}
