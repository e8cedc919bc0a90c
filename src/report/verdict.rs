//! The verdicts, and the corrections of the paper's equations on which a verdict with corrections
//! rests.

use std::fmt;

use super::exponent::OverSettings;
use super::finding::Finding;
use crate::paper::published::{Claim, ClaimKind};
use crate::paper::reading::Role;
use crate::text::described;

described! {
    /// The verdict on a claim.
    Verdict: [&'static str; 3] as described {
        /// The model as stated gives it.
        Reproduced = [
            "reproduced",
            "reproduced",
            "the model as stated, solved accurately, gives it to every printed digit; a statement \
                holds in all its parts",
        ],
        /// The model with the listed corrections gives it.
        WithCorrections = [
            "reproduced with corrected equations",
            "corrected",
            "the model with the corrections that are listed, solved accurately, gives it to every \
            printed digit or in all its parts; as stated it does not",
        ],
        /// Reproduced, with an assumption that the paper does not make.
        UnderAssumption = [
            "reproduced under an added assumption",
            "assumed",
            "the corrected model gives it only if the normal force is never negative, which the \
            paper does not say; among the readings with corrected signs this one was chosen \
            because it gives the caption of Fig. 12, so that its class is no evidence for it",
        ],
        /// Only the paper's program or equations, taken literally, give it.
        AsPrintedOnly = [
            "reproduced as printed only",
            "printed",
            "the paper's own program or equations, taken literally, give it to every printed digit \
            or in all its parts; neither the model as stated nor a corrected one does",
        ],
        /// A part of the statement holds.
        InPart = [
            "in part only",
            "part",
            "for statements and curves only: some of its parts hold and others fail; the failing \
            ones are named",
        ],
        /// None of these.
        NotReproduced = [
            "not reproduced",
            "missed",
            "neither the model as stated, nor a corrected one, nor the program gives it; for an \
            exponent, no setting of the estimator that was tried does",
        ],
        /// The value depends on quantities that the paper does not state.
        Undeterminable = [
            "undeterminable",
            "open",
            "the paper does not state what the value depends on; the settings tried move it by \
            more than its printed digits and their range holds these, or none identifies it and \
            the published sign is that of the equations; a value outside the range is not \
            reproduced",
        ],
        /// Holds by definition; not counted.
        Identity = [
            "identity",
            "identity",
            "it follows from other claims or from a definition, so that it is no evidence: listed \
                and not counted",
        ],
    }
}

impl Verdict {
    /// The verdicts that are counted, in the order of the tables: all but an identity.
    pub const COUNTED: [Verdict; 7] = {
        let [a, b, c, d, e, f, g, _] = Verdict::ALL;
        [a, b, c, d, e, f, g]
    };

    /// The meaning of the word.
    pub fn meaning(self) -> &'static str {
        self.described()[2]
    }

    /// Name in the style sheet of the page.
    pub fn key(self) -> &'static str {
        self.described()[1]
    }

    /// The verdict from findings on a claim of this kind, and the corrections of the corrected
    /// ones. If several findings have one role, all must agree. What the settings of an estimator
    /// say of one finding comes first.
    pub fn of(kind: ClaimKind, findings: &[Finding], corrections: &[Correction]) -> Verdict {
        let with = |role: Role| {
            let evidence = move |one: &&Finding| one.reading.role() == role && one.is_evidence();
            findings.iter().filter(evidence)
        };
        let all_agree = |role| with(role).next().is_some() && with(role).all(|one| one.agrees);
        let says = |what| findings.iter().any(|one| one.settings == what);
        let a_part_holds = || {
            let accurate = with(Role::Stated).chain(with(Role::Corrected));
            accurate.flat_map(Finding::parts).any(|holds| holds)
        };
        if kind == ClaimKind::Identity {
            Verdict::Identity
        } else if says(OverSettings::Excluded) {
            Verdict::NotReproduced
        } else if says(OverSettings::Undetermined) {
            Verdict::Undeterminable
        } else if all_agree(Role::Stated) {
            Verdict::Reproduced
        } else if all_agree(Role::Corrected) {
            match corrections.contains(&Correction::ClippedNormalForce) {
                true => Verdict::UnderAssumption,
                false => Verdict::WithCorrections,
            }
        } else if all_agree(Role::AsPrinted) {
            Verdict::AsPrintedOnly
        } else if matches!(kind, ClaimKind::Statement | ClaimKind::Curve) && a_part_holds() {
            Verdict::InPart
        } else {
            Verdict::NotReproduced
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.described()[0])
    }
}

described! {
    /// A correction. The errata show each by a computation.
    Correction: &'static str as pub description {
        /// Signs of x3 and T in the second row of Eq. (27).
        BracketSigns = "Eq. (27): +x3 and +T(v) in the bracket of the second row (printed −x3, −T)",
        /// μ0 counted once in Eq. (28).
        FrictionAmplitude = "Eq. (28): friction is mu0 − xi6 x3 − xi7 x4 (printed mu0 times that \
            with 1 for mu0)",
        /// Meaning of the nine numbers of the captions.
        CaptionOrder = "captions: the numbers are xi1 … xi5, mu0, xi6, delta, vp and xi7 = 0 \
            (printed xi1 … xi7, delta, vp)",
        /// The contact cannot pull.
        ClippedNormalForce = "the normal force is never negative (not said in the paper: contact \
            can only push)",
        /// Sign of the Hénon step from x2 > vp.
        StepFromAbove = "Sect. 3: the Hénon step is vp − x2 from either side (printed x2 − vp from \
            one side; by the listing, from above)",
        /// dt/dx1 in Eq. (15).
        ReleaseSlope = "Eq. (15): dt/dx1 is 1/x2 (printed 1/f2)",
        /// The step of Eq. (15).
        ReleaseStep = "Sect. 3: the step at a tangent point is h2 = x1,0 − x1^(i), from the state \
            before the step that is repeated (printed x1,0 − x1^(i+1))",
    }
}

