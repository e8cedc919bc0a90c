//! Evidence for the statements that no table of a figure decides.
//!
//! For each claim, one function computes, judges the statement's parts by the results, and puts
//! these into a sentence. If the same results show a misprint, it returns that too.

mod belt;
mod beside_curves;
mod fig08;
mod loops;
mod motions;
mod procedure;
mod sigma;
mod stick_phases;
mod sticks;
mod without_friction;
mod zone_attraction;
mod zones;

pub use loops::Loops;
pub use motions::{ByProcedure, Shape, Shapes};
pub use procedure::LowerEnds;

use super::errata::Proof;
use super::figures::Computed;
use super::finding::Finding;
use crate::figures::block_and_bracket::Data;
use crate::figures::rows::Row;
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defects, Setup};
use crate::paper::models::{Caption, ForcedOscillator};
use crate::paper::published::Claims;
use crate::paper::reading::Reading;
use crate::paper::slip_times_three::{InjectedDefects, settled};
use stick_phases::GridPhases;
use stickslip::Error;

/// The evidence for all such statements.
pub struct Statements {
    findings: Vec<(ClaimId, Vec<Finding>)>,
    /// The ends of model 2's stick zones at rest (m), ascending: Eq. (24).
    pub at_rest: Vec<f64>,
    /// Results of the procedure of Sect. 3 for Figs. 10–12.
    pub by_procedure: ByProcedure,
    /// Kinds of motion of Figs. 10, 11 and 12.
    pub shapes: Shapes,
    /// Loops of Fig. 10's motion.
    pub loops: Loops,
    /// Releases that Sect. 3 does not test.
    pub lower_ends: LowerEnds,
    /// Misprints of Sect. 4.2 that the same numbers show, in the order of the report.
    pub errata: Vec<Proof>,
}

impl Statements {
    /// Computes all evidence.
    ///
    /// # Errors
    /// The solver's.
    pub fn compute(claims: &Claims, computed: &Computed) -> Result<Statements, Error> {
        use ClaimId::*;
        let ((zone_attracts, grid), (by_procedure, loops)) = rayon::join(
            || rayon::join(zone_attraction::attracts, || GridPhases::compute(claims)),
            || rayon::join(ByProcedure::compute, Loops::compute),
        );
        let (grid, by_procedure) = (grid?, by_procedure?);
        let model = ForcedOscillator::default();
        let zone = zones::ZoneMotion::of(&model, &grid.set);
        let shapes = Shapes(computed.bracket.each_ref().map(Shape::of));
        let (arcs, regions) = fig08::arcs()?;
        let (start, start_erratum) = fig08::start(claims)?;
        let durations = sticks::durations(&grid, claims.published_stick_numbers());
        let drawn = &computed.fig07.oscillation;
        let by_appendix = fig08::found_by_appendix(claims, Defects::AS_PRINTED);
        let findings = vec![
            (S2Sigma, sigma::of_belt()),
            (Eq19Sigma, sigma::of_forced()),
            (S2InnerPoints, belt::inner_points()?),
            (Fig04NoStick, belt::no_stick(&computed.fig04.cycle)?),
            (S3Order, procedure::order_of_steps()),
            (
                S4ListingParameters,
                procedure::listing_parameters(&Setup::default(), &model),
            ),
            (S5OneRig, procedure::one_rig(&Caption::ALL)),
            (Fig12Ratio, ratio(claims, &computed.bracket[2])),
            (
                Fig07bOscillation,
                beside_curves::beside_curves(&model, drawn)?,
            ),
            (S4ZoneAttracts, zone_attracts?),
            (S4NoStickAtZero, without_friction::no_stick_at_zero()?),
            (S4ZoneLocation, zones::location(&model)),
            (S4ExactLengths, sticks::exact_lengths(&grid)),
            (
                S4UntilTangent,
                sticks::until_tangent(&grid, settled_sticks()?),
            ),
            (Fig08ExitAtVisible, sticks::exit_at_visible(&grid)),
            (S4Arcs, arcs),
            (Fig08Start, start),
            (S4FoundByAppendix, by_appendix),
            (S4ZoneOscillates, zone.zone()),
            (S6OscillatingBoundary, zone.boundary()),
            (S5ByProcedure, by_procedure.findings()),
            (S5Shapes, shapes.findings()),
            (S5Kinds, shapes.kinds()),
        ];
        Ok(Statements {
            findings,
            by_procedure,
            shapes,
            loops: loops?,
            lower_ends: sticks::lower_ends(&grid),
            errata: vec![durations, start_erratum, regions, zone.direction()],
            at_rest: zone.at_rest,
        })
    }

    /// Findings on a claim; empty if a table of a figure decides it.
    pub fn of(&self, id: ClaimId) -> &[Finding] {
        let entry = self.findings.iter().find(|(claim, _)| *claim == id);
        entry.map_or(&[], |(_, findings)| findings)
    }
}

/// `fig12.lambda_ratio`: λ1 : λ3 of Fig. 12, which does not depend on the unit of time.
fn ratio(claims: &Claims, data: &Data) -> Vec<Finding> {
    let id = ClaimId::Fig12Ratio;
    let equations = &data.exact.spectrum.exponents;
    let sampled = &data.from_data.exponents;
    let rows = [
        (
            Reading::CorrectedEquations,
            equations[0].value() / equations[2].value(),
        ),
        (Reading::CorrectedData, sampled[0].value / sampled[2].value),
    ];
    let rows = rows.map(|(reading, value)| Row::number(id, reading, value, "1"));
    Finding::of_rows(claims, claims.of(id), "report", &rows)
}

/// Number of stick phases of the motion on which the stated model settles from the start of Fig. 8.
fn settled_sticks() -> Result<usize, Error> {
    Ok(settled(InjectedDefects::NONE)?.pattern_sticks().count())
}
