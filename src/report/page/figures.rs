//! The figures, each with published against computed.

use maud::{Markup, PreEscaped, html};

use super::super::figures::Table;
use super::super::ledger::Ledger;
use super::heading;
use crate::figures::rows::{Row, Value};

pub(super) fn section(ledger: &Ledger) -> Markup {
    html! {
        section aria-labelledby="figures" {
            (heading("figures"))
            @for table in &ledger.tables {
                h3 id=(table.figure) { (table.title) }
                (figure(table.title, table.about, &table.svg))
                (numbers(table))
                p.soft {
                    "All numbers: " a href={ "../golden/" (table.figure) ".snap" } { "golden/" (table.figure) ".snap" }
                    ", " a href={ "../figures/" (table.figure) ".csv" } { "figures/" (table.figure) ".csv" } "."
                }
            }
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
fn numbers(table: &Table) -> Markup {
    let rows: Vec<&Row> = table
        .rows
        .iter()
        .filter(|row| row.published.is_some())
        .collect();
    html! {
        @if !rows.is_empty() {
            details {
                summary { "Published against computed: " (agreeing(&rows)) " of " (rows.len()) " rows agree" }
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
                        @for row in rows {
                            tr {
                                th scope="row" { code { (row.id) } }
                                td data-column="Reading" { (row.reading) }
                                td.number data-column="Published" { (row.published.as_deref().unwrap_or_default()) }
                                td.number data-column="Computed" { (shown(row)) }
                                td data-column="Agrees" { @if row.agrees == Some(true) { "yes" } @else { "no" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn agreeing(rows: &[&Row]) -> usize {
    rows.iter().filter(|row| row.agrees == Some(true)).count()
}

/// Two digits more than a reader compares; all are in the golden.
fn shown(row: &Row) -> String {
    let value = match &row.value {
        Value::Number(v) if *v == f64::NEG_INFINITY => "−∞".to_owned(),
        Value::Number(v) if v.is_nan() => "–".to_owned(),
        Value::Number(v) => format!("{v:.6}"),
        other => other.to_string(),
    };
    match row.status.as_deref() {
        None | Some("ok") => value,
        Some(status) => format!("{value} ({status})"),
    }
}
