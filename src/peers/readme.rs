//! The README's sentences on speed beside other solvers, written from the committed measurements.

use super::compare::{Ratio, WANTED, ratios};
use super::report::duration;
use super::row::Row;
use crate::text::Marks;

/// Where they stand in the README.
pub const MARKS: Marks = Marks {
    begin: "<!-- speed: written by `make bench-peers` -->\n",
    end: "<!-- end of speed -->\n",
};

/// For each peer how many times our time it takes, least and most over the problems, against one of our solvers.
pub fn block(rows: &[Row], ours: &str) -> String {
    let all = ratios(rows, &[ours]);
    let mut peers: Vec<&str> = Vec::new();
    for ratio in &all {
        if !peers.contains(&ratio.peer.as_str()) && !ratio.peer.starts_with(OWN) {
            peers.push(&ratio.peer);
        }
    }
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
