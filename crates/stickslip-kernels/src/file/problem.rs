//! What is wrong with a file, shown where it is wrong.

use std::ops::Range;

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::SimpleFile;
use codespan_reporting::term;

/// Something wrong at a place of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong.
    pub message: String,
    /// Where, in bytes of the file.
    pub place: Range<usize>,
    /// What is said at that place.
    pub label: String,
    /// A second place that has to do with it, and what is said there.
    pub also: Option<Box<(Range<usize>, String)>>,
    /// What to do about it.
    pub help: Option<String>,
}

impl Problem {
    /// A problem with nothing but a message and a place.
    pub fn new(message: impl Into<String>, place: Range<usize>) -> Self {
        Problem {
            message: message.into(),
            place,
            label: String::new(),
            also: None,
            help: None,
        }
    }

    /// With words at its place.
    #[must_use]
    pub fn label(self, label: impl Into<String>) -> Self {
        Problem {
            label: label.into(),
            ..self
        }
    }

    /// With a second place.
    #[must_use]
    pub fn also(self, place: Range<usize>, label: impl Into<String>) -> Self {
        Problem {
            also: Some(Box::new((place, label.into()))),
            ..self
        }
    }

    /// With advice.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Problem {
            help: Some(help.into()),
            ..self
        }
    }

    /// With advice, if there is some.
    #[must_use]
    pub fn help_if(self, help: Option<String>) -> Self {
        Problem { help, ..self }
    }

    /// With line, column and the source around it.
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
        let file = SimpleFile::new(source.name.as_str(), source.text.as_str());
        let config = term::Config::default();
        match term::emit_into_string(&config, &file, &diagnostic) {
            // The program begins every message with this word itself.
            Ok(text) => text.trim_start_matches("error: ").trim_end().to_owned(),
            Err(_) => self.message.clone(),
        }
    }
}

/// The text of a file and what it is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Path, or name of a shipped model.
    pub name: String,
    /// Content.
    pub text: String,
}
