//! Series of interpreted functions: one call serves many series.

use std::cell::RefCell;

use super::inverse;
use super::pass::{Pass, Rows};
use super::recorded::Recorded;
use super::recording::{Place, Recording};
use super::row::{Lanes, lanes};
use super::series::{Expansion, Functions, outcome, watched_rows};

/// The recorded operations of the functions, and the places of the results.
#[derive(Debug)]
pub(crate) struct Repeated<const L: usize, const N: usize, const W: usize> {
    recording: RefCell<Recording<L>>,
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

impl<const L: usize, const N: usize, const W: usize> Repeated<L, N, W> {
    pub(crate) fn new() -> Self {
        Repeated {
            recording: RefCell::new(Recording::default()),
            field: [Place::Line(0); N],
            watched: [Place::Line(0); W],
            watches_lines: false,
            taken: 0,
            room: 0,
            expansion: Expansion::default(),
        }
    }

    /// Discards the recording because the functions change.
    pub(crate) fn forget(&mut self) {
        self.recording.get_mut().forget();
    }

    /// See [`super::series::in_rows`].
    pub(super) fn expand(
        &mut self,
        into: Rows<'_, L>,
        (t, h): (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        order: usize,
        functions: &impl Functions<N, W>,
    ) -> Result<Expansion<W>, usize> {
        if !self.first_again(into, (t, h), x) {
            self.first(into, (t, h), x, functions)?;
        }
        let recording = self.recording.borrow();
        for k in 1..=order {
            let pass = Pass::new(into, k);
            let per_order = inverse(k);
            for (i, place) in self.field.into_iter().enumerate() {
                let slope = recording.coefficient(place, k - 1, &pass);
                let newest = lanes(|l| slope[l] * (h[l] * per_order));
                pass.put(i, newest);
            }
            recording.repeat(&pass);
            self.keep_watched(&recording, &pass);
        }
        Ok(self.expansion)
    }

    /// Stores watched functions that are linear in time in rows, too.
    #[inline(always)]
    fn keep_watched(&self, recording: &Recording<L>, pass: &Pass<'_, L>) {
        if !self.watches_lines {
            return;
        }
        pass.taken.set(self.taken);
        for place in self.watched {
            if let Place::Line(_) = place {
                // Constants have no row.
                let _ = recording.number(place, pass).in_row();
            }
        }
    }

    /// Computes order 0 by a recorded call of the functions.
    fn first(
        &mut self,
        into: Rows<'_, L>,
        (t, h): (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        functions: &impl Functions<N, W>,
    ) -> Result<(), usize> {
        let pass = Pass::recorded(into, &self.recording);
        let time = pass.time(t, h);
        self.recording.borrow_mut().begin(time);
        let time = Recorded::at(Place::Line(0), time, &pass);
        let mut state = [time; N];
        for (i, (number, newest)) in state.iter_mut().zip(*x).enumerate() {
            *number = Recorded::at(Place::Row(i as u32), pass.state(newest), &pass);
        }
        let (field, watched) = functions.at(time, &state);
        self.taken = pass.next();
        let mut recording = self.recording.borrow_mut();
        for (place, number) in self.field.iter_mut().zip(field) {
            *place = recording.place(number);
        }
        for (place, number) in self.watched.iter_mut().zip(watched) {
            *place = recording.place(number);
        }
        let watched = watched_rows(watched.map(|function| function.number));
        let mut rows = self.watched.iter().zip(&watched);
        self.watches_lines =
            rows.any(|(place, row)| matches!(place, Place::Line(_)) && row.is_some());
        self.room = pass.next() + pass.choices.get();
        self.expansion = outcome(&pass, watched, into.all.len())?;
        recording.end(self.field.into_iter().chain(self.watched), &pass);
        Ok(())
    }

    /// Computes order 0 by repetition, if all comparisons give the recorded results.
    fn first_again(
        &mut self,
        into: Rows<'_, L>,
        (t, h): (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
    ) -> bool {
        if !self.recording.get_mut().is_complete() || self.room > into.all.len() {
            return false;
        }
        let pass = Pass::new(into, 0);
        for newest in *x {
            pass.state(newest);
        }
        let is_alike = self
            .recording
            .get_mut()
            .repeat_first(pass.time(t, h), &pass);
        self.keep_watched(&self.recording.borrow(), &pass);
        self.expansion.divided = pass.divided.get();
        self.expansion.value_read = pass.value_read.get();
        self.expansion.overflowed = pass.overflowed.get();
        is_alike
    }
}
