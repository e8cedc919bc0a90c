//! Elements shared by the sections of the page.

use maud::{Markup, html};

use super::super::figures::Picture;
use super::super::ledger::Ledger;

/// Contents of the page.
pub struct Report<'a> {
    /// Claims, figures, matrix, convergence, scan, errata.
    pub ledger: &'a Ledger,
    /// The convergence of the listing for small steps.
    pub convergence: Picture,
    /// Attractors of the stated model as each parameter changes.
    pub scan: Picture,
}

/// Sections in order: anchor and heading.
pub(super) const SECTIONS: [(&str, &str); 9] = [
    ("claims", "Claims"),
    ("cause", "What makes Fig. 8"),
    ("existence", "Does the stated model stick and slip?"),
    ("readings", "How Figs. 10–12 can be read"),
    ("errata", "Errata"),
    ("figures", "Other figures"),
    ("methods", "Methods"),
    ("cite", "How to cite"),
    ("remake", "How this page was made"),
];

/// A section's heading.
pub(super) fn heading(anchor: &str) -> Markup {
    let section = SECTIONS.iter().find(|(name, _)| *name == anchor);
    html! { h2 id=(anchor) { (section.map_or(anchor, |(_, heading)| heading)) } }
}

/// The head of a table.
pub(super) fn columns(names: &[&str]) -> Markup {
    html! { thead { tr { @for name in names { th scope="col" { (name) } } } } }
}
