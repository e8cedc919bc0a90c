//! What each operation's next coefficient is (Griewank & Walther, *Evaluating Derivatives*, 2008, Ch. 13).

use super::{INVERSE, Series, lanes};
use crate::math;
use crate::taylor::tape::{Instruction, Numbers, Tape};

impl<const L: usize> Series<L> {
    /// Coefficient `k` of everything that one instruction computes.
    #[inline(always)]
    pub(super) fn advance<const K: usize>(
        &mut self,
        tape: &Tape,
        numbers: &Numbers<L>,
        instruction: &Instruction,
    ) {
        let of = |series: &Self, row: u32| series.lanes_at(row as usize, K);
        let first = |series: &Self, row: u32| series.lanes_at(row as usize, 0);
        match *instruction {
            Instruction::Combination { out, ref sum } => {
                let value = self.combine(tape, numbers, sum, K);
                self.set(out as usize, K, value);
            }
            Instruction::Product { out, a, b } => {
                let sum = self.convolution::<K>(a, b);
                let (a0, b0) = (first(self, a), first(self, b));
                let value = if K == 0 {
                    lanes(|l| a0[l] * b0[l])
                } else {
                    let (of_a, of_b) = (of(self, a), of(self, b));
                    lanes(|l| sum[l] + (of_a[l] * b0[l] + a0[l] * of_b[l]))
                };
                self.set(out as usize, K, value);
            }
            Instruction::Square { out, a } => {
                let sum = self.convolution_with_itself::<K>(a);
                let (a0, of_a) = (first(self, a), of(self, a));
                let value = if K == 0 {
                    lanes(|l| a0[l] * a0[l])
                } else {
                    lanes(|l| sum[l] + 2.0 * a0[l] * of_a[l])
                };
                self.set(out as usize, K, value);
            }
            Instruction::Quotient { out, a, b } => {
                let sum = self.convolution::<K>(b, out);
                let (b0, of_a) = (first(self, b), of(self, a));
                let value = if K == 0 {
                    lanes(|l| of_a[l] / b0[l])
                } else {
                    let (of_b, q0) = (of(self, b), first(self, out));
                    lanes(|l| (of_a[l] - (sum[l] + of_b[l] * q0[l])) / b0[l])
                };
                self.set(out as usize, K, value);
            }
            Instruction::Reciprocal { out, b } => {
                let sum = self.convolution::<K>(b, out);
                let of_b = of(self, b);
                let value = if K == 0 {
                    lanes(|l| 1.0 / of_b[l])
                } else {
                    let q0 = first(self, out);
                    lanes(|l| -(sum[l] + of_b[l] * q0[l]) * q0[l])
                };
                self.set(out as usize, K, value);
            }
            Instruction::Root { out, a } => {
                let sum = self.convolution_with_itself::<K>(out);
                let of_a = of(self, a);
                let value = if K == 0 {
                    lanes(|l| of_a[l].sqrt())
                } else {
                    let r0 = first(self, out);
                    lanes(|l| (of_a[l] - sum[l]) / (2.0 * r0[l]))
                };
                self.set(out as usize, K, value);
            }
            Instruction::Exponential { out, a, helper } => {
                let sum = self.convolution::<K>(helper, out);
                let slope = self.slope(a, helper, K);
                let value = if K == 0 {
                    let a0 = first(self, a);
                    lanes(|l| math::exp(a0[l]))
                } else {
                    let e0 = first(self, out);
                    lanes(|l| (sum[l] + slope[l] * e0[l]) * INVERSE[K])
                };
                self.set(out as usize, K, value);
            }
            Instruction::Logarithm { out, a, helper } => {
                let sum = self.convolution::<K>(helper, a);
                let (a0, of_a) = (first(self, a), of(self, a));
                let value = if K == 0 {
                    self.set(helper as usize, 0, [0.0; L]);
                    lanes(|l| math::ln(a0[l]))
                } else {
                    let slope: [f64; L] = lanes(|l| (of_a[l] * K as f64 - sum[l]) / a0[l]);
                    self.set(helper as usize, K, slope);
                    lanes(|l| slope[l] * INVERSE[K])
                };
                self.set(out as usize, K, value);
            }
            Instruction::SineCosineOfTime { sine, a } => {
                let cosine = sine + 1;
                let (up, down) = if K == 0 {
                    let a0 = first(self, a);
                    (lanes(|l| math::sin(a0[l])), lanes(|l| math::cos(a0[l])))
                } else {
                    let slope = self.lanes_at(a as usize, 1);
                    let last = |row| self.lanes_at(row as usize, K - 1);
                    let (s, c) = (last(sine), last(cosine));
                    (
                        lanes(|l| slope[l] * c[l] * INVERSE[K]),
                        lanes(|l| -(slope[l] * s[l] * INVERSE[K])),
                    )
                };
                self.set(sine as usize, K, up);
                self.set(cosine as usize, K, down);
            }
            Instruction::SineCosine { sine, a, helper } => {
                let cosine = sine + 1;
                let of_sine = self.convolution::<K>(helper, cosine);
                let of_cosine = self.convolution::<K>(helper, sine);
                let slope = self.slope(a, helper, K);
                let (up, down) = if K == 0 {
                    let a0 = first(self, a);
                    (lanes(|l| math::sin(a0[l])), lanes(|l| math::cos(a0[l])))
                } else {
                    let (s0, c0) = (first(self, sine), first(self, cosine));
                    (
                        lanes(|l| (of_sine[l] + slope[l] * c0[l]) * INVERSE[K]),
                        lanes(|l| -(of_cosine[l] + slope[l] * s0[l]) * INVERSE[K]),
                    )
                };
                self.set(sine as usize, K, up);
                self.set(cosine as usize, K, down);
            }
        }
    }

    /// Coefficient `K` of the product of two rows, without the two terms that have a coefficient 0: those with the newest
    /// coefficients are added last, so that nothing waits for them.
    #[inline(always)]
    fn convolution<const K: usize>(&self, a: u32, b: u32) -> [f64; L] {
        let (a, b) = (&self.rows[a as usize], &self.rows[b as usize]);
        let mut sum = [0.0; L];
        if K >= 2 && K.is_multiple_of(2) {
            sum = lanes(|l| a[K / 2][l] * b[K / 2][l]);
        }
        for j in (1..K.div_ceil(2)).rev() {
            for l in 0..L {
                sum[l] += a[j][l] * b[K - j][l] + a[K - j][l] * b[j][l];
            }
        }
        sum
    }

    /// The same for a square.
    #[inline(always)]
    fn convolution_with_itself<const K: usize>(&self, a: u32) -> [f64; L] {
        let a = &self.rows[a as usize];
        let mut sum = [0.0; L];
        for j in (1..K.div_ceil(2)).rev() {
            for l in 0..L {
                sum[l] += a[j][l] * a[K - j][l];
            }
        }
        lanes(|l| {
            let pairs = 2.0 * sum[l];
            if K >= 2 && K.is_multiple_of(2) {
                pairs + a[K / 2][l] * a[K / 2][l]
            } else {
                pairs
            }
        })
    }

    /// Coefficient `k` of `s a'(s)`.
    #[inline(always)]
    fn slope(&mut self, a: u32, helper: u32, k: usize) -> [f64; L] {
        let of_a = self.lanes_at(a as usize, k);
        let slope = lanes(|l| of_a[l] * k as f64);
        self.set(helper as usize, k, slope);
        slope
    }
}
