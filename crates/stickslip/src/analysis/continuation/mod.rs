//! Continuation of periodic orbits, stable or not, along a parameter through folds and changes of
//! their phases.

mod both_ways;
mod crossings;
mod curve;
mod ends;
mod equilibrium;
mod equilibrium_curve;
mod homoclinic;
mod sequence_changes;
mod stepping;
mod steps;
mod switching;
mod tangent_line;
mod test_functions;

use std::fmt;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use nalgebra::Complex;

use super::critical::Critical;
use super::cycle::{Cycle, SequenceChange, Shooting};
use super::normal_form::NormalForm;
use super::stability::Stability;
use crate::dynamics::{AsDynamics, Components, Modes, Vector};
use crate::error::{Error, require};
use crate::filippov::Options;
pub use curve::{Curve, CurveBifurcation, CurvePoint, CurveSpecialPoint, CurveStop};
pub(super) use ends::{is_led, same_attractor};
pub use equilibrium::{
    EquilibriumBifurcation, EquilibriumBranch, EquilibriumPoint, SpecialEquilibrium,
};
pub use equilibrium_curve::{
    EquilibriumCurve, EquilibriumCurveBifurcation, EquilibriumCurvePoint, EquilibriumCurveSpecial,
};
pub(super) use steps::Continuation;
pub use switching::SwitchedBranch;
use tangent_line::{TangentLine, Units};

/// The range and the step sizes of a continuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuationSettings {
    /// The branch ends where the parameter leaves this range.
    pub range: (f64, f64),
    /// First and longest step, as a fraction of the range and of the orbit's size. Default 0.02.
    pub step: f64,
    /// Largest number of orbits on the branch. Default 1000.
    pub most_points: usize,
    /// The period of the first orbit, where the forcing prescribes it. Where the parameter changes
    /// it, the system tells the forcing's period: [`crate::Filippov::period`].
    pub forced: Option<f64>,
}

impl ContinuationSettings {
    /// The defaults, in this range.
    pub fn over(from: f64, to: f64) -> Self {
        ContinuationSettings {
            range: (from.min(to), from.max(to)),
            step: 0.02,
            most_points: 1000,
            forced: None,
        }
    }

    /// Sets the period of the first orbit, a multiple of the forcing's.
    #[must_use]
    pub fn forced(self, period: f64) -> Self {
        ContinuationSettings {
            forced: Some(period),
            ..self
        }
    }

    /// Checks the settings, as [`continue_periodic_orbit`] does first.
    ///
    /// # Errors
    /// [`Error::Option`] for the first one that is out of bounds.
    pub fn check(&self) -> Result<(), Error> {
        let width = self.range.1 - self.range.0;
        let is_range = width > 0.0 && width.is_finite();
        let is_step = self.step > 0.0 && self.step <= 1.0;
        let most = self.most_points;
        let forced = self.forced.unwrap_or(1.0);
        let is_forced = forced > 0.0 && forced.is_finite();
        let wide = "a range of positive, finite width";
        require(is_range, "range", width, wide)?;
        require(is_step, "step", self.step, "positive and at most 1")?;
        require(most >= 2, "most_points", most as f64, "at least 2")?;
        require(is_forced, "forced", forced, "positive and finite")
    }
}

/// A periodic orbit on a branch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BranchPoint {
    /// The parameter.
    pub parameter: f64,
    /// A time at which the orbit is in the middle of a phase; the phase may change along the
    /// branch.
    pub t: f64,
    /// The state at `t`, with the parameter as its last component.
    pub x: Vector,
    /// Period.
    pub period: f64,
    /// The multipliers in descending order of modulus, without the trivial one of an autonomous
    /// system.
    pub multipliers: Vec<Complex<f64>>,
    /// The modes in one period as [`Modes::cycle`].
    pub sequence: Vec<Modes>,
}

impl BranchPoint {
    /// Stability by the multipliers.
    pub fn stability(&self) -> Stability {
        Stability::of(&self.multipliers)
    }
}

