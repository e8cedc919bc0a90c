//! The table of claims, with its filter, and how many there are of each kind.

use maud::{Markup, html};

use super::super::digits::minus;
use super::super::exponent::ExponentCheck;
use super::super::finding::Finding;
use super::super::ledger::{Entry, Ledger};
use super::super::readme::formatted_values;
use super::super::sentences::PARTS;
use super::super::verdict::{Correction, Verdict};
use super::parts::{columns, function, heading, typeset};
use crate::figures::rows::Value;
use crate::paper::published::{Claim, ClaimKind, Digits, Group};
use crate::paper::reading::{Reading, Role};
use crate::text::joined;

/// The number of claims with each verdict, and the meaning of each verdict.
pub(super) fn counts(ledger: &Ledger) -> Markup {
    html! {
        table.counts {
            caption { "Of " (ledger.counted()) " claims" }
            tbody {
                @for (verdict, count) in ledger.counts() {
                    tr {
                        th scope="row" { (verdict_badge(verdict)) }
                        td.number { b { (count) } }
                        td.soft { (verdict.meaning()) }
                    }
                }
            }
        }
    }
}

/// The number of claims with each verdict: for each group, or for each part of the paper.
fn by<'a, K: Copy>(
    ledger: &Ledger,
    title: &str,
    rows: impl IntoIterator<Item = (K, &'a str)>,
    is_of: fn(&Claim, K) -> bool,
) -> Markup {
    let counted = |key: K, verdict: Verdict| {
        let of = |entry: &&Entry| is_of(&entry.claim, key) && entry.verdict == verdict;
        ledger.entries.iter().filter(of).count()
    };
    html! {
        div.scroll tabindex="0" role="region" aria-label=(title) { table {
            caption { (title) }
            thead { tr {
                th scope="col" { "Claims" }
                @for verdict in Verdict::COUNTED { th.number scope="col" { (verdict) } }
            } }
            tbody {
                @for (key, name) in rows {
                    tr {
                        th scope="row" { (name) }
                        @for verdict in Verdict::COUNTED { td.number { (counted(key, verdict)) } }
                    }
                }
            }
        } }
    }
}

pub(super) fn section(ledger: &Ledger) -> Markup {
    let identities = ledger.entries.len() - ledger.counted();
    let filters = ledger.counts().into_iter();
    let filters = filters.chain([(Verdict::Identity, identities)]);
    let groups = Group::ALL.map(|group| (group, group.meaning()));
    html! {
        section.claims aria-labelledby="claims" {
            (heading("claims"))
            fieldset.filter {
                legend { "Show" }
                label {
                    input type="radio" name="verdict" id="all" checked;
                    "all " (ledger.entries.len())
                }
                @for (verdict, count) in filters {
                    label {
                        input type="radio" name="verdict" id={ "only-" (verdict.key()) };
                        (verdict) " " (count)
                    }
                }
            }
            table.list.cards {
                caption {
                    "The claims of the paper, in its order; what is wrong in its formulas and \
                        captions is listed under the errata. The evidence is folded under each \
                        claim. An identity could not have come out otherwise and is not counted. \
                        Where a sentence has two honest readings, the evidence names the one that \
                        is not judged."
                }
                (columns(&["Claim", "Published", "Found", "Verdict"]))
                tbody {
                    @for entry in &ledger.entries { (row(ledger, entry)) }
                }
            }
            (by(ledger, "Claims by kind", groups, |claim, group| claim.group == group))
            (by(ledger, "Claims by the part of the paper that makes them", PARTS, |claim, part| {
                claim.part == part
            }))
            h3 #corrections { "Corrections" }
            dl {
                @for one in Correction::ALL {
                    dt { (one.label()) }
                    dd { (typeset(one.description())) }
                }
            }
            details {
                summary { "What the readings are" }
                dl {
                    @for reading in Reading::ALL { dt { (reading) } dd { (reading.meaning()) } }
                    dt { "unidentified, starved, unstable, unpredictable" }
                    dd { "the estimator's own status of an exponent from data: the data do not \
                        spread in its direction, too few neighbours are near, the size of the \
                        neighbourhoods moves it, or the maps do not predict the data" }
                    dt { "biased" }
                    dd { "the estimator's status is good, but the exponent differs from that of \
                        the equations by more than the known errors" }
                }
            }
        }
    }
}

