//! The steps along a branch of equilibria, and the special ones between them.

use nalgebra::Complex;

use super::super::Stop;
use super::super::crossings::{Crossing, Eigenvalue, Eigenvalues, MOST_HALVINGS, Spectra};
use super::super::sequence_changes::STEP_BEYOND;
use super::super::stepping::{FIRST_STEP, SHORTER, StepOutcome, Stepping, follow};
use super::super::tangent_line::LEAST_COSINE;
use super::{
    BranchEquilibrium, EquilibriaOnLine, EquilibriumBifurcation, EquilibriumBranch,
    EquilibriumContinuation, EquilibriumPoint, EquilibriumTangent, ROUNDING, SpecialEquilibrium,
    others,
};
use crate::analysis::attractors::equilibrium::{ZERO, holds};
use crate::analysis::cycle::{
    LocatedZero, SolutionFunction, SolutionsOnLine, unit, with_last_digits,
};
use crate::analysis::multipliers::{eigenvalues, uncertainties};
use crate::dynamics::{Matrix, Vector};

impl BranchEquilibrium {
    /// The eigenvalues, which rounding leaves uncertain: by that of the largest entry, and as much
    /// as a change of each entry by its rounding shows.
    fn spectrum(&self) -> Eigenvalues {
        let values = self.eigenvalues();
        let rounded = Matrix::from_fn(self.along.nrows(), self.along.ncols(), |i, j| {
            let sign = if (i + 2 * j) % 3 == 0 { -1.0 } else { 1.0 };
            self.along[(i, j)] * (1.0 + sign * ROUNDING)
        });
        let largest = self.along.amax();
        let known = uncertainties(&values, eigenvalues(&rounded), largest);
        let eigenvalue = |(value, known): (Complex<f64>, f64)| Eigenvalue {
            value,
            beyond: value.re,
            uncertainty: known.max(ROUNDING * largest),
        };
        Eigenvalues(values.into_iter().zip(known).map(eigenvalue).collect())
    }
}

impl Spectra for EquilibriaOnLine<'_> {
    fn spectrum(&self, one: &BranchEquilibrium) -> Option<Eigenvalues> {
        Some(one.spectrum())
    }
}

