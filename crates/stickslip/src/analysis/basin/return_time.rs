//! The time in which an orbit returns to its attractor.

use std::collections::VecDeque;

use numerics::bisect;

use crate::analysis::attractors::{
    Attractor, AttractorKind, RecurrenceSettings, SOLVER_TOLERANCES,
};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Moment, OrbitProgress, Section, Solution, Step, Vector,
};
use crate::error::{Error, require};
use crate::filippov::Options;

/// Parts of a step at whose ends the distance to the attractor is taken. Chosen: steps are as long
/// as the solution is smooth.
const PARTS: usize = 8;

/// Part of the tolerance to which an orbit must approach an equilibrium before it counts as staying
/// within: near one, distances may grow so many times before they decay. Chosen.
const STAYS_WITHIN: f64 = 1e-3;

/// Part of the tolerance by which chords may miss the curve of a periodic orbit. Parabolas over
/// them miss it by far less. Chosen.
const CHORD_ERROR: f64 = 0.05;

/// Largest number of chords of a periodic orbit, which bounds time and memory.
const MOST_CHORDS: usize = 200_000;

impl Attractor {
    /// The time after which an orbit stays within a distance of the attractor that it reaches.
    /// `None` where there is no such time within [`RecurrenceSettings::longest`]. Nor is there for
    /// a motion that is neither an equilibrium nor periodic.
    ///
    /// `reached` is what [`crate::analysis::attractor`] finds from `x0` with the same settings. The
    /// distance is Euclidean, in the units of the states. It is that to the equilibrium, or to the
    /// curve of the periodic orbit, from which the orbit may be ahead or behind. It must stay small
    /// through a period of the cycle. At an equilibrium it must stay small until it is a thousandth
    /// of `tolerance`, or the error of the solver.
    ///
    /// In a system with a drive, states are compared with the attractor's at the same phase, at
    /// whole periods of the drive.
    ///
    /// Mean and largest return times over random starts are measures of stability beside the share
    /// of the basin (Menck, Heitzig, Marwan & Kurths, *Nature Physics* 9 (2013) 89; "convergence
    /// times" of Attractors.jl).
    ///
    /// ```
    #[doc = include_str!("../../../examples/common/belt.rs")]
    /// use stickslip::Options;
    /// use stickslip::analysis::{RecurrenceSettings, attractor};
    ///
    /// let belt = Belt { speed: 0.2 };
    /// let (settings, options) = (RecurrenceSettings::within(500.0), Options::default());
    /// let reached = attractor(&belt, [3.0, 0.1], &settings, &options)?;
    /// let time = reached.return_time(&belt, [3.0, 0.1], 1e-3, &settings, &options)?;
    /// println!("on {} to 0.001 after {time:?}", reached.kind);
    /// assert!(time.unwrap() > 0.0);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Option`] for a tolerance that is not positive, or so small that it takes more than
    /// 200 000 chords of the periodic orbit. Those of [`crate::Integration::new`].
    pub fn return_time<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        x0: impl Components,
        tolerance: f64,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Option<f64>, Error> {
        let is_allowed = tolerance > 0.0 && tolerance.is_finite();
        require(
            is_allowed,
            "return_within",
            tolerance,
            "positive and finite",
        )?;
        let settled = match &self.kind {
            AttractorKind::Periodic { .. } => Some(self.settled(system, settings, options)?),
            _ => None,
        };
        let reached = settled.as_ref().unwrap_or(self);
        let (system, start) = (&*system.dynamics(), x0.vector());
        let start = Moment { t: 0.0, x: start };
        match (&reached.kind, settings.forcing, reached.points.first()) {
            (AttractorKind::Periodic { returns, .. }, Some(period), Some(_)) => {
                let returns = *returns;
                let near = |at: &Moment| {
                    let number = (at.t / period).round() as usize;
                    let same_phase = reached.points.iter().find(|point| {
                        (point.t / period).round() as usize % returns == number % returns
                    });
                    same_phase.is_some_and(|point| (&at.x - &point.x).norm() <= tolerance)
                };
                at_strobes(system, &start, (period, returns), near, settings, options)
            }
            (AttractorKind::Periodic { period, .. }, None, Some(_)) => {
                let cycle = Chords::of(system, reached, *period, tolerance, options)?;
                let stays = |_: f64, since: f64| since >= *period;
                let distance = |x: &Vector| cycle.distance(x);
                in_time(
                    system,
                    &start,
                    (tolerance, settings),
                    distance,
                    stays,
                    options,
                )
            }
            (AttractorKind::Equilibrium | AttractorKind::EquilibriumSet, _, Some(point)) => {
                let error = SOLVER_TOLERANCES * (options.largest_allowed(&point.x));
                let enough = error.max(STAYS_WITHIN * tolerance);
                let stays = |distance: f64, _: f64| distance <= enough;
                let distance = |x: &Vector| (x - &point.x).norm();
                in_time(
                    system,
                    &start,
                    (tolerance, settings),
                    distance,
                    stays,
                    options,
                )
            }
            _ => Ok(None),
        }
    }

