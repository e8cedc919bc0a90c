//! Conditions of jumps, and derivatives of functions at a moment.

use std::sync::Arc;

use stickslip::Direction;
use stickslip::dynamics::Comparison;
use stickslip::scalar::Dual;

use super::impacts::ROUNDING;
use crate::expression::{self, Tape};

/// A choice in what a jump sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The condition that decides.
    pub condition: JumpCondition,
    /// The choices of the jump, by number, of whose branch it is part: that where they hold, or the
    /// other one.
    pub within: Vec<(usize, bool)>,
}

/// The map of a state by a jump.
pub(super) type StateMap<'m> = dyn Fn(&mut [f64]) + 'm;

/// The condition of a jump.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpCondition {
    /// The comparisons and how they are joined.
    pub test: expression::Condition,
    /// Lead of the number that is asked to be larger, for each comparison in order.
    pub leads: Tape,
    /// Number of comparisons.
    pub count: usize,
}

impl JumpCondition {
    /// The condition with other values of the held numbers of its graph.
    pub(super) fn with_held(&self, held: &Arc<[f64]>) -> Self {
        JumpCondition {
            leads: self.leads.with_held(held),
            ..self.clone()
        }
    }

    /// Whether it holds; `None` where a number that decides it is none.
    pub(super) fn holds(&self, t: f64, x: &[f64]) -> Option<bool> {
        let mut leads = vec![f64::NAN; self.count];
        self.leads.evaluate(t, x, &mut leads);
        judged(&self.test, &mut leads.into_iter())
    }

    /// The comparisons, numbered from `first` on. In a choice, `map` is what the jump makes of a
    /// state, and a comparison decides nothing at which that is continuous.
    pub(super) fn comparisons(
        &self,
        (t, x): (f64, &[f64]),
        discrete: &[bool],
        (first, map): (usize, Option<&StateMap<'_>>),
    ) -> Vec<Comparison> {
        let is_of_condition = map.is_none();
        let all = self.compared(t, x, discrete).into_iter();
        let all = all.map(|(of, decides)| {
            let jumps = |map| !of.is_continuous(map, (t, x));
            let decides = decides && map.is_none_or(jumps);
            (of, decides)
        });
        let all = all.enumerate();
        all.map(|(number, (of, decides))| Comparison {
            number: first + number,
            lead: of.value,
            size: of.value.abs() + of.size(t, x),
            slope: of
                .by_state
                .iter()
                .map(|slope| slope * slope)
                .sum::<f64>()
                .sqrt(),
            decides,
            is_of_condition,
        })
        .collect()
    }

    /// Whether a comparison that decides is between equal numbers, to rounding, and a change of the
    /// time or of a state that is not discrete makes one of them larger.
    pub(super) fn is_tied(&self, t: f64, x: &[f64], discrete: &[bool]) -> bool {
        let mut all = self.compared(t, x, discrete).into_iter();
        all.any(|(of, decides)| decides && of.value.abs() <= ROUNDING * of.size(t, x))
    }

    /// The lead of each comparison, and whether the opposite result of that alone would change
    /// whether the condition holds. It never is where only discrete states move the lead.
    fn compared(&self, t: f64, x: &[f64], discrete: &[bool]) -> Vec<(Slopes, bool)> {
        let mut leads = vec![f64::NAN; self.count];
        self.leads.evaluate(t, x, &mut leads);
        let slopes = slopes(&self.leads, self.count, t, x).into_iter();
        let decided = |(number, of): (usize, Slopes)| {
            let moves = |state: usize| discrete.get(state) != Some(&true);
            let by_state = of.by_state.iter().enumerate();
            let is_moved = of.in_time != 0.0 || { by_state }
                .any(|(state, slope)| *slope != 0.0 && moves(state));
            let [one, other] = [1.0, -1.0].map(|side| {
                let mut leads = leads.clone();
                leads[number] = side;
                judged(&self.test, &mut leads.into_iter())
            });
            (of, is_moved && one != other)
        };
        slopes.enumerate().map(decided).collect()
    }
}

/// Whether a condition holds with these leads, of which it takes its own. Of several parts, the
/// first that decides counts; `None` where it is not defined.
fn judged(test: &expression::Condition, leads: &mut impl Iterator<Item = f64>) -> Option<bool> {
    use expression::Condition as Test;
    let mut first = |parts: &[Test], decides: bool| {
        let all: Vec<Option<bool>> = parts.iter().map(|part| judged(part, leads)).collect();
        let found = all.into_iter().find(|part| *part != Some(!decides));
        found.unwrap_or(Some(!decides))
    };
    match test {
        Test::All(parts) => first(parts, false),
        Test::Any(parts) => first(parts, true),
        Test::Not(part) => judged(part, leads).map(|holds| !holds),
        Test::Comparison { with_equal, .. } => {
            let lead = leads.next().filter(|lead| !lead.is_nan())?;
            Some(lead > 0.0 || *with_equal && lead == 0.0)
        }
    }
}

/// The derivatives of a function by the states and by time.
struct Slopes {
    value: f64,
    by_state: Vec<f64>,
    in_time: f64,
}

impl Slopes {
    /// Size of the terms of the function, by which rounding of the state and time changes it.
    fn size(&self, t: f64, x: &[f64]) -> f64 {
        let sizes = self.by_state.iter().zip(x);
        let sizes = sizes.map(|(slope, x)| (slope * x).abs());
        sizes.sum::<f64>() + (self.in_time * t).abs()
    }

