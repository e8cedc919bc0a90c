//! Series of interpreted functions: one call serves many series.

use pulp::{Arch, NullaryFnOnce};

use super::recorded::Recorder;
use super::recording::{LinearNumber, Location, Recording, Replay};
use super::row::{Lanes, lanes};
use super::series::{Expansion, Functions, outcome, watched_rows};
use super::steps::Steps;
use super::sweep::{CoefficientRows, Sweep};
use super::{MAX_ORDER, inverse};

/// Largest number of calls that are kept for one flow. Chosen: three comparisons have eight sets of
/// results. With fewer, functions are called again; with more, more calls are tried in vain.
const MAX_CALLS: usize = 8;

/// Recorded calls of the functions of one flow, one for each set of results of their comparisons.
#[derive(Debug, Default)]
pub(crate) struct RecordedCalls<const N: usize, const W: usize> {
    calls: Vec<RecordedCall<N, W>>,
    /// Index of the call that was repeated last.
    latest: usize,
}

/// Storage for the linear numbers of a recording in `L` lanes.
pub(crate) type LinearNumbers<const L: usize> = Vec<LinearNumber<L>>;

/// One call: the recorded operations, and the locations of the results.
#[derive(Debug)]
struct RecordedCall<const N: usize, const W: usize> {
    recording: Recording,
    /// Steps for the orders above 0.
    steps: Steps,
    /// The state at the call, and how many of its components move. The others are held.
    x: [f64; N],
    dimension: usize,
    /// Whether it serves only states with the same held components.
    reads_held: bool,
    /// Whether the recording can be repeated: no value was read.
    is_complete: bool,
    field: [Location; N],
    watched: [Location; W],
    /// Whether a watched function is linear in time.
    watches_linear: bool,
    /// Number of rows taken at the end of the functions.
    taken: usize,
    /// Number of rows required.
    room: usize,
    expansion: Expansion<W>,
}

impl<const N: usize, const W: usize> RecordedCalls<N, W> {
    /// [`super::series::in_rows`] in one lane.
    pub(crate) fn expand(
        &mut self,
        into: CoefficientRows<'_, 1>,
        (t, h): (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
        order: usize,
        functions: &impl Functions<N, W>,
    ) -> Result<Expansion<W>, usize> {
        if !self.repeat_first(into, (t, h), x)? {
            let call = RecordedCall::new(into, (t, h), x, functions)?;
            self.keep(call);
        }
        let call = &self.calls[self.latest];
        expand_alone(&call.higher_orders(call.recording.alone(), into, (h, order)));
        Ok(call.expansion)
    }

    /// Expansion in several lanes. `None` if no recorded call serves all of them.
    pub(crate) fn expand_again<const L: usize>(
        &self,
        into: CoefficientRows<'_, L>,
        (t, h): (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        order: usize,
        linear_numbers: &mut LinearNumbers<L>,
    ) -> Result<Option<Expansion<W>>, usize> {
        let usable = self.in_order().map(|i| &self.calls[i]);
        for call in usable.filter(|call| call.serves(x)) {
            if call.room > into.all.len() {
                return Err(call.room);
            }
            call.recording.spread(linear_numbers);
            let sweep = sweep_of_state(into, x);
            let agrees = call
                .recording
                .repeat_first(linear_numbers, (sweep.time(t, h), x), &sweep);
            let expansion = call.expansion_by(&sweep);
            if !agrees || expansion.lanes_differ || expansion.value_read || expansion.overflowed {
                continue;
            }
            let (recording, linear_numbers) = (&call.recording, linear_numbers.as_slice());
            let higher = call.higher_orders(
                Replay {
                    recording,
                    linear_numbers,
                },
                into,
                (h, order),
            );
            higher.store_watched(&sweep);
            Arch::new().dispatch(higher);
            return Ok(Some(expansion));
        }
        Ok(None)
    }

    /// Indices of all calls, the latest first.
    fn in_order(&self) -> impl Iterator<Item = usize> + use<N, W> {
        let (latest, count) = (self.latest, self.calls.len());
        (0..count).map(move |i| (latest + i) % count)
    }

    /// Computes order 0 by repetition, if all comparisons of a call give the recorded results.
    fn repeat_first(
        &mut self,
        into: CoefficientRows<'_, 1>,
        (t, h): (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
    ) -> Result<bool, usize> {
        for i in self.in_order() {
            let call = &mut self.calls[i];
            if !call.serves(x) {
                continue;
            }
            if call.room > into.all.len() {
                return Err(call.room);
            }
            let sweep = sweep_of_state(into, x);
            let at = (sweep.time(t, h), &x[..]);
            if !call.recording.repeat_first_alone(at, &sweep) {
                continue;
            }
            let higher = call.higher_orders(call.recording.alone(), into, (h, 0));
            higher.store_watched(&sweep);
            call.expansion = call.expansion_by(&sweep);
            self.latest = i;
            return Ok(true);
        }
        Ok(false)
    }

    /// Keeps a call. It replaces one that cannot be repeated or, if there are too many, the next
    /// one after the latest.
    fn keep(&mut self, call: RecordedCall<N, W>) {
        let useless = |call: &RecordedCall<N, W>| !call.is_complete;
        self.latest = match self.calls.iter().position(useless) {
            Some(useless) => useless,
            None if self.calls.len() < MAX_CALLS => self.calls.len(),
            None => (self.latest + 1) % MAX_CALLS,
        };
        match self.calls.get_mut(self.latest) {
            Some(old) => *old = call,
            None => self.calls.push(call),
        }
    }
}

/// A sweep of order 0 that has begun with the state.
fn sweep_of_state<'a, const L: usize, const N: usize>(
    into: CoefficientRows<'a, L>,
    x: &[Lanes<L>; N],
) -> Sweep<'a, L> {
    let sweep = Sweep::new(into, 0);
    for newest in *x {
        sweep.store_next(newest);
    }
    sweep
}

impl<const N: usize, const W: usize> RecordedCall<N, W> {
    /// Computes order 0 by a recorded call of the functions.
    fn new(
        into: CoefficientRows<'_, 1>,
        (t, h): (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
        functions: &impl Functions<N, W>,
    ) -> Result<Self, usize> {
        let recorder = Recorder::new(into, (t, h));
        let sweep = &recorder.sweep;
        let time = recorder.at(Location::Linear(0), sweep.time(t, h));
        let mut state = [time; N];
        for (i, (number, newest)) in state.iter_mut().zip(*x).enumerate() {
            let moving = recorder.at(Location::InRow(i as u32), sweep.state(newest));
            *number = match i < functions.dimension() {
                true => moving,
                false => recorder.held(newest[0]),
            };
        }
        let (field, watched) = functions.at_held(time, &state);
        let taken = sweep.next_row();
        let field = field.map(|number| recorder.location(number));
        let locations = watched.map(|number| recorder.location(number));
        let watched = watched_rows(watched.map(|function| function.number));
        let mut rows = locations.iter().zip(&watched);
        let watches_linear =
            rows.any(|(location, row)| matches!(location, Location::Linear(_)) && row.is_some());
        let rows = sweep.next_row();
        let room = rows + sweep.choices.get();
        let expansion = outcome(sweep, watched, into.all.len())?;
        let is_complete = !sweep.value_read.get();
        let reads_held = recorder.reads_held.get();
        let recording = recorder.end();
        let wanted = field.into_iter().chain(locations);
        Ok(RecordedCall {
            steps: Steps::of(&recording, wanted, rows),
            recording,
            x: x.map(|[x]| x),
            dimension: functions.dimension().min(N),
            reads_held,
            is_complete,
            field,
            watched: locations,
            watches_linear,
            taken,
            room,
            expansion,
        })
    }

    /// Whether it can be repeated at a state, which has the same held components in all lanes.
    fn serves<const L: usize>(&self, x: &[Lanes<L>; N]) -> bool {
        let mut held = self.dimension..N;
        self.is_complete && (!self.reads_held || held.all(|i| x[i][0] == self.x[i]))
    }

    /// The expansion with the flags of a sweep of order 0.
    fn expansion_by<const L: usize>(&self, sweep: &Sweep<'_, L>) -> Expansion<W> {
        Expansion {
            lanes_differ: sweep.lanes_differ.get(),
            value_read: sweep.value_read.get(),
            overflowed: sweep.overflowed.get(),
            ..self.expansion
        }
    }

    fn higher_orders<'a, const L: usize>(
        &'a self,
        replay: Replay<'a, L>,
        into: CoefficientRows<'a, L>,
        (h, order): (Lanes<L>, usize),
    ) -> HigherOrders<'a, L> {
        let watched: &[Location] = if self.watches_linear {
            &self.watched
        } else {
            &[]
        };
        HigherOrders {
            replay,
            steps: &self.steps,
            into,
            h,
            order,
            field: &self.field[..self.dimension],
            held: N - self.dimension,
            watched,
            taken: self.taken,
        }
    }
}