    /// The same periodic orbit, with state and section points after as much time again as the run
    /// took to come to it. What is left of its start has then fallen twice by the same factor, down
    /// to the error of the solver. Other motions are returned as they are.
    ///
    /// # Errors
    /// Those of [`crate::Integration::step`].
    pub fn settled<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Attractor, Error> {
        let mut settled = self.clone();
        let AttractorKind::Periodic { period, .. } = self.kind else {
            return Ok(settled);
        };
        let at = Moment {
            t: self.t,
            x: self.x.clone(),
        };
        let count = self.points.len();
        let (sections, step, t_end) = match settings.forcing {
            Some(forcing) => {
                let strobe = Section::Strobe {
                    first: 0.0,
                    period: forcing,
                };
                let periods = (self.t / forcing).ceil() + count as f64 + 0.5;
                (vec![strobe], 0.5 * forcing, self.t + periods * forcing)
            }
            None => (Vec::new(), f64::INFINITY, 2.0 * self.t + period),
        };
        // A step must not pass over two strobe times.
        let options = options.longest_step(options.longest_step.min(step));
        let dynamics = system.dynamics();
        let mut orbit = dynamics.begin(&at, t_end, &options, &sections)?;
        let mut points = VecDeque::new();
        let end = loop {
            match orbit.step()? {
                OrbitProgress::Passage(at) => {
                    points.push_back(at.moment());
                    if points.len() > count {
                        points.pop_front();
                    }
                }
                OrbitProgress::End(end) => break end,
                _ => {}
            }
        };
        if points.len() == count {
            settled.points = points.into();
        }
        (settled.t, settled.x) = (end.t, end.x);
        Ok(settled)
    }
}

