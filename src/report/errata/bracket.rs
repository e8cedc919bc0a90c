//! Misprints on model 3 with their effect on the motion: the signs of Eq. (27), and the captions of
//! Figs. 10–12.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::proof::{Proof, ProofResult};
use crate::figures::block_and_bracket::{DIVERGED, START, TOLERANCE};
use crate::figures::rows::Value;
use crate::motion::{Class, Criterion, Evidence, SystemKind};
use crate::orbit_records::TurningPoints;
use crate::paper::models::{BlockAndBracket, Caption, CaptionOrder, Interpretation};
use crate::report::spread::mended_captions;
use stickslip::{Error, Observer, Options, State, StepRecord, run};

/// The section is recorded from the start of the published series to here: over a hundred
/// oscillations.
const SECTION_END: f64 = 4500.0;

/// Records the largest component of an orbit before the series begins, and its section after that.
struct TransientAndSection<'a> {
    largest: f64,
    turns: TurningPoints<'a>,
}

impl Observer<4> for TransientAndSection<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        if step.t_start >= START {
            self.turns.step(step);
        }
        self.largest = self.largest.max(step.x_end.amax());
        ControlFlow::Continue(())
    }
}

/// The motion of the equations in one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionOutcome {
    /// A component exceeds the bound at this time.
    Diverges(f64),
    /// No component does; the largest component until `START`.
    Bounded(f64),
    /// The block has no turning points: it is in equilibrium or sticks for good.
    NoTurns,
    /// The section closes after so many points; time of one round.
    Closes(usize, f64),
    /// The section does not close within the window; its points.
    Open(usize),
}

/// Integrates the equations until `end`. The section up to [`SECTION_END`] decides the class.
fn outcome(caption: &Caption, reading: &Interpretation, end: f64) -> Result<MotionOutcome, Error> {
    let model = BlockAndBracket::from_caption(caption, reading)?;
    let options = Options::tol(TOLERANCE).escape(DIVERGED);
    let mut observer = TransientAndSection {
        largest: 0.0,
        turns: TurningPoints::new(&model, &options),
    };
    let start = State::from(caption.start);
    match run(&model, 0.0, start, end, &options, &mut observer).map_err(Error::from) {
        Err(Error::Escaped { t, .. }) => return Ok(MotionOutcome::Diverges(t)),
        other => other?,
    };
    let section = observer.turns.points;
    let window = (SystemKind::Flow, &[][..], SECTION_END - START);
    let evidence = Evidence::gather(&section, window, &Criterion::default());
    Ok(match evidence.class() {
        _ if end <= START => MotionOutcome::Bounded(observer.largest),
        _ if section.is_empty() => MotionOutcome::NoTurns,
        Class::Periodic(turns) => MotionOutcome::Closes(turns, turns as f64 * evidence.return_time),
        _ => MotionOutcome::Open(section.len()),
    })
}

/// Proof decided by the section.
pub(in crate::report) fn by_section(
    caption: &Caption,
    reading: &Interpretation,
) -> Result<MotionOutcome, Error> {
    outcome(caption, reading, SECTION_END)
}

impl MotionOutcome {
    fn proof_result(self, what: &str) -> ProofResult {
        let (more, value, unit): (_, Value, _) = match self {
            MotionOutcome::Diverges(t) => (
                format!(": a component passes {DIVERGED} at t"),
                t.into(),
                "t",
            ),
            MotionOutcome::Bounded(size) => (
                format!(": largest component until t = {START}"),
                size.into(),
                "1",
            ),
            MotionOutcome::NoTurns => (String::new(), "comes to rest".into(), ""),
            MotionOutcome::Closes(turns, round) => (
                format!(": closes (turns: {turns}) after"),
                round.into(),
                "t",
            ),
            MotionOutcome::Open(points) => {
                let open = format!("does not close in {points} turns");
                (String::new(), open.as_str().into(), "")
            }
        };
        ProofResult::new(format!("{what}{more}"), value, unit)
    }

