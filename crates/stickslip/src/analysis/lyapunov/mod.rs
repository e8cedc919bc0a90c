//! The full Lyapunov spectrum from the equations, through slips, sticks and moving boundaries.
//!
//! # Method
//! An orthonormal frame of tangent vectors is carried along the orbit and made orthonormal again after every step and every
//! transition; the logarithms of the lengths that Gram–Schmidt finds, divided by time, tend to the exponents in descending
//! order (Benettin, Galgani, Giorgilli & Strelcyn, *Meccanica* 15 (1980) 9; Shimada & Nagashima, *Prog. Theor. Phys.* 61
//! (1979) 1605). Steps carry the frame by being run again on dual numbers, crossings and entries into stick by their
//! saltation matrices (Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671; Leine & Nijmeijer, *Dynamics and Bifurcations of
//! Non-Smooth Mechanical Systems*, 2004, Ch. 7), with the boundary's own motion in them. Leaving stick changes no vector:
//! the sliding field and the field that takes over agree there.
//!
//! # What stick does
//! Entry into stick maps all states near Σ onto Σ. Its saltation matrix projects along `k = f_stick − f_slip` and has rank
//! `N − 1`: a full frame loses one direction, and whatever Gram–Schmidt would still find for it is rounding. So the loss is not
//! measured but known: the projection annihilates the frame's first vector that, together with those before it, spans a
//! space that holds `k` — for a full frame the last one, unless a symmetry of the system has it otherwise. That vector's
//! exponent is [`Exponent::Annihilated`], −∞, and it is never given a substitute.
//!
//! Further entries find `N − 1` vectors and map them onto Σ one to one, except where `k` lies in their span: a `k` that does
//! so to rounding takes another direction with it, one that does not is an ordinary stretch. So in general one exponent is −∞
//! however often the orbit sticks, and the other `N − 1` are those of the flow from Σ to Σ.
//!
//! # A check that does not use the frame's lengths
//! The volume that the surviving vectors span also follows from Liouville's formula: the divergence of the fields,
//! integrated by quadrature over the dense output, and for each transition the factor by which it changes volumes.
//! [`Spectrum::volume_rate`] is that rate, and [`Spectrum::defect`] what the sum of the finite exponents differs from it.

mod averages;
mod frame;
mod measurement;
mod settings;
mod spectrum;
mod volume;

pub use averages::Growth;
pub use settings::SpectrumOptions;
pub use spectrum::{Exponent, Running, Spectrum};

use crate::error::Error;
use crate::filippov::{Integration, Observer, Progress, Summary, Switched, tell};
use crate::system::State;
use measurement::Measurement;

/// The Lyapunov spectrum of the orbit from `(t0, x0)`; memory does not grow with the length of the run.
///
/// The orbit first runs for `settings.transient` with the frame on it, so that the frame has turned into the directions
/// that belong to the exponents, and is then measured for `settings.duration`. Directions that stick annihilated during the
/// transient come back at its end: an orbit that sticks only on its way to an attractor that does not has `N` finite
/// exponents.
///
/// Over a whole number of periods of a periodic orbit, after a transient that has brought orbit and frame onto it, the
/// exponents are those of the Floquet multipliers to rounding; otherwise they are off by a term that falls as one over the
/// duration.
///
/// ```
/// use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum};
/// use stickslip::models::BeltOscillator;
///
/// // A slow belt: the block sticks in every period.
/// let belt = BeltOscillator { belt_speed: 0.2, ..BeltOscillator::default() };
/// let settings = SpectrumOptions::over(50.0, 500.0);
/// let spectrum = lyapunov_spectrum(&belt, (0.0, [0.5, 0.1]), &settings)?;
/// assert!(spectrum.exponents[0].value().abs() < 0.02);
/// assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
/// assert!(spectrum.stick_entries > 10);
/// # Ok::<(), stickslip::Error>(())
/// ```
///
/// # Errors
/// [`Error::Option`]; those of [`crate::run`]; [`Error::NoUniqueFuture`] where the orbit ends on a repelling part of Σ or at a two-fold;
/// [`Error::TangentSingular`] where it grazes Σ so exactly that tangent vectors have no image, or two
/// contacts come to zero in the same instant.
pub fn lyapunov_spectrum(
    system: &dyn Dynamics,
    start: (f64, impl Components),
    settings: &dyn DynamicspectrumOptions,
) -> Result<Spectrum, Error> {
    lyapunov_spectrum_watched(system, start, settings, &mut ())
}

/// [`lyapunov_spectrum`] with an observer of the measured part of the run as well, for minima, sections and
/// the like in the same pass. If it ends the run, the spectrum is that of the part so far.
///
/// # Errors
/// As [`lyapunov_spectrum`].
pub fn lyapunov_spectrum_watched<S, O>(
    system: &dyn Dynamics,
    (t0, x0): (f64, impl Components),
    settings: &dyn DynamicspectrumOptions,
    watcher: &mut O,
) -> Result<Spectrum, Error>
    O: Observer + ?Sized,
{
    settings.check()?;
    // Where an orbit rests, one step would be as long as all blocks.
    let block = settings.duration / settings.blocks as f64;
    let solver = settings.solver;
    let settings = &settings.solver(solver.longest_step(solver.longest_step.min(block)));
    let mut measurement = Measurement::new(system, settings);
    let mut begin = (t0, x0.into());
    if settings.transient > 0.0 {
        let t_end = t0 + settings.transient;
        let reached = follow(system, begin, t_end, settings, &mut measurement, &mut ())?;
        begin = (reached.t, reached.x);
    }
    measurement.begin_measuring(begin.0);
    let t_end = begin.0 + settings.duration;
    let summary = follow(system, begin, t_end, settings, &mut measurement, watcher)?;
    Ok(measurement.finish(summary))
}

/// Goes along an orbit with the frame first and `watcher` behind it.
fn follow<S, O>(
    system: &dyn Dynamics,
    (t, x): (f64, Vector),
    t_end: f64,
    settings: &dyn DynamicspectrumOptions,
    measurement: &mut Measurement<'_, S, N>,
    watcher: &mut O,
) -> Result<Summary, Error>
    O: Observer + ?Sized,
{
    let mut integration = Integration::new(system, t, x, t_end, &settings.solver)?;
    let mut is_stopping = false;
    loop {
        let progress = integration.step()?;
        match &progress {
            Progress::Step => measurement.step(&integration.last_step())?,
            Progress::Transition(at) => measurement.transition(at)?,
            Progress::PhaseEnd(_) => {}
            Progress::End(summary) if summary.ending.is_final() => {
                return Err(summary.goes_no_further());
            }
            Progress::End(_) => {}
        }
        if let Some(summary) = tell(&mut integration, &progress, watcher, &mut is_stopping)? {
            return Ok(summary);
        }
    }
}
