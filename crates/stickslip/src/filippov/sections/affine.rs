//! Affine event functions over a step. Functions with the same slopes differ by a constant, and
//! share all that a step says about them.

use super::EventFunctions;
use super::function_series::{FunctionSeries, OnSeries};
use super::over_step::SampledStep;
use crate::filippov::flow::gradient;
use crate::filippov::run::TIME_ROUNDING;
use crate::filippov::uncertainty::STATE_ROUNDING;
use crate::ode::Timed;
use crate::system::{State, components};

/// An affine function of time and state: one of the [`Slopes`], and a constant.
#[derive(Clone, Copy)]
pub(super) struct Affine {
    pub slopes: usize,
    constant: f64,
}

/// Slopes that affine functions have in common, and their part of these functions over a step.
pub(super) struct Slopes<const N: usize> {
    normal: State<N>,
    in_time: f64,
    /// That part at the ends of the step.
    start: f64,
    end: f64,
    /// Size of its terms.
    size: f64,
    /// Bounds of it over the step.
    range: [f64; 2],
    /// What it adds from the start of a Taylor step on.
    rise: FunctionSeries,
    is_series: bool,
}

impl<const N: usize> Slopes<N> {
    /// The affine ones of event functions, and what slopes they have.
    pub(super) fn of(events: &impl EventFunctions<N>) -> (Vec<Option<Affine>>, Vec<Self>) {
        let mut all: Vec<Self> = Vec::new();
        let mut affine = |number: usize| {
            if !events.is_affine(number) {
                return None;
            }
            let (t, x) = (0.0, State::from([0.0; N]));
            let value = |t, x: &_| events.value(number, t, x);
            let (normal, in_time) = gradient(value, &Timed { t, x }, N);
            let known = all
                .iter()
                .position(|one| (one.normal, one.in_time) == (normal, in_time));
            let slopes = known.unwrap_or(all.len());
            if slopes == all.len() {
                all.push(Slopes {
                    normal,
                    in_time,
                    start: 0.0,
                    end: 0.0,
                    size: 0.0,
                    range: [f64::NEG_INFINITY, f64::INFINITY],
                    rise: FunctionSeries::new(),
                    is_series: false,
                });
            }
            let constant = events.value(number, t, components(&x));
            Some(Affine { slopes, constant })
        };
        let functions = (0..events.count()).map(&mut affine).collect();
        (functions, all)
    }

    /// Takes the next step, of states of this size.
    pub(super) fn follow<K>(&mut self, over: &SampledStep<'_, K, N>, size: &State<N>) {
        let step = over.step;
        let at = |t: f64, x: &State<N>| self.normal.dot(x) + self.in_time * t;
        (self.start, self.end) = (at(step.t_start, &step.x_start), at(step.t_end, &step.x_end));
        let late = f64::max(step.t_start.abs(), step.t_end.abs());
        self.size = self.normal.abs().dot(size) + self.in_time.abs() * late;
        let dense = &step.dense;
        self.rise.clear();
        self.is_series = dense.series().is_some();
        let Some(series) = dense.series() else {
            let half = 0.5 * dense.h * self.in_time;
            let range = over.terms().range_along(&self.normal, half);
            let middle = self.in_time * dense.t0 + half;
            self.bound([range.low + middle, range.high + middle]);
            return;
        };
        let order = series.len() - 1;
        let c = self.rise.add((0.0, 1.0), order);
        for (c, of_state) in c[1..].iter_mut().zip(&series[1..]) {
            *c = self.normal.dot(of_state);
        }
        c[1] += dense.h * self.in_time;
        // A step that is cut is shorter than its series.
        let length = step.t_end - step.t_start;
        if (length - dense.h).abs() > TIME_ROUNDING * late {
            let (part, mut power) = (length / dense.h, 1.0);
            for c in &mut c[1..=order] {
                power *= part;
                *c *= power;
            }
        }
        let reach: f64 = c[1..=order].iter().map(|c| c.abs()).sum();
        self.bound([self.start - reach, self.start + reach]);
    }

    /// Takes bounds of the solution. The end of the step may have been moved onto a boundary.
    fn bound(&mut self, [low, high]: [f64; 2]) {
        self.range = [low.min(self.end), high.max(self.end)];
    }

    /// A function over a Taylor step that ends where its series does; `None` over another one.
    pub(super) fn function(&mut self, of: Affine) -> Option<OnSeries<'_>> {
        let rounding = STATE_ROUNDING * self.size;
        self.rise.find_turns(rounding);
        let is_whole = self.rise.ends_at(self.end - self.start, rounding);
        is_whole.then_some(OnSeries {
            series: &self.rise,
            constant: self.start + of.constant,
            start: self.start + of.constant,
            end: self.end + of.constant,
            rounding,
            is_affine: true,
        })
    }

    /// Whether a function certainly has the sign `side` throughout the step.
    pub(super) fn has_sign(&mut self, side: f64, of: Affine) -> bool {
        if self.is_beyond(side, of) {
            return true;
        }
        if !self.is_series || !self.rise.find_turns(STATE_ROUNDING * self.size) {
            return false;
        }
        let [low, high] = self.rise.range();
        self.bound([self.start + low, self.start + high]);
        self.is_beyond(side, of)
    }

    fn is_beyond(&self, side: f64, Affine { constant, .. }: Affine) -> bool {
        let [low, high] = self.range;
        let nearest = if side > 0.0 { low } else { -high };
        nearest + side * constant > STATE_ROUNDING * (constant.abs() + self.size)
    }
}