/// A verdict as a word with a sign of its own shape and colour.
pub(super) fn verdict_badge(verdict: Verdict) -> Markup {
    html! { span class={ "mark " (verdict.key()) } { (verdict) } }
}

fn row(ledger: &Ledger, entry: &Entry) -> Markup {
    let claim = &entry.claim;
    html! {
        tr class=(entry.verdict.key()) id={ "claim-" (claim.id) } {
            th scope="row" {
                (typeset(&claim.what))
                " " span.soft { (claim.location) " · " code { (claim.id) } }
                details {
                    summary { "evidence" }
                    ul { @for line in entry.lines() { li { (typeset(&line)) } } }
                    @if entry.needs_cause() {
                        p { "Cause: " a href="#cause" { (ledger.cause.status()) } "." }
                    }
                    p.soft {
                        "judged by " (function(&claim.sources[0])) ", tested by "
                        (function(&claim.sources[1]))
                    }
                }
            }
            td data-column="Published" { (typeset(&published(entry))) }
            td data-column="Found" {
                ul.found {
                    @for one in entry
                        .distinct()
                        .into_iter()
                        .filter(|one| one.reading.role() != Role::Supplementary)
                    {
                        li {
                            (one.reading) ": " b { (typeset(&value_quality(entry, one))) }
                            @if one.by_construction { " by construction: no evidence" }
                        }
                    }
                }
                @if let Some(exponent) = &entry.exponent {
                    p.soft { (typeset(&sign_and_spread(claim, exponent))) }
                }
            }
            td data-column="Verdict" {
                (verdict_badge(entry.verdict))
                @if !entry.corrections.is_empty()
                    && matches!(
                        entry.verdict,
                        Verdict::WithCorrections | Verdict::UnderAssumption | Verdict::InPart
                    )
                {
                    span.soft { " (" a href="#corrections" { (labels(&entry.corrections)) } ")" }
                }
            }
        }
    }
}

/// Short names of corrections.
pub(super) fn labels(corrections: &[Correction]) -> String {
    joined(corrections.iter().map(|one| one.label()), ", ")
}

/// The published value with its unit; long closed-form numbers to six decimals.
fn published(entry: &Entry) -> String {
    let claim = &entry.claim;
    let mut parts: Vec<(&str, &f64)> = claim.published.split(';').zip(claim.values()).collect();
    if claim.kind == ClaimKind::Set {
        parts.sort_by(|one, other| other.1.total_cmp(one.1));
    }
    let texts = parts.into_iter().map(|(text, value)| match claim.digits {
        Digits::Exact if text.len() > 8 => plot::number(*value, 6) + "…",
        _ => minus(text),
    });
    let text = match joined(texts, "; ") {
        none if none.is_empty() => claim.published.clone(),
        text => text,
    };
    match claim.unit.as_str() {
        _ if text.is_empty() => "stated".to_owned(),
        "" | "1" => text,
        unit => format!("{text} {unit}"),
    }
}

/// The sign and the spread of an exponent.
fn sign_and_spread(claim: &Claim, exponent: &ExponentCheck) -> String {
    let not = if exponent.sign_agrees() { "" } else { "not " };
    let (sign, sentence) = (exponent.sign, exponent.sentence(claim));
    format!("sign: {sign}, {not}as published; {sentence}")
}

/// The values of a reading with their quality in brackets, or the parts of a statement that fail.
fn value_quality(entry: &Entry, finding: &Finding) -> String {
    let values = formatted_values(entry, finding);
    if let [Value::Statement(parts)] = &finding.values[..] {
        let failing = parts.iter().filter(|(_, holds)| !holds);
        return match joined(failing.map(|(what, _)| what), "; ") {
            none if none.is_empty() => values,
            failing if values == "fails" => format!("fails: {failing}"),
            failing => format!("{values}; fails: {failing}"),
        };
    }
    match finding.note.as_deref() {
        None | Some("ok" | "annihilated") => values,
        Some(note) if finding.digits.is_some() => format!("{values} ({note})"),
        Some(_) => values,
    }
}
