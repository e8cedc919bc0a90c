//! What becomes of one claim.

use std::fmt;

use super::digits::Agreement;
use super::readme;
use crate::figures::rows::Value;
use crate::paper::published::Claim;

/// What the comparison comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The stated model, solved accurately, gives it to all published digits, or the statement holds.
    Reproduced,
    /// The printed code or formula gives it and the stated model does not, and the accurate solver with exactly the named
    /// defects gives it too.
    AsPrintedOnly,
    /// The kind of motion or the sign is right, the digits are not.
    ClassOnly,
    /// No tested reading gives it.
    NotReproduced,
}

impl Verdict {
    /// All of them, the best first.
    pub const ALL: [Verdict; 4] = [
        Verdict::Reproduced,
        Verdict::AsPrintedOnly,
        Verdict::ClassOnly,
        Verdict::NotReproduced,
    ];
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::AsPrintedOnly => "reproduced as printed only",
            Verdict::ClassOnly => "class only",
            Verdict::NotReproduced => "not reproduced",
        })
    }
}

/// What a reading stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The stated model, solved accurately.
    Stated,
    /// What the paper's code or equations literally say.
    AsPrinted,
    /// An accurate solver with named defects put into it.
    Injected,
    /// Anything else that was tried.
    Tried,
}

impl Role {
    /// The role of a reading by its name in the figures' tables.
    pub fn of(reading: &str) -> Role {
        match reading.split('/').next() {
            Some("exact") => Role::Stated,
            Some("as-printed") => Role::AsPrinted,
            Some("slip-times-three" | "least-set") => Role::Injected,
            _ => Role::Tried,
        }
    }
}

/// What one reading gives for a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingValue {
    /// Name of the reading, as in the figures' tables.
    pub reading: String,
    /// Where it was computed: `fig08`, or `report`.
    pub source: &'static str,
    /// What it gives; a set has several members.
    pub values: Vec<Value>,
    /// Digits in agreement, of a set the least; nothing for words.
    pub digits: Option<Agreement>,
    /// Whether it is what the paper says.
    pub agrees: bool,
    /// What the value is worth, such as `unidentified`.
    pub note: Option<String>,
}

impl ReadingValue {
    /// Its role.
    pub fn role(&self) -> Role {
        Role::of(&self.reading)
    }

    /// The values in full precision, members separated by `;`.
    pub fn text(&self) -> String {
        let texts: Vec<String> = self.values.iter().map(Value::to_string).collect();
        texts.join(";")
    }

    /// One line of evidence, numbers rounded to one digit more than the paper prints.
    pub fn line(&self, decimals: usize) -> String {
        let texts: Vec<String> = self
            .values
            .iter()
            .map(|value| match value {
                Value::Number(v) if v.is_finite() => readme::decimals(*v, decimals),
                other => other.to_string(),
            })
            .collect();
        let mut line = format!("{} ({}): {}", self.reading, self.source, texts.join("; "));
        match self.digits {
            Some(digits) => line += &format!(", {digits} digits"),
            None if self.agrees => line += ", agrees",
            None => line += ", does not agree",
        }
        if let Some(note) = self.note.as_ref().filter(|note| *note != "ok") {
            line += &format!(", {note}");
        }
        line
    }

    /// The value, if there is just one and it is a number.
    pub fn number(&self) -> Option<f64> {
        match self.values[..] {
            [Value::Number(value)] => Some(value),
            _ => None,
        }
    }
}

/// Why the printed code gives what the stated model does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cause {
    /// Names of the defects, as in [`crate::paper::listing::Defect::name`].
    pub defects: Vec<&'static str>,
    /// The injection in words, with its outcome.
    pub text: String,
}

/// How far a value moves over what is unstated.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Least value.
    pub least: f64,
    /// Largest value.
    pub largest: f64,
    /// Over what.
    pub over: String,
}

impl Spread {
    /// Whether the published value lies in it.
    pub fn holds(&self, claim: &Claim) -> bool {
        let published = claim.values();
        published
            .first()
            .is_some_and(|v| (self.least..=self.largest).contains(v))
    }
}

/// Everything about one claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The claim.
    pub claim: Claim,
    /// What the readings give.
    pub readings: Vec<ReadingValue>,
    /// The verdict.
    pub verdict: Verdict,
    /// What it rests on, line by line.
    pub evidence: Vec<String>,
    /// Why, for [`Verdict::AsPrintedOnly`].
    pub cause: Option<Cause>,
    /// How far, for [`Verdict::ClassOnly`] of a number.
    pub spread: Option<Spread>,
}

impl Entry {
    /// The first reading with a name.
    pub fn reading(&self, name: &str) -> Option<&ReadingValue> {
        self.readings.iter().find(|one| one.reading == name)
    }

    /// The most digits in agreement of any reading with a role.
    pub fn digits(&self, role: Role) -> Option<Agreement> {
        let all = self.readings.iter().filter(|one| one.role() == role);
        all.filter_map(|one| one.digits)
            .max_by_key(|digits| digits.agreeing)
    }
}

/// The verdict, by the readings alone: `class_right` says whether kind or sign is that of the paper.
pub fn verdict(readings: &[ReadingValue], class_right: Option<bool>) -> Verdict {
    let of = |role: Role| readings.iter().filter(move |one| one.role() == role);
    let stated = of(Role::Stated).next().is_some() && of(Role::Stated).all(|one| one.agrees);
    let printed = of(Role::AsPrinted).any(|one| one.agrees);
    let injected = of(Role::Injected).any(|one| one.agrees);
    if stated {
        Verdict::Reproduced
    } else if printed && injected {
        Verdict::AsPrintedOnly
    } else if class_right == Some(true) {
        Verdict::ClassOnly
    } else {
        Verdict::NotReproduced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(name: &str, agrees: bool) -> ReadingValue {
        ReadingValue {
            reading: name.into(),
            source: "report",
            values: vec![Value::Count(1)],
            digits: None,
            agrees,
            note: None,
        }
    }

    #[test]
    fn the_verdict_follows_from_the_readings() {
        let of = |all: &[(&str, bool)], class| {
            let readings: Vec<_> = all
                .iter()
                .map(|&(name, agrees)| reading(name, agrees))
                .collect();
            verdict(&readings, class)
        };
        assert_eq!(
            of(&[("exact", true), ("as-printed", false)], None),
            Verdict::Reproduced
        );
        // One accurate reading that contradicts is enough against it.
        assert_eq!(
            of(
                &[("exact/equations", true), ("exact/data", false)],
                Some(true)
            ),
            Verdict::ClassOnly
        );
        let printed = [("exact", false), ("as-printed", true)];
        assert_eq!(of(&printed, None), Verdict::NotReproduced);
        let with_cause = [printed[0], printed[1], ("slip-times-three", true)];
        assert_eq!(of(&with_cause, None), Verdict::AsPrintedOnly);
        assert_eq!(
            of(&[("best-of-readings", true)], None),
            Verdict::NotReproduced
        );
        assert_eq!(of(&[("exact", false)], Some(false)), Verdict::NotReproduced);
        assert_eq!(of(&[], None), Verdict::NotReproduced);
    }
}
