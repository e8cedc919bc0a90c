//! Results as text, CSV, JSON and files. A command describes its results once; only this module
//! formats them.

mod table;
mod words;

use std::fmt::{Display, Write};
use std::path::{Path, PathBuf};

use output::{Artifact, PngError, WriteError};
use serde::Serialize;
use serde_json::{Map, Value as Json, json};
use stickslip_model::file::System;

pub(crate) use table::Table;
use words::shortened;
pub(crate) use words::{
    by_state, complex_within, explained, input_name, place, significant_digits, state_words, within,
};

/// Final output of a command.
pub(crate) struct CommandOutput {
    /// Text for standard output.
    pub(crate) text: String,
    /// An error that occurred after the results were computed.
    pub(crate) failure: Option<String>,
}

/// Folder and formats of the output.
#[derive(Debug, clap::Args)]
pub(crate) struct OutputArguments {
    /// Folder for the files; created if it does not exist
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
    /// Rejects output that cannot be written, before anything is computed.
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
    /// The rows cannot be written as CSV.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
    /// A figure cannot be converted to PNG.
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

/// Results of a command, as text and as JSON, with tables and figures.
#[derive(Default)]
pub(crate) struct Report {
    text: String,
    /// Indentation of a line, and width of its title, in characters.
    margin: (usize, usize),
    json: Map<String, Json>,
    tables: Vec<Artifact>,
    figures: Vec<(String, String)>,
    /// Files that have been written already.
    written: Vec<PathBuf>,
    failure: Option<String>,
}

impl Report {
    /// Begins a report with the name of a system and what was computed.
    pub(crate) fn of(system: &System, what: impl Display) -> Self {
        let mut report = Self::plain(format!("{}: {what}\n", system.file.name), (2, 13));
        report.system(system);
        report
    }

    /// Adds the name and values of the system, for programs.
    pub(crate) fn system(&mut self, system: &System) -> &mut Self {
        let parameters = system.file.parameters.iter().zip(&system.values);
        let parameters: Map<String, Json> = parameters
            .map(|(parameter, &value)| (parameter.name.clone(), json!(value)))
            .collect();
        let system = json!({ "name": system.file.name, "parameters": parameters });
        self.field("system", system)
    }

    /// Begins a report with a given text and margins.
    pub(crate) fn plain(text: String, margin: (usize, usize)) -> Self {
        Self {
            text,
            margin,
            ..Self::default()
        }
    }

    /// Adds a line of text with a title, which may be empty. A text of very many characters, such
    /// as a formula that another program wrote, is cut in the middle.
    pub(crate) fn line(&mut self, title: &str, text: impl Display) -> &mut Self {
        let (indent, width) = self.margin;
        let text = shortened(text.to_string());
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{:indent$}{title:width$}{text}", "");
        self
    }

    /// Adds lines with one title.
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

    /// Adds items of one kind, each with a line of text and a value for programs.
    pub(crate) fn list(
        &mut self,
        title: &str,
        things: impl IntoIterator<Item = (String, Json)>,
    ) -> &mut Self {
        let (lines, values): (Vec<String>, Vec<Json>) = things.into_iter().unzip();
        self.lines(title, lines).field(title, values)
    }

    /// Adds a line of text without a title.
    pub(crate) fn note(&mut self, text: impl Display) -> &mut Self {
        let _ = writeln!(self.text, "  {text}");
        self
    }

    /// Adds a value for programs.
    pub(crate) fn field(&mut self, key: &str, value: impl Serialize) -> &mut Self {
        self.json.insert(key.to_owned(), json!(value));
        self
    }

    /// Adds the members of an object, for programs.
    pub(crate) fn fields(&mut self, object: Json) -> &mut Self {
        if let Json::Object(members) = object {
            self.json.extend(members);
        }
        self
    }

    /// Adds a table to write.
    pub(crate) fn table(&mut self, table: Artifact) -> &mut Self {
        self.tables.push(table);
        self
    }

    /// Adds a file that has been written already.
    pub(crate) fn file(&mut self, path: PathBuf) -> &mut Self {
        self.written.push(path);
        self
    }

    /// Adds a figure to write. One that cannot be drawn is left out, and the command fails after
    /// everything else is written.
    pub(crate) fn figure(&mut self, name: &str, figure: &plot::Figure) -> &mut Self {
        match figure.render() {
            Ok(svg) => self.figures.push((name.to_owned(), svg)),
            Err(error) => self.left_out(name, &error),
        }
        self
    }

    fn left_out(&mut self, figure: &str, error: &dyn Display) {
        self.failure(Some(format!("the figure {figure} is left out: {error}")));
    }

    /// Adds an error that occurred after the results were computed.
    pub(crate) fn failure(&mut self, failure: Option<String>) -> &mut Self {
        self.failure = match (self.failure.take(), failure) {
            (Some(one), Some(other)) => Some(format!("{one}; {other}")),
            (one, other) => one.or(other),
        };
        self
    }

    /// The output of a command that writes no files.
    pub(crate) fn output(self, as_json: bool) -> CommandOutput {
        let text = if as_json {
            format!("{:#}\n", Json::Object(self.json))
        } else {
            self.text
        };
        CommandOutput {
            text,
            failure: self.failure,
        }
    }

    /// Writes the files, staged in a folder for incomplete files, and returns the output.
    pub(crate) fn written(
        mut self,
        staging: &Path,
        output: &OutputArguments,
    ) -> Result<CommandOutput, OutputError> {
        let mut artifacts = std::mem::take(&mut self.tables);
        for (name, svg) in std::mem::take(&mut self.figures) {
            if output.png {
                let file = format!("{name}.png");
                match output::png(&svg) {
                    Ok(bytes) => artifacts.push(Artifact { name: file, bytes }),
                    Err(error) => self.left_out(&file, &error),
                }
            }
            artifacts.push(Artifact::text(format!("{name}.svg"), svg));
        }
        let written = output::write_all_by(staging, Path::new(&output.out), &artifacts)?;
        let paths = [std::mem::take(&mut self.written), written].concat();
        self.text.push('\n');
        self.text.push_str(&output::listing(&paths));
        let paths = paths.iter().map(|path| path.display().to_string());
        self.field("files", paths.collect::<Json>());
        Ok(self.output(output.json))
    }
}
