//! What a comparison comes to: the words of the verdicts, each of which means one thing.

use std::fmt;

use super::finding::Finding;
use crate::paper::published::Kind;
use crate::paper::reading::Role;

/// What becomes of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The model as stated gives it.
    Reproduced,
    /// The model with the listed corrections gives it.
    WithCorrections,
    /// Only the paper's program or equations to the letter give it.
    AsPrintedOnly,
    /// Of a statement: a part holds.
    InKind,
    /// None of these.
    NotReproduced,
}

impl Verdict {
    /// How many there are.
    pub const COUNT: usize = 5;

    /// All of them, the best first.
    pub const ALL: [Verdict; Verdict::COUNT] = [
        Verdict::Reproduced,
        Verdict::WithCorrections,
        Verdict::AsPrintedOnly,
        Verdict::InKind,
        Verdict::NotReproduced,
    ];

    /// What the word means.
    pub const fn meaning(self) -> &'static str {
        match self {
            Verdict::Reproduced => {
                "the model as stated, solved accurately, gives it to every printed digit; a statement holds in all its parts"
            }
            Verdict::WithCorrections => {
                "the model with the corrections that are listed, solved accurately, gives it to every printed digit or in all its parts; \
                 as stated it does not"
            }
            Verdict::AsPrintedOnly => {
                "the paper's own program or equations, to the letter, give it to every printed digit or in all its parts; neither the model as \
                 stated nor a corrected one does"
            }
            Verdict::InKind => {
                "of statements and curves alone: a part holds and a part does not, and the evidence names both"
            }
            Verdict::NotReproduced => {
                "neither the model as stated, nor a corrected one, nor the program gives it"
            }
        }
    }

    /// The verdict that findings on a claim of this kind come to. Where several findings have one role, all of them must agree.
    pub fn of(kind: Kind, findings: &[Finding]) -> Verdict {
        let with = |role: Role| {
            let evidence = move |one: &&Finding| one.reading.role() == role && !one.by_construction;
            findings.iter().filter(evidence)
        };
        let all_agree = |role| with(role).next().is_some() && with(role).all(|one| one.agrees);
        let a_part_holds = || {
            let accurate = with(Role::Stated).chain(with(Role::Corrected));
            accurate.flat_map(Finding::parts).any(|holds| holds)
        };
        if all_agree(Role::Stated) {
            Verdict::Reproduced
        } else if all_agree(Role::Corrected) {
            Verdict::WithCorrections
        } else if all_agree(Role::AsPrinted) {
            Verdict::AsPrintedOnly
        } else if matches!(kind, Kind::Statement | Kind::Curve) && a_part_holds() {
            Verdict::InKind
        } else {
            Verdict::NotReproduced
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::WithCorrections => "reproduced with corrected equations",
            Verdict::AsPrintedOnly => "reproduced as printed only",
            Verdict::InKind => "in kind only",
            Verdict::NotReproduced => "not reproduced",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::rows::Part;
    use crate::paper::claim_id::ClaimId;
    use crate::paper::published::Claims;
    use crate::paper::reading::Reading::{self, *};

    fn of(id: ClaimId, findings: &[Finding]) -> Verdict {
        Verdict::of(Claims::committed().unwrap().of(id).kind, findings)
    }

    /// Findings on the first stick length, 0.4697 m.
    fn numbers(found: &[(Reading, f64)]) -> Verdict {
        let id = ClaimId::Fig08StickLength1;
        let claim = Claims::committed().unwrap().of(id);
        let findings: Vec<Finding> = found
            .iter()
            .map(|&(reading, value)| Finding::number(claim, reading, "test", value))
            .collect();
        of(id, &findings)
    }

    fn statement(found: &[(Reading, &[bool])]) -> Verdict {
        let findings: Vec<Finding> = found
            .iter()
            .map(|(reading, parts)| {
                let part = |&holds: &bool| Part {
                    what: "a part",
                    holds,
                };
                Finding::statement(*reading, "test", parts.iter().map(part).collect())
            })
            .collect();
        of(ClaimId::S4Arcs, &findings)
    }

    #[test]
    fn evidence_can_be_had_for_every_verdict() {
        let (right, wrong) = (0.46971, 0.4711);
        let cases = [
            (numbers(&[(Exact, right)]), Verdict::Reproduced),
            (
                numbers(&[(Exact, wrong), (Corrected, right)]),
                Verdict::WithCorrections,
            ),
            (
                numbers(&[(Exact, wrong), (AsPrinted, right)]),
                Verdict::AsPrintedOnly,
            ),
            (statement(&[(Exact, &[true, false])]), Verdict::InKind),
            (
                numbers(&[(Exact, wrong), (AsPrinted, wrong)]),
                Verdict::NotReproduced,
            ),
        ];
        for (found, wanted) in cases {
            assert_eq!(found, wanted);
        }
        assert_eq!(cases.map(|(_, wanted)| wanted), Verdict::ALL);
    }

    #[test]
    fn a_number_is_never_right_in_kind() {
        assert_eq!(numbers(&[(Exact, 0.4698)]), Verdict::NotReproduced);
        assert_eq!(
            numbers(&[(CorrectedEquations, 0.4697), (CorrectedData, 0.4711)]),
            Verdict::NotReproduced
        );
        assert_eq!(numbers(&[]), Verdict::NotReproduced);
        // What is shown beside decides nothing.
        assert_eq!(
            numbers(&[(SlipTimesThree, 0.4697), (BestOfReadings, 0.4697)]),
            Verdict::NotReproduced
        );
    }

    #[test]
    fn a_statement_that_holds_nowhere_is_not_reproduced() {
        assert_eq!(
            statement(&[(Exact, &[false, false])]),
            Verdict::NotReproduced
        );
        assert_eq!(
            statement(&[(Corrected, &[true]), (Corrected, &[false])]),
            Verdict::InKind
        );
    }

    #[test]
    fn what_could_not_have_come_out_otherwise_is_no_evidence() {
        let part = Part {
            what: "a part",
            holds: true,
        };
        let vacuous = Finding::statement(AsPrinted, "test", vec![part]).by_construction();
        assert_eq!(of(ClaimId::S4Arcs, &[vacuous]), Verdict::NotReproduced);
    }
}
