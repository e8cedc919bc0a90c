//! Errors in a file, shown with the source line.

use std::ops::Range;

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;

/// An error at a position in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The message.
    pub message: String,
    /// Position in bytes of the file.
    pub place: Range<usize>,
    /// Label at the position.
    pub label: String,
    /// A second, related position and its label.
    pub also: Option<Box<(Range<usize>, String)>>,
    /// Advice.
    pub help: Option<String>,
}

impl Problem {
    /// An error with only a message and a position.
    pub fn new(message: impl Into<String>, place: Range<usize>) -> Self {
        Problem {
            message: message.into(),
            place,
            label: String::new(),
            also: None,
            help: None,
        }
    }

    /// Adds a label at the position.
    #[must_use]
    pub fn label(self, label: impl Into<String>) -> Self {
        Problem {
            label: label.into(),
            ..self
        }
    }

    /// Adds a second position.
    #[must_use]
    pub fn also(self, place: Range<usize>, label: impl Into<String>) -> Self {
        Problem {
            also: Some(Box::new((place, label.into()))),
            ..self
        }
    }

    /// Adds advice.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Problem {
            help: Some(help.into()),
            ..self
        }
    }

    /// Adds advice, if there is any.
    #[must_use]
    pub fn help_if(self, help: Option<String>) -> Self {
        Problem { help, ..self }
    }

    /// The text of the error, with line, column and surrounding source.
    pub fn shown(&self, source: &Source) -> String {
        let primary = Label::primary((), self.place.clone()).with_message(&self.label);
        let mut labels = vec![primary];
        if let Some((place, label)) = self.also.as_deref() {
            labels.push(Label::secondary((), place.clone()).with_message(label));
        }
        let diagnostic = Diagnostic::error()
            .with_message(&self.message)
            .with_labels(labels)
            .with_notes(
                self.help
                    .iter()
                    .map(|help| format!("help: {help}"))
                    .collect(),
            );
        if let Some(text) = self.in_long_line(&source.text) {
            return format!("{}\n  ┌─ {}:{text}", self.message, source.name);
        }
        let file = SimpleFile::new(source.name.as_str(), source.text.as_str());
        let config = term::Config::default();
        match term::emit_into_string(&config, &file, &diagnostic) {
            // The program itself begins every message with this word.
            Ok(text) => text.trim_start_matches("error: ").trim_end().to_owned(),
            Err(_) => self.message.clone(),
        }
    }

    /// Line and column of a fault in a line that is too long to be shown, and the advice.
    fn in_long_line(&self, text: &str) -> Option<String> {
        let before = text.get(..self.place.start)?;
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let is_long = text[start..].lines().next()?.len() > MOST_LINE_BYTES;
        let help = self.help.iter().map(|help| format!("\n  = help: {help}"));
        let (line, column) = (
            before.matches('\n').count(),
            before[start..].chars().count(),
        );
        is_long.then(|| format!("{}:{}{}", line + 1, column + 1, help.collect::<String>()))
    }
}

/// Longest line that is shown, in bytes. It is chosen: lines written by hand are shorter.
const MOST_LINE_BYTES: usize = 1000;

/// The text of a file and its name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// Path, or name of a shipped model.
    pub name: String,
    /// Content.
    pub text: String,
}
