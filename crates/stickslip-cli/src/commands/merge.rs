//! `stickslip merge`: shares of a sweep, joined.

use super::basin::Basin;
use super::bifurcation::Bifurcation;
use super::map::Map;
use super::sweeping::{Sweep, finish, merged};
use crate::failure::Failure;
use crate::render::{CommandOutput, OutputArguments};

/// Join the shares of a sweep that were computed with --shard, and write its tables and figures
///
/// Missing blocks, blocks that differ between two shares, and shares or blocks of another sweep are
/// errors, which name them.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Output folders of the shares
    #[arg(required = true, value_name = "FOLDER")]
    shares: Vec<String>,

    #[command(flatten)]
    output: OutputArguments,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    arguments.output.check()?;
    let merged = merged(&arguments.output.out, &arguments.shares)?;
    match merged.store.plan().command.as_str() {
        Basin::COMMAND => finish::<Basin>(&merged.store, &arguments.output),
        Bifurcation::COMMAND => finish::<Bifurcation>(&merged.store, &arguments.output),
        Map::COMMAND => finish::<Map>(&merged.store, &arguments.output),
        other => Err(Failure::Usage(format!(
            "the shares are of `{other}`, which this program does not know; use the one that \
                computed them"
        ))),
    }
}
