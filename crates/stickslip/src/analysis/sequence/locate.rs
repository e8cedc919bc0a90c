//! Where on a branch of periodic orbits their phases change.

use super::circuit::{Circuit, Kind};
use super::margin::{Margin, Site};

/// A periodic orbit on a branch.
#[derive(Clone, Debug)]
pub(crate) struct Known<B> {
    /// Place on the branch.
    pub s: f64,
    pub circuit: Circuit,
    /// What the branch itself needs of it.
    pub branch: B,
}

impl<B> Known<B> {
    /// Whether the other orbit's phases are as well known as this one's.
    pub fn is_as_certain(&self, next: &Self) -> bool {
        next.circuit.is_certain || !self.circuit.is_certain
    }

    /// Whether the branch goes on in the next orbit without a change of phases.
    pub fn goes_on_in(&self, next: &Self) -> bool {
        is_same(&next.circuit.sequence(), &self.circuit.sequence()) && self.is_as_certain(next)
    }
}

/// A margin of this part of its scale is zero.
const ZERO: f64 = 1e-9;

/// A margin of this part of its scale is vanishing: where it grows as a root, a change located to 1e-10 leaves some 1e-6.
pub(super) const VANISHING: f64 = 3e-5;

/// Trials allowed.
const MOST: usize = 200;

/// Part of the way to where a margin would be zero by which a trial falls short of it, or goes beyond.
const SHORT: f64 = 1e-3;

/// Whether two orbits have the same phases, the same part being the first.
pub(crate) fn is_same(one: &[Kind], other: &[Kind]) -> bool {
    one.len() == other.len() && one == other
}

/// The last orbit before the phases change or the branch ends, which it does between it and `bad`, to `resolution` in the place; and where the
/// first trial behind it was. `good` holds one orbit or more, in order; `solve` finds one at a place, given those known.
pub(crate) fn locate<B>(
    good: &mut Vec<Known<B>>,
    mut bad: f64,
    resolution: f64,
    mut solve: impl FnMut(f64, &[Known<B>]) -> Option<Known<B>>,
) -> f64 {
    for trial in 0..MOST {
        let [.., last] = good.as_slice() else { break };
        let (from, way) = (last.s, bad - last.s);
        if way.abs() <= resolution {
            break;
        }
        let zero = (trial % 3 < 2)
            .then(|| estimate(good, bad, trial % 2 == 1))
            .flatten();
        let s = match zero {
            Some(zero) => {
                let off = SHORT * (zero - from) + 0.25 * resolution * way.signum();
                let s = if trial % 3 == 0 {
                    zero - off
                } else {
                    zero + off
                };
                let inside = (s - from) * (bad - s) > 0.0;
                if inside { s } else { from + 0.5 * way }
            }
            None => from + 0.5 * way,
        };
        if s == from || s == bad {
            break;
        }
        match solve(s, good) {
            Some(found) if last.goes_on_in(&found) => good.push(found),
            _ => bad = s,
        }
    }
    bad
}

/// Follows a branch from `first`, by steps that begin with `step`, to the last orbit before its phases change; `None` where they do not within
/// some dozens of steps.
pub(crate) fn approach<B>(
    first: Known<B>,
    step: f64,
    resolution: f64,
    mut solve: impl FnMut(f64, &[Known<B>]) -> Option<Known<B>>,
) -> Option<(Vec<Known<B>>, f64)> {
    const STEPS: usize = 40;
    const GROWTH: f64 = 1.3;
    let mut good = vec![first];
    let mut step = step;
    for _ in 0..STEPS {
        let last = good.last()?;
        let s = last.s + step;
        match solve(s, &good) {
            Some(found) if last.goes_on_in(&found) => good.push(found),
            _ => {
                let bad = locate(&mut good, s, resolution, &mut solve);
                return Some((good, bad));
            }
        }
        step *= GROWTH;
    }
    None
}

/// Where the first of the margins would be zero that are falling, by the last two orbits; those of short phases and of the rate at which the
/// boundary is come to by their squares if asked: what begins at a graze grows as a root.
fn estimate<B>(good: &[Known<B>], bad: f64, by_squares: bool) -> Option<f64> {
    let [.., one, two] = good else { return None };
    let mut best: Option<f64> = None;
    for margin in &two.circuit.margins {
        let Some(before) = one.circuit.margin(margin.key) else {
            continue;
        };
        let is_square = by_squares && matches!(margin.key.site, Site::Duration | Site::Arrival);
        let of = |value: f64| if is_square { value * value } else { value };
        let (first, second) = (of(before.value), of(margin.value));
        if second.abs() >= first.abs() {
            continue;
        }
        let zero = two.s - second * (two.s - one.s) / (second - first);
        let inside = (zero - two.s) * (bad - zero) > 0.0;
        let nearer = best.is_none_or(|other| (zero - two.s).abs() < (other - two.s).abs());
        if inside && nearer {
            best = Some(zero);
        }
    }
    best
}

/// The margin that has come nearest to zero. If a phase is vanishing it is that, for at its end other functions vanish with it.
pub(crate) fn least(circuit: &Circuit) -> Option<&Margin> {
    let nearest = |is_asked: fn(&Margin) -> bool| {
        let asked = circuit.margins.iter().filter(|margin| is_asked(margin));
        asked.min_by(|a, b| a.relative().total_cmp(&b.relative()))
    };
    let shortest = nearest(|margin| margin.key.site == Site::Duration);
    shortest
        .filter(|margin| margin.vanishes())
        .or_else(|| nearest(|_| true))
}

/// How far behind the last of the orbits a function is zero that has come near to it there, going on as before. Where orbits
/// can be computed to the change itself that is nothing; where they cannot, it is what the location lacks.
pub(super) fn shortfall<B>(good: &[Known<B>], margin: &Margin) -> f64 {
    let value = |one: &Known<B>| one.circuit.margin(margin.key).map(|m| m.value.abs());
    let values = good.iter().filter_map(|one| Some((one.s, value(one)?)));
    let values: Vec<(f64, f64)> = values.collect();
    let Some(&(end, last)) = values.last() else {
        return 0.0;
    };
    // Once as near to zero as at the end, what it still does is rounding.
    let (before, rest) = {
        let first = values.iter().position(|&(_, value)| value <= last);
        values.split_at(first.unwrap_or(values.len()))
    };
    let noise = rest.iter().map(|&(_, value)| value).fold(last, f64::max);
    let noise = noise + margin.most_off();
    // Of orbits that lie closer, rounding tells what the function does.
    let apart = |&&(_, value): &&(f64, f64)| value >= 2.0 * noise;
    match before.iter().rev().find(apart) {
        // What grows as a root is nearer to zero than this, what vanishes as a square further by some times.
        Some(&(s, value)) => (noise * (end - s) / (value - noise)).abs(),
        None if noise <= ZERO * margin.scale => 0.0,
        // Nothing tells how the function goes on: the change may be as far away as the orbits known reach.
        None => values.first().map_or(0.0, |&(s, _)| (end - s).abs()),
    }
}
