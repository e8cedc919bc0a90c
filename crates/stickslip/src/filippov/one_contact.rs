//! A Filippov system of one boundary as a switched system: slip below, slip above, stick.

use super::check::check;
use super::flow::{
    CONTACT, GUARDS, OneContactFlow, boundary_gradient, flow_path, gradient, normal_component,
    side_of_guard, sliding_field,
};
use super::guard::Event;
use super::observer::{Transition, TransitionKind};
use super::options::{AtRepelling, Options};
use super::rules::{
    Departure, Fate, LeadingDerivative, LieDerivatives, WithStaticFriction, departure,
    departure_by, on_boundary,
};
use super::run::StepState;
use super::switched::{Next, PROJECTION_STEPS, StickingPoint, Switched, UseFlow, Vanishes};
use super::two_fold::{two_fold, two_fold_followed, two_fold_in_stick};
use super::uncertainty::RELATIVE_ROUNDING;
use crate::dual::Dual;
use crate::dynamics::Modes;
use crate::error::{ContactFault, Error};
use crate::ode::{Linear, Timed};
use crate::orbit::Ending;
use crate::scalar::Scalar;
use crate::system::{Filippov, Mode, Side, State, components};

impl<S: Filippov<N>, const N: usize> Switched<N, GUARDS> for S {
    type Mode = Mode;
    /// Sign of the contact function.
    type Branch = f64;
    const UNDECIDED: Mode = Mode::Stick;
    const INTERPRETED: bool = S::INTERPRETED;

    fn check(&self, start: &Timed<N>, t_end: f64, options: &Options) -> Result<(), Error> {
        check(self, start, t_end, options)
    }

    /// Sign of the contact function; if that is zero, of its rate along the mean of the two fields.
    fn branch(&self, _mode: Mode, at: &Timed<N>) -> f64 {
        let x = components(&at.x);
        let below = self.field(Side::Below, at.t, x);
        let above = self.field(Side::Above, at.t, x);
        let path = std::array::from_fn(|i| Dual::new(x[i], 0.5 * (below[i] + above[i])));
        match self.contact(Dual::new(at.t, 1.0), &path) {
            Some(contact) if contact.re < 0.0 || contact.re == 0.0 && contact.eps < 0.0 => -1.0,
            _ => 1.0,
        }
    }

    fn restored_branch(contact: f64) -> f64 {
        contact
    }

    #[inline(always)]
    fn with_flow<U: UseFlow<N>>(&self, mode: Mode, contact: f64, user: U) -> U::Output {
        user.use_flow(&OneContactFlow {
            system: self,
            mode,
            contact,
        })
    }

    #[inline(always)]
    fn slip_field<T: Scalar>(&self, mode: Mode, t: T, x: &[T; N]) -> Option<[T; N]> {
        match mode {
            Mode::Slip(side) => Some(self.field(side, t, x)),
            Mode::Stick => None,
        }
    }

    /// Off Σ the side decides. On Σ, to rounding, the rules decide.
    fn first_mode(&self, run: &mut StepState<N, GUARDS>) -> Result<Next<Mode, GUARDS>, Error> {
        let Timed { t, x } = &run.at;
        let h = self.boundary(*t, components(x));
        let side = if h < 0.0 { Side::Below } else { Side::Above };
        if !on_boundary(self, side, *t, x, run.slack()) {
            return Ok(Next::Mode(Mode::Slip(side), [0; GUARDS]));
        }
        next(self, run, None)
    }

    fn event_within_mode(&self, guard: usize, contact: &mut f64) -> Option<TransitionKind> {
        if guard != CONTACT {
            return None;
        }
        *contact = -*contact;
        Some(if *contact < 0.0 {
            TransitionKind::ContactLoss
        } else {
            TransitionKind::ContactGain
        })
    }

    fn switch(
        &self,
        run: &mut StepState<N, GUARDS>,
        from: Mode,
        _branch: &mut f64,
        event: &Event<N>,
    ) -> Result<Next<Mode, GUARDS>, Error> {
        if let Some(followed) = two_fold_followed(self, run, from, 0) {
            return Ok(followed);
        }
        let vanishes = from == Mode::Stick
            && self.with_flow(
                from,
                self.branch(from, &run.at),
                Vanishes(event, &run.options),
            );
        let tangent = vanishes.then(|| side_of_guard(event.guard));
        next(self, run, tangent)
    }

