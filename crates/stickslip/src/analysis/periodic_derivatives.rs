//! Derivatives of a periodic orbit by parameters.

use super::derivatives::{Differentiated, EventDerivatives, OrbitDerivatives, Variable};
use super::monodromy::{flow_derivative, velocity_in};
use super::periodic::PeriodicOrbit;
use crate::dynamics::{
    AsDynamics, Dynamics, Matrix, Modes, Moment, OrbitProgress, Solution, Step, Vector,
};
use crate::error::Error;
use crate::filippov::Options;

/// Parts of a step within which a velocity that keeps its sign has no zero. It is chosen: two
/// extremes of a state within one part are not seen.
const PARTS_PER_STEP: u32 = 16;

/// Halvings of a part that holds an extreme: its time is then known to rounding.
const HALVINGS: u32 = 60;

/// Units in the last place within which two times of one run are the same instant.
const SAME_INSTANT: f64 = 8.0 * f64::EPSILON;

/// The smallest or largest value of a state along a periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtremeDerivatives {
    /// A time at which the state has it.
    pub t: f64,
    /// The value.
    pub value: f64,
    /// Derivative of the value by each parameter.
    pub by: Vec<f64>,
}

/// Derivatives of a periodic orbit, as [`PeriodicOrbit::derivatives`] computes them.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicDerivatives {
    /// Derivatives of the period.
    pub period: Vec<f64>,
    /// Derivatives of the state, with a row for each state and a column for each parameter: at the
    /// time of the orbit, which a drive holds fixed. An autonomous orbit is followed on the plane
    /// through its state perpendicular to the flow.
    pub x: Matrix,
    /// Smallest and largest value of each state.
    pub extremes: Vec<[ExtremeDerivatives; 2]>,
}

impl PeriodicOrbit {
    /// Derivatives of a periodic orbit by parameters, which are last states of `system`: of its
    /// period, of its state and of the smallest and largest value of each state.
    ///
    /// They follow from the equations of the shooting, `φ(T; x, p) = x` with the flow `φ`, by the
    /// implicit function theorem: `(M − I) dx + f dT = −∂φ/∂p dp`. The monodromy matrix `M` and
    /// `∂φ/∂p` are computed on dual numbers, through all events. An extreme moves with the orbit,
    /// since the velocity of the state is zero there, or as the event does at which the velocity
    /// changes its sign.
    ///
    /// `parameters` are their values. The period of a forced orbit changes with that of the drive,
    /// which the system tells: [`crate::Filippov::period`]. `options` are those by which the orbit
    /// was found.
    ///
    /// ```
    /// use stickslip::analysis::PeriodicOrbit;
    /// use stickslip::{Family, Options, Scalar, Side, math};
    ///
    /// /// A state that follows a drive of strength `a`: x′ = −x + a sin t.
    /// struct Follower;
    /// impl Family<1, 1> for Follower {
    ///     fn field<T: Scalar>(&self, _side: Side, t: T, x: &[T; 1], a: &[T; 1]) -> [T; 1] {
    ///         [a[0] * t.sin() - x[0]]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 1], _a: &[T; 1]) -> T {
    ///         T::constant(1.0)
    ///     }
    /// }
    ///
    /// let (period, options) = (2.0 * std::f64::consts::PI, Options::tol(1e-12));
    /// let follower = Follower.at([2.0]);
    /// let orbit = PeriodicOrbit::near_forced(&follower, 0.0, [0.0], period, &options)?;
    /// let along = follower.free([0])?;
    /// let found = orbit.derivatives(&along, &[2.0], true, &options)?;
    /// // The amplitude is a/√2.
    /// assert!((found.extremes[0][1].by[0] - 0.5_f64.sqrt()).abs() < 1e-9);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`crate::run`]. [`Error::TangentSingular`] where the orbit has no derivative, as at
    /// a graze. [`Error::NotFound`] for an orbit of a family, and for one without neighbours, as at
    /// a fold. The same error is returned where a discrete state depends on a parameter at the
    /// start of the period. [`Error::Parameter`] where the numbers of states do not fit.
    pub fn derivatives<Kind>(
        &self,
        system: &impl AsDynamics<Kind>,
        parameters: &[f64],
        is_forced: bool,
        options: &Options,
    ) -> Result<PeriodicDerivatives, Error> {
        let system = &*system.dynamics();
        let (n, count) = (self.x.len(), parameters.len());
        if n + count != system.states() {
            return Err(Error::Parameter {
                name: "the number of states with their parameters",
                value: system.states() as f64,
                bound: "the sum of both numbers",
            });
        }
        let missing = |what: &'static str| Error::NotFound {
            what,
            t: self.t,
            span: self.period,
        };
        if self.family > 0 {
            return Err(missing(
                "the derivative of an orbit that is one of a family",
            ));
        }
        let state = self.x.iter().chain(parameters).copied();
        let start = Moment {
            t: self.t,
            x: Vector::from_iterator(n + count, state),
        };
        let t_end = self.t + self.period;
        let by: Vec<Variable> = (0..n + count).map(Variable::Start).collect();
        let found = Extremes::of(system, &start, t_end, n, options)?;
        let times = found.times();
        let of = Differentiated::all(system, &by);
        let along = of.derivatives(start.clone(), t_end, &times, &[], options)?;
        if let Some(lost) = along.lost {
            return Err(lost);
        }
        let drive = is_forced.then(|| match system.period(&start.x) {
            Some((drive, slopes)) => slopes.rows(n, count) * (self.period / drive).round(),
            None => Vector::zeros(count),
        });
        let (flow, velocity) = flow_derivative(system, &start, t_end, options, !is_forced)?;
        let solved = solved(
            &flow.matrix,
            (&velocity, &found.velocity),
            (n, count),
            drive.as_ref(),
        );
        let (x, period) = solved.ok_or_else(|| missing("an orbit beside the periodic orbit"))?;
        let holds = |state: usize| !system.is_discrete(state) || x.row(state).amax() == 0.0;
        if !(0..n).all(holds) {
            return Err(missing("the derivative of a discrete state at the start"));
        }
        // Of the start of the run: the state on the orbit, and the parameters themselves.
        let mut seeds = Matrix::zeros(n + count, count);
        seeds.rows_mut(0, n).copy_from(&x);
        seeds.rows_mut(n, count).fill_with_identity();
        let extremes = found.derivatives(system, (&along, &times), &seeds);
        Ok(PeriodicDerivatives {
            period,
            x,
            extremes,
        })
    }
}

