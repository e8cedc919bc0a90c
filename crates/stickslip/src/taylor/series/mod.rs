//! The tape evaluated order by order.
//!
//! Every operation's next coefficient is a convolution of coefficients that are known already. Written for `L` lanes: one
//! for an orbit alone, several for orbits side by side. No lane knows of another: each has the bits that it would have alone.

mod recurrence;

use std::cmp::Ordering;

use pulp::{Arch, NullaryFnOnce};

use super::MOST_ORDER;
use super::tape::{Combination, Numbers, Tape};

/// `1/k`.
const INVERSE: [f64; MOST_ORDER + 2] = {
    let mut inverse = [0.0; MOST_ORDER + 2];
    let mut k = 1;
    while k < inverse.len() {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

const ROOM: usize = MOST_ORDER + 1;

/// The coefficients of one number by order.
type Row<const L: usize> = [[f64; L]; ROOM];

/// Coefficients of everything on a tape, each scaled by the power of a step length, so that none overflows.
#[derive(Clone, Debug)]
pub(crate) struct Series<const L: usize> {
    rows: Vec<Row<L>>,
    arch: Arch,
}

#[inline(always)]
fn lanes<const L: usize>(f: impl FnMut(usize) -> f64) -> [f64; L] {
    std::array::from_fn(f)
}

impl<const L: usize> Series<L> {
    pub(crate) fn new() -> Self {
        Series {
            rows: Vec::new(),
            arch: Arch::new(),
        }
    }

    /// Makes room for a tape.
    pub(crate) fn fit(&mut self, tape: &Tape) {
        if self.rows.len() < tape.rows {
            self.rows.resize(tape.rows, [[0.0; L]; ROOM]);
        }
    }

    #[inline(always)]
    fn lanes_at(&self, row: usize, k: usize) -> [f64; L] {
        self.rows[row][k]
    }

    #[inline(always)]
    fn set(&mut self, row: usize, k: usize, value: [f64; L]) {
        self.rows[row][k] = value;
    }

    /// The series of the solution through `(t, x)` to `order`, in time over `h`, and of everything that is watched.
    #[inline(always)]
    fn expand_lanes(
        &mut self,
        tape: &Tape,
        numbers: &Numbers<L>,
        t: [f64; L],
        x: &[[f64; L]],
        h: [f64; L],
        order: usize,
    ) {
        for (row, x) in x.iter().enumerate() {
            self.set(row, 0, *x);
        }
        self.set(x.len(), 0, t);
        self.set(x.len(), 1, h);
        // Written out for every order, so that each convolution has a length that the compiler knows.
        macro_rules! orders {
            ($($k:literal)*) => {$(
                let instructions = match order.cmp(&$k) {
                    Ordering::Greater => &tape.inner,
                    Ordering::Equal => &tape.last,
                    Ordering::Less => return,
                };
                for instruction in instructions {
                    self.advance::<$k>(tape, numbers, instruction);
                }
                if $k < order {
                    for (i, slope) in tape.field.iter().enumerate() {
                        let slope = self.combine(tape, numbers, slope, $k);
                        let next = lanes(|l| slope[l] * (h[l] * INVERSE[$k + 1]));
                        self.set(i, $k + 1, next);
                    }
                }
            )*};
        }
        orders!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24);
    }

    /// Coefficient `k` of a combination.
    #[inline(always)]
    fn combine(&self, tape: &Tape, numbers: &Numbers<L>, sum: &Combination, k: usize) -> [f64; L] {
        let terms = sum.terms();
        let mut terms = tape.nodes[terms.clone()]
            .iter()
            .zip(&numbers.factors[terms]);
        let Some((&first, factor)) = terms.next() else {
            return if k == 0 {
                numbers.constants[sum.constant as usize]
            } else {
                [0.0; L]
            };
        };
        let row = self.lanes_at(first as usize, k);
        let mut value = lanes(|l| factor[l] * row[l]);
        for (&node, factor) in terms {
            let row = self.lanes_at(node as usize, k);
            for l in 0..L {
                value[l] += factor[l] * row[l];
            }
        }
        if k == 0 {
            let constant = numbers.constants[sum.constant as usize];
            for l in 0..L {
                value[l] += constant[l];
            }
        }
        value
    }

    /// The series of the solutions through `(t, x)` to `order`, each in time over its `h`, and of everything that is watched.
    #[inline(always)]
    pub(crate) fn expand_all(
        &mut self,
        tape: &Tape,
        numbers: &Numbers<L>,
        at: (&[f64; L], &[[f64; L]]),
        h: &[f64; L],
        order: usize,
    ) {
        let arch = self.arch;
        arch.dispatch(Expand {
            series: self,
            tape,
            numbers,
            t: *at.0,
            x: at.1,
            h: *h,
            order,
        });
    }
}

impl Series<1> {
    /// The series of the solution through `(t, x)` to `order`, in time over `h`, and of everything that is watched.
    #[inline(never)]
    pub(crate) fn expand(&mut self, tape: &Tape, t: f64, x: &[[f64; 1]], h: f64, order: usize) {
        self.expand_all(tape, &tape.numbers, (&[t], x), &[h], order);
    }

    /// Takes rows of one lane of an expansion.
    pub(crate) fn take_lane<const L: usize>(
        &mut self,
        of: &Series<L>,
        lane: usize,
        rows: &[u32],
        order: usize,
    ) {
        for &row in rows {
            let (to, from) = (&mut self.rows[row as usize], &of.rows[row as usize]);
            for (to, from) in to[..=order].iter_mut().zip(&from[..=order]) {
                to[0] = from[lane];
            }
        }
    }

    /// Coefficient `k` of row `row`.
    #[inline(always)]
    pub(crate) fn at(&self, row: usize, k: usize) -> f64 {
        self.rows[row][k][0]
    }

    /// Coefficient `k` of a combination.
    #[inline(always)]
    pub(crate) fn combination(&self, tape: &Tape, sum: &Combination, k: usize) -> f64 {
        self.combine(tape, &tape.numbers, sum, k)[0]
    }
}

/// An expansion in the widest vectors that the machine and this build have; their width changes no bit.
struct Expand<'a, const L: usize> {
    series: &'a mut Series<L>,
    tape: &'a Tape,
    numbers: &'a Numbers<L>,
    t: [f64; L],
    x: &'a [[f64; L]],
    h: [f64; L],
    order: usize,
}

