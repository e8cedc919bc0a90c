//! The walk along a branch: steps, what is special on the way, and the end.

use super::corner::Behind;
use super::corrector::{Corrector, Guess, OnBranch};
use super::critical::{Critical, zero_between};
use super::rest::hopf;
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

/// An orbit of less than this part of the widest one's extent is about to be an equilibrium.
const SMALL: f64 = 0.04;

/// No step is longer than this part of the orbit's own extent.
const OF_EXTENT: f64 = 0.1;

/// A branch under way.
pub(super) struct Walk<'a, S: Switched<N, G>, const N: usize, const G: usize> {
    corrector: Corrector<'a, S>,
    settings: &'a ContinuationSettings,
    /// Width of the range.
    width: f64,
    /// Size of the first orbit.
    size: f64,
    /// Extent of the widest orbit yet.
    widest: f64,
    /// The last two orbits.
    before: OnBranch<N, S::Mode>,
    last: OnBranch<N, S::Mode>,
    step: f64,
    points: Vec<BranchPoint<N, S::Mode>>,
    special: Vec<SpecialPoint<N, S::Mode>>,
}

/// The line through the last two orbits, along which the next is sought.
struct Line<const N: usize> {
    base: Timed<N>,
    period: f64,
    /// Changes for a step of length 1.
    direction: State<N>,
    of_time: f64,
    of_period: f64,
    /// Distance between the two.
    length: f64,
    /// Weights of the components.
    weights: State<N>,
}

