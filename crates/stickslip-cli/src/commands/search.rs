//! The search for a periodic orbit, from a run and by shooting.

use serde::Serialize;
use stickslip::analysis::{
    PeriodicOrbit, RecurrenceSettings, find_periodic_orbit, periodic_orbit, periodic_orbit_forced,
};
use stickslip::dynamics::{Section, Summary, Vector};
use stickslip::{Ending, Error, Options};
use stickslip_kernels::kernel::{Motion, Run, Watcher, follow};

use super::attractors;
use super::extremes::Extremes;
use super::sweeping::check_period;
use crate::failure::Failure;
use crate::render::state_words;
use crate::terminal::patiently;
use stickslip_kernels::file::System;

/// How a periodic orbit is looked for.
#[derive(Debug, clap::Args, Serialize)]
pub(super) struct SearchArguments {
    /// How long the run before is; 0 to shoot from the start
    #[arg(long, value_name = "TIME", default_value_t = 200.0)]
    transient: f64,
    /// How long the orbit may take to come back, of a system that does not depend on time; default 100
    #[arg(long, value_name = "TIME")]
    longest: Option<f64>,
    /// Periods of the drive in one of the orbit, of a driven system; default the fewest after which the run comes back, 16 at most
    #[arg(long, value_name = "COUNT")]
    periods: Option<u32>,
}

/// How long the orbit may take to come back where nothing is given.
const LONGEST: f64 = 100.0;

/// How long the run is followed to see what it comes to, where no periodic orbit was found.
const UNTIL: f64 = 2000.0;

/// Most periods of the drive that are tried for one of the orbit.
const MOST_PERIODS: u32 = 16;

/// Part of the state within which it has come back after a part of the period that was found.
const RETURNED: f64 = 1e-6;

impl SearchArguments {
    /// The orbit that the run from `(t, x)` comes to, and the number of periods of the drive in one of it, if there is a drive.
    pub(super) fn found(
        &self,
        system: &System,
        (t, x): (f64, &[f64]),
        options: &Options,
    ) -> Result<(PeriodicOrbit, Option<u32>), Failure> {
        for (name, value) in [
            ("--transient", self.transient),
            ("--longest", self.longest.unwrap_or(LONGEST)),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Failure::Usage(format!(
                    "{name} {value}: it must be finite and not negative"
                )));
            }
        }
        check_period(system)?;
        let search = Search {
            system,
            options,
            transient: self.transient,
            longest: self.longest.unwrap_or(LONGEST),
        };
        let drive = system.built.period.filter(|_| system.built.depends_on_time);
        self.have_effect(drive)?;
        patiently("looking for a periodic orbit", |_| match drive {
            Some(period) => search.driven(t, x, period, self.periods),
            None => match search.free(x) {
                Ok(orbit) => Ok((orbit, None)),
                Err(error) => Err(search.instead(error, x)),
            },
        })
    }

    /// The equilibrium that the run from `x` comes to, or without a run that state.
    pub(super) fn equilibrium(
        &self,
        system: &System,
        x: &[f64],
        options: &Options,
    ) -> Result<Vec<f64>, Failure> {
        if system.built.depends_on_time {
            return Err(Failure::Usage(
                "--equilibrium has no effect: the system depends on time, so that it has none; \
                 leave it out"
                    .to_owned(),
            ));
        }
        if self.transient == 0.0 {
            return Ok(x.to_vec());
        }
        let settings = RecurrenceSettings::within(UNTIL.max(self.transient));
        let outcome = attractors::reached_from(system, x, &settings, options)?;
        let point = outcome.points.first();
        match (&outcome.motion, point) {
            (Motion::Equilibrium, Some((_, x))) => Ok(x.clone()),
            _ => Err(Failure::NoPeriodicOrbit(format!(
                "no equilibrium was found: the run comes to {}; start elsewhere (--start), or \
                 beside an equilibrium without a run (--transient 0)",
                attractors::words(&outcome, UNTIL)
            ))),
        }
    }

    /// Refuses what would be given in vain.
    fn have_effect(&self, drive: Option<f64>) -> Result<(), Failure> {
        match (drive, self.periods, self.longest) {
            (None, Some(periods), _) => Err(Failure::Usage(format!(
                "--periods {periods} has no effect: the system does not depend on time, so that the period of its orbits is found and not \
                 given; leave it out"
            ))),
            (Some(_), _, Some(longest)) => Err(Failure::Usage(format!(
                "--longest {longest} has no effect: the system depends on time, so that its orbits come back after a multiple of the period; \
                 give --periods, or leave it out"
            ))),
            _ => Ok(()),
        }
    }
}

