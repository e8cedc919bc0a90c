//! The defects that cause the published numbers, and whether the stated model has stick–slip at
//! all.

use maud::{Markup, html};

use super::super::convergence::SLOPE_TOLERANCE;
use super::super::ledger::Ledger;
use super::super::matrix::ComparedRun;
use super::super::scan::{ParameterPoint, StartClass};
use super::figures::figure;
use super::parts::{Report, columns, heading, typeset};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::Defect;
use crate::text::joined;

/// Short headings of the four numbers.
const NUMBERS: [&str; 4] = [
    "length 1 (m)",
    "length 2 (m)",
    "duration 1 (s)",
    "duration 2 (s)",
];

/// Conditions for a cause to count as shown.
fn conditions() -> [String; 3] {
    [
        "Injected into the event-exact solver, the two defects that remain as the step goes to \
         zero must give the same motion. Its four numbers may differ from the published ones by \
         the program's own step error and half a printed digit"
            .to_owned(),
        format!(
            "As its step goes to zero, the program's numbers must approach those of that solver \
             at first order: fitted slopes within {SLOPE_TOLERANCE} of one, and the finest steps \
             within the bound found without them"
        ),
        "The difference at the printed step must be within that bound and equal the program's own \
         step error, which is measured without the solver"
            .to_owned(),
    ]
}

pub(super) fn cause(report: &Report) -> Markup {
    let ledger = report.ledger;
    html! {
        section aria-labelledby="cause" {
            (heading("cause"))
            p { "Of the two faults, one is a slip of programming: a list is a reference. The other \
                is in the method: Sect. 3 asks only whether the body has passed a tangent point \
                upward, and the lower end of a moving zone may overtake it." }
            p { b { "The cause is " (ledger.cause.status()) "." } " Three conditions are tested, \
                each of which could have failed." }
            table.cards {
                (columns(&["Condition", "Result", "Holds"]))
                tbody {
                    @for (condition, (result, holds)) in
                        conditions().iter().zip(ledger.cause.parts())
                    {
                        tr {
                            th scope="row" { (condition) }
                            td data-column="Result" { (result) }
                            td data-column="Holds" { @if holds { "yes" } @else { "no" } }
                        }
                    }
                }
            }
            p { (ledger.injection.separate_effects()) }
            (figure(&report.convergence, report.convergence.about))
            p { (ledger.convergence.sentence()) }
            h3 { "The program's defects" }
            p { "Each is a switch, so that every subset of them can be run. This is a statement on \
                the program alone. " (ledger.matrix.sentence()) }
            details {
                summary { "The defects, and the program with each alone and with each mended" }
                dl {
                    @for erratum in &ledger.errata {
                        @if Defect::ALL.iter().any(|defect| defect.name() == erratum.name) {
                            dt { code { (erratum.name) } }
                            dd { (typeset(&erratum.printed)) " (" (erratum.location) ")" }
                        }
                    }
                }
                (matrix(ledger))
            }
        }
    }
}

fn matrix(ledger: &Ledger) -> Markup {
    html! {
        table.cards {
            caption {
                "The listing at its printed step with each defect alone, each mended alone, all, \
                none. Of more than two stick phases the two longest are given. In brackets: digits \
                that agree with "
                @for (i, id) in ClaimId::STICK_NUMBERS.iter().enumerate() {
                    @if i > 0 { ", " }
                    code { (id) }
                }
                "."
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
                        td data-column="Motion" { (cell.motion) }
                    }
                }
            }
        }
    }
}

fn number(cell: &ComparedRun, i: usize) -> String {
    match (cell.numbers, cell.digits) {
        (Some(numbers), Some(digits)) => format!("{:.4} ({})", numbers[i], digits[i]),
        _ => String::new(),
    }
}

pub(super) fn existence(report: &Report) -> Markup {
    let scan = &report.ledger.scan;
    html! {
        section aria-labelledby="existence" {
            (heading("existence"))
            p { (typeset(&scan.sentence())) }
            @for (name, point) in &scan.variants {
                p { "With " (typeset(name)) ": " (counts(point)) "." }
            }
            p { (typeset(&scan.chaos.sentence())) }
            (figure(&report.scan, report.scan.about))
        }
    }
}

/// The number of starts in each class.
fn counts(point: &ParameterPoint) -> String {
    let counts = StartClass::ALL.iter().zip(point.counts);
    let some = counts.filter(|(_, count)| *count > 0);
    let texts = some.map(|(class, count)| {
        let name = class.name().replace('_', " ");
        format!("{count} starts: {name}")
    });
    joined(texts, ", ")
}
