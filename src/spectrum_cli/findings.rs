//! All that the program finds out about a series.

use super::embedding::Embedded;
use stickslip::analysis::data_spectrum::{
    Balance, DataSpectrum, Divergence, Status, SurrogateTest,
};

/// The spectrum and what stands beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// The spectrum, of the columns or of delayed values.
    pub spectrum: DataSpectrum,
    /// The divergence that was given and what it says of the spectrum; none of delayed values.
    pub balance: Option<(f64, Balance)>,
    /// The embedding, if the columns were embedded.
    pub embedded: Option<Embedded>,
    /// The largest exponent by diverging neighbours, where there are points enough.
    pub divergence: Option<Divergence>,
    /// The test against surrogates, if it was asked for.
    pub surrogates: Option<SurrogateTest>,
}

impl Findings {
    /// The status of an exponent in a word: that of the estimator, but for exponents of the embedding's own, which no
    /// other status would make one of the system's.
    pub fn status(&self, i: usize) -> &'static str {
        let status = self.spectrum.exponents[i].status;
        if self.is_spurious(i) {
            "spurious"
        } else {
            status.word()
        }
    }

    /// Whether the next delayed value does not depend on those before.
    pub fn is_noise(&self) -> bool {
        let of_embedding = |embedded: &Embedded| embedded.choice.is_noise;
        self.embedded.as_ref().is_some_and(of_embedding)
    }

    /// Whether an exponent that the data determine is the embedding's own.
    pub fn is_spurious(&self, i: usize) -> bool {
        let determined = !matches!(
            self.spectrum.exponents[i].status,
            Status::Unidentified | Status::Annihilated
        );
        let of_embedding = |embedded: &Embedded| embedded.is_spurious(i);
        determined && self.embedded.as_ref().is_some_and(of_embedding)
    }
}