    fn guard_at_collapse(&self, run: &StepState<N, GUARDS>, mode: Mode) -> Option<usize> {
        two_fold_in_stick(self, run, mode)
    }

    fn ending_of_pile_up(&self, run: &StepState<N, GUARDS>, mode: Mode) -> Option<Ending> {
        two_fold(self, run, mode, 0).map(Ending::TwoFold)
    }

    fn stick_at_accumulation(
        &self,
        run: &mut StepState<N, GUARDS>,
        _mode: Mode,
        _contacts: &[usize],
        at: &Timed<N>,
    ) -> Option<StickingPoint<Mode, f64, N, GUARDS>> {
        let at = Timed {
            t: at.t,
            x: onto_two_fold(self, at),
        };
        let held = WithStaticFriction(self);
        let slack = run.slack();
        let of = |side| LeadingDerivative::new(&held, side, at.t, &at.x, slack, false);
        let [below, above] = [Side::Below, Side::Above].map(of);
        run.counters.field_calls += below.calls + above.calls;
        let departure = departure(below, above, None);
        // If both normal components vanish, every weight is equally tangent, and the mean may lead
        // away.
        let here = (at.t, &at.x, self.dimension());
        let [along] = LieDerivatives::along(here, slack, |t, x| {
            let path = flow_path(t, x, |t, x| sliding_field(self, t, x));
            [self.boundary(path.0, &path.1)]
        });
        let [below, above] = [Side::Below, Side::Above]
            .map(|side| LieDerivatives::new(&held, side, at.t, &at.x, slack));
        let holds = departure.fate == Fate::Stick && along.holds_beside([&below, &above]);
        holds.then(|| StickingPoint {
            at,
            to: Mode::Stick,
            branch: self.branch(Mode::Stick, &at),
            orders: departure.orders,
            contact: 0,
        })
    }

    fn discontinuity_guard(&self, at: &Transition<N>) -> Option<usize> {
        match at.kind {
            TransitionKind::Crossing | TransitionKind::StickEntry => Some(0),
            // If the holding field ends as the slipping one begins, the fields agree.
            TransitionKind::StickExit => {
                let here = Timed { t: at.t, x: at.x };
                let jumps = static_over_kinetic(self, &here) > 1.0 + RELATIVE_ROUNDING;
                jumps.then_some(match at.to {
                    Mode::Slip(Side::Above) => 1,
                    Mode::Slip(Side::Below) | Mode::Stick => 0,
                })
            }
            // At a loss of contact the fields kink and do not jump.
            TransitionKind::Touch
            | TransitionKind::ContactLoss
            | TransitionKind::ContactGain
            | TransitionKind::Jump => None,
        }
    }

    fn mode_by_side(&self, t: f64, x: &State<N>) -> Mode {
        let h = self.boundary(t, components(x));
        if h == 0.0 {
            Mode::Stick
        } else {
            Mode::Slip(if h < 0.0 { Side::Below } else { Side::Above })
        }
    }

    fn normals(&self, mode: Mode, at: &Timed<N>, states: usize) -> Vec<(usize, State<N>)> {
        let boundary = |t, x: &_| self.boundary(t, x);
        match mode {
            Mode::Stick => vec![(0, gradient(boundary, at, states).0)],
            Mode::Slip(_) => Vec::new(),
        }
    }

    fn dimension(&self) -> usize {
        Filippov::dimension(self)
    }

    fn period(&self, x: &[Dual<f64>; N]) -> Option<Dual<f64>> {
        Filippov::period(self, x)
    }

    const CONTACTS: usize = 1;

    fn of_contacts(mode: &Mode) -> &[Mode] {
        std::slice::from_ref(mode)
    }

    fn restored(modes: Modes) -> Mode {
        match modes.is_empty() {
            true => Mode::Slip(Side::Above),
            false => modes.get(0),
        }
    }
}

