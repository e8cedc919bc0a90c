//! How well the phases of a periodic orbit are determined: next to one with a multiplier of 1, rounding leaves its state open.

use super::circuit::Circuit;
use super::locate::is_same;
use super::margin::Margin;
use crate::analysis::anchor::Anchor;
use crate::dynamics::{Dynamics, Matrix, Vector, run};
use crate::filippov::Options;
use crate::math;

/// A state that may be off by less than this part of how far its components go is as good as known.
pub(super) const LEAST: f64 = 1e-11;

/// One closes as well as the orbit if its gap is no larger than so many times what is left of that.
const CLOSED: f64 = 2.0;

/// Doublings of the smallest displacement: where the return map is curved, as next to a branch point, more closes than by the linear estimate, or less.
const DOUBLINGS: i32 = 32;

/// How an orbit closes, of which the first so many components are states, and the others are given.
#[derive(Clone, Debug)]
pub(crate) struct Closing {
    pub states: usize,
    /// The derivative of the flow map over the period.
    pub matrix: Matrix,
    /// The vector that moves the start, along which an orbit of a system that does not depend on time closes anyway.
    pub flow: Option<Vector>,
    /// What rounding may leave of the gap, and what the tolerances may have the return map off by.
    pub by_rounding: Vector,
    pub by_tolerance: Vector,
    /// Dimension of the family of orbits that it is one of.
    pub family: usize,
}

/// Where a singular value of the return map less one is below this, other orbits near by close within what the tolerances do; above it the map that is computed
/// has an orbit of its own, with phases of its own.
const NEARLY_SINGULAR: f64 = 1e-2;

/// Margins of more than so many times what the state may be off by are not touched by it.
const CLEAR: f64 = 1e3;

/// A direction in which a state and its period may be off, for a displacement of length 1 in parts of how far the components go.
struct Direction {
    x: Vector,
    period: f64,
    /// By how much the orbit may be off, by the linear estimate: what rounding leaves, and that with what the tolerances do.
    by_rounding: f64,
    both: f64,
}

impl Closing {
    /// The directions in which the orbit may be off by more than [`LEAST`], where rounding leaves so much of its gap, and the tolerances as much with it, in parts of
    /// how far the components go.
    /// Those of a family are left out, as a Newton step leaves them out.
    fn open(&self, sizes: &Vector, by_rounding: f64, both: f64) -> Vec<Direction> {
        let states = self.states;
        let unknowns = states + usize::from(self.flow.is_some());
        let mut matrix = Matrix::zeros(unknowns, unknowns);
        for i in 0..states {
            for j in 0..states {
                let own = f64::from(u8::from(i == j));
                matrix[(i, j)] = (self.matrix[(i, j)] - own) * (sizes[j] / sizes[i]);
            }
        }
        let mut speed = 1.0;
        if let Some(flow) = &self.flow {
            let flow = flow.component_div(sizes);
            speed = flow.rows(0, states).norm();
            for i in 0..states {
                matrix[(i, states)] = flow[i] / speed;
                matrix[(states, i)] = flow[i] / speed;
            }
        }
        if !(both.is_finite() && matrix.iter().all(|v| v.is_finite())) {
            return Vec::new();
        }
        let parts = matrix.svd(false, true);
        let mut sizes_of_all: Vec<f64> = parts.singular_values.iter().copied().collect();
        sizes_of_all.sort_by(f64::total_cmp);
        let of_family = sizes_of_all.iter().take(self.family);
        let rounding = unknowns as f64 * f64::EPSILON * parts.singular_values.max();
        let bound = of_family.copied().fold(rounding, f64::max);
        let Some(directions) = parts.v_t else {
            return Vec::new();
        };
        let values = parts.singular_values.iter().zip(directions.row_iter());
        let values = values.filter(|(value, _)| **value > bound);
        let directions = values.map(|(&value, row)| Direction {
            x: Vector::from_fn(sizes.len(), |i, _| match i < states {
                true => row[i] * sizes[i],
                false => 0.0,
            }),
            period: if unknowns > states {
                row[states] / speed
            } else {
                0.0
            },
            by_rounding: by_rounding / value,
            both: if value < NEARLY_SINGULAR {
                both / value
            } else {
                by_rounding / value
            },
        });
        directions.filter(|one| one.both > LEAST).collect()
    }
}

impl Circuit {
    /// Notes by how much the margins may be off, and whether the phases may be others, for an orbit that was followed from `start`.
    pub fn that_closes(
        mut self,
        system: &dyn Dynamics,
        start: &Anchor,
        closing: &Closing,
        options: &Options,
    ) -> Self {
        let extent = self.extent;
        let sizes = self
            .sizes
            .map(|size| if size > 0.0 { size } else { extent });
        let part = |left: &Vector| {
            let parts = left.component_div(&sizes);
            parts.rows(0, closing.states).amax()
        };
        let by_rounding = part(&closing.by_rounding);
        let both = by_rounding.max(part(&closing.by_tolerance));
        let sequence = self.sequence();
        let nearest = self.margins.iter().map(Margin::relative);
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        for direction in closing.open(&sizes, by_rounding, both) {
            if CLEAR * direction.both < nearest {
                for margin in &mut self.margins {
                    let off = [direction.by_rounding, direction.both].map(|off| off * margin.scale);
                    margin.by_rounding = margin.by_rounding.max(off[0]);
                    margin.off = margin.off.max(off[1]);
                }
                continue;
            }
            for sign in [1.0, -1.0] {
                let displaced = |left: f64| {
                    let closes = |gap: &Vector| {
                        let gap = gap.component_div(&sizes);
                        gap.rows(0, closing.states).amax() <= CLOSED * left
                    };
                    let (moved, period) =
                        self.farthest(system, start, (&direction, sign), options, closes)?;
                    let there = Circuit::follow(system, &moved, period, options);
                    Some(there.ok().filter(|one| is_same(&one.sequence(), &sequence)))
                };
                let by_rounding = displaced(by_rounding);
                // Away from 1 the tolerances leave nothing open.
                let both = if direction.both > direction.by_rounding {
                    displaced(both)
                } else {
                    by_rounding.clone()
                };
                let Some(both) = both else { continue };
                self.is_certain &= both.is_some();
                let known = [by_rounding.flatten(), both];
                for margin in &mut self.margins {
                    let off = known.each_ref().map(|there| {
                        let there = there.as_ref()?.margin_like(margin)?;
                        Some((there.value - margin.value).abs())
                    });
                    margin.by_rounding = margin.by_rounding.max(off[0].unwrap_or(0.0));
                    let off = off[1].or(off[0]).unwrap_or(0.0);
                    margin.off = margin.off.max(off).max(margin.by_rounding);
                }
            }
        }
        self
    }

    /// The state and period farthest away in a direction, one way, by doublings of [`LEAST`], from which an orbit closes so well.
    fn farthest(
        &self,
        system: &dyn Dynamics,
        start: &Anchor,
        (direction, sign): (&Direction, f64),
        options: &Options,
        closes: impl Fn(&Vector) -> bool,
    ) -> Option<(Anchor, f64)> {
        let displaced = |by: f64| {
            let moved = start.moved(&start.x + &direction.x * by).settled(system);
            let period = self.period + direction.period * by;
            let t_end = moved.t + period;
            let end = run(system, &moved, t_end, options).ok()?;
            closes(&(end.x - &moved.x)).then_some((moved, period))
        };
        let ways = (0..DOUBLINGS).map(|k| sign * LEAST * math::powi(2.0, k));
        ways.map_while(displaced).last()
    }
}
