//! Errata, methods, citation and origin.

use maud::{Markup, PreEscaped, html};

use super::super::errata::Shown;
use super::super::ledger::Ledger;
use super::heading;
use crate::figures::rows::Value;
use stickslip::math;

pub(super) fn errata(ledger: &Ledger) -> Markup {
    html! {
        section.errata aria-labelledby="errata" {
            (heading("errata"))
            p { "Misprints and slips of the paper, each with the computation that shows it." }
            table.cards {
                thead {
                    tr {
                        th scope="col" { "Place" }
                        th scope="col" { "Printed" }
                        th scope="col" { "Should read" }
                        th scope="col" { "Shown by" }
                    }
                }
                tbody {
                    @for erratum in &ledger.errata {
                        tr {
                            th scope="row" { (erratum.place) }
                            td data-column="Printed" { (erratum.printed) }
                            td data-column="Should read" { (erratum.correct) }
                            td data-column="Shown by" {
                                ul.found {
                                    @for shown in &erratum.shown { li { (shown.what) ": " b { (value(shown)) } } }
                                }
                                @if !erratum.holds { p { "The computation does not bear it out." } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A number with six significant digits and its unit, a count or a word as it is.
fn value(shown: &Shown) -> String {
    let v = match &shown.value {
        Value::Number(v) => *v,
        Value::Count(_) | Value::Word(_) | Value::Statement(_) => return shown.value.to_string(),
    };
    let size = v.abs();
    let text = if v.fract() == 0.0 && size < 1e6 {
        format!("{v}")
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (5.0 - math::log10(size).floor()).max(0.0) as usize;
        format!("{v:.decimals$}")
    } else {
        format!("{v:.5e}")
    };
    match shown.unit {
        "" | "1" => text,
        unit => format!("{text} {unit}"),
    }
    .replace('-', "−")
}

/// How values and verdicts are made. Paragraphs stand apart by an empty line, and their lines are
/// one.
const METHODS: &str = include_str!("../../../assets/report/methods.html");

/// What was done, in the words of the field.
pub(super) fn methods(ledger: &Ledger) -> Markup {
    let text = METHODS.replace("{source}", &ledger.spread.search.cited());
    let paragraphs = text.trim_end().split("\n\n");
    html! {
        section aria-labelledby="methods" {
            (heading("methods"))
            @for paragraph in paragraphs { (PreEscaped(paragraph.replace('\n', " "))) }
        }
    }
}

pub(super) fn cite() -> Markup {
    html! {
        section aria-labelledby="cite" {
            (heading("cite"))
            p { "The paper:" }
            pre {
                "P. Olejnik, J. Awrejcewicz: Application of Hénon method in numerical estimation of the stick–slip transitions existing in "
                "Filippov-type discontinuous dynamical systems with dry friction. Nonlinear Dynamics 73 (2013) 723–736. "
                "doi:10.1007/s11071-013-0826-7"
            }
            p { "This replication and the library under it (" code { "CITATION.cff" } "):" }
            pre { "stickslip " (env!("CARGO_PKG_VERSION")) ": " (env!("CARGO_PKG_DESCRIPTION")) "." }
        }
    }
}

pub(super) fn remake() -> Markup {
    html! {
        section aria-labelledby="remake" {
            (heading("remake"))
            pre {
                "make figures   # figures/ and the numbers behind them\n"
                "make report    # this page, report/claims.csv, the table in README.md\n"
                "make test      # fails when a verdict or a number changes, or this page is not what the program writes"
            }
            p { "stickslip " (env!("CARGO_PKG_VERSION")) ", Rust 1.89 or newer, libraries as in " code { "Cargo.lock" } ": the same bytes on every machine." }
        }
    }
}
