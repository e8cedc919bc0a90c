//! The walk along a branch: steps, what is special on the way, and the end.

use super::corner::Behind;
use super::corrector::{Corrector, Guess, OnBranch};
use super::critical::Critical;
use super::line::Line;
use super::{Branch, BranchPoint, ContinuationSettings, Special, SpecialPoint, Stop};
use crate::analysis::periodic::slope_at;
use crate::analysis::sequence::SequenceBifurcation;
use crate::analysis::sequence::circuit::anchor;
use crate::analysis::sequence::locate::locate;
use crate::error::Error;
use crate::filippov::{Options, Switched};
use crate::ode::Timed;
use crate::system::State;

/// A change of phases is located to this part of the range.
const RESOLUTION: f64 = 1e-11;

/// Steps shorter than this lead nowhere.
const SHORTEST: f64 = 1e-7;

/// No step is longer than this part of the orbit's own extent.
const OF_EXTENT: f64 = 0.1;

/// A branch under way.
pub(super) struct Walk<'a, S: Switched<N, G>, const N: usize, const G: usize> {
    pub(super) corrector: Corrector<'a, S>,
    pub(super) settings: &'a ContinuationSettings,
    /// Width of the range.
    pub(super) width: f64,
    /// Size of the first orbit.
    pub(super) size: f64,
    /// Extent of the widest orbit yet.
    pub(super) widest: f64,
    /// The last two orbits.
    pub(super) before: OnBranch<N, S::Mode>,
    pub(super) last: OnBranch<N, S::Mode>,
    pub(super) step: f64,
    pub(super) points: Vec<BranchPoint<N, S::Mode>>,
    pub(super) special: Vec<SpecialPoint<N, S::Mode>>,
}

impl<'a, S: Switched<N, G>, const N: usize, const G: usize> Walk<'a, S, N, G> {
    pub fn begin(
        system: &'a S,
        x: State<N>,
        period: f64,
        settings: &'a ContinuationSettings,
        options: &'a Options,
    ) -> Result<Self, Error> {
        let rate = slope_at(system, 0.0, &x)[N - 1];
        if rate != 0.0 {
            return Err(Error::Parameter {
                name: "the last state's rate",
                value: rate,
                bound: "zero: the last state is the parameter of the continuation",
            });
        }
        let corrector = Corrector {
            system,
            forced: settings.forced,
            options,
        };
        let period = settings.forced.unwrap_or(period);
        let at = anchor(system, &Timed { t: 0.0, x }, period, options)?;
        let first = corrector.orbit(&at_parameter(at, period, x[N - 1]), 0.0);
        let first = first.ok_or(Error::NotFound {
            what: "a periodic orbit near the start of the branch",
            t: at.t,
            span: period,
        })?;
        let mut walk = Walk {
            corrector,
            settings,
            width: settings.range.1 - settings.range.0,
            size: first.circuit.extent,
            widest: first.circuit.extent,
            before: first.clone(),
            last: first,
            step: settings.step,
            points: Vec::new(),
            special: Vec::new(),
        };
        walk.note();
        Ok(walk)
    }

    pub fn into_branch(self, stop: Stop) -> Branch<N, S::Mode> {
        Branch {
            points: self.points,
            special: self.special,
            stop,
        }
    }

    /// Follows the branch to its end.
    pub fn go(&mut self, upwards: bool) -> Stop {
        if let Some(stop) = self.second(if upwards { 1.0 } else { -1.0 }) {
            return stop;
        }
        loop {
            if self.points.len() >= self.settings.most_points {
                return Stop::Points;
            }
            if let Some(stop) = self.shrinks().or_else(|| self.advance()) {
                return stop;
            }
        }
    }

    /// The second orbit, at a parameter a little further on.
    fn second(&mut self, direction: f64) -> Option<Stop> {
        let mut way = 0.1 * self.settings.step * self.width * direction;
        let here = self.parameter();
        for _ in 0..12 {
            let circuit = &self.last.circuit;
            let guess = at_parameter(circuit.anchor, circuit.period, here + way);
            if let Some(next) = self.corrector.orbit(&guess, 0.0)
                && next.circuit.sequence() == circuit.sequence()
            {
                self.take(next);
                return None;
            }
            way *= 0.25;
        }
        Some(Stop::NoConvergence)
    }

