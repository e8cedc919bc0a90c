//! The ledger: every claim of the paper, what the readings give for it, and what that comes to.

use super::accuracy::{Accuracy, AccuracyError};
use super::cause::Cause;
use super::checks::check;
use super::convergence::{self, Convergence};
use super::correction::Correction;
use super::entry::Entry;
use super::errata::{Erratum, errata};
use super::evidence::{Evidence, EvidenceError};
use super::figures::{self, Computed, signs};
use super::finding::Finding;
use super::injection::Injection;
use super::matrix::{Matrix, MatrixError, SUBSETS};
use super::remark::Remark;
use super::scan::{self, Scan};
use super::spread::{self, Spread, SpreadError};
use super::statements::Statements;
use super::verdict::Verdict;
use crate::figures::FigureError;
use crate::figures::fig08::{FOLLOWED, REACH, Shares};
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::published::{Claim, Claims, PublishedError};
use crate::paper::reading::{Reading, Role};
use crate::readings::ZERO;
use stickslip::error::Error;
use stickslip_series::Status;

/// Everything the report says.
pub struct Ledger {
    /// One entry for each claim, in the order of the table of claims.
    pub entries: Vec<Entry>,
    /// Which defects of the listing make the numbers of Fig. 8.
    pub matrix: Matrix,
    /// The listing's approach to its limit.
    pub convergence: Convergence,
    /// The two defects in the event-exact solver, together and alone.
    pub injection: Injection,
    /// What makes Fig. 8.
    pub cause: Cause,
    /// Whether the stated model has a stick–slip attractor near the printed parameters.
    pub scan: Scan,
    /// The Hénon step's order and error.
    pub accuracy: Accuracy,
    /// The estimator's spread in Figs. 10–12, and what the search over their readings found.
    pub spread: Spread,
    /// Evidence for statements.
    pub statements: Statements,
    /// The paper's misprints.
    pub errata: Vec<Erratum>,
    /// The figures' data.
    pub computed: Computed,
}