/// The derivatives of state and period from those of the flow over a period: `velocities` are those
/// at the end and at the start.
fn solved(
    flow: &Matrix,
    velocities: (&Vector, &Vector),
    (n, count): (usize, usize),
    drive: Option<&Vector>,
) -> Option<(Matrix, Vec<f64>)> {
    let (ends, begins) = (velocities.0.rows(0, n), velocities.1.rows(0, n));
    let unknowns = n + usize::from(drive.is_none());
    let mut matrix = Matrix::zeros(unknowns, unknowns);
    let mut right = Matrix::zeros(unknowns, count);
    let closes = flow.view((0, 0), (n, n)) - Matrix::identity(n, n);
    matrix.view_mut((0, 0), (n, n)).copy_from(&closes);
    let by_parameters = -flow.view((0, n), (n, count));
    right.rows_mut(0, n).copy_from(&by_parameters);
    match drive {
        Some(drive) => {
            for (k, slope) in drive.iter().enumerate() {
                for (i, rate) in ends.iter().enumerate() {
                    right[(i, k)] -= rate * slope;
                }
            }
        }
        None => {
            matrix.view_mut((0, n), (n, 1)).copy_from(&ends);
            let row = begins.transpose();
            matrix.view_mut((n, 0), (1, n)).copy_from(&row);
        }
    }
    let found = matrix.lu().solve(&right)?;
    let is_finite = found.iter().all(|value| value.is_finite());
    let period = match drive {
        Some(drive) => drive.iter().copied().collect(),
        None => found.row(n).iter().copied().collect(),
    };
    is_finite.then(|| (found.rows(0, n).into_owned(), period))
}

/// Place of an extreme of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ExtremeAt {
    /// Start of a step.
    Begin,
    /// Inside a step, where its velocity is zero.
    Inside,
    /// End of a step.
    End,
}

/// A smallest or largest value.
#[derive(Clone, Debug)]
struct Extreme {
    at: Moment,
    mode: Modes,
    place: ExtremeAt,
}

/// Extremes of all states along one period.
struct Extremes {
    /// Smallest and largest value of each state.
    of: Vec<[Extreme; 2]>,
    /// The velocity at the start.
    velocity: Vector,
}

impl Extremes {
    fn of(
        system: &dyn Dynamics,
        start: &Moment,
        t_end: f64,
        states: usize,
        options: &Options,
    ) -> Result<Self, Error> {
        let mut orbit = system.begin(start, t_end, options, &[])?;
        let mode = orbit.mode();
        let begin = Extreme {
            at: start.clone(),
            mode,
            place: ExtremeAt::Begin,
        };
        let mut found = Extremes {
            of: vec![[begin.clone(), begin]; states],
            velocity: velocity_in(system, mode, start),
        };
        loop {
            match orbit.step()? {
                OrbitProgress::Step => {
                    let step = orbit.last_step();
                    found.widen(system, &step, &orbit.solution());
                }
                OrbitProgress::End(_) => return Ok(found),
                OrbitProgress::Transition(_)
                | OrbitProgress::Passage(_)
                | OrbitProgress::PhaseEnd(_)
                | OrbitProgress::Kink(_) => {}
            }
        }
    }

