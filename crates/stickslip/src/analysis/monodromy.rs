//! The derivative of the flow map, through slips, sticks and the transitions between them.

use nalgebra::SMatrix;

use super::tangent::{Tangent, flatten};
use crate::error::Error;
use crate::filippov::{Integration, Options, Progress, Summary, Switched, TransitionKind};
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
/// Those of [`crate::run`].
pub fn monodromy<S: Switched<N, G>, const N: usize, const G: usize>(
    system: &S,
    t0: f64,
    x0: impl Into<State<N>>,
    t_end: f64,
    options: &Options,
) -> Result<Monodromy<N>, Error> {
    let tangent = Tangent::new(system, options);
    let mut matrix = SMatrix::from_fn(|i, j| f64::from(u8::from(i == j)));
    let mut stick_entries = 0;
    let mut integration = Integration::new(system, t0, x0, t_end, options)?;
    loop {
        match integration.step()? {
            Progress::Step => {
                let step = integration.last_step();
                on_columns(&mut matrix, |column| {
                    *column = tangent.carried(&step, column)
                });
            }
            Progress::Transition(at) => {
                let Some(jump) = tangent.jump(&at) else {
                    continue;
                };
                matrix = jump.matrix * matrix;
                if at.kind == TransitionKind::StickEntry {
                    stick_entries += 1;
                    // On Σ there is nothing across it; rounding would leave something.
                    on_columns(&mut matrix, |column| flatten(&jump.gradient, column));
                }
            }
            Progress::PhaseEnd(_) => {}
            Progress::End(summary) => {
                return Ok(Monodromy {
                    matrix,
                    stick_entries,
                    summary,
                });
            }
        }
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
