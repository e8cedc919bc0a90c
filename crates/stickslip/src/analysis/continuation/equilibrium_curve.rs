//! Curves of special equilibria in two parameters.

use std::fmt;

use nalgebra::Complex;

use super::both_ways::{CurveEndOf, FollowedCurve, SpecialOnCurve, follow_both_ways};
use super::curve::others;
use super::equilibrium::{
    BranchEquilibrium, EquilibriaOnLine, EquilibriumBifurcation, EquilibriumContinuation,
    EquilibriumTangent, ROUNDING, SpecialEquilibrium,
};
use super::tangent_line::LEAST_COSINE;
use super::{ContinuationSettings, CurveStop, check_rate, check_start};
use crate::analysis::attractors::equilibrium::ZERO;
use crate::analysis::critical::RESOLVED_PLACE;
use crate::analysis::cycle::{SolutionsOnLine, unit, with_last_digits};
use crate::dynamics::{AsDynamics, Modes, Moment, Vector};
use crate::error::{Error, require};

/// A bifurcation of codimension two, at an equilibrium on a curve in two parameters (Kuznetsov
/// 2004, Ch. 8; di Bernardo, Budd, Champneys & Kowalczyk 2008, Ch. 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquilibriumCurveBifurcation {
    /// A cusp: two folds meet, and both parameters turn back along the curve.
    Cusp,
    /// A Bogdanov–Takens point: two eigenvalues are zero, and a curve of Hopf bifurcations ends on
    /// one of folds.
    BogdanovTakens,
    /// A fold–Hopf point: an eigenvalue is zero, and a pair is imaginary.
    FoldHopf,
    /// Two pairs of eigenvalues are imaginary.
    DoubleHopf,
    /// An eigenvalue is zero at a boundary equilibrium.
    FoldAtBoundary,
    /// A pair of eigenvalues is imaginary at a boundary equilibrium.
    HopfAtBoundary,
    /// The equilibrium lies on two boundaries, or on both edges of a sliding region.
    TwoBoundaries,
}

impl fmt::Display for EquilibriumCurveBifurcation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EquilibriumCurveBifurcation::Cusp => "cusp",
            EquilibriumCurveBifurcation::BogdanovTakens => "Bogdanov-Takens",
            EquilibriumCurveBifurcation::FoldHopf => "fold-Hopf",
            EquilibriumCurveBifurcation::DoubleHopf => "double Hopf",
            EquilibriumCurveBifurcation::FoldAtBoundary => "fold at boundary equilibrium",
            EquilibriumCurveBifurcation::HopfAtBoundary => "Hopf at boundary equilibrium",
            EquilibriumCurveBifurcation::TwoBoundaries => "equilibrium at two boundaries",
        })
    }
}

/// An equilibrium on a curve of special ones.
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumCurvePoint {
    /// The two parameters, which are the last two states; the branch parameter comes last.
    pub parameters: [f64; 2],
    /// The state, with both parameters.
    pub x: Vector,
    /// At a Hopf bifurcation, the absolute value of the imaginary pair: angle per unit of time.
    pub frequency: Option<f64>,
}

/// A special equilibrium on a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumCurveSpecial {
    /// Both parameters, as in [`EquilibriumCurvePoint::parameters`].
    pub parameters: [f64; 2],
    /// Uncertainty of each parameter, as in [`SpecialEquilibrium::uncertainty`].
    pub uncertainties: [f64; 2],
    /// The bifurcation.
    pub what: EquilibriumCurveBifurcation,
    /// Number of equilibria in [`EquilibriumCurve::points`] before it.
    pub behind: usize,
    /// The state, with both parameters.
    pub x: Vector,
}

/// A curve of special equilibria in two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumCurve {
    /// The equilibrium at which it begins.
    pub at: SpecialEquilibrium,
    /// The equilibria, from one end of the curve to the other. A closed curve ends with its first
    /// one.
    pub points: Vec<EquilibriumCurvePoint>,
    /// The special ones between them, in the same order. An end may be one.
    pub special: Vec<EquilibriumCurveSpecial>,
    /// Index of the equilibrium at which it began.
    pub first: usize,
    /// Why the curve ends before the first and behind the last equilibrium.
    pub stops: [CurveStop; 2],
}

