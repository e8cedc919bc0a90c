//! The figures, each with published against computed.

use maud::{Markup, PreEscaped, html};

use super::super::figures::Table;
use super::super::readme::{decimals, minus};
use super::Report;
use super::heading;
use crate::figures::rows::{Comparison, Row, Value};

/// Figures of the paper that hold nothing to compute, and why.
const NOTHING_TO_COMPUTE: [(&str, &str); 5] = [
    (
        "Fig. 1",
        "a drawing of the oscillator on the belt; what it defines is Eqs. (1)–(3)",
    ),
    (
        "Fig. 2",
        "a block diagram of the procedure; what it does is the Appendix's listing, which is run here",
    ),
    ("Fig. 3", "the second half of that diagram"),
    (
        "Fig. 5",
        "a drawing of the forced oscillator; what it defines is Eqs. (17), (18)",
    ),
    (
        "Fig. 9",
        "a drawing of the block and the bracket; what it defines is Eqs. (27), (28)",
    ),
];

pub(super) fn section(report: &Report) -> Markup {
    html! {
        section.figures aria-labelledby="figures" {
            (heading("figures"))
            @for table in &report.ledger.computed.tables {
                h3 id=(table.figure) { (table.title) }
                (figure(table.title, table.about, &table.svg))
                (numbers(report, table))
                p.soft { "All its numbers: " code { "golden/" (table.figure) ".snap" } " and " code { "figures/" (table.figure) ".csv" } " of the project." }
            }
            h3 { "Figures that hold nothing to compute" }
            dl { @for (name, why) in NOTHING_TO_COMPUTE { dt { (name) } dd { (why) "." } } }
        }
    }
}

/// A drawing with its caption. The drawing names and describes itself.
pub(super) fn figure(title: &str, about: &str, svg: &str) -> Markup {
    html! {
        figure {
            div.picture tabindex="0" role="group" aria-label={ (title) "; scrolls sideways on a narrow screen" } {
                (PreEscaped(svg))
            }
            figcaption { (about) }
        }
    }
}

/// Rows that the paper says something of.
fn numbers(report: &Report, table: &Table) -> Markup {
    let rows: Vec<(&Row, Comparison)> = table
        .rows
        .iter()
        .filter_map(|row| Some((row, row.comparison(report.claims)?)))
        .collect();
    let agreeing = rows.iter().filter(|(_, one)| one.agrees).count();
    html! {
        @if !rows.is_empty() {
            details {
                summary { "Published against computed: " (agreeing) " of " (rows.len()) " rows agree" }
                table.cards {
                    thead {
                        tr {
                            th scope="col" { "Quantity" }
                            th scope="col" { "Reading" }
                            th.number scope="col" { "Published" }
                            th.number scope="col" { "Computed" }
                            th scope="col" { "Agrees" }
                        }
                    }
                    tbody {
                        @for (row, comparison) in rows {
                            tr {
                                th scope="row" { code { (row.quantity) } }
                                td data-column="Reading" { (row.reading) }
                                td.number data-column="Published" { (minus(&comparison.published)) }
                                td.number data-column="Computed" { (shown(row)) }
                                td data-column="Agrees" { @if comparison.agrees { "yes" } @else { "no" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Two digits more than a reader compares; all are in the golden.
fn shown(row: &Row) -> String {
    let value = match &row.value {
        Value::Number(v) if *v == f64::NEG_INFINITY => "−∞".to_owned(),
        Value::Number(v) if v.is_nan() => "–".to_owned(),
        Value::Number(v) => decimals(*v, 6),
        other => other.to_string(),
    };
    match row.status {
        None | Some("ok") => value,
        Some(status) => format!("{value} ({status})"),
    }
}
