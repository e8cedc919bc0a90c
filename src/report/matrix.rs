//! What the listing does at its printed step with every subset of its defects. That is a statement on the listing alone; what makes the
//! numbers of Fig. 8 is shown in [`super::cause`].

use rayon::prelude::*;

use super::digits::{Agreement, agreement};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defect, Defects, ListingError, Motion, Setup, run};
use crate::paper::published::{Claim, Claims, PublishedError};

/// Subsets of the defects.
pub const SUBSETS: usize = 1 << Defect::ALL.len();

/// What the listing does with some of its defects.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The defects that are present.
    pub present: Vec<Defect>,
    /// Lengths of the two longest stick phases (m), then their durations (s).
    pub numbers: Option<[f64; 4]>,
    /// Class of the settled motion.
    pub motion: Motion,
    /// How far the numbers agree with the published ones.
    pub digits: Option<[Agreement; 4]>,
}

impl Cell {
    /// Whether all four numbers are the published ones to all printed digits.
    pub fn gives_digits(&self) -> bool {
        self.digits
            .is_some_and(|digits| digits.iter().all(|one| one.complete()))
    }

    /// Whether the motion is the published one: stick–slip, two stick phases in two forcing periods.
    pub fn gives_class(&self) -> bool {
        self.motion == Motion::PUBLISHED
    }

    fn has(&self, defect: Defect) -> bool {
        self.present.contains(&defect)
    }

    /// The class of motion in words.
    pub fn class(&self) -> String {
        match self.motion {
            Motion::StickSlip { sticks, period } => {
                let plural = if period == 1 { "" } else { "s" };
                format!("stick–slip, {sticks} stick phases in {period} forcing period{plural}")
            }
            Motion::SlipOnly { period } => format!("slip only, period {period}"),
            Motion::Stalled { t } => format!("hangs: the clock stands at {t:.4} s"),
            Motion::Escaped { t } => format!("escapes at {t:.4} s"),
            Motion::BrokenDown { t } => format!("breaks down at {t:.4} s"),
            _ => "no pattern repeats".into(),
        }
    }
}

/// The listing at its own step with every subset of its defects.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// One cell for each subset; bit `k` of the index says whether `Defect::ALL[k]` is present.
    pub cells: Vec<Cell>,
}

/// A question asked of every cell.
pub type Property = fn(&Cell) -> bool;

