//! Options of the search for a periodic orbit.

use serde::Serialize;
use stickslip::analysis::PeriodicOrbit;
use stickslip::error::Point;
use stickslip::{Error, Options};
use stickslip_model::file::System;
use stickslip_model::study::{MOTION_SEARCH_TIME, PeriodicSearch, SearchError, equilibrium};

use super::attractors;
use super::sweeping::check_period;
use crate::failure::Failure;
use crate::render::state_words;
use output::terminal::with_spinner;

/// Settings of the search for a periodic orbit.
#[derive(Debug, clap::Args, Serialize)]
pub(super) struct SearchArguments {
    /// Length of the run before the search; 0 searches from the start. Default 200, but at most
    /// 1000 periods of a drive or, without a drive, 1000 transitions
    #[arg(long, value_name = "TIME")]
    transient: Option<f64>,
    /// Longest time of return, for a system that does not depend on time; default 100
    #[arg(long, value_name = "TIME")]
    longest: Option<f64>,
    /// Period of the orbit in periods of the drive; default the smallest number after which the run
    /// returns, at most 16
    #[arg(long, value_name = "COUNT")]
    periods: Option<u32>,
}

/// Default for the longest period.
const DEFAULT_LONGEST: f64 = 100.0;

impl SearchArguments {
    /// Searches the periodic orbit that the run from `(t, x)` approaches. Also returns its number
    /// of periods of the drive, if there is a drive.
    pub(super) fn periodic_orbit(
        &self,
        system: &System,
        (t, x): (f64, &[f64]),
        options: &Options,
    ) -> Result<(PeriodicOrbit, Option<u32>), Failure> {
        check_period(system)?;
        let search = PeriodicSearch {
            transient: self.transient,
            period: None,
            longest: self.longest.unwrap_or(DEFAULT_LONGEST),
            periods: self.periods,
        };
        let drive = system.built.period.filter(|_| system.built.depends_on_time);
        self.have_effect(drive)?;
        let found = with_spinner("looking for a periodic orbit", |_| {
            search.orbit(system, (t, x), options)
        });
        found.map_err(|error| in_words(error, system))
    }

    /// The equilibrium that the run from `x` approaches, or `x` itself without a run.
    pub(super) fn equilibrium(
        &self,
        system: &System,
        x: &[f64],
        options: &Options,
    ) -> Result<Vec<f64>, Failure> {
        let found = equilibrium(system, x, self.transient, options);
        found.map_err(|error| in_words(error, system).of(system))
    }

    /// Rejects options without effect.
    fn have_effect(&self, drive: Option<f64>) -> Result<(), Failure> {
        match (drive, self.periods, self.longest) {
            (None, Some(periods), _) => Err(Failure::Usage(format!(
                "--periods {periods} has no effect: the system does not depend on time, so that \
                 the period of its orbits is found and not given; leave it out"
            ))),
            (Some(_), _, Some(longest)) => Err(Failure::Usage(format!(
                "--longest {longest} has no effect: the system depends on time, so that its orbits \
                 come back after a multiple of the period; give --periods, or leave it out"
            ))),
            _ => Ok(()),
        }
    }
}

/// Words for the failure of a search, and its remedy.
fn in_words(error: SearchError, system: &System) -> Failure {
    let comes_to = |rest: &str| {
        Failure::NoPeriodicOrbit(format!(
            "no periodic orbit was found: the run comes to {rest}; start elsewhere (--start), or \
                set other parameters (--set)"
        ))
    };
    let place = |x: &Point| state_words(&x.0);
    match &error {
        SearchError::NoPeriods => {
            Failure::Usage("--periods 0: an orbit takes one period at least".to_owned())
        }
        SearchError::Setting { name, value } => Failure::Usage(format!(
            "--{name} {value}: it must be finite and not negative"
        )),
        SearchError::Period(error) => Failure::Usage(error.to_string()),
        SearchError::Held { x } => comes_to(&format!(
            "rest at {}, where friction holds it against the drive",
            place(x)
        )),
        SearchError::Equilibrium { x, is_of_set } => {
            let set = if *is_of_set {
                ", one of a set of equilibria"
            } else {
                ""
            };
            comes_to(&format!("the equilibrium {}{set}", place(x)))
        }
        SearchError::HasNoEquilibrium => Failure::Usage(
            "--equilibrium has no effect: the system depends on time, so that it has none; leave \
                it out"
                .to_owned(),
        ),
        SearchError::NoEquilibrium(outcome) => Failure::NoPeriodicOrbit(format!(
            "no equilibrium was found: the run comes to {}; start elsewhere (--start), or beside \
                an equilibrium without a run (--transient 0)",
            attractors::words(system, outcome, MOTION_SEARCH_TIME)
        )),
        SearchError::TakesLonger { .. } => {
            Failure::NoPeriodicOrbit(format!("{error}; give a longer time (--longest)"))
        }
        SearchError::Failed(Error::NotFound { .. }) => {
            let other = match system.built.depends_on_time {
                true => "another period (--periods)",
                false => "a longer time (--longest)",
            };
            Failure::NoPeriodicOrbit(format!(
                "{error}; give {other}, another run before (--transient), or start elsewhere \
                 (--start)"
            ))
        }
        SearchError::Failed(error) => error.clone().into(),
    }
}
