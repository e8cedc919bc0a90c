//! What the table says, in words.

use std::fmt::Write;

use super::chance::{self, Level};
use super::counts::{self, DigitsMet, Exponents, Pairs};
use super::error::ReadingsError;
use super::plan::{DT, Group, Part, Plan};
use super::row::Row;
use super::score::{CAP, FLOOR, Twelve};
use super::search;
use super::spread::{ExponentSpread, described, median};

/// The text of `readings.txt`.
///
/// # Errors
/// [`ReadingsError::Published`] if a published exponent is missing.
pub fn summary(plan: &Plan, rows: &[Row], target: &Twelve) -> Result<String, ReadingsError> {
    let published = counts::exponents()?;
    let of = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).collect();
    let search: Vec<&Row> = of(&|row| row.key[0] == Part::Search.name());
    let spread: Vec<&Row> = of(&|row| Group::recommended().has(row));
    let kept: Vec<&Row> = of(&|row| row.key[0] == Part::Search.name() && row.keeps_all());
    let mut text = tried(plan, &search);
    if let Some(alone) = chance::alone(&search, target, plan.draws) {
        text += &motions(&counts::pairs(&search));
        text += &each_alone(plan, alone, target);
    }
    if !kept.is_empty() {
        text += &best(&kept, target, &published);
        text += &together(plan, &kept, target);
    }
    if !spread.is_empty() {
        text += &own_spread(&spread, target, &published);
    }
    Ok(text)
}

/// Writing into a string cannot fail.
macro_rules! line {
    ($text:expr, $($rest:tt)*) => {{ let _ = writeln!($text, $($rest)*); }};
}

fn tried(plan: &Plan, search: &[&Row]) -> String {
    let mut text = String::new();
    let total: usize = plan
        .groups
        .iter()
        .map(|group| plan.settings_of(group))
        .map(|all| all.iter().filter(|one| one.0 == Part::Search).count())
        .sum();
    line!(
        text,
        "stickslip readings: {} search, t from {}, {} points at dt = {DT}\n",
        plan.name,
        plan.from,
        plan.points
    );
    line!(
        text,
        "Tried: {} of {total} configurations (reading x integrator x estimator settings), each for all three figures.",
        search.len()
    );
    if search.len() < total {
        line!(text, "The search is not complete: run it again to go on.");
    }
    text
}

/// What becomes of the three motions, and what each integrator makes of Fig. 11.
fn motions(pairs: &[&Row]) -> String {
    let mut text = String::new();
    let count = Pairs::count(pairs);
    line!(
        text,
        "Of {} pairs of reading and integrator {} keep all three motions. As captioned, loops and all, Fig. 10 is in {}, Fig. 11 in {}, Fig. 12 in {}, \
         all three in {}.\nIn kind, periodic with any number of loops passing for Fig. 10: {}, {}, {}, all three in {}.\n",
        count.all,
        count.kept,
        count.class[0],
        count.class[1],
        count.class[2],
        count.classes,
        count.kind[0],
        count.kind[1],
        count.kind[2],
        count.kinds
    );
    line!(
        text,
        "By integrator: readings that keep all three motions, that have all three kinds; and of Fig. 11 where it stays: how often it is quasi-periodic,\n\
         half the extent of x1, correlation dimension of the section:"
    );
    let mut integrators: Vec<&str> = Vec::new();
    for row in pairs {
        if !integrators.contains(&row.key[2].as_str()) {
            integrators.push(&row.key[2]);
        }
    }
    for integrator in integrators {
        let of: Vec<&Row> = pairs
            .iter()
            .copied()
            .filter(|row| row.key[2] == integrator)
            .collect();
        let (all, stays) = (Pairs::count(&of), |row: &&&Row| row.classes[1].stays());
        let range = |size: usize| {
            let values = || of.iter().filter(stays).map(|row| row.sizes[1][size]);
            let (least, most) = (
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            );
            format!("{least:.2} to {most:.2}")
        };
        let _ = write!(
            text,
            "  {integrator:<20} {:>2} of {}, {}",
            all.kept, all.all, all.kinds
        );
        match of.iter().filter(stays).count() {
            0 => line!(text, "; Fig. 11 stays in none"),
            count => line!(
                text,
                "; Fig. 11 {} of {count}, {}, {}",
                all.kind[1],
                range(0),
                range(1)
            ),
        }
    }
    line!(
        text,
        "\nDistance: root mean square of |found - published| / (|published| + {FLOOR}), each at most {CAP}; a missing or infinite \
         exponent counts {CAP}.\nExponents in descending order, those marked ? (unidentified) or * (starved or unpredictable) included.\n"
    );
    text
}

