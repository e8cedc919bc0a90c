//! Whether an orbit converges to an equilibrium, and where.

use super::attractor::AttractorKind;
use super::tolerance::{ROUNDING, SameWithin};
use crate::analysis::cycle::unit;
use crate::analysis::multipliers;
use crate::dynamics::{Dynamics, Matrix, Modes, Moment, Vector};
use crate::interval::Interval;
use crate::math::{modulus, product};
use crate::system::{Mode, Side};

/// Largest number of Newton steps. Quadratic convergence takes ten; a double zero takes one for
/// each factor of two.
const MOST_STEPS: usize = 30;

/// Fraction of the Jacobian's largest entry below which an eigenvalue or a singular value cannot be
/// distinguished from zero. It is above the square root of rounding, the error of a double one.
pub(crate) const ZERO: f64 = 1e-7;

/// Fraction of the size of an equilibrium up to which a guard is zero to rounding. The equilibrium
/// then lies at the edge of its mode's domain.
const EDGE_ROUNDING: f64 = 1e-14;

/// Step lengths within which an orbit may oscillate about the equilibrium that it approaches.
/// Chosen.
const OSCILLATION: f64 = 10.0;

/// An equilibrium.
#[derive(Clone, Debug)]
pub(crate) struct Equilibrium {
    pub x: Vector,
    /// The Jacobian of the mode's field there.
    pub jacobian: Matrix,
}

/// The equilibrium of a mode near `x` by Newton's iteration with the Jacobian's pseudo-inverse; of
/// a set of equilibria it yields the nearest. `None` where it does not converge. Only the first
/// `free` components change, except those that jumps alone change; a parameter may follow them.
pub(crate) fn equilibrium_near(
    system: &dyn Dynamics,
    mode: Modes,
    t: f64,
    x: &Vector,
    free: usize,
) -> Option<Equilibrium> {
    let mut at = Moment { t, x: x.clone() };
    let mut smallest = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let jacobian = jacobian_of(system, mode, &at);
        let step = newton_step(system, mode, &at, &jacobian, free)?;
        let size = step.amax();
        // The last step is rounding once it is not smaller than the one before.
        if size == 0.0 || size >= 0.5 * smallest {
            let rounding = 1e-12 * at.x.amax().max(f64::MIN_POSITIVE) + f64::MIN_POSITIVE;
            // A subnormal number is a rounded zero.
            let x =
                at.x.map(|v| if v.abs() < f64::MIN_POSITIVE { 0.0 } else { v });
            return (size <= rounding.max(1e-12)).then_some(Equilibrium { x, jacobian });
        }
        smallest = size;
        at.x += step;
    }
    None
}

/// The sum of the Newton steps of two points, each an equilibrium to rounding. If they are farther
/// apart, they are distinct.
pub(super) fn distance_bounds(
    system: &dyn Dynamics,
    mode: Modes,
    points: [&Moment; 2],
) -> Option<Vector> {
    let [one, other] = points.map(|at| {
        let jacobian = jacobian_of(system, mode, at);
        newton_step(system, mode, at, &jacobian, system.states())
    });
    Some(one?.abs() + other?.abs())
}

/// Parts of the distance between two equilibria at which the field is probed, each of the one
/// before. Near enough to the first, any field is its leading power, unless rounding comes first.
const PROBED_PART: f64 = 1.0 / 128.0;

/// Part of the way that Newton's step leaves at least where the field is rounding. Chosen: towards
/// a zero of order `p` it leaves `1 - 1/p`, and this is order 8.
const LEFT: f64 = 7.0 / 8.0;

/// Whether the field resolves the distance between two points at which it vanishes. At some small
/// part of the way from the first to the second, Newton's step must lead back towards the first.
///
/// Where terms of a field cancel, as in `1 - (x + 1)`, it vanishes on an interval. Newton's steps
/// are then zero at all points of it, and the points have no size for comparison at `x = 0`.
pub(super) fn resolves(
    system: &dyn Dynamics,
    mode: Modes,
    [from, to]: [&Moment; 2],
) -> Option<bool> {
    // Components that jumps alone change have no field that resolves them.
    let differs = |i: usize| from.x[i] != to.x[i];
    if (0..system.states()).any(|i| system.is_constant_between_jumps(i) && differs(i)) {
        return Some(true);
    }
    let step = |x: Vector| {
        let at = Moment { t: from.t, x };
        let jacobian = jacobian_of(system, mode, &at);
        newton_step(system, mode, &at, &jacobian, system.states())
    };
    let (way, here) = (&to.x - &from.x, step(from.x.clone())?);
    let mut part = PROBED_PART;
    while part > f64::EPSILON {
        let moved = &from.x + &way * part;
        let by = &moved - &from.x;
        let back = step(moved)? - &here;
        if (back + &by).norm() <= LEFT * by.norm() && by.amax() > 0.0 {
            return Some(true);
        }
        part *= PROBED_PART;
    }
    Some(false)
}

