//! "Estimated with high accuracy": the order and the error of the Hénon step against exact event times.

use super::convergence::{PRINTED_STEP, order};
use crate::paper::listing::{Defect, Defects, ListingError, Params, Run, Setup, run};
use stickslip::error::Error;
use stickslip::filippov::{Locator, Method, Options, TransitionKind, solve};
use stickslip::models::ForcedOscillator;
use stickslip::ode::{Rk4, Timed, henon_step};
use stickslip::orbit::Orbit;
use stickslip::system::{Filippov, Mode, Side, State};

/// Steps (s) at which orders are measured: their errors are well above rounding.
const STEPS: [f64; 5] = [1.6e-2, 1.13e-2, 8e-3, 5.7e-3, 4e-3];
/// How long before the event a run starts (s), not a multiple of any step.
const LEAD: f64 = 0.2003;
/// Part of a step that the single Hénon step has to make.
const PART: f64 = 0.7;
const TOLERANCE: f64 = 1e-14;
/// End of the run that lets the motion settle (s).
const SETTLED: f64 = 63.3;

/// Errors of the time of one event.
#[derive(Clone, Debug, PartialEq)]
pub struct EventErrors {
    /// How the event was found.
    pub method: &'static str,
    /// The side the orbit comes from.
    pub from: Side,
    /// Steps and errors (s).
    pub errors: Vec<(f64, f64)>,
    /// Slope of log error against log step.
    pub order: f64,
    /// Error at the printed step (s).
    pub at_printed_step: f64,
}

/// Errors of event times on the stated model's own orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// The stated method (RK4 with fixed step, then one Hénon step onto Σ), from either side.
    pub stated: [EventErrors; 2],
    /// One Hénon step alone from an exact state, from either side: a step errs by one order more.
    pub single: [EventErrors; 2],
    /// The listing with the sign of its step from above as printed and all else mended.
    pub printed_sign: EventErrors,
    /// The listing as printed, from either side.
    pub as_printed: [EventErrors; 2],
}

/// Why the accuracy could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum AccuracyError {
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The listing cannot run.
    #[error(transparent)]
    Listing(#[from] ListingError),
}

/// An event on the settled orbit, and a state some time before it.
struct Event {
    from: Side,
    t0: f64,
    x0: State<f64, 2>,
    /// The event's time, exact to rounding.
    t: f64,
    /// The orbit between.
    orbit: Orbit<2>,
}

impl Accuracy {
    /// Measures all errors.
    ///
    /// # Errors
    /// [`AccuracyError`].
    pub fn compute() -> Result<Accuracy, AccuracyError> {
        let model = ForcedOscillator::default();
        let up = event(&model, Side::Below)?;
        let down = event(&model, Side::Above)?;
        let sign_alone = Defects::MENDED.flipped(Defect::S2StepSign);
        Ok(Accuracy {
            stated: [stated(&model, &up)?, stated(&model, &down)?],
            single: [single(&model, &up)?, single(&model, &down)?],
            printed_sign: listing(
                "listing, sign of the Hénon step as printed",
                sign_alone,
                &down,
            )?,
            as_printed: [
                listing("listing as printed", Defects::AS_PRINTED, &up)?,
                listing("listing as printed", Defects::AS_PRINTED, &down)?,
            ],
        })
    }

    /// Whether "high accuracy" is true of the stated method: event times converge with the order of the integrator, and at the
    /// printed step err by less than half a unit of the last digit the paper prints.
    pub fn stated_is_accurate(&self) -> bool {
        self.stated.iter().all(EventErrors::is_accurate)
    }

    /// Whether it is true of the listing as printed.
    pub fn as_printed_is_accurate(&self) -> bool {
        self.as_printed.iter().all(EventErrors::is_accurate)
    }
}

impl EventErrors {
    /// Durations are printed to 1e-4 s; the integrator's order is 4.
    fn is_accurate(&self) -> bool {
        self.order > 3.5 && self.at_printed_step < 0.5e-4
    }

    /// One line of evidence.
    pub fn line(&self) -> String {
        let from = match self.from {
            Side::Below => "below",
            Side::Above => "above",
        };
        let (method, off) = (self.method, self.at_printed_step);
        if self.is_accurate() {
            return format!(
                "{method}, from {from}: order {:.2}, event time off by {off:.1e} s at h = {PRINTED_STEP:e} s",
                self.order
            );
        }
        format!(
            "{method}, from {from}: event time off by {off:.1e} s at h = {PRINTED_STEP:e} s, {:.1} steps; at steps of {:e} to {:e} s by {:.1} to \
             {:.1} steps",
            off / PRINTED_STEP,
            STEPS[STEPS.len() - 1],
            STEPS[0],
            self.in_steps(f64::min),
            self.in_steps(f64::max)
        )
    }

