//! Continuation of a branch, step by step.

use std::ops::ControlFlow;

use super::stepping::{FIRST_STEP, SHORTER, SHORTEST_STEP, StepOutcome, Stepping, follow};
use super::tangent_line::{TangentLine, Units};
use super::{
    Branch, BranchPoint, ContinuationSettings, CycleBifurcation, PartialBranch, SpecialPoint, Stop,
    check_rate, check_start, critical, parameter_of,
};
use crate::analysis::cycle::{Cycle, LocatedZero, Margin, OrbitGuess, Shooting, StepBudget};
use crate::analysis::normal_form::{CriticalPair, NormalForm, ReturnMap};
use crate::analysis::periodic::why_not_found;
use crate::dynamics::{Dynamics, Modes, Moment, Vector, run};
use crate::error::Error;
use crate::filippov::Options;

/// Precision to which an end of a branch is located, as a fraction of the parameter's range or of a
/// step. Chosen: at the usual tolerances, orbits are no more accurate.
pub(super) const RESOLUTION: f64 = 1e-11;

/// Longest step, as a fraction of the orbit's own extent, where the branch may end as that
/// vanishes. Chosen: an orbit that shrinks is then followed through ten orbits or more for each
/// factor e.
const LONGEST_OF_EXTENT: f64 = 0.1;

/// An orbit at a fold, and the direction in which its branch passes that. Along it, the parameter
/// is determined; in a family, it is undetermined which orbit is meant. `row` is the parameter's.
fn at_fold(shooting: &Shooting<'_>, first: &Cycle, row: &Vector) -> Option<(Cycle, Vector)> {
    if first.family == 0 {
        return None;
    }
    let least = first.jacobian.with_row(row).least_determined()?;
    let (_, along) = least.into_iter().next()?;
    let value = along.dot(&first.outline.unknowns());
    let on_branch = shooting.solve(&first.outline, Some((&along, value)))?;
    (on_branch.family == 0).then_some((on_branch, along))
}

/// The continuation of a branch.
pub(in crate::analysis) struct Continuation<'a> {
    pub(super) shooting: Shooting<'a>,
    pub(super) settings: &'a ContinuationSettings,
    pub(super) branch: PartialBranch,
    /// The kind of special orbit at which to stop, and the number of such orbits to pass before.
    pub(in crate::analysis) wanted: Option<(IsWanted, usize)>,
    /// Orbit of the junction.
    pub(super) junction: Option<Junction>,
    /// The flips, where branches that begin there are followed, too.
    pub(super) flips: Option<Vec<Junction>>,
    /// Whether the first orbit lies on another branch, too.
    pub(super) begins_on_other: bool,
}

/// Whether a special orbit is of the kind at which to stop.
type IsWanted = fn(&CycleBifurcation) -> bool;

/// A special orbit from which a curve or another branch is followed.
pub(super) struct Junction {
    pub at: SpecialPoint,
    pub cycle: Cycle,
    /// The line on which it was located.
    pub line: TangentLine,
    /// The margin that vanishes, at a change of the phases.
    pub margin: Option<Margin>,
}

