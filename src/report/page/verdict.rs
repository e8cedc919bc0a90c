//! The verdict in three sentences.

use super::super::entry::{Entry, Role, Verdict};
use super::super::ledger::Ledger;
use super::super::matrix::Cell;
use super::super::scan::Class;

/// Of all claims; of Fig. 8 and what makes it; of Figs. 10–12.
pub(super) fn sentences(ledger: &Ledger) -> [String; 3] {
    [all(ledger), fig_8(ledger), figs_10_to_12(ledger)]
}

fn all(ledger: &Ledger) -> String {
    let counts = ledger.counts().map(|(verdict, count)| match verdict {
        Verdict::Reproduced => format!("{count} hold in the stated model, solved accurately"),
        Verdict::AsPrintedOnly => format!("{count} only in the printed program"),
        Verdict::ClassOnly => format!("{count} in kind or sign but not in their digits"),
        Verdict::NotReproduced => format!("{count} not at all"),
    });
    format!(
        "Of the {} quantities and statements that the paper publishes {}.",
        ledger.entries.len(),
        join(&counts)
    )
}

fn fig_8(ledger: &Ledger) -> String {
    let starts = ledger.scan.printed().map_or_else(String::new, |point| {
        let of = |class| {
            let mut counts = Class::ALL.iter().zip(point.counts);
            counts
                .find(|(one, _)| **one == class)
                .map_or(0, |(_, count)| count)
        };
        let sticking = of(Class::StickSlip) + of(Class::StickSlipTwo);
        format!("{sticking} of {} starts", ledger.scan.starts)
    });
    let lengths = ledger
        .entries
        .iter()
        .filter(|entry| entry.claim.id.starts_with("fig08.stick_length"))
        .map(|entry| entry.claim.published.clone())
        .collect::<Vec<_>>();
    let defects: Vec<String> = ledger
        .matrix
        .necessary(Cell::gives_class)
        .into_iter()
        .map(|defect| defect.description().to_owned())
        .collect();
    format!(
        "The stick–slip motion of Fig. 8 with its lengths of {} m is made by the program, not by the model: the program gives them to all \
         printed digits, every variant of it that moves so has in common that {}, and the stated model itself settles on stick–slip from {starts}.",
        join(&lengths),
        join(&defects),
    )
}

fn figs_10_to_12(ledger: &Ledger) -> String {
    let of = |part: &str| {
        let figures = ["fig10", "fig11", "fig12"];
        let part = part.to_owned();
        ledger.entries.iter().filter(move |entry| {
            figures
                .iter()
                .any(|figure| entry.claim.id.starts_with(&format!("{figure}.{part}")))
        })
    };
    let right = of("class")
        .filter(|entry| entry.verdict == Verdict::Reproduced)
        .count();
    let agree = of("lambda").filter(|entry| entry.verdict == Verdict::Reproduced);
    let zero = |entry: &&Entry| entry.claim.values().first() == Some(&0.0);
    let (digits, zeros) = (agree.clone().count(), agree.filter(zero).count());
    let within = of("lambda")
        .filter(|entry| entry.verdict != Verdict::Reproduced)
        .filter(|entry| {
            let spread = entry.spread.as_ref();
            spread.is_some_and(|spread| spread.holds(&entry.claim))
        })
        .count();
    let diverging = of("class")
        .filter(|entry| {
            let mut readings = entry.readings.iter();
            readings.any(|one| one.role() == Role::AsPrinted && one.text() == "diverges")
        })
        .count();
    let all = of("lambda").count();
    format!(
        "Of Figs. 10–12 the corrected equations give {right} of {} kinds of motion as captioned (with the signs as printed {diverging} diverge) and \
         {digits} of {all} exponents to the printed digits ({zeros} of them a zero); of the other {} published values {within} lie within what the \
         estimator's unstated settings can give.",
        of("class").count(),
        all - digits,
    )
}

/// `a, b and c`.
fn join(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
