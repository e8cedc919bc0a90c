//! Where an event function vanishes next to which rounding leaves the orbits open: by orbits further away.

use super::determined::LEAST;
use super::locate::{Known, is_same};
use super::margin::{Key, Margin};
use super::{Orbits, of_tolerance};
use crate::analysis::lagrange::weights;
use crate::dynamics::Vector;

/// The first orbits are so many times farther away as what the location lacks, each next one farther than the one before.
const GROWTH: f64 = std::f64::consts::SQRT_2;

/// As many orbits are computed, and so many of them, one after the other, are used together.
const MOST: usize = 40;
const TOGETHER: usize = 7;

/// A zero in the parameter.
#[derive(Clone)]
pub(super) struct Zero {
    pub parameter: f64,
    pub uncertainty: f64,
    /// Where on the orbit.
    pub x: Vector,
}

/// An orbit's parameter, from that of the first one, and its event function with what that may be off by.
#[derive(Clone)]
struct Node {
    parameter: f64,
    value: f64,
    off: f64,
    x: Vector,
}

/// Where the event function is zero beyond the last orbit before a change, whose place is the parameter; `lacks` is how far beyond about, `away` the direction in which orbits have
/// the same phases, and `about` finds them there.
///
/// The parameter as a function of the event function's value is smooth where that vanishes, also where it grows as a root. So a polynomial through some orbits leads to it, by
/// those for which what rounding leaves and what the polynomial lacks are least together; the same orbits with a tenth of the tolerances tell what the tolerances do.
pub(super) fn zero_beyond<B: Clone>(
    last: Known<B>,
    key: Key,
    lacks: f64,
    away: f64,
    about: &impl Orbits<B>,
) -> Option<Zero> {
    let origin = last.s;
    let mut orbits = vec![last];
    let mut distance = lacks;
    for _ in 0..MOST {
        let found = about.at(origin + distance * away.signum(), &orbits);
        let next = found.filter(|next| orbits.last().is_some_and(|last| last.goes_on_in(next)));
        distance *= GROWTH;
        match next {
            Some(next) => orbits.push(next),
            // Next to the last one none may be found yet.
            None if orbits.len() == 1 => {}
            None => break,
        }
    }
    let node = |one: &Known<B>, margin: &Margin| Node {
        parameter: one.s - origin,
        value: margin.value,
        // Less than that is not looked for.
        off: margin.by_rounding.max(LEAST * margin.scale),
        x: margin.at.x.clone(),
    };
    let nodes = orbits
        .iter()
        .map_while(|one| Some(node(one, one.circuit.margin(key)?)));
    let nodes: Vec<Node> = nodes.collect();
    let zeros: Vec<Option<Zero>> = nodes.windows(TOGETHER).map(zero).collect();
    // One that the next orbits lead to as well is no accident.
    let pairs = zeros.windows(2).enumerate();
    let agreed = pairs.filter_map(|(begin, two)| {
        let (one, next) = (two[0].as_ref()?, two[1].as_ref()?);
        let differs = (one.parameter - next.parameter).abs();
        let uncertainty = one.uncertainty.max(differs);
        // Not farther beyond than the orbits lie away.
        let reach = nodes.get(begin + TOGETHER - 1)?.parameter;
        let is_near = one.parameter.abs() <= reach.abs() && one.parameter * away <= 0.0;
        is_near.then_some((
            begin,
            Zero {
                uncertainty,
                ..one.clone()
            },
        ))
    });
    let mut agreed: Vec<(usize, Zero)> = agreed.collect();
    agreed.sort_by(|a, b| a.1.uncertainty.total_cmp(&b.1.uncertainty));
    let with_tolerance = |(begin, best): (usize, Zero)| {
        let finer = orbits.get(begin..begin + TOGETHER)?.iter().map(|one| {
            let finer = about.finer(one)?;
            let same = is_same(&finer.sequence(), &one.circuit.sequence());
            let margin = finer.margin(key).filter(|_| same)?;
            Some(node(one, margin))
        });
        let finer: Vec<Node> = finer.collect::<Option<_>>()?;
        let by_tolerance = of_tolerance(best.parameter, at_zero(&finer));
        Some(Zero {
            parameter: origin + best.parameter,
            uncertainty: best.uncertainty + by_tolerance,
            ..best
        })
    };
    agreed.into_iter().find_map(with_tolerance).or_else(|| {
        // By the line through the first one that is told from it.
        let one = nodes.first()?;
        let most = one.value.abs() + orbits.first()?.circuit.margin(key)?.most_off();
        let apart = nodes.iter().find(|other| other.value.abs() >= 2.0 * most)?;
        let per_value = apart.parameter / (apart.value.abs() - most);
        Some(Zero {
            parameter: origin,
            uncertainty: (most * per_value).abs().max(lacks),
            x: one.x.clone(),
        })
    })
}

