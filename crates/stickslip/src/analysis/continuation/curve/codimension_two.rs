//! Names of bifurcations of codimension two, and the functions that vanish there.

use std::fmt;

use nalgebra::Complex;

use super::super::CycleBifurcation;
use super::super::both_ways::SpecialOnCurve;
use super::CurveKind;
use crate::analysis::cycle::SequenceBifurcation;
use crate::dynamics::Vector;

/// A bifurcation of codimension two, at an orbit on a curve in two parameters (Kuznetsov 2004, Ch.
/// 9; Colombo & Dercole 2010 for those with a change of the phases).
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CurveBifurcation {
    /// A cusp: two folds meet, and both parameters turn back along the curve.
    Cusp,
    /// A strong resonance 1:n, with n from 1 to 4: a pair of multipliers is `exp(±2πi/n)`. At 1:1
    /// and 1:2 it is a double multiplier, and a Neimark–Sacker curve ends on one of folds or flips.
    Resonance(u8),
    /// Multipliers are 1 and −1.
    FoldFlip,
    /// A multiplier is 1, and a pair is on the unit circle.
    FoldNeimarkSacker,
    /// A multiplier is −1, and a pair is on the unit circle.
    FlipNeimarkSacker,
    /// A generalized flip: the flip changes between super- and subcritical, and a curve of folds of
    /// the orbits of twice the period begins.
    GeneralizedFlip,
    /// A Chenciner point: the Neimark–Sacker bifurcation changes between super- and subcritical.
    Chenciner,
    /// A multiplier is 1 at a change of the phases.
    FoldAtChange(SequenceBifurcation),
    /// A multiplier is −1 at a change of the phases.
    FlipAtChange(SequenceBifurcation),
    /// A pair of multipliers is on the unit circle at a change of the phases.
    NeimarkSackerAtChange(SequenceBifurcation),
    /// The phases change at the end of a branch.
    EndAtChange(SequenceBifurcation),
    /// Two changes of the phases at once, the curve's own first.
    TwoChanges([SequenceBifurcation; 2]),
    /// A graze becomes an inflection: the rate and the second derivative of the boundary's function
    /// along the orbit vanish at once. A curve of grazes ends.
    CubicTangency,
    /// A bifurcation of the orbit of half the period, which both halves have become.
    OfHalf(Box<CurveBifurcation>),
}

impl fmt::Display for CurveBifurcation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CurveBifurcation::Cusp => f.write_str("cusp"),
            CurveBifurcation::Resonance(order) => write!(f, "1:{order} resonance"),
            CurveBifurcation::FoldFlip => f.write_str("fold-flip"),
            CurveBifurcation::FoldNeimarkSacker => f.write_str("fold-Neimark-Sacker"),
            CurveBifurcation::FlipNeimarkSacker => f.write_str("flip-Neimark-Sacker"),
            CurveBifurcation::GeneralizedFlip => f.write_str("generalized flip"),
            CurveBifurcation::Chenciner => f.write_str("Chenciner"),
            CurveBifurcation::FoldAtChange(change) => write!(f, "fold at {change}"),
            CurveBifurcation::FlipAtChange(change) => write!(f, "flip at {change}"),
            CurveBifurcation::NeimarkSackerAtChange(change) => {
                write!(f, "Neimark-Sacker at {change}")
            }
            CurveBifurcation::EndAtChange(change) => write!(f, "end of a branch at {change}"),
            CurveBifurcation::TwoChanges([one, other]) => write!(f, "{one} at {other}"),
            CurveBifurcation::CubicTangency => f.write_str("cubic tangency"),
            CurveBifurcation::OfHalf(of) => write!(f, "{of} of the orbit of half the period"),
        }
    }
}

/// A special orbit on a curve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveSpecialPoint {
    /// Both parameters, as in [`super::CurvePoint::parameters`].
    pub parameters: [f64; 2],
    /// Uncertainty of each parameter, as in [`super::super::SpecialPoint::uncertainty`].
    pub uncertainties: [f64; 2],
    /// CurveKind.
    pub what: CurveBifurcation,
    /// Number of orbits in [`super::Curve::points`] before it.
    pub behind: usize,
    /// A time and a state on the orbit.
    pub t: f64,
    /// See `t`.
    pub x: Vector,
    /// Period.
    pub period: f64,
}

impl SpecialOnCurve for CurveSpecialPoint {
    type What = CurveBifurcation;

    fn known(&self) -> (&CurveBifurcation, [f64; 2], [f64; 2]) {
        (&self.what, self.parameters, self.uncertainties)
    }

    fn behind(&mut self) -> &mut usize {
        &mut self.behind
    }
}

/// A function that vanishes at special orbits of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CodimensionTwoTest {
    /// A multiplier is 1, besides what the curve demands.
    Fold,
    /// A multiplier is −1, besides what the curve demands.
    Flip,
    /// A pair is on the unit circle, besides what the curve demands.
    Torus,
    /// The pair of a Neimark–Sacker curve has this sum.
    Sum(f64),
    /// The coefficient of the normal form.
    Coefficient,
}

