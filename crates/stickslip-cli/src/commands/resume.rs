//! `end.json`: the end of a run, from which another run goes on.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use output::Artifact;
use serde::{Deserialize, Serialize};
use stickslip::Options;
use stickslip::dynamics::{Moment, RunMemory, Vector};
use stickslip::error::readable;

use crate::failure::Failure;
use crate::sweep::digest;
use stickslip_model::file::System;

/// Name of the file.
const END: &str = "end.json";

/// Version of its format.
const FORMAT: u32 = 3;

/// The end of a run.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct End {
    format: u32,
    /// Name of the system, for readers.
    system: String,
    t: f64,
    /// The state, by name.
    state: BTreeMap<String, f64>,
    /// Dependencies of the run besides its start, by name: the hash of the system's text, its
    /// parameters, the options of the solver.
    depends_on: BTreeMap<String, String>,
    /// Words for how it ended. An earlier format without them is refused by its number.
    #[serde(default)]
    ending: String,
    /// Hash of the memory: a changed one would go on from nowhere.
    sha256: String,
    /// The run that goes on; none where nothing does.
    memory: Option<RunMemory>,
}

fn hash(memory: &Option<RunMemory>) -> String {
    // A memory that cannot be written has no hash, and none is written.
    let text = serde_json::to_string(memory).unwrap_or_default();
    digest(text.as_bytes())
}

/// Dependencies of a run of a system besides its start.
fn depends_on(system: &System, options: &Options) -> BTreeMap<String, String> {
    let mut parts = BTreeMap::from([
        ("program".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        (
            "the text of the system, with its tables".to_owned(),
            digest(format!("{}{:?}", system.file.source.text, system.file.inputs).as_bytes()),
        ),
        ("--method".to_owned(), format!("{:?}", options.method)),
        ("--rtol".to_owned(), format!("{:?}", options.rtol)),
        ("--atol".to_owned(), format!("{:?}", options.atol)),
        (
            "--longest-step".to_owned(),
            format!("{:?}", options.longest_step),
        ),
        (
            "--at-repelling".to_owned(),
            format!("{:?}", options.at_repelling),
        ),
        (
            "--at-pile-up".to_owned(),
            format!("{:?}", options.at_pile_up),
        ),
    ]);
    let parameters = system.file.parameters.iter().zip(&system.values);
    parts.extend(parameters.map(|(parameter, value)| {
        (
            format!("parameter `{}`", parameter.name),
            format!("{value:?}"),
        )
    }));
    parts
}

impl End {
    /// The end of a run. Where nothing goes on, the file replaces that of an earlier run in the
    /// folder: going on from there would be wrong without a word.
    pub(super) fn of(
        system: &System,
        options: &Options,
        (end, ending): (&Moment, String),
        memory: Option<RunMemory>,
    ) -> Self {
        let names = system.file.states.iter().map(|state| state.name.clone());
        End {
            format: FORMAT,
            system: system.file.name.clone(),
            t: end.t,
            state: names.zip(end.x.iter().copied()).collect(),
            depends_on: depends_on(system, options),
            ending,
            sha256: hash(&memory),
            memory,
        }
    }

    /// The end of many orbits, of which none goes on alone.
    pub(super) fn of_many(system: &System, options: &Options, t: f64, count: usize) -> Self {
        let x = Vector::zeros(0);
        End::of(
            system,
            options,
            (&Moment { t, x }, format!("{count} orbits of --starts")),
            None,
        )
    }

    /// The file to write.
    pub(super) fn artifact(&self) -> Result<Artifact, Failure> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| Failure::Usage(format!("{END} cannot be written: {error}")))?;
        Ok(Artifact::text(END.to_owned(), text + "\n"))
    }

    /// Reads the end of a run of the same system with the same options, from the file or the folder
    /// that holds it.
    ///
    /// # Errors
    /// [`Failure::Usage`] with what differs.
    pub(super) fn read(
        path: &Path,
        system: &System,
        options: &Options,
    ) -> Result<RunMemory, Failure> {
        let path: PathBuf = match path.is_dir() {
            true => path.join(END),
            false => path.to_owned(),
        };
        let at = path.display();
        let usage = |message: String| Failure::Usage(message);
        let bytes = std::fs::read(&path).map_err(|error| {
            usage(format!(
                "--resume: {at} cannot be read: {error}; `simulate` writes it into the folder of \
                 --out"
            ))
        })?;
        let end: End = serde_json::from_slice(&bytes)
            .map_err(|error| usage(format!("--resume: {at} is no end of a run: {error}")))?;
        if end.format != FORMAT {
            return Err(usage(format!(
                "--resume: {at} has format {}, and this program reads {FORMAT}; make the run again",
                end.format
            )));
        }
        if hash(&end.memory) != end.sha256 {
            return Err(usage(format!(
                "--resume: {at} was changed after it was written; make the run again"
            )));
        }
        let here = depends_on(system, options);
        let names = end.depends_on.keys().chain(here.keys());
        let of = |parts: &BTreeMap<String, String>, name: &String| {
            parts.get(name).map_or("absent", String::as_str).to_owned()
        };
        let mut both = names.map(|name| (name, of(&end.depends_on, name), of(&here, name)));
        match both.find(|(_, there, here)| there != here) {
            None => end.memory.ok_or_else(|| {
                usage(format!(
                    "--resume: {at} is of a run that ended at t = {} ({}), from where none goes \
                     on; begin with --start",
                    readable(end.t),
                    end.ending
                ))
            }),
            Some((name, there, here)) => Err(usage(format!(
                "--resume: {at} is the end of another run: {name} is {there} there and \
                 {here} here; \
                 go on with the same, or begin anew with --start"
            ))),
        }
    }
}
