//! How far an exponent of Figs. 10–12 moves over settings of the estimator that the paper does not state.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::figures::FigureError;
use crate::figures::block_and_bracket::{Set, compute};
use stickslip::analysis::data_spectrum::{
    DataError, DataSettings, Neighbourhood, Series, data_spectrum,
};
use stickslip::analysis::motion::Class;
use stickslip::error::Error;
use stickslip::filippov::{Observer, Options, StepRecord, run};
use stickslip::models::{BlockAndBracket, Caption, Reading};
use stickslip::system::State;

/// Begin and end of the series, and the time between two of its states: the paper's.
const WINDOW: (f64, f64) = (3000.0, 12_000.0);
const PER_UNIT: f64 = 5.0;
const TOLERANCE: f64 = 1e-10;
/// Reference points of an estimate, the first so many of the window; neighbours are sought in all of it.
const REFERENCES: usize = 5000;

/// The figures and their captions.
const FIGURES: [(&str, Caption); 3] = [
    ("fig10", Caption::FIG10),
    ("fig11", Caption::FIG11),
    ("fig12", Caption::FIG12),
];

/// One estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The settings in words.
    pub settings: String,
    /// Exponents, the largest first.
    pub exponents: [f64; 4],
}

/// All estimates of one figure's exponents.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureSpread {
    /// Name of the figure.
    pub figure: &'static str,
    /// One estimate for each of the settings.
    pub estimates: Vec<Estimate>,
}

impl FigureSpread {
    /// Least and largest finite value of exponent `i`, from 0.
    pub fn range(&self, i: usize) -> Option<(f64, f64)> {
        let values = self.estimates.iter().map(|one| one.exponents[i]);
        let finite = || values.clone().filter(|value| value.is_finite());
        Some((finite().reduce(f64::min)?, finite().reduce(f64::max)?))
    }
}

/// Estimates of all three figures, and the loops of Fig. 10.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Figs. 10, 11, 12.
    pub figures: Vec<FigureSpread>,
    /// Class of the motion of Fig. 10 with its caption mended, each of the three entries that can be at fault in turn.
    pub mended: Vec<(String, Class)>,
}

/// Why the spread could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum SpreadError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The estimator failed.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A figure could not be computed.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// Ball radii as fractions of the signal's spread, each with the most neighbours that it is cut to.
const BALLS: [(f64, usize); 3] = [(0.02, 40), (0.05, 100), (0.1, 400)];
/// `d` of Eq. (25).
const STEPS: [usize; 3] = [1, 3, 5];
/// Settings tried: all combinations, with linear and with affine maps.
pub fn settings() -> Vec<(String, DataSettings)> {
    let mut all = Vec::new();
    for (eps, max) in BALLS {
        for step in STEPS {
            for (affine, fit) in [(false, "linear"), (true, "affine")] {
                let name = format!("eps {eps}, 12 to {max} neighbours, d = {step}, {fit}");
                let settings = DataSettings {
                    neighbours: Neighbourhood::Ball { eps, min: 12, max },
                    step,
                    affine,
                    stride: step,
                    references: Some(REFERENCES),
                    sensitivity: false,
                    ..DataSettings::default()
                };
                all.push((name, settings));
            }
        }
    }
    all
}

/// The settings in words.
pub fn described() -> String {
    let balls: Vec<String> = BALLS
        .iter()
        .map(|(eps, max)| format!("{eps} with up to {max}"))
        .collect();
    let steps = STEPS.map(|step| step.to_string());
    format!(
        "ball radius {} neighbours, d = {}, linear or affine maps, {REFERENCES} reference points",
        balls.join(", "),
        steps.join(", ")
    )
}

/// Estimates and figures computed.
pub const JOBS: usize = FIGURES.len() * BALLS.len() * STEPS.len() * 2 + MENDED_ENTRIES;
/// Entries of Fig. 10's caption that may be at fault.
const MENDED_ENTRIES: usize = 3;

impl Spread {
    /// Estimates all, and calls `tick` after each.
    ///
    /// # Errors
    /// [`SpreadError`].
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Spread, SpreadError> {
        let series = FIGURES
            .par_iter()
            .map(|(_, caption)| series(caption))
            .collect::<Result<Vec<Series>, SpreadError>>()?;
        let settings = settings();
        let jobs: Vec<(usize, usize)> = (0..FIGURES.len())
            .flat_map(|figure| (0..settings.len()).map(move |k| (figure, k)))
            .collect();
        let mut estimates = jobs
            .par_iter()
            .map(|&(figure, k)| {
                let found = data_spectrum(&series[figure], &settings[k].1)?;
                let mut exponents: Vec<f64> = found.exponents.iter().map(|e| e.value).collect();
                exponents.sort_by(|one, other| other.total_cmp(one));
                tick();
                Ok(Estimate {
                    settings: settings[k].0.clone(),
                    exponents: std::array::from_fn(|i| {
                        exponents.get(i).copied().unwrap_or(f64::NAN)
                    }),
                })
            })
            .collect::<Result<Vec<_>, DataError>>()?
            .into_iter();
        let figures = FIGURES
            .iter()
            .map(|(figure, _)| FigureSpread {
                figure,
                estimates: estimates.by_ref().take(settings.len()).collect(),
            })
            .collect();
        let mended = mended_captions()
            .into_par_iter()
            .map(|(name, caption)| {
                let class = compute(&Set {
                    figure: "fig10",
                    caption,
                    shown: 1.0,
                    title: "",
                    description: "",
                })?
                .exact
                .class;
                tick();
                Ok((name, class))
            })
            .collect::<Result<_, FigureError>>()?;
        Ok(Spread { figures, mended })
    }
}

/// Fig. 10's caption with ξ6/μ0 = ξ4 − 1 restored, as it holds in the two other captions, by changing one of the three.
fn mended_captions() -> [(String, Caption); MENDED_ENTRIES] {
    let [_, _, _, xi4, _, mu0, xi6, _, _] = Caption::FIG10.numbers;
    [
        ("xi6", 6, mu0 * (xi4 - 1.0)),
        ("mu0", 5, xi6 / (xi4 - 1.0)),
        ("xi4", 3, 1.0 + xi6 / mu0),
    ]
    .map(|(name, place, value)| {
        let mut caption = Caption::FIG10;
        caption.numbers[place] = value;
        (format!("{name} = {value:.3}"), caption)
    })
}

/// The sampled motion that a caption describes, in the reading `exact`.
fn series(caption: &Caption) -> Result<Series, SpreadError> {
    let model = BlockAndBracket::from_caption(caption, &Reading::exact())?;
    let mut sampler = Sampler(Vec::new());
    let (start, options) = (State::from(caption.start), Options::tol(TOLERANCE));
    run(&model, 0.0, start, WINDOW.1, &options, &mut sampler)?;
    Ok(Series::from_rows(sampler.0, 1.0 / PER_UNIT)?)
}

/// States at equal intervals.
struct Sampler(Vec<[f64; 4]>);

impl Observer<4> for Sampler {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        loop {
            let t = WINDOW.0 + self.0.len() as f64 / PER_UNIT;
            if t > step.t_end {
                return ControlFlow::Continue(());
            }
            let x = if t == step.t_end {
                step.x_end
            } else {
                step.dense.at_time(t)
            };
            self.0.push(x.into());
        }
    }
}
