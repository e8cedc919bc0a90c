//! The ledger: every claim of the paper, what the readings give for it, and what that comes to.

use super::accuracy::{Accuracy, AccuracyError};
use super::checks::check;
use super::convergence;
use super::convergence::Convergence;
use super::digits::Agreement;
use super::digits::agreement;
use super::entry::{Cause, Entry, ReadingValue, Role, Spread, Verdict, verdict};
use super::errata::{ErrataError, Erratum, errata};
use super::figures::{self, Computed, Sign, Table, kind_of_motion, readings_of, signs_of_class};
use super::injection::{Exits, Injection, mended_listing_error};
use super::matrix::{Cell, FOUR, Matrix, MatrixError, SUBSETS, list};
use super::scan::{self, Scan};
use super::spread::{self, Spread as Estimates, SpreadError};
use crate::figures::FigureError;
use crate::figures::rows::{Row, Value};
use crate::paper::published::{Claim, Digits, PublishedError, claims, published};
use stickslip::error::Error;

/// Everything the report says.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger {
    /// One entry for each claim, in the order of the table of claims.
    pub entries: Vec<Entry>,
    /// The figures' tables.
    pub tables: Vec<Table>,
    /// Which defects of the listing make the numbers of Fig. 8.
    pub matrix: Matrix,
    /// The listing's approach to its limit.
    pub convergence: Convergence,
    /// The limit's defects in the event-exact solver.
    pub injection: Injection,
    /// How far the mended listing's crossings are from those of the event-exact orbit (m).
    pub mended_listing_error: f64,
    /// Ends of stick phases of the stated model.
    pub exits: Exits,
    /// Whether the stated model has a stick–slip attractor near the printed parameters.
    pub scan: Scan,
    /// The Hénon step's order and error.
    pub accuracy: Accuracy,
    /// The estimator's spread in Figs. 10–12.
    pub spread: Estimates,
    /// The paper's misprints.
    pub errata: Vec<Erratum>,
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
    /// The spread could not be measured.
    #[error(transparent)]
    Spread(#[from] SpreadError),
    /// The errata could not be computed.
    #[error(transparent)]
    Errata(#[from] ErrataError),
    /// The table of claims is not sound.
    #[error(transparent)]
    Published(#[from] PublishedError),
}

/// How often [`Ledger::compute`] calls its `tick`.
pub const TICKS: usize =
    figures::FIGURES + SUBSETS + convergence::RUNS + scan::POINTS + spread::JOBS;

impl Ledger {
    /// Computes everything; `tick` is called [`TICKS`] times on the way, from any thread.
    ///
    /// # Errors
    /// [`LedgerError`] of the first part that fails.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Ledger, LedgerError> {
        let computed = figures::compute(tick)?;
        let matrix = Matrix::compute(tick)?;
        let injection = Injection::compute()?;
        let convergence = Convergence::compute(injection.numbers, tick)?;
        let exits = Exits::compute()?;
        let exact = &computed.fig08.exact;
        let mended_listing_error =
            mended_listing_error(exact.left, exact.right).map_err(MatrixError::from)?;
        let length = |id| Ok::<f64, PublishedError>(published(id)?.values().into_iter().sum());
        let scan = Scan::compute([length(FOUR[0])?, length(FOUR[1])?], tick)?;
        let accuracy = Accuracy::compute()?;
        let spread = Estimates::compute(tick)?;
        let rows: Vec<&Row> = computed
            .tables
            .iter()
            .flat_map(|table| &table.rows)
            .collect();
        let errata = errata(&matrix, &accuracy, &rows)?;
        let claims = claims()?;
        let sources = Sources {
            claims: &claims,
            computed: &computed,
            matrix: &matrix,
            injection: &injection,
            mended_listing_error,
            exits,
            scan: &scan,
            accuracy: &accuracy,
            spread: &spread,
        };
        let entries = claims.iter().map(|claim| sources.entry(claim)).collect();
        Ok(Ledger {
            entries,
            tables: computed.tables,
            matrix,
            convergence,
            injection,
            mended_listing_error,
            exits,
            scan,
            accuracy,
            spread,
            errata,
        })
    }

    /// How many claims have each verdict.
    pub fn counts(&self) -> [(Verdict, usize); 4] {
        Verdict::ALL.map(|verdict| {
            let with = self.entries.iter().filter(|entry| entry.verdict == verdict);
            (verdict, with.count())
        })
    }

    /// The entry of a claim.
    pub fn entry(&self, id: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.claim.id == id)
    }
}

/// What entries are made from.
struct Sources<'a> {
    claims: &'a [Claim],
    computed: &'a Computed,
    matrix: &'a Matrix,
    injection: &'a Injection,
    mended_listing_error: f64,
    exits: Exits,
    scan: &'a Scan,
    accuracy: &'a Accuracy,
    spread: &'a Estimates,
}