/// The kind of a special orbit on a branch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CycleBifurcation {
    /// A fold: a multiplier is 1, and the branch turns back.
    Fold,
    /// A branch point: a multiplier is 1, the branch goes on, and another one crosses it.
    BranchPoint,
    /// A flip: a multiplier is −1, and a branch of twice the period begins.
    Flip,
    /// A Neimark–Sacker bifurcation: a pair of multipliers is on the unit circle, and a torus
    /// emerges.
    NeimarkSacker {
        /// The angle of the pair, in radians.
        angle: f64,
    },
    /// The phases change.
    Sequence(Box<SequenceChange>),
    /// An end of the branch: [`Stop::Homoclinic`]. It begins a curve in two parameters.
    Homoclinic {
        /// Number of saddles.
        saddles: NonZeroUsize,
    },
    /// An end of the branch: [`Stop::TwoFold`]. It begins a curve in two parameters.
    TwoFold,
    /// The number of multipliers outside the unit circle changes, and no bifurcation was resolved
    /// that explains it.
    Unresolved {
        /// Their number before it.
        before: usize,
        /// Their number after it.
        after: usize,
    },
}

impl fmt::Display for CycleBifurcation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CycleBifurcation::Fold => f.write_str("fold"),
            CycleBifurcation::BranchPoint => f.write_str("branch point"),
            CycleBifurcation::Flip => f.write_str("flip"),
            CycleBifurcation::NeimarkSacker { .. } => f.write_str("Neimark-Sacker"),
            CycleBifurcation::Sequence(change) => change.bifurcation.fmt(f),
            CycleBifurcation::Homoclinic { saddles } => f.write_str(match saddles.get() {
                1 => "homoclinic",
                _ => "heteroclinic",
            }),
            CycleBifurcation::TwoFold => f.write_str("two-fold"),
            CycleBifurcation::Unresolved { .. } => f.write_str("unresolved crossing"),
        }
    }
}

/// A special orbit on a branch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpecialPoint {
    /// The parameter.
    pub parameter: f64,
    /// Uncertainty of the parameter: the residual of the test function with its rounding error,
    /// over its slope along the branch. It includes the error of integration, as in
    /// [`SequenceChange::uncertainty`].
    pub uncertainty: f64,
    /// Kind.
    pub what: CycleBifurcation,
    /// Number of orbits in [`Branch::points`] before it.
    pub behind: usize,
    /// A state on the orbit, or on the nearest one that could be computed.
    pub x: Vector,
    /// Period.
    pub period: f64,
    /// The normal form of a flip or Neimark–Sacker bifurcation; `None` for others, and where the
    /// return map has no derivatives near the orbit.
    pub normal_form: Option<NormalForm>,
}

/// Reason for the end of the continuation of a branch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stop {
    /// The parameter has reached an end of its range.
    Range,
    /// The branch has as many points as requested, or the observer of [`PartialBranch::follow`]
    /// stopped it.
    Points,
    /// The branch is closed: the last orbit is the first. If it began at a branch point, it has
    /// come back to it.
    Closed,
    /// A flip of the orbit of half the period: both halves of the last orbit are that orbit. The
    /// branch would return on itself, half a period later.
    Flip {
        /// The parameter.
        parameter: f64,
        /// Uncertainty.
        uncertainty: f64,
    },
    /// A Hopf bifurcation: the orbit shrinks to an equilibrium that has a pair of imaginary
    /// eigenvalues at this parameter.
    Equilibrium {
        /// The parameter.
        parameter: f64,
        /// Absolute value of the eigenvalues: angle per unit of time.
        frequency: f64,
    },
    /// A boundary-equilibrium bifurcation: the orbit shrinks to an equilibrium or approaches one.
    /// At this parameter the equilibrium reaches the discontinuity boundary, the edge of its
    /// sliding region, or the function of a jump.
    BoundaryEquilibrium {
        /// The parameter.
        parameter: f64,
    },
    /// Crossing orbits shrink to a two-fold: a point at which the fields of both sides are tangent
    /// to the boundary.
    TwoFold {
        /// The parameter, extrapolated from those of ever smaller orbits.
        parameter: f64,
        /// Uncertainty.
        uncertainty: f64,
    },
    /// The orbit of a driven system comes to rest: its motion is below a thousandth of the widest
    /// one's on the branch. One step farther, friction holds it all the time.
    #[cfg_attr(feature = "serde", serde(rename = "Rest"))]
    HeldByFriction,
    /// The orbit approaches a saddle and its period grows. It becomes a homoclinic orbit, or with
    /// several saddles a heteroclinic cycle, and the branch ends.
    Homoclinic {
        /// The parameter, extrapolated from those of the last orbits, which approach it like
        /// `e^(-rT)` with the period `T`.
        parameter: f64,
        /// The distance of the extrapolation, which exceeds the error; NaN where there was nothing
        /// to extrapolate from.
        uncertainty: f64,
        /// Number of saddles that it passes.
        saddles: NonZeroUsize,
        /// The rate at which orbits leave the saddle, at the last orbit's parameter: the smallest
        /// positive real part of its eigenvalues; with several saddles, the smallest of these.
        leaves: f64,
        /// The rate at which orbits approach the saddle: the negative real part nearest to zero. It
        /// is minus infinity for an equilibrium of the sliding field that orbits reach from across
        /// the boundary, in finite time.
        comes: f64,
    },
    /// The phases change behind the last orbit, and no orbit with other phases could be computed
    /// next to it.
    SequenceEnds,
    /// The solver cannot follow the friction law behind the last orbit, as where static friction is
    /// below kinetic friction. It is not written to files.
    #[cfg_attr(feature = "serde", serde(skip))]
    Refused(Error),
    /// No further orbit could be computed within the shortest step behind the last one; or the
    /// branch has come back to its first orbit in the opposite direction, as it turned round at the
    /// last special orbit.
    NoConvergence,
}

