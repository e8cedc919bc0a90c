//! The motions of Figs. 10–12: by the procedure of Sect. 3, and whether exponents and sections show
//! the same kind of motion.
//!
//! A positive exponent means chaos; two zero exponents a torus; one a closed orbit. A section
//! closes if the test of the figures finds at most 64 distinct points that repeat in the same order
//! ([`crate::motion::Evidence`]). A thousand points hardly distinguish an uneven
//! curve from a chaotic set. So whether an open section is a curve decides nothing. It is only
//! shown: the points lie on a curve if hardly any has more than two neighbours in their minimum
//! spanning tree.

use rayon::prelude::*;

use crate::figures::block_and_bracket::{Data, SETS, by_rk4_and_henon};
use crate::motion::Class;
use crate::paper::models::Interpretation;
use crate::paper::reading::Reading::{Corrected, CorrectedEquations};
use crate::readings::OrbitVerdict;
use crate::report::finding::{Finding, as_printed, statement};
use crate::text::joined;
use stickslip::Error;

/// Step of the classical Runge–Kutta method. The paper states none for Figs. 10–12.
const RK4_STEP: f64 = 0.01;

/// `s5.by_procedure`: Eq. (27) by the procedure of Sect. 3, steps of RK4 with Hénon's step onto Σ.
/// Classes of the motions of Figs. 10, 11 and 12; `None` where the orbit escapes.
#[derive(Clone, Debug, PartialEq)]
pub struct ByProcedure {
    /// Classes with the corrected equations.
    pub corrected: Vec<Option<Class>>,
    /// Classes with the equations as printed.
    pub as_printed: Vec<Option<Class>>,
}

impl ByProcedure {
    /// Integrates all six orbits.
    pub(super) fn compute() -> Result<ByProcedure, Error> {
        let readings = [Interpretation::exact(), Interpretation::as_printed()];
        let runs = readings.map(|reading| SETS.map(|set| (reading, set)));
        let runs = runs.as_flattened().par_iter();
        let classes = runs.map(|(reading, set)| by_rk4_and_henon(set, reading, RK4_STEP));
        let mut corrected = classes.collect::<Result<Vec<_>, Error>>()?;
        let as_printed = corrected.split_off(SETS.len());
        Ok(ByProcedure {
            corrected,
            as_printed,
        })
    }

    pub(super) fn findings(&self) -> Vec<Finding> {
        let whats = [
            "Fig. 10: the captioned class, with its number of loops",
            "Fig. 11: the captioned class",
            "Fig. 12: the captioned class",
        ];
        let parts = |classes: &[Option<Class>]| {
            let captioned = |i: usize| {
                classes[i].is_some_and(|class| OrbitVerdict::Motion(class).is_published(i))
            };
            [0, 1, 2].map(|i| (whats[i], captioned(i)))
        };
        let names = |classes: &[Option<Class>]| {
            let name = |one: &Option<Class>| one.map_or("escapes".into(), |one| one.to_string());
            joined(classes.iter().map(name), ", ")
        };
        let (corrected, printed) = (names(&self.corrected), names(&self.as_printed));
        let line = format!(
            "by RK4 with steps of {RK4_STEP} and Hénon's step, Figs. 10, 11, 12: {corrected}; with \
             the equations as printed: {printed}. Another reading, that it gave the very \
             trajectories of the figures, cannot be decided: neither step nor program is stated, \
             and only the text of the paper was at hand, not its pictures"
        );
        vec![
            statement(Corrected, parts(&self.corrected), line),
            as_printed(parts(&self.as_printed)),
        ]
    }
}

/// A set with a smaller fraction of branching points lies on a curve. This is half the value of the
/// Hénon attractor.
const CURVE_BRANCHING: f64 = 0.05;
/// Maximum number of distinct points of a section that closes, as in
/// [`crate::motion`].
const MAX_CLOSED_POINTS: usize = 64;

/// One figure by its exponents and by its section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// The motion by section and exponents together, as in the figure.
    pub class: Class,
    /// Points of the section.
    pub points: usize,
    /// Distinct points, if the section closes.
    pub closes_after: Option<usize>,
    /// Fraction of points at which the minimum spanning tree branches; NaN if the section closes.
    pub branching: f64,
    /// Exponents that are zero within their errors.
    pub zeros: usize,
    /// Whether the first exponent is positive.
    pub positive: bool,
}