impl Sources<'_> {
    fn entry(&self, claim: &Claim) -> Entry {
        let mut readings = readings_of(claim, self.claims, &self.computed.tables);
        readings.extend(self.computed_here(claim));
        let verdict = verdict(&readings, self.class_right(claim, &readings));
        let decimals = match claim.digits {
            Digits::Decimals(decimals) => decimals + 1,
            _ => 6,
        };
        let check = check(&claim.id).map(|check| format!("check: {check}"));
        let mut evidence: Vec<String> = check.into_iter().collect();
        evidence.extend(readings.iter().map(|one| one.line(decimals)));
        let spread = (verdict == Verdict::ClassOnly)
            .then(|| self.spread_of(claim, &readings))
            .flatten();
        evidence.extend(self.further(claim, verdict, &readings, spread.as_ref()));
        let cause = (verdict == Verdict::AsPrintedOnly).then(|| self.cause(claim, &readings));
        Entry {
            claim: claim.clone(),
            readings,
            verdict,
            evidence,
            cause,
            spread,
        }
    }

    /// Readings that no figure has.
    fn computed_here(&self, claim: &Claim) -> Vec<ReadingValue> {
        if let Some(i) = FOUR.iter().position(|id| *id == claim.id) {
            return self.four_numbers(claim, i);
        }
        let injection = self.injection;
        let statement =
            |reading, holds| word(reading, if holds { "holds" } else { "fails" }, holds);
        let count = |reading, n: usize| counted(claim, reading, n);
        match claim.id.as_str() {
            "fig08.two_periodic" => {
                let same = injection.sticks == 2 && injection.period_two;
                vec![statement("slip-times-three", same)]
            }
            "fig08.deflections" => {
                let exact = &self.computed.fig08.exact;
                let left = [exact.left, exact.right].into_iter().filter(|x1| *x1 < 0.0);
                vec![
                    count("exact", left.count()),
                    count("slip-times-three", injection.deflections),
                ]
            }
            "fig08.exit_at_visible" => {
                let exits = self.exits;
                let all = exits.all > 0 && exits.visible == exits.all;
                let injected = injection.sticks > 0 && injection.visible_exits == injection.sticks;
                vec![
                    statement("exact", all).noted(format!(
                        "{} of {} ends of stick phases, transient in the stated model",
                        exits.visible, exits.all
                    )),
                    statement("slip-times-three", injected),
                ]
            }
            "abstract.accuracy" => vec![
                statement("exact", self.accuracy.stated_is_accurate()),
                statement("as-printed", self.accuracy.as_printed_is_accurate()),
            ],
            _ => Vec::new(),
        }
    }

    /// The stated model's, and those of the mended listing with the least set of defects that gives all four.
    fn four_numbers(&self, claim: &Claim, i: usize) -> Vec<ReadingValue> {
        let sticks = self.computed.fig08.exact.sticks;
        let mut readings = vec![word("exact", &format!("{sticks} stick phases"), false)];
        let least = self.matrix.minimal(Cell::gives_digits);
        // The mended listing stands for an accurate solver as long as it errs by less than the last printed digit shows.
        let accurate = self.mended_listing_error < 0.5e-4;
        if let Some(numbers) = least
            .first()
            .and_then(|cell| cell.numbers)
            .filter(|_| accurate)
        {
            readings.push(ReadingValue {
                reading: "least-set".into(),
                source: "report",
                values: vec![Value::Number(numbers[i])],
                digits: agreement(claim, numbers[i]),
                agrees: claim.agrees(numbers[i]),
                note: None,
            });
        }
        readings
    }

    /// Whether the kind of motion or the sign is that of the paper; nothing where a claim has neither.
    fn class_right(&self, claim: &Claim, readings: &[ReadingValue]) -> Option<bool> {
        if let Some((figure, i)) = exponent(&claim.id) {
            let class = published(&format!("fig{}.class", figure + 10)).ok()?;
            let expected = signs_of_class(&class.published)?;
            return Some(self.computed.signs[figure][i] == expected[i]);
        }
        if !claim.id.ends_with(".class") {
            return None;
        }
        let stated = readings.iter().find(|one| one.role() == Role::Stated)?;
        Some(kind_of_motion(&stated.text()) == kind_of_motion(&claim.published))
    }

    fn spread_of(&self, claim: &Claim, readings: &[ReadingValue]) -> Option<Spread> {
        let (figure, i) = exponent(&claim.id)?;
        let figure = self.spread.figures.get(figure)?;
        // The figure's own two estimates use more reference points, whose number is as little stated.
        let from_data = readings
            .iter()
            .filter(|one| one.reading != "exact/equations");
        let own = from_data
            .filter_map(ReadingValue::number)
            .filter(|v| v.is_finite());
        let (least, largest) = own.fold(figure.range(i)?, |(least, largest), v| {
            (least.min(v), largest.max(v))
        });
        Some(Spread {
            least,
            largest,
            over: format!(
                "{} settings of the data estimator on one accurate trajectory, besides the figure's two ({})",
                figure.estimates.len(),
                spread::described()
            ),
        })
    }

    /// Lines of evidence besides the readings.
    fn further(
        &self,
        claim: &Claim,
        verdict: Verdict,
        readings: &[ReadingValue],
        spread: Option<&Spread>,
    ) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some((figure, i)) = exponent(&claim.id) {
            let sign = match self.computed.signs[figure][i] {
                Sign::Positive => "positive",
                Sign::Zero => "zero within its error",
                Sign::Negative => "negative",
            };
            lines.push(format!("from the equations the exponent is {sign}"));
            let class = published(&format!("fig{}.class", figure + 10));
            let expected = class
                .ok()
                .and_then(|class| signs_of_class(&class.published));
            let printed = claim.values().first().copied();
            if expected.is_some_and(|signs| signs[i] == Sign::Zero) {
                lines.push(match printed {
                    Some(0.0) => "the captioned kind of motion demands a zero here: what agrees is that it is one".into(),
                    _ => format!(
                        "the captioned kind of motion demands a zero here; printed is {}",
                        claim.published
                    ),
                });
            }
        }
        if let Some(spread) = spread {
            lines.push(spread_line(claim, spread));
        }
        if claim.id == "fig10.class" {
            let mended: Vec<String> = self
                .spread
                .mended
                .iter()
                .map(|(entry, class)| format!("{entry}: {class}"))
                .collect();
            lines.push(format!(
                "the caption's entries contradict each other; mended one at a time, {}",
                mended.join(", ")
            ));
        }
        if claim.id == "fig08.two_periodic" {
            lines.push(self.scan.sentence());
        }
        if claim.id == "abstract.accuracy" {
            let accuracy = self.accuracy;
            let all = accuracy.stated.iter().chain(&accuracy.single);
            let all = all
                .chain([&accuracy.printed_sign])
                .chain(&accuracy.as_printed);
            lines.extend(all.map(super::accuracy::EventErrors::line));
        }
        if verdict == Verdict::NotReproduced {
            lines.extend(nearest(claim, readings));
        }
        lines
    }

    fn cause(&self, claim: &Claim, readings: &[ReadingValue]) -> Cause {
        let with = |name: &str| {
            let outcome = readings.iter().find(|one| one.reading == name);
            outcome.map_or_else(|| "nothing".into(), |one| one.line(5))
        };
        let least = |property| {
            let cells = self.matrix.minimal(property);
            cells
                .first()
                .map(|cell| cell.present.clone())
                .unwrap_or_default()
        };
        let (all, class) = (least(Cell::gives_digits), least(Cell::gives_class));
        let continuous = format!(
            "{} make the class; in the event-exact solver, as they act when the step goes to zero: {}",
            list(&class),
            with("slip-times-three")
        );
        let (defects, text) = if FOUR.contains(&claim.id.as_str()) {
            let text = format!(
                "put into the mended listing, whose crossings are within {:.0e} m of the exact orbit's, {} give: {}. Of these {continuous}; \
                 the rest of the digits is the finite step's",
                self.mended_listing_error,
                list(&all),
                with("least-set")
            );
            (all, text)
        } else {
            (class, continuous)
        };
        Cause {
            defects: defects.iter().map(|defect| defect.name()).collect(),
            text,
        }
    }
}

