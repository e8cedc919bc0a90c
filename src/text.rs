//! Text helpers shared by several programs.

use std::fmt::Display;

/// An enum with a table row for each variant. `ALL` lists the variants in order. The method named
/// after `as` returns the row.
macro_rules! described {
    ($(#[$of_enum:meta])* $name:ident: $row:ty as $vis:vis $method:ident {
        $($(#[$of_variant:meta])* $variant:ident = $described:expr,)*
    }) => {
        $(#[$of_enum])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$of_variant])* $variant,)*
        }

        impl $name {
            /// All variants, in order.
            pub const ALL: [$name; [$(stringify!($variant)),*].len()] = [$($name::$variant),*];

            /// Row of the table.
            $vis const fn $method(self) -> $row {
                match self {
                    $($name::$variant => $described,)*
                }
            }
        }
    };
}
pub(crate) use described;

/// The items joined by `between`.
pub(crate) fn joined<T: Display>(items: impl IntoIterator<Item = T>, between: &str) -> String {
    let items = items.into_iter().map(|item| item.to_string());
    items.collect::<Vec<String>>().join(between)
}

/// Each distinct item once, in order of first occurrence.
pub(crate) fn distinct<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut all = Vec::new();
    for item in items {
        if !all.contains(&item) {
            all.push(item);
        }
    }
    all
}

/// Records as CSV.
pub(crate) fn csv<R, F>(records: impl IntoIterator<Item = R>) -> String
where
    R: IntoIterator<Item = F>,
    F: AsRef<[u8]>,
{
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    for record in records {
        // Writing to memory does not fail.
        let _ = writer.write_record(record);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The lines that delimit a generated part of a file that is otherwise written by hand.
#[derive(Clone, Copy, Debug)]
pub struct SectionMarkers {
    /// The line before it, with its newline.
    pub begin: &'static str,
    /// The line after it, with its newline.
    pub end: &'static str,
}

impl SectionMarkers {
    /// `text` with `part` between the marks; `None` if it has no such marks.
    pub fn replace_section(self, text: &str, part: &str) -> Option<String> {
        let (before, tail) = text.split_once(self.begin)?;
        let (_, after) = tail.split_once(self.end)?;
        let SectionMarkers { begin, end } = self;
        Some(format!("{before}{begin}\n{part}\n{end}{after}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_between_the_marks_is_replaced() {
        let marks = SectionMarkers {
            begin: "<!-- b -->\n",
            end: "<!-- e -->\n",
        };
        let readme = "a\n<!-- b -->\nold\n<!-- e -->\nb\n";
        let once = marks.replace_section(readme, "| new |\n").unwrap();
        assert_eq!(once, "a\n<!-- b -->\n\n| new |\n\n<!-- e -->\nb\n");
        assert_eq!(
            marks.replace_section(&once, "| new |\n"),
            Some(once.clone())
        );
        assert_eq!(marks.replace_section("no marks", "x"), None);
    }
}