impl Shape {
    pub(super) fn of(data: &Data) -> Shape {
        let evidence = &data.exact.evidence;
        let closes = evidence.repeats && (1..=MAX_CLOSED_POINTS).contains(&evidence.distinct);
        Shape {
            class: data.exact.class,
            points: data.section.len(),
            closes_after: closes.then_some(evidence.distinct),
            branching: match closes {
                true => f64::NAN,
                false => branching(&data.section),
            },
            zeros: evidence.zeros,
            positive: evidence.positive,
        }
    }

    /// The class by the exponents alone, which do not give the number of loops.
    fn by_exponents(&self) -> Class {
        match (self.positive, self.zeros) {
            (true, _) => Class::Chaotic,
            (false, 1) => Class::Periodic(1),
            (false, 2) => Class::QuasiPeriodic,
            _ => Class::Undecided,
        }
    }

    /// Whether the section closes if and only if the exponents show a closed orbit.
    pub fn confirmed(&self) -> bool {
        let class = self.by_exponents();
        let closed = matches!(class, Class::Periodic(_));
        class != Class::Undecided && self.closes_after.is_some() == closed
    }

    fn line(&self, figure: usize) -> String {
        let section = match self.closes_after {
            Some(points) => format!("closes (distinct points: {points})"),
            None => {
                let (all, percent) = (self.points, 100.0 * self.branching);
                let like = match self.branching < CURVE_BRANCHING {
                    true => "like",
                    false => "unlike",
                };
                format!(
                    "of {all} points does not close (its minimum spanning tree branches at \
                     {percent:.1} % of them, {like} that of a curve, which decides nothing)"
                )
            }
        };
        let class = self.by_exponents();
        let (zeros, positive) = (self.zeros, usize::from(self.positive));
        format!(
            "Fig. {}: the section {section}; the exponents ({zeros} zero, {positive} positive): \
                {class}",
            figure + 10
        )
    }
}

/// Fraction of points with more than two neighbours in the minimum spanning tree (Prim 1957).
fn branching<const N: usize>(points: &[[f64; N]]) -> f64 {
    if points.is_empty() {
        return f64::NAN;
    }
    let square = |one: &[f64; N], other: &[f64; N]| -> f64 {
        one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let mut degrees = vec![0_u32; points.len()];
    // For each point outside the tree: its index, its squared distance from the tree, and the
    // nearest member.
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

/// Shapes of Figs. 10, 11 and 12.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes(pub [Shape; 3]);

impl Shapes {
    /// `s5.kinds`: the kinds of motion, without the number of loops.
    pub(super) fn kinds(&self) -> Vec<Finding> {
        let whats = [
            "Fig. 10: a periodic motion",
            "Fig. 11: a quasi-periodic motion",
            "Fig. 12: a chaotic motion",
        ];
        let holds = |i: usize| OrbitVerdict::Motion(self.0[i].class).is_of_kind(i);
        let parts = [0, 1, 2].map(|i| (whats[i], holds(i)));
        vec![Finding::statement(Corrected, parts)]
    }

    /// `s5.shapes`: whether exponents and sections show the same kind of motion.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let whats = [
            "Fig. 10: the section closes, as the exponents say",
            "Fig. 11: the section stays open, as the exponents say",
            "Fig. 12: the section stays open, as the exponents say",
        ];
        let parts = [0, 1, 2].map(|i| (whats[i], self.0[i].confirmed()));
        vec![statement(CorrectedEquations, parts, self.line())]
    }

    /// The results in words.
    pub fn line(&self) -> String {
        let each = self.0.iter().enumerate();
        let each = joined(each.map(|(figure, one)| one.line(figure)), ". ");
        format!("{each}. The exponents do not give the number of loops of a closed orbit")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::math;

    /// A closed curve in space, sampled unevenly like a section of a torus.
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
            assert!(on_curve < 0.5 * CURVE_BRANCHING, "{on_curve}");
            let on_attractor = branching(&henon(points as usize));
            assert!(on_attractor > 1.5 * CURVE_BRANCHING, "{on_attractor}");
        }
    }

    #[test]
    fn a_section_that_closes_confirms_a_periodic_motion_alone() {
        let shape = |closes_after, zeros, positive| Shape {
            class: Class::Undecided,
            points: 1000,
            closes_after,
            branching: f64::NAN,
            zeros,
            positive,
        };
        assert!(shape(Some(1), 1, false).confirmed() && shape(None, 2, false).confirmed());
        assert!(!shape(Some(1), 2, false).confirmed() && !shape(Some(1), 1, true).confirmed());
        assert!(!shape(None, 1, false).confirmed() && !shape(None, 0, false).confirmed());
    }
}
