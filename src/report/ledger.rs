//! The ledger: every claim of the paper, the findings of all readings, and the verdict.

use super::accuracy::Accuracy;
use super::cause::{Cause, Injection};
use super::convergence::{self, Convergence};
use super::digits::Agreement;
use super::errata::{Erratum, errata};
use super::evidence::Statements;
use super::exponent::{ExponentCheck, OverSettings};
use super::figures::{self, Computed, signs};
use super::finding::Finding;
use super::matrix::{Matrix, SUBSETS};
use super::scan::{self, Scan};
use super::spread::{self, Estimated, Spread};
use super::verdict::{Correction, Verdict};
use crate::figures::fig08::{PERIODS_FOLLOWED, START_RANGE, Shares};
use crate::figures::rows::Row;
use crate::numbers::extent;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::published::{Claim, Claims, Digits};
use crate::paper::reading::{Reading, Role};
use crate::readings::ZERO_SIZE;
use crate::terminal::ProgramError;
use stickslip_series::Status;

/// One claim, the findings of all readings, and the verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The claim.
    pub claim: Claim,
    /// Findings in the order of the figures, then the evidence.
    pub findings: Vec<Finding>,
    /// The verdict.
    pub verdict: Verdict,
    /// Corrections of the corrected readings; empty if there are none.
    pub corrections: Vec<Correction>,
    /// Checks of a published exponent.
    pub exponent: Option<ExponentCheck>,
    /// Further lines of evidence.
    pub further: Vec<String>,
}

impl Entry {
    /// The findings, without repeated values of one reading.
    pub fn distinct(&self) -> Vec<&Finding> {
        let mut kept: Vec<&Finding> = Vec::new();
        for one in &self.findings {
            let same =
                |other: &&Finding| (other.reading, other.text()) == (one.reading, one.text());
            if !kept.iter().any(same) {
                kept.push(one);
            }
        }
        kept
    }

    /// The finding of a reading.
    pub fn reading(&self, reading: Reading) -> Option<&Finding> {
        self.findings.iter().find(|one| one.reading == reading)
    }

    /// The agreeing digits of the best reading that counts in the verdict.
    pub fn digits(&self) -> Option<Agreement> {
        let counted = |one: &&Finding| one.reading.role() != Role::Supplementary;
        let digits = self.findings.iter().filter(counted);
        let digits = digits.filter_map(|one| one.digits);
        digits.max_by_key(|digits| digits.agreeing)
    }

    /// A finding in words, with one digit more than printed.
    pub fn line(&self, finding: &Finding) -> String {
        finding.line(match self.claim.digits {
            Digits::Decimals(decimals) => decimals + 1,
            Digits::Exact | Digits::None => 6,
        })
    }

    /// All evidence, a line each.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("check: {}", self.claim.check)];
        let findings = self.findings.iter();
        lines.extend(findings.map(|one| format!("{}, {}", one.reading, self.line(one))));
        lines.extend(self.further.iter().cloned());
        lines
    }

    /// Whether a cause is needed: only the paper's own program gives the claim.
    pub fn needs_cause(&self) -> bool {
        self.verdict == Verdict::AsPrintedOnly
    }
}

/// All results of the report.
pub struct Ledger {
    /// One entry for each claim, in the order of the table of claims.
    pub entries: Vec<Entry>,
    /// The defects of the listing that cause the numbers of Fig. 8.
    pub matrix: Matrix,
    /// The listing's convergence to its limit.
    pub convergence: Convergence,
    /// The two defects in the event-exact solver, together and alone.
    pub injection: Injection,
    /// The cause of Fig. 8's numbers.
    pub cause: Cause,
    /// Whether the stated model has a stick–slip attractor near the printed parameters.
    pub scan: Scan,
    /// The order and error of the Hénon step.
    pub accuracy: Accuracy,
    /// The estimator's spread in Figs. 10–12, and the results of the search over their readings.
    pub spread: Spread,
    /// Evidence for statements.
    pub statements: Statements,
    /// The paper's misprints.
    pub errata: Vec<Erratum>,
    /// The figures' data.
    pub computed: Computed,
}

