//! The generated part of the README: the verdict.

use super::finding::Finding;
use super::ledger::{Entry, Ledger};
use super::sentences::sentences;
use crate::figures::rows::Value;
use crate::paper::published::{ClaimKind, Digits};
use crate::text::{SectionMarkers, joined};

/// Markers of the part in the README.
pub const SECTION_MARKERS: SectionMarkers = SectionMarkers {
    begin: "<!-- verdicts: written by `make report` -->\n",
    end: "<!-- end of verdicts -->\n",
};

/// The text between the marks: the verdict in three sentences.
pub fn block(ledger: &Ledger) -> String {
    joined(sentences(ledger).map(|sentence| item(&sentence) + "\n"), "")
}

/// An item of a list, in lines of at most 100 columns.
fn item(sentence: &str) -> String {
    let mut lines = vec![String::from("*")];
    for word in sentence.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 100 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("  {word}")),
        }
    }
    lines.join("\n")
}

/// The values of a reading with as many decimals as are printed, or six for a closed form.
pub(super) fn formatted_values(entry: &Entry, finding: &Finding) -> String {
    let decimals = match entry.claim.digits {
        Digits::Decimals(printed) => printed,
        Digits::Exact | Digits::None => 6,
    };
    let mut values: Vec<&Value> = finding.values.iter().collect();
    if entry.claim.kind == ClaimKind::Set {
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
