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
mod store;
mod summary;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::Parser;
use rayon::prelude::*;

use crate::terminal::{self, ProgramError};
use output::Artifact;

pub use committed::{CommittedSearch, Match};
use plan::Plan;
pub use plan::{Integrator, ZERO_SIZE};
pub use scoring::{ConfirmedStatements, ExponentSpread, PairCounts, ValueRange, sources_in_words};
pub use search::{Scaled, estimate};
pub use settings::Setting;
pub use significance::{MatchLevel, Share};
use store::{OPTION, Store, TABLE};
pub use table::{ConfigurationRow, OrbitVerdict, other_motions};

/// Name of the summary.
const SUMMARY: &str = "readings.txt";

const ABOUT: &str = "Searches the ways to read the paper's Eq. (27)-(28) and the captions of Figs. \
    10-12 for the one that gives the twelve published Lyapunov exponents, and says how much such a \
    find is worth.";

const AFTER: &str = "\
Writes into the folder
  readings.csv  every configuration tried: form of equations and captions, integrator, \
    settings of the estimator; classes,
                sizes of the motions, exponents with their status, distance from the published ones
  readings.txt  the nearest to each figure and to all, chance level, spread of the \
    estimator; also printed

A run that was stopped, or had no time left, goes on where it was when started again with the same \
    folder. What is kept is
whole readings x integrators, with all settings of the estimator: each takes about 5 to 30 s, \
    the first, which has most settings,
up to a minute. With --time-limit those begun are finished, so that the limit is overrun by as \
    much, and however short it is
one is begun. Complete files are the same bytes for any number of threads and interruptions.

Exit codes: 0 done or out of time, 1 a file cannot be read or written, 2 wrong command line.

Examples:
  readings --out readings
  readings --out readings --time-limit 300
  readings --quick --out quick --threads 1";

/// Arguments of the program.
#[derive(Debug, Parser)]
#[command(name = "readings", version, about = ABOUT, after_help = AFTER)]
pub struct Arguments {
    /// Folder for the files; made if it does not exist
    #[arg(
        long,
        value_name = "DIR",
        default_value = "readings",
        visible_alias = "out-dir"
    )]
    pub out: PathBuf,

    /// Begin nothing new after so many seconds; what is begun, one thing at least, is finished and
    /// takes about 5 to 30 s [default: no limit]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time_limit: Option<Duration>,

    /// Threads [default: one per core]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Short series and a few configurations only, as a check of the program
    #[arg(long)]
    pub quick: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    text.parse::<f64>()
        .ok()
        .filter(|&value| value > 0.0)
        .and_then(|value| Duration::try_from_secs_f64(value).ok())
        .ok_or_else(|| "give a positive number of seconds, such as 300".into())
}

/// The program. Exit code 0 on success, 1 on failure, 2 for a wrong command line.
pub fn main() -> ExitCode {
    terminal::finish("summary", run(&Arguments::parse()))
}

/// Searches, writes the table as it grows, then the summary, and returns the summary.
///
/// # Errors
/// A file that cannot be read or written; threads that cannot be started.
pub fn run(arguments: &Arguments) -> Result<String, ProgramError> {
    let begin = Instant::now();
    let limit = arguments.time_limit;
    let late = || limit.is_some_and(|limit| begin.elapsed() >= limit);
    let plan = match arguments.quick {
        true => Plan::quick()?,
        false => Plan::full()?,
    };
    let store = Store::open(&plan, &arguments.out)?;
    // An unwritable folder is reported before the search.
    store.write()?;
    let pending = store.pending();
    let total = plan.groups.len();
    let done = total - pending.len();
    let bar = terminal::bar(done, total, " readings x integrators, {elapsed}");
    bar.enable_steady_tick(Duration::from_secs(1));
    let store = Mutex::new(store);
    let begun = AtomicBool::new(false);
    let work = || {
        // One task at a time, so that short and long ones spread evenly.
        pending.par_iter().with_max_len(1).try_for_each(|&i| {
            // At least one task is done whatever the limit, so that repeated calls finish the
            // search.
            if begun.swap(true, Ordering::Relaxed) && late() {
                return Ok(());
            }
            let rows = search::group_rows(&plan.groups[i], &plan);
            // After a panic elsewhere the lock is poisoned, but the rows are still complete.
            let added = store
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .add(i, rows);
            bar.inc(1);
            added
        })
    };
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| {
            format!("cannot start {threads} threads: {error}; give fewer with --threads")
        })?;
    let outcome = pool.install(work);
    bar.finish_and_clear();
    outcome?;
    let store = store.into_inner().unwrap_or_else(PoisonError::into_inner);
    let text = summary::summary(&plan, &store.rows());
    terminal::write(&arguments.out, &[Artifact::text(SUMMARY, &text)], OPTION)?;
    let folder = arguments.out.display();
    Ok(text + &format!("\nwrote {TABLE} and {SUMMARY} into {folder}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::block_and_bracket::best_common_settings;
    use crate::paper::models::Reading;
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
        let table = committed("golden/readings.csv");
        assert!(table.starts_with(&plan.heading()), "run `make readings`");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(TABLE), &table).unwrap();
        let store = Store::open(&plan, folder.path()).unwrap();
        assert_eq!(store.pending(), [0; 0], "run `make readings`");
        let text = summary::summary(&plan, &store.rows());
        assert!(
            text == committed("golden/readings.txt"),
            "run `make readings`"
        );
    }

    #[test]
    fn the_in_place_scheme_never_makes_the_torus_of_fig_11() {
        let table = committed("golden/readings.csv");
        let rows: Vec<ConfigurationRow> =
            table.lines().filter_map(ConfigurationRow::parse).collect();
        let of = |integrator: &str| {
            let recommended = plan::reading_name(&Reading::exact());
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
        let table = committed("golden/readings.csv");
        let rows: Vec<ConfigurationRow> =
            table.lines().filter_map(ConfigurationRow::parse).collect();
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