impl<'a> Continuation<'a> {
    pub fn begin(
        system: &'a dyn Dynamics,
        (x, period, upwards): (Vector, f64, bool),
        settings: &'a ContinuationSettings,
        (plane, options): (Option<(&'a Vector, f64)>, &'a Options),
        budget: Option<&'a StepBudget>,
    ) -> Result<Self, Error> {
        let period = settings.forced.unwrap_or(period);
        let start = Moment { t: 0.0, x };
        // The other parameter, if there is one, is the one before the last.
        let parameters = 1 + usize::from(plane.is_some());
        check_start(&start.x, parameters, settings)?;
        let last = start.x.len() - 1;
        let states = start.x.len() - parameters;
        let (low, high) = settings.range;
        let value = start.x[last];
        let outline = OrbitGuess::of_run(system, &start, period, options)?;
        for segment in &outline.segments {
            let flow = system.flow(segment.mode, &segment.inside);
            let rates = flow.velocity(&segment.inside);
            let rates = rates.rows(states, parameters);
            rates.iter().try_for_each(|rate| check_rate(*rate))?;
        }
        let shooting = Shooting {
            states,
            plane,
            budget,
            ..Shooting::of(system, &outline, settings.forced, options)
        };
        let row = outline.unit(last);
        let first = shooting.nearest(&outline, Some((&row, value)));
        let not_found = || {
            let what = "a periodic orbit near the start of the branch";
            let (t, span) = (start.t, period);
            let not_found = Error::NotFound { what, t, span };
            why_not_found(system, (&start, period), options, not_found)
        };
        let first = first.ok_or_else(not_found)?;
        let fold = at_fold(&shooting, &first, &row);
        let (first, row) = fold.unwrap_or((first, row));
        let shooting = Shooting {
            family: first.family,
            extent: first.extent,
            ..shooting
        };
        let units = Units::at(&shooting, &first, high - low);
        let sign = if upwards { 1.0 } else { -1.0 };
        let line = TangentLine::tangent(&shooting, &units, &first, &(row * sign));
        Ok(Continuation::from_orbit(
            shooting,
            settings,
            units,
            (first, line),
        ))
    }

    /// Resumes a branch.
    pub fn resume(
        system: &'a dyn Dynamics,
        branch: PartialBranch,
        settings: &'a ContinuationSettings,
        options: &'a Options,
    ) -> Self {
        let outline = &branch.last.outline;
        let forced = settings.forced.map(|_| branch.last.period);
        let shooting = Shooting {
            states: outline.begin.x.len() - 1,
            family: branch.first.family,
            extent: branch.widest,
            ..Shooting::of(system, outline, forced, options)
        };
        Continuation::with(shooting, settings, branch)
    }

    fn with(
        shooting: Shooting<'a>,
        settings: &'a ContinuationSettings,
        branch: PartialBranch,
    ) -> Self {
        Continuation {
            shooting,
            settings,
            branch,
            wanted: None,
            junction: None,
            flips: None,
            begins_on_other: false,
        }
    }

    /// Begins at an orbit, along a line.
    pub(super) fn from_orbit(
        shooting: Shooting<'a>,
        settings: &'a ContinuationSettings,
        units: Units,
        (first, line): (Cycle, Option<TangentLine>),
    ) -> Self {
        let branch = PartialBranch {
            units,
            widest: first.extent,
            heading: line.as_ref().map_or(0.0, TangentLine::heading),
            before: first.clone(),
            first: first.clone(),
            last: first,
            line,
            step: FIRST_STEP * settings.step,
            points: Vec::new(),
            extents: Vec::new(),
            special: Vec::new(),
        };
        let mut continuation = Continuation::with(shooting, settings, branch);
        continuation.record();
        continuation
    }

    pub fn into_branch(self, stop: Stop) -> Branch {
        Branch {
            family: self.branch.first.family,
            points: self.branch.points,
            special: self.branch.special,
            stop,
        }
    }

    /// Follows the branch to its end.
    pub fn go_on(&mut self, observe: &mut dyn FnMut(&PartialBranch) -> ControlFlow<()>) -> Stop {
        if self.branch.points.len() == 1 && self.leaves_range() {
            return Stop::Range;
        }
        let continuation = self;
        follow(&mut BranchSteps {
            continuation,
            observe,
        })
    }

    /// Follows the branch to one of the special orbits of a kind, by its number counted from 0.
    pub(super) fn seek(&mut self, is_wanted: IsWanted, number: usize) -> Option<Junction> {
        self.wanted = Some((is_wanted, number));
        self.go_on(&mut |_| ControlFlow::Continue(()));
        self.junction.take()
    }

    /// Whether the line leads out of the range.
    fn leaves_range(&self) -> bool {
        let heading = self.branch.line.as_ref().map_or(0.0, TangentLine::heading);
        let (low, high) = self.settings.range;
        let here = self.parameter();
        heading > 0.0 && here >= high || heading < 0.0 && here <= low
    }

    /// Index of the parameter among the components.
    pub(super) fn place(&self) -> usize {
        self.branch.last.outline.begin.x.len() - 1
    }

    pub(super) fn parameter(&self) -> f64 {
        parameter_of(&self.branch.last)
    }

    /// Takes a step, or passes a change of the phases.
    fn advance(&mut self) -> StepOutcome<Stop> {
        if self.branch.last.is_badly_cut() {
            self.cut_anew();
        }
        let Some(line) = self.branch.line.clone() else {
            return StepOutcome::Lost;
        };
        let mut step = self.branch.step;
        // Only friction ends the motion of a driven system. Without it the branch goes on at rest.
        let last = &self.branch.last;
        if self.shooting.forced.is_none() || last.outline.modes().iter().any(Modes::any_sticks) {
            step = step.min(LONGEST_OF_EXTENT * last.extent / self.branch.units.size);
        }
        if let Some(&(_, place)) = line.vanishing(step).first() {
            let change = self.vanishing_segments(&line, place);
            if let Some(change) = change.filter(|change| self.is_in_range(&change.at.solution)) {
                return self.pass_change(change);
            }
            step = 0.5 * place;
            if step < SHORTEST_STEP {
                let vanished = self.vanished_segment(&line, place);
                return match vanished.or_else(|| self.vanishing_at_jump(place)) {
                    Some(change) => self.pass_change(change),
                    None => StepOutcome::Lost,
                };
            }
        }
        let (low, high) = self.settings.range;
        let next = line.on(&self.shooting, step);
        let Some(mut next) = next.filter(Cycle::is_differentiable) else {
            return StepOutcome::Shortened(SHORTER * step);
        };
        let is_outside = !self.is_in_range(&next);
        if is_outside {
            let there = parameter_of(&next);
            let end = there.clamp(low, high);
            let part = (end - self.parameter()) / (there - self.parameter());
            let guess = line.guess(part * step);
            let row = guess.unit(self.place());
            let at_end = self.shooting.solve(&guess, Some((&row, end)));
            let Some(at_end) = at_end.filter(Cycle::is_differentiable) else {
                return StepOutcome::Shortened(SHORTER * step);
            };
            next = at_end;
        }
        let onward = line.continued(&self.shooting, &self.branch.units, &next);
        let bends = |onward: &TangentLine| !line.bends_little(onward);
        let strays = line.strays(&self.shooting, &self.branch.units, &next);
        if strays || onward.as_ref().is_some_and(bends) {
            return StepOutcome::Shortened(0.5 * step);
        }
        // Beside a flip, Newton's method may lead to the half's branch.
        if [&next, &self.branch.last].map(Cycle::is_half_twice) == [Some(true), Some(false)] {
            return StepOutcome::Shortened(0.5 * step);
        }
        match self.change_before(&line, &next) {
            Err(()) => return StepOutcome::Shortened(0.5 * step),
            Ok(Some(change)) => return self.pass_change(change),
            Ok(None) => {}
        }
        if let Some(why) = self.refused(&next.anchor) {
            return StepOutcome::End(self.go_to_edge(&line, line.place(&next), why));
        }
        if self.is_homoclinic(&next) {
            return StepOutcome::Lost;
        }
        let found = StepOutcome::Found {
            length: step,
            iterations: next.iterations,
        };
        let end = self.follow(&line, next, onward);
        if self.junction.is_some() {
            return StepOutcome::End(Stop::Points);
        }
        let end = end.or(is_outside.then_some(Stop::Range));
        end.map_or(found, StepOutcome::End)
    }

    /// Whether the period grows while the parameter changes by no more than the tolerance.
    fn is_homoclinic(&self, next: &Cycle) -> bool {
        let least = self.shooting.options.rtol.max(16.0 * f64::EPSILON);
        let grows = self.shooting.forced.is_none() && next.period > self.branch.last.period;
        let size = self.parameter().abs().max(self.branch.units.width);
        grows && (parameter_of(next) - self.parameter()).abs() <= least * size
    }

    /// Cuts the last orbit in another segment.
    fn cut_anew(&mut self) {
        let outline = self.branch.last.without_cut();
        let row = outline.unit(self.place());
        if let (Some(line), Some(anew)) = (
            &self.branch.line,
            self.shooting
                .solve(&outline, Some((&row, self.parameter()))),
        ) {
            self.branch.line = line.continued(&self.shooting, &self.branch.units, &anew);
            self.branch.last = anew;
        }
    }

    /// Whether an orbit lies in the parameter's range.
    pub(super) fn is_in_range(&self, cycle: &Cycle) -> bool {
        let (low, high) = self.settings.range;
        (low..=high).contains(&parameter_of(cycle))
    }

    /// Reason for which the system cannot be integrated over a period from a moment of the last
    /// orbit, if so.
    pub(super) fn refused(&self, start: &Moment) -> Option<Stop> {
        let (system, options) = (self.shooting.system, self.shooting.options);
        // The run takes about as many steps as the orbit did.
        if let Some(budget) = self.shooting.budget {
            budget.spend(self.branch.last.steps as u64);
        }
        let error = run(system, start, start.t + self.branch.last.period, options).err()?;
        let is_of_friction = |error: &Error| match error {
            Error::Contacts { fault, .. } => fault.is_of_friction(),
            _ => false,
        };
        is_of_friction(&error).then_some(Stop::Refused(error))
    }

    /// Bisects for the last orbit on the line, before a place, over which the system can be
    /// integrated, and ends the branch there.
    fn go_to_edge(&mut self, line: &TangentLine, step: f64, mut why: Stop) -> Stop {
        let (mut good, mut bad) = ((0.0, None), step);
        while bad - good.0 > RESOLUTION {
            let middle = 0.5 * (good.0 + bad);
            match line.on(&self.shooting, middle) {
                Some(one) => match self.refused(&one.anchor) {
                    Some(stop) => (bad, why) = (middle, stop),
                    None => good = (middle, Some(one)),
                },
                None => bad = middle,
            }
        }
        if let (_, Some(last)) = good {
            let onward = line.continued(&self.shooting, &self.branch.units, &last);
            return self.follow(line, last, onward).unwrap_or(why);
        }
        why
    }

    /// Continues from this orbit.
    pub(super) fn take(&mut self, next: Cycle) {
        self.branch.widest = self.branch.widest.max(next.extent);
        self.shooting.extent = self.branch.widest;
        self.branch.units.include(&self.branch.first, &next);
        self.branch.before = std::mem::replace(&mut self.branch.last, next);
        self.record();
    }

    /// Records a special orbit. The continuation stops there if that was asked for.
    pub(super) fn record_special(
        &mut self,
        what: CycleBifurcation,
        zero: LocatedZero,
        line: TangentLine,
        margin: Option<Margin>,
    ) {
        let cycle = zero.solution;
        let normal_form = self.normal_form(&what, &cycle, zero.parameter);
        let at = SpecialPoint {
            parameter: zero.parameter,
            uncertainty: self.with_last_digits(zero.parameter, zero.uncertainty),
            what,
            behind: self.branch.points.len(),
            x: cycle.anchor.x.clone(),
            period: cycle.period,
            normal_form,
        };
        self.branch.special.push(at.clone());
        let junction = Junction {
            at,
            cycle,
            line,
            margin,
        };
        let what = &junction.at.what;
        match (&mut self.wanted, &mut self.flips) {
            (Some((is_wanted, number)), _) if is_wanted(what) => match number.checked_sub(1) {
                Some(less) => *number = less,
                None => {
                    self.wanted = None;
                    self.junction = Some(junction);
                }
            },
            (_, Some(flips)) if *what == CycleBifurcation::Flip => flips.push(junction),
            _ => {}
        }
    }

    /// The normal form of a flip or Neimark–Sacker bifurcation. It is not computed within a budget
    /// of steps, which is for places alone.
    fn normal_form(
        &self,
        what: &CycleBifurcation,
        near: &Cycle,
        parameter: f64,
    ) -> Option<NormalForm> {
        let of = match what {
            CycleBifurcation::Flip => CriticalPair::Flip,
            CycleBifurcation::NeimarkSacker { angle } => CriticalPair::Angle(*angle),
            _ => return None,
        };
        if self.shooting.budget.is_some_and(StepBudget::is_spent) {
            return None;
        }
        // The nearest orbit that was computed may lie beside the zero.
        let row = near.outline.unit(self.place());
        let at_zero = self.shooting.solve(&near.outline, Some((&row, parameter)));
        let map = ReturnMap::of(at_zero.as_ref().unwrap_or(near), &self.shooting)?;
        map.normal_form(of, &ReturnMap::MULTIPLES)
    }

    /// Records the last orbit.
    fn record(&mut self) {
        let Moment { t, x } = self.branch.last.anchor.clone();
        self.branch.extents.push(self.branch.last.extent);
        self.branch.points.push(BranchPoint {
            parameter: parameter_of(&self.branch.last),
            t,
            x,
            period: self.branch.last.period,
            multipliers: critical(&self.branch.last, &self.shooting)
                .map_or_else(Vec::new, |of| of.multipliers),
            sequence: self.branch.last.outline.modes(),
        });
    }
}

/// The steps along a branch, each of which is observed.
struct BranchSteps<'c, 'a, 'o> {
    continuation: &'c mut Continuation<'a>,
    observe: &'o mut dyn FnMut(&PartialBranch) -> ControlFlow<()>,
}