impl SpecialEquilibrium {
    /// Follows in two parameters a fold, a Hopf bifurcation or a boundary equilibrium of a branch.
    ///
    /// **The parameters are the last two states.** The last is the branch parameter, as in
    /// [`super::EquilibriumBranch::through`]; the other has the value `other` on the branch, and a
    /// range. In the plane across the curve, equilibria form a branch. The function that vanishes
    /// at the special equilibrium has a zero on it. At a fold it is the determinant of the
    /// Jacobian. At a Hopf bifurcation it is the sum of a pair of eigenvalues, and at a boundary
    /// equilibrium a guard of the mode. So curves pass their own folds, and curves of folds pass
    /// cusps. `sizes` are those of the states, [`super::EquilibriumBranch::sizes`], in whose units
    /// steps are measured.
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that is not allowed; [`Error::Parameter`] where the last two
    /// states are no parameters; [`Error::NotFound`] where no curve continues from the equilibrium:
    /// a branch point has none.
    ///
    /// ```
    /// use stickslip::analysis::{
    ///     ContinuationSettings, EquilibriumBranch, EquilibriumCurveBifurcation,
    /// };
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// x' = p + q x - x³ has folds at 27 p² = 4 q³, which meet in a cusp.
    /// struct Cusp<const N: usize>;
    /// impl<const N: usize> Filippov<N> for Cusp<N> {
    ///     fn field<T: Scalar>(&self, _side: Side, _t: T, x: &[T; N]) -> [T; N] {
    ///         let q = if N == 3 { x[1] } else { T::constant(1.0) };
    ///         let mut rate = [T::constant(0.0); N];
    ///         rate[0] = x[N - 1] + q * x[0] - x[0] * x[0] * x[0];
    ///         rate
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; N]) -> T {
    ///         x[0] - 10.0
    ///     }
    /// }
    ///
    /// let settings = ContinuationSettings::over(-1.0, 1.0);
    /// let options = Options::tol(1e-12);
    /// let start = [1.0, 0.0];
    /// let branch = EquilibriumBranch::through(&Cusp::<2>, start, false, &settings, &options)?;
    /// let how = (&settings, (-1.0, 2.0));
    /// let at = &branch.special[0];
    /// let curve = at.curve(&Cusp::<3>, (1.0, &branch.sizes), how)?;
    /// assert_eq!(curve.special[0].what, EquilibriumCurveBifurcation::Cusp);
    /// for point in &curve.points {
    ///     let [q, p] = point.parameters;
    ///     assert!((27.0 * p * p - 4.0 * q * q * q).abs() < 1e-11);
    /// }
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    pub fn curve<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        (other, sizes): (f64, &Vector),
        (settings, range): (&ContinuationSettings, (f64, f64)),
    ) -> Result<EquilibriumCurve, Error> {
        settings.check()?;
        ContinuationSettings::over(range.0, range.1).check()?;
        let system = &*system.dynamics();
        let place = self.x.len() - 1;
        let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        let is_size = sizes.len() == place && least > 0.0 && sizes.amax() < f64::INFINITY;
        require(
            is_size,
            "sizes",
            least,
            "positive and finite, one for each state",
        )?;
        let x = self.x.clone().insert_row(place, other);
        check_start(&x, 2, settings)?;
        let begin = Moment { t: 0.0, x };
        let velocity = system.flow(self.mode, &begin).velocity(&begin);
        check_rate(velocity[place])?;
        check_rate(velocity[place + 1])?;
        let not_found = Error::NotFound {
            what: "a curve of the special equilibrium",
            t: 0.0,
            span: 0.0,
        };
        let condition = match self.what {
            EquilibriumBifurcation::Fold => Some(Condition::Fold),
            EquilibriumBifurcation::Hopf { frequency } => {
                Some(Condition::Pair(frequency * frequency))
            }
            EquilibriumBifurcation::Boundary { contact, .. } => {
                let flow = system.flow(self.mode, &begin);
                let guards = flow.guards().into_iter();
                let guards = guards.filter(|guard| guard.is_condition && guard.contact == contact);
                let values =
                    guards.map(|guard| (guard.number, flow.guard(guard.number, &begin).abs()));
                let least = values.min_by(|a, b| a.1.total_cmp(&b.1));
                least.map(|(number, _)| Condition::Guard(number))
            }
            EquilibriumBifurcation::BranchPoint | EquilibriumBifurcation::Unresolved { .. } => None,
        };
        let condition = condition.ok_or(not_found.clone())?;
        let largest = sizes.amax();
        let mut units = sizes.clone().resize_vertically(place + 2, largest);
        units[place] = range.1 - range.0;
        units[place + 1] = settings.range.1 - settings.range.0;
        let curve = CurveOfEquilibria {
            of: EquilibriumContinuation {
                system,
                settings,
                units,
                largest,
                parameters: 2,
            },
            mode: self.mode,
            ranges: [range, settings.range],
        };
        let first = curve.first(&begin.x, condition).ok_or(not_found)?;
        let whole = follow_both_ways(&curve, &first, first.point());
        Ok(EquilibriumCurve {
            at: self.clone(),
            points: whole.points,
            special: whole.special,
            first: whole.first,
            stops: whole.stops,
        })
    }
}

