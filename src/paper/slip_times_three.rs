//! The limit of the listing as its step goes to zero, solved accurately. Injecting its defects
//! shows the cause of Fig. 8's numbers.
//!
//! Two defects of the Appendix remain in the limit. Its in-place stages move the state by three
//! steps along the field while the clock advances by one. So a slip phase runs three times too fast
//! relative to the forcing; a stick phase does not. And a stick phase ends only at the upper end of
//! the zone that it entered. The lower end, which may pass the body, is not tested. [`settled`]
//! injects both or either of them into the event-exact solver ([`InjectedDefects`]). The result
//! does not depend on the listing's arithmetic, nor on any published number.

use std::ops::ControlFlow;

use crate::numbers::not_found;
use crate::paper::listing::{END, Setup};
use crate::paper::models::ForcedOscillator;
use crate::paper::pattern::Pattern;
use crate::paper::{TOLERANCE, bounded};
use stickslip::first_zero;
use stickslip::{
    Error, Filippov, Mode, Observer, Options, Phase, Scalar, Side, State, Transition,
    TransitionKind, run,
};

/// The forced oscillator with the state moving `factor` times too fast relative to the time.
struct FasterSlip<'a> {
    model: &'a ForcedOscillator,
    factor: f64,
}

impl Filippov<2> for FasterSlip<'_> {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        self.model.field(side, t, x).map(|rate| rate * self.factor)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
        self.model.boundary(t, x)
    }
}

/// The defects injected into the event-exact solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InjectedDefects {
    /// Factor by which a slip phase is too fast.
    pub slip: f64,
    /// Whether a stick phase ends only at the upper end of the zone that it entered, as in the
    /// listing. Otherwise it ends at whichever end comes first, as in the model.
    pub one_sided_exit: bool,
}

impl InjectedDefects {
    /// Both defects, as in the listing.
    pub const BOTH: InjectedDefects = InjectedDefects {
        slip: 3.0,
        one_sided_exit: true,
    };
    /// The faster slip alone.
    pub const SLIP_ALONE: InjectedDefects = InjectedDefects {
        one_sided_exit: false,
        ..InjectedDefects::BOTH
    };
    /// The exit tested at one side alone.
    pub const EXIT_ALONE: InjectedDefects = InjectedDefects {
        slip: 1.0,
        ..InjectedDefects::BOTH
    };
    /// The stated model.
    pub const NONE: InjectedDefects = InjectedDefects {
        slip: 1.0,
        ..InjectedDefects::SLIP_ALONE
    };
}

/// A number of the settled motion with the eight decimals to which it has converged by the end of
/// the run.
pub fn converged(value: f64) -> f64 {
    (value * 1e8).round() / 1e8
}

/// The motion on which Fig. 8's oscillator settles with the defects `injected`, over the length of
/// the listing's run. The listing's start is on Σ, in a stick phase.
///
/// # Errors
/// The solver's; [`Error::NotFound`] if nothing repeats, or a stick phase begins in no zone or does
/// not end.
pub fn settled(injected: InjectedDefects) -> Result<Pattern, Error> {
    let model = &ForcedOscillator::default();
    let factor = injected.slip;
    let hastened = FasterSlip { model, factor };
    let (zones, options) = (model.stick_zones()?, bounded(TOLERANCE));
    let mut collected = StopAtEvent {
        phases: Vec::new(),
        event: TransitionKind::StickEntry,
    };
    let (mut t, mut x) = (0.0, Setup::default().state());
    while t < END {
        let (released, at) = match injected.one_sided_exit {
            true => upper_exit(model, &zones, t, &x)?,
            false => either_exit(model, t, &x, &options)?,
        };
        if released > t {
            collected.phases.push(Phase {
                mode: Mode::Stick,
                t_start: t,
                t_end: released,
                x_start: x,
                x_end: at,
            });
        }
        if released >= END {
            break;
        }
        let slip = run(&hastened, released, at, END, &options, &mut collected)?;
        (t, x) = (slip.t, slip.x);
    }
    let pattern = Pattern::of_phases(&collected.phases, END, model.period());
    pattern.ok_or_else(|| not_found("a motion that repeats", 0.0, END))
}

/// Keeps phases and stops at the first event of one kind.
struct StopAtEvent {
    phases: Vec<Phase<2>>,
    event: TransitionKind,
}

impl Observer<2> for StopAtEvent {
    fn phase(&mut self, phase: &Phase<2>) -> ControlFlow<()> {
        self.phases.push(*phase);
        ControlFlow::Continue(())
    }
    fn transition(&mut self, transition: &Transition<2>) -> ControlFlow<()> {
        match transition.kind == self.event {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// The state where the stated model releases a body from `(t, x)` on Σ; the start itself if it does
/// not stick there.
fn either_exit(
    model: &ForcedOscillator,
    t: f64,
    x: &State<2>,
    options: &Options,
) -> Result<(f64, State<2>), Error> {
    let mut stick = StopAtEvent {
        phases: Vec::new(),
        event: TransitionKind::StickExit,
    };
    run(model, t, *x, END, options, &mut stick)?;
    let first = stick.phases.first();
    let sticks = first.filter(|phase| phase.mode == Mode::Stick);
    Ok(sticks.map_or((t, *x), |phase| (phase.t_end, phase.x_end)))
}

/// The state where a body that rides the belt from `(t, x)` meets the upper end of its zone.
fn upper_exit(
    model: &ForcedOscillator,
    zones: &[(f64, f64)],
    t: f64,
    x: &State<2>,
) -> Result<(f64, State<2>), Error> {
    let z = x[0] - model.support(t);
    // The body may enter at the end of a zone, off by a rounding error.
    let slack = 1e-9;
    let holds = |(lower, upper): &&(f64, f64)| z >= lower - slack && z <= upper + slack;
    let Some(&(_, upper)) = zones.iter().find(holds) else {
        return Err(not_found("a stick zone that holds the body", t, 0.0));
    };
    let room = |later: f64| upper + model.support(t + later) - x[0] - model.belt_speed * later;
    // The zone's end is periodic while the belt moves on. A search over half a period at a time is
    // short.
    let (window, most) = (0.5 * model.period(), 1000);
    let later = (0..most).find_map(|k| {
        let from = f64::from(k) * window;
        let part = first_zero(|s: f64| room(from + s * window), 0.0, 1.0)?;
        Some(from + window * part)
    });
    let span = f64::from(most) * window;
    let later = later.ok_or_else(|| not_found("the upper end of the stick zone", t, span))?;
    let at = State::from([x[0] + model.belt_speed * later, model.belt_speed]);
    Ok((t + later, at))
}
