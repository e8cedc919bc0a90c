//! The derivative of the flow map, through slips, sticks and the transitions between them.

use nalgebra::SMatrix;

use super::anchor::velocity_in;
use super::tangent::{Tangent, flatten};
use crate::error::Error;
use crate::filippov::{
    Integration, Options, Progress, StepRecord, Summary, Switched, Transition, TransitionKind,
};
use crate::ode::Timed;
use crate::system::{Mode, Side, State};

/// The derivative ∂x(t)/∂x(t0) of the flow map along one orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monodromy<const N: usize> {
    /// The derivative, `N` × `N`: column `j` is the change of the end state with component `j` of the start.
    pub matrix: SMatrix<f64, N, N>,
    /// How many times the orbit entered stick; the first such entry takes one from the rank; so does stick at the start, which is no entry.
    pub stick_entries: usize,
    /// How the run that carried it ended.
    pub summary: Summary<N>,
}

/// The monodromy matrix from `(t0, x0)` to `t_end`: every step is run again on dual numbers, every
/// transition contributes its saltation matrix. Where a contact sticks at the start, the orbit is taken to have been on its Σ before: of a change
/// across it there is what comes back to Σ along the kinetic friction, also where that is too weak to bring it back.
///
/// # Errors
/// Those of [`crate::run`]; [`Error::NoUniqueFuture`] where Σ repels, and at a two-fold; [`Error::TangentSingular`] where the orbit grazes Σ, or
/// two contacts come to zero in the same instant.
pub fn monodromy<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t0: f64,
    x0: impl Into<State<N>>,
    t_end: f64,
    options: &Options,
) -> Result<Monodromy<N>, Error> {
    let start = Timed {
        t: t0,
        x: x0.into(),
    };
    Ok(turn(system, &start, t_end, options, false)?.monodromy)
}

/// An orbit from a start to an end, as shooting needs it.
pub(super) struct Turn<const N: usize> {
    pub monodromy: Monodromy<N>,
    /// The vector that moves the end state, of the mode that the orbit is in.
    pub velocity: State<N>,
    /// How far each component has gone from the start.
    pub reach: State<N>,
}

/// The monodromy matrix and the velocity at the end. The flow of a system that does not depend on time carries its own direction along exactly.
/// So that direction is taken out of what is carried and put back at the end: near an equilibrium, where an orbit is slow and neighbours part
/// fast, what a step errs along the flow would else grow beyond all that is asked for.
///
/// # Errors
/// As [`monodromy`].
pub(super) fn turn<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    start: &Timed<N>,
    t_end: f64,
    options: &Options,
    is_autonomous: bool,
) -> Result<Turn<N>, Error> {
    let tangent = Tangent::new(system, options);
    let mut integration = Integration::new(system, start.t, start.x, t_end, options)?;
    let mut map = TangentMap::identity();
    map.begin(system, integration.mode(), start);
    if is_autonomous {
        map.take_out(&velocity_in(system, integration.mode(), start));
    }
    let mut reach = State::zeros();
    loop {
        match integration.step()? {
            Progress::Step => {
                map.through_step(&tangent, &integration.last_step());
                reach = (integration.x() - start.x).abs().sup(&reach);
            }
            Progress::Transition(at) => map.through_transition(&tangent, &at)?,
            Progress::PhaseEnd(_) => {}
            Progress::End(summary) => {
                let end = Timed {
                    t: summary.t,
                    x: summary.x,
                };
                let velocity = velocity_in(system, integration.mode(), &end);
                return Ok(Turn {
                    monodromy: Monodromy {
                        matrix: map.whole(&velocity),
                        stick_entries: map.stick_entries,
                        summary,
                    },
                    velocity,
                    reach,
                });
            }
        }
    }
}

/// The derivative of the flow map from a start to where a run has come.
pub(super) struct TangentMap<const N: usize> {
    pub(super) matrix: SMatrix<f64, N, N>,
    stick_entries: usize,
    /// How much of the velocity was taken out of each column, where it is.
    along: Option<State<N>>,
}

impl<const N: usize> TangentMap<N> {
    pub(super) fn identity() -> Self {
        TangentMap {
            matrix: SMatrix::from_fn(|i, j| f64::from(u8::from(i == j))),
            stick_entries: 0,
            along: None,
        }
    }

    /// Takes the direction of this velocity out of all columns.
    fn take_out(&mut self, velocity: &State<N>) {
        let square = velocity.norm_squared();
        // At rest there is no direction.
        if square == 0.0 {
            return;
        }
        let parts = self.matrix.tr_mul(velocity) / square;
        self.matrix -= velocity * parts.transpose();
        *self.along.get_or_insert_with(State::zeros) += parts;
    }

    /// With what was taken out.
    fn whole(&self, velocity: &State<N>) -> SMatrix<f64, N, N> {
        match self.along {
            Some(along) => self.matrix + velocity * along.transpose(),
            None => self.matrix,
        }
    }

    /// An orbit that begins in stick is taken to have been on Σ before: of a change across it nothing is left.
    pub(super) fn begin<S: Switched<N, G>, const G: usize>(
        &mut self,
        system: &S,
        mode: S::Mode,
        at: &Timed<N>,
    ) {
        for (contact, normal) in system.normals(mode, at) {
            // The way back to Σ is along that by which one side's field differs from that of stick, which lies between both sides'.
            let [below, above] = [Side::Below, Side::Above].map(|side| {
                let slips = S::with_mode_of(mode, contact, Mode::Slip(side));
                velocity_in(system, slips, at)
            });
            let way = above - below;
            let across = normal.dot(&way);
            if across != 0.0 {
                on_columns(&mut self.matrix, |column| {
                    *column -= way * (normal.dot(column) / across);
                    flatten(&normal, column);
                });
            }
        }
    }

    pub(super) fn through_step<S: Switched<N, G>, const G: usize>(
        &mut self,
        tangent: &Tangent<'_, S>,
        step: &StepRecord<N, S::Mode>,
    ) {
        on_columns(&mut self.matrix, |column| {
            *column = tangent.carried(step, column)
        });
        if self.along.is_some() {
            let end = Timed {
                t: step.t_end,
                x: step.x_end,
            };
            self.take_out(&velocity_in(tangent.system, step.mode, &end));
        }
    }

    pub(super) fn through_transition<S: Switched<N, G>, const G: usize>(
        &mut self,
        tangent: &Tangent<'_, S>,
        at: &Transition<N, S::Mode>,
    ) -> Result<(), Error> {
        let Some(jump) = tangent.jump(at)? else {
            return Ok(());
        };
        self.matrix = jump.matrix * self.matrix;
        if at.kind == TransitionKind::StickEntry {
            self.stick_entries += 1;
            // On Σ there is nothing across it; rounding would leave something.
            on_columns(&mut self.matrix, |column| flatten(&jump.gradient, column));
        }
        Ok(())
    }
}

fn on_columns<const N: usize>(
    matrix: &mut SMatrix<f64, N, N>,
    mut change: impl FnMut(&mut State<N>),
) {
    for j in 0..N {
        let mut column = matrix.column(j).into_owned();
        change(&mut column);
        matrix.set_column(j, &column);
    }
}