/// Newton's step from a moment towards an equilibrium of a mode, in the first `free` components.
pub(in crate::analysis) fn newton_step_at(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    free: usize,
) -> Option<Vector> {
    newton_step(system, mode, at, &jacobian_of(system, mode, at), free)
}

/// Newton's step towards an equilibrium.
fn newton_step(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    jacobian: &Matrix,
    free: usize,
) -> Option<Vector> {
    let (matrix, right) = equations(system, mode, at, jacobian, free)?;
    let step = matrix.svd(true, true).solve(&right, ZERO).ok()?;
    Some(without_constant(
        system,
        step.resize_vertically(system.states(), 0.0),
    ))
}

/// A direction without the rounding of components that jumps alone change.
pub(crate) fn without_constant(system: &dyn Dynamics, mut direction: Vector) -> Vector {
    for (i, part) in direction.iter_mut().enumerate() {
        if system.is_constant_between_jumps(i) {
            *part = 0.0;
        }
    }
    direction
}

/// The equations of Newton's step towards an equilibrium for the first `free` components, each
/// scaled to its own unit: a matrix and the right-hand side. A component that jumps alone change
/// keeps its value.
pub(crate) fn equations(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    jacobian: &Matrix,
    free: usize,
) -> Option<(Matrix, Vector)> {
    let flow = system.flow(mode, at);
    let velocity = flow.velocity(at);
    // The sliding field has no component across the boundary, neither on it nor nearby. So an
    // additional equation states that the equilibrium lies on the boundary.
    let onto = flow.projected(at) - &at.x;
    let length = |normal: &Vector| normal.rows(0, free).norm();
    let normals = system.normals(mode, at).into_iter();
    let normals = normals.map(|(_, normal)| (normal.dot(&onto), normal));
    let kept = system
        .kept(at)
        .into_iter()
        .map(|(off, gradient)| (-off, gradient));
    let mut normals: Vec<(f64, Vector)> = normals.chain(kept).collect();
    normals.retain(|(_, normal)| length(normal) > 0.0);
    let mut matrix = Matrix::zeros(free + normals.len(), free);
    let mut right = Vector::zeros(matrix.nrows());
    for i in 0..free {
        for j in (0..free).filter(|&j| !system.is_constant_between_jumps(j)) {
            matrix[(i, j)] = jacobian[(i, j)];
        }
        right[i] = -velocity[i];
        if system.is_constant_between_jumps(i) {
            matrix[(i, i)] = jacobian.amax().max(1.0);
        }
    }
    for (k, (onto, normal)) in normals.iter().enumerate() {
        for j in 0..free {
            matrix[(free + k, j)] = normal[j];
        }
        right[free + k] = *onto;
    }
    if matrix.iter().chain(&velocity).any(|v| !v.is_finite()) {
        return None;
    }
    // Each equation is scaled to its own unit: beside that of a stiff spring, that of a position is
    // not small. Cancellation in a sliding field leaves rounding of its largest terms, and no
    // equation.
    let rounding = ROUNDING * terms(system, mode, at, jacobian).amax();
    for (mut row, right) in matrix.row_iter_mut().zip(right.iter_mut()) {
        let size = row.amax();
        // A rate that no state changes has no zero.
        if size == 0.0 && *right != 0.0 && !mode.any_sticks() && normals.is_empty() {
            return None;
        }
        let per_size = if size > rounding { 1.0 / size } else { 0.0 };
        row *= per_size;
        *right *= per_size;
    }
    Some((matrix, right))
}

/// Sizes of the terms of a mode's Jacobian. A sliding field combines the fields on both sides,
/// which may cancel: of one state, nothing but their rounding is left.
pub(crate) fn terms(system: &dyn Dynamics, mode: Modes, at: &Moment, jacobian: &Matrix) -> Matrix {
    let slips = |side: Side| {
        let contacts = mode.iter().enumerate();
        let sticking = contacts.filter(|(_, own)| *own == Mode::Stick);
        sticking.fold(mode, |slips, (k, _)| slips.with(k, Mode::Slip(side)))
    };
    let sides = [Side::Below, Side::Above].into_iter();
    let fields = sides.filter(|_| mode.any_sticks()).map(slips);
    let fields = fields.map(|slips| jacobian_of(system, slips, at).abs());
    fields.fold(jacobian.abs(), |sizes, field| sizes.sup(&field))
}

/// The Jacobian of a mode's field, by dual numbers.
pub(crate) fn jacobian_of(system: &dyn Dynamics, mode: Modes, at: &Moment) -> Matrix {
    let flow = system.flow(mode, at);
    let axes = Matrix::identity(system.states(), system.states());
    let columns: Vec<Vector> = axes
        .column_iter()
        .map(|axis| flow.derivative(at, &axis.into_owned()))
        .collect();
    Matrix::from_columns(&columns)
}

