//! Integrated segments, and the derivatives of the flow over them.

use super::{OrbitGuess, Segment, SegmentKind, Shooting, StepBudget};
use crate::analysis::monodromy::{TangentMap, velocity_in};
use crate::analysis::tangent::Tangent;
use crate::dynamics::{Matrix, Moment, OrbitProgress, Solution, Step, Transition, Vector};
use crate::filippov::{MIN_TOLERANCE, Options, TransitionKind};
use crate::math::product;
use crate::orbit::Ending;
use crate::system::{Mode, Side};

/// An integrated segment.
pub(super) struct Piece {
    pub begin: Moment,
    pub end: Moment,
    pub steps: Vec<(Step, Solution)>,
    /// The jumps in it, each with the number of steps before it.
    pub jumps: Vec<(usize, Transition)>,
    /// The number of steps before its phase: those to a landing.
    pub phase: usize,
}

impl Piece {
    pub(super) fn followed_by(mut self, next: Piece) -> Self {
        let before = self.steps.len();
        self.jumps.extend(
            next.jumps
                .into_iter()
                .map(|(steps, at)| (before + steps, at)),
        );
        self.steps.extend(next.steps);
        self.end = next.end;
        self
    }
}

/// The derivative of the flow over a part of the orbit, split into the component along the flow and
/// the rest: near a saddle, one is small beside the other.
pub(super) struct FlowDerivative {
    /// Derivative without the component along the flow.
    pub across: Matrix,
    /// Coefficients of the velocity in that component.
    pub along: Vector,
    /// The velocity at its end.
    pub velocity: Vector,
    pub is_autonomous: bool,
}

impl FlowDerivative {
    pub(super) fn total(&self) -> Matrix {
        &self.across + &self.velocity * self.along.transpose()
    }

    /// Appends a saltation; `rate` is that of the guard with this gradient.
    pub(super) fn apply_saltation(&mut self, kick: &Vector, gradient: &Vector, rate: f64) {
        let by_guard = gradient.tr_mul(&self.across) / rate;
        self.across += kick * by_guard;
        self.velocity += kick;
        self.remove_along();
    }

    /// Appends a jump of the state, from the derivative of its map; the kick is that of the
    /// saltation.
    pub(super) fn apply_jump(
        &mut self,
        by_state: &Matrix,
        (kick, gradient, rate): (&Vector, &Vector, f64),
        velocity: Vector,
    ) {
        let by_guard = gradient.tr_mul(&self.across) / rate;
        self.across = product(by_state, &self.across) + kick * by_guard;
        self.velocity = velocity;
        self.remove_along();
    }

    /// Moves the component along the flow from `across` to `along`.
    fn remove_along(&mut self) {
        let square = self.velocity.norm_squared();
        if self.is_autonomous && square > 0.0 {
            let part = self.across.tr_mul(&self.velocity) / square;
            self.across -= &self.velocity * part.transpose();
            self.along += part;
        }
    }

    /// Composition of this one with a later one.
    fn followed_by(mut self, next: &FlowDerivative) -> FlowDerivative {
        self.along += self.across.tr_mul(&next.along);
        self.across = product(&next.across, &self.across);
        self.velocity.clone_from(&next.velocity);
        self
    }
}

