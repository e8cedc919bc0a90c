//! The equations for a periodic orbit as segments, with their derivatives by the unknowns.

use super::jacobian::{Jacobian, Part, Row};
use super::pieces::{FlowDerivative, Piece};
use super::{OrbitGuess, Segment, SegmentKind, Shooting, ULPS, unit};
use crate::dynamics::{Matrix, Moment, Vector};
use crate::filippov::Options;
use crate::math::product;

/// An equation: its residual, the derivative of that by the unknowns, and its change per unit of
/// the states.
type Equation = (f64, Row, f64);

/// Parts assembled from the segments before the present moment.
struct Assembly<'a> {
    shooting: &'a Shooting<'a>,
    outline: &'a OrbitGuess,
    options: &'a Options,
    at: Moment,
    /// The derivatives of state and time by the state and the time with which the present piece
    /// begins, and by the duration of its segment.
    of_state: Matrix,
    of_time: Vector,
    parts: Vec<Part>,
    pieces: Vec<Piece>,
    /// The derivative of the flow over each piece, with the saltation at its end.
    maps: Vec<FlowDerivative>,
    rows: Vec<Equation>,
    /// Largest amplification of an error so far.
    growth: f64,
    /// The unknowns that the first equations set equal if no state changes over any piece.
    unchanged: Vec<[usize; 2]>,
    /// Index among the unknowns of the state with which the present piece begins.
    base: usize,
}

impl Assembly<'_> {
    /// Index of the time at the beginning among the unknowns.
    fn time(&self) -> usize {
        self.outline.begin.x.len() + self.outline.segments.len()
    }

    /// The derivative of an equation of the present piece, from that by its beginning and duration,
    /// with further ones.
    fn row(&self, by: &Vector, others: &[(usize, f64)]) -> Row {
        let n = self.at.x.len();
        let number = self.parts.len() - 1;
        let duration = n + self.parts[number].segment;
        let of_state = (0..n).map(|i| (self.base + i, by[i]));
        let entries = of_state.chain([(duration, by[n + 1])]);
        Row {
            entries: entries.chain(others.iter().copied()).collect(),
            in_time: Some((number, by[n])),
        }
    }

    /// Integrates a share of a segment.
    fn through(&mut self, number: usize, share: f64) -> Option<Piece> {
        let segment = &self.outline.segments[number];
        let n = self.at.x.len();
        let piece = self.shooting.piece(
            segment,
            self.at.clone(),
            share * segment.duration,
            self.options,
        )?;
        let has_landed = segment.is_cuttable() || piece.phase > 0;
        let map = self
            .shooting
            .flow_derivative(segment, &piece)
            .filter(|_| has_landed)?;
        let total = map.total();
        let base = (&Matrix::identity(n, n + 2), &unit(n + 2, n));
        self.of_state = self.shooting.moved(segment, &piece, &total, base);
        self.of_time = unit(n + 2, n);
        // A longer duration makes it longer by its share.
        self.of_time[n + 1] = share;
        for (i, rate) in map.velocity.iter().enumerate() {
            self.of_state[(i, n + 1)] += rate * share;
        }
        self.parts.push(Part {
            segment: number,
            share,
            state: self.base,
        });
        self.growth = self.growth.max(self.of_state.amax()).max(total.amax());
        self.maps.push(map);
        self.at = piece.end.clone();
        Some(piece)
    }

    /// Begins anew with the unknown state of a cut, which the present state must equal.
    fn cut(&mut self, number: usize) -> Option<()> {
        let state = self.outline.cut.as_ref()?.states.get(number)?;
        let n = state.len();
        let place = self.time() + 1 + number * n;
        let gap = &self.at.x - state;
        for i in 0..n {
            let row = self.row(&self.of_state.row(i).transpose(), &[(place + i, -1.0)]);
            self.rows.push((gap[i], row, 1.0));
            self.unchanged.push([self.base + i, place + i]);
        }
        self.base = place;
        self.at.x.clone_from(state);
        Some(())
    }

    /// The equation that a function vanishes here, from its gradient in the state and in time.
    fn zero_of(&self, value: f64, (gradient, in_time): (&Vector, f64)) -> Equation {
        let row = self.of_state.tr_mul(gradient) + &self.of_time * in_time;
        // As if the orbit moved by its extent in a period.
        let by_time = in_time.abs() * self.outline.period() / self.shooting.extent;
        (
            value,
            self.row(&row, &[]),
            gradient.norm().max(by_time).max(f64::MIN_POSITIVE),
        )
    }

    /// The equation of the event at the end of a segment, and the transition there.
    fn event(&mut self, number: usize) -> Option<Equation> {
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
            let equation = self.zero_of(value, (&gradient, in_time));
            let reset = system.map(event.contact, &self.at);
            self.at.x = reset.after;
            self.of_state = product(&reset.by_state, &self.of_state)
                + &reset.by_time * self.of_time.transpose();
            let after = next.velocity(&self.at);
            let kick = &after - &reset.by_state * &velocity - &reset.by_time;
            if let Some(map) = self.maps.last_mut() {
                map.apply_jump(&reset.by_state, (&kick, &gradient, rate), after);
            }
            return Some(equation);
        }
        let kick = next.velocity(&self.at) - &velocity;
        if kick.amax() > f64::EPSILON * velocity.amax()
            && let Some(map) = self.maps.last_mut()
        {
            map.apply_saltation(&kick, &gradient, rate);
        }
        Some(self.zero_of(value, (&gradient, in_time)))
    }
}

