//! The search for the user's own events, a step at a time.

use std::ops::ControlFlow;

use super::affine::{Affine, SeriesZero, Slopes};
use super::composed::ComposedSeries;
use super::crossings::Crossings;
use super::over_step::{OverStep, SampledStep};
use super::{Direction, EventFunctions, EventRecord};
use crate::filippov::flow::{Flow, GUARDS, flow_path, gradient};
use crate::filippov::integration::Integration;
use crate::filippov::observer::StepRecord;
use crate::filippov::options::{Method, Options};
use crate::filippov::rules::LieDerivatives;
use crate::filippov::switched::{Switched, UseFlow};
use crate::filippov::uncertainty::STATE_ROUNDING;
use crate::ode::Timed;
use crate::system::{Mode, State, components};

/// Whether a function stands at a zero. It is compared with the value there, which location and
/// rounding leave, until it has the sign that it left with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Standing {
    /// No longer.
    #[default]
    Left,
    /// Stands at its value where the next step begins; location leaves this much at most.
    AtStart(f64),
    /// Stands at this value.
    At(f64),
    /// Has left this value.
    Leaving(f64),
}

/// Searches for zeros of the user's functions in the steps of a run that something else drives. An
/// [`crate::Observer`] owns one and gives it every step. A loop over [`crate::Integration::step`]
/// gives it [`crate::Integration::last_step`].
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use std::ops::ControlFlow;
/// use stickslip::analysis::{Spectrum, SpectrumOptions};
/// use stickslip::{Direction, EventFunctions, EventSearch, Observer, Options, StepRecord};
///
/// /// Where the block turns back.
/// struct Turn;
/// impl EventFunctions<2> for Turn {
///     fn value<T: Scalar>(&self, _number: usize, _t: T, x: &[T; 2]) -> T {
///         x[1]
///     }
///     fn direction(&self, _number: usize) -> Direction {
///         Direction::Falling
///     }
/// }
///
/// /// Returns to a section, counted while exponents are measured.
/// struct Returns<'a>(EventSearch<'a, Belt, Turn, 2>, usize);
/// impl Observer<2> for Returns<'_> {
///     fn step(&mut self, step: &StepRecord<2>) -> ControlFlow<()> {
///         self.1 += self.0.in_step(step).len();
///         ControlFlow::Continue(())
///     }
/// }
///
/// let belt = Belt { speed: 0.2 };
/// let settings = SpectrumOptions::over(50.0, 500.0);
/// let mut returns = Returns(EventSearch::new(&belt, Turn, &settings.solver), 0);
/// Spectrum::watched(&belt, (0.0, [0.5, 0.1]), &settings, &mut returns)?;
/// assert!(returns.1 > 10);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub struct EventSearch<'a, S: Switched<N, G>, V, const N: usize, const G: usize = GUARDS> {
    system: &'a S,
    events: V,
    method: Method,
    /// Knowledge of each function at the end of the last step, and at its start.
    known: Vec<Known>,
    known_before: Vec<Known>,
    /// Each function that is affine, and the slopes that these have. Behind them come those of the
    /// others over the last step.
    affine: Vec<Option<Affine>>,
    slopes: Vec<Slopes<N>>,
    /// Number of slopes of affine functions.
    of_affine: usize,
    composed: ComposedSeries<N>,
    /// Room for the zeros of a function.
    zeros: Vec<SeriesZero>,
    /// Recent size of the state's components, and that at the start of the last step.
    size: State<N>,
    size_before: State<N>,
    last_events: Vec<EventRecord<N, S::Mode>>,
    /// Whether the search ends at the first event of each function in a step.
    only_first: bool,
}

/// A search between two steps: what is known of each function, and the recent size of the state's
/// components.
pub(crate) type SearchMemory = (Vec<Known>, Vec<f64>);

/// Signs of a function over the steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Known {
    /// Last sign of the function; 0 while unknown.
    side: f64,
    standing: Standing,
}

