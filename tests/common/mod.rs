//! Comparison with golden files.

use insta::Comparator;
use insta::Snapshot;
use insta::internals::SnapshotContents;

/// Compares line by line and word by word: numbers up to a relative difference, all other words
/// exactly.
#[derive(Clone, Copy, Debug)]
pub struct NumericComparison {
    /// Largest relative difference.
    pub tolerance: f64,
}

impl NumericComparison {
    /// Whether two texts are equal in this sense.
    pub fn same(&self, golden: &str, found: &str) -> bool {
        let (golden, found) = (golden.trim_end(), found.trim_end());
        golden.lines().count() == found.lines().count()
            && golden.lines().zip(found.lines()).all(|(golden, found)| {
                let words = (golden.split_whitespace(), found.split_whitespace());
                words.0.clone().count() == words.1.clone().count()
                    && words
                        .0
                        .zip(words.1)
                        .all(|(golden, found)| self.same_word(golden, found))
            })
    }

    fn same_word(&self, golden: &str, found: &str) -> bool {
        if golden == found {
            return true;
        }
        match (golden.parse::<f64>(), found.parse::<f64>()) {
            (Ok(golden), Ok(found)) => {
                // The relative difference of infinities would always be allowed.
                let size = golden.abs().max(found.abs());
                size.is_finite() && (golden - found).abs() <= self.tolerance * size
            }
            _ => false,
        }
    }
}

impl Comparator for NumericComparison {
    fn matches(&self, reference: &Snapshot, test: &Snapshot) -> bool {
        match (reference.contents(), test.contents()) {
            (SnapshotContents::Text(golden), SnapshotContents::Text(found)) => {
                self.same(&golden.to_string(), &found.to_string())
            }
            _ => false,
        }
    }

    fn dyn_clone(&self) -> Box<dyn Comparator> {
        Box::new(*self)
    }
}

/// Compares with `golden/<name>.snap`, numbers up to a relative difference.
pub fn assert_golden(name: &str, text: String, tolerance: f64) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(concat!(env!("CARGO_MANIFEST_DIR"), "/golden"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_comparator(Box::new(NumericComparison { tolerance }));
    settings.bind(|| insta::assert_snapshot!(name, text));
}
