//! The figures, each with published against computed.

use maud::{Markup, PreEscaped, html};

use super::Report;
use super::heading;

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
