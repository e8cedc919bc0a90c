//! The README's table of verdicts, written from the ledger.

use super::entry::{Entry, ReadingValue, Role, Verdict};
use super::ledger::Ledger;
use crate::figures::rows::Value;
use crate::paper::published::Digits;

const BEGIN: &str = "<!-- verdicts: written by `make report` -->\n";
const END: &str = "<!-- end of verdicts -->\n";

/// Parts of the paper, by the beginnings of their claims' names.
const PARTS: [(&str, &[&str]); 9] = [
    (
        "Eqs. (12)–(16), Sect. 2",
        &["eq12.", "eq13.", "s2.", "eq16."],
    ),
    ("Fig. 4", &["fig04."]),
    ("Fig. 6", &["fig06."]),
    (
        "Eqs. (22)–(24), Fig. 7",
        &["eq22.", "eq23.", "eq24.", "fig07"],
    ),
    ("Fig. 8", &["fig08."]),
    ("Fig. 10", &["fig10."]),
    ("Fig. 11", &["fig11."]),
    ("Fig. 12", &["fig12."]),
    ("Abstract, Sect. 5.2", &["abstract.", "s5."]),
];

/// Claims of these are listed one by one.
const LISTED: [&str; 4] = ["fig08.", "fig10.", "fig11.", "fig12."];

/// The tables in Markdown.
pub fn table(ledger: &Ledger) -> String {
    let mut text = String::from("| part of the paper | claims |");
    for verdict in Verdict::ALL {
        text += &format!(" {verdict} |");
    }
    text += "\n|---|--:|--:|--:|--:|--:|\n";
    for (name, beginnings) in PARTS {
        let of = |entry: &&Entry| {
            beginnings
                .iter()
                .any(|begin| entry.claim.id.starts_with(begin))
        };
        let entries: Vec<&Entry> = ledger.entries.iter().filter(of).collect();
        text += &format!("| {name} | {} |", entries.len());
        for verdict in Verdict::ALL {
            let count = entries
                .iter()
                .filter(|entry| entry.verdict == verdict)
                .count();
            text += &if count == 0 {
                "  |".to_owned()
            } else {
                format!(" {count} |")
            };
        }
        text += "\n";
    }
    text += &format!("| **all** | **{}** |", ledger.entries.len());
    for (_, count) in ledger.counts() {
        text += &format!(" **{count}** |");
    }
    text += "\n\n| claim | published | exact | as printed | verdict |\n|---|---|---|---|---|\n";
    let listed = |entry: &&Entry| LISTED.iter().any(|begin| entry.claim.id.starts_with(begin));
    for entry in ledger.entries.iter().filter(listed) {
        let published = match entry.claim.published.as_str() {
            "" => "stated",
            said => said,
        };
        text += &format!(
            "| `{}` | {} | {} | {} | {} |\n",
            entry.claim.id,
            minus(published),
            cell(entry, Role::Stated),
            cell(entry, Role::AsPrinted),
            entry.verdict
        );
    }
    text
}

/// What the first reading with a role gives; empty where none speaks.
fn cell(entry: &Entry, role: Role) -> String {
    let first = entry.readings.iter().find(|one| one.role() == role);
    first.map_or_else(String::new, |one| shown(entry, one))
}

/// A reading's values with as many decimals as are printed; six of what is known in closed form.
pub(super) fn shown(entry: &Entry, reading: &ReadingValue) -> String {
    let decimals = match entry.claim.digits {
        Digits::Decimals(printed) => printed,
        Digits::Exact | Digits::None => 6,
    };
    let texts: Vec<String> = reading
        .values
        .iter()
        .map(|value| match value {
            Value::Number(v) if *v == f64::NEG_INFINITY => "−∞".to_owned(),
            Value::Number(v) if v.is_finite() => self::decimals(*v, decimals),
            other => other.to_string(),
        })
        .collect();
    texts.join("; ")
}

/// A number with so many decimals and a true minus sign; a zero has none.
pub(super) fn decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.chars().all(|c| "-0.".contains(c));
    minus(if is_zero {
        text.trim_start_matches('-')
    } else {
        &text
    })
}

/// With a true minus sign where a number begins with a hyphen.
pub(super) fn minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => format!("−{rest}"),
        _ => text.to_owned(),
    }
}

/// `readme` with `table` between its marks; nothing if it has no marks.
pub fn with_table(readme: &str, table: &str) -> Option<String> {
    let (before, rest) = readme.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}\n{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_between_the_marks_is_replaced() {
        let readme = format!("a\n{BEGIN}old\n{END}b\n");
        let once = with_table(&readme, "| new |\n").unwrap();
        assert_eq!(once, format!("a\n{BEGIN}\n| new |\n\n{END}b\n"));
        assert_eq!(with_table(&once, "| new |\n"), Some(once.clone()));
        assert_eq!(with_table("no marks", "x"), None);
    }

    #[test]
    fn numbers_get_a_true_minus_and_words_keep_their_hyphens() {
        assert_eq!(minus("-0.0049"), "−0.0049");
        assert_eq!(minus("quasi-periodic"), "quasi-periodic");
        assert_eq!(minus("-"), "-");
    }
}
