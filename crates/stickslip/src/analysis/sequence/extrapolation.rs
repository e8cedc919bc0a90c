//! Where an event function vanishes next to which rounding leaves the orbits open: by orbits further away.

use super::Orbits;
use super::determined::LEAST;
use super::locate::Known;
use super::margin::Key;
use crate::analysis::lagrange::weights;
use crate::system::State;

/// The first orbits are so many times farther away as what the location lacks, each next one farther than the one before.
const GROWTH: f64 = std::f64::consts::SQRT_2;

/// As many orbits are computed, and so many of them, one after the other, are used together.
const MOST: usize = 40;
const TOGETHER: usize = 7;

/// How many times as far as was expected the zero may lie.
const FURTHEST: f64 = 10.0;

/// A zero in the parameter.
pub(super) struct Zero<const N: usize> {
    pub parameter: f64,
    pub uncertainty: f64,
    /// Where on the orbit.
    pub x: State<N>,
}

/// An orbit's parameter, from that of the first one, and its event function with what that may be off by.
#[derive(Clone, Copy)]
struct Node<const N: usize> {
    parameter: f64,
    value: f64,
    off: f64,
    x: State<N>,
}

/// Where the event function is zero beyond the last orbit before a change, whose place is the parameter; `lacks` is how far beyond about, `away` the direction in which orbits have
/// the same phases, and `orbits` are found there.
///
/// The parameter as a function of the event function's value is smooth where that vanishes, also where it grows as a root. So a polynomial through some orbits leads to it, by
/// those for which what rounding leaves and what the polynomial lacks are least together.
pub(super) fn zero_beyond<B: Clone, const N: usize, K: Copy + PartialEq>(
    last: Known<B, N, K>,
    key: Key,
    lacks: f64,
    away: f64,
    about: &impl Orbits<B, N, K>,
) -> Option<Zero<N>> {
    let origin = last.s;
    let mut orbits = vec![last];
    let mut distance = lacks;
    for _ in 0..MOST {
        let found = about.at(origin + distance * away.signum(), &orbits);
        let next = found.filter(|next| orbits.last().is_some_and(|last| last.goes_on_in(next)));
        let Some(next) = next else { break };
        orbits.push(next);
        distance *= GROWTH;
    }
    let node = |one: &Known<B, N, K>| {
        let margin = one.circuit.margin(key)?;
        Some(Node {
            parameter: one.s - origin,
            value: margin.value,
            // Less than that is not looked for.
            off: margin.off.max(LEAST * margin.scale),
            x: margin.at.x,
        })
    };
    let nodes: Vec<Node<N>> = orbits.iter().map_while(node).collect();
    let zeros = nodes.windows(TOGETHER).filter_map(zero);
    let best = zeros.min_by(|a, b| a.uncertainty.total_cmp(&b.uncertainty))?;
    let is_near = best.parameter.abs() <= FURTHEST * lacks && best.parameter * away <= 0.0;
    is_near.then_some(Zero {
        parameter: origin + best.parameter,
        ..best
    })
}

/// By the polynomial through all of the nodes, of which the last one is farthest away.
fn zero<const N: usize>(nodes: &[Node<N>]) -> Option<Zero<N>> {
    let falls = |two: &[Node<N>]| {
        two[0].value.abs() < two[1].value.abs() && two[0].value * two[1].value > 0.0
    };
    if !nodes.windows(2).all(falls) {
        return None;
    }
    let (_, nearer) = nodes.split_last()?;
    let [all, fewer] = [nodes, nearer].map(at_zero);
    let (one, two) = (nodes.first()?, nodes.get(1)?);
    let slope = (two.parameter - one.parameter) / (two.value - one.value);
    let weighted = || weights_at_zero(nodes).into_iter().zip(nodes);
    let by_rounding: f64 = weighted()
        .map(|(weight, node)| (weight * node.off).abs())
        .sum();
    Some(Zero {
        parameter: all,
        uncertainty: by_rounding * slope.abs() + (all - fewer).abs(),
        x: weighted().map(|(weight, node)| node.x * weight).sum(),
    })
}

fn at_zero<const N: usize>(nodes: &[Node<N>]) -> f64 {
    let weights = weights_at_zero(nodes).into_iter().zip(nodes);
    weights.map(|(weight, node)| weight * node.parameter).sum()
}

fn weights_at_zero<const N: usize>(nodes: &[Node<N>]) -> Vec<f64> {
    let values: Vec<f64> = nodes.iter().map(|node| node.value).collect();
    weights(&values, 0.0)
}
