//! The verdict in a few sentences, every number of them formatted from the run: the page and the README open with these.

use super::entry::Entry;
use super::ledger::Ledger;
use super::paper_part::PaperPart;
use super::remark::Remark;
use super::verdict::Verdict;
use crate::figures::block_and_bracket::DIVERGES;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::listing::Defect;
use crate::paper::reading::Reading;

/// Of all claims; of Fig. 8 and what makes it; of Figs. 10–12.
pub(super) fn sentences(ledger: &Ledger) -> Vec<String> {
    vec![all(ledger), fig_8(ledger), figs_10_to_12(ledger)]
}

fn all(ledger: &Ledger) -> String {
    let counts = ledger
        .counts()
        .map(|(verdict, count)| format!("{count} {verdict}"));
    format!(
        "Of the {} quantities and statements that the paper publishes: {}.",
        ledger.entries.len(),
        join(&counts)
    )
}

fn fig_8(ledger: &Ledger) -> String {
    let four: Vec<&Entry> = ClaimId::FOUR.iter().map(|id| ledger.entry(*id)).collect();
    let published = four
        .iter()
        .map(|entry| entry.claim.published.clone())
        .collect::<Vec<_>>();
    let by = |reading: Reading| {
        let agrees = |entry: &&&Entry| entry.reading(reading).is_some_and(|one| one.agrees);
        four.iter().filter(agrees).count()
    };
    let shares = ledger.shares();
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let defects = [Defect::InPlaceStages, Defect::OneSidedExit].map(Defect::description);
    format!(
        "The stick–slip motion of Fig. 8 has {} as published lengths (m) and durations (s) of its stick phases. The program of the Appendix gives \
         {} of these four numbers to every printed digit; the stated model gives {}. Of {} starts in the stated model {} settle on motions that \
         never stick, {} escape, {} stick and slip, and {} do not settle. Two defects of the program make the motion: {}; and {}. That cause is {} by \
         putting the two into the accurate solver. The last digits are the error of the program's step.",
        join(&published),
        by(Reading::AsPrinted),
        by(Reading::Exact),
        shares.starts,
        percent(shares.slip_only + shares.other),
        percent(shares.escapes),
        percent(shares.stick_slip),
        percent(shares.unsettled),
        defects[0],
        defects[1],
        ledger.cause.status()
    )
}

fn figs_10_to_12(ledger: &Ledger) -> String {
    let classes = SpectrumFigure::ALL.map(|figure| ledger.entry(figure.class()));
    let exponents: Vec<&Entry> = SpectrumFigure::ALL
        .iter()
        .flat_map(|figure| figure.exponents())
        .map(|id| ledger.entry(id))
        .collect();
    let met = |entry: &&&Entry| {
        matches!(
            entry.verdict,
            Verdict::Reproduced | Verdict::WithCorrections
        )
    };
    let digits: Vec<&&Entry> = exponents.iter().filter(met).collect();
    let zeros = digits
        .iter()
        .filter(|entry| entry.claim.values() == [0.0])
        .count();
    let remarks = || exponents.iter().filter_map(|entry| entry.remark.as_ref());
    let signs = remarks().filter(|remark| remark.sign_agrees()).count();
    let within: Vec<_> = remarks().filter(|remark| remark.within_range()).collect();
    let told = |remark: &&&Remark| {
        remark
            .range
            .is_some_and(|range| 2 * range.unidentified <= range.settings)
    };
    let identified = within.iter().filter(told).count();
    let unlike: Vec<String> = classes
        .iter()
        .filter(|entry| entry.verdict == Verdict::NotReproduced)
        .map(|entry| {
            let found = entry.reading(Reading::Corrected);
            format!(
                " ({} is published for {}, {} found)",
                entry.claim.published,
                PaperPart::of(entry.claim.id).name(),
                found.map_or_else(String::new, |one| one.text())
            )
        })
        .collect();
    let diverging = classes
        .iter()
        .filter_map(|entry| entry.reading(Reading::AsPrinted))
        .filter(|one| one.text() == DIVERGES)
        .count();
    let search = &ledger.spread.search;
    format!(
        "Figs. 10–12 publish {} classes of motion. The corrected equations give {} of them{}. With the signs as printed {diverging} of the three \
         motions diverge. Of the {} published exponents {} {} met to every printed digit, {zeros} of them a printed zero. {signs} have the computed \
         sign; {} lie inside what {} settings of the estimator can give, {identified} of these where most settings identify the exponent. A search \
         over {} ways to read and evaluate the figures ({}) meets {} of the exponents in no way. Of its {} pairs of equations and integrator {} give \
         all three captioned classes; {} give the same kinds of motion when the number of loops is left out. Its nearest exponents are no nearer than \
         chance: {:.0} % of random targets of the same classes are met as well.",
        classes.len(),
        classes.iter().filter(|entry| met(entry)).count(),
        unlike.concat(),
        exponents.len(),
        digits.len(),
        if digits.len() == 1 { "is" } else { "are" },
        within.len(),
        search.spread[0][0].settings,
        search.configurations,
        search.cited(),
        search.digits.by_none(),
        search.pairs.all,
        search.pairs.classes,
        search.pairs.kinds,
        search.kinds_first.percent(),
    )
}

/// `a, b and c`.
pub(super) fn join(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
