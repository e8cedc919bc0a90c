//! The work of the searches for one minimum, all stages together.

use crate::study::least_squares::{LeastSquares, LeastSquaresSettings};

/// Steps and evaluations so far, of which there is a greatest number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FitWork {
    most: usize,
    pub(super) steps: usize,
    pub(super) evaluations: usize,
    pub(super) failures: usize,
    pub(super) crossings: usize,
    pub(super) jumps: usize,
}

impl FitWork {
    /// None, of at most so many evaluations.
    pub(super) fn of_at_most(most: usize) -> Self {
        FitWork {
            most,
            ..FitWork::default()
        }
    }

    /// Evaluations that are left.
    pub(super) fn left(&self) -> usize {
        self.most.saturating_sub(self.evaluations)
    }

    /// Settings of a search with the evaluations that are left; none where there are none.
    pub(super) fn settings_left(
        &self,
        settings: &LeastSquaresSettings,
    ) -> Option<LeastSquaresSettings> {
        let most_evaluations = self.left();
        (most_evaluations > 0).then(|| LeastSquaresSettings {
            most_evaluations,
            ..settings.clone()
        })
    }

    pub(super) fn add<P>(&mut self, search: &LeastSquares<P>) {
        self.steps += search.steps;
        self.evaluations += search.evaluations;
        self.failures += search.failures;
        self.crossings += search.crossings;
        self.jumps += search.jumps;
    }
}