impl<'a, S, V, const N: usize, const G: usize> EventSearch<'a, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    /// A search through successive steps of one run of `system` with `options`, from any step on.
    pub fn new(system: &'a S, events: V, options: &Options) -> Self {
        let (affine, slopes) = Slopes::of(&events);
        EventSearch {
            system,
            known: vec![Known::default(); events.count()],
            known_before: Vec::new(),
            composed: ComposedSeries::of(&affine),
            of_affine: slopes.len(),
            affine,
            slopes,
            zeros: Vec::new(),
            events,
            method: options.method,
            size: State::zeros(),
            size_before: State::zeros(),
            last_events: Vec::new(),
            only_first: false,
        }
    }

    /// A search for only the first event of each function in a step.
    pub(crate) fn only_first(self) -> Self {
        let only_first = true;
        EventSearch { only_first, ..self }
    }

    /// The events in the next step of the run, in order of time. Terminal events are not treated
    /// specially.
    #[inline]
    pub fn in_step(&mut self, step: &StepRecord<N, S::Mode>) -> &[EventRecord<N, S::Mode>] {
        self.last_events.clear();
        self.known_before.clone_from(&self.known);
        self.size_before = self.size;
        // A step of length zero holds nothing that the next one does not.
        if step.t_end > step.t_start {
            self.search(step);
        }
        &self.last_events
    }

    /// The events of the last step.
    pub(crate) fn last_events(&self) -> &[EventRecord<N, S::Mode>] {
        &self.last_events
    }

    /// Keeps the first events of the last step only.
    pub(super) fn truncate(&mut self, count: usize) {
        self.last_events.truncate(count);
    }

    /// Records the size of the components over a step.
    fn note_size(&mut self, [start, end]: [&State<N>; 2]) {
        for i in 0..N {
            let now = f64::max(start[i].abs(), end[i].abs());
            self.size[i] = now.max(0.5 * self.size[i]);
        }
    }

    fn search(&mut self, step: &StepRecord<N, S::Mode>) {
        self.note_size([&step.x_start, &step.x_end]);
        let sampled = SampledStep::new(step);
        for slopes in &mut self.slopes[..self.of_affine] {
            slopes.follow(&sampled, &self.size);
        }
        let functions = (&self.events, self.system.dimension());
        let slopes = (&mut self.slopes, self.of_affine);
        self.composed.follow(step, functions, &self.size, slopes);
        // A slide is settled on its boundary, from which its series drifts.
        let slides = S::of_contacts(&step.mode).contains(&Mode::Stick);
        for number in 0..self.known.len() {
            let Known { side, standing } = &mut self.known[number];
            let is_affine = self.affine[number].is_some();
            let series = self.affine[number].or_else(|| self.composed.function(number));
            let series = series.filter(|_| *side != 0.0);
            if let (Standing::Leaving(_), Some(of)) = (*standing, series)
                && self.slopes[of.slopes].has_left(*side, of)
            {
                *standing = Standing::Left;
            }
            let (side, standing) = (*side, *standing);
            let has_left = side != 0.0 && matches!(standing, Standing::Left);
            if let Some(of) = series
                && has_left
                && self.slopes[of.slopes].has_sign(side, of)
            {
                continue;
            }
            let over = OverStep {
                system: self.system,
                events: &self.events,
                number,
                dimension: self.system.dimension(),
                over: &sampled,
                method: self.method,
                size: &self.size,
                zero: 0.0,
            };
            let has_zeros = series.is_some_and(|of| {
                let begins = matches!(standing, Standing::AtStart(_));
                !slides
                    && (has_left || begins)
                    && self.slopes[of.slopes].find_zeros((side, begins), of, &mut self.zeros)
            });
            if !has_zeros && has_left && !is_affine && over.is_clear_throughout(side) {
                continue;
            }
            let (requested, only_first) = (self.events.direction(number), self.only_first);
            let events = &mut self.last_events;
            let mut report = |at: &Timed<N>, rate: f64, direction: Direction| {
                events.push(EventRecord {
                    number,
                    t: at.t,
                    x: at.x,
                    mode: step.mode,
                    direction,
                    rate,
                });
                match only_first {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            };
            let mut crossings = Crossings::<S, V, _, N, G>::new(over, side);
            if let Some(of) = series.filter(|_| has_zeros) {
                let slopes = &self.slopes[of.slopes];
                for zero in &self.zeros {
                    let direction = Direction::leaving(crossings.side);
                    // The state before a jump is as near to the zero as single values are, and a
                    // series leaves a part of a function out that is not affine.
                    let by_values = only_first || !is_affine;
                    let located = match (requested.includes(direction), by_values) {
                        (false, _) => None,
                        (true, true) => {
                            let probe = crossings.newton(zero.between, slopes.part(zero.s, step));
                            Some((probe.at, probe.rate))
                        }
                        (true, false) => slopes.at(*zero, step),
                    };
                    crossings.side = -crossings.side;
                    if let Some((at, rate)) = located
                        && report(&at, rate, direction).is_break()
                    {
                        break;
                    }
                }
                self.known[number] = Known {
                    side: crossings.side,
                    standing: Standing::Left,
                };
                continue;
            }
            let standing = crossings.stand(standing);
            let _ = crossings.each(
                &mut |probe, direction| match requested.includes(direction) {
                    true => report(&probe.at, probe.rate, direction),
                    false => ControlFlow::Continue(()),
                },
            );
            self.known[number] = Known {
                side: crossings.side,
                standing: match standing {
                    Standing::At(zero) if !crossings.stands => Standing::Leaving(zero),
                    standing => standing,
                },
            };
        }
        self.last_events
            .sort_by(|one, other| (one.t.total_cmp(&other.t)).then(one.number.cmp(&other.number)));
    }
}

