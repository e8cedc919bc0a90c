//! Tests of the series against references with 30 digits, exact identities, and each other.

use std::cell::{Cell, RefCell};

use pulp::{Arch, NullaryFnOnce};

use super::recorded_calls::{LinearNumbers, RecordedCalls};
use super::row::{CoefficientRow, Lanes};
use super::series::{Expansion, Functions, Series, WatchedRow, in_rows};
use super::{MAX_COEFFICIENTS, MAX_ORDER};
use crate::dual::Dual;
use crate::scalar::Scalar;

#[inline(always)]
fn expand<const L: usize, const N: usize, const W: usize>(
    series: &mut Series<L>,
    time: (Lanes<L>, Lanes<L>),
    x: [Lanes<L>; N],
    order: usize,
    functions: &impl Functions<N, W>,
) -> Expansion<W> {
    series.expand_by(|rows| in_rows(rows, time, &x, order, functions))
}

/// Functions that count their calls.
struct Interpreted<'a, F>(&'a F, Cell<usize>);

impl<F: Functions<N, W>, const N: usize, const W: usize> Functions<N, W> for Interpreted<'_, F> {
    fn at<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; W]) {
        self.1.set(self.1.get() + 1);
        self.0.at(t, x)
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }
}

/// Coefficients of the watched functions along the solution from `x` at time 0, in units of time
/// `h`.
fn coefficients<const N: usize, const W: usize>(
    functions: &impl Functions<N, W>,
    x: [f64; N],
    h: f64,
) -> [Vec<f64>; W] {
    let read = |series: &Series<1>, expansion: Expansion<W>| {
        expansion.watched.map(|watched| {
            let row = watched.expect("not constant").row;
            (0..=MAX_ORDER)
                .map(|k| series.rows()[row].lane(0, k))
                .collect()
        })
    };
    let linear = |of: &Expansion<W>| of.watched.map(|watched| watched.map(|row| row.is_linear));
    // One call serves series at other times and states, and of other lengths.
    let (interpreted, mut repeated) = (
        Interpreted(functions, Cell::new(0)),
        RecordedCalls::default(),
    );
    let mut found = [const { Vec::new() }; W];
    let mut series = Series::<1>::default();
    expand(
        &mut series,
        ([0.0], [h]),
        x.map(|x| [x + 0.05]),
        MAX_ORDER,
        functions,
    );
    for (t, shift, length) in [
        (0.3, 0.1, 0.5 * h),
        (-0.1, 0.0, h),
        (0.0, 0.2, 0.7 * h),
        (0.0, 0.0, h),
    ] {
        let (time, x) = (([t], [length]), x.map(|x| [x + shift]));
        let mut by_calls = Series::<1>::default();
        let wanted = expand(&mut by_calls, time, x, MAX_ORDER, functions);
        let again =
            series.expand_by(|rows| repeated.expand(rows, time, &x, MAX_ORDER, &interpreted));
        assert_eq!(linear(&again), linear(&wanted));
        found = read(&by_calls, wanted);
        let again: [Vec<f64>; W] = read(&series, again);
        for (found, again) in found.iter().zip(again) {
            let size = found.iter().fold(0.0, |size, c| f64::max(size, c.abs()));
            for (k, (a, b)) in found.iter().zip(again).enumerate() {
                let allowed = 1e-14 * a.abs() + 1e-16 * size;
                assert!(
                    (a - b).abs() <= allowed,
                    "at {t}, {x:?}, order {k}: {a} {b}"
                );
            }
        }
    }
    assert_eq!(interpreted.1.get(), 1);
    found
}

/// Functions of `3/4 + s/2 − s²/4 + s³/8`, in the order of the references.
struct OfPolynomial;