    fn in_steps(&self, pick: fn(f64, f64) -> f64) -> f64 {
        let all = self.errors.iter().map(|(h, e)| e / h);
        all.reduce(pick).unwrap_or(f64::NAN)
    }
}

/// The last crossing from one side on the settled orbit.
fn event(model: &ForcedOscillator, from: Side) -> Result<Event, Error> {
    let options = Options::tol(TOLERANCE);
    let start = State::from([Params::default().x1, model.belt_speed]);
    let settled = solve(model, 0.0, start, SETTLED, &options)?;
    let crossing = settled
        .transitions
        .iter()
        .rfind(|at| at.kind == TransitionKind::Crossing && at.from == Mode::Slip(from))
        .ok_or(Error::NotFound {
            what: "a crossing of Σ",
            t: 0.0,
            span: SETTLED,
        })?;
    let t0 = crossing.t - LEAD;
    let x0 = settled.at(t0)?;
    // Afresh from that state, so that it alone decides.
    let orbit = solve(model, t0, x0, crossing.t + LEAD, &options)?;
    let t = first_transition(&orbit, t0)?;
    Ok(Event {
        from,
        t0,
        x0,
        t,
        orbit,
    })
}

fn first_transition(orbit: &Orbit<2>, t: f64) -> Result<f64, Error> {
    let what = "a crossing of Σ";
    let first = orbit.transitions.first().map(|at| at.t);
    let span = 2.0 * LEAD;
    first.ok_or(Error::NotFound { what, t, span })
}

fn measure<E>(
    method: &'static str,
    event: &Event,
    error: impl Fn(f64) -> Result<f64, E>,
) -> Result<EventErrors, E> {
    let errors = STEPS
        .into_iter()
        .map(|h| Ok((h, error(h)?)))
        .collect::<Result<Vec<_>, E>>()?;
    Ok(EventErrors {
        method,
        from: event.from,
        order: order(&errors),
        errors,
        at_printed_step: error(PRINTED_STEP)?,
    })
}

fn stated(model: &ForcedOscillator, event: &Event) -> Result<EventErrors, Error> {
    measure("RK4 and Hénon step", event, |h| {
        // n + ½ steps to the event, so that the last cut falls alike for all of them.
        let lead = event.t - event.t0;
        let step = lead / ((lead / h).round() + 0.5);
        let options = Options::default()
            .method(Method::Rk4 { step })
            .locator(Locator::Henon);
        let orbit = solve(model, event.t0, event.x0, event.t + 2.0 * step, &options)?;
        Ok((first_transition(&orbit, event.t0)? - event.t).abs())
    })
}

fn single(model: &ForcedOscillator, event: &Event) -> Result<EventErrors, Error> {
    measure("one Hénon step of RK4", event, |h| {
        let t = event.t - PART * h;
        let x = event.orbit.at(t)?;
        let change = model.belt_speed - x[1];
        let mut slope = |at: &Timed<f64, 2>| {
            let f = model.field(event.from, at.t, &at.x);
            Timed {
                t: 1.0 / f[1],
                x: f / f[1],
            }
        };
        let end = henon_step::<Rk4, f64, 2>(&mut slope, &Timed { t, x }, change);
        Ok((end.t - event.t).abs())
    })
}

fn listing(
    method: &'static str,
    defects: Defects,
    event: &Event,
) -> Result<EventErrors, AccuracyError> {
    measure(method, event, |h| {
        let params = Params {
            t0: event.t0,
            x1: event.x0[0],
            x2: event.x0[1],
            ..Params::default()
        };
        let outcome = run(&Setup {
            params,
            defects,
            h,
            window_start: 0.0,
            end: 2.0 * LEAD,
        })?;
        let found = first_on_belt(&outcome).ok_or(Error::NotFound {
            what: "a crossing of Σ by the listing",
            t: event.t0,
            span: 2.0 * LEAD,
        })?;
        Ok((found - event.t).abs())
    })
}

/// When the listing first reaches the belt's speed.
fn first_on_belt(run: &Run) -> Option<f64> {
    let crossing = run.crossings.first().map(|crossing| crossing.at.t);
    let entry = run.phases.first().map(|phase| phase.entry.t);
    let unfinished = run.unfinished.map(|(entry, _)| entry.t);
    [crossing, entry, unfinished]
        .into_iter()
        .flatten()
        .reduce(f64::min)
}
