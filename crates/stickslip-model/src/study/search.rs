//! The search for a periodic orbit, from a run and by shooting.

use std::ops::ControlFlow;

use stickslip::analysis::{Attractor, AttractorKind, PeriodicOrbit, RecurrenceSettings, attractor};
use stickslip::dynamics::{OrbitProgress, Summary, Vector};
use stickslip::error::Point;
use stickslip::{Ending, Error, Options};

use super::extremes::{PARTS_PER_STEP, time_in};
use crate::file::{PeriodError, System};
use crate::kernel::{Watcher, follow, ignore};

/// Time for which the run is followed to name its motion if no periodic orbit is found. It is the
/// default of `--until`, too.
pub const MOTION_SEARCH_TIME: f64 = 2000.0;

/// Largest number of drive periods that is tried as the period of the orbit. It is chosen: four
/// period doublings.
pub const MOST_PERIODS: u32 = 16;

/// Default length of the transient, in units of the file's time. It is chosen: with a decay of 10 %
/// per unit of time it leaves 2e-9.
const DEFAULT_TRANSIENT: f64 = 200.0;

/// Transitions, or periods of the drive, after which the default transient ends if that is earlier.
/// It is chosen: the decay per cycle has no time scale, and 3 % of it leave 1e-13.
const DEFAULT_TRANSIENT_CYCLES: u32 = 1000;

/// Settings of the search for a periodic orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicSearch {
    /// Length of the preceding transient; 0 to shoot from the start. The default is 200, or less:
    /// at most 1000 periods of a drive, and without a drive 1000 transitions.
    pub transient: Option<f64>,
    /// Period of the orbit. For an autonomous system it is a guess. By default it is found.
    pub period: Option<f64>,
    /// Longest return time for an autonomous system.
    pub longest: f64,
    /// Period of the orbit in periods of the drive, for a driven system. By default it is the
    /// smallest number after which the run returns, at most [`MOST_PERIODS`].
    pub periods: Option<u32>,
}

/// Reason for which no periodic orbit was found.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SearchError {
    /// An orbit takes at least one period.
    #[error("periods = 0: an orbit takes one period of the drive at least")]
    NoPeriods,
    /// A setting is not allowed.
    #[error("{name} = {value}: it must be {BOUND_OF_TIMES}")]
    Setting {
        /// Name.
        name: &'static str,
        /// Value.
        value: f64,
    },
    /// The period of the drive is not known.
    #[error(transparent)]
    Period(#[from] PeriodError),
    /// Friction holds the system against the drive.
    #[error(
        "no periodic orbit was found: the run comes to rest at {x}, where friction holds it \
            against the drive"
    )]
    Held {
        /// State.
        x: Point,
    },
    /// The run reaches an equilibrium.
    #[error("no periodic orbit was found: the run comes to the equilibrium {x}")]
    Equilibrium {
        /// The equilibrium.
        x: Point,
        /// Whether it is one of a set of equilibria.
        is_of_set: bool,
    },
    /// The return takes longer.
    #[error(
        "no periodic orbit was found that comes back within {longest}: the run comes to one of \
            period {period:.6}"
    )]
    TakesLonger {
        /// The longest time allowed.
        longest: f64,
        /// The period.
        period: f64,
    },
    /// A system that depends on time has no equilibrium.
    #[error("the system depends on time, so that it has no equilibrium")]
    HasNoEquilibrium,
    /// The run reaches another motion than an equilibrium.
    #[error("no equilibrium was found: the run comes to a motion of kind `{}`", .0.kind.word())]
    NoEquilibrium(Box<Attractor>),
    /// The search failed with an error.
    #[error(transparent)]
    Failed(#[from] Error),
}

/// Bound of the times of a search, in words.
pub const BOUND_OF_TIMES: &str = "finite and not negative";

pub(super) fn check_time(name: &'static str, value: f64) -> Result<(), SearchError> {
    match value >= 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(SearchError::Setting { name, value }),
    }
}

