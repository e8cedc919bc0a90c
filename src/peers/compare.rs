//! Ratios of times at equal accuracy.

use super::measurement::Measurement;
use crate::numbers::median;
use crate::text::distinct;
use stickslip::math;

/// Errors below this count as equal: the rounding of the times themselves.
const LEAST_ERROR: f64 = 1e-16;
/// The error at which solvers are compared, if they reach it. It is chosen: near rounding, where
/// solvers differ most.
pub const COMPARED_ERROR: f64 = 1e-12;

/// The Pareto front of a solver on a problem, as (time, error): points at which neither can be
/// improved without the other. Time rises and the error falls.
pub fn front<'a>(rows: impl Iterator<Item = &'a Measurement>) -> Vec<(f64, f64)> {
    let point = |row: &Measurement| Some((median(&row.seconds)?, row.error?.max(LEAST_ERROR)));
    let mut points: Vec<(f64, f64)> = rows.filter_map(point).collect();
    points.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if front.last().is_none_or(|last| point.1 < last.1) {
            front.push(point);
        }
    }
    front
}

/// The time that a solver with this front needs for an error, by interpolation of logarithms.
/// `None` if it does not reach the error.
pub fn time_for(front: &[(f64, f64)], error: f64) -> Option<f64> {
    let above = front.iter().position(|point| point.1 <= error)?;
    let (slower, better) = front[above];
    if above == 0 || better == error {
        return Some(slower);
    }
    let (faster, worse) = front[above - 1];
    let part = math::ln(error / worse) / math::ln(better / worse);
    Some(faster * math::exp(part * math::ln(slower / faster)))
}

/// A peer compared with one of our solvers.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratio {
    /// Problem.
    pub problem: &'static str,
    /// Peer solver.
    pub peer: String,
    /// Our solver.
    pub ours: String,
    /// The error at which both are compared: [`COMPARED_ERROR`], or the peer's smallest error if
    /// that is larger.
    pub error: f64,
    /// The peer's time (s).
    pub their_time: f64,
    /// Our time (s); `None` if we do not reach the error.
    pub our_time: Option<f64>,
}

/// All peers against all our solvers, in the order of the rows.
pub fn ratios(rows: &[Measurement], ours: &[&str]) -> Vec<Ratio> {
    let mut ratios = Vec::new();
    for (problem, peer) in distinct(rows.iter().map(|row| (row.problem, row.solver.as_str()))) {
        let of = |solver: &str| {
            let measured = |row: &&Measurement| row.problem == problem && row.solver == solver;
            front(rows.iter().filter(measured))
        };
        let theirs = of(peer);
        let Some(best) = theirs.last().filter(|_| !ours.contains(&peer)) else {
            continue;
        };
        let error = best.1.max(COMPARED_ERROR);
        let Some(their_time) = time_for(&theirs, error) else {
            continue;
        };
        for name in ours {
            ratios.push(Ratio {
                problem,
                peer: peer.into(),
                ours: (*name).into(),
                error,
                their_time,
                our_time: time_for(&of(name), error),
            });
        }
    }
    ratios
}

/// Index of the row with the smallest error for each solver and problem, in the order of their
/// first rows.
pub fn most_accurate(rows: &[Measurement]) -> Vec<usize> {
    let order = |row: &Measurement| row.error.unwrap_or(f64::INFINITY);
    let pairs = distinct(rows.iter().map(|row| (row.problem, &row.solver)));
    let of_pair = |(problem, solver): (&str, &String)| {
        let same = |&i: &usize| rows[i].problem == problem && rows[i].solver == *solver;
        let all = (0..rows.len()).filter(same);
        all.min_by(|&one, &other| order(&rows[one]).total_cmp(&order(&rows[other])))
    };
    pairs.into_iter().filter_map(of_pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(solver: &str, seconds: f64, error: Option<f64>) -> Measurement {
        Measurement {
            solver: solver.into(),
            problem: "decay",
            error,
            seconds: vec![seconds],
            ..Measurement::default()
        }
    }

    #[test]
    fn the_front_leaves_out_what_is_bettered() {
        let rows = [
            row("one", 4.0, Some(1e-8)),
            row("one", 1.0, Some(1e-4)),
            row("one", 3.0, Some(1e-3)),
            row("one", 2.0, None),
            row("one", 5.0, Some(0.0)),
        ];
        assert_eq!(
            front(rows.iter()),
            [(1.0, 1e-4), (4.0, 1e-8), (5.0, LEAST_ERROR)]
        );
    }

    #[test]
    fn times_are_interpolated_by_their_logarithms() {
        let front = [(1.0, 1e-4), (4.0, 1e-8)];
        assert!((time_for(&front, 1e-6).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(time_for(&front, 1e-2), Some(1.0));
        assert_eq!(time_for(&front, 1e-8), Some(4.0));
        assert_eq!(time_for(&front, 1e-9), None);
    }

    #[test]
    fn peers_are_compared_where_both_can_be() {
        let rows = [
            row("us", 1.0, Some(1e-6)),
            row("us", 2.0, Some(1e-12)),
            row("exact", 30.0, Some(1e-14)),
            row("rough", 10.0, Some(1e-6)),
            row("lost", 10.0, None),
        ];
        let ratios = ratios(&rows, &["us"]);
        let compared: Vec<(&str, f64, Option<f64>)> = ratios
            .iter()
            .map(|r| {
                (
                    r.peer.as_str(),
                    r.error,
                    r.our_time.map(|t| r.their_time / t),
                )
            })
            .collect();
        assert_eq!(
            compared,
            [("exact", 1e-12, Some(15.0)), ("rough", 1e-6, Some(10.0))]
        );
    }
}
