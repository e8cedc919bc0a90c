//! Continuation of equilibria along a parameter: of the field on one side of each boundary, and of
//! the sliding field.

mod steps;

use std::fmt;

use nalgebra::Complex;

use super::{ContinuationSettings, Stop, check_rate, check_start};
use crate::analysis::attractors::equilibrium::{
    ZERO, along_boundaries, equations, holds, jacobian_of, terms, without_constant,
};
use crate::analysis::critical::RESOLVED_PLACE;
use crate::analysis::cycle::{
    AT_ZERO, LocatedZero, SAFETY, SolutionFunction, SolutionsOnLine, resolved, unit,
};
use crate::analysis::multipliers::eigenvalues;
use crate::analysis::stability::Stability;
use crate::dynamics::{AsDynamics, Components, Dynamics, Matrix, Modes, Moment, Vector};
use crate::error::Error;
use crate::filippov::Options;
use crate::system::{Mode, Side};

/// An equilibrium on a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumPoint {
    /// The parameter.
    pub parameter: f64,
    /// The state; the last component is the parameter.
    pub x: Vector,
    /// The mode of which it is an equilibrium; where a contact sticks, of the sliding field.
    pub mode: Modes,
    /// The eigenvalues of the mode's field, along the boundaries of the contacts that stick.
    pub eigenvalues: Vec<Complex<f64>>,
}

impl EquilibriumPoint {
    /// Stability by the eigenvalues.
    pub fn stability(&self) -> Stability {
        Stability::of_eigenvalues(&self.eigenvalues)
    }
}

/// The kind of a special equilibrium on a branch.
#[derive(Clone, Debug, PartialEq)]
pub enum EquilibriumBifurcation {
    /// A fold: the branch turns back, and an eigenvalue is zero.
    Fold,
    /// A branch point: an eigenvalue is zero, the branch continues and another one meets it.
    BranchPoint,
    /// A Hopf bifurcation: a pair of eigenvalues is imaginary, and periodic orbits emerge.
    Hopf {
        /// Absolute value of these eigenvalues: angle per unit of time.
        frequency: f64,
    },
    /// The equilibrium reaches a boundary, or the edge of its sliding region (di Bernardo, Budd,
    /// Champneys & Kowalczyk 2008, Ch. 5).
    Boundary {
        /// The contact whose boundary it is, counted from 0.
        contact: usize,
        /// The mode before it.
        before: Modes,
        /// The mode of the equilibrium with which the branch continues, if there is one.
        after: Option<Modes>,
        /// Whether the branch turns back there: a nonsmooth fold, and not persistence.
        turns: bool,
    },
    /// The number of eigenvalues with a positive real part changes, and no bifurcation was resolved
    /// that explains it.
    Unresolved {
        /// Their number before it.
        before: usize,
        /// Their number after it.
        after: usize,
    },
}

impl fmt::Display for EquilibriumBifurcation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EquilibriumBifurcation::Fold => "fold",
            EquilibriumBifurcation::BranchPoint => "branch point",
            EquilibriumBifurcation::Hopf { .. } => "Hopf",
            EquilibriumBifurcation::Boundary { .. } => "boundary equilibrium",
            EquilibriumBifurcation::Unresolved { .. } => "unresolved crossing",
        })
    }
}

/// A special equilibrium on a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecialEquilibrium {
    /// The parameter.
    pub parameter: f64,
    /// Uncertainty of the parameter: the residual of the function that vanishes there, with its
    /// rounding error, over its slope along the branch.
    pub uncertainty: f64,
    /// The kind of the special equilibrium.
    pub what: EquilibriumBifurcation,
    /// Number of branch points before it.
    pub behind: usize,
    /// The state; the last component is the parameter.
    pub x: Vector,
    /// The mode of the branch before it.
    pub mode: Modes,
}

/// A branch of equilibria.
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumBranch {
    /// The equilibria, in the order in which they were computed.
    pub points: Vec<EquilibriumPoint>,
    /// The special ones between them, in the same order.
    pub special: Vec<SpecialEquilibrium>,
    /// Size of each state on the branch.
    pub sizes: Vector,
    /// Reason for the end of the branch: an end of the range, the requested number of points, or a
    /// boundary with no equilibrium behind it. A closed branch ends with its first equilibrium. An
    /// equilibrium may not have been found.
    pub stop: Stop,
}

