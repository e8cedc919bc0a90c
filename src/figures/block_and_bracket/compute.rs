//! The orbit, its spectra and what becomes of the equations as printed.

use super::Set;
use super::watch::Watch;
use crate::figures::FigureError;
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::analysis::{Spectrum, SpectrumOptions, lyapunov_spectrum_watched};
use stickslip::error::Error;
use stickslip::filippov::{Locator, Method, Options, run};
use stickslip::models::{BlockAndBracket, Reading};
use stickslip::system::State;
use stickslip_series::{DataSettings, DataSpectrum, Neighbourhood, Series, data_spectrum};

/// The series begins here, as in the paper.
pub(super) const START: f64 = 3000.0;
/// And ends here.
pub(super) const END: f64 = 12_000.0;
/// Time between two of its states.
pub(super) const DT: f64 = 0.2;
const TOLERANCE: f64 = 1e-10;
/// A component beyond this has diverged.
pub(super) const DIVERGED: f64 = 1e3;

/// A bounded motion, from `START` to `END`.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Exponents from the equations.
    pub spectrum: Spectrum,
    /// Evidence for the class of the motion.
    pub evidence: Evidence,
    /// The class.
    pub class: Class,
    /// Least normal force, unclipped, in units of `mg`.
    pub least_force: f64,
    /// Losses of contact.
    pub contact_losses: u64,
}

/// The equations as printed.
#[derive(Clone, Debug)]
pub enum Literal {
    /// A component exceeds 1000 at this time.
    Diverges(f64),
    /// It does not until the end of the series.
    Bounded(Box<Measured>),
}

/// What the figure shows.
#[derive(Clone, Debug)]
pub struct Data {
    /// The model with the corrected equations.
    pub model: BlockAndBracket,
    /// Its motion.
    pub exact: Measured,
    /// Exponents from the sampled states.
    pub from_data: DataSpectrum,
    /// The same by the nearest of the search's settings for the three figures together.
    pub best_of_readings: DataSpectrum,
    /// States sampled.
    pub samples: usize,
    /// The part of the orbit that is drawn.
    pub curve: Vec<[f64; 4]>,
    /// Its section points, the first few.
    pub turns: Vec<[f64; 4]>,
    /// All section points: where the block turns back.
    pub section: Vec<[f64; 4]>,
    /// The reading `as-printed`.
    pub literal: Literal,
}

/// Computes one of the three figures.
///
/// # Errors
/// [`FigureError::Compute`].
pub fn compute(set: &Set) -> Result<Data, FigureError> {
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| FigureError::Compute {
        figure: set.figure.name(),
        source,
    };
    // Two independent runs, each of them sequential: the same bits on any number of threads.
    let (exact, literal) = rayon::join(|| exact(set), || literal(set));
    let (model, exact, watched) = exact.map_err(|error| failed(error.into()))?;
    let samples = watched.series.len();
    let rows = watched.series.iter().copied();
    let series = Series::from_rows(rows, DT).map_err(|error| failed(error.into()))?;
    let spectrum =
        |settings| data_spectrum(&series, &settings).map_err(|error| failed(error.into()));
    let from_data = spectrum(DataSettings::sano_sawada())?;
    let best_of_readings = spectrum(best_common())?;
    let section: Vec<[f64; 4]> = watched.section.iter().map(|(_, x)| *x).collect();
    let turns = section.iter().take(16).copied().collect();
    Ok(Data {
        model,
        exact,
        from_data,
        best_of_readings,
        samples,
        curve: watched.curve,
        turns,
        section,
        literal: literal.map_err(|error| failed(error.into()))?,
    })
}

/// What is kept of a [`Watch`].
struct Watched {
    series: Vec<[f64; 4]>,
    section: Vec<(f64, [f64; 4])>,
    curve: Vec<[f64; 4]>,
}

fn exact(set: &Set) -> Result<(BlockAndBracket, Measured, Watched), Error> {
    let model = BlockAndBracket::from_caption(&set.caption, &Reading::exact())?;
    let (measured, watched) = measure(&model, set, Options::tol(TOLERANCE))?;
    Ok((model, measured, watched))
}

fn literal(set: &Set) -> Result<Literal, Error> {
    let model = BlockAndBracket::from_caption(&set.caption, &Reading::as_printed())?;
    let options = Options::tol(TOLERANCE).escape(DIVERGED);
    let start = State::from(set.caption.start);
    match run(&model, 0.0, start, END, &options, &mut ()) {
        Err(failure) => match failure.error {
            Error::Escaped { t, .. } => Ok(Literal::Diverges(t)),
            other => Err(other),
        },
        Ok(_) => {
            let (measured, _) = measure(&model, set, options)?;
            Ok(Literal::Bounded(Box::new(measured)))
        }
    }
}

/// Class of the motion by the procedure of Sect. 3: classical Runge–Kutta steps of one length, and
/// Hénon's step onto Σ. Nothing if the orbit escapes.
///
/// # Errors
/// Those of [`lyapunov_spectrum_watched`] except an escape.
pub fn by_rk4_and_henon(set: &Set, reading: &Reading, step: f64) -> Result<Option<Class>, Error> {
    let model = BlockAndBracket::from_caption(&set.caption, reading)?;
    let options = Options::tol(TOLERANCE)
        .method(Method::Rk4 { step })
        .locator(Locator::Henon)
        .escape(DIVERGED);
    match measure(&model, set, options) {
        Ok((measured, _)) => Ok(Some(measured.class)),
        Err(Error::Escaped { .. }) => Ok(None),
        Err(other) => Err(other),
    }
}

fn measure(
    model: &BlockAndBracket,
    set: &Set,
    solver: Options,
) -> Result<(Measured, Watched), Error> {
    let settings = SpectrumOptions::over(START, END - START).solver(solver);
    let mut watch = Watch::new(model, &settings.solver, set.shown);
    let start = (0.0, State::from(set.caption.start));
    let spectrum = lyapunov_spectrum_watched(model, start, &settings, &mut watch)?;
    let evidence = Evidence::gather(
        &watch.turns.points,
        (Of::Flow, &spectrum.exponents, spectrum.duration),
        &Criterion::default(),
    );
    let measured = Measured {
        class: evidence.class(),
        evidence,
        least_force: watch.least_force,
        contact_losses: watch.losses,
        spectrum,
    };
    let watched = Watched {
        series: watch.samples.states,
        section: watch.turns.points,
        curve: watch.curve,
    };
    Ok((measured, watched))
}

/// The estimator's settings that come nearest to all three figures together, of the settings of the
/// program `readings` with a radius in units of the spread, for
/// [`stickslip::models::Reading::exact`] solved exactly. The figures show what it gives. The first
/// few are as good as each other within the scatter of Fig. 12's chaotic orbit: a change of the
/// solver's last bits can exchange them, and a test of the search then says so.
pub(crate) fn best_common() -> DataSettings {
    DataSettings {
        neighbours: Neighbourhood::Ball {
            eps: 0.1,
            min: 12,
            max: 400,
        },
        step: 1,
        // Reference points all over the series.
        stride: 1,
        references: None,
        affine: false,
        sensitivity: true,
        ..DataSettings::sano_sawada()
    }
}