struct Search<'a> {
    system: &'a System,
    options: &'a Options,
    transient: f64,
    longest: f64,
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
        let orbit = find_periodic_orbit(system, x, self.transient, self.longest, self.options)?;
        self.shortest(orbit)
    }

    /// The same orbit with its shortest period. Where stick has made all returns equal but for rounding, one of the later ones may be the nearest.
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

    /// Of a driven one: first a whole number of periods as a transient, then as many as it takes to come back.
    fn driven(
        &self,
        t: f64,
        x: &[f64],
        period: f64,
        periods: Option<u32>,
    ) -> Result<(PeriodicOrbit, Option<u32>), Failure> {
        if periods == Some(0) {
            return Err(Failure::Usage(
                "--periods 0: an orbit takes one period at least".to_owned(),
            ));
        }
        let wait = (self.transient / period).ceil() * period;
        let x = Vector::from_column_slice(x);
        let (t, x) = if wait > 0.0 {
            self.strobed(t, &x, wait)?
        } else {
            (t, x)
        };
        let count = match periods {
            Some(count) => count,
            None => self.comes_back(t, &x, period)?,
        };
        let period = f64::from(count) * period;
        if self.rests((t, &x), period)? {
            let place = state_words(x.as_slice());
            return Err(comes_to(&format!(
                "rest at {place}, where friction holds it against the drive"
            )));
        }
        let orbit = periodic_orbit_forced(self.system.dynamics(), t, &x, period, self.options)?;
        Ok((orbit, Some(count)))
    }

    /// Whether nothing moves in a period.
    fn rests(&self, (t, x): (f64, &Vector), period: f64) -> Result<bool, Error> {
        let mut extremes = Extremes::from(x.as_slice());
        self.follow((t, x), period, &mut extremes)?;
        let found = extremes.found();
        Ok(found.iter().all(|(low, high)| low == high))
    }

    /// Why there is no periodic orbit: where the run comes to rest, that it does, where it takes longer to come back, how long, and otherwise what
    /// the search failed with.
    fn instead(&self, error: Error, x: &[f64]) -> Failure {
        let looked = matches!(
            error,
            Error::NotConverged { .. }
                | Error::NotFound { .. }
                | Error::TangentSingular { .. }
                | Error::EventPileUp { .. }
                | Error::Shrunk { .. }
        );
        let settings = RecurrenceSettings::within(UNTIL.max(self.transient + self.longest));
        let outcome = looked
            .then(|| attractors::reached_from(self.system, x, &settings, self.options))
            .and_then(Result::ok);
        let Some(outcome) = outcome else {
            return error.into();
        };
        match (attractors::place(&outcome), outcome.motion) {
            (Some(place), Motion::EquilibriumSet) => comes_to(&format!(
                "the equilibrium {place}, one of a set of equilibria"
            )),
            (Some(place), _) => comes_to(&format!("the equilibrium {place}")),
            // What is left of a stick passes before the orbit is awaited.
            (None, Motion::Periodic { period, .. }) if 2.0 * period > self.longest => {
                Failure::NoPeriodicOrbit(format!(
                    "no periodic orbit was found that comes back within {}: the run comes to one of period {period:.6}; give a longer time \
                     (--longest)",
                    self.longest
                ))
            }
            _ => error.into(),
        }
    }

    fn strobed(&self, t: f64, x: &Vector, span: f64) -> Result<(f64, Vector), Failure> {
        let ended = self.follow((t, x), span, &mut ())?;
        let (t, x) = (ended.t, stickslip::error::Point::from(&ended.x));
        match ended.ending {
            Ending::Shrunk => return Err(Error::Shrunk { t, x }.into()),
            ending if ending.is_final() => return Err(Error::NoUniqueFuture { t, x }.into()),
            _ => {}
        }
        Ok((ended.t, ended.x))
    }

    /// After how many periods the run is about where it was, as near as it ever comes.
    fn comes_back(&self, t: f64, x: &Vector, period: f64) -> Result<u32, Failure> {
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

/// That a run ends at rest.
fn comes_to(rest: &str) -> Failure {
    Failure::NoPeriodicOrbit(format!(
        "no periodic orbit was found: the run comes to {rest}; start elsewhere (--start), or set other parameters (--set)"
    ))
}
