//! The report's tables as CSV.

use super::entry::Entry;
use super::ledger::Ledger;
use super::scan::Class;
use crate::figures::FigureError;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::{Digits, Kind};
use crate::paper::reading::{Reading, Role};

/// The claims: what is published, what each reading gives, verdict, corrections, remarks, evidence
/// by reading.
///
/// # Errors
/// [`FigureError::Csv`] if the writer refuses a field.
pub fn claims(ledger: &Ledger) -> Result<String, FigureError> {
    let mut header = vec![
        "id",
        "where",
        "claim",
        "kind",
        "published",
        "digits",
        "unit",
    ];
    header.extend(Reading::ALL.map(Reading::name));
    header.extend([
        "digits_in_agreement",
        "verdict",
        "corrections",
        "sign_agrees",
        "least_over_unstated",
        "median_over_unstated",
        "largest_over_unstated",
        "settings",
        "unidentified",
        "within_unstated",
        "cause",
        "check",
    ]);
    let mut header: Vec<String> = header.into_iter().map(str::to_owned).collect();
    header.extend(Reading::ALL.map(|reading| format!("evidence.{reading}")));
    header.push("evidence.further".to_owned());
    text(std::iter::once(header).chain(ledger.entries.iter().map(|entry| claim(ledger, entry))))
}

fn claim(ledger: &Ledger, entry: &Entry) -> Vec<String> {
    let claim = &entry.claim;
    let kind = match claim.kind {
        Kind::Value => "value",
        Kind::Set => "set",
        Kind::Curve => "curve",
        Kind::Statement => "statement",
        Kind::Identity => "identity",
    };
    let digits = match claim.digits {
        Digits::Decimals(decimals) => decimals.to_string(),
        Digits::Exact => "exact".into(),
        Digits::None => String::new(),
    };
    let mut row = vec![
        claim.id.to_string(),
        claim.place.clone(),
        claim.what.clone(),
        kind.into(),
        claim.published.clone(),
        digits,
        claim.unit.clone(),
    ];
    row.extend(Reading::ALL.map(|reading| {
        // Several figures may give the same reading; each value is there once.
        let mut texts: Vec<String> = Vec::new();
        for one in entry.findings.iter().filter(|one| one.reading == reading) {
            let text = one.text();
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
        texts.join(" / ")
    }));
    let agreement = [Role::Stated, Role::Corrected, Role::AsPrinted].map(|role| entry.digits(role));
    let best = agreement
        .into_iter()
        .flatten()
        .max_by_key(|one| one.agreeing);
    row.push(best.map_or_else(String::new, |digits| digits.to_string()));
    row.push(entry.verdict.to_string());
    let corrections: Vec<&str> = entry
        .corrections
        .iter()
        .map(|one| one.description())
        .collect();
    row.push(corrections.join(" | "));
    let remark = entry.remark.as_ref();
    let said = |text: Option<String>| text.unwrap_or_default();
    row.push(said(remark.map(|one| one.sign_agrees().to_string())));
    let range = remark.and_then(|one| one.spread.values);
    row.push(said(range.map(|range| format!("{:?}", range.least))));
    row.push(said(range.map(|range| format!("{:?}", range.median))));
    row.push(said(range.map(|range| format!("{:?}", range.largest))));
    row.push(said(remark.map(|one| one.spread.settings.to_string())));
    row.push(said(remark.map(|one| one.spread.unidentified.to_string())));
    row.push(said(remark.map(|one| one.within_range().to_string())));
    row.push(if entry.asks_for_cause() {
        ledger.cause.status().to_string()
    } else {
        String::new()
    });
    row.push(entry.check.to_owned());
    row.extend(Reading::ALL.map(|reading| {
        let of = entry.findings.iter().filter(|one| one.reading == reading);
        let lines: Vec<String> = of.map(|one| entry.line(one)).collect();
        lines.join(" | ")
    }));
    row.push(entry.further.join(" | "));
    row
}

/// The listing's numbers over the steps, with their distance from the limit.
///
/// # Errors
/// [`FigureError::Csv`].
pub fn convergence(ledger: &Ledger) -> Result<String, FigureError> {
    let convergence = &ledger.convergence;
    let mut header = vec!["h".to_owned(), "all_digits".to_owned()];
    header.extend(ClaimId::FOUR.map(|id| id.to_string()));
    header.extend(ClaimId::FOUR.map(|id| format!("{id}.error")));
    let limit = convergence.limit;
    let mut rows = vec![header];
    let mut zero = vec!["0".to_owned(), "false".to_owned()];
    let complete = convergence.limit_digits.iter().all(|one| one.complete());
    zero[1] = complete.to_string();
    zero.extend(limit.map(|v| format!("{v:?}")));
    zero.extend(limit.map(|_| "0.0".to_owned()));
    rows.push(zero);
    for at in convergence.steps.iter().chain(&convergence.around) {
        let mut row = vec![format!("{:?}", at.h), at.gives_digits().to_string()];
        match at.numbers {
            Some(numbers) => {
                row.extend(numbers.map(|v| format!("{v:?}")));
                row.extend((0..4).map(|i| format!("{:?}", numbers[i] - limit[i])));
            }
            None => row.extend((0..8).map(|_| String::new())),
        }
        rows.push(row);
    }
    text(rows)
}

/// Where the starts lead for every value of every parameter, and the stick–slip motions found.
///
/// # Errors
/// [`FigureError::Csv`].
pub fn scan(ledger: &Ledger) -> Result<String, FigureError> {
    let scan = &ledger.scan;
    let mut header = vec!["parameter", "factor", "value"];
    header.extend(Class::ALL.map(Class::name));
    header.extend(["motions", "distance"]);
    let mut rows = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    let lines = scan.lines.iter().flat_map(|line| {
        let name = line.parameter.name();
        line.points.iter().map(move |point| (name, point))
    });
    let variants = scan.variants.iter().map(|(name, point)| (*name, point));
    for (name, point) in lines.chain(variants) {
        let mut row = vec![
            name.to_owned(),
            format!("{:?}", point.factor),
            format!("{:?}", point.value),
        ];
        row.extend(point.counts.map(|count| count.to_string()));
        let motions: Vec<String> = point
            .stick_slip
            .iter()
            .map(|motion| {
                let lengths: Vec<String> =
                    motion.lengths.iter().map(|l| format!("{l:.6}")).collect();
                format!("period {}: {}", motion.period, lengths.join(" "))
            })
            .collect();
        row.push(motions.join("; "));
        let nearest = point.nearest(scan.published, |_| true);
        row.push(nearest.map_or_else(String::new, |(_, distance)| format!("{distance:?}")));
        rows.push(row);
    }
    text(rows)
}

fn text(rows: impl IntoIterator<Item = Vec<String>>) -> Result<String, FigureError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(&row)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?;
    // Every field was a `str`, so nothing can be lost here.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