impl SpecialOnCurve for EquilibriumCurveSpecial {
    type What = EquilibriumCurveBifurcation;

    fn known(&self) -> (&EquilibriumCurveBifurcation, [f64; 2], [f64; 2]) {
        (&self.what, self.parameters, self.uncertainties)
    }

    fn behind(&mut self) -> &mut usize {
        &mut self.behind
    }
}

/// The function that vanishes on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Condition {
    /// The determinant of the Jacobian.
    Fold,
    /// The sum of two eigenvalues, both real or conjugate. Near an equilibrium of the curve they
    /// have this product.
    Pair(f64),
    /// The guard of this number.
    Guard(usize),
}

/// Sum and product of the two eigenvalues whose sum is nearest to zero and whose product is nearest
/// to a given one, and the other eigenvalues.
fn pair_near(values: &[Complex<f64>], product: f64) -> Option<(f64, f64, Vec<Complex<f64>>)> {
    let all = (0..values.len()).flat_map(|i| (i + 1..values.len()).map(move |j| (i, j)));
    let pairs = all.map(|(i, j)| ((i, j), values[i] + values[j], values[i] * values[j]));
    // Two real ones, or one with its conjugate.
    let pairs = pairs.filter(|(_, sum, product)| sum.im == 0.0 && product.im == 0.0);
    let off = |sum: f64, other: f64| sum * sum + (other - product).abs();
    let nearest = pairs.min_by(|a, b| off(a.1.re, a.2.re).total_cmp(&off(b.1.re, b.2.re)));
    let ((i, j), sum, product) = nearest?;
    let others = values.iter().enumerate();
    let others = others.filter(|(k, _)| *k != i && *k != j);
    Some((sum.re, product.re, others.map(|(_, one)| *one).collect()))
}

/// The real part of the pair nearest to the imaginary axis.
fn rate_of_pair(values: &[Complex<f64>]) -> Option<f64> {
    let pairs = values.iter().filter(|one| one.im > 0.0);
    let rates = pairs.map(|one| one.re);
    rates.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// An equilibrium of the curve, and the line on which the curve leaves it.
#[derive(Clone)]
struct CurveEquilibrium {
    one: BranchEquilibrium,
    condition: Condition,
    /// The line along the curve.
    along: EquilibriumTangent,
    /// The line across it, on which the condition has a zero.
    across: EquilibriumTangent,
}

impl CurveEquilibrium {
    fn parameters(&self) -> [f64; 2] {
        let x = &self.one.at.x;
        [x[x.len() - 2], x[x.len() - 1]]
    }

    fn point(&self) -> EquilibriumCurvePoint {
        let frequency = match self.condition {
            Condition::Pair(product) => Some(product.max(0.0).sqrt()),
            _ => None,
        };
        EquilibriumCurvePoint {
            parameters: self.parameters(),
            x: self.one.at.x.clone(),
            frequency,
        }
    }
}

/// A function of the equilibria of a curve.
type EquilibriumFunction<'f> = dyn Fn(&CurveEquilibrium) -> Option<f64> + 'f;

/// The continuation of a curve.
struct CurveOfEquilibria<'a> {
    of: EquilibriumContinuation<'a>,
    mode: Modes,
    /// Ranges of both parameters.
    ranges: [(f64, f64); 2],
}

