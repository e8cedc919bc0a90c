//! A recorded orbit: events, phases, passages, and its course as far as it is asked for.

use super::{
    Dynamics, Kink, Modes, Moment, OrbitProgress, OrbitUnderWay, Passage, Phase, Section, Solution,
    Step, Summary, Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::orbit::sticks_in;
use crate::system::Mode;

/// Times at which a recorded orbit keeps its state.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Sampling {
    /// None, besides those of events.
    Nowhere,
    /// The start, the ends of steps, and the moments behind jumps, where a time stands twice.
    #[default]
    Steps,
    /// Given times in ascending order. At a jump it is the state before it, and at a jump on the
    /// very end of the run that after it.
    Times(Vec<f64>),
}

/// Rows of a time and the state at that time, in order of time.
#[derive(Clone, Debug, PartialEq)]
struct Points {
    states: usize,
    flat: Vec<f64>,
}

impl Points {
    fn new(states: usize) -> Self {
        let flat = Vec::new();
        Points { states, flat }
    }

    fn push(&mut self, t: f64, x: &Vector) {
        self.flat.push(t);
        self.flat.extend(x);
    }

    fn len(&self) -> usize {
        self.flat.len() / (1 + self.states)
    }

    fn from(&self, first: usize) -> impl DoubleEndedIterator<Item = (f64, &[f64])> + Clone {
        let width = 1 + self.states;
        let rows = self.flat[self.flat.len().min(first * width)..].chunks_exact(width);
        rows.map(|row| (row[0], &row[1..]))
    }

    fn truncate(&mut self, count: usize) {
        self.flat.truncate(count * (1 + self.states));
    }
}

/// An event of a recorded orbit that is not a passage of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum OrbitEvent {
    /// A mode changes, a boundary is touched, or the state jumps.
    Transition {
        /// The transition, with the state before it.
        at: Transition,
        /// State after it, which differs at a jump.
        after: Vector,
    },
    /// An input has a kink, or a switch changes its sign.
    Kink(Kink),
}

impl OrbitEvent {
    /// The transition, if it is one.
    pub fn transition(&self) -> Option<&Transition> {
        match self {
            OrbitEvent::Transition { at, .. } => Some(at),
            OrbitEvent::Kink(_) => None,
        }
    }

    /// Time.
    pub fn t(&self) -> f64 {
        match self {
            OrbitEvent::Transition { at, .. } => at.t,
            OrbitEvent::Kink(at) => at.t,
        }
    }

    /// State before it.
    pub fn before(&self) -> &Vector {
        match self {
            OrbitEvent::Transition { at, .. } => &at.x,
            OrbitEvent::Kink(at) => &at.x,
        }
    }

    /// State after it.
    pub fn after(&self) -> &Vector {
        match self {
            OrbitEvent::Transition { after, .. } => after,
            OrbitEvent::Kink(at) => &at.x,
        }
    }

    /// Modes before and after it.
    pub fn modes(&self) -> [Modes; 2] {
        match self {
            OrbitEvent::Transition { at, .. } => [at.from, at.to],
            OrbitEvent::Kink(at) => [at.mode; 2],
        }
    }

    fn is_jump(&self) -> bool {
        let at = self.transition();
        at.is_some_and(|at| at.kind == TransitionKind::Jump)
    }
}

/// An orbit of any dynamics with what happened along it.
///
/// [`RecordedOrbit::solve`] integrates one. A loop of one's own begins with [`RecordedOrbit::new`]
/// and gives what [`OrbitUnderWay::step`] reports to [`RecordedOrbit::take`].
pub struct RecordedOrbit {
    /// Start.
    pub start: Moment,
    /// End of what is recorded.
    pub end: Moment,
    /// Phases in order of time.
    pub phases: Vec<Phase>,
    /// Transitions and kinks in order of time.
    pub events: Vec<OrbitEvent>,
    /// Passages of sections in order of time.
    pub passages: Vec<Passage>,
    /// The steps with the solution over each, if they are kept.
    pub steps: Vec<(Step, Solution)>,
    sampling: Sampling,
    points: Points,
    /// Number of given times that are reached.
    reached: usize,
    keeps_steps: bool,
}

