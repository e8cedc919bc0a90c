//! Normal forms of flips and Neimark–Sacker bifurcations: whether what branches off is stable.

use std::fmt;

use nalgebra::{Complex, DMatrix, DVector};

use super::cycle::{Cycle, Shooting, closeness};
use super::monodromy::flow_derivative;
use crate::dynamics::{Dynamics, Matrix, Moment, Vector, run};
use crate::filippov::{MIN_TOLERANCE, Options};
use crate::math::modulus;

/// Side of a bifurcation on which the smaller or longer orbits, or the torus, exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Criticality {
    /// Branching orbits exist where the orbit is unstable. They attract where it has no other
    /// unstable direction.
    Supercritical,
    /// Branching orbits exist where the orbit is stable, and are unstable.
    Subcritical,
}

impl fmt::Display for Criticality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Criticality::Supercritical => "supercritical",
            Criticality::Subcritical => "subcritical",
        })
    }
}

/// The cubic coefficient of the return map on the center manifold of a bifurcation (Kuznetsov
/// 2004, Sections 5.4 and 10.3; Govaerts, Kuznetsov & Dhooge 2005).
///
/// At a flip the map is `u ↦ −u + c u³`. At a Neimark–Sacker bifurcation with the angle θ it is
/// `z ↦ exp(iθ) z (1 + d |z|²)`, and `c` is the negative real part of `d`. Both are for a critical
/// eigenvector of length 1. So `c` is positive at a supercritical bifurcation. At the strong
/// resonances 1:1 to 1:4 the second map has further terms, and the sign alone does not decide.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NormalForm {
    /// The coefficient `c`.
    pub coefficient: f64,
    /// Uncertainty: twice the change of `c` with half the distance of the orbits from which the
    /// derivatives of the map were taken, and what the tolerances leave of their differences.
    pub uncertainty: f64,
}

impl NormalForm {
    /// The side, if the sign of the coefficient is known.
    pub fn criticality(&self) -> Option<Criticality> {
        if self.coefficient.abs() <= self.uncertainty {
            return None;
        }
        match self.coefficient.partial_cmp(&0.0)? {
            std::cmp::Ordering::Greater => Some(Criticality::Supercritical),
            std::cmp::Ordering::Less => Some(Criticality::Subcritical),
            std::cmp::Ordering::Equal => None,
        }
    }
}

/// The return map near a periodic orbit: over the period of the forcing, or to the plane across the
/// orbit.
pub(super) struct ReturnMap<'a> {
    system: &'a dyn Dynamics,
    /// Number of components that are states; parameters follow them.
    states: usize,
    /// A moment of the orbit inside a phase.
    anchor: &'a Moment,
    period: f64,
    /// Whether the forcing prescribes the period.
    is_forced: bool,
    /// Extent of the orbit.
    extent: f64,
    options: Options,
}

/// The bifurcation whose coefficient is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CriticalPair {
    /// A multiplier is −1.
    Flip,
    /// A pair has this angle.
    Angle(f64),
}

impl<'a> ReturnMap<'a> {
    /// Multiples of distances for a single orbit. Chosen: both ways from the best one.
    pub const MULTIPLES: [f64; 4] = [4.0, 1.0, 0.25, 0.0625];

    /// The map near an orbit that was computed; `None` in a family.
    pub fn of(cycle: &'a Cycle, shooting: &Shooting<'a>) -> Option<Self> {
        (shooting.family == 0).then_some(ReturnMap {
            system: shooting.system,
            states: shooting.states,
            anchor: &cycle.anchor,
            period: cycle.period,
            is_forced: shooting.forced.is_some(),
            extent: cycle.extent,
            options: tight(shooting.options),
        })
    }

