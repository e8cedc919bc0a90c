//! `stickslip new`: an example to change.

use std::path::{Path, PathBuf};

use output::{Artifact, WriteError, write_all};
use stickslip_model::file::EXAMPLE;

use crate::failure::Failure;
use crate::render::{CommandOutput, Report};

/// Write an example of a system file, with comments
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// File to write
    #[arg(value_name = "FILE", default_value = "system.toml")]
    file: PathBuf,

    /// Print the path of the file as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandOutput, Failure> {
    let path = &arguments.file;
    let shown = path.display().to_string();
    if path.exists() {
        return Err(Failure::Usage(format!(
            "{shown} exists already; choose another name, or remove it first"
        )));
    }
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::Usage(format!(
            "{shown} is no name of a file; give one that ends with .toml"
        )));
    };
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    write_all(folder, &[Artifact::text(name, EXAMPLE)]).map_err(|error| {
        // This command has no --out, so the error must not suggest it.
        let (WriteError::Folder { path, source } | WriteError::File { path, source }) = error;
        let path = path.display();
        Failure::Usage(format!(
            "cannot write {path}: {source}; choose another place"
        ))
    })?;
    let text = format!("wrote {shown}\nnext: stickslip check {shown}\n");
    let mut report = Report::plain(text, (0, 0));
    report.field("files", [shown]);
    Ok(report.output(arguments.json))
}
