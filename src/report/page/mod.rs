//! The report as one HTML page that needs nothing else: style, figures and the little script are in it.

mod claims;
mod figures;
mod injection;
mod text;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::ledger::Ledger;
use super::sentences::sentences;
use crate::paper::published::Claims;

/// A picture of the report's own.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Heading.
    pub title: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// The drawing.
    pub svg: String,
}

/// What made the page.
#[derive(Clone, Debug)]
pub struct Origin {
    /// Commit of the project, if that is known.
    pub commit: Option<String>,
    /// Version of the compiler, if that is known.
    pub compiler: Option<String>,
}

/// Everything on the page.
pub struct Report {
    /// Claims, figures, matrix, convergence, scan, errata.
    pub ledger: Ledger,
    /// What the paper publishes.
    pub claims: &'static Claims,
    /// The convergence of the listing for small steps.
    pub convergence: Picture,
    /// What becomes of the stated model as each parameter changes.
    pub scan: Picture,
    /// What made it.
    pub origin: Origin,
}

const STYLE: &str = include_str!("../../../assets/report/style.css");
const SORT: &str = include_str!("../../../assets/report/sort.js");

/// Sections in order: anchor and heading.
const SECTIONS: [(&str, &str); 8] = [
    ("claims", "Claims"),
    ("figures", "Figures"),
    ("cause", "What makes Fig. 8"),
    ("existence", "Does the stated model stick and slip?"),
    ("errata", "Errata"),
    ("methods", "Methods"),
    ("cite", "How to cite"),
    ("remake", "How this page was made"),
];

/// The page. Everything that is text is escaped; drawings, style and script are the project's own.
pub fn page(report: &Report) -> String {
    document(report).into_string()
}

fn document(report: &Report) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Replication report: Olejnik & Awrejcewicz 2013" }
                meta name="description" content="What holds of the paper, claim by claim, and why not where it does not.";
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#claims" { "Skip to the table of claims" }
                header {
                    h1 { "Application of Hénon method in numerical estimation of the stick–slip transitions: a replication" }
                    p.soft {
                        "Report on P. Olejnik, J. Awrejcewicz, "
                        cite { "Nonlinear Dynamics" }
                        " 73 (2013) 723–736, doi 10.1007/s11071-013-0826-7, made by stickslip " (env!("CARGO_PKG_VERSION")) "."
                    }
                    (opening(&report.ledger))
                    nav aria-label="Sections" {
                        ol {
                            @for (anchor, heading) in SECTIONS { li { a href={ "#" (anchor) } { (heading) } } }
                        }
                    }
                }
                main {
                    (claims::section(&report.ledger))
                    (figures::section(report))
                    (injection::cause(report))
                    (injection::existence(report))
                    (text::errata(&report.ledger))
                    (text::methods(&report.ledger))
                    (text::cite())
                    (text::remake(&report.origin))
                }
                footer { p { "MIT licence. Every number given as found on this page was computed by the run that wrote it, or comes from the committed search whose file and hash stand beside it." } }
                script { (PreEscaped(SORT)) }
            }
        }
    }
}

/// The verdict in a few sentences.
fn opening(ledger: &Ledger) -> Markup {
    html! {
        div.verdict { @for sentence in sentences(ledger) { p { (sentence) } } }
    }
}

/// A section's heading.
fn heading(anchor: &str) -> Markup {
    let text = SECTIONS
        .iter()
        .find(|(known, _)| *known == anchor)
        .map_or(anchor, |(_, heading)| heading);
    html! { h2 id=(anchor) { (text) } }
}