/// Moves from near a two-fold onto it, by Newton steps for the boundary function and for the mean
/// of its rates along both fields.
fn onto_two_fold<S: Filippov<N>, const N: usize>(system: &S, at: &Timed<N>) -> State<N> {
    let mut here = *at;
    for _ in 0..PROJECTION_STEPS {
        let (normal, _) = boundary_gradient(system, here.t, &here.x);
        let (slope, _) = gradient(
            |t, x| {
                let rate = |side| normal_component(system, t, x, &system.holding(side, t, x));
                (rate(Side::Below) + rate(Side::Above)) * 0.5
            },
            &here,
            system.dimension(),
        );
        // Across Σ the slope of a root of the distance is infinite. The way leads along Σ.
        let slope = slope.map(|slope| if slope.is_finite() { slope } else { 0.0 });
        let x = components(&here.x);
        let rate = |side| normal_component(system, here.t, x, &system.holding(side, here.t, x));
        let (h, rate) = (
            system.boundary(here.t, x),
            0.5 * (rate(Side::Below) + rate(Side::Above)),
        );
        let (aa, bb, ab) = (
            normal.norm_squared(),
            slope.norm_squared(),
            normal.dot(&slope),
        );
        let determinant = aa * bb - ab * ab;
        if determinant <= RELATIVE_ROUNDING * aa * bb {
            break;
        }
        here.x = here
            .x
            .add_scaled((ab * rate - bb * h) / determinant, &normal)
            .add_scaled((ab * h - aa * rate) / determinant, &slope);
    }
    here.x
}

/// Ratio of static to kinetic friction at a point of Σ. Each is the difference of the normal
/// components of its two fields. The ratio is 1 where the fields agree.
fn static_over_kinetic<S: Filippov<N>, const N: usize>(system: &S, at: &Timed<N>) -> f64 {
    let (t, x) = (at.t, components(&at.x));
    let sides = [Side::Below, Side::Above];
    let fields = sides.map(|side| (system.holding(side, t, x), system.field(side, t, x)));
    if fields.iter().all(|(at_rest, in_slip)| at_rest == in_slip) {
        return 1.0;
    }
    let apart = |of: [&[f64; N]; 2]| {
        let [below, above] = of.map(|f| normal_component(system, t, x, f));
        below - above
    };
    let at_rest = apart([&fields[0].0, &fields[1].0]);
    at_rest / apart([&fields[0].1, &fields[1].1])
}

/// Continuation from a point of Σ. `tangent` names the side whose normal component, by the holding
/// fields, is known to vanish: a stick phase has just ended there.
fn next<S: Filippov<N>, const N: usize>(
    system: &S,
    run: &mut StepState<N, GUARDS>,
    tangent: Option<Side>,
) -> Result<Next<Mode, GUARDS>, Error> {
    let Departure { fate, orders } = departure_at(system, run, tangent)?;
    let [below, above, _] = orders;
    Ok(match (fate, run.options.at_repelling) {
        (Fate::Slip(side), _) => Next::Mode(Mode::Slip(side), orders),
        (Fate::Stick, _) => Next::Mode(Mode::Stick, orders),
        (Fate::Repelling, AtRepelling::Stop) => Next::End(Ending::Repelling),
        (Fate::Repelling, AtRepelling::GoBelow) => {
            Next::Mode(Mode::Slip(Side::Below), [below + 1, 0, 0])
        }
        (Fate::Repelling, AtRepelling::GoAbove) => {
            Next::Mode(Mode::Slip(Side::Above), [above + 1, 0, 0])
        }
    })
}

/// The fate of a point of Σ.
fn departure_at<S: Filippov<N>, const N: usize>(
    system: &S,
    run: &mut StepState<N, GUARDS>,
    tangent: Option<Side>,
) -> Result<Departure, Error> {
    let (at, slack, calls) = (run.at, run.slack(), &mut run.counters.field_calls);
    let ratio = static_over_kinetic(system, &at);
    if ratio == 1.0 {
        return Ok(departure_by(system, (&at, slack), tangent, calls));
    }
    let too_weak = |ratio| {
        let contact = 0;
        Error::at_contacts(&at, ContactFault::StaticBelowKinetic { contact, ratio })
    };
    if ratio < 1.0 - RELATIVE_ROUNDING {
        return Err(too_weak(ratio));
    }
    let held = departure_by(&WithStaticFriction(system), (&at, slack), tangent, calls);
    if held.fate == Fate::Stick {
        return Ok(held);
    }
    let slip = departure_by(system, (&at, slack), None, calls);
    if slip.fate == Fate::Stick {
        return Err(too_weak(ratio));
    }
    Ok(slip)
}
