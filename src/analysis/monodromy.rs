//! The derivative of the flow map, through slips, sticks and the transitions between them.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use nalgebra::SMatrix;
use num_dual::Dual;

use crate::error::Error;
use crate::filippov::{
    Method, Observer, Options, StepRecord, Summary, Transition, TransitionKind, boundary_gradient,
    run, sliding_field,
};
use crate::ode::{Dop853, Rk4, RungeKutta, stages};
use crate::system::{Filippov, Mode, State};

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

/// The saltation matrix of a transition at `(t, x)` from the vector `before` to `after`:
/// `S = I + (f⁺ − f⁻) ∇hᵀ / (∂h/∂t + ∇h·f⁻)`.
///
/// Aizerman & Gantmakher 1958; Müller, *Chaos, Solitons & Fractals* 5 (1995) 1671; Leine & Nijmeijer 2004, Ch. 7. It
/// holds for crossing and for entry into stick (`after` the sliding field), where it has a zero eigenvalue; leaving
/// stick at a tangent point changes no vector and its saltation matrix is the identity.
pub fn saltation<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: &State<f64, N>,
    before: &State<f64, N>,
    after: &State<f64, N>,
) -> SMatrix<f64, N, N> {
    let (gradient, in_time) = boundary_gradient(system, t, x);
    let mut rate = in_time;
    for i in 0..N {
        rate += gradient[i] * before[i];
    }
    SMatrix::from_fn(|i, j| {
        f64::from(u8::from(i == j)) + (after[i] - before[i]) * gradient[j] / rate
    })
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
    match options.method {
        Method::Dop853 | Method::Dop853Fixed { .. } => {
            carry::<Dop853, S, N>(system, t0, x0, t_end, options)
        }
        Method::Rk4 { .. } => carry::<Rk4, S, N>(system, t0, x0, t_end, options),
    }
}

fn carry<M: RungeKutta, S: Filippov<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: State<f64, N>,
    t_end: f64,
    options: &Options,
) -> Result<Monodromy<N>, Error> {
    let mut tangent = Tangent::<M, S, N> {
        system,
        matrix: SMatrix::from_fn(|i, j| f64::from(u8::from(i == j))),
        stick_entries: 0,
        method: PhantomData,
    };
    let summary = run(system, t0, x0, t_end, options, &mut tangent)?;
    Ok(Monodromy {
        matrix: tangent.matrix,
        stick_entries: tangent.stick_entries,
        summary,
    })
}

/// Carries tangent vectors along a run.
struct Tangent<'a, M, S, const N: usize> {
    system: &'a S,
    matrix: SMatrix<f64, N, N>,
    stick_entries: usize,
    method: PhantomData<M>,
}

impl<M: RungeKutta, S: Filippov<N>, const N: usize> Tangent<'_, M, S, N> {
    /// The column after the step, by the step itself on dual numbers.
    fn carried(&self, step: &StepRecord<N>, column: &State<f64, N>) -> State<f64, N> {
        let mut field = |t: Dual<f64>, x: &State<Dual<f64>, N>| match step.mode {
            Mode::Slip(side) => self.system.field(side, t, x),
            Mode::Stick => sliding_field(self.system, t, x),
        };
        let start = State::from_fn(|i, _| Dual::new(step.x_start[i], column[i]));
        let t = Dual::new(step.t_start, 0.0);
        let h = Dual::new(step.t_end - step.t_start, 0.0);
        let slope = field(t, &start);
        let end = stages::<M, _, _>(&mut field, t, &start, slope, h).end;
        end.map(|v| v.eps)
    }

    fn vector(&self, mode: Mode, t: f64, x: &State<f64, N>) -> State<f64, N> {
        match mode {
            Mode::Slip(side) => self.system.field(side, t, x),
            Mode::Stick => sliding_field(self.system, t, x),
        }
    }
}

impl<M: RungeKutta, S: Filippov<N>, const N: usize> Observer<N> for Tangent<'_, M, S, N> {
    fn step(&mut self, step: &StepRecord<N>) -> ControlFlow<()> {
        for j in 0..N {
            let column = self.matrix.column(j).into_owned();
            let carried = self.carried(step, &column);
            self.matrix.set_column(j, &carried);
        }
        ControlFlow::Continue(())
    }

    fn transition(&mut self, at: &Transition<N>) -> ControlFlow<()> {
        if matches!(
            at.kind,
            TransitionKind::Crossing | TransitionKind::StickEntry
        ) {
            let before = self.vector(at.from, at.t, &at.x);
            let after = self.vector(at.to, at.t, &at.x);
            let jump = saltation(self.system, at.t, &at.x, &before, &after);
            self.matrix = jump * self.matrix;
        }
        if at.kind == TransitionKind::StickEntry {
            self.stick_entries += 1;
            self.flatten(at.t, &at.x);
        }
        ControlFlow::Continue(())
    }
}

impl<M, S: Filippov<N>, const N: usize> Tangent<'_, M, S, N> {
    /// Takes out of every column what rounding has left across Σ: on Σ there is nothing across it.
    fn flatten(&mut self, t: f64, x: &State<f64, N>) {
        let (gradient, _) = boundary_gradient(self.system, t, x);
        let square = gradient.norm_squared();
        for j in 0..N {
            let across: f64 = (0..N).map(|i| gradient[i] * self.matrix[(i, j)]).sum();
            for i in 0..N {
                self.matrix[(i, j)] -= gradient[i] * across / square;
            }
        }
    }
}
