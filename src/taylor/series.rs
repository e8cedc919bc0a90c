//! The tape evaluated order by order.
//!
//! Every operation's next coefficient is a convolution of coefficients that are known already. `L` orbits go side by
//! side, lane by lane in the same order of operations: each has the bits that it would have alone.

use super::MOST_ORDER;
use super::tape::{Combination, Instruction, Tape};
use crate::math;

/// Summands that a convolution takes at a time; it is filled up with zeros to a multiple.
const CHUNK: usize = 4;
const FORWARD: usize = (MOST_ORDER / CHUNK + 1) * CHUNK;
const BACKWARD: usize = MOST_ORDER + 1 + CHUNK;

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

/// The coefficients of one number, twice: in order, and in reverse order with zeros behind the first, so that a convolution
/// goes upwards through both of its factors.
#[derive(Clone, Copy, Debug)]
struct Row<const L: usize> {
    forward: [[f64; L]; FORWARD],
    backward: [[f64; L]; BACKWARD],
}

impl<const L: usize> Row<L> {
    const ZERO: Self = Row {
        forward: [[0.0; L]; FORWARD],
        backward: [[0.0; L]; BACKWARD],
    };

    #[inline(always)]
    fn set(&mut self, k: usize, value: [f64; L]) {
        self.forward[k] = value;
        self.backward[MOST_ORDER - k] = value;
    }
}

/// Coefficients of everything on a tape, each scaled by the power of a step length, so that none overflows.
#[derive(Clone, Debug)]
pub(crate) struct Series<const L: usize> {
    rows: Vec<Row<L>>,
}

#[inline(always)]
fn lanes<const L: usize>(f: impl FnMut(usize) -> f64) -> [f64; L] {
    std::array::from_fn(f)
}

/// `Σ a_j b_j` over slices of whole chunks. The first chunk, which holds the newest coefficient of one factor, is added last:
/// all else is ready before it.
#[inline(always)]
fn dot<const L: usize>(a: &[[f64; L]], b: &[[f64; L]]) -> [f64; L] {
    let mut sums = [[0.0; L]; CHUNK];
    let mut add = |a: &[[f64; L]], b: &[[f64; L]]| {
        for j in 0..CHUNK {
            for l in 0..L {
                sums[j][l] += a[j][l] * b[j][l];
            }
        }
    };
    let mut pairs = a.chunks_exact(CHUNK).zip(b.chunks_exact(CHUNK));
    let first = pairs.next();
    for (a, b) in pairs {
        add(a, b);
    }
    if let Some((a, b)) = first {
        add(a, b);
    }
    lanes(|l| (sums[0][l] + sums[2][l]) + (sums[1][l] + sums[3][l]))
}

impl<const L: usize> Series<L> {
    pub(crate) fn new() -> Self {
        Series { rows: Vec::new() }
    }

    /// Makes room for a tape.
    pub(crate) fn fit(&mut self, tape: &Tape) {
        if self.rows.len() < tape.rows {
            self.rows.resize(tape.rows, Row::ZERO);
        }
    }

    /// Forgets everything; needed after coefficients that were not finite.
    pub(crate) fn clear(&mut self) {
        self.rows.fill(Row::ZERO);
    }

    /// Coefficient `k` of row `row`.
    #[inline(always)]
    pub(crate) fn at(&self, row: usize, k: usize) -> [f64; L] {
        self.rows[row].forward[k]
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
        for (row, x) in self.rows.iter_mut().zip(x) {
            row.set(0, *x);
        }
        self.rows[N].set(0, t);
        self.rows[N].set(1, h);
        for k in 0..order {
            for instruction in &tape.of_field {
                self.advance(tape, instruction, k);
            }
            for (i, slope) in tape.field.iter().enumerate() {
                let slope = self.combination(tape, slope, k);
                let next = lanes(|l| slope[l] * h[l] * INVERSE[k + 1]);
                self.rows[i].set(k + 1, next);
            }
        }
        for instruction in &tape.of_both {
            self.advance(tape, instruction, order);
        }
        if !tape.of_watched.is_empty() {
            for k in 0..=order {
                for instruction in &tape.of_watched {
                    self.advance(tape, instruction, k);
                }
            }
        }
    }

    /// Coefficient `k` of a combination.
    #[inline(always)]
    pub(crate) fn combination(&self, tape: &Tape, sum: &Combination, k: usize) -> [f64; L] {
        let mut value = [if k == 0 { sum.constant } else { 0.0 }; L];
        for term in &tape.terms[sum.first as usize..(sum.first + sum.count) as usize] {
            let row = &self.rows[term.node as usize].forward[k];
            for l in 0..L {
                value[l] += term.factor * row[l];
            }
        }
        value
    }

