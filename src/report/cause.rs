//! The cause of the four numbers of Fig. 8, shown by injection in three parts. No part was chosen
//! because it agrees.
//!
//! Two defects of the listing remain as the step goes to zero. Injected into the event-exact
//! solver, they must give the same motion, and the published numbers within the listing's step
//! error ([`MotionComparison`]). The listing must converge to those numbers at first order as its
//! step goes to zero ([`Approach`]). The difference at the printed step must be the listing's own
//! step error, which is measured without the injected solver ([`StepError`]).

use super::convergence::{Approach, Convergence};
use crate::numbers::not_found;
use crate::paper::listing::PRINTED_STEP;
use crate::paper::pattern::Pattern;
use crate::paper::published::HALF_DIGIT;
use crate::paper::slip_times_three::{InjectedDefects, settled};
use crate::text::joined;
use stickslip::Error;

/// Two stick lengths (m), then their durations (s).
type StickNumbers = [f64; 4];

/// The settled motions with the defects injected.
#[derive(Clone, Debug, PartialEq)]
pub struct Injection {
    /// Pattern with both defects.
    pub both: Pattern,
    /// Four numbers.
    pub numbers: StickNumbers,
    /// Pattern with the faster slip alone, or the error that ends the run.
    pub slip_alone: Result<Pattern, Error>,
    /// Pattern with the one-sided exit alone, or the error that ends the run.
    pub exit_alone: Result<Pattern, Error>,
}

impl Injection {
    /// Runs all three.
    ///
    /// # Errors
    /// Those of [`settled`] with both defects; [`Error::NotFound`] if fewer than two stick phases
    /// remain.
    pub fn compute() -> Result<Injection, Error> {
        let both = settled(InjectedDefects::BOTH)?;
        let numbers = both.stick_numbers();
        let numbers = numbers.ok_or_else(|| not_found("a pair of stick phases", 0.0, both.end))?;
        Ok(Injection {
            both,
            numbers,
            slip_alone: settled(InjectedDefects::SLIP_ALONE),
            exit_alone: settled(InjectedDefects::EXIT_ALONE),
        })
    }

    /// The effect of either defect alone, in words.
    pub fn separate_effects(&self) -> String {
        let of = |run: &Result<Pattern, Error>| match run {
            Ok(pattern) => {
                let (sticks, period) = (pattern.pattern_sticks().count(), pattern.period);
                format!("stick phases: {sticks}, period {period}")
            }
            Err(error) => format!("no settled motion: {error}"),
        };
        let (slip, exit) = (of(&self.slip_alone), of(&self.exit_alone));
        format!(
            "Of the two alone: slip three times too fast, {slip}; exit tested at one end, {exit}."
        )
    }
}

fn within_bounds(values: &StickNumbers, allowed_differences: &StickNumbers) -> bool {
    let mut pairs = values.iter().zip(allowed_differences);
    pairs.all(|(one, allowed_differences)| one.abs() <= *allowed_differences)
}

/// (a) The event-exact solver with defects injected, compared with the listing and the published
/// numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionComparison {
    /// The listing at the printed step.
    pub listing: Pattern,
    /// The event-exact solver with the defects, or the error that ends its run.
    pub injected: Result<Pattern, Error>,
    /// Four numbers minus the published ones.
    pub differences: Option<StickNumbers>,
    /// Allowed size of the differences, see [`MotionComparison::allowed_differences`].
    pub allowed_differences: StickNumbers,
}

impl MotionComparison {
    /// Compares a motion with injected defects with the listing's and the published numbers.
    pub fn new(
        listing: &Pattern,
        injected: Result<Pattern, Error>,
        published: StickNumbers,
        allowed_differences: StickNumbers,
    ) -> MotionComparison {
        let numbers = injected.as_ref().ok().and_then(Pattern::stick_numbers);
        MotionComparison {
            differences: numbers.map(|four| std::array::from_fn(|i| four[i] - published[i])),
            listing: listing.clone(),
            injected,
            allowed_differences,
        }
    }

    /// Allowed difference between a solver without a step error and the published numbers. It is
    /// the step error of the listing at its step, measured without another solver, plus half a
    /// printed digit.
    pub fn allowed_differences(convergence: &Convergence) -> StickNumbers {
        // The finest step represents the limit and has its own step error. That enters once in the
        // bound and once here.
        let finest = convergence.finest().map_or(f64::NAN, |finest| finest.h);
        let own = convergence.own_approach.each_ref();
        own.map(|one| one.bound * (PRINTED_STEP + 2.0 * finest) + HALF_DIGIT)
    }

    /// Whether both motions are of the same kind ([`Pattern::same_motion`]) and the four numbers
    /// equal the published ones within the allowed differences.
    pub fn holds(&self) -> bool {
        let injected = self.injected.as_ref();
        injected.is_ok_and(|injected| injected.same_motion(&self.listing))
            && self
                .differences
                .is_some_and(|four| within_bounds(&four, &self.allowed_differences))
    }

    /// Describes the cause in words.
    pub fn sentence(&self) -> String {
        let kind = |pattern: &Pattern| {
            let (sticks, period) = (pattern.pattern_sticks().count(), pattern.period);
            let deflections = pattern.deflections().len();
            format!("{sticks} stick phases in {period} forcing periods, {deflections} deflections")
        };
        let injected = match &self.injected {
            Ok(injected) => kind(injected),
            Err(error) => {
                return format!(
                    "in the event-exact solver the injected defects give no motion: {error}"
                );
            }
        };
        let off = match self.differences {
            None => "no two stick phases to compare".to_owned(),
            Some(differences) => {
                let [l1, l2, d1, d2] = differences.map(thousandths);
                let allowed_differences = joined(self.allowed_differences.map(allowed), ", ");
                format!(
                    "off the published lengths by {l1} and {l2} mm, off the durations by {d1} and \
                        {d2} ms, where {allowed_differences} are allowed"
                )
            }
        };
        let listing = kind(&self.listing);
        format!(
            "in the event-exact solver the injected defects give {injected} (the listing: \
                {listing}), {off}"
        )
    }
}

