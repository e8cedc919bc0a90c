//! Whether the columns of a file are embedded, how, and what is said of it.

use std::fmt::Write;

use serde_json::{Value, json};

use super::Arguments;
use super::error::SpectrumError;
use super::read::Table;
use stickslip::analysis::data_spectrum::{
    DataSettings, DataSpectrum, DimensionReason, EmbeddingChoice, EmbeddingSettings, Origin,
    Reversal, Series, needed_embedding,
};

/// An embedding and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Embedded {
    /// Delay and dimension, with the evidence.
    pub choice: EmbeddingChoice,
    /// Which exponents are the system's.
    pub reversal: Reversal,
}

/// The embedding that the options ask for or the data need; `None` if the columns are the state as they are.
///
/// # Errors
/// Those of [`needed_embedding`].
pub(super) fn choose(
    series: &Series,
    arguments: &Arguments,
    progress: &dyn Fn(usize, usize),
) -> Result<Option<EmbeddingChoice>, SpectrumError> {
    if arguments.dimension == Some(1) && arguments.delay != Some(0) {
        return Ok(None);
    }
    let settings = EmbeddingSettings {
        delay: arguments.delay,
        dimension: arguments.dimension,
        theiler: arguments.theiler,
    };
    Ok(needed_embedding(series, &settings, progress)?)
}

/// What delayed values need beyond states, but for what the options ask for.
pub(super) fn settings(
    settings: DataSettings,
    choice: &EmbeddingChoice,
    embedded: &Series,
    arguments: &Arguments,
) -> DataSettings {
    let asked = settings.neighbours;
    let mut settings = settings.delayed(choice.embedding.delay, embedded);
    if arguments.neighbours.is_some() {
        settings.neighbours = asked;
    }
    if let Some(step) = arguments.step {
        (settings.step, settings.stride) = (step, 1);
    }
    if let Some(stride) = arguments.stride {
        settings.stride = stride;
    }
    settings
}

impl Embedded {
    /// Whether exponent `i` is the embedding's and not the system's.
    pub fn is_spurious(&self, i: usize) -> bool {
        self.reversal.origins.get(i) == Some(&Origin::Spurious)
    }

    /// What was embedded and why so, for the terminal.
    pub(super) fn text(&self, source: &Table) -> String {
        let choice = &self.choice;
        // A number alone would read as a value.
        let columns: Vec<String> = source
            .names
            .iter()
            .map(|name| match name.parse::<usize>() {
                Ok(_) => format!("column {name}"),
                Err(_) => name.clone(),
            })
            .collect();
        let mut text = format!(
            "embedded: {} values of {} with a delay of {} points ({}); dimension: {}",
            choice.embedding.dimension,
            columns.join(" and of "),
            choice.embedding.delay,
            choice.delay_reason.words(),
            choice.dimension_reason.words(),
        );
        // Writing to a string cannot fail.
        let _ = match choice.cao {
            Some(dimension) => writeln!(text, "; by Cao's method {dimension}"),
            None => writeln!(
                text,
                "; by Cao's method none up to {}",
                choice.dimensions.len()
            ),
        };
        text
    }

    /// Whose the exponents are, for the terminal.
    pub(super) fn origins(&self, spectrum: &DataSpectrum) -> String {
        let of = |origin: Origin| -> Option<String> {
            let all = (1..).zip(&self.reversal.origins);
            let found: Vec<String> = all
                .filter(|(_, one)| **one == origin)
                .map(|(i, _): (usize, _)| i.to_string())
                .collect();
            (!found.is_empty()).then(|| found.join(", "))
        };
        let by = if self.reversal.is_conclusive {
            format!(
                "by the fit of rank {} and by time reversal",
                spectrum.fixed_rank
            )
        } else {
            format!(
                "by the fit of rank {}; the reversed series does not have the first exponent again and tells nothing",
                spectrum.fixed_rank
            )
        };
        match (of(Origin::System), of(Origin::Spurious)) {
            (None, None) => {
                "Which exponents are the system's and which the embedding's cannot be told.\n"
                    .into()
            }
            (system, spurious) => format!(
                "The system's exponents: {}; the embedding's own: {}{} ({by}).\n",
                system.as_deref().unwrap_or("none"),
                spurious.as_deref().unwrap_or("none"),
                of(Origin::Unknown).map_or(String::new(), |which| format!("; not told: {which}"))
            ),
        }
    }

    /// What makes the embedding doubtful.
    pub(super) fn warnings(&self) -> Vec<String> {
        let choice = &self.choice;
        let mut warnings = Vec::new();
        if choice.dimension_reason == DimensionReason::FewestFalse {
            warnings.push(format!(
                "at least 1 % of the nearest neighbours are false with any number of delayed values up to {}: noise, or more dimensions than \
                 that: give a filtered series, more columns, or --dimension",
                choice.dimensions.len()
            ));
        }
        if self.is_spurious(0) {
            warnings.push(format!(
                "exponent 1 is the embedding's own and none of the system's: try --dimension {}",
                choice.embedding.dimension.saturating_sub(1)
            ));
        }
        warnings
    }

    /// For `--json`.
    pub(super) fn json(&self) -> Value {
        let choice = &self.choice;
        let dimensions: Vec<Value> = choice
            .dimensions
            .iter()
            .map(|one| {
                json!({
                    "dimension": one.dimension,
                    "false_neighbours": one.false_neighbours,
                    "cao_e1": one.e1,
                    "cao_e2": one.e2,
                })
            })
            .collect();
        json!({
            "delay": choice.embedding.delay,
            "delay_reason": choice.delay_reason.words(),
            "dimension": choice.embedding.dimension,
            "dimension_reason": choice.dimension_reason.words(),
            "cao_dimension": choice.cao,
            "mutual_information": choice.information,
            "dimensions": dimensions,
            "reversal_is_conclusive": self.reversal.is_conclusive,
            "origins": self.reversal.origins.iter().map(|origin| origin.word()).collect::<Vec<_>>(),
        })
    }
}
