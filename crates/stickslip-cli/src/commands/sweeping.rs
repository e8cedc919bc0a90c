//! Shared parts of the commands that compute sweeps.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;

use super::arguments::{RunArguments, count, time_or};
use crate::failure::Failure;
use crate::render::{CommandOutput, OutputArguments, OutputError, Report, Table};
use crate::sweep::{
    BlockError, Computed, Definition, Plan, Share, Store, SweepError, Task, Writer, run,
    write_whole,
};
use output::terminal::DelayedProgressBar;
use stickslip_model::file::{Source, System, SystemFile};
use stickslip_model::study::MOTION_SEARCH_TIME;

/// The part of a sweep to compute, and the number of threads.
#[derive(Debug, clap::Args)]
pub(super) struct SweepArguments {
    /// Compute only share I of N; other jobs or machines compute the rest, and `stickslip merge`
    /// joins them
    #[arg(long, value_name = "I/N", default_value_t = Share::WHOLE, hide_default_value = true)]
    shard: Share,

    /// Number of threads; default one per core. The result does not depend on it
    #[arg(long, value_name = "NUMBER", value_parser = count)]
    threads: Option<NonZeroUsize>,

    #[command(flatten)]
    resume: ResumeArguments,
}

/// Whether to resume from the blocks on disk.
#[derive(Debug, clap::Args)]
pub(super) struct ResumeArguments {
    /// Begin anew: remove what an earlier run of this command has saved in sweep/, also with other
    /// options; with --shard only this share of the same sweep
    #[arg(long)]
    pub(super) fresh: bool,
}

impl ResumeArguments {
    /// Removes the saved sweep, or the blocks of a share, if the command is to begin anew.
    pub(super) fn prepare(
        &self,
        folder: &Path,
        plan: &Plan,
        share: Share,
    ) -> Result<(), SweepError> {
        match (self.fresh, share.is_whole()) {
            (true, true) => Writer::remove_sweep(folder, &plan.command),
            (true, false) => Writer::open(folder, plan, share)?.remove_blocks(share),
            (false, _) => Ok(()),
        }
    }
}

/// The longest time in which an orbit must reach an attractor.
#[derive(Debug, clap::Args)]
pub(super) struct UntilArguments {
    /// Time after which an orbit that has reached no attractor counts as undecided; default 2000,
    /// or 10000 periods of a drive with a period below 0.2
    #[arg(long, value_name = "TIME")]
    until: Option<f64>,
}

impl UntilArguments {
    pub(super) fn of(&self, system: &System) -> f64 {
        time_or(self.until, MOTION_SEARCH_TIME, system)
    }
}

/// The duration of the measurement of the largest exponent.
#[derive(Debug, clap::Args)]
pub(super) struct ExponentArguments {
    /// Time over which the Lyapunov exponent is measured, on the attractor; default 500, or 2500
    /// periods of a drive with a period below 0.2
    #[arg(long, value_name = "TIME")]
    duration: Option<f64>,
}

impl ExponentArguments {
    /// The time, if exponents can be measured over it.
    pub(super) fn of(&self, system: &System) -> Result<f64, Failure> {
        let duration = time_or(self.duration, 500.0, system);
        if duration > 0.0 && duration.is_finite() {
            return Ok(duration);
        }
        Err(Failure::Usage(format!(
            "--duration {duration}: it must be positive and finite"
        )))
    }
}

/// Number of blocks for `of` items, with `in_block` items in each.
pub(super) fn blocks(of: NonZeroUsize, in_block: usize) -> NonZeroUsize {
    NonZeroUsize::new(of.get().div_ceil(in_block)).unwrap_or(NonZeroUsize::MIN)
}

/// A command that computes block by block. Its fields are everything that the blocks depend on,
/// except the system, and are written to the manifest.
pub(super) trait Sweep: Serialize + DeserializeOwned + Sync {
    /// Name of the command.
    const COMMAND: &'static str;

    /// Content of a block.
    type Block: Serialize + DeserializeOwned;

    /// Number of chains of blocks, and of blocks in each.
    fn size(&self) -> (NonZeroUsize, NonZeroUsize);

    /// Computes the content of a block; `before` is the previous block of its chain.
    fn block(
        &self,
        system: &System,
        index: usize,
        before: Option<Self::Block>,
    ) -> Result<Self::Block, Failure>;

    /// Reports the results of all blocks. Tables that may not fit into memory are written to the
    /// folder `out`.
    fn report(&self, system: &System, store: &Store, out: &Path) -> Result<Report, Failure>;
}

/// Encodes the content of a block as CBOR. JSON cannot be used: it writes `null` for numbers that
/// are infinite or undefined, and does not read that as a number.
pub(super) fn to_content(value: &impl Serialize) -> Result<Vec<u8>, BlockError> {
    let mut content = Vec::new();
    ciborium::into_writer(value, &mut content)?;
    Ok(content)
}

/// Decodes what [`to_content`] has written.
pub(super) fn from_content<T: DeserializeOwned>(content: &[u8]) -> Result<T, BlockError> {
    Ok(ciborium::from_reader(content)?)
}

/// Writes a table that may not fit into memory. Its rows are made from one block at a time.
pub(super) fn table<T: DeserializeOwned, R>(
    store: &Store,
    path: &Path,
    table: &Table<'_, R>,
    mut rows: impl FnMut(usize, T) -> Result<Vec<R>, Failure>,
) -> Result<(), Failure> {
    write_whole(path, &store.staging()?, |file| {
        let mut writer = csv::Writer::from_writer(file);
        table.write_heading(&mut writer)?;
        store.for_each(|block, content| {
            let holds = from_content(content);
            let holds = holds.map_err(|source| SweepError::Block { block, source })?;
            Ok::<_, Failure>(table.write_rows(&mut writer, rows(block, holds)?)?)
        })?;
        let flushed = writer.flush().map_err(csv::Error::from);
        Ok(flushed.map_err(OutputError::from)?)
    })
}

