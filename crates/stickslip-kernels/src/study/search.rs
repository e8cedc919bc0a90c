//! The search for a periodic orbit, from a run and by shooting.

use std::ops::ControlFlow;

use stickslip::analysis::{
    Kind, PeriodicOrbit, RecurrenceSettings, attractor, find_periodic_orbit, periodic_orbit,
    periodic_orbit_forced,
};
use stickslip::dynamics::{Section, Step, Summary, Vector};
use stickslip::error::Point;
use stickslip::{Ending, Error, Options};

use crate::file::{PeriodError, System};
use crate::kernel::{Run, Watcher, follow};

/// How long the run is followed to see what it comes to, where no periodic orbit was found.
pub const UNTIL: f64 = 2000.0;

/// Most periods of the drive that are tried for one of the orbit.
pub const MOST_PERIODS: u32 = 16;

/// Part of the state within which it has come back after a part of the period that was found.
const RETURNED: f64 = 1e-6;

/// How a periodic orbit is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicSearch {
    /// How long the run before is; 0 to shoot from the start.
    pub transient: f64,
    /// How long the orbit may take to come back, of a system that does not depend on time.
    pub longest: f64,
    /// Periods of the drive in one of the orbit, of a driven system; if not given, the fewest after
    /// which the run comes back, [`MOST_PERIODS`] at most.
    pub periods: Option<u32>,
}

/// Why no periodic orbit was found.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SearchError {
    /// An orbit takes one period at least.
    #[error("periods = 0: an orbit takes one period of the drive at least")]
    NoPeriods,
    /// A setting is not allowed.
    #[error("{name} = {value}: it must be finite and not negative")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The period of the drive is not known.
    #[error(transparent)]
    Period(#[from] PeriodError),
    /// Friction holds the run against the drive.
    #[error(
        "no periodic orbit was found: the run comes to rest at {x}, where friction holds it \
            against the drive"
    )]
    Held {
        /// Where.
        x: Point,
    },
    /// The run comes to an equilibrium.
    #[error("no periodic orbit was found: the run comes to the equilibrium {x}")]
    Equilibrium {
        /// Where.
        x: Point,
        /// Whether it is one of a set of equilibria.
        is_of_set: bool,
    },
    /// The run takes longer to come back.
    #[error(
        "no periodic orbit was found that comes back within {longest}: the run comes to one of \
            period {period:.6}"
    )]
    TakesLonger {
        /// The time given.
        longest: f64,
        /// The period.
        period: f64,
    },
    /// What the search failed with.
    #[error(transparent)]
    Failed(#[from] Error),
}

impl PeriodicSearch {
    /// The orbit that the run from a time and state comes to, and the number of periods of the
    /// drive in one of it, if there is a drive.
    ///
    /// # Errors
    /// [`SearchError`].
    pub fn found(
        &self,
        system: &System,
        (t, x): (f64, &[f64]),
        options: &Options,
    ) -> Result<(PeriodicOrbit, Option<u32>), SearchError> {
        let times = [("transient", self.transient), ("longest", self.longest)];
        if let Some((name, value)) = times
            .into_iter()
            .find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
        {
            return Err(SearchError::Setting { name, value });
        }
        let drive = system.checked_period()?;
        let drive = drive.filter(|_| system.built.depends_on_time);
        let search = Search {
            system,
            options,
            settings: self,
        };
        match drive {
            Some(period) => search.driven(t, x, period),
            None => match search.free(x) {
                Ok(orbit) => Ok((orbit, None)),
                Err(error) => Err(search.instead(error, x)),
            },
        }
    }
}

struct Search<'a> {
    system: &'a System,
    options: &'a Options,
    settings: &'a PeriodicSearch,
}

