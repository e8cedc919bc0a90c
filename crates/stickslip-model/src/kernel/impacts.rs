//! Newton's law of restitution at stops that close or touch.
//!
//! The impulses `P ≥ 0` and the rates of the gaps after them, `u⁺ = u⁻ + G P`, are complementary:
//! `w = u⁺ + e u⁻ ≥ 0` with `P·w = 0` where a gap closes, `w = u⁺` elsewhere (Moreau, *Unilateral
//! contact and dry friction in finite freedom dynamics*, CISM 302 (1988); Glocker, *Set-Valued
//! Force Laws*, 2001, Sect. 9).

use stickslip::Scalar;

use crate::expression::Tape;

/// A gap counts as closed, and a rate as zero, up to this part of the sizes of its terms: some
/// thousand units in the last place, which sums of as many terms leave.
const ROUNDING: f64 = 1e-12;

/// The law of impact of the stops of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Impacts {
    /// For each stop: gap, its size, rate, its size, restitution, and what a unit of impulse at
    /// each stop adds to the rate. Then, for each stop, what a unit of impulse adds to each state,
    /// and the direction in which the state opens the gap by one.
    pub parts: Tape,
    /// The discrete state of each stop: 1 while it carries.
    pub closed: Vec<usize>,
    /// Number of states.
    pub states: usize,
}

/// A stop at an impact.
struct Touching<T> {
    stop: usize,
    gap: T,
    rate: T,
    restitution: T,
    /// Size of the terms of the rate.
    size: f64,
    /// Whether the stop carries, so that what is left of its rate is rounding.
    carries: bool,
    /// Whether it carries after a landing: that stop, and those that carried before. A reaction
    /// that then would pull ends at once.
    lands: bool,
    coupling: Vec<T>,
}

impl<T: Scalar> Touching<T> {
    /// The rate that the law compares with, without impulses.
    fn wanted(&self) -> T {
        match self.rate.value() < 0.0 && !self.carries && !self.lands {
            true => self.rate + self.restitution * self.rate,
            false => self.rate,
        }
    }
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
    fn evaluated<T: Scalar>(&self, t: T, x: &[T]) -> Vec<T> {
        let count = self.closed.len();
        let mut parts = vec![T::zero(); count * (OF_STOP + count + 2 * self.states)];
        self.parts.evaluate(t, x, &mut parts);
        parts
    }

    /// Opens the stops whose gaps a jump has changed.
    pub fn release<T: Scalar>(&self, t: T, before: &[T], x: &mut [T]) {
        let width = OF_STOP + self.closed.len();
        let [old, new] = [before, &*x].map(|x| self.evaluated(t, x));
        for (stop, &closed) in self.closed.iter().enumerate() {
            let [gap, size] = [0, 1].map(|part| new[stop * width + part].value());
            if (gap - old[stop * width].value()).abs() > ROUNDING * size {
                x[closed] = T::zero();
            }
        }
    }

    /// The states after the impact of a stop; with `None`, after a jump, which may move what closed
    /// stops carry. Not a number where no impulses follow the law, or a restitution is not between
    /// 0 and 1.
    pub fn settle<T: Scalar>(&self, impact: Option<usize>, t: T, x: &mut [T]) {
        self.changed(impact, false, t, x);
    }

    /// The states after the landing of a stop: its gap and the rate of that are zero. The rate
    /// vanishes by an impulse, which other closed stops share. The gap vanishes along the motion
    /// that follows an impulse. So the derivative is that of infinitely many impacts.
    pub fn land<T: Scalar>(&self, stop: usize, t: T, x: &mut [T]) {
        self.changed(Some(stop), true, t, x);
    }

