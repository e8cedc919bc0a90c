//! Newton's iteration for a periodic orbit with a given sequence of modes.

use super::minima::minima;
use super::newton::newton_solution;
use super::{Cut, Cycle, Margin, Outline, Segment, Site, margin, to_cut};
use crate::analysis::monodromy::{TangentMap, velocity_in};
use crate::analysis::tangent::Tangent;
use crate::dynamics::{Dynamics, Happening, Matrix, Modes, Moment, Solution, Step, Vector};
use crate::filippov::Options;
use crate::system::{Mode, Side};

/// Iterations allowed.
const MOST: usize = 14;

/// Tolerances within which an orbit closes and its event functions vanish.
pub(super) const TOLERANCES: f64 = 100.0;

/// Units in the last place that a step may leave of a gap.
const ULPS: f64 = 16.0;

/// Where rounding leaves more of a gap than this part of the orbit's extent, nothing closes.
const CLOSED: f64 = 1e-6;

/// An iterate's run is left where it goes so many times as far as orbits of the branch do.
const FAR: f64 = 100.0;

/// An orbit closes in its velocity to this part of it. Where it is slow that says more than that it
/// closes in place: next to an equilibrium any orbit comes back to where it was.
const SAME_VELOCITY: f64 = 1e-4;

/// A segment as it was run through.
pub(super) struct Piece {
    pub begin: Moment,
    pub end: Moment,
    pub steps: Vec<(Step, Solution)>,
}

impl Piece {
    fn followed_by(mut self, next: Piece) -> Self {
        self.steps.extend(next.steps);
        self.end = next.end;
        self
    }
}

/// The equations for a periodic orbit: what it is an orbit of.
#[derive(Clone, Copy)]
pub(crate) struct Shooting<'a> {
    pub system: &'a dyn Dynamics,
    /// How many of the components are states; those behind them are parameters.
    pub states: usize,
    /// The period, where it is the forcing's.
    pub forced: Option<f64>,
    /// How far the widest orbit goes that is known.
    pub extent: f64,
    /// Dimension of the families that the orbits are of.
    pub family: usize,
    /// An equation that is added where two parameters are unknown.
    pub extra: Extra<'a>,
    pub options: &'a Options,
}

/// An equation: what is left of it, its derivative by the unknowns, and the size of a unit of
/// length in it.
type Row = (f64, Vector, f64);

/// The derivative of the flow over a part of the orbit, without its part along the flow, and that:
/// near a saddle the one is small beside the other.
struct Map {
    across: Matrix,
    along: Vector,
    /// The vector that moves the orbit at its end.
    velocity: Vector,
    is_autonomous: bool,
}

impl Map {
    fn whole(&self) -> Matrix {
        &self.across + &self.velocity * self.along.transpose()
    }

    /// Behind a saltation, at which `rate` is that of the guard of this gradient.
    fn salted(&mut self, kick: &Vector, gradient: &Vector, rate: f64) {
        let by_guard = gradient.tr_mul(&self.across) / rate;
        self.across += kick * by_guard;
        self.velocity += kick;
        self.take_out();
    }

    /// Behind a jump of the state, by the derivative of its map; the kick is that of the saltation.
    fn reset(
        &mut self,
        by_state: &Matrix,
        (kick, gradient, rate): (&Vector, &Vector, f64),
        velocity: Vector,
    ) {
        let by_guard = gradient.tr_mul(&self.across) / rate;
        self.across = by_state * &self.across + kick * by_guard;
        self.velocity = velocity;
        self.take_out();
    }

    /// Takes out what has come in along the flow.
    fn take_out(&mut self) {
        let square = self.velocity.norm_squared();
        if self.is_autonomous && square > 0.0 {
            let part = self.across.tr_mul(&self.velocity) / square;
            self.across -= &self.velocity * part.transpose();
            self.along += part;
        }
    }

    /// Behind this one another.
    fn followed_by(mut self, next: &Map) -> Map {
        self.along += self.across.tr_mul(&next.along);
        self.across = &next.across * self.across;
        self.velocity.clone_from(&next.velocity);
        self
    }
}

/// Where a piece begins, and the derivatives of state and time there by the unknowns.
struct Base {
    segment: usize,
    at: Moment,
    of_state: Matrix,
    of_time: Vector,
}