impl EquilibriumContinuation<'_> {
    /// Follows the branch from its first equilibrium to its end.
    pub(super) fn follow(
        self,
        first: BranchEquilibrium,
        row: &Vector,
    ) -> Option<EquilibriumBranch> {
        let line = self.tangent(&first, row)?;
        let mut steps = EquilibriumSteps {
            step: FIRST_STEP * self.settings.step,
            begin: (first.clone(), line.row.clone()),
            points: vec![first.point()],
            special: Vec::new(),
            of: self,
            last: first,
            line,
        };
        let stop = follow(&mut steps);
        let states = steps.of.units.len() - 1;
        let of_states = |x: &Vector| x.rows(0, states).abs();
        let points = steps.points.iter().map(|at| of_states(&at.x));
        Some(EquilibriumBranch {
            sizes: points.fold(of_states(&steps.of.units), |sizes, x| sizes.sup(&x)),
            points: steps.points,
            special: steps.special,
            stop,
        })
    }

    /// The special equilibria between two on a line, in order; beyond a boundary this mode has
    /// none. `None` where the mode does not hold at the second one and its boundary was not found.
    fn between(
        &self,
        line: &EquilibriumTangent,
        (last, next): (&BranchEquilibrium, &BranchEquilibrium),
        length: f64,
    ) -> Option<Vec<(LocatedZero<BranchEquilibrium>, EquilibriumBifurcation)>> {
        let path = self.on(line);
        let width = self.units[self.units.len() - 1];
        let heading =
            |one: &BranchEquilibrium| Some(self.tangent(one, &line.row)?.heading() / width);
        let branch = |one: &BranchEquilibrium| Some(one.along.determinant() / heading(one)?);
        let rate = |one: &BranchEquilibrium| Some(one.pair()?.re);
        let size = last.along.amax();
        let boundary = |contact| EquilibriumBifurcation::Boundary {
            contact,
            before: line.mode,
            after: None,
            turns: false,
        };
        let hopf = EquilibriumBifurcation::Hopf { frequency: 0.0 };
        let is_moved = [last, next].map(heading);
        let is_moved = is_moved
            .into_iter()
            .flatten()
            .any(|one| one.abs() > ROUNDING);
        // Where the last one has more neutral eigenvalues than the next, it is special itself.
        let spectra = [last, next].map(BranchEquilibrium::spectrum);
        let earlier = path.before_neutral(length, spectra.each_ref());
        let (begins, begin) = earlier.as_ref().map_or((0.0, last), |(s, one)| (*s, one));
        let [_, there] = spectra;
        let spectra = [begin.spectrum(), there];
        let is_neutral = |crossing| spectra.iter().all(|one| one.has_neutral(crossing));
        type Named<'f> = (
            (EquilibriumBifurcation, Crossing),
            &'f SolutionFunction<'f, BranchEquilibrium>,
            f64,
        );
        let mut functions: Vec<Named<'_>> = Vec::new();
        if !is_neutral(Crossing::Pair(0)) {
            functions.push(((hopf, Crossing::Pair(0)), &rate, ROUNDING * size));
        }
        if is_moved {
            let [fold, point] = [
                EquilibriumBifurcation::Fold,
                EquilibriumBifurcation::BranchPoint,
            ]
            .map(|what| (what, Crossing::Positive));
            functions.push((fold, &heading, ROUNDING));
            functions.push((point, &branch, 0.0));
        }
        let mut located = Vec::new();
        let mut zeros = Vec::new();
        for ((what, crossing), function, noise) in functions {
            let (Some(a), Some(b)) = (function(begin), function(next)) else {
                continue;
            };
            if a * b >= 0.0 || a.abs().max(b.abs()) <= noise {
                continue;
            }
            if let Some(zero) = path.zero([(begins, a), (length, b)], function) {
                let crossing = match crossing {
                    Crossing::Pair(_) => Crossing::Pair(if a < b { 2 } else { -2 }),
                    real => real,
                };
                let what = match what {
                    EquilibriumBifurcation::Hopf { .. } => EquilibriumBifurcation::Hopf {
                        frequency: zero.solution.pair().map_or(f64::NAN, |pair| pair.im),
                    },
                    other => other,
                };
                located.push((zero.s, crossing));
                zeros.push((zero, what));
            }
        }
        let [a, b] = spectra;
        let ends = [&(begins, begin, a), &(length, next, b)];
        let [before, after] = ends.map(|end| end.2.unstable());
        let turns = [begin, next].map(heading);
        let turns = matches!(turns, [Some(a), Some(b)] if a * b < 0.0);
        for one in path.hidden(ends, &located, MOST_HALVINGS) {
            let what = match one.crossing {
                _ if !one.is_resolved => EquilibriumBifurcation::Unresolved { before, after },
                Crossing::Pair(_) => EquilibriumBifurcation::Hopf {
                    frequency: one.value.im.abs(),
                },
                _ if turns => EquilibriumBifurcation::Fold,
                _ => EquilibriumBifurcation::BranchPoint,
            };
            zeros.push((one.at, what));
        }
        let flow = self.system.flow(line.mode, &last.at);
        let guards = flow.guards().into_iter().filter(|guard| guard.is_condition);
        for guard in guards {
            let value = |one: &BranchEquilibrium| Some(flow.guard(guard.number, &one.at));
            let (a, b) = (value(last)?, value(next)?);
            if b > 0.0 {
                continue;
            }
            // A guard that is zero at the beginning of the line belongs to the boundary there.
            let ends = (a > 0.0).then_some([(0.0, a), (length, b)])?;
            let zero = path
                .zero(ends, &value)
                .or_else(|| path.edge(ends, &value))?;
            zeros.push((zero, boundary(guard.contact)));
        }
        zeros.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
        let is_end =
            |what: &EquilibriumBifurcation| matches!(what, EquilibriumBifurcation::Boundary { .. });
        if let Some(end) = zeros.iter().position(|(_, what)| is_end(what)) {
            zeros.truncate(end + 1);
        }
        Some(zeros)
    }

    /// The equilibrium of another mode of a contact that continues one on its boundary, and the
    /// line on which it leaves the boundary.
    fn behind(
        &self,
        at: &BranchEquilibrium,
        contact: usize,
    ) -> Option<(BranchEquilibrium, EquilibriumTangent)> {
        let last = at.at.x.len() - 1;
        let by_parameter = unit(last + 1, last);
        // Where a stop opens or closes, a jump leads to another discrete state.
        if contact >= at.mode.len() {
            return None;
        }
        others(at.mode, contact).find_map(|mode| {
            let one = self.solve(mode, &at.at.x, &[&by_parameter])?;
            let off = (&one.at.x - &at.at.x).component_div(&self.units).amax();
            if off > ZERO {
                return None;
            }
            let line = self.tangent(&one, &by_parameter)?;
            let is_held = |line: &EquilibriumTangent| {
                let beyond = self.on(line).on(STEP_BEYOND * self.settings.step);
                beyond.is_some_and(|beyond| holds(self.system, beyond.mode, &beyond.at))
            };
            let back = self.tangent(&one, &-&line.row);
            let line = std::iter::once(line).chain(back).find(is_held)?;
            Some((one, line))
        })
    }

    /// The equilibrium after a step on a line, or at the end of the range if that comes first; and
    /// whether it does.
    fn next(&self, line: &EquilibriumTangent, step: f64) -> Option<(BranchEquilibrium, bool)> {
        let path = self.on(line);
        let (low, high) = self.settings.range;
        let next = path.on(step)?;
        let end = next.parameter().clamp(low, high);
        if end == next.parameter() {
            return Some((next, false));
        }
        let place = line.from.len() - 1;
        let here = line.from[place];
        let part = (end - here) / (next.parameter() - here);
        let mut guess = &line.from + (&next.at.x - &line.from) * part;
        guess[place] = end;
        let mut next = self.solve(line.mode, &guess, &[&unit(place + 1, place)])?;
        next.at.x[place] = end;
        Some((next, true))
    }

    /// The place of the first equilibrium of the branch on a line, if the branch passes it there in
    /// the direction in which it began.
    fn closes(
        &self,
        (first, row): &(BranchEquilibrium, Vector),
        line: &EquilibriumTangent,
        length: f64,
    ) -> Option<f64> {
        let s = line.row.dot(&(&first.at.x - &line.from));
        let is_passed = first.mode == line.mode && (0.0..=length).contains(&s);
        let found = is_passed.then(|| self.on(line).on(s))??;
        (self.are_same(&found.at.x, &first.at.x) && row.dot(&line.direction) > 0.0).then_some(s)
    }
}

