//! Event-exact integration of dry-friction (Filippov) systems.
//!
//! A Filippov system has two smooth vector fields, one on either side of a boundary Σ. A block on a
//! moving belt is one. Friction pushes it forward while it is slower than the belt and back while
//! it is faster; Σ is where both are equally fast. The orbit slips on one side, crosses Σ, or
//! sticks to it (*slides* on it, in Filippov's words) where both fields push towards it.
//!
//! # Two functions
//! You write the field of each side and a function that is zero on Σ, for any [`Scalar`].
//! Everything else is derived:
//!
//! ```
//! use stickslip::{Filippov, Mode, Options, Scalar, Side, solve};
//!
//! /// A block on a belt of speed 0.2, held by a spring; friction decays with slip speed.
//! struct Block;
//!
//! impl Filippov<2> for Block {
//!     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
//!         let slip_speed = (x[1] - 0.2) * side.sign();
//!         let friction = T::constant(side.sign()) / (slip_speed + 1.0);
//!         [x[1], -x[0] - friction]
//!     }
//!     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
//!         x[1] - 0.2
//!     }
//! }
//!
//! fn main() -> Result<(), stickslip::Error> {
//!     let orbit = solve(&Block, 0.0, [0.04, -0.01], 40.0, &Options::tol(1e-12))?;
//!     assert_eq!(orbit.phases[1].mode, Mode::Stick);
//!     println!("{} transitions, x(20) = {}", orbit.transitions.len(), orbit.at(20.0)?);
//!     Ok(())
//! }
//! ```
//!
//! # Step by step
//! [`solve`] stores the whole [`Orbit`]; [`run`] reports to an [`Observer`] and stores nothing.
//! Both are loops over [`Integration::step`], which you can write yourself:
//!
//! ```
//! use stickslip::{Integration, Options, Progress, models::BeltOscillator};
//!
//! fn main() -> Result<(), stickslip::Error> {
//!     let belt = BeltOscillator::default();
//!     let mut integration = Integration::new(&belt, 0.0, [0.5, 1.5], 20.0, &Options::default())?;
//!     let mut highest = f64::NEG_INFINITY;
//!     loop {
//!         match integration.step()? {
//!             Progress::Step => highest = highest.max(integration.x()[0]),
//!             Progress::Transition(at) => println!("{:?} at t = {}", at.kind, at.t),
//!             Progress::PhaseEnd(_) => {}
//!             Progress::End(_) => break,
//!         }
//!     }
//!     assert!(highest > 0.5);
//!     Ok(())
//! }
//! ```
//!
//! # Several contacts
//! Two rubbing bodies, or a chain of them, are a [`Contacts`] system: a field for every combination
//! of sides, and a boundary for each contact. Wrapped in [`Several`] it goes wherever a Filippov
//! system goes. Its modes are arrays, one [`Mode`] for each contact. Static friction above kinetic
//! is a second field, [`Filippov::holding`] or [`Contacts::holding`]. `examples/chain.rs` is a
//! chain of eight blocks on a belt.
//!
//! ```
//! use stickslip::{Contacts, Options, Scalar, Several, Side, solve};
//!
//! /// A block on a block on a floor that is shaken. States: positions, then velocities.
//! struct Stacked;
//!
//! impl Contacts<4, 2> for Stacked {
//!     fn field<T: Scalar>(&self, sides: &[Side; 2], t: T, x: &[T; 4]) -> [T; 4] {
//!         let [floor, between] = [0.2 * sides[0].sign(), 0.15 * sides[1].sign()];
//!         let lower = -x[0] + (t * 0.8).cos() - floor + between;
//!         let upper = (-x[1] * 0.4 - between) / 0.5;
//!         [x[2], x[3], lower, upper]
//!     }
//!     fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 4]) -> [T; 2] {
//!         [x[2], x[3] - x[2]]
//!     }
//! }
//!
//! fn main() -> Result<(), stickslip::Error> {
//!     let orbit = solve(&Several(Stacked), 0.0, [0.0; 4], 40.0, &Options::tol(1e-12))?;
//!     for at in orbit.transitions.iter().take(3) {
//!         println!("t = {:.6}, contact {}: {:?} to {:?}", at.t, at.contact, at.from, at.to);
//!     }
//!     assert_eq!(orbit.transitions.len(), 30);
//!     Ok(())
//! }
//! ```
//!
//! # Sections and events
//! Zeros of your own functions ([`EventFunctions`]) are found on every step's dense output and
//! located on the step itself, in slip and in stick. They may have a direction, and may end the
//! run. [`solve_with_events`] stores them beside the orbit, [`Watched`] reports them among the
//! transitions, and [`EventSearch`] finds them for an [`Observer`]. [`analysis::PoincareMap`] makes
//! one function a system of discrete time, with the map's derivative:
//!
//! ```
//! use stickslip::{Direction, EventFunctions, Options, Scalar, analysis::PoincareMap};
//! use stickslip::models::BeltOscillator;
//!
//! /// Where the block turns back, at the right end of its way.
//! struct TurnsBack;
//! impl EventFunctions<2, 1> for TurnsBack {
//!     fn values<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 1] {
//!         [x[1]]
//!     }
//!     fn direction(&self, _number: usize) -> Direction {
//!         Direction::Falling
//!     }
//! }
//!
//! fn main() -> Result<(), stickslip::Error> {
//!     let belt = BeltOscillator::default();
//!     let longest = 50.0;
//!     let options = Options::tol(1e-12);
//!     let mut map = PoincareMap::new(&belt, &TurnsBack, (0.0, [0.5, 1.5]), longest, &options)?;
//!     for _ in 0..20 {
//!         map.step()?;
//!     }
//!     let before = map.state().clone();
//!     let (turned, derivative) = map.step_with_derivative()?;
//!     // It has settled, and a change of the place would be an eighth of it the next time.
//!     assert!((turned.x - before).amax() < 1e-10);
//!     assert!((derivative[(0, 0)] - 0.12629).abs() < 1e-4);
//!     Ok(())
//! }
//! ```
//!
//! # Spectra
//! [`analysis`] has tangent points, monodromy matrices through stick and crossing, periodic orbits,
//! and Lyapunov spectra:
//!
//! ```
//! use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
//! use stickslip::models::BeltOscillator;
//!
//! fn main() -> Result<(), stickslip::Error> {
//!     let belt = BeltOscillator { belt_speed: 0.2, ..BeltOscillator::default() };
//!     let settings = SpectrumOptions::over(50.0, 500.0);
//!     let spectrum = lyapunov_spectrum(&belt, (0.0, [0.5, 0.1]), &settings)?;
//!     // Stick forgets one direction altogether.
//!     assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
//!     Ok(())
//! }
//! ```
//!
//! # Attractors, sweeps and branches
//! [`analysis::attractor`] finds the attractor of a start, without a list of attractors.
//! [`analysis::basin`] does so for many starts and gives the shares. [`analysis::sweep`] follows an
//! attractor along a parameter, up or down, and locates the changes of its phases. The event
//! function that vanishes names the change, one of the four sliding bifurcations say; the
//! multipliers name folds, flips, tori and branch points. [`analysis::continue_periodic_orbit`]
//! follows a periodic orbit, stable or not, through folds and grazes. Their pages have examples.
//!
//! # Ensembles
//! [`ensemble`] integrates many starts or parameters on all cores. Each orbit is bit-for-bit the
//! same as alone, and the results come in order:
//!
//! ```
//! use std::ops::ControlFlow;
//! use stickslip::{Options, Start, ensemble, models::BeltOscillator};
//!
//! fn main() {
//!     // The same start on belts of a hundred speeds.
//!     let starts = (1..=100).map(|k| Start {
//!         system: BeltOscillator { belt_speed: 0.02 * f64::from(k), ..BeltOscillator::default() },
//!         t: 0.0,
//!         x: [0.5, 0.1].into(),
//!     });
//!     let mut ends = Vec::new();
//!     // Nothing is watched on the way.
//!     ensemble(starts, 20.0, &Options::default(), |_| (), |number, (), outcome| {
//!         match outcome {
//!             Ok(summary) => ends.push(summary.x),
//!             Err(failure) => println!("belt {number}: {failure}"),
//!         }
//!         ControlFlow::Continue(())
//!     });
//!     assert_eq!(ends.len(), 100);
//! }
//! ```
//!
//! # Errors
//! Every failure is an [`Error`] with the values that explain it; [`solve`] hands back the orbit up
//! to it:
//!
//! ```
//! use stickslip::{Error, Options, models::BeltOscillator, solve};
//!
//! fn main() {
//!     let tight = Options::default().escape(1.0);
//!     match solve(&BeltOscillator::default(), 0.0, [0.5, 0.9], 50.0, &tight) {
//!         Err(failure) => {
//!             assert!(matches!(failure.error, Error::Escaped { .. }));
//!             println!("{failure}; it came to t = {}", failure.partial.t_end);
//!         }
//!         Ok(_) => unreachable!("the belt takes the block further than that"),
//!     }
//! }
//! ```

pub mod analysis;
mod dual;
pub mod dynamics;
pub mod error;
pub mod filippov;
mod interval;
pub mod math;
pub mod models;
pub mod ode;
pub mod orbit;
pub mod scalar;
pub mod statistics;
pub mod system;
mod taylor;

/// The crate whose vectors and matrices appear in signatures. Use this one, so that the versions
/// agree.
pub use nalgebra;

pub use error::Error;
pub use filippov::{
    Approach, AtPileUp, AtRepelling, Contacts, Direction, EventFunctions, EventRecord, EventSearch,
    Failure, Fate, Integration, Locator, Method, Observer, Options, OrbitWithEvents, Phase, Plane,
    Progress, Several, Start, StepRecord, Strobe, Summary, Switched, Transition, TransitionKind,
    TwoFold, Visibility, Watched, WatchedProgress, ensemble, fate, run, solve, solve_with_events,
};
pub use orbit::{Counters, Ending, Orbit};
pub use scalar::Scalar;
pub use system::{Filippov, Mode, Side, State};

/// The READMEs' examples are compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
