//! The loop of every continuation: predictor–corrector steps along a tangent, whose length follows
//! the corrector (Allgower & Georg 2003, Ch. 6).

/// Shortest step. Chosen: behind it a branch that goes on could be followed with ever shorter
/// steps, each of which costs as much as a long one.
pub(super) const SHORTEST_STEP: f64 = 1e-7;

/// First step of a branch, as a fraction of the longest one. Chosen: later steps grow by 1.4 each.
pub(super) const FIRST_STEP: f64 = 0.1;

/// Ratio of a step to the one before, where that has found nothing. Chosen: a corrector that
/// diverges does so from farther away as well.
pub(super) const SHORTER: f64 = 0.3;

/// What a step of a continuation has come to.
pub(super) enum Outcome<End> {
    /// A solution, over a step of this length in so many iterations.
    Found { length: f64, iterations: usize },
    /// Another place from which the continuation goes on by steps of its own choice.
    Elsewhere,
    /// No solution that continues the last one; the next attempt has this length.
    Shortened(f64),
    /// No solution at any length.
    Lost,
    /// An end that the step itself shows.
    End(End),
}

/// A continuation, step by step.
pub(super) trait Stepping {
    /// The reason for its end.
    type End;

    /// Length of the next step, and that of the longest one.
    fn step(&mut self) -> (&mut f64, f64);

    /// Reason to end where it is.
    fn completed(&mut self) -> Option<Self::End>;

    /// Takes a step of at most this length.
    fn take_step(&mut self, length: f64) -> Outcome<Self::End>;

    /// Names the end behind which no solution was found.
    fn name_end(&mut self) -> Self::End;
}

/// Steps to the end of a continuation.
pub(super) fn follow<S: Stepping>(steps: &mut S) -> S::End {
    // Most iterations of a step behind which the next one is longer, and by how much. Chosen.
    const EASY: usize = 5;
    const LONGER: f64 = 1.4;
    loop {
        if let Some(end) = steps.completed() {
            return end;
        }
        let length = *steps.step().0;
        match steps.take_step(length) {
            Outcome::Found { length, iterations } => {
                let longer = if iterations <= EASY { LONGER } else { 1.0 };
                let (step, longest) = steps.step();
                *step = (longer * length).min(longest);
            }
            Outcome::Elsewhere => {}
            Outcome::Shortened(length) => {
                *steps.step().0 = length;
                if length < SHORTEST_STEP {
                    return steps.name_end();
                }
            }
            Outcome::Lost => return steps.name_end(),
            Outcome::End(end) => return end,
        }
    }
}
