//! Chaotic motions with the spring of Eq. (4), where no start settles: exponents and stick phases.

use std::ops::ControlFlow;

use super::point::{double_well, starts};
use crate::figures::block_and_bracket::{DIVERGED, TOLERANCE};
use crate::numbers::extent;
use crate::paper::models::ForcedOscillator;
use stickslip::analysis::{Spectrum, SpectrumOptions};
use stickslip::{Error, Mode, Observer, Options, Phase, State};

/// Stride of the scan's starts that are integrated: all lead to motions of one kind.
const START_STRIDE: usize = 10;
/// Forcing periods before measuring.
const TRANSIENT: f64 = 100.0;
/// Forcing periods measured.
const MEASURED: u32 = 2000;
/// Standard errors by which a positive exponent must exceed zero. An estimate of a zero exponent
/// exceeds this once in 30 000.
const STANDARD_ERRORS: f64 = 4.0;
/// Stick phases are near the published ones if their lengths differ by at most this fraction: one
/// of the four printed digits.
const LENGTH_TOLERANCE: f64 = 0.1;

/// Results for one start.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredStart {
    /// First Lyapunov exponent (1/s), from the equations; −∞ if stick annihilates even that
    /// direction.
    pub lambda: f64,
    /// Standard error (1/s), from the means of blocks of a hundred forcing periods.
    pub std_error: f64,
    /// Lengths of the stick phases within the 2000 forcing periods measured (m), in order of time.
    pub lengths: Vec<f64>,
}

impl MeasuredStart {
    /// Whether the first exponent is positive by several standard errors.
    pub fn is_chaotic(&self) -> bool {
        self.lambda > STANDARD_ERRORS * self.std_error
    }

    /// Distance of the stick phases from the published lengths. For two successive phases, it is
    /// the larger of the relative differences from the published pair, in either order. The minimum
    /// over all pairs is returned; it is infinite with fewer than two.
    pub fn distance(&self, published: [f64; 2]) -> f64 {
        let off = |length: f64, published: f64| (length / published - 1.0).abs();
        let [first, second] = published;
        let of = |pair: &[f64]| {
            let forward = off(pair[0], first).max(off(pair[1], second));
            let backward = off(pair[0], second).max(off(pair[1], first));
            forward.min(backward)
        };
        extent(self.lengths.windows(2).map(of)).0
    }
}

/// Some of the starts, with the spring of Eq. (4).
#[derive(Clone, Debug, PartialEq)]
pub struct Chaos {
    /// Every tenth of the scan's starts, from the first on.
    pub followed: Vec<MeasuredStart>,
    /// The published lengths (m).
    pub published: [f64; 2],
}

impl Chaos {
    /// Integrates every tenth of the scan's starts.
    ///
    /// # Errors
    /// Those of [`stickslip::analysis::lyapunov_spectrum`].
    pub(super) fn compute(published: [f64; 2]) -> Result<Chaos, Error> {
        let model = double_well();
        let starts = starts(&ForcedOscillator::default())?.into_iter();
        let followed = starts.step_by(START_STRIDE).map(|x| follow(&model, x));
        Ok(Chaos {
            followed: followed.collect::<Result<_, Error>>()?,
            published,
        })
    }

    /// The smallest distance of any of them from the published lengths.
    pub fn distance(&self) -> f64 {
        let followed = self.followed.iter();
        extent(followed.map(|one| one.distance(self.published))).0
    }

    /// Whether any of them has two successive stick phases with lengths near the published ones.
    pub fn is_near(&self) -> bool {
        self.distance() <= LENGTH_TOLERANCE
    }

