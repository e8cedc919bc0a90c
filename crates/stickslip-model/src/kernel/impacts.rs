//! Newton's law of restitution at stops that close or touch.
//!
//! The impulses `P ≥ 0` and the rates of the gaps after them, `u⁺ = u⁻ + G P`, are complementary:
//! `w ≥ 0` with `P·w = 0`. If a gap closes, `w = u⁺ + e u⁻`; else `w = u⁺`.
//!
//! Sources: Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, CISM 302
//! (1988); Glocker, *Set-Valued Force Laws*, 2001, Sect. 9.

use std::sync::Arc;

use stickslip::Scalar;

use crate::expression::Tape;

/// A gap counts as closed, and a rate as zero, up to this part of the sizes of its terms. It is
/// some thousand units in the last place: the rounding of a sum of as many terms.
pub(crate) const ROUNDING: f64 = 1e-12;

/// The law of impact of the stops of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Impacts {
    /// Numbers of each stop: gap, its size, rate, its size, restitution, and the part of a unit of
    /// impulse at each stop in the rate. Then, for each stop, what a unit of impulse adds to each
    /// state, and the direction in which the state opens the gap by one.
    pub parts: Tape,
    /// The discrete state of each stop: 1 while it carries.
    pub closed: Vec<usize>,
    /// Number of states.
    pub states: usize,
}

/// A stop at an impact.
pub(crate) struct Touching<T> {
    /// Number of the stop.
    pub stop: usize,
    gap: T,
    rate: T,
    /// Restitution.
    pub restitution: T,
    /// Size of the terms of the rate.
    size: f64,
    /// The error in the rate of a gap that is closed, which is no motion.
    left: f64,
    /// Whether the stop carries.
    carries: bool,
    /// Whether it carries after a landing: that stop, and those that carried before. A reaction
    /// that then would pull ends at once.
    lands: bool,
    /// What a unit of impulse at each stop adds to the rate.
    pub coupling: Vec<T>,
}

impl<T: Scalar> Touching<T> {
    /// Whether the body comes nearer to a stop that is open.
    fn bounces(&self) -> bool {
        self.rate.value() < 0.0 && !self.carries && !self.lands
    }

    /// Whether the restitution is between 0 and 1. A stop that separates gives nothing back, and
    /// has no speed of approach.
    pub(crate) fn has_restitution(&self) -> bool {
        !self.bounces() || (0.0..=1.0).contains(&self.restitution.value())
    }

    /// The rate that the law compares with, without impulses.
    fn wanted(&self) -> T {
        match self.bounces() {
            true => self.rate + self.restitution * self.rate,
            false => self.rate,
        }
    }

    /// The impulse that removes the error in the rate.
    fn impulse_of_error(&self) -> f64 {
        (self.left / self.coupling[self.stop].value()).abs()
    }
}

/// Event to which stops react.
enum ImpactCause {
    /// The impact of a stop.
    Impact(usize),
    /// The landing of a stop.
    Landing(usize),
    /// The lift-off from a stop. Others that have let go in the same instant take no part.
    LiftOff(usize),
    /// A jump, and by how much it has changed the rate of each gap.
    Jump(Vec<f64>),
}

/// An impact: the stops that take part, and their impulses if some follow the law.
struct Strike<T> {
    touching: Vec<Touching<T>>,
    impulses: Option<Vec<Option<T>>>,
    /// The numbers of [`Impacts::parts`].
    parts: Vec<T>,
}

/// Numbers of a stop before those of its couplings.
const OF_STOP: usize = 5;

impl Impacts {
    /// The law with other values of the held numbers of its graph.
    #[must_use]
    pub fn with_held(&self, held: &Arc<[f64]>) -> Self {
        Impacts {
            parts: self.parts.with_held(held),
            closed: self.closed.clone(),
            states: self.states,
        }
    }

    fn evaluated<T: Scalar>(&self, t: T, x: &[T]) -> Vec<T> {
        let count = self.closed.len();
        let mut parts = vec![T::zero(); count * (OF_STOP + count + 2 * self.states)];
        self.parts.evaluate(t, x, &mut parts);
        parts
    }