/// The Jacobian of the first `free` components along the boundaries of the contacts that stick,
/// without the components that jumps alone change.
pub(crate) fn along_boundaries(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    jacobian: &Matrix,
    free: usize,
) -> Matrix {
    let of_states = jacobian.view((0, 0), (free, free));
    let normals = system
        .normals(mode, at)
        .into_iter()
        .map(|(_, normal)| normal);
    let normals = normals.chain(system.kept(at).into_iter().map(|(_, gradient)| gradient));
    let constant = (0..free).filter(|&i| system.is_constant_between_jumps(i));
    let constant = constant.map(|i| unit(free, i));
    let normals: Vec<Vector> = normals
        .map(|normal| normal.rows(0, free).into_owned())
        .chain(constant)
        .collect();
    if normals.is_empty() {
        return of_states.into_owned();
    }
    let across = Matrix::from_columns(&normals).qr().q();
    let parts =
        (Matrix::identity(free, free) - product(&across, &across.transpose())).symmetric_eigen();
    // A projection has the eigenvalues 0 and 1.
    let axes: Vec<usize> = (0..free).filter(|k| parts.eigenvalues[*k] > 0.5).collect();
    let basis = parts.eigenvectors.select_columns(&axes);
    basis.tr_mul(&product(&of_states, &basis))
}

/// The smallest guard of a mode at a point.
pub(crate) fn least_guard(system: &dyn Dynamics, mode: Modes, at: &Moment) -> f64 {
    let flow = system.flow(mode, at);
    let guards = flow.guards().into_iter();
    let guards = guards.filter(|guard| guard.is_condition);
    let values = guards.map(|guard| flow.guard(guard.number, at));
    values.fold(f64::INFINITY, f64::min)
}

/// Whether a mode holds at a point.
pub(crate) fn holds(system: &dyn Dynamics, mode: Modes, at: &Moment) -> bool {
    least_guard(system, mode, at) > 0.0
}

/// Bounds of the velocity at a point from a time on, if all contacts slip; of zero width unless the
/// field depends on time. `None` where intervals do not decide.
pub(super) fn velocities_from(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
) -> Option<Vec<Interval>> {
    let ever = Interval::new(at.t, f64::INFINITY);
    let point: Vec<Interval> = at.x.iter().map(|x| Interval::around(*x, 0.0)).collect();
    system.flow(mode, at).velocity_over(ever, &point)
}

/// The equilibrium to which an orbit at a state converges, and whether it is one of a set. `None`
/// if none is close enough, or if it does not attract.
pub(super) fn attracting_equilibrium(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    scale: impl Fn(usize) -> f64,
    tolerance: &SameWithin,
) -> Option<(AttractorKind, Vector)> {
    let Equilibrium { x, jacobian } = equilibrium_near(system, mode, at.t, &at.x, system.states())?;
    let is_near = |i: usize| (x[i] - at.x[i]).abs() <= OSCILLATION * tolerance.allowed(i, scale(i));
    if !(0..x.len()).all(is_near) {
        return None;
    }
    let there = Moment { t: at.t, x };
    let guard = least_guard(system, mode, &there);
    let is_on_edge = guard.abs() <= EDGE_ROUNDING * there.x.amax();
    if guard <= 0.0 && !is_on_edge {
        return None;
    }
    let velocities = velocities_from(system, mode, &there);
    if velocities.is_some_and(|all| all.iter().any(|v| v.high > v.low)) {
        return None;
    }
    let kind = kind_by_jacobian(system, mode, &there, &jacobian)?;
    (guard > 0.0 || kind == AttractorKind::Equilibrium).then_some((kind, there.x))
}

/// Whether an equilibrium is one of a set; `None` where it does not attract.
pub(super) fn kind_of_equilibrium(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
) -> Option<AttractorKind> {
    kind_by_jacobian(system, mode, at, &jacobian_of(system, mode, at))
}

/// Kind by the Jacobian there, restricted to motion along the boundaries of the contacts that
/// stick. Off them a body held by friction has a double zero eigenvalue, which rounding splits by
/// its square root.
fn kind_by_jacobian(
    system: &dyn Dynamics,
    mode: Modes,
    at: &Moment,
    jacobian: &Matrix,
) -> Option<AttractorKind> {
    let bound = ZERO * jacobian.amax();
    let along = along_boundaries(system, mode, at, jacobian, system.states());
    let mut is_of_set = false;
    for value in multipliers(&along) {
        if modulus(value) <= bound {
            is_of_set = true;
        } else if value.re >= -bound {
            return None;
        }
    }
    Some(if is_of_set {
        AttractorKind::EquilibriumSet
    } else {
        AttractorKind::Equilibrium
    })
}
