//! The full Lyapunov spectrum from the equations, through slips, sticks and moving boundaries.
//!
//! # Method
//! An orthonormal frame of tangent vectors is carried along the orbit and made orthonormal again
//! after every step and every transition. The logarithms of the Gram–Schmidt lengths, divided by
//! time, tend to the exponents in descending order (Benettin, Galgani, Giorgilli & Strelcyn,
//! *Meccanica* 15 (1980) 9; Shimada & Nagashima, *Prog. Theor. Phys.* 61 (1979) 1605). Steps are
//! repeated on dual numbers to carry the frame. Crossings and entries into stick apply their
//! saltation matrices (Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671; Leine & Nijmeijer,
//! *Dynamics and Bifurcations of Non-Smooth Mechanical Systems*, 2004, Ch. 7), which include the
//! boundary's own motion. Leaving stick changes no vector: the sliding field and the new field
//! agree there.
//!
//! # The effect of stick
//! Entry into stick maps all states near Σ onto Σ. Its saltation matrix projects along `k = f_stick
//! − f_slip` and has rank `N − 1`. A full frame loses one direction, and the length that
//! Gram–Schmidt would still compute for it is rounding. So the loss is determined in advance, not
//! measured. The projection annihilates the first vector that, together with those before it, spans
//! a space containing `k`. In a full frame this is the last one, unless a symmetry of the system
//! decides otherwise. That vector's exponent is [`Exponent::Annihilated`], −∞, and the vector is
//! never replaced.
//!
//! Further entries meet `N − 1` vectors and map them onto Σ one to one, except where `k` lies in
//! their span. A `k` that does so to rounding annihilates another direction; any other `k` is an
//! ordinary stretch. So in general one exponent is −∞ however often the orbit sticks, and the other
//! `N − 1` are those of the flow from Σ to Σ.
//!
//! A jump that sets states to constants has a kernel of several dimensions, and annihilates as many
//! directions in the same way. A jump into an equilibrium annihilates all.
//!
//! # A check independent of the frame's lengths
//! The volume that the surviving vectors span also follows from Liouville's formula. The divergence
//! of the fields is integrated by quadrature over the dense output, and each transition contributes
//! the factor by which it changes volumes. [`Spectrum::volume_rate`] is the resulting rate, and
//! [`Spectrum::defect`] its difference from the sum of the finite exponents.

mod averages;
mod frame;
mod measurement;
mod rounding;
mod settings;
mod spectrum;
mod volume;

pub use settings::SpectrumOptions;
pub use spectrum::{Exponent, Running, Spectrum};

use crate::dynamics::{
    AsDynamics, Components, Dynamics, Moment, OrbitProgress, OrbitUnderWay, Summary, Typed,
    observed,
};
use crate::error::Error;
use crate::filippov::{Observer, Options, Switched};
use crate::orbit::Ending;
use measurement::Measurement;