/// Number of calls of `tick` by [`Ledger::compute`].
pub const TICKS: usize =
    figures::FIGURES + SUBSETS + convergence::RUNS + scan::POINTS + spread::JOBS;

impl Ledger {
    /// Computes everything; `tick` is called [`TICKS`] times, from any thread.
    ///
    /// # Errors
    /// That of the first part that fails.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Ledger, ProgramError> {
        let claims = Claims::committed()?;
        let published = claims.published_stick_numbers();
        let computed = Computed::compute(tick)?;
        let matrix = Matrix::compute(claims, tick);
        let injection = Injection::compute()?;
        let convergence = Convergence::compute(claims, injection.numbers, tick);
        let printed = &computed.fig08.as_printed.pattern;
        let both = injection.both.clone();
        let accuracy = Accuracy::compute()?;
        let statements = Statements::compute(claims, &computed)?;
        let mut ledger = Ledger {
            entries: Vec::new(),
            cause: Cause::new(printed, both, &convergence, published),
            scan: Scan::compute([published[0], published[1]], tick)?,
            spread: Spread::compute(&computed.bracket, tick)?,
            errata: errata(claims, &matrix, &accuracy, &statements.errata)?,
            matrix,
            convergence,
            injection,
            accuracy,
            statements,
            computed,
        };
        let judged = |claim: &Claim| ledger.rejudged(claims, claim.id);
        ledger.entries = claims.iter().map(judged).collect();
        Ok(ledger)
    }

    /// Number of claims counted: all but identities.
    pub fn counted(&self) -> usize {
        self.counts().iter().map(|(_, count)| count).sum()
    }

    /// Number of claims with each verdict.
    pub fn counts(&self) -> [(Verdict, usize); 7] {
        Verdict::COUNTED.map(|verdict| (verdict, self.with(verdict)))
    }

    /// Number of claims with a verdict.
    pub fn with(&self, verdict: Verdict) -> usize {
        let with = self.entries.iter().filter(|entry| entry.verdict == verdict);
        with.count()
    }

    /// The entry of a claim.
    pub fn entry(&self, id: ClaimId) -> &Entry {
        // `compute` stores one entry per claim, in the order of the variants.
        &self.entries[id as usize]
    }

    /// The entry of a claim, judged against `claims`. With the published table it is the claim's
    /// own entry. With a changed table, it is the entry that would result if the paper had printed
    /// that.
    pub fn rejudged(&self, claims: &Claims, id: ClaimId) -> Entry {
        let claim = claims.of(id);
        let pictures = self.computed.pictures.iter();
        let rows = pictures.flat_map(|one| Finding::of_rows(claims, claim, one.figure, &one.rows));
        let mut findings: Vec<Finding> = rows.collect();
        findings.extend(match id {
            ClaimId::S3ReleaseAccuracy => self.accuracy.release_findings(),
            ClaimId::S3ArrivalAccuracy => self.accuracy.arrival_findings(),
            ClaimId::GoodEstimations => self.accuracy.estimations(self.statements.lower_ends),
            ClaimId::S5Reconstruction => self.spread.reconstruction(),
            ClaimId::S5LargeEnough => self.spread.large_enough(),
            ClaimId::Eq24TangentPoints => {
                let rows = Row::members(id, Reading::Exact, &self.statements.at_rest, "m");
                Finding::of_rows(claims, claim, "report", &rows)
            }
            _ => self.statements.of(id).to_vec(),
        });
        let exponent = self.check(claims, id);
        let settings = match exponent {
            Some(exponent) => exponent.over_settings(claim),
            None if self.settings_decide(id) => OverSettings::Undetermined,
            None => OverSettings::Decided,
        };
        for one in &mut findings {
            match one.reading {
                Reading::CorrectedData => one.settings = settings,
                // A bounded orbit of an autonomous flow that tends to no equilibrium has a zero
                // exponent (Haken, Phys. Lett. A 94 (1983) 71); saltation carries the field before
                // an event onto the field after it.
                Reading::CorrectedEquations if id == ClaimId::S5ZeroExponent => {
                    one.by_construction = true;
                }
                _ => {}
            }
        }
        let has_corrected = |one: &Finding| one.reading.role() == Role::Corrected;
        let corrected = findings.iter().any(has_corrected);
        let corrections: Vec<Correction> = self.corrections(claim).filter(|_| corrected).collect();
        Entry {
            verdict: Verdict::of(claim.kind, &findings, &corrections),
            corrections,
            exponent,
            further: self.further(claim, exponent),
            claim: claim.clone(),
            findings,
        }
    }

    /// A published exponent, or the ratio of two, against the settings of the estimator.
    fn check(&self, claims: &Claims, id: ClaimId) -> Option<ExponentCheck> {
        let (figure, of, place) = match id.exponent() {
            Some((figure, k)) => (figure, Estimated::Exponent(figure as usize, k), k),
            // λ1 is positive, so that the ratio has the sign of λ3.
            None if id == ClaimId::Fig12Ratio => (SpectrumFigure::Fig12, spread::RATIO, 2),
            None => return None,
        };
        let data = &self.computed.bracket[figure as usize];
        let exponents = &data.exact.spectrum.exponents;
        let finite = |k: usize| Some((exponents[k].value(), exponents[k].std_error()?));
        let equations = match id {
            ClaimId::Fig12Ratio => {
                finite(0)
                    .zip(finite(2))
                    .map(|((first, of_first), (third, of_third))| {
                        let ratio = first / third;
                        let relative = of_first / first.abs() + of_third / third.abs();
                        [ratio, ratio.abs() * relative]
                    })
            }
            _ => finite(place).map(|(value, error)| [value, error]),
        };
        Some(ExponentCheck {
            published: claims.value(id),
            sign: signs(data)[place],
            equations,
            range: self.spread.range(of, spread::any),
            linear: self.spread.range(of, spread::as_printed),
        })
    }

    /// The corrections of a claim's corrected readings. The clipped force has no effect on an orbit
    /// that never leaves the belt.
    fn corrections(&self, claim: &Claim) -> impl Iterator<Item = Correction> {
        let of_claim =
            |one: &SpectrumFigure| one.class() == claim.id || one.exponents().contains(&claim.id);
        let figure = SpectrumFigure::ALL.iter().position(of_claim);
        let lifts_off = figure.is_none_or(|f| self.computed.bracket[f].exact.contact_losses > 0);
        let all = Correction::of(claim);
        all.filter(move |one| lifts_off || *one != Correction::ClippedNormalForce)
    }

    /// Whether some settings of the estimator confirm a statement on spectra and others do not.
    fn settings_decide(&self, id: ClaimId) -> bool {
        let Spread { search, .. } = &self.spread;
        let counts = &search.confirmed_statements;
        let confirmed = match id {
            ClaimId::S5ZeroExponent => counts.zero,
            ClaimId::S5TwoZeroExponents => counts.two_zeros,
            ClaimId::S5PositiveExponent => counts.positive,
            _ => return false,
        };
        confirmed > 0 && confirmed < search.spread[0][0].settings
    }

    /// The assumption behind the class of Fig. 12.
    fn assumption_sentence(&self) -> String {
        let [first, second, third] = self
            .computed
            .bracket
            .each_ref()
            .map(|data| format!("{:.0} %", 100.0 * data.exact.lifted_fraction));
        format!(
            "under an added assumption: the normal force is clipped at zero, which the paper does \
             not say and which was chosen as the only one of the readings below that gives the \
             caption. The block is off the belt for {third} of the time (Fig. 10: {first}, \
             Fig. 11: {second})"
        )
    }

    /// Distance from zero of the nearest exponent that the estimate from data determines, in words.
    fn nearest_to_zero(&self) -> String {
        let nearest = self.computed.bracket.each_ref().map(|data| {
            let exponents = data.from_data.exponents.iter();
            let determined = exponents.filter(|one| one.status == Status::Ok);
            format!("{:.4}", extent(determined.map(|one| one.value.abs())).0)
        });
        format!(
            "of the exponents that an estimate from the sampled motion determines, the nearest to \
                zero is {} in size (Figs. 10, 11, 12)",
            nearest.join(", ")
        )
    }

    /// Lines of evidence besides the findings.
    fn further(&self, claim: &Claim, exponent: Option<ExponentCheck>) -> Vec<String> {
        let Spread { search, .. } = &self.spread;
        let confirmed_statements = |met: usize, what: &str| {
            let all = search.spread[0][0].settings;
            format!(
                "{met} of {all} settings of the estimator {what} (sizes up to {ZERO_SIZE} pass for \
                    zero)"
            )
        };
        let counts = &search.confirmed_statements;
        match claim.id {
            ClaimId::Fig10Class => vec![
                self.statements.loops.sentence(),
                self.spread.mended_sentence(),
                self.spread.two_periodic_sentence(),
            ],
            ClaimId::Fig12Class => {
                let shapes = self.statements.shapes.line();
                let class = format!(
                    "the class rests on a section that does not close and on the positive \
                        exponent: {shapes}"
                );
                vec![
                    class,
                    self.assumption_sentence(),
                    self.spread.chaos_sentence(),
                ]
            }
            ClaimId::Fig08TwoPeriodic => vec![
                shares_sentence(&self.computed.fig08.shares),
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
            ClaimId::S5AllNegative => vec![
                "a bounded orbit of an autonomous flow that tends to no equilibrium has a zero \
                 exponent (Haken, Phys. Lett. A 94 (1983) 71), so that no motion of the paper can \
                 have negative ones alone"
                    .to_owned(),
            ],
            ClaimId::S5ZeroExponent => vec![
                "the equations' exponents are no evidence: a bounded orbit of an autonomous flow \
                 that tends to no equilibrium has a zero exponent (Haken, Phys. Lett. A 94 (1983) \
                 71), through events because saltation carries the field before onto the field \
                 after"
                    .to_owned(),
                self.nearest_to_zero(),
                confirmed_statements(counts.zero, "give each figure an exponent that is zero"),
            ],
            ClaimId::S5TwoZeroExponents => {
                let what = "make the first two of Fig. 11 zero";
                vec![confirmed_statements(counts.two_zeros, what)]
            }
            ClaimId::S5PositiveExponent => {
                let what = "make the first of Fig. 12 positive";
                let confirmed = confirmed_statements(counts.positive, what);
                vec![confirmed, self.spread.chaos_sentence()]
            }
            ClaimId::S5Kinds => vec![self.spread.chaos_sentence()],
            ClaimId::S5Shapes => vec![
                "the published spectra and pictures do not enter: the digits of the first are not \
                 reproduced or undeterminable, and the second were not at hand"
                    .to_owned(),
                self.spread.chaos_sentence(),
            ],
            ClaimId::S3ArrivalAccuracy => self.accuracy.lines_of_arrival(),
            ClaimId::S3ReleaseAccuracy => self.accuracy.lines_of_release(),
            id => {
                let mut lines: Vec<String> =
                    exponent.iter().map(|one| one.sentence(claim)).collect();
                let digits = id.exponent();
                lines.extend(digits.map(|(f, k)| self.spread.digits_sentence(f as usize, k)));
                lines
            }
        }
    }
}

/// Attractors of the starts of Fig. 8's grid in the stated model.
fn shares_sentence(shares: &Shares) -> String {
    let percent = |part: f64| format!("{:.0} %", 100.0 * part);
    let (slip, escape) = (
        percent(shares.slip_only + shares.other),
        percent(shares.escapes),
    );
    let (stick_slip, unsettled) = (percent(shares.stick_slip), percent(shares.unsettled));
    let ([x1, x2], starts) = (START_RANGE, shares.starts);
    format!(
        "Of {starts} starts in the stated model, from −{x1} to {x1} m and −{x2} to {x2} m/s, \
         within {PERIODS_FOLLOWED} forcing periods {slip} settle on motions that never stick, \
         {escape} escape, {stick_slip} stick and slip, and {unsettled} do not settle \
         (other windows of starts have other shares)."
    )
}
