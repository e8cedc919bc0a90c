//! Readings of Figs. 10–12: a row for each.

use maud::{Markup, html};

use super::super::ledger::{Entry, Ledger};
use super::super::sentences::search;
use super::super::verdict::{Correction, Verdict};
use super::claims::{labels, verdict_badge};
use super::parts::{columns, heading, typeset};
use crate::paper::claim_id::SpectrumFigure;
use crate::paper::reading::Reading;

const COLUMNS: [&str; 6] = [
    "Figure",
    "Captioned",
    "Corrected equations",
    "As printed",
    "Exponents",
    "Rests on",
];

pub(super) fn section(ledger: &Ledger) -> Markup {
    let [found, nearest, joint] = search(&ledger.spread.search);
    html! {
        section aria-labelledby="readings" {
            (heading("readings"))
            table.cards {
                (columns(&COLUMNS))
                tbody { @for figure in SpectrumFigure::ALL { (row(ledger, figure)) } }
            }
            p { (typeset(&found)) }
            details {
                summary { "How much a match with the published exponents is worth" }
                p { (typeset(&nearest)) }
                p { (typeset(&joint)) }
            }
        }
    }
}

fn row(ledger: &Ledger, figure: SpectrumFigure) -> Markup {
    let class = ledger.entry(figure.class());
    let text = |reading| {
        class
            .reading(reading)
            .map_or_else(String::new, |one| one.text())
    };
    let data = &ledger.computed.bracket[figure as usize];
    let pairs = &ledger.spread.search.pairs;
    let name = class.claim.location.replace(" caption", "");
    let lifted = format!("{:.0} %", 100.0 * data.exact.lifted_fraction);
    let (of_class, all) = (pairs.class[figure as usize], pairs.all);
    html! {
        tr {
            th scope="row" { a href={ "#" (figure.name()) } { (name) } }
            td data-column="Captioned" { (class.claim.published) }
            td data-column="Corrected equations" {
                (text(Reading::Corrected)) " " (verdict_badge(class.verdict))
                p.soft {
                    (of_class) " of " (all) " pairs of equations and integrator give the caption"
                }
            }
            td data-column="As printed" { (text(Reading::AsPrinted)) }
            td data-column="Exponents" {
                ul.found { @for id in figure.exponents() { li { (exponent(ledger.entry(id))) } } }
            }
            td data-column="Rests on" {
                a href="#corrections" { (labels(&class.corrections)) }
                @if class.corrections.contains(&Correction::ClippedNormalForce) {
                    p.soft { "off the belt " (lifted) " of the time" }
                }
            }
        }
    }
}

fn exponent(entry: &Entry) -> Markup {
    let name = entry.claim.id.exponent().map_or(0, |(_, k)| k + 1);
    let verdict = match entry.verdict {
        Verdict::NotReproduced => "no setting tried",
        _ => "undeterminable",
    };
    let published = entry.claim.published.replace('-', "−");
    html! { (typeset(&format!("λ{name}"))) " = " (published) ": " (verdict) }
}