/// (c) The difference at the printed step, by the injected solver and by the listing alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepError {
    /// The finest step (s), which represents the listing's own limit.
    pub finest: f64,
    /// The listing at the printed step minus the injected solver, and its bound C h from the other
    /// steps.
    pub step_difference: StickNumbers,
    step_bound: StickNumbers,
    /// The listing at the printed step minus the listing at the finest: its own step error. The
    /// bound on it is from the listing alone, at the other steps.
    own_error: StickNumbers,
    own_bound: StickNumbers,
    /// Allowed difference of `own_error` and `step_difference`: the bound at the finest step, from
    /// the listing alone.
    allowed_gap: StickNumbers,
    /// Whether the listing at the printed step gives all printed digits of the four published
    /// numbers.
    published: bool,
}

impl StepError {
    fn new(convergence: &Convergence) -> Option<StepError> {
        let (finest, printed) = (convergence.finest()?, convergence.printed()?);
        let (limit, at) = (finest.numbers?, printed.numbers?);
        let approach = convergence.approach.each_ref();
        let own = convergence.own_approach.each_ref().map(|one| one.bound);
        Some(StepError {
            finest: finest.h,
            step_difference: std::array::from_fn(|i| at[i] - convergence.limit[i]),
            step_bound: approach.map(|one| one.bound * PRINTED_STEP),
            own_error: std::array::from_fn(|i| at[i] - limit[i]),
            own_bound: own.map(|bound| bound * (PRINTED_STEP + finest.h)),
            allowed_gap: own.map(|bound| bound * finest.h),
            published: printed.gives_digits(),
        })
    }

    /// Whether both differences are within their bounds and equal within the allowed difference.
    pub fn holds(&self) -> bool {
        let apart = std::array::from_fn(|i| self.own_error[i] - self.step_difference[i]);
        self.published
            && within_bounds(&self.step_difference, &self.step_bound)
            && within_bounds(&self.own_error, &self.own_bound)
            && within_bounds(&apart, &self.allowed_gap)
    }

    /// Describes the check in words.
    pub fn sentence(&self) -> String {
        let [left, own] =
            [self.step_difference, self.own_error].map(|four| joined(four.map(thousandths), ", "));
        let (bounds, finest) = (joined(self.step_bound.map(allowed), ", "), self.finest);
        format!(
            "at h = {PRINTED_STEP:e} s the listing is off the injected solver by {left} (mm, mm, \
             ms, ms), where {bounds} are allowed, and off itself at h = {finest:e} s by {own}"
        )
    }
}

/// The cause of Fig. 8's numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// (a) The injected defects give the same motion and nearly the same numbers.
    pub motion: MotionComparison,
    /// (b) Convergence of the listing's numbers to those of the injected solver.
    pub approach: [Approach; 4],
    /// (c) The difference at the printed step; `None` where the listing has no four numbers.
    pub step: Option<StepError>,
}

impl Cause {
    /// Compares the listing at the printed step, the event-exact solver with the defects, the
    /// listing's convergence and the published numbers.
    pub fn new(
        listing: &Pattern,
        injected: Pattern,
        convergence: &Convergence,
        published: StickNumbers,
    ) -> Cause {
        let allowed_differences = MotionComparison::allowed_differences(convergence);
        Cause {
            motion: MotionComparison::new(listing, Ok(injected), published, allowed_differences),
            approach: convergence.approach,
            step: StepError::new(convergence),
        }
    }

    /// Whether the numbers converge to those of the injected solver at first order.
    pub fn first_order(&self) -> bool {
        self.approach.iter().all(Approach::first_order)
    }

    /// Whether the difference at the printed step is the listing's own step error.
    pub fn is_step_error(&self) -> bool {
        self.step.as_ref().is_some_and(StepError::holds)
    }

    /// Whether all three parts hold.
    pub fn is_shown(&self) -> bool {
        self.motion.holds() && self.first_order() && self.is_step_error()
    }

    /// The result in words.
    pub fn status(&self) -> &'static str {
        if self.is_shown() {
            "shown"
        } else {
            "shown in part"
        }
    }

    /// The three parts in words, and whether each holds.
    pub fn parts(&self) -> [(String, bool); 3] {
        let bounds = self.approach.iter().map(|one| {
            let (bound, slope, error) = (one.bound, one.slope, one.slope_error);
            format!("{bound:.1} h (slope {slope:.2} ± {error:.2})")
        });
        let bounds = joined(bounds, ", ");
        let approach =
            format!("as the step goes to zero the listing's numbers approach them within {bounds}");
        let none = || "the listing has no four numbers at the printed step".to_owned();
        let left = self.step.as_ref().map_or_else(none, StepError::sentence);
        [
            (self.motion.sentence(), self.motion.holds()),
            (approach, self.first_order()),
            (left, self.is_step_error()),
        ]
    }
}

/// Formats a number in thousandths of the unit, with the sign.
fn thousandths(value: f64) -> String {
    format!("{:+.3}", 1e3 * value)
}

/// A number without its sign.
fn allowed(value: f64) -> String {
    format!("{:.3}", 1e3 * value)
}