    /// Opens the stops whose gaps a jump has changed. Returns by how much it has changed the rate
    /// of each gap; zero where that is rounding.
    fn release<T: Scalar>(&self, t: T, before: &[T], x: &mut [T]) -> Vec<f64> {
        let width = OF_STOP + self.closed.len();
        let [old, new] = [before, &*x].map(|x| self.evaluated(t, x));
        let moved = |place: usize| {
            let [of, size] = [place, place + 1].map(|place| new[place].value());
            let moved = of - old[place].value();
            if moved.abs() > ROUNDING * size {
                moved
            } else {
                0.0
            }
        };
        let closed = self.closed.iter().enumerate();
        closed
            .map(|(stop, &closed)| {
                if moved(stop * width) != 0.0 {
                    x[closed] = T::zero();
                }
                moved(stop * width + 2)
            })
            .collect()
    }

    /// Whether each stop carries in a state.
    pub fn carrying<T: Scalar>(&self, x: &[T]) -> Vec<bool> {
        let closed = self.closed.iter();
        closed.map(|&closed| x[closed].value() > 0.5).collect()
    }

    /// The states after the impact of a stop. Not a number where no impulses follow the law, or a
    /// restitution is not between 0 and 1.
    pub fn strike<T: Scalar>(&self, stop: usize, t: T, x: &mut [T]) {
        self.changed(&ImpactCause::Impact(stop), t, x);
    }

    /// The states after a jump from a state before it, which may move what closed stops carry. Not
    /// a number as at an impact.
    pub fn settle<T: Scalar>(&self, t: T, before: &[T], x: &mut [T]) {
        let kicks = self.release(t, before, x);
        self.changed(&ImpactCause::Jump(kicks), t, x);
    }

    /// The states after a stop has let go.
    pub fn lift_off<T: Scalar>(&self, stop: usize, t: T, x: &mut [T]) {
        self.changed(&ImpactCause::LiftOff(stop), t, x);
        x[self.closed[stop]] = T::zero();
    }

    /// The states after the landing of a stop: its gap and the rate of that are zero. The rate
    /// vanishes by an impulse, which other closed stops share. The gap vanishes along the motion
    /// that follows an impulse. So the derivative is that of infinitely many impacts.
    pub fn land<T: Scalar>(&self, stop: usize, t: T, x: &mut [T]) {
        self.changed(&ImpactCause::Landing(stop), t, x);
    }

    /// The impulses of all stops at an impact or a landing.
    pub fn impulses(&self, stop: usize, lands: bool, t: f64, x: &[f64]) -> Vec<f64> {
        let cause = match lands {
            true => ImpactCause::Landing(stop),
            false => ImpactCause::Impact(stop),
        };
        self.impulses_of(&cause, t, x)
    }

    /// The impulses of all stops behind a jump from a state before it.
    pub fn impulses_behind(&self, t: f64, before: &[f64], x: &mut [f64]) -> Vec<f64> {
        let kicks = self.release(t, before, x);
        self.impulses_of(&ImpactCause::Jump(kicks), t, x)
    }

    /// The stops that take part in the impact of one of them.
    pub(crate) fn touching(&self, stop: usize, t: f64, x: &[f64]) -> Vec<Touching<f64>> {
        let strike = self.struck(&ImpactCause::Impact(stop), t, x);
        strike.map_or_else(Vec::new, |strike| strike.touching)
    }