/// The Lyapunov spectrum of the orbit from `(t0, x0)`; memory does not grow with the length of the
/// run.
///
/// The orbit first runs for `settings.transient` with the frame, so that the frame aligns with the
/// directions of the exponents. It is then measured for `settings.duration`. Directions that stick
/// annihilates during the transient are restored at its end. So an orbit that sticks only on its
/// way to an attractor without stick has `N` finite exponents.
///
/// Over an integer number of periods of a periodic orbit, the exponents are those of the Floquet
/// multipliers to rounding. The transient must have brought orbit and frame onto the orbit.
/// Otherwise they have an error that falls as one over the duration.
///
/// A measurement that ends early, by one of the errors below, yields what it has measured, with the
/// error in [`Spectrum::ended`]. It may end before two blocks are complete, or where the motion
/// shrinks to a point, or where a jump stops the orbit. Then the first half of most of the time
/// until the end is the transient, and the second half is measured.
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
///
/// // A slow belt: the block sticks in every period.
/// let belt = Belt { speed: 0.2 };
/// let settings = SpectrumOptions::over(50.0, 500.0);
/// let spectrum = lyapunov_spectrum(&belt, (0.0, [0.5, 0.1]), &settings)?;
/// assert!(spectrum.exponents[0].value().abs() < 0.02);
/// assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
/// assert!(spectrum.stick_entries > 10);
/// // One tangent vector is enough for the largest.
/// let largest = Exponent::largest(&belt, (0.0, [0.5, 0.1]), &settings)?;
/// assert_eq!(largest, spectrum.exponents[0]);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// [`Error::Option`]; those of [`crate::run`]. [`Error::NoUniqueFuture`] where the orbit ends on a
/// repelling part of Σ or at a two-fold. [`Error::Stopped`] where a jump or a terminal event stops
/// it. [`Error::TangentSingular`] where it grazes Σ so exactly
/// that tangent vectors have no image, or two contacts reach zero in the same instant.
pub fn lyapunov_spectrum<Kind>(
    system: &impl AsDynamics<Kind>,
    (t, x): (f64, impl Components),
    settings: &SpectrumOptions,
) -> Result<Spectrum, Error> {
    let start = Moment { t, x: x.vector() };
    let system = &*system.dynamics();
    let all = system.states();
    measured_alone(system, start.clone(), settings, all).or_else(|error| {
        // What ends the transient, or the measurement just after it, leaves the time before.
        let place = error
            .place()
            .filter(|_| !matches!(error, Error::Interrupted { .. }));
        let time = place.map_or(0.0, |(end, _)| PART_BEFORE_END * (end - start.t));
        if time <= 0.0 {
            return Err(error);
        }
        let shorter = SpectrumOptions {
            transient: time,
            duration: time,
            ..*settings
        };
        match spectrum_of(system, start, &shorter) {
            Ok(spectrum) => Ok(Spectrum {
                ended: Some(error),
                ..spectrum
            }),
            Err(_) => Err(error),
        }
    })
}

/// Part of a time that ends early in which the frame settles, and part that is measured. The last
/// tenth is left out, as an orbit may be inexact before it is lost. Chosen.
const PART_BEFORE_END: f64 = 0.45;

/// [`lyapunov_spectrum`], except that a measurement that ends early is an error.
pub(super) fn spectrum_of(
    system: &dyn Dynamics,
    start: Moment,
    settings: &SpectrumOptions,
) -> Result<Spectrum, Error> {
    whole(measured_alone(system, start, settings, system.states())?)
}

/// The spectrum of so many vectors, without an observer.
fn measured_alone(
    system: &dyn Dynamics,
    start: Moment,
    settings: &SpectrumOptions,
    count: usize,
) -> Result<Spectrum, Error> {
    let run = |refines: bool| {
        let begin =
            |at: &Moment, t_end: f64, options: &Options| system.begin(at, t_end, options, &[]);
        let whole = measured(system, start.clone(), (settings, count, refines), begin)?;
        match whole.summary.ending {
            // What stops the run leaves a time that is not known before, and blocks of that time.
            Ending::Stopped => Err(whole.summary.no_future_error()),
            _ => Ok(whole),
        }
    };
    match run(false) {
        Err(shrunk @ Error::Shrunk { .. }) => match run(true) {
            Err(error) if !matches!(error, Error::Shrunk { .. }) => Err(shrunk),
            refined => refined,
        },
        result => result,
    }
}

impl Exponent {
    /// The largest exponent alone, from one tangent vector: the first of [`lyapunov_spectrum`] in a
    /// fraction of its time.
    ///
    /// If exponents are equal, as in a spiral, the spectrum begins with the vector that grew most
    /// over the measured time. Here there is only one vector.
    ///
    /// # Errors
    /// As [`lyapunov_spectrum`], however much has been measured.
    pub fn largest<Kind>(
        system: &impl AsDynamics<Kind>,
        (t, x): (f64, impl Components),
        settings: &SpectrumOptions,
    ) -> Result<Exponent, Error> {
        let start = Moment { t, x: x.vector() };
        let system = &*system.dynamics();
        let alone = whole(measured_alone(system, start.clone(), settings, 1)?)?.exponents[0];
        match alone {
            // Other vectors may survive the one that is annihilated.
            Exponent::Annihilated => Ok(spectrum_of(system, start, settings)?.exponents[0]),
            Exponent::Finite { .. } => Ok(alone),
        }
    }
}