    /// The normal form; `None` where the map has no derivative near the orbit.
    ///
    /// Second and third derivatives are differences of first ones along neighbouring orbits, which
    /// are exact. Where a neighbour has other phases, or the noise of integration is amplified,
    /// both distances differ: the pair of distances with the least difference counts.
    ///
    /// The distances are multiples of the fifth root of the tolerances, and half of them. There
    /// the errors of truncation and of integration are about equal.
    pub fn normal_form(&self, of: CriticalPair, multiples: &[f64]) -> Option<NormalForm> {
        let chart = self.chart()?;
        let matrix = self.derivative(&chart, &Vector::zeros(chart.ncols()))?;
        let tolerance = self.options.coarsest().max(f64::EPSILON);
        let distance = self.extent * crate::math::pow(tolerance, 0.2);
        let mut best: Option<NormalForm> = None;
        let coefficient = |h: f64| self.coefficient((&chart, &matrix), of, h);
        for &multiple in multiples {
            let far = coefficient(multiple * distance);
            let near = coefficient(0.5 * multiple * distance);
            let (Some(far), Some(near)) = (far, near) else {
                continue;
            };
            let (near, noise) = near;
            let far = far.0;
            // The error is quadratic in the distance.
            let found = NormalForm {
                coefficient: (4.0 * near - far) / 3.0,
                uncertainty: 2.0 * (near - far).abs() + noise,
            };
            let is_better = |best: &NormalForm| found.uncertainty < best.uncertainty;
            if found.uncertainty.is_finite() && best.as_ref().is_none_or(is_better) {
                best = Some(found);
            }
        }
        best
    }

    /// Orthonormal directions in which the start is varied: all states or, in an autonomous system,
    /// those across the flow.
    fn chart(&self) -> Option<Matrix> {
        let n = self.states;
        if self.is_forced {
            return Some(Matrix::identity(n, n));
        }
        let normal = self.normal()?;
        let mut basis = Matrix::from_columns(&[normal]).insert_columns(1, n, 0.0);
        basis.columns_mut(1, n).fill_with_identity();
        let orthogonal = basis.qr().q();
        Some(orthogonal.columns(1, n - 1).into_owned())
    }

    /// The direction of the flow at the anchor.
    fn normal(&self) -> Option<Vector> {
        let begun = self
            .system
            .begin(self.anchor, self.anchor.t + self.period, &self.options, &[]);
        let mode = begun.ok()?.mode();
        let velocity = self.system.flow(mode, self.anchor).velocity(self.anchor);
        let own = velocity.rows(0, self.states).into_owned();
        own.try_normalize(0.0)
    }

    /// The derivative of the map at an offset from the orbit, in the chart.
    fn derivative(&self, chart: &Matrix, offset: &Vector) -> Option<Matrix> {
        // Newton's iteration for the time of return converges quadratically from the period.
        const ITERATIONS: usize = 4;
        let (system, n) = (self.system, self.states);
        let mut start = self.anchor.clone();
        let moved = start.x.rows(0, n) + chart * offset;
        start.x.rows_mut(0, n).copy_from(&moved);
        let mut t_end = start.t + self.period;
        if self.is_forced {
            let (found, _) = flow_derivative(system, &start, t_end, &self.options, false).ok()?;
            return Some(found.matrix.view((0, 0), (n, n)).into_owned());
        }
        let normal = self.normal()?;
        let velocity = |at: &Moment| -> Option<Vector> {
            let begun = system
                .begin(at, at.t + self.period, &self.options, &[])
                .ok()?;
            let all = system.flow(begun.mode(), at).velocity(at);
            Some(all.rows(0, n).into_owned())
        };
        for _ in 0..ITERATIONS {
            let end = run(system, &start, t_end, &self.options).ok()?;
            let at = Moment {
                t: end.t,
                x: end.x.clone(),
            };
            let off = end.x.rows(0, n) - self.anchor.x.rows(0, n);
            t_end -= normal.dot(&off) / normal.dot(&velocity(&at)?);
            if !t_end.is_finite() || (t_end - start.t - self.period).abs() > 0.5 * self.period {
                return None;
            }
        }
        let (found, rate) = flow_derivative(system, &start, t_end, &self.options, false).ok()?;
        let flow = found.matrix.view((0, 0), (n, n)).into_owned();
        let rate = rate.rows(0, n).into_owned();
        let along = normal.transpose() * &flow / normal.dot(&rate);
        let section = flow - rate * along;
        Some(chart.transpose() * section * chart)
    }

