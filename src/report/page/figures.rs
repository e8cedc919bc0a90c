//! The figures, with published and computed values.

use maud::{Markup, PreEscaped, html};

use super::super::figures::Picture;
use super::parts::{Report, heading};

/// Figures without computed content, and why.
const DRAWINGS: &str = include_str!("../../../assets/report/drawings.html");

/// The first figure of the page.
const OPENING: &str = "fig08";

/// Fig. 8.
pub(super) fn opening(report: &Report) -> Markup {
    let pictures = report.ledger.computed.pictures.iter();
    html! {
        @for picture in pictures.filter(|one| one.figure == OPENING) {
            div id=(picture.figure) {
                (figure(
                    picture,
                    "Fig. 8. Left: the Appendix’s program, run to the letter. Right: the equations \
                     it is meant to solve, with the same parameters. Only the text of the paper \
                     was at hand: its pictures were not compared."
                ))
            }
        }
    }
}

pub(super) fn section(report: &Report) -> Markup {
    let pictures = report.ledger.computed.pictures.iter();
    html! {
        section.figures aria-labelledby="figures" {
            (heading("figures"))
            p.soft { "The numbers of each figure are in " code { "figures/figNN.csv" } " of the \
                project." }
            @for picture in pictures.filter(|one| one.figure != OPENING) {
                h3 id=(picture.figure) { (picture.title) }
                (figure(picture, picture.about))
            }
            h3 { "Figures that hold nothing to compute" }
            (PreEscaped(DRAWINGS.trim_end()))
        }
    }
}

/// A drawing with its caption. The drawing has its own title and description.
pub(super) fn figure(picture: &Picture, about: &str) -> Markup {
    html! {
        figure {
            div.picture tabindex="0" role="group" aria-label={ (picture.title) "; scrolls sideways \
                on a narrow screen" } {
                (PreEscaped(&picture.svg))
            }
            figcaption { (about) }
        }
    }
}