impl PeriodicSearch {
    /// The orbit that the run from a time and state reaches. For a driven system whose period is
    /// not given, also its period in periods of the drive.
    ///
    /// # Errors
    /// [`SearchError`].
    pub fn orbit(
        &self,
        system: &System,
        (t, x): (f64, &[f64]),
        options: &Options,
    ) -> Result<(PeriodicOrbit, Option<u32>), SearchError> {
        check_time("transient", self.transient.unwrap_or(DEFAULT_TRANSIENT))?;
        check_time("longest", self.longest)?;
        let search = OrbitSearch {
            system,
            options,
            settings: self,
        };
        let dynamics = system.dynamics();
        if let Some(period) = self.period {
            let drive = Some(period).filter(|_| system.built.depends_on_time);
            let (t, x) = search.after_transient(t, x, drive)?;
            let orbit = match drive {
                Some(period) => PeriodicOrbit::near_forced(dynamics, t, &x, period, options),
                None => PeriodicOrbit::near(dynamics, &x, period, options),
            };
            return Ok((orbit?, None));
        }
        let drive = system.checked_period()?;
        match drive.filter(|_| system.built.depends_on_time) {
            Some(period) => search.driven(t, x, period),
            None => match search.free(t, x) {
                Ok(orbit) => Ok((orbit, None)),
                Err(error) => Err(search.explained(error, x)),
            },
        }
    }
}

struct OrbitSearch<'a> {
    system: &'a System,
    options: &'a Options,
    settings: &'a PeriodicSearch,
}

