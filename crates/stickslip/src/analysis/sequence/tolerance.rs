//! By how much the tolerances have the place of a change off.

use super::Orbits;
use super::locate::{Known, is_same};
use super::margin::Margin;
use crate::analysis::critical::zero_between;
use crate::math;

/// Orbits are computed so many times farther away than what is known already, each next one as much farther than the one before; and so many at most.
const FARTHER: f64 = 10.0;
const MOST: i32 = 9;

/// By how much a value may be off, which is another one with a tenth of the tolerances: most of it is the difference, and twice that is on the safe side.
pub(in crate::analysis) fn of_tolerance(value: f64, finer: f64) -> f64 {
    2.0 * (finer - value).abs()
}

/// The zero of an event function next to the last orbit, whose place is the parameter.
pub(super) struct Near<'a, B, O> {
    pub last: &'a Known<B>,
    pub margin: &'a Margin,
    /// The way back to an orbit that is apart from it, or zero where there is none.
    pub away: f64,
    /// What the location lacks.
    pub lacks: f64,
    pub about: &'a O,
}

impl<B, O: Orbits<B>> Near<'_, B, O> {
    /// An orbit with the same phases so far away.
    fn orbit(&self, way: f64) -> Option<Known<B>> {
        let one = self.about.at(self.last.s + way, &[])?;
        self.last.goes_on_in(&one).then_some(one)
    }

    fn value(&self, way: f64) -> Option<f64> {
        let orbit = self.orbit(way)?;
        Some(orbit.circuit.margin_like(self.margin)?.value)
    }

    /// Ways back, each longer than the one before; to both sides where it is not known which is back.
    fn ways(&self) -> impl Iterator<Item = f64> {
        let least = self.lacks.max(f64::EPSILON * self.last.s.abs());
        let signs = match self.away {
            0.0 => [1.0, -1.0],
            away => [away.signum(), f64::NAN],
        };
        let ways =
            (1..=MOST).flat_map(move |k| signs.map(|sign| sign * least * math::powi(FARTHER, k)));
        ways.filter(|way| way.is_finite())
    }

    /// The zero, where it lies before the last orbit: by how little the boundary is passed at a graze that is not noticed depends on the tolerances.
    pub fn passed(&self) -> Option<f64> {
        let last = self.margin.value;
        let values = self.ways().filter_map(|way| Some((way, self.value(way)?)));
        // Back over the zero if it was passed, or else away from it at once.
        let mut values =
            values.skip_while(|(_, value)| value * last > 0.0 && value.abs() < last.abs());
        let (way, value) = values.next()?;
        if value * last >= 0.0 {
            return None;
        }
        // Next to it the boundary is touched, and no minimum is told: the line through both sides is as good.
        let value_at = |way| Some(self.value(way).unwrap_or(0.0));
        let zero = zero_between((way, value), (0.0, last), value_at)?;
        Some(self.last.s + zero)
    }

    /// By how much the tolerances may have the zero off: by the function's difference on an orbit with the same phases a little way back, over its slope.
    /// The way is longer than the shift, so that the orbit has these phases with a tenth of the tolerances as well. Where nothing tells, it may be as far
    /// away as orbits were known.
    pub fn shift_by_tolerances(&self) -> f64 {
        const SHORTER: f64 = 0.5;
        let shift = |way: f64| {
            let one = self.orbit(way)?;
            let there = one.circuit.margin_like(self.margin)?;
            let finer = self.about.finer(&one)?;
            let same = is_same(&finer.sequence(), &one.circuit.sequence());
            let other = same.then_some(&finer)?.margin_like(there)?;
            let slope = (there.value - self.margin.value) / way;
            let shift = (of_tolerance(there.value, other.value) / slope).abs();
            (shift <= SHORTER * way.abs()).then_some(shift)
        };
        self.ways().find_map(shift).unwrap_or(self.away.abs())
    }
}
