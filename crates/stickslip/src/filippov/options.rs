//! Settings of the solver.

use super::absolute::AbsoluteTolerance;
use crate::dynamics::Vector;
use crate::error::{Error, require};
use crate::ode::Tolerance;

/// Integrator that makes the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Order 8 with adaptive steps ([`crate::ode::Dop853`]); the default.
    Dop853,
    /// Taylor series of the solution with adaptive steps; the order follows from the tolerance. The
    /// fastest method for errors of 1e-9 and less.
    ///
    /// The field runs once for each order, on numbers that carry their own recurrences.
    /// `#[inline(always)]` on the user's functions saves a third of the time.
    ///
    /// Events are zeros of the boundary function's series, isolated with certainty, so that
    /// `locator` has no effect. Where a field or boundary uses `max`, `min`, `abs` or
    /// [`crate::Scalar::exceeds`], a step ends where the comparison changes. It also ends where a
    /// function becomes flat to rounding or negligible beside one. These bounds are ±17 for `tanh`,
    /// ±5.57 for `erf`, and ±37 for `exp`, `cosh` and `sinh`.
    ///
    /// Other flat and narrow features (a high power of `1/(1 + x²)`) need
    /// [`Options::longest_step`]. A function that branches on [`crate::Scalar::value`] is sampled,
    /// as for Runge–Kutta steps. If such a branch bends it sharply, two crossings close to the bend
    /// can be missed.
    Taylor,
    /// The classical method of order 4 with a fixed step ([`crate::ode::Rk4`]).
    Rk4 {
        /// Step length.
        step: f64,
    },
}

/// Location of an event inside a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Locator {
    /// A step to the event of the dense output, then one Hénon step over the small rest. The Hénon
    /// step has order 4 if the rest is below a thousandth of the step. Near grazing the swapped
    /// slope is nearly singular, and [`Locator::RootSearch`] is used. Accurate to the order of the
    /// method; lands on Σ to a few units in the last place.
    #[default]
    Auto,
    /// One Hénon step from the start of the integration step that crosses.
    /// Further ones follow while a curved Σ leaves more than rounding. [`Locator::RootSearch`]
    /// takes over if the slope is nearly singular. With adaptive steps it also does if an ordinary
    /// step of that length misses by more than the tolerance.
    Henon,
    /// A safeguarded root search (Newton within a bracket) on re-integrated steps.
    RootSearch,
}

/// Behaviour where the future is not unique. This is where Σ repels (both fields lead away), and
/// at a two-fold (both fields are tangent to Σ) that the orbit slides into. At a two-fold a side is
/// chosen if its field is visible there; otherwise the run continues by the rules. With several
/// contacts ([`crate::Several`]) nothing is chosen: the run ends with an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AtRepelling {
    /// Stop there; the orbit's ending says so.
    #[default]
    Stop,
    /// Continue below Σ.
    GoBelow,
    /// Continue above Σ.
    GoAbove,
}

/// Behaviour where infinitely many transitions accumulate in finite time (Zeno).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum AtPileUp {
    /// End there, with [`crate::Error::EventPileUp`] or, at a two-fold of one contact, with
    /// [`crate::Ending::TwoFold`].
    #[default]
    Stop,
    /// Continue from the accumulation point with all contacts that pile up there in stick, if
    /// friction can hold them all at once. Otherwise end as by default. A start at such a point,
    /// and a state there behind a jump or a kink, stays there, too.
    ///
    /// The last phase is a straight line to that point. One transition into the mode of rest
    /// follows, a [`crate::TransitionKind::StickEntry`]. The flow has no derivative there.
    Rest,
}

