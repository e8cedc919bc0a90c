//! The lines of a text, one at a time and none without bound.

use std::io::{BufRead, Read};

use crate::spectrum_cli::error::SpectrumError;

/// Longest line.
const LONGEST: usize = 1 << 26;

/// Marks at the start of files that are no text, with what they are and what to do.
const FOREIGN: [(&[u8], &str, &str); 9] = [
    (
        b"\x1f\x8b",
        "is compressed by gzip",
        "unpack it first: gunzip",
    ),
    (b"BZh", "is compressed by bzip2", "unpack it first: bunzip2"),
    (b"\xfd7zXZ", "is compressed by xz", "unpack it first: unxz"),
    (
        b"\x28\xb5\x2f\xfd",
        "is compressed by zstd",
        "unpack it first: unzstd",
    ),
    (
        b"PK\x03\x04",
        "is a zip archive or a spreadsheet",
        "unpack it, or save the sheet as CSV",
    ),
    (
        b"MATLAB 5.0",
        "is a MAT-file",
        "save the variable as text: save('x.txt', 'x', '-ascii', '-double')",
    ),
    (
        b"\x89HDF",
        "is an HDF5 file",
        "write the array as text or .npy",
    ),
    (b"\xff\xfe", "is UTF-16", "save it as UTF-8 or plain ASCII"),
    (b"\xfe\xff", "is UTF-16", "save it as UTF-8 or plain ASCII"),
];

/// A line that is not empty.
pub(super) enum Line<'a> {
    /// Its number, counted from 1, and its text.
    Content(u64, &'a str),
    /// A comment, without its mark.
    Comment(String),
}

/// Reads line after line.
pub(super) struct Lines<'i, R> {
    input: &'i str,
    source: R,
    number: u64,
    bytes: Vec<u8>,
    /// Whether a line with content came.
    has_begun: bool,
    /// A blank line behind it.
    blank: Option<u64>,
    /// The first blank line with content before and behind it.
    gap: Option<u64>,
}

impl<'i, R: BufRead> Lines<'i, R> {
    /// The lines of a text; other kinds of files are refused.
    pub(super) fn new(input: &'i str, mut source: R) -> Result<Self, SpectrumError> {
        let failed = |source| SpectrumError::Read {
            input: input.to_owned(),
            source,
        };
        let start = source.fill_buf().map_err(failed)?;
        let foreign = FOREIGN.iter().find(|(mark, ..)| start.starts_with(mark));
        let binary = || {
            start.contains(&0).then_some((
                &b""[..],
                "is no text",
                "give a file of numbers in lines",
            ))
        };
        let mac = || {
            let returns = start.contains(&b'\r') && !start.contains(&b'\n');
            returns.then_some((
                &b""[..],
                "ends its lines with carriage returns alone",
                "turn them into line feeds: tr '\\r' '\\n'",
            ))
        };
        if let Some((_, what, remedy)) = foreign.copied().or_else(binary).or_else(mac) {
            let input = input.to_owned();
            return Err(SpectrumError::Foreign {
                input,
                what,
                remedy,
            });
        }
        // Spreadsheets put a mark before the first character.
        if start.starts_with(b"\xef\xbb\xbf") {
            source.consume(3);
        }
        Ok(Lines {
            input,
            source,
            number: 0,
            bytes: Vec::new(),
            has_begun: false,
            blank: None,
            gap: None,
        })
    }

    /// The next line that holds something; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>, SpectrumError> {
        loop {
            self.number += 1;
            self.bytes.clear();
            let mut part = self.source.by_ref().take(LONGEST as u64 + 1);
            let read =
                part.read_until(b'\n', &mut self.bytes)
                    .map_err(|source| SpectrumError::Read {
                        input: self.input.to_owned(),
                        source,
                    })?;
            if read == 0 {
                return Ok(None);
            }
            if read > LONGEST {
                return Err(self.text(format!("the line is longer than {LONGEST} bytes: is this a table of numbers with one state in a line?")));
            }
            if !self.bytes.trim_ascii().is_empty() {
                break;
            }
            if self.has_begun {
                self.blank.get_or_insert(self.number);
            }
        }
        if let [b'#' | b'%', comment @ ..] = self.bytes.trim_ascii() {
            // In whatever encoding.
            return Ok(Some(Line::Comment(
                String::from_utf8_lossy(comment).trim().to_owned(),
            )));
        }
        let number = self.number;
        if std::str::from_utf8(&self.bytes).is_err() || self.bytes.contains(&0) {
            return Err(self
                .text("the text is not UTF-8; save the file as UTF-8 or plain ASCII".to_owned()));
        }
        self.has_begun = true;
        self.gap = self.gap.or(self.blank);
        let text = std::str::from_utf8(&self.bytes).unwrap_or_default();
        Ok(Some(Line::Content(
            number,
            text.trim_end_matches(['\r', '\n']),
        )))
    }

    /// The first blank line between lines with content, if there is one.
    pub(super) fn gap(&self) -> Option<u64> {
        self.gap
    }

    fn text(&self, cause: String) -> SpectrumError {
        SpectrumError::Text {
            input: self.input.to_owned(),
            line: self.number,
            cause,
        }
    }
}
