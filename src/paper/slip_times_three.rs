//! The listing's limit as its step goes to zero, solved accurately: the cause of Fig. 8's numbers by injection.
//!
//! Two defects of the Appendix survive the limit. Its in-place stages carry the state three steps along the field
//! while the clock advances one, so that a slip runs three times too fast against the forcing; a stick phase keeps its own
//! pace. And a stick phase ends only where the body meets the upper end of the zone it entered; the lower end,
//! which may sweep past it, is never looked at. [`run`] puts just these two into the event-exact solver: if the
//! published numbers come out of it, these two are what made them. [`run_hastened`] with the factor 1 has the second alone.

use std::ops::ControlFlow;

use stickslip::error::Error;
use stickslip::filippov::{
    Observer, Options, Phase, Transition, TransitionKind, first_zero, run as integrate,
};
use stickslip::models::ForcedOscillator;
use stickslip::scalar::Scalar;
use stickslip::system::{Filippov, Mode, Side, State};

/// The forced oscillator whose state moves `factor` times as fast as its clock says.
struct Hastened<'a> {
    model: &'a ForcedOscillator,
    factor: f64,
}

/// In-place stages move the state by h/2 + h/2 + h + h along the field and the clock by h.
const FACTOR: f64 = 3.0;

impl Filippov<2> for Hastened<'_> {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &State<T, 2>) -> State<T, 2> {
        self.model.field(side, t, x).map(|rate| rate * self.factor)
    }
    fn boundary<T: Scalar>(&self, t: T, x: &State<T, 2>) -> T {
        self.model.boundary(t, x)
    }
}

/// Phases of a run of [`run`].
#[derive(Clone, Debug, PartialEq)]
pub struct SlipTimesThree {
    /// Slip and stick phases in order of time.
    pub phases: Vec<Phase<2>>,
}

impl SlipTimesThree {
    /// The two longest stick phases among those that end within the last two forcing periods: their lengths (m), the longer
    /// first, then their durations (s). `None` when there are not two.
    pub fn four_numbers(&self, forcing_period: f64) -> Option<[f64; 4]> {
        let sticks: Vec<&Phase<2>> = self
            .phases
            .iter()
            .filter(|phase| phase.mode == Mode::Stick)
            .collect();
        // The phase exactly two periods before the last belongs to the pattern before.
        let from = sticks.last()?.t_end - 1.99 * forcing_period;
        let mut lengths: Vec<(f64, f64)> = sticks
            .iter()
            .filter(|phase| phase.t_end > from)
            .map(|phase| (phase.displacement()[0], phase.duration()))
            .collect();
        lengths.sort_by(|one, other| other.0.total_cmp(&one.0));
        match lengths[..] {
            [first, second, ..] => Some([first.0, second.0, first.1, second.1]),
            _ => None,
        }
    }
}

/// Runs the forced oscillator with its slips hastened threefold and its stick phases ended at the upper end of their zone
/// only, from `(0, x0)` on Σ in a stick phase to `t_end`. `zones` are the stick zones (lower end, upper end) in
/// `z = x₁ − A sin(ωt)`, Eq. (24).
///
/// # Errors
/// Those of [`stickslip::run`]; [`Error::NotFound`] when a stick phase begins in no zone or finds no end.
pub fn run(
    model: &ForcedOscillator,
    zones: &[(f64, f64)],
    x0: State<f64, 2>,
    t_end: f64,
    options: &Options,
) -> Result<SlipTimesThree, Error> {
    run_hastened(FACTOR, model, zones, x0, t_end, options)
}

/// As [`run`], with slips `factor` times too fast instead of three times; 1 leaves the exit as the only defect.
///
/// # Errors
/// As [`run`].
pub fn run_hastened(
    factor: f64,
    model: &ForcedOscillator,
    zones: &[(f64, f64)],
    x0: State<f64, 2>,
    t_end: f64,
    options: &Options,
) -> Result<SlipTimesThree, Error> {
    let hastened = Hastened { model, factor };
    let mut collected = UntilStick { phases: Vec::new() };
    let (mut t, mut x) = (0.0, x0);
    loop {
        let (released, at) = upper_exit(model, zones, t, &x)?;
        collected.phases.push(Phase {
            mode: Mode::Stick,
            t_start: t,
            t_end: released,
            x_start: x,
            x_end: at,
        });
        if released >= t_end {
            break;
        }
        let slip = integrate(&hastened, released, at, t_end, options, &mut collected)?;
        if slip.t >= t_end {
            break;
        }
        (t, x) = (slip.t, slip.x);
    }
    Ok(SlipTimesThree {
        phases: collected.phases,
    })
}

/// Keeps slip phases and stops where a stick phase begins.
struct UntilStick {
    phases: Vec<Phase<2>>,
}

impl Observer<2> for UntilStick {
    fn phase(&mut self, phase: &Phase<2>) -> ControlFlow<()> {
        self.phases.push(*phase);
        ControlFlow::Continue(())
    }
    fn transition(&mut self, transition: &Transition<2>) -> ControlFlow<()> {
        if transition.kind == TransitionKind::StickEntry {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Where a body that rides the belt from `(t, x)` meets the upper end of its zone.
fn upper_exit(
    model: &ForcedOscillator,
    zones: &[(f64, f64)],
    t: f64,
    x: &State<f64, 2>,
) -> Result<(f64, State<f64, 2>), Error> {
    let z = x[0] - model.support(t);
    // The body may enter on the very end of a zone, a rounding beside it.
    let slack = 1e-9;
    let zone = zones
        .iter()
        .find(|(lower, upper)| z >= lower - slack && z <= upper + slack);
    let Some(&(_, upper)) = zone else {
        let what = "a stick zone that holds the body";
        return Err(Error::NotFound { what, t, span: 0.0 });
    };
    let room = |later: f64| upper + model.support(t + later) - x[0] - model.belt_speed * later;
    // The zone's end returns with every forcing period, the belt goes on: half a period at a time the search is short.
    let window = 0.5 * model.period();
    let most = 1000;
    for k in 0..most {
        let from = f64::from(k) * window;
        let ahead = |s: f64| room(from + s * window);
        if let Some(part) = first_zero(ahead, 0.0, 1.0) {
            let later = from + window * part;
            let at = State::from([x[0] + model.belt_speed * later, model.belt_speed]);
            return Ok((t + later, at));
        }
    }
    let what = "the upper end of the stick zone";
    Err(Error::NotFound {
        what,
        t,
        span: f64::from(most) * window,
    })
}
