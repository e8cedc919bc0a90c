//! Starts of a search that fill the bounds.

use rayon::prelude::*;
use stickslip::analysis::{LeastSquaresSettings, least_squares};
use stickslip::dynamics::Vector;

use super::FitError;
use super::problem::FitProblem;
use super::record_run::Failed;
use super::statistics::halton;
use super::unknowns::Kind;
use super::work::FitWork;

impl FitProblem<'_> {
    /// The point with the parameters of the observables alone fitted, such as an offset, and the
    /// work: the orbit stays. Far from their values the whole problem would leave the orbit of the
    /// data.
    pub(super) fn with_observables_fitted(
        &self,
        x: &Vector,
        settings: &LeastSquaresSettings,
    ) -> (Vector, FitWork) {
        let mut work = FitWork::of_at_most(settings.most_evaluations);
        let own_parameters = self.request.file.parameters.len();
        let locals = self.records.iter().flat_map(|record| &record.local);
        let further = locals.filter_map(|(kind, place)| match kind {
            Kind::Parameter(number) if *number >= own_parameters => Some(*place),
            _ => None,
        });
        let further: std::collections::BTreeSet<usize> = further.collect();
        let further: Vec<usize> = further.into_iter().collect();
        if further.is_empty() || work.left() <= 1 {
            return (x.clone(), work);
        }
        let settings = LeastSquaresSettings {
            bounds: further.iter().map(|&k| settings.bounds[k]).collect(),
            most_evaluations: work.left() - 1,
            ..settings.clone()
        };
        let whole = |part: &Vector| {
            let mut whole = x.clone();
            for (&k, value) in further.iter().zip(part) {
                whole[k] = *value;
            }
            whole
        };
        let part = Vector::from_iterator(further.len(), further.iter().map(|&k| x[k]));
        let found = least_squares(&part, &settings, |part| {
            let mut at = self.residuals(&whole(part))?;
            at.jacobian = at.jacobian.select_columns(&further);
            Ok::<_, Failed>(at)
        });
        match found {
            Ok(found) => {
                work.add(&found);
                (whole(&found.x), work)
            }
            Err(_) => (x.clone(), work),
        }
    }

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
