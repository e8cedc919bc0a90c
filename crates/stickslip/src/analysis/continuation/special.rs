//! The special orbits between two on a branch, by their multipliers.

use super::line::Line;
use super::walk::{Vanishing, Walk};
use super::{Special, SpecialPoint, critical, parameter_of};
use crate::analysis::critical::zero_between;
use crate::analysis::cycle::{Cycle, Function, Path, Shooting, Zero, at_least};
use crate::analysis::lagrange::weights;
use crate::dynamics::Vector;

/// The determinant that vanishes where another branch meets this one: that of the derivative of the
/// equations, with the plane across the branch (Keller 1977).
fn bordered(cycle: &Cycle, across: &Vector) -> f64 {
    let rows = cycle.jacobian.nrows();
    let mut matrix = cycle.jacobian.clone().insert_row(rows, 0.0);
    let row = across.clone().resize_vertically(matrix.ncols(), 0.0);
    matrix.set_row(rows, &row.transpose());
    matrix.determinant()
}

impl Walk<'_> {
    /// Continues to this orbit on the line, and records the special ones between the last one and
    /// it, by the multipliers.
    pub(super) fn follow(&mut self, line: &Line, next: Cycle, onward: Option<Line>) {
        let behind = self.branch.points.len();
        let shooting = self.shooting;
        let of = |cycle: &Cycle| critical(cycle, &shooting);
        let (here, there) = (of(&self.branch.last), of(&next));
        let length = line.place(&next);
        let most = self.branch.last.monodromy.amax().max(next.monodromy.amax());
        // Near a homoclinic orbit: the error that cancellation of large numbers leaves.
        let noise = next.known * most * most;
        let (units, across) = (self.branch.units, line.across());
        let heading = |cycle: &Cycle| Some(line.goes_on(&shooting, units, cycle)?.heading());
        let parts = |cycle: &Cycle| Some(bordered(cycle, across));
        let minus_one = |cycle: &Cycle| Some(of(cycle).minus_one);
        let circle = |cycle: &Cycle| of(cycle).circle;
        let is_of_one = [here.one, there.one]
            .map(f64::abs)
            .iter()
            .any(|one| *one > noise);
        let functions: [(&Function<'_>, bool); 4] = [
            (&heading, is_of_one),
            (&parts, is_of_one),
            (
                &minus_one,
                here.minus_one.abs().max(there.minus_one.abs()) > noise,
            ),
            (&circle, true),
        ];
        let mut found = Vec::new();
        for (kind, (function, is_known)) in functions.into_iter().enumerate() {
            let (true, Some(a), Some(b)) = (is_known, function(&self.branch.last), function(&next))
            else {
                continue;
            };
            if a * b >= 0.0 {
                continue;
            }
            let by_polynomial = |rough: f64| self.interpolated(line, length, rough, function);
            let path = line.orbits(&self.shooting);
            let zero = path.zero([(0.0, a), (length, b)], function);
            let place = zero.as_ref().map(Place::of);
            let place = place.or_else(|| by_polynomial(length * a / (a - b)));
            let Some(mut place) = place else {
                continue;
            };
            // A zero that the neighbouring orbits do not resolve is none: the tangent is
            // undetermined there.
            let ends =
                [&self.branch.last, &next].map(|one| (parameter_of(one) - place.parameter).abs());
            let is_resolved = place.uncertainty < ends[0].max(ends[1]);
            if kind == 0 && !is_resolved {
                continue;
            }
            let what = match kind {
                0 => Special::Fold,
                1 => Special::BranchPoint,
                2 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: line
                        .on(&self.shooting, place.s)
                        .map_or(there.angle, |cycle| of(&cycle).angle),
                },
            };
            let there = zero.map_or_else(|| next.clone(), |zero| zero.solution);
            // Next to it, orbits are less exact than around it.
            if what == Special::BranchPoint
                && let Some(other) = by_polynomial(place.s)
                && is_better(other.uncertainty, place.uncertainty)
            {
                place = other;
            }
            found.push((
                place.s,
                SpecialPoint {
                    parameter: place.parameter,
                    uncertainty: self.at_least(place.parameter, place.uncertainty),
                    what,
                    behind,
                    x: place.x,
                    period: place.period,
                },
                there,
            ));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, point, there) in found {
            self.note_special(point, there, Vanishing::Multiplier(line.clone()));
        }
        self.take(next);
        self.branch.line = onward;
    }

    /// Where a function of the multipliers vanishes near a place, by a polynomial through orbits
    /// around it. Where another branch meets this one, Newton's matrix is singular, and no orbit
    /// can be computed next to it.
    fn interpolated(
        &self,
        line: &Line,
        length: f64,
        rough: f64,
        function: &Function<'_>,
    ) -> Option<Place> {
        // Spacing, as a fraction of the distance between the last two orbits, and number on each
        // side.
        const APART: f64 = 0.05;
        const EACH_WAY: i32 = 4;
        const FEWEST: usize = 5;
        let node = |s: f64, shooting: &Shooting<'_>| {
            let cycle = line.on(shooting, s)?;
            let value = function(&cycle)?;
            Some((value, Place::at(s, &cycle)))
        };
        let places = (-EACH_WAY..=EACH_WAY).filter(|k| *k != 0);
        let places = places.map(|k| rough + APART * length * f64::from(k));
        let nodes: Vec<(f64, Place)> = places.filter_map(|s| node(s, &self.shooting)).collect();
        if nodes.len() < FEWEST {
            return None;
        }
        let place = zero_of_polynomial(&nodes)?;
        // Without the farthest node, the polynomial's error shows; without the nearest, the
        // rounding error.
        let without_farthest = nodes.get(1..nodes.len() - 1).and_then(zero_of_polynomial);
        let mut nearest: Vec<f64> = nodes.iter().map(|(value, _)| value.abs()).collect();
        nearest.sort_by(f64::total_cmp);
        let is_apart = |node: &&(f64, Place)| node.0.abs() > nearest[1];
        let apart: Vec<(f64, Place)> = nodes.iter().filter(is_apart).cloned().collect();
        let both = without_farthest.zip(zero_of_polynomial(&apart));
        let off = |other: &Place| (place.parameter - other.parameter).abs();
        let lacks = both.map_or(f64::NAN, |(one, two)| off(&one) + off(&two));
        // The tolerances have the largest effect at the nearest node. Next to a multiplier of 1,
        // errors that differ between orbits amplify it.
        let by_tolerance = || {
            const SAFE: f64 = 8.0;
            let ((first, one), (last, other)) = (nodes.first()?, nodes.last()?);
            let options = &self.shooting.options.finer();
            let finer = Shooting {
                options,
                ..self.shooting
            };
            let nearest = nodes
                .iter()
                .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
            let (value, finer) = node(nearest.1.s, &finer)?;
            let slope = (last - first) / (other.parameter - one.parameter);
            let along = (finer.parameter - nearest.1.parameter).abs();
            Some(SAFE * (((value - nearest.0) / slope).abs() + along))
        };
        let uncertainty = lacks + by_tolerance().unwrap_or(f64::NAN);
        Some(Place {
            uncertainty,
            ..place
        })
    }

    /// The zero of a function by orbits around it, where these determine its parameter better: next
    /// to an orbit with a multiplier of 1, the closing error exceeds rounding.
    pub(super) fn refined(
        &self,
        line: &Line,
        zero: Zero,
        length: f64,
        function: &Function<'_>,
    ) -> Zero {
        const GOOD: f64 = 100.0;
        let options = self.shooting.options;
        if zero.uncertainty <= GOOD * options.rtol * self.branch.units.width {
            return zero;
        }
        match self.interpolated(line, length, zero.s, function) {
            Some(place) if is_better(place.uncertainty, zero.uncertainty) => Zero {
                parameter: place.parameter,
                uncertainty: place.uncertainty,
                ..zero
            },
            _ => zero,
        }
    }

    /// An uncertainty, at least what Newton's iteration leaves of a parameter's last digits. Where
    /// none is known, the place lies in the last step.
    pub(super) fn at_least(&self, parameter: f64, uncertainty: f64) -> f64 {
        let step = (self.parameter() - parameter_of(&self.branch.before)).abs();
        at_least((parameter, uncertainty), step, self.branch.units.width)
    }
}

