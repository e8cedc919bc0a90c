//! `stickslip spectrum`: the Lyapunov spectrum of a time series.

mod figure;
mod findings;
mod json;
mod warnings;

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use stickslip::error::readable;
use stickslip_series::{
    DataError, DataSettings, Degree, EmbeddingSettings, Estimator, Given, Neighbourhood, Progress,
    SURROGATE_SEED, Series, check_surrogates, data_spectrum_with, divergence, needed_embedding,
    reversal, surrogate_test,
};

use crate::failure::Failure;
use crate::render::{CommandOutput, OutputArguments, Report};
use crate::table;
use findings::{Embedded, Findings};
use output::terminal::{DelayedProgressBar, note};

const ABOUT: &str = "Lyapunov exponents of a time series: maps fitted to neighbours of each point \
    at two sizes, chained along the series and extrapolated to size zero. A status says which \
    exponents the data determine. --estimator sano-sawada is the method of Sano and Sawada, linear \
    maps of one size.";

const AFTER: &str = include_str!("help.txt").trim_ascii_end();

/// Text after `-h`, which has a line for each option.
const AFTER_SHORT: &str = "\
One column is embedded; several are the state as they are, unless they lack one. \
A column named t or time gives --dt.
Example: stickslip spectrum lorenz.dat --dt 0.02 --columns 1
What the statuses of exponents and the columns of the table mean, which files are read,
more examples: --help";

/// Lyapunov exponents of a time series from a file, without equations
#[derive(Debug, clap::Args)]
#[command(long_about = ABOUT, after_help = AFTER_SHORT, after_long_help = AFTER)]
pub(super) struct Arguments {
    /// Text with one state per line, or a .npy array; - for standard input
    ///
    /// Commas, semicolons, tabs or spaces separate the columns. The first line may hold names.
    file: PathBuf,

    /// Time between two lines [default: of the column t or time]
    ///
    /// 1 for a map.
    #[arg(long, value_parser = number, value_name = "TIME")]
    dt: Option<f64>,

    /// Columns to use, by number (from 1) or name [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    columns: Vec<String>,

    /// Radius of the neighbourhoods over the spread √Σvar [default: 0.1]
    #[arg(long, value_parser = number, value_name = "FRACTION")]
    eps: Option<f64>,

    /// Neighbours: fewest and most in the ball, or the number of nearest
    ///
    /// [default: 12-12; 40-40 for delayed values, fewer below 4000 points]
    #[arg(long, value_parser = neighbours, value_name = "MIN-MAX|K")]
    neighbours: Option<Neighbours>,

    /// Delayed values of each column in a state
    ///
    /// 1 takes the columns as they are. [default: for one column the first number with less than
    /// 1 % false neighbours]
    #[arg(long, value_parser = count, value_name = "VALUES")]
    dimension: Option<usize>,

    /// Points between delayed values
    ///
    /// [default: first minimum of the mutual information; 1 for a map, a quarter of a period for a
    /// clean periodic motion]
    #[arg(long, value_parser = count, value_name = "POINTS")]
    delay: Option<usize>,

    /// Number of points that a map predicts ahead
    ///
    /// [default: 1; the delay for delayed values]
    #[arg(long, value_parser = count, value_name = "D")]
    step: Option<usize>,

    /// Theiler window: closer points in time are not neighbours
    ///
    /// [default: time in which the autocorrelation falls to 1/e]
    #[arg(long, value_parser = count, value_name = "POINTS")]
    theiler: Option<usize>,

    /// Fit a constant term, too, to the linear map of Eq. (25)
    #[arg(long)]
    affine: bool,

    /// Singular values below this fraction of the largest are zero
    #[arg(
        long,
        value_parser = number,
        value_name = "FRACTION",
        default_value_t = DataSettings::default().rank_tolerance
    )]
    rank_tolerance: f64,

    /// Estimator of the exponents from the local maps
    #[arg(long, value_enum, default_value_t = Method::Extrapolated)]
    estimator: Method,

    /// Degree of the maps that are extrapolated
    ///
    /// The error of linear maps contains their difference from quadratic ones where the series is
    /// long enough for these. In shorter series it contains too little of the bias. [default:
    /// quadratic where the series is long enough]
    #[arg(long, value_enum)]
    degree: Option<MapDegree>,

    /// Mean divergence of the system, to which the exponents must add up
    ///
    /// It is the trace of the Jacobian per unit of time; of a map, ln |det J|. The columns must be
    /// the system's state.
    #[arg(long, value_parser = number, value_name = "VALUE")]
    divergence: Option<f64>,

    /// Tikhonov term over the largest singular value
    #[arg(long, value_parser = number, value_name = "FRACTION", default_value_t = 0.0)]
    ridge: f64,

    /// Rank of the second fit [default: number of tangent directions]
    #[arg(long, value_parser = count, value_name = "RANK")]
    rank: Option<usize>,

    /// Distance between reference points, in points
    ///
    /// [default: 1; for delayed values with maps over one delay the largest that leaves a third of
    /// all, and 1500]
    #[arg(long, value_parser = count, value_name = "POINTS")]
    stride: Option<usize>,

    /// Most reference points, from the first on [default: all]
    ///
    /// At least 20.
    #[arg(long, value_parser = count, value_name = "COUNT")]
    references: Option<usize>,

    /// Number of surrogates of linear noise to compare with, at least 19
    ///
    /// Each surrogate takes as long as the series.
    #[arg(long, value_parser = count, value_name = "COUNT")]
    surrogates: Option<usize>,

    /// Print JSON
    #[arg(long, conflicts_with = "csv")]
    json: bool,

    /// Print CSV
    #[arg(long)]
    csv: bool,

    /// Folder for a picture, spectrum.svg
    ///
    /// It is created if it does not exist.
    #[arg(long, value_name = "DIR", visible_alias = "out-dir")]
    out: Option<String>,
}

