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
//! Both are loops over [`Integration::step`], which you can write yourself. Most pages named here
//! and below have an example.
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
//! one function a system of discrete time, with the map's derivative.
//!
//! # Spectra
//! [`analysis`] has tangent points, monodromy matrices through stick and crossing, periodic orbits,
//! and Lyapunov spectra ([`analysis::lyapunov_spectrum`]).
//!
//! # Attractors, sweeps and branches
//! [`analysis::attractor`] finds the attractor of a start, without a list of attractors.
//! [`analysis::basin`] does so for many starts and gives the shares. [`analysis::sweep`] follows an
//! attractor along a parameter, up or down, and locates the changes of its phases. The event
//! function that vanishes names the change, one of the four sliding bifurcations say; the
//! multipliers name folds, flips, tori and branch points. [`analysis::continue_periodic_orbit`]
//! follows a periodic orbit, stable or not, through folds and grazes.
//!
//! # Ensembles
//! [`ensemble`] integrates many starts or parameters on all cores. Each orbit is bit-for-bit the
//! same as alone, and the results come in order.
//!
//! # What to use
//!
//! | To … | use |
//! |---|---|
//! | write a system | [`Filippov`], [`Contacts`] in [`Several`], [`Scalar`], [`Side`], [`Mode`] |
//! | let it jump | [`dynamics::WithJumps`], [`dynamics::Jumps`], [`dynamics::Reset`] |
//! | run it and keep the orbit | [`solve`]: [`Orbit`], [`Phase`], [`Transition`], [`Failure`] |
//! | run it step by step | [`Integration`], [`Progress`]; [`run`] with an [`Observer`] |
//! | run many | [`ensemble`], [`Start`] |
//! | choose how | [`Options`]: [`Method`], [`Locator`], [`AtRepelling`], [`AtPileUp`] |
//! | know how it ended | [`Summary`]: [`Ending`], [`TwoFold`], [`Counters`] |
//! | find events of your own | [`EventFunctions`], [`Plane`], [`Strobe`]; [`solve_with_events`] |
//! | look at a point of Σ | [`fate`], [`Visibility`], [`normal_component`], [`boundary_gradient`] |
//! | map a section to itself | [`analysis::PoincareMap`] |
//! | find periodic orbits | [`analysis::find_periodic_orbit`], [`analysis::periodic_orbit`] |
//! | judge their stability | [`analysis::monodromy`], [`analysis::multipliers`] |
//! | follow them | [`analysis::continue_periodic_orbit`], [`analysis::switch_branches`] |
//! | follow equilibria | [`analysis::continue_equilibrium`] |
//! | follow a change in two parameters | [`analysis::continue_change`] |
//! | find attractors and basins | [`analysis::attractor`], [`analysis::basin`] |
//! | follow an attractor | [`analysis::sweep`], [`analysis::locate_changes`] |
//! | differentiate orbits | [`analysis::orbit_derivatives`], [`analysis::periodic_derivatives`] |
//! | fit to data | [`analysis::least_squares`], [`analysis::constrained_least_squares`] |
//! | measure exponents | [`analysis::lyapunov_spectrum`], [`analysis::largest_exponent`] |
//! | use numbers of states from run time | [`dynamics::Dynamics`], [`dynamics::Vector`] |
//! | compute with the same bits everywhere | [`math`], [`math::product`] of matrices |
//! | build a solver of your own | [`ode`]: steps, dense output, [`ode::henon_step`] |
//!
//! The other names are settings and results of these, and are linked from their pages. [`error`]
//! has the failures, [`scalar`] the numbers that carry derivatives and bounds.
//!
//! # Errors
//! Every failure is an [`Error`] with the values that explain it. [`solve`] returns the orbit up to
//! it in a [`Failure`].

// Of this workspace only this crate and its `stickslip-numerics` are published.
#![warn(missing_docs)]

pub mod analysis;
mod contact_fault;
mod dual;
pub mod dynamics;
pub mod error;
mod filippov;
mod interval;
pub mod math;
pub mod ode;
mod orbit;
pub mod scalar;
pub mod system;
mod taylor;

/// The crate whose vectors and matrices appear in signatures. Use this one, so that the versions
/// agree.
pub use nalgebra;

pub use error::Error;
pub use filippov::{
    AtPileUp, AtRepelling, Contacts, Direction, EventFunctions, EventOf, EventRecord, EventSearch,
    Failure, Fate, Integration, Locator, Method, Observer, Options, OrbitWithEvents, Phase,
    PhaseOf, Plane, Progress, Several, Start, StepRecord, Strobe, Switched, Transition,
    TransitionKind, TransitionOf, Visibility, Watched, WatchedProgress, boundary_gradient,
    ensemble, fate, first_zero, normal_component, run, solve, solve_with_events,
};
pub use orbit::{Approach, Counters, Ending, Orbit, Summary, SummaryOf, TwoFold};
pub use scalar::Scalar;
pub use system::{Filippov, Mode, Side, State};

/// The READMEs' examples are compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