/// The sign with which an event function leaves zero along a flow.
struct Departing<'a, V, const N: usize> {
    events: &'a V,
    number: usize,
    at: Timed<N>,
    slack: f64,
}

impl<V: EventFunctions<N>, const N: usize> UseFlow<N> for Departing<'_, V, N> {
    type Output = LieDerivatives;

    fn with<F: Flow<N>>(self, flow: &F) -> LieDerivatives {
        let here = (self.at.t, &self.at.x, flow.dimension());
        let [lie] = LieDerivatives::along(here, self.slack, |t, x| {
            let path = flow_path(t, x, |t, x| flow.field(t, x));
            [self.events.value(self.number, path.0, &path.1)]
        });
        lie
    }
}

/// The errors of a run may add up to so many tolerances. Chosen: a state that stands closer behind
/// a zero than this is taken for one at the zero.
pub(crate) const TOLERATED: f64 = 100.0;

/// The sign of a sum of parts of this size, beyond rounding.
fn clear_sign(value: f64, size: f64) -> f64 {
    if value.abs() > STATE_ROUNDING * size {
        value.signum()
    } else {
        0.0
    }
}

impl<S, V, const N: usize, const G: usize> EventSearch<'_, S, V, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
{
    /// The search between two steps.
    pub(crate) fn memory(&self) -> SearchMemory {
        (self.known.clone(), self.size.as_slice().to_vec())
    }

    /// Goes on as the search of a memory. Returns whether it is one of the same functions.
    pub(crate) fn restore(&mut self, (known, size): &SearchMemory) -> bool {
        let is_same = known.len() == self.known.len() && size.len() == N;
        if is_same {
            self.known.clone_from(known);
            self.size = State::from_column_slice(size);
        }
        is_same
    }

    /// Last sign of a function; 0 while unknown.
    pub(crate) fn side(&self, number: usize) -> f64 {
        self.known[number].side
    }

    /// Gradient of a function in the state, and its time derivative.
    fn slopes(&self, number: usize, at: &Timed<N>) -> (State<N>, f64) {
        let value = |t, x: &_| self.events.value(number, t, x);
        gradient(value, at, self.system.dimension())
    }

    /// The sign of a function at a moment; 0 where it may be rounding, or is within what is `left`
    /// of its zero by location, and by a distance of the state from a manifold.
    pub(crate) fn sign_beyond(
        &self,
        number: usize,
        (left, distance): (f64, f64),
        at: &Timed<N>,
    ) -> f64 {
        let value = self.events.value(number, at.t, components(&at.x));
        let (slopes, _) = self.slopes(number, at);
        match value.abs() <= left + slopes.abs().sum() * distance {
            true => 0.0,
            false => self.sign_at(number, at),
        }
    }

    /// The sign of a function at a moment; 0 where it may be rounding.
    pub(crate) fn sign_at(&self, number: usize, at: &Timed<N>) -> f64 {
        let value = self.events.value(number, at.t, components(&at.x));
        let (slopes, in_time) = self.slopes(number, at);
        let size = self.size.sup(&at.x.abs());
        clear_sign(value, slopes.abs().dot(&size) + in_time.abs() * at.t.abs())
    }

    /// Largest distance from zero to which errors within the tolerance may move a function.
    pub(crate) fn tolerated(&self, number: usize, at: &Timed<N>, options: &Options) -> f64 {
        let (slopes, _) = self.slopes(number, at);
        let size = self.size.sup(&at.x.abs());
        let error = State::from_fn(|i, _| options.allowed(i, size[i]));
        TOLERATED * slopes.abs().dot(&error)
    }

