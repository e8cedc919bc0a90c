//! The search for a periodic orbit, from a run and by shooting.

use stickslip::{Error, Options};
use stickslip_kernels::kernel::{Periodic, Run, Shooting};

use super::Failure;
use super::sweeping::check_period;
use crate::system::System;
use crate::terminal::patiently;

/// How a periodic orbit is looked for.
#[derive(Debug, clap::Args)]
pub(super) struct SearchArguments {
    /// How long the run before is; 0 to shoot from the start
    #[arg(
        long,
        value_name = "TIME",
        allow_negative_numbers = true,
        default_value_t = 200.0
    )]
    transient: f64,
    /// How long the orbit may take to come back
    #[arg(
        long,
        value_name = "TIME",
        allow_negative_numbers = true,
        default_value_t = 100.0
    )]
    longest: f64,
    /// Periods of the drive in one of the orbit; default the fewest after which the run comes back, 16 at most
    #[arg(long, value_name = "COUNT")]
    periods: Option<u32>,
}

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
    ) -> Result<(Periodic, Option<u32>), Failure> {
        for (name, value) in [("--transient", self.transient), ("--longest", self.longest)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Failure::Usage(format!(
                    "{name} {value}: it must be finite and not negative"
                )));
            }
        }
        let search = Search {
            system,
            options,
            transient: self.transient,
            longest: self.longest,
        };
        check_period(system)?;
        patiently("looking for a periodic orbit", || {
            match system.built.period {
                Some(period) if system.built.depends_on_time => {
                    search.driven(t, x, period, self.periods)
                }
                _ => Ok((search.free(t, x)?, None)),
            }
        })
    }
}

struct Search<'a> {
    system: &'a System,
    options: &'a Options,
    transient: f64,
    longest: f64,
}

impl Search<'_> {
    fn run<'x>(&'x self, t: f64, x: &'x [f64], t_end: f64) -> Run<'x> {
        Run {
            t,
            x,
            t_end,
            options: self.options,
        }
    }

    /// Of a system that does not depend on time.
    fn free(&self, t: f64, x: &[f64]) -> Result<Periodic, Error> {
        let shooting = Shooting::Found {
            transient: self.transient,
            longest: self.longest,
        };
        let found = self
            .system
            .kernel()
            .periodic(&self.run(t, x, t), shooting)?;
        self.shortest(found)
    }

    /// The same orbit with its shortest period. Where stick has made all returns equal but for rounding, one of the later ones may be the nearest.
    fn shortest(&self, orbit: Periodic) -> Result<Periodic, Error> {
        let kernel = self.system.kernel();
        let size = orbit
            .x
            .iter()
            .fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()));
        for parts in (2..=MOST_PERIODS).rev() {
            let period = orbit.period / f64::from(parts);
            let part = self.run(orbit.t, &orbit.x, orbit.t + period);
            let ended = kernel.run(&part, None, &mut ())?;
            let away = ended.x.iter().zip(&orbit.x).map(|(a, b)| (a - b).abs());
            if away.fold(0.0, f64::max) <= RETURNED * size {
                return kernel.periodic(&part, Shooting::Free { period });
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
    ) -> Result<(Periodic, Option<u32>), Failure> {
        if periods == Some(0) {
            return Err(Failure::Usage(
                "--periods 0: an orbit takes one period at least".to_owned(),
            ));
        }
        let wait = (self.transient / period).ceil() * period;
        let (t, x) = if wait > 0.0 {
            self.strobed(t, x, wait)?
        } else {
            (t, x.to_vec())
        };
        let count = match periods {
            Some(count) => count,
            None => self.comes_back(t, &x, period)?,
        };
        let forced = Shooting::Forced {
            period: f64::from(count) * period,
        };
        let orbit = self.system.kernel().periodic(&self.run(t, &x, t), forced)?;
        Ok((orbit, Some(count)))
    }

    fn strobed(&self, t: f64, x: &[f64], span: f64) -> Result<(f64, Vec<f64>), Failure> {
        let ended = self
            .system
            .kernel()
            .run(&self.run(t, x, t + span), None, &mut ())?;
        if ended.ending.is_ambiguous() {
            let x = stickslip::error::Point(ended.x);
            return Err(Error::NoUniqueFuture { t: ended.t, x }.into());
        }
        Ok((ended.t, ended.x))
    }

    /// After how many periods the run is about where it was, as near as it ever comes.
    fn comes_back(&self, t: f64, x: &[f64], period: f64) -> Result<u32, Failure> {
        let mut distances = Vec::new();
        let (mut at, mut now) = (t, x.to_vec());
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