impl Functions<1, 15> for OfPolynomial {
    fn at<T: Scalar>(&self, s: T, _x: &[T; 1]) -> ([T; 1], [T; 15]) {
        let u = ((s * 0.125 - 0.25) * s + 0.5) * s + 0.75;
        let functions = [
            u * (u * u),
            (u * u) / (u + 1.0),
            u.recip(),
            u.powi(-3),
            u.powf(2.5),
            u.sqrt(),
            u.exp(),
            u.ln(),
            u.sin(),
            u.cos(),
            u.tan(),
            u.atan(),
            u.sinh(),
            u.cosh(),
            u.tanh(),
        ];
        ([T::zero()], functions)
    }
}

#[test]
fn every_function_has_the_coefficients_that_it_is_known_to_have() {
    let table = include_str!("../../tests/data/coefficients.csv");
    let exact = table.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        (fields[0], fields[2].parse::<f64>().expect("a number"))
    });
    let exact: Vec<(&str, f64)> = exact.collect();
    let found = coefficients(&OfPolynomial, [0.0], 1.0);
    assert_eq!(exact.len(), found.len() * MAX_COEFFICIENTS);
    for (found, exact) in found.iter().zip(exact.chunks(MAX_COEFFICIENTS)) {
        for (k, (found, (name, exact))) in found.iter().zip(exact).enumerate() {
            // A coefficient that nearly cancels has the rounding error of its neighbours.
            let allowed = 3e-14 * exact.abs() + 1e-17;
            assert!(
                (found - exact).abs() <= allowed,
                "{name}, order {k}: {found} {exact}"
            );
        }
    }
}

/// `x' = x² + 1` from 0, whose solution is the tangent, and functions whose values follow from it.
struct OfTangent;

impl Functions<1, 9> for OfTangent {
    fn at<T: Scalar>(&self, t: T, x: &[T; 1]) -> ([T; 1], [T; 9]) {
        let x = x[0];
        let (sine, cosine) = (t * 2.0).sin_cos();
        let watched = [
            x,
            t.tan(),
            x.atan(),
            sine * sine + cosine * cosine + t,
            (x + 2.0).ln().exp(),
            t - ((x + 2.0).sqrt() - (x + 2.0).powf(0.5)),
            x + t * 3.0,
            x - t * 3.0,
            t * 3.0 - x,
        ];
        ([x * x + 1.0], watched)
    }
}

/// `x' = t`, with linear functions only.
struct OfTime;

impl Functions<1, 3> for OfTime {
    fn at<T: Scalar>(&self, t: T, x: &[T; 1]) -> ([T; 1], [T; 3]) {
        let watched = [x[0], t * (t * 2.0 + 1.0), (t - 3.0) / 2.0];
        ([t], watched)
    }
}

#[test]
fn what_is_linear_in_time_stays_so_until_it_is_multiplied() {
    let [x, product, line] = coefficients(&OfTime, [1.0], 0.5);
    let is_line_and_no_more = |found: &[f64], exact: [f64; 3]| {
        assert_eq!(found[..3], exact);
        assert!(found[3..].iter().all(|c| *c == 0.0));
    };
    is_line_and_no_more(&x, [1.0, 0.0, 0.125]);
    is_line_and_no_more(&product, [0.0, 0.5, 0.5]);
    is_line_and_no_more(&line, [-1.5, 0.25, 0.0]);
}

#[test]
fn functions_of_a_solution_keep_their_identities() {
    let h = 0.5;
    let [x, tangent, angle, one, exp_of_ln, none, sum, less, rest] =
        coefficients(&OfTangent, [0.0], h);
    for k in 0..=MAX_ORDER {
        let at = |order: usize, value: f64| if k == order { value } else { 0.0 };
        for (found, exact, what) in [
            (tangent[k], x[k], "tan t is the solution"),
            (angle[k], at(1, h), "atan x is the time"),
            (one[k], at(0, 1.0) + at(1, h), "sin² + cos²"),
            (exp_of_ln[k], x[k] + at(0, 2.0), "exp ln"),
            (none[k], at(1, h), "two roots"),
            (sum[k], x[k] + at(1, 3.0 * h), "with a line"),
            (less[k], x[k] - at(1, 3.0 * h), "less a line"),
            (rest[k], at(1, 3.0 * h) - x[k], "a line less it"),
        ] {
            assert!(
                (found - exact).abs() <= 2e-15,
                "{what}, order {k}: {found} {exact}"
            );
        }
    }
}

