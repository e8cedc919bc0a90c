//! What makes the four numbers of Fig. 8, shown by injection: three parts, none of which was chosen
//! because it agrees.
//!
//! The two defects of the listing that outlast a vanishing step are put into the event-exact
//! solver, and must make the same motion and the published numbers as far as the listing's step
//! lets tell ([`SameMotion`]). The listing must come to those numbers as its step goes to zero, at
//! first order ([`Approach`]). And what is left at the printed step must be the listing's own error
//! of the step, found without the injected solver ([`StepError`]).

use std::fmt;

use super::convergence::{Approach, Convergence, PRINTED_STEP};
use crate::numbers::missing;
use crate::paper::pattern::Pattern;
use crate::paper::slip_times_three::{Injected, settled};
use crate::text::joined;
use stickslip::error::Error;

/// Half a unit of the last digit to which the paper prints the four numbers (m, s).
const HALF_DIGIT: f64 = 0.5e-4;

/// The settled motions with the defects injected.
#[derive(Clone, Debug, PartialEq)]
pub struct Injection {
    /// With both.
    pub both: Pattern,
    /// Its lengths of the two stick phases (m), then their durations (s).
    pub numbers: [f64; 4],
    /// With the hastened slip alone, or the error that the run ends with.
    pub slip_alone: Result<Pattern, Error>,
    /// With the one-sided exit alone.
    pub exit_alone: Result<Pattern, Error>,
}

impl Injection {
    /// Runs all three.
    ///
    /// # Errors
    /// Those of [`settled`] with both defects; [`Error::NotFound`] if no two stick phases are left.
    pub fn compute() -> Result<Injection, Error> {
        let both = settled(Injected::BOTH)?;
        let numbers = both.four_numbers();
        let numbers = numbers.ok_or_else(|| missing("a pair of stick phases", 0.0, both.end))?;
        Ok(Injection {
            both,
            numbers,
            slip_alone: settled(Injected::SLIP_ALONE),
            exit_alone: settled(Injected::EXIT_ALONE),
        })
    }

    /// What either defect does alone, in words.
    pub fn alone(&self) -> String {
        let of = |run: &Result<Pattern, Error>| match run {
            Ok(pattern) => format!(
                "stick phases: {}, period {}",
                pattern.sticks_of_one().count(),
                pattern.period
            ),
            Err(error) => format!("no settled motion: {error}"),
        };
        format!(
            "Of the two alone: slip three times too fast, {}; exit tested at one end, {}.",
            of(&self.slip_alone),
            of(&self.exit_alone)
        )
    }
}

/// Whether a cause is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All three parts hold.
    Shown,
    /// One does not.
    ShownInPart,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Status::Shown => "shown",
            Status::ShownInPart => "shown in part",
        })
    }
}

/// (a) What the event-exact solver does with defects injected, beside the listing and the published
/// numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct SameMotion {
    /// The listing at the printed step.
    pub listing: Pattern,
    /// The event-exact solver with the defects, or the error that it ends with.
    pub injected: Result<Pattern, Error>,
    /// Its four numbers less the published ones (m, m, s, s).
    pub differences: Option<[f64; 4]>,
    /// How far they may be off (m, m, s, s), see [`SameMotion::most`].
    pub most: [f64; 4],
}

impl SameMotion {
    /// Sets a motion with injected defects beside the listing's and the published numbers (m, m, s,
    /// s).
    pub fn new(
        listing: &Pattern,
        injected: Result<Pattern, Error>,
        published: [f64; 4],
        most: [f64; 4],
    ) -> SameMotion {
        let numbers = injected.as_ref().ok().and_then(Pattern::four_numbers);
        SameMotion {
            differences: numbers.map(|four| std::array::from_fn(|i| four[i] - published[i])),
            listing: listing.clone(),
            injected,
            most,
        }
    }

    /// How far the numbers of a solver without a step may be off those that the listing prints at
    /// its step (m, m, s, s): what the listing's own numbers move by from there to a vanishing
    /// step, found without any solver, and half a printed digit.
    pub fn most(convergence: &Convergence) -> [f64; 4] {
        // The finest step stands for none and errs by its own part of the bound, once in the bound
        // and once here.
        let finest = convergence.finest().map_or(f64::NAN, |finest| finest.h);
        let own = convergence.own_approach.each_ref();
        own.map(|one| one.bound * (PRINTED_STEP + 2.0 * finest) + HALF_DIGIT)
    }

    /// Whether both motions are of the same kind, [`Pattern::same_motion`].
    pub fn same_kind(&self) -> bool {
        let injected = self.injected.as_ref();
        injected.is_ok_and(|injected| injected.same_motion(&self.listing))
    }

    /// Whether the motion is the same and the four numbers are the published ones as far as can be
    /// told.
    pub fn holds(&self) -> bool {
        let near = |four: [f64; 4]| four.iter().zip(self.most).all(|(d, most)| d.abs() <= most);
        self.same_kind() && self.differences.is_some_and(near)
    }

