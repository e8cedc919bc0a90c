//! Results as text, CSV, JSON and files. A command describes what it has found once; each form is
//! written here and nowhere else.

mod table;
mod words;

use std::fmt::{Display, Write};
use std::path::{Path, PathBuf};

use output::{Artifact, PngError, WriteError};
use serde::Serialize;
use serde_json::{Map, Value as Json, json};
use stickslip_kernels::file::System;

pub(crate) use table::Table;
pub(crate) use words::{
    by_state, explained, input_name, known, place, rounded, state_words, within,
};

/// What a command prints at its end.
pub(crate) struct Answer {
    /// For standard output.
    pub(crate) text: String,
    /// What went wrong behind what was found all the same.
    pub(crate) failure: Option<String>,
}

/// What to write, and where.
#[derive(Debug, clap::Args)]
pub(crate) struct OutputArguments {
    /// Folder for the files; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "stickslip-output")]
    pub(crate) out: String,

    /// Print the result as JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Also write the figures as PNG, at twice the nominal size; in a build with --features png
    #[arg(long)]
    pub(crate) png: bool,
}

impl OutputArguments {
    /// Refuses what cannot be written before anything is computed for it.
    ///
    /// # Errors
    /// [`OutputError::Png`].
    pub(crate) fn check(&self) -> Result<(), OutputError> {
        if self.png && !cfg!(feature = "png") {
            return Err(PngError::NotBuilt.into());
        }
        Ok(())
    }
}

/// Failure of making or writing files.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file or its folder cannot be made.
    #[error("{0}; {hint}choose another with --out", hint = if_file(.0))]
    Write(#[from] WriteError),
    /// The rows do not fit into a CSV file.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
    /// The drawing failed.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// A figure cannot be made a PNG.
    #[error("{0}{hint}", hint = if_not_built(.0))]
    Png(#[from] PngError),
}

fn if_file(error: &WriteError) -> &'static str {
    match error {
        WriteError::Folder { .. } => "",
        WriteError::File { .. } => "check that the folder is writable and the disk not full, or ",
    }
}

fn if_not_built(error: &PngError) -> &'static str {
    match error {
        PngError::NotBuilt => {
            " (feature png); build it with `cargo install --path crates/stickslip-cli --features \
                png`"
        }
        PngError::Rendering(_) => "",
    }
}

/// What a command has found, for people and for programs, with its tables and figures.
#[derive(Default)]
pub(crate) struct Report {
    text: String,
    /// Columns before the title of a line, and those that the title takes.
    margin: (usize, usize),
    json: Map<String, Json>,
    tables: Vec<Artifact>,
    figures: Vec<(String, String)>,
    /// Files that are on disk already.
    there: Vec<PathBuf>,
    failure: Option<String>,
}

impl Report {
    /// About a system: its name and what was done with it.
    pub(crate) fn of(system: &System, what: impl Display) -> Self {
        let mut report = Self::plain(format!("{}: {what}\n", system.file.name), (2, 13));
        report.system(system);
        report
    }

    /// The system's name and values, for programs.
    pub(crate) fn system(&mut self, system: &System) -> &mut Self {
        let parameters = system.file.parameters.iter().zip(&system.values);
        let parameters: Map<String, Json> = parameters
            .map(|(parameter, &value)| (parameter.name.clone(), json!(value)))
            .collect();
        let system = json!({ "name": system.file.name, "parameters": parameters });
        self.field("system", system)
    }

    /// With a beginning and margins of its own.
    pub(crate) fn plain(text: String, margin: (usize, usize)) -> Self {
        Self {
            text,
            margin,
            ..Self::default()
        }
    }

    /// A line for people, under a title, which may be empty.
    pub(crate) fn line(&mut self, title: &str, text: impl Display) -> &mut Self {
        let (indent, width) = self.margin;
        // Writing into a text cannot fail.
        let _ = writeln!(self.text, "{:indent$}{title:width$}{text}", "");
        self
    }

    /// Lines under one title.
    pub(crate) fn lines(
        &mut self,
        title: &str,
        texts: impl IntoIterator<Item = String>,
    ) -> &mut Self {
        for (k, text) in texts.into_iter().enumerate() {
            self.line(if k == 0 { title } else { "" }, text);
        }
        self
    }

    /// Things of one kind, each with a line for people and a value for programs.
    pub(crate) fn list(
        &mut self,
        title: &str,
        things: impl IntoIterator<Item = (String, Json)>,
    ) -> &mut Self {
        let (lines, values): (Vec<String>, Vec<Json>) = things.into_iter().unzip();
        self.lines(title, lines).field(title, values)
    }

    /// A line for people that has no title.
    pub(crate) fn note(&mut self, text: impl Display) -> &mut Self {
        let _ = writeln!(self.text, "  {text}");
        self
    }

    /// A value for programs.
    pub(crate) fn field(&mut self, key: &str, value: impl Serialize) -> &mut Self {
        self.json.insert(key.to_owned(), json!(value));
        self
    }

    /// The members of an object, for programs.
    pub(crate) fn fields(&mut self, object: Json) -> &mut Self {
        if let Json::Object(members) = object {
            self.json.extend(members);
        }
        self
    }

    /// A table to write.
    pub(crate) fn table(&mut self, table: Artifact) -> &mut Self {
        self.tables.push(table);
        self
    }

    /// A file that is on disk already.
    pub(crate) fn file(&mut self, path: PathBuf) -> &mut Self {
        self.there.push(path);
        self
    }

    /// A figure to write.
    pub(crate) fn figure(
        &mut self,
        name: &str,
        figure: &plot::Figure,
    ) -> Result<&mut Self, OutputError> {
        self.figures.push((name.to_owned(), figure.render()?));
        Ok(self)
    }

    /// What went wrong behind what was found all the same.
    pub(crate) fn failure(&mut self, failure: Option<String>) -> &mut Self {
        self.failure = failure;
        self
    }

    /// What was found, of a command that writes no files.
    pub(crate) fn answer(self, as_json: bool) -> Answer {
        let text = if as_json {
            format!("{:#}\n", Json::Object(self.json))
        } else {
            self.text
        };
        Answer {
            text,
            failure: self.failure,
        }
    }

    /// Writes the files, by way of a folder for what is unfinished, and says what was found.
    pub(crate) fn written(
        mut self,
        staging: &Path,
        output: &OutputArguments,
    ) -> Result<Answer, OutputError> {
        let mut artifacts = std::mem::take(&mut self.tables);
        for (name, svg) in std::mem::take(&mut self.figures) {
            if output.png {
                artifacts.push(Artifact {
                    name: format!("{name}.png"),
                    bytes: output::png(&svg)?,
                });
            }
            artifacts.push(Artifact::text(format!("{name}.svg"), svg));
        }
        let written = output::write_all_by(staging, Path::new(&output.out), &artifacts)?;
        let paths = [std::mem::take(&mut self.there), written].concat();
        self.text.push('\n');
        self.text.push_str(&output::listing(&paths));
        let paths = paths.iter().map(|path| path.display().to_string());
        self.field("files", paths.collect::<Json>());
        Ok(self.answer(output.json))
    }
}
