//! The committed search, `golden/readings.csv`: its results for the report, and the hash of the
//! file.

use sha2::{Digest, Sha256};

use super::plan::{self, Plan};
use super::scoring::{
    ConfirmedStatements, ExponentSpread, PairCounts, RowsByRole, count_matching, for_each_exponent,
    sources,
};
use super::search;
use super::settings::{Setting, settings_name};
use super::significance::{MatchLevel, Share, digits_share, single_figure_levels};
use super::table::ConfigurationRow;

/// The committed table of all readings.
const TABLE: &str = include_str!("../../golden/readings.csv");
/// Path in the project.
const FILE: &str = "golden/readings.csv";

/// The results of the committed search.
#[derive(Clone, Debug, PartialEq)]
pub struct CommittedSearch {
    /// The file.
    pub file: &'static str,
    /// SHA-256 of its content, in hexadecimal.
    pub sha256: String,
    /// Configurations tried: readings × integrators × settings of the estimator.
    pub configurations: usize,
    /// Configurations among these whose reading keeps all three motions.
    pub kept: usize,
    /// Configurations among these with all three kinds of motion. No others are ranked.
    pub ranked: usize,
    /// Numbers of readings, integrators and settings of the estimator among the ranked
    /// configurations.
    pub ranked_from: [usize; 3],
    /// Pairs of reading and integrator, by class.
    pub pairs: PairCounts,
    /// Number of configurations that keep all three motions and match a published exponent to the
    /// printed digits, for each exponent.
    pub digits: [[usize; 4]; 3],
    /// Distance of configurations from all twelve exponents together: those that keep all three
    /// motions, and the ranked ones.
    pub joint_levels: [MatchLevel; 2],
    /// Distance of the nearest configuration for each figure alone, and that configuration.
    pub figure_levels: [(MatchLevel, Match); 3],
    /// A row of each pair of reading and integrator, for its motions.
    pub motions: Vec<ConfigurationRow>,
    /// Fraction of random targets for an exponent that are matched by as many of these
    /// configurations as the published one. `None` where none matches it.
    pub digits_by_random_targets: [[Option<Share>; 4]; 3],
    /// Values of each exponent of each figure over the settings that the paper does not state, for
    /// the recommended reading.
    pub spread: [[ExponentSpread; 4]; 3],
    /// The rows behind them, each setting once, with the setting.
    pub recommended: Vec<(ConfigurationRow, Setting)>,
    /// Number of these settings that confirm the statements of Sect. 5.2.
    pub confirmed_statements: ConfirmedStatements,
}

/// The rows of the committed search.
///
/// # Errors
/// As [`CommittedSearch::read`].
pub fn committed_rows() -> Result<Vec<ConfigurationRow>, String> {
    complete_rows(TABLE, &Plan::full()?)
}

/// Ranges of the exponents of Figs. 10–12 over the settings that the paper does not state, for the
/// recommended reading; see [`CommittedSearch::spread`].
///
/// # Errors
/// As [`CommittedSearch::read`].
pub fn committed_spread() -> Result<[[ExponentSpread; 4]; 3], String> {
    let plan = Plan::full()?;
    let rows = complete_rows(TABLE, &plan)?;
    Ok(spread(&RowsByRole::of(&rows).recommended, &plan))
}

fn spread(recommended: &[&ConfigurationRow], plan: &Plan) -> [[ExponentSpread; 4]; 3] {
    for_each_exponent(|exponent| ExponentSpread::of(recommended, exponent, &plan.published))
}

