//! The part of the README that says what holds: claims counted by verdict for each part of the
//! paper.

use super::finding::Finding;
use super::ledger::{Entry, Ledger};
use super::sentences::{PARTS, resting, sentences};
use super::verdict::Verdict;
use crate::figures::rows::Value;
use crate::paper::published::{Digits, Kind};
use crate::text::{Marks, joined};

/// Where it stands in the README.
pub const MARKS: Marks = Marks {
    begin: "<!-- verdicts: written by `make report` -->\n",
    end: "<!-- end of verdicts -->\n",
};

/// What stands between the marks: the verdict in three sentences, the table, and what its words
/// mean.
pub fn block(ledger: &Ledger) -> String {
    let meanings = Verdict::COUNTED
        .iter()
        .map(|verdict| format!("* **{verdict}**: {}", verdict.meaning()));
    format!(
        "{}\n\n{}\n{}\n\n{}\n\n{} more are listed and not counted: identities, which could not have come out otherwise.\n",
        sentences(ledger).join("\n\n"),
        counts(ledger),
        joined(meanings, "\n"),
        resting(ledger),
        ledger.entries.len() - ledger.counted()
    )
}

/// How many claims of each part of the paper have each verdict.
fn counts(ledger: &Ledger) -> String {
    let cells = |cells: Vec<String>| format!(" {} |\n", cells.join(" | "));
    let names = Verdict::COUNTED.map(|verdict| verdict.to_string());
    let mut text = String::from("| part of the paper | claims |") + &cells(names.to_vec());
    text += &format!("|---|--:|{}\n", "--:|".repeat(Verdict::COUNTED.len()));
    for (part, name) in PARTS {
        let of = |entry: &&Entry| entry.claim.part == part && entry.verdict != Verdict::Identity;
        let entries: Vec<&Entry> = ledger.entries.iter().filter(of).collect();
        text += &format!("| {name} | {} |", entries.len());
        for verdict in Verdict::COUNTED {
            let with = entries.iter().filter(|entry| entry.verdict == verdict);
            text += &match with.count() {
                0 => "  |".to_owned(),
                count => format!(" {count} |"),
            };
        }
        text += "\n";
    }
    let all = ledger.counts().map(|(_, count)| format!("**{count}**"));
    text + &format!("| **all** | **{}** |", ledger.counted()) + &cells(all.to_vec())
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
    let texts = values.into_iter().map(|value| match value {
        Value::Number(v) if *v == f64::NEG_INFINITY => "−∞".to_owned(),
        Value::Number(v) if v.is_finite() => plot::number(*v, decimals),
        other => other.to_string(),
    });
    let mut texts: Vec<String> = texts.collect();
    texts.dedup();
    texts.join("; ")
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Number(v) => *v,
        _ => f64::NAN,
    }
}
