//! `fig10.class`: how many loops the corrected model of Fig. 10 has from other starts and with one
//! number of its caption changed.

use rayon::prelude::*;

use crate::paper::models::{Caption, Interpretation};
use crate::report::errata::{MotionOutcome, by_section};
use crate::text::joined;
use numerics::SplitMix;
use stickslip::{Error, math};

/// Number of starts, each component up to [`REACH`] in size, from a fixed seed.
const STARTS: usize = 60;
const REACH: f64 = 2.0;
const SEED: u64 = 10;
/// The numbers of the caption that are changed, by name. The others are zero.
const NUMBERS: [(&str, usize); 7] = [
    ("xi1", 0),
    ("xi3", 2),
    ("xi4", 3),
    ("mu0", 5),
    ("xi6", 6),
    ("delta", 7),
    ("vp", 8),
];
/// Factors to either side of 1, up to 2: 4.4 % apart, as in the scan of Fig. 8.
const FACTORS: i32 = 16;
/// Loops in the caption.
const CAPTIONED: usize = 2;

/// Loops of the motion of Fig. 10.
#[derive(Clone, Debug, PartialEq)]
pub struct Loops {
    /// Starts, and those that lead to a closed orbit of one loop.
    pub starts: (usize, usize),
    /// Changed number, factor of its least change in either direction, for two loops.
    pub nearest: Vec<(&'static str, f64)>,
}

fn is_closed(outcome: MotionOutcome, loops: usize) -> bool {
    matches!(outcome, MotionOutcome::Closes(turns, _) if turns == loops)
}

impl Loops {
    /// Integrates all starts, and all changes from the caption's start.
    pub(super) fn compute() -> Result<Loops, Error> {
        let mut random = SplitMix::from_index(SEED, 0);
        let mut start = || std::array::from_fn(|_| random.between(-REACH, REACH));
        let starts: Vec<[f64; 4]> = (0..STARTS).map(|_| start()).collect();
        let outcomes = starts.into_par_iter().map(|start| {
            let caption = Caption {
                start,
                ..Caption::FIG10
            };
            by_section(&caption, &Interpretation::exact())
        });
        let outcomes = outcomes.collect::<Result<Vec<_>, Error>>()?;
        let one = outcomes.iter().filter(|one| is_closed(**one, 1)).count();
        let lines = NUMBERS
            .into_par_iter()
            .flat_map_iter(|number| [-1, 1].map(|sign| (number, sign)));
        let nearest = lines.map(|((name, index), sign)| {
            // The first change that has the captioned loops ends the search.
            let found = (1..=FACTORS).find_map(|k| {
                let factor = math::pow(2.0, f64::from(sign * k) / f64::from(FACTORS));
                let mut caption = Caption::FIG10;
                caption.numbers[index] *= factor;
                match by_section(&caption, &Interpretation::exact()) {
                    Ok(outcome) => is_closed(outcome, CAPTIONED).then_some(Ok((name, factor))),
                    Err(error) => Some(Err(error)),
                }
            });
            found.transpose()
        });
        let nearest = nearest.collect::<Result<Vec<_>, Error>>()?;
        Ok(Loops {
            starts: (STARTS, one),
            nearest: nearest.into_iter().flatten().collect(),
        })
    }

    /// Describes the loops in words.
    pub fn sentence(&self) -> String {
        let (all, one) = self.starts;
        let changes = self.nearest.iter().map(|(name, factor)| {
            let percent = format!("{:+.0}", 100.0 * (factor - 1.0)).replace('-', "−");
            format!("{name} {percent} %")
        });
        let least = match joined(changes, ", ") {
            none if none.is_empty() => "no change has two loops".to_owned(),
            changes => format!("two loops need at least {changes}"),
        };
        format!(
            "{one} of {all} random starts with components up to {REACH} in size close after one \
             loop; of the caption's numbers, each changed alone by up to a factor of two in steps \
             of 4.4 % (narrower windows would be missed), {least}"
        )
    }
}
