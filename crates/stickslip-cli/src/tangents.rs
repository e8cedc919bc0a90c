//! Tangent points of a contact's boundary, and where on it a contact sticks.
//!
//! Of a system of two states a boundary Σ is a curve, of more states a surface. It is looked at along one state: for every value of that the boundary's
//! own equation gives another one, and further states keep the values that they are given. There the rates at which the two fields
//! approach Σ are functions of one number. Where one of them vanishes a field is tangent to Σ; where both fields push to Σ the contact sticks.

use stickslip::analysis::Visibility;
use stickslip::scalar::Dual;
use stickslip::{Scalar, Side};

use crate::system::System;
use stickslip_kernels::expression::Tape;

/// How many values the range is divided into: two tangent points nearer than one of these are not told apart from none.
const FINENESS: usize = 2000;

/// Newton steps for the state that the boundary's equation gives.
const MOST_STEPS: usize = 50;

/// A line on the boundary of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Contact, counted from 0.
    pub contact: usize,
    /// State that goes along the line.
    pub along: usize,
    /// State that the boundary's equation gives.
    pub solved: usize,
    /// From where to where.
    pub range: (f64, f64),
    /// Time.
    pub t: f64,
    /// Values of the other states, and where to look for the solved one first.
    pub x: Vec<f64>,
}

/// Where a field is tangent to the boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentPoint {
    /// State.
    pub x: Vec<f64>,
    /// Side whose field is tangent.
    pub side: Side,
    /// How its orbit lies.
    pub visibility: Visibility,
}

/// What the boundary does to orbits in a part of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Both fields push to it: the contact sticks.
    Stick,
    /// Both fields lead away: no future is unique.
    Repelling,
}

/// A part of the line, by values of the state along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// What happens in it.
    pub kind: Kind,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
}

/// What was found on a line.
#[derive(Clone, Debug, PartialEq)]
pub struct OnLine {
    /// Tangent points of the fields of slip, by falling value of the state along the line.
    pub points: Vec<TangentPoint>,
    /// Zones of stick and of repulsion, by falling value.
    pub zones: Vec<Zone>,
    /// The state along the line, and at which rate the fields below and above go upwards through the boundary.
    pub rates: Vec<(f64, [f64; 2])>,
}

/// Which fields are asked.
#[derive(Clone, Copy)]
enum Fields {
    Slip,
    Holding,
}

/// By how much the boundary function's rate is larger with the field above than with that below. Friction makes it smaller.
pub struct Jumps {
    /// In slip.
    pub slip: f64,
    /// While the contact holds.
    pub holding: f64,
    /// What rounding leaves of the rates.
    pub rounding: f64,
}

impl Line {
    /// The line through a point of state space: of the state that the boundary changes with most the value is solved for; along is `along`, or the
    /// first other state. `None` where there is no other state, or the boundary changes with none.
    pub fn through(
        system: &System,
        contact: usize,
        along: Option<usize>,
        range: (f64, f64),
        (t, x): (f64, &[f64]),
    ) -> Option<Line> {
        let states = 0..system.states();
        let slope = |state: usize| system.boundary_and_slope(contact, t, x, state).1.abs();
        let solved = states
            .clone()
            .filter(|&state| Some(state) != along && slope(state) > 0.0)
            .max_by(|&a, &b| slope(a).total_cmp(&slope(b)))?;
        let along = along.or_else(|| states.clone().find(|&state| state != solved))?;
        Some(Line {
            contact,
            along,
            solved,
            range,
            t,
            x: x.to_vec(),
        })
    }

    /// Tangent points and zones on the line.
    pub fn scan(&self, system: &System) -> OnLine {
        let (low, high) = self.range;
        let mut rates = Vec::with_capacity(FINENESS + 1);
        let mut holding = Vec::with_capacity(FINENESS + 1);
        for k in 0..=FINENESS {
            let s = low + (high - low) * k as f64 / FINENESS as f64;
            if let Some(rate) = self.rates(system, Fields::Slip, s) {
                rates.push((s, rate));
            }
            if let Some(rate) = self.rates(system, Fields::Holding, s) {
                holding.push((s, rate));
            }
        }
        let mut points = Vec::new();
        let mut ends = vec![low, high];
        for (index, side) in [(0, Side::Below), (1, Side::Above)] {
            for s in self.roots(system, Fields::Slip, index, &rates) {
                if let Some(x) = self.state(system, s) {
                    let visibility = self.visibility(system, side, &x);
                    points.push(TangentPoint {
                        x,
                        side,
                        visibility,
                    });
                }
            }
            ends.extend(self.roots(system, Fields::Holding, index, &holding));
        }
        points.sort_by(|a, b| b.x[self.along].total_cmp(&a.x[self.along]));
        ends.sort_by(|a, b| b.total_cmp(a));
        let zone = |ends: &[f64]| {
            let (to, from) = (ends[0], ends[1]);
            let [below, above] = self.rates(system, Fields::Holding, 0.5 * (from + to))?;
            let kind = match (below > 0.0 && above < 0.0, below < 0.0 && above > 0.0) {
                (true, _) => Kind::Stick,
                (_, true) => Kind::Repelling,
                _ => return None,
            };
            Some(Zone { kind, from, to })
        };
        let zones = ends.windows(2).filter_map(zone).collect();
        OnLine {
            points,
            zones,
            rates,
        }
    }

