//! The report as tables: every claim, the convergence, the scan.

use super::ledger::{Entry, Ledger};
use super::scan::Class;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::Digits;
use crate::paper::reading::Reading;
use crate::text::{csv, joined};

/// Every claim with its values under each reading, verdict, cause and evidence.
///
/// # Errors
/// [`csv::Error`].
pub fn claims(ledger: &Ledger) -> Result<String, csv::Error> {
    let header = [
        "id,where,claim,kind,published,digits,unit",
        &joined(Reading::ALL, ","),
        "digits_in_agreement,verdict,corrections,sign_agrees",
        "least_over_unstated,median_over_unstated,largest_over_unstated,settings,unidentified",
        "within_unstated,cause,check",
        &joined(
            Reading::ALL.map(|reading| format!("evidence.{reading}")),
            ",",
        ),
        "evidence.further",
    ];
    let header = header.join(",").split(',').map(str::to_owned).collect();
    let entries = ledger.entries.iter().map(|entry| claim(ledger, entry));
    csv(std::iter::once(header).chain(entries))
}

fn claim(ledger: &Ledger, entry: &Entry) -> Vec<String> {
    let claim = &entry.claim;
    let digits = match claim.digits {
        Digits::Decimals(decimals) => decimals.to_string(),
        Digits::Exact => "exact".into(),
        Digits::None => String::new(),
    };
    let of = |reading| {
        entry
            .findings
            .iter()
            .filter(move |one| one.reading == reading)
    };
    let mut row = vec![
        claim.id.to_string(),
        claim.place.clone(),
        claim.what.clone(),
        claim.kind.name().into(),
        claim.published.clone(),
        digits,
        claim.unit.clone(),
    ];
    let values = entry.distinct();
    row.extend(Reading::ALL.map(|reading| {
        let of = values.iter().filter(|one| one.reading == reading);
        joined(of.map(|one| one.text()), " / ")
    }));
    let corrections = entry.corrections.iter().map(|one| one.description());
    row.extend([
        entry
            .digits()
            .map_or_else(String::new, |one| one.to_string()),
        entry.verdict.to_string(),
        joined(corrections, " | "),
    ]);
    // Each is empty but for a published exponent.
    let remark = entry.remark.as_ref();
    let said = |text: Option<String>| text.unwrap_or_default();
    let range = remark.and_then(|one| one.spread.values);
    let cause = ledger.cause.status().to_string();
    row.extend([
        said(remark.map(|one| one.sign_agrees().to_string())),
        said(range.map(|range| format!("{:?}", range.least))),
        said(range.map(|range| format!("{:?}", range.median))),
        said(range.map(|range| format!("{:?}", range.largest))),
        said(remark.map(|one| one.spread.settings.to_string())),
        said(remark.map(|one| one.spread.unidentified.to_string())),
        said(remark.map(|one| one.within_range().to_string())),
        said(entry.asks_for_cause().then_some(cause)),
        claim.check.clone(),
    ]);
    row.extend(Reading::ALL.map(|reading| joined(of(reading).map(|one| entry.line(one)), " | ")));
    row.push(entry.further.join(" | "));
    row
}

/// The listing's numbers at all steps, and their distances from the limit, which stands at step 0.
///
/// # Errors
/// [`csv::Error`].
pub fn convergence(ledger: &Ledger) -> Result<String, csv::Error> {
    let convergence = &ledger.convergence;
    let limit = convergence.limit;
    let mut header = vec!["h".to_owned(), "all_digits".to_owned()];
    header.extend(ClaimId::FOUR.map(|id| id.to_string()));
    header.extend(ClaimId::FOUR.map(|id| format!("{id}.error")));
    let row = |h: String, complete: bool, numbers: Option<[f64; 4]>| {
        let mut row = vec![h, complete.to_string()];
        let exact = |v: f64| format!("{v:?}");
        match numbers {
            Some(numbers) => {
                row.extend(numbers.map(exact));
                row.extend((0..4).map(|i| exact(numbers[i] - limit[i])));
            }
            None => row.extend((0..8).map(|_| String::new())),
        }
        row
    };
    let complete = convergence.limit_digits.iter().all(|one| one.complete());
    let mut rows = vec![header, row("0".to_owned(), complete, Some(limit))];
    let steps = convergence.steps.iter().chain(&convergence.around);
    rows.extend(steps.map(|at| row(format!("{:?}", at.h), at.gives_digits(), at.numbers)));
    csv(rows)
}

/// What starts lead to at each set of parameters.
///
/// # Errors
/// [`csv::Error`].
pub fn scan(ledger: &Ledger) -> Result<String, csv::Error> {
    let scan = &ledger.scan;
    let mut header = vec!["parameter", "factor", "value"];
    header.extend(Class::ALL.map(Class::name));
    header.extend(["motions", "distance"]);
    let mut rows = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    let lines = scan.lines.iter();
    let lines = lines.flat_map(|line| line.points.iter().map(|point| (line.name, point)));
    let variants = scan.variants.iter().map(|(name, point)| (*name, point));
    for (name, point) in lines.chain(variants) {
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