impl EquilibriumBranch {
    /// Follows the equilibrium near `x` from its parameter upwards or downwards by
    /// pseudo-arclength. Plain Newton steps lead from `x` to it, so `x` must be close to it. Its
    /// mode is the one that the system takes there, or one that differs from it in one contact.
    /// States that jumps alone change keep their values. **The parameter is the last state**, as in
    /// [`super::continue_periodic_orbit`]. Folds, branch points and Hopf bifurcations are zeros of
    /// functions of the Jacobian. A boundary equilibrium is a zero of a guard of the mode. The
    /// branch continues with the equilibrium of another mode of that contact that begins there, if
    /// there is one.
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that is not allowed; [`Error::Parameter`] where the last
    /// state is no parameter; [`Error::NotFound`] where there is no equilibrium near the start, or
    /// where it belongs to a set of equilibria at the same parameter.
    ///
    /// ```
    /// use stickslip::analysis::{ContinuationSettings, EquilibriumBifurcation, EquilibriumBranch};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// A block on a belt of speed v, with damping 0.1 and falling friction.
    /// struct Block;
    /// impl Filippov<3> for Block {
    ///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
    ///         let slip_speed = (x[1] - x[2]) * side.sign();
    ///         let friction = ((slip_speed * -2.0).exp() * 0.5 + 0.5) * side.sign();
    ///         [x[1], -x[0] - x[1] * 0.1 - friction, T::constant(0.0)]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
    ///         x[1] - x[2]
    ///     }
    /// }
    ///
    /// let settings = ContinuationSettings::over(0.5, 2.0);
    /// let start = [0.5, 0.0, 2.0];
    /// let options = Options::tol(1e-12);
    /// let branch = EquilibriumBranch::through(&Block, start, false, &settings, &options)?;
    /// // The slope of the friction takes the damping: 0.1 = exp(-2 v).
    /// let EquilibriumBifurcation::Hopf { frequency } = branch.special[0].what else { panic!() };
    /// assert!((branch.special[0].parameter - 0.5 * 10.0_f64.ln()).abs() < 1e-12);
    /// assert!((frequency - 1.0).abs() < 1e-12);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    pub fn through<Kind>(
        system: &impl AsDynamics<Kind>,
        x: impl Components,
        upwards: bool,
        settings: &ContinuationSettings,
        options: &Options,
    ) -> Result<EquilibriumBranch, Error> {
        settings.check()?;
        let system = &*system.dynamics();
        let x = x.vector();
        check_start(&x, 1, settings)?;
        let (at, width) = (Moment { t: 0.0, x }, settings.range.1 - settings.range.0);
        let mode = system.begin(&at, at.t + 1.0, options, &[])?;
        let mode = mode.mode();
        let last = at.x.len() - 1;
        let rate = system.flow(mode, &at).velocity(&at)[last];
        check_rate(rate)?;
        let largest = at.x.rows(0, last).amax();
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let mut units = Vector::repeat(last + 1, largest);
        units[last] = width;
        let mut continuation = EquilibriumContinuation {
            system,
            settings,
            units,
            largest,
            parameters: 1,
        };
        let by_parameter = unit(last + 1, last);
        let near = |mode: Modes| continuation.solve(mode, &at.x, &[&by_parameter]);
        let is_held = |one: &BranchEquilibrium| holds(system, one.mode, &one.at);
        let modes =
            std::iter::once(mode).chain((0..mode.iter().count()).flat_map(|k| others(mode, k)));
        let first = modes.filter_map(near).find(is_held);
        if let Some(first) = &first {
            continuation.units = continuation.units_at(first, options);
        }
        let by_own_units = |one: BranchEquilibrium| {
            let again = continuation.solve(one.mode, &one.at.x, &[&by_parameter]);
            again.filter(|one| continuation.is_isolated(one))
        };
        let not_found = Error::NotFound {
            what: "an equilibrium near the start of the branch that is none of a set of equilibria",
            t: at.t,
            span: 0.0,
        };
        let first = first.and_then(by_own_units).ok_or(not_found.clone())?;
        let sign = if upwards { 1.0 } else { -1.0 };
        continuation
            .follow(first, &(by_parameter * sign))
            .ok_or(not_found)
    }
}

