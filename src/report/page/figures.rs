//! The figures, with published and computed values.

use maud::{Markup, PreEscaped, html};

use super::super::figures::Picture;
use super::parts::{Report, file, heading, typeset};

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
                    "Fig. 8. Left: the Appendix’s program, run to the letter where it can be. \
                     Right: the equations it is meant to solve, with the same parameters. One slip \
                     of programming and one gap in the method make the difference. Only the text \
                     of the paper was at hand: its pictures were not compared."
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
            figcaption { (typeset(about)) " " (sources(picture)) }
        }
    }
}

/// Links to the program, the table and the golden file of a figure. The report's own have the
/// report's.
fn sources(picture: &Picture) -> Markup {
    let name = picture.figure;
    let (program, golden) = match picture.rows.is_empty() {
        true => ("report", "ledger"),
        false => (name, name),
    };
    html! {
        "(" (file(&format!("src/bin/{program}.rs"), "program")) ", "
        (file(&format!("figures/{name}.csv"), "numbers")) ", "
        (file(&format!("golden/{golden}.snap"), "golden")) ")"
    }
}
