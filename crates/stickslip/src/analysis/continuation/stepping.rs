//! The loop of every continuation: predictor–corrector steps along a tangent, whose length follows
//! the corrector (Allgower & Georg 2003, Ch. 6).

/// Shortest step of orbits. Chosen: behind it a branch that goes on could be followed with ever
/// shorter steps, each of which costs as much as a long one.
pub(super) const SHORTEST_STEP: f64 = 1e-7;

/// First step of a branch, as a fraction of the longest one. Chosen: later steps grow by 1.4 each.
pub(super) const FIRST_STEP: f64 = 0.1;

/// Ratio of a step to the one before, where that has found nothing. Chosen: a corrector that
/// diverges does so from farther away as well.
pub(super) const SHORTER: f64 = 0.3;

/// Outcome of a step of a continuation.
pub(super) enum StepOutcome<End> {
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

    /// Shortest step.
    const SHORTEST: f64 = SHORTEST_STEP;

    /// Length of the next step, and that of the longest one.
    fn step(&mut self) -> (&mut f64, f64);

    /// Reason to end where it is.
    fn completed(&mut self) -> Option<Self::End>;

    /// Takes a step of at most this length.
    fn take_step(&mut self, length: f64) -> StepOutcome<Self::End>;

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
            StepOutcome::Found { length, iterations } => {
                let longer = if iterations <= EASY { LONGER } else { 1.0 };
                let (step, longest) = steps.step();
                *step = (longer * length).min(longest);
            }
            StepOutcome::Elsewhere => {}
            StepOutcome::Shortened(length) => {
                *steps.step().0 = length;
                if length < S::SHORTEST {
                    return steps.name_end();
                }
            }
            StepOutcome::Lost => return steps.name_end(),
            StepOutcome::End(end) => return end,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line on which no step of more than the distance to its end finds anything.
    struct ToEnd {
        at: f64,
        end: f64,
        step: f64,
        taken: Vec<f64>,
    }

    impl Stepping for ToEnd {
        type End = &'static str;

        fn step(&mut self) -> (&mut f64, f64) {
            (&mut self.step, 0.3)
        }

        fn completed(&mut self) -> Option<&'static str> {
            (self.taken.len() == 1000).then_some("enough")
        }

        fn take_step(&mut self, length: f64) -> StepOutcome<&'static str> {
            if self.at + length > self.end {
                return StepOutcome::Shortened(SHORTER * length);
            }
            self.at += length;
            self.taken.push(length);
            let iterations = if self.at > 0.5 { 6 } else { 5 };
            StepOutcome::Found { length, iterations }
        }

        fn name_end(&mut self) -> &'static str {
            "the end"
        }
    }

    #[test]
    fn steps_grow_to_the_longest_and_shrink_to_the_end() {
        let begin = |end: f64| ToEnd {
            at: 0.0,
            end,
            step: 0.01,
            taken: Vec::new(),
        };
        let mut steps = begin(1.0);
        assert_eq!(follow(&mut steps), "the end");
        assert!((1.0 - SHORTEST_STEP / SHORTER..=1.0).contains(&steps.at));
        let easy = steps.taken.windows(2).take_while(|two| two[0] < two[1]);
        let easy = easy.map(|two| two[1] / two[0]).collect::<Vec<_>>();
        assert!(easy.len() > 5 && easy.iter().all(|ratio| (ratio - 1.4).abs() < 1e-12));
        // A corrector that labours keeps the length.
        let largest = steps
            .taken
            .iter()
            .fold(0.0, |most: f64, one| most.max(*one));
        assert!(largest < 0.3 && steps.taken.iter().filter(|one| **one == largest).count() > 1);
        let mut endless = begin(f64::INFINITY);
        assert_eq!(
            (follow(&mut endless), endless.taken.len()),
            ("enough", 1000)
        );
    }
}
