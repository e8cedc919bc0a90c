//! The program `readings`: a search over interpretations of Figs. 10–12 of the paper.
//!
//! The paper prints Eq. (27)–(28) with signs that contradict Newton's law. It gives nine numbers
//! without their names, no settings of its estimator, and a program for another model. Every
//! combination tried is a row of a table, with its distance from the twelve published exponents. A
//! reading that loses one of the three motions or changes its kind is not ranked. The last part of
//! the summary decides. It says how near the same search comes to other targets, and how far the
//! estimator's settings alone move an exponent.

mod committed;
mod orbit;
mod plan;
mod scoring;
mod search;
mod settings;
mod significance;
mod summary;
mod table;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use rayon::prelude::*;

use crate::terminal::{self, ProgramError};
use output::Artifact;
use output::terminal::DelayedProgressBar;

pub use committed::{CommittedSearch, Match, committed_rows, committed_spread};
use plan::Plan;
pub use plan::{Integrator, ZERO_SIZE};
pub use scoring::{ConfirmedStatements, ExponentSpread, PairCounts, ValueRange, sources_in_words};
pub use search::{Scaled, estimate};
pub use settings::Setting;
pub use significance::{MatchLevel, Share};
pub use table::{ConfigurationRow, OrbitVerdict, other_motions};

/// The option that chooses the folder.
const OPTION: &str = "--out";

const ABOUT: &str = "Searches the ways to read the paper's Eq. (27)-(28) and the captions of Figs. \
    10-12 for the one that gives the twelve published Lyapunov exponents, and says how much such a \
    find is worth.";

const AFTER: &str = "\
Writes into the folder, after some ten minutes
  readings.csv  every configuration tried: form of equations and captions, integrator, \
    settings of the estimator; classes,
                sizes of the motions, exponents with their status, distance from the published ones
  readings.txt  the nearest to each figure and to all, chance level, spread of the \
    estimator; also printed

The files are the same bytes for any number of threads.

Example:
  readings --out golden";

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(name = "readings", version, about = ABOUT, after_help = AFTER)]
struct Arguments {
    /// Folder for the files; made if it does not exist
    #[arg(
        long,
        value_name = "DIR",
        default_value = "readings",
        visible_alias = "out-dir"
    )]
    out: PathBuf,
}

/// The program. Exit code 0 on success, 1 on failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let found = Plan::full().map_err(ProgramError::from);
    terminal::finish(found.and_then(|plan| run(&plan, &arguments.out)))
}

