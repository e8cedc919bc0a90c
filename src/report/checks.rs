//! How each claim is judged, in words.

use crate::paper::claim_id::ClaimId;

/// The check behind a claim.
pub const fn check(id: ClaimId) -> &'static str {
    use ClaimId::*;
    match id {
        Eq12CriticalPoints => {
            "zeros of the slope of σ, found by a root search, against the published set"
        }
        Eq13CriticalMu0 => {
            "the friction that makes σ zero at these points, against the published set"
        }
        S2BoundaryTangentPoints => {
            "ends of the stick zone at the critical mu0, against the published pair"
        }
        S2DegenerateZone => "zeros of σ at mu0 = 0 are counted, and the intervals where σ < 0",
        S2ContinuousZone => "the intervals where σ < 0 at mu0 = 2/(3√3) are counted",
        S2Sigma => {
            "the product of the solver's normal components on Σ over a grid of positions and mu0 against the published polynomial; the \
             decision stick or cross there against the sign of σ"
        }
        S2InnerPoints => {
            "a body put on the belt left of the inner points at the critical mu0 is integrated until it slips"
        }
        Eq16TangentPoints => "roots of the cubic by Newton steps against the published set",
        Eq24TangentPoints => {
            "where stick begins and ends along Σ of model 2 at rest, bisected, against the published set"
        }
        Fig04Visibility => {
            "second Lie derivative of the boundary function along the tangent field, by dual numbers, at each of the six points"
        }
        Fig04NoStick => {
            "stick phases of the limit cycle are counted over a whole period, and the figure's orbits that stick on their way to it"
        }
        Fig04Deflection => {
            "the tangent point nearest to the cycle's left crossing of Σ, and the slopes before and after it"
        }
        S3ReleaseAccuracy => {
            "release times by a step of Eq. (15) against exact ones on the system of Sect. 3, whose tangent points are at rest: at the printed step \
             off by less than half a unit of the last printed digit, at worst over the part of the step that is left; with points that move beside"
        }
        Fig06FrictionLaw => "1/(1 + δ|v|) decreases for every δ > 0: nothing is left to test",
        Eq19Sigma => {
            "the product of the solver's normal components of model 2 over a grid of z and of parameters against the published polynomial, \
             its slope by dual numbers against Eq. (21)"
        }
        Eq22CriticalPoints => {
            "zeros of the slope of σ, found by a root search for k1 = 3, k2 = 12, against the printed formulas"
        }
        Eq23CriticalMu0 => "the spring's force at these points against the printed formulas",
        Fig07aTangency => "the sign of σ on both sides of each of its double zeros",
        Fig07bOscillation => {
            "model 2 is integrated from points of Σ just inside and just outside each of the six drawn curves: stick on the one side, slip on \
             the other"
        }
        Fig07cBranches => {
            "tangent points are counted at mu0 = 0, below, at and above the critical value"
        }
        S4ZoneAttracts => {
            "stick or not on a grid of the zone; the motions that a set of starts leads to, for values of mu0 below the critical one, most of which must lead to cycles; at that value beside"
        }
        S4NoStickAtZero => {
            "model 2 is integrated without friction from a set of starts: stick phases, σ and the jump of the slope at every crossing"
        }
        S4ZoneLocation => "ends of the stick zones with each parameter a little larger",
        S4FoundByAppendix => {
            "the program of the Appendix is run as printed, and with all its defects mended"
        }
        S5Samples => {
            "the published numbers give the time between two states: nothing is left to test"
        }
        S5ByProcedure => {
            "RK4 with Hénon's step onto Σ on the corrected equations, and on those as printed; the class of each motion, loops counted, against the caption"
        }
        S5Kinds => {
            "the class of each motion, by section and exponents together; loops of a closed orbit left out"
        }
        S6OscillatingBoundary => {
            "how far Σ, and the stick zone in it, travel over a forcing period"
        }
        S4ExactLengths => {
            "the release predicted from the point of entry and the set (24) against the located one, for every stick phase from a grid of \
             starts"
        }
        S4UntilTangent => {
            "for the stick phases of Fig. 8's motion: the speed in them, and whether the release is the first instant at which a tangent point \
             meets the body; for those of the stated model from a grid of starts beside"
        }
        S4LengthIsWay => {
            "durations less lengths over vp, as published, of the program and of the stated model, against the rounding of print"
        }
        Fig08Start => "the program and the stated model are run from the third tangent point",
        S4Arcs => "the order of the slip phases of the periodic orbit, and their velocities",
        S4ZoneOscillates => {
            "ends of the stick zone on Σ, bisected at times of a forcing period, against z_k + A sin(ωt); their travel along x1 and x2"
        }
        Fig08StickLength1 | Fig08StickLength2 | Fig08StickDuration1 | Fig08StickDuration2 => {
            "the two longest stick phases of one pattern of the settled motion; digits by rounding"
        }
        Fig08TwoPeriodic => {
            "the settled motion sticks, and repeats after two forcing periods and not after one; of the stated model, whether any of 2501 \
             starts leads to such a motion"
        }
        Fig08Deflections => {
            "distinct points of the closed trajectory's left half at which Σ is crossed without stick"
        }
        Fig08ExitAtVisible => {
            "at every release the distance from the tangent points of (24), moved, and the second derivative of the boundary function along the \
             field that takes over, time counted; the points that Fig. 4's caption calls visible beside"
        }
        Fig10Lambda1 | Fig10Lambda2 | Fig10Lambda3 | Fig10Lambda4 | Fig11Lambda1 | Fig11Lambda2
        | Fig11Lambda3 | Fig11Lambda4 | Fig12Lambda1 | Fig12Lambda2 | Fig12Lambda3
        | Fig12Lambda4 => {
            "the exponent from the corrected equations and from their sampled motion; both must round to the published digits; undeterminable \
             where the listed settings of the estimator move the second by more than a unit of the last of these"
        }
        Fig10Class | Fig11Class | Fig12Class => {
            "section points from t = 3000 to 12000 that differ are counted, and the exponents from the equations, with their errors, tell \
             zero from positive; loops count"
        }
        S5ZeroExponent => {
            "exponents from the equations that are zero within their errors are counted in each figure; what the sampled motion gives beside"
        }
        S5TwoZeroExponents => {
            "exponents that are zero within their errors are counted, from the equations and from the sampled motion; both must bear it out"
        }
        S5PositiveExponent => {
            "the first exponent is above zero by several standard errors, from the equations and from the sampled motion; both must bear it out"
        }
        S5Shapes => {
            "in each figure the section must close where the exponents tell a closed orbit, and nowhere else"
        }
        S3ArrivalAccuracy => {
            "arrival times on Σ by RK4 and one step of Eq. (14), from both sides, against exact ones: at the printed step off by less than half a \
             unit of the last printed digit, at worst over the part of the step that is left"
        }
    }
}