/// The nearest of all rows to each figure, and whether it can count.
fn each_alone(plan: &Plan, alone: [(Level, &Row); 3], target: &Twelve) -> String {
    let mut text = String::new();
    for (figure, (level, row)) in alone.iter().enumerate() {
        line!(
            text,
            "Nearest to Fig. {} alone, motions aside:",
            figure + 10
        );
        describe(&mut text, row);
        exponents(&mut text, row, target, figure);
        text += &level_of(level);
        line!(
            text,
            "  three figures were looked at: the best of three is met so well by chance in {:.1} %",
            level.random.best_of_three()
        );
        let classes = search::motions(plan, row).join(", ");
        line!(
            text,
            "  its motions: {classes}{}\n",
            if row.is_ranked() {
                ""
            } else {
                ": a reading that loses a figure or gives it another kind of motion is no match and is not ranked"
            }
        );
    }
    text
}

fn best(kept: &[&Row], target: &Twelve, published: &Exponents) -> String {
    let mut text = String::new();
    let by_kind = least(kept, Row::kinds_first);
    let by_exponents = least(kept, |row| ((), row.scores[3]));
    for (what, row) in [
        ("Best common setting (kinds of motion first):", by_kind),
        (
            "Nearest exponents of readings that keep all three motions, not ranked without all three kinds:",
            by_exponents,
        ),
    ] {
        let Some(row) = row else { continue };
        line!(text, "{what}");
        describe(&mut text, row);
        for figure in 0..3 {
            exponents(&mut text, row, target, figure);
        }
        line!(
            text,
            "  distance {:.3}; {} of 3 kinds of motion, {} of 3 classes; {} of 12 exponents to the printed digits\n",
            row.scores[3],
            row.kinds_right(),
            row.classes_right(),
            DigitsMet::count(&[row], published).most
        );
    }
    text
}

/// The first of the rows with the least key.
pub fn least<'a, K: PartialOrd>(rows: &[&'a Row], key: impl Fn(&Row) -> K) -> Option<&'a Row> {
    let mut best: Option<(&Row, K)> = None;
    for &row in rows {
        let k = key(row);
        if best.as_ref().is_none_or(|(_, least)| k < *least) {
            best = Some((row, k));
        }
    }
    best.map(|(row, _)| row)
}

fn describe(text: &mut String, row: &Row) {
    line!(text, "  reading     {}", row.key[1]);
    line!(text, "  integrator  {}", row.key[2]);
    line!(text, "  estimator   {}", row.key[3]);
}

fn exponents(text: &mut String, row: &Row, target: &Twelve, figure: usize) {
    let _ = write!(text, "  Fig. {}  ", figure + 10);
    for k in 0..4 {
        let mark = match row.statuses[figure][k].as_str() {
            "unidentified" => "?",
            "ok" | "annihilated" => " ",
            _ => "*",
        };
        let _ = write!(text, "{:+.4}{mark} ", row.exponents[figure][k]);
    }
    let _ = write!(text, " published");
    for value in target[figure] {
        let _ = write!(text, " {value:+.4}");
    }
    line!(text, "  {}", row.classes[figure]);
}

