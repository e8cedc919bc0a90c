//! The Poincaré map: from each passage of a section to the next one.

use super::graze::check_step;
use super::monodromy::{TangentMap, velocity_in};
use super::tangent::{Tangent, singular};
use crate::dynamics::{
    Components, Dynamics, DynamicsRef, Matrix, Moment, OrbitProgress, OrbitUnderWay, Passage,
    Section, Step, Typed, Vector, watched,
};
use crate::error::{Error, require};
use crate::filippov::{EventFunctions, Options, Switched};

/// A passage rate up to this fraction of its summands is zero to rounding. It is some thousand
/// units in the last place, for the error of the field.
const RATE_ROUNDING: f64 = 1e-12;

/// The Poincaré map of a system and a section: a discrete-time system, in which each step is one
/// return.
///
/// The section is a plane, a strobe, or an event function ([`EventFunctions`]) of the user's own,
/// which has a direction and may depend on time. A start on the section is no return. The orbit
/// is not restarted, so that the returns are those of one run. As an iterator the map has no end,
/// except after an error.
///
/// ```
#[doc = include_str!("../../examples/common/belt.rs")]
/// use stickslip::dynamics::{AsDynamics, Section};
/// use stickslip::{Direction, Options, analysis::PoincareMap};
///
/// let belt = Belt { speed: 1.0 };
/// let (point, normal) = (vec![0.0, 0.0].into(), vec![1.0, 0.0].into());
/// let section = Section::Plane { point, normal, direction: Direction::Rising };
/// let (belt, options) = (belt.dynamics(), Options::tol(1e-12));
/// let mut map = PoincareMap::at_run_time(&*belt, section, (0.0, [0.5, 1.5]), 50.0, &options)?;
/// for at in map.by_ref().take(20) {
///     let at = at?;
///     println!("return {} at t = {}: x' = {}", at.number, at.t, at.x[1]);
/// }
/// // On the cycle now: the map contracts the section as the cycle's multiplier says.
/// let (_, derivative) = map.step_with_derivative()?;
/// assert!((derivative.trace() - 0.12629).abs() < 1e-4);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct PoincareMap<'a> {
    dynamics: DynamicsRef<'a>,
    orbit: Box<dyn OrbitUnderWay + 'a>,
    section: Section,
    options: Options,
    /// The longest time between returns.
    longest: f64,
    /// The present state of the map.
    at: Moment,
    number: usize,
    /// The part of the last step that lies after the last return.
    after_return: Option<Step>,
    has_failed: bool,
}

impl<'a> PoincareMap<'a> {
    /// The map from `start` (time and state), on the section or off it. A return must occur within
    /// `longest`. Terminal sections are not treated specially.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`]; [`Error::Option`] where `longest` is not positive.
    pub fn new<S, V, const N: usize, const G: usize>(
        system: &'a S,
        section: &'a V,
        start: (f64, impl Components),
        longest: f64,
        options: &Options,
    ) -> Result<Self, Error>
    where
        S: Switched<N, G> + Send + Sync,
        V: EventFunctions<N> + Send + Sync,
    {
        let typed = Typed::<&S, S, &V, _, _, N, G>::with_section(system, section);
        let at = moment(start);
        let options = bounded(longest, options)?;
        let orbit = watched(&typed, &at, &options)?;
        let dynamics = DynamicsRef::Owned(Box::new(typed));
        Ok(PoincareMap::of(
            dynamics,
            orbit,
            Section::OfSystem(0),
            at,
            longest,
            options,
        ))
    }

    /// The map of a system known at run time, or of a plane or a strobe.
    ///
    /// ```
    /// use stickslip::dynamics::{AsDynamics, Section};
    /// use stickslip::{Filippov, Options, Scalar, Side, analysis::PoincareMap};
    ///
    /// /// A block on a floor, pushed with period 2.
    /// struct Pushed;
    ///
    /// impl Filippov<2> for Pushed {
    ///     fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
    ///         let push = (t * std::f64::consts::PI).cos() * 3.0;
    ///         [x[1], push - x[0] - 0.4 * side.sign()]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
    ///         x[1]
    ///     }
    /// }
    ///
    /// let strobe = Section::Strobe { first: 0.0, period: 2.0 };
    /// let (pushed, options) = (Pushed.dynamics(), Options::tol(1e-10));
    /// let mut map = PoincareMap::at_run_time(&*pushed, strobe, (0.0, [0.1, 0.2]), 3.0, &options)?;
    /// assert!((map.step()?.t - 2.0).abs() < 1e-12);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`PoincareMap::new`].
    pub fn at_run_time(
        dynamics: &'a dyn Dynamics,
        section: Section,
        start: (f64, impl Components),
        longest: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let at = moment(start);
        let options = bounded(longest, options)?;
        let orbit = dynamics.begin(&at, f64::MAX, &options, std::slice::from_ref(&section))?;
        let dynamics = DynamicsRef::Borrowed(dynamics);
        Ok(PoincareMap::of(
            dynamics, orbit, section, at, longest, options,
        ))
    }

    fn of(
        dynamics: DynamicsRef<'a>,
        orbit: Box<dyn OrbitUnderWay + 'a>,
        section: Section,
        at: Moment,
        longest: f64,
        options: Options,
    ) -> Self {
        PoincareMap {
            dynamics,
            orbit,
            section,
            options,
            longest,
            at,
            number: 0,
            after_return: None,
            has_failed: false,
        }
    }