    /// `Σ_{j=0}^k a_j b_{k−j}`.
    #[inline(always)]
    fn whole(&self, a: u32, b: u32, k: usize) -> [f64; L] {
        let count = (k / CHUNK + 1) * CHUNK;
        let from = MOST_ORDER - k;
        dot(
            &self.rows[a as usize].forward[..count],
            &self.rows[b as usize].backward[from..from + count],
        )
    }

    /// `Σ_{j=1}^k a_j b_{k−j}`.
    #[inline(always)]
    fn tail(&self, a: u32, b: u32, k: usize) -> [f64; L] {
        let count = k.div_ceil(CHUNK) * CHUNK;
        let from = MOST_ORDER + 1 - k;
        dot(
            &self.rows[a as usize].forward[1..1 + count],
            &self.rows[b as usize].backward[from..from + count],
        )
    }

    #[inline(always)]
    fn advance(&mut self, tape: &Tape, instruction: &Instruction, k: usize) {
        match *instruction {
            Instruction::Combination { out, ref sum } => {
                let value = self.combination(tape, sum, k);
                self.rows[out as usize].set(k, value);
            }
            Instruction::Product { out, a, b } => {
                let value = self.whole(a, b, k);
                self.rows[out as usize].set(k, value);
            }
            Instruction::Quotient { out, a, b } => {
                let rest = self.tail(b, out, k);
                let (numerator, b0) = (self.at(a as usize, k), self.at(b as usize, 0));
                self.rows[out as usize].set(k, lanes(|l| (numerator[l] - rest[l]) / b0[l]));
            }
            Instruction::Reciprocal { out, b } => {
                let value = if k == 0 {
                    let b0 = self.at(b as usize, 0);
                    lanes(|l| 1.0 / b0[l])
                } else {
                    let (rest, first) = (self.tail(b, out, k), self.at(out as usize, 0));
                    lanes(|l| -rest[l] * first[l])
                };
                self.rows[out as usize].set(k, value);
            }
            Instruction::Root { out, a } => {
                let of_a = self.at(a as usize, k);
                let value = if k == 0 {
                    lanes(|l| of_a[l].sqrt())
                } else {
                    self.rows[out as usize].forward[k] = [0.0; L];
                    let (rest, first) = (self.tail(out, out, k), self.at(out as usize, 0));
                    lanes(|l| (of_a[l] - rest[l]) / (2.0 * first[l]))
                };
                self.rows[out as usize].set(k, value);
            }
            Instruction::Exponential { out, a, helper } => {
                let of_a = self.at(a as usize, k);
                let value = if k == 0 {
                    lanes(|l| math::exp(of_a[l]))
                } else {
                    self.rows[helper as usize].forward[k] = lanes(|l| of_a[l] * k as f64);
                    let sum = self.tail(helper, out, k);
                    lanes(|l| sum[l] * INVERSE[k])
                };
                self.rows[out as usize].set(k, value);
            }
            Instruction::Logarithm { out, a, helper } => {
                let of_a = self.at(a as usize, k);
                let value = if k == 0 {
                    lanes(|l| math::ln(of_a[l]))
                } else {
                    self.rows[helper as usize].forward[k] = [0.0; L];
                    let (rest, first) = (self.tail(helper, a, k), self.at(a as usize, 0));
                    let slope: [f64; L] = lanes(|l| (of_a[l] * k as f64 - rest[l]) / first[l]);
                    self.rows[helper as usize].forward[k] = slope;
                    lanes(|l| slope[l] * INVERSE[k])
                };
                self.rows[out as usize].set(k, value);
            }
            Instruction::SineCosine { sine, a, helper } => {
                let of_a = self.at(a as usize, k);
                let cosine = sine + 1;
                let (of_sine, of_cosine) = if k == 0 {
                    (lanes(|l| math::sin(of_a[l])), lanes(|l| math::cos(of_a[l])))
                } else {
                    self.rows[helper as usize].forward[k] = lanes(|l| of_a[l] * k as f64);
                    let up = self.tail(helper, cosine, k);
                    let down = self.tail(helper, sine, k);
                    (
                        lanes(|l| up[l] * INVERSE[k]),
                        lanes(|l| -down[l] * INVERSE[k]),
                    )
                };
                self.rows[sine as usize].set(k, of_sine);
                self.rows[cosine as usize].set(k, of_cosine);
            }
        }
    }
}
