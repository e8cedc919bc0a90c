//! `stickslip orbit`: a periodic orbit.

use std::fmt::Write;

use serde_json::json;
use stickslip::{Error, Options};

use super::arguments::{OutputArguments, SolverArguments, StartArguments, SystemArguments};
use super::recording::{Phase, Recording};
use super::{Failure, Found, figures, tables};
use crate::output::Artifact;
use crate::system::System;
use crate::terminal::{Patience, Said, patiently};
use stickslip_kernels::kernel::{Periodic, Run, Shooting};

/// Find a periodic orbit: from a run, refined by shooting; period, multipliers, sequence of phases
///
/// Of a driven system the period is a multiple of the one that the file gives. Writes orbit.csv, multipliers.csv, phases.csv, transitions.csv,
/// portrait.svg and history.svg of one period.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    system: SystemArguments,
    #[command(flatten)]
    start: StartArguments,
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
    #[command(flatten)]
    solver: SolverArguments,
    #[command(flatten)]
    output: OutputArguments,
}

/// Most periods of the drive that are tried for one of the orbit.
const MOST_PERIODS: u32 = 16;

/// Part of the state within which it has come back after a part of the period that was found.
const RETURNED: f64 = 1e-6;

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    arguments.output.check()?;
    let system = arguments.system.system()?;
    let options = arguments.solver.options()?;
    let (t, x) = arguments.start.of(&system)?;
    for (name, value) in [
        ("--transient", arguments.transient),
        ("--longest", arguments.longest),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(Failure::Usage(format!(
                "{name} {value}: it must be finite and not negative"
            )));
        }
    }
    let search = Search {
        system: &system,
        options: &options,
        transient: arguments.transient,
        longest: arguments.longest,
    };
    let (orbit, periods) = patiently("looking for a periodic orbit", || {
        match system.built.period {
        Some(period) => search.driven(t, &x, period, arguments.periods),
        None if system.built.depends_on_time => Err(Failure::Usage(
            "the system depends on time: what is its period? Add period = \"…\" to [time] of the file".to_owned(),
        )),
        None => Ok((search.free(t, &x)?, None)),
    }
    })?;
    let t_end = orbit.t + orbit.period;
    let mut recording = Recording::new(orbit.t, &orbit.x, t_end, Patience::new("one period"));
    let once = Run {
        t: orbit.t,
        x: &orbit.x,
        t_end,
        options: &options,
    };
    let outcome = system.kernel().run(&once, system.section(), &mut recording);
    recording.close();
    outcome?;
    let found = Orbit {
        system: &system,
        orbit: &orbit,
        periods,
        recording: &recording,
    };
    found.found()?.written(&arguments.output)
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

struct Orbit<'a> {
    system: &'a System,
    orbit: &'a Periodic,
    /// Periods of the drive in one of the orbit.
    periods: Option<u32>,
    recording: &'a Recording,
}