/// An equation that is added.
#[derive(Clone, Copy, Default)]
pub(crate) enum Extra<'a> {
    #[default]
    None,
    /// The product of the unknowns with a row has a value.
    Plane(&'a Vector, f64),
    /// A margin is zero.
    Zero(&'a Margin),
}

/// What a turn is made of, as far as it has come.
struct Under<'a> {
    shooting: &'a Shooting<'a>,
    outline: &'a Outline,
    options: &'a Options,
    at: Moment,
    /// Derivatives of state and time by the unknowns.
    of_state: Matrix,
    of_time: Vector,
    bases: Vec<Base>,
    pieces: Vec<Piece>,
    /// The derivatives of the flow over each piece, with the saltation behind it.
    maps: Vec<Map>,
    rows: Vec<Row>,
    growth: f64,
}

impl Under<'_> {
    /// Where the time at the beginning is among the unknowns.
    fn time(&self) -> usize {
        self.outline.begin.x.len() + self.outline.segments.len()
    }

    /// Runs through a part of a segment.
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

    /// The state at a cut with this number is an unknown, and what comes to it is the same.
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

    /// The derivative of a function at a moment, of this gradient in the state and in time.
    fn row(
        &self,
        value: f64,
        (gradient, in_time): (&Vector, f64),
        base: (&Matrix, &Vector),
    ) -> Row {
        let row = base.0.tr_mul(gradient) + base.1 * in_time;
        // Of a length that the function changes by as much on.
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
        let number = margin.key.part;
        if margin.key.site == Site::Duration {
            let row = unit(self.of_time.len(), self.at.x.len() + number);
            return Some((margin.value, row, 1.0));
        }
        let bases = self.bases.iter().rev();
        let mut bases = bases.filter(|base| base.segment == number && base.at.t <= margin.at.t);
        let base = bases.next()?;
        let segment = &outline.segments[number];
        let (flow, guard, sign) = match margin.key.site {
            Site::Minimum(guard) | Site::Begin(guard) => (
                shooting.system.flow(segment.mode, &segment.inside),
                guard,
                1.0,
            ),
            Site::Landing => {
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
        // A smallest value does not change with the time at which it is taken.
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

/// A vector of this length with a 1 at a place.
fn unit(count: usize, place: usize) -> Vector {
    Vector::from_fn(count, |i, _| f64::from(u8::from(i == place)))
}

/// The equations at some unknowns.
struct Turn {
    /// What is left of them; and in units of length.
    left: Vector,
    off: f64,
    /// Their derivative by the unknowns.
    jacobian: Matrix,
    pieces: Vec<Piece>,
    monodromy: Matrix,
    /// Where the orbit is cut.
    anchor: Moment,
    /// The vectors that move the orbit at its beginning and at its end.
    velocities: [Vector; 2],
    /// What rounding may leave of them.
    rounding: f64,
    steps: usize,
}

impl<'a> Shooting<'a> {
    /// For orbits of a system near an outline, of which all components are states.
    pub fn of(
        system: &'a dyn Dynamics,
        outline: &Outline,
        forced: Option<f64>,
        options: &'a Options,
    ) -> Self {
        Shooting {
            system,
            states: system.states(),
            forced,
            extent: outline.extent,
            family: 0,
            extra: Extra::None,
            options,
        }
    }

    /// Whether a margin is below zero by more than the tolerances leave open.
    pub fn is_violated(&self, margin: &Margin) -> bool {
        margin.is_violated(self.options)
    }

    /// Whether an orbit has the phases of its sequence.
    pub fn is_valid(&self, cycle: &Cycle) -> bool {
        !cycle.margins.iter().any(|margin| self.is_violated(margin))
    }

    /// [`Shooting::solve`], of a family the orbit that is nearest to the guess.
    pub fn nearest(&self, guess: &Outline, row: Option<(&Vector, f64)>) -> Option<Cycle> {
        let with_family = |family| Shooting { family, ..*self }.solve(guess, row);
        match with_family(0) {
            Some(found) if found.family > 0 => with_family(found.family).or(Some(found)),
            Some(found) => Some(found),
            None => with_family(1).filter(|found| found.family > 0),
        }
    }

    /// The equations at an orbit that solves them, whether or not they have another solution next
    /// to it.
    pub fn evaluated(&self, outline: &Outline) -> Option<Cycle> {
        let outline = match outline.cut {
            Some(_) => outline.clone(),
            None => self.cut(outline, self.options)?,
        };
        let turn = self.turn(&outline, &outline, self.options)?;
        let sizes = sizes(&turn.pieces);
        let period = outline.period();
        self.cycle(outline, turn, (period, sizes), (0, self.family))
    }

    /// Solves the equations near a guess. `row` closes the system where a parameter is unknown: the
    /// product of the unknowns with it has a value.
    pub fn solve(&self, guess: &Outline, row: Option<(&Vector, f64)>) -> Option<Cycle> {
        let by_tolerance = TOLERANCES * self.options.atol.max(self.options.rtol);
        let reach = guess.begin.x.amax() + FAR * self.extent;
        let bounded = self.options.escape(self.options.escape.min(reach));
        let guessed = guess.period();
        let mut outline = match guess.cut {
            Some(_) => guess.clone(),
            None => self.cut(guess, &bounded)?,
        };
        let mut last_off = f64::INFINITY;
        for iterations in 1..=MOST {
            let turn = self.turn(&outline, guess, &bounded)?;
            let unknowns = outline.unknowns();
            let mut matrix = turn.jacobian.clone();
            let mut right = -&turn.left;
            let mut is_on = true;
            if let Some((row, value)) = row {
                let row = &row.clone().resize_vertically(unknowns.len(), 0.0);
                let off = value - row.dot(&unknowns);
                is_on = off.abs() <= by_tolerance.min(1e-12) * row.amax();
                let rows = matrix.nrows();
                matrix = matrix.insert_row(rows, 0.0);
                matrix.set_row(rows, &row.transpose());
                right = right.insert_row(rows, off);
            }
            let wanted = self.closes_to(&turn);
            let closes =
                turn.off <= wanted && is_on && (turn.off >= 0.5 * last_off || turn.off == 0.0);
            let sizes = sizes(&turn.pieces);
            let most = sizes.amax();
            let other = if most > by_tolerance { most } else { 1.0 };
            let scales = sizes.map(|size| if size > by_tolerance { size } else { other });
            let known = by_tolerance.max(ULPS * f64::EPSILON * turn.steps as f64);
            // Next to a saddle nearly all directions seem free; only of families some are.
            let (free, known) = match self.family {
                _ if closes => (0, known),
                0 => (0, 0.0),
                family => (family, known),
            };
            let solved = newton_solution(matrix, &right, (self.states, free), (scales, known));
            if closes {
                let family = solved.map_or(0, |(_, free)| free);
                return self.cycle(outline, turn, (guessed, sizes), (iterations, family));
            }
            last_off = turn.off;
            outline = outline.with(&(unknowns + solved?.0));
            let period = outline.period();
            let is_possible = (period - guessed).abs() < guessed
                && outline.segments.iter().all(|one| one.duration >= 0.0)
                && outline.begin.x.iter().all(|v| v.is_finite());
            if !is_possible {
                return None;
            }
        }
        None
    }

    /// What may be left of the equations, in units of length.
    fn closes_to(&self, turn: &Turn) -> f64 {
        let by_tolerance = TOLERANCES * self.options.atol.max(self.options.rtol);
        by_tolerance.max(turn.rounding.min(CLOSED * self.extent))
    }

    /// State and mode of an orbit at a time, or whole periods before or behind it.
    pub fn place(&self, cycle: &Cycle, t: f64) -> Option<(Moment, Modes)> {
        // What begins here, to rounding, is not the end of what was before.
        let blur = 64.0 * f64::EPSILON * (t.abs() + cycle.period);
        let behind = |at: &Moment| {
            let way = (t - at.t).rem_euclid(cycle.period);
            if cycle.period - way <= blur { 0.0 } else { way }
        };
        let begins = cycle.begins.iter().zip(&cycle.outline.segments);
        let last = begins.min_by(|(a, _), (b, _)| behind(a).total_cmp(&behind(b)));
        let (begin, segment) = last?;
        let piece = self.piece(segment, begin.clone(), behind(begin), self.options)?;
        Some((piece.end, segment.mode))
    }

    fn cycle(
        &self,
        outline: Outline,
        turn: Turn,
        (guessed, sizes): (f64, Vector),
        (iterations, family): (usize, usize),
    ) -> Option<Cycle> {
        let by_tolerance = TOLERANCES * self.options.atol.max(self.options.rtol);
        let extent = sizes.amax();
        let period = outline.period();
        let [start, end] = &turn.velocities;
        let is_near = (period - guessed).abs() <= 0.3 * guessed;
        let within = SAME_VELOCITY.max(TOLERANCES * by_tolerance) * start.norm();
        let has_events = outline.segments.iter().any(|one| one.end.is_some());
        let is_same = self.forced.is_some() || has_events || (end - start).norm() <= within;
        let is_finite = turn.monodromy.iter().all(|entry| entry.is_finite());
        if !is_near || !is_same || !is_finite || extent <= by_tolerance {
            return None;
        }
        let margins = self.margins(&outline, &turn.pieces);
        let closes_to = self.closes_to(&turn);
        Some(Cycle {
            anchor: turn.anchor,
            begins: turn.pieces.iter().map(|one| one.begin.clone()).collect(),
            period,
            jacobian: turn.jacobian,
            monodromy: turn.monodromy,
            margins,
            sizes,
            extent,
            outline,
            closes_to,
            known: by_tolerance.max(ULPS * f64::EPSILON * turn.steps as f64),
            iterations,
            family,
        })
    }

    /// The outline with a cut in the middle of the longest of the segments in which the fewest
    /// contacts stick.
    fn cut(&self, outline: &Outline, options: &Options) -> Option<Outline> {
        let number = to_cut(&outline.segments);
        let mut at = outline.begin.clone();
        let mut states = Vec::with_capacity(outline.segments.len());
        let mut middle = at.x.clone();
        for (k, segment) in outline.segments.iter().enumerate() {
            if k > 0 {
                states.push(at.x.clone());
            }
            if k == number {
                let half = self.piece(segment, at.clone(), 0.5 * segment.duration, options)?;
                middle = half.end.x;
            }
            at = self.piece(segment, at, segment.duration, options)?.end;
        }
        states.push(middle);
        Some(Outline {
            cut: Some(Cut { number, states }),
            ..outline.clone()
        })
    }

    /// Runs through the segments; `guess` is where the iteration began, from which an orbit without
    /// transitions does not go along the flow.
    fn turn(&self, outline: &Outline, guess: &Outline, options: &Options) -> Option<Turn> {
        let n = outline.begin.x.len();
        let cut = outline.cut.as_ref()?;
        let count = outline.segments.len();
        let time = n + count;
        let unknowns = time + 1 + n * cut.states.len();
        let mut under = Under {
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
                under.cut(number - 1)?;
            }
            let piece = if number == cut.number {
                let first = under.through(number, 0.5)?;
                under.cut(count - 1)?;
                anchor = under.at.clone();
                at_cut = velocity(&outline.segments[number], &anchor);
                first.followed_by(under.through(number, 0.5)?)
            } else {
                under.through(number, 1.0)?
            };
            under.pieces.push(piece);
            events.extend(under.event(number));
        }
        let ends = under.maps.last()?.velocity.clone();
        let gap = &under.at.x - &outline.begin.x;
        for i in 0..self.states {
            let row = under.of_state.row(i).transpose() - unit(unknowns, i);
            under.rows.push((gap[i], row, 1.0));
        }
        let has_events = !events.is_empty();
        under.rows.extend(events);
        // The time at the beginning is open where the forcing knows it and an event is there.
        if let Some(period) = self.forced {
            let is_duration = |i: usize| i >= n && i < time;
            let row = Vector::from_fn(unknowns, |i, _| f64::from(u8::from(is_duration(i))));
            under.rows.push((outline.period() - period, row, 1.0));
        }
        if self.forced.is_none() || !has_events {
            let off = outline.begin.t - guess.begin.t;
            under.rows.push((off, unit(unknowns, time), 1.0));
        }
        if self.forced.is_none() && !has_events {
            let along = begins.rows(0, self.states);
            let way = &outline.begin.x - &guess.begin.x;
            let value = along.dot(&way.rows(0, self.states));
            let row = along.into_owned().resize_vertically(unknowns, 0.0);
            under.rows.push((value, row, f64::INFINITY));
        }
        let extra = match self.extra {
            Extra::None => None,
            Extra::Plane(row, value) => {
                let row = row.clone().resize_vertically(unknowns, 0.0);
                let size = row.amax();
                Some((row.dot(&outline.unknowns()) - value, row, size))
            }
            Extra::Zero(margin) => Some(under.margin(margin)?),
        };
        under.rows.extend(extra);
        let segment = &outline.segments[cut.number];
        let landed = self.landed(segment, &anchor, self.states).0;
        let monodromy = self.monodromy(&mut under.maps, cut.number, (landed, at_cut));
        let size = under.at.x.amax().max(outline.begin.x.amax());
        let steps: usize = under.pieces.iter().map(|piece| piece.steps.len()).sum();
        // A state at a time that is rounded is off by how fast it moves. The roundings of many
        // steps' times add up like their root: to a unit by three and a half standard deviations.
        let speed = under.maps.iter().map(|map| map.velocity.amax());
        let speed = speed.fold(begins.amax(), f64::max);
        let time = under.at.t.abs().max(outline.begin.t.abs());
        let by_time = time * speed * (steps as f64).sqrt();
        let by_state = ULPS * steps as f64 * size;
        let rows = under.rows;
        let off = rows.iter().map(|(value, _, size)| (value / size).abs());
        Some(Turn {
            off: off.fold(0.0, f64::max),
            left: Vector::from_iterator(rows.len(), rows.iter().map(|row| row.0)),
            jacobian: Matrix::from_fn(rows.len(), unknowns, |i, j| rows[i].1[j]),
            pieces: under.pieces,
            monodromy,
            anchor,
            velocities: [begins, ends],
            rounding: f64::EPSILON * (by_state + by_time) * under.growth,
            steps,
        })
    }

    /// The derivative of the flow map of the states over the period from the cut; across the flow
    /// where the system does not depend on time.
    fn monodromy(
        &self,
        maps: &mut [Map],
        cut: usize,
        (landed, velocity): (Matrix, Vector),
    ) -> Matrix {
        // The maps behind the cut come first; it lies behind the first piece of its segment.
        maps.rotate_left(cut + 1);
        let is_autonomous = self.forced.is_none();
        let start = Map {
            across: landed,
            along: Vector::zeros(velocity.len()),
            velocity: velocity.clone(),
            is_autonomous,
        };
        let whole = maps.iter().fold(start, Map::followed_by);
        let of_states = whole.across.view((0, 0), (self.states, self.states));
        if !is_autonomous {
            return of_states.into_owned();
        }
        let basis = across(&velocity.rows(0, self.states).into_owned());
        basis.tr_mul(&(of_states * &basis))
    }

    /// The derivative of the state at the end of a piece by the unknowns, from those of state and
    /// time at its beginning; it lasts as long.
    fn moved(
        &self,
        segment: &Segment,
        piece: &Piece,
        map: &Matrix,
        (of_state, of_time): (&Matrix, &Vector),
    ) -> Matrix {
        let flow = self.system.flow(segment.mode, &segment.inside);
        let [before, behind] = [&piece.begin, &piece.end].map(|at| flow.velocity(at));
        let (landed, by_time) = self.landed(segment, &piece.begin, piece.begin.x.len());
        let begun = landed * of_state + (by_time - before) * of_time.transpose();
        map * begun + behind * of_time.transpose()
    }

    /// How far the orbit is from each change of its phases.
    fn margins(&self, outline: &Outline, pieces: &[Piece]) -> Vec<Margin> {
        let mut margins = minima(self.system, outline, pieces);
        for margin in &mut margins {
            self.settle(outline, pieces, margin);
        }
        margins.extend(margin::at_events(self.system, outline, pieces));
        margins
    }

    /// A smallest value by a step that ends there: between its ends a step is off by more than
    /// there.
    fn settle(&self, outline: &Outline, pieces: &[Piece], margin: &mut Margin) {
        let Site::Minimum(guard) = margin.key.site else {
            return;
        };
        let (segment, t) = (&outline.segments[margin.key.part], margin.at.t);
        let steps = pieces[margin.key.part].steps.iter();
        let mut steps = steps.filter(|(step, _)| step.t_start < t && t < step.t_end);
        let Some((step, _)) = steps.next() else {
            return;
        };
        let begin = Moment {
            t: step.t_start,
            x: step.x_start.clone(),
        };
        if let Some(piece) = self.piece(segment, begin, t - step.t_start, self.options) {
            margin.at.x = piece.end.x;
            let flow = self.system.flow(segment.mode, &segment.inside);
            margin.value = flow.guard(guard, &margin.at);
        }
    }

    /// Runs through a segment, or a part of it.
    fn piece(
        &self,
        segment: &Segment,
        begin: Moment,
        duration: f64,
        options: &Options,
    ) -> Option<Piece> {
        let t_end = begin.t + duration;
        let mut steps = Vec::new();
        let mut end = begin.clone();
        if t_end > begin.t {
            let mode = (segment.mode, &segment.inside);
            let mut run = self.system.begin_in(mode, &begin, t_end, options).ok()?;
            while let Happening::Step = run.step().ok()? {
                steps.push((run.last_step(), run.solution()));
            }
            end = run.now();
        }
        (end.t == t_end || t_end <= begin.t).then_some(Piece { begin, end, steps })
    }

    /// The derivative, by the state and by the time, of the state in which a segment begins: what
    /// sticks is landed on its boundary, by a change of the first `free` components.
    fn landed(&self, segment: &Segment, at: &Moment, free: usize) -> (Matrix, Vector) {
        let n = at.x.len();
        let modes = segment.mode.iter().enumerate();
        let sticks = modes.filter(|(_, mode)| *mode == Mode::Stick);
        let slip = Mode::Slip(Side::Above);
        let gradients: Vec<(Vector, f64)> = sticks
            .map(|(contact, _)| {
                let flow = self.system.flow(segment.mode.with(contact, slip), at);
                flow.guard_gradient(contact, at)
            })
            .collect();
        let identity = Matrix::identity(n, n);
        if gradients.is_empty() {
            return (identity, Vector::zeros(n));
        }
        let normals = Matrix::from_fn(n, gradients.len(), |i, k| gradients[k].0[i]);
        let in_time = Vector::from_fn(gradients.len(), |k, _| gradients[k].1);
        let mut back = normals.clone();
        back.rows_mut(free, n - free).fill(0.0);
        let Some(inverse) = normals.tr_mul(&back).try_inverse() else {
            return (identity, Vector::zeros(n));
        };
        let back = back * inverse;
        (identity - &back * normals.transpose(), -back * in_time)
    }

    /// The derivative of the state at the end of a piece by that at its beginning.
    fn carried(&self, segment: &Segment, piece: &Piece) -> Map {
        let tangent = Tangent::new(self.system, self.options);
        let n = piece.begin.x.len();
        let is_autonomous = self.forced.is_none();
        let flow = self.system.flow(segment.mode, &segment.inside);
        let mut map = TangentMap::identity(self.system);
        if is_autonomous {
            map.take_out(&velocity_in(self.system, segment.mode, &piece.begin));
        }
        for (step, _) in &piece.steps {
            map.through_step(&tangent, step);
        }
        let (across, along) = map.apart();
        Map {
            across,
            along: along.cloned().unwrap_or_else(|| Vector::zeros(n)),
            velocity: flow.velocity(&piece.end),
            is_autonomous,
        }
    }
}

/// An orthonormal basis of what is across a vector: a reflection that takes the first axis to it
/// takes the others there.
fn across(vector: &Vector) -> Matrix {
    let n = vector.len();
    let mut normal = vector / vector.norm();
    normal[0] += if normal[0] < 0.0 { -1.0 } else { 1.0 };
    let square = normal.norm_squared();
    let reflection = Matrix::identity(n, n) - &normal * normal.transpose() * (2.0 / square);
    reflection.columns(1, n - 1).into_owned()
}

/// How far the components go, at the ends of steps.
fn sizes(pieces: &[Piece]) -> Vector {
    let ends = pieces.iter().flat_map(|piece| &piece.steps);
    let mut ends = ends.map(|(step, _)| &step.x_end);
    let Some(first) = ends.next() else {
        return pieces
            .first()
            .map_or(Vector::zeros(0), |one| one.begin.x.abs() * 0.0);
    };
    let begin = &pieces[0].begin.x;
    let (mut low, mut high) = (first.inf(begin), first.sup(begin));
    for x in ends {
        (low, high) = (low.inf(x), high.sup(x));
    }
    high - low
}