/// The equilibria of the curve, by their places on the line from one of them.
struct OnCurve<'l> {
    curve: &'l CurveOfEquilibria<'l>,
    from: &'l CurveEquilibrium,
    /// Which parameter is asked for.
    which: usize,
}

impl SolutionsOnLine for OnCurve<'_> {
    type Solution = CurveEquilibrium;

    fn on(&self, place: f64) -> Option<CurveEquilibrium> {
        self.curve.on(self.from, place)
    }

    fn finer(&self, place: f64) -> Option<CurveEquilibrium> {
        self.on(place)
    }

    fn parameter(&self, one: &CurveEquilibrium) -> f64 {
        one.parameters()[self.which]
    }
}

/// A zero of a function on the curve.
struct Located {
    s: f64,
    at: CurveEquilibrium,
    uncertainties: [f64; 2],
}

/// An end of the curve.
type EquilibriumCurveEnd = CurveEndOf<EquilibriumCurvePoint, EquilibriumCurveSpecial>;

impl CurveOfEquilibria<'_> {
    fn value(&self, condition: Condition, one: &BranchEquilibrium) -> Option<f64> {
        match condition {
            Condition::Fold => Some(one.along.determinant()),
            Condition::Pair(product) => Some(pair_near(&one.eigenvalues(), product)?.0),
            Condition::Guard(number) => Some(
                self.of
                    .system
                    .flow(self.mode, &one.at)
                    .guard(number, &one.at),
            ),
        }
    }

    /// The condition near another equilibrium of the curve.
    fn near(condition: Condition, one: &BranchEquilibrium) -> Condition {
        match condition {
            Condition::Pair(product) => Condition::Pair(
                pair_near(&one.eigenvalues(), product).map_or(product, |(_, product, _)| product),
            ),
            other => other,
        }
    }

    /// The equilibrium of the curve at which a branch has come to it, found again.
    fn first(&self, x: &Vector, condition: Condition) -> Option<CurveEquilibrium> {
        // At a fold, the parameters do not determine the state beside it.
        let [a, b] = self.of.plane_at(self.mode, x)?;
        let one = self.of.solve(self.mode, x, &[&a, &b])?;
        let count = x.len();
        let found = self.found(one, condition, &unit(count, count - 2))?;
        let guess = found.one.at.x.clone();
        self.corrected(&found, guess, &found.along.row)
    }

    /// An equilibrium of the curve with its lines: in the plane of all equilibria there, the
    /// condition changes fastest across the curve and not along it. The product with a row grows
    /// along it.
    fn found(
        &self,
        one: BranchEquilibrium,
        condition: Condition,
        row: &Vector,
    ) -> Option<CurveEquilibrium> {
        // Distance of the equilibria whose difference is a derivative, in units of the components.
        // Chosen: truncation, its square, and rounding over it are both below 1e-10.
        const APART: f64 = 1e-5;
        let (values, directions) = self.of.parts(&one);
        let directions = directions?;
        let rows = directions.nrows();
        if rows < 2
            || values
                .iter()
                .filter(|one| **one <= ZERO * values.max())
                .count()
                > 2
        {
            return None;
        }
        let axes = [rows - 2, rows - 1].map(|k| directions.row(k).transpose());
        let line = |direction: &Vector, other: &Vector| EquilibriumTangent {
            mode: self.mode,
            from: one.at.x.clone(),
            direction: direction.component_mul(&self.of.units),
            row: direction.component_div(&self.of.units),
            plane: Some(other.component_div(&self.of.units)),
        };
        let condition = Self::near(condition, &one);
        let rate = |line: &EquilibriumTangent| {
            let path = self.of.on(line);
            let [a, b] = [-APART, APART].map(|s| self.value(condition, &path.on(s)?));
            Some((b? - a?) / (2.0 * APART))
        };
        let [a, b] = [(0, 1), (1, 0)].map(|(k, other)| rate(&line(&axes[k], &axes[other])));
        let (a, b) = (a?, b?);
        let length = (a * a + b * b).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let across = (&axes[0] * a + &axes[1] * b) / length;
        let mut along = (&axes[1] * a - &axes[0] * b) / length;
        if row.dot(&along.component_mul(&self.of.units)) < 0.0 {
            along.neg_mut();
        }
        Some(CurveEquilibrium {
            along: line(&along, &across),
            across: line(&across, &along),
            condition,
            one,
        })
    }

    /// The equilibrium of the curve near a guess, in the plane through it across the curve.
    fn corrected(
        &self,
        near: &CurveEquilibrium,
        guess: Vector,
        row: &Vector,
    ) -> Option<CurveEquilibrium> {
        let line = EquilibriumTangent {
            from: guess,
            ..near.across.clone()
        };
        let path: EquilibriaOnLine<'_> = self.of.on(&line);
        let value = |one: &BranchEquilibrium| self.value(near.condition, one);
        let begin = path.on(0.0)?;
        let at_begin = value(&begin)?;
        let one = if at_begin == 0.0 {
            begin
        } else {
            let step = self.of.settings.step;
            let ends = path.bracket((0.0, at_begin), step, &value)?;
            let (s, one) = path.root(ends, &value)?;
            (s.abs() <= step).then_some(one)?
        };
        self.found(one, near.condition, row)
    }

    /// The equilibrium of the curve at a place on the line from another one.
    fn on(&self, from: &CurveEquilibrium, s: f64) -> Option<CurveEquilibrium> {
        let guess = &from.along.from + &from.along.direction * s;
        self.corrected(from, guess, &from.along.row)
    }

    /// The zero of a function between two places on the line from an equilibrium.
    fn located(
        &self,
        from: &CurveEquilibrium,
        ends: [(f64, f64); 2],
        function: &EquilibriumFunction<'_>,
    ) -> Option<Located> {
        let on = |which| OnCurve {
            curve: self,
            from,
            which,
        };
        let (s, at) = on(0).root(ends, function)?;
        let length = ends[1].0 - ends[0].0;
        let uncertainties = [0, 1].map(|which| {
            let (low, high) = self.ranges[which];
            let width = high - low;
            let found = on(which).uncertainty((s, &at), length, function);
            // Places on the curve and across it are located to so much of the ranges.
            let resolved = 2.0 * RESOLVED_PLACE * width;
            with_last_digits(
                (at.parameters()[which], found.unwrap_or(f64::NAN) + resolved),
                length * width,
                (width, 1),
            )
        });
        Some(Located {
            s,
            at,
            uncertainties,
        })
    }

    /// The functions whose zeros are special equilibria on the curve, with their names.
    fn tests(&self) -> Vec<(EquilibriumCurveBifurcation, Box<EquilibriumFunction<'_>>)> {
        use EquilibriumCurveBifurcation as Name;
        let determinant = |at: &CurveEquilibrium| Some(at.one.along.determinant());
        let rate = |at: &CurveEquilibrium| rate_of_pair(&at.one.eigenvalues());
        let besides = |at: &CurveEquilibrium| match at.condition {
            Condition::Pair(product) => Some(pair_near(&at.one.eigenvalues(), product)?.2),
            _ => None,
        };
        vec![
            (
                Name::BogdanovTakens,
                Box::new(|at: &CurveEquilibrium| {
                    let is_fold = at.condition == Condition::Fold;
                    is_fold.then(|| others(&at.one.eigenvalues(), 0.0))
                }) as Box<EquilibriumFunction<'_>>,
            ),
            (
                Name::FoldHopf,
                Box::new(move |at: &CurveEquilibrium| match at.condition {
                    Condition::Fold => rate(at),
                    Condition::Pair(_) => Some(besides(at)?.iter().product::<Complex<f64>>().re),
                    Condition::Guard(_) => None,
                }),
            ),
            (
                Name::DoubleHopf,
                Box::new(move |at: &CurveEquilibrium| rate_of_pair(&besides(at)?)),
            ),
            (
                Name::FoldAtBoundary,
                Box::new(move |at: &CurveEquilibrium| match at.condition {
                    Condition::Guard(_) => determinant(at),
                    _ => None,
                }),
            ),
            (
                Name::HopfAtBoundary,
                Box::new(move |at: &CurveEquilibrium| match at.condition {
                    Condition::Guard(_) => rate(at),
                    _ => None,
                }),
            ),
        ]
    }

    /// The cusp between two folds, at which both parameters are at rest along the curve.
    fn cusp(
        &self,
        (at, next): (&CurveEquilibrium, &CurveEquilibrium),
        length: f64,
    ) -> Option<Located> {
        // Rate of the parameters at a cusp, as a fraction of that at the ends. Chosen: where the
        // curve only turns, it is about 1.
        const AT_REST: f64 = 1e-2;
        let rates = |one: &CurveEquilibrium| {
            let direction = one.along.direction.component_div(&self.of.units);
            direction.rows(direction.len() - 2, 2).into_owned()
        };
        let ahead = rates(at);
        let function = |one: &CurveEquilibrium| Some(rates(one).dot(&ahead));
        let [a, b] = [at, next].map(function);
        let (a, b) = (a?, b?);
        if a <= 0.0 || b >= 0.0 {
            return None;
        }
        let located = self.located(at, [(0.0, a), (length, b)], &function)?;
        let is_at_rest =
            rates(&located.at).norm() <= AT_REST * ahead.norm().max(rates(next).norm());
        is_at_rest.then_some(located)
    }

    /// The special equilibrium that was located on the curve.
    fn described(
        &self,
        located: &Located,
        what: EquilibriumCurveBifurcation,
        behind: usize,
    ) -> EquilibriumCurveSpecial {
        EquilibriumCurveSpecial {
            parameters: located.at.parameters(),
            uncertainties: located.uncertainties,
            what,
            behind,
            x: located.at.one.at.x.clone(),
        }
    }

    /// The first equilibrium, if the curve comes back to it between two others.
    fn closes(
        &self,
        (at, length): (&CurveEquilibrium, f64),
        first: &CurveEquilibrium,
    ) -> Option<EquilibriumCurveEnd> {
        let s = at.along.row.dot(&(&first.one.at.x - &at.along.from));
        if !(0.0..=length).contains(&s) {
            return None;
        }
        let found = self.on(at, s)?;
        let is_first = self.of.are_same(&found.one.at.x, &first.one.at.x);
        is_first.then(|| EquilibriumCurveEnd {
            s,
            stop: CurveStop::Closed,
            last: first.point(),
            special: None,
        })
    }
}

