//! The tape evaluated order by order.
//!
//! Every operation's next coefficient is a convolution of coefficients that are known already. Each pair of them is added to the
//! sum that it belongs to as soon as both are known, so that of order `k` only the two products with the newest
//! coefficients are left when its turn comes. `L` orbits go side by side, lane by lane in the same order of operations: each has
//! the bits that it would have alone.

use super::MOST_ORDER;
use super::tape::{Combination, Instruction, Tape};
use crate::math;

/// Sums that are served at a time.
const BLOCK: usize = 4;
/// Room in front of a row: a block may begin before the coefficients do.
const AHEAD: usize = BLOCK;
const SUMS: usize = (MOST_ORDER / BLOCK + 1) * BLOCK;

/// `1/k`.
pub(crate) const INVERSE: [f64; MOST_ORDER + 2] = {
    let mut inverse = [0.0; MOST_ORDER + 2];
    let mut k = 1;
    while k < inverse.len() {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

/// The coefficients of one number.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Row<const L: usize>([[f64; L]; AHEAD + SUMS]);

/// Convolution sums under way, by order.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Sums<const L: usize>([[f64; L]; SUMS]);

impl<const L: usize> Row<L> {
    const ZERO: Self = Row([[0.0; L]; AHEAD + SUMS]);
}

impl<const L: usize> Sums<L> {
    const ZERO: Self = Sums([[0.0; L]; SUMS]);
}

/// Coefficients of everything on a tape, each scaled by the power of a step length, so that none overflows.
#[derive(Clone, Debug)]
pub(crate) struct Series<const L: usize> {
    rows: Vec<Row<L>>,
    sums: Vec<Sums<L>>,
}

#[inline(always)]
fn lanes<const L: usize>(f: impl FnMut(usize) -> f64) -> [f64; L] {
    std::array::from_fn(f)
}

impl<const L: usize> Series<L> {
    pub(crate) fn new() -> Self {
        Series {
            rows: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Makes room for a tape.
    pub(crate) fn fit(&mut self, tape: &Tape) {
        if self.rows.len() < tape.rows {
            self.rows.resize(tape.rows, Row::ZERO);
            self.sums.resize(tape.rows, Sums::ZERO);
        }
    }

    /// Forgets everything; needed after coefficients that were not finite.
    pub(crate) fn clear(&mut self) {
        self.rows.fill(Row::ZERO);
    }

    /// Coefficient `k` of row `row`.
    #[inline(always)]
    pub(crate) fn at(&self, row: usize, k: usize) -> [f64; L] {
        self.rows[row].0[AHEAD + k]
    }

    #[inline(always)]
    fn set(&mut self, row: usize, k: usize, value: [f64; L]) {
        self.rows[row].0[AHEAD + k] = value;
    }

    /// The series of the solution through `(t, x)` to `order`, in time over `h`, and of everything that is watched.
    pub(crate) fn expand<const N: usize>(
        &mut self,
        tape: &Tape,
        t: [f64; L],
        x: &[[f64; L]; N],
        h: [f64; L],
        order: usize,
    ) {
        for (row, x) in x.iter().enumerate() {
            self.set(row, 0, *x);
        }
        self.set(N, 0, t);
        self.set(N, 1, h);
        for k in 0..order {
            for instruction in &tape.of_field {
                self.advance(tape, instruction, k, order);
            }
            for (i, slope) in tape.field.iter().enumerate() {
                let slope = self.combination(tape, slope, k);
                let next = lanes(|l| slope[l] * h[l] * INVERSE[k + 1]);
                self.set(i, k + 1, next);
            }
        }
        for instruction in &tape.of_both {
            self.advance(tape, instruction, order, order);
        }
        if !tape.of_watched.is_empty() {
            for k in 0..=order {
                for instruction in &tape.of_watched {
                    self.advance(tape, instruction, k, order);
                }
            }
        }
    }

    /// Coefficient `k` of a combination.
    #[inline(always)]
    pub(crate) fn combination(&self, tape: &Tape, sum: &Combination, k: usize) -> [f64; L] {
        let mut value = [if k == 0 { sum.constant } else { 0.0 }; L];
        for term in &tape.terms[sum.first as usize..(sum.first + sum.count) as usize] {
            let row = self.at(term.node as usize, k);
            for l in 0..L {
                value[l] += term.factor * row[l];
            }
        }
        value
    }

    /// Adds the products of coefficient `k` of `a` with those of `b` up to `k`, and the other way round, to the sums that they
    /// belong to, those with coefficient 0 excepted.
    #[inline(always)]
    fn pair(&mut self, sums: u32, (a, b): (u32, u32), k: usize, order: usize) {
        let (a, b) = (&self.rows[a as usize].0, &self.rows[b as usize].0);
        let (of_a, of_b) = (a[AHEAD + k], b[AHEAD + k]);
        add_products(
            &mut self.sums[sums as usize].0,
            k,
            order,
            |n, l| of_a[l] * b[AHEAD + n - k][l] + of_b[l] * a[AHEAD + n - k][l],
            |l| of_a[l] * of_b[l],
        );
    }

    /// The same for a square.
    #[inline(always)]
    fn pair_with_itself(&mut self, sums: u32, a: u32, k: usize, order: usize) {
        let a = &self.rows[a as usize].0;
        let of_a = a[AHEAD + k];
        add_products(
            &mut self.sums[sums as usize].0,
            k,
            order,
            |n, l| 2.0 * of_a[l] * a[AHEAD + n - k][l],
            |l| of_a[l] * of_a[l],
        );
    }

    /// Coefficient `k` of everything that one instruction computes.
    #[inline(always)]
    fn advance(&mut self, tape: &Tape, instruction: &Instruction, k: usize, order: usize) {
        // The sum that belongs to order k: all products but those with coefficient 0.
        let sum = |series: &mut Self, row: u32| {
            let sums = &mut series.sums[row as usize].0;
            if k == 0 {
                *sums = Sums::ZERO.0;
            }
            sums[k]
        };
        let of = |series: &Self, row: u32| series.at(row as usize, k);
        let first = |series: &Self, row: u32| series.at(row as usize, 0);
        match *instruction {
            Instruction::Combination { out, ref sum } => {
                let value = self.combination(tape, sum, k);
                self.set(out as usize, k, value);
            }
            Instruction::Product { out, a, b } => {
                let sum = sum(self, out);
                let (a0, b0) = (first(self, a), first(self, b));
                let value = if k == 0 {
                    lanes(|l| a0[l] * b0[l])
                } else {
                    let (of_a, of_b) = (of(self, a), of(self, b));
                    lanes(|l| sum[l] + (of_a[l] * b0[l] + a0[l] * of_b[l]))
                };
                self.set(out as usize, k, value);
                self.pair(out, (a, b), k, order);
            }
            Instruction::Square { out, a } => {
                let sum = sum(self, out);
                let (a0, of_a) = (first(self, a), of(self, a));
                let value = if k == 0 {
                    lanes(|l| a0[l] * a0[l])
                } else {
                    lanes(|l| sum[l] + 2.0 * a0[l] * of_a[l])
                };
                self.set(out as usize, k, value);
                self.pair_with_itself(out, a, k, order);
            }
            Instruction::Quotient { out, a, b } => {
                let sum = sum(self, out);
                let (b0, of_a) = (first(self, b), of(self, a));
                let value = if k == 0 {
                    lanes(|l| of_a[l] / b0[l])
                } else {
                    let (of_b, q0) = (of(self, b), first(self, out));
                    lanes(|l| (of_a[l] - (sum[l] + of_b[l] * q0[l])) / b0[l])
                };
                self.set(out as usize, k, value);
                self.pair(out, (b, out), k, order);
            }
            Instruction::Reciprocal { out, b } => {
                let sum = sum(self, out);
                let of_b = of(self, b);
                let value = if k == 0 {
                    lanes(|l| 1.0 / of_b[l])
                } else {
                    let q0 = first(self, out);
                    lanes(|l| -(sum[l] + of_b[l] * q0[l]) * q0[l])
                };
                self.set(out as usize, k, value);
                self.pair(out, (b, out), k, order);
            }
            Instruction::Root { out, a } => {
                let sum = sum(self, out);
                let of_a = of(self, a);
                let value = if k == 0 {
                    lanes(|l| of_a[l].sqrt())
                } else {
                    let r0 = first(self, out);
                    lanes(|l| (of_a[l] - sum[l]) / (2.0 * r0[l]))
                };
                self.set(out as usize, k, value);
                self.pair_with_itself(out, out, k, order);
            }
            Instruction::Exponential { out, a, helper } => {
                let sum = sum(self, out);
                let slope = self.slope(a, helper, k);
                let value = if k == 0 {
                    let a0 = first(self, a);
                    lanes(|l| math::exp(a0[l]))
                } else {
                    let e0 = first(self, out);
                    lanes(|l| (sum[l] + slope[l] * e0[l]) * INVERSE[k])
                };
                self.set(out as usize, k, value);
                self.pair(out, (helper, out), k, order);
            }
            Instruction::Logarithm { out, a, helper } => {
                let sum = sum(self, out);
                let (a0, of_a) = (first(self, a), of(self, a));
                let value = if k == 0 {
                    self.set(helper as usize, 0, [0.0; L]);
                    lanes(|l| math::ln(a0[l]))
                } else {
                    let slope: [f64; L] = lanes(|l| (of_a[l] * k as f64 - sum[l]) / a0[l]);
                    self.set(helper as usize, k, slope);
                    lanes(|l| slope[l] * INVERSE[k])
                };
                self.set(out as usize, k, value);
                self.pair(out, (helper, a), k, order);
            }
            Instruction::SineCosine { sine, a, helper } => {
                let cosine = sine + 1;
                let (of_sine, of_cosine) = (sum(self, sine), sum(self, cosine));
                let slope = self.slope(a, helper, k);
                let (up, down) = if k == 0 {
                    let a0 = first(self, a);
                    (lanes(|l| math::sin(a0[l])), lanes(|l| math::cos(a0[l])))
                } else {
                    let (s0, c0) = (first(self, sine), first(self, cosine));
                    (
                        lanes(|l| (of_sine[l] + slope[l] * c0[l]) * INVERSE[k]),
                        lanes(|l| -(of_cosine[l] + slope[l] * s0[l]) * INVERSE[k]),
                    )
                };
                self.set(sine as usize, k, up);
                self.set(cosine as usize, k, down);
                self.pair(sine, (helper, cosine), k, order);
                self.pair(cosine, (helper, sine), k, order);
            }
        }
    }

    /// Coefficient `k` of `s a'(s)`.
    #[inline(always)]
    fn slope(&mut self, a: u32, helper: u32, k: usize) -> [f64; L] {
        let of_a = self.at(a as usize, k);
        let slope = lanes(|l| of_a[l] * k as f64);
        self.set(helper as usize, k, slope);
        slope
    }
}

/// Adds the products whose larger index is `k` to the sums `k + 1` to `2k`, `product` of them to sum `n`, once `square` to `2k`.
/// Sums up to `k` and beyond the order no longer matter: whole blocks are served.
#[inline(always)]
fn add_products<const L: usize>(
    sums: &mut [[f64; L]; SUMS],
    k: usize,
    order: usize,
    product: impl Fn(usize, usize) -> f64,
    square: impl Fn(usize) -> f64,
) {
    let whole = 2 * k > order;
    let end = if whole {
        SUMS.min((order / BLOCK + 1) * BLOCK)
    } else {
        2 * k / BLOCK * BLOCK
    };
    let mut n = (k + 1) / BLOCK * BLOCK;
    while n < end {
        for j in 0..BLOCK {
            for l in 0..L {
                sums[n + j][l] += product(n + j, l);
            }
        }
        n += BLOCK;
    }
    if !whole {
        for n in n.max(k + 1)..2 * k {
            for l in 0..L {
                sums[n][l] += product(n, l);
            }
        }
        for l in 0..L {
            sums[2 * k][l] += square(l);
        }
    }
}
