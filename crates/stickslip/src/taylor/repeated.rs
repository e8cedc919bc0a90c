//! Series of interpreted functions: one call serves many series.

use std::cell::RefCell;

use pulp::{Arch, NullaryFnOnce};

use super::pass::{Pass, Rows};
use super::recorded::Recorded;
use super::recording::{Line, Place, Recording, Replay};
use super::row::{Lanes, lanes};
use super::series::{Expansion, Functions, outcome, watched_rows};
use super::{MOST_ORDER, inverse};

/// Maximum number of calls that are kept for one flow.
const MOST_CALLS: usize = 8;

/// Recorded calls of the functions of one flow, one for each set of results of their comparisons.
#[derive(Debug, Default)]
pub(crate) struct Repeated<const N: usize, const W: usize> {
    calls: Vec<RecordedCall<N, W>>,
    /// Index of the call that was repeated last.
    latest: usize,
}

/// Storage for the lines of a recording in `L` lanes.
pub(crate) type Lines<const L: usize> = Vec<Line<L>>;

/// One call: the recorded operations, and the places of the results.
#[derive(Debug)]
struct RecordedCall<const N: usize, const W: usize> {
    recording: Recording,
    field: [Place; N],
    watched: [Place; W],
    /// Whether a watched function is linear in time.
    watches_lines: bool,
    /// Number of rows taken at the end of the functions.
    taken: usize,
    /// Number of rows required.
    room: usize,
    expansion: Expansion<W>,
}

impl<const N: usize, const W: usize> Repeated<N, W> {
    /// As [`super::series::in_rows`], in one lane.
    pub(crate) fn expand(
        &mut self,
        into: Rows<'_, 1>,
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
        expand_alone(&call.above(call.recording.alone(), into, (h, order)));
        Ok(call.expansion)
    }

    /// The same in several lanes. `None` if no recorded call serves all of them.
    pub(crate) fn expand_again<const L: usize>(
        &self,
        into: Rows<'_, L>,
        (t, h): (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        order: usize,
        lines: &mut Lines<L>,
    ) -> Result<Option<Expansion<W>>, usize> {
        let usable = self.in_order().map(|i| &self.calls[i]);
        for call in usable.filter(|call| call.recording.is_complete()) {
            if call.room > into.all.len() {
                return Err(call.room);
            }
            call.recording.spread(lines);
            let pass = pass_of_state(into, x);
            let is_alike = call.recording.repeat_first(lines, pass.time(t, h), &pass);
            let expansion = call.expansion_by(&pass);
            if !is_alike || expansion.divided || expansion.value_read || expansion.overflowed {
                continue;
            }
            let (recording, lines) = (&call.recording, lines.as_slice());
            let above = call.above(Replay { recording, lines }, into, (h, order));
            above.keep_watched(&pass);
            Arch::new().dispatch(above);
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
        into: Rows<'_, 1>,
        (t, h): (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
    ) -> Result<bool, usize> {
        for i in self.in_order() {
            let call = &mut self.calls[i];
            if !call.recording.is_complete() {
                continue;
            }
            if call.room > into.all.len() {
                return Err(call.room);
            }
            let pass = pass_of_state(into, x);
            let time = pass.time(t, h);
            if !call.recording.repeat_first_alone(time, &pass) {
                continue;
            }
            let above = call.above(call.recording.alone(), into, (h, 0));
            above.keep_watched(&pass);
            call.expansion = call.expansion_by(&pass);
            self.latest = i;
            return Ok(true);
        }
        Ok(false)
    }

    /// Keeps a call. It replaces one that cannot be repeated or, if there are too many, the next
    /// one after the latest.
    fn keep(&mut self, call: RecordedCall<N, W>) {
        let useless = |call: &RecordedCall<N, W>| !call.recording.is_complete();
        self.latest = match self.calls.iter().position(useless) {
            Some(useless) => useless,
            None if self.calls.len() < MOST_CALLS => self.calls.len(),
            None => (self.latest + 1) % MOST_CALLS,
        };
        match self.calls.get_mut(self.latest) {
            Some(old) => *old = call,
            None => self.calls.push(call),
        }
    }
}

/// A pass of order 0 that has begun with the state.
fn pass_of_state<'a, const L: usize, const N: usize>(
    into: Rows<'a, L>,
    x: &[Lanes<L>; N],
) -> Pass<'a, L> {
    let pass = Pass::new(into, 0);
    for newest in *x {
        pass.keep(newest);
    }
    pass
}

impl<const N: usize, const W: usize> RecordedCall<N, W> {
    /// Computes order 0 by a recorded call of the functions.
    fn new(
        into: Rows<'_, 1>,
        (t, h): (Lanes<1>, Lanes<1>),
        x: &[Lanes<1>; N],
        functions: &impl Functions<N, W>,
    ) -> Result<Self, usize> {
        let recording = RefCell::new(Recording::default());
        let pass = Pass::recorded(into, &recording);
        let time = pass.time(t, h);
        *recording.borrow_mut() = Recording::begin(time);
        let time = Recorded::at(Place::Line(0), time, &pass);
        let mut state = [time; N];
        for (i, (number, newest)) in state.iter_mut().zip(*x).enumerate() {
            *number = Recorded::at(Place::Row(i as u32), pass.state(newest), &pass);
        }
        let (field, watched) = functions.at(time, &state);
        let taken = pass.next();
        let (field, places) = {
            let mut recording = recording.borrow_mut();
            let mut place = |number| recording.place(number);
            (field.map(&mut place), watched.map(&mut place))
        };
        let watched = watched_rows(watched.map(|function| function.number));
        let mut rows = places.iter().zip(&watched);
        let watches_lines =
            rows.any(|(place, row)| matches!(place, Place::Line(_)) && row.is_some());
        let room = pass.next() + pass.choices.get();
        let expansion = outcome(&pass, watched, into.all.len())?;
        let wanted = field.into_iter().chain(places);
        recording.borrow_mut().end(wanted, &pass);
        Ok(RecordedCall {
            field,
            watched: places,
            watches_lines,
            taken,
            room,
            expansion,
            recording: recording.take(),
        })
    }