impl Correction {
    /// Short name: C1, C2, …
    pub fn label(self) -> String {
        format!("C{}", self as usize + 1)
    }

    /// The corrections of a claim's corrected readings.
    pub fn of(claim: &Claim) -> impl Iterator<Item = Correction> {
        let carries = |one: &Correction| claim.corrections.split(' ').any(|it| it == one.label());
        Correction::ALL.into_iter().filter(carries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::rows::Row;
    use crate::paper::claim_id::ClaimId;
    use crate::paper::published::Claims;
    use crate::paper::reading::Reading::{self, *};

    fn of(id: ClaimId, findings: &[Finding]) -> Verdict {
        Verdict::of(Claims::committed().unwrap().of(id).kind, findings, &[])
    }

    const LENGTH: ClaimId = ClaimId::Fig08StickLength1;

    /// The finding of a reading for the first stick length, 0.4697 m.
    fn number(reading: Reading, value: f64) -> Finding {
        let claims = Claims::committed().unwrap();
        let row = Row::number(LENGTH, reading, value, "m");
        Finding::of_rows(claims, claims.of(LENGTH), "test", &[row]).remove(0)
    }

    /// A value that depends on settings, beside one that does not.
    fn over(settings: OverSettings, value: f64) -> Verdict {
        let moved = Finding {
            settings,
            ..number(CorrectedData, value)
        };
        of(LENGTH, &[number(CorrectedEquations, value), moved])
    }

    fn numbers(found: &[(Reading, f64)]) -> Verdict {
        let findings = found.iter().map(|&(reading, value)| number(reading, value));
        of(LENGTH, &findings.collect::<Vec<_>>())
    }

    fn statement(found: &[(Reading, &[bool])]) -> Verdict {
        let findings: Vec<Finding> = found
            .iter()
            .map(|(reading, parts)| {
                Finding::statement(*reading, parts.iter().map(|holds| ("a part", *holds)))
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
                Verdict::of(
                    ClaimKind::Value,
                    &[number(Corrected, right)],
                    &[Correction::ClippedNormalForce],
                ),
                Verdict::UnderAssumption,
            ),
            (
                numbers(&[(Exact, wrong), (AsPrinted, right)]),
                Verdict::AsPrintedOnly,
            ),
            (statement(&[(Exact, &[true, false])]), Verdict::InPart),
            (
                numbers(&[(Exact, wrong), (AsPrinted, wrong)]),
                Verdict::NotReproduced,
            ),
            (
                over(OverSettings::Undetermined, right),
                Verdict::Undeterminable,
            ),
        ];
        for (found, wanted) in cases {
            assert_eq!(found, wanted);
        }
        assert_eq!(cases.map(|(_, wanted)| wanted), Verdict::COUNTED);
        // A setting that gives the digits decides as little as one that does not.
        for (settings, verdict) in [
            (OverSettings::Undetermined, Verdict::Undeterminable),
            (OverSettings::Excluded, Verdict::NotReproduced),
        ] {
            assert_eq!(
                [right, wrong].map(|value| over(settings, value)),
                [verdict; 2]
            );
        }
    }

    #[test]
    fn an_annihilated_direction_is_no_evidence_against_an_estimate() {
        let (right, none) = (0.4697, f64::NEG_INFINITY);
        assert_eq!(
            numbers(&[(CorrectedEquations, none), (CorrectedData, right)]),
            Verdict::WithCorrections
        );
        assert_eq!(
            numbers(&[(CorrectedEquations, none)]),
            Verdict::NotReproduced
        );
    }

    #[test]
    fn a_number_is_never_right_in_part() {
        assert_eq!(numbers(&[(Exact, 0.4698)]), Verdict::NotReproduced);
        assert_eq!(
            numbers(&[(CorrectedEquations, 0.4697), (CorrectedData, 0.4711)]),
            Verdict::NotReproduced
        );
        assert_eq!(numbers(&[]), Verdict::NotReproduced);
        // A reading shown beside decides nothing.
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
            Verdict::InPart
        );
    }

    #[test]
    fn an_identity_is_listed_whatever_was_found() {
        for holds in [true, false] {
            let found = [Finding::statement(Exact, [("a part", holds)])];
            assert_eq!(of(ClaimId::Fig06FrictionLaw, &found), Verdict::Identity);
        }
        assert!(!Verdict::COUNTED.contains(&Verdict::Identity));
    }

    #[test]
    fn what_could_not_have_come_out_otherwise_is_no_evidence() {
        let vacuous = Finding::statement(AsPrinted, [("a part", true)]).by_construction();
        assert_eq!(of(ClaimId::S4Arcs, &[vacuous]), Verdict::NotReproduced);
    }
}
