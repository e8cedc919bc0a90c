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
//! run. [`solve_with_events`] stores them in the orbit, and [`EventSearch`] finds them for an
//! [`Observer`]. [`analysis::PoincareMap`] makes one function a system of discrete time, with the
//! map's derivative.
//!
//! # Spectra
//! [`analysis`] has monodromy matrices through stick and crossing, periodic orbits, and Lyapunov
//! spectra ([`analysis::lyapunov_spectrum`]).
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
//! Systems are run from the crate's root:
//! - **Systems**: [`Filippov`], or [`Contacts`] in [`Several`], written for any [`Scalar`] with
//!   [`Side`] and [`Mode`]. A [`Family`] is a function of constants, and a [`Member`] one of its
//!   systems, in which constants can be free. A start is a [`State`], or anything else that is
//!   [`IntoState`].
//! - **Runs**: [`solve`] stores an [`Orbit`] with every [`Phase`], [`Transition`]
//!   ([`TransitionKind`]) and [`StepRecord`], or returns a [`Failure`]. [`run`] reports them to
//!   an [`Observer`]. [`Integration`] takes single steps and returns [`Progress`]. [`ensemble`]
//!   runs from every [`Start`] of many. The systems that they take are [`Switched`].
//! - **Settings**: [`Options`], with [`Method`], [`AbsoluteTolerance`], [`Locator`],
//!   [`AtRepelling`] and [`AtPileUp`].
//! - **Ends**: [`Summary`], with [`Ending`] and [`Counters`]; [`TwoFold`] and the [`Approach`]
//!   to it.
//! - **Events**: [`EventFunctions`] and their [`Direction`]. [`solve_with_events`] stores every
//!   [`EventRecord`]; [`EventSearch`] stores nothing. [`first_zero`] is for any function of one
//!   variable.
//! - **Points of Σ**: [`fate`] returns a [`Fate`]. [`Visibility`] is the kind of a tangency.
//!
//! Orbits and families of orbits are studied in [`analysis`]. A result is a type with methods:
//! - **Periodic orbits**: [`PeriodicOrbit`](analysis::PeriodicOrbit), near a guess or approached by
//!   an orbit, with its shortest period, multipliers and derivatives
//!   ([`PeriodicDerivatives`](analysis::PeriodicDerivatives) with
//!   [`ExtremeDerivatives`](analysis::ExtremeDerivatives)).
//!   [`multipliers`](analysis::multipliers) and [`Stability`](analysis::Stability) judge it.
//!   [`Monodromy`](analysis::Monodromy) is that of any orbit.
//! - **Maps**: [`PoincareMap`](analysis::PoincareMap), an iterator over every return to a section.
//! - **Attractors**: [`attractor`](analysis::attractor) returns an
//!   [`Attractor`](analysis::Attractor) with its [`AttractorKind`](analysis::AttractorKind), by
//!   the criterion of [`RecurrenceSettings`](analysis::RecurrenceSettings).
//!   [`Attractors`](analysis::Attractors) numbers them all. [`basin`](analysis::basin) returns a
//!   [`Basin`](analysis::Basin), with the [`Share`](analysis::Share) of each.
//! - **Basins in numbers**: [`BasinEntropy`](analysis::BasinEntropy),
//!   [`UncertaintyExponent`](analysis::UncertaintyExponent), and
//!   [`SharesAt`](analysis::SharesAt) values of a parameter. The least
//!   [`Push`](analysis::Push) out of a basin by [`PushSettings`](analysis::PushSettings). An
//!   [`EdgeState`](analysis::EdgeState) of an [`EdgeKind`](analysis::EdgeKind) by
//!   [`EdgeSettings`](analysis::EdgeSettings).
//! - **Sweeps**: [`sweep`](analysis::sweep) follows an attractor and returns every
//!   [`SweepPoint`](analysis::SweepPoint). [`locate_changes`](analysis::locate_changes), within a
//!   [`StepBudget`](analysis::StepBudget), returns every
//!   [`AttractorChange`](analysis::AttractorChange): [`WhatChanges`](analysis::WhatChanges), or
//!   why it is [`NotFollowed`](analysis::NotFollowed).
//! - **Branches**: [`continue_periodic_orbit`](analysis::continue_periodic_orbit) returns a
//!   [`Branch`](analysis::Branch) by [`ContinuationSettings`](analysis::ContinuationSettings):
//!   every [`BranchPoint`](analysis::BranchPoint) and [`SpecialPoint`](analysis::SpecialPoint)
//!   ([`CycleBifurcation`](analysis::CycleBifurcation),
//!   [`SequenceChange`](analysis::SequenceChange),
//!   [`SequenceBifurcation`](analysis::SequenceBifurcation)), and its [`Stop`](analysis::Stop).
//!   [`PartialBranch`](analysis::PartialBranch) is one that can be stored and continued.
//!   [`SwitchedBranch`](analysis::SwitchedBranch) has those that begin at a special point. A
//!   [`NormalForm`](analysis::NormalForm) tells the [`Criticality`](analysis::Criticality) of a
//!   flip or torus.
//! - **Branches of equilibria**: [`EquilibriumBranch`](analysis::EquilibriumBranch) with
//!   [`EquilibriumPoint`](analysis::EquilibriumPoint),
//!   [`SpecialEquilibrium`](analysis::SpecialEquilibrium) and
//!   [`EquilibriumBifurcation`](analysis::EquilibriumBifurcation).
//! - **Curves in two parameters**: [`Curve`](analysis::Curve) of a special orbit or of an end, with
//!   [`CurvePoint`](analysis::CurvePoint), [`CurveSpecialPoint`](analysis::CurveSpecialPoint)
//!   ([`CurveBifurcation`](analysis::CurveBifurcation)) and [`CurveStop`](analysis::CurveStop).
//!   [`EquilibriumCurve`](analysis::EquilibriumCurve) of a special equilibrium, with
//!   [`EquilibriumCurvePoint`](analysis::EquilibriumCurvePoint) and
//!   [`EquilibriumCurveSpecial`](analysis::EquilibriumCurveSpecial)
//!   ([`EquilibriumCurveBifurcation`](analysis::EquilibriumCurveBifurcation)).
//! - **Exponents**: [`lyapunov_spectrum`](analysis::lyapunov_spectrum) by
//!   [`SpectrumOptions`](analysis::SpectrumOptions). A [`Spectrum`](analysis::Spectrum) has
//!   every [`Exponent`](analysis::Exponent) and its [`Running`](analysis::Running) values.
//! - **Derivatives**: [`OrbitDerivatives`](analysis::OrbitDerivatives) by every
//!   [`Variable`](analysis::Variable), or of a [`Differentiated`](analysis::Differentiated) run,
//!   with [`EventDerivatives`](analysis::EventDerivatives).
//!   [`OrbitTangents`](analysis::OrbitTangents) go beside an orbit of one's own loop.
//!
//! Sizes known only at run time, and jumps, are in [`dynamics`]:
//! - **Systems**: [`Dynamics`](dynamics::Dynamics) is the interface of the analyses.
//!   [`AsDynamics`](dynamics::AsDynamics) turns a typed system into a
//!   [`DynamicsRef`](dynamics::DynamicsRef); so do [`Typed`](dynamics::Typed), and
//!   [`WithJumps`](dynamics::WithJumps) for [`Jumps`](dynamics::Jumps), which may hang on a
//!   [`Comparison`](dynamics::Comparison). [`Components`](dynamics::Components) are a start of any
//!   form.
//! - **Recorded orbits**: [`RecordedOrbit`](dynamics::RecordedOrbit) has every phase,
//!   [`OrbitEvent`](dynamics::OrbitEvent) and passage, the states at the times of a
//!   [`Sampling`](dynamics::Sampling), and the state at any time.
//! - **Runs**: [`OrbitUnderWay`](dynamics::OrbitUnderWay) returns
//!   [`OrbitProgress`](dynamics::OrbitProgress): [`Step`](dynamics::Step),
//!   [`Phase`](dynamics::Phase), [`Transition`](dynamics::Transition),
//!   [`Kink`](dynamics::Kink), [`Passage`](dynamics::Passage) of a
//!   [`Section`](dynamics::Section) and [`Summary`](dynamics::Summary). They hold a
//!   [`Moment`](dynamics::Moment), [`Modes`](dynamics::Modes), a
//!   [`Solution`](dynamics::Solution) over a step, a [`Vector`](dynamics::Vector) or a
//!   [`Matrix`](dynamics::Matrix). A [`Listener`](dynamics::Listener) gets the steps of many
//!   orbits, with what [`Watching`](dynamics::Watching) asks for.
//!   [`Interrupt`](dynamics::Interrupt) ends a run, [`RunMemory`](dynamics::RunMemory) continues
//!   one. A [`SmoothFlow`](dynamics::SmoothFlow) is that of one mode, with every
//!   [`Guard`](dynamics::Guard) that ends it.
//!
//! Numbers and tools:
//! - **Numbers**: [`math`], functions with the same bits everywhere. [`scalar::Dual`] carries a
//!   derivative, [`scalar::Interval`] bounds. [`nalgebra`] has the vectors and matrices.
//! - **Solvers of your own**: [`ode::RungeKutta`] methods [`ode::Dop853`] and [`ode::Rk4`], with
//!   [`ode::step_end`], a [`ode::Dense`] solution over a step, and [`ode::henon_step`] with
//!   [`ode::Timed`] states.
//! - **Errors**: [`Error`], with [`error::Point`], [`error::ContactFault`] and
//!   [`error::Accumulation`]. [`error::readable`] writes a number.
//!
//! # Errors
//! Every failure is an [`Error`] with the values that explain it. [`solve`] returns the orbit up to
//! it in a [`Failure`].

// Of this workspace only this crate and its `stickslip-numerics` are published.
#![warn(missing_docs)]

pub mod analysis;
mod contact_fault;
mod dual;
mod duals;
pub mod dynamics;
pub mod error;
mod family;
mod filippov;
mod interval;
pub mod math;
pub mod ode;
mod orbit;
pub mod scalar;
mod system;
mod taylor;

/// The crate whose vectors and matrices appear in signatures. Use this one, so that the versions
/// agree.
pub use nalgebra;

pub use error::Error;
pub use family::{Family, Member};
pub use filippov::{
    AbsoluteTolerance, AtPileUp, AtRepelling, Contacts, Direction, EventFunctions, EventRecord,
    EventSearch, Failure, Fate, Integration, Locator, Method, Observer, Options, Phase, Progress,
    Several, Start, StepRecord, Switched, Transition, TransitionKind, Visibility, ensemble, fate,
    first_zero, run, solve, solve_with_events,
};
pub use orbit::{Approach, Counters, Ending, Orbit, Summary, TwoFold};
pub use scalar::Scalar;
pub use system::{Filippov, IntoState, Mode, Side, State};

/// The READMEs' examples are compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
