//! Everything about one claim.

use super::correction::Correction;
use super::digits::Agreement;
use super::finding::Finding;
use super::remark::Remark;
use super::verdict::Verdict;
use crate::paper::published::{Claim, Digits};
use crate::paper::reading::{Reading, Role};

/// Everything about one claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The claim.
    pub claim: Claim,
    /// How it is judged, in words.
    pub check: &'static str,
    /// What the readings give.
    pub findings: Vec<Finding>,
    /// The verdict: it follows from kind and findings alone.
    pub verdict: Verdict,
    /// What was corrected, for [`Verdict::WithCorrections`] and wherever a corrected reading was judged.
    pub corrections: Vec<Correction>,
    /// Of a Lyapunov exponent: its sign, and how far the estimator moves it.
    pub remark: Option<Remark>,
    /// What else was computed, line by line.
    pub further: Vec<String>,
}

impl Entry {
    /// The findings with a role.
    pub fn with(&self, role: Role) -> impl Iterator<Item = &Finding> {
        self.findings
            .iter()
            .filter(move |one| one.reading.role() == role)
    }

    /// The first finding of a reading.
    pub fn reading(&self, reading: Reading) -> Option<&Finding> {
        self.findings.iter().find(|one| one.reading == reading)
    }

    /// The most digits in agreement of any reading with a role.
    pub fn digits(&self, role: Role) -> Option<Agreement> {
        self.with(role)
            .filter_map(|one| one.digits)
            .max_by_key(|digits| digits.agreeing)
    }

    /// What one reading gives, in a line.
    pub fn line(&self, finding: &Finding) -> String {
        finding.line(match self.claim.digits {
            Digits::Decimals(decimals) => decimals + 1,
            Digits::Exact | Digits::None => 6,
        })
    }

    /// The evidence, line by line: how it is judged, what each reading gives, what else was
    /// computed.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("check: {}", self.check)];
        let findings = self.findings.iter();
        lines.extend(findings.map(|one| format!("{}, {}", one.reading, self.line(one))));
        lines.extend(self.further.iter().cloned());
        lines
    }

    /// Whether its motion or number is made by the paper's program alone, so that a cause is due.
    pub fn asks_for_cause(&self) -> bool {
        self.verdict == Verdict::AsPrintedOnly
    }
}
