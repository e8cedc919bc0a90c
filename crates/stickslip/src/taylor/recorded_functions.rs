//! Series of functions along a solution whose series is known.

use super::MAX_ORDER;
use super::recorded::Recorder;
use super::recording::{Location, Recording};
use super::series::Series;
use super::steps::{RowSource, Steps};
use super::sweep::{CoefficientRows, Sweep};
use crate::scalar::Scalar;

/// Most factors of a function that has a series. Chosen: half of the order of a series at the
/// tolerance 1e-6. A higher power has a narrow feature that falls below rounding beside it.
const MOST_FACTORS: u32 = 8;

/// Functions of time and state.
pub(crate) trait Composed<const N: usize> {
    /// Number of functions.
    fn count(&self) -> usize;

    /// The value of a function.
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T;
}

/// Recorded calls of functions, and the coefficients of their series over the last step.
#[derive(Debug, Default)]
pub(crate) struct RecordedFunctions<const N: usize> {
    call: Option<FunctionsCall<N>>,
    series: Series<1>,
}

/// One call of all functions. It can be repeated at any state, but for held components that the
/// functions read.
#[derive(Debug)]
struct FunctionsCall<const N: usize> {
    recording: Recording,
    steps: Steps,
    x: [f64; N],
    reads_held: bool,
    /// Rows of each function; `None` for one with conditions, whose series may hold only for a
    /// while, and for one that is linear in time.
    functions: Vec<Option<RowSource>>,
    room: usize,
}

impl<const N: usize> RecordedFunctions<N> {
    /// Expands the functions along the solution with the coefficients `x`, of which the first
    /// components move, from the time `t` on and in units of time `h`.
    pub(crate) fn expand<X: Copy + Into<[f64; N]>>(
        &mut self,
        (t, h): (f64, f64),
        x: &[X],
        dimension: usize,
        functions: &impl Composed<N>,
    ) {
        let (call, coefficients) = (&mut self.call, x);
        self.series.expand_by(|into| {
            let start: [f64; N] = coefficients.first().map_or([f64::NAN; N], |x| (*x).into());
            let serves = |call: &FunctionsCall<N>| {
                !call.reads_held || call.x[dimension..] == start[dimension..]
            };
            let repeats = match call.as_mut().filter(|call| serves(call)) {
                Some(call) => call.repeat(into, (t, h), &start)?,
                None => false,
            };
            if !repeats {
                *call = Some(FunctionsCall::new(
                    into,
                    (t, h),
                    (&start, dimension),
                    functions,
                )?);
            }
            let orders = coefficients.len().min(MAX_ORDER + 1);
            for (k, x) in coefficients.iter().enumerate().take(orders).skip(1) {
                let x: [f64; N] = (*x).into();
                for (row, x) in into.all.iter().zip(x) {
                    row.set(k, [x]);
                }
            }
            if let Some(call) = call {
                call.higher_orders(into, orders);
            }
            Ok(())
        });
    }

    /// The rows of each function, where it has a series.
    pub(crate) fn rows(&self) -> &[Option<RowSource>] {
        self.call.as_ref().map_or(&[], |call| &call.functions)
    }

    /// The value at the start of the expansion of a function with these rows.
    pub(crate) fn first(&self, of: RowSource) -> f64 {
        self.series.rows()[of.first as usize].lane(0, 0)
    }

    /// Coefficient `k` above order 0.
    pub(crate) fn higher(&self, of: RowSource, k: usize) -> f64 {
        of.factor * self.series.rows()[of.higher as usize].lane(0, k)
    }
}

impl<const N: usize> FunctionsCall<N> {
    /// Records the functions. Those without a series are called once to see that, and left out.
    fn new(
        into: CoefficientRows<'_, 1>,
        time: (f64, f64),
        at: (&[f64; N], usize),
        functions: &impl Composed<N>,
    ) -> Result<Self, usize> {
        let all: Vec<usize> = (0..functions.count()).collect();
        let tried = Self::of_some(into, time, at, (functions, &all))?;
        let has_series = |number: &usize| tried.functions[*number].is_some();
        let some: Vec<usize> = all.iter().copied().filter(has_series).collect();
        match some.len() == all.len() {
            true => Ok(tried),
            false => Self::of_some(into, time, at, (functions, &some)),
        }
    }

    fn of_some(
        into: CoefficientRows<'_, 1>,
        (t, h): (f64, f64),
        (x, dimension): (&[f64; N], usize),
        (functions, some): (&impl Composed<N>, &[usize]),
    ) -> Result<Self, usize> {
        let recorder = Recorder::new(into, ([t], [h]));
        let sweep = &recorder.sweep;
        let time = recorder.at(Location::Linear(0), sweep.time([t], [h]));
        let mut state = [time; N];
        for (i, (number, newest)) in state.iter_mut().zip(x).enumerate() {
            let moving = recorder.at(Location::InRow(i as u32), sweep.state([*newest]));
            *number = match i < dimension {
                true => moving,
                false => recorder.held(*newest),
            };
        }
        let mut found = vec![None; functions.count()];
        for &number in some {
            sweep.value_read.set(false);
            let checks = recorder.checks();
            let value = functions.value(number, time, &state);
            let has_series = !sweep.value_read.get() && recorder.checks() == checks;
            if let Location::InRow(row) = recorder.location(value)
                && has_series
            {
                found[number] = Some(row);
            }
        }
        let rows = sweep.next_row();
        let room = rows + sweep.choices.get();
        if room > into.all.len() {
            return Err(room);
        }
        let reads_held = recorder.reads_held.get();
        let recording = recorder.end();
        // A narrow feature of others is seen far from it by terms that rounding hides.
        let is_plain = |row: &u32| {
            let factors = recording.factors(Location::InRow(*row));
            factors.is_some_and(|factors| factors <= MOST_FACTORS)
        };
        for row in &mut found {
            *row = row.filter(is_plain);
        }
        let wanted = found.iter().flatten().map(|&row| Location::InRow(row));
        let (steps, sources) = Steps::with_sources(&recording, wanted, rows);
        let source = |row: &Option<u32>| row.map(|row| sources[row as usize]);
        Ok(FunctionsCall {
            functions: found.iter().map(source).collect(),
            recording,
            steps,
            x: *x,
            reads_held,
            room,
        })
    }

    /// Repeats order 0. Returns whether all comparisons gave the recorded results.
    fn repeat(
        &mut self,
        into: CoefficientRows<'_, 1>,
        (t, h): (f64, f64),
        x: &[f64; N],
    ) -> Result<bool, usize> {
        if self.room > into.all.len() {
            return Err(self.room);
        }
        let sweep = Sweep::new(into, 0);
        let x = x.map(|x| [x]);
        x.iter().for_each(|x| {
            sweep.store_next(*x);
        });
        let at = (sweep.time([t], [h]), &x[..]);
        Ok(self.recording.repeat_first_alone(at, &sweep))
    }

    fn higher_orders(&self, into: CoefficientRows<'_, 1>, orders: usize) {
        higher_orders(&self.recording, &self.steps, into, orders);
    }
}

/// Repeats the operations for the orders above 0. The number of states is not part of the type, so
/// that this compiles once for all systems.
#[inline(never)]
fn higher_orders(
    recording: &Recording,
    steps: &Steps,
    into: CoefficientRows<'_, 1>,
    orders: usize,
) {
    let replay = recording.alone();
    for k in 1..orders {
        steps.repeat(&replay, into, k);
    }
}