impl<const L: usize> NullaryFnOnce for Expand<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.series
            .expand_lanes(self.tape, self.numbers, self.t, self.x, self.h, self.order);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tape::Instruction;
    use super::*;
    use crate::math;
    use crate::scalar::Scalar;
    use crate::system::State;
    use crate::taylor::recorder::Recorded;
    use crate::taylor::sketch::Sketch;

    const H: f64 = 0.5;

    /// Coefficients in `t/H` of functions of the time at 0, and of the solution of `x' = x² + 1` from 0, the tangent.
    fn coefficients<const W: usize>(
        functions: impl Fn(Recorded, Recorded) -> [Recorded; W],
    ) -> Vec<Vec<f64>> {
        let (mut tape, mut sketch, mut series) =
            (Tape::default(), Sketch::default(), Series::<1>::new());
        tape.record(&mut sketch, 0.0, &State::from([0.0]), |t, x| {
            ([x[0] * x[0] + 1.0], functions(t, x[0]))
        });
        series.fit(&tape);
        series.expand(&tape, 0.0, &[[0.0]], H, MOST_ORDER);
        let row = |function| {
            (0..ROOM)
                .map(|k| series.combination(&tape, function, k))
                .collect()
        };
        tape.watched.iter().map(row).collect()
    }

    fn assert_series(found: &[f64], what: &str, exact: impl Fn(usize) -> f64) {
        for (k, found) in found.iter().enumerate() {
            let exact = exact(k) * math::powi(H, k as i32);
            assert!(
                (found - exact).abs() <= 1e-14 * exact.abs(),
                "{what}, order {k}: {found} {exact}"
            );
        }
    }

    #[test]
    fn every_operation_has_the_series_that_it_is_known_to_have() {
        let one = |t: Recorded| t + 1.0;
        let found = coefficients(|t, _| {
            [
                Scalar::exp(t * 2.0),
                Scalar::ln(one(t)),
                Scalar::sqrt(one(t)),
                Scalar::sin(t * 3.0),
                Scalar::cos(t * 3.0),
                // Of no linear function of the time: the tape takes another way.
                Scalar::sin(one(t) * one(t) - t * t + t),
                Recorded::constant(2.0) / (-t + 1.0),
                one(t) / (-t + 1.0),
                one(t) * one(t),
                Scalar::exp(t) * one(t),
            ]
        });
        let factorial = |k: usize| (1..=k).fold(1.0, |product, j| product * j as f64);
        let sign = |k: usize| math::powi(-1.0, k as i32);
        assert_series(&found[0], "exp", |k| {
            math::powi(2.0, k as i32) / factorial(k)
        });
        assert_series(&found[1], "ln", |k| {
            if k == 0 { 0.0 } else { -sign(k) / k as f64 }
        });
        let half = |k: usize| (0..k).fold(1.0, |c, j| c * (0.5 - j as f64) / (j + 1) as f64);
        assert_series(&found[2], "sqrt", half);
        let power = |k: usize| math::powi(3.0, k as i32) / factorial(k);
        assert_series(&found[3], "sin", |k| {
            if k % 2 == 1 {
                sign(k / 2) * power(k)
            } else {
                0.0
            }
        });
        assert_series(&found[4], "cos", |k| {
            if k % 2 == 0 {
                sign(k / 2) * power(k)
            } else {
                0.0
            }
        });
        let (s, c) = (math::sin(1.0), math::cos(1.0));
        assert_series(&found[5], "sin by convolution", |k| {
            [s, c, -s, -c][k % 4] * power(k)
        });
        assert_series(&found[6], "1/x", |_| 2.0);
        assert_series(&found[7], "a/b", |k| if k == 0 { 1.0 } else { 2.0 });
        assert_series(&found[8], "square", |k| {
            [1.0, 2.0, 1.0].get(k).copied().unwrap_or(0.0)
        });
        assert_series(&found[9], "product", |k| (1 + k) as f64 / factorial(k));
    }

    #[test]
    fn neither_lanes_nor_the_width_of_vectors_change_a_bit() {
        let (mut tape, mut sketch) = (Tape::default(), Sketch::default());
        tape.record(&mut sketch, 0.2, &State::from([0.3, 0.7]), |t, x| {
            let friction = Recorded::constant(0.3) / (x[1] * 0.5 + 1.0);
            let forced = Scalar::sin(t * 3.0) * Scalar::exp(-x[0]);
            let spring = x[0] * x[0] * x[1] - Scalar::sqrt(x[0] + 2.0);
            let field = [x[1] / (x[0] + 2.0), forced - friction + spring];
            (field, [Scalar::ln(x[0] + 1.0) * Scalar::cos(x[1])])
        });
        const LANES: usize = 4;
        let t: [f64; LANES] = std::array::from_fn(|l| 0.1 * l as f64);
        let h = t.map(|t| 0.3 + 0.2 * t);
        let x = [t.map(|t| 0.3 + t), t.map(|t| 0.7 - t)];
        let mut numbers = Numbers::default();
        numbers.gather([&tape.numbers; LANES]);
        for arch in [Arch::Scalar, Arch::new()] {
            let (mut wide, mut alone) = (Series::<LANES>::new(), Series::<1>::new());
            (wide.arch, alone.arch) = (arch, Arch::Scalar);
            wide.fit(&tape);
            alone.fit(&tape);
            wide.expand_all(&tape, &numbers, (&t, &x), &h, MOST_ORDER);
            for l in 0..LANES {
                alone.expand(&tape, t[l], &x.map(|x| [x[l]]), h[l], MOST_ORDER);
                for (one, many) in alone.rows.iter().zip(&wide.rows) {
                    for (one, many) in one.iter().zip(many) {
                        assert_eq!(one[0].to_bits(), many[l].to_bits(), "lane {l}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_cancels_cancels_exactly_and_what_is_the_same_is_computed_once() {
        let (mut tape, mut sketch) = (Tape::default(), Sketch::default());
        tape.record(&mut sketch, 0.0, &State::from([0.3]), |t, x| {
            let a = Scalar::sin(x[0]) + t;
            let weight = a / (a - x[0] * x[0]);
            let sliding = a + weight * (x[0] * x[0] - a);
            ([Scalar::sin(x[0])], [sliding, x[0] * x[0]])
        });
        let sliding = tape.watched[0];
        assert_eq!(sliding.count, 0);
        assert_eq!(tape.numbers.constants[sliding.constant as usize], [0.0]);
        let squares =
            |instruction: &&Instruction| matches!(instruction, Instruction::Square { .. });
        assert_eq!(tape.inner.iter().filter(squares).count(), 1);
        assert_eq!(tape.inner.len(), 2, "sine and cosine, and the square");
        assert_eq!(tape.last.len(), 1, "the square");
    }

    #[test]
    fn the_tangent_solves_its_equation() {
        let found = coefficients(|_, x| [x]);
        // tan t = t + t³/3 + 2t⁵/15 + 17t⁷/315 + 62t⁹/2835 + …
        let exact = [
            0.0,
            1.0,
            0.0,
            1.0 / 3.0,
            0.0,
            2.0 / 15.0,
            0.0,
            17.0 / 315.0,
            0.0,
            62.0 / 2835.0,
        ];
        assert_series(&found[0][..10], "tan", |k| exact[k]);
    }
}
