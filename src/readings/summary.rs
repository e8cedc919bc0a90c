//! What the table says, in words.

use std::fmt::Write;

use super::chance;
use super::plan::{DT, Part, Plan};
use super::row::Row;
use super::score::{CAP, FLOOR, Twelve};
use crate::paper::published::{PublishedError, published};

/// The text of `readings.txt`.
///
/// # Errors
/// [`PublishedError`] if a published exponent is missing.
pub fn summary(plan: &Plan, rows: &[Row], target: &Twelve) -> Result<String, PublishedError> {
    let of = |part: Part| -> Vec<&Row> {
        let is = |row: &&Row| row.key[0] == part.name();
        rows.iter().filter(is).collect()
    };
    let (search, spread) = (of(Part::Search), of(Part::Spread));
    let mut text = String::new();
    text += &tried(plan, &search);
    if !search.is_empty() {
        text += &best(&search, target)?;
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
    if search.is_empty() {
        return text;
    }
    let mut systems: Vec<(&[String], [bool; 3])> = search
        .iter()
        .map(|row| {
            (
                &row.key[1..3],
                [0, 1, 2].map(|f| row.classes[f].is_published(f)),
            )
        })
        .collect();
    systems.dedup();
    let right = |f: usize| systems.iter().filter(|one| one.1[f]).count();
    let all = systems.iter().filter(|one| one.1 == [true; 3]).count();
    line!(
        text,
        "Of {} pairs of reading and integrator, Fig. 10 is periodic in {}, Fig. 11 quasi-periodic in {}, Fig. 12 chaotic in {}, all \
         three as published in {all}.",
        systems.len(),
        right(0),
        right(1),
        right(2)
    );
    line!(
        text,
        "Distance: root mean square of |found - published| / (|published| + {FLOOR}), each at most {CAP}; a missing or infinite \
         exponent counts {CAP}. Exponents in descending order, those marked ? (unidentified) or * (starved or\n         unpredictable) included.\n"
    );
    text
}

fn best(search: &[&Row], target: &Twelve) -> Result<String, PublishedError> {
    let mut text = String::new();
    for figure in 0..3 {
        let key = |row: &Row| {
            (
                !row.classes[figure].is_published(figure),
                row.scores[figure],
            )
        };
        if let Some(row) = least(search, key) {
            line!(text, "Best for Fig. {} alone (class first):", figure + 10);
            describe(&mut text, row);
            exponents(&mut text, row, target, figure);
            line!(text, "  distance {:.3}\n", row.scores[figure]);
        }
    }
    let by_class = least(search, Row::classes_first);
    let by_exponents = least(search, |row| ((), row.scores[3]));
    for (what, row) in [
        ("Best common setting (classes first):", by_class),
        ("Nearest exponents, classes aside:", by_exponents),
    ] {
        let Some(row) = row else { continue };
        line!(text, "{what}");
        describe(&mut text, row);
        for figure in 0..3 {
            exponents(&mut text, row, target, figure);
        }
        let mut printed = 0;
        for figure in 0..3 {
            for k in 0..4 {
                let claim = published(&format!("fig{}.lambda.{}", figure + 10, k + 1))?;
                printed += usize::from(claim.agrees(row.exponents[figure][k]));
            }
        }
        line!(
            text,
            "  distance {:.3}; {} of 3 classes; {printed} of 12 exponents to the printed digits\n",
            row.scores[3],
            row.classes_right()
        );
    }
    Ok(text)
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
        "Exponents only: distance of the nearest of the same configurations (classes aside) to"
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
    text += &random(plan, search, own);
    line!(
        text,
        "Classes first: classes met, and distance of the nearest of the configurations that meet so many (a different set in each line), to"
    );
    let published = [0, 1, 2];
    let (most, right) = chance::by_class(search, published);
    let own = chance::nearest(&right, target);
    line!(
        text,
        "  the published figures               {most} of 3  {own:.3}"
    );
    for order in chance::ORDERS {
        let (most, rows) = chance::by_class(search, order);
        let distance = chance::nearest(&rows, &order.map(|figure| target[figure]));
        line!(
            text,
            "  columns exchanged ({})        {most} of 3  {distance:.3}",
            columns(order)
        );
    }
    line!(
        text,
        "  Of the 27 ways to give three figures these classes, {} are met entirely by some configuration; {} configurations meet {most} \
         classes as published.",
        chance::assignments_met(search),
        right.len()
    );
    text += &random(plan, &right, own);
    text
}

/// Median of values in ascending order: of an even count the mean of the middle two.
fn median(sorted: &[f64]) -> Option<f64> {
    let upper = sorted.get(sorted.len() / 2)?;
    let lower = sorted.get((sorted.len() - 1) / 2)?;
    Some(0.5 * (lower + upper))
}

fn columns(order: [usize; 3]) -> String {
    order.map(|figure| (figure + 10).to_string()).join(" ")
}

/// How well random targets of the published classes are met.
fn random(plan: &Plan, rows: &[&Row], own: f64) -> String {
    let mut text = String::new();
    let random = chance::random(rows, plan.draws);
    let as_near = random.iter().filter(|&&distance| distance <= own).count();
    if let (Some(first), Some(median)) = (random.first(), median(&random)) {
        line!(
            text,
            "  {} random targets of the same classes: least {first:.3}, median {median:.3}",
            random.len()
        );
    }
    line!(
        text,
        "  {as_near} of {} random targets ({:.1} %) are met as well as the published ones.\n",
        random.len(),
        100.0 * as_near as f64 / random.len().max(1) as f64
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
    line!(
        text,
        "(eps, neighbour counts, d and ridge, affine), same three series throughout:"
    );
    line!(
        text,
        "  exponent          min    median       max   published   unidentified   starved or unpredictable"
    );
    // Of exponents that are identified in most settings, and of the others.
    let mut widths = [Vec::new(), Vec::new()];
    for (figure, published) in target.iter().enumerate() {
        for (k, published) in published.iter().enumerate() {
            let mut values: Vec<f64> = spread
                .iter()
                .map(|row| row.exponents[figure][k])
                .filter(|value| value.is_finite())
                .collect();
            values.sort_by(f64::total_cmp);
            let having = |statuses: &[&str]| {
                let has = |row: &&&Row| statuses.contains(&row.statuses[figure][k].as_str());
                spread.iter().filter(has).count()
            };
            let unidentified = having(&["unidentified"]);
            let doubtful = having(&["starved", "unpredictable"]);
            let (Some(min), Some(median), Some(max)) =
                (values.first(), median(&values), values.last())
            else {
                line!(
                    text,
                    "  fig{}.lambda.{}   no finite value",
                    figure + 10,
                    k + 1
                );
                continue;
            };
            widths[usize::from(2 * unidentified > spread.len())].push(max - min);
            line!(
                text,
                "  fig{}.lambda.{}  {min:>9.4} {median:>9.4} {max:>9.4}   {:>9.4}   {unidentified:>2} of {:<15} {doubtful}",
                figure + 10,
                k + 1,
                published,
                spread.len()
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
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[1.0, 2.0, 5.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0, 5.0, 9.0]), Some(3.5));
    }

    #[test]
    fn nothing_is_ranked_where_nothing_was_tried() {
        let target = super::super::score::target().unwrap();
        let text = summary(&Plan::quick(), &[], &target).unwrap();
        assert!(text.contains("Tried: 0 of 8") && text.contains("not complete"));
        assert!(!text.contains("pairs of") && !text.contains("Distance"));
    }
}