impl<const N: usize> Line<N> {
    /// Where the orbit is sought at a place on it.
    fn guess(&self, s: f64) -> Guess<N> {
        let at = Timed {
            t: self.base.t + self.of_time * s,
            x: self.base.x + self.direction * s,
        };
        let row = self.direction.component_mul(&self.weights);
        Guess {
            at,
            period: self.period + self.of_period * s,
            row,
            value: row.dot(&at.x),
        }
    }
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
        let first = first.ok_or(Error::NotConverged {
            what: "the first periodic orbit of the branch",
            iterations: 12,
            residual: f64::NAN,
            wanted: 100.0 * options.atol.max(options.rtol),
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

    fn parameter(&self) -> f64 {
        self.last.circuit.anchor.x[N - 1]
    }

    fn line(&self) -> Line<N> {
        let (a, b) = (&self.before.circuit, &self.last.circuit);
        let (state, parameter) = (1.0 / self.size, 1.0 / self.width);
        let weights = State::from_fn(|i, _| {
            let weight = if i + 1 < N { state } else { parameter };
            weight * weight
        });
        let is_forced = self.settings.forced.is_some();
        let mut way = b.anchor.x - a.anchor.x;
        if !is_forced {
            // Along the flow it is the same orbit.
            let mut flow = self.last.branch.slope;
            flow[N - 1] = 0.0;
            way -= flow * (flow.dot(&way) / flow.norm_squared());
        }
        let length = way.component_mul(&way).dot(&weights).sqrt();
        Line {
            // Only the forcing knows the time.
            base: Timed {
                t: if is_forced { b.anchor.t } else { 0.0 },
                x: b.anchor.x,
            },
            period: b.period,
            direction: way / length,
            of_time: if is_forced {
                (b.anchor.t - a.anchor.t) / length
            } else {
                0.0
            },
            of_period: (b.period - a.period) / length,
            length,
            weights,
        }
    }

    /// The orbit next to a place on the line, if there is one no farther from it than the place is from the last orbit.
    fn on(&self, line: &Line<N>, s: f64) -> Option<OnBranch<N, S::Mode>> {
        let guess = line.guess(s);
        let found = self.corrector.orbit(&guess, s)?;
        let off = found.branch.start - guess.at.x;
        let distance = off.component_mul(&off).dot(&line.weights).sqrt();
        (distance <= s.abs().max(0.1 * self.step)).then_some(found)
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

    /// Whether the next orbit lies outside the range; the last one is then that at its end.
    fn leaves_range(&mut self, next: &OnBranch<N, S::Mode>) -> Option<Stop> {
        let (low, high) = self.settings.range;
        let (here, there) = (self.parameter(), next.circuit.anchor.x[N - 1]);
        if (low..=high).contains(&there) {
            return None;
        }
        let end = there.clamp(low, high);
        let part = ((end - here) / (there - here)).clamp(0.0, 1.0);
        let (a, b) = (&self.last.circuit, &next.circuit);
        let at = Timed {
            t: b.anchor.t,
            x: a.anchor.x + (b.anchor.x - a.anchor.x) * part,
        };
        let found = self
            .corrector
            .orbit(&at_parameter(at, b.period, end), 0.0)
            .filter(|found| found.circuit.sequence() == a.sequence());
        if let Some(found) = found
            && part > 0.0
        {
            self.take(found);
        }
        Some(Stop::Range)
    }

    /// Whether the orbit is about to be an equilibrium.
    fn shrinks(&mut self) -> Option<Stop> {
        let extent = self.last.circuit.extent;
        if extent >= SMALL * self.widest || extent >= self.before.circuit.extent {
            return None;
        }
        let (parameter, frequency) = hopf(self.corrector.system, &self.last, self.width)?;
        Some(Stop::Equilibrium {
            parameter,
            frequency,
        })
    }

    /// What is special between the last orbit and the next, by the multipliers.
    fn note_critical(&mut self, line: &Line<N>, next: &OnBranch<N, S::Mode>) {
        let is_forced = self.settings.forced.is_some();
        let of = |orbit: &OnBranch<N, S::Mode>| Critical::of(&orbit.branch, is_forced);
        let (here, there) = (of(&self.last), of(next));
        let turns = {
            let change = |a: &OnBranch<N, _>, b: &OnBranch<N, _>| {
                b.circuit.anchor.x[N - 1] - a.circuit.anchor.x[N - 1]
            };
            change(&self.before, &self.last) * change(&self.last, next) < 0.0
        };
        type Function = fn(&Critical) -> Option<f64>;
        let functions: [Function; 3] = [|c| Some(c.one), |c| Some(c.minus_one), |c| c.circle];
        let mut found = Vec::new();
        for (kind, function) in functions.into_iter().enumerate() {
            let (Some(a), Some(b)) = (function(&here), function(&there)) else {
                continue;
            };
            if a * b >= 0.0 {
                continue;
            }
            let at = |s: f64| self.on(line, s);
            let value = |s: f64| at(s).and_then(|orbit| function(&of(&orbit)));
            let Some(orbit) = zero_between((0.0, a), (next.s, b), value).and_then(at) else {
                continue;
            };
            let what = match kind {
                0 if turns => Special::Fold,
                0 => self.fold_or_branch(line, next, &orbit),
                1 => Special::Flip,
                _ => Special::NeimarkSacker {
                    angle: of(&orbit).angle,
                },
            };
            found.push((
                orbit.s,
                SpecialPoint {
                    parameter: orbit.circuit.anchor.x[N - 1],
                    what,
                    behind: self.points.len(),
                    x: orbit.circuit.anchor.x,
                    period: orbit.circuit.period,
                },
            ));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.special
            .extend(found.into_iter().map(|(_, point)| point));
    }

    /// Whether the parameter turns back at an orbit between the last and the next one.
    fn fold_or_branch(
        &self,
        line: &Line<N>,
        next: &OnBranch<N, S::Mode>,
        orbit: &OnBranch<N, S::Mode>,
    ) -> Special<N, S::Mode> {
        let near = 1e-3 * next.s;
        let parameter = |s: f64| {
            let found = self.on(line, s);
            found.map(|found| found.circuit.anchor.x[N - 1])
        };
        let here = orbit.circuit.anchor.x[N - 1];
        match (parameter(orbit.s - near), parameter(orbit.s + near)) {
            (Some(before), Some(behind)) if (before - here) * (behind - here) < 0.0 => {
                Special::BranchPoint
            }
            _ => Special::Fold,
        }
    }

    /// Goes on from this orbit.
    fn take(&mut self, next: OnBranch<N, S::Mode>) {
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
fn at_parameter<const N: usize>(at: Timed<N>, period: f64, parameter: f64) -> Guess<N> {
    let mut at = at;
    at.x[N - 1] = parameter;
    Guess {
        at,
        period,
        row: State::from_fn(|i, _| f64::from(u8::from(i == N - 1))),
        value: parameter,
    }
}
