//! The README's verdicts and every sentence of it that has a computed number, written from the ledger.

use super::entry::Entry;
use super::finding::Finding;
use super::ledger::Ledger;
use super::paper_part::PaperPart;
use super::sentences::{resting, sentences};
use super::verdict::Verdict;
use crate::figures::rows::Value;
use crate::marked::Marks;
use crate::paper::published::{Digits, Kind};

/// Where it stands in the README.
pub const MARKS: Marks = Marks {
    begin: "<!-- verdicts: written by `make report` -->\n",
    end: "<!-- end of verdicts -->\n",
};

/// What stands between the marks: the verdict in three sentences, the table, and what its words
/// mean.
pub fn block(ledger: &Ledger) -> String {
    let meanings: Vec<String> = Verdict::ALL
        .iter()
        .map(|verdict| format!("* **{verdict}**: {}", verdict.meaning()))
        .collect();
    format!(
        "{}\n\n{}\n{}\n\n{}\n\n{} more are listed and not counted: identities, which could not have come out otherwise.\n",
        sentences(ledger).join("\n\n"),
        counts(ledger),
        meanings.join("\n"),
        resting(ledger),
        ledger.entries.len() - ledger.counted()
    )
}

/// How many claims of each part of the paper have each verdict.
fn counts(ledger: &Ledger) -> String {
    let mut text = String::from("| part of the paper | claims |");
    for verdict in Verdict::ALL {
        text += &format!(" {verdict} |");
    }
    text += "\n|---|--:|";
    text += &"--:|".repeat(Verdict::COUNT);
    text += "\n";
    for part in PaperPart::ALL {
        let of = |entry: &&Entry| {
            PaperPart::of(entry.claim.id) == part && entry.verdict != Verdict::Identity
        };
        let entries: Vec<&Entry> = ledger.entries.iter().filter(of).collect();
        text += &format!("| {} | {} |", part.name(), entries.len());
        for verdict in Verdict::ALL {
            let with = entries.iter().filter(|entry| entry.verdict == verdict);
            text += &match with.count() {
                0 => "  |".to_owned(),
                count => format!(" {count} |"),
            };
        }
        text += "\n";
    }
    text += &format!("| **all** | **{}** |", ledger.counted());
    for (_, count) in ledger.counts() {
        text += &format!(" **{count}** |");
    }
    text + "\n"
}

/// A reading's values with as many decimals as are printed; six of what is known in closed form.
pub(super) fn shown(entry: &Entry, finding: &Finding) -> String {
    let decimals = match entry.claim.digits {
        Digits::Decimals(printed) => printed,
        Digits::Exact | Digits::None => 6,
    };
    let mut values: Vec<&Value> = finding.values.iter().collect();
    if entry.claim.kind == Kind::Set {
        values.sort_by(|one, other| number(other).total_cmp(&number(one)));
    }
    let mut texts: Vec<String> = values
        .into_iter()
        .map(|value| match value {
            Value::Number(v) if *v == f64::NEG_INFINITY => "−∞".to_owned(),
            Value::Number(v) if v.is_finite() => self::decimals(*v, decimals),
            other => other.to_string(),
        })
        .collect();
    // Several roads may lead to one member.
    texts.dedup();
    texts.join("; ")
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Number(v) => *v,
        _ => f64::NAN,
    }
}

/// A number with so many decimals and a true minus sign; a zero has none.
pub(in crate::report) fn decimals(value: f64, decimals: usize) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_get_a_true_minus_and_words_keep_their_hyphens() {
        assert_eq!(minus("-0.0049"), "−0.0049");
        assert_eq!(minus("quasi-periodic"), "quasi-periodic");
        assert_eq!(minus("-"), "-");
    }
}
