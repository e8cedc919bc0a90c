//! What is counted of a search: pairs of reading and integrator by class and by kind, exponents met to the printed digits.

use std::collections::BTreeSet;

use super::chance::ZERO;
use super::row::Row;
use super::score::Twelve;
use crate::paper::claim_id::SpectrumFigure;
use crate::paper::published::{Claim, Claims, PublishedError};

/// The published exponents of Figs. 10–12, the largest first.
pub type Exponents = [[Claim; 4]; 3];

/// From the table of claims.
///
/// # Errors
/// [`PublishedError`] if one is missing.
pub fn exponents() -> Result<Exponents, PublishedError> {
    let claims = Claims::committed()?;
    Ok(SpectrumFigure::ALL.map(|figure| figure.exponents().map(|id| claims.of(id).clone())))
}

/// One row for each pair of reading and integrator: its motions do not depend on the estimator.
pub fn pairs<'a>(search: &[&'a Row]) -> Vec<&'a Row> {
    let mut pairs = search.to_vec();
    pairs.dedup_by(|one, other| one.key[1..3] == other.key[1..3]);
    pairs
}

/// From how many readings, integrators and settings rows come.
pub fn sources(rows: &[&Row]) -> [usize; 3] {
    [1, 2, 3].map(|part| {
        let names: BTreeSet<&str> = rows.iter().map(|row| &*row.key[part]).collect();
        names.len()
    })
}

/// In words.
pub fn sources_in_words([readings, integrators, settings]: [usize; 3]) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    format!(
        "{readings} reading{}, {integrators} integrator{}, {settings} setting{} of the estimator",
        plural(readings),
        plural(integrators),
        plural(settings)
    )
}

/// Of the settings tried for the recommended reading, how many bear out what Sect. 5.2 says of
/// exponents. One of a size up to [`ZERO`] passes for zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BorneOut {
    /// Each figure has an exponent that is zero.
    pub zero: usize,
    /// The first two of Fig. 11 are.
    pub two_zeros: usize,
    /// The first of Fig. 12 is positive.
    pub positive: usize,
}

impl BorneOut {
    pub(super) fn count(rows: &[&Row]) -> BorneOut {
        let with =
            |is: &dyn Fn(&Twelve) -> bool| rows.iter().filter(|row| is(&row.exponents)).count();
        let zero = |value: &f64| value.abs() <= ZERO;
        BorneOut {
            zero: with(&|all| all.iter().all(|four| four.iter().any(zero))),
            two_zeros: with(&|all| all[1][..2].iter().all(zero)),
            positive: with(&|all| all[2][0] > ZERO),
        }
    }
}

/// Pairs of reading and integrator. Each has one class for each figure, whatever the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// All.
    pub all: usize,
    /// Those whose three motions stay bounded and can be followed.
    pub kept: usize,
    /// Those with the captioned class of each figure; for Fig. 10 that is two-periodic.
    pub class: [usize; 3],
    /// Those with all three captioned classes.
    pub classes: usize,
    /// Those with the captioned kind of motion of each figure: for Fig. 10 periodic with any number of loops.
    pub kind: [usize; 3],
    /// Those with all three captioned kinds.
    pub kinds: usize,
}

impl Pairs {
    /// Of one row for each pair.
    pub(super) fn count(pairs: &[&Row]) -> Pairs {
        let with = |has: &dyn Fn(&Row) -> bool| pairs.iter().filter(|row| has(row)).count();
        Pairs {
            all: pairs.len(),
            kept: with(&Row::keeps_all),
            class: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_published(f))),
            classes: with(&|row| row.classes_right() == 3),
            kind: [0, 1, 2].map(|f| with(&|row| row.classes[f].is_of_kind(f))),
            kinds: with(&|row| row.kinds_right() == 3),
        }
    }
}

/// How often each published exponent is met to all printed digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigitsMet {
    /// By how many configurations each exponent of each figure is.
    pub by: [[usize; 4]; 3],
    /// The most exponents of the twelve that one configuration meets.
    pub most: usize,
}

impl DigitsMet {
    /// Of some rows.
    pub(super) fn count(rows: &[&Row], published: &Exponents) -> DigitsMet {
        let mut met = DigitsMet::default();
        for row in rows {
            let mut of_row = 0;
            let values = row.exponents.as_flattened();
            let claims = published.as_flattened().iter().zip(values);
            for (by, (claim, value)) in met.by.as_flattened_mut().iter_mut().zip(claims) {
                let agrees = usize::from(claim.agrees(*value));
                *by += agrees;
                of_row += agrees;
            }
            met.most = met.most.max(of_row);
        }
        met
    }
}
