//! Which defects make the published numbers, and whether the stated model sticks and slips at all.

use maud::{Markup, html};

use super::super::ledger::Ledger;
use super::super::matrix::{Cell, FOUR};
use super::figures::figure;
use super::{Report, heading};

/// Short headings of the four numbers.
const NUMBERS: [&str; 4] = [
    "length 1 (m)",
    "length 2 (m)",
    "duration 1 (s)",
    "duration 2 (s)",
];

pub(super) fn cause(report: &Report) -> Markup {
    let ledger = &report.ledger;
    html! {
        section aria-labelledby="cause" {
            (heading("cause"))
            p { "The Appendix's program has seven defects. Each is a switch here, so every subset of them can be run." }
            p { b { (ledger.matrix.sentence()) } }
            (matrix(ledger))
            h3 { "The step" }
            p { (ledger.convergence.sentence()) }
            (figure(report.convergence.title, report.convergence.about, &report.convergence.svg))
        }
    }
}

fn matrix(ledger: &Ledger) -> Markup {
    html! {
        table.cards {
            caption {
                "The listing at its printed step with each defect alone, each mended alone, all, none. In brackets: digits that agree with "
                @for (i, id) in FOUR.iter().enumerate() { @if i > 0 { ", " } code { (id) } } "."
            }
            thead {
                tr {
                    th scope="col" { "Listing" }
                    @for name in NUMBERS { th.number scope="col" { (name) } }
                    th scope="col" { "Motion" }
                }
            }
            tbody {
                @for (name, cell) in ledger.matrix.named() {
                    tr {
                        th scope="row" { (name) }
                        @for (i, heading) in NUMBERS.iter().enumerate() {
                            td.number data-column=(heading) { (number(cell, i)) }
                        }
                        td data-column="Motion" { (cell.class()) }
                    }
                }
            }
        }
    }
}

fn number(cell: &Cell, i: usize) -> String {
    match (cell.numbers, cell.digits) {
        (Some(numbers), Some(digits)) => format!("{:.4} ({})", numbers[i], digits[i]),
        _ => String::new(),
    }
}

pub(super) fn existence(report: &Report) -> Markup {
    html! {
        section aria-labelledby="existence" {
            (heading("existence"))
            p { (report.ledger.scan.sentence()) }
            (figure(report.scan.title, report.scan.about, &report.scan.svg))
        }
    }
}
