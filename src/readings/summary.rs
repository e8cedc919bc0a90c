//! The results of the search in words: `readings.txt`.

use super::plan::{DIFFERENCE_CAP, Plan, SEARCH, ZERO_SIZE};
use super::scoring::{
    ExponentSpread, PairCounts, RowsByRole, count_matching, for_each_exponent, sources,
    sources_in_words,
};
use super::search;
use super::settings::spread_in_words;
use super::significance::{self, MatchLevel};
use super::table::{ConfigurationRow, OrbitVerdict, Twelve};
use crate::figures::block_and_bracket::DT;
use crate::numbers::{extent, median};
use crate::paper::published::LAST_DIGIT;
use crate::text::distinct;

/// The text of `readings.txt`.
pub fn summary(plan: &Plan, rows: &[ConfigurationRow]) -> String {
    let rows = RowsByRole::of(rows);
    let mut text = tried(plan, rows.search.len());
    let levels = significance::single_figure_levels(&rows.search, &plan.target, plan.draws);
    if let Some(levels) = levels {
        text += &motions(&rows.pairs);
        let each = levels.into_iter().enumerate();
        text.extend(each.map(|(figure, one)| nearest(plan, figure, one)));
    }
    if !rows.kept.is_empty() {
        text += &best(plan, &rows.kept);
        text += &joint_chance_levels(plan, &rows);
    }
    if !rows.recommended.is_empty() {
        text += &own_spread(plan, &rows.recommended);
    }
    text
}

fn tried(plan: &Plan, done: usize) -> String {
    let settings = plan.groups.iter().flat_map(|group| plan.settings_of(group));
    let total = settings.filter(|one| one.0 == SEARCH).count();
    let Plan { from, points, .. } = plan;
    format!(
        "stickslip readings: full search, t from {from}, {points} points at dt = {DT}\n\n\
         Tried: {done} of {total} configurations (reading x integrator x estimator settings), each \
         for all three figures.\n"
    )
}

/// The classes of the three motions, and Fig. 11 by each integrator.
fn motions(pairs: &[&ConfigurationRow]) -> String {
    let PairCounts {
        all,
        kept,
        class: [c10, c11, c12],
        classes,
        kind: [k10, k11, k12],
        kinds,
    } = PairCounts::count(pairs);
    let integrators = distinct(pairs.iter().map(|row| row.integrator()));
    let by_integrator = integrators.into_iter().map(|integrator| {
        let of = pairs.iter().copied();
        let of: Vec<&ConfigurationRow> = of.filter(|row| row.integrator() == integrator).collect();
        let count = PairCounts::count(&of);
        let (all, kept, kinds, quasi_periodic) =
            (count.all, count.kept, count.kinds, count.kind[1]);
        let bounded: Vec<&&ConfigurationRow> = of
            .iter()
            .filter(|row| row.classes[1].is_bounded())
            .collect();
        let range = |size: usize| {
            let (least, most) = extent(bounded.iter().map(|row| row.sizes[1][size]));
            format!("{least:.2} to {most:.2}")
        };
        let of_fig11 = match bounded.len() {
            0 => "stays in none".to_owned(),
            count => format!("{quasi_periodic} of {count}, {}, {}", range(0), range(1)),
        };
        format!("  {integrator:<20} {kept:>2} of {all}, {kinds}; Fig. 11 {of_fig11}\n")
    });
    let by_integrator: String = by_integrator.collect();
    format!(
        "Of {all} pairs of reading and integrator {kept} keep all three motions. As captioned, \
         loops and all, Fig. 10 is in {c10}, Fig. 11 in {c11}, Fig. 12 in {c12}, all three in \
         {classes}.\n\
         In kind, periodic with any number of loops passing for Fig. 10: {k10}, {k11}, {k12}, all \
         three in {kinds}.\n\n\
         By integrator: readings that keep all three motions, that have all three kinds; and of \
         Fig. 11 where it stays: how often it is quasi-periodic,\n\
         half the extent of x1, correlation dimension of the section:\n\
         {by_integrator}\n\
         Distance: root mean square of |found - published| / (|published| + {ZERO_SIZE}), each at \
         most {DIFFERENCE_CAP}; a missing or infinite exponent counts {DIFFERENCE_CAP}.\n\
         Exponents in descending order, those marked ? (unidentified) or * (starved or \
         unpredictable) included.\n\n"
    )
}

