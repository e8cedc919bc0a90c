//! `stickslip new`: an example to change.

use std::path::{Path, PathBuf};

use serde_json::json;
use stickslip_kernels::file::EXAMPLE;

use super::Failure;
use crate::output::{Artifact, OutputError, write_all};
use crate::terminal::Said;

/// Write an example of a system's file, with comments
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// File to write
    #[arg(value_name = "FILE", default_value = "system.toml")]
    file: PathBuf,

    /// Print as JSON where it was written
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Said, Failure> {
    let path = &arguments.file;
    if path.exists() {
        return Err(Failure::Usage(format!(
            "{} exists already; choose another name, or remove it first",
            path.display()
        )));
    }
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::Usage(format!(
            "{} is no name of a file; give one that ends with .toml",
            path.display()
        )));
    };
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let written = write_all(folder, &[Artifact::text(name, EXAMPLE)]);
    written.map_err(|error| match error {
        // There is no --out here.
        OutputError::CreateDir { path, source } | OutputError::Write { path, source } => {
            Failure::Usage(format!(
                "cannot write {}: {source}; choose another place",
                path.display()
            ))
        }
        other => other.into(),
    })?;
    let shown = path.display().to_string();
    let text = if arguments.json {
        format!("{:#}\n", json!({ "files": [shown] }))
    } else {
        format!("wrote {shown}\nnext: stickslip check {shown}\n")
    };
    Ok(Said {
        text,
        failure: None,
    })
}