    /// The sign of a function's rate where the state moves with this velocity.
    pub(crate) fn sign_of_rate(&self, number: usize, at: &Timed<N>, velocity: &State<N>) -> f64 {
        let (slopes, in_time) = self.slopes(number, at);
        let size = slopes.abs().dot(&velocity.abs()) + in_time.abs();
        clear_sign(slopes.dot(velocity) + in_time, size)
    }

    /// The sign of a function that is at zero, as soon as the motion has left the present state; 0
    /// where the first three derivatives vanish. Components of the state are known up to `slack`.
    pub(crate) fn sign_of_departure(
        &self,
        (number, slack): (usize, f64),
        integration: &Integration<'_, S, N, G>,
    ) -> f64 {
        let departing = Departing {
            events: &self.events,
            number,
            slack,
            at: integration.at(),
        };
        integration.with_flow(departing).leading(false).1
    }

    /// Whether a function that leaves zero at a moment comes back from a height that is rounding.
    pub(crate) fn hardly_rises(
        &self,
        number: usize,
        at: &Timed<N>,
        integration: &Integration<'_, S, N, G>,
    ) -> bool {
        let (events, slack, at) = (&self.events, 0.0, *at);
        let departing = Departing {
            events,
            number,
            at,
            slack,
        };
        let [_, rate, bend, _] = integration.with_flow(departing).values;
        let (slopes, in_time) = self.slopes(number, &at);
        let size = self.size.sup(&at.x.abs());
        let size = slopes.abs().dot(&size) + in_time.abs() * at.t.abs();
        rate * rate <= 2.0 * bend.abs() * STATE_ROUNDING * size
    }

    /// Whether a component that the run changes moves a function: by itself, or by jumps.
    pub(crate) fn depends_on_state(
        &self,
        number: usize,
        at: &Timed<N>,
        jumps: impl Fn(usize) -> bool,
    ) -> bool {
        let value = |t, x: &_| self.events.value(number, t, x);
        let (slopes, _) = gradient(value, at, N);
        let moves = |i: usize| i < self.system.dimension() || jumps(i);
        (0..N).any(|i| slopes[i] != 0.0 && moves(i))
    }

    /// Forgets the part of the last step after the state at which the step is cut.
    pub(crate) fn cut(&mut self, start: &State<N>, at: &State<N>) {
        for (known, before) in self.known.iter_mut().zip(&self.known_before) {
            known.side = before.side;
            // It may have left after that state.
            if let (Standing::AtStart(_) | Standing::At(_), Standing::Leaving(zero)) =
                (before.standing, known.standing)
            {
                known.standing = Standing::At(zero);
            }
        }
        self.size = self.size_before;
        self.note_size([start, at]);
    }

    /// Sets the last sign of all functions; 0 if the state starts anew.
    pub(crate) fn set_sides(&mut self, side: f64) {
        (0..self.known.len()).for_each(|number| self.set_side(number, side));
    }

    /// Sets the last sign of a function.
    pub(crate) fn set_side(&mut self, number: usize, side: f64) {
        self.known[number] = Known {
            side,
            standing: Standing::Left,
        };
    }

    /// A function stands at zero, of which location leaves this much at most, and leaves it with
    /// this sign, as far as that is known.
    pub(crate) fn stand_at_zero(&mut self, number: usize, left: f64, side: f64) {
        self.known[number] = Known {
            side,
            standing: Standing::AtStart(left),
        };
    }

    /// Remainder of the zero at which a function stands, as location leaves it.
    pub(crate) fn left_of_zero(&self, number: usize) -> f64 {
        match self.known[number].standing {
            Standing::AtStart(left) | Standing::At(left) => left.abs(),
            Standing::Left | Standing::Leaving(_) => 0.0,
        }
    }

    /// Whether a function stood at a zero where the last step began.
    pub(crate) fn stood_at_zero(&self, number: usize) -> bool {
        let before = self.known_before.get(number).map(|known| known.standing);
        matches!(before, Some(Standing::AtStart(_) | Standing::At(_)))
    }

    /// Whether a function has not left its last zero.
    pub(crate) fn stands_at_zero(&self, number: usize) -> bool {
        let standing = self.known[number].standing;
        matches!(standing, Standing::AtStart(_) | Standing::At(_))
    }
}
