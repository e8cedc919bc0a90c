//! The equations for a periodic orbit as segments, with their derivatives by the unknowns.

use super::pieces::{Map, Piece};
use super::shooting::{Extra, ULPS};
use super::{Margin, MarginKind, Outline, Segment, Shooting, unit};
use crate::dynamics::{Matrix, Moment, Vector};
use crate::filippov::Options;
use crate::system::Mode;

/// An equation: its residual, its derivative by the unknowns, and its change per unit of length.
type Row = (f64, Vector, f64);

/// The beginning of a piece, and the derivatives of state and time there by the unknowns.
struct Base {
    segment: usize,
    at: Moment,
    of_state: Matrix,
    of_time: Vector,
}

/// The elements of one traversal, so far.
struct Assembly<'a> {
    shooting: &'a Shooting<'a>,
    outline: &'a Outline,
    options: &'a Options,
    at: Moment,
    /// Derivatives of state and time by the unknowns.
    of_state: Matrix,
    of_time: Vector,
    bases: Vec<Base>,
    pieces: Vec<Piece>,
    /// The derivatives of the flow over each piece, followed by saltation.
    maps: Vec<Map>,
    rows: Vec<Row>,
    growth: f64,
}

impl Assembly<'_> {
    /// Index of the time at the beginning among the unknowns, if it is one.
    fn time(&self) -> usize {
        self.outline.begin.x.len() + self.outline.segments.len()
    }

    /// Integrates a part of a segment.
    fn through(&mut self, number: usize, share: f64) -> Option<Piece> {
        let segment = &self.outline.segments[number];
        let n = self.at.x.len();
        let piece = self.shooting.piece(
            segment,
            self.at.clone(),
            share * segment.duration,
            self.options,
        )?;
        self.bases.push(Base {
            segment: number,
            at: self.at.clone(),
            of_state: self.of_state.clone(),
            of_time: self.of_time.clone(),
        });
        let map = self.shooting.carried(segment, &piece);
        let whole = map.whole();
        let base = (&self.of_state, &self.of_time);
        self.of_state = self.shooting.moved(segment, &piece, &whole, base);
        self.of_time[n + number] += share;
        // Longer by its share of the duration.
        for (i, rate) in map.velocity.iter().enumerate() {
            self.of_state[(i, n + number)] += rate * share;
        }
        self.growth = self.growth.max(self.of_state.amax()).max(whole.amax());
        self.maps.push(map);
        self.at = piece.end.clone();
        Some(piece)
    }

    /// Makes the state at a cut with this number an unknown, which the incoming state must equal.
    fn cut(&mut self, number: usize) -> Option<()> {
        let state = self.outline.cut.as_ref()?.states.get(number)?;
        let n = state.len();
        let place = self.time() + 1 + number * n;
        let mut by_cut = Matrix::zeros(n, self.of_state.ncols());
        by_cut.columns_mut(place, n).fill_with_identity();
        let gap = &self.at.x - state;
        let rows = &self.of_state - &by_cut;
        for i in 0..n {
            self.rows.push((gap[i], rows.row(i).transpose(), 1.0));
        }
        self.of_state = by_cut;
        self.at.x.clone_from(state);
        Some(())
    }

    /// The derivative of a function at a moment by the unknowns, from its gradient in the state and
    /// in time.
    fn row(
        &self,
        value: f64,
        (gradient, in_time): (&Vector, f64),
        base: (&Matrix, &Vector),
    ) -> Row {
        let row = base.0.tr_mul(gradient) + base.1 * in_time;
        // Scaled as if the orbit moved by its extent in a period.
        let by_time = in_time.abs() * self.outline.period() / self.shooting.extent;
        (
            value,
            row,
            gradient.norm().max(by_time).max(f64::MIN_POSITIVE),
        )
    }

    /// The event at the end of a segment.
    fn event(&mut self, number: usize) -> Option<Row> {
        let outline = self.outline;
        let segment = &outline.segments[number];
        let event = segment.end?;
        let system = self.shooting.system;
        let flow = system.flow(segment.mode, &segment.inside);
        let velocity = flow.velocity(&self.at);
        let (value, (gradient, in_time)) = match event.at_kink {
            Some((input, reading)) => {
                let (now, gradient, in_time) = system.clock(input, &self.at);
                (now - reading, (gradient, in_time))
            }
            None => (
                flow.guard(event.guard, &self.at),
                flow.guard_gradient(event.guard, &self.at),
            ),
        };
        let next = &outline.segments[(number + 1) % outline.segments.len()];
        let next = system.flow(next.mode, &next.inside);
        let rate = in_time + gradient.dot(&velocity);
        if event.is_of_jump {
            let row = self.row(value, (&gradient, in_time), (&self.of_state, &self.of_time));
            let reset = system.reset(event.contact, &self.at);
            self.at.x = reset.after;
            self.of_state =
                &reset.by_state * &self.of_state + &reset.by_time * self.of_time.transpose();
            let after = next.velocity(&self.at);
            let kick = &after - &reset.by_state * &velocity - &reset.by_time;
            if let Some(map) = self.maps.last_mut() {
                map.reset(&reset.by_state, (&kick, &gradient, rate), after);
            }
            return Some(row);
        }
        let kick = next.velocity(&self.at) - &velocity;
        if kick.amax() > f64::EPSILON * velocity.amax()
            && let Some(map) = self.maps.last_mut()
        {
            map.salted(&kick, &gradient, rate);
        }
        Some(self.row(value, (&gradient, in_time), (&self.of_state, &self.of_time)))
    }

    /// The equation that a margin is zero.
    fn margin(&self, wanted: &Margin) -> Option<Row> {
        let (shooting, outline) = (self.shooting, self.outline);
        let found = shooting.margins(outline, &self.pieces);
        let margin = wanted.like(&found, outline.period())?;
        let number = margin.part;
        if margin.kind == MarginKind::Duration {
            let row = unit(self.of_time.len(), self.at.x.len() + number);
            return Some((margin.value, row, 1.0));
        }
        let bases = self.bases.iter().rev();
        let mut bases = bases.filter(|base| base.segment == number && base.at.t <= margin.at.t);
        let base = bases.next()?;
        let segment = &outline.segments[number];
        let (flow, guard, sign) = match margin.kind {
            MarginKind::Minimum(guard) | MarginKind::Begin(guard) => (
                shooting.system.flow(segment.mode, &segment.inside),
                guard,
                1.0,
            ),
            MarginKind::Landing => {
                let (stuck, guard) = margin.landing(shooting.system)?;
                let sticks = segment.mode.get(margin.contact) == Mode::Stick;
                (stuck, guard, if sticks { 1.0 } else { -1.0 })
            }
            _ => return None,
        };
        let (gradient, in_time) = flow.guard_gradient(guard, &margin.at);
        let after = margin.at.t - base.at.t;
        let piece = shooting.piece(segment, base.at.clone(), after, self.options)?;
        let whole = shooting.carried(segment, &piece).whole();
        // A minimum is stationary in the time at which it is taken.
        let there = (&base.of_state, &base.of_time);
        let of_state = shooting.moved(segment, &piece, &whole, there);
        let (value, row, size) = self.row(
            margin.value,
            (&gradient, in_time),
            (&of_state, &base.of_time),
        );
        Some((value, row * sign, size))
    }
}