    fn impulses_of(&self, cause: &ImpactCause, t: f64, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.closed.len()];
        if let Some(Strike {
            touching,
            impulses: Some(impulses),
            ..
        }) = self.struck(cause, t, x)
        {
            for (one, impulse) in touching.iter().zip(impulses) {
                all[one.stop] = impulse.unwrap_or(0.0);
            }
        }
        all
    }

    fn changed<T: Scalar>(&self, cause: &ImpactCause, t: T, x: &mut [T]) {
        let Some(Strike {
            touching, parts, ..
        }) = self.struck(cause, t, x)
        else {
            return;
        };
        // What location leaves of the gaps would displace all later impacts.
        let rows = |parts: &[T], stop: usize| {
            let (count, states) = (self.closed.len(), self.states);
            let first = count * (OF_STOP + count) + 2 * stop * states;
            let [acts, ways] = [0, 1].map(|row| first + row * states);
            [acts, ways].map(|row| parts[row..row + states].to_vec())
        };
        for (one, shift) in touching.iter().zip(shifts(&touching)) {
            let [_, ways] = rows(&parts, one.stop);
            for (x, way) in x.iter_mut().zip(ways) {
                *x = *x - way * shift;
            }
        }
        // The rates are those at closed gaps.
        let Some(strike) = self.struck(cause, t, x) else {
            return;
        };
        let Some(impulses) = strike.impulses else {
            x.fill(T::constant(f64::NAN));
            return;
        };
        let (parts, touching) = (strike.parts, strike.touching);
        for (one, impulse) in touching.iter().zip(&impulses) {
            let [acts, _] = rows(&parts, one.stop);
            for (x, acts) in x.iter_mut().zip(acts) {
                if let Some(impulse) = *impulse {
                    *x = *x + acts * impulse;
                }
            }
        }
        for (one, impulse) in touching.iter().zip(&impulses) {
            let (after, size) = rate_after(one, &touching, &impulses);
            let is_pressed = one.carries && impulse.is_some();
            let moves = (after.value() - one.left).abs() > ROUNDING * size;
            let closes = one.lands || is_pressed || !moves;
            x[self.closed[one.stop]] = if closes { T::one() } else { T::zero() };
        }
    }

    /// The stops that take part in an impact and the impulses that follow the law; `None` where
    /// nothing changes.
    fn struck<T: Scalar>(&self, cause: &ImpactCause, t: T, x: &[T]) -> Option<Strike<T>> {
        let impact = match cause {
            ImpactCause::Impact(stop) | ImpactCause::Landing(stop) | ImpactCause::LiftOff(stop) => {
                Some(*stop)
            }
            ImpactCause::Jump(_) => None,
        };
        let lands = matches!(cause, ImpactCause::Landing(_) | ImpactCause::LiftOff(_));
        let may_touch = matches!(cause, ImpactCause::Impact(_) | ImpactCause::Landing(_));
        let count = self.closed.len();
        let width = OF_STOP + count;
        let parts = self.evaluated(t, x);
        let of = |stop: usize, part: usize| parts[stop * width + part];
        let touching: Vec<Touching<T>> = (0..count)
            .filter_map(|stop| {
                let (gap, rate) = (of(stop, 0), of(stop, 2));
                let is_closed = x[self.closed[stop]].value() > 0.5;
                // The instant is known to the rounding of time.
                let size = of(stop, 1).value() + (rate.value() * t.value()).abs();
                let touches = may_touch && gap.value() <= ROUNDING * size;
                let takes_part = impact == Some(stop) || is_closed || touches;
                let is_kicked = match cause {
                    ImpactCause::Jump(kicks) => kicks[stop] != 0.0,
                    _ => false,
                };
                let carries = is_closed && !is_kicked;
                let left = if carries { rate.value() } else { 0.0 };
                takes_part.then(|| Touching {
                    stop,
                    gap,
                    rate,
                    left,
                    restitution: of(stop, 4),
                    size: of(stop, 3).value(),
                    carries,
                    lands: lands && (is_closed || impact == Some(stop)),
                    coupling: parts[stop * width + OF_STOP..(stop + 1) * width].to_vec(),
                })
            })
            .collect();
        if impact.is_none() && touching.iter().all(|one| one.carries) {
            return None;
        }
        let is_defined = touching.iter().all(Touching::has_restitution);
        let impulses = is_defined.then(|| impulses(&touching));
        Some(Strike {
            impulses: impulses.flatten(),
            touching,
            parts,
        })
    }
}

/// The rate of a gap after impulses, and the size of its terms.
fn rate_after<T: Scalar>(
    of: &Touching<T>,
    touching: &[Touching<T>],
    impulses: &[Option<T>],
) -> (T, f64) {
    let pushed = touching.iter().zip(impulses);
    pushed.fold((of.rate, of.size), |(rate, size), (other, impulse)| {
        let Some(impulse) = *impulse else {
            return (rate, size);
        };
        let part = of.coupling[other.stop] * impulse;
        (rate + part, size + part.value().abs())
    })
}

