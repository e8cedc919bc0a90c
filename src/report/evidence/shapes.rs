//! `s5.shapes`, `s5.kinds`: whether exponents and sections of Figs. 10–12 tell the same kind of
//! motion, and the published one.
//!
//! Exponents: a positive one means chaos, two zeros a torus, one a closed orbit. A section closes
//! when the figures' own test finds at most 64 distinct points that follow one another in the same
//! order again and again ([`stickslip::analysis::motion::Evidence`]). A thousand points hardly tell
//! an uneven curve from a chaotic set, so that whether a section that does not close is a curve
//! decides nothing. It is shown beside: whether the points can be strung, that is whether in the
//! tree of least length that joins them hardly any has more than two neighbours.

use super::{Evidence, Part};
use crate::figures::block_and_bracket::Data;
use stickslip::analysis::motion::Class;

/// A set with a smaller share of branching points can be strung: half of what the Hénon attractor has.
const STRUNG: f64 = 0.05;
/// Most distinct points of a section that closes.
const MOST: usize = 64;

/// A kind of motion, loops of a closed orbit left out.
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
    /// What the captions of Figs. 10, 11 and 12 name.
    pub const CAPTIONED: [Kind; 3] = [Kind::Periodic, Kind::QuasiPeriodic, Kind::Chaotic];

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

impl From<Class> for Kind {
    fn from(class: Class) -> Kind {
        match class {
            Class::Periodic(_) => Kind::Periodic,
            Class::QuasiPeriodic => Kind::QuasiPeriodic,
            Class::Chaotic => Kind::Chaotic,
            Class::Undecided => Kind::Untold,
        }
    }
}

/// One figure, looked at in two ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Kind of the motion by section and exponents together, as in the figure.
    pub kind: Kind,
    /// Points of the section.
    pub points: usize,
    /// Distinct ones among them if it closes.
    pub closes_after: Option<usize>,
    /// Share of the points at which the tree of least length branches, if the section does not close.
    pub branching: Option<f64>,
    /// Exponents that are zero within their errors.
    pub zeros: usize,
    /// Whether the first is positive.
    pub positive: bool,
}

impl Shape {
    /// From a figure's section and exponents.
    pub fn of(data: &Data) -> Shape {
        let evidence = &data.exact.evidence;
        let closes = evidence.repeats && (1..=MOST).contains(&evidence.distinct);
        Shape {
            kind: data.exact.class.into(),
            points: data.section.len(),
            closes_after: closes.then_some(evidence.distinct),
            branching: (!closes).then(|| branching(&data.section)),
            zeros: evidence.zeros,
            positive: evidence.positive,
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

    /// Whether the section closes if the exponents say so, and only then.
    pub fn confirmed(&self) -> bool {
        let kind = self.by_exponents();
        kind != Kind::Untold && self.closes_after.is_some() == (kind == Kind::Periodic)
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

/// One part for each of the three figures.
fn parts(holds: [bool; 3], whats: [&'static str; 3]) -> Vec<Part> {
    let both = whats.into_iter().zip(holds);
    both.map(|(what, holds)| Part { what, holds }).collect()
}

impl Shapes {
    /// From the data of Figs. 10, 11, 12 in this order.
    pub fn of(figures: [&Data; 3]) -> Shapes {
        Shapes {
            figures: figures.map(Shape::of),
        }
    }

    /// `s5.kinds`: the kinds of motion, loops left out.
    pub fn kinds(&self) -> Vec<Part> {
        parts(
            std::array::from_fn(|i| self.figures[i].kind == Kind::CAPTIONED[i]),
            [
                "Fig. 10: a periodic motion",
                "Fig. 11: a quasi-periodic one",
                "Fig. 12: a chaotic one",
            ],
        )
    }
}

impl Evidence for Shapes {
    fn parts(&self) -> Vec<Part> {
        parts(
            self.figures.map(|one| one.confirmed()),
            [
                "Fig. 10: the section closes as the exponents say",
                "Fig. 11: it does not close as they say",
                "Fig. 12: it does not close as they say",
            ],
        )
    }

    fn line(&self) -> String {
        let section = |one: &Shape| match (one.closes_after, one.branching) {
            (Some(points), _) => format!("closes (distinct points: {points})"),
            (None, Some(branching)) => format!(
                "of {} points does not close (it branches at {:.1} % of them and {} be strung, which decides nothing)",
                one.points,
                100.0 * branching,
                if branching < STRUNG { "can" } else { "cannot" }
            ),
            _ => "does not tell".to_owned(),
        };
        let figures: Vec<String> = (10..)
            .zip(&self.figures)
            .map(|(figure, one): (u32, _)| {
                format!(
                    "Fig. {figure}: the section {}; the exponents ({} zero, {} positive): {}",
                    section(one),
                    one.zeros,
                    usize::from(one.positive),
                    one.by_exponents().name(),
                )
            })
            .collect();
        format!(
            "{}. How many loops a closed orbit has the exponents cannot tell",
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
    fn a_section_that_closes_confirms_a_periodic_motion_alone() {
        let shape = |closes_after, zeros, positive| Shape {
            kind: Kind::Untold,
            points: 1000,
            closes_after,
            branching: None,
            zeros,
            positive,
        };
        assert!(shape(Some(1), 1, false).confirmed() && shape(None, 2, false).confirmed());
        assert!(!shape(Some(1), 2, false).confirmed() && !shape(Some(1), 1, true).confirmed());
        assert!(!shape(None, 1, false).confirmed() && !shape(None, 0, false).confirmed());
    }
}
