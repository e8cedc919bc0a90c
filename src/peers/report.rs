//! The printed report, also written to report/bench.txt.

use super::compare::{COMPARED_ERROR, Ratio, most_accurate, ratios};
use super::measurement::Measurement;
use crate::numbers::median;
use crate::text::{SectionMarkers, distinct};

/// A time in a suitable unit.
pub fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    let decimals = match value {
        v if v < 10.0 => 2,
        v if v < 100.0 => 1,
        _ => 0,
    };
    format!("{value:.decimals$} {unit}")
}

/// The tables.
pub fn text(rows: &[Measurement], ours: &[&str], head: &str) -> String {
    let mut text = format!("{head}\n");
    text += "\n\
        Most accurate setting of every solver: error of event times, time of a run (median), \
        compilation\n";
    for row in most_accurate(rows).into_iter().map(|i| &rows[i]) {
        let cell = |value: Option<f64>| value.map_or("-".into(), duration);
        let error = row.error.map_or("-".into(), |error| format!("{error:.1e}"));
        let (time, compile) = (cell(median(&row.seconds)), cell(row.compile));
        let Measurement {
            problem,
            solver,
            note,
            ..
        } = row;
        text +=
            &format!("  {problem:15} {solver:22} {error:>8} {time:>10} {compile:>10}  {note}\n");
    }
    let ratios = ratios(rows, ours);
    if !ratios.is_empty() {
        text += &format!(
            "\n\
                Times at equal error, {COMPARED_ERROR:e} or the peer's least if that is larger, \
                between settings by interpolation\n"
        );
        text +=
            "  problem         peer                        error      peer       ours  peer/ours\n";
    }
    for ratio in ratios {
        let (time, quotient) = match ratio.our_time {
            Some(time) => (duration(time), format!("{:.1}", ratio.their_time / time)),
            None => ("never".into(), "-".into()),
        };
        let theirs = duration(ratio.their_time);
        let Ratio {
            problem,
            peer,
            ours,
            error,
            ..
        } = ratio;
        text += &format!(
            "  {problem:15} {peer:22} {error:>10.1e} {theirs:>9} {time:>10} {quotient:>10}  \
                ({ours})\n"
        );
    }
    text + &processes(rows, ours)
}

fn processes(rows: &[Measurement], ours: &[&str]) -> String {
    let timed = || rows.iter().filter_map(|row| Some((row, row.process?)));
    let mut text = String::new();
    for (row, process) in timed() {
        let Measurement {
            problem, solver, ..
        } = row;
        let own = |other: &Measurement| other.problem == *problem && ours.contains(&&*other.solver);
        let own = timed()
            .filter(|(other, _)| own(other))
            .map(|(_, process)| process);
        let fastest = own.min_by(f64::total_cmp);
        let ratio = fastest.map_or(String::new(), |fastest| format!("{:.0}", process / fastest));
        let time = duration(process);
        text += &format!("  {problem:15} {solver:22} {time:>9} {ratio:>8} times ours\n");
    }
    if text.is_empty() {
        return text;
    }
    format!("\nWhole processes: start, compile, run once with the most accurate setting\n{text}")
}

/// Markers of the table in the page of speeds.
pub const SECTION_MARKERS: SectionMarkers = SectionMarkers {
    begin: "<!-- speed: written by `make bench-peers` -->\n",
    end: "<!-- end of speed -->\n",
};

/// A table with a line for each peer: the ratio of its time to that of our solver, smallest and
/// largest over the problems.
pub fn block(rows: &[Measurement], ours: &str) -> String {
    let all = ratios(rows, &[ours]);
    let peers = all.iter().map(|one| one.peer.as_str());
    let peers = distinct(peers.filter(|peer| !peer.starts_with(OWN_PREFIX)));
    let mut text = format!(
        "| time for an error of {COMPARED_ERROR:e} (or the peer's least), over that of `{ours}` \
            | least | most | on |\n\
            |---|--:|--:|---|\n"
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

/// Prefix of the names of our solvers.
const OWN_PREFIX: &str = "stickslip";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::{OWN_SOLVER, measurement, problems};

    #[test]
    fn times_have_three_digits_and_a_unit() {
        let times = [1.234e-5, 4.5e-3, 0.1234, 2.0].map(duration);
        assert_eq!(times, ["12.3 µs", "4.50 ms", "123 ms", "2.00 s"]);
    }

    #[test]
    fn the_page_has_the_committed_measurements() {
        let table = include_str!("../../report/bench.csv");
        let rows = measurement::read(table, &problems().unwrap()).unwrap();
        let page = include_str!("../../docs/speed.md");
        let written = SECTION_MARKERS
            .replace_section(page, &block(&rows, OWN_SOLVER))
            .unwrap();
        assert!(written == page, "run `peers redraw`");
        // Another measurement gives another table.
        let mut other = rows.clone();
        for row in other.iter_mut().filter(|row| row.solver == "heyoka") {
            row.seconds.iter_mut().for_each(|seconds| *seconds *= 2.0);
        }
        assert_ne!(block(&other, OWN_SOLVER), block(&rows, OWN_SOLVER));
    }
}