/// A branch of periodic orbits.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Branch {
    /// The orbits, in the order in which they were computed.
    pub points: Vec<BranchPoint>,
    /// The special orbits between them, in the same order.
    pub special: Vec<SpecialPoint>,
    /// Reason for the end of the branch.
    pub stop: Stop,
    /// Dimension of the family of orbits at each value of which the nearest to that before is on
    /// the branch; 0 where orbits are isolated.
    pub family: usize,
}

/// Follows the periodic orbit near `x`, with a period near `period`, from its parameter upwards or
/// downwards by pseudo-arclength.
///
/// **The parameter is the last state**, and its rate is zero: that of a [`crate::Family`] with a
/// constant free, or of a system whose [`crate::Filippov::dimension`] excludes it. All derivatives,
/// by the states and by the parameter, come from the user's functions on dual numbers and from the
/// saltation at each transition. No finite differences are used.
///
/// Every orbit is computed by Newton's iteration as segments with a given sequence of modes, in the
/// plane across the branch's tangent (Keller 1977; Thota & Dankowicz 2008). Where a test function
/// changes sign, its zero is located: a function of the multipliers (Govaerts 2000), or the margin
/// to a change of the phases ([`SequenceChange`]). The branch goes on with the phases behind the
/// change. At a nonsmooth fold it turns back there. The special orbits between two orbits must
/// explain the numbers of their multipliers outside the unit circle. Otherwise those that test
/// functions hide are searched for. [`CycleBifurcation::Unresolved`] tells that none was found.
///
/// # Errors
/// Those of [`crate::Integration::new`]; [`Error::Option`] for a setting that is not allowed;
/// [`Error::Parameter`] where the last state's rate is not zero; [`Error::NotFound`] where there is
/// no orbit near the start.
///
/// ```
/// use stickslip::analysis::{ContinuationSettings, CycleBifurcation, continue_periodic_orbit};
/// use stickslip::{Family, Options, Scalar, Side};
///
/// /// r' = r (p + 2 r² - r⁴), θ' = 1: two cycles for -1 < p < 0.
/// struct Rings;
/// impl Family<2, 1> for Rings {
///     fn field<T: Scalar>(&self, _: Side, _t: T, [x, y]: &[T; 2], [p]: &[T; 1]) -> [T; 2] {
///         let square = *x * *x + *y * *y;
///         let grows = *p + square * 2.0 - square * square;
///         [*x * grows - *y, *y * grows + *x]
///     }
///     fn boundary<T: Scalar>(&self, _t: T, [x, _]: &[T; 2], _: &[T; 1]) -> T {
///         *x - 10.0
///     }
/// }
///
/// let along = Rings.at([-0.5]).free([0])?;
/// let settings = ContinuationSettings::over(-1.5, 0.0);
/// let (start, options) = ([1.3, 0.0, -0.5], Options::tol(1e-12));
/// let branch = continue_periodic_orbit(&along, start, 6.3, false, &settings, &options)?;
/// assert_eq!(branch.special[0].what, CycleBifurcation::Fold);
/// assert!((branch.special[0].parameter + 1.0).abs() < 1e-9);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn continue_periodic_orbit<Kind>(
    system: &impl AsDynamics<Kind>,
    x: impl Components,
    period: f64,
    upwards: bool,
    settings: &ContinuationSettings,
    options: &Options,
) -> Result<Branch, Error> {
    let begun = PartialBranch::begin(system, x, period, upwards, settings, options)?;
    begun.follow(system, settings, options, |_| ControlFlow::Continue(()))
}