impl Spectrum {
    /// [`lyapunov_spectrum`] with an observer of the measured part of the run, for minima, sections
    /// and the like in the same integration. If the observer ends the run, the spectrum is that of
    /// the part so far.
    ///
    /// # Errors
    /// As [`lyapunov_spectrum`], however much has been measured. [`Error::Stopped`] where the
    /// observer ends the run before its first step.
    pub fn watched<S, O, const N: usize, const G: usize>(
        system: &S,
        (t, x): (f64, impl Components),
        settings: &SpectrumOptions,
        mut watcher: &mut O,
    ) -> Result<Spectrum, Error>
    where
        S: Switched<N, G> + Send + Sync,
        O: Observer<N, S::Mode> + ?Sized,
    {
        let start = Moment { t, x: x.vector() };
        let dynamics = Typed::<&S, S, _, _, _, N, G>::new(system);
        let spectrum = measured(
            &dynamics,
            start,
            (settings, N, false),
            |at, t_end, options| observed(system, (at, t_end), options, &mut watcher),
        );
        whole(spectrum?)
    }
}

/// The spectrum of so many vectors; `begin` begins the measured part of the run. With `refines`,
/// the absolute tolerance follows a decay to zero: linear parts decide the exponents there unless a
/// boundary passes through zero, and then directions do.
fn measured<'a>(
    system: &dyn Dynamics,
    mut start: Moment,
    (settings, count, refines): (&SpectrumOptions, usize, bool),
    begin: impl FnOnce(&Moment, f64, &Options) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>,
) -> Result<Spectrum, Error> {
    settings.check()?;
    // At an equilibrium, one step would be as long as all blocks.
    let block = settings.duration / settings.blocks as f64;
    let solver = settings.solver;
    let settings = settings.solver(solver.longest_step(solver.longest_step.min(block)));
    let mut measurement = Measurement::new(system, settings, (count, refines));
    if settings.transient > 0.0 {
        let t_end = start.t + settings.transient;
        let mut orbit = system.begin(&start, t_end, &measurement.settings.solver, &[])?;
        let summary = follow(&mut orbit, t_end, &mut measurement)?;
        if summary.ending == Ending::Stopped {
            return Err(summary.no_future_error());
        }
        let Summary { t, x, .. } = summary;
        start = Moment { t, x };
    }
    measurement.begin_measuring(start.t);
    let t_end = start.t + settings.duration;
    let mut orbit = begin(&start, t_end, &measurement.settings.solver)?;
    match follow(&mut orbit, t_end, &mut measurement) {
        Ok(summary) if summary.t <= start.t => Err(summary.no_future_error()),
        Ok(summary) => Ok(measurement.finish(summary, None)),
        Err(error @ (Error::Interrupted { .. } | Error::Shrunk { .. })) => Err(error),
        Err(error) => match measurement.reached(2.0 * block) {
            Some(Moment { t, x }) => {
                let (ending, counters) = (Ending::Failed, orbit.counters());
                let summary = Summary {
                    ending,
                    t,
                    x,
                    counters,
                };
                Ok(measurement.finish(summary, Some(error)))
            }
            None => Err(error),
        },
    }
}

/// The spectrum of a run that has not ended early.
fn whole(spectrum: Spectrum) -> Result<Spectrum, Error> {
    spectrum.ended.clone().map_or(Ok(spectrum), Err)
}

/// Integrates an orbit with the frame.
///
/// Where the measurement refines its tolerance, another orbit continues from the middle of a step,
/// which lies on no boundary.
fn follow<'a>(
    orbit: &mut Box<dyn OrbitUnderWay + 'a>,
    t_end: f64,
    measurement: &mut Measurement<'a>,
) -> Result<Summary, Error> {
    loop {
        match orbit.step()? {
            OrbitProgress::Step => {
                let mut step = orbit.last_step();
                let is_refined = measurement.is_to_be_refined(&step);
                if is_refined {
                    let t = 0.5 * (step.t_start + step.t_end);
                    let x = orbit.solution()(t);
                    step = step.cut(&Moment { t, x });
                }
                measurement.step(&step, &mut **orbit)?;
                if is_refined {
                    *orbit = measurement.refine(&step.end(), t_end)?;
                }
            }
            OrbitProgress::Transition(at) => measurement.transition(&at)?,
            OrbitProgress::PhaseEnd(_) | OrbitProgress::Passage(_) | OrbitProgress::Kink(_) => {}
            OrbitProgress::End(summary) if summary.ending.is_final() => {
                return Err(summary.no_future_error());
            }
            OrbitProgress::End(summary) => return Ok(summary),
        }
    }
}