    /// The state at the last return, or the start.
    pub fn state(&self) -> &Vector {
        &self.at.x
    }

    /// The time of the last return, or of the start.
    pub fn time(&self) -> f64 {
        self.at.t
    }

    /// Number of returns so far.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The next return. Its number counts the returns, from 1.
    ///
    /// # Errors
    /// Those of [`crate::Integration::step`]; [`Error::NotFound`] where there is no return within
    /// the longest time; [`Error::NoUniqueFuture`] where Σ repels or the orbit reaches a two-fold.
    pub fn step(&mut self) -> Result<Passage, Error> {
        let passage = self.advance(None)?;
        Ok(self.arrive(passage))
    }

    /// The next return, and the derivative of its state with respect to the state at the last
    /// return or the start. It is square in the states, with column `j` for component `j` there.
    ///
    /// It is `(I − f ∇gᵀ/(∂g/∂t + ∇g·f)) Φ` with the tangent flow Φ between the two, and the field
    /// `f` and the section `g` at the return. The first factor removes the effect of the start on
    /// the return time, along the motion. On the section its eigenvalues are the Floquet
    /// multipliers of a periodic orbit, with zero in place of the trivial one. The time at the last
    /// return is held fixed. In a non-autonomous system, derivatives of successive returns multiply
    /// only where the section fixes the time. From a state in stick it begins as
    /// [`crate::analysis::Monodromy::of`] does.
    ///
    /// # Errors
    /// Those of [`PoincareMap::step`]; [`Error::TangentSingular`] where the orbit passes the
    /// section at zero rate, and where the flow up to there has no derivative. The passage still
    /// counts as a return and starts the next derivative.
    pub fn step_with_derivative(&mut self) -> Result<(Passage, Matrix), Error> {
        let mut map = TangentMap::identity(&*self.dynamics);
        map.begin(&*self.dynamics, self.orbit.mode(), &self.at);
        let passage = self.advance(Some(&mut map))?;
        let flow = map.matrix();
        let here = passage.moment();
        let velocity = velocity_in(&*self.dynamics, passage.mode, &here);
        let (normal, in_time) = self.dynamics.section_gradient(&self.section, &here);
        let rate = in_time + normal.dot(&velocity);
        let derivative = &flow - &velocity * (normal.transpose() * &flow) / rate;
        // An exit from stick at a tangent point passes a section that is Σ at no rate except for
        // rounding.
        let size = in_time.abs() + normal.norm() * velocity.norm();
        let arrived = self.arrive(passage);
        if rate.abs() <= RATE_ROUNDING * size || derivative.iter().any(|v| !v.is_finite()) {
            return Err(singular(here.t, &here.x));
        }
        Ok((arrived, derivative))
    }

    /// Continues to the next passage, with the tangent flow between the two if requested.
    fn advance(&mut self, mut map: Option<&mut TangentMap>) -> Result<Passage, Error> {
        let tangent = Tangent::new(&*self.dynamics, &self.options);
        loop {
            let progress = match self.orbit.step()? {
                OrbitProgress::Passage(passage) => {
                    if passage.t - self.at.t > self.longest {
                        return Err(self.no_return());
                    }
                    let here = passage.moment();
                    if let Some(step) = &mut self.after_return {
                        let before = step.cut(&here);
                        if let Some(map) = &mut map {
                            map.through_step(&tangent, &before);
                        }
                    }
                    return Ok(passage);
                }
                other => other,
            };
            if let (Some(step), Some(map)) = (self.after_return.take(), &mut map) {
                map.through_step(&tangent, &step);
            }
            match progress {
                OrbitProgress::Step => {
                    let step = self.orbit.last_step();
                    if step.t_start - self.at.t > self.longest {
                        return Err(self.no_return());
                    }
                    if map.is_some() {
                        check_step(&tangent, &step, &mut *self.orbit)?;
                    }
                    self.after_return = Some(step);
                }
                OrbitProgress::Transition(at) => {
                    if let Some(map) = &mut map {
                        map.through_exact_transition(&tangent, &at)?;
                    }
                }
                OrbitProgress::PhaseEnd(_) | OrbitProgress::Passage(_) | OrbitProgress::Kink(_) => {
                }
                OrbitProgress::End(summary) => return Err(summary.no_future_error()),
            }
        }
    }

    fn arrive(&mut self, passage: Passage) -> Passage {
        self.at = passage.moment();
        self.number += 1;
        Passage {
            number: self.number,
            ..passage
        }
    }

    fn no_return(&self) -> Error {
        Error::NotFound {
            what: "a return to the section",
            t: self.at.t,
            span: self.longest,
        }
    }
}

fn moment((t, x): (f64, impl Components)) -> Moment {
    Moment { t, x: x.vector() }
}

/// The options for returns within a given time: no step need be longer.
fn bounded(longest: f64, options: &Options) -> Result<Options, Error> {
    let is_positive = longest > 0.0 && longest.is_finite();
    require(is_positive, "longest", longest, "positive and finite")?;
    Ok(options.longest_step(options.longest_step.min(longest)))
}

impl Iterator for PoincareMap<'_> {
    type Item = Result<Passage, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed {
            return None;
        }
        let next = self.step();
        self.has_failed = next.is_err();
        Some(next)
    }
}
