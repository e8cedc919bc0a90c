//! The range of an exponent of Figs. 10–12 over settings of the estimator that the paper does not
//! state, from the committed search. The estimates at the ends of a range are made again, for their
//! standard errors. Also the class of Fig. 10 with its caption corrected, computed.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::exponent::SettingsRange;
use super::finding::{Finding, statement};
use crate::figures::block_and_bracket::{Data, FigureSet, SETS, TOLERANCE, class};
use crate::motion::Class;
use crate::paper::models::{self, Caption};
use crate::paper::reading::Reading;
use crate::readings::{
    CommittedSearch, ConfigurationRow, Integrator, Scaled, Setting, estimate, other_motions,
};
use crate::terminal::ProgramError;
use crate::text::joined;
use stickslip::{Error, Options};
use stickslip_series::{DataExponent, Neighbourhood, Status};

/// Estimates for all three figures, and the loops of Fig. 10.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// The committed search, which has the estimates.
    pub search: CommittedSearch,
    /// Estimates at the ends of the ranges, made again: figure and row among the search's
    /// recommended ones, from 0, and exponents in descending order.
    pub at_ends: Vec<((usize, usize), Vec<DataExponent>)>,
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
    pub fn compute(figures: &[Data; 3], tick: &(dyn Fn() + Sync)) -> Result<Spread, ProgramError> {
        let search = CommittedSearch::read()?;
        let series = figures.each_ref().map(|data| Scaled::of(&data.states));
        let at_ends = ends_of_all(&search).into_par_iter().map(|(figure, row)| {
            let (series, setting) = (series[figure].as_ref(), &search.recommended[row].1);
            let exponents = series.map_or_else(Vec::new, |series| estimate(series, setting));
            ((figure, row), exponents)
        });
        let at_ends = at_ends.collect();
        let of_caption = |(name, caption)| {
            let set = FigureSet { caption, ..SETS[0] };
            let class = class(
                &set,
                &models::Interpretation::exact(),
                Options::tol(TOLERANCE),
            )?;
            tick();
            Ok((name, class))
        };
        let mended = mended_captions().into_par_iter().map(of_caption);
        let mended = mended.collect::<Result<_, Error>>()?;
        Ok(Spread {
            search,
            at_ends,
            mended,
        })
    }

    /// The range of an exponent or a ratio over the settings that `counts` accepts.
    pub fn range(&self, of: Estimated, counts: fn(&Setting) -> bool) -> SettingsRange {
        let rows = self.search.recommended.iter();
        let ends = ends(&self.search, of, counts);
        SettingsRange {
            ends: ends.map(|rows| {
                let value = |row: usize| of.value(&self.search.recommended[row].0);
                rows.map(|row| value(row).unwrap_or(f64::NAN))
            }),
            errors: ends.map_or([0.0; 2], |rows| rows.map(|row| self.error(of, row))),
            identifying: values(&self.search, of, counts).count(),
            settings: rows.filter(|(_, setting)| counts(setting)).count(),
        }
    }

    /// Standard error of the estimate of a row at an end; that of a ratio by its relative errors.
    fn error(&self, of: Estimated, row: usize) -> f64 {
        let exponents = |figure| {
            let made = self.at_ends.iter().find(|(key, _)| *key == (figure, row));
            made.map_or(&[][..], |(_, exponents)| exponents)
        };
        let one = |figure, k: usize| exponents(figure).get(k).map_or(f64::NAN, |one| one.stderr);
        match of {
            Estimated::Exponent(figure, k) => one(figure, k),
            Estimated::Ratio(figure, [above, below]) => {
                let relative = [above, below].map(|k| {
                    let value = exponents(figure).get(k).map_or(f64::NAN, |one| one.value);
                    one(figure, k) / value
                });
                let value = of
                    .value(&self.search.recommended[row].0)
                    .unwrap_or(f64::NAN);
                value.abs() * (relative[0] * relative[0] + relative[1] * relative[1]).sqrt()
            }
        }
    }

    /// `s5.reconstruction`: whether the method identifies the exponents of the paper's own
    /// discontinuous systems.
    pub(super) fn reconstruction(&self) -> Vec<Finding> {
        let whats = [
            "Fig. 10: each exponent is identified by a setting of the method",
            "Fig. 11: each exponent is identified by a setting of the method",
            "Fig. 12: each exponent is identified by a setting of the method",
        ];
        let identified = self.identified();
        let some = identified.map(|four| four.iter().filter(|count| **count > 0).count());
        let parts = [0, 1, 2].map(|figure| (whats[figure], some[figure] == 4));
        let line = format!(
            "of four exponents each, {} are identified by at least one of {} settings (Figs. 10, \
             11, 12): in stick the velocity of the block is constant, so that the sum in Eq. (25) \
             is singular, and entry into stick annihilates a direction",
            joined(some, ", "),
            self.search.recommended.len()
        );
        vec![statement(Reading::CorrectedData, parts, line)]
    }

    /// `s5.large_enough`: whether more neighbours than components are enough.
    pub(super) fn large_enough(&self) -> Vec<Finding> {
        let settings = self.search.recommended.len();
        let least =
            self.search
                .recommended
                .iter()
                .map(|(_, (_, settings))| match settings.neighbours {
                    Neighbourhood::Ball { min, .. } => min,
                    Neighbourhood::Nearest(count) => count,
                });
        let least = least.min().unwrap_or(0);
        let identified: usize = self.identified().as_flattened().iter().sum();
        let all = 12 * settings;
        let what = "with nk > ni neighbours in every ball, Eq. (25) identifies the exponents";
        let line = format!(
            "with at least {least} neighbours, of four components each, {identified} of {all} \
             exponents are identified ({settings} settings, twelve exponents)"
        );
        vec![statement(
            Reading::CorrectedData,
            [(what, least > 4 && identified == all)],
            line,
        )]
    }

    /// Number of settings that identify each exponent.
    fn identified(&self) -> [[usize; 4]; 3] {
        let count = |figure, k| values(&self.search, Estimated::Exponent(figure, k), any).count();
        [0, 1, 2].map(|figure| [0, 1, 2, 3].map(|k| count(figure, k)))
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

    /// Describes the matches of an exponent to its printed digits in the search, and their
    /// significance; `figure` and `k` from 0.
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

/// Estimated quantity: an exponent of a figure, or the ratio of two, all from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Estimated {
    /// One exponent.
    Exponent(usize, usize),
    /// A ratio of two, which does not depend on the unit of time.
    Ratio(usize, [usize; 2]),
}