    /// See [`Jumps`], where the state along the line is `s`.
    pub fn jumps(&self, system: &System, s: f64) -> Option<Jumps> {
        // Some operations of a field of some terms, each off by half a unit in the last place of the largest.
        const ULPS: f64 = 64.0;
        let [slip, holding] =
            [Fields::Slip, Fields::Holding].map(|fields| self.rates(system, fields, s));
        let (slip, holding) = (slip?, holding?);
        let largest = slip
            .iter()
            .chain(&holding)
            .fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let jump = |[below, above]: [f64; 2]| above - below;
        Some(Jumps {
            slip: jump(slip),
            holding: jump(holding),
            rounding: ULPS * f64::EPSILON * largest,
        })
    }

    /// The state on the boundary where the state along the line is `s`.
    fn state(&self, system: &System, s: f64) -> Option<Vec<f64>> {
        let mut x = self.x.clone();
        x[self.along] = s;
        for _ in 0..MOST_STEPS {
            let (height, slope) = system.boundary_and_slope(self.contact, self.t, &x, self.solved);
            if height == 0.0 {
                return Some(x);
            }
            let next = x[self.solved] - height / slope;
            if !next.is_finite() {
                return None;
            }
            // Nearer there is none.
            let close = 4.0 * f64::EPSILON * next.abs().max(f64::MIN_POSITIVE);
            let is_there = (next - x[self.solved]).abs() <= close;
            x[self.solved] = next;
            if is_there {
                return Some(x);
            }
        }
        None
    }

    /// How fast the fields below and above go upwards through the boundary.
    fn rates(&self, system: &System, fields: Fields, s: f64) -> Option<[f64; 2]> {
        let x = self.state(system, s)?;
        let rates = [Side::Below, Side::Above].map(|side| {
            let tape = self.field(system, fields, side, &x);
            let velocity = rates_of(tape, self.t, &x);
            let moving: Vec<Dual<f64>> = x
                .iter()
                .zip(&velocity)
                .map(|(&x, &v)| Dual::new(x, v))
                .collect();
            system
                .boundary_of(self.contact, Dual::new(self.t, 1.0), &moving)
                .eps
        });
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    }

    /// The field with the contact on this side and the others where the state has them.
    fn field<'a>(&self, system: &'a System, fields: Fields, side: Side, x: &[f64]) -> &'a Tape {
        let mut above = 0;
        for contact in 0..system.contacts() {
            let is_above = if contact == self.contact {
                side == Side::Above
            } else {
                system.height(contact, self.t, x) > 0.0
            };
            above |= usize::from(is_above) << contact;
        }
        let held = system.built.fields.holding.get(1 << self.contact);
        match (fields, held) {
            (Fields::Holding, Some(holding)) => &holding[above],
            _ => &system.built.fields.slip[above],
        }
    }

    /// Where the rate of one side changes its sign, by bisection to neighbouring numbers.
    fn roots(
        &self,
        system: &System,
        fields: Fields,
        side: usize,
        sampled: &[(f64, [f64; 2])],
    ) -> Vec<f64> {
        let mut roots = Vec::new();
        let mut last: Option<(f64, f64)> = None;
        for &(s, rates) in sampled {
            let rate = rates[side];
            if rate == 0.0 {
                continue;
            }
            if let Some((before, rate_before)) = last
                && rate * rate_before < 0.0
            {
                roots.push(self.root(system, fields, side, (before, s), rate_before));
            }
            last = Some((s, rate));
        }
        roots
    }

    fn root(
        &self,
        system: &System,
        fields: Fields,
        side: usize,
        (mut a, mut b): (f64, f64),
        rate_at_a: f64,
    ) -> f64 {
        loop {
            let middle = 0.5 * (a + b);
            if middle <= a || middle >= b {
                return b;
            }
            match self.rates(system, fields, middle) {
                Some(rates) if rates[side] == 0.0 => return middle,
                Some(rates) if rates[side] * rate_at_a > 0.0 => a = middle,
                _ => b = middle,
            }
        }
    }

    /// By the sign of the second derivative of the boundary function along the field.
    fn visibility(&self, system: &System, side: Side, x: &[f64]) -> Visibility {
        let tape = self.field(system, Fields::Slip, side, x);
        let velocity = rates_of(tape, self.t, x);
        let moving: Vec<Dual<f64>> = x
            .iter()
            .zip(&velocity)
            .map(|(&x, &v)| Dual::new(x, v))
            .collect();
        let mut rates = vec![Dual::zero(); x.len()];
        tape.evaluate(Dual::new(self.t, 1.0), &moving, &mut rates);
        let twice: Vec<Dual<Dual<f64>>> = moving
            .iter()
            .zip(&rates)
            .map(|(&x, &v)| Dual::new(x, v))
            .collect();
        let time = Dual::new(Dual::new(self.t, 1.0), Dual::one());
        let bending = system.boundary_of(self.contact, time, &twice).eps.eps;
        // What is left of two terms of the acceleration that cancel.
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

/// The rates of all states.
fn rates_of(field: &Tape, t: f64, x: &[f64]) -> Vec<f64> {
    let mut rates = vec![f64::NAN; x.len()];
    field.evaluate(t, x, &mut rates);
    rates
}

impl System {
    /// The boundary function of a contact on any number.
    fn boundary_of<T: Scalar>(&self, contact: usize, t: T, x: &[T]) -> T {
        let mut heights = vec![T::zero(); self.contacts()];
        self.built.boundaries.evaluate(t, x, &mut heights);
        heights[contact]
    }

    /// The boundary function of a contact, and its derivative by one state.
    fn boundary_and_slope(&self, contact: usize, t: f64, x: &[f64], state: usize) -> (f64, f64) {
        let seeded: Vec<Dual<f64>> = x
            .iter()
            .enumerate()
            .map(|(k, &x)| Dual::new(x, if k == state { 1.0 } else { 0.0 }))
            .collect();
        let height = self.boundary_of(contact, Dual::constant(t), &seeded);
        (height.re, height.eps)
    }
}