/// By the polynomial through all of the nodes, of which the last one is farthest away.
fn zero(nodes: &[Node]) -> Option<Zero> {
    let rises =
        |two: &[Node]| two[0].value.abs() < two[1].value.abs() && two[0].value * two[1].value > 0.0;
    if !nodes.windows(2).all(rises) {
        return None;
    }
    let (_, nearer) = nodes.split_last()?;
    let [all, fewer] = [nodes, nearer].map(at_zero);
    let weighted = || weights_at_zero(nodes).into_iter().zip(nodes);
    let slope = |k: usize| {
        let (one, two) = (
            nodes.get(k.saturating_sub(1))?,
            nodes.get(k + 1).or(nodes.get(k))?,
        );
        Some((two.parameter - one.parameter) / (two.value - one.value))
    };
    let by_rounding = weighted()
        .enumerate()
        .map(|(k, (weight, node))| Some((weight * node.off * slope(k)?).abs()));
    let by_rounding: f64 = by_rounding.sum::<Option<f64>>()?;
    Some(Zero {
        parameter: all,
        uncertainty: by_rounding + (all - fewer).abs(),
        x: weighted().map(|(weight, node)| &node.x * weight).sum(),
    })
}

fn at_zero(nodes: &[Node]) -> f64 {
    let weights = weights_at_zero(nodes).into_iter().zip(nodes);
    weights.map(|(weight, node)| weight * node.parameter).sum()
}

fn weights_at_zero(nodes: &[Node]) -> Vec<f64> {
    let values: Vec<f64> = nodes.iter().map(|node| node.value).collect();
    weights(&values, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orbits before a change at the parameter 0, the values of which are off by so much one way and the other.
    fn nodes(nearest: f64, parameter: impl Fn(f64) -> f64, off: f64) -> Vec<Node> {
        let node = |k: usize| {
            let value = nearest * crate::math::powi(GROWTH, k as i32);
            Node {
                parameter: parameter(value),
                value: value + if k.is_multiple_of(2) { off } else { -off },
                off,
                x: Vector::from_element(1, 1.0 + value),
            }
        };
        (0..TOGETHER).map(node).collect()
    }

    #[test]
    fn a_zero_that_values_grow_from_linearly_or_as_a_root_is_led_to_within_the_uncertainty() {
        let linear = |v: f64| -v * (2.0 + v) / (1.0 + v);
        let root = |v: f64| -v * v * (3.0 - v);
        for parameter in [&linear as &dyn Fn(f64) -> f64, &root] {
            for nearest in [1e-4, 1e-3, 1e-2] {
                for off in [1e-12, 1e-9, 1e-7] {
                    let found = zero(&nodes(nearest, parameter, off)).unwrap();
                    let error = found.parameter.abs();
                    let bound = found.uncertainty;
                    assert!(error <= bound, "{nearest} {off}: {error:e} {bound:e}");
                    assert!((found.x[0] - 1.0).abs() <= 1e3 * off + 1e-9);
                }
            }
            let found = zero(&nodes(1e-2, parameter, 1e-12)).unwrap();
            assert!(found.uncertainty < 1e-9, "{:e}", found.uncertainty);
        }
    }

    #[test]
    fn values_that_do_not_fall_towards_the_change_lead_nowhere() {
        let mut risen = nodes(1e-3, |v| -v, 0.0);
        risen[0].value = 1.0;
        assert!(zero(&risen).is_none());
    }
}
