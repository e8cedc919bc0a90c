//! The verdict in a few sentences, with every number formatted from the run. They open the page and
//! the README.

use super::exponent::ExponentCheck;
use super::ledger::{Entry, Ledger};
use super::matrix::ComparedRun;
use super::verdict::{Correction, Verdict};
use crate::figures::block_and_bracket::DIVERGES;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::published::Claim;
use crate::paper::reading::Reading;
use crate::readings::{CommittedSearch, Match, other_motions, sources_in_words};
use stickslip::analysis::motion::Class;

/// The parts of the paper in which claims are counted: keys in `data/claims.csv` and names.
pub(super) const PARTS: [(&str, &str); 9] = [
    ("sect2", "Sect. 2, Eqs. (8)–(16)"),
    ("fig4", "Fig. 4"),
    ("henon", "Abstract, Sect. 3: the Hénon step"),
    ("fig7", "Sect. 4.1, Eqs. (19)–(24), Figs. 6, 7"),
    ("fig8", "Sect. 4.2, Fig. 8"),
    ("fig10", "Fig. 10"),
    ("fig11", "Fig. 11"),
    ("fig12", "Fig. 12"),
    ("sect5", "Sects. 5.2, 6"),
];

/// The name of the part to which a claim belongs.
fn part_of(claim: &Claim) -> &'static str {
    let entry = PARTS.iter().find(|(part, _)| *part == claim.part);
    entry.map_or("", |(_, name)| name)
}

/// The verdict in three sentences: all claims, Fig. 8, and Figs. 10–12.
pub(super) fn sentences(ledger: &Ledger) -> [String; 3] {
    let gives = |ids: &[ClaimId], met: &dyn Fn(&Entry) -> bool| {
        let count = ids.iter().filter(|id| met(ledger.entry(**id))).count();
        format!("{count} of {}", ids.len())
    };
    let by = |reading| move |entry: &Entry| entry.reading(reading).is_some_and(|one| one.agrees);
    let least = |property| {
        let least = ledger.matrix.minimal(property).into_iter().next();
        least.map_or(0, |cell| cell.present.present().count())
    };
    let classes = SpectrumFigure::ALL.map(SpectrumFigure::class);
    let exponents = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    let open = |entry: &Entry| entry.verdict == Verdict::Undeterminable;
    let (stated, counted) = (ledger.with(Verdict::Reproduced), ledger.counted());
    let corrected = ledger.with(Verdict::WithCorrections);
    let clipped = ledger.entries.iter().filter(|one| {
        one.verdict == Verdict::WithCorrections
            && one.corrections.contains(&Correction::ClippedNormalForce)
    });
    let clipped = clipped.count();
    let (motion, digits) = (
        least(ComparedRun::gives_class),
        least(ComparedRun::gives_digits),
    );
    let printed = gives(&ClaimId::STICK_NUMBERS, &by(Reading::AsPrinted));
    let exact = gives(&ClaimId::STICK_NUMBERS, &by(Reading::Exact));
    let (classes, differing_classes) = (
        gives(&classes, &by(Reading::Corrected)),
        differing_classes(ledger),
    );
    let exponents = gives(exponents.as_flattened(), &open);
    [
        format!(
            "The paper’s equations, solved accurately, bear out {stated} of its {counted} claims \
                as they stand and {corrected} more with corrections ({clipped} of these with a \
                contact that cannot pull, which the paper does not say)."
        ),
        format!(
            "Fig. 8 comes from defects of the Appendix’s program ({motion} make its motion, \
             {digits} its digits), which gives {printed} published numbers; the equations give \
             {exact}."
        ),
        format!(
            "Of Figs. 10–12 the corrected equations give {classes} captioned \
             classes{differing_classes}; {exponents} exponents are undeterminable, for the \
             settings behind them are not stated."
        ),
    ]
}

/// The number of verdicts that depend on the corrected model of Figs. 10–12.
pub(super) fn dependent_verdicts(ledger: &Ledger) -> String {
    let verdict = Verdict::WithCorrections;
    let model = |one: &&Entry| {
        one.verdict == verdict && one.corrections.contains(&Correction::BracketSigns)
    };
    let model = ledger.entries.iter().filter(model).count();
    let all = ledger.with(verdict);
    format!(
        "{model} of the {all} claims {verdict} rest on one corrected model, that of Figs. 10–12."
    )
}

/// The captioned classes that the corrected equations do not give, in brackets.
fn differing_classes(ledger: &Ledger) -> String {
    let of = |figure: SpectrumFigure| {
        let entry = ledger.entry(figure.class());
        let corrected = entry.reading(Reading::Corrected)?;
        if corrected.agrees {
            return None;
        }
        let (name, published) = (part_of(&entry.claim), &entry.claim.published);
        let class = ledger.computed.bracket[figure as usize].exact.class;
        Some(match (class, published.parse()) {
            (Class::Periodic(loops), Ok(Class::Periodic(captioned))) => {
                let plural = if loops == 1 { "" } else { "s" };
                format!("{name} closes after {loops} loop{plural}, not {captioned}")
            }
            _ => format!("{name} is {}, not {published}", corrected.text()),
        })
    };
    let all: Vec<String> = SpectrumFigure::ALL.into_iter().filter_map(of).collect();
    match &*join(&all) {
        "" => String::new(),
        all => format!(" ({all})"),
    }
}

