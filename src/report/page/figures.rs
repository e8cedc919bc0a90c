//! The figures, each with published against computed.

use maud::{Markup, PreEscaped, html};

use super::parts::{Report, heading};

/// Figures that hold nothing to compute, and why.
const DRAWINGS: &str = include_str!("../../../assets/report/drawings.html");

/// The figure that the page opens with.
const OPENING: &str = "fig08";

/// Fig. 8.
pub(super) fn opening(report: &Report) -> Markup {
    let tables = report.ledger.computed.tables.iter();
    html! {
        @for table in tables.filter(|table| table.figure == OPENING) {
            div id=(table.figure) {
                (figure(
                    table.title,
                    "Fig. 8. Left: the Appendix’s program, run to the letter. Right: the equations it is meant to solve, with the same \
                     parameters. Only the text of the paper was at hand: its pictures were not compared.",
                    &table.svg
                ))
            }
        }
    }
}

pub(super) fn section(report: &Report) -> Markup {
    let tables = report.ledger.computed.tables.iter();
    html! {
        section.figures aria-labelledby="figures" {
            (heading("figures"))
            p.soft { "The numbers of each figure are in " code { "figures/figNN.csv" } " of the project." }
            @for table in tables.filter(|table| table.figure != OPENING) {
                h3 id=(table.figure) { (table.title) }
                (figure(table.title, table.about, &table.svg))
            }
            h3 { "Figures that hold nothing to compute" }
            (PreEscaped(DRAWINGS.trim_end()))
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
