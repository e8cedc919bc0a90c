//! Separators and number format of a text file.

use csv::StringRecord;

/// Separator of columns, and whether numbers have a decimal comma.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// Separator of columns. `None` means any number of spaces and tabs.
    separator: Option<char>,
    has_decimal_comma: bool,
}

impl Dialect {
    /// Detects the format of the first lines. A note is returned if only their digits show that
    /// commas are decimal ones. The very first line counts only if it contains a number, or is the
    /// only line.
    ///
    /// # Errors
    /// Why the columns cannot be distinguished.
    pub fn sense<'t>(
        lines: impl Iterator<Item = &'t str>,
    ) -> Result<(Self, Option<&'static str>), &'static str> {
        let mut sample: Vec<&str> = lines.collect();
        let may_be_number = |part: &str| parse(part).is_some();
        let parts = |line: &'t str| line.split([',', ';', '\t', ' ', '\r']);
        if sample.len() > 1 && !parts(sample[0]).any(may_be_number) {
            sample.remove(0);
        }
        let separator = separator(&sample);
        if separator == Some(',') && are_parts(&sample) {
            if sample.iter().any(|line| line.matches(',').count() > 1) {
                return Err(
                    "commas separate the columns and are decimal commas, too, as no whole numbers \
                     begin with -0 or 0: write decimal points, or separate the columns by \
                     semicolons",
                );
            }
            let dialect = Dialect {
                separator: None,
                has_decimal_comma: true,
            };
            return Ok((
                dialect,
                Some(
                    "the commas are read as decimal commas, as no whole numbers begin with -0 or \
                     0; if they separate columns, write semicolons",
                ),
            ));
        }
        let mut dialect = Dialect {
            separator,
            has_decimal_comma: false,
        };
        // If something else separates columns, a comma can only be a decimal one. If points occur
        // too, no comma is taken as a decimal one.
        let cells: Vec<StringRecord> = sample.iter().map(|line| dialect.cells(line)).collect();
        let any = |holds: &dyn Fn(&str) -> bool| cells.iter().flatten().any(holds);
        let commas = any(&|cell| with_point(cell).is_some());
        let points = any(&|cell| cell.contains('.') && parse(cell).is_some());
        dialect.has_decimal_comma = separator != Some(',') && commas && !points;
        Ok((dialect, None))
    }

    /// The cells of a line, without spaces around them and without quotes, within which separators
    /// do not count.
    pub fn cells(&self, line: &str) -> StringRecord {
        let mut is_quoted = false;
        let cells = line.split(|c: char| {
            is_quoted ^= c == '"';
            let separates = self.separator.map_or(c.is_whitespace(), |one| c == one);
            separates && !is_quoted
        });
        let is_cell = |cell: &&str| self.separator.is_some() || !cell.is_empty();
        let cells = cells.map(str::trim).filter(is_cell);
        cells.map(unquoted).collect()
    }

    /// The names in a comment, if there are `count` and none is a number. Properties of the file as
    /// Octave writes them (`# columns: 1`) are no names.
    pub fn header(&self, comment: &str, count: usize) -> Option<StringRecord> {
        let mut words = comment.split_whitespace();
        if words.next().is_some_and(|word| word.ends_with(':')) && words.next().is_some() {
            return None;
        }
        let words = comment.split_whitespace();
        let by_spaces = words.map(|word| unquoted(word.trim_end_matches([',', ';'])));
        let separated = self.separator.map(|_| self.cells(comment));
        let separated = separated.filter(|names| names.len() == count);
        let names = separated.unwrap_or_else(|| by_spaces.collect());
        let is_name = |name: &str| !name.is_empty() && self.number(name).is_none();
        (names.len() == count && names.iter().all(is_name)).then_some(names)
    }

    /// The number in a cell.
    pub fn number(&self, cell: &str) -> Option<f64> {
        if self.has_decimal_comma
            && let Some(pointed) = with_point(cell)
        {
            return parse(&pointed);
        }
        parse(cell)
    }

    /// Name of the separator, for messages.
    pub fn separated_by(&self) -> &'static str {
        match self.separator {
            None => "spaces",
            Some(';') => "semicolons",
            Some('\t') => "tabs",
            Some(_) => "commas",
        }
    }
}

fn separator(sample: &[&str]) -> Option<char> {
    let any = |character: char| sample.iter().any(|line| line.contains(character));
    if any(';') {
        return Some(';');
    }
    if any('\t') {
        // Alignment with several tabs leaves empty cells in every line. A missing value does so
        // only in some lines.
        let aligned = |line: &&str| line.trim().split('\t').any(|cell| cell.trim().is_empty());
        return (!sample.iter().all(aligned)).then_some('\t');
    }
    // Cells between separating commas contain no spaces. Those between decimal commas do.
    let is_word = |cell: &str| cell.split_whitespace().count() <= 1;
    if any(',') && sample.iter().all(|line| line.split(',').all(is_word)) {
        return Some(',');
    }
    let is_number = |cell: &str| parse(cell).is_some() || with_point(cell).is_some();
    let by_spaces = |line: &&str| !is_word(line) && line.split_whitespace().any(is_number);
    (any('"') || !sample.iter().any(by_spaces)).then_some(',')
}

/// Whether commas separate the two parts of decimal numbers. All cells are then digits, and some
/// are no whole numbers, as -0 before a comma or 05 after it.
fn are_parts(sample: &[&str]) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let mut has_fraction = false;
    for line in sample {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if !cells.len().is_multiple_of(2) {
            return false;
        }
        for pair in cells.chunks_exact(2) {
            if !digits(pair[0].trim_start_matches(['+', '-'])) || !digits(pair[1]) {
                return false;
            }
            has_fraction |= pair[0] == "-0" || (pair[1].len() > 1 && pair[1].starts_with('0'));
        }
    }
    has_fraction
}

/// Parses a number, also in the notation of Fortran.
fn parse(cell: &str) -> Option<f64> {
    cell.parse().ok().or_else(|| {
        let is_fortran = cell
            .bytes()
            .all(|b| b.is_ascii_digit() || b"+-.dD".contains(&b));
        is_fortran
            .then(|| cell.replace(['d', 'D'], "e").parse().ok())
            .flatten()
    })
}

/// The cell with a point in place of its only comma.
fn with_point(cell: &str) -> Option<String> {
    let (whole, rest) = cell.split_once(',')?;
    let begins = whole
        .trim_start_matches(['+', '-'])
        .bytes()
        .all(|b| b.is_ascii_digit());
    let goes_on = rest.bytes().next().is_some_and(|b| b.is_ascii_digit());
    let pointed = format!("{whole}.{rest}");
    (begins && goes_on && parse(&pointed).is_some()).then_some(pointed)
}

/// A cell without its quotes, single or double ones.
fn unquoted(cell: &str) -> &str {
    let inside = |quote: char| cell.strip_prefix(quote)?.strip_suffix(quote);
    let inside = inside('"').or_else(|| inside('\''));
    inside.map_or(cell, str::trim)
}