/// The steps along a branch.
struct EquilibriumSteps<'a> {
    of: EquilibriumContinuation<'a>,
    points: Vec<EquilibriumPoint>,
    special: Vec<SpecialEquilibrium>,
    /// The first equilibrium, and the row of the plane across the branch there.
    begin: (BranchEquilibrium, Vector),
    last: BranchEquilibrium,
    line: EquilibriumTangent,
    step: f64,
}

impl Stepping for EquilibriumSteps<'_> {
    type End = Stop;

    // A shorter step is within the rounding of an equilibrium.
    const SHORTEST: f64 = ROUNDING;

    fn step(&mut self) -> (&mut f64, f64) {
        (&mut self.step, self.of.settings.step)
    }

    fn completed(&mut self) -> Option<Stop> {
        let (low, high) = self.of.settings.range;
        let (here, heading) = (self.last.parameter(), self.line.heading());
        if heading > 0.0 && here >= high || heading < 0.0 && here <= low {
            return Some(Stop::Range);
        }
        let is_enough = self.points.len() >= self.of.settings.most_points;
        is_enough.then_some(Stop::Points)
    }

    fn take_step(&mut self, step: f64) -> StepOutcome<Stop> {
        let shorter = StepOutcome::Shortened(SHORTER * step);
        let line = &self.line;
        let Some((next, is_at_end)) = self.of.next(line, step) else {
            return shorter;
        };
        let onward = self.of.tangent(&next, &line.row);
        let onward = onward.filter(|onward| line.row.dot(&onward.direction) >= LEAST_COSINE);
        let Some(onward) = onward else {
            return shorter;
        };
        let length = line.row.dot(&(&next.at.x - &line.from));
        let Some(mut zeros) = self.of.between(line, (&self.last, &next), length) else {
            return shorter;
        };
        let closes = (self.points.len() > 3)
            .then(|| self.of.closes(&self.begin, line, length))
            .flatten();
        zeros.retain(|(zero, _)| closes.is_none_or(|s| zero.s < s));
        match self.record(zeros, length) {
            Some(Err(stop)) => return StepOutcome::End(stop),
            Some(Ok(behind)) => {
                (self.last, self.line) = behind;
                return StepOutcome::Elsewhere;
            }
            None => {}
        }
        let point = if closes.is_some() {
            self.begin.0.point()
        } else {
            next.point()
        };
        self.points.push(point);
        if closes.is_some() {
            return StepOutcome::End(Stop::Closed);
        }
        if is_at_end {
            return StepOutcome::End(Stop::Range);
        }
        let units = self.of.units.iter_mut().zip(&next.at.x);
        for (size, own) in units.take(self.begin.1.len() - 1) {
            *size = size.max(own.abs());
        }
        let iterations = next.iterations;
        (self.last, self.line) = (next, onward);
        StepOutcome::Found {
            length: step,
            iterations,
        }
    }

    fn name_end(&mut self) -> Stop {
        Stop::NoConvergence
    }
}

impl EquilibriumSteps<'_> {
    /// Records special equilibria on the line over a length. At a boundary, returns the equilibrium
    /// with which the branch goes on and its tangent, or the end of the branch.
    fn record(
        &mut self,
        zeros: Vec<(LocatedZero<BranchEquilibrium>, EquilibriumBifurcation)>,
        length: f64,
    ) -> Option<Result<(BranchEquilibrium, EquilibriumTangent), Stop>> {
        let (low, high) = self.of.settings.range;
        let mut behind = None;
        for (zero, mut what) in zeros {
            if let EquilibriumBifurcation::Boundary {
                contact,
                after,
                turns,
                ..
            } = &mut what
            {
                let begin = self.of.behind(&zero.solution, *contact);
                if let Some((begin, onward)) = &begin {
                    *after = Some(begin.mode);
                    *turns = self.line.heading() * onward.heading() < 0.0;
                }
                let parameter = zero.parameter;
                behind = Some(begin.ok_or(Stop::BoundaryEquilibrium { parameter }));
            }
            self.special.push(SpecialEquilibrium {
                parameter: zero.parameter,
                uncertainty: with_last_digits(
                    (zero.parameter, zero.uncertainty),
                    length,
                    (high - low, 1),
                ),
                what,
                behind: self.points.len(),
                x: zero.solution.at.x,
                mode: self.line.mode,
            });
        }
        behind
    }
}
