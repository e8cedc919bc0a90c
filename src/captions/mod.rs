//! Effect of the rounding of the captions of Figs. 10–12 on exponents and classes.
//!
//! The captions have three decimals. The program `captions` moves every number that is not zero by
//! at most half a unit of the last one, evenly and independently, and computes the spectrum from
//! the equations again. The zeros `ξ2 = ξ5 = 0.000` stay: they say that there are no dampers, which
//! the order of the nine numbers rests on ([`crate::paper::models::CaptionOrder`]). The starts stay
//! too, since the motions forget them.
//!
//! [`committed`] is the table `golden/captions.csv`, [`ExponentBudget`] what it says on an
//! exponent.

pub mod cli;
mod table;

use rayon::prelude::*;

use crate::figures::block_and_bracket::{FigureSet, SETS, TOLERANCE};
use crate::motion::{Class, Criterion, Evidence, SystemKind};
use crate::orbit_records::TurningPoints;
use crate::paper::models::{BlockAndBracket, Caption, Interpretation};
use numerics::SplitMix;
use std::ops::ControlFlow;
use stickslip::analysis::{Exponent, Spectrum, SpectrumOptions};
use stickslip::{Error, Locator, Method, Observer, Options, State, StepRecord};
pub use table::{CaptionTable, ExponentBudget, committed};

/// Draws for each figure.
pub const DRAWS: usize = 200;
/// Half a unit of the captions' last decimal.
pub const HALF_UNIT: f64 = 0.0005;
/// Seed of the draws, the same in every run: the paper's year, volume and page of the captions.
const SEED: u64 = 0x2013_0073_0733;
/// Time run before measuring. The slowest decay of the three motions, 0.008, leaves 1e-7 of a
/// start. Weak phase locking may decay more slowly; then it is not told from a torus.
const TRANSIENT: f64 = 2000.0;
/// Time measured, a third of the paper's series: enough to see the effect on Figs. 10 and 11. Any
/// on Fig. 12 is less than the scatter of a chaotic orbit over that time.
pub const DURATION: f64 = 3000.0;
/// Largest uncertainty of an exponent that counts as zero (1/t): that of the figures, over a third
/// of their time.
const RESOLUTION: f64 = 3e-3;
/// Tolerance of the run that shows the effect of the tolerance: a hundred times the figures'.
const COARSE_TOLERANCE: f64 = 1e-8;
/// Step of the run that shows the effect of the paper's own method, its Sect. 3.
const FIXED_STEP: f64 = 5e-3;

/// A spectrum of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptionVariant {
    /// The caption as printed.
    Printed,
    /// The caption as printed, with a tolerance of 1e-8 instead of 1e-10.
    CoarseTolerance,
    /// The caption as printed, by Runge–Kutta steps of 0.005 and Hénon's step onto Σ.
    FixedStep,
    /// The numbers of a draw, counted from 1.
    Draw(usize),
}

impl CaptionVariant {
    /// All of a figure, in the order of the table.
    pub fn all() -> impl Iterator<Item = CaptionVariant> {
        let computed_otherwise = [
            CaptionVariant::Printed,
            CaptionVariant::CoarseTolerance,
            CaptionVariant::FixedStep,
        ];
        computed_otherwise
            .into_iter()
            .chain((1..=DRAWS).map(CaptionVariant::Draw))
    }

    /// Name in the table.
    pub fn name(self) -> String {
        match self {
            CaptionVariant::Printed => "printed".into(),
            CaptionVariant::CoarseTolerance => format!("tolerance {COARSE_TOLERANCE:e}"),
            CaptionVariant::FixedStep => format!("step {FIXED_STEP}"),
            CaptionVariant::Draw(number) => format!("draw {number}"),
        }
    }

    /// The caption's numbers.
    fn numbers(self, figure: usize) -> [f64; 9] {
        let printed = SETS[figure].caption.numbers;
        let CaptionVariant::Draw(number) = self else {
            return printed;
        };
        // Each draw has nine numbers of the sequence of its own.
        let place = (figure * DRAWS + number - 1) * printed.len();
        let mut random = SplitMix::from_index(SEED, place as u64);
        printed.map(|value| {
            let moved = value + random.between(-HALF_UNIT, HALF_UNIT);
            if value == 0.0 { 0.0 } else { moved }
        })
    }