/// The first strobe from which on the states are near through so many periods.
fn at_strobes(
    system: &dyn Dynamics,
    start: &Moment,
    (period, returns): (f64, usize),
    near: impl Fn(&Moment) -> bool,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Option<f64>, Error> {
    // A step must not pass over two strobe times.
    let options = options.longest_step(options.longest_step.min(0.5 * period));
    let strobe = Section::Strobe { first: 0.0, period };
    let mut orbit = system.begin(start, settings.longest, &options, &[strobe])?;
    let mut since = near(start).then_some(0.0);
    loop {
        match orbit.step() {
            Ok(OrbitProgress::Passage(at)) => {
                let at = at.moment();
                match since.filter(|_| near(&at)) {
                    Some(first) if at.t - first >= (returns as f64 - 0.5) * period => {
                        return Ok(since);
                    }
                    Some(_) => {}
                    None => since = near(&at).then_some(at.t),
                }
            }
            Ok(OrbitProgress::End(_)) => return Ok(None),
            Ok(_) => {}
            Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
            Err(_) => return Ok(None),
        }
    }
}

/// The time from which on the distance is at most the tolerance. `stays` has the present distance
/// and the time since then, and knows when that is certain.
fn in_time(
    system: &dyn Dynamics,
    start: &Moment,
    (tolerance, settings): (f64, &RecurrenceSettings),
    distance: impl Fn(&Vector) -> f64,
    stays: impl Fn(f64, f64) -> bool,
    options: &Options,
) -> Result<Option<f64>, Error> {
    let mut orbit = system.begin(start, settings.longest, options, &[])?;
    let mut since = (distance(&start.x) <= tolerance).then_some(start.t);
    loop {
        match orbit.step() {
            Ok(OrbitProgress::Step) => {
                let step = orbit.last_step();
                let solution = orbit.solution();
                let length = step.t_end - step.t_start;
                let mut before = step.t_start;
                for part in 0..=PARTS {
                    let t = step.t_start + length * part as f64 / PARTS as f64;
                    let is_near = |x: &Vector| distance(x) <= tolerance;
                    let x = state_in(&step, &solution, t);
                    let off = distance(&x);
                    since = match since {
                        _ if off > tolerance => None,
                        // A jump may lead there between two steps.
                        None if part == 0 => Some(t),
                        None => Some(bisect(before, t, |t| {
                            is_near(&state_in(&step, &solution, t))
                        })),
                        known => known,
                    };
                    if since.is_some_and(|first| stays(off, t - first)) {
                        return Ok(since);
                    }
                    before = t;
                }
            }
            // An orbit that ends before its time has come to an equilibrium.
            Ok(OrbitProgress::End(end)) => return Ok(since.filter(|_| end.t < settings.longest)),
            Ok(_) => {}
            Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
            // Impacts that accumulate at an equilibrium end a run with an error.
            Err(_) => return Ok(since),
        }
    }
}

/// The state at a time in a step. At the ends it is that of the run.
fn state_in(step: &Step, solution: &Solution, t: f64) -> Vector {
    if t <= step.t_start {
        step.x_start.clone()
    } else if t >= step.t_end {
        step.x_end.clone()
    } else {
        solution(t)
    }
}

/// A part of a curve between two points.
struct Chord {
    from: Vector,
    to: Vector,
    /// The curve's distance from the middle of the chord, as of a parabola.
    sagitta: Vector,
}

impl Chord {
    /// The part of a curve through a point between two others.
    fn through(from: Vector, middle: Option<&Vector>, to: Vector) -> Self {
        let sagitta = middle.map_or_else(
            || Vector::zeros(from.len()),
            |middle| {
                let part = part_along(middle, (&from, &to));
                let off = middle - &from - (&to - &from) * part;
                match 4.0 * part * (1.0 - part) {
                    // The middle in time is nearly that of the chord.
                    height if height > 0.5 => off / height,
                    _ => off * 0.0,
                }
            },
        );
        Chord { from, to, sagitta }
    }

    fn distance(&self, x: &Vector) -> f64 {
        let part = part_along(x, (&self.from, &self.to));
        let height = 4.0 * part * (1.0 - part);
        let ends = self.from.iter().zip(&self.to).zip(&self.sagitta);
        let off = ends.zip(x).map(|(((a, b), rise), x)| {
            let off = x - a - part * (b - a) - height * rise;
            off * off
        });
        off.sum::<f64>().sqrt()
    }
}

/// The curve of a periodic orbit, as chords.
struct Chords {
    /// None spans a jump.
    chords: Vec<Chord>,
}

impl Chords {
    fn of(
        system: &dyn Dynamics,
        reached: &Attractor,
        period: f64,
        tolerance: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        let at = Moment {
            t: reached.t,
            x: reached.x.clone(),
        };
        let mut orbit = system.begin(&at, at.t + period, options, &[])?;
        let mut cycle = Chords { chords: Vec::new() };
        let allowed = CHORD_ERROR * tolerance;
        loop {
            match orbit.step()? {
                OrbitProgress::Step => {
                    let (step, solution) = (orbit.last_step(), orbit.solution());
                    let at = |part: usize| {
                        let t =
                            step.t_start + (step.t_end - step.t_start) * part as f64 / PARTS as f64;
                        (t, state_in(&step, &solution, t))
                    };
                    for part in 0..PARTS {
                        cycle.add((at(part), at(part + 1)), &solution, allowed);
                    }
                    let bound = "so large that 200000 chords describe the periodic orbit";
                    let is_allowed = cycle.chords.len() <= MOST_CHORDS;
                    require(is_allowed, "return_within", tolerance, bound)?;
                }
                OrbitProgress::End(_) => return Ok(cycle),
                _ => {}
            }
        }
    }

    /// Adds a part of a step, in halves until its middle is near enough to the chord.
    fn add(
        &mut self,
        (from, to): ((f64, Vector), (f64, Vector)),
        solution: &Solution,
        allowed: f64,
    ) {
        let t = 0.5 * (from.0 + to.0);
        let is_between = from.0 < t && t < to.0;
        let middle = (is_between && self.chords.len() <= MOST_CHORDS).then(|| solution(t));
        if let Some(middle) = &middle
            && to_chord(middle, &(from.1.clone(), to.1.clone())) > allowed
        {
            self.add((from, (t, middle.clone())), solution, allowed);
            self.add(((t, middle.clone()), to), solution, allowed);
            return;
        }
        self.chords
            .push(Chord::through(from.1, middle.as_ref(), to.1));
    }

    fn distance(&self, x: &Vector) -> f64 {
        let each = self.chords.iter().map(|chord| chord.distance(x));
        each.fold(f64::INFINITY, f64::min)
    }
}

/// The part of a chord at which it is nearest to a point.
fn part_along(x: &Vector, (from, to): (&Vector, &Vector)) -> f64 {
    let (mut square, mut along) = (0.0, 0.0);
    for ((a, b), x) in from.iter().zip(to.iter()).zip(x.iter()) {
        square += (b - a) * (b - a);
        along += (b - a) * (x - a);
    }
    match square > 0.0 {
        true => (along / square).clamp(0.0, 1.0),
        false => 0.0,
    }
}

/// Distance from a point to a chord.
pub(super) fn to_chord(x: &Vector, (from, to): &(Vector, Vector)) -> f64 {
    let part = part_along(x, (from, to));
    let mut distance = 0.0;
    for ((a, b), x) in from.iter().zip(to.iter()).zip(x.iter()) {
        let off = x - a - part * (b - a);
        distance += off * off;
    }
    distance.sqrt()
}
