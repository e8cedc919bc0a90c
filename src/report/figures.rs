//! The figures' tables, and which claim each row speaks of.

use rayon::prelude::*;

use super::digits::agreement;
use super::entry::ReadingValue;
use crate::figures::block_and_bracket;
use crate::figures::fig08::Data as Fig08Data;
use crate::figures::rows::{Row, Value};
use crate::figures::{
    FigureError, FigureSpec, fig04::Fig04, fig06::Fig06, fig07::Fig07, fig08::Fig08, fig10::Fig10,
    fig11::Fig11, fig12::Fig12,
};
use crate::paper::published::{Claim, Kind};

/// One figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the figure.
    pub figure: &'static str,
    /// One line on what it shows.
    pub title: &'static str,
    /// What is drawn and which numbers are reported.
    pub about: &'static str,
    /// The picture.
    pub svg: String,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// Sign of a Lyapunov exponent, zero within its error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Nearby orbits separate.
    Positive,
    /// Neither.
    Zero,
    /// They approach each other.
    Negative,
}

/// What the ledger needs of the figures.
pub struct Computed {
    /// All tables.
    pub tables: Vec<Table>,
    /// Fig. 8 in full.
    pub fig08: Fig08Data,
    /// Signs of the exponents of Figs. 10, 11, 12 from the equations, the largest first.
    pub signs: [[Sign; 4]; 3],
}

/// Figures computed.
pub const FIGURES: usize = 7;

fn table<F: FigureSpec>(tick: &(dyn Fn() + Sync)) -> Result<(F::Data, Table), FigureError> {
    let data = F::compute()?;
    let table = Table {
        figure: F::NAME,
        title: F::TITLE,
        about: F::ABOUT,
        svg: F::draw(&data)?,
        rows: F::numbers(&data),
    };
    tick();
    Ok((data, table))
}

/// Computes all figures and calls `tick` after each.
///
/// # Errors
/// [`FigureError`] of the first that fails.
pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Computed, FigureError> {
    let bracket = [
        table_of_bracket::<Fig10>,
        table_of_bracket::<Fig11>,
        table_of_bracket::<Fig12>,
    ];
    let ((fig04, fig06), (fig07, fig08)) = rayon::join(
        || (table::<Fig04>(tick), table::<Fig06>(tick)),
        || (table::<Fig07>(tick), table::<Fig08>(tick)),
    );
    let (fig08, eighth) = fig08?;
    let bracket = bracket
        .par_iter()
        .map(|one| one(tick))
        .collect::<Result<Vec<_>, FigureError>>()?;
    let mut tables = vec![fig04?.1, fig06?.1, fig07?.1, eighth];
    let mut signs = [[Sign::Zero; 4]; 3];
    for (slot, (table, found)) in signs.iter_mut().zip(bracket) {
        tables.push(table);
        *slot = found;
    }
    Ok(Computed {
        tables,
        fig08,
        signs,
    })
}

fn table_of_bracket<F: FigureSpec<Data = block_and_bracket::Data>>(
    tick: &(dyn Fn() + Sync),
) -> Result<(Table, [Sign; 4]), FigureError> {
    let (data, table) = table::<F>(tick)?;
    let evidence = &data.exact.evidence;
    // In descending order: what grows, what stays, what shrinks.
    let grow = usize::from(evidence.positive);
    let signs = std::array::from_fn(|i| match i {
        _ if i < grow => Sign::Positive,
        _ if i < grow + evidence.zeros => Sign::Zero,
        _ => Sign::Negative,
    });
    Ok((table, signs))
}

/// The signs that a flow's exponents have in a published class of motion.
pub fn signs_of_class(class: &str) -> Option<[Sign; 4]> {
    use Sign::{Negative, Positive, Zero};
    match kind_of_motion(class) {
        "periodic" => Some([Zero, Negative, Negative, Negative]),
        "quasi-periodic" => Some([Zero, Zero, Negative, Negative]),
        "chaotic" => Some([Positive, Zero, Negative, Negative]),
        _ => None,
    }
}

/// A class without its number of loops: `two-periodic` is a kind of `periodic`.
pub fn kind_of_motion(class: &str) -> &str {
    match class {
        "quasi-periodic" => class,
        _ if class.ends_with("periodic") => "periodic",
        _ => class,
    }
}

/// Rows that speak of a claim under another name, by the beginning of it and its end.
const ALIASES: [(&str, &str, &str); 3] = [
    ("fig04.tangent_point.", ".kind", "fig04.visibility"),
    ("fig04.tangent_point.", "", "eq16.tangent_points"),
    ("fig07c.points_", "", "fig07c.branches"),
];

/// The claim that a row speaks of: the one of its name, the one whose member it is, or by an alias.
pub fn claim_of<'a>(row: &str, claims: &'a [Claim]) -> Option<&'a Claim> {
    let by_name = |claim: &&Claim| {
        let rest = row.strip_prefix(claim.id.as_str());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let alias = || {
        let known = ALIASES
            .iter()
            .find(|(begin, end, _)| row.starts_with(begin) && row.ends_with(end))?;
        claims.iter().find(|claim| claim.id == known.2)
    };
    claims.iter().find(by_name).or_else(alias)
}

/// What the tables' compared rows give for a claim, one value for each reading of each figure.
pub fn readings_of(claim: &Claim, claims: &[Claim], tables: &[Table]) -> Vec<ReadingValue> {
    let mut readings: Vec<ReadingValue> = Vec::new();
    for table in tables {
        let first = readings.len();
        for row in &table.rows {
            let Some(agrees) = row.agrees else { continue };
            if claim_of(&row.id, claims).is_none_or(|of| of.id != claim.id) {
                continue;
            }
            let digits = match &row.value {
                Value::Number(value) => agreement(claim, *value),
                // How many members a set has is no member.
                _ if claim.kind == Kind::Set => continue,
                _ => None,
            };
            let by_alias = !row.id.starts_with(claim.id.as_str());
            let detail = by_alias && claim.kind != Kind::Set;
            let known = readings[first..]
                .iter_mut()
                .find(|one| one.reading == row.reading);
            match known {
                Some(known) => {
                    if !detail {
                        known.values.push(row.value.clone());
                    }
                    known.agrees &= agrees;
                    known.digits = match (known.digits, digits) {
                        (Some(one), Some(other)) => Some(one.and(other)),
                        (one, other) => one.or(other),
                    };
                }
                None => readings.push(ReadingValue {
                    reading: row.reading.clone(),
                    source: table.figure,
                    values: if detail {
                        Vec::new()
                    } else {
                        vec![row.value.clone()]
                    },
                    digits,
                    agrees,
                    note: row.status.clone(),
                }),
            }
        }
    }
    readings
}
