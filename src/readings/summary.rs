//! What the table says, in words.

use std::fmt::Write;

use super::chance::{self, Level};
use super::counts::{Pairs, Published, digits_of};
use super::error::ReadingsError;
use super::plan::{DT, Part, Plan};
use super::row::Row;
use super::score::{CAP, FLOOR, Twelve};
use super::spread::{ExponentSpread, described, median};

/// The text of `readings.txt`.
///
/// # Errors
/// [`ReadingsError::Published`] if a published exponent is missing, [`ReadingsError::Class`] if a published class is none.
pub fn summary(plan: &Plan, rows: &[Row], target: &Twelve) -> Result<String, ReadingsError> {
    let published = Published::read()?;
    let of = |part: Part| -> Vec<&Row> {
        let is = |row: &&Row| row.key[0] == part.name();
        rows.iter().filter(is).collect()
    };
    let (search, spread) = (of(Part::Search), of(Part::Spread));
    let mut text = String::new();
    text += &tried(plan, &search, &published);
    if !search.is_empty() {
        text += &best(&search, target, &published);
        text += &level(plan, &search, target);
    }
    if !spread.is_empty() {
        text += &own_spread(&spread, target);
    }
    Ok(text)
}

/// Writing into a string cannot fail.
macro_rules! line {
    ($text:expr, $($rest:tt)*) => { let _ = writeln!($text, $($rest)*); };
}

fn tried(plan: &Plan, search: &[&Row], published: &Published) -> String {
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
    if search.is_empty() {
        return text;
    }
    let pairs = Pairs::count(search, published);
    let classes = published.classes.map(|class| class.to_string());
    line!(
        text,
        "Of {} pairs of reading and integrator, Fig. 10 is {} as captioned in {}, Fig. 11 {} in {}, Fig. 12 {} in {}, all three as captioned in {}.",
        pairs.all,
        classes[0],
        pairs.class[0],
        classes[1],
        pairs.class[1],
        classes[2],
        pairs.class[2],
        pairs.classes
    );
    line!(
        text,
        "In kind, periodic with any number of loops passing for Fig. 10: Fig. 10 in {}, Fig. 11 in {}, Fig. 12 in {}, all three in {}. Ranking and \
         chance level below go by kind.",
        pairs.kind[0],
        pairs.kind[1],
        pairs.kind[2],
        pairs.kinds
    );
    line!(
        text,
        "Distance: root mean square of |found - published| / (|published| + {FLOOR}), each at most {CAP}; a missing or infinite \
         exponent counts {CAP}. Exponents in descending order, those marked ? (unidentified) or * (starved or\n         unpredictable) included.\n"
    );
    text
}

