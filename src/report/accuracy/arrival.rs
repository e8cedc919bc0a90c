//! Arrival on Σ from slip, Eq. (14): the stated method, its parts, and the listing.

use super::errors::{EXACT_TOLERANCE, EventErrors};
use crate::numbers::not_found;
use crate::paper::listing::{Defects, END, Run, Setup, run};
use crate::paper::models::ForcedOscillator;
use stickslip::ode::{Rk4, Timed, henon_step};
use stickslip::{
    Error, Filippov, Locator, Method, Mode, Options, Orbit, Side, State, TransitionKind, solve,
};

/// Time of a run before the event (s), not a multiple of any step.
const LEAD_TIME: f64 = 0.2003;

/// A crossing on the settled orbit, and a state before it.
pub(super) struct Arrival<'a> {
    model: &'a ForcedOscillator,
    from: Side,
    t0: f64,
    x0: State<2>,
    /// The event's time, exact to rounding.
    t: f64,
    /// The orbit between them.
    orbit: Orbit<2>,
}

impl<'a> Arrival<'a> {
    /// The last crossing from one side on the settled orbit.
    pub(super) fn from(model: &'a ForcedOscillator, from: Side) -> Result<Self, Error> {
        let options = Options::tol(EXACT_TOLERANCE);
        let settled = solve(model, 0.0, Setup::default().state(), END, &options)?;
        let mut transitions = settled.transitions.iter();
        let crossing = transitions
            .rfind(|at| at.kind == TransitionKind::Crossing && at.from == Mode::Slip(from))
            .ok_or_else(|| not_found("a crossing of Σ", 0.0, END))?;
        let t0 = crossing.t - LEAD_TIME;
        let x0 = settled.at(t0)?;
        // Restarted from that state, which alone determines the orbit.
        let orbit = solve(model, t0, x0, crossing.t + LEAD_TIME, &options)?;
        Ok(Arrival {
            model,
            from,
            t0,
            x0,
            t: first_transition(&orbit, t0)?,
            orbit,
        })
    }

    /// The step near `h` for which the event comes after a whole number of steps and `part` of
    /// another. So the last step is cut at the same fraction for all of them.
    fn step(&self, h: f64, part: f64) -> f64 {
        let lead = self.t - self.t0;
        lead / ((lead / h).round() + part)
    }

    fn measure(
        &self,
        method: &'static str,
        locate: impl Fn(f64, f64) -> Result<f64, Error>,
    ) -> Result<EventErrors, Error> {
        EventErrors::measure(method, (self.from, self.t), locate)
    }

    /// RK4 with fixed steps, then one Hénon step onto Σ from the state before the crossing.
    pub(super) fn stated(&self) -> Result<EventErrors, Error> {
        self.measure("arrival by RK4 and Hénon step from", |h, part| {
            let step = self.step(h, part);
            let method = Method::Rk4 { step };
            let options = Options::default().method(method).locator(Locator::Henon);
            let end = self.t + 2.0 * step;
            let orbit = solve(self.model, self.t0, self.x0, end, &options)?;
            first_transition(&orbit, self.t0)
        })
    }

    /// Errors with the step printed in Sect. 3: `vp − x2` from below, `x2 − vp` from above.
    pub(super) fn as_in_the_text(&self) -> Result<EventErrors, Error> {
        let gap = |at: &Timed<2>| self.model.boundary(at.t, at.x.as_ref());
        self.measure(
            "arrival by the step that Sect. 3 prints, from",
            |h, part| {
                let step = self.step(h, part);
                let mut at = Timed {
                    t: self.t0,
                    x: self.x0,
                };
                loop {
                    let next = henon_step::<Rk4, 2>(&mut |at| self.in_time(at), &at, step);
                    if gap(&next) * self.from.sign() <= 0.0 {
                        break;
                    }
                    if next.t > self.t + LEAD_TIME {
                        return Err(not_found("a crossing of Σ", self.t0, 2.0 * LEAD_TIME));
                    }
                    at = next;
                }
                // Both are positive: from above the step leads away from Σ.
                let change = gap(&at).abs();
                Ok(henon_step::<Rk4, 2>(&mut |at| self.in_velocity(at), &at, change).t)
            },
        )
    }

    /// One Hénon step alone from an exact state. Its error is of one order higher.
    pub(super) fn single(&self) -> Result<EventErrors, Error> {
        self.measure("arrival by one Hénon step of RK4 alone from", |h, part| {
            let t = self.t - part * h;
            let x = self.orbit.at(t)?;
            let change = self.model.belt_speed - x[1];
            let mut slope = |at: &Timed<2>| self.in_velocity(at);
            Ok(henon_step::<Rk4, 2>(&mut slope, &Timed { t, x }, change).t)
        })
    }

    /// The listing with these defects.
    pub(super) fn listing(
        &self,
        method: &'static str,
        defects: Defects,
    ) -> Result<EventErrors, Error> {
        self.measure(method, |h, part| {
            let outcome = run(&Setup {
                defects,
                h: self.step(h, part),
                window_start: 0.0,
                end: 2.0 * LEAD_TIME,
                start: [self.t0, self.x0[0], self.x0[1]],
                ..Setup::default()
            });
            let what = "a crossing of Σ by the listing";
            let first = first_on_belt(&outcome);
            first.ok_or_else(|| not_found(what, self.t0, 2.0 * LEAD_TIME))
        })
    }

    fn field(&self, at: &Timed<2>) -> State<2> {
        self.model.field(self.from, at.t, at.x.as_ref()).into()
    }

    /// Slope with time as the independent variable.
    fn in_time(&self, at: &Timed<2>) -> Timed<2> {
        Timed {
            t: 1.0,
            x: self.field(at),
        }
    }

    /// Eq. (14): slope with velocity as the independent variable.
    fn in_velocity(&self, at: &Timed<2>) -> Timed<2> {
        let f = self.field(at);
        Timed {
            t: 1.0 / f[1],
            x: f / f[1],
        }
    }
}

fn first_transition(orbit: &Orbit<2>, t: f64) -> Result<f64, Error> {
    let first = orbit.transitions.first().map(|at| at.t);
    first.ok_or_else(|| not_found("a crossing of Σ", t, 2.0 * LEAD_TIME))
}

/// Time at which the listing first reaches the belt's speed.
fn first_on_belt(run: &Run) -> Option<f64> {
    let crossing = run.crossings.first().map(|crossing| crossing.at.t);
    let entry = run.phases.first().map(|phase| phase.stick.entry.t);
    let unfinished = run.unfinished.map(|(entry, _)| entry.t);
    [crossing, entry, unfinished]
        .into_iter()
        .flatten()
        .reduce(f64::min)
}