impl ReadingValue {
    fn noted(mut self, note: String) -> Self {
        self.note = Some(note);
        self
    }
}

fn word(reading: &str, word: &str, agrees: bool) -> ReadingValue {
    ReadingValue {
        reading: reading.into(),
        source: "report",
        values: vec![Value::Word(word.into())],
        digits: None,
        agrees,
        note: None,
    }
}

fn counted(claim: &Claim, reading: &str, n: usize) -> ReadingValue {
    ReadingValue {
        values: vec![Value::Count(n as u64)],
        ..word(reading, "", n.to_string() == claim.published)
    }
}

/// Figure, from 0 for Fig. 10, and index, from 0, of a published exponent.
fn exponent(id: &str) -> Option<(usize, usize)> {
    let rest = id.strip_prefix("fig1")?;
    let (figure, index) = rest.split_once(".lambda.")?;
    let (figure, index): (usize, usize) = (figure.parse().ok()?, index.parse().ok()?);
    (figure < 3 && (1..=4).contains(&index)).then(|| (figure, index - 1))
}

fn spread_line(claim: &Claim, spread: &Spread) -> String {
    format!(
        "moves from {:.5} to {:.5} over {}, which the paper does not state; the published value lies {} that range",
        spread.least,
        spread.largest,
        spread.over,
        if spread.holds(claim) {
            "within"
        } else {
            "outside"
        }
    )
}

/// The tested reading nearest to a published number.
fn nearest(claim: &Claim, readings: &[ReadingValue]) -> Option<String> {
    let published = *claim.values().first()?;
    let distance = |one: &&ReadingValue| {
        one.number()
            .map_or(f64::INFINITY, |v| (v - published).abs())
    };
    let best = readings
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let none = Agreement {
        agreeing: 0,
        printed: 1,
    };
    Some(format!(
        "nearest: {} ({} digits)",
        best.reading,
        best.digits.unwrap_or(none)
    ))
}