/// A level that the field uses before it is watched.
struct Shared;

impl Functions<1, 1> for Shared {
    fn at<T: Scalar>(&self, _t: T, x: &[T; 1]) -> ([T; 1], [T; 1]) {
        let field = [(x[0] - 0.4) * x[0]];
        (field, [x[0] - 0.4])
    }
}

#[test]
fn what_is_done_twice_is_as_linear_as_what_is_done_once() {
    // The function asserts that repetition agrees.
    let [level] = coefficients(&Shared, [0.3], 0.5);
    assert_eq!(level[0], 0.3 - 0.4);
    assert_eq!(level[1], (0.3 - 0.4) * 0.3 * 0.5);
}

/// Two equations with all features: friction, forcing, a spring with a stop.
struct Everything;

impl Functions<2, 3> for Everything {
    fn at<T: Scalar>(&self, t: T, x: &[T; 2]) -> ([T; 2], [T; 3]) {
        let friction = T::constant(0.3) / (x[1] * 0.5 + 1.0);
        let forced = (t * 3.0).sin() * (-x[0]).exp();
        let spring = x[0] * x[0] * x[1] - (x[0] + 2.0).sqrt() + (x[0] - 0.9).max(T::zero());
        let field = [x[1] / (x[0] + t + 2.0), forced - friction + spring / 3.0];
        let others = (x[0] + 1.0).ln() * x[1].cos().powf(1.5);
        (field, [others, x[1] - t * 0.5, T::one()])
    }
}

/// An expansion in the widest vectors of the machine.
struct Widest<'a, F, const L: usize> {
    functions: &'a F,
    series: &'a mut Series<L>,
    time: (Lanes<L>, Lanes<L>),
    x: [Lanes<L>; 2],
}

impl<F: Functions<2, 3>, const L: usize> NullaryFnOnce for Widest<'_, F, L> {
    type Output = Expansion<3>;
    #[inline(always)]
    fn call(self) -> Expansion<3> {
        expand(self.series, self.time, self.x, MAX_ORDER, self.functions)
    }
}

const LANES: usize = 4;

/// Starts of the series in each lane: time, length, state.
fn begin() -> (Lanes<LANES>, Lanes<LANES>, [Lanes<LANES>; 2]) {
    let t: [f64; LANES] = std::array::from_fn(|l| 0.1 * l as f64);
    let x = [t.map(|t| 0.3 + t), t.map(|t| 0.7 - t)];
    (t, t.map(|t| 0.3 + 0.2 * t), x)
}

#[test]
fn neither_lanes_nor_the_width_of_vectors_change_a_bit() {
    let (t, h, x) = begin();
    for arch in [Arch::Scalar, Arch::new()] {
        let mut wide = Series::<LANES>::default();
        let together = arch.dispatch(Widest {
            functions: &Everything,
            series: &mut wide,
            time: (t, h),
            x,
        });
        assert!(!together.lanes_differ && !together.value_read);
        assert_lanes_are_alone(&wide, &together, |time, x, alone| {
            expand(alone, time, x, MAX_ORDER, &Everything)
        });
    }
}

