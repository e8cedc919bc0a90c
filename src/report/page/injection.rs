//! Which defects make the published numbers, and whether the stated model sticks and slips at all.

use maud::{Markup, html};

use super::super::ledger::Ledger;
use super::super::matrix::{Cell, FOUR};
use super::super::scan::{Class, Point};
use super::figures::figure;
use super::{Report, heading};
use crate::paper::listing::Defect;

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
            p { b { (ledger.matrix.sentence()) } }
            p { "The defects of the Appendix's program, each a switch here, so that every subset of them can be run:" }
            dl {
                @for defect in Defect::ALL {
                    dt { code { (defect.name()) } }
                    dd { (defect.description()) " (lines " (defect.lines()) ")" }
                }
            }
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
                "The listing at its printed step with each defect alone, each mended alone, all, none. Of more than two stick phases the two \
                longest are given. In brackets: digits that agree with "
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
            @for (name, point) in &report.ledger.scan.variants {
                p { "With " (name) ": " (counts(point)) "." }
            }
            (figure(report.scan.title, report.scan.about, &report.scan.svg))
        }
    }
}

/// How many starts lead where.
fn counts(point: &Point) -> String {
    let of_class = Class::ALL.iter().zip(point.counts);
    let parts: Vec<String> = of_class
        .filter(|(_, count)| *count > 0)
        .map(|(class, count)| format!("{count} starts: {}", class.name().replace('_', " ")))
        .collect();
    parts.join(", ")
}
