//! All evidence for the paper's statements, computed together.

use super::evidence::{
    Arcs, BesideCurves, ByProcedure, EvidenceError, ExactLengths, Exits, Followed, FoundByAppendix,
    InnerPoints, NoFriction, OscillatingBoundary, Shapes, Sigma, Start, UntilTangent, Way,
    ZoneAttracts, ZoneLocation, ZoneOscillates,
};
use super::figures::Computed;

/// What was measured for each statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Statements {
    /// `s2.sigma`
    pub sigma_of_belt: Sigma,
    /// `eq19.sigma`
    pub sigma_of_forced: Sigma,
    /// `s2.inner_points`
    pub inner_points: InnerPoints,
    /// `fig07b.oscillation`
    pub beside_curves: BesideCurves,
    /// `s4.zone_attracts`
    pub zone_attracts: ZoneAttracts,
    /// `s4.no_stick_at_zero`
    pub no_friction: NoFriction,
    /// `s4.zone_location`
    pub zone_location: ZoneLocation,
    /// `s4.exact_lengths`
    pub exact_lengths: ExactLengths,
    /// `s4.until_tangent`
    pub until_tangent: UntilTangent,
    /// `s4.arcs`
    pub arcs: Arcs,
    /// `s4.zone_oscillates`
    pub zone_oscillates: ZoneOscillates,
    /// `s4.found_by_appendix`
    pub found_by_appendix: FoundByAppendix,
    /// `fig08.exit_at_visible`
    pub exits: Exits,
    /// `fig08.start`
    pub start: Start,
    /// `s4.length_is_way`
    pub way: Way,
    /// `s5.by_procedure`
    pub by_procedure: ByProcedure,
    /// `s5.shapes` and `s5.kinds`
    pub shapes: Shapes,
    /// `s6.oscillating_boundary`
    pub oscillating_boundary: OscillatingBoundary,
}

impl Statements {
    /// Measures all.
    ///
    /// # Errors
    /// [`EvidenceError`] of the first that fails.
    pub fn compute(computed: &Computed) -> Result<Statements, EvidenceError> {
        let zone_oscillates = ZoneOscillates::compute()?;
        let ((zone_attracts, followed), by_procedure) = rayon::join(
            || rayon::join(ZoneAttracts::compute, Followed::compute),
            ByProcedure::compute,
        );
        let followed = followed?;
        let [fig10, fig11, fig12] = &computed.bracket;
        Ok(Statements {
            sigma_of_belt: Sigma::of_belt(),
            sigma_of_forced: Sigma::of_forced(),
            inner_points: InnerPoints::compute()?,
            beside_curves: BesideCurves::compute(&computed.fig07.oscillation)?,
            zone_attracts: zone_attracts?,
            no_friction: NoFriction::compute()?,
            zone_location: ZoneLocation::compute(),
            exact_lengths: ExactLengths::compute(&followed)?,
            until_tangent: UntilTangent::compute(&followed)?,
            arcs: Arcs::compute()?,
            oscillating_boundary: OscillatingBoundary::from(&zone_oscillates),
            zone_oscillates,
            found_by_appendix: FoundByAppendix::compute()?,
            exits: Exits::compute(&followed)?,
            start: Start::compute()?,
            way: Way::compute(&followed)?,
            by_procedure: by_procedure?,
            shapes: Shapes::of([fig10, fig11, fig12]),
        })
    }
}
