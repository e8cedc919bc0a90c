//! The verdict in a few sentences, every number of them formatted from the run: the page and the
//! README open with these.

use super::correction::Correction;
use super::ledger::{Entry, Ledger};
use super::matrix::Cell;
use super::readme::part_of;
use super::verdict::Verdict;
use crate::figures::block_and_bracket::DIVERGES;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::reading::Reading;
use crate::readings::{Committed, Level, Match, sources_in_words};
use stickslip::analysis::motion::Class;

/// The verdict in three sentences: of all claims, of Fig. 8, of Figs. 10–12. What else there is
/// stands with the claims.
pub(super) fn sentences(ledger: &Ledger) -> [String; 3] {
    let with = |verdict| {
        let entries = ledger.entries.iter();
        entries.filter(|entry| entry.verdict == verdict).count()
    };
    let gives = |ids: &[ClaimId], met: &dyn Fn(&Entry) -> bool| {
        let found = ids.iter().filter(|id| met(ledger.entry(**id))).count();
        format!("{found} of {}", ids.len())
    };
    let by = |reading| move |entry: &Entry| entry.reading(reading).is_some_and(|one| one.agrees);
    let least = |property| {
        let cells = ledger.matrix.minimal(property);
        cells
            .first()
            .map_or(0, |cell| cell.present.present().count())
    };
    let exponents = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    [
        format!(
            "The paper’s equations, solved accurately, bear out {} of its {} claims as they stand and {} more with misprints corrected.",
            with(Verdict::Reproduced),
            ledger.counted(),
            with(Verdict::WithCorrections),
        ),
        format!(
            "Fig. 8 comes from defects of the Appendix’s program ({} make its motion, {} its digits), which gives {} published numbers; the \
             equations give {}.",
            least(Cell::gives_class),
            least(Cell::gives_digits),
            gives(&ClaimId::FOUR, &by(Reading::AsPrinted)),
            gives(&ClaimId::FOUR, &by(Reading::Exact)),
        ),
        format!(
            "Of Figs. 10–12 the corrected equations give {} captioned classes{}; {} exponents are undeterminable, for the settings behind \
             them are not stated.",
            gives(
                &SpectrumFigure::ALL.map(SpectrumFigure::class),
                &by(Reading::Corrected)
            ),
            unlike(ledger),
            gives(exponents.as_flattened(), &|entry| entry.verdict
                == Verdict::Undeterminable),
        ),
    ]
}

/// How many verdicts stand or fall with the one corrected model of Figs. 10–12.
pub(super) fn resting(ledger: &Ledger) -> String {
    let with = |is: &dyn Fn(&&Entry) -> bool| ledger.entries.iter().filter(is).count();
    let corrected = |one: &&Entry| one.verdict == Verdict::WithCorrections;
    let model =
        |one: &&Entry| corrected(one) && one.corrections.contains(&Correction::BracketSigns);
    format!(
        "{} of the {} claims {} rest on one corrected model, that of Figs. 10–12.",
        with(&model),
        with(&corrected),
        Verdict::WithCorrections
    )
}

/// The captioned classes that the corrected equations do not give, in brackets.
fn unlike(ledger: &Ledger) -> String {
    let of = |figure: SpectrumFigure| {
        let entry = ledger.entry(figure.class());
        let found = entry
            .reading(Reading::Corrected)
            .filter(|one| !one.agrees)?;
        let (name, published) = (part_of(&entry.claim), &entry.claim.published);
        let class = ledger.computed.bracket[figure as usize].exact.class;
        Some(match (class, published.parse()) {
            (Class::Periodic(loops), Ok(Class::Periodic(captioned))) => {
                let plural = if loops == 1 { "" } else { "s" };
                format!("{name} closes after {loops} loop{plural}, not {captioned}")
            }
            _ => format!("{name} is {}, not {published}", found.text()),
        })
    };
    let all: Vec<String> = SpectrumFigure::ALL.into_iter().filter_map(of).collect();
    match &all[..] {
        [] => String::new(),
        all => format!(" ({})", join(all)),
    }
}