    fn solver(self) -> Options {
        match self {
            CaptionVariant::CoarseTolerance => Options::tol(COARSE_TOLERANCE),
            CaptionVariant::FixedStep => Options::tol(TOLERANCE)
                .method(Method::Rk4 { step: FIXED_STEP })
                .locator(Locator::Henon),
            _ => Options::tol(TOLERANCE),
        }
    }
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptionSpectrum {
    /// Figure, from 0 for Fig. 10.
    pub figure: usize,
    /// Spectrum of the figure.
    pub variant: CaptionVariant,
    /// The nine numbers of the caption.
    pub numbers: [f64; 9],
    /// Class of the motion.
    pub class: Class,
    /// Exponents (1/t); −∞ for a direction that stick annihilates.
    pub exponents: [f64; 4],
    /// Standard errors of the exponents (1/t), statistical only; not a number for one of −∞.
    pub std_errors: [f64; 4],
}

impl CaptionSpectrum {
    /// An exponent, from 0.
    fn exponent(&self, k: usize) -> Exponent {
        let (value, std_error) = (self.exponents[k], self.std_errors[k]);
        match value == f64::NEG_INFINITY {
            true => Exponent::Annihilated,
            false => Exponent::Finite { value, std_error },
        }
    }

    /// Whether an exponent, from 0, is zero within its uncertainty.
    pub fn is_zero(&self, k: usize) -> bool {
        let exponent = self.exponent(k);
        exponent.value().abs() <= exponent.uncertainty(DURATION)
    }
}

/// The section of the measured part of a run.
struct SectionPoints<'a>(TurningPoints<'a>);

impl Observer<4> for SectionPoints<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.0.step(step);
        ControlFlow::Continue(())
    }
}

/// Computes a row of the table.
///
/// # Errors
/// The solver's.
pub fn caption_spectrum(figure: usize, variant: CaptionVariant) -> Result<CaptionSpectrum, Error> {
    let FigureSet { caption, .. } = SETS[figure];
    let numbers = variant.numbers(figure);
    let caption = Caption { numbers, ..caption };
    let model = BlockAndBracket::from_caption(&caption, &Interpretation::exact())?;
    let settings = SpectrumOptions::over(TRANSIENT, DURATION).solver(variant.solver());
    let mut section = SectionPoints(TurningPoints::new(&model, &settings.solver));
    let start = (0.0, State::from(caption.start));
    let spectrum = Spectrum::watched(&model, start, &settings, &mut section)?;
    let of = (SystemKind::Flow, &spectrum.exponents[..], spectrum.duration);
    let criterion = Criterion {
        resolution: RESOLUTION,
        ..Criterion::default()
    };
    let evidence = Evidence::gather(&section.0.points, of, &criterion);
    let each = |k: usize| spectrum.exponents[k];
    Ok(CaptionSpectrum {
        figure,
        variant,
        numbers,
        class: evidence.class(),
        exponents: std::array::from_fn(|k| each(k).value()),
        std_errors: std::array::from_fn(|k| each(k).std_error().unwrap_or(f64::NAN)),
    })
}

/// Computes the whole table and calls `tick` after each row. The result does not depend on the
/// number of threads.
///
/// # Errors
/// The solver's.
pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<CaptionTable, Error> {
    let of_figure = |figure| CaptionVariant::all().map(move |variant| (figure, variant));
    let jobs: Vec<(usize, CaptionVariant)> = (0..SETS.len()).flat_map(of_figure).collect();
    let row = |&(figure, variant): &(usize, CaptionVariant)| {
        let row = caption_spectrum(figure, variant);
        tick();
        row
    };
    let rows = jobs.par_iter().with_max_len(1).map(row);
    Ok(CaptionTable::new(rows.collect::<Result<_, Error>>()?))
}

/// Number of rows.
pub fn rows() -> u64 {
    (SETS.len() * CaptionVariant::all().count()) as u64
}