impl FollowedCurve for CurveOfEquilibria<'_> {
    type First = CurveEquilibrium;
    type At = CurveEquilibrium;
    type Point = EquilibriumCurvePoint;
    type Special = EquilibriumCurveSpecial;

    fn settings(&self) -> &ContinuationSettings {
        self.of.settings
    }

    fn begin(&self, first: &CurveEquilibrium, sign: f64) -> Option<CurveEquilibrium> {
        let mut at = first.clone();
        at.along.direction *= sign;
        at.along.row *= sign;
        Some(at)
    }

    fn next(
        &self,
        at: &CurveEquilibrium,
        step: f64,
    ) -> Option<(CurveEquilibrium, EquilibriumCurvePoint, usize)> {
        let next = self.on(at, step)?;
        let (point, iterations) = (next.point(), next.one.iterations);
        let bends_little = at.along.row.dot(&next.along.direction) >= LEAST_COSINE;
        bends_little.then_some((next, point, iterations))
    }

    fn end_before(&self, _: &CurveEquilibrium, _: f64, _: usize) -> Option<EquilibriumCurveEnd> {
        None
    }

    fn ends(
        &self,
        (at, next): (&CurveEquilibrium, &CurveEquilibrium),
        first: &CurveEquilibrium,
        (length, number): (f64, usize),
    ) -> Result<Vec<EquilibriumCurveEnd>, Option<CurveStop>> {
        use EquilibriumCurveBifurcation as Name;
        let mut ends = Vec::new();
        let end =
            |values: [f64; 2], function: &EquilibriumFunction<'_>, stop, what: Option<Name>| {
                let places = [(0.0, values[0]), (length, values[1])];
                let located = self.located(at, places, function);
                let located = located.ok_or(None)?;
                Ok::<EquilibriumCurveEnd, Option<CurveStop>>(EquilibriumCurveEnd {
                    s: located.s,
                    stop,
                    last: located.at.point(),
                    special: what.map(|what| self.described(&located, what, number)),
                })
            };
        let product = |one: &CurveEquilibrium| match one.condition {
            Condition::Pair(product) => Some(product),
            _ => None,
        };
        if let (Some(a), Some(b)) = (product(at), product(next))
            && a > 0.0
            && b < 0.0
        {
            let what = Some(Name::BogdanovTakens);
            ends.push(end([a, b], &product, CurveStop::BogdanovTakens, what)?);
        }
        let own = match at.condition {
            Condition::Guard(number) => Some(number),
            _ => None,
        };
        let flow = self.of.system.flow(self.mode, &at.one.at);
        let guards = flow.guards().into_iter();
        for guard in guards.filter(|guard| guard.is_condition && Some(guard.number) != own) {
            let value = |one: &CurveEquilibrium| {
                let at = &one.one.at;
                Some(self.of.system.flow(self.mode, at).guard(guard.number, at))
            };
            let (Some(a), Some(b)) = (value(at), value(next)) else {
                continue;
            };
            if a > 0.0 && b < 0.0 {
                let what = match at.condition {
                    Condition::Fold => Name::FoldAtBoundary,
                    Condition::Pair(_) => Name::HopfAtBoundary,
                    Condition::Guard(_) => Name::TwoBoundaries,
                };
                ends.push(end([a, b], &value, CurveStop::AnotherChange, Some(what))?);
            } else if a <= 0.0 && b < 0.0 {
                // The mode has no equilibrium where its guard is negative beyond rounding.
                let x = &next.one.at.x;
                let (gradient, _) = flow.guard_gradient(guard.number, &next.one.at);
                let rounding = ROUNDING * gradient.abs().dot(&x.abs().sup(&self.of.units));
                if b < -rounding {
                    return Err(None);
                }
            }
        }
        let values = [at, next].map(CurveEquilibrium::parameters);
        for (k, (low, high)) in self.ranges.into_iter().enumerate() {
            let bound = values[1][k].clamp(low, high);
            if bound == values[1][k] {
                continue;
            }
            let value = |one: &CurveEquilibrium| Some(one.parameters()[k] - bound);
            let off = [values[0][k] - bound, values[1][k] - bound];
            let mut end = end(off, &value, CurveStop::Range, None)?;
            let place = end.last.x.len() - 2 + k;
            end.last.parameters[k] = bound;
            end.last.x[place] = bound;
            ends.push(end);
        }
        if number > 3 {
            ends.extend(self.closes((at, length), first));
        }
        Ok(ends)
    }

    fn special(
        &self,
        (at, next): (&CurveEquilibrium, &CurveEquilibrium),
        (length, number): (f64, usize),
    ) -> Vec<(f64, EquilibriumCurveSpecial)> {
        let mut found = Vec::new();
        for (what, function) in self.tests() {
            let (Some(a), Some(b)) = (function(at), function(next)) else {
                continue;
            };
            if a * b < 0.0 {
                let located = self.located(at, [(0.0, a), (length, b)], &function);
                found.extend(located.map(|located| (located, what)));
            }
        }
        if at.condition == Condition::Fold {
            let cusp = self.cusp((at, next), length);
            found.extend(cusp.map(|located| (located, EquilibriumCurveBifurcation::Cusp)));
        }
        found.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
        let described = found
            .iter()
            .map(|(located, what)| (located.s, self.described(located, *what, number)));
        described.collect()
    }

    fn last_end(
        &self,
        _: &CurveEquilibrium,
        _: f64,
        _: usize,
    ) -> Result<EquilibriumCurveEnd, CurveStop> {
        Err(CurveStop::NoConvergence)
    }
}
