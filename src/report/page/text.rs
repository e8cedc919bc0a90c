//! Errata, methods, citation and origin.

use maud::{Markup, html};

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

pub(super) fn methods(ledger: &Ledger) -> Markup {
    html! {
        section aria-labelledby="methods" {
            (heading("methods"))
            p {
                b { "Two readings side by side. " }
                i { "As printed" } " is what the paper's own program or formula literally says: the Appendix's listing is carried "
                "statement by statement, Python's aliasing of lists included, with each of its defects as a switch. "
                i { "Exact" } " is the model that the paper states, solved accurately; " i { "corrected" } " is the same with corrections that are "
                "listed wherever a verdict rests on them. What only the program gives is told so, with its cause."
            }
            p {
                b { "The solver. " }
                "A system is two functions, the smooth field on either side of the discontinuity boundary Σ and a function that is zero on Σ. "
                "Steps are of order 8 with an error control (Hairer, Nørsett & Wanner's DOP853) and dense output. Over every step the "
                "event functions are shown to have no zero, or their first zero is isolated; it is then located by Hénon's step (the "
                "paper's own subject) at the order of the integrator, or by a bracketed search near grazing. Whether the body crosses, "
                "sticks or is released follows Filippov's convex method (Filippov 1988) with Lie derivatives from dual numbers; so do tangent "
                "points and their visibility (Kuznetsov, Rinaldi & Gragnani 2003)."
            }
            p {
                b { "Exponents from the equations. " }
                "Tangent vectors are carried with every step and jump at every transition by the saltation matrix (Müller 1995; Leine & "
                "Nijmeijer 2004), and are made orthonormal again (Benettin et al. 1980; Shimada & Nagashima 1979). Entry into stick "
                "annihilates a direction: its exponent is −∞."
            }
            p {
                b { "Exponents from data. " }
                "Eqs. (25)–(26) (Sano & Sawada 1985) by QR and singular values, never by the normal equations. Data on a curve or a torus "
                "determine only as many exponents as it has dimensions; any beyond is marked unidentified, with its value in brackets. "
                "The paper states neither radius nor step nor counts of neighbours: the table of claims tells how far an exponent moves "
                "over the settings that a reader could have chosen. These estimates come from the committed search: " (ledger.spread.search.cited()) "."
            }
            p {
                b { "Digits. " }
                "A value agrees with a published one to as many significant digits as it stays within half a unit of. Elementary "
                "functions are computed in software and parallel results collected in order, so every number has the same bits on every machine."
            }
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