    /// The coefficient, from neighbours at a distance, and what the tolerances leave of it.
    fn coefficient(
        &self,
        (chart, matrix): (&Matrix, &Matrix),
        of: CriticalPair,
        h: f64,
    ) -> Option<(f64, f64)> {
        let size = matrix.nrows();
        // An orbit at this distance is as accurate as orbits close, and the derivatives of what
        // remains by the distance.
        let noise = closeness(&self.options) * self.extent / (h * h * h);
        // First and second derivative of the map's derivative along a direction.
        let along = |direction: &Vector| -> Option<[DMatrix<Complex<f64>>; 2]> {
            let ahead = self.derivative(chart, &(direction * h))?;
            let behind = self.derivative(chart, &(direction * -h))?;
            let first = (&ahead - &behind) / (2.0 * h);
            let second = (ahead - matrix * 2.0 + behind) / (h * h);
            Some([complex(&first), complex(&second)])
        };
        let identity = DMatrix::<Complex<f64>>::identity(size, size);
        let own = complex(matrix);
        match of {
            CriticalPair::Flip => {
                let [q, p] = null_vectors(&own + &identity)?;
                // The eigenvector is real, up to a factor.
                let sizes = q.iter().map(|entry| (modulus(*entry), entry));
                let (size, largest) = sizes.max_by(|a, b| a.0.total_cmp(&b.0))?;
                let phase = largest.conj() / size;
                let real = (&q * phase).map(|entry| entry.re).normalize();
                let q = real.map(|entry| Complex::new(entry, 0.0));
                let p = &p / p.dotc(&q).conj();
                let [first, second] = along(&real)?;
                let square = &first * &q;
                let shifted = (&identity - &own).lu().solve(&square)?;
                // The second derivative is symmetric: along q of what is moved by it.
                let cubic = &second * &q + (&first * shifted) * Complex::new(3.0, 0.0);
                Some((p.dotc(&cubic).re / 6.0, noise * p.norm()))
            }
            CriticalPair::Angle(angle) => {
                let turn = Complex::new(crate::math::cos(angle), crate::math::sin(angle));
                let [q, p] = null_vectors(&own - &identity * turn)?;
                let p = &p / p.dotc(&q).conj();
                let [a, b] = [q.map(|entry| entry.re), q.map(|entry| entry.im)];
                let conjugate = q.map(|entry| entry.conj());
                let [one, two] = [along(&a)?, along(&b)?];
                let unit = Complex::new(0.0, 1.0);
                // Derivatives along q and along its conjugate.
                let by_q = &one[0] + &two[0] * unit;
                let by_conjugate = &one[0] - &two[0] * unit;
                let mixed = &by_q * &conjugate;
                let square = &by_q * &q;
                let shifted = (&identity - &own).lu().solve(&mixed)?;
                let doubled = (&identity * (turn * turn) - &own).lu().solve(&square)?;
                let cubic = (&one[1] + &two[1]) * &q
                    + (&by_q * shifted) * Complex::new(2.0, 0.0)
                    + &by_conjugate * doubled;
                Some((-(turn.conj() * p.dotc(&cubic)).re / 2.0, noise * p.norm()))
            }
        }
    }
}

/// Smaller tolerances: at small distances, effects of third order are far below the orbit's size.
fn tight(options: &Options) -> Options {
    // Fraction of the tolerances. Chosen: a step is then about a third shorter.
    const TIGHTER: f64 = 1e-3;
    Options {
        rtol: (TIGHTER * options.rtol).max(MIN_TOLERANCE),
        atol: options.atol.map(|atol| TIGHTER * atol),
        ..*options
    }
}

fn complex(matrix: &Matrix) -> DMatrix<Complex<f64>> {
    matrix.map(|entry| Complex::new(entry, 0.0))
}

/// The unit vectors that a nearly singular matrix and its adjoint take to nearly zero.
fn null_vectors(matrix: DMatrix<Complex<f64>>) -> Option<[DVector<Complex<f64>>; 2]> {
    if !matrix
        .iter()
        .all(|entry| entry.re.is_finite() && entry.im.is_finite())
    {
        return None;
    }
    let parts = matrix.svd(true, true);
    let (left, right) = (parts.u?, parts.v_t?);
    let values = parts.singular_values.iter().enumerate();
    let (least, _) = values.min_by(|a, b| a.1.total_cmp(b.1))?;
    Some([right.row(least).adjoint(), left.column(least).into_owned()])
}
