//! The derivative of the flow map, through slips, sticks and the transitions between them.

use super::cycle::SegmentEnd;
use super::graze::{check_step, is_graze};
use super::instant::{Cause, LastEvent};
use super::tangent::{Tangent, flatten, singular};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Matrix, Modes, Moment, OrbitProgress, Step, Summary,
    Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::system::{Mode, Side};

/// The derivative ∂x(t)/∂x(t0) of the flow map along one orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Monodromy {
    /// The derivative, square in the states: column `j` is the change of the end state with
    /// component `j` of the start.
    pub matrix: Matrix,
    /// Number of entries into stick. The first entry reduces the rank by one; so does stick at the
    /// start, which does not count as an entry.
    pub stick_entries: usize,
    /// End of the run, and its work.
    pub summary: Summary,
}

impl Monodromy {
    /// The monodromy matrix from `(t0, x0)` to `t_end`. Every step is repeated on dual numbers, and
    /// every transition contributes its saltation matrix. If a contact sticks at the start, the
    /// orbit is assumed to have been on its Σ before. A change across Σ is projected back along the
    /// kinetic friction, even if that is too weak to return it to Σ.
    ///
    /// # Errors
    /// Those of [`crate::run`]; [`Error::NoUniqueFuture`] where Σ repels, and at a two-fold.
    /// [`Error::TangentSingular`] where the orbit grazes Σ, or two contacts reach zero in the same
    /// instant.
    pub fn of<Kind>(
        system: &impl AsDynamics<Kind>,
        t0: f64,
        x0: impl Components,
        t_end: f64,
        options: &Options,
    ) -> Result<Monodromy, Error> {
        let start = Moment {
            t: t0,
            x: x0.vector(),
        };
        let found = flow_derivative(&*system.dynamics(), &start, t_end, options, false);
        found.map(|(monodromy, _)| monodromy)
    }
}

/// The vector along which a state moves in a mode.
pub(super) fn velocity_in(system: &dyn Dynamics, mode: Modes, at: &Moment) -> Vector {
    system.flow(mode, at).velocity(at)
}

/// The monodromy matrix, and the velocity at the end.
///
/// An autonomous flow carries its own direction exactly. So that direction is
/// removed from the carried vectors and restored at the end. Otherwise the errors of steps along
/// the flow would grow without bound near an equilibrium, where an orbit is slow and neighbours
/// separate fast.
///
/// # Errors
/// As [`Monodromy::of`].
pub(super) fn flow_derivative(
    system: &dyn Dynamics,
    start: &Moment,
    t_end: f64,
    options: &Options,
    is_autonomous: bool,
) -> Result<(Monodromy, Vector), Error> {
    let tangent = Tangent::new(system, options);
    let mut orbit = system.begin(start, t_end, options, &[])?;
    let mut map = TangentMap::identity(system);
    map.begin(system, orbit.mode(), start);
    if is_autonomous {
        map.take_out(&velocity_in(system, orbit.mode(), start));
    }
    loop {
        match orbit.step()? {
            OrbitProgress::Step => {
                let step = orbit.last_step();
                check_step(&tangent, &step, &mut *orbit)?;
                map.through_step(&tangent, &step);
            }
            OrbitProgress::Transition(at) => map.through_exact_transition(&tangent, &at)?,
            OrbitProgress::PhaseEnd(_) | OrbitProgress::Passage(_) | OrbitProgress::Kink(_) => {}
            OrbitProgress::End(summary) => {
                let velocity = velocity_in(system, orbit.mode(), &orbit.now());
                let monodromy = Monodromy {
                    matrix: map.complete(&velocity),
                    stick_entries: map.stick_entries,
                    summary,
                };
                return Ok((monodromy, velocity));
            }
        }
    }
}

/// The derivative of the flow map from a start to the present state of a run.
pub(super) struct TangentMap {
    /// Columns.
    columns: Vec<Vector>,
    stick_entries: usize,
    /// The multiple of the velocity that was removed from each column, if it is removed.
    along: Option<Vector>,
    last: LastEvent,
}

