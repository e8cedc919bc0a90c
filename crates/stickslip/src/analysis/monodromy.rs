//! The derivative of the flow map, through slips, sticks and the transitions between them.

use nalgebra::SMatrix;

use super::tangent::{Tangent, flatten};
use crate::error::Error;
use crate::filippov::{
    Integration, Options, Progress, StepRecord, Summary, Switched, Transition, TransitionKind,
};
use crate::system::State;

/// The derivative ∂x(t)/∂x(t0) of the flow map along one orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monodromy<const N: usize> {
    /// The derivative, `N` × `N`: column `j` is the change of the end state with component `j` of the start.
    pub matrix: SMatrix<f64, N, N>,
    /// How many times the orbit entered stick; the first such entry takes one from the rank.
    pub stick_entries: usize,
    /// How the run that carried it ended.
    pub summary: Summary<N>,
}

/// The monodromy matrix from `(t0, x0)` to `t_end`: every step is run again on dual numbers, every
/// transition contributes its saltation matrix.
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
    let tangent = Tangent::new(system, options);
    let mut map = TangentMap::identity();
    let mut integration = Integration::new(system, t0, x0, t_end, options)?;
    loop {
        match integration.step()? {
            Progress::Step => map.through_step(&tangent, &integration.last_step()),
            Progress::Transition(at) => map.through_transition(&tangent, &at)?,
            Progress::PhaseEnd(_) => {}
            Progress::End(summary) => {
                return Ok(Monodromy {
                    matrix: map.matrix,
                    stick_entries: map.stick_entries,
                    summary,
                });
            }
        }
    }
}

/// The derivative of the flow map from a start to where a run has come.
pub(super) struct TangentMap<const N: usize> {
    pub(super) matrix: SMatrix<f64, N, N>,
    stick_entries: usize,
}

impl<const N: usize> TangentMap<N> {
    pub(super) fn identity() -> Self {
        TangentMap {
            matrix: SMatrix::from_fn(|i, j| f64::from(u8::from(i == j))),
            stick_entries: 0,
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
