//! The result of one reading for a claim.

use super::digits::{Agreement, agreement};
use super::exponent::OverSettings;
use crate::figures::rows::{Part, Quantity, Row, Value};
use crate::paper::published::{Claim, ClaimKind, Claims};
use crate::paper::reading::Reading;
use crate::text::joined;

/// The result of one reading for a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The reading.
    pub reading: Reading,
    /// The figure whose table has it, or `report`.
    pub source: &'static str,
    /// A value, members of a set, or a statement with its parts.
    pub values: Vec<Value>,
    /// Agreeing digits, for a number.
    pub digits: Option<Agreement>,
    /// Whether it agrees with the published value.
    pub agrees: bool,
    /// Whether it holds by construction, so that it is not evidence.
    pub by_construction: bool,
    /// Evidence of settings that the paper does not state.
    pub settings: OverSettings,
    /// A note.
    pub note: Option<String>,
}

impl Finding {
    /// A statement, judged by its parts.
    pub fn statement(reading: Reading, parts: impl IntoIterator<Item = Part>) -> Self {
        let parts: Vec<Part> = parts.into_iter().collect();
        Finding {
            agrees: !parts.is_empty() && parts.iter().all(|(_, holds)| *holds),
            values: vec![Value::Statement(parts)],
            ..Finding::new(reading)
        }
    }

    fn new(reading: Reading) -> Self {
        Finding {
            reading,
            source: "report",
            values: Vec::new(),
            digits: None,
            agrees: false,
            by_construction: false,
            settings: OverSettings::Decided,
            note: None,
        }
    }

    /// The finding with a note.
    #[must_use]
    pub fn with_note(mut self, note: String) -> Self {
        self.note = Some(note);
        self
    }

    /// Marks it as holding by construction.
    #[must_use]
    pub fn by_construction(mut self) -> Self {
        self.by_construction = true;
        self
    }

    /// Whether it is evidence. It does not hold by construction, and is not an annihilated
    /// exponent, which no estimate can give.
    pub fn is_evidence(&self) -> bool {
        !self.by_construction
            && !matches!(self.values[..], [Value::Number(v)] if v == f64::NEG_INFINITY)
    }

    /// The findings in a figure's rows, one for each reading.
    pub fn of_rows(
        claims: &Claims,
        claim: &Claim,
        source: &'static str,
        rows: &[Row],
    ) -> Vec<Self> {
        let mut findings: Vec<Finding> = Vec::new();
        let compared = |row: &&Row| {
            matches!(
                row.quantity,
                Quantity::Claim(id) | Quantity::Member(id, _) if id == claim.id
            )
        };
        for row in rows.iter().filter(compared) {
            let digits = match row.value {
                Value::Number(value) => agreement(claim, value),
                _ => None,
            };
            let agrees = row.comparison(claims).is_some_and(|one| one.agrees);
            let of_reading = |one: &&mut Finding| one.reading == row.reading;
            if let Some(finding) = findings.iter_mut().find(of_reading) {
                finding.values.push(row.value.clone());
                finding.agrees &= agrees;
                finding.digits = match (finding.digits, digits) {
                    (Some(one), Some(other)) => Some(one.and(other)),
                    (one, other) => one.or(other),
                };
                continue;
            }
            findings.push(Finding {
                source,
                values: vec![row.value.clone()],
                digits,
                agrees,
                note: row.status.map(str::to_owned),
                ..Finding::new(row.reading)
            });
        }
        if claim.kind == ClaimKind::Set {
            for finding in &mut findings {
                finding.agrees &= finding.has_every_member(claim);
            }
        }
        findings
    }

    fn has_every_member(&self, claim: &Claim) -> bool {
        claim.values().iter().all(|published| {
            let is = |value: &Value| {
                matches!(value, Value::Number(v) if claim.agrees_with(*published, *v))
            };
            self.values.iter().any(is)
        })
    }

    /// Whether each part of a statement holds; for other values, whether it agrees.
    pub fn parts(&self) -> Vec<bool> {
        match &self.values[..] {
            [Value::Statement(parts)] => parts.iter().map(|(_, holds)| *holds).collect(),
            _ => vec![self.agrees],
        }
    }

    /// The values in full precision.
    pub fn text(&self) -> String {
        joined(&self.values, ";")
    }

    /// Describes the finding in words, with numbers to so many decimals.
    pub fn line(&self, decimals: usize) -> String {
        let part = |(what, holds): &Part| {
            let word = if *holds { "holds" } else { "fails" };
            format!("{what}: {word}")
        };
        let texts = self.values.iter().map(|value| match value {
            Value::Number(v) if v.is_finite() => plot::number(*v, decimals),
            Value::Statement(parts) => joined(parts.iter().map(part), "; "),
            other => other.to_string(),
        });
        let mut line = format!("{}: {}", self.source, joined(texts, "; "));
        match self.digits {
            Some(digits) => line += &format!(", {digits} digits"),
            None if matches!(self.values[..], [Value::Statement(_)]) => {}
            None if self.agrees => line += ", agrees",
            None => line += ", does not agree",
        }
        if let Some(note) = self.note.as_ref().filter(|note| *note != "ok") {
            line += &format!(" – {note}");
        }
        match self.settings {
            OverSettings::Decided => {}
            OverSettings::Undetermined => {
                line += " – undetermined: settings that the paper does not state decide it";
            }
            OverSettings::Excluded => line += " – no setting tried gives the published value",
        }
        if self.by_construction {
            line += " – no evidence: it could not have come out otherwise";
        } else if !self.is_evidence() {
            line += " – no evidence: not comparable with an estimate from data";
        }
        line
    }
}

/// A statement judged by its parts, with the numbers in one sentence.
pub(super) fn statement(
    reading: Reading,
    parts: impl IntoIterator<Item = Part>,
    line: String,
) -> Finding {
    Finding::statement(reading, parts).with_note(line)
}

/// The statement tested on the listing as printed; it decides nothing about the model.
pub(super) fn as_printed(parts: impl IntoIterator<Item = Part>) -> Finding {
    Finding::statement(Reading::AsPrinted, parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::claim_id::ClaimId;

    #[test]
    fn a_set_is_found_when_every_member_is_and_nothing_else() {
        let claims = Claims::committed().unwrap();
        let id = ClaimId::Eq13CriticalMu0;
        let published = claims.of(id).values().to_vec();
        let of = |values: &[f64]| {
            let rows = Row::members(id, Reading::Exact, values, "N");
            Finding::of_rows(claims, claims.of(id), "test", &rows)[0].clone()
        };
        assert!(of(&published).agrees);
        assert!(!of(&published[1..]).agrees);
        assert!(!of(&[published[0], published[1], published[2], 0.3]).agrees);
        let near: Vec<f64> = published.iter().map(|v| v + 1e-9).collect();
        assert!(!of(&near).agrees && of(&near).digits.unwrap().agreeing >= 7);
    }

    #[test]
    fn a_published_digit_that_changes_changes_the_finding() {
        let text = include_str!("../../data/claims.csv");
        let changed = Claims::parse(&text.replace("value,0.4697,4", "value,0.4698,4")).unwrap();
        let id = ClaimId::Fig08StickLength1;
        let row = Row::number(id, Reading::AsPrinted, 0.469695, "m");
        let agrees = |claims: &Claims| {
            let rows = std::slice::from_ref(&row);
            Finding::of_rows(claims, claims.of(id), "test", rows)[0].agrees
        };
        assert!(agrees(Claims::committed().unwrap()) && !agrees(&changed));
    }
}
