//! Identifiers of the published quantities and statements: one for each row of `data/claims.csv`.

use std::fmt;

use crate::text::described;

/// Generates the enum, the list of all variants and their names from one table.
macro_rules! claim_ids {
    ($($variant:ident = $name:literal,)*) => {
        described! {
            /// A row of `data/claims.csv`. The variants stand in the order of its rows.
            ClaimId: &'static str as pub name {
                $(#[doc = concat!("`", $name, "`")] $variant = $name,)*
            }
        }
    };
}

claim_ids! {
    Eq12CriticalPoints = "eq12.critical_points",
    Eq13CriticalMu0 = "eq13.mu0_critical",
    S2Sigma = "s2.sigma",
    S2DegenerateZone = "s2.degenerate_zone",
    S2ContinuousZone = "s2.continuous_zone",
    S2BoundaryTangentPoints = "s2.boundary_tangent_points",
    S2InnerPoints = "s2.inner_points",
    Eq16TangentPoints = "eq16.tangent_points",
    Fig04Visibility = "fig04.visibility",
    Fig04NoStick = "fig04.no_stick",
    Fig04Deflection = "fig04.deflection",
    S3ArrivalAccuracy = "s3.arrival_accuracy",
    S3ReleaseAccuracy = "s3.release_accuracy",
    S3Order = "s3.order",
    GoodEstimations = "abstract.good_estimations",
    Fig06FrictionLaw = "fig06.friction_law",
    Eq19Sigma = "eq19.sigma",
    Eq22CriticalPoints = "eq22.critical_points",
    Eq23CriticalMu0 = "eq23.mu0_critical",
    Fig07aTangency = "fig07a.tangency",
    S4NoStickAtZero = "s4.no_stick_at_zero",
    S4ZoneAttracts = "s4.zone_attracts",
    S4ZoneLocation = "s4.zone_location",
    Fig07bOscillation = "fig07b.oscillation",
    Fig07cBranches = "fig07c.branches",
    Eq24TangentPoints = "eq24.tangent_points",
    S4ExactLengths = "s4.exact_lengths",
    S4ListingParameters = "s4.listing_parameters",
    Fig08StickModes = "fig08.stick_modes",
    Fig08StickLength1 = "fig08.stick_length.1",
    Fig08StickLength2 = "fig08.stick_length.2",
    Fig08StickDuration1 = "fig08.stick_duration.1",
    Fig08StickDuration2 = "fig08.stick_duration.2",
    Fig08Start = "fig08.start",
    Fig08TwoPeriodic = "fig08.two_periodic",
    Fig08Deflections = "fig08.deflections",
    Fig08ExitAtVisible = "fig08.exit_at_visible",
    S4UntilTangent = "s4.until_tangent",
    S4Arcs = "s4.arcs",
    S4ZoneOscillates = "s4.zone_oscillates",
    S4FoundByAppendix = "s4.found_by_appendix",
    S5ByProcedure = "s5.by_procedure",
    S5Samples = "s5.samples",
    S5Kinds = "s5.kinds",
    S5ZeroExponent = "s5.zero_exponent",
    S5TwoZeroExponents = "s5.two_zero_exponents",
    S5PositiveExponent = "s5.positive_exponent",
    S5Shapes = "s5.shapes",
    S5AllNegative = "s5.all_negative",
    S5Reconstruction = "s5.reconstruction",
    S5LargeEnough = "s5.large_enough",
    S5OneRig = "s5.one_rig",
    Fig10Lambda1 = "fig10.lambda.1",
    Fig10Lambda2 = "fig10.lambda.2",
    Fig10Lambda3 = "fig10.lambda.3",
    Fig10Lambda4 = "fig10.lambda.4",
    Fig10Class = "fig10.class",
    Fig11Lambda1 = "fig11.lambda.1",
    Fig11Lambda2 = "fig11.lambda.2",
    Fig11Lambda3 = "fig11.lambda.3",
    Fig11Lambda4 = "fig11.lambda.4",
    Fig11Class = "fig11.class",
    Fig12Lambda1 = "fig12.lambda.1",
    Fig12Lambda2 = "fig12.lambda.2",
    Fig12Lambda3 = "fig12.lambda.3",
    Fig12Lambda4 = "fig12.lambda.4",
    Fig12Class = "fig12.class",
    Fig12Ratio = "fig12.lambda_ratio",
    S6OscillatingBoundary = "s6.oscillating_boundary",
}

impl ClaimId {
    /// The claim of this name.
    pub fn named(name: &str) -> Option<ClaimId> {
        ClaimId::ALL.into_iter().find(|id| id.name() == name)
    }

    /// The four numbers of Sect. 4.2: lengths of the stick phases (m), then their durations (s).
    pub const STICK_NUMBERS: [ClaimId; 4] = [
        ClaimId::Fig08StickLength1,
        ClaimId::Fig08StickLength2,
        ClaimId::Fig08StickDuration1,
        ClaimId::Fig08StickDuration2,
    ];

    /// Figure and index, from 0, of a published Lyapunov exponent.
    pub fn exponent(self) -> Option<(SpectrumFigure, usize)> {
        SpectrumFigure::ALL.into_iter().find_map(|figure| {
            let k = figure.exponents().iter().position(|id| *id == self)?;
            Some((figure, k))
        })
    }
}

impl fmt::Display for ClaimId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

described! {
    /// A figure that publishes a spectrum of Lyapunov exponents. It is described by the name of its
    /// program and the first of its five rows in the table of claims. Those are four exponents and
    /// the class of its motion.
    SpectrumFigure: (&'static str, ClaimId) as described {
        /// Fig. 10.
        Fig10 = ("fig10", ClaimId::Fig10Lambda1),
        /// Fig. 11.
        Fig11 = ("fig11", ClaimId::Fig11Lambda1),
        /// Fig. 12.
        Fig12 = ("fig12", ClaimId::Fig12Lambda1),
    }
}

impl SpectrumFigure {
    /// Name of the program and of its files.
    pub const fn name(self) -> &'static str {
        self.described().0
    }

    /// Exponents, λ1 first.
    pub fn exponents(self) -> [ClaimId; 4] {
        std::array::from_fn(|k| self.row(k))
    }

    /// The class of its motion.
    pub fn class(self) -> ClaimId {
        self.row(4)
    }

    fn row(self, index: usize) -> ClaimId {
        ClaimId::ALL[self.described().1 as usize + index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_a_figure_are_its_own() {
        for figure in SpectrumFigure::ALL {
            let name = figure.name();
            assert_eq!(figure.class().name(), format!("{name}.class"));
            for (k, id) in (1..).zip(figure.exponents()) {
                assert_eq!(id.name(), format!("{name}.lambda.{k}"));
            }
        }
    }
}
