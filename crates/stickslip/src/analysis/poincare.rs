//! The map that takes each passage of a section to the next one.

use nalgebra::SMatrix;

use super::monodromy::TangentMap;
use super::tangent::{Tangent, singular};
use crate::error::Error;
use crate::filippov::{
    EventFunctions, EventRecord, Happening, Integration, Options, Progress, StepRecord, Switched,
    Velocity, Watched, gradient,
};
use crate::ode::Timed;
use crate::system::{Mode, State, components};

/// A return to a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Return<const N: usize, K = Mode> {
    /// Which return it is, counted from 1.
    pub number: usize,
    /// Time.
    pub t: f64,
    /// State, on the section.
    pub x: State<N>,
    /// Mode that the section is passed in; at the very end of a phase, the one that ends.
    pub mode: K,
}

/// Part of what it is summed from below which the rate of a passage is rounding.
const ROUNDING: f64 = 1e-12;

/// The Poincaré map of a system and a section: a system of discrete time, of which each step is one return.
///
/// The section is an event function ([`EventFunctions`]) with a direction: [`crate::Plane`], or one of your own, of time too (a strobe).
/// A start on the section is no return. The orbit goes on from return to return without a new start, so that the returns are
/// those of one run. As an iterator the map has no end; after an error there is nothing more.
///
/// ```
/// use stickslip::{Direction, Options, Plane, analysis::PoincareMap, models::BeltOscillator};
///
/// let belt = BeltOscillator::default();
/// let section = Plane { point: [0.0, 0.0].into(), normal: [1.0, 0.0].into(), direction: Direction::Rising };
/// let options = Options::tol(1e-12);
/// let mut map = PoincareMap::new(&belt, &section, (0.0, [0.5, 1.5]), 50.0, &options)?;
/// for at in map.by_ref().take(20) {
///     let at = at?;
///     println!("return {} at t = {}: x' = {}", at.number, at.t, at.x[1]);
/// }
/// // On the cycle now: the map contracts the section as the cycle's multiplier says.
/// let (_, derivative) = map.step_with_derivative()?;
/// assert!((derivative.trace() - 0.12629).abs() < 1e-4);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct PoincareMap<'a, S: Switched<N, G>, V, const N: usize, const G: usize> {
    watched: Watched<'a, S, V, N, 1, G>,
    system: &'a S,
    section: &'a V,
    tangent: Tangent<'a, S>,
    /// The longest time that a return may take.
    longest: f64,
    /// Where the map stands.
    at: Timed<N>,
    number: usize,
    /// The part of the last step that lies behind the last return.
    rest: Option<StepRecord<N, S::Mode>>,
    has_failed: bool,
}