/// The equations evaluated at some unknowns.
pub(super) struct ShootingEquations {
    /// The residuals, and the largest of them in the unit of the states.
    pub residuals: Vector,
    pub largest: f64,
    /// Derivative of the residuals by the unknowns.
    pub jacobian: Jacobian,
    pub pieces: Vec<Piece>,
    pub monodromy: Matrix,
    /// Moment at which the orbit is cut.
    pub anchor: Moment,
    /// The vectors that move the orbit at its beginning and at its end.
    pub velocities: [Vector; 2],
    /// Residual that rounding may leave.
    pub rounding: f64,
    pub steps: usize,
}

impl Shooting<'_> {
    /// Integrates the segments. `guess` is where the iteration began. From there, an orbit without
    /// transitions does not move along the flow.
    pub(super) fn equations(
        &self,
        outline: &OrbitGuess,
        guess: &OrbitGuess,
        options: &Options,
    ) -> Option<ShootingEquations> {
        let n = outline.begin.x.len();
        let cut = outline.cut.as_ref()?;
        let count = outline.segments.len();
        let time = n + count;
        let mut assembly = Assembly {
            shooting: self,
            outline,
            options,
            at: outline.begin.clone(),
            of_state: Matrix::identity(n, n + 2),
            of_time: unit(n + 2, n),
            parts: Vec::new(),
            pieces: Vec::new(),
            maps: Vec::new(),
            rows: Vec::new(),
            growth: 1.0,
            unchanged: Vec::new(),
            base: 0,
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
            let by = assembly.of_state.row(i).transpose();
            let row = assembly.row(&by, &[(i, -1.0)]);
            assembly.rows.push((gap[i], row, 1.0));
            assembly.unchanged.push([assembly.base + i, i]);
        }
        let has_events = !events.is_empty();
        assembly.rows.extend(events);
        // As if the orbit moved by its extent in a period.
        let by_time = outline.period() / self.extent;
        // The durations add up to the period of the forcing.
        if let Some((period, gradient)) = self.prescribed(&outline.begin.x) {
            let by_state = gradient.iter().map(|slope| -slope).enumerate();
            let row = Row::of(by_state.chain((n..time).map(|duration| (duration, 1.0))));
            let off = outline.period() - period;
            assembly.rows.push((off, row, by_time));
        }
        // The time at the beginning is arbitrary in an autonomous system, or without an event
        // there.
        if self.forced.is_none() || !has_events {
            let off = outline.begin.t - guess.begin.t;
            let row = Row::of([(time, 1.0)]);
            assembly.rows.push((off, row, by_time));
        }
        for (number, segment) in outline.segments.iter().enumerate() {
            if let SegmentKind::Flight { share } = segment.kind {
                let next = outline.segments[(number + 1) % count].duration;
                let off = (1.0 - share) * segment.duration - share * next;
                let next = n + (number + 1) % count;
                let row = Row::of([(n + number, 1.0 - share), (next, -share)]);
                assembly.rows.push((off, row, by_time));
            }
        }
        if self.forced.is_none() && !has_events {
            let along = begins.rows(0, self.states);
            let way = &outline.begin.x - &guess.begin.x;
            let value = along.dot(&way.rows(0, self.states));
            let row = Row::of(along.iter().copied().enumerate());
            assembly.rows.push((value, row, f64::INFINITY));
        }
        if let Some((row, value)) = self.plane {
            let first = outline.unknowns().resize_vertically(row.len(), 0.0);
            let (off, size) = (row.dot(&first) - value, row.amax());
            let row = Row::of(row.iter().copied().enumerate());
            assembly.rows.push((off, row, size));
        }
        let segment = &outline.segments[cut.number];
        let projected = self.projected(segment, &anchor, self.states).0;
        let monodromy = self.monodromy(&mut assembly.maps, cut.number, (projected, at_cut));
        let size = assembly.at.x.amax().max(outline.begin.x.amax());
        let steps: usize = assembly.pieces.iter().map(|piece| piece.steps.len()).sum();
        // The rounding of a time displaces the state by its velocity. Over many steps these add up
        // like the square root of their number. Three and a half standard deviations are allowed.
        let speed = assembly.maps.iter().map(|map| map.velocity.amax());
        let speed = speed.fold(begins.amax(), f64::max);
        let time = assembly.at.t.abs().max(outline.begin.t.abs());
        let of_times = time * speed * (steps as f64).sqrt();
        let by_state = ULPS * steps as f64 * size;
        let rows = assembly.rows;
        let sizes = rows.iter().map(|(value, _, size)| (value / size).abs());
        let largest = sizes.fold(0.0, f64::max);
        let residuals = Vector::from_iterator(rows.len(), rows.iter().map(|row| row.0));
        let rows = rows.into_iter().map(|(_, row, _)| row).collect();
        Some(ShootingEquations {
            largest,
            residuals,
            jacobian: Jacobian::new(outline, (assembly.parts, rows), assembly.unchanged),
            pieces: assembly.pieces,
            monodromy,
            anchor,
            velocities: [begins, ends],
            rounding: f64::EPSILON * (by_state + of_times) * assembly.growth,
            steps,
        })
    }
}
