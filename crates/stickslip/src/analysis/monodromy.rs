//! The derivative of the flow map, through slips, sticks and the transitions between them.

use super::tangent::{Tangent, flatten};
use crate::dynamics::{
    AsDynamics, Components, Dynamics, Happening, Matrix, Modes, Moment, Section, Step, Summary,
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
    /// How many times the orbit entered stick; the first such entry takes one from the rank; so does stick at the start, which is no entry.
    pub stick_entries: usize,
    /// How the run that carried it ended.
    pub summary: Summary,
}

/// The monodromy matrix from `(t0, x0)` to `t_end`: every step is run again on dual numbers, every
/// transition contributes its saltation matrix. Where a contact sticks at the start, the orbit is taken to have been on its Σ before: of a change
/// across it there is what comes back to Σ along the kinetic friction, also where that is too weak to bring it back.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NoUniqueFuture`] where Σ repels, and at a two-fold; [`Error::TangentSingular`] where the orbit grazes Σ, or
/// two contacts come to zero in the same instant.
pub fn monodromy<Kind>(
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
    turn(&*system.dynamics(), &start, t_end, options, false)
}

/// The vector that moves a state in a mode.
pub(super) fn velocity_in(system: &dyn Dynamics, mode: Modes, at: &Moment) -> Vector {
    system.flow(mode, at).velocity(at)
}

/// The monodromy matrix. The flow of a system that does not depend on time carries its own direction along exactly.
/// So that direction is taken out of what is carried and put back at the end: near an equilibrium, where an orbit is slow and neighbours part
/// fast, what a step errs along the flow would else grow beyond all that is asked for.
///
/// # Errors
/// As [`monodromy`].
pub(super) fn turn(
    system: &dyn Dynamics,
    start: &Moment,
    t_end: f64,
    options: &Options,
    is_autonomous: bool,
) -> Result<Monodromy, Error> {
    let tangent = Tangent::new(system, options);
    let mut orbit = system.begin(start, t_end, options, &Section::None)?;
    let mut map = TangentMap::identity(system);
    map.begin(system, orbit.mode(), start);
    if is_autonomous {
        map.take_out(&velocity_in(system, orbit.mode(), start));
    }
    loop {
        match orbit.step()? {
            Happening::Step => {
                let step = orbit.last_step();
                map.through_step(&tangent, &step);
            }
            Happening::Transition(at) => map.through_transition(&tangent, &at)?,
            Happening::PhaseEnd(_) | Happening::Passage(_) => {}
            Happening::End(summary) => {
                let velocity = velocity_in(system, orbit.mode(), &orbit.now());
                return Ok(Monodromy {
                    matrix: map.whole(&velocity),
                    stick_entries: map.stick_entries,
                    summary,
                });
            }
        }
    }
}

/// The derivative of the flow map from a start to where a run has come.
pub(super) struct TangentMap {
    /// Its columns.
    columns: Vec<Vector>,
    stick_entries: usize,
    /// How much of the velocity was taken out of each column, where it is.
    along: Option<Vector>,
}

impl TangentMap {
    /// At a start; along discrete states there is no change.
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
        }
    }

    /// The derivative as a matrix.
    pub(super) fn matrix(&self) -> Matrix {
        Matrix::from_columns(&self.columns)
    }

    /// Takes the direction of this velocity out of all columns.
    pub(super) fn take_out(&mut self, velocity: &Vector) {
        let square = velocity.norm_squared();
        // At rest there is no direction.
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

    /// The derivative without what was taken out of it, and that.
    pub(super) fn apart(&self) -> (Matrix, Option<&Vector>) {
        (self.matrix(), self.along.as_ref())
    }

    /// With what was taken out.
    pub(super) fn whole(&self, velocity: &Vector) -> Matrix {
        match &self.along {
            Some(along) => self.matrix() + velocity * along.transpose(),
            None => self.matrix(),
        }
    }

    /// An orbit that begins in stick is taken to have been on Σ before: of a change across it nothing is left.
    pub(super) fn begin(&mut self, system: &dyn Dynamics, mode: Modes, at: &Moment) {
        for (contact, normal) in system.normals(mode, at) {
            // The way back to Σ is along that by which one side's field differs from that of stick, which lies between both sides'.
            let [below, above] = [Side::Below, Side::Above]
                .map(|side| velocity_in(system, mode.with(contact, Mode::Slip(side)), at));
            let way = above - below;
            let across = normal.dot(&way);
            if across != 0.0 {
                for column in &mut self.columns {
                    *column -= &way * (normal.dot(column) / across);
                    flatten(&normal, column);
                }
            }
        }
    }

    pub(super) fn through_step(&mut self, tangent: &Tangent<'_>, step: &Step) {
        tangent.carry(step, &mut self.columns);
        if self.along.is_some() {
            self.take_out(&velocity_in(tangent.system, step.mode, &step.end()));
        }
    }

    pub(super) fn through_transition(
        &mut self,
        tangent: &Tangent<'_>,
        at: &Transition,
    ) -> Result<(), Error> {
        let Some(jump) = tangent.jump(at)? else {
            return Ok(());
        };
        let enters = at.kind == TransitionKind::StickEntry;
        self.stick_entries += usize::from(enters);
        for column in &mut self.columns {
            *column = &jump.matrix * &*column;
            // On Σ there is nothing across it; rounding would leave something.
            if enters {
                flatten(&jump.gradient, column);
            }
        }
        Ok(())
    }
}