    /// In words.
    pub fn sentence(&self) -> String {
        match &self.injected {
            Ok(injected) => {
                let kind = |pattern: &Pattern| {
                    format!(
                        "{} stick phases in {} forcing periods, {} deflections",
                        pattern.sticks_of_one().count(),
                        pattern.period,
                        pattern.deflections().len()
                    )
                };
                let off = self.differences.map_or_else(
                    || "no two stick phases to compare".to_owned(),
                    |[l1, l2, d1, d2]| {
                        format!(
                            "off the published lengths by {} and {} mm, off the durations by {} and {} ms, where {} are allowed",
                            thousandths(l1),
                            thousandths(l2),
                            thousandths(d1),
                            thousandths(d2),
                            self.most.map(|most| format!("{:.3}", 1e3 * most)).join(", ")
                        )
                    },
                );
                format!(
                    "in the event-exact solver the injected defects give {} (the listing: {}), {off}",
                    kind(injected),
                    kind(&self.listing)
                )
            }
            Err(error) => {
                format!("in the event-exact solver the injected defects give no motion: {error}")
            }
        }
    }
}

/// (c) What is left at the printed step, by the injected solver and by the listing alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepError {
    /// The finest step (s), which stands for the listing's own limit.
    pub finest: f64,
    /// The listing at the printed step less the injected solver (m, m, s, s).
    pub left: [f64; 4],
    /// The listing at the printed step less the listing at the finest: its own error of the step,
    /// by itself alone.
    pub own: [f64; 4],
    /// The bound C h on `left` at the printed step, from the other steps.
    pub most_left: [f64; 4],
    /// The bound on `own` from the listing alone, from the other steps.
    pub most_own: [f64; 4],
    /// How far `own` and `left` may be apart: the bound at the finest step, from the listing alone.
    pub most_apart: [f64; 4],
    /// Whether the listing at the printed step gives all four published numbers to all printed
    /// digits.
    pub published: bool,
}

impl StepError {
    fn new(convergence: &Convergence) -> Option<StepError> {
        let (finest, printed) = (convergence.finest()?, convergence.printed()?);
        let (limit, at) = (finest.numbers?, printed.numbers?);
        let own = convergence.own_approach.each_ref().map(|one| one.bound);
        Some(StepError {
            finest: finest.h,
            left: std::array::from_fn(|i| at[i] - convergence.limit[i]),
            own: std::array::from_fn(|i| at[i] - limit[i]),
            most_left: convergence
                .approach
                .each_ref()
                .map(|one| one.bound * PRINTED_STEP),
            most_own: own.map(|bound| bound * (PRINTED_STEP + finest.h)),
            most_apart: own.map(|bound| bound * finest.h),
            published: printed.gives_digits(),
        })
    }

    /// Whether what is left is within its bound, the listing's own error within its own, and both
    /// the same.
    pub fn holds(&self) -> bool {
        self.published
            && (0..4).all(|i| {
                self.left[i].abs() <= self.most_left[i]
                    && self.own[i].abs() <= self.most_own[i]
                    && (self.own[i] - self.left[i]).abs() <= self.most_apart[i]
            })
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let four = |of: &[f64; 4]| of.map(thousandths).join(", ");
        let allowed = self.most_left.map(|most| format!("{:.3}", 1e3 * most));
        format!(
            "at h = {PRINTED_STEP:e} s the listing is off the injected solver by {} (mm, mm, ms, ms), where {} are allowed, and off itself at \
             h = {:e} s by {}",
            four(&self.left),
            allowed.join(", "),
            self.finest,
            four(&self.own)
        )
    }
}

/// What makes Fig. 8's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// (a) The injected defects make the same motion and nearly the same numbers.
    pub motion: SameMotion,
    /// (b) How the listing's numbers approach those of the injected solver.
    pub approach: [Approach; 4],
    /// (c) What is left at the printed step; nothing where the listing has no four numbers.
    pub step: Option<StepError>,
}

impl Cause {
    /// From the listing at the printed step, the event-exact solver with the defects, the listing's
    /// convergence and the published numbers (m, m, s, s).
    pub fn new(
        listing: &Pattern,
        injected: Pattern,
        convergence: &Convergence,
        published: [f64; 4],
    ) -> Cause {
        Cause {
            motion: SameMotion::new(
                listing,
                Ok(injected),
                published,
                SameMotion::most(convergence),
            ),
            approach: convergence.approach,
            step: StepError::new(convergence),
        }
    }

    /// Whether the numbers go to those of the injected solver at first order.
    pub fn first_order(&self) -> bool {
        self.approach.iter().all(Approach::first_order)
    }

    /// Whether what is left at the printed step is the listing's own error of the step.
    pub fn is_step_error(&self) -> bool {
        self.step.as_ref().is_some_and(StepError::holds)
    }

    /// Whether the cause is shown.
    pub fn status(&self) -> Status {
        if self.motion.holds() && self.first_order() && self.is_step_error() {
            Status::Shown
        } else {
            Status::ShownInPart
        }
    }

    /// The three parts in words, and whether each holds.
    pub fn parts(&self) -> [(String, bool); 3] {
        let bounds = self.approach.iter().map(|one| {
            let (bound, slope, error) = (one.bound, one.slope, one.slope_error);
            format!("{bound:.1} h (slope {slope:.2} ± {error:.2})")
        });
        let left = self.step.as_ref().map_or_else(
            || "the listing has no four numbers at the printed step".to_owned(),
            StepError::sentence,
        );
        [
            (self.motion.sentence(), self.motion.holds()),
            (
                format!(
                    "as the step goes to zero the listing's numbers approach them within {}",
                    joined(bounds, ", ")
                ),
                self.first_order(),
            ),
            (left, self.is_step_error()),
        ]
    }
}

/// In thousandths of the unit, with the sign.
fn thousandths(value: f64) -> String {
    format!("{:+.3}", 1e3 * value)
}