/// The impulses that follow the law: those of the smallest set of stops that does. `None` stands
/// for no impulse.
fn impulses<T: Scalar>(touching: &[Touching<T>]) -> Option<Vec<Option<T>>> {
    let mut sets: Vec<usize> = (0..1 << touching.len()).collect();
    sets.sort_by_key(|set| set.count_ones());
    sets.into_iter().find_map(|set| {
        let chosen: Vec<usize> = (0..touching.len()).filter(|i| set & 1 << i != 0).collect();
        let values = solved(touching, &chosen)?;
        let mut impulses = vec![None; touching.len()];
        for (i, value) in chosen.iter().zip(&values) {
            impulses[*i] = Some(*value);
        }
        // What lands has no rate left, whatever its sign.
        let of = |i: &usize| touching[*i].lands;
        let pushes = chosen
            .iter()
            .zip(&values)
            .all(|(i, impulse)| of(i) || impulse.value() >= -touching[*i].impulse_of_error());
        let holds = touching.iter().enumerate().all(|(i, one)| {
            let (after, size) = rate_after(one, touching, &impulses);
            let left = one.wanted() - one.rate + after;
            set & 1 << i != 0 || !one.lands && left.value() - one.left >= -ROUNDING * size
        });
        (pushes && holds).then_some(impulses)
    })
}

/// Distance to go back along the way of each stop so that all gaps vanish at once. The way that
/// closes one gap opens another one as much as the impulses do. Ways that depend on each other are
/// gone one by one, as those of two stops that hold one body at one place.
fn shifts<T: Scalar>(touching: &[Touching<T>]) -> Vec<T> {
    let entry = |row: &Touching<T>, column: &Touching<T>| {
        row.coupling[column.stop] / column.coupling[column.stop]
    };
    let matrix = touching.iter().map(|row| {
        let columns = touching.iter();
        columns.map(|column| entry(row, column)).collect()
    });
    let gaps = || touching.iter().map(|one| one.gap).collect();
    let found = eliminated(matrix.collect(), gaps());
    let is_sound = |shift: &T| shift.value().is_finite();
    found
        .filter(|all| all.iter().all(is_sound))
        .unwrap_or_else(gaps)
}

/// The impulses of these stops that make what the law compares vanish at each.
fn solved<T: Scalar>(touching: &[Touching<T>], chosen: &[usize]) -> Option<Vec<T>> {
    let count = chosen.len();
    let entry =
        |row: usize, column: usize| touching[chosen[row]].coupling[touching[chosen[column]].stop];
    let matrix = (0..count)
        .map(|row| (0..count).map(|column| entry(row, column)).collect())
        .collect();
    let right = chosen.iter().map(|&one| -touching[one].wanted()).collect();
    eliminated(matrix, right)
}

/// The solution of linear equations by elimination; `None` where a pivot vanishes to rounding.
fn eliminated<T: Scalar>(mut matrix: Vec<Vec<T>>, mut right: Vec<T>) -> Option<Vec<T>> {
    let count = right.len();
    let sizes = matrix.iter().flatten().map(|entry| entry.value().abs());
    let largest = sizes.fold(0.0, f64::max);
    for pivot in 0..count {
        let size = |row: &usize| matrix[*row][pivot].value().abs();
        let best = (pivot..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if size(&best) <= ROUNDING * largest {
            return None;
        }
        matrix.swap(pivot, best);
        right.swap(pivot, best);
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            let lead = matrix[pivot].clone();
            for (entry, lead) in matrix[row].iter_mut().zip(lead).skip(pivot) {
                *entry = *entry - factor * lead;
            }
            right[row] = right[row] - factor * right[pivot];
        }
    }
    for row in (0..count).rev() {
        for column in row + 1..count {
            right[row] = right[row] - matrix[row][column] * right[column];
        }
        right[row] = right[row] / matrix[row][row];
    }
    Some(right)
}