/// λ1 : λ3 of Fig. 12.
pub const RATIO: Estimated = Estimated::Ratio(2, [0, 2]);

impl Estimated {
    /// The value in a row; `None` if its setting does not identify it.
    fn value(self, row: &ConfigurationRow) -> Option<f64> {
        let identified = |figure: usize, k: usize| {
            let value = row.exponents[figure][k];
            let is = row.statuses[figure][k] != Status::Unidentified.word() && value.is_finite();
            is.then_some(value)
        };
        match self {
            Estimated::Exponent(figure, k) => identified(figure, k),
            Estimated::Ratio(figure, [above, below]) => {
                Some(identified(figure, above)? / identified(figure, below)?)
            }
        }
    }
}

/// Rows that identify a value, and their values.
fn values(
    search: &CommittedSearch,
    of: Estimated,
    counts: fn(&Setting) -> bool,
) -> impl Iterator<Item = (usize, f64)> + Clone {
    let rows = search.recommended.iter().enumerate();
    let counted = rows.filter(move |(_, (_, setting))| counts(setting));
    counted.filter_map(move |(index, (row, _))| Some((index, of.value(row)?)))
}

/// The rows with the smallest and the largest value.
fn ends(
    search: &CommittedSearch,
    of: Estimated,
    counts: fn(&Setting) -> bool,
) -> Option<[usize; 2]> {
    let values = values(search, of, counts);
    let least = values
        .clone()
        .min_by(|one, other| one.1.total_cmp(&other.1))?;
    let largest = values.max_by(|one, other| one.1.total_cmp(&other.1))?;
    Some([least.0, largest.0])
}

/// Any setting.
pub fn any(_: &Setting) -> bool {
    true
}

/// A setting with Eq. (25) as printed, which has no affine term.
pub fn as_printed((_, settings): &Setting) -> bool {
    !settings.affine
}

/// Figures and rows at the ends of all ranges.
fn ends_of_all(search: &CommittedSearch) -> Vec<(usize, usize)> {
    let exponents = (0..12).map(|k| Estimated::Exponent(k / 4, k % 4));
    let with_figure = |of: Estimated| {
        let (Estimated::Exponent(figure, _) | Estimated::Ratio(figure, _)) = of;
        ends(search, of, any)
            .into_iter()
            .flatten()
            .map(move |row| (figure, row))
    };
    let all: BTreeSet<_> = exponents.chain([RATIO]).flat_map(with_figure).collect();
    all.into_iter().collect()
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