/// The row nearest to a figure, and whether it can count.
fn nearest(plan: &Plan, figure: usize, (level, row): (MatchLevel, &ConfigurationRow)) -> String {
    let (described, exponents) = (describe(row), exponents(row, &plan.target, figure));
    let percent = level.random.best_of_three();
    let motions = search::motions(plan, row).join(", ");
    let counts = match row.is_ranked() {
        true => "",
        false => {
            ": a reading that loses a figure or gives it another kind of motion is no match and is \
                not ranked"
        }
    };
    let (figure, level) = (figure + 10, level_of(&level));
    format!(
        "Nearest to Fig. {figure} alone, motions aside:\n\
         {described}{exponents}{level}  three figures were looked at: the best of three is met so \
         well by chance in {percent:.1} %\n  \
         its motions: {motions}{counts}\n\n"
    )
}

fn best(plan: &Plan, kept: &[&ConfigurationRow]) -> String {
    let of = |(what, row): (&str, Option<&ConfigurationRow>)| {
        let row = row?;
        let (described, distance) = (describe(row), row.scores[3]);
        let exponents: String = (0..3).map(|f| exponents(row, &plan.target, f)).collect();
        let kinds = row.right(OrbitVerdict::is_of_kind);
        let classes = row.right(OrbitVerdict::is_published);
        let met = for_each_exponent(|exponent| count_matching(&[row], exponent, &plan.published));
        let met: usize = met.as_flattened().iter().sum();
        Some(format!(
            "{what}\n\
                {described}{exponents}  distance {distance:.3}; {kinds} of 3 kinds of motion, \
                {classes} of 3 classes; {met} of 12 exponents to the printed digits\n\n"
        ))
    };
    let by_kind = "Best common setting (kinds of motion first):";
    let by_exponents = "Nearest exponents of readings that keep all three motions, not ranked \
        without all three kinds:";
    let both = [
        (by_kind, minimal_by(kept, ConfigurationRow::kinds_first)),
        (by_exponents, minimal_by(kept, |row| ((), row.scores[3]))),
    ];
    both.into_iter().filter_map(of).collect()
}

/// The first of the rows with the smallest key.
pub fn minimal_by<'a, K: PartialOrd>(
    rows: &[&'a ConfigurationRow],
    key: impl Fn(&ConfigurationRow) -> K,
) -> Option<&'a ConfigurationRow> {
    let lesser = |one: &'a ConfigurationRow, other| if key(other) < key(one) { other } else { one };
    rows.iter().copied().reduce(lesser)
}

fn describe(row: &ConfigurationRow) -> String {
    let [_, reading, integrator, settings] = &row.key;
    format!("  reading     {reading}\n  integrator  {integrator}\n  estimator   {settings}\n")
}

fn exponents(row: &ConfigurationRow, target: &Twelve, figure: usize) -> String {
    let values = row.exponents[figure].iter().zip(row.statuses[figure]);
    let values = values.map(|(value, status)| {
        let mark = match status {
            "unidentified" => "?",
            "ok" | "annihilated" => " ",
            _ => "*",
        };
        format!("{value:+.4}{mark} ")
    });
    let values: String = values.collect();
    let published = target[figure].iter().map(|value| format!(" {value:+.4}"));
    let (published, class) = (published.collect::<String>(), row.classes[figure]);
    let figure = figure + 10;
    format!("  Fig. {figure}  {values} published{published}  {class}\n")
}