#[test]
fn a_call_recorded_in_one_lane_is_repeated_in_several_with_the_same_bits() {
    let (t, h, x) = begin();
    let interpreted = Interpreted(&Everything, Cell::new(0));
    let repeated = RefCell::new(RecordedCalls::default());
    let alone = |time: (Lanes<1>, Lanes<1>), x: [Lanes<1>; 2], alone: &mut Series<1>| {
        let mut repeated = repeated.borrow_mut();
        alone.expand_by(|rows| repeated.expand(rows, time, &x, MAX_ORDER, &interpreted))
    };
    let mut wide = Series::<LANES>::default();
    let mut linear_numbers = LinearNumbers::new();
    let mut together = |x: [Lanes<LANES>; 2]| {
        let repeated = repeated.borrow();
        wide.expand_by(|rows| {
            repeated.expand_again(rows, (t, h), &x, MAX_ORDER, &mut linear_numbers)
        })
    };
    // Nothing is recorded yet, and then nothing for the lane whose comparison differs.
    assert!(together(x).is_none());
    alone(([0.5], [0.1]), [[0.2], [0.4]], &mut Series::default());
    let mut lanes_differ = x;
    lanes_differ[0][2] = 1.5;
    assert!(together(lanes_differ).is_none());
    let expansion = together(x).expect("all comparisons agree");
    let calls = interpreted.1.get();
    assert_lanes_are_alone(&wide, &expansion, alone);
    assert_eq!(interpreted.1.get(), calls);
    // Both results of the comparison are kept.
    let at = |x: f64| alone(([0.5], [0.1]), [[x], [0.4]], &mut Series::default());
    at(1.5);
    let calls = interpreted.1.get();
    for x in [0.2, 1.4, 0.3] {
        at(x);
    }
    assert_eq!(interpreted.1.get(), calls);
}

/// A field with two held components, of which the second may decide which operations follow.
struct WithHeld {
    reads_choice: bool,
}

impl Functions<3, 1> for WithHeld {
    fn at<T: Scalar>(&self, t: T, [x, level, choice]: &[T; 3]) -> ([T; 3], [T; 1]) {
        let (x, level, choice) = (*x, *level, *choice);
        let scale = (level * 3.0 + T::one() / level).sqrt();
        let forced = (t * level).sin() * scale - (level - 0.5).max(T::zero());
        let by_choice = match self.reads_choice && choice.value() > 0.5 {
            true => x * choice,
            false => x / choice,
        };
        let rate = x * level - by_choice * x / (level + 2.0) + forced;
        ([rate, T::zero(), T::zero()], [x - level * t])
    }

    fn dimension(&self) -> usize {
        1
    }
}

/// Expands a field with held components one after another by the same recorded calls, each with
/// the bits that it has by a call of its own. Returns the numbers of calls that this takes.
fn calls_with_held(reads_choice: bool, held: &[[f64; 2]]) -> Vec<usize> {
    let with_held = WithHeld { reads_choice };
    let interpreted = Interpreted(&with_held, Cell::new(0));
    let rows = |x: [f64; 3], calls: &mut RecordedCalls<3, 1>| {
        let mut series = Series::<1>::default();
        let (time, x) = (([0.2], [0.1]), x.map(|x| [x]));
        let expansion =
            series.expand_by(|rows| calls.expand(rows, time, &x, MAX_ORDER, &interpreted));
        let watched = expansion.watched[0].expect("moves").row;
        [0, watched].map(|row| {
            let row = &series.rows()[row];
            std::array::from_fn::<_, MAX_COEFFICIENTS, _>(|k| row.lane(0, k).to_bits())
        })
    };
    let mut calls = RecordedCalls::default();
    let count = |&[level, choice]: &[f64; 2]| {
        let x = [0.6, level, choice];
        let before = interpreted.1.get();
        let found = rows(x, &mut calls);
        let made = interpreted.1.get() - before;
        let alone = rows(x, &mut RecordedCalls::default());
        assert_eq!(found, alone, "{level} {choice}");
        made
    };
    held.iter().map(count).collect()
}