    /// Whether a map of the state is continuous across the nearest zero of the function. Beside a
    /// place where it jumps, values on both sides stay apart as they come nearer.
    fn is_continuous(&self, map: &StateMap<'_>, (t, x): (f64, &[f64])) -> bool {
        let square = self.by_state.iter().map(|slope| slope * slope).sum::<f64>();
        let after = |value: f64| {
            let mut x = x.to_vec();
            for (x, slope) in x.iter_mut().zip(&self.by_state) {
                *x += slope * ((value - self.value) / square);
            }
            map(&mut x);
            x
        };
        let apart = |off: f64| {
            let pairs = after(off).into_iter().zip(after(-off));
            pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let near = ROUNDING.sqrt() * (self.value.abs() + self.size(t, x));
        square > 0.0 && apart(near / 16.0) <= 0.5 * apart(near)
    }
}

/// The derivatives of so many functions.
fn slopes(functions: &Tape, count: usize, t: f64, x: &[f64]) -> Vec<Slopes> {
    let mut all = Vec::with_capacity(count);
    // The last direction is that of time.
    for direction in 0..=x.len() {
        let seed = |at: usize| f64::from(u8::from(at == direction));
        let seeded = x.iter().enumerate().map(|(i, x)| Dual::new(*x, seed(i)));
        let seeded: Vec<Dual<f64>> = seeded.collect();
        let mut out = vec![Dual::new(0.0, 0.0); count];
        functions.evaluate(Dual::new(t, seed(x.len())), &seeded, &mut out);
        all.push(out);
    }
    let of = |number: usize| Slopes {
        value: all[0][number].re,
        by_state: (0..x.len()).map(|state| all[state][number].eps).collect(),
        in_time: all[x.len()][number].eps,
    };
    (0..count).map(of).collect()
}

/// A motion along which the sign of a function is asked for.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    /// Rates of the states.
    pub rates: &'a [f64],
    /// What the location of a zero has left of the function there.
    pub left: f64,
}

/// The sign that a function has from a moment on: of its value, or of its rate along the motion
/// where the value is rounding. Zero where both are, or without a motion.
pub(super) fn sign_from(function: &Tape, (t, x): (f64, &[f64]), motion: Option<Motion<'_>>) -> f64 {
    let of = |value: f64, rounding: f64| match value.abs() > rounding {
        true => value.signum(),
        false => 0.0,
    };
    let mut all = slopes(function, 1, t, x).into_iter();
    let sign = all.next().map(|one| {
        let rounding = ROUNDING * one.size(t, x);
        let Some(Motion { rates, left }) = motion else {
            return of(one.value, rounding);
        };
        let parts = one.by_state.iter().zip(rates);
        let parts = parts.map(|(slope, rate)| slope * rate).chain([one.in_time]);
        let (rate, speed) = parts.fold((0.0, 0.0), |(rate, speed), part| {
            (rate + part, speed + part.abs())
        });
        // The instant is known to the rounding of time.
        match of(one.value, left.max(rounding + ROUNDING * speed * t.abs())) {
            0.0 => of(rate, ROUNDING * speed),
            sign => sign,
        }
    });
    sign.unwrap_or(0.0)
}

/// Whether a function of time alone, as far as the first `states` are concerned, is zero at a
/// moment to rounding and goes in this direction.
pub(super) fn passes_by_time(
    function: &Tape,
    states: usize,
    direction: Direction,
    (t, x): (f64, &[f64]),
) -> bool {
    slopes(function, 1, t, x).into_iter().any(|one| {
        let goes = match direction {
            Direction::Rising => one.in_time > 0.0,
            Direction::Falling => one.in_time < 0.0,
            Direction::Both => one.in_time != 0.0,
        };
        let mut by_state = one.by_state.iter().take(states);
        goes && by_state.all(|slope| *slope == 0.0) && one.value.abs() <= ROUNDING * one.size(t, x)
    })
}