    /// Whether it may be quasi-periodic or chaotic: bounded, with an open section.
    fn is_open(self) -> bool {
        matches!(self, MotionOutcome::Open(_))
    }
}

pub(super) fn signs() -> Result<Proof, Error> {
    let mut all = Vec::new();
    let mut holds = true;
    for (figure, caption) in (10..).zip(Caption::ALL) {
        let (printed, corrected) = rayon::join(
            || outcome(&caption, &Interpretation::as_printed(), START),
            || outcome(&caption, &Interpretation::exact(), START),
        );
        let (printed, corrected) = (printed?, corrected?);
        holds &= matches!(printed, MotionOutcome::Diverges(_));
        holds &= matches!(corrected, MotionOutcome::Bounded(_));
        all.push(printed.proof_result(&format!("Fig. {figure}, as printed")));
        all.push(corrected.proof_result(&format!("Fig. {figure}, corrected")));
    }
    Ok(Proof::new("signs", all, holds))
}

/// Values of static friction (mg), for the heading's order, which gives none.
const FRICTIONS: [f64; 4] = [0.3, 0.7, 1.0, 2.0];

pub(super) fn order_of_captions() -> Result<Proof, Error> {
    let mut all = Vec::new();
    let mut holds = true;
    for (figure, caption) in (11..).zip(&Caption::ALL[1..]) {
        let [_, xi2, _, xi4, xi5, sixth, seventh, ..] = caption.numbers;
        let (ratio, stiffness) = (seventh / sixth, xi4 - 1.0);
        let what = format!("Fig. {figure}: seventh number over sixth");
        all.push(ProofResult::new(what, ratio, "1"));
        all.push(ProofResult::new(
            format!("Fig. {figure}: xi4 - 1 = k3/k2"),
            stiffness,
            "1",
        ));
        holds &= (ratio - stiffness).abs() < 1e-3 && xi2 == 0.0 && xi5 == 0.0;
        let corrected = by_section(caption, &Interpretation::exact())?;
        holds &= corrected.is_open();
        all.push(corrected.proof_result(&format!("Fig. {figure}, corrected order")));
        let headed = FRICTIONS.par_iter().map(|&mu0| {
            let reading = Interpretation {
                order: CaptionOrder::Heading { mu0 },
                ..Interpretation::exact()
            };
            by_section(caption, &reading)
        });
        let headed = headed.collect::<Result<Vec<MotionOutcome>, Error>>()?;
        for (mu0, outcome) in FRICTIONS.into_iter().zip(headed) {
            holds &= !outcome.is_open();
            all.push(
                outcome.proof_result(&format!("Fig. {figure}, order of the heading, mu0 = {mu0}")),
            );
        }
    }
    Ok(Proof::new("order_of_captions", all, holds))
}

pub(super) fn caption_of_fig10() -> Result<Proof, Error> {
    let [_, _, _, xi4, _, mu0, xi6, ..] = Caption::FIG10.numbers;
    let (ratio, stiffness) = (xi6 / mu0, xi4 - 1.0);
    let mut all = vec![
        ProofResult::new("seventh number over sixth", ratio, "1"),
        ProofResult::new("xi4 - 1", stiffness, "1"),
    ];
    let printed = by_section(&Caption::FIG10, &Interpretation::exact())?;
    all.push(printed.proof_result("as printed"));
    let mended = mended_captions();
    let outcomes = mended.par_iter();
    let outcomes = outcomes.map(|(_, caption)| by_section(caption, &Interpretation::exact()));
    let outcomes = outcomes.collect::<Result<Vec<MotionOutcome>, Error>>()?;
    let holds = (ratio - stiffness).abs() > 1e-2 && !outcomes.contains(&printed);
    let with = mended.iter().zip(outcomes);
    all.extend(with.map(|((entry, _), one)| one.proof_result(&format!("with {entry}"))));
    Ok(Proof::new("caption_of_fig10", all, holds))
}
