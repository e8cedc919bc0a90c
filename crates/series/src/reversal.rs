//! Classification of the exponents of an embedding: the system's, or spurious.
//!
//! m delayed values of a system whose attractor has fewer dimensions give m exponents. Some of them
//! are the embedding's own, and may have any value: of x alone of Hénon's map the first of three is
//! 0.8, twice the system's. Two criteria distinguish them.
//! * A fit restricted to the tangent directions of the points has no room for spurious exponents
//!   (Stoop and Parisi, Physica D 50, 89, 1991).
//! * With the time reversed, true exponents change their sign; spurious ones have no reason to
//!   (Parlitz, Int. J. Bifurcation Chaos 2, 155, 1992).
//!
//! Extrapolated quadratic maps omit directions in which the points only bend, and with them most
//! spurious exponents; the first exponents are then the system's. A reversed series may be
//! unpredictable, or have exponents of its own. Its map may have no inverse, or expand what is
//! contracted below the distances of the points. It then does not reproduce the first exponent
//! either, and is not used.

use super::error::DataError;
use super::estimate::data_spectrum_with;
use super::progress::Progress;
use super::result::{CHANGE_ERRORS, DataSpectrum, Status};
use super::series::Series;
use super::settings::{DataSettings, Estimator, longest_stride};

/// Two exponents agree if they differ by at most this fraction of the larger one, or of the first
/// exponent. Errors do not contain the bias of finite neighbourhoods. Chosen: a smaller fraction
/// calls a biased exponent spurious, a larger one lets a spurious one pass.
const BIAS: f64 = 0.25;
/// Two exponents also agree if the stretchings per map differ by at most this fraction. All
/// exponents of a regular motion are near 0, and a fit is no better than this. Chosen.
const FIT_ERROR: f64 = 0.01;
/// Reference points of the reversed series, where the step allows fewer than all. They suffice for
/// a comparison to within [`BIAS`].
const REFERENCES: usize = 1000;
/// Exponents are not compared if the residual ratio of a series, in either direction of time, is
/// above this value. It then predicts at most three quarters of the variance. Chosen.
const UNPREDICTABLE: f64 = 0.5;

/// Origin of an exponent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The system's: the fit restricted to the tangent directions has it, or the reversed series
    /// with the other sign.
    System,
    /// The embedding's: neither has it.
    Spurious,
    /// No comparison is possible:
    /// * no tangent direction was found;
    /// * all directions are tangent, and the reversed series does not have the first exponent;
    /// * the maps predict too little; or the exponent has no value.
    Unknown,
}

impl Origin {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Origin::System => "system",
            Origin::Spurious => "spurious",
            Origin::Unknown => "unknown",
        }
    }
}

/// Result of the comparison with the reversed series.
#[derive(Clone, Debug, PartialEq)]
pub struct Reversal {
    /// Origins of the exponents, in the order of the spectrum.
    pub origins: Vec<Origin>,
    /// The exponents of the reversed series by the fit of fixed rank, with their standard errors.
    pub reversed: Vec<(f64, f64)>,
    /// Whether the reversed series has the first exponent with the other sign. If not, it carries
    /// no information on the others.
    pub is_conclusive: bool,
}

/// The status of an exponent in a word: that of the estimator, except that exponents which are the
/// embedding's own are `spurious`. `reversal` is that of an embedded series.
pub fn status_word(
    spectrum: &DataSpectrum,
    reversal: Option<&Reversal>,
    number: usize,
) -> &'static str {
    let status = spectrum.exponents[number].status;
    let origin = reversal.and_then(|reversal| reversal.origins.get(number));
    match (status, origin) {
        (Status::Unidentified | Status::Annihilated, _) => status.word(),
        (_, Some(Origin::Spurious)) => Origin::Spurious.word(),
        _ => status.word(),
    }
}

