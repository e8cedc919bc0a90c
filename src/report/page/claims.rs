//! The table of claims, with its filter.

use maud::{Markup, html};

use super::super::entry::{Entry, ReadingValue, Verdict};
use super::super::ledger::Ledger;
use super::super::readme::{minus, shown};
use super::heading;

pub(super) fn section(ledger: &Ledger) -> Markup {
    html! {
        section.claims aria-labelledby="claims" {
            (heading("claims"))
            dl {
                @for verdict in Verdict::ALL {
                    dt { (mark(verdict)) }
                    dd { (meaning(verdict)) }
                }
            }
            fieldset.filter {
                legend { "Show" }
                label { input type="radio" name="verdict" id="all" checked; "all " (ledger.entries.len()) }
                @for (verdict, count) in ledger.counts() {
                    label {
                        input type="radio" name="verdict" id={ "only-" (key(verdict)) };
                        (verdict) " " (count)
                    }
                }
            }
            p.soft {
                b { "exact" } ": the stated model solved accurately (" b { "/equations" } ", " b { "/data" } ": exponents from the equations, and by \
                Eqs. (25)–(26) from the sampled motion). " b { "as-printed" } ": the paper's program or equations to the letter. "
                b { "slip-times-three" } ": the event-exact solver with the program's two defects that outlast a vanishing step. "
                b { "least-set" } ": the mended program with the fewest defects that give all four numbers. "
                b { "best-of-readings" } ": what a search over 1248 ways to read Figs. 10–12 ranks first. "
                b { "unidentified" } ": the data do not determine that exponent."
            }
            table.sortable.cards {
                caption { "Every quantity and statement that the paper publishes, in its order." }
                thead {
                    tr {
                        th scope="col" { "Claim" }
                        th scope="col" { "Published" }
                        th scope="col" { "Found" }
                        th scope="col" { "Verdict" }
                        th scope="col" { "Evidence" }
                    }
                }
                tbody { @for (place, entry) in ledger.entries.iter().enumerate() { (row(place, entry)) } }
            }
        }
    }
}

/// A verdict as a word with a sign of its own shape and colour.
pub(super) fn mark(verdict: Verdict) -> Markup {
    html! { span class={ "mark " (key(verdict)) } { (verdict) } }
}

fn row(place: usize, entry: &Entry) -> Markup {
    let claim = &entry.claim;
    html! {
        tr class=(key(entry.verdict)) id={ "claim-" (claim.id) } {
            th scope="row" data-key=(place) {
                code { (claim.id) }
                br;
                (claim.what)
                br;
                span.soft { (claim.place) }
            }
            td data-column="Published" { (published(entry)) }
            td data-column="Found" {
                ul.found {
                    @for reading in &entry.readings {
                        li {
                            (reading.reading) ": " b { (worth(entry, reading)) }
                            @if let Some(digits) = reading.digits { span.soft { " (" (digits) " digits)" } }
                        }
                    }
                }
            }
            td data-column="Verdict" data-key=(entry.verdict as usize) { (mark(entry.verdict)) }
            td data-column="Evidence" {
                @if let Some(cause) = &entry.cause { p { b { "Cause: " } (cause.text) } }
                @if let Some(spread) = &entry.spread {
                    p {
                        "From " (rounded(spread.least)) " to " (rounded(spread.largest)) " over " (spread.over) ": "
                        b { @if spread.holds(&entry.claim) { "holds" } @else { "does not hold" } }
                        " the published value."
                    }
                }
                @match &entry.evidence[..] {
                    [] => {}
                    [only] => p { (only) },
                    [first, rest @ ..] => {
                        p { (first) }
                        details {
                            summary { "more (" (rest.len()) ")" }
                            ul { @for line in rest { li { (line) } } }
                        }
                    }
                }
            }
        }
    }
}

/// What the paper says, with its unit; long closed-form numbers to six decimals.
fn published(entry: &Entry) -> String {
    let claim = &entry.claim;
    if claim.published.is_empty() {
        return "stated".to_owned();
    }
    let short = |part: &str| match part.trim().parse::<f64>() {
        Ok(value) if part.trim().len() > LONG => minus(&format!("{value:.6}…")),
        _ => minus(part.trim()),
    };
    let parts: Vec<String> = claim.published.split(';').map(short).collect();
    let text = parts.join("; ");
    match claim.unit.as_str() {
        "" | "1" => text,
        unit => format!("{text} {unit}"),
    }
}

/// More characters than a printed number has.
const LONG: usize = 12;

/// Name of a verdict in the style sheet.
fn key(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "reproduced",
        Verdict::AsPrintedOnly => "printed",
        Verdict::ClassOnly => "class",
        Verdict::NotReproduced => "missed",
    }
}

fn meaning(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => {
            "the stated model, solved accurately, gives it to all published digits, or the statement holds"
        }
        Verdict::AsPrintedOnly => {
            "the printed program or formula gives it, the stated model does not, and putting exactly the named defects into an \
             accurate solver, or into the mended program where it is shown to be as accurate, gives it too"
        }
        Verdict::ClassOnly => {
            "the kind of motion is right, or the exponent has the sign that the captioned kind demands; the digits are not"
        }
        Verdict::NotReproduced => "no tested reading gives it",
    }
}

/// Four decimals as the paper prints, two digits of what these would show as zero.
fn rounded(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 {
        minus(&format!("{value:.1e}"))
    } else {
        minus(&format!("{value:.4}"))
    }
}

/// A reading's values and, in brackets, what they are worth.
fn worth(entry: &Entry, reading: &ReadingValue) -> String {
    let note = reading.note.as_ref();
    match note.filter(|note| *note != "ok" && *note != "annihilated") {
        Some(note) => format!("{} ({note})", shown(entry, reading)),
        None => shown(entry, reading),
    }
}