/// A branch that is not complete, with all that its continuation needs.
///
/// With the feature `serde` it can be written to a file. Continued from the file, it is bit-for-bit
/// the branch without the interruption.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartialBranch {
    units: Units,
    first: Cycle,
    /// Rate of the parameter along the branch at the first orbit.
    heading: f64,
    /// Extent of the widest of its orbits.
    widest: f64,
    /// The last two orbits, and the line on which the branch continues.
    before: Cycle,
    last: Cycle,
    line: Option<TangentLine>,
    step: f64,
    points: Vec<BranchPoint>,
    /// The extent of each of them.
    extents: Vec<f64>,
    special: Vec<SpecialPoint>,
}

impl PartialBranch {
    /// Computes the orbit with which a branch begins, as [`continue_periodic_orbit`] does.
    ///
    /// # Errors
    /// Those of [`continue_periodic_orbit`].
    pub fn begin<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        period: f64,
        upwards: bool,
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<Self, Error> {
        settings.check()?;
        let system = &*system.dynamics();
        let start = (x.vector(), period, upwards);
        let continuation = Continuation::begin(system, start, settings, (None, options), None)?;
        Ok(continuation.branch)
    }

    /// Follows the branch to its end, with its original settings and options.
    ///
    /// `observe` receives the branch before every step, and may stop it. From a clone of what it
    /// receives, the branch can be continued.
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that is not allowed.
    pub fn follow<Kind>(
        self,
        system: &impl AsDynamics<Kind>,
        settings: &ContinuationSettings,
        options: &Options,
        mut observe: impl FnMut(&PartialBranch) -> ControlFlow<()>,
    ) -> Result<Branch, Error> {
        settings.check()?;
        let system = &*system.dynamics();
        let mut continuation = Continuation::resume(system, self, settings, options);
        let stop = continuation.go_on(&mut observe);
        Ok(continuation.into_branch(stop))
    }

    /// The orbits computed so far.
    pub fn points(&self) -> &[BranchPoint] {
        &self.points
    }
}

/// Checks that a state ends with as many parameters, and that the last one is in its range.
fn check_start(
    x: &Vector,
    parameters: usize,
    settings: &ContinuationSettings,
) -> Result<(), Error> {
    if x.len() <= parameters {
        return Err(Error::Parameter {
            name: "the number of states",
            value: x.len() as f64,
            bound: "at least one state, and the parameters behind it",
        });
    }
    let ((low, high), value) = (settings.range, x[x.len() - 1]);
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::Parameter {
        name: "the last state",
        value,
        bound: "in the range of the continuation",
    })
}

/// Checks that a parameter does not change.
fn check_rate(rate: f64) -> Result<(), Error> {
    if rate == 0.0 {
        return Ok(());
    }
    Err(Error::Parameter {
        name: "the last state's rate",
        value: rate,
        bound: "zero: the last state is the parameter of the continuation",
    })
}

/// The parameter of an orbit.
fn parameter_of(cycle: &Cycle) -> f64 {
    let x = &cycle.outline.begin.x;
    x[x.len() - 1]
}

/// A state at another parameter.
fn with_parameter(mut x: Vector, parameter: f64) -> Vector {
    let last = x.len() - 1;
    x[last] = parameter;
    x
}

/// The test functions of an orbit's multipliers, where the flow map has a derivative.
fn critical(cycle: &Cycle, shooting: &Shooting<'_>) -> Option<Critical> {
    let has_any = cycle.is_differentiable();
    has_any.then(|| Critical::of(&cycle.monodromy, shooting.family))
}
