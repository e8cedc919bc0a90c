//! The plan of a sweep: everything that its blocks depend on, as recorded in its folder. Also its
//! shares, each of which one process or machine computes.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::block::digest;
use super::error::SweepError;

/// Name of the file that identifies the sweep in a folder.
pub(super) const MANIFEST: &str = "manifest.json";

/// Version of the file format.
const FORMAT_VERSION: u32 = 22;

/// The program and its version. Other versions may compute different bits.
const PROGRAM: &str = concat!("stickslip ", env!("CARGO_PKG_VERSION"));

/// A sweep. Two sweeps with the same plan have the same blocks, bit for bit. As JSON it is the
/// file `manifest.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    format: u32,
    program: String,
    /// Computation, such as `basin`.
    pub command: String,
    /// Every argument that a block depends on, by name.
    pub arguments: BTreeMap<String, Value>,
    /// Number of chains.
    pub chains: NonZeroUsize,
    /// Number of blocks in a chain. If blocks are independent, each is a chain of its own.
    #[serde(rename = "blocks_in_chain")]
    pub length: NonZeroUsize,
    /// The system.
    pub system: Definition,
}

/// A system, as its complete file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    name: String,
    sha256: String,
    text: String,
}

impl Definition {
    /// A system from the name and text of its file.
    pub fn new(name: String, text: String) -> Self {
        let sha256 = digest(text.as_bytes());
        Self { name, sha256, text }
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file's text.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl Plan {
    /// A plan with the given numbers of chains and of blocks in each chain.
    pub fn new(
        command: &str,
        arguments: BTreeMap<String, Value>,
        (chains, length): (NonZeroUsize, NonZeroUsize),
        system: Definition,
    ) -> Self {
        Self {
            format: FORMAT_VERSION,
            program: PROGRAM.to_owned(),
            command: command.to_owned(),
            arguments,
            chains,
            length,
            system,
        }
    }

    /// The plan of the blocks in `folder`, if there is one.
    ///
    /// # Errors
    /// [`SweepError::Read`], [`SweepError::BadManifest`].
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, SweepError> {
        let bad = |reason: String| SweepError::BadManifest {
            path: folder.join(MANIFEST),
            reason,
        };
        let Some(value) = Self::value_in(folder)? else {
            return Ok(None);
        };
        // The version is checked first: another one may have other fields.
        match value.get("format").and_then(Value::as_u64) {
            Some(format) if format == u64::from(FORMAT_VERSION) => {}
            Some(format) => {
                return Err(bad(format!(
                    "another version of the program wrote it: its format is {format}, and this \
                     one reads {FORMAT_VERSION}"
                )));
            }
            None => return Err(bad("it has no format".to_owned())),
        }
        let plan: Self = serde_json::from_value(value).map_err(|error| bad(error.to_string()))?;
        if digest(plan.system.text.as_bytes()) != plan.system.sha256 {
            return Err(bad(
                "the system's text in it is not the one that its hash is of".to_owned(),
            ));
        }
        Ok(Some(plan))
    }

    /// The command of the sweep in `folder`, of any version of the format; `None` if there is none.
    ///
    /// # Errors
    /// [`SweepError::Read`], [`SweepError::BadManifest`].
    pub(super) fn command_in(folder: &Path) -> Result<Option<String>, SweepError> {
        let value = Self::value_in(folder)?;
        Ok(value.map(|value| value["command"].as_str().unwrap_or_default().to_owned()))
    }

    /// The manifest in `folder`, if there is one.
    fn value_in(folder: &Path) -> Result<Option<Value>, SweepError> {
        let path = folder.join(MANIFEST);
        match fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map(Some).map_err(|error| {
                let reason = error.to_string();
                SweepError::BadManifest { path, reason }
            }),
            Err(error) if is_absent(&error) => Ok(None),
            Err(source) => Err(SweepError::Read { path, source }),
        }
    }