#[test]
fn a_recorded_call_serves_other_held_components_with_the_same_bits() {
    // Another result of a comparison needs a call.
    let levels = [0.7, 0.9, 1.3, 0.3, 0.4, 1.3].map(|level| [level, level + 0.1]);
    assert_eq!(calls_with_held(false, &levels), [1, 0, 0, 1, 0, 0]);
    // So does any other value of what is read.
    let choices = [0.9, 0.3, 0.8, 0.9].map(|choice| [0.7, choice]);
    assert_eq!(calls_with_held(true, &choices), [1, 1, 1, 0]);
}

/// Asserts that every lane has the bits that it has alone.
fn assert_lanes_are_alone(
    wide: &Series<LANES>,
    together: &Expansion<3>,
    expand_alone: impl Fn((Lanes<1>, Lanes<1>), [Lanes<1>; 2], &mut Series<1>) -> Expansion<3>,
) {
    let (t, h, x) = begin();
    for l in 0..LANES {
        let mut alone = Series::<1>::default();
        let expansion = expand_alone(([t[l]], [h[l]]), x.map(|x| [x[l]]), &mut alone);
        assert_eq!((expansion.choices, together.choices), (1, 1));
        let rows = |watched: &[Option<WatchedRow>]| -> Vec<usize> {
            let watched = watched.iter().flatten().map(|watched| watched.row);
            (0..2).chain(watched).collect()
        };
        assert_eq!(rows(&expansion.watched), rows(&together.watched));
        let rows = rows(&expansion.watched);
        let choices = alone.choices(&expansion).iter();
        let rows_alone = rows.iter().map(|&row| &alone.rows()[row]).chain(choices);
        let choices = wide.choices(together).iter();
        let in_lane = rows.iter().map(|&row| &wide.rows()[row]).chain(choices);
        for (row, (alone, wide)) in rows_alone.zip(in_lane).enumerate() {
            for k in 0..=MAX_ORDER {
                let bits = [alone.lane(0, k), wide.lane(l, k)].map(f64::to_bits);
                assert_eq!(bits[0], bits[1], "lane {l}, row {row}, order {k}");
            }
        }
    }
}

#[test]
fn lanes_that_compare_differently_are_not_expanded_together() {
    let expand = |x: [f64; 2]| {
        let x = [x, [0.1, 0.1]];
        expand(
            &mut Series::<2>::default(),
            ([0.0; 2], [0.1; 2]),
            x,
            8,
            &Everything,
        )
    };
    assert!(!expand([0.1, 0.2]).lanes_differ);
    assert!(expand([0.1, 1.2]).lanes_differ);
}

#[test]
fn functions_are_called_again_where_a_comparison_comes_out_otherwise() {
    let (interpreted, mut repeated) =
        (Interpreted(&Chosen, Cell::new(0)), RecordedCalls::default());
    let mut series = Series::<1>::default();
    for (x, calls) in [(-0.25, 1), (-0.2, 1), (0.25, 2), (0.2, 2), (-0.6, 3)] {
        let expansion = series
            .expand_by(|rows| repeated.expand(rows, ([0.0], [0.125]), &[[x]], 8, &interpreted));
        assert_eq!(interpreted.1.get(), calls, "at {x}");
        let mut wanted = Series::<1>::default();
        let of_calls = expand(&mut wanted, ([0.0], [0.125]), [[x]], 8, &Chosen);
        assert_eq!(expansion.choices, of_calls.choices);
        let row = |watched: Option<WatchedRow>| watched.expect("not constant").row;
        let watched = expansion.watched.map(|of| &series.rows()[row(of)]);
        let found = watched.into_iter().chain(series.choices(&expansion));
        let watched = of_calls.watched.map(|of| &wanted.rows()[row(of)]);
        let wanted = watched.into_iter().chain(wanted.choices(&of_calls));
        for (found, wanted) in found.zip(wanted) {
            for k in 0..=8 {
                assert_eq!(found.at(k), wanted.at(k), "at {x}, order {k}");
            }
        }
    }
}

