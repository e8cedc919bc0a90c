//! Tangent points and stick zones on the boundary of a contact.
//!
//! The boundary Σ is a curve in a system of two states, and a surface for more states. It is
//! scanned along one state. For every value of that state, the equation of the boundary determines
//! another one; further states have fixed values. The equation may have several solutions or none.
//! Each solution is followed as a branch to the points where Σ turns back. On a branch, the rates
//! at which the two fields approach Σ are functions of one variable. Where one rate vanishes, a
//! field is tangent to Σ. Where both fields point towards Σ, the contact sticks.

use numerics::bisect;
use stickslip::Visibility;
use stickslip::scalar::Dual;
use stickslip::{Scalar, Side};

use crate::file::System;
use crate::kernel::Combination;

/// Number of intervals in the range. It is chosen: two tangent points within one interval are not
/// detected.
const LINE_INTERVALS: usize = 2000;

/// Number of intervals in the window of the solved state. It is chosen: two branches within one of
/// them may be missed.
const WINDOW_INTERVALS: usize = 64;

/// Values of the solved state count as equal if they differ by less than this, relative to their
/// size and the window. It is the square root of rounding, as at a turning point.
const BRANCH_DISTANCE: f64 = 1e-7;

/// Values of the state along the line and of the solved state.
pub type LinePoint = [f64; 2];

/// Maximum number of Newton steps for the solved state. From a turning point each step halves the
/// distance, and 50 halvings reach rounding.
const MOST_NEWTON_STEPS: usize = 50;

/// A line on the boundary of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLine {
    /// Contact, counted from 0.
    pub contact: usize,
    /// State that varies along the line.
    pub along: usize,
    /// State for which the equation of the boundary is solved.
    pub solved: usize,
    /// Range of the state along the line.
    pub range: (f64, f64),
    /// Time.
    pub t: f64,
    /// Values of the other states, and the initial guess for the solved one.
    pub x: Vec<f64>,
    /// Points of a branch, by rising value; empty if no branch is chosen.
    pub path: Vec<LinePoint>,
}

/// Point at which a field is tangent to the boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentPoint {
    /// State.
    pub x: Vec<f64>,
    /// Side whose field is tangent.
    pub side: Side,
    /// Whether the tangent orbit is visible.
    pub visibility: Visibility,
}

/// Behaviour of orbits at the boundary, in a part of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// Both fields point towards the boundary: the contact sticks.
    Stick,
    /// Both fields point away: the future is not unique.
    Repelling,
}

/// A part of the line, by values of the state along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Behaviour of orbits in the zone.
    pub kind: ZoneKind,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
}

/// Results on a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineResults {
    /// Tangent points of the fields of slip, by falling value of the state along the line.
    pub points: Vec<TangentPoint>,
    /// Zones of stick and of repulsion, by falling value.
    pub zones: Vec<Zone>,
    /// The state along the line, and the rates of the boundary function with the fields below and
    /// above.
    pub rates: Vec<(f64, [f64; 2])>,
}

/// Choice of the fields to evaluate.
#[derive(Clone, Copy)]
enum FieldChoice {
    Slip,
    Holding,
}

/// Difference of the rate of the boundary function between the field above and the field below.
/// Friction makes it negative.
pub struct RateJumps {
    /// Difference in slip.
    pub slip: f64,
    /// Difference while the contact holds.
    pub holding: f64,
    /// Rounding error of the rates.
    pub rounding: f64,
}