/// The orders above 0. The number of states is not part of the type, so that this compiles once for
/// all systems.
struct HigherOrders<'a, const L: usize> {
    replay: Replay<'a, L>,
    steps: &'a Steps,
    into: CoefficientRows<'a, L>,
    h: Lanes<L>,
    order: usize,
    /// The rates of the components that move, and the number of those that are held.
    field: &'a [Location],
    held: usize,
    /// The watched functions, if one of them is linear in time.
    watched: &'a [Location],
    /// Number of rows taken at the end of the functions.
    taken: usize,
}

impl<const L: usize> HigherOrders<'_, L> {
    #[inline(always)]
    fn expand(&self) {
        let rows = self.into.all;
        for k in 1..=self.order.min(MAX_ORDER) {
            let per_order = inverse(k);
            for (location, row) in self.field.iter().zip(rows) {
                let slope = self.replay.coefficient(*location, k - 1, rows);
                row.set(k, lanes(|l| slope[l] * (self.h[l] * per_order)));
            }
            for row in rows.iter().skip(self.field.len()).take(self.held) {
                row.set(k, [0.0; L]);
            }
            self.steps.repeat(&self.replay, self.into, k);
            if !self.watched.is_empty() {
                self.store_watched(&Sweep::new(self.into, k));
            }
        }
    }

    /// Stores watched functions that are linear in time in rows, too.
    #[inline(always)]
    fn store_watched(&self, sweep: &Sweep<'_, L>) {
        sweep.rows_taken.set(self.taken);
        for location in self.watched {
            if let Location::Linear(_) = location {
                // Constants have no row.
                let _ = self.replay.number(*location, sweep).in_row();
            }
        }
    }
}

/// Expands the orders above 0 of one orbit.
#[inline(never)]
fn expand_alone<const L: usize>(higher: &HigherOrders<'_, L>) {
    higher.expand();
}

/// Expands the orders above 0 of several orbits, in the widest vectors of the machine. The width
/// changes no bit.
impl<const L: usize> NullaryFnOnce for HigherOrders<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.expand();
    }
}
