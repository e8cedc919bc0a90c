//! What is counted of a search: pairs of reading and integrator by class and by kind, exponents met to the printed digits.

use super::error::ReadingsError;
use super::row::Row;
use crate::paper::claim_id::SpectrumFigure;
use crate::paper::published::{Claim, Claims};
use stickslip::analysis::motion::Class;

/// What is published of Figs. 10–12.
#[derive(Clone, Debug)]
pub struct Published {
    /// The captioned classes.
    pub classes: [Class; 3],
    /// The exponents, the largest first.
    pub exponents: [[Claim; 4]; 3],
}

impl Published {
    /// From the table of claims.
    ///
    /// # Errors
    /// [`ReadingsError::Published`] if one is missing, [`ReadingsError::Class`] for a word that is no class.
    pub fn read() -> Result<Published, ReadingsError> {
        let claims = Claims::committed()?;
        let [first, second, third] =
            SpectrumFigure::ALL.map(|figure| claims.of(figure.class()).published.parse::<Class>());
        Ok(Published {
            classes: [first?, second?, third?],
            exponents: SpectrumFigure::ALL
                .map(|figure| figure.exponents().map(|id| claims.of(id).clone())),
        })
    }
}

/// Pairs of reading and integrator. Each has one class for each figure, whatever the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// All.
    pub all: usize,
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
    /// Of the rows of a search, in their order.
    pub(super) fn count(search: &[&Row], published: &Published) -> Pairs {
        let mut pairs: Vec<(&[String], [bool; 3], [bool; 3])> = search
            .iter()
            .map(|row| {
                let class = |f: usize| row.classes[f].is(published.classes[f]);
                let kind = |f: usize| row.classes[f].is_of_kind(f);
                (&row.key[1..3], [0, 1, 2].map(class), [0, 1, 2].map(kind))
            })
            .collect();
        pairs.dedup();
        let mut count = Pairs {
            all: pairs.len(),
            ..Pairs::default()
        };
        for (_, class, kind) in pairs {
            for f in 0..3 {
                count.class[f] += usize::from(class[f]);
                count.kind[f] += usize::from(kind[f]);
            }
            count.classes += usize::from(class == [true; 3]);
            count.kinds += usize::from(kind == [true; 3]);
        }
        count
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
    /// Of the rows of a search.
    pub(super) fn count(search: &[&Row], published: &Published) -> DigitsMet {
        let mut met = DigitsMet::default();
        for row in search {
            let mut of_row = 0;
            for figure in 0..3 {
                for k in 0..4 {
                    let agrees = agrees(row, published, figure, k);
                    met.by[figure][k] += usize::from(agrees);
                    of_row += usize::from(agrees);
                }
            }
            met.most = met.most.max(of_row);
        }
        met
    }

    /// How many of the twelve exponents no configuration meets.
    pub fn by_none(&self) -> usize {
        self.by.as_flattened().iter().filter(|&&n| n == 0).count()
    }

    /// How many exponents there are.
    pub fn all(&self) -> usize {
        self.by.as_flattened().len()
    }
}

/// Of the twelve exponents of a row those that have all printed digits.
pub(super) fn digits_of(row: &Row, published: &Published) -> usize {
    DigitsMet::count(&[row], published).most
}

fn agrees(row: &Row, published: &Published, figure: usize, k: usize) -> bool {
    published.exponents[figure][k].agrees(row.exponents[figure][k])
}
