//! The time between two rows: from a column, or held against one.

use stickslip::statistics::middle_two;

/// Rows may be further apart in time than `dt` by this part of it.
const UNEVEN: f64 = 0.01;
/// A step that differs from one of ten digits by no more than this part is that one: the rest is rounding of the printed times.
const ROUNDING: f64 = 1e-9;

/// The times of the rows, with their lines.
#[derive(Default)]
pub(super) struct Clock(Vec<(u64, f64)>);

/// Two rows that are not one step apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    /// Line of the later one.
    pub line: u64,
    /// Their times.
    pub from: f64,
    pub to: f64,
    /// What the step should be.
    pub dt: f64,
}

impl Clock {
    pub(super) fn push(&mut self, line: u64, time: f64) {
        self.0.push((line, time));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether all steps are `dt`; if not, the first that is another.
    pub(super) fn holds(&self, dt: f64) -> Result<(), Gap> {
        let gap = |pair: &&[(u64, f64)]| !agree(pair[1].1 - pair[0].1, dt);
        self.0.windows(2).find(gap).map_or(Ok(()), |pair| {
            let ((_, from), (line, to)) = (pair[0], pair[1]);
            Err(Gap { line, from, to, dt })
        })
    }

    /// The step that they all are.
    pub(super) fn dt(&self) -> Result<f64, Gap> {
        let steps: Vec<f64> = self
            .0
            .windows(2)
            .map(|pair| pair[1].1 - pair[0].1)
            .collect();
        let Some([middle, _]) = middle_two(steps.iter().copied()) else {
            // One row is too few whatever its step.
            return Ok(1.0);
        };
        // Times that descend or stand still are told at the first row that does.
        self.holds(rounded(middle.abs()).max(f64::MIN_POSITIVE))?;
        let (first, last) = (self.0[0].1, self.0[steps.len()].1);
        Ok(rounded((last - first) / steps.len() as f64))
    }
}

/// The step of values that rise or fall evenly; two are even whatever they are.
pub(super) fn even_step(values: impl DoubleEndedIterator<Item = f64> + Clone) -> Option<f64> {
    let steps = values
        .clone()
        .count()
        .checked_sub(1)
        .filter(|&steps| steps > 1)?;
    let (first, last) = (values.clone().next()?, values.clone().next_back()?);
    let mean = (last - first) / steps as f64;
    let mut pairs = values.clone().zip(values.skip(1));
    let is_even = mean != 0.0 && pairs.all(|(one, next)| agree(next - one, mean));
    is_even.then(|| rounded(mean))
}

/// At most so many steps, and one in a hundred, that are not as all others are gaps of a time.
const GAPS: usize = 10;

/// Of values that rise evenly but for a few steps their step, and the number of the first value behind one of these, counted from 0.
pub(super) fn first_gap(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, usize)> {
    let pairs = values.clone().zip(values.skip(1));
    let all: Vec<f64> = pairs.map(|(one, next)| next - one).collect();
    let [step, _] = middle_two(all.iter().copied()).filter(|[step, _]| *step > 0.0)?;
    let mut gaps = (1..).zip(&all).filter(|(_, one)| !agree(**one, step));
    let (first, _) = gaps.next()?;
    let gaps = 1 + gaps.count();
    (gaps <= GAPS && 100 * gaps <= all.len()).then(|| (rounded(step), first))
}

/// Whether two steps are the same.
pub(super) fn agree(step: f64, dt: f64) -> bool {
    (step - dt).abs() <= UNEVEN * dt.abs()
}

fn rounded(step: f64) -> f64 {
    let short: f64 = format!("{step:.9e}").parse().unwrap_or(step);
    if (short - step).abs() <= ROUNDING * step.abs() {
        short
    } else {
        step
    }
}
