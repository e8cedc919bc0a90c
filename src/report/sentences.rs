//! The finding in a few sentences, with every number formatted from the run. They open the page and
//! the README.

use super::ledger::{Entry, Ledger};
use super::matrix::ComparedRun;
use super::verdict::Verdict;
use crate::motion::Class;
use crate::paper::claim_id::{ClaimId, SpectrumFigure};
use crate::paper::published::{Claim, Group};
use crate::paper::reading::Reading;
use crate::readings::{CommittedSearch, Match, other_motions, sources_in_words};

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
    ("sect5", "Sects. 5, 6"),
];

/// The name of the part to which a claim belongs.
fn part_of(claim: &Claim) -> &'static str {
    let entry = PARTS.iter().find(|(part, _)| *part == claim.part);
    entry.map_or("", |(_, name)| name)
}

/// The finding: Fig. 8, the algebra, Figs. 10–12, and all claims.
pub(super) fn sentences(ledger: &Ledger) -> [String; 4] {
    [
        fig_8(ledger),
        algebra(ledger),
        figs_10_to_12(ledger),
        all_claims(ledger),
    ]
}

fn fig_8(ledger: &Ledger) -> String {
    let gives = |reading| {
        let agrees = |id: &&ClaimId| {
            ledger
                .entry(**id)
                .reading(reading)
                .is_some_and(|one| one.agrees)
        };
        let all = ClaimId::STICK_NUMBERS;
        format!("{} of {}", all.iter().filter(agrees).count(), all.len())
    };
    let least = |property| {
        let least = ledger.matrix.minimal(property).into_iter().next();
        least.map_or(0, |cell| cell.present.present().count())
    };
    let (motion, digits) = (
        least(ComparedRun::gives_class),
        least(ComparedRun::gives_digits),
    );
    let (printed, exact) = (gives(Reading::AsPrinted), gives(Reading::Exact));
    format!(
        "Fig. 8’s stick–slip is not a solution of the paper’s equations: solved accurately, they \
         settle on no stick from its start and give {exact} of its published numbers. {motion} \
         faults together make the motion: one slip of programming (a list is a reference, so that \
         the program overwrites its own state and slip runs three times too fast) and one gap in \
         the method (Sect. 3 tests one end of the moving stick zone only). With the {digits} \
         defects that its digits need, the printed program gives {printed} numbers."
    )
}

fn algebra(ledger: &Ledger) -> String {
    // Claims of a group that hold as they stand, and all of them.
    let of = |group: Group| {
        let of = |one: &&Entry| one.claim.group == group;
        let holds = |one: &&Entry| of(one) && one.verdict == Verdict::Reproduced;
        let entries = || ledger.entries.iter();
        [
            entries().filter(holds).count(),
            entries().filter(of).count(),
        ]
    };
    let [[holding, all], [alike, printed]] = [Group::Algebra, Group::Print].map(of);
    let computed = ledger.with(Verdict::Reproduced) - holding - alike;
    format!(
        "The printed algebra of Sects. 2–4 is right: {holding} of {all} claims follow from its \
         polynomials. {alike} of {printed} comparisons of printed numbers hold. Of the claims that \
         take a computation, {computed} hold as they stand."
    )
}

fn figs_10_to_12(ledger: &Ledger) -> String {
    let classes = SpectrumFigure::ALL.map(|figure| ledger.entry(figure.class()));
    let with = |verdict| classes.iter().filter(move |one| one.verdict == verdict);
    let corrected = with(Verdict::WithCorrections).count();
    let assumed = with(Verdict::UnderAssumption);
    let assumed: Vec<String> = assumed
        .map(|one| {
            format!(
                "{} only under an added assumption, a contact that cannot pull",
                part_of(&one.claim)
            )
        })
        .collect();
    let notes = assumed.iter().cloned().chain(differing_classes(ledger));
    let notes = notes.collect::<Vec<_>>().join("; ");
    let exponents = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    let exponents = exponents.as_flattened();
    let count = |verdict| {
        let of = exponents
            .iter()
            .filter(|id| ledger.entry(**id).verdict == verdict);
        of.count()
    };
    let settings = ledger.spread.search.recommended.len();
    format!(
        "Of Figs. 10–12, {} of {} have their captioned class after listed corrections ({notes}). \
         Of {} exponents, {} are given by none of {settings} settings of the estimator, and {} are \
         undeterminable.",
        corrected + assumed.len(),
        classes.len(),
        exponents.len(),
        count(Verdict::NotReproduced),
        count(Verdict::Undeterminable),
    )
}

fn all_claims(ledger: &Ledger) -> String {
    let counts = ledger
        .counts()
        .map(|(verdict, count)| format!("{count} {verdict}"));
    let identities = ledger.entries.len() - ledger.counted();
    format!(
        "Of {} claims in all: {}. {identities} more could not come out otherwise and are not \
         counted.",
        ledger.counted(),
        counts.join(", ")
    )
}

/// The captioned classes that the corrected equations do not give.
fn differing_classes(ledger: &Ledger) -> impl Iterator<Item = String> {
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
    SpectrumFigure::ALL.into_iter().filter_map(of)
}

/// The search over the readings of Figs. 10–12.
pub(super) fn search(search: &CommittedSearch) -> [String; 3] {
    let (configurations, citation, pairs) =
        (search.configurations, search.citation(), &search.pairs);
    [
        format!(
            "A search over {configurations} configurations of equations, integrator and estimator \
             ({citation}) finds {} of {} pairs of equations and integrator with all three \
             captioned classes, and {} with all three kinds of motion, whatever the number of \
             loops.",
            pairs.classes, pairs.all, pairs.kinds,
        ),
        nearest_single_figure(search),
        joint_match(search),
    ]
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
