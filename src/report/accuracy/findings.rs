//! The claims that speak of accuracy, as findings.

use super::{Accuracy, EventErrors};
use crate::figures::rows::Part;
use crate::paper::reading::Reading;
use crate::report::finding::Finding;

const REPORT: &str = "report";

fn finding(reading: Reading, parts: &[(&'static str, bool)]) -> Finding {
    let part = |&(what, holds): &(&'static str, bool)| Part { what, holds };
    Finding::statement(reading, REPORT, parts.iter().map(part).collect())
}

impl Accuracy {
    /// `abstract.accuracy`: transitions of either kind.
    pub fn findings(&self) -> Vec<Finding> {
        vec![
            finding(
                Reading::Exact,
                &[
                    ("arrival on Σ, from either side", self.arrival_as_stated()),
                    ("release from stick, Eq. (15)", self.release_as_stated()),
                ],
            ),
            finding(
                Reading::Corrected,
                &[
                    ("arrival on Σ, from either side", self.arrival_corrected()),
                    (
                        "release at a tangent point at rest, model 1",
                        self.release_corrected(),
                    ),
                    (
                        "release at a tangent point that moves, model 2",
                        self.release_corrected_on_forced(),
                    ),
                ],
            ),
            finding(
                Reading::AsPrinted,
                &[("the listing's transitions", self.listing_is_accurate())],
            ),
        ]
    }

    /// `s3.release_accuracy`: release by Eq. (15), as printed on the system of Sect. 3, corrected on both that the paper uses it for.
    pub fn release_findings(&self) -> Vec<Finding> {
        vec![
            finding(
                Reading::Exact,
                &[("release by Eq. (15)", self.release_as_stated())],
            ),
            finding(
                Reading::Corrected,
                &[
                    (
                        "release with 1/x2 in Eq. (15), at a tangent point at rest, model 1",
                        self.release_corrected(),
                    ),
                    (
                        "the same at a tangent point that moves, model 2",
                        self.release_corrected_on_forced(),
                    ),
                ],
            ),
            finding(
                Reading::AsPrinted,
                &[("release by the listing", self.release.listing.is_accurate())],
            ),
        ]
    }

    /// Every measurement of arrival in a line.
    pub fn lines_of_arrival(&self) -> impl Iterator<Item = String> {
        self.of_arrival().map(EventErrors::line)
    }

    /// Every measurement of release in a line.
    pub fn lines_of_release(&self) -> impl Iterator<Item = String> {
        self.of_release()
            .map(|(model, errors)| format!("{model}, {}", errors.line()))
    }
}
