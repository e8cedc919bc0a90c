//! Uncertainties of the exponents of Figs. 10, 11 and 12, a column of bars for each source.

use super::compute::Data;
use crate::captions::{self, CaptionTable};
use crate::readings::{self, ExponentSpread};
use crate::terminal::ProgramError;
use crate::text::described;
use stickslip::analysis::Exponent;

described! {
    /// Sources of uncertainty of an exponent.
    Source: &'static str as pub(super) name {
        /// One standard error of the mean over the run.
        Statistical = "standard error",
        /// Captions within the rounding of their last decimal: the range over the draws.
        Captions = "captions",
        /// Another tolerance, or the paper's fixed steps: the largest change.
        Solver = "step and tolerance",
        /// Settings of the estimator that the paper does not state: the range over those that
        /// identify the exponent.
        Settings = "settings",
    }
}

/// Range of an exponent by one source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorBar {
    pub(super) source: Source,
    /// Index of the exponent, from 0.
    pub(super) index: usize,
    /// Smallest value (1/t), −∞ where a draw has an annihilated direction.
    pub(super) least: f64,
    /// Largest value (1/t).
    pub(super) largest: f64,
}

/// The bars of a figure, from the committed tables of captions and readings.
pub(super) fn error_bars(data: &Data) -> Result<Vec<ErrorBar>, ProgramError> {
    let figure = data.set.figure as usize;
    let settings = readings::committed_spread()?;
    let exponents = &data.exact.spectrum.exponents;
    Ok(bars(
        exponents,
        captions::committed()?,
        figure,
        &settings[figure],
    ))
}

/// No source bounds an exponent of −∞ except the settings, which give it finite values.
fn bars(
    exponents: &[Exponent],
    captions: &CaptionTable,
    figure: usize,
    settings: &[ExponentSpread; 4],
) -> Vec<ErrorBar> {
    let range = |source, index: usize| -> Option<(f64, f64)> {
        let exponent = exponents.get(index)?;
        let within = |error: f64| (exponent.value() - error, exponent.value() + error);
        let std_error = exponent.std_error();
        let budget = std_error.and_then(|_| captions.budget(figure, index));
        match source {
            Source::Statistical => std_error.map(within),
            Source::Captions => budget.map(|one| (one.least, one.largest)),
            Source::Solver => budget.map(|one| within(one.solver)),
            Source::Settings => settings[index].values.map(|one| (one.least, one.largest)),
        }
    };
    let places = Source::ALL
        .into_iter()
        .flat_map(|source| (0..4).map(move |index| (source, index)));
    let bar = |(source, index)| {
        let (least, largest) = range(source, index)?;
        Some(ErrorBar {
            source,
            index,
            least,
            largest,
        })
    };
    places.filter_map(bar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::block_and_bracket::SETS;

    /// Columns of `report/claims.csv`, written by other code from the same computations.
    const COLUMNS: [(Source, [&str; 2]); 2] = [
        (
            Source::Captions,
            ["least_over_captions", "largest_over_captions"],
        ),
        (
            Source::Settings,
            ["least_over_unstated", "largest_over_unstated"],
        ),
    ];

    #[test]
    fn bars_span_the_ranges_of_the_table_of_claims() {
        let mut reader = csv::Reader::from_path(
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("report/claims.csv"),
        )
        .unwrap();
        let header = reader.headers().unwrap().clone();
        let column = |name: &str| header.iter().position(|one| one == name).unwrap();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let (captions, settings) = (
            captions::committed().unwrap(),
            readings::committed_spread().unwrap(),
        );
        let mut compared = 0;
        for (figure, set) in SETS.iter().enumerate() {
            let row = |index: usize| {
                let id = set.figure.exponents()[index].to_string();
                rows.iter().find(|row| row[0] == *id).unwrap()
            };
            let number = |index: usize, name: &str| row(index)[column(name)].parse::<f64>();
            let finite = |index: usize| Exponent::Finite {
                value: -0.5,
                std_error: number(index, "statistical_error").unwrap_or(f64::NAN),
            };
            let exponents = [0, 1, 2, 3].map(|index| {
                let annihilated = row(index)[column("corrected/equations")].contains("inf");
                if annihilated {
                    Exponent::Annihilated
                } else {
                    finite(index)
                }
            });
            let drawn = bars(&exponents, captions, figure, &settings[figure]);
            let of = |source, index| {
                drawn
                    .iter()
                    .find(|one| (one.source, one.index) == (source, index))
            };
            for index in 0..4 {
                for (source, names) in COLUMNS {
                    let ends = names.map(|name| number(index, name).ok());
                    let shown = of(source, index);
                    assert_eq!(shown.map(|one| one.least), ends[0], "{source:?} {index}");
                    assert_eq!(shown.map(|one| one.largest), ends[1], "{source:?} {index}");
                    compared += usize::from(shown.is_some());
                }
                let half = |source| of(source, index).map(|one| (one.largest - one.least) / 2.0);
                for (source, name) in [
                    (Source::Statistical, "statistical_error"),
                    (Source::Solver, "solver_change"),
                ] {
                    let wanted = number(index, name).ok();
                    let close = |(one, other): (f64, f64)| (one - other).abs() < 1e-15;
                    assert_eq!(
                        half(source).is_some(),
                        wanted.is_some(),
                        "{source:?} {index}"
                    );
                    assert!(
                        half(source).zip(wanted).is_none_or(close),
                        "{source:?} {index}"
                    );
                }
            }
        }
        assert!(compared > 12, "{compared}");
    }
}