impl CurveKind {
    pub(super) fn of(what: &CycleBifurcation) -> Option<Self> {
        Some(match what {
            CycleBifurcation::Fold | CycleBifurcation::BranchPoint => CurveKind::Fold,
            CycleBifurcation::Flip => CurveKind::Flip,
            CycleBifurcation::NeimarkSacker { .. } => CurveKind::Torus,
            CycleBifurcation::Sequence(change) => CurveKind::Change(change.bifurcation),
            CycleBifurcation::Homoclinic { .. }
            | CycleBifurcation::TwoFold
            | CycleBifurcation::Unresolved { .. } => return None,
        })
    }

    /// The functions that are evaluated along the curve.
    pub(super) fn tests(self) -> &'static [CodimensionTwoTest] {
        match self {
            CurveKind::Fold | CurveKind::Change(_) => &[
                CodimensionTwoTest::Fold,
                CodimensionTwoTest::Flip,
                CodimensionTwoTest::Torus,
            ],
            CurveKind::Flip => &[
                CodimensionTwoTest::Fold,
                CodimensionTwoTest::Flip,
                CodimensionTwoTest::Torus,
                CodimensionTwoTest::Coefficient,
            ],
            CurveKind::Torus => &[
                CodimensionTwoTest::Fold,
                CodimensionTwoTest::Flip,
                CodimensionTwoTest::Sum(-1.0),
                CodimensionTwoTest::Sum(0.0),
                CodimensionTwoTest::Coefficient,
            ],
        }
    }

    /// The name of a zero of a function.
    pub(super) fn named(self, test: CodimensionTwoTest) -> CurveBifurcation {
        match (self, test) {
            (CurveKind::Change(change), CodimensionTwoTest::Fold) => {
                CurveBifurcation::FoldAtChange(change)
            }
            (CurveKind::Change(change), CodimensionTwoTest::Flip) => {
                CurveBifurcation::FlipAtChange(change)
            }
            (CurveKind::Change(change), _) => CurveBifurcation::NeimarkSackerAtChange(change),
            (CurveKind::Fold, CodimensionTwoTest::Fold) => CurveBifurcation::Resonance(1),
            (CurveKind::Flip, CodimensionTwoTest::Flip) => CurveBifurcation::Resonance(2),
            (CurveKind::Fold, CodimensionTwoTest::Flip)
            | (CurveKind::Flip, CodimensionTwoTest::Fold) => CurveBifurcation::FoldFlip,
            (CurveKind::Torus, CodimensionTwoTest::Fold) | (CurveKind::Fold, _) => {
                CurveBifurcation::FoldNeimarkSacker
            }
            (CurveKind::Torus, CodimensionTwoTest::Flip)
            | (CurveKind::Flip, CodimensionTwoTest::Torus | CodimensionTwoTest::Sum(_)) => {
                CurveBifurcation::FlipNeimarkSacker
            }
            (CurveKind::Flip, CodimensionTwoTest::Coefficient) => CurveBifurcation::GeneralizedFlip,
            (CurveKind::Torus, CodimensionTwoTest::Coefficient) => CurveBifurcation::Chenciner,
            (CurveKind::Torus, CodimensionTwoTest::Sum(0.0)) => CurveBifurcation::Resonance(4),
            (CurveKind::Torus, _) => CurveBifurcation::Resonance(3),
        }
    }

    /// The name of an orbit of the curve at which the phases change.
    pub(super) fn at_change(of: Option<Self>, change: SequenceBifurcation) -> CurveBifurcation {
        match of {
            Some(CurveKind::Fold) => CurveBifurcation::FoldAtChange(change),
            Some(CurveKind::Flip) => CurveBifurcation::FlipAtChange(change),
            Some(CurveKind::Torus) => CurveBifurcation::NeimarkSackerAtChange(change),
            Some(CurveKind::Change(own)) => CurveBifurcation::TwoChanges([own, change]),
            None => CurveBifurcation::EndAtChange(change),
        }
    }

    /// The name of the orbit of half the period that both halves become.
    pub(super) fn of_half(self) -> CurveBifurcation {
        let of = match self {
            CurveKind::Fold => CurveBifurcation::GeneralizedFlip,
            CurveKind::Flip => CurveBifurcation::FlipNeimarkSacker,
            CurveKind::Torus => CurveBifurcation::Resonance(2),
            CurveKind::Change(change) => CurveBifurcation::FlipAtChange(change),
        };
        CurveBifurcation::OfHalf(Box::new(of))
    }
}

/// The angle of a pair of multipliers on the unit circle with this sum.
pub(super) fn angle_of(sum: f64) -> Option<f64> {
    let cosine = 0.5 * sum;
    let square = 1.0 - cosine * cosine;
    (square >= 0.0).then(|| crate::math::atan2(square.sqrt(), cosine))
}

/// The sum of the products of all multipliers but one, less a number each: zero where a second one
/// is that number. Unlike the multipliers, it is smooth where two of them meet.
pub(in crate::analysis::continuation) fn others(multipliers: &[Complex<f64>], number: f64) -> f64 {
    let without = |k: usize| {
        let all = multipliers.iter().enumerate().filter(|(i, _)| *i != k);
        all.map(|(_, one)| one - number).product::<Complex<f64>>()
    };
    let sum: Complex<f64> = (0..multipliers.len()).map(without).sum();
    sum.re
}
