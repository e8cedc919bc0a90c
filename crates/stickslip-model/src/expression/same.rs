//! Numbers that are the same for the present values of the parameters.

use rustc_hash::FxHashSet;

use super::graph::{Graph, Id, Node};

impl Graph {
    /// Whether two numbers are the same with these values of the parameters: computed by the same
    /// operations from the same inputs and equal held numbers.
    pub fn are_same(&mut self, one: Id, other: Id) -> bool {
        let mut compared = FxHashSet::default();
        let mut open = vec![(one, other)];
        while let Some((one, other)) = open.pop() {
            if one == other || !compared.insert((one, other)) {
                continue;
            }
            let is_same = match (self.place(one), self.place(other)) {
                (Some(one), Some(other)) => self.held.equal(one, other),
                (None, None) => match operands_of_same(self.node(one), self.node(other)) {
                    Some(pairs) => {
                        open.extend(pairs.into_iter().flatten());
                        true
                    }
                    None => false,
                },
                _ => false,
            };
            if !is_same {
                return false;
            }
        }
        true
    }
}

/// The operands of two numbers, in pairs; `None` if they are not the same operation.
fn operands_of_same(one: Node, other: Node) -> Option<[Option<(Id, Id)>; 2]> {
    match (one, other) {
        (Node::Call(f, a), Node::Call(g, c)) if f == g => Some([Some((a, c)), None]),
        (Node::Curve(k, a), Node::Curve(l, c)) if k == l => Some([Some((a, c)), None]),
        (Node::Negative(a), Node::Negative(c)) => Some([Some((a, c)), None]),
        (Node::Sum(a, b), Node::Sum(c, d))
        | (Node::Difference(a, b), Node::Difference(c, d))
        | (Node::Product(a, b), Node::Product(c, d))
        | (Node::Quotient(a, b), Node::Quotient(c, d))
        | (Node::IntegerPower(a, b), Node::IntegerPower(c, d))
        | (Node::RealPower(a, b), Node::RealPower(c, d))
        | (Node::Angle(a, b), Node::Angle(c, d))
        | (Node::Larger(a, b), Node::Larger(c, d))
        | (Node::Smaller(a, b), Node::Smaller(c, d))
        | (Node::WherePositive(a, b), Node::WherePositive(c, d))
        | (Node::WhereNotPositive(a, b), Node::WhereNotPositive(c, d)) => {
            Some([Some((a, c)), Some((b, d))])
        }
        _ => None,
    }
}
