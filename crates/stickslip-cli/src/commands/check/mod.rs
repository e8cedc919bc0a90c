//! `stickslip check`: what was understood of a file.

mod doubts;
mod json;
mod words;

use super::Failure;
use super::arguments::SystemArguments;
use crate::tangents::{Line, OnLine};
use crate::terminal::Said;
use stickslip_kernels::file::System;

/// Say what was understood of a file
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    system: SystemArguments,

    /// Print it as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    let system = arguments.system.system()?;
    let on_boundary = on_boundary(&system);
    let doubts = doubts::doubts(&system);
    let text = if arguments.json {
        let understood = json::understood(&system, on_boundary.as_ref(), &doubts);
        format!("{understood:#}\n")
    } else {
        words::understood(&system, on_boundary.as_ref(), &doubts)
    };
    Ok(Said {
        text,
        failure: None,
    })
}

/// On which side of a boundary a height over it is.
fn whereabouts(height: f64) -> &'static str {
    if height < 0.0 {
        "below"
    } else if height > 0.0 {
        "above"
    } else {
        "on"
    }
}

/// Tangent points and stick zones, where one contact and two states leave nothing to choose but the range, and the file has that.
fn on_boundary(system: &System) -> Option<(Line, Vec<(Line, OnLine)>)> {
    if system.contacts() != 1 || system.states() != 2 {
        return None;
    }
    let (t, start) = (system.built.t_start, system.built.start.as_deref()?);
    let whole = (f64::NEG_INFINITY, f64::INFINITY);
    let line = Line::through(system, 0, None, whole, (t, start))?;
    let range = system.file.states[line.along].range?;
    let line = Line { range, ..line };
    let found = line.scan(system);
    Some((line, found))
}
