//! What one reading gives for a claim.

use super::digits::{Agreement, agreement};
use super::readme;
use crate::figures::rows::{Part, Quantity, Row, Value};
use crate::paper::published::{Claim, Claims, Kind};
use crate::paper::reading::Reading;

/// What one reading gives for a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The reading.
    pub reading: Reading,
    /// Where it was computed: `fig08`, or `report`.
    pub source: &'static str,
    /// What it gives; a set has several members.
    pub values: Vec<Value>,
    /// Digits in agreement, of a set the least; nothing for words.
    pub digits: Option<Agreement>,
    /// Whether it is what the paper says.
    pub agrees: bool,
    /// Whether it could not have come out otherwise, and is therefore no evidence.
    pub by_construction: bool,
    /// Whether settings that the paper does not state move it by more than the printed digits.
    pub undetermined: bool,
    /// What the value is worth, such as `unidentified`.
    pub note: Option<String>,
}

impl Finding {
    /// A number against the one that `claim` publishes.
    pub fn number(claim: &Claim, reading: Reading, source: &'static str, value: f64) -> Self {
        Finding {
            values: vec![Value::Number(value)],
            digits: agreement(claim, value),
            agrees: claim.agrees(value),
            ..Finding::new(reading, source)
        }
    }

    /// The members of a set.
    pub fn set(claim: &Claim, reading: Reading, source: &'static str, values: &[f64]) -> Self {
        let members = values
            .iter()
            .map(|value| Finding::number(claim, reading, source, *value));
        let mut found = members
            .reduce(|mut known, one| {
                known.join(one);
                known
            })
            .unwrap_or_else(|| Finding::new(reading, source));
        found.agrees &= found.has_every_member(claim);
        found
    }

    /// A word or a count against the published one.
    pub fn word(claim: &Claim, reading: Reading, source: &'static str, value: Value) -> Self {
        Finding {
            agrees: value.to_string() == claim.published,
            values: vec![value],
            ..Finding::new(reading, source)
        }
    }

    /// A statement, part by part; without parts it does not hold.
    pub fn statement(reading: Reading, source: &'static str, parts: Vec<Part>) -> Self {
        Finding {
            agrees: !parts.is_empty() && parts.iter().all(|part| part.holds),
            values: vec![Value::Statement(parts)],
            ..Finding::new(reading, source)
        }
    }

    fn new(reading: Reading, source: &'static str) -> Self {
        Finding {
            reading,
            source,
            values: Vec::new(),
            digits: None,
            agrees: false,
            by_construction: false,
            undetermined: false,
            note: None,
        }
    }

    /// The same, with a word on what it is worth.
    #[must_use]
    pub fn noted(mut self, note: String) -> Self {
        self.note = Some(note);
        self
    }

    /// The same, as something that could not have come out otherwise.
    #[must_use]
    pub fn by_construction(mut self) -> Self {
        self.by_construction = true;
        self
    }

    /// The same, as a value that unstated settings decide.
    #[must_use]
    pub fn undetermined(mut self) -> Self {
        self.undetermined = true;
        self
    }

    /// Whether it can speak for the claim or against it. A direction that stick annihilates has the
    /// exponent −∞ in the equations; an estimate from data is always finite, and the two cannot be
    /// compared.
    pub fn is_evidence(&self) -> bool {
        !self.by_construction && self.value() != Some(f64::NEG_INFINITY)
    }

    /// What a figure's rows give for a claim, one finding for each reading.
    pub fn of_rows(
        claims: &Claims,
        claim: &Claim,
        source: &'static str,
        rows: &[Row],
    ) -> Vec<Self> {
        let mut findings: Vec<Finding> = Vec::new();
        let compared = |row: &&Row| matches!(row.quantity, Quantity::Claim(id) | Quantity::Member(id, _) if id == claim.id);
        for row in rows.iter().filter(compared) {
            let one = Finding::of_row(claims, claim, source, row);
            match findings
                .iter_mut()
                .find(|known| known.reading == row.reading)
            {
                Some(known) => known.join(one),
                None => findings.push(one),
            }
        }
        if claim.kind == Kind::Set {
            for found in &mut findings {
                found.agrees &= found.has_every_member(claim);
            }
        }
        findings
    }

    fn of_row(claims: &Claims, claim: &Claim, source: &'static str, row: &Row) -> Self {
        let comparison = row.comparison(claims);
        let digits = match row.value {
            Value::Number(value) => agreement(claim, value),
            _ => None,
        };
        Finding {
            values: vec![row.value.clone()],
            digits,
            agrees: comparison.is_some_and(|one| one.agrees),
            note: row.status.map(str::to_owned),
            ..Finding::new(row.reading, source)
        }
    }

    /// Another member of the same set.
    fn join(&mut self, other: Finding) {
        self.values.extend(other.values);
        self.agrees &= other.agrees;
        self.digits = match (self.digits, other.digits) {
            (Some(one), Some(other)) => Some(one.and(other)),
            (one, other) => one.or(other),
        };
    }

    /// Whether every published member was found.
    fn has_every_member(&self, claim: &Claim) -> bool {
        claim.values().iter().all(|published| {
            let is = |value: &Value| {
                matches!(value, Value::Number(v) if claim.agrees_with(*published, *v))
            };
            self.values.iter().any(is)
        })
    }

    /// Whether each of its parts holds: of a statement these, otherwise the whole.
    pub fn parts(&self) -> Vec<bool> {
        match &self.values[..] {
            [Value::Statement(parts)] => parts.iter().map(|part| part.holds).collect(),
            _ => vec![self.agrees],
        }
    }

    /// The values in full precision, members separated by `;`.
    pub fn text(&self) -> String {
        let texts: Vec<String> = self.values.iter().map(Value::to_string).collect();
        texts.join(";")
    }

    /// One line of evidence, numbers rounded to so many decimals.
    pub fn line(&self, decimals: usize) -> String {
        let texts: Vec<String> = self
            .values
            .iter()
            .map(|value| match value {
                Value::Number(v) if v.is_finite() => readme::decimals(*v, decimals),
                Value::Statement(parts) => in_words(parts),
                other => other.to_string(),
            })
            .collect();
        let mut line = format!("{}: {}", self.source, texts.join("; "));
        match self.digits {
            Some(digits) => line += &format!(", {digits} digits"),
            None if matches!(self.values[..], [Value::Statement(_)]) => {}
            None if self.agrees => line += ", agrees",
            None => line += ", does not agree",
        }
        if let Some(note) = self.note.as_ref().filter(|note| *note != "ok") {
            line += &format!(" – {note}");
        }
        if self.undetermined {
            line += " – undetermined: settings that the paper does not state decide it";
        }
        if self.by_construction {
            line += " – no evidence: it could not have come out otherwise";
        } else if !self.is_evidence() {
            line += " – no evidence: not comparable with an estimate from data";
        }
        line
    }

    /// The value, if there is just one and it is a number.
    pub fn value(&self) -> Option<f64> {
        match self.values[..] {
            [Value::Number(value)] => Some(value),
            _ => None,
        }
    }
}

/// Every part with what becomes of it.
fn in_words(parts: &[Part]) -> String {
    let texts: Vec<String> = parts
        .iter()
        .map(|part| {
            format!(
                "{}: {}",
                part.what,
                if part.holds { "holds" } else { "fails" }
            )
        })
        .collect();
    texts.join("; ")
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
        let agrees = |claims: &Claims| {
            Finding::number(claims.of(id), Reading::AsPrinted, "test", 0.469695).agrees
        };
        assert!(agrees(Claims::committed().unwrap()) && !agrees(&changed));
    }
}