impl<'a, S, V, const N: usize, const G: usize> PoincareMap<'a, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    /// The map from `start` (time and state), on the section or off it. A return that takes more time than `longest` is none.
    /// Whether the section is terminal plays no part.
    ///
    /// # Errors
    /// Those of [`Integration::new`]; [`Error::Option`] where `longest` is not positive.
    pub fn new(
        system: &'a S,
        section: &'a V,
        start: (f64, impl Into<State<N>>),
        longest: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        if !(longest > 0.0 && longest.is_finite()) {
            return Err(Error::Option {
                name: "longest",
                value: longest,
                bound: "positive and finite",
            });
        }
        let (t, x) = (start.0, start.1.into());
        // No step need be longer than a return.
        let options = options.longest_step(options.longest_step.min(longest));
        let integration = Integration::new(system, t, x, f64::MAX, &options)?;
        Ok(PoincareMap {
            watched: Watched::new(integration, section).endless(),
            system,
            section,
            tangent: Tangent::new(system, &options),
            longest,
            at: Timed { t, x },
            number: 0,
            rest: None,
            has_failed: false,
        })
    }

    /// The state at the last return, or the start.
    pub fn state(&self) -> &State<N> {
        &self.at.x
    }

    /// The time of the last return, or of the start.
    pub fn time(&self) -> f64 {
        self.at.t
    }

    /// The returns so far.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The next return.
    ///
    /// # Errors
    /// Those of [`Integration::step`]; [`Error::NotFound`] where there is no return within the longest time, and
    /// [`Error::NoUniqueFuture`] where Σ repels or the orbit comes to a two-fold.
    pub fn step(&mut self) -> Result<Return<N, S::Mode>, Error> {
        let event = self.advance(None)?;
        Ok(self.arrive(&event))
    }

    /// The next return, and the derivative of its state with respect to the state at the last one, or the start: `N` × `N`, column `j` for
    /// its component `j`.
    ///
    /// It is `(I − f ∇gᵀ/(∂g/∂t + ∇g·f)) Φ`, with the tangent flow Φ from there to here, the field `f` here, and the section
    /// `g`: what a change of the start does to the time of the return is taken out along the motion. On the section it has the
    /// Floquet multipliers of a periodic orbit but the one along it, in whose place there is a zero. The time at the last return is held:
    /// of a system that depends on time the derivatives of returns in a row multiply where the section fixes the time. From a state in stick it
    /// begins as [`crate::analysis::monodromy`] does.
    ///
    /// # Errors
    /// As [`PoincareMap::step`]; [`Error::TangentSingular`] where the orbit does not pass through the section with a rate, which is a return
    /// all the same and the start of the next derivative, and where the flow up to there has no derivative.
    pub fn step_with_derivative(
        &mut self,
    ) -> Result<(Return<N, S::Mode>, SMatrix<f64, N, N>), Error> {
        let mut map = TangentMap::identity();
        let mode = self.watched.integration().mode();
        map.begin(self.system, mode, &self.at);
        let event = self.advance(Some(&mut map))?;
        let flow = map.matrix;
        let here = Velocity(event.t, components(&event.x));
        let velocity = self
            .system
            .with_flow(event.mode, S::Branch::default(), here);
        let velocity = State::from(velocity);
        let (t, x) = (event.t, event.x);
        let (normal, in_time) = gradient(|t, x| self.section.values(t, x)[0], &Timed { t, x });
        let rate = in_time + normal.dot(&velocity);
        let derivative = flow - velocity * (normal.transpose() * flow) / rate;
        // An exit from stick at a tangent point passes a section that is Σ with no rate but rounding's.
        let size = in_time.abs() + normal.norm() * velocity.norm();
        let arrived = self.arrive(&event);
        if rate.abs() <= ROUNDING * size || derivative.iter().any(|v| !v.is_finite()) {
            return Err(singular(t, &x));
        }
        Ok((arrived, derivative))
    }

    /// Goes on to the next passage, with the tangent flow from here to there if it is asked for.
    fn advance(
        &mut self,
        mut map: Option<&mut TangentMap<N>>,
    ) -> Result<EventRecord<N, S::Mode>, Error> {
        loop {
            let progress = match self.watched.step()? {
                Happening::Event(event) => {
                    if event.t - self.at.t > self.longest {
                        return Err(self.no_return());
                    }
                    let here = Timed {
                        t: event.t,
                        x: event.x,
                    };
                    if let Some(step) = &mut self.rest {
                        let before = step.cut(&here);
                        if let Some(map) = &mut map {
                            map.through_step(&self.tangent, &before);
                        }
                    }
                    return Ok(event);
                }
                Happening::Progress(progress) => progress,
            };
            if let (Some(step), Some(map)) = (self.rest.take(), &mut map) {
                map.through_step(&self.tangent, &step);
            }
            match progress {
                Progress::Step => {
                    let step = self.watched.last_step();
                    if step.t_start - self.at.t > self.longest {
                        return Err(self.no_return());
                    }
                    self.rest = Some(step);
                }
                Progress::Transition(at) => {
                    if let Some(map) = &mut map {
                        map.through_transition(&self.tangent, &at)?;
                    }
                }
                Progress::PhaseEnd(_) => {}
                Progress::End(summary) => return Err(summary.goes_no_further()),
            }
        }
    }

    fn arrive(&mut self, event: &EventRecord<N, S::Mode>) -> Return<N, S::Mode> {
        let EventRecord { t, x, mode, .. } = *event;
        self.at = Timed { t, x };
        self.number += 1;
        Return {
            number: self.number,
            t,
            x,
            mode,
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

impl<S, V, const N: usize, const G: usize> Iterator for PoincareMap<'_, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
{
    type Item = Result<Return<N, S::Mode>, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed {
            return None;
        }
        let next = self.step();
        self.has_failed = next.is_err();
        Some(next)
    }
}