impl Matrix {
    /// Runs all subsets at the printed step and calls `tick` after each.
    ///
    /// # Errors
    /// [`MatrixError`] if the setup or the table of claims is not sound.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Matrix, MatrixError> {
        let claims = four_claims()?;
        let cells = (0..SUBSETS)
            .into_par_iter()
            .map(|mask| {
                let cell = cell(mask, &claims);
                tick();
                cell
            })
            .collect::<Result<_, ListingError>>()?;
        Ok(Matrix { cells })
    }

    /// The listing as printed.
    pub fn all(&self) -> &Cell {
        &self.cells[SUBSETS - 1]
    }

    /// The listing with everything mended.
    pub fn none(&self) -> &Cell {
        &self.cells[0]
    }

    /// The listing with this defect alone mended.
    pub fn mended(&self, defect: Defect) -> &Cell {
        let k = Defect::ALL.iter().position(|&one| one == defect);
        &self.cells[SUBSETS - 1 - k.map_or(0, |k| 1 << k)]
    }

    /// The cells a reader wants to see, named: all, none, each alone, each mended alone.
    pub fn named(&self) -> Vec<(String, &Cell)> {
        let mut named = vec![
            ("as printed".to_owned(), self.all()),
            ("all mended".to_owned(), self.none()),
        ];
        let each = || Defect::ALL.iter().enumerate();
        named.extend(each().map(|(k, d)| (format!("only {}", d.name()), &self.cells[1 << k])));
        named.extend(each().map(|(k, d)| {
            let name = format!("mended: {}", d.name());
            (name, &self.cells[SUBSETS - 1 - (1 << k)])
        }));
        named
    }

    /// The subsets that have the property.
    pub fn having(&self, property: Property) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |cell| property(cell))
    }

    /// The defects that are present wherever the property holds; none if it holds nowhere.
    pub fn necessary(&self, property: Property) -> Vec<Defect> {
        let nowhere = self.having(property).next().is_none();
        let everywhere = |defect: &Defect| self.having(property).all(|cell| cell.has(*defect));
        let candidates = Defect::ALL.into_iter().filter(|_| !nowhere);
        candidates.filter(everywhere).collect()
    }

    /// The subsets with the property no proper subset of which has it, the smallest first.
    pub fn minimal(&self, property: Property) -> Vec<&Cell> {
        let inside =
            |small: &Cell, large: &Cell| small.present.iter().all(|&defect| large.has(defect));
        let mut minimal: Vec<&Cell> = self
            .having(property)
            .filter(|cell| {
                let mut others = self.having(property);
                !others.any(|other| other != *cell && inside(other, cell))
            })
            .collect();
        minimal.sort_by_key(|cell| cell.present.len());
        minimal
    }

    /// The defects that may be present or absent in any subset with the property without taking it away.
    pub fn irrelevant(&self, property: Property) -> Vec<Defect> {
        let has = |mask: usize| property(&self.cells[mask]);
        let idle = |&k: &usize| {
            (0..SUBSETS)
                .filter(|&mask| has(mask))
                .all(|mask| has(mask ^ (1 << k)))
        };
        (0..Defect::ALL.len())
            .filter(idle)
            .map(|k| Defect::ALL[k])
            .collect()
    }

    /// Which defects the listing needs, and which suffice in it, for the published digits and for the published class.
    pub fn sentence(&self) -> String {
        format!(
            "Of all {SUBSETS} subsets of the defects, run in the listing at its printed step, {}; {}.",
            self.about(
                "the four published numbers to all printed digits",
                Cell::gives_digits
            ),
            self.about("the published kind of motion", Cell::gives_class),
        )
    }

    fn about(&self, what: &str, property: Property) -> String {
        let count = self.having(property).count();
        if count == 0 {
            return format!("none gives {what}");
        }
        let minimal = self.minimal(property);
        let necessary = self.necessary(property);
        let conditions = match &minimal[..] {
            [only] if only.present == necessary => {
                let with: Vec<&Cell> = self
                    .cells
                    .iter()
                    .filter(|cell| necessary.iter().all(|&one| cell.has(one)))
                    .collect();
                let lost = with.iter().filter(|cell| !property(cell)).count();
                let others = match lost {
                    0 => "sufficient whatever else is present".to_owned(),
                    _ => format!(
                        "sufficient by themselves (with others added, {lost} of the {} subsets that contain them lose it)",
                        with.len()
                    ),
                };
                format!("{} are necessary and together {others}", list(&necessary))
            }
            several => {
                let sets: Vec<String> = several
                    .iter()
                    .map(|cell| format!("{{{}}}", list(&cell.present)))
                    .collect();
                let needed = match &necessary[..] {
                    [] => "no defect is necessary".to_owned(),
                    all => format!("{} necessary", list(all)),
                };
                format!(
                    "{needed}, and one of the least sets {} sufficient",
                    sets.join(" or ")
                )
            }
        };
        let idle = match &self.irrelevant(property)[..] {
            [] => String::new(),
            all => format!(", {} without influence", list(all)),
        };
        format!("{count} give {what}: {conditions}{idle}")
    }
}

/// Names, separated by commas.
pub fn list(defects: &[Defect]) -> String {
    let names: Vec<&str> = defects.iter().map(|defect| defect.name()).collect();
    names.join(", ")
}

/// The claims the four numbers are compared with.
///
/// # Errors
/// [`PublishedError`] if the table lacks one.
pub fn four_claims() -> Result<[Claim; 4], PublishedError> {
    let claims = Claims::committed()?;
    Ok(ClaimId::FOUR.map(|id| claims.of(id).clone()))
}

/// How far four numbers agree with the published ones.
pub fn four_digits(claims: &[Claim; 4], numbers: &[f64; 4]) -> [Agreement; 4] {
    let nothing = Agreement {
        agreeing: 0,
        printed: 1,
    };
    std::array::from_fn(|i| agreement(&claims[i], numbers[i]).unwrap_or(nothing))
}

fn cell(mask: usize, claims: &[Claim; 4]) -> Result<Cell, ListingError> {
    let present: Vec<Defect> = Defect::ALL
        .into_iter()
        .enumerate()
        .filter(|(k, _)| mask >> k & 1 == 1)
        .map(|(_, defect)| defect)
        .collect();
    let defects = present
        .iter()
        .fold(Defects::MENDED, |defects, &one| defects.flipped(one));
    let outcome = run(&Setup {
        defects,
        ..Setup::default()
    })?;
    let numbers = outcome.four_numbers();
    Ok(Cell {
        present,
        numbers,
        motion: outcome.motion,
        digits: numbers.map(|numbers| four_digits(claims, &numbers)),
    })
}

/// Why the matrix cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum MatrixError {
    /// The listing cannot run.
    #[error(transparent)]
    Listing(#[from] ListingError),
    /// The table of claims lacks a number.
    #[error(transparent)]
    Published(#[from] PublishedError),
}