/// The equations evaluated at some unknowns.
pub(super) struct Equations {
    /// The residuals, as they are and in units of length.
    pub left: Vector,
    pub off: f64,
    /// Their derivative by the unknowns.
    pub jacobian: Matrix,
    pub pieces: Vec<Piece>,
    pub monodromy: Matrix,
    /// Where the orbit is cut.
    pub anchor: Moment,
    /// The vectors that move the orbit at its beginning and at its end.
    pub velocities: [Vector; 2],
    /// Residual that rounding may leave.
    pub rounding: f64,
    pub steps: usize,
}

impl Shooting<'_> {
    /// Integrates the segments. `guess` is where the iteration began; an orbit without transitions
    /// does not move along the flow from there.
    pub(super) fn equations(
        &self,
        outline: &Outline,
        guess: &Outline,
        options: &Options,
    ) -> Option<Equations> {
        let n = outline.begin.x.len();
        let cut = outline.cut.as_ref()?;
        let count = outline.segments.len();
        let time = n + count;
        let unknowns = time + 1 + n * cut.states.len();
        let mut assembly = Assembly {
            shooting: self,
            outline,
            options,
            at: outline.begin.clone(),
            of_state: Matrix::identity(n, unknowns),
            of_time: unit(unknowns, time),
            bases: Vec::new(),
            pieces: Vec::new(),
            maps: Vec::new(),
            rows: Vec::new(),
            growth: 1.0,
        };
        let velocity = |segment: &Segment, at: &Moment| {
            let flow = self.system.flow(segment.mode, &segment.inside);
            flow.velocity(at)
        };
        let begins = velocity(outline.segments.first()?, &outline.begin);
        let mut at_cut = Vector::zeros(n);
        let mut anchor = outline.begin.clone();
        let mut events = Vec::new();
        for number in 0..count {
            if number > 0 {
                assembly.cut(number - 1)?;
            }
            let piece = if number == cut.number {
                let first = assembly.through(number, 0.5)?;
                assembly.cut(count - 1)?;
                anchor = assembly.at.clone();
                at_cut = velocity(&outline.segments[number], &anchor);
                first.followed_by(assembly.through(number, 0.5)?)
            } else {
                assembly.through(number, 1.0)?
            };
            assembly.pieces.push(piece);
            events.extend(assembly.event(number));
        }
        let ends = assembly.maps.last()?.velocity.clone();
        let gap = &assembly.at.x - &outline.begin.x;
        for i in 0..self.states {
            let row = assembly.of_state.row(i).transpose() - unit(unknowns, i);
            assembly.rows.push((gap[i], row, 1.0));
        }
        let has_events = !events.is_empty();
        assembly.rows.extend(events);
        // The time at the beginning is unknown if the forcing depends on it and an event occurs
        // there.
        if let Some(period) = self.forced {
            let is_duration = |i: usize| i >= n && i < time;
            let row = Vector::from_fn(unknowns, |i, _| f64::from(u8::from(is_duration(i))));
            assembly.rows.push((outline.period() - period, row, 1.0));
        }
        if self.forced.is_none() || !has_events {
            let off = outline.begin.t - guess.begin.t;
            assembly.rows.push((off, unit(unknowns, time), 1.0));
        }
        if self.forced.is_none() && !has_events {
            let along = begins.rows(0, self.states);
            let way = &outline.begin.x - &guess.begin.x;
            let value = along.dot(&way.rows(0, self.states));
            let row = along.into_owned().resize_vertically(unknowns, 0.0);
            assembly.rows.push((value, row, f64::INFINITY));
        }
        let extra = match self.extra {
            Extra::None => None,
            Extra::Plane(row, value) => {
                let row = row.clone().resize_vertically(unknowns, 0.0);
                let size = row.amax();
                Some((row.dot(&outline.unknowns()) - value, row, size))
            }
            Extra::Zero(margin) => Some(assembly.margin(margin)?),
        };
        assembly.rows.extend(extra);
        let segment = &outline.segments[cut.number];
        let landed = self.landed(segment, &anchor, self.states).0;
        let monodromy = self.monodromy(&mut assembly.maps, cut.number, (landed, at_cut));
        let size = assembly.at.x.amax().max(outline.begin.x.amax());
        let steps: usize = assembly.pieces.iter().map(|piece| piece.steps.len()).sum();
        // The rounding of a time displaces the state by its velocity. The roundings of many steps'
        // times add up like the square root of their number; three and a half standard deviations
        // are allowed.
        let speed = assembly.maps.iter().map(|map| map.velocity.amax());
        let speed = speed.fold(begins.amax(), f64::max);
        let time = assembly.at.t.abs().max(outline.begin.t.abs());
        let by_time = time * speed * (steps as f64).sqrt();
        let by_state = ULPS * steps as f64 * size;
        let rows = assembly.rows;
        let off = rows.iter().map(|(value, _, size)| (value / size).abs());
        Some(Equations {
            off: off.fold(0.0, f64::max),
            left: Vector::from_iterator(rows.len(), rows.iter().map(|row| row.0)),
            jacobian: Matrix::from_fn(rows.len(), unknowns, |i, j| rows[i].1[j]),
            pieces: assembly.pieces,
            monodromy,
            anchor,
            velocities: [begins, ends],
            rounding: f64::EPSILON * (by_state + by_time) * assembly.growth,
            steps,
        })
    }
}