fn together(plan: &Plan, kept: &[&Row], target: &Twelve) -> String {
    let mut text = String::new();
    let ranked: Vec<&Row> = kept.iter().copied().filter(|row| row.is_ranked()).collect();
    line!(text, "Chance level, all twelve exponents together:");
    for (rows, which) in [
        (kept, "whose reading keeps all three motions"),
        (&ranked, "with all three kinds of motion, which are ranked"),
    ] {
        let from = counts::sources_in_words(counts::sources(rows));
        line!(text, "  {} configurations {which} ({from}):", rows.len());
        text += &level_of(&Level::of(rows, kept, (target, &[0, 1, 2]), plan.draws));
    }
    line!(
        text,
        "Random targets: a zero exponent evenly from -{} to {}; a negative one from -{} to -{}, a positive one from {} to {}, their logarithms\n\
         evenly; periodic 0 - - -, quasi-periodic 0 0 - -, chaotic + 0 - -. Spectra of other readings: those with the published signs where the published\n\
         size is above {}, each compared with the rows of other readings; one that gives the same spectrum to the last bit is the same reading by another name.\n",
        chance::ZERO,
        chance::ZERO,
        chance::NEGATIVE.1,
        chance::NEGATIVE.0,
        chance::POSITIVE.0,
        chance::POSITIVE.1,
        chance::ZERO
    );
    text
}

/// How well other targets are met.
fn level_of(level: &Level) -> String {
    format!(
        "  distance {:.3}; as near or nearer are {} of {} random targets ({:.2} %) and {} of {} spectra that other readings give ({:.1} %)\n",
        level.published,
        level.random.met,
        level.random.of,
        level.random.percent(),
        level.readings.met,
        level.readings.of,
        level.readings.percent()
    )
}

fn own_spread(spread: &[&Row], target: &Twelve, exponents: &Exponents) -> String {
    let mut text = String::new();
    line!(
        text,
        "The estimator's own spread: the recommended reading ({}; {}) under {} settings",
        spread[0].key[1],
        spread[0].key[2],
        spread.len()
    );
    line!(
        text,
        "({}; and those of the search), same three series throughout; ranges of the settings that identify the exponent:",
        described()
    );
    line!(
        text,
        "  exponent          min    median       max   published   unidentified   starved or unpredictable   published digits"
    );
    let mut widths = Vec::new();
    for (figure, published) in target.iter().enumerate() {
        for (k, published) in published.iter().enumerate() {
            let of = ExponentSpread::of(spread, (figure, k), exponents);
            let Some(values) = of.values else {
                line!(
                    text,
                    "  fig{}.lambda.{}   identified by none {published:>21.4}   {:>2} of {:<15} {:<26} {}",
                    figure + 10,
                    k + 1,
                    of.unidentified,
                    of.settings,
                    of.doubtful,
                    of.met
                );
                continue;
            };
            widths.push(values.largest - values.least);
            line!(
                text,
                "  fig{}.lambda.{}  {:>9.4} {:>9.4} {:>9.4}   {:>9.4}   {:>2} of {:<15} {:<26} {}",
                figure + 10,
                k + 1,
                values.least,
                values.median,
                values.largest,
                published,
                of.unidentified,
                of.settings,
                of.doubtful,
                of.met
            );
        }
    }
    widths.sort_by(f64::total_cmp);
    if let (Some(least), Some(median), Some(most)) =
        (widths.first(), median(&widths), widths.last())
    {
        line!(
            text,
            "The settings, which the paper does not state, move the {} exponents that some of them identify by {least:.4} to {most:.4}, median {median:.4}:\n\
             {:.0} units of the fourth printed decimal.",
            widths.len(),
            median / 1e-4
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_ranked_where_nothing_was_tried() {
        let target = super::super::score::target().unwrap();
        let text = summary(&Plan::quick(), &[], &target).unwrap();
        assert!(text.contains("Tried: 0 of 8") && text.contains("not complete"));
        assert!(!text.contains("pairs of") && !text.contains("Distance"));
    }
}