impl BoundaryLine {
    /// The line through a point of state space. The solved state is the one on which the boundary
    /// function depends most. The line follows the state `along`, or the first other state. `None`
    /// if there is no other state, or the boundary function depends on no state.
    pub fn through(
        system: &System,
        contact: usize,
        along: Option<usize>,
        range: (f64, f64),
        (t, x): (f64, &[f64]),
    ) -> Option<BoundaryLine> {
        let states = 0..system.states();
        // The gradient vanishes in the middle of a closed boundary, so a nearby point is tried.
        let beside: Vec<f64> = x.iter().map(|x| x + 1.0).collect();
        let slope = |state: usize| {
            let of = |x: &[f64]| system.boundary_and_slope(contact, t, x, state).1.abs();
            of(x).max(f64::MIN_POSITIVE * of(&beside))
        };
        let solved = states
            .clone()
            .filter(|&state| Some(state) != along && slope(state) > 0.0)
            .max_by(|&a, &b| slope(a).total_cmp(&slope(b)))?;
        let along = along.or_else(|| states.clone().find(|&state| state != solved))?;
        Some(BoundaryLine {
            contact,
            along,
            solved,
            range,
            t,
            x: x.to_vec(),
            path: Vec::new(),
        })
    }

    /// The branches of the boundary, each as a line over its own range, in the order of their lower
    /// ends, with the results on them. Branches are searched in a window of the solved state: its
    /// range in the file, or else as far from the start as the range is wide. Newton's iteration
    /// from the start may locate further ones.
    pub fn scan(&self, system: &System) -> Vec<(BoundaryLine, LineResults)> {
        let (start, width) = (self.x[self.solved], self.range.1 - self.range.0);
        let shown = system.file.states[self.solved].range;
        let (low, high) = shown.unwrap_or((start - width, start + width));
        let (low, high) = (low.min(start), high.max(start));
        let parts = |from: f64, to: f64, parts: usize| -> Vec<f64> {
            let part = |k| from + (to - from) * k as f64 / parts as f64;
            (0..=parts).map(part).collect()
        };
        let along = parts(self.range.0, self.range.1, LINE_INTERVALS);
        let across = parts(low, high, WINDOW_INTERVALS);
        let is_same = |a: LinePoint, b: LinePoint| {
            (a[1] - b[1]).abs() <= BRANCH_DISTANCE * (a[1].abs() + (high - low))
        };
        let mut paths: Vec<Vec<LinePoint>> = Vec::new();
        for (k, &s) in along.iter().enumerate() {
            let height = |&y: &f64| (y, self.boundary(system, [s, y]).0);
            let heights: Vec<(f64, f64)> = across.iter().map(height).collect();
            let changes = heights.windows(2).filter(|two| two[0].1 * two[1].1 <= 0.0);
            let guesses = changes
                .map(|two| 0.5 * (two[0].0 + two[1].0))
                .chain([start]);
            for seed in guesses.filter_map(|y| self.solve(system, [s, y])) {
                let passes = |path: &Vec<LinePoint>| {
                    let there = path.binary_search_by(|at| at[0].total_cmp(&s));
                    there.is_ok_and(|there| is_same(path[there], seed))
                };
                if !paths.iter().any(passes) {
                    let mut path = self.follow(system, seed, along[..k].iter().rev(), is_same);
                    path.reverse();
                    path.push(seed);
                    path.extend(self.follow(system, seed, along[k + 1..].iter(), is_same));
                    paths.push(path);
                }
            }
        }
        paths.retain(|path| path.len() > 1);
        paths.sort_by(|a, b| {
            a[0][0]
                .total_cmp(&b[0][0])
                .then(a[0][1].total_cmp(&b[0][1]))
        });
        let lines = paths.into_iter().map(|path| {
            let range = (path[0][0], path[path.len() - 1][0]);
            let line = BoundaryLine {
                range,
                path,
                ..self.clone()
            };
            let found = line.on_branch(system);
            (line, found)
        });
        lines.collect()
    }