/// Estimator of the exponents from the local maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Extrapolation from two sizes of the neighbourhoods to size zero, with its error
    Extrapolated,
    /// Linear maps of one size, Eqs. (25) and (26) of the paper, no correction
    SanoSawada,
}

/// Degree of the maps that are extrapolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MapDegree {
    /// Linear maps
    Linear,
    /// Quadratic forms beside them
    Quadratic,
}

/// Fewest and most neighbours taken from a ball; without the latter the number of nearest ones.
type Neighbours = (usize, Option<usize>);

fn neighbours(text: &str) -> Result<Neighbours, String> {
    let number = |part: &str| {
        part.trim().parse::<usize>().map_err(|_| {
            format!("'{part}' is no number of neighbours; give 30, or a range such as 20-40")
        })
    };
    match text.split_once('-') {
        Some((min, max)) => Ok((number(min)?, Some(number(max)?))),
        None => Ok((number(text)?, None)),
    }
}

/// Parses a number from the command line.
fn number(text: &str) -> Result<f64, String> {
    let pointed = text.replace(',', ".");
    match text.parse() {
        Ok(value) => Ok(value),
        Err(_) if pointed.parse::<f64>().is_ok() => Err(format!(
            "a number has a decimal point here: write {pointed}"
        )),
        Err(_) => Err("this is not a number; write it as 0.02 or 2e-2".into()),
    }
}

/// Parses a whole number from the command line.
fn count(text: &str) -> Result<usize, String> {
    text.parse()
        .map_err(|_| format!("a whole number from 0 to {} is needed", usize::MAX))
}

impl Arguments {
    /// Settings of the estimator.
    ///
    /// # Errors
    /// [`Failure::Usage`] for options that exclude one another.
    fn settings(&self) -> Result<DataSettings, Failure> {
        let degree = self.degree.map(|degree| match degree {
            MapDegree::Linear => Degree::Linear,
            MapDegree::Quadratic => Degree::Quadratic,
        });
        let mut settings = DataSettings {
            estimator: match self.estimator {
                Method::Extrapolated => Estimator::Extrapolated { degree },
                Method::SanoSawada => Estimator::SanoSawada,
            },
            theiler: self.theiler,
            step: self.step.unwrap_or(1),
            affine: self.affine,
            rank_tolerance: self.rank_tolerance,
            ridge: self.ridge,
            fixed_rank: self.rank,
            stride: self.stride.unwrap_or(1),
            references: self.references,
            ..DataSettings::default()
        };
        if let Some((count, None)) = self.neighbours {
            if self.eps.is_some() {
                let twice = count.saturating_mul(2);
                return Err(Failure::Usage(format!(
                    "--neighbours {count} takes the nearest {count} points and no ball, so that \
                     --eps has no meaning; give a range such as --neighbours {count}-{twice}, or \
                     no --eps"
                )));
            }
            settings.neighbours = Neighbourhood::Nearest(count);
        } else if let Neighbourhood::Ball { eps, min, max } = &mut settings.neighbours {
            *eps = self.eps.unwrap_or(*eps);
            if let Some((least, Some(most))) = self.neighbours {
                (*min, *max) = (least, most);
            }
        }
        Ok(settings)
    }

    /// Rejects invalid options before the file is read.
    fn check(&self) -> Result<(), Failure> {
        if let Some(dt) = self.dt {
            Series::new(vec![0.0], 1, dt)?;
        }
        self.surrogates.map_or(Ok(()), check_surrogates)?;
        match self.divergence {
            Some(value) if !value.is_finite() => {
                Err(Failure::Usage(refused("divergence", value, "finite")))
            }
            _ => Ok(()),
        }
    }
}

