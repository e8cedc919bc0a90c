//! Event functions that are not affine, as series over Taylor steps. They are functions of the
//! series of the states, by their recorded operations.

use super::EventFunctions;
use super::affine::{Affine, Slopes};
use crate::filippov::flow::gradient;
use crate::filippov::observer::StepRecord;
use crate::ode::{Timed, power_series};
use crate::scalar::Scalar;
use crate::system::{State, components};
use crate::taylor::MAX_COEFFICIENTS;
use crate::taylor::recorded_functions::{Composed, RecordedFunctions};
use crate::taylor::steps::RowSource;

/// The functions that are not affine.
pub(super) struct ComposedSeries<const N: usize> {
    numbers: Vec<usize>,
    recorded: RecordedFunctions<N>,
    /// Rows of each set of functions that differ by a constant, the first of them, and whether
    /// there are others.
    sets: Vec<(RowSource, usize, bool)>,
    /// Each of the functions over the last step; `None` where it has no series.
    of: Vec<Option<Affine>>,
}

/// Some of the functions.
struct NotAffine<'a, V> {
    events: &'a V,
    numbers: &'a [usize],
}

impl<V: EventFunctions<N>, const N: usize> Composed<N> for NotAffine<'_, V> {
    fn count(&self) -> usize {
        self.numbers.len()
    }

    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T {
        self.events.value(self.numbers[number], t, x)
    }
}

impl<const N: usize> ComposedSeries<N> {
    /// The functions that are not affine.
    pub(super) fn of(affine: &[Option<Affine>]) -> Self {
        let numbers = (0..affine.len()).filter(|&number| affine[number].is_none());
        ComposedSeries {
            numbers: numbers.collect(),
            recorded: RecordedFunctions::default(),
            sets: Vec::new(),
            of: vec![None; affine.len()],
        }
    }

    /// A function over the last step, by the slopes that [`ComposedSeries::follow`] has set.
    pub(super) fn function(&self, number: usize) -> Option<Affine> {
        self.of[number]
    }

    /// Takes the next step of a system of which the first components move, with states of this
    /// size. The slopes from `first` on are those of the sets of functions.
    pub(super) fn follow<K>(
        &mut self,
        step: &StepRecord<N, K>,
        (events, dimension): (&impl EventFunctions<N>, usize),
        size: &State<N>,
        (slopes, first): (&mut Vec<Slopes<N>>, usize),
    ) {
        let Some(of_states) = step.dense.series().filter(|_| !self.numbers.is_empty()) else {
            self.of.fill(None);
            return;
        };
        let (numbers, recorded) = (&self.numbers, &mut self.recorded);
        let functions = NotAffine { events, numbers };
        let time = (step.t_start, step.dense.h);
        recorded.expand(time, of_states, dimension, &functions);
        let recorded = &*recorded;
        self.sets.clear();
        for (&number, rows) in numbers.iter().zip(recorded.rows()) {
            self.of[number] = rows.map(|rows| {
                let same = |(set, ..): &(RowSource, usize, bool)| {
                    (set.higher, set.factor) == (rows.higher, rows.factor)
                };
                let known = self.sets.iter().position(same);
                let set = known.unwrap_or(self.sets.len());
                match self.sets.get_mut(set) {
                    Some((.., is_shared)) => *is_shared = true,
                    None => self.sets.push((rows, number, false)),
                }
                Affine {
                    slopes: first + set,
                    constant: recorded.first(rows),
                }
            });
        }
        let order = of_states.len() - 1;
        for (set, &(rows, number, is_shared)) in self.sets.iter().enumerate() {
            let mut c = [0.0; MAX_COEFFICIENTS];
            for (k, c) in c.iter_mut().enumerate().take(order + 1).skip(1) {
                *c = recorded.higher(rows, k);
            }
            let length = step.t_end - step.t_start;
            let (middle, _) = power_series(of_states, 0.5 * length / step.dense.h);
            let change = |t: f64, x: &State<N>| {
                events.value(number, t, components(x)) - recorded.first(rows)
            };
            let changes = [
                change(step.t_start + 0.5 * length, &middle),
                change(step.t_end, &step.x_end),
            ];
            let at = Timed {
                t: step.t_start,
                x: step.x_start,
            };
            let dual = |t, x: &_| events.value(number, t, x);
            let (gradient, in_time) = gradient(dual, &at, dimension);
            let late = f64::max(step.t_start.abs(), step.t_end.abs());
            let size = gradient.abs().dot(size) + in_time.abs() * late;
            let size = size.max(recorded.first(rows).abs());
            if slopes.len() == first + set {
                slopes.push(Slopes::composed());
            }
            slopes[first + set].is_shared = is_shared;
            slopes[first + set].follow_series(step, (c, order), (changes, size));
        }
    }
}
