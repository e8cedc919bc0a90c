//! Two-folds: points of Σ where both fields are tangent to it.
//!
//! In three dimensions sliding orbits reach them from open sets, and so can crossings that spiral
//! in (Teixeira, *J. Math. Anal. Appl.* 145 (1990) 65; Colombo & Jeffrey, *SIAM J. Appl. Dyn.
//! Syst.* 10 (2011) 423). After one the future is not unique.

use super::flow::{Flow, flow_path, gradient};
use super::options::AtRepelling;
use super::rules::{LieDerivatives, Visibility};
use super::run::{StepState, TIME_ROUNDING};
use super::switched::{Next, Switched, UseFlow};
use super::uncertainty::propagate;
use crate::dual::Dual;
use crate::dynamics::Modes;
use crate::ode::{Timed, Tolerance};
use crate::orbit::{Approach, Ending, TwoFold};
use crate::scalar::Scalar;
use crate::system::{Mode, Side, State};

/// A two-fold that an orbit reaches within about this time counts as reached. No step resolves the
/// way there, since the sliding field changes as fast as its direction. Chosen: a longer time
/// ends runs that pass it; with a shorter one, steps collapse before it.
const TWO_FOLD_TIME: f64 = 5e-7;

/// Least ratio, at a two-fold, of the difference of the fields to their normal components. Below it
/// they agree and Σ has no effect, as where friction has no normal force. Chosen: at a two-fold the
/// ratio grows without bound.
const FIELD_DIFFERENCE: f64 = 10.0;

/// The two-fold of a contact at the present state, if there is one. There the orbits of both its
/// fields are tangent to its boundary, with the other contacts in their modes. Tangent is what is
/// so within [`TWO_FOLD_TIME`], or to the tolerances of a touch ([`crate::Options::touch`]). A
/// two-fold is reached by sliding if the orbit has slid for longer than that time, else by
/// crossings.
pub(super) fn two_fold<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    run: &StepState<N, G>,
    mode: S::Mode,
    contact: usize,
) -> Option<TwoFold> {
    let at = &run.at;
    let within = TWO_FOLD_TIME.max(TIME_ROUNDING * at.t.abs());
    let sticks = S::of_contacts(&mode)[contact] == Mode::Stick;
    let approach = if sticks && at.t - run.from.t > within {
        Approach::Sliding
    } else {
        Approach::Crossings
    };
    let slips = |side| {
        let slips = with_mode::<S, N, G>(mode, contact, Mode::Slip(side));
        (slips, system.branch(slips, at))
    };
    let [below, above] = [Side::Below, Side::Above].map(|side| {
        let (mode, branch) = slips(side);
        system.with_flow(
            mode,
            branch,
            MotionOfSide(contact, at, run.options.tolerance()),
        )
    });
    let difference = (above.velocity - below.velocity).norm();
    let rates = [&below, &above].map(|side| side.derivatives[1]);
    // Both functions are the boundary's, of different signs.
    if difference * below.slope <= FIELD_DIFFERENCE * (rates[0] + rates[1]).abs() {
        return None;
    }
    let is_tangent = |of: &SideMotion<N>| {
        let [_, first, second, _] = of.derivatives;
        let error = run.options.touch * of.error;
        first.abs() <= (second.abs() * within).max(error)
    };
    if !is_tangent(&below) || !is_tangent(&above) {
        return None;
    }
    let kind = |side| {
        let (mode, branch) = slips(side);
        let kind = system.with_flow(mode, branch, TangencyKind(contact, at));
        // If the second derivative vanishes as well, the point is more degenerate than a two-fold.
        (kind != Visibility::Degenerate).then_some(kind)
    };
    Some(TwoFold {
        below: kind(Side::Below)?,
        above: kind(Side::Above)?,
        approach,
    })
}

/// The first contact in stick at a two-fold of its own.
pub(super) fn two_fold_in_stick<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    run: &StepState<N, G>,
    mode: S::Mode,
) -> Option<usize> {
    let modes = S::of_contacts(&mode);
    let sticks = (0..modes.len()).filter(|&contact| modes[contact] == Mode::Stick);
    let mut folds = sticks.filter(|&contact| two_fold(system, run, mode, contact).is_some());
    folds.next()
}

/// Continuation after the end of a stick phase of a contact at a two-fold, if it is at one.
pub(super) fn two_fold_followed<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    run: &StepState<N, G>,
    from: S::Mode,
    contact: usize,
) -> Option<Next<S::Mode, G>> {
    if S::of_contacts(&from)[contact] != Mode::Stick {
        return None;
    }
    let two_fold = two_fold(system, run, from, contact)?;
    let chosen = match run.options.at_repelling {
        AtRepelling::Stop => return Some(Next::End(Ending::TwoFold(two_fold))),
        AtRepelling::GoBelow => Side::Below,
        AtRepelling::GoAbove => Side::Above,
    };
    let is_visible = two_fold.visibility(chosen) == Visibility::Visible;
    is_visible.then(|| {
        let mut orders = [0; G];
        orders[contact] = 2;
        Next::Mode(
            with_mode::<S, N, G>(from, contact, Mode::Slip(chosen)),
            orders,
        )
    })
}

/// The modes with another one of a contact.
fn with_mode<S: Switched<N, G>, const N: usize, const G: usize>(
    modes: S::Mode,
    contact: usize,
    mode: Mode,
) -> S::Mode {
    S::restored(Modes::new(S::of_contacts(&modes)).with(contact, mode))
}

/// The motion of a slipping contact with respect to its boundary.
struct MotionOfSide<'a, const N: usize>(usize, &'a Timed<N>, Tolerance<N>);

struct SideMotion<const N: usize> {
    velocity: State<N>,
    /// Value and time derivatives of the contact's guard: its boundary function, positive on its
    /// side.
    derivatives: [f64; 4],
    /// Error of the first derivative by the tolerance.
    error: f64,
    /// Length of the guard's gradient.
    slope: f64,
}

impl<const N: usize> UseFlow<N> for MotionOfSide<'_, N> {
    type Output = SideMotion<N>;

    fn with<F: Flow<N>>(self, flow: &F) -> SideMotion<N> {
        let MotionOfSide(guard, at, tolerance) = self;
        let [rate] = propagate(at, (flow.dimension(), &tolerance), |t, x| {
            let field = flow.field(t, x);
            let path = std::array::from_fn(|i| Dual::new(x[i], field[i]));
            [flow.guard(guard, Dual::new(t, Dual::one()), &path).eps]
        });
        let (slope, _) = gradient(|t, x| flow.guard(guard, t, x), at, flow.dimension());
        SideMotion {
            velocity: flow.velocity(at.t, &at.x),
            derivatives: flow.jet(guard, at.t, &at.x),
            error: rate.by_tolerance,
            slope: slope.norm(),
        }
    }
}

/// Kind of the tangency of a flow with the boundary of a contact that slips in it.
struct TangencyKind<'a, const N: usize>(usize, &'a Timed<N>);

impl<const N: usize> UseFlow<N> for TangencyKind<'_, N> {
    type Output = Visibility;

    fn with<F: Flow<N>>(self, flow: &F) -> Visibility {
        let TangencyKind(guard, at) = self;
        let here = (at.t, &at.x, flow.dimension());
        let [lie] = LieDerivatives::along(here, 0.0, |t, x| {
            let path = flow_path(t, x, |t, x| flow.field(t, x));
            [flow.guard(guard, path.0, &path.1)]
        });
        lie.visibility(Side::Above)
    }
}
