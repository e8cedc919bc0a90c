//! Parts of the paper, by which claims are counted.

use crate::paper::claim_id::ClaimId;

/// A part of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PaperPart {
    /// Model 1: Eqs. (1)–(13), (16).
    Sect2,
    /// Fig. 4 and Sect. 3's account of it.
    Fig4,
    /// The Hénon step: abstract and Sect. 3.
    Henon,
    /// Model 2: Eqs. (17)–(24), Figs. 6, 7 and Sect. 4.1.
    Fig7,
    /// Fig. 8 and Sect. 4.2.
    Fig8,
    /// Fig. 10.
    Fig10,
    /// Fig. 11.
    Fig11,
    /// Fig. 12.
    Fig12,
    /// What Sects. 5.2 and 6 say.
    Sect5,
}

impl PaperPart {
    /// All of them, in the order of the paper.
    pub const ALL: [PaperPart; 9] = [
        PaperPart::Sect2,
        PaperPart::Fig4,
        PaperPart::Henon,
        PaperPart::Fig7,
        PaperPart::Fig8,
        PaperPart::Fig10,
        PaperPart::Fig11,
        PaperPart::Fig12,
        PaperPart::Sect5,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            PaperPart::Sect2 => "Sect. 2, Eqs. (8)–(16)",
            PaperPart::Fig4 => "Fig. 4",
            PaperPart::Henon => "Abstract, Sect. 3: the Hénon step",
            PaperPart::Fig7 => "Sect. 4.1, Eqs. (19)–(24), Figs. 6, 7",
            PaperPart::Fig8 => "Sect. 4.2, Fig. 8",
            PaperPart::Fig10 => "Fig. 10",
            PaperPart::Fig11 => "Fig. 11",
            PaperPart::Fig12 => "Fig. 12",
            PaperPart::Sect5 => "Sects. 5.2, 6",
        }
    }

    /// The part that a claim belongs to.
    pub const fn of(id: ClaimId) -> PaperPart {
        use ClaimId::*;
        match id {
            Eq12CriticalPoints
            | Eq13CriticalMu0
            | S2BoundaryTangentPoints
            | S2DegenerateZone
            | S2ContinuousZone
            | S2Sigma
            | S2InnerPoints
            | Eq16TangentPoints => PaperPart::Sect2,
            Fig04Visibility | Fig04NoStick | Fig04Deflection => PaperPart::Fig4,
            S3ArrivalAccuracy | S3ReleaseAccuracy => PaperPart::Henon,
            Fig06FrictionLaw | Eq19Sigma | Eq22CriticalPoints | Eq23CriticalMu0
            | Fig07aTangency | Fig07bOscillation | Fig07cBranches | Eq24TangentPoints
            | S4ZoneAttracts | S4ExactLengths | S4NoStickAtZero | S4ZoneLocation => PaperPart::Fig7,
            Fig08StickLength1 | Fig08StickLength2 | Fig08StickDuration1 | Fig08StickDuration2
            | Fig08Start | Fig08TwoPeriodic | Fig08Deflections | Fig08ExitAtVisible
            | S4UntilTangent | S4LengthIsWay | S4Arcs | S4ZoneOscillates | S4FoundByAppendix => {
                PaperPart::Fig8
            }
            Fig10Lambda1 | Fig10Lambda2 | Fig10Lambda3 | Fig10Lambda4 | Fig10Class => {
                PaperPart::Fig10
            }
            Fig11Lambda1 | Fig11Lambda2 | Fig11Lambda3 | Fig11Lambda4 | Fig11Class => {
                PaperPart::Fig11
            }
            Fig12Lambda1 | Fig12Lambda2 | Fig12Lambda3 | Fig12Lambda4 | Fig12Class => {
                PaperPart::Fig12
            }
            S5ByProcedure
            | S5Kinds
            | S5ZeroExponent
            | S5TwoZeroExponents
            | S5PositiveExponent
            | S5Shapes
            | S5Samples
            | S6OscillatingBoundary => PaperPart::Sect5,
        }
    }
}