/// Whether an uncertainty is less than another, which may be NaN.
fn is_better(one: f64, other: f64) -> bool {
    one < other || other.is_nan()
}

/// A place on the branch.
#[derive(Clone)]
struct Place {
    s: f64,
    parameter: f64,
    uncertainty: f64,
    /// A state on the orbit there.
    x: Vector,
    period: f64,
}

impl Place {
    fn at(s: f64, cycle: &Cycle) -> Self {
        Place {
            s,
            parameter: parameter_of(cycle),
            uncertainty: 0.0,
            x: cycle.anchor.x.clone(),
            period: cycle.period,
        }
    }

    fn of(zero: &Zero) -> Self {
        Place {
            uncertainty: zero.uncertainty,
            ..Place::at(zero.s, &zero.solution)
        }
    }
}

/// Where the interpolating polynomial of a function vanishes between two of its nodes.
fn zero_of_polynomial(nodes: &[(f64, Place)]) -> Option<Place> {
    let places: Vec<f64> = nodes.iter().map(|(_, place)| place.s).collect();
    let at = |s: f64, of: fn(&(f64, Place)) -> f64| -> f64 {
        let terms = weights(&places, s).into_iter().zip(nodes);
        terms.map(|(weight, node)| weight * of(node)).sum()
    };
    let value = |s: f64| at(s, |node| node.0);
    let mut pairs = nodes.windows(2);
    let ends = pairs.find(|two| two[0].0 * two[1].0 < 0.0)?;
    let [a, b] = [&ends[0], &ends[1]].map(|(value, place)| (place.s, *value));
    let s = zero_between(a, b, |s| Some(value(s)))?;
    let weighted = weights(&places, s).into_iter().zip(nodes);
    let nothing = Vector::zeros(nodes.first()?.1.x.len());
    let x = weighted.fold(nothing, |sum, (weight, (_, place))| sum + &place.x * weight);
    Some(Place {
        s,
        parameter: at(s, |node| node.1.parameter),
        uncertainty: 0.0,
        x,
        period: at(s, |node| node.1.period),
    })
}
