//! What is printed, and kept as report/bench.txt.

use super::compare::{Ratio, WANTED, most_accurate, ratios};
use super::row::Row;
use crate::text::{Marks, distinct};

/// A time in the unit that suits it.
pub fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    let decimals = if value < 10.0 {
        2
    } else if value < 100.0 {
        1
    } else {
        0
    };
    format!("{value:.decimals$} {unit}")
}

/// The tables.
pub fn text(rows: &[Row], ours: &[&str], head: &str) -> String {
    let mut text = format!("{head}\n");
    text += "\nMost accurate setting of every solver: error of event times, time of a run (median), compilation\n";
    for row in most_accurate(rows).into_iter().map(|i| &rows[i]) {
        let cell = |value: Option<f64>| value.map_or("-".into(), duration);
        let error = row.error.map_or("-".into(), |error| format!("{error:.1e}"));
        text += &format!(
            "  {:15} {:22} {:>8} {:>10} {:>10}  {}\n",
            row.problem,
            row.solver,
            error,
            cell(row.median()),
            cell(row.compile),
            row.note
        );
    }
    let ratios = ratios(rows, ours);
    if !ratios.is_empty() {
        text += &format!(
            "\nTimes at equal error, {WANTED:e} or the peer's least if that is larger, between settings by interpolation\n"
        );
        text +=
            "  problem         peer                        error      peer       ours  peer/ours\n";
        for ratio in &ratios {
            text += &line(ratio);
        }
    }
    text + &processes(rows, ours)
}

fn line(ratio: &Ratio) -> String {
    let (time, quotient) = match ratio.our_time {
        Some(time) => (duration(time), format!("{:.1}", ratio.their_time / time)),
        None => ("never".into(), "-".into()),
    };
    format!(
        "  {:15} {:22} {:>10.1e} {:>9} {:>10} {:>10}  ({})\n",
        ratio.problem,
        ratio.peer,
        ratio.error,
        duration(ratio.their_time),
        time,
        quotient,
        ratio.ours
    )
}

fn processes(rows: &[Row], ours: &[&str]) -> String {
    let timed: Vec<(&Row, f64)> = rows
        .iter()
        .filter_map(|row| Some((row, row.process?)))
        .collect();
    if timed.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "\nWhole processes: start, compile, run once with the most accurate setting\n",
    );
    for (row, process) in &timed {
        let fastest = timed
            .iter()
            .filter(|(other, _)| {
                other.problem == row.problem && ours.contains(&other.solver.as_str())
            })
            .map(|(_, process)| *process)
            .min_by(f64::total_cmp);
        let ratio = fastest.map_or(String::new(), |fastest| format!("{:.0}", process / fastest));
        text += &format!(
            "  {:15} {:22} {:>9} {:>8} times ours\n",
            row.problem,
            row.solver,
            duration(*process),
            ratio
        );
    }
    text
}

/// Where they stand in the README.
pub const MARKS: Marks = Marks {
    begin: "<!-- speed: written by `make bench-peers` -->\n",
    end: "<!-- end of speed -->\n",
};

/// For each peer how many times our time it takes, least and most over the problems, against one of
/// our solvers.
pub fn block(rows: &[Row], ours: &str) -> String {
    let all = ratios(rows, &[ours]);
    let peers = all.iter().map(|one| one.peer.as_str());
    let peers = distinct(peers.filter(|peer| !peer.starts_with(OWN)));
    let mut text = format!(
        "| time for an error of {WANTED:e} (or the peer's least), over that of `{ours}` | least | most | on |\n|---|--:|--:|---|\n"
    );
    for peer in peers {
        let of_peer: Vec<(&Ratio, f64)> = all
            .iter()
            .filter(|one| one.peer == peer)
            .filter_map(|one| Some((one, one.their_time / one.our_time?)))
            .collect();
        let least = of_peer.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let most = of_peer.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let (Some((at, least)), Some((_, most))) = (least, most) {
            text += &format!(
                "| {peer} | {least:.1} | {most:.1} | least on {} ({} there) |\n",
                at.problem,
                duration(at.their_time)
            );
        }
    }
    text
}

/// How the names of our own solvers begin.
const OWN: &str = "stickslip";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::{OURS, all_problems, row};

    #[test]
    fn times_have_three_digits_and_a_unit() {
        let told: Vec<String> = [1.234e-5, 4.5e-3, 0.1234, 2.0].map(duration).into();
        assert_eq!(told, ["12.3 µs", "4.50 ms", "123 ms", "2.00 s"]);
    }

    #[test]
    fn the_readme_has_the_committed_measurements() {
        let table = include_str!("../../report/bench.csv");
        let rows = row::read(table, &all_problems().unwrap()).unwrap();
        let readme = include_str!("../../README.md");
        let written = MARKS.put(readme, &block(&rows, OURS)).unwrap();
        assert!(written == readme, "run `peers redraw`");
        // Another measurement is another table.
        let mut other = rows.clone();
        for row in other.iter_mut().filter(|row| row.solver == "heyoka") {
            row.seconds.iter_mut().for_each(|seconds| *seconds *= 2.0);
        }
        assert_ne!(block(&other, OURS), block(&rows, OURS));
    }
}
