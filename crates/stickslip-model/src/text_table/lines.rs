//! The lines of a text, one at a time and with a maximum length.

use std::io::{BufRead, Read};

use super::TableError;

/// Maximum length of a line, in bytes: enough for a million columns.
const MOST_LINE_BYTES: usize = 1 << 24;

/// First bytes of files that are not text, with the kind of file and a remedy.
const FOREIGN: [(&[u8], &str); 9] = [
    (b"\x1f\x8b", "compressed by gzip; unpack it first: gunzip"),
    (b"BZh", "compressed by bzip2; unpack it first: bunzip2"),
    (b"\xfd7zXZ", "compressed by xz; unpack it first: unxz"),
    (
        b"\x28\xb5\x2f\xfd",
        "compressed by zstd; unpack it first: unzstd",
    ),
    (
        b"PK\x03\x04",
        "a zip archive or a spreadsheet; unpack it, or save the sheet as CSV",
    ),
    (
        b"MATLAB 5.0",
        "a MAT-file; save the variable as text: save('x.txt', 'x', '-ascii', '-double')",
    ),
    (b"\x89HDF", "an HDF5 file; write the array as text or .npy"),
    (b"\xff\xfe", UTF16),
    (b"\xfe\xff", UTF16),
];
const UTF16: &str = "UTF-16; save it as UTF-8 or plain ASCII";

/// Reads line after line.
pub(super) struct Lines<'i, R> {
    input: &'i str,
    source: R,
    number: u64,
    bytes: Vec<u8>,
    /// Whether a line with content has been read.
    has_begun: bool,
    /// The last comment above the content, without its mark.
    pub(super) comment: Option<String>,
    /// Number of a blank line after content.
    blank: Option<u64>,
    /// Number of the first blank line between lines with content.
    pub(super) gap: Option<u64>,
}

impl<'i, R: BufRead> Lines<'i, R> {
    /// Begins to read a text; other kinds of files are rejected.
    pub(super) fn new(input: &'i str, mut source: R) -> Result<Self, TableError> {
        let start = source
            .fill_buf()
            .map_err(|source| TableError::read(input, source))?;
        let foreign = FOREIGN.iter().find(|(mark, _)| start.starts_with(mark));
        let refusal = if let Some((_, what)) = foreign {
            Some(*what)
        } else if start.contains(&0) {
            Some("no text; give a file of numbers in lines")
        } else {
            None
        };
        if let Some(what) = refusal {
            return Err(TableError::File(format!("{input} is {what}")));
        }
        if start.contains(&b'\r') && !start.contains(&b'\n') {
            return Err(TableError::File(format!(
                "{input} ends its lines with carriage returns alone; turn them into line feeds: tr \
                    '\\r' '\\n'"
            )));
        }
        // Spreadsheets write a byte order mark before the first character.
        if start.starts_with(b"\xef\xbb\xbf") {
            source.consume(3);
        }
        Ok(Lines {
            input,
            source,
            number: 0,
            bytes: Vec::new(),
            has_begun: false,
            comment: None,
            blank: None,
            gap: None,
        })
    }

    /// The next line that is neither blank nor a comment, with its number from 1; `None` at the
    /// end.
    pub(super) fn next(&mut self) -> Result<Option<(u64, &str)>, TableError> {
        loop {
            self.number += 1;
            self.bytes.clear();
            let mut part = self.source.by_ref().take(MOST_LINE_BYTES as u64 + 1);
            let read = part
                .read_until(b'\n', &mut self.bytes)
                .map_err(|source| TableError::read(self.input, source))?;
            if read > MOST_LINE_BYTES {
                return Err(self.refused(&format!(
                    "the line is longer than {MOST_LINE_BYTES} bytes: is this \
                    a table of numbers with one state in a line?"
                )));
            }
            match self.bytes.trim_ascii() {
                _ if read == 0 => return Ok(None),
                [] if self.has_begun => {
                    self.blank.get_or_insert(self.number);
                }
                [] => {}
                [b'#' | b'%', comment @ ..] => {
                    if !self.has_begun {
                        // Comments may have any encoding.
                        let text = String::from_utf8_lossy(comment);
                        self.comment = Some(text.trim().to_owned());
                    }
                }
                _ => break,
            }
        }
        self.has_begun = true;
        self.gap = self.gap.or(self.blank);
        match std::str::from_utf8(&self.bytes) {
            Ok(text) if !text.contains('\0') => {
                Ok(Some((self.number, text.trim_end_matches(['\r', '\n']))))
            }
            _ => Err(self.refused("the text is not UTF-8; save the file as UTF-8 or plain ASCII")),
        }
    }

    fn refused(&self, cause: &str) -> TableError {
        TableError::File(format!("{}, line {}: {cause}", self.input, self.number))
    }
}
