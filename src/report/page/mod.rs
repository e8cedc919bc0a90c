//! The report as one self-contained HTML page, including style and figures. Its links to sources
//! and tables lead to files of the project.

mod claims;
mod figures;
mod injection;
mod parts;
mod readings;
mod text;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::sentences::sentences;
pub use parts::Report;
use parts::{SECTIONS, file};

const STYLE: &str = include_str!("../../../assets/report/style.css");

/// The page. All text is escaped; drawings and style are the project's own.
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
                meta name="description" content="What holds of the paper, claim by claim, and why \
                    not where it does not.";
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#claims" { "Skip to the table of claims" }
                header {
                    h1 { "Stick–slip by Hénon’s method: a replication" }
                    p.soft {
                        "P. Olejnik, J. Awrejcewicz, "
                        cite { "Nonlinear Dynamics" }
                        " 73 (2013) 723–736, "
                        a href="https://doi.org/10.1007/s11071-013-0826-7" {
                            "doi 10.1007/s11071-013-0826-7"
                        }
                        ". The authors were not contacted. Tables: "
                        (file("report/claims.csv", "claims.csv")) ", "
                        (file("data/errata.csv", "errata.csv")) ", "
                        (file("golden/ledger.snap", "golden")) "; "
                        (file("src/report/mod.rs", "code")) "."
                    }
                    @for sentence in sentences(report.ledger) { p.verdict { (sentence) } }
                    (figures::opening(report))
                    (claims::counts(report.ledger))
                    nav aria-label="Sections" {
                        ol {
                            @for (anchor, heading) in SECTIONS {
                                li { a href={ "#" (anchor) } { (heading) } }
                            }
                        }
                    }
                }
                main {
                    (claims::section(report.ledger))
                    (injection::cause(report))
                    (injection::existence(report))
                    (readings::section(report.ledger))
                    (text::errata(report.ledger))
                    (figures::section(report))
                    (text::methods(report.ledger))
                    (text::cite())
                    (text::remake())
                }
                footer { p { "MIT licence. Every number given as found on this page was computed \
                    by the run that wrote it, or comes from the committed search whose file and \
                    hash stand beside it." } }
            }
        }
    }
}
