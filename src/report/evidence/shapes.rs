//! `s5.shapes`: whether exponents and sections of Figs. 10–12 tell the same kind of motion, each on its own.
//!
//! A section closes when the figures' own test finds at most 64 distinct points that follow one another in the same order again and
//! again ([`stickslip::analysis::motion::Evidence`]). Else it lies on a curve when its correlation dimension is below 1.2. That limit was set
//! before the figures were looked at, and it decides.
//!
//! With a thousand points the dimension hardly tells an uneven curve from the Hénon attractor (a test shows it). A second opinion is
//! therefore told beside it, which decides nothing because it was chosen afterwards: whether the points can be strung, that is whether in
//! the tree of least length that joins them hardly any has more than two neighbours.
//!
//! Exponents: a positive one means chaos, two zeros a torus, one a closed orbit.

use super::{Evidence, Part};
use crate::correlation::{CURVE, correlation_dimension};
use crate::figures::block_and_bracket::Data;

/// A set with a smaller share of branching points can be strung: half of what the Hénon attractor has.
const STRUNG: f64 = 0.05;
/// Most distinct points of a section that closes.
const MOST: usize = 64;

/// A kind of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Closes.
    Periodic,
    /// Lies on a torus.
    QuasiPeriodic,
    /// Neither.
    Chaotic,
    /// Cannot be told.
    Untold,
}

impl Kind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Periodic => "periodic",
            Kind::QuasiPeriodic => "quasi-periodic",
            Kind::Chaotic => "chaotic",
            Kind::Untold => "untold",
        }
    }
}

/// One figure, looked at in two ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Number of the figure.
    pub figure: usize,
    /// Kind that the caption names.
    pub captioned: Kind,
    /// Points of the section.
    pub points: usize,
    /// Distinct ones among them if it closes.
    pub closes_after: Option<usize>,
    /// Share of the points at which the tree of least length branches, if the section does not close.
    pub branching: Option<f64>,
    /// Correlation dimension of the section (Grassberger & Procaccia 1983) if it does not close: the slope of ln C(r) against ln r
    /// while the share C of pairs nearer than r rises from 0.002 to 0.02.
    pub dimension: Option<f64>,
    /// Exponents that are zero within their errors.
    pub zeros: usize,
    /// Whether the first is positive.
    pub positive: bool,
}

impl Shape {
    /// From a figure's section and exponents.
    pub fn of(figure: usize, captioned: Kind, data: &Data) -> Shape {
        let evidence = &data.exact.evidence;
        let closes = evidence.repeats && (1..=MOST).contains(&evidence.distinct);
        Shape {
            figure,
            captioned,
            points: data.section.len(),
            closes_after: closes.then_some(evidence.distinct),
            branching: (!closes).then(|| branching(&data.section)),
            dimension: (!closes).then(|| correlation_dimension(&data.section)),
            zeros: evidence.zeros,
            positive: evidence.positive,
        }
    }

    /// The kind by the section alone.
    pub fn by_section(&self) -> Kind {
        match (self.closes_after, self.dimension) {
            (Some(_), _) => Kind::Periodic,
            (None, Some(dimension)) if dimension < CURVE => Kind::QuasiPeriodic,
            (None, Some(dimension)) if dimension >= CURVE => Kind::Chaotic,
            _ => Kind::Untold,
        }
    }

    /// The kind by the exponents alone.
    pub fn by_exponents(&self) -> Kind {
        match (self.positive, self.zeros) {
            (true, _) => Kind::Chaotic,
            (false, 1) => Kind::Periodic,
            (false, 2) => Kind::QuasiPeriodic,
            _ => Kind::Untold,
        }
    }

    fn confirmed(&self) -> bool {
        self.by_section() == self.by_exponents() && self.by_exponents() != Kind::Untold
    }
}