/// What was found of Figs. 10–12 and of the search over their readings.
pub(super) fn figs_10_to_12(ledger: &Ledger) -> String {
    let classes = SpectrumFigure::ALL.map(|figure| ledger.entry(figure.class()));
    let exponents = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    let exponents = exponents.as_flattened().iter();
    let exponents: Vec<&Entry> = exponents.map(|id| ledger.entry(*id)).collect();
    let met = |entry: &&&Entry| {
        matches!(
            entry.verdict,
            Verdict::Reproduced | Verdict::WithCorrections
        )
    };
    let count = |verdict| {
        let with = exponents.iter().filter(|one| one.verdict == verdict);
        with.count()
    };
    let remarks = || exponents.iter().filter_map(|entry| entry.remark.as_ref());
    let signs = remarks().filter(|remark| remark.sign_agrees()).count();
    let within = remarks().filter(|remark| remark.within_range()).count();
    let printed = classes
        .iter()
        .filter_map(|entry| entry.reading(Reading::AsPrinted));
    let diverging = printed.filter(|one| one.text() == DIVERGES).count();
    let search = &ledger.spread.search;
    format!(
        "Figs. 10–12 publish {} classes of motion. The corrected equations give {} of them{}. With the signs as printed {diverging} of the three \
         motions diverge. Of the {} published exponents {} are {}: settings of the estimator that the paper does not state decide \
         their digits; {}: {}. {signs} have the computed sign, {within} lie inside what those of {} settings give that identify them. A search over {} ways to read and \
         evaluate the figures ({}) finds {} of its {} pairs of equations and integrator with all three captioned classes, and {} with the same \
         kinds of motion, loops aside. {} {}",
        classes.len(),
        classes.iter().filter(|entry| met(entry)).count(),
        unlike(ledger),
        exponents.len(),
        count(Verdict::Undeterminable),
        Verdict::Undeterminable,
        Verdict::NotReproduced,
        count(Verdict::NotReproduced),
        search.spread[0][0].settings,
        search.configurations,
        search.cited(),
        search.pairs.classes,
        search.pairs.all,
        search.pairs.kinds,
        lead(search),
        together(search),
    )
}

/// What becomes of the figure that one configuration comes nearest to, in view of the three that
/// were looked at.
fn lead(search: &Committed) -> String {
    let percent = |(level, _): &(Level, Match)| level.random.percent();
    let each: [String; 3] = [0, 1, 2].map(|figure| {
        let level = &search.alone[figure].0;
        format!(
            "{:.1} % and {:.1} % for Fig. {}",
            level.random.best_of_three(),
            level.readings.percent(),
            figure + 10
        )
    });
    let nearest =
        (0..3).min_by(|&a, &b| percent(&search.alone[a]).total_cmp(&percent(&search.alone[b])));
    let figure = nearest.unwrap_or(0);
    let (level, found) = &search.alone[figure];
    format!(
        "Each figure by itself, as many random targets (the best of three looks) and spectra of other readings are met as well as its \
         exponents: {}. The nearest, Fig. {}, is {} match; its reading ({}; {}) {}.",
        join(&each),
        figure + 10,
        if level.is_rare(3) {
            "a rare"
        } else {
            "no rare"
        },
        found.reading,
        found.integrator,
        if (0..3).all(|f| found.classes[f].is_of_kind(f)) {
            "has all three kinds of motion".to_owned()
        } else {
            format!("is no match: it leaves {}", found.others(figure))
        }
    )
}

/// What the nearest configuration of those that can count is worth.
fn together(search: &Committed) -> String {
    let [kept, ranked] = &search.together;
    format!(
        "Taken together, the twelve exponents single out {} setting. By the {} configurations with all three kinds of motion ({}) {:.0} % of \
         random targets and {:.1} % of the {} spectra of other readings are met as well; by the {} that keep all three motions {:.0} % and {:.1} %.",
        if ranked.is_rare(1) { "a" } else { "no" },
        search.ranked,
        sources_in_words(search.ranked_from),
        ranked.random.percent(),
        ranked.readings.percent(),
        ranked.readings.of,
        search.kept,
        kept.random.percent(),
        kept.readings.percent(),
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