fn joint_chance_levels(plan: &Plan, rows: &RowsByRole) -> String {
    let mut text = String::from("Chance level, all twelve exponents together:\n");
    let kept = "whose reading keeps all three motions";
    let ranked = "with all three kinds of motion, which are ranked";
    for (of, which) in [(&rows.kept, kept), (&rows.ranked, ranked)] {
        let from = sources_in_words(sources(of));
        text += &format!("  {} configurations {which} ({from}):\n", of.len());
        let figures = (&plan.target, &[0, 1, 2][..]);
        text += &level_of(&MatchLevel::of(of, &rows.kept, figures, plan.draws));
    }
    let (zero, negative, positive) = (
        ZERO_SIZE,
        significance::NEGATIVE_SIZES,
        significance::POSITIVE_SIZES,
    );
    text + &format!(
        "Random targets: a zero exponent evenly from -{zero} to {zero}; a negative one from -{} to \
         -{}, a positive one from {} to {}, their logarithms\n\
         evenly; periodic 0 - - -, quasi-periodic 0 0 - -, chaotic + 0 - -. Spectra of other \
         readings: those with the published signs where the published\n\
         size is above {zero}, each compared with the rows of other readings; one that gives the \
         same spectrum to the last bit is the same reading by another name.\n\n",
        negative.1, negative.0, positive.0, positive.1,
    )
}

/// The level of a match among other targets.
fn level_of(level: &MatchLevel) -> String {
    let MatchLevel {
        published,
        random,
        readings,
    } = level;
    let (of_random, of_readings) = (random.percent(), readings.percent());
    format!(
        "  distance {published:.3}; as near or nearer are {} of {} random targets ({of_random:.2} \
            %) and {} of {} spectra that other readings give ({of_readings:.1} %)\n",
        random.matched, random.of, readings.matched, readings.of,
    )
}

fn own_spread(plan: &Plan, spread: &[&ConfigurationRow]) -> String {
    let (reading, integrator) = (spread[0].reading(), spread[0].integrator());
    let (count, settings) = (spread.len(), spread_in_words());
    let mut text = format!(
        "The estimator's own spread: the recommended reading ({reading}; {integrator}) under \
         {count} settings\n\
         ({settings}; and those of the search), same three series throughout; ranges of the \
         settings that identify the exponent:\n  \
         exponent          min    median       max   published   unidentified   starved or \
         unpredictable   published digits\n"
    );
    let mut widths = Vec::new();
    for (figure, k) in for_each_exponent(|exponent| exponent).into_iter().flatten() {
        let of = ExponentSpread::of(spread, (figure, k), &plan.published);
        let published = plan.target[figure][k];
        let values = match of.values {
            Some(values) => {
                let (least, median, most) = (values.least, values.median, values.largest);
                widths.push(most - least);
                format!(" {least:>9.4} {median:>9.4} {most:>9.4}   {published:>9.4}")
            }
            None => format!("  identified by none {published:>21.4}"),
        };
        let (figure, k) = (figure + 10, k + 1);
        let (unidentified, all, doubtful, agreeing) =
            (of.unidentified, of.settings, of.doubtful, of.agreeing);
        text += &format!(
            "  fig{figure}.lambda.{k} {values}   {unidentified:>2} of {all:<15} {doubtful:<26} \
                {agreeing}\n"
        );
    }
    if let Some(median) = median(&widths) {
        let (least, most) = extent(widths.iter().copied());
        let (count, units) = (widths.len(), median / LAST_DIGIT);
        text += &format!(
            "The settings, which the paper does not state, move the {count} exponents that some of \
             them identify by {least:.4} to {most:.4}, median {median:.4}:\n\
             {units:.0} units of the fourth printed decimal.\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_ranked_where_nothing_was_tried() {
        let text = summary(&Plan::full().unwrap(), &[]);
        assert!(text.contains("Tried: 0 of "));
        assert!(!text.contains("pairs of") && !text.contains("Distance"));
    }
}