    pub(super) fn parameter(&self) -> f64 {
        self.last.circuit.anchor.x[N - 1]
    }

    /// Takes a step, or gets behind a change of phases.
    fn advance(&mut self) -> Option<Stop> {
        let line = self.line();
        let wanted = self.last.circuit.sequence();
        let step = self
            .step
            .min(OF_EXTENT * self.last.circuit.extent / self.size);
        match self.on(&line, step) {
            Some(next) if next.circuit.sequence() == wanted => {
                if let Some(stop) = self.leaves_range(&next) {
                    return Some(stop);
                }
                self.note_critical(&line, &next);
                let few = next.branch.iterations <= 5;
                let longer = if few { 1.4 * step } else { step };
                self.step = longer.min(self.settings.step);
                self.take(next);
                None
            }
            other => self.get_behind(&line, step, other),
        }
    }

    /// The phases change within the step, or it is too long.
    fn get_behind(
        &mut self,
        line: &Line<N>,
        step: f64,
        trial: Option<OnBranch<N, S::Mode>>,
    ) -> Option<Stop> {
        let wanted = self.last.circuit.sequence();
        let (mut before, mut last) = (self.before.clone(), self.last.clone());
        (before.s, last.s) = (-line.length, 0.0);
        let mut good = vec![before, last];
        let mut behind: Vec<_> = trial.into_iter().collect();
        let bad = locate(&mut good, step, RESOLUTION, |s, _| {
            let found = self.on(line, s)?;
            if found.circuit.sequence() != wanted {
                behind.push(found.clone());
            }
            Some(found)
        });
        behind.sort_by(|a, b| a.s.total_cmp(&b.s));
        let edge = good.last()?.clone();
        let place = (edge.circuit.anchor.x[N - 1], (bad - edge.s) * self.width);
        let next = Behind {
            corrector: &self.corrector,
            good: &good,
            found: &behind,
            width: self.width,
        }
        .enter(place)?;
        if next.change.bifurcation == SequenceBifurcation::Unnamed {
            // Another orbit was met, or none: nearer to the last one it may be the right one.
            self.step = 0.1 * step;
            if edge.s > 0.01 * step {
                self.note_critical(line, &edge);
                self.take(edge);
            }
            return (self.step < SHORTEST).then_some(Stop::NoConvergence);
        }
        if edge.s > 0.0 {
            self.note_critical(line, &edge);
            self.take(edge.clone());
        }
        self.special.push(SpecialPoint {
            parameter: next.change.parameter,
            behind: self.points.len(),
            x: next.at.x,
            period: next.change.period,
            what: Special::Sequence(Box::new(next.change)),
        });
        let Some([near, far]) = next.orbits else {
            return Some(Stop::SequenceEnds);
        };
        self.take(near);
        self.take(far);
        None
    }

    /// Goes on from this orbit.
    pub(super) fn take(&mut self, next: OnBranch<N, S::Mode>) {
        self.widest = self.widest.max(next.circuit.extent);
        self.before = std::mem::replace(&mut self.last, next);
        self.note();
    }

    fn note(&mut self) {
        let OnBranch {
            circuit, branch, ..
        } = &self.last;
        let is_forced = self.settings.forced.is_some();
        self.points.push(BranchPoint {
            parameter: circuit.anchor.x[N - 1],
            t: circuit.anchor.t,
            x: circuit.anchor.x,
            period: circuit.period,
            multipliers: Critical::of(branch, is_forced).multipliers,
            sequence: circuit.modes(),
        });
    }
}

/// The orbit at a given parameter, near a state.
pub(super) fn at_parameter<const N: usize>(at: Timed<N>, period: f64, parameter: f64) -> Guess<N> {
    let mut at = at;
    at.x[N - 1] = parameter;
    Guess {
        at,
        period,
        row: State::from_fn(|i, _| f64::from(u8::from(i == N - 1))),
        value: parameter,
    }
}