/// Modes with another mode of a contact.
fn others(mode: Modes, contact: usize) -> impl Iterator<Item = Modes> {
    let all = [
        Mode::Stick,
        Mode::Slip(Side::Below),
        Mode::Slip(Side::Above),
    ];
    let own = mode.get(contact);
    let other = all.into_iter().filter(move |one| *one != own);
    other.map(move |one| mode.with(contact, one))
}

/// Rounding of a difference, as a fraction of its terms: of about so many operations.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

#[derive(Clone)]
pub(super) struct BranchEquilibrium {
    mode: Modes,
    /// The state, followed by the parameters.
    pub at: Moment,
    /// The derivative of the equations by all components, each equation scaled to its own unit.
    equations: Matrix,
    /// The Jacobian along the boundaries of the contacts that stick.
    pub along: Matrix,
    pub iterations: usize,
}

impl BranchEquilibrium {
    fn parameter(&self) -> f64 {
        self.at.x[self.at.x.len() - 1]
    }

    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        eigenvalues(&self.along)
    }

    /// The pair of eigenvalues nearest to the imaginary axis.
    fn pair(&self) -> Option<Complex<f64>> {
        let pairs = self.eigenvalues().into_iter().filter(|one| one.im > 0.0);
        pairs.min_by(|a, b| a.re.abs().total_cmp(&b.re.abs()))
    }

    fn point(&self) -> EquilibriumPoint {
        let mut eigenvalues = self.eigenvalues();
        eigenvalues.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        EquilibriumPoint {
            parameter: self.parameter(),
            x: self.at.x.clone(),
            mode: self.mode,
            eigenvalues,
        }
    }
}

/// The tangent of a branch at an equilibrium, along which the next one is sought.
#[derive(Clone)]
pub(super) struct EquilibriumTangent {
    pub mode: Modes,
    pub from: Vector,
    pub direction: Vector,
    /// The plane across it.
    pub row: Vector,
    /// A plane along it in which its equilibria lie, with two parameters.
    pub plane: Option<Vector>,
}

impl EquilibriumTangent {
    fn heading(&self) -> f64 {
        self.direction[self.direction.len() - 1]
    }
}

pub(super) struct EquilibriumContinuation<'a> {
    pub system: &'a dyn Dynamics,
    pub settings: &'a ContinuationSettings,
    /// Sizes of the components.
    pub units: Vector,
    /// The largest size that a state may have at the first equilibrium.
    pub largest: f64,
    /// Number of components that are parameters: the last ones.
    pub parameters: usize,
}

/// The equilibria on a line.
pub(super) struct EquilibriaOnLine<'l> {
    continuation: &'l EquilibriumContinuation<'l>,
    line: &'l EquilibriumTangent,
}

impl SolutionsOnLine for EquilibriaOnLine<'_> {
    type Solution = BranchEquilibrium;

    fn on(&self, place: f64) -> Option<BranchEquilibrium> {
        let line = self.line;
        let guess = &line.from + &line.direction * place;
        let planes: Vec<&Vector> = std::iter::once(&line.row).chain(&line.plane).collect();
        self.continuation.solve(line.mode, &guess, &planes)
    }

    fn finer(&self, place: f64) -> Option<BranchEquilibrium> {
        self.on(place)
    }

    fn parameter(&self, one: &BranchEquilibrium) -> f64 {
        one.parameter()
    }
}