    /// The impulses of all stops at an impact, or behind a jump, and whether a stop lands.
    pub fn impulses(&self, (impact, lands): (Option<usize>, bool), t: f64, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.closed.len()];
        if let Some(Strike {
            touching,
            impulses: Some(impulses),
            ..
        }) = self.strike((impact, lands), t, x)
        {
            for (one, impulse) in touching.iter().zip(impulses) {
                all[one.stop] = impulse.unwrap_or(0.0);
            }
        }
        all
    }

    fn changed<T: Scalar>(&self, impact: Option<usize>, lands: bool, t: T, x: &mut [T]) {
        let Some(strike) = self.strike((impact, lands), t, x) else {
            return;
        };
        let Some(impulses) = strike.impulses else {
            x.fill(T::constant(f64::NAN));
            return;
        };
        let (parts, touching) = (strike.parts, strike.touching);
        let count = self.closed.len();
        let width = OF_STOP + count;
        for (one, impulse) in touching.iter().zip(&impulses) {
            let of_stop = &parts[count * width + 2 * one.stop * self.states..];
            let (acts, ways) = of_stop[..2 * self.states].split_at(self.states);
            for (x, (acts, way)) in x.iter_mut().zip(acts.iter().zip(ways)) {
                // What location leaves of the gap would displace all later impacts.
                *x = *x - *way * one.gap;
                if let Some(impulse) = *impulse {
                    *x = *x + *acts * impulse;
                }
            }
        }
        for (one, impulse) in touching.iter().zip(&impulses) {
            let (after, size) = rate_after(one, &touching, &impulses);
            let is_pressed = one.carries && impulse.is_some();
            let closes = one.lands || is_pressed || after.value().abs() <= ROUNDING * size;
            x[self.closed[one.stop]] = if closes { T::one() } else { T::zero() };
        }
    }

    /// The stops that take part in an impact and the impulses that follow the law; `None` where
    /// nothing changes.
    fn strike<T: Scalar>(
        &self,
        (impact, lands): (Option<usize>, bool),
        t: T,
        x: &[T],
    ) -> Option<Strike<T>> {
        let count = self.closed.len();
        let width = OF_STOP + count;
        let parts = self.evaluated(t, x);
        let of = |stop: usize, part: usize| parts[stop * width + part];
        let sizes = (0..count).map(|stop| of(stop, 3).value());
        let largest = sizes.fold(0.0, f64::max);
        let touching: Vec<Touching<T>> = (0..count)
            .filter_map(|stop| {
                let (gap, rate) = (of(stop, 0), of(stop, 2));
                let is_closed = x[self.closed[stop]].value() > 0.5;
                // The instant is known to the rounding of time.
                let size = of(stop, 1).value() + (rate.value() * t.value()).abs();
                let touches = impact.is_some() && gap.value() <= ROUNDING * size;
                let takes_part = impact == Some(stop) || is_closed || touches;
                let is_small = rate.value().abs() <= ROUNDING * largest;
                takes_part.then(|| Touching {
                    stop,
                    gap,
                    rate,
                    restitution: of(stop, 4),
                    size: of(stop, 3).value(),
                    carries: is_closed && (impact.is_some() || is_small),
                    lands: lands && (is_closed || impact == Some(stop)),
                    coupling: parts[stop * width + OF_STOP..(stop + 1) * width].to_vec(),
                })
            })
            .collect();
        if impact.is_none() && touching.iter().all(|one| one.carries) {
            return None;
        }
        let is_defined = |one: &Touching<T>| (0.0..=1.0).contains(&one.restitution.value());
        let impulses = touching.iter().all(is_defined).then(|| impulses(&touching));
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
            .all(|(i, impulse)| of(i) || impulse.value() >= 0.0);
        let holds = touching.iter().enumerate().all(|(i, one)| {
            let (after, size) = rate_after(one, touching, &impulses);
            let left = one.wanted() - one.rate + after;
            set & 1 << i != 0 || !one.lands && left.value() >= -ROUNDING * size
        });
        (pushes && holds).then_some(impulses)
    })
}

/// The impulses of these stops that make what the law compares vanish at each.
fn solved<T: Scalar>(touching: &[Touching<T>], chosen: &[usize]) -> Option<Vec<T>> {
    let count = chosen.len();
    let entry =
        |row: usize, column: usize| touching[chosen[row]].coupling[touching[chosen[column]].stop];
    let mut matrix: Vec<Vec<T>> = (0..count)
        .map(|row| (0..count).map(|column| entry(row, column)).collect())
        .collect();
    let mut right: Vec<T> = chosen.iter().map(|&one| -touching[one].wanted()).collect();
    for pivot in 0..count {
        let size = |row: &usize| matrix[*row][pivot].value().abs();
        let best = (pivot..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if matrix[best][pivot].value() == 0.0 {
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
