//! `stickslip orbit`: a periodic orbit.

use std::fmt::Write;

use serde_json::json;

use super::arguments::{Ready, RunArguments};
use super::attractors::family_words;
use super::extremes::Extremes;
use super::recording::{Phase, Recording};
use super::search::SearchArguments;
use super::{Failure, Found, figures, tables};
use crate::output::csv_table;
use crate::terminal::{Patience, Said};
use stickslip::analysis::Stability;
use stickslip::error::readable;
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::{Modes, Periodic, Run};

/// Find a periodic orbit: from a run, refined by shooting; period, multipliers, sequence of phases
///
/// Of a driven system the period is a multiple of the one that the file gives. Writes orbit.csv, multipliers.csv, phases.csv, transitions.csv,
/// portrait.svg and history.svg of one period.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    search: SearchArguments,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    arguments
        .run
        .answered(|ready| found(ready, &arguments.search))
}

fn found(ready: &Ready, search: &SearchArguments) -> Result<Found, Failure> {
    let Ready {
        system, options, ..
    } = ready;
    let (orbit, periods) = search.found(system, (ready.t, &ready.x), options)?;
    let t_end = orbit.t + orbit.period;
    let mut recording = Recording::new(orbit.t, &orbit.x, t_end, Patience::new("one period"));
    let once = Run {
        t: orbit.t,
        x: &orbit.x,
        t_end,
        options,
    };
    let outcome = system.kernel().run(&once, system.section(), &mut recording);
    recording.close();
    outcome?;
    let mut extremes = Extremes::from(&orbit.x);
    system.kernel().run(&once, None, &mut extremes)?;
    let found = Orbit {
        system,
        orbit: &orbit,
        periods,
        recording: &recording,
        extremes: extremes.found(),
    };
    found.found()
}

struct Orbit<'a> {
    system: &'a System,
    orbit: &'a Periodic,
    /// Periods of the drive in one of the orbit.
    periods: Option<u32>,
    recording: &'a Recording,
    /// Least and greatest value of each state.
    extremes: Vec<(f64, f64)>,
}

impl Orbit<'_> {
    /// The phases in one period, in letters. The orbit begins in the middle of one, which is counted once.
    fn sequence(&self) -> String {
        let phases = self.recording.phases.iter();
        let mut modes: Vec<Modes> = phases.map(|phase| phase.modes).collect();
        if modes.len() > 1 && modes.first() == modes.last() {
            modes.pop();
        }
        tables::sequence(&modes)
    }

    /// By all multipliers but the trivial one of a system that does not depend on time.
    fn stability(&self) -> Stability {
        let trivial = usize::from(self.periods.is_none());
        Stability::of(self.orbit.multipliers.get(trivial..).unwrap_or_default())
    }

    /// Time in stick in one period.
    fn stick_time(&self) -> f64 {
        let sticks = |phase: &&Phase| phase.modes.to_vec().contains(&stickslip::Mode::Stick);
        self.recording
            .phases
            .iter()
            .filter(sticks)
            .map(Phase::duration)
            .fold(0.0, |sum, duration| sum + duration)
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
            csv_table("orbit.csv", &heading, [row])?,
            csv_table("multipliers.csv", &columns, multipliers)?,
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
                im => format!(" {} {:?} i", if im < 0.0 { "-" } else { "+" }, im.abs()),
            };
            let _ = writeln!(text, "  {title:13}{:?}{imaginary}{trivial}", multiplier.re);
        }
        let _ = writeln!(text, "  stability    {}", self.stability());
        if orbit.family > 0 {
            let _ = writeln!(text, "  family       {}", family_words(orbit.family));
        }
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
            let (low, high) = self.extremes[k];
            let _ = writeln!(
                text,
                "  {:13}from {} to {}, at first {}",
                state.name,
                readable(low),
                readable(high),
                readable(orbit.x[k])
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
            .map(|(k, state)| (state.name.clone(), json!(self.extremes[k])))
            .collect();
        json!({
            "system": tables::system_json(self.system),
            "period": orbit.period,
            "periods_of_drive": self.periods,
            "residual": orbit.residual,
            "t": orbit.t,
            "x": tables::state_json(self.system, &orbit.x),
            "multipliers": multipliers,
            "family_dimension": orbit.family,
            "stability": self.stability().to_string(),
            "phases": self.sequence(),
            "stick_time": self.stick_time(),
            "extremes": extremes,
        })
    }
}
