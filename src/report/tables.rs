//! The report as tables: every claim, the convergence, and the scan.

use std::fmt::Display;

use super::exponent::{ExponentCheck, SettingsRange};
use super::ledger::{Entry, Ledger};
use super::scan::StartClass;
use crate::captions;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::Digits;
use crate::paper::reading::Reading;
use crate::paper::slip_times_three::converged;
use crate::text::{csv, joined};

/// Every claim with its values under each reading, verdict, cause and evidence.
pub fn claims(ledger: &Ledger) -> String {
    let mut table: Vec<Vec<String>> = Vec::new();
    for entry in &ledger.entries {
        let (names, texts) = claim(ledger, entry).into_iter().unzip();
        if table.is_empty() {
            table.push(names);
        }
        table.push(texts);
    }
    csv(table)
}

/// Names and contents of the columns.
fn claim(ledger: &Ledger, entry: &Entry) -> Vec<(String, String)> {
    let claim = &entry.claim;
    let digits = match claim.digits {
        Digits::Decimals(decimals) => decimals.to_string(),
        Digits::Exact => "exact".into(),
        Digits::None => String::new(),
    };
    let mut row = Vec::new();
    let mut add = |name: &str, text: &dyn Display| row.push((name.to_owned(), text.to_string()));
    add("id", &claim.id);
    add("where", &claim.location);
    add("claim", &claim.what);
    add("kind", &claim.kind.name());
    add("group", &claim.group.name());
    add("published", &claim.published);
    add("digits", &digits);
    add("unit", &claim.unit);
    let values = entry.distinct();
    for reading in Reading::ALL {
        let of = values.iter().filter(|one| one.reading == reading);
        add(reading.name(), &joined(of.map(|one| one.text()), " / "));
    }
    let corrections = entry.corrections.iter().map(|one| one.description());
    let digits = entry.digits().map(|digits| digits.to_string());
    add("digits_in_agreement", &digits.unwrap_or_default());
    add("verdict", &entry.verdict);
    add("corrections", &joined(corrections, " | "));
    // Both are empty except for a published exponent.
    let exponent = entry.exponent.as_ref();
    let text = |of: &dyn Fn(&ExponentCheck) -> String| exponent.map(of).unwrap_or_default();
    add("sign_agrees", &text(&|one| one.sign_agrees().to_string()));
    type OfExponent = fn(&ExponentCheck) -> SettingsRange;
    let ranges: [(&str, OfExponent); 2] = [
        ("over_unstated", |one| one.range),
        ("as_in_eq_25", |one| one.linear),
    ];
    for (name, of) in ranges {
        for (end, what) in ["least", "largest"].into_iter().enumerate() {
            let value = |one: &ExponentCheck| Some(format!("{:?}", of(one).ends?[end]));
            add(
                &format!("{what}_{name}"),
                &text(&|one| value(one).unwrap_or_default()),
            );
        }
        add(
            &format!("settings_{name}"),
            &text(&|one| of(one).settings.to_string()),
        );
        add(
            &format!("identifying_{name}"),
            &text(&|one| of(one).identifying.to_string()),
        );
    }
    let errors = |one: &ExponentCheck| joined(one.range.errors.map(|v| format!("{v:?}")), ";");
    add("standard_errors_of_ends", &text(&errors));
    add(
        "within_widened",
        &text(&|one| one.within_range(claim).to_string()),
    );
    let budget = claim.id.exponent().map(|(figure, k)| {
        let equations = &ledger.computed.bracket[figure as usize].exact.spectrum;
        // A table that cannot be read has ended the figures already.
        let captions = captions::committed().ok();
        let over_captions = captions.and_then(|table| table.budget(figure as usize, k));
        (equations.exponents[k].std_error(), over_captions)
    });
    let or_empty = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:?}"));
    let over_captions = budget.and_then(|(_, over_captions)| over_captions);
    add("statistical_error", &or_empty(budget.and_then(|one| one.0)));
    add(
        "least_over_captions",
        &or_empty(over_captions.map(|one| one.least)),
    );
    add(
        "largest_over_captions",
        &or_empty(over_captions.map(|one| one.largest)),
    );
    add(
        "solver_change",
        &or_empty(over_captions.map(|one| one.solver)),
    );
    let cause = entry.needs_cause().then(|| ledger.cause.status());
    add("cause", &cause.unwrap_or_default());
    add("check", &claim.check);
    for (name, source) in ["code", "test"].into_iter().zip(&claim.sources) {
        add(name, source);
    }
    for reading in Reading::ALL {
        let of = entry.findings.iter().filter(|one| one.reading == reading);
        let lines = joined(of.map(|one| entry.line(one)), " | ");
        add(&format!("evidence.{reading}"), &lines);
    }
    add("evidence.further", &entry.further.join(" | "));
    row
}

/// The listing's numbers at all steps and their distances from the limit, which is listed as step
/// 0.
pub fn convergence(ledger: &Ledger) -> String {
    let convergence = &ledger.convergence;
    let limit = convergence.limit;
    let mut header = vec!["h".to_owned(), "all_digits".to_owned()];
    header.extend(ClaimId::STICK_NUMBERS.map(|id| id.to_string()));
    header.extend(ClaimId::STICK_NUMBERS.map(|id| format!("{id}.error")));
    let row = |h: String, complete: bool, numbers: Option<[f64; 4]>| {
        let errors = numbers.map(|four| std::array::from_fn(|i| four[i] - converged(limit[i])));
        let cells = |four: Option<[f64; 4]>| match four {
            Some(four) => four.map(|v| format!("{v:?}")),
            None => Default::default(),
        };
        let mut row = vec![h, complete.to_string()];
        row.extend([cells(numbers), cells(errors)].into_iter().flatten());
        row
    };
    let complete = convergence.limit_digits.iter().all(|one| one.complete());
    let limit = limit.map(converged);
    let mut rows = vec![header, row("0".to_owned(), complete, Some(limit))];
    let steps = convergence.steps.iter().chain(&convergence.around);
    rows.extend(steps.map(|at| row(format!("{:?}", at.h), at.gives_digits(), at.numbers)));
    csv(rows)
}

/// The attractors of the starts at each set of parameters.
pub fn scan(ledger: &Ledger) -> String {
    let scan = &ledger.scan;
    let mut header = vec!["parameter", "factor", "value"];
    header.extend(StartClass::ALL.map(StartClass::name));
    header.extend(["motions", "distance"]);
    let mut rows = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    let variants = scan.variants.iter().map(|(name, point)| (*name, point));
    for (name, point) in scan.points().chain(variants) {
        let mut row = vec![
            name.to_owned(),
            format!("{:?}", point.factor),
            format!("{:?}", point.value),
        ];
        row.extend(point.counts.map(|count| count.to_string()));
        let motions = point.stick_slip.iter().map(|motion| {
            let lengths = motion.lengths.iter().map(|l| format!("{l:.6}"));
            format!("period {}: {}", motion.period, joined(lengths, " "))
        });
        row.push(joined(motions, "; "));
        let nearest = point.nearest(scan.published, |_| true);
        row.push(nearest.map_or_else(String::new, |(_, distance)| format!("{distance:?}")));
        rows.push(row);
    }
    csv(rows)
}
