//! The range of an exponent of Figs. 10–12 over settings of the estimator that the paper does not
//! state, from the committed search. Also the class of Fig. 10 with its caption corrected,
//! computed.

use rayon::prelude::*;

use crate::figures::block_and_bracket::{FigureSet, SETS, TOLERANCE, class};
use crate::paper::models::{Caption, Reading};
use crate::readings::{CommittedSearch, ConfigurationRow, Integrator, other_motions};
use crate::terminal::ProgramError;
use crate::text::joined;
use stickslip::analysis::motion::Class;
use stickslip::{Error, Options};

/// Estimates for all three figures, and the loops of Fig. 10.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The committed search, which has the estimates.
    pub search: CommittedSearch,
    /// Class of the motion of Fig. 10 with its caption corrected, in turn for each of the three
    /// entries that may be wrong.
    pub mended: Vec<(String, Class)>,
}

/// Number of corrected captions, each of which is computed once.
pub const JOBS: usize = 3;

impl Spread {
    /// Reads the search and computes the corrected captions, and calls `tick` after each of these.
    ///
    /// # Errors
    /// The solver's; a message if the search is not complete.
    pub fn compute(tick: &(dyn Fn() + Sync)) -> Result<Spread, ProgramError> {
        let search = CommittedSearch::read()?;
        let of_caption = |(name, caption)| {
            let set = FigureSet { caption, ..SETS[0] };
            let class = class(&set, &Reading::exact(), Options::tol(TOLERANCE))?;
            tick();
            Ok((name, class))
        };
        let mended = mended_captions().into_par_iter().map(of_caption);
        let mended = mended.collect::<Result<_, Error>>()?;
        Ok(Spread { search, mended })
    }

    /// The class of Fig. 10 with its caption corrected.
    pub fn mended_sentence(&self) -> String {
        let each = self.mended.iter();
        let each = joined(each.map(|(entry, class)| format!("{entry}: {class}")), ", ");
        format!("the caption's entries contradict each other; corrected one at a time, {each}")
    }

    /// The readings that give Fig. 10 as captioned, including its loops, and the motions of the
    /// other figures there.
    pub fn two_periodic_sentence(&self) -> String {
        let captioned = |one: &&ConfigurationRow| one.classes[0].is_published(0);
        let all = self.search.motions.iter().filter(captioned);
        let each = all.map(|one| {
            let (reading, integrator, [amplitude, _]) =
                (one.reading(), one.integrator(), one.sizes[0]);
            let others = other_motions(&one.motions(), 0);
            format!("{reading}; {integrator} (x1 within {amplitude:.3} of its middle; {others})")
        });
        match joined(each, " | ") {
            none if none.is_empty() => "no reading of the search is two-periodic".to_owned(),
            each => format!("other readings make it two-periodic: {each}"),
        }
    }

    /// The class of Fig. 12 in every reading with the corrected signs, solved exactly.
    pub fn chaos_sentence(&self) -> String {
        let corrected = |one: &&ConfigurationRow| {
            one.integrator() == Integrator::Exact.name() && one.reading().starts_with("+x3 +T;")
        };
        let all: Vec<&ConfigurationRow> = self.search.motions.iter().filter(corrected).collect();
        let chaotic = |one: &&&ConfigurationRow| one.classes[2].is_of_kind(2);
        let chaotic: Vec<&&ConfigurationRow> = all.iter().filter(chaotic).collect();
        let has = |one: &ConfigurationRow, choice: &str| {
            one.reading().split("; ").any(|part| part == choice)
        };
        // The choices that all readings with the class share and no others have.
        let choices = chaotic.first().map_or("", |one| one.reading()).split("; ");
        let needed = choices.filter(|choice| {
            chaotic.iter().all(|one| has(one, choice)) && !all.iter().all(|one| has(one, choice))
        });
        let words = all
            .iter()
            .map(|one| format!("{}: {}", one.reading(), one.classes[2]));
        format!(
            "with the signs corrected and solved exactly, {} of {} readings give the class of \
             Fig. 12 (those with {}): {}",
            chaotic.len(),
            all.len(),
            joined(needed, "; "),
            joined(words, " | ")
        )
    }

    /// How often the search matches an exponent to its printed digits, and the significance of
    /// that; `figure` and `k` from 0.
    pub fn digits_sentence(&self, figure: usize, k: usize) -> String {
        let (agreeing, kept) = (self.search.digits[figure][k], self.search.kept);
        let of = format!(
            "{agreeing} of the {kept} configurations with three bounded motions give the printed \
             digits"
        );
        match self.search.digits_by_random_targets[figure][k] {
            Some(share) => {
                let percent = share.percent();
                format!("{of}; as many match {percent:.0} % of random targets")
            }
            None => of,
        }
    }
}

/// Fig. 10's caption with ξ6/μ0 = ξ4 − 1 restored by changing one of the three. The relation holds
/// in the two other captions.
pub(super) fn mended_captions() -> [(String, Caption); JOBS] {
    let [_, _, _, xi4, _, mu0, xi6, _, _] = Caption::FIG10.numbers;
    [
        ("xi6", 6, mu0 * (xi4 - 1.0)),
        ("mu0", 5, xi6 / (xi4 - 1.0)),
        ("xi4", 3, 1.0 + xi6 / mu0),
    ]
    .map(|(name, index, value)| {
        let mut caption = Caption::FIG10;
        caption.numbers[index] = value;
        (format!("{name} = {value:.3}"), caption)
    })
}