    /// The bytes on disk.
    ///
    /// # Errors
    /// [`SweepError::BadManifest`] if it cannot be written down.
    pub(super) fn bytes(&self, folder: &Path) -> Result<Vec<u8>, SweepError> {
        let mut bytes =
            serde_json::to_vec_pretty(self).map_err(|error| SweepError::BadManifest {
                path: folder.join(MANIFEST),
                reason: error.to_string(),
            })?;
        bytes.push(b'\n');
        Ok(bytes)
    }

    /// The fingerprint of the blocks. It does not include the name of the system, which is only a
    /// file name.
    ///
    /// # Errors
    /// As [`Plan::bytes`].
    pub(super) fn fingerprint(&self, folder: &Path) -> Result<String, SweepError> {
        let mut nameless = self.clone();
        nameless.system.name.clear();
        nameless.bytes(folder).map(|bytes| digest(&bytes))
    }

    /// The first difference between two sweeps: its name, its value here, and its value in the
    /// other. `None` if their blocks are the same.
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
        let arguments = arguments.flat_map(|(name, value)| leaves(name.clone(), value));
        let arguments =
            arguments.map(|(name, value)| (format!("the argument `{name}`"), value.to_string()));
        let lines = (1..).zip(self.system.text.split('\n'));
        let lines = lines.map(|(k, line)| (format!("line {k} of the system"), format!("{line:?}")));
        let counts = [
            ("the number of chains", self.chains),
            ("the number of blocks in a chain", self.length),
        ];
        let counts = counts.map(|(name, count)| (name.to_owned(), count.to_string()));
        let parts = named.into_iter().chain(arguments).chain(lines);
        parts.chain(counts).collect()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.chains.get() * self.length.get()
    }

    /// The blocks of chain `index`. Each begins where the one before ended, so one thread computes
    /// them in order.
    pub fn chain(&self, index: usize) -> Range<usize> {
        let length = self.length.get();
        index * length..(index + 1) * length
    }

    /// The block from which `block` continues.
    pub fn before(&self, block: usize) -> Option<usize> {
        (!block.is_multiple_of(self.length.get())).then(|| block - 1)
    }
}

/// Whether a file does not exist. A file in the place of a parent folder also counts; making the
/// folder reports that.
pub(super) fn is_absent(error: &io::Error) -> bool {
    use io::ErrorKind::{NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory)
}

/// Share `number` of `of`, counted from 1. It has every `of`-th chain, so that expensive and cheap
/// parts of a plane are spread over all shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: usize,
    of: usize,
}

impl Share {
    /// The whole sweep.
    pub const WHOLE: Share = Share { number: 1, of: 1 };

    /// Share `number` of `of`.
    ///
    /// # Errors
    /// [`SweepError::Share`] unless 1 ≤ `number` ≤ `of`.
    pub fn new(number: usize, of: usize) -> Result<Self, SweepError> {
        if number == 0 || number > of {
            return Err(SweepError::Share {
                text: format!("{number}/{of}"),
            });
        }
        Ok(Self { number, of })
    }

    /// Whether the share is the whole sweep.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// The chains of the share, in order. A share has no chains if there are fewer chains than
    /// `number`.
    pub fn chains(self, plan: &Plan) -> impl Iterator<Item = Range<usize>> {
        let all = self.number - 1..plan.chains.get();
        all.step_by(self.of).map(|index| plan.chain(index))
    }
}

impl FromStr for Share {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            let number = number.parse().ok()?;
            Some((number, of.parse().ok()?))
        });
        match numbers {
            Some((number, of)) => Self::new(number, of),
            None => Err(SweepError::Share { text: text.into() }),
        }
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// The values in an argument, each with the names on the way to it.
fn leaves(name: String, value: &Value) -> Vec<(String, &Value)> {
    let Value::Object(inner) = value else {
        return vec![(name, value)];
    };
    let inner = inner.iter();
    inner
        .flat_map(|(key, value)| leaves(format!("{name}.{key}"), value))
        .collect()
}
