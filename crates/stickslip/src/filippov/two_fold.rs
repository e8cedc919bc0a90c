//! Two-folds: points of Σ where both fields are tangent to it.
//!
//! In three dimensions sliding orbits reach them from open sets, and so can crossings that spiral
//! in (Teixeira, *J. Math. Anal. Appl.* 145 (1990) 65; Colombo & Jeffrey, *SIAM J. Appl. Dyn.
//! Syst.* 10 (2011) 423). After one the future is not unique.

use super::flow::{boundary_gradient, normal_component};
use super::rules::{LieDerivatives, Visibility};
use super::run::{StepState, TIME_ROUNDING};
use crate::orbit::{Approach, TwoFold};
use crate::system::{Filippov, Mode, Side, State, components};

/// A two-fold that an orbit reaches within about this time counts as reached. No step resolves the
/// way there, since the sliding field changes as fast as its direction. Chosen: a longer time
/// ends runs that pass it; with a shorter one, steps collapse before it.
const TWO_FOLD_TIME: f64 = 5e-7;

/// At a two-fold the fields differ by more than this factor times their normal components. Else
/// they agree and Σ has no effect, as where friction has no normal force. Chosen: at a two-fold the
/// factor grows without bound.
const FIELD_DIFFERENCE: f64 = 10.0;

/// The two-fold at the present state, if there is one: the orbits of both fields are tangent to Σ
/// within [`TWO_FOLD_TIME`]. It is reached by sliding if the orbit has slid for longer than that,
/// else by crossings.
pub(super) fn two_fold<S: Filippov<N>, const N: usize, const G: usize>(
    system: &S,
    run: &StepState<N, G>,
    mode: Mode,
) -> Option<TwoFold> {
    let at = &run.at;
    let within = TWO_FOLD_TIME.max(TIME_ROUNDING * at.t.abs());
    let approach = if mode == Mode::Stick && at.t - run.from.t > within {
        Approach::Sliding
    } else {
        Approach::Crossings
    };
    let kind = |side: Side| {
        let lie = LieDerivatives::new(system, side, at.t, &at.x, 0.0);
        let is_tangent = lie.values[1].abs() <= lie.values[2].abs() * within;
        // If the second derivative vanishes as well, the point is more degenerate than a two-fold.
        let kind = lie.visibility(side);
        (is_tangent && kind != Visibility::Degenerate).then_some(kind)
    };
    let x = components(&at.x);
    let [below, above] = [Side::Below, Side::Above].map(|side| system.field(side, at.t, x));
    let [down, up] = [&below, &above].map(|f| normal_component(system, at.t, x, f));
    let difference = (State::from(above) - State::from(below)).norm();
    let slope = boundary_gradient(system, at.t, &at.x).0.norm();
    if difference * slope <= FIELD_DIFFERENCE * (up - down).abs() {
        return None;
    }
    Some(TwoFold {
        below: kind(Side::Below)?,
        above: kind(Side::Above)?,
        approach,
    })
}
