//! The table of the spectra, and what it says on each exponent.

use super::{CaptionSpectrum, CaptionVariant};
use crate::figures::block_and_bracket::SETS;
use crate::motion::Class;
use crate::numbers::extent;
use crate::text::csv;
use std::sync::OnceLock;

/// The committed table.
const TABLE: &str = include_str!("../../golden/captions.csv");
/// Columns.
const HEADER: [&str; 20] = [
    "figure",
    "run",
    "xi1",
    "xi2",
    "xi3",
    "xi4",
    "xi5",
    "mu0",
    "xi6",
    "delta",
    "vp",
    "class",
    "lambda1",
    "lambda2",
    "lambda3",
    "lambda4",
    "std_error1",
    "std_error2",
    "std_error3",
    "std_error4",
];

/// Effects of the caption's rounding and of the solver on an exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentBudget {
    /// Least value over the draws (1/t).
    pub least: f64,
    /// Largest value over the draws (1/t).
    pub largest: f64,
    /// Largest change of the printed caption's value by another tolerance or by fixed steps (1/t).
    pub solver: f64,
}

/// The spectra of all figures.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptionTable {
    rows: Vec<CaptionSpectrum>,
}

impl CaptionTable {
    /// The table with these rows.
    pub fn new(rows: Vec<CaptionSpectrum>) -> Self {
        CaptionTable { rows }
    }

    /// All rows.
    pub fn rows(&self) -> &[CaptionSpectrum] {
        &self.rows
    }

    /// The rows of a figure, from 0 for Fig. 10: draws, or the printed caption computed in several
    /// ways.
    fn of(&self, figure: usize, draws: bool) -> impl Iterator<Item = &CaptionSpectrum> {
        let is_draw = |one: &CaptionSpectrum| matches!(one.variant, CaptionVariant::Draw(_));
        let rows = self.rows.iter();
        rows.filter(move |one| one.figure == figure && is_draw(one) == draws)
    }

    /// The budget of an exponent, figure and index from 0; `None` where stick annihilates it in
    /// every spectrum.
    pub fn budget(&self, figure: usize, k: usize) -> Option<ExponentBudget> {
        let printed = self.of(figure, false).next()?.exponents[k];
        let (least, largest) = extent(self.of(figure, true).map(|one| one.exponents[k]));
        let changes = self.of(figure, false);
        let changes = changes.map(|one| (one.exponents[k] - printed).abs());
        let budget = ExponentBudget {
            least,
            largest,
            solver: extent(changes).1,
        };
        largest.is_finite().then_some(budget)
    }

    /// The first exponent of the printed caption that is zero within its uncertainty, from 0. A
    /// bounded flow that tends to no equilibrium has one, whatever the caption, so that its range
    /// over the draws is scatter.
    pub fn zero_by_theorem(&self, figure: usize) -> Option<usize> {
        let printed = self.of(figure, false).next()?;
        (0..4).find(|&k| printed.is_zero(k))
    }

    /// The fastest decay (1/t) that passes for a zero second exponent among the draws that count as
    /// quasi-periodic: slower locking is not seen. `None` without such draws.
    pub fn slowest_unseen(&self, figure: usize) -> Option<f64> {
        let tori = self.of(figure, true);
        let tori = tori.filter(|one| one.class == Class::QuasiPeriodic);
        let decays: Vec<f64> = tori.map(|one| -one.exponents[1]).collect();
        (!decays.is_empty()).then(|| extent(decays).1)
    }

    /// The classes of a figure's draws with their numbers, the most frequent first.
    pub fn classes(&self, figure: usize) -> Vec<(Class, usize)> {
        let mut classes: Vec<(Class, usize)> = Vec::new();
        for one in self.of(figure, true) {
            match classes.iter_mut().find(|(class, _)| *class == one.class) {
                Some((_, count)) => *count += 1,
                None => classes.push((one.class, 1)),
            }
        }
        classes.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        classes
    }

    /// The table as CSV, numbers in full precision.
    pub fn csv(&self) -> String {
        let row = |one: &CaptionSpectrum| {
            let mut row = vec![
                SETS[one.figure].figure.name().to_owned(),
                one.variant.name(),
            ];
            row.extend(one.numbers.map(|value| format!("{value:?}")));
            row.push(one.class.to_string());
            let measured = one.exponents.into_iter().chain(one.std_errors);
            row.extend(measured.map(|value| format!("{value:?}")));
            row
        };
        let header = HEADER.map(str::to_owned).to_vec();
        csv(std::iter::once(header).chain(self.rows.iter().map(row)))
    }

    /// Reads what [`CaptionTable::csv`] writes.
    fn parse(text: &str) -> Result<Self, String> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let records = reader.records().enumerate();
        let rows = records.map(|(line, record)| {
            let record = record.ok();
            let row = record.as_ref().and_then(parsed);
            row.ok_or_else(|| {
                let line = line + 2;
                format!("line {line} of golden/captions.csv is no spectrum; run `make captions`")
            })
        });
        Ok(CaptionTable {
            rows: rows.collect::<Result<_, String>>()?,
        })
    }
}

fn parsed(record: &csv::StringRecord) -> Option<CaptionSpectrum> {
    let number = |k: usize| record.get(k)?.parse::<f64>().ok();
    let four = |from: usize| -> Option<[f64; 4]> {
        Some([
            number(from)?,
            number(from + 1)?,
            number(from + 2)?,
            number(from + 3)?,
        ])
    };
    let mut numbers = [0.0; 9];
    for (k, value) in numbers.iter_mut().enumerate() {
        *value = number(2 + k)?;
    }
    let name = record.get(0)?;
    let run = record.get(1)?;
    Some(CaptionSpectrum {
        figure: SETS.iter().position(|set| set.figure.name() == name)?,
        variant: CaptionVariant::all().find(|variant| variant.name() == run)?,
        numbers,
        class: record.get(11)?.parse().ok()?,
        exponents: four(12)?,
        std_errors: four(16)?,
    })
}

/// The committed table `golden/captions.csv`.
///
/// # Errors
/// A message with the line that is no spectrum.
pub fn committed() -> Result<&'static CaptionTable, String> {
    static COMMITTED: OnceLock<Result<CaptionTable, String>> = OnceLock::new();
    let table = COMMITTED.get_or_init(|| CaptionTable::parse(TABLE));
    table.as_ref().map_err(Clone::clone)
}
