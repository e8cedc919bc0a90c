//! Errata, methods, citation and origin.

use maud::{Markup, PreEscaped, html};

use super::super::errata::ProofResult;
use super::super::ledger::Ledger;
use super::parts::{columns, heading, typeset};
use crate::figures::rows::Value;
use stickslip::math;

pub(super) fn errata(ledger: &Ledger) -> Markup {
    html! {
        section.errata aria-labelledby="errata" {
            (heading("errata"))
            p { "Misprints and errors of the paper, each with the computation that shows it, or, \
                where the text alone does, what is read there." }
            table.cards {
                (columns(&["Place", "Printed", "Should read", "Shown by"]))
                tbody {
                    @for erratum in &ledger.errata {
                        tr {
                            th scope="row" { (erratum.location) }
                            td data-column="Printed" { (typeset(&erratum.printed)) }
                            td data-column="Should read" { (typeset(&erratum.correct)) }
                            td data-column="Shown by" {
                                ul.found {
                                    @for shown in &erratum.shown {
                                        li {
                                            (typeset(&shown.what)) ": "
                                            b { (typeset(&value(shown))) }
                                        }
                                    }
                                }
                                @if let Some(why) = &erratum.by_reading {
                                    p { "By reading: " (typeset(why)) }
                                }
                                @if !erratum.holds { p { "The computation does not confirm it." } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A number with six significant digits and its unit; a count or a word as it is.
fn value(shown: &ProofResult) -> String {
    let v = match &shown.value {
        Value::Number(v) => *v,
        Value::Count(_) | Value::Word(_) | Value::Statement(_) => return shown.value.to_string(),
    };
    let size = v.abs();
    let text = if v.is_infinite() {
        "∞".to_owned()
    } else if v.fract() == 0.0 && size < 1e6 {
        format!("{v}")
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (5.0 - math::log10(size).floor()).max(0.0) as usize;
        format!("{v:.decimals$}")
    } else {
        format!("{v:.5e}")
    };
    match shown.unit.as_str() {
        "" | "1" => text,
        unit => format!("{text} {unit}"),
    }
    .replace('-', "−")
}

const METHODS: &str = include_str!("../../../assets/report/methods.html");
const CITE: &str = include_str!("../../../assets/report/cite.html");
const REMAKE: &str = include_str!("../../../assets/report/remake.html");

/// Paragraphs, with their lines joined.
pub(super) fn methods(ledger: &Ledger) -> Markup {
    let text = METHODS.replace("{source}", &ledger.spread.search.citation());
    let text = text.replace("\n\n", "\0").replace('\n', " ");
    prose("methods", &text.replace('\0', ""))
}

pub(super) fn cite() -> Markup {
    let text = CITE.replace("{version}", env!("CARGO_PKG_VERSION"));
    let description = env!("CARGO_PKG_DESCRIPTION").replace('&', "&amp;");
    prose("cite", &text.replace("{description}", &description))
}

pub(super) fn remake() -> Markup {
    let text = REMAKE.replace("{version}", env!("CARGO_PKG_VERSION"));
    prose("remake", &text)
}

/// A section of ready markup.
fn prose(anchor: &str, text: &str) -> Markup {
    html! {
        section aria-labelledby=(anchor) { (heading(anchor)) (PreEscaped(text.trim_end())) }
    }
}