impl Orbit<'_> {
    /// The phases in one period, in letters. The orbit begins in the middle of one, which is counted once.
    fn sequence(&self) -> String {
        let phases = self.recording.phases.iter();
        let mut letters: Vec<String> = phases.map(|phase| tables::letters(&phase.modes)).collect();
        if letters.len() > 1 && letters.first() == letters.last() {
            letters.pop();
        }
        letters.join(" ")
    }

    /// Whether all multipliers but the trivial one of a system that does not depend on time are within the unit circle.
    fn is_stable(&self) -> bool {
        let trivial = usize::from(self.periods.is_none());
        let others = self.orbit.multipliers.iter().skip(trivial);
        others.clone().all(|multiplier| multiplier.norm() < 1.0)
    }

    /// Time in stick in one period.
    fn stick_time(&self) -> f64 {
        let sticks = |phase: &&Phase| phase.modes.as_slice().contains(&stickslip::Mode::Stick);
        self.recording
            .phases
            .iter()
            .filter(sticks)
            .map(Phase::duration)
            .sum()
    }

    fn extremes(&self, state: usize) -> (f64, f64) {
        let values = self.recording.points.iter().map(|point| point.x[state]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    }

    fn found(&self) -> Result<Found, Failure> {
        let Orbit {
            system,
            orbit,
            recording,
            ..
        } = *self;
        let states = system.file.states.iter().map(|state| state.name.clone());
        let mut heading: Vec<String> = ["period", "residual", "t"].map(str::to_owned).into();
        heading.extend(states);
        let mut row: Vec<String> = [orbit.period, orbit.residual, orbit.t]
            .map(tables::exact)
            .into();
        row.extend(orbit.x.iter().map(|&x| tables::exact(x)));
        let multipliers = orbit.multipliers.iter().map(|multiplier| {
            [multiplier.re, multiplier.im, multiplier.norm()]
                .map(tables::exact)
                .into()
        });
        let columns = ["re", "im", "modulus"].map(str::to_owned);
        let tables = vec![
            Artifact::csv("orbit.csv", &heading, [row])?,
            Artifact::csv("multipliers.csv", &columns, multipliers)?,
            tables::phases("phases", system, &recording.phases)?,
            tables::transitions("transitions", system, &recording.transitions)?,
        ];
        let mut figures = vec![("history".to_owned(), figures::history(system, recording)?)];
        if system.states() > 1 {
            figures.push(("portrait".to_owned(), figures::portrait(system, recording)?));
        }
        Ok(Found {
            summary: self.summary(),
            json: self.json(),
            tables,
            figures,
            failure: None,
        })
    }

    fn summary(&self) -> String {
        let orbit = self.orbit;
        let mut text = format!("{}: periodic orbit\n", self.system.file.name);
        let drive = match self.periods {
            Some(1) => "  (1 period of the drive)".to_owned(),
            Some(count) => format!("  ({count} periods of the drive)"),
            None => String::new(),
        };
        // Writing into a text cannot fail.
        let _ = writeln!(text, "  period       {}{drive}", orbit.period);
        let _ = writeln!(text, "  residual     {:e}", orbit.residual);
        for (k, multiplier) in orbit.multipliers.iter().enumerate() {
            let title = if k == 0 { "multipliers" } else { "" };
            let trivial = if k == 0 && self.periods.is_none() {
                "  (the trivial one)"
            } else {
                ""
            };
            let imaginary = match multiplier.im {
                0.0 => String::new(),
                im => format!(" {} {} i", if im < 0.0 { "-" } else { "+" }, im.abs()),
            };
            let _ = writeln!(text, "  {title:13}{}{imaginary}{trivial}", multiplier.re);
        }
        let _ = writeln!(
            text,
            "  stability    {}",
            if self.is_stable() {
                "stable"
            } else {
                "not stable"
            }
        );
        let _ = writeln!(
            text,
            "  phases       {}  (- below, + above, S stick)",
            self.sequence()
        );
        let stick = self.stick_time();
        let _ = writeln!(
            text,
            "  stick        {stick} of the period, {:.1} %",
            100.0 * stick / orbit.period
        );
        for (k, state) in self.system.file.states.iter().enumerate() {
            let (low, high) = self.extremes(k);
            let _ = writeln!(
                text,
                "  {:13}from {low} to {high}, at first {}",
                state.name, orbit.x[k]
            );
        }
        text
    }

    fn json(&self) -> serde_json::Value {
        let orbit = self.orbit;
        let multipliers = orbit.multipliers.iter();
        let multipliers: Vec<[f64; 2]> = multipliers.map(|m| [m.re, m.im]).collect();
        let states = self.system.file.states.iter().enumerate();
        let extremes: serde_json::Map<String, serde_json::Value> = states
            .map(|(k, state)| (state.name.clone(), json!(self.extremes(k))))
            .collect();
        json!({
            "system": tables::system_json(self.system),
            "period": orbit.period,
            "periods_of_drive": self.periods,
            "residual": orbit.residual,
            "t": orbit.t,
            "x": tables::state_json(self.system, &orbit.x),
            "multipliers": multipliers,
            "stable": self.is_stable(),
            "phases": self.sequence(),
            "stick_time": self.stick_time(),
            "extremes": extremes,
        })
    }
}