    /// The motions in words.
    pub fn sentence(&self) -> String {
        let (followed, all) = (&self.followed, self.followed.len());
        let some = |is: fn(&MeasuredStart) -> bool, verb: &str, none: &str| {
            let count = followed.iter().filter(|one| is(one)).count();
            match count {
                count if count == all => verb.to_owned(),
                0 => none.to_owned(),
                count => format!("{verb} from {count} of {all} starts"),
            }
        };
        let sticks = some(|one| !one.lengths.is_empty(), "sticks", "does not stick");
        let chaotic = some(MeasuredStart::is_chaotic, "chaotically", "not chaotically");
        let near = match self.is_near() {
            true => "near the published lengths",
            false => "nowhere near the published lengths",
        };
        let least_and_most = |of: fn(&MeasuredStart) -> f64| extent(followed.iter().map(of));
        let (low, high) = least_and_most(|one| one.lambda);
        let (_, error) = least_and_most(|one| one.std_error);
        let (few, many) = least_and_most(|one| one.lengths.len() as f64);
        let (shortest, longest) = extent(followed.iter().flat_map(|one| one.lengths.clone()));
        let of_stick = match shortest <= longest {
            true => {
                format!("{few:.0} to {many:.0} stick phases of {shortest:.4} to {longest:.4} m")
            }
            false => "no stick phase".to_owned(),
        };
        let percent = 100.0 * self.distance();
        let nearest = match percent.is_finite() {
            true => {
                let [first, second] = self.published;
                format!(
                    "no two in succession come nearer to the published {first} and {second} m than \
                     {percent:.0} %"
                )
            }
            false => "no two of them follow each other".to_owned(),
        };
        format!(
            "With the spring of Eq. (4) the block {sticks}, {chaotic}, and {near}: from {all} \
             starts, every {START_STRIDE}th of the scan's, λ1 = {low:.2} to {high:.2} 1/s with \
             standard errors up to {error:.2}, and in {MEASURED} forcing periods {of_stick}; \
             {nearest}."
        )
    }
}

/// Integrates one start.
fn follow(model: &ForcedOscillator, x: State<2>) -> Result<MeasuredStart, Error> {
    let period = model.period();
    let (transient, measured) = (TRANSIENT * period, f64::from(MEASURED) * period);
    let options = Options::tol(TOLERANCE).escape(DIVERGED);
    let settings = SpectrumOptions::over(transient, measured).solver(options);
    let mut sticks = Sticks {
        from: transient,
        lengths: Vec::new(),
    };
    let spectrum = Spectrum::watched(model, (0.0, x), &settings, &mut sticks)?;
    let first = spectrum.exponents[0];
    Ok(MeasuredStart {
        lambda: first.value(),
        std_error: first.std_error().unwrap_or(f64::INFINITY),
        lengths: sticks.lengths,
    })
}

/// Records the lengths of the stick phases that begin after some time.
struct Sticks {
    from: f64,
    lengths: Vec<f64>,
}

impl Observer<2> for Sticks {
    fn phase(&mut self, phase: &Phase<2>) -> ControlFlow<()> {
        if phase.mode == Mode::Stick && phase.t_start >= self.from {
            self.lengths.push(phase.displacement()[0]);
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn followed(lambda: f64, lengths: &[f64]) -> MeasuredStart {
        MeasuredStart {
            lambda,
            std_error: 0.02,
            lengths: lengths.to_vec(),
        }
    }

    fn of(followed: Vec<MeasuredStart>) -> Chaos {
        let published = [0.4697, 0.1663];
        Chaos {
            followed,
            published,
        }
    }

    #[test]
    fn the_sentence_says_what_was_found() {
        let short = || followed(0.4, &[0.01, 0.05]);
        let sentence = of(vec![short(), short()]).sentence();
        assert!(
            sentence.contains("block sticks, chaotically, and nowhere near the published lengths"),
            "{sentence}"
        );
        // Each part of the sentence changes with its number.
        let regular = of(vec![short(), followed(0.05, &[0.01])]).sentence();
        assert!(
            regular.contains("sticks, chaotically from 1 of 2 starts, and nowhere near"),
            "{regular}"
        );
        let slips = of(vec![followed(0.4, &[]), followed(0.4, &[])]).sentence();
        assert!(
            slips.contains("does not stick, chaotically, and nowhere near"),
            "{slips}"
        );
        let found = of(vec![short(), followed(0.4, &[0.02, 0.16, 0.46])]).sentence();
        assert!(
            found.contains("chaotically, and near the published lengths"),
            "{found}"
        );
    }

    #[test]
    fn model_2_with_the_spring_of_eq_4_sticks_chaotically() {
        let found = Chaos::compute([0.4697, 0.1663]).unwrap();
        assert!(found.followed.len() >= 5);
        let sticks = |one: &MeasuredStart| !one.lengths.is_empty() && one.is_chaotic();
        assert!(found.followed.iter().all(sticks) && !found.is_near());
    }
}