impl Shooting<'_> {
    /// Integrates a segment, or a part of it.
    pub(super) fn piece(
        &self,
        segment: &Segment,
        begin: Moment,
        duration: f64,
        options: &Options,
    ) -> Option<Piece> {
        // Steps with an error so much smaller have about half the length, by an order of eight.
        const FINER: f64 = 1.0 / 256.0;
        let t_end = begin.t + duration;
        if let SegmentKind::Chatter { impact, landing } = segment.kind {
            let mut options = *options;
            if self.is_finer {
                options.rtol = (FINER * options.rtol).max(MIN_TOLERANCE);
                options.atol = options.atol.map(|atol| FINER * atol);
            }
            let landed = self.run_to_rest((impact, landing), begin, t_end, &options)?;
            let begin = landed.end.clone();
            return Some(landed.followed_by(self.run_in(segment, begin, t_end, &options)?));
        }
        let piece = self.run_in(segment, begin, t_end, options)?;
        if !self.is_finer {
            return Some(piece);
        }
        let whole = piece.steps.iter().map(|(step, _)| step);
        let mut halves = whole.flat_map(|step| [0.5 * (step.t_start + step.t_end), step.t_end]);
        let begin = self.run_in(segment, piece.begin.clone(), piece.begin.t, options);
        halves.try_fold(begin?, |before, t| {
            let first_step = Some(t - before.end.t).filter(|step| *step > 0.0);
            let options = Options {
                first_step,
                ..*options
            };
            let next = self.run_in(segment, before.end.clone(), t, &options)?;
            Some(before.followed_by(next))
        })
    }

    /// The first segment of an outline whose impacts do not accumulate before it ends.
    pub(in crate::analysis) fn never_landing(&self, outline: &OrbitGuess) -> Option<usize> {
        let states = &outline.cut.as_ref()?.states;
        let mut t = outline.begin.t;
        for (number, segment) in outline.segments.iter().enumerate() {
            let (begin, end) = (t, t + segment.duration);
            t = end;
            let SegmentKind::Chatter { impact, landing } = segment.kind else {
                continue;
            };
            let x = number
                .checked_sub(1)
                .and_then(|before| states.get(before))?;
            let begin = Moment {
                t: begin,
                x: x.clone(),
            };
            let run = self.run_to_rest((impact, landing), begin, end, self.options);
            if run?.phase == 0 {
                return Some(number);
            }
        }
        None
    }

    /// The run of the system to a landing, or to a time before it.
    fn run_to_rest(
        &self,
        (impact, landing): (usize, usize),
        begin: Moment,
        t_end: f64,
        options: &Options,
    ) -> Option<Piece> {
        let mut piece = Piece {
            end: begin.clone(),
            begin,
            steps: Vec::new(),
            jumps: Vec::new(),
            phase: 0,
        };
        if t_end <= piece.begin.t {
            return Some(piece);
        }
        let mut run = self.system.begin(&piece.begin, t_end, options, &[]).ok()?;
        loop {
            match run.step().ok()? {
                OrbitProgress::Step => {
                    let cost = StepBudget::with_tangents(self.states);
                    if self.budget.is_some_and(|budget| !budget.spend(cost)) {
                        return None;
                    }
                    piece.steps.push((run.last_step(), run.solution()));
                }
                OrbitProgress::Transition(at) => {
                    let is_of_chatter =
                        at.kind == TransitionKind::Jump && [impact, landing].contains(&at.contact);
                    if !is_of_chatter {
                        return None;
                    }
                    let has_landed = at.contact == landing;
                    piece.jumps.push((piece.steps.len(), at));
                    if has_landed {
                        piece.phase = piece.steps.len();
                        break;
                    }
                }
                // The steps carry the effect of a kink.
                OrbitProgress::PhaseEnd(_) | OrbitProgress::Kink(_) => {}
                OrbitProgress::End(summary) if summary.ending == Ending::EndTime => break,
                OrbitProgress::End(_) | OrbitProgress::Passage(_) => return None,
            }
        }
        piece.end = run.now();
        Some(piece)
    }

    fn run_in(
        &self,
        segment: &Segment,
        begin: Moment,
        t_end: f64,
        options: &Options,
    ) -> Option<Piece> {
        let mut steps = Vec::new();
        let mut end = begin.clone();
        if t_end > begin.t {
            let mode = (segment.mode, &segment.inside);
            let mut run = self.system.begin_in(mode, &begin, t_end, options).ok()?;
            while let OrbitProgress::Step = run.step().ok()? {
                // The tangent vectors of all states are carried over it.
                let cost = StepBudget::with_tangents(self.states);
                if self.budget.is_some_and(|budget| !budget.spend(cost)) {
                    return None;
                }
                steps.push((run.last_step(), run.solution()));
            }
            end = run.now();
        }
        (end.t == t_end || t_end <= begin.t).then_some(Piece {
            begin,
            end,
            steps,
            jumps: Vec::new(),
            phase: 0,
        })
    }

    /// The derivative, by state and time, of the state in which a segment begins: on the stops that
    /// carry, as after their landings. A change of the first `free` components projects sticking
    /// contacts onto their boundaries.
    pub(super) fn projected(
        &self,
        segment: &Segment,
        at: &Moment,
        free: usize,
    ) -> (Matrix, Vector) {
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
        let (mut landed, mut landed_in_time) = (Matrix::identity(n, n), Vector::zeros(n));
        for number in self.system.landings(at) {
            let landing = self.system.reset(number, at);
            landed = product(&landing.by_state, &landed);
            landed_in_time = &landing.by_state * landed_in_time + landing.by_time;
        }
        if gradients.is_empty() {
            return (landed, landed_in_time);
        }
        let normals = Matrix::from_fn(n, gradients.len(), |i, k| gradients[k].0[i]);
        let in_time = Vector::from_fn(gradients.len(), |k, _| gradients[k].1);
        let mut back = normals.clone();
        back.rows_mut(free, n - free).fill(0.0);
        let Some(inverse) = normals.tr_mul(&back).try_inverse() else {
            return (landed, landed_in_time);
        };
        let back = product(&back, &inverse);
        let onto = Matrix::identity(n, n) - product(&back, &normals.transpose());
        (
            product(&onto, &landed),
            onto * landed_in_time - back * in_time,
        )
    }

    /// The derivative of the state at the end of a piece by that at its beginning; `None` where a
    /// jump in it has none.
    pub(super) fn flow_derivative(
        &self,
        segment: &Segment,
        piece: &Piece,
    ) -> Option<FlowDerivative> {
        let tangent = Tangent::new(self.system, self.options);
        let tangent = if self.is_finer {
            tangent.finer()
        } else {
            tangent
        };
        let n = piece.begin.x.len();
        let is_autonomous = self.forced.is_none();
        let flow = self.system.flow(segment.mode, &segment.inside);
        let mut map = TangentMap::identity(self.system);
        if is_autonomous {
            map.take_out(&velocity_in(self.system, segment.mode, &piece.begin));
        }
        let mut jumps = piece.jumps.iter().peekable();
        for (number, (step, _)) in piece.steps.iter().enumerate() {
            map.through_step(&tangent, step);
            while let Some((_, at)) = jumps.next_if(|(before, _)| *before <= number + 1) {
                map.through_transition(&tangent, at).ok()?;
            }
        }
        let (across, along) = map.apart();
        Some(FlowDerivative {
            across,
            along: along.cloned().unwrap_or_else(|| Vector::zeros(n)),
            velocity: flow.velocity(&piece.end),
            is_autonomous,
        })
    }

    /// The derivative of the state at the end of a piece by the unknowns, from those of state and
    /// time at its beginning; its duration is fixed.
    pub(super) fn moved(
        &self,
        segment: &Segment,
        piece: &Piece,
        map: &Matrix,
        (of_state, of_time): (&Matrix, &Vector),
    ) -> Matrix {
        let flow = self.system.flow(segment.mode, &segment.inside);
        let [first, last] = [&piece.begin, &piece.end].map(|at| flow.velocity(at));
        let (projected, by_time) = self.projected(segment, &piece.begin, flow.moving());
        let begun = product(&projected, of_state) + (by_time - first) * of_time.transpose();
        product(map, &begun) + last * of_time.transpose()
    }

    /// The derivative of the flow map of the states over the period from the cut; in an autonomous
    /// system, transverse to the flow.
    pub(super) fn monodromy(
        &self,
        maps: &mut [FlowDerivative],
        cut: usize,
        (projected, velocity): (Matrix, Vector),
    ) -> Matrix {
        // The map of the piece that begins at the cut comes first: the second one of its segment.
        maps.rotate_left(cut + 1);
        let is_autonomous = self.forced.is_none();
        let start = FlowDerivative {
            across: projected,
            along: Vector::zeros(velocity.len()),
            velocity: velocity.clone(),
            is_autonomous,
        };
        let period = maps.iter().fold(start, FlowDerivative::followed_by);
        let of_states = period.across.view((0, 0), (self.states, self.states));
        if !is_autonomous {
            return of_states.into_owned();
        }
        let basis = across(&velocity.rows(0, self.states).into_owned());
        basis.tr_mul(&product(&of_states, &basis))
    }
}

/// An orthonormal basis of the complement of a vector, by the reflection that maps the first axis
/// to it.
pub(super) fn across(vector: &Vector) -> Matrix {
    let n = vector.len();
    let mut normal = vector / vector.norm();
    normal[0] += if normal[0] < 0.0 { -1.0 } else { 1.0 };
    let square = normal.norm_squared();
    let reflection = Matrix::identity(n, n) - &normal * normal.transpose() * (2.0 / square);
    reflection.columns(1, n - 1).into_owned()
}