/// Searches, writes the table and the summary, and returns the summary.
///
/// # Errors
/// A folder or file that cannot be written.
fn run(plan: &Plan, folder: &Path) -> Result<String, ProgramError> {
    // An unwritable folder is reported before the search.
    terminal::write(folder, &[], OPTION)?;
    let bar = DelayedProgressBar::new("{bar:40} {pos}/{len} readings x integrators, {elapsed}");
    // One group at a time, so that short and long ones spread evenly.
    let rows = plan
        .groups
        .par_iter()
        .with_max_len(1)
        .flat_map_iter(|group| {
            let rows = search::rows(plan, group, &plan.settings_of(group));
            bar.one_more(plan.groups.len() as u64);
            rows
        });
    let rows: Vec<ConfigurationRow> = rows.collect();
    bar.clear();
    let lines: String = rows.iter().map(ConfigurationRow::line).collect();
    let table = plan.heading() + &ConfigurationRow::header() + &lines;
    let text = summary::summary(plan, &rows);
    let files = [
        Artifact::text("readings.csv", table),
        Artifact::text("readings.txt", &text),
    ];
    let written = terminal::write(folder, &files, OPTION)?;
    Ok(text + &output::listing(&written))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::block_and_bracket::best_common_settings;
    use crate::paper::models::Interpretation;
    use plan::Group;
    use scoring::RowsByRole;
    use settings::{Unit, settings_name};

    fn committed(name: &str) -> String {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(root.join(name)).unwrap()
    }

    #[test]
    fn the_committed_search_is_complete_and_its_summary_follows_from_it() {
        let plan = Plan::full().unwrap();
        let rows = committed_rows().unwrap();
        for row in &rows {
            assert_eq!(row.scores, scoring::scores(&row.exponents, &plan.target));
        }
        let text = summary::summary(&plan, &rows);
        assert!(
            text == committed("golden/readings.txt"),
            "run `make readings`"
        );
    }

    #[test]
    fn the_files_are_the_same_for_any_number_of_threads() {
        let mut plan = Plan {
            from: 300.0,
            points: 3001,
            draws: 50,
            ..Plan::full().unwrap()
        };
        plan.groups.retain(|group| {
            let integrators = [Integrator::Exact, Integrator::InPlace(1e-2)];
            let readings = [Interpretation::exact(), Interpretation::as_printed()];
            readings.contains(&group.reading) && integrators.contains(&group.integrator)
        });
        plan.search.truncate(2);
        plan.spread.truncate(2);
        let search = |threads: usize| {
            let folder = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let said = pool.build().unwrap().install(|| run(&plan, folder.path()));
            let said = said.unwrap();
            assert!(said.contains("random targets") && said.contains("readings.csv"));
            let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
            ["readings.csv", "readings.txt"].map(read)
        };
        let [table, text] = search(1);
        assert_eq!([table.clone(), text], search(2));
        // Every row reads back, to the last bit.
        let rows: Vec<&str> = table.lines().filter(|line| line.starts_with('s')).collect();
        assert_eq!(rows.len(), 2 * 4 + 2);
        for line in rows {
            let row = ConfigurationRow::parse(line).unwrap();
            assert_eq!(row.line().trim_end(), line);
        }
        let file = tempfile::NamedTempFile::new().unwrap();
        let refused = run(&plan, &file.path().join("sub")).unwrap_err();
        assert!(refused.to_string().contains("with --out"), "{refused}");
    }

    #[test]
    fn the_in_place_scheme_never_makes_the_torus_of_fig_11() {
        let rows = committed_rows().unwrap();
        let of = |integrator: &str| {
            let recommended = plan::reading_name(&Interpretation::exact());
            let mut all = rows.iter();
            let is =
                |row: &&ConfigurationRow| row.key[1] == recommended && row.key[2] == integrator;
            all.find(is).unwrap_or_else(|| panic!("{integrator}"))
        };
        let torus = of("exact");
        assert!(torus.classes[1].is_of_kind(1) && torus.sizes[1][1] < 1.1);
        for h in ["0.01", "0.005", "0.001"] {
            let scheme = of(&format!("in-place h={h}"));
            assert!(scheme.classes[1].is_bounded() && !scheme.classes[1].is_of_kind(1));
            assert!(scheme.sizes[1][0] < 0.6 * torus.sizes[1][0], "{h}");
        }
    }

    #[test]
    fn the_figures_use_the_nearest_setting_of_the_recommended_reading() {
        let rows = committed_rows().unwrap();
        let search: Vec<&ConfigurationRow> = RowsByRole::of(&rows)
            .search
            .into_iter()
            .filter(|row| Group::recommended().has(row))
            // The figures measure radii in units of the spread only.
            .filter(|row| !row.key[3].contains("absolute") && !row.key[3].contains("of ranges"))
            .collect();
        let best = summary::minimal_by(&search, ConfigurationRow::kinds_first).unwrap();
        let setting = (Unit::Spread, best_common_settings());
        assert_eq!(best.key[3], settings_name(&setting));
        // The figures compute the same exponents, in the same order of size.
        for figure in 0..3 {
            let shown = committed(&format!("figures/fig{}.csv", figure + 10));
            let mut values: Vec<f64> = shown
                .lines()
                .filter(|line| line.contains(".lambda.") && line.contains(",best-of-readings,"))
                .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
                .collect();
            values.sort_by(|one, other| other.total_cmp(one));
            assert_eq!(values, best.exponents[figure], "fig{}", figure + 10);
        }
    }
}