impl RecordedOrbit {
    /// The record of a run before its first step. It keeps states at the times of `sampling`, and
    /// the solution over every step for [`RecordedOrbit::at`] if `keeps_steps`.
    pub fn new(start: &Moment, sampling: Sampling, keeps_steps: bool) -> Self {
        let mut orbit = RecordedOrbit {
            start: start.clone(),
            end: start.clone(),
            phases: Vec::new(),
            events: Vec::new(),
            passages: Vec::new(),
            steps: Vec::new(),
            sampling,
            points: Points::new(start.x.len()),
            reached: 0,
            keeps_steps,
        };
        match &orbit.sampling {
            Sampling::Nowhere => {}
            Sampling::Steps => orbit.points.push(start.t, &start.x),
            Sampling::Times(times) => {
                orbit.reached = times.iter().take_while(|t| **t == start.t).count();
                (0..orbit.reached).for_each(|_| orbit.points.push(start.t, &start.x));
            }
        }
        orbit
    }

    /// Integrates and records an orbit with every step. Returns it up to its end or its failure,
    /// and how it ended.
    ///
    /// # Errors
    /// Those of [`crate::Integration::new`].
    ///
    /// # Examples
    /// ```
    /// use stickslip::dynamics::{AsDynamics, Moment, RecordedOrbit, Sampling};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// A block on a moving belt.
    /// struct Belt;
    ///
    /// impl Filippov<2> for Belt {
    ///     fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
    ///         x[1] - 0.2
    ///     }
    ///     fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 2]) -> [T; 2] {
    ///         [x[1], -x[0] - side.sign()]
    ///     }
    /// }
    ///
    /// let start = Moment { t: 0.0, x: vec![1.0, 0.0].into() };
    /// let sampling = Sampling::Times(vec![0.0, 2.5, 5.0]);
    /// let system = Belt.dynamics();
    /// let (orbit, ended) =
    ///     RecordedOrbit::solve(&*system, &start, 5.0, &Options::tol(1e-9), &[], sampling)?;
    /// assert_eq!(orbit.points().count(), 3);
    /// assert_eq!(ended?.t, 5.0);
    /// let (_, middle) = orbit.points().nth(1).unwrap();
    /// assert_eq!(orbit.at(2.5)?.as_slice(), middle);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    pub fn solve(
        dynamics: &dyn Dynamics,
        start: &Moment,
        t_end: f64,
        options: &Options,
        sections: &[Section],
        sampling: Sampling,
    ) -> Result<(Self, Result<Summary, Error>), Error> {
        let mut orbit = RecordedOrbit::new(start, sampling, true);
        let mut run = dynamics.begin(start, t_end, options, sections)?;
        loop {
            match run.step() {
                Ok(OrbitProgress::End(summary)) => {
                    orbit.finish(&summary);
                    return Ok((orbit, Ok(summary)));
                }
                Ok(progress) => orbit.take(progress, &mut *run),
                Err(error) => {
                    orbit.end = run.now();
                    return Ok((orbit, Err(error)));
                }
            }
        }
    }

    /// Records what an orbit reports.
    pub fn take(&mut self, progress: OrbitProgress, orbit: &mut dyn OrbitUnderWay) {
        match progress {
            OrbitProgress::Step => self.step(orbit.last_step(), orbit),
            OrbitProgress::Passage(at) => self.passages.push(at),
            OrbitProgress::Kink(at) => self.events.push(OrbitEvent::Kink(at)),
            OrbitProgress::PhaseEnd(phase) => self.phases.push(phase),
            OrbitProgress::Transition(at) => {
                let after = Vector::from_column_slice(orbit.x());
                self.events.push(OrbitEvent::Transition { at, after });
            }
            OrbitProgress::End(summary) => self.finish(&summary),
        }
    }

    /// Records the last step of an orbit.
    pub fn step(&mut self, step: Step, orbit: &mut dyn OrbitUnderWay) {
        match &self.sampling {
            Sampling::Nowhere => {}
            Sampling::Steps => {
                let events = self.events.iter().rev();
                let mut at_start = events.take_while(|at| at.t() == step.t_start);
                if at_start.any(OrbitEvent::is_jump) {
                    self.points.push(step.t_start, &step.x_start);
                }
                self.points.push(step.t_end, &step.x_end);
            }
            Sampling::Times(times) => {
                let mut solution = None;
                let next = times[self.reached..].iter();
                for &t in next.take_while(|t| **t <= step.t_end) {
                    match t == step.t_end {
                        true => self.points.push(t, &step.x_end),
                        false => {
                            let solution = solution.get_or_insert_with(|| orbit.solution());
                            self.points.push(t, &solution(t));
                        }
                    }
                    self.reached += 1;
                }
            }
        }
        self.end.t = step.t_end;
        self.end.x.clone_from(&step.x_end);
        if self.keeps_steps {
            self.steps.push((step, orbit.solution()));
        }
    }

    /// Completes the record of a run that has ended. A jump at the very end leads to another state.
    pub fn finish(&mut self, ended: &Summary) {
        if self.end.t != ended.t || self.end.x == ended.x {
            return;
        }
        self.end.x.clone_from(&ended.x);
        let is_sampled = match &self.sampling {
            Sampling::Nowhere => false,
            Sampling::Steps => true,
            Sampling::Times(times) => {
                let is_last = times[..self.reached].last() == Some(&ended.t);
                if is_last {
                    self.points.truncate(self.points.len() - 1);
                }
                is_last
            }
        };
        if is_sampled {
            self.points.push(ended.t, &ended.x);
        }
    }

    /// Ends the record at an earlier moment of the orbit.
    pub fn cut(&mut self, at: &Moment) {
        self.events.retain(|event| event.t() <= at.t);
        self.passages.retain(|one| one.t <= at.t);
        let kept = self.points().take_while(|(t, _)| *t <= at.t).count();
        self.points.truncate(kept);
        let last = self.points().next_back();
        if self.sampling == Sampling::Steps && last.is_none_or(|(t, _)| t < at.t) {
            self.points.push(at.t, &at.x);
        }
        self.phases.retain(|phase| phase.t_start < at.t);
        if let Some(phase) = self.phases.last_mut()
            && phase.t_end > at.t
        {
            (phase.t_end, phase.x_end) = (at.t, at.x.clone());
        }
        self.end = at.clone();
    }

    /// Number of states at the times of [`Sampling`].
    pub fn point_count(&self) -> usize {
        self.points.len()
    }

    /// The states at the times of [`Sampling`], each with its time, in order of time.
    pub fn points(&self) -> impl DoubleEndedIterator<Item = (f64, &[f64])> + Clone {
        self.points_from(0)
    }

    /// [`RecordedOrbit::points`] from one on.
    pub fn points_from(
        &self,
        first: usize,
    ) -> impl DoubleEndedIterator<Item = (f64, &[f64])> + Clone {
        self.points.from(first)
    }

    /// The transitions in order of time.
    pub fn transitions(&self) -> impl DoubleEndedIterator<Item = &Transition> {
        self.events.iter().filter_map(OrbitEvent::transition)
    }

    /// Intervals of time in which a contact sticks, whatever the others do meanwhile.
    pub fn sticks_of(&self, contact: usize) -> Vec<(f64, f64)> {
        sticks_in(self.phases.iter().map(|phase| {
            let sticks = phase.mode.get(contact) == Mode::Stick;
            (sticks, phase.t_start, phase.t_end)
        }))
    }

    /// The state at a time, if the steps are kept; see [`crate::Orbit::at`].
    ///
    /// # Errors
    /// [`Error::OutsideOrbit`] where the record does not cover the time.
    pub fn at(&self, t: f64) -> Result<Vector, Error> {
        let from = self.steps.first();
        let from = from.map_or(self.end.t, |(step, _)| step.t_start);
        let to = self.end.t;
        if !(from..=to).contains(&t) {
            return Err(Error::OutsideOrbit { t, from, to });
        }
        let index = self.steps.partition_point(|(step, _)| step.t_end < t);
        Ok(match self.steps.get(index) {
            Some((step, _)) if t == step.t_end => step.x_end.clone(),
            Some((_, solution)) => solution(t),
            None => self.end.x.clone(),
        })
    }
}