impl EquilibriaOnLine<'_> {
    /// The last equilibrium at which a guard is positive, where none can be computed on its zero.
    /// At a two-fold both fields are tangent to the boundary, and the sliding field is 0/0.
    fn edge(
        &self,
        [(begin, at_begin), (end, _)]: [(f64, f64); 2],
        guard: &SolutionFunction<'_, BranchEquilibrium>,
    ) -> Option<LocatedZero<BranchEquilibrium>> {
        let (mut low, mut high, mut last) = (begin, end, None);
        while high - low > RESOLVED_PLACE * (end - begin) {
            let middle = 0.5 * (low + high);
            let found = self.on(middle);
            let found = found.and_then(|one| Some((guard(&one)?, one)));
            match found.filter(|(value, _)| *value > 0.0) {
                Some(found) => (low, last) = (middle, Some(found)),
                None => high = middle,
            }
        }
        let (value, solution) = last?;
        // Twice as far from the zero, the slope is that at the zero.
        let back = value / (at_begin - value) * (low - begin);
        let before = self.on(low - back)?;
        let per_value = (solution.parameter() - before.parameter()) / (guard(&before)? - value);
        (value <= AT_ZERO * at_begin).then(|| LocatedZero {
            s: low,
            parameter: solution.parameter(),
            uncertainty: SAFETY * (value * per_value).abs(),
            solution,
        })
    }
}