    /// Follows the branch from a point, at these values and up to its end.
    fn follow<'a>(
        &self,
        system: &System,
        mut at: LinePoint,
        values: impl Iterator<Item = &'a f64>,
        is_same: impl Fn(LinePoint, LinePoint) -> bool,
    ) -> Vec<LinePoint> {
        // The slope must keep its sign, and the iteration must lead back to the previous point.
        // Otherwise the result may be on another branch.
        let next = |at: LinePoint, s: f64| {
            let next = self.solve(system, [s, at[1]])?;
            let back = self.solve(system, [at[0], next[1]])?;
            let slopes = self.boundary(system, next).1 * self.boundary(system, at).1;
            (slopes > 0.0 && is_same(back, at)).then_some(next)
        };
        let mut points = Vec::new();
        for &s in values {
            if let Some(there) = next(at, s) {
                at = there;
                points.push(at);
                continue;
            }
            let seen = at;
            bisect(seen[0], s, |middle| match next(at, middle) {
                Some(there) => {
                    at = there;
                    false
                }
                None => true,
            });
            points.extend((at != seen).then_some(at));
            break;
        }
        points
    }

    /// Tangent points and zones on a branch.
    fn on_branch(&self, system: &System) -> LineResults {
        let (low, high) = self.range;
        let [rates, holding] = [FieldChoice::Slip, FieldChoice::Holding].map(|fields| {
            let along = self.path.iter().map(|at| at[0]);
            let rates = along.filter_map(|s| Some((s, self.rates(system, fields, s)?)));
            rates.collect::<Vec<_>>()
        });
        let mut points = Vec::new();
        let mut ends = vec![low, high];
        for (index, side) in [(0, Side::Below), (1, Side::Above)] {
            for s in self.roots(system, FieldChoice::Slip, index, &rates) {
                if let Some(x) = self.state(system, s) {
                    let visibility = self.visibility(system, side, &x);
                    points.push(TangentPoint {
                        x,
                        side,
                        visibility,
                    });
                }
            }
            ends.extend(self.roots(system, FieldChoice::Holding, index, &holding));
        }
        points.sort_by(|a, b| b.x[self.along].total_cmp(&a.x[self.along]));
        ends.sort_by(|a, b| b.total_cmp(a));
        let zone = |ends: &[f64]| {
            let (to, from) = (ends[0], ends[1]);
            let [below, above] = self.rates(system, FieldChoice::Holding, 0.5 * (from + to))?;
            let kind = match (below > 0.0 && above < 0.0, below < 0.0 && above > 0.0) {
                (true, _) => ZoneKind::Stick,
                (_, true) => ZoneKind::Repelling,
                _ => return None,
            };
            Some(Zone { kind, from, to })
        };
        let zones = ends.windows(2).filter_map(zone).collect();
        LineResults {
            points,
            zones,
            rates,
        }
    }

    /// [`RateJumps`] where the state along the line is `s`.
    pub fn jumps(&self, system: &System, s: f64) -> Option<RateJumps> {
        // Allows for some operations on the terms of a field, each with an error of half a unit in
        // the last place of the largest.
        const RATE_ULPS: f64 = 64.0;
        let [slip, holding] =
            [FieldChoice::Slip, FieldChoice::Holding].map(|fields| self.rates(system, fields, s));
        let (slip, holding) = (slip?, holding?);
        let largest = slip
            .iter()
            .chain(&holding)
            .fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let jump = |[below, above]: [f64; 2]| above - below;
        Some(RateJumps {
            slip: jump(slip),
            holding: jump(holding),
            rounding: RATE_ULPS * f64::EPSILON * largest,
        })
    }

    /// The state on the boundary where the state along the line is `s`.
    fn state(&self, system: &System, s: f64) -> Option<Vec<f64>> {
        let next = self.path.partition_point(|at| at[0] < s).max(1);
        let guess = match (self.path.get(next - 1), self.path.get(next)) {
            (Some(a), Some(b)) => a[1] + (s - a[0]) / (b[0] - a[0]) * (b[1] - a[1]),
            _ => self.x[self.solved],
        };
        Some(self.at(self.solve(system, [s, guess])?))
    }

    fn at(&self, at: LinePoint) -> Vec<f64> {
        let mut x = self.x.clone();
        (x[self.along], x[self.solved]) = (at[0], at[1]);
        x
    }

    /// The boundary function, and its derivative with respect to the solved state.
    fn boundary(&self, system: &System, at: LinePoint) -> (f64, f64) {
        system.boundary_and_slope(self.contact, self.t, &self.at(at), self.solved)
    }

    /// Solves for the solved state by Newton's iteration from `at`.
    fn solve(&self, system: &System, mut at: LinePoint) -> Option<LinePoint> {
        for _ in 0..MOST_NEWTON_STEPS {
            let (height, slope) = self.boundary(system, at);
            if height == 0.0 {
                return Some(at);
            }
            let next = at[1] - height / slope;
            if !next.is_finite() {
                return None;
            }
            // Rounding prevents a smaller step.
            let close = 4.0 * f64::EPSILON * next.abs().max(f64::MIN_POSITIVE);
            let is_there = (next - at[1]).abs() <= close;
            at[1] = next;
            if is_there {
                return Some(at);
            }
        }
        None
    }

    /// Rates of the boundary function with the fields below and above.
    fn rates(&self, system: &System, fields: FieldChoice, s: f64) -> Option<[f64; 2]> {
        let x = self.state(system, s)?;
        let rates = [Side::Below, Side::Above].map(|side| {
            let velocity = self.velocity(system, (fields, side), &x, (self.t, &x[..]));
            let (time, moving) = (Dual::new(self.t, 1.0), moving(&x, &velocity));
            system.boundary(self.contact, time, &moving).eps
        });
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    }

    /// The velocity with the contact on this side. The modes of other contacts follow from the
    /// state.
    fn velocity<T: Scalar>(
        &self,
        system: &System,
        (fields, side): (FieldChoice, Side),
        at: &[f64],
        (t, x): (T, &[T]),
    ) -> Vec<T> {
        let mut above = 0;
        for contact in 0..system.contacts() {
            let is_above = if contact == self.contact {
                side == Side::Above
            } else {
                system.boundary(contact, self.t, at) > 0.0
            };
            above |= usize::from(is_above) << contact;
        }
        let held = match fields {
            FieldChoice::Holding if system.built.has_static => 1 << self.contact,
            _ => 0,
        };
        system.field(Combination { above, held }, t, x)
    }

    /// Zeros of the rate of one side with a change of sign, by bisection.
    fn roots(
        &self,
        system: &System,
        fields: FieldChoice,
        side: usize,
        sampled: &[(f64, [f64; 2])],
    ) -> Vec<f64> {
        let root = |((a, rate_at_a), (b, _)): ((f64, f64), (f64, f64))| {
            bisect(a, b, |s| {
                let rates = self.rates(system, fields, s);
                rates.is_none_or(|rates| rates[side] * rate_at_a <= 0.0)
            })
        };
        let rates = sampled.iter().map(|(s, rates)| (*s, rates[side]));
        let rates: Vec<(f64, f64)> = rates.filter(|(_, rate)| *rate != 0.0).collect();
        let pairs = rates.iter().copied().zip(rates.iter().copied().skip(1));
        let changes = pairs.filter(|((_, before), (_, rate))| rate * before < 0.0);
        changes.map(root).collect()
    }

    /// Visibility, from the sign of the second derivative of the boundary function along the field.
    fn visibility(&self, system: &System, side: Side, x: &[f64]) -> Visibility {
        let of = (FieldChoice::Slip, side);
        let velocity = self.velocity(system, of, x, (self.t, x));
        let once = moving(x, &velocity);
        let rates = self.velocity(system, of, x, (Dual::new(self.t, 1.0), &once[..]));
        let (time, twice) = (Dual::new(self.t, 1.0), moving(&once, &rates));
        let time = Dual::new(time, Dual::one());
        let bending = system.boundary(self.contact, time, &twice).eps.eps;
        // Rounding error that remains if two terms of the acceleration cancel.
        let size: f64 = rates.iter().map(|rate| rate.eps.abs()).fold(1.0, f64::max);
        if bending.abs() <= 64.0 * f64::EPSILON * size {
            Visibility::Degenerate
        } else if bending * side.sign() > 0.0 {
            Visibility::Visible
        } else {
            Visibility::Invisible
        }
    }
}

/// A state whose dual part is a velocity.
fn moving<T: Scalar>(x: &[T], velocity: &[T]) -> Vec<Dual<T>> {
    let pairs = x.iter().zip(velocity);
    pairs.map(|(&x, &v)| Dual::new(x, v)).collect()
}