impl Stepping for BranchSteps<'_, '_, '_> {
    type End = Stop;

    fn step(&mut self) -> (&mut f64, f64) {
        let longest = self.continuation.settings.step;
        (&mut self.continuation.branch.step, longest)
    }

    fn completed(&mut self) -> Option<Stop> {
        let of = &self.continuation;
        let is_spent = of.shooting.budget.is_some_and(StepBudget::is_spent);
        let is_enough = is_spent || (self.observe)(&of.branch).is_break();
        if is_enough || of.branch.points.len() >= of.settings.most_points {
            return Some(Stop::Points);
        }
        of.shrinks()
    }

    fn take_step(&mut self, _: f64) -> StepOutcome<Stop> {
        let outcome = self.continuation.advance();
        if let StepOutcome::Shortened(length) = outcome
            && length < SHORTEST_STEP
        {
            let (of, step) = (&self.continuation, length / SHORTER);
            let change = of.vanishing_at_jump(step).or_else(|| of.late_landing(step));
            if let Some(change) = change {
                return self.continuation.pass_change(change);
            }
        }
        if !matches!(outcome, StepOutcome::Found { .. } | StepOutcome::Elsewhere) {
            return outcome;
        }
        match self.continuation.closes() {
            Some(Stop::NoConvergence) => StepOutcome::Lost,
            Some(stop) => StepOutcome::End(stop),
            None => outcome,
        }
    }

    fn name_end(&mut self) -> Stop {
        let of = &self.continuation;
        let is_short = of.branch.step < SHORTEST_STEP;
        let boundary = is_short.then(|| of.boundary_equilibrium()).flatten();
        let end = boundary.or_else(|| of.homoclinic_end());
        end.unwrap_or(Stop::NoConvergence)
    }
}