impl Search<'_> {
    /// Follows the orbit from `(t, x)` for a time.
    fn follow(
        &self,
        (t, x): (f64, &Vector),
        span: f64,
        watcher: &mut dyn Watcher,
    ) -> Result<Summary, Error> {
        let run = Run {
            t,
            x: x.as_slice(),
            t_end: t + span,
            options: self.options,
        };
        follow(self.system.dynamics(), &run, &Section::None, watcher)
    }

    /// Of a system that does not depend on time.
    fn free(&self, x: &[f64]) -> Result<PeriodicOrbit, Error> {
        let system = self.system.dynamics();
        let PeriodicSearch {
            transient, longest, ..
        } = *self.settings;
        let orbit = find_periodic_orbit(system, x, transient, longest, self.options)?;
        self.shortest(orbit)
    }

    /// The same orbit with its shortest period. Where stick has made all returns equal but for
    /// rounding, one of the later ones may be the nearest.
    fn shortest(&self, orbit: PeriodicOrbit) -> Result<PeriodicOrbit, Error> {
        let size = orbit
            .x
            .iter()
            .fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()));
        for parts in (2..=MOST_PERIODS).rev() {
            let period = orbit.period / f64::from(parts);
            let ended = self.follow((orbit.t, &orbit.x), period, &mut ())?;
            let away = ended.x.iter().zip(&orbit.x).map(|(a, b)| (a - b).abs());
            if away.fold(0.0, f64::max) <= RETURNED * size {
                return periodic_orbit(self.system.dynamics(), &orbit.x, period, self.options);
            }
        }
        Ok(orbit)
    }

    /// Of a driven one: first a whole number of periods as a transient, then as many as it takes to
    /// come back.
    fn driven(
        &self,
        t: f64,
        x: &[f64],
        period: f64,
    ) -> Result<(PeriodicOrbit, Option<u32>), SearchError> {
        if self.settings.periods == Some(0) {
            return Err(SearchError::NoPeriods);
        }
        let wait = (self.settings.transient / period).ceil() * period;
        let x = Vector::from_column_slice(x);
        let (t, x) = if wait > 0.0 {
            self.strobed(t, &x, wait)?
        } else {
            (t, x)
        };
        let count = match self.settings.periods {
            Some(count) => count,
            None => self.comes_back(t, &x, period)?,
        };
        let period = f64::from(count) * period;
        let mut rest = Rest {
            x: x.clone(),
            lasts: true,
        };
        self.follow((t, &x), period, &mut rest)?;
        if rest.lasts {
            return Err(SearchError::Held { x: (&x).into() });
        }
        let orbit = periodic_orbit_forced(self.system.dynamics(), t, &x, period, self.options)?;
        Ok((orbit, Some(count)))
    }

    /// Why there is no periodic orbit: where the run comes to rest, that it does, where it takes
    /// longer to come back, how long, and otherwise what the search failed with.
    fn instead(&self, error: Error, x: &[f64]) -> SearchError {
        let looked = matches!(
            error,
            Error::NotConverged { .. }
                | Error::NotFound { .. }
                | Error::TangentSingular { .. }
                | Error::EventPileUp { .. }
                | Error::Shrunk { .. }
        );
        let PeriodicSearch {
            transient, longest, ..
        } = *self.settings;
        let settings = RecurrenceSettings::within(UNTIL.max(transient + longest));
        let reached = looked
            .then(|| attractor(self.system.dynamics(), x, &settings, self.options))
            .and_then(Result::ok);
        match reached.as_ref().map(|one| (&one.kind, one.points.first())) {
            Some((kind @ (Kind::Equilibrium | Kind::EquilibriumSet), Some(at))) => {
                SearchError::Equilibrium {
                    x: (&at.x).into(),
                    is_of_set: *kind == Kind::EquilibriumSet,
                }
            }
            // What is left of a stick passes before the orbit is awaited.
            Some((&Kind::Periodic { period, .. }, _)) if 2.0 * period > longest => {
                SearchError::TakesLonger { longest, period }
            }
            _ => error.into(),
        }
    }

    fn strobed(&self, t: f64, x: &Vector, span: f64) -> Result<(f64, Vector), Error> {
        let ended = self.follow((t, x), span, &mut ())?;
        let (t, x) = (ended.t, Point::from(&ended.x));
        match ended.ending {
            Ending::Shrunk => return Err(Error::Shrunk { t, x }),
            ending if ending.is_final() => return Err(Error::NoUniqueFuture { t, x }),
            _ => {}
        }
        Ok((ended.t, ended.x))
    }

    /// After how many periods the run is about where it was, as near as it ever comes.
    fn comes_back(&self, t: f64, x: &Vector, period: f64) -> Result<u32, Error> {
        let mut distances = Vec::new();
        let (mut at, mut now) = (t, x.clone());
        for _ in 0..MOST_PERIODS {
            (at, now) = self.strobed(at, &now, period)?;
            let away = now.iter().zip(x).map(|(a, b)| (a - b).abs());
            distances.push(away.fold(0.0, f64::max));
        }
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        // What rounding and the rest of the transient leave is no difference.
        let near = (10.0 * nearest).max(1e-9);
        let first = distances.iter().position(|&distance| distance <= near);
        Ok(first.map_or(1, |first| first as u32 + 1))
    }
}

/// Places of a step at which rest is looked for, in equal parts of it.
const PER_STEP: u32 = 16;

/// Whether nothing moves.
struct Rest {
    x: Vector,
    lasts: bool,
}

impl Watcher for Rest {
    fn watches_steps(&self) -> bool {
        true
    }

    fn step(&mut self, step: &Step, solution: &dyn Fn(f64) -> Vector) -> ControlFlow<()> {
        let at = |k: u32| {
            step.t_start + (step.t_end - step.t_start) * f64::from(k) / f64::from(PER_STEP)
        };
        self.lasts = (0..=PER_STEP).all(|k| solution(at(k)) == self.x);
        match self.lasts {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    }
}
