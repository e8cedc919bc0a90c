//! The README's verdicts and every sentence of it that has a computed number, written from the ledger.

use super::correction::Correction;
use super::entry::Entry;
use super::finding::Finding;
use super::ledger::Ledger;
use super::paper_part::PaperPart;
use super::sentences::sentences;
use super::verdict::Verdict;
use crate::figures::rows::Value;
use crate::marked::Marks;
use crate::paper::published::{Digits, Kind};
use crate::paper::reading::Role;

/// Where it stands in the README.
pub const MARKS: Marks = Marks {
    begin: "<!-- verdicts: written by `make report` -->\n",
    end: "<!-- end of verdicts -->\n",
};

/// Claims of these parts are listed one by one.
const LISTED: [PaperPart; 4] = [
    PaperPart::Fig8,
    PaperPart::Fig10,
    PaperPart::Fig11,
    PaperPart::Fig12,
];

/// What stands between the marks: the tables, and the sentences that have numbers in them.
pub fn block(ledger: &Ledger) -> String {
    let sentences = sentences(ledger).join("\n\n");
    format!(
        "{}\n{}\n{}\n{sentences}\n",
        counts(ledger),
        meanings(),
        listed(ledger)
    )
}

/// What the words mean.
fn meanings() -> String {
    let each: Vec<String> = Verdict::ALL
        .iter()
        .map(|verdict| format!("* **{verdict}**: {}", verdict.meaning()))
        .collect();
    let corrections: Vec<String> = Correction::ALL
        .iter()
        .map(|one| format!("* {}: {}", one.label(), one.description()))
        .collect();
    format!(
        "{}\n\nEach exponent is judged by its own digits. That its sign agrees, or that it lies inside what the estimator's unstated settings can \
         give, is remarked in the report and is no verdict. The corrections:\n\n{}\n",
        each.join("\n"),
        corrections.join("\n")
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
        let of = |entry: &&Entry| PaperPart::of(entry.claim.id) == part;
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
    text += &format!("| **all** | **{}** |", ledger.entries.len());
    for (_, count) in ledger.counts() {
        text += &format!(" **{count}** |");
    }
    text + "\n"
}

/// The claims of Figs. 8 and 10–12, one by one.
fn listed(ledger: &Ledger) -> String {
    let all = ledger.entries.len();
    let mut text = format!(
        "Of these {all}, the claims of Figs. 8 and 10–12 one by one; all are in `report/claims.csv`.\n\n| claim | published | as stated | with corrected equations | as printed | verdict |\n|---|---|---|---|---|---|\n",
    );
    let listed = |entry: &&Entry| LISTED.contains(&PaperPart::of(entry.claim.id));
    for entry in ledger.entries.iter().filter(listed) {
        let published = match entry.claim.published.as_str() {
            "" => "stated",
            said => said,
        };
        let labels: Vec<String> = match entry.verdict {
            Verdict::WithCorrections => entry.corrections.iter().map(|one| one.label()).collect(),
            _ => Vec::new(),
        };
        text += &format!(
            "| `{}` | {} | {} | {} | {} | {}{} |\n",
            entry.claim.id,
            minus(published),
            cell(entry, Role::Stated),
            cell(entry, Role::Corrected),
            cell(entry, Role::AsPrinted),
            entry.verdict,
            if labels.is_empty() {
                String::new()
            } else {
                format!(" ({})", labels.join(", "))
            }
        );
    }
    text
}

/// What the first reading with a role gives; empty where none speaks.
fn cell(entry: &Entry, role: Role) -> String {
    let Some(first) = entry.with(role).next() else {
        return String::new();
    };
    let text = shown(entry, first);
    if first.by_construction {
        text + " by construction: no evidence"
    } else {
        text
    }
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