/// Share of the points with more than two neighbours in the tree of least length through all of them (Prim 1957).
fn branching<const N: usize>(points: &[[f64; N]]) -> f64 {
    if points.is_empty() {
        return f64::NAN;
    }
    let square = |one: &[f64; N], other: &[f64; N]| -> f64 {
        one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let mut degrees = vec![0_u32; points.len()];
    // For each point outside the tree its square distance from it, and the member it is nearest to.
    let mut outside: Vec<(usize, f64, usize)> = (1..points.len())
        .map(|i| (i, square(&points[0], &points[i]), 0))
        .collect();
    while let Some(at) = (0..outside.len()).min_by(|&a, &b| outside[a].1.total_cmp(&outside[b].1)) {
        let (joined, _, to) = outside.swap_remove(at);
        degrees[joined] += 1;
        degrees[to] += 1;
        for (i, distance, nearest) in &mut outside {
            let from_here = square(&points[joined], &points[*i]);
            if from_here < *distance {
                (*distance, *nearest) = (from_here, joined);
            }
        }
    }
    let branches = degrees.iter().filter(|degree| **degree > 2).count();
    branches as f64 / points.len() as f64
}

/// Figs. 10, 11 and 12.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// One for each figure.
    pub figures: [Shape; 3],
}

impl Shapes {
    /// From the data of Figs. 10, 11, 12 in this order.
    pub fn of(figures: [&Data; 3]) -> Shapes {
        let [first, second, third] = figures;
        Shapes {
            figures: [
                Shape::of(10, Kind::Periodic, first),
                Shape::of(11, Kind::QuasiPeriodic, second),
                Shape::of(12, Kind::Chaotic, third),
            ],
        }
    }
}

impl Evidence for Shapes {
    fn parts(&self) -> Vec<Part> {
        let [first, second, third] = &self.figures;
        vec![
            Part {
                what: "Fig. 10: exponents and section tell the same kind of motion",
                holds: first.confirmed(),
            },
            Part {
                what: "Fig. 11: exponents and section tell the same kind of motion",
                holds: second.confirmed(),
            },
            Part {
                what: "Fig. 12: exponents and section tell the same kind of motion",
                holds: third.confirmed(),
            },
        ]
    }

    fn line(&self) -> String {
        let figures: Vec<String> = self
            .figures
            .iter()
            .map(|one| {
                let section = match (one.closes_after, one.branching, one.dimension) {
                    (Some(points), ..) => format!("closes (distinct points: {points})"),
                    (None, Some(branching), Some(dimension)) => format!(
                        "of {} points has correlation dimension {dimension:.2} (second opinion: it branches at {:.1} % of them, so that it {} be strung)",
                        one.points,
                        100.0 * branching,
                        if branching < STRUNG { "can" } else { "cannot" }
                    ),
                    _ => "does not tell".to_owned(),
                };
                format!(
                    "Fig. {}: the section {section}: {}; the exponents ({} zero, {} positive): {}",
                    one.figure,
                    one.by_section().name(),
                    one.zeros,
                    usize::from(one.positive),
                    one.by_exponents().name(),
                )
            })
            .collect();
        format!(
            "{}. A dimension below {CURVE} is taken for a curve; how many loops a closed orbit has the exponents cannot tell",
            figures.join(". ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::math;

    /// A closed curve in space, visited like a section of a torus and unevenly.
    fn curve(points: u32) -> Vec<[f64; 3]> {
        (0..points)
            .map(|k| {
                let phase = 2.399_963 * f64::from(k);
                let phase = phase + 0.8 * math::sin(phase);
                [
                    math::sin(phase),
                    math::cos(phase),
                    0.5 * math::sin(3.0 * phase),
                ]
            })
            .collect()
    }

    fn henon(points: usize) -> Vec<[f64; 2]> {
        let (mut x, mut y) = (0.1, 0.1);
        let mut all = Vec::new();
        for k in 0..points + 100 {
            (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
            if k >= 100 {
                all.push([x, y]);
            }
        }
        all
    }

    #[test]
    fn the_limit_lies_between_curves_and_the_henon_attractor() {
        for points in [900, 1400] {
            let on_curve = branching(&curve(points));
            assert!(on_curve < 0.5 * STRUNG, "{on_curve}");
            let on_attractor = branching(&henon(points as usize));
            assert!(on_attractor > 1.5 * STRUNG, "{on_attractor}");
        }
    }

    #[test]
    fn the_dimension_does_not_tell_an_uneven_curve_from_the_henon_attractor() {
        let (on_curve, on_attractor) = (
            correlation_dimension(&curve(1050)),
            correlation_dimension(&henon(1400)),
        );
        assert!(
            (on_attractor - on_curve).abs() < 0.1,
            "{on_curve} {on_attractor}"
        );
    }
}