/// Figs. 10–12 and the search over their readings.
pub(super) fn figs_10_to_12(ledger: &Ledger) -> String {
    let classes = SpectrumFigure::ALL.map(|figure| ledger.entry(figure.class()));
    let exponents = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    let exponents = exponents.as_flattened().iter();
    let exponents: Vec<&Entry> = exponents.map(|id| ledger.entry(*id)).collect();
    let met = [Verdict::Reproduced, Verdict::WithCorrections];
    let met = classes.iter().filter(|entry| met.contains(&entry.verdict));
    let count = |verdict| {
        let with = exponents.iter().filter(|one| one.verdict == verdict);
        with.count()
    };
    let checks = || exponents.iter().filter_map(|entry| entry.exponent);
    let signs = checks().filter(ExponentCheck::sign_agrees).count();
    let within = checks().filter(ExponentCheck::within_range).count();
    let printed = classes.iter();
    let printed = printed.filter_map(|entry| entry.reading(Reading::AsPrinted));
    let diverging = printed.filter(|one| one.text() == DIVERGES).count();
    let (open, missed) = (Verdict::Undeterminable, Verdict::NotReproduced);
    let (of_open, of_missed) = (count(open), count(missed));
    let (met, differing_classes) = (met.count(), differing_classes(ledger));
    let search = &ledger.spread.search;
    let (settings, configurations) = (search.spread[0][0].settings, search.configurations);
    let (citation, pairs) = (search.citation(), &search.pairs);
    let (nearest, joint) = (nearest_single_figure(search), joint_match(search));
    format!(
        "Figs. 10–12 publish {} classes of motion. The corrected equations give {met} of \
         them{differing_classes}. With the signs as printed {diverging} of the three motions \
         diverge. Of the {} published exponents {of_open} are {open}, since their digits depend on \
         settings of the estimator that the paper does not state, and {of_missed} are {missed}. \
         {signs} have the computed sign. {within} lie in the range of the settings that identify \
         them, of {settings} tried. A search over {configurations} configurations of equations, \
         integrator and estimator ({citation}) finds {} of {} pairs of equations and integrator \
         with all three captioned classes, and {} with all three kinds of motion, whatever the \
         number of loops. {nearest} {joint}",
        classes.len(),
        exponents.len(),
        pairs.classes,
        pairs.all,
        pairs.kinds,
    )
}

/// The significance of the configuration nearest to one figure, given that three figures were
/// tried.
fn nearest_single_figure(search: &CommittedSearch) -> String {
    let each = [0, 1, 2].map(|figure| {
        let level = &search.figure_levels[figure].0;
        let (random, readings) = (level.random.best_of_three(), level.readings.percent());
        format!("{random:.1} % and {readings:.1} % for Fig. {}", figure + 10)
    });
    let percent = |figure: &usize| search.figure_levels[*figure].0.random.percent();
    let nearest = (0..3).min_by(|a, b| percent(a).total_cmp(&percent(b)));
    let figure = nearest.unwrap_or(0);
    let (level, Match { row, motions }) = &search.figure_levels[figure];
    let rare = if level.is_rare(3) {
        "a rare"
    } else {
        "not a rare"
    };
    let leaves = match row.is_ranked() {
        true => "has all three kinds of motion".to_owned(),
        false => format!("is no match: it gives {}", other_motions(motions, figure)),
    };
    let (reading, integrator) = (row.reading(), row.integrator());
    format!(
        "For each figure alone, the shares of random targets (best of three figures) and of \
         spectra of other readings that are matched as well as its exponents are: {}. The nearest, \
         Fig. {}, is {rare} match; its reading ({reading}; {integrator}) {leaves}.",
        join(&each),
        figure + 10,
    )
}

/// The significance of the nearest configuration among those that count.
fn joint_match(search: &CommittedSearch) -> String {
    let [kept, ranked] = search.joint_levels.each_ref().map(|level| {
        let (random, readings) = (level.random.percent(), level.readings.percent());
        (random, readings, level.readings.of)
    });
    let is_rare = search.joint_levels[1].is_rare(1);
    let single = if is_rare { "a" } else { "no" };
    let sources = sources_in_words(search.ranked_from);
    format!(
        "Together, the twelve exponents single out {single} setting. The {} configurations with \
         all three kinds of motion ({sources}) match {:.0} % of random targets and {:.1} % of the \
         {} spectra of other readings as well; the {} with three bounded motions match {:.0} % and \
         {:.1} %.",
        search.ranked, ranked.0, ranked.1, ranked.2, search.kept, kept.0, kept.1,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::published::Claims;

    #[test]
    fn every_claim_belongs_to_a_part_of_the_paper() {
        for claim in Claims::committed().unwrap().iter() {
            assert_ne!(part_of(claim), "", "{}", claim.id);
        }
    }
}