/// Settings of the solver; `Options::default()` suits most systems.
///
/// ```
/// use stickslip::{Method, Options};
/// let strict = Options::tol(1e-13).escape(1e3);
/// let fixed = Options::default().method(Method::Rk4 { step: 1e-3 });
/// assert_eq!(strict.rtol, 1e-13);
/// assert_eq!(fixed.rtol, Options::default().rtol);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative error allowed per step; default 1e-10.
    pub rtol: f64,
    /// Absolute error allowed per step, for all states or for each, in their units; default 1e-10.
    /// States that stay far below it are not resolved. Where an analysis compares whole states, the
    /// largest counts; a distance from a boundary is zero by the smallest.
    pub atol: AbsoluteTolerance,
    /// Integrator; default [`Method::Dop853`].
    pub method: Method,
    /// Event location; default [`Locator::Auto`].
    pub locator: Locator,
    /// Longest step; default unbounded (the last step may be 1 % longer). Error control samples the
    /// field at a few places of each step. Set a bound for a push in slip, or a feature of a
    /// boundary, that is much narrower than the solution's own features.
    pub longest_step: f64,
    /// First step; default chosen from the field.
    pub first_step: Option<f64>,
    /// Largest component (by size) that the state may have; beyond it the run ends with
    /// [`Error::Escaped`]. Default unbounded.
    pub escape: f64,
    /// Behaviour where Σ repels; default stop.
    pub at_repelling: AtRepelling,
    /// Behaviour where transitions accumulate; default stop.
    pub at_pile_up: AtPileUp,
    /// A contact with Σ that reaches no deeper than this many tolerances is a touch, not a pair of
    /// crossings. The solution itself is not more accurate. Default 10.
    pub touch: f64,
    /// Least number of consecutive transitions that are a pile-up. They happen within
    /// `pile_up_span · max(1, |t|)`, all others would at the ratio of their durations, and the
    /// motion between them shrinks. Or no component moves by more than 100 tolerances between any
    /// two, the motion shrinks further, and nothing depends on time but what piles up in finite
    /// time. With [`Method::Taylor`] this is also the number of reversals of the field by a
    /// comparison between which only rounding moves the orbit. Default 100. Fewer transitions are a
    /// pile-up if their durations are a geometric series and the steps after them collapse. They
    /// also are if the tolerance does not separate the contacts' boundaries.
    pub pile_up_count: usize,
    /// See `pile_up_count`; default 1e-7.
    pub pile_up_span: f64,
    /// A run with more transitions than this ends with [`Error::TooMany`]; default 10⁷.
    pub most_events: u64,
    /// Largest number of steps; default 10⁹.
    pub most_steps: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            rtol: 1e-10,
            atol: 1e-10.into(),
            method: Method::Dop853,
            locator: Locator::Auto,
            longest_step: f64::INFINITY,
            first_step: None,
            escape: f64::INFINITY,
            at_repelling: AtRepelling::Stop,
            at_pile_up: AtPileUp::Stop,
            touch: 10.0,
            pile_up_count: 100,
            pile_up_span: 1e-7,
            most_events: 10_000_000,
            most_steps: 10_000_000,
        }
    }
}

/// Smallest relative tolerance: a few units in the last place of a double.
pub(crate) const MIN_TOLERANCE: f64 = 1e-15;
/// Smallest absolute tolerance: those of smaller errors would lose digits.
pub(crate) const MIN_ABSOLUTE: f64 = 1e-280;
/// Largest tolerance. Chosen: above it a method of order 8 does not follow the solution.
const MAX_TOLERANCE: f64 = 0.1;

impl Options {
    /// The defaults with both tolerances set to `tolerance`.
    pub fn tol(tolerance: f64) -> Self {
        Options {
            rtol: tolerance,
            atol: tolerance.into(),
            ..Options::default()
        }
    }