/// Compares the spectrum of an embedded series with its fit of fixed rank and with the reversed
/// series. `progress(done, total)` is called at intervals with numbers of reference points.
///
/// # Errors
/// Those of [`super::data_spectrum`].
pub fn reversal(
    embedded: &Series,
    spectrum: &DataSpectrum,
    progress: Progress<'_>,
) -> Result<Reversal, DataError> {
    if spectrum.fixed_rank == 0 {
        return Ok(Reversal {
            origins: vec![Origin::Unknown; spectrum.exponents.len()],
            reversed: Vec::new(),
            is_conclusive: false,
        });
    }
    let covered = spectrum.settings.reference(spectrum.references);
    let step = spectrum.settings.step;
    let stride = longest_stride(step, covered.saturating_add(step), REFERENCES);
    let mut settings = DataSettings {
        estimator: Estimator::SanoSawada,
        sensitivity: false,
        stride: stride.max(spectrum.settings.stride),
        ..spectrum.settings.clone()
    };
    settings.references = Some(settings.references_before(covered));
    let backward = data_spectrum_with(&reversed(embedded)?, &settings, progress)?;
    let [forward, reversed] = [spectrum, &backward].map(|spectrum| -> Vec<(f64, f64)> {
        let all = spectrum.exponents.iter();
        all.filter_map(|exponent| exponent.fixed_rank).collect()
    });
    let negated = reversed.iter().map(|&(value, stderr)| (-value, stderr));
    let negated: Vec<(f64, f64)> = negated.collect();
    let of_a_map = FIT_ERROR / (step as f64 * embedded.dt());
    let first = forward.first().map_or(0.0, |first| first.0.abs());
    let scale = if first < of_a_map {
        of_a_map / BIAS
    } else {
        first
    };
    let is_among_negated = |first: &(f64, f64)| {
        let mut negated = negated.iter();
        negated.any(|other| distance(*first, *other, scale).is_some())
    };
    let is_conclusive =
        backward.residual_ratio < UNPREDICTABLE && forward.first().is_some_and(is_among_negated);
    let is_noisy = spectrum.residual_ratio > UNPREDICTABLE;
    let full = spectrum.exponents.iter();
    let full: Vec<(f64, f64)> = full.map(|one| (one.value, one.stderr)).collect();
    let [by_rank, by_reversal] = [&forward, &negated]
        .map(|references| matched(&full, references, scale, spectrum.dimension));
    // A fit of full rank has room for spurious exponents, too, so that an exponent missing from it
    // proves nothing.
    let is_judged = is_conclusive || forward.len() < full.len();
    let origins = full.iter().zip(by_rank.into_iter().zip(by_reversal));
    let origins = origins.map(|(exponent, (by_rank, by_reversal))| {
        if forward.is_empty() || is_noisy || !exponent.0.is_finite() {
            Origin::Unknown
        } else if by_rank || is_conclusive && by_reversal {
            Origin::System
        } else if is_judged {
            Origin::Spurious
        } else {
            Origin::Unknown
        }
    });
    Ok(Reversal {
        origins: origins.collect(),
        reversed,
        is_conclusive,
    })
}

/// The series, last point first.
fn reversed(series: &Series) -> Result<Series, DataError> {
    let rows = series.values().chunks(series.columns()).rev();
    Series::new(
        rows.flatten().copied().collect(),
        series.columns(),
        series.dt(),
    )
}

/// The distance of two values that agree; `None` for others.
fn distance(a: (f64, f64), b: (f64, f64), scale: f64) -> Option<f64> {
    let difference = (a.0 - b.0).abs();
    let errors = CHANGE_ERRORS * (a.1 * a.1 + b.1 * b.1).sqrt();
    let bias = BIAS * scale.max(a.0.abs()).max(b.0.abs());
    // NaN agrees with nothing.
    (difference <= errors.max(bias)).then_some(difference)
}

/// Marks the members of `all` that are among `references`. Each reference matches at most one, the
/// nearest. The first `dimension` exponents, which the data determine, are matched before the
/// others.
fn matched(
    all: &[(f64, f64)],
    references: &[(f64, f64)],
    scale: f64,
    dimension: usize,
) -> Vec<bool> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, a) in all.iter().enumerate() {
        for (k, b) in references.iter().enumerate() {
            pairs.extend(distance(*a, *b, scale).map(|distance| (distance, i, k)));
        }
    }
    pairs.sort_by(|a, b| {
        let late = |pair: &(f64, usize, usize)| pair.1 >= dimension;
        late(a).cmp(&late(b)).then(a.0.total_cmp(&b.0))
    });
    let mut is_matched = vec![false; all.len()];
    let mut is_used = vec![false; references.len()];
    for (_, i, k) in pairs {
        if !is_matched[i] && !is_used[k] {
            (is_matched[i], is_used[k]) = (true, true);
        }
    }
    is_matched
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_known_value_is_one_of_the_others_only() {
        let exact =
            |values: &[f64]| -> Vec<(f64, f64)> { values.iter().map(|&v| (v, 0.0)).collect() };
        let all = exact(&[0.85, 0.42, -1.1, -1.63]);
        assert_eq!(
            matched(&all, &exact(&[0.418, -1.45]), 0.418, 2),
            [false, true, false, true]
        );
        assert_eq!(matched(&all, &exact(&[f64::NAN]), 0.4, 2), [false; 4]);
        // The last is nearer, but the second is one that the data determine.
        let all = exact(&[0.42, -1.63, -1.1, -1.5]);
        assert_eq!(
            matched(&all, &exact(&[0.418, -1.45]), 0.418, 2),
            [true, true, false, false]
        );
    }
}