fn best(search: &[&Row], target: &Twelve, published: &Published) -> String {
    let mut text = String::new();
    for figure in 0..3 {
        let key = |row: &Row| (!row.classes[figure].is_of_kind(figure), row.scores[figure]);
        if let Some(row) = least(search, key) {
            line!(
                text,
                "Best for Fig. {} alone (kind of motion first):",
                figure + 10
            );
            describe(&mut text, row);
            exponents(&mut text, row, target, figure);
            line!(text, "  distance {:.3}\n", row.scores[figure]);
        }
    }
    let by_kind = least(search, Row::kinds_first);
    let by_exponents = least(search, |row| ((), row.scores[3]));
    for (what, row) in [
        ("Best common setting (kinds of motion first):", by_kind),
        ("Nearest exponents, motions aside:", by_exponents),
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
            (0..3)
                .filter(|&f| row.classes[f].is(published.classes[f]))
                .count(),
            digits_of(row, published)
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

fn level(plan: &Plan, search: &[&Row], target: &Twelve) -> String {
    let mut text = String::new();
    line!(
        text,
        "Chance level. Random targets: a zero exponent evenly from -{} to {}; a negative one from -{} to -{}, a positive one from {} to \
         {}, their logarithms evenly; periodic 0 - - -, quasi-periodic 0 0 - -, chaotic + 0 - -.\n",
        chance::ZERO,
        chance::ZERO,
        chance::NEGATIVE.1,
        chance::NEGATIVE.0,
        chance::POSITIVE.0,
        chance::POSITIVE.1
    );
    line!(
        text,
        "Exponents only: distance of the nearest of the same configurations (motions aside) to"
    );
    let own = chance::nearest(search, target);
    line!(text, "  the published exponents             {own:.3}");
    for order in chance::ORDERS {
        let distance = chance::nearest(search, &order.map(|figure| target[figure]));
        line!(
            text,
            "  columns exchanged ({})        {distance:.3}",
            columns(order)
        );
    }
    text += &random(&Level::exponents_only(search, target, plan.draws));
    line!(
        text,
        "Kinds of motion first: kinds met, and distance of the nearest of the configurations that meet so many (a different set in each line), to"
    );
    let published = [0, 1, 2];
    let (most, right) = chance::by_kind(search, published);
    let own = chance::nearest(&right, target);
    line!(
        text,
        "  the published figures               {most} of 3  {own:.3}"
    );
    for order in chance::ORDERS {
        let (most, rows) = chance::by_kind(search, order);
        let distance = chance::nearest(&rows, &order.map(|figure| target[figure]));
        line!(
            text,
            "  columns exchanged ({})        {most} of 3  {distance:.3}",
            columns(order)
        );
    }
    line!(
        text,
        "  Of the 27 ways to give three figures these kinds of motion, {} are met entirely by some configuration; {} configurations meet {most} \
         kinds as published.",
        chance::assignments_met(search),
        right.len()
    );
    text += &random(&Level::kinds_first(search, target, plan.draws));
    text
}

fn columns(order: [usize; 3]) -> String {
    order.map(|figure| (figure + 10).to_string()).join(" ")
}

/// How well random targets of the published classes are met.
fn random(level: &Level) -> String {
    let mut text = String::new();
    if level.draws > 0 {
        line!(
            text,
            "  {} random targets of the same classes: least {:.3}, median {:.3}",
            level.draws,
            level.least,
            level.median
        );
    }
    line!(
        text,
        "  {} of {} random targets ({:.1} %) are met as well as the published ones.\n",
        level.as_near,
        level.draws,
        level.percent()
    );
    text
}

fn own_spread(spread: &[&Row], target: &Twelve) -> String {
    let mut text = String::new();
    line!(
        text,
        "The estimator's own spread: the recommended reading ({}; {}) under {} settings",
        spread[0].key[1],
        spread[0].key[2],
        spread.len()
    );
    line!(text, "({}), same three series throughout:", described());
    line!(
        text,
        "  exponent          min    median       max   published   unidentified   starved or unpredictable"
    );
    // Of exponents that are identified in most settings, and of the others.
    let mut widths = [Vec::new(), Vec::new()];
    for (figure, published) in target.iter().enumerate() {
        for (k, published) in published.iter().enumerate() {
            let of = ExponentSpread::of(spread, figure, k);
            let Some(values) = of.values else {
                line!(
                    text,
                    "  fig{}.lambda.{}   no finite value",
                    figure + 10,
                    k + 1
                );
                continue;
            };
            widths[usize::from(of.mostly_unidentified())].push(values.largest - values.least);
            line!(
                text,
                "  fig{}.lambda.{}  {:>9.4} {:>9.4} {:>9.4}   {:>9.4}   {:>2} of {:<15} {}",
                figure + 10,
                k + 1,
                values.least,
                values.median,
                values.largest,
                published,
                of.unidentified,
                of.settings,
                of.doubtful
            );
        }
    }
    line!(text, "The settings, which the paper does not state, move");
    for (widths, which) in widths
        .iter_mut()
        .zip(["identified in most of them", "unidentified in most of them"])
    {
        widths.sort_by(f64::total_cmp);
        if let (Some(least), Some(median), Some(most)) =
            (widths.first(), median(widths), widths.last())
        {
            line!(
                text,
                "  the {} exponents {which} by {least:.4} to {most:.4}, median {median:.4}: {:.0} units of the fourth printed decimal;",
                widths.len(),
                median / 1e-4
            );
        }
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