/// A function that a comparison selects.
struct Chosen;

impl Functions<1, 3> for Chosen {
    fn at<T: Scalar>(&self, t: T, x: &[T; 1]) -> ([T; 1], [T; 3]) {
        let chosen = [x[0].abs(), x[0].max(t - 0.5), x[0].min(t - 0.5)];
        ([T::one()], chosen)
    }
}

#[test]
fn a_comparison_is_remembered_by_how_much_it_is_decided() {
    let mut series = Series::<1>::default();
    let expansion = expand(&mut series, ([0.0], [0.125]), [[-0.25]], 8, &Chosen);
    let watched = expansion
        .watched
        .map(|watched| &series.rows()[watched.expect("not constant").row]);
    let choices = series.choices(&expansion).iter().rev();
    let line = |row: &CoefficientRow<1>| [row.lane(0, 0), row.lane(0, 1)];
    assert_eq!(
        watched.map(line),
        [[0.25, -0.125], [-0.25, 0.125], [-0.5, 0.125]]
    );
    let ahead: Vec<[f64; 2]> = choices.map(line).collect();
    assert_eq!(ahead, [[0.25, -0.125], [0.25, 0.0], [0.25, 0.0]]);
}

/// The rate of `x₁ − 0.4` along the field, and the difference of two fields.
struct Cancelling;

impl Functions<2, 2> for Cancelling {
    fn at<T: Scalar>(&self, t: T, x: &[T; 2]) -> ([T; 2], [T; 2]) {
        let field = [x[1], x[0] * x[0]];
        let along = [0, 1].map(|i| Dual::new(x[i], field[i]));
        let boundary = (along[1] - 0.4) * Dual::one() + Dual::new(t, T::one()) * Dual::zero();
        let [_, shared] = field;
        (field, [boundary.eps, shared - field[1]])
    }
}

#[test]
fn derivatives_that_are_zero_or_one_leave_nothing_behind_and_what_is_shared_cancels() {
    let mut series = Series::<1>::default();
    let x = [[0.3], [0.7]];
    let [rate, none] = expand(&mut series, ([0.0], [0.5]), x, 8, &Cancelling).watched;
    assert_eq!(rate.expect("not constant").row, 2, "the field's own row");
    assert!(none.is_none());
}

#[test]
fn a_function_with_more_operations_than_there_is_room_for_makes_room() {
    struct Long;
    impl Functions<1, 1> for Long {
        fn at<T: Scalar>(&self, _t: T, x: &[T; 1]) -> ([T; 1], [T; 1]) {
            let one = (0..50).fold(x[0], |sum, _| sum + x[0].max(T::zero()));
            ([x[0]], [one / 51.0])
        }
    }
    let [mean] = coefficients(&Long, [1.0], 1.0);
    for (k, found) in mean.iter().enumerate() {
        let exact = (1..=k).fold(1.0, |product, j| product / j as f64);
        assert!(
            (found - exact).abs() <= 51.0 * f64::EPSILON * exact,
            "{k}: {found} {exact}"
        );
    }
}

#[test]
fn values_of_a_series_are_those_of_the_numbers() {
    struct Reading;
    impl Functions<1, 1> for Reading {
        fn at<T: Scalar>(&self, t: T, x: &[T; 1]) -> ([T; 1], [T; 1]) {
            assert_eq!(((x[0] * x[0]).value(), t.value()), (0.25, 3.0));
            ([t], [(x[0] - 0.5).divided_or(x[0] - 0.5, 7.0) + t])
        }
    }
    let mut series = Series::<1>::default();
    let expansion = expand(&mut series, ([3.0], [0.1]), [[0.5]], 8, &Reading);
    assert!(expansion.value_read);
    let row = &series.rows()[expansion.watched[0].expect("not constant").row];
    assert_eq!((row.at(0), row.at(1)), ([10.0], [0.1]));
}
