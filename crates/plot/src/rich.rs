//! Markup for the mathematics in labels.
//!
//! `*x*` is italic, `**(a)**` bold; `_` and `^` put the next character, or a group in braces, below
//! or above the line: `*x*_1`, `*z*_{*k*}`, `10^{−4}`. A backslash takes the next character
//! literally. Greek letters and signs are typed as they are: `*μ*_0 = √3/9`.

/// Position of a run of text relative to the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Level {
    /// The line itself.
    #[default]
    Base,
    /// Subscript.
    Sub,
    /// Superscript.
    Sup,
}

impl Level {
    /// Font size relative to the text on the line.
    pub(super) fn scale(self) -> f64 {
        match self {
            Level::Base => 1.0,
            Level::Sub | Level::Sup => 0.72,
        }
    }

    /// Distance of the baseline below the line's, in font sizes of the text on the line.
    pub(super) fn drop(self) -> f64 {
        match self {
            Level::Base => 0.0,
            Level::Sub => 0.24,
            Level::Sup => -0.38,
        }
    }
}

/// A text in one style.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Run {
    /// The characters.
    pub(super) text: String,
    /// Slanted, for variables.
    pub(super) italic: bool,
    /// Heavy, for panel labels.
    pub(super) bold: bool,
    /// Level: on, below or above the line.
    pub(super) level: Level,
}

/// Splits marked-up text into runs. Every input is accepted: a mark that is never closed reaches to
/// the end.
pub(super) fn parse(markup: &str) -> Vec<Run> {
    let mut parser = Parser::default();
    let mut chars = markup.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '\\' => {
                parser.run.text.extend(chars.next());
            }
            '*' if chars.peek() == Some(&'*') => {
                chars.next();
                parser.flush();
                parser.run.bold = !parser.run.bold;
            }
            '*' => {
                parser.flush();
                parser.run.italic = !parser.run.italic;
            }
            '_' | '^' if !parser.in_group => {
                parser.flush();
                parser.run.level = if c == '_' { Level::Sub } else { Level::Sup };
                if chars.peek() == Some(&'{') {
                    chars.next();
                    parser.in_group = true;
                } else {
                    parser.run.text.extend(chars.next());
                    parser.return_to_line();
                }
            }
            '}' if parser.in_group => parser.return_to_line(),
            _ => parser.run.text.push(c),
        }
    }
    parser.flush();
    parser.runs
}

/// The characters alone, for places that cannot show markup.
pub(super) fn plain(markup: &str) -> String {
    parse(markup).into_iter().map(|run| run.text).collect()
}

#[derive(Default)]
struct Parser {
    runs: Vec<Run>,
    /// The run that is being extended.
    run: Run,
    in_group: bool,
}

impl Parser {
    fn flush(&mut self) {
        if !self.run.text.is_empty() {
            self.runs.push(self.run.clone());
            self.run.text.clear();
        }
    }

    fn return_to_line(&mut self) {
        self.flush();
        self.run.level = Level::Base;
        self.in_group = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(text: &str, italic: bool, bold: bool, level: Level) -> Run {
        Run {
            text: text.into(),
            italic,
            bold,
            level,
        }
    }

    #[test]
    fn variables_subscripts_and_powers() {
        assert_eq!(
            parse("*x*_1 = *z*_{*k*} + 10^{−4}"),
            vec![
                run("x", true, false, Level::Base),
                run("1", false, false, Level::Sub),
                run(" = ", false, false, Level::Base),
                run("z", true, false, Level::Base),
                run("k", true, false, Level::Sub),
                run(" + 10", false, false, Level::Base),
                run("−4", false, false, Level::Sup),
            ]
        );
    }

    #[test]
    fn bold_and_escapes() {
        assert_eq!(
            parse(r"**(a)** 2\*3"),
            vec![
                run("(a)", false, true, Level::Base),
                run(" 2*3", false, false, Level::Base)
            ]
        );
    }

    #[test]
    fn unfinished_markup_is_taken_to_the_end() {
        assert_eq!(plain("*x"), "x");
        assert_eq!(plain("x_"), "x");
        assert_eq!(plain("x_{ab"), "xab");
        assert_eq!(plain("\\"), "");
        assert_eq!(plain("{a}"), "{a}");
    }
}