impl TangentMap {
    /// The map at a start: the identity. Discrete states have no tangent direction.
    pub(super) fn identity(system: &dyn Dynamics) -> Self {
        let states = system.states();
        let mut matrix = Matrix::identity(states, states);
        for state in (0..states).filter(|&state| system.is_discrete(state)) {
            matrix[(state, state)] = 0.0;
        }
        TangentMap {
            columns: matrix
                .column_iter()
                .map(|column| column.into_owned())
                .collect(),
            stick_entries: 0,
            along: None,
            last: LastEvent::none(),
        }
    }

    /// The map with a further column.
    pub(super) fn with(mut self, column: Vector) -> Self {
        self.columns.push(column);
        self
    }

    /// The derivative as a matrix.
    pub(super) fn matrix(&self) -> Matrix {
        Matrix::from_columns(&self.columns)
    }

    /// Removes the direction of this velocity from all columns.
    pub(super) fn take_out(&mut self, velocity: &Vector) {
        let square = velocity.norm_squared();
        // An equilibrium has no such direction.
        if square == 0.0 {
            return;
        }
        let count = self.columns.len();
        let along = self.along.get_or_insert_with(|| Vector::zeros(count));
        for (column, along) in self.columns.iter_mut().zip(along.iter_mut()) {
            let part = column.dot(velocity) / square;
            *column -= velocity * part;
            *along += part;
        }
    }

    /// The derivative without the removed part, and that part.
    pub(super) fn apart(&self) -> (Matrix, Option<&Vector>) {
        (self.matrix(), self.along.as_ref())
    }

    /// The derivative with the removed part.
    pub(super) fn complete(&self, velocity: &Vector) -> Matrix {
        match &self.along {
            Some(along) => self.matrix() + velocity * along.transpose(),
            None => self.matrix(),
        }
    }

    /// An orbit that begins in stick is assumed to have been on Σ before: a change across Σ
    /// vanishes.
    /// One on a stop that carries has landed there.
    pub(super) fn begin(&mut self, system: &dyn Dynamics, mode: Modes, at: &Moment) {
        for number in system.landings(at) {
            let landing = system.reset(number, at);
            for column in &mut self.columns {
                *column = &landing.by_state * &*column;
            }
        }
        for (contact, normal) in system.normals(mode, at) {
            // The projection onto Σ is along the difference of one side's field and the sliding
            // field, which lies between both sides' fields.
            let [below, above] = [Side::Below, Side::Above]
                .map(|side| velocity_in(system, mode.with(contact, Mode::Slip(side)), at));
            let direction = above - below;
            let across = normal.dot(&direction);
            if across != 0.0 {
                for column in &mut self.columns {
                    *column -= &direction * (normal.dot(column) / across);
                    flatten(&normal, column);
                }
            }
        }
    }

    pub(super) fn through_step(&mut self, tangent: &Tangent<'_>, step: &Step) {
        self.columns = tangent.carried(step, &self.columns);
        if self.along.is_some() {
            self.take_out(&velocity_in(tangent.system, step.mode, &step.end()));
        }
    }

    pub(super) fn through_transition(
        &mut self,
        tangent: &Tangent<'_>,
        at: &Transition,
    ) -> Result<(), Error> {
        let cause = self.last.cause_of(tangent.system, at);
        self.pass(tangent, at, cause)
    }

    /// Applies [`Self::through_transition`] on an orbit that is no iterate of a search.
    ///
    /// # Errors
    /// [`Error::TangentSingular`] where the orbit grazes, too.
    pub(super) fn through_exact_transition(
        &mut self,
        tangent: &Tangent<'_>,
        at: &Transition,
    ) -> Result<(), Error> {
        let cause = self.last.cause_of(tangent.system, at);
        match is_graze(
            tangent,
            at,
            &SegmentEnd::of(tangent.system, at, cause),
            cause,
        ) {
            true => Err(singular(at.t, &at.x)),
            false => self.pass(tangent, at, cause),
        }
    }

    fn pass(&mut self, tangent: &Tangent<'_>, at: &Transition, cause: Cause) -> Result<(), Error> {
        let Some(jump) = tangent.passed(at, cause, &self.columns)? else {
            return Ok(());
        };
        let enters = at.kind == TransitionKind::StickEntry;
        self.stick_entries += usize::from(enters);
        let is_at_boundary = cause.kink.is_none();
        for column in &mut self.columns {
            *column = &jump.matrix * &*column;
            // On Σ the component across it is zero, except for rounding.
            if enters && is_at_boundary {
                flatten(&jump.gradient, column);
            }
        }
        Ok(())
    }
}