/// The rows of a table, if they are those of the search.
fn complete_rows(table: &str, plan: &Plan) -> Result<Vec<ConfigurationRow>, String> {
    let rows: Vec<ConfigurationRow> = table.lines().filter_map(ConfigurationRow::parse).collect();
    let keys = plan.groups.iter().flat_map(|group| {
        let settings = plan.settings_of(group);
        settings.into_iter().map(|one| plan::key(group, &one))
    });
    let expected: Vec<[String; 4]> = keys.collect();
    let same = rows.iter().map(|row| &row.key).eq(&expected);
    match same && table.starts_with(&plan.heading()) {
        true => Ok(rows),
        false => Err(format!(
            "{FILE} is not the table of the full search: {} of {} configurations can be read, or \
             they were made with other settings; make it with `make readings`",
            rows.len(),
            expected.len()
        )),
    }
}

/// A row with its three motions in words, and with the time of an escape.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// The row.
    pub row: ConfigurationRow,
    /// Motions.
    pub motions: [String; 3],
}

impl CommittedSearch {
    /// Reads the table.
    ///
    /// # Errors
    /// A message if a configuration of the full search is missing or has other settings.
    pub fn read() -> Result<CommittedSearch, String> {
        CommittedSearch::of(TABLE)
    }

    fn of(table: &str) -> Result<CommittedSearch, String> {
        let plan = Plan::full()?;
        let (published, target) = (&plan.published, &plan.target);
        let rows = complete_rows(table, &plan)?;
        let RowsByRole {
            search,
            kept,
            ranked,
            pairs,
            recommended,
        } = RowsByRole::of(&rows);
        let agreeing = for_each_exponent(|exponent| count_matching(&kept, exponent, published));
        let levels = single_figure_levels(&search, target, plan.draws);
        let levels = levels.ok_or_else(|| format!("{FILE} has no rows"))?;
        let digest = Sha256::digest(table.as_bytes());
        let by_random_targets = |(figure, k): (usize, usize)| {
            let rows = agreeing[figure][k];
            (rows > 0).then(|| digits_share(&kept, (figure, k), rows, plan.draws))
        };
        let level = |rows| MatchLevel::of(rows, &kept, (target, &[0, 1, 2]), plan.draws);
        let with_motions = |(level, row): (MatchLevel, &ConfigurationRow)| {
            let (row, motions) = (row.clone(), search::motions(&plan, row));
            (level, Match { row, motions })
        };
        let settings = || plan.search.iter().chain(&plan.spread);
        let with_setting = |row: &&ConfigurationRow| {
            let setting = settings().find(|one| settings_name(one) == row.key[3]);
            Some(((*row).clone(), setting?.clone()))
        };
        Ok(CommittedSearch {
            file: FILE,
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            configurations: search.len(),
            kept: kept.len(),
            ranked: ranked.len(),
            ranked_from: sources(&ranked),
            pairs: PairCounts::count(&pairs),
            joint_levels: [level(&kept), level(&ranked)],
            figure_levels: levels.map(with_motions),
            motions: pairs.into_iter().cloned().collect(),
            digits_by_random_targets: for_each_exponent(by_random_targets),
            spread: spread(&recommended, &plan),
            recommended: recommended.iter().filter_map(with_setting).collect(),
            confirmed_statements: ConfirmedStatements::count(&recommended),
            digits: agreeing,
        })
    }

    /// The path and the first digits of the hash, for citation beside a number.
    pub fn citation(&self) -> String {
        format!("{}, SHA-256 {}…", self.file, &self.sha256[..16])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_that_is_not_the_full_search_is_refused() {
        assert!(CommittedSearch::read().is_ok());
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
            let refused = CommittedSearch::of(&other).unwrap_err();
            assert!(refused.contains("not the table of the full search"));
        }
    }

    #[test]
    fn another_number_in_the_table_is_another_hash_and_another_spread() {
        let committed = CommittedSearch::read().unwrap();
        let least = committed.spread[0][1].values.unwrap().least;
        let other =
            CommittedSearch::of(&TABLE.replacen(&format!(",{least},"), ",-99,", 1)).unwrap();
        assert_ne!(other.sha256, committed.sha256);
        assert_eq!(other.spread[0][1].values.unwrap().least, -99.0);
    }
}
