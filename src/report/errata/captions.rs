//! Misprints of the captions of Figs. 10–12, and what of the motion depends on them.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::{Erratum, Shown, erratum, number, word};
use crate::report::evidence::EvidenceError;
use crate::turns::Turns;
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::error::Error;
use stickslip::filippov::{Observer, Options, StepRecord, run};
use stickslip::models::{BlockAndBracket, Caption, CaptionOrder, Reading};
use stickslip::system::State;

const TOLERANCE: f64 = 1e-10;
/// A component beyond this has diverged.
const DIVERGED: f64 = 1e3;
/// The section is kept from the first of these times to the second.
const WINDOW: (f64, f64) = (3000.0, 4500.0);
/// Static friction (mg) tried where the heading's order leaves none.
const FRICTIONS: [f64; 4] = [0.3, 0.7, 1.0, 2.0];

pub(super) fn errata() -> Result<Vec<Erratum>, EvidenceError> {
    Ok(vec![order_of_captions()?, caption_of_fig10()?])
}

/// The section of an orbit within the window.
struct Watch<'a>(Turns<'a>);

impl Observer<4> for Watch<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        if step.t_start >= WINDOW.0 {
            self.0.step(step);
        }
        ControlFlow::Continue(())
    }
}

/// What the section of a motion says, without exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    /// A component passes the bound at this time.
    Diverges(f64),
    /// The block turns nowhere: it rests or sticks for good.
    Rests,
    /// Closes after so many turns; time of one round.
    Closes(usize, f64),
    /// Does not close within the window; points of the section.
    Open(usize),
}

fn outcome(caption: &Caption, reading: &Reading) -> Result<Outcome, Error> {
    let model = BlockAndBracket::from_caption(caption, reading)?;
    let options = Options::tol(TOLERANCE).escape(DIVERGED);
    let mut watch = Watch(Turns::new(&model, &options));
    let start = State::from(caption.start);
    let run = run(&model, 0.0, start, WINDOW.1, &options, &mut watch);
    match run.map_err(Error::from) {
        Ok(_) => {}
        Err(Error::Escaped { t, .. }) => return Ok(Outcome::Diverges(t)),
        Err(error) => return Err(error),
    }
    let section = watch.0.points;
    let evidence = Evidence::gather(
        &section,
        (Of::Flow, &[], WINDOW.1 - WINDOW.0),
        &Criterion::default(),
    );
    Ok(match evidence.class() {
        _ if section.is_empty() => Outcome::Rests,
        Class::Periodic(turns) => Outcome::Closes(turns, turns as f64 * evidence.return_time),
        _ => Outcome::Open(section.len()),
    })
}

impl Outcome {
    fn shown(self, what: String) -> Shown {
        match self {
            Outcome::Diverges(t) => number(
                format!("{what}: a component passes {DIVERGED} at t"),
                t,
                "t",
            ),
            Outcome::Rests => word(what, "comes to rest"),
            Outcome::Closes(turns, round) => {
                number(format!("{what}: closes (turns: {turns}) after"), round, "t")
            }
            Outcome::Open(points) => word(what, format!("does not close in {points} turns")),
        }
    }

    /// Whether it is what a caption calls quasi-periodic or chaotic: bounded and open.
    fn is_open(self) -> bool {
        matches!(self, Outcome::Open(_))
    }
}

fn order_of_captions() -> Result<Erratum, EvidenceError> {
    let figures = [("Fig. 11", Caption::FIG11), ("Fig. 12", Caption::FIG12)];
    let mut shown = Vec::new();
    let mut holds = true;
    for (figure, caption) in figures {
        let [_, xi2, _, xi4, xi5, sixth, seventh, ..] = caption.numbers;
        shown.push(number(
            format!("{figure}: seventh number over sixth"),
            seventh / sixth,
            "1",
        ));
        shown.push(number(format!("{figure}: xi4 - 1 = k3/k2"), xi4 - 1.0, "1"));
        holds &= (seventh / sixth - (xi4 - 1.0)).abs() < 1e-3 && xi2 == 0.0 && xi5 == 0.0;
        let corrected = outcome(&caption, &Reading::exact())?;
        holds &= corrected.is_open();
        shown.push(corrected.shown(format!("{figure}, corrected order")));
        let heading = FRICTIONS
            .par_iter()
            .map(|&mu0| {
                let reading = Reading {
                    order: CaptionOrder::Heading { mu0 },
                    ..Reading::exact()
                };
                outcome(&caption, &reading)
            })
            .collect::<Result<Vec<Outcome>, Error>>()?;
        for (mu0, found) in FRICTIONS.into_iter().zip(heading) {
            holds &= !found.is_open();
            shown.push(found.shown(format!("{figure}, order of the heading, mu0 = {mu0}")));
        }
    }
    Ok(erratum(
        "Captions of Figs. 10-12",
        "the nine numbers are headed xi1 … xi7, delta, vp",
        "they are xi1 … xi5, mu0, xi6, delta, vp: xi2 = xi5 = 0 leaves no damper and so xi7 = 0, and the seventh over the sixth is \
         xi6/mu0 = k3/k2",
        shown,
        holds,
    ))
}

fn caption_of_fig10() -> Result<Erratum, EvidenceError> {
    let [_, _, _, xi4, _, mu0, xi6, ..] = Caption::FIG10.numbers;
    let mended = [
        ("xi6", 6, mu0 * (xi4 - 1.0)),
        ("mu0", 5, xi6 / (xi4 - 1.0)),
        ("xi4", 3, 1.0 + xi6 / mu0),
    ];
    let mut shown = vec![
        number("seventh number over sixth", xi6 / mu0, "1"),
        number("xi4 - 1", xi4 - 1.0, "1"),
    ];
    let printed = outcome(&Caption::FIG10, &Reading::exact())?;
    shown.push(printed.shown("as printed".to_owned()));
    let found = mended
        .par_iter()
        .map(|&(_, place, value)| {
            let mut caption = Caption::FIG10;
            if let Some(number) = caption.numbers.get_mut(place) {
                *number = value;
            }
            outcome(&caption, &Reading::exact())
        })
        .collect::<Result<Vec<Outcome>, Error>>()?;
    let mut differ = true;
    for ((name, _, value), one) in mended.into_iter().zip(found) {
        differ &= one != printed;
        shown.push(one.shown(format!("with {name} = {value:.3}")));
    }
    Ok(erratum(
        "Caption of Fig. 10",
        "the seventh number is 1.115",
        "another number there, or at xi4 or mu0: the relation that holds for Figs. 11 and 12 fails, and the period of the motion \
         depends on which is meant",
        shown,
        (xi6 / mu0 - (xi4 - 1.0)).abs() > 1e-2 && differ,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motions_depend_on_what_the_numbers_are() {
        for found in [order_of_captions().unwrap(), caption_of_fig10().unwrap()] {
            assert!(found.holds, "{found:#?}");
        }
    }
}
