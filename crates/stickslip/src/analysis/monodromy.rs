//! The derivative of the flow map, through slips, sticks and the transitions between them.

use std::ops::ControlFlow;

use nalgebra::SMatrix;

use super::tangent::{Tangent, flatten};
use crate::error::Error;
use crate::filippov::{Observer, Options, StepRecord, Summary, Transition, TransitionKind, run};
use crate::system::{Filippov, State};

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
/// Those of [`run`].
pub fn monodromy<S: Filippov<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<f64, N>,
    t_end: f64,
    options: &Options,
) -> Result<Monodromy<N>, Error> {
    let mut carrier = Carrier {
        tangent: Tangent::new(system, options),
        matrix: SMatrix::from_fn(|i, j| f64::from(u8::from(i == j))),
        stick_entries: 0,
    };
    let summary = run(system, t0, x0, t_end, options, &mut carrier)?;
    Ok(Monodromy {
        matrix: carrier.matrix,
        stick_entries: carrier.stick_entries,
        summary,
    })
}

/// Carries the columns of the derivative along a run.
struct Carrier<'a, S, const N: usize> {
    tangent: Tangent<'a, S>,
    matrix: SMatrix<f64, N, N>,
    stick_entries: usize,
}

impl<S: Filippov<N>, const N: usize> Observer<N> for Carrier<'_, S, N> {
    fn step(&mut self, step: &StepRecord<N>) -> ControlFlow<()> {
        for j in 0..N {
            let column = self.matrix.column(j).into_owned();
            let carried = self.tangent.carried(step, &column);
            self.matrix.set_column(j, &carried);
        }
        ControlFlow::Continue(())
    }

    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        let Some(jump) = self.tangent.jump(at) else {
            return ControlFlow::Continue(());
        };
        self.matrix = jump.matrix * self.matrix;
        if at.kind == TransitionKind::StickEntry {
            self.stick_entries += 1;
            // On Σ there is nothing across it; rounding would leave something.
            for j in 0..N {
                let mut column = self.matrix.column(j).into_owned();
                flatten(&jump.gradient, &mut column);
                self.matrix.set_column(j, &column);
            }
        }
        ControlFlow::Continue(())
    }
}
