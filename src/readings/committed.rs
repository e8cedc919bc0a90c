//! The committed search, `golden/readings.csv`: what the report says of it, and which file that is.

use sha2::{Digest, Sha256};

use super::chance::Level;
use super::counts::{DigitsMet, Pairs, Published};
use super::error::ReadingsError;
use super::plan::{Part, Plan};
use super::row::Row;
use super::score;
use super::spread::ExponentSpread;
use super::store;

/// The committed table of all readings.
const TABLE: &str = include_str!("../../golden/readings.csv");
/// Its place in the project.
const FILE: &str = "golden/readings.csv";

/// What the committed search has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Committed {
    /// The file.
    pub file: &'static str,
    /// SHA-256 of its content, in hexadecimal digits.
    pub sha256: String,
    /// Configurations tried: readings × integrators × settings of the estimator.
    pub configurations: usize,
    /// Pairs of reading and integrator, by class.
    pub pairs: Pairs,
    /// How often the published exponents are met to the printed digits.
    pub digits: DigitsMet,
    /// How random targets are met, classes aside.
    pub exponents_only: Level,
    /// How random targets are met by the configurations with most of the published kinds of motion.
    pub kinds_first: Level,
    /// What the settings that the paper does not state make of each exponent of each figure, for the recommended reading.
    pub spread: [[ExponentSpread; 4]; 3],
}

impl Committed {
    /// Reads the table.
    ///
    /// # Errors
    /// [`ReadingsError::Incomplete`] if a configuration of the full search is missing or was made with other settings;
    /// [`ReadingsError::Published`], [`ReadingsError::Class`].
    pub fn read() -> Result<Committed, ReadingsError> {
        Committed::of(TABLE)
    }

    fn of(table: &str) -> Result<Committed, ReadingsError> {
        let (plan, target, published) = (Plan::full(), score::target()?, Published::read()?);
        let rows: Vec<Row> = table.lines().filter_map(Row::parse).collect();
        let wanted: Vec<[String; 4]> = plan
            .groups
            .iter()
            .flat_map(|group| store::keys(&plan, group))
            .collect();
        let same = rows.iter().map(|row| &row.key).eq(&wanted);
        if !(same && table.starts_with(&plan.heading(&target))) {
            return Err(ReadingsError::Incomplete {
                file: FILE,
                found: rows.len(),
                wanted: wanted.len(),
            });
        }
        let of = |part: Part| -> Vec<&Row> {
            let is = |row: &&Row| row.key[0] == part.name();
            rows.iter().filter(is).collect()
        };
        let (search, spread) = (of(Part::Search), of(Part::Spread));
        let digest = Sha256::digest(table.as_bytes());
        Ok(Committed {
            file: FILE,
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            configurations: search.len(),
            pairs: Pairs::count(&search, &published),
            digits: DigitsMet::count(&search, &published),
            exponents_only: Level::exponents_only(&search, &target, plan.draws),
            kinds_first: Level::kinds_first(&search, &target, plan.draws),
            spread: [0, 1, 2]
                .map(|figure| [0, 1, 2, 3].map(|k| ExponentSpread::of(&spread, figure, k))),
        })
    }

    /// The file with the beginning of its hash, as it stands beside a number taken from it.
    pub fn cited(&self) -> String {
        format!("{}, SHA-256 {}…", self.file, &self.sha256[..16])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::search;
    use crate::readings::spread::spread_settings;

    /// Of the settings of the spread one in so many is computed anew, from the first on.
    const EVERY: usize = 15;

    #[test]
    fn the_estimates_of_the_spread_are_what_the_program_computes_now() {
        let kept: Vec<_> = spread_settings().into_iter().step_by(EVERY).collect();
        assert_eq!(kept.len(), 2);
        let plan = Plan::full().with_spread_alone(kept);
        let target = score::target().unwrap();
        let recommended = plan
            .groups
            .iter()
            .find(|group| !store::keys(&plan, group).is_empty());
        let rows = search::group_rows(recommended.unwrap(), &plan, &target);
        let lines: Vec<&str> = TABLE
            .lines()
            .filter(|line| line.starts_with("spread,"))
            .collect();
        let wanted: Vec<&str> = lines.into_iter().step_by(EVERY).collect();
        let found: Vec<String> = rows
            .iter()
            .map(|row| row.line().trim_end().to_owned())
            .collect();
        assert_eq!(found, wanted);
    }

    #[test]
    fn a_table_that_is_not_the_full_search_is_refused() {
        assert!(Committed::read().is_ok());
        let last = TABLE.trim_end().rfind('\n').unwrap();
        for other in [
            TABLE[..last].to_owned(),
            TABLE.replacen(
                "points of the series = 45001",
                "points of the series = 45000",
                1,
            ),
            TABLE.replacen(",quasi-periodic,", ",quasi,", 1),
        ] {
            let refused = Committed::of(&other);
            assert!(matches!(refused, Err(ReadingsError::Incomplete { .. })));
        }
    }

    #[test]
    fn another_number_in_the_table_is_another_hash_and_another_spread() {
        let committed = Committed::read().unwrap();
        let least = committed.spread[0][1].values.unwrap().least;
        let other = Committed::of(&TABLE.replacen(&format!(",{least},"), ",-99,", 1)).unwrap();
        assert_ne!(other.sha256, committed.sha256);
        assert_eq!(other.spread[0][1].values.unwrap().least, -99.0);
    }
}