    /// Takes the extremes of a step where they are beyond those before.
    fn widen(&mut self, system: &dyn Dynamics, step: &Step, solution: &Solution) {
        let time = |part: u32| {
            let part = f64::from(part) / f64::from(PARTS_PER_STEP);
            step.t_start + part * (step.t_end - step.t_start)
        };
        let moment = |t: f64| Moment { t, x: solution(t) };
        // Inputs hold their values up to the step's end, where they may kink.
        let flow = system.flow_held(step.mode, &step.end(), step.t_start);
        let velocity = |at: &Moment| flow.velocity(at);
        let inside = (1..PARTS_PER_STEP).map(|part| moment(time(part)));
        let begin = std::iter::once(step.start());
        let samples: Vec<Moment> = begin.chain(inside).chain([step.end()]).collect();
        let rates: Vec<Vector> = samples.iter().map(velocity).collect();
        for (state, known) in self.of.iter_mut().enumerate() {
            let mut consider = |at: &Moment, place: ExtremeAt| {
                for (extreme, sign) in known.iter_mut().zip([-1.0, 1.0]) {
                    if sign * at.x[state] > sign * extreme.at.x[state] {
                        let (at, mode) = (at.clone(), step.mode);
                        *extreme = Extreme { at, mode, place };
                    }
                }
            };
            consider(&step.start(), ExtremeAt::Begin);
            for (pair, rates) in samples.windows(2).zip(rates.windows(2)) {
                let [before, after] = [&rates[0], &rates[1]].map(|rate| rate[state]);
                if before * after < 0.0 {
                    let (mut low, mut high) = (pair[0].t, pair[1].t);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        match velocity(&moment(middle))[state] * before > 0.0 {
                            true => low = middle,
                            false => high = middle,
                        }
                    }
                    consider(&moment(0.5 * (low + high)), ExtremeAt::Inside);
                }
            }
            consider(&step.end(), ExtremeAt::End);
        }
    }

    fn all(&self) -> impl Iterator<Item = &Extreme> {
        self.of.iter().flatten()
    }

    /// Times of all extremes, rising.
    fn times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.all().map(|one| one.at.t).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Derivatives of the extremes, from those along the orbit at their times.
    fn derivatives(
        &self,
        system: &dyn Dynamics,
        (along, times): (&OrbitDerivatives, &[f64]),
        seeds: &Matrix,
    ) -> Vec<[ExtremeDerivatives; 2]> {
        let of = |state: usize, one: &Extreme| {
            let is_same = |t: f64| (t - one.at.t).abs() <= SAME_INSTANT * one.at.t.abs();
            let mut events = along.transitions.iter().filter(|event| is_same(event.at));
            let event: Option<&EventDerivatives> = match one.place {
                ExtremeAt::End => events.next(),
                ExtremeAt::Begin => events.next_back(),
                ExtremeAt::Inside => None,
            };
            let row = match (event, one.place) {
                (Some(event), ExtremeAt::End) => event.before.row(state).into_owned(),
                (Some(event), _) => event.after.row(state).into_owned(),
                (None, _) => {
                    let number = times.iter().position(|t| *t == one.at.t);
                    let columns = number.and_then(|number| along.states.get(number));
                    let Some(columns) = columns else {
                        let none = vec![f64::NAN; seeds.ncols()];
                        return none;
                    };
                    let mut row = columns.row(state).into_owned();
                    if let Some(input) = system.kink(&one.at) {
                        // The state turns where the input does, at the reading of its clock.
                        let velocity = velocity_in(system, one.mode, &one.at);
                        let (_, gradient, in_time) = system.clock(input, &one.at);
                        let rate = in_time + gradient.dot(&velocity);
                        row -= columns.tr_mul(&gradient).transpose() * (velocity[state] / rate);
                    }
                    row
                }
            };
            (row * seeds).iter().copied().collect()
        };
        let extreme = |(state, pair): (usize, &[Extreme; 2])| {
            pair.each_ref().map(|one| ExtremeDerivatives {
                t: one.at.t,
                value: one.at.x[state],
                by: of(state, one),
            })
        };
        self.of.iter().enumerate().map(extreme).collect()
    }
}