impl OrbitSearch<'_> {
    /// Follows the orbit from `(t, x)` for a time `span`.
    fn follow(
        &self,
        (t, x): (f64, &Vector),
        span: f64,
        watcher: &mut Watcher<'_>,
    ) -> Result<Summary, Error> {
        let (system, start) = (self.system.dynamics(), (t, x.as_slice()));
        follow(system, start, t + span, self.options, &[], watcher)
    }

    /// The orbit of an autonomous system.
    fn free(&self, t: f64, x: &[f64]) -> Result<PeriodicOrbit, Error> {
        let (t, x) = self.after_transient(t, x, None)?;
        let (system, longest) = (self.system.dynamics(), self.settings.longest);
        // The search counts time from the end of the transient; its errors get the file's time.
        let found = PeriodicOrbit::approached(system, &x, 0.0, longest, self.options);
        found.map_err(|error| match error {
            Error::NotFound { what, span, .. } => Error::NotFound { what, t, span },
            other => other,
        })
    }

    /// The orbit of a driven system. The transient is an integer number of periods. The orbit takes
    /// as many periods as the run needs to return, or fewer if it closes after these.
    fn driven(
        &self,
        t: f64,
        x: &[f64],
        period: f64,
    ) -> Result<(PeriodicOrbit, Option<u32>), SearchError> {
        if self.settings.periods == Some(0) {
            return Err(SearchError::NoPeriods);
        }
        let (t, x) = self.after_transient(t, x, Some(period))?;
        let given = self.settings.periods;
        let count = match given {
            Some(count) => count,
            None => self.return_periods(t, &x, period)?,
        };
        let drive = period;
        let period = f64::from(count) * drive;
        if self.rests((t, &x), period)? {
            return Err(SearchError::Held { x: (&x).into() });
        }
        let (system, options) = (self.system.dynamics(), self.options);
        let orbit = PeriodicOrbit::near_forced(system, t, &x, period, options)?;
        let orbit = match given {
            Some(_) => orbit,
            None => orbit.with_shortest_period(system, Some(drive), options)?,
        };
        let count = (orbit.period / drive).round() as u32;
        Ok((orbit, Some(count)))
    }

    /// Explains the lack of a periodic orbit: the run reaches an equilibrium, or it takes longer to
    /// return. Otherwise the error of the search is returned.
    fn explained(&self, error: Error, x: &[f64]) -> SearchError {
        let looked = matches!(
            error,
            Error::NotConverged { .. }
                | Error::NotFound { .. }
                | Error::TangentSingular { .. }
                | Error::ChainedJumps { .. }
                | Error::SimultaneousEvents { .. }
                | Error::TiedChoice { .. }
                | Error::EventPileUp { .. }
                | Error::Shrunk { .. }
        );
        let longest = self.settings.longest;
        let transient = self.settings.transient.unwrap_or(DEFAULT_TRANSIENT);
        let settings = RecurrenceSettings::within(MOTION_SEARCH_TIME.max(transient + longest));
        let reached = looked
            .then(|| attractor(self.system.dynamics(), x, &settings, self.options))
            .and_then(Result::ok);
        match reached.as_ref().map(|one| (&one.kind, one.points.first())) {
            Some((
                kind @ (AttractorKind::Equilibrium | AttractorKind::EquilibriumSet),
                Some(at),
            )) => SearchError::Equilibrium {
                x: (&at.x).into(),
                is_of_set: *kind == AttractorKind::EquilibriumSet,
            },
            // The remainder of a stick phase passes before the wait for the orbit begins.
            Some((&AttractorKind::Periodic { period, .. }, _)) if 2.0 * period > longest => {
                SearchError::TakesLonger { longest, period }
            }
            _ => error.into(),
        }
    }

    /// The time and state after the transient, which is an integer number of periods of the drive.
    fn after_transient(
        &self,
        t: f64,
        x: &[f64],
        drive: Option<f64>,
    ) -> Result<(f64, Vector), Error> {
        let given = self.settings.transient;
        let cycles = f64::from(DEFAULT_TRANSIENT_CYCLES);
        let span = given.unwrap_or(drive.map_or(DEFAULT_TRANSIENT, |period| {
            DEFAULT_TRANSIENT.min(cycles * period)
        }));
        let span = drive.map_or(span, |period| (span / period).ceil() * period);
        let x = Vector::from_column_slice(x);
        if span == 0.0 {
            return Ok((t, x));
        }
        let is_counted = given.is_none() && drive.is_none();
        let (mut left, mut end) = (is_counted.then_some(DEFAULT_TRANSIENT_CYCLES), None);
        let ended = self.follow((t, &x), span, &mut |progress, orbit| {
            match progress {
                OrbitProgress::Transition(_) => left = left.map(|left| left.saturating_sub(1)),
                // A step may end at the next transition; in its middle there is none.
                OrbitProgress::Step if left == Some(0) => {
                    let step = orbit.last_step();
                    let t = 0.5 * (step.t_start + step.t_end);
                    if t != step.t_end {
                        end = Some((t, orbit.solution()(t)));
                        return ControlFlow::Break(());
                    }
                }
                _ => {}
            }
            ControlFlow::Continue(())
        })?;
        end.map_or_else(|| at_end(ended, t), Ok)
    }

    /// Whether friction holds the state for a period.
    fn rests(&self, start: (f64, &Vector), period: f64) -> Result<bool, Error> {
        let mut lasts = true;
        self.follow(start, period, &mut |progress, orbit| {
            if progress == OrbitProgress::Step {
                let (step, solution) = (orbit.last_step(), orbit.solution());
                let is_at_x = |k| solution(time_in(&step, k)) == *start.1;
                lasts = step.mode.any_sticks() && (0..=PARTS_PER_STEP).all(is_at_x);
            }
            match lasts {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        })?;
        Ok(lasts)
    }

    /// The time and state after a period.
    fn after_period(&self, t: f64, x: &Vector, period: f64) -> Result<(f64, Vector), Error> {
        at_end(self.follow((t, x), period, &mut ignore)?, t)
    }

    /// Number of periods after which the run returns about as near as it ever does.
    fn return_periods(&self, t: f64, x: &Vector, period: f64) -> Result<u32, Error> {
        let mut distances = Vec::new();
        let (mut at, mut now) = (t, x.clone());
        for _ in 0..MOST_PERIODS {
            (at, now) = self.after_period(at, &now, period)?;
            let away = now.iter().zip(x).map(|(a, b)| (a - b).abs());
            distances.push(away.fold(0.0, f64::max));
        }
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        // Rounding and the remaining transient do not count as a difference.
        let near = (10.0 * nearest).max(1e-9);
        let first = distances.iter().position(|&distance| distance <= near);
        Ok(first.map_or(1, |first| first as u32 + 1))
    }
}

/// The end of a run from a time `begun`, which other runs go on from.
fn at_end(ended: Summary, begun: f64) -> Result<(f64, Vector), Error> {
    let (t, x) = (ended.t, Point::from(&ended.x));
    match ended.ending {
        Ending::EndTime => Ok((ended.t, ended.x)),
        Ending::Shrunk => Err(Error::Shrunk { t, x }),
        Ending::Stopped => Err(Error::NotFound {
            what: "a return of the orbit before a jump stops it",
            t: begun,
            span: t - begun,
        }),
        _ => Err(Error::NoUniqueFuture { t, x }),
    }
}