/// Why the ledger could not be made.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// A figure failed.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The solver failed.
    #[error(transparent)]
    Solver(#[from] Error),
    /// The matrix of defects failed.
    #[error(transparent)]
    Matrix(#[from] MatrixError),
    /// The accuracy could not be measured.
    #[error(transparent)]
    Accuracy(#[from] AccuracyError),
    /// Evidence for a statement or an erratum could not be computed.
    #[error(transparent)]
    Evidence(#[from] EvidenceError),
    /// The estimator's spread could not be told.
    #[error(transparent)]
    Spread(#[from] SpreadError),
    /// The table of claims is not sound.
    #[error(transparent)]
    Published(#[from] PublishedError),
}

/// Times that [`Ledger::compute`] calls `tick`.
pub const TICKS: usize =
    figures::FIGURES + SUBSETS + convergence::RUNS + scan::POINTS + spread::JOBS;

impl Ledger {
    /// Computes everything; `tick` is called [`TICKS`] times on the way, from any thread.
    ///
    /// # Errors
    /// [`LedgerError`] of the first part that fails.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Ledger, LedgerError> {
        let claims = Claims::committed()?;
        let computed = Computed::compute(tick)?;
        let matrix = Matrix::compute(tick)?;
        let injection = Injection::compute()?;
        let convergence = Convergence::compute(injection.numbers, tick)?;
        let cause = Cause::new(
            &computed.fig08.as_printed.pattern,
            Ok(injection.both.clone()),
            &convergence,
            ClaimId::FOUR.map(|id| claims.value(id)),
        );
        let lengths = [ClaimId::Fig08StickLength1, ClaimId::Fig08StickLength2];
        let scan = Scan::compute(lengths.map(|id| claims.value(id)), tick)?;
        let accuracy = Accuracy::compute()?;
        let spread = Spread::compute(tick)?;
        let statements = Statements::compute(&computed)?;
        let errata = errata(&matrix, &accuracy, &statements)?;
        let mut ledger = Ledger {
            entries: Vec::new(),
            matrix,
            convergence,
            injection,
            cause,
            scan,
            accuracy,
            spread,
            statements,
            errata,
            computed,
        };
        ledger.entries = claims
            .iter()
            .map(|claim| ledger.judged_anew(claims, claim.id))
            .collect();
        Ok(ledger)
    }

    /// How many claims are counted: all but identities.
    pub fn counted(&self) -> usize {
        self.counts().iter().map(|(_, count)| count).sum()
    }

    /// How many claims have each verdict.
    pub fn counts(&self) -> [(Verdict, usize); Verdict::COUNT] {
        Verdict::ALL.map(|verdict| {
            let with = self.entries.iter().filter(|entry| entry.verdict == verdict);
            (verdict, with.count())
        })
    }

    /// The entry of a claim.
    pub fn entry(&self, id: ClaimId) -> &Entry {
        // `compute` has made one for each, in the order of the variants.
        &self.entries[id as usize]
    }

    /// Where the starts of Fig. 8's grid end up in the stated model.
    pub fn shares(&self) -> Shares {
        self.computed.fig08.shares
    }

    /// What the same computations come to for a claim as `claims` has it: with the published table its entry, with a changed one what
    /// would be said if the paper had printed that.
    pub fn judged_anew(&self, claims: &Claims, id: ClaimId) -> Entry {
        let claim = claims.of(id);
        let mut findings: Vec<Finding> = self
            .computed
            .tables
            .iter()
            .flat_map(|table| Finding::of_rows(claims, claim, table.figure, &table.rows))
            .collect();
        findings.extend(self.statement(claim));
        let remark = id
            .exponent()
            .map(|(figure, k)| self.remark(claims.value(id), figure, k));
        if remark.is_some_and(|remark| remark.is_undetermined(claim)) {
            let estimates = |one: &&mut Finding| one.reading == Reading::CorrectedData;
            for one in findings.iter_mut().filter(estimates) {
                one.undetermined = true;
            }
        }
        let has_corrected = |one: &Finding| one.reading.role() == Role::Corrected;
        let corrections = if findings.iter().any(has_corrected) {
            self.corrections(id)
        } else {
            Vec::new()
        };
        Entry {
            verdict: Verdict::of(claim.kind, &findings),
            check: check(id),
            corrections,
            remark,
            further: self.further(claim, &findings, remark.as_ref()),
            claim: claim.clone(),
            findings,
        }
    }

    /// What the evidence says of a statement that no figure's table answers.
    fn statement(&self, claim: &Claim) -> Vec<Finding> {
        use ClaimId::*;
        let all = &self.statements;
        match claim.id {
            S2Sigma => exact(&all.sigma_of_belt),
            Eq19Sigma => exact(&all.sigma_of_forced),
            S2InnerPoints => exact(&all.inner_points),
            Fig07bOscillation => exact(&all.beside_curves),
            S4ZoneAttracts => exact(&all.zone_attracts),
            S4NoStickAtZero => exact(&all.no_friction),
            S4ZoneLocation => exact(&all.zone_location),
            S4ExactLengths => exact(&all.exact_lengths),
            S4UntilTangent => exact(&all.until_tangent),
            S4Arcs => exact(&all.arcs),
            S4ZoneOscillates => exact(&all.zone_oscillates),
            S6OscillatingBoundary => exact(&all.oscillating_boundary),
            Fig08Start => exact(&all.start),
            S4LengthIsWay => exact(&all.way),
            S5ByProcedure => beside_printed(Reading::Corrected, &all.by_procedure),
            S5Shapes => vec![evidence(Reading::CorrectedEquations, &all.shapes)],
            S5Kinds => {
                let kinds = all.shapes.kinds();
                vec![Finding::statement(Reading::Corrected, REPORT, kinds)]
            }
            S4FoundByAppendix => {
                // The claim is the first part; the second, what the program without its defects finds, is told beside it.
                let found = &all.found_by_appendix;
                let printed = found.parts().into_iter().take(1).collect();
                vec![Finding::statement(Reading::AsPrinted, REPORT, printed).noted(found.line())]
            }
            Fig08ExitAtVisible => {
                let listing = vec![all.exits.of_listing()];
                let mut findings = exact(&all.exits);
                findings.push(
                    Finding::statement(Reading::AsPrinted, REPORT, listing).by_construction(),
                );
                findings
            }
            S3ReleaseAccuracy => self.accuracy.release_findings(),
            S3ArrivalAccuracy => self.accuracy.arrival_findings(),
            Eq24TangentPoints => vec![Finding::set(
                claim,
                Reading::Exact,
                REPORT,
                &all.zone_oscillates.at_rest,
            )],
            // Figures' tables.
            Eq12CriticalPoints
            | Eq13CriticalMu0
            | S2BoundaryTangentPoints
            | S2DegenerateZone
            | S2ContinuousZone
            | Eq16TangentPoints
            | Fig04Visibility
            | Fig04NoStick
            | Fig04Deflection
            | Fig06FrictionLaw
            | Eq22CriticalPoints
            | Eq23CriticalMu0
            | Fig07aTangency
            | Fig07cBranches
            | Fig08StickLength1
            | Fig08StickLength2
            | Fig08StickDuration1
            | Fig08StickDuration2
            | Fig08TwoPeriodic
            | Fig08Deflections
            | Fig10Lambda1
            | Fig10Lambda2
            | Fig10Lambda3
            | Fig10Lambda4
            | Fig10Class
            | Fig11Lambda1
            | Fig11Lambda2
            | Fig11Lambda3
            | Fig11Lambda4
            | Fig11Class
            | Fig12Lambda1
            | Fig12Lambda2
            | Fig12Lambda3
            | Fig12Lambda4
            | Fig12Class
            | S5Samples
            | S5ZeroExponent
            | S5TwoZeroExponents
            | S5PositiveExponent => Vec::new(),
        }
    }

    /// The corrections that a claim's corrected readings carry. An orbit that never leaves the belt knows nothing of the clipped force.
    fn corrections(&self, id: ClaimId) -> Vec<Correction> {
        let figure = SpectrumFigure::ALL
            .into_iter()
            .position(|one| one.class() == id || one.exponents().contains(&id));
        let lifts_off = figure.is_none_or(|f| self.computed.bracket[f].exact.contact_losses > 0);
        Correction::of(id)
            .iter()
            .copied()
            .filter(|one| lifts_off || *one != Correction::ClippedNormalForce)
            .collect()
    }

    fn remark(&self, published: f64, figure: SpectrumFigure, k: usize) -> Remark {
        let figure = figure as usize;
        Remark {
            published,
            sign: signs(&self.computed.bracket[figure])[k],
            spread: self.spread.search.spread[figure][k],
        }
    }

    /// Another reading of "close to zero": of the estimate from data.
    fn nearest_to_zero(&self) -> String {
        let nearest = self.computed.bracket.each_ref().map(|data| {
            let told = data.from_data.exponents.iter();
            let told = told.filter(|one| one.status == Status::Ok);
            let sizes = told.map(|one| one.value.abs());
            format!("{:.4}", sizes.fold(f64::INFINITY, f64::min))
        });
        format!(
            "of the exponents that an estimate from the sampled motion determines, the nearest to zero is {} in size (Figs. 10, 11, 12)",
            nearest.join(", ")
        )
    }

    /// Lines of evidence besides the findings.
    fn further(&self, claim: &Claim, findings: &[Finding], remark: Option<&Remark>) -> Vec<String> {
        let borne_out = |met: usize, what: &str| {
            let all = self.spread.search.spread[0][0].settings;
            format!(
                "{met} of {all} settings of the estimator {what} (sizes up to {ZERO} pass for zero)"
            )
        };
        let counts = &self.spread.search.borne_out;
        match claim.id {
            ClaimId::Fig10Class => vec![
                self.spread.mended_sentence(),
                self.spread.two_periodic_sentence(),
            ],
            ClaimId::Fig12Class => vec![
                format!(
                    "the class rests on a section that does not close and on the positive exponent: {}",
                    self.statements.shapes.line()
                ),
                self.spread.chaos_sentence(),
            ],
            ClaimId::Fig04NoStick => {
                let figure = &self.computed.fig04;
                let (sticking, all) = (figure.sticking, figure.orbits.len());
                vec![format!(
                    "{sticking} of the {all} orbits of the figure ride the belt before they settle; of the periodic solution alone \
                    the sentence holds; that reading is not judged, for it says “in the considered system” and goes on to the transient trajectory"
                )]
            }
            ClaimId::Fig08TwoPeriodic => vec![
                shares_sentence(&self.shares()),
                self.scan.sentence(),
                self.scan.chaos.sentence(),
            ],
            ClaimId::S5Samples => match claim.values() {
                [states, _, begin, end] => vec![format!(
                    "{} time units between {states} states are {} apart",
                    end - begin,
                    (end - begin) / (states - 1.0)
                )],
                _ => Vec::new(),
            },
            ClaimId::S5ZeroExponent => vec![
                self.nearest_to_zero(),
                borne_out(counts.zero, "give each figure an exponent that is zero"),
            ],
            ClaimId::S5TwoZeroExponents => {
                vec![borne_out(
                    counts.two_zeros,
                    "make the first two of Fig. 11 zero",
                )]
            }
            ClaimId::S5PositiveExponent => {
                vec![borne_out(
                    counts.positive,
                    "make the first of Fig. 12 positive",
                )]
            }
            ClaimId::S3ArrivalAccuracy => self.accuracy.lines_of_arrival().collect(),
            ClaimId::S3ReleaseAccuracy => self.accuracy.lines_of_release().collect(),
            _ => {
                let digits = |(figure, k)| self.spread.digits_sentence(figure as usize, k);
                let judged =
                    |one: &&Finding| one.is_evidence() && one.reading.role() == Role::Corrected;
                let all_agree = findings.iter().filter(judged).all(|one| one.agrees);
                let words = remark.map(|remark| match remark.sentence() {
                    settings if all_agree => format!(
                        "equations and data round to the published digits; that decides nothing where other settings do not: {settings}"
                    ),
                    settings => settings,
                });
                let digits = claim.id.exponent().and_then(digits);
                words.into_iter().chain(digits).collect()
            }
        }
    }
}

const REPORT: &str = "report";

/// Where the starts of Fig. 8's grid end up in the stated model.
fn shares_sentence(shares: &Shares) -> String {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    format!(
        "Of {} starts in the stated model, from −{} to {} m and −{} to {} m/s, within {FOLLOWED} forcing periods {} settle on motions that never \
         stick, {} escape, {} stick and slip, and {} do not settle (other windows of starts have other shares).",
        shares.starts,
        REACH[0],
        REACH[0],
        REACH[1],
        REACH[1],
        percent(shares.slip_only + shares.other),
        percent(shares.escapes),
        percent(shares.stick_slip),
        percent(shares.unsettled),
    )
}

/// A statement of the stated model, and what the listing makes of it where that was looked at.
fn exact(found: &dyn Evidence) -> Vec<Finding> {
    beside_printed(Reading::Exact, found)
}

/// A statement by one reading, and what the letter of the paper makes of it where that was looked
/// at.
fn beside_printed(reading: Reading, found: &dyn Evidence) -> Vec<Finding> {
    let mut findings = vec![evidence(reading, found)];
    let printed = found.as_printed();
    if !printed.is_empty() {
        findings.push(Finding::statement(Reading::AsPrinted, REPORT, printed));
    }
    findings
}

fn evidence(reading: Reading, found: &dyn Evidence) -> Finding {
    Finding::statement(reading, REPORT, found.parts()).noted(found.line())
}