/// Name of the values of the parameters in the manifest.
const PARAMETERS: &str = "parameters";

/// The folder of a sweep within the output folder.
pub(super) fn folder(out: &str) -> PathBuf {
    Path::new(out).join("sweep")
}

/// Computes the missing blocks of a sweep. If all are then present, writes its results.
pub(super) fn sweep<S: Sweep>(
    arguments: &SweepArguments,
    of: &RunArguments,
    wanted: impl FnOnce(&System) -> Result<S, Failure>,
) -> Result<CommandOutput, Failure> {
    let (system, output) = (of.system()?, &of.output);
    check_period(&system)?;
    let wanted = wanted(&system)?;
    let plan = plan(S::COMMAND, &wanted, wanted.size(), &system)?;
    let (folder, share) = (folder(&output.out), arguments.shard);
    arguments.resume.prepare(&folder, &plan, share)?;
    let task = Task {
        plan: &plan,
        folder: &folder,
        share,
        threads: arguments.threads,
    };
    let progress =
        DelayedProgressBar::new("{bar:40} {pos}/{len} blocks, {elapsed} gone, {eta} to go");
    let computed = run(
        &task,
        &|done, all| progress.done(done as u64, all as u64),
        |index, before| {
            let before = before.map(from_content).transpose()?;
            to_content(&wanted.block(&system, index, before)?)
        },
    );
    progress.clear();
    let computed = computed?;
    if share.is_whole() {
        finished(&wanted, &system, &computed.store, output)
    } else {
        Ok(share_done(share, &computed).output(output.json))
    }
}

/// Writes tables and figures of a sweep whose blocks are complete.
pub(super) fn finish<S: Sweep>(
    store: &Store,
    output: &OutputArguments,
) -> Result<CommandOutput, Failure> {
    let (wanted, system) = of_plan::<S>(store.plan())?;
    finished(&wanted, &system, store, output)
}

fn finished<S: Sweep>(
    wanted: &S,
    system: &System,
    store: &Store,
    output: &OutputArguments,
) -> Result<CommandOutput, Failure> {
    let mut report = wanted.report(system, store, output.out.as_ref())?;
    report.field("arguments", wanted);
    Ok(report.written(&store.staging()?, output)?)
}

/// Joins shares in the output folder.
pub(super) fn merged(
    out: &str,
    shares: &[String],
) -> Result<crate::sweep::Merged, crate::sweep::SweepError> {
    let shares: Vec<PathBuf> = shares.iter().map(|share| folder(share)).collect();
    crate::sweep::merge(&folder(out), &shares)
}

/// Checks whether attractors can be searched. A driven system is sampled once a period, so its
/// period must be known and valid.
pub(super) fn check_period(system: &System) -> Result<(), Failure> {
    let checked = system.checked_period().map(|_| ());
    checked.map_err(|error| Failure::Usage(error.to_string()))
}

/// The plan of a sweep: its command, everything that it depends on besides the system, and the
/// numbers of chains and blocks.
pub(super) fn plan(
    command: &str,
    wanted: &impl Serialize,
    size: (NonZeroUsize, NonZeroUsize),
    system: &System,
) -> Result<Plan, Failure> {
    let internal = |error: serde_json::Error| Failure::Usage(error.to_string());
    let value = serde_json::to_value(wanted).map_err(internal)?;
    let mut arguments: BTreeMap<String, serde_json::Value> =
        serde_json::from_value(value).map_err(internal)?;
    let names = system.file.parameters.iter();
    let values: BTreeMap<&str, f64> = names
        .map(|parameter| parameter.name.as_str())
        .zip(system.values.iter().copied())
        .collect();
    arguments.insert(PARAMETERS.to_owned(), json!(values));
    let Source { name, text } = system.file.source.clone();
    let definition = Definition::new(name, text);
    Ok(Plan::new(command, arguments, size, definition))
}

fn of_plan<S: Sweep>(plan: &Plan) -> Result<(S, System), Failure> {
    let wrong = |error: serde_json::Error| {
        Failure::Usage(format!(
            "the manifest's arguments are not those of {}: {error}",
            S::COMMAND
        ))
    };
    let mut arguments = plan.arguments.clone();
    let parameters = arguments.remove(PARAMETERS).unwrap_or_default();
    let parameters: BTreeMap<String, f64> = serde_json::from_value(parameters).map_err(wrong)?;
    let wanted = serde_json::from_value(json!(arguments)).map_err(wrong)?;
    let file = SystemFile::parse(Source {
        name: plan.system.name().to_owned(),
        text: plan.system.text().to_owned(),
    })?;
    let parameters: Vec<(String, f64)> = parameters.into_iter().collect();
    Ok((wanted, file.with(&parameters)?))
}

fn share_done(share: Share, computed: &Computed) -> Report {
    let (new, old, repaired) = (computed.new, computed.old, computed.repaired.len());
    let folder = computed.store.folder().display().to_string();
    let text = format!(
        "share {share}: {} blocks, {old} of them from earlier runs, {repaired} damaged and \
         recomputed\n\
         wrote {folder}\n\
         join all shares with `stickslip merge --out DIR FOLDER...`\n",
        new + old
    );
    let mut report = Report::plain(text, (0, 0));
    report
        .field("share", share.to_string())
        .field("computed", new)
        .field("there_before", old)
        .field("repaired", repaired)
        .field("folder", folder);
    report
}