    /// The expansion with the flags of a pass of order 0.
    fn expansion_by<const L: usize>(&self, pass: &Pass<'_, L>) -> Expansion<W> {
        Expansion {
            divided: pass.divided.get(),
            value_read: pass.value_read.get(),
            overflowed: pass.overflowed.get(),
            ..self.expansion
        }
    }

    fn above<'a, const L: usize>(
        &'a self,
        replay: Replay<'a, L>,
        into: Rows<'a, L>,
        (h, order): (Lanes<L>, usize),
    ) -> Above<'a, L> {
        let watched: &[Place] = if self.watches_lines {
            &self.watched
        } else {
            &[]
        };
        Above {
            replay,
            into,
            h,
            order,
            field: &self.field,
            watched,
            taken: self.taken,
        }
    }
}

/// The orders above 0. The number of states is not part of the type, so that this compiles once for
/// all systems.
struct Above<'a, const L: usize> {
    replay: Replay<'a, L>,
    into: Rows<'a, L>,
    h: Lanes<L>,
    order: usize,
    field: &'a [Place],
    /// The watched functions, if one of them is linear in time.
    watched: &'a [Place],
    /// Number of rows taken at the end of the functions.
    taken: usize,
}

impl<const L: usize> Above<'_, L> {
    #[inline(always)]
    fn expand(&self) {
        let rows = self.into.all;
        for k in 1..=self.order.min(MOST_ORDER) {
            let per_order = inverse(k);
            for (place, row) in self.field.iter().zip(rows) {
                let slope = self.replay.coefficient(*place, k - 1, rows);
                row.set(k, lanes(|l| slope[l] * (self.h[l] * per_order)));
            }
            self.replay.repeat(self.into, k);
            if !self.watched.is_empty() {
                self.keep_watched(&Pass::new(self.into, k));
            }
        }
    }

    /// Stores watched functions that are linear in time in rows, too.
    #[inline(always)]
    fn keep_watched(&self, pass: &Pass<'_, L>) {
        pass.taken.set(self.taken);
        for place in self.watched {
            if let Place::Line(_) = place {
                // Constants have no row.
                let _ = self.replay.number(*place, pass).in_row();
            }
        }
    }
}

/// Expands the orders above 0 of one orbit.
#[inline(never)]
fn expand_alone<const L: usize>(above: &Above<'_, L>) {
    above.expand();
}

/// Expands the orders above 0 of several orbits, in the widest vectors of the machine. The width
/// changes no bit.
impl<const L: usize> NullaryFnOnce for Above<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.expand();
    }
}
