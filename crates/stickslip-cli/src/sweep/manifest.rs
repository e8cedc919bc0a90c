//! What says of which sweep the blocks in a folder are.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::block::digest;
use super::error::SweepError;
use super::plan::Plan;

/// Name of the file.
pub(super) const NAME: &str = "manifest.json";

/// Version of the files' form.
const FORMAT: u32 = 6;

/// The program and its version: another one may have other bits.
const PROGRAM: &str = concat!("stickslip ", env!("CARGO_PKG_VERSION"));

/// The file `manifest.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    format: u32,
    program: String,
    command: String,
    arguments: BTreeMap<String, Value>,
    chains: NonZeroUsize,
    blocks_in_chain: NonZeroUsize,
    system: System,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct System {
    name: String,
    sha256: String,
    text: String,
}

impl Manifest {
    pub(super) fn of(plan: &Plan) -> Self {
        Self {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            command: plan.command.clone(),
            arguments: plan.arguments.clone(),
            chains: plan.chains,
            blocks_in_chain: plan.length,
            system: System {
                name: plan.system.clone(),
                sha256: digest(plan.system_text.as_bytes()),
                text: plan.system_text.clone(),
            },
        }
    }

    pub(super) fn into_plan(self) -> Plan {
        Plan {
            command: self.command,
            arguments: self.arguments,
            system: self.system.name,
            system_text: self.system.text,
            chains: self.chains,
            length: self.blocks_in_chain,
        }
    }

    /// The manifest in `folder`, if there is one.
    ///
    /// # Errors
    /// [`SweepError::Read`], [`SweepError::BadManifest`].
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, SweepError> {
        let path = folder.join(NAME);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if is_absent(&error) => return Ok(None),
            Err(source) => return Err(SweepError::Read { path, source }),
        };
        let bad = |reason: String| SweepError::BadManifest {
            path: path.clone(),
            reason,
        };
        // The version is asked first: another one may have other fields.
        let value: Value =
            serde_json::from_slice(&bytes).map_err(|error| bad(error.to_string()))?;
        match value.get("format").and_then(Value::as_u64) {
            Some(format) if format == u64::from(FORMAT) => {}
            Some(format) => {
                return Err(bad(format!(
                    "its format is {format}, and this program reads {FORMAT}"
                )));
            }
            None => return Err(bad("it has no format".to_owned())),
        }
        let manifest: Self =
            serde_json::from_value(value).map_err(|error| bad(error.to_string()))?;
        if digest(manifest.system.text.as_bytes()) != manifest.system.sha256 {
            return Err(bad(
                "the system's text in it is not the one that its hash is of".to_owned(),
            ));
        }
        Ok(Some(manifest))
    }

    /// The bytes on disk.
    ///
    /// # Errors
    /// [`SweepError::BadManifest`] if it cannot be written down.
    pub(super) fn bytes(&self, folder: &Path) -> Result<Vec<u8>, SweepError> {
        let mut bytes =
            serde_json::to_vec_pretty(self).map_err(|error| SweepError::BadManifest {
                path: folder.join(NAME),
                reason: error.to_string(),
            })?;
        bytes.push(b'\n');
        Ok(bytes)
    }

    /// What its blocks are marked with. The system's name is that of a file, and says nothing of what is in it.
    ///
    /// # Errors
    /// As [`Manifest::bytes`].
    pub(super) fn fingerprint(&self, folder: &Path) -> Result<String, SweepError> {
        let mut nameless = self.clone();
        nameless.system.name.clear();
        nameless.bytes(folder).map(|bytes| digest(&bytes))
    }

    /// What differs first between two sweeps: what it is, its value here and its value in the other; nothing if their blocks are the same.
    pub(super) fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let (old, new) = (self.parts(), other.parts());
        let value = |parts: &[(String, String)], name: &String| {
            let part = parts.iter().find(|part| part.0 == *name);
            part.map_or("absent".to_owned(), |part| part.1.clone())
        };
        let names = old.iter().chain(&new).map(|part| &part.0);
        let mut both = names.map(|name| (name.clone(), value(&old, name), value(&new, name)));
        both.find(|(_, old, new)| old != new)
    }

    /// Everything that blocks depend on, as names and values.
    fn parts(&self) -> Vec<(String, String)> {
        let named = [
            ("the program", &self.program),
            ("the command", &self.command),
        ];
        let named = named.map(|(name, text)| (name.to_owned(), format!("`{text}`")));
        let arguments = self.arguments.iter();
        let arguments =
            arguments.map(|(name, value)| (format!("the argument `{name}`"), value.to_string()));
        let lines = (1..).zip(self.system.text.split('\n'));
        let lines = lines.map(|(k, line)| (format!("line {k} of the system"), format!("{line:?}")));
        let counts = [
            ("the number of chains", self.chains),
            ("the number of blocks in a chain", self.blocks_in_chain),
        ];
        let counts = counts.map(|(name, count)| (name.to_owned(), count.to_string()));
        let parts = named.into_iter().chain(arguments).chain(lines);
        parts.chain(counts).collect()
    }
}

/// Whether a file could not be read because there is none; a file in the place of a folder above it
/// is told when the folder is made.
pub(super) fn is_absent(error: &io::Error) -> bool {
    use io::ErrorKind::{NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory)
}
