//! Starts of a search: the given one, those that fill the bounds, and calibration fitted there.

use crate::study::least_squares::{LeastSquaresSettings, least_squares};
use rayon::prelude::*;
use stickslip::dynamics::Vector;

use super::FitError;
use super::problem::FitProblem;
use super::record_run::Failed;
use super::statistics::halton;
use super::unknowns::Kind;

/// Most evaluations in which calibration is fitted at a start. Chosen: one that is linear, as
/// offsets and scales, takes three.
const MOST_EVALUATIONS: usize = 8;

/// Relative tolerance of calibration at a start.
const TOLERANCE: f64 = 1e-3;

/// A start of a search, and the evaluations that it has taken.
pub(super) type Begun = (Vector, usize);

impl FitProblem<'_> {
    /// The best of `count` starts that fill the bounds evenly, and the given one, by rising cost.
    pub(super) fn best_starts(
        &self,
        given: &Vector,
        count: usize,
        best: usize,
        settings: &LeastSquaresSettings,
    ) -> Result<Vec<Begun>, FitError> {
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
        let rated = starts.into_par_iter().map(|x| {
            let begun = self.calibrated(&x, settings).unwrap_or((x, 0));
            let cost = self.cost(&begun.0).filter(|cost| cost.is_finite())?;
            Some((cost, begun))
        });
        let rated: Vec<Option<(f64, Begun)>> = rated.collect();
        self.check_interrupt()?;
        let mut rated: Vec<(f64, Begun)> = rated.into_iter().flatten().collect();
        // A stable sort: equal ones stay in order.
        rated.sort_by(|one, other| one.0.total_cmp(&other.0));
        rated.truncate(best);
        match rated.is_empty() {
            true => Err(FitError::NoStart { count: count + 1 }),
            false => Ok(rated.into_iter().map(|(_, begun)| begun).collect()),
        }
    }

    /// The given start, and that with calibration fitted, if there is any.
    pub(super) fn given_starts(
        &self,
        given: Vector,
        settings: &LeastSquaresSettings,
    ) -> Result<Vec<Begun>, FitError> {
        let calibrated = self.calibrated(&given, settings);
        self.check_start(calibrated.as_ref().map_or(&given, |begun| &begun.0))?;
        Ok(calibrated.into_iter().chain([(given, 0)]).collect())
    }

    /// A start with the parameters fitted on which no orbit depends, such as offsets and scales,
    /// and the others held. The search then begins in the valley of the others (variable
    /// projection: Golub and Pereyra, *SIAM J. Numer. Anal.* 10 (1973) 413). `None` without such
    /// parameters, or where the run fails.
    fn calibrated(&self, x: &Vector, settings: &LeastSquaresSettings) -> Option<Begun> {
        let own = self.request.file.parameters.len();
        let locals = self.records.iter().flat_map(|record| &record.local);
        let places = locals.filter(|(kind, _)| matches!(kind, Kind::Parameter(k) if *k >= own));
        let mut places: Vec<usize> = places.map(|&(_, place)| place).collect();
        places.sort_unstable();
        places.dedup();
        if places.is_empty() {
            return None;
        }
        let whole = |part: &Vector| {
            let mut x = x.clone();
            places
                .iter()
                .zip(part)
                .for_each(|(&place, value)| x[place] = *value);
            x
        };
        let part = Vector::from_iterator(places.len(), places.iter().map(|&place| x[place]));
        let settings = LeastSquaresSettings {
            bounds: places.iter().map(|&place| settings.bounds[place]).collect(),
            tolerance: TOLERANCE,
            most_evaluations: MOST_EVALUATIONS.min(settings.most_evaluations),
            ..settings.clone()
        };
        let found = least_squares(&part, &settings, |part| {
            let mut at = self.residuals(&whole(part))?;
            at.jacobian = at.jacobian.select_columns(&places);
            Ok::<_, Failed>(at)
        });
        found.ok().map(|found| (whole(&found.x), found.evaluations))
    }
}
