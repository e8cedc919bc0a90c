//! Text between two marks in a file that is otherwise written by hand.

/// The lines that a generated part stands between.
#[derive(Clone, Copy, Debug)]
pub struct Marks {
    /// The line before it, with its end.
    pub begin: &'static str,
    /// The line after it, with its end.
    pub end: &'static str,
}

impl Marks {
    /// `text` with `part` between the marks; nothing if it does not have them.
    pub fn put(self, text: &str, part: &str) -> Option<String> {
        let (before, rest) = text.split_once(self.begin)?;
        let (_, after) = rest.split_once(self.end)?;
        let Marks { begin, end } = self;
        Some(format!("{before}{begin}\n{part}\n{end}{after}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_between_the_marks_is_replaced() {
        let marks = Marks {
            begin: "<!-- b -->\n",
            end: "<!-- e -->\n",
        };
        let readme = "a\n<!-- b -->\nold\n<!-- e -->\nb\n";
        let once = marks.put(readme, "| new |\n").unwrap();
        assert_eq!(once, "a\n<!-- b -->\n\n| new |\n\n<!-- e -->\nb\n");
        assert_eq!(marks.put(&once, "| new |\n"), Some(once.clone()));
        assert_eq!(marks.put("no marks", "x"), None);
    }
}
