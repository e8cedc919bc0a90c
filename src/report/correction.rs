//! What was corrected of the paper's equations where a verdict rests on a corrected reading.

use crate::paper::published::Claim;
use crate::text::described;

described! {
    /// A correction. The errata show each by a computation.
    Correction: &'static str {
        /// Signs of x3 and T in the second row of Eq. (27).
        BracketSigns = "Eq. (27): +x3 and +T(v) in the bracket of the second row (printed −x3, −T)",
        /// μ0 counted once in Eq. (28).
        FrictionAmplitude = "Eq. (28): friction is mu0 − xi6 x3 − xi7 x4 (printed mu0 times that with 1 for mu0)",
        /// What the nine numbers of the captions are.
        CaptionOrder = "captions: the numbers are xi1 … xi5, mu0, xi6, delta, vp and xi7 = 0 (printed xi1 … xi7, delta, vp)",
        /// Contact that cannot pull.
        ClippedNormalForce = "the normal force is never negative (not said in the paper: contact can only push)",
        /// Sign of the Hénon step from x2 > vp.
        StepFromAbove = "Sect. 3: the Hénon step is vp − x2 from either side (printed x2 − vp from above)",
        /// dt/dx1 in Eq. (15).
        ReleaseSlope = "Eq. (15): dt/dx1 is 1/x2 (printed 1/f2)",
    }
}

impl Correction {
    /// Its short name: C1, C2, …
    pub fn label(self) -> String {
        format!("C{}", self as usize + 1)
    }

    /// In words.
    pub const fn description(self) -> &'static str {
        self.described()
    }

    /// Those that the corrected readings of a claim carry.
    pub fn of(claim: &Claim) -> impl Iterator<Item = Correction> {
        let carries = |one: &Correction| claim.corrections.split(' ').any(|it| it == one.label());
        Correction::ALL.into_iter().filter(carries)
    }
}