impl EquilibriumContinuation<'_> {
    /// The equilibria on a line.
    pub fn on<'l>(&'l self, line: &'l EquilibriumTangent) -> EquilibriaOnLine<'l> {
        let continuation = self;
        EquilibriaOnLine { continuation, line }
    }

    /// The equilibrium of a mode near a guess, in the planes through it across rows.
    pub fn solve(
        &self,
        mode: Modes,
        guess: &Vector,
        rows: &[&Vector],
    ) -> Option<BranchEquilibrium> {
        // Plain Newton steps converge within ten, unless the Jacobian is nearly singular.
        const MOST_ITERATIONS: usize = 20;
        let count = guess.len();
        let states = count - self.parameters;
        let mut at = Moment {
            t: 0.0,
            x: guess.clone(),
        };
        let mut last = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            let jacobian = jacobian_of(self.system, mode, &at);
            let (equations, right) = equations(self.system, mode, &at, &jacobian, count)?;
            let off = guess - &at.x;
            let step = self.bordered(&equations, rows, (&right, &off))?;
            let size = step.component_div(&self.units).amax();
            // The last step is rounding once it is not smaller than the one before.
            if size <= f64::EPSILON || size >= 0.5 * last {
                // The residual of a least-squares solution is not rounding. Each equation and each
                // rate is compared with its own terms, which may differ by any factor.
                let within = |values: &Vector, terms: &Vector| {
                    let mut pairs = values.iter().zip(terms);
                    pairs.all(|(value, terms)| value.abs() <= ZERO * ZERO.sqrt() * terms)
                };
                let sizes = at.x.abs().sup(&self.units);
                let solves = within(&right, &(equations.abs() * &sizes));
                let velocity = self.system.flow(mode, &at).velocity(&at);
                let terms = terms(self.system, mode, &at, &jacobian);
                let is_at_rest = within(&velocity, &(terms * &sizes));
                let along = along_boundaries(self.system, mode, &at, &jacobian, states);
                return (size <= ZERO && solves && is_at_rest).then_some(BranchEquilibrium {
                    mode,
                    at,
                    equations,
                    along,
                    iterations,
                });
            }
            last = size;
            at.x += step;
        }
        None
    }

    /// Solves the equations with rows appended, across which the step has the part of a distance.
    fn bordered(
        &self,
        equations: &Matrix,
        rows: &[&Vector],
        (right, off): (&Vector, &Vector),
    ) -> Option<Vector> {
        let (mut matrix, mut right) = (equations.clone(), right.clone());
        for row in rows {
            let last = matrix.nrows();
            matrix = matrix.insert_row(last, 0.0);
            matrix.set_row(last, &row.transpose());
            right = right.insert_row(last, row.dot(off));
        }
        for (k, unit) in self.units.iter().enumerate() {
            matrix.column_mut(k).scale_mut(*unit);
        }
        for (mut row, right) in matrix.row_iter_mut().zip(right.iter_mut()) {
            let size = row.amax();
            if size > 0.0 {
                row /= size;
                *right /= size;
            }
        }
        let bound = f64::EPSILON * matrix.nrows() as f64;
        let solution = matrix.svd(true, true).solve(&right, bound).ok()?;
        Some(without_constant(
            self.system,
            solution.component_mul(&self.units),
        ))
    }

    /// The singular values of the equations and their directions, in units of the components.
    pub fn parts(&self, one: &BranchEquilibrium) -> (Vector, Option<Matrix>) {
        self.parts_of(&one.equations)
    }

    /// The rows of the plane in which equilibria with two parameters lie near `x`, as far as the
    /// linear equations there say. Planes across both cut it in one point, also at a fold.
    pub fn plane_at(&self, mode: Modes, x: &Vector) -> Option<[Vector; 2]> {
        let at = Moment {
            t: 0.0,
            x: x.clone(),
        };
        let jacobian = jacobian_of(self.system, mode, &at);
        let (equations, _) = equations(self.system, mode, &at, &jacobian, x.len())?;
        let (_, directions) = self.parts_of(&equations);
        let directions = directions.filter(|all| all.nrows() >= 2)?;
        let row = |k: usize| directions.row(directions.nrows() - k).transpose();
        Some([2, 1].map(|k| row(k).component_div(&self.units)))
    }

    fn parts_of(&self, equations: &Matrix) -> (Vector, Option<Matrix>) {
        let mut scaled = equations.clone();
        for (k, unit) in self.units.iter().enumerate() {
            scaled.column_mut(k).scale_mut(*unit);
        }
        for mut row in scaled.row_iter_mut() {
            let size = row.amax();
            if size > 0.0 {
                row /= size;
            }
        }
        let parts = scaled.svd(false, true);
        (parts.singular_values, parts.v_t)
    }

    /// Whether no other equilibria at the same parameter are adjacent to one.
    fn is_isolated(&self, one: &BranchEquilibrium) -> bool {
        let (values, _) = self.parts(one);
        let bound = ZERO * values.max();
        let is_line = values.iter().filter(|value| **value <= bound).count() == 1;
        let last = self.units.len() - 1;
        let line = self.tangent(one, &unit(last + 1, last));
        // A set at one parameter is a line as well.
        let moves = |line: EquilibriumTangent| line.heading() > ROUNDING * self.units[last];
        is_line && line.is_some_and(moves)
    }

    /// The tangent of the branch at an equilibrium, in the direction in which the product with a
    /// row grows.
    fn tangent(&self, one: &BranchEquilibrium, row: &Vector) -> Option<EquilibriumTangent> {
        let (_, directions) = self.parts(one);
        let directions = directions?;
        let way = directions.row(directions.nrows() - 1).transpose();
        let mut direction = without_constant(self.system, way.component_mul(&self.units));
        if row.dot(&direction) < 0.0 {
            direction.neg_mut();
        }
        let squares = self.units.component_mul(&self.units);
        Some(EquilibriumTangent {
            mode: one.mode,
            from: one.at.x.clone(),
            row: direction.component_div(&squares),
            direction,
            plane: None,
        })
    }

    /// The units at the first equilibrium of a branch. A state has its own size there or, if that
    /// is more, that of its change over the parameter's range by its rate along the branch. Rates
    /// have no bound next to a fold: the largest size of a state, or the change by the secant of a
    /// step, is the most. A state of which all are within the tolerances has the largest size.
    fn units_at(&self, first: &BranchEquilibrium, options: &Options) -> Vector {
        let (x, last) = (&first.at.x, self.units.len() - 1);
        let line = self.tangent(first, &unit(last + 1, last));
        let mut units = self.units.clone();
        let farther = [1.0, -1.0].into_iter().find_map(|sign| {
            let mut guess = x.clone();
            guess[last] += sign * self.settings.step * units[last];
            self.solve(first.mode, &guess, &[&unit(last + 1, last)])
        });
        for i in 0..last {
            let rate = |line: &EquilibriumTangent| (line.direction[i] / line.heading()).abs();
            let change = line.as_ref().map_or(0.0, rate) * units[last];
            let secant = |one: &BranchEquilibrium| (one.at.x[i] - x[i]).abs() / self.settings.step;
            let most = self.largest.max(farther.as_ref().map_or(0.0, secant));
            let own = x[i].abs().max(change).min(most);
            if own > resolved(options.allowed(i, x[i].abs())) {
                units[i] = own;
            }
        }
        units
    }

    /// Whether the place on a line determines two states as one.
    pub fn are_same(&self, one: &Vector, other: &Vector) -> bool {
        (one - other).component_div(&self.units).amax() <= ZERO
    }
}