    /// Sets the integrator.
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Options { method, ..self }
    }

    /// Sets the event location.
    #[must_use]
    pub fn locator(self, locator: Locator) -> Self {
        Options { locator, ..self }
    }

    /// Sets the bound on the components of the state.
    #[must_use]
    pub fn escape(self, bound: f64) -> Self {
        Options {
            escape: bound,
            ..self
        }
    }

    /// Sets the longest step.
    #[must_use]
    pub fn longest_step(self, step: f64) -> Self {
        Options {
            longest_step: step,
            ..self
        }
    }

    /// Sets the choice where Σ repels.
    #[must_use]
    pub fn at_repelling(self, choice: AtRepelling) -> Self {
        Options {
            at_repelling: choice,
            ..self
        }
    }

    /// Sets the choice where transitions accumulate.
    #[must_use]
    pub fn at_pile_up(self, choice: AtPileUp) -> Self {
        Options {
            at_pile_up: choice,
            ..self
        }
    }

    /// Sets the absolute tolerance: a number for all states, or an [`AbsoluteTolerance`] with one
    /// for each.
    #[must_use]
    pub fn atol(self, atol: impl Into<AbsoluteTolerance>) -> Self {
        Options {
            atol: atol.into(),
            ..self
        }
    }

    /// Error that a step may make in a component of this size.
    #[inline(always)]
    pub fn allowed(&self, component: usize, size: f64) -> f64 {
        self.atol.of(component) + self.rtol * size
    }

    /// The largest error that a step may make in a component of a state.
    pub fn largest_allowed(&self, x: &Vector) -> f64 {
        let each = x.iter().enumerate();
        each.fold(0.0, |most: f64, (i, x)| most.max(self.allowed(i, x.abs())))
    }

    /// The largest of the tolerances, relative and absolute.
    pub fn coarsest(&self) -> f64 {
        self.rtol.max(self.atol.largest())
    }

    /// The tolerance by which methods choose their order: the relative one, unless every absolute
    /// one is larger.
    pub(crate) fn finest(&self) -> f64 {
        self.rtol.max(self.atol.smallest())
    }

    /// The tolerances as the step-size control takes them.
    #[inline(always)]
    pub(crate) fn tolerance<const N: usize>(&self) -> Tolerance<N> {
        Tolerance {
            rtol: self.rtol,
            atol: self.atol.components(),
        }
    }

    /// The fixed step, if there is one.
    pub(crate) fn fixed_step(&self) -> Option<f64> {
        match self.method {
            Method::Dop853 | Method::Taylor => None,
            Method::Rk4 { step } => Some(step),
        }
    }

    /// Checks that a run to a time that was asked for is possible within
    /// [`Options::most_steps`]: all its steps are at most [`Options::longest_step`]. A run that may
    /// end earlier, by an event say, needs no such check.
    ///
    /// # Errors
    /// [`Error::TooShortSteps`].
    pub fn check_span(&self, t: f64, t_end: f64) -> Result<(), Error> {
        if !t.is_finite() || !t_end.is_finite() {
            return Err(Error::Interval { t0: t, t_end });
        }
        let (most_steps, longest_step) = (self.most_steps, self.longest_step);
        let least = (t_end - t) / most_steps as f64;
        if longest_step >= least || self.fixed_step().is_some() {
            return Ok(());
        }
        Err(Error::TooShortSteps {
            longest_step,
            least,
            most_steps,
            t_end,
        })
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Option`] with name, value and bound of the first that is not allowed.
    pub fn check(&self) -> Result<(), Error> {
        let allowed = |tol: f64, least: f64| (least..=MAX_TOLERANCE).contains(&tol);
        let is_allowed = allowed(self.rtol, MIN_TOLERANCE);
        require(is_allowed, "rtol", self.rtol, "between 1e-15 and 0.1")?;
        let common = self.atol.smallest();
        let given = self.atol.values().iter().copied();
        for atol in given.chain([common]) {
            let is_allowed = allowed(atol, MIN_ABSOLUTE);
            require(is_allowed, "atol", atol, "between 1e-280 and 0.1")?;
        }
        if let Some(step) = self.fixed_step() {
            let good = step > 0.0 && step.is_finite();
            require(good, "method.step", step, "positive and finite")?;
        }
        if let Some(step) = self.first_step {
            let good = step > 0.0 && step.is_finite();
            require(good, "first_step", step, "positive and finite")?;
        }
        require(
            self.longest_step > 0.0,
            "longest_step",
            self.longest_step,
            "positive",
        )?;
        require(self.escape > 0.0, "escape", self.escape, "positive")?;
        let touch = self.touch >= 0.0 && self.touch.is_finite();
        require(touch, "touch", self.touch, "finite and at least 0")?;
        let count = self.pile_up_count as f64;
        require(
            self.pile_up_count >= 2,
            "pile_up_count",
            count,
            "at least 2",
        )?;
        let span = self.pile_up_span > 0.0 && self.pile_up_span.is_finite();
        require(
            span,
            "pile_up_span",
            self.pile_up_span,
            "positive and finite",
        )
    }
}