fn refused(setting: &str, value: f64, bound: &str) -> String {
    let flag = match setting {
        // `min` and `max` are the two ends of one option.
        "min" => "neighbours, minimum",
        "max" => "neighbours, maximum",
        "fixed_rank" => "rank",
        "rank_tolerance" => "rank-tolerance",
        same => same,
    };
    let value = readable(value);
    format!("--{flag} = {value} is not allowed: it must be {bound}")
}

impl From<DataError> for Failure {
    /// Settings are named after their options.
    fn from(error: DataError) -> Self {
        match error {
            DataError::Setting { name, value, bound } => Self::Usage(refused(name, value, &bound)),
            // The defaults never extend beyond the end of a series, so the option is at fault.
            DataError::Span { .. } => Self::Usage(error.to_string()),
            other => Self::Series(other),
        }
    }
}

/// Runs `work`, which reports how much is done and how much there is.
fn counted<T>(what: &str, work: impl FnOnce(Progress<'_>) -> T) -> T {
    let progress =
        DelayedProgressBar::new(format!("{what} {{bar:40}} {{percent}} %, {{eta}} to go"));
    let outcome = work(&|done, total| {
        progress.done(done as u64, total.max(1) as u64);
        ControlFlow::Continue(())
    });
    progress.clear();
    outcome
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    let settings = arguments.settings()?;
    arguments.check()?;
    let source = counted("reading", |report| {
        table::read(
            &arguments.file,
            &arguments.columns,
            arguments.dt,
            &|done, total| {
                let _ = report(done, total);
            },
        )
    })?;
    let series = Series::new(source.values.clone(), source.names.len(), source.dt)?;
    let findings = find(&series, settings, arguments)?;
    let warnings = warnings::all(&findings, &source, arguments);
    let mut report = Report::plain(findings.table(&source), (0, 0));
    report.fields(json::fields(&findings, &source, &warnings));
    let mut answer = match &arguments.out {
        Some(folder) => {
            report.figure("spectrum", &figure::figure(&findings, &source.input));
            let output = OutputArguments {
                out: folder.clone(),
                json: arguments.json,
                png: false,
            };
            report.written(Path::new(folder), &output)?
        }
        None => report.output(arguments.json),
    };
    if arguments.csv {
        answer.text = findings.csv()?;
    }
    for warning in &warnings {
        note(&format!("warning: {warning}"));
    }
    Ok(answer)
}

/// Computes all results.
fn find(
    series: &Series,
    settings: DataSettings,
    arguments: &Arguments,
) -> Result<Findings, Failure> {
    let embedding = EmbeddingSettings {
        delay: arguments.delay,
        dimension: arguments.dimension,
        theiler: arguments.theiler,
    };
    let as_they_are = arguments.dimension == Some(1) && arguments.delay != Some(0);
    let choice = counted("embedding", |report| match as_they_are {
        true => Ok(None),
        false => needed_embedding(series, &embedding, report),
    })?;
    let embedding = choice.as_ref().map(|choice| choice.embedding);
    let (vectors, settings) = match embedding {
        Some(embedding) => {
            let vectors = embedding.of(series)?;
            let given = Given {
                neighbours: arguments.neighbours.is_some(),
                step: arguments.step.is_some(),
                stride: arguments.stride.is_some(),
            };
            let delayed = settings.delayed_but(embedding.delay, &vectors, given);
            (Cow::Owned(vectors), delayed)
        }
        None => (Cow::Borrowed(series), settings),
    };
    let vectors = vectors.as_ref();
    let spectrum = counted("spectrum", |report| {
        let span = series.len() - vectors.len();
        let found = data_spectrum_with(vectors, &settings, report);
        found.map_err(|error| error.in_rows(span))
    })?;
    let embedded = match choice {
        Some(choice) => Some(Embedded {
            choice,
            reversal: counted("reversed series", |report| {
                reversal(vectors, &spectrum, report)
            })?,
        }),
        None => None,
    };
    let curves = counted("diverging neighbours", |report| {
        divergence(vectors, settings.theiler, report)
    });
    let surrogates = match arguments.surrogates {
        Some(count) => Some(counted("surrogates", |report| {
            surrogate_test(series, embedding, &settings, count, SURROGATE_SEED, report)
        })?),
        None => None,
    };
    // Some exponents of delayed values may be spurious, so their sum is not compared.
    let balance = arguments
        .divergence
        .filter(|_| embedded.is_none())
        .map(|divergence| (divergence, spectrum.balance(divergence)));
    Ok(Findings {
        spectrum,
        balance,
        embedded,
        // A spectrum needs fewer points than this.
        divergence: match curves {
            Err(DataError::TooFew { .. }) => None,
            other => Some(other?),
        },
        surrogates,
    })
}
