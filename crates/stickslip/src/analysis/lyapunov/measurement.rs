//! A frame of tangent vectors along an orbit, and the sums of their growth.

use super::super::instant::LastEvent;
use super::super::tangent::{MATRIX_ROUNDING, Saltation, Tangent, flatten, singular};
use super::averages::Growth;
use super::frame::Frame;
use super::settings::SpectrumOptions;
use super::spectrum::{Spectrum, uncertainties};
use super::volume::growth;
use crate::analysis::cycle::unit;
use crate::dynamics::{
    Dynamics, Matrix, Modes, Moment, OrbitUnderWay, Step, Summary, Transition, Vector,
};
use crate::error::{Error, Point};
use crate::filippov::{MIN_ABSOLUTE, TransitionKind};
use crate::math;

/// Part of a vector across the boundary of a sticking contact that may stay, as a fraction of its
/// length. The error of the length is the square of that: far below rounding. Any fraction from
/// rounding to its square root would do.
const ACROSS_BOUNDARY: f64 = 1e-12;

/// Number of parts of steps after which the rounding of vectors is measured again. Chosen: it takes
/// the time of a further vector.
const PARTS_PER_CHECK: u64 = 16;

/// Transitions within the tolerances of one place after which an orbit is lost there. Chosen.
const NARROW_TRANSITIONS: usize = 4;

/// The frame and its sums.
pub(super) struct Measurement<'a> {
    tangent: Tangent<'a>,
    /// The solver's absolute tolerance may be refined.
    pub(super) settings: SpectrumOptions,
    /// Largest size of the state since the tolerance was refined; `None` where that is not wanted.
    largest: Option<f64>,
    frame: Frame,
    growth: Growth,
    /// Logarithm of the volume spanned by the surviving vectors, by Liouville's formula. It has a
    /// meaning for a full frame only.
    log_volume: f64,
    /// Integral of the divergence.
    divergence: f64,
    /// A place, and the number of transitions since the orbit left the tolerances around it.
    narrow: (Moment, usize),
    /// End of the last step that the frame was carried over, when measuring.
    reached: Option<Moment>,
    stick_time: f64,
    stick_entries: usize,
    collapses: usize,
    /// Number of parts of steps so far.
    parts: u64,
    last: LastEvent,
    /// Whether no step has been taken since the run began.
    is_fresh: bool,
    /// Whether the run is still in the transient.
    is_settling: bool,
}

impl<'a> Measurement<'a> {
    /// A measurement of the largest exponents, so many of them. With `refines`, the absolute
    /// tolerance follows the size of the state.
    pub(super) fn new(
        system: &'a dyn Dynamics,
        settings: SpectrumOptions,
        (count, refines): (usize, bool),
    ) -> Self {
        Measurement {
            tangent: Tangent::new(system, &settings.solver),
            largest: refines.then_some(0.0),
            frame: Frame::generic(system.states(), count),
            growth: Growth::new(count, 0.0, &settings),
            settings,
            log_volume: 0.0,
            divergence: 0.0,
            narrow: (
                Moment {
                    t: 0.0,
                    x: Vector::zeros(system.states()),
                },
                0,
            ),
            reached: None,
            stick_time: 0.0,
            stick_entries: 0,
            collapses: 0,
            parts: 0,
            last: LastEvent::none(),
            is_fresh: true,
            is_settling: true,
        }
    }

    /// Resets the sums and keeps the frame.
    pub(super) fn begin_measuring(&mut self, t: f64) {
        self.frame.revive();
        if let Some(shadow) = &mut self.frame.shadow {
            shadow.begin_measuring();
        }
        self.growth = Growth::new(self.frame.len(), t, &self.settings);
        self.log_volume = 0.0;
        self.divergence = 0.0;
        self.stick_time = 0.0;
        self.stick_entries = 0;
        self.collapses = 0;
        self.is_fresh = true;
        self.is_settling = false;
    }

    /// The spectrum of a run that has ended, early because of an error.
    pub(super) fn finish(self, summary: Summary, ended: Option<Error>) -> Spectrum {
        let shadow = self.frame.shadow.as_ref();
        let bound = |j: usize| shadow.map_or(0.0, |shadow| shadow.bound(j));
        let rounding: Vec<f64> = self.growth.order().into_iter().map(bound).collect();
        let (duration, exponents, convergence) = self.growth.finish(summary.t);
        // Time in units in which the orbit and its frame settled before, or else of its steps.
        let step = duration / self.parts.max(1) as f64;
        let span = duration / self.settings.transient.max(step);
        Spectrum {
            uncertainties: uncertainties(&exponents, &rounding, (duration, span)),
            ended,
            exponents,
            convergence,
            volume_rate: self.log_volume / duration,
            mean_divergence: self.divergence / duration,
            stick_entries: self.stick_entries,
            collapses: self.collapses,
            stick_fraction: self.stick_time / duration,
            duration,
            summary,
        }
    }

    /// End of the measured part of the run, if it is as long as this.
    pub(super) fn reached(&self, least: f64) -> Option<Moment> {
        let is_enough = |at: &&Moment| self.growth.elapsed(at.t) >= least;
        self.reached.as_ref().filter(is_enough).cloned()
    }

    /// Adds the logarithms of the lengths that remained when the frame was made orthonormal.
    /// `log_determinant` belongs to the map that was applied to the whole frame; the share of the
    /// annihilated vectors is subtracted.
    fn book(&mut self, lengths: &[f64], log_determinant: f64) {
        self.log_volume += log_determinant;
        for (j, length) in lengths.iter().enumerate() {
            let log = math::ln(*length);
            if self.frame.is_alive(j) {
                self.growth.logs[j] += log;
            } else {
                self.log_volume -= log;
            }
        }
    }

    /// Removes the directions that a map with these orthonormal vectors as its kernel annihilates.
    /// The volume of the others is that of all, divided by the heights.
    fn collapse(&mut self, kernel: &[Vector]) {
        if kernel.is_empty() {
            return;
        }
        for j in self.frame.collapse(Matrix::from_columns(kernel)) {
            self.log_volume -= self.growth.logs[j];
            self.growth.logs[j] = f64::NEG_INFINITY;
        }
    }

    /// Projects the surviving vectors along the unit vector `kernel` by `map`, which leads into the
    /// space across `gradient`.
    ///
    /// Such a map preserves the volumes of the parallelepipeds that the vectors span together with
    /// `kernel`. So the vectors' own volume changes like their distance to the tip of `kernel`,
    /// before and after.
    fn project(
        &mut self,
        kernel: &Vector,
        gradient: &Vector,
        map: impl Fn(&mut Vector),
    ) -> Option<()> {
        self.collapse(std::slice::from_ref(kernel));
        let before = self.frame.height(kernel);
        for q in self.frame.columns_mut() {
            map(q);
            flatten(gradient, q);
        }
        let lengths = self.frame.orthonormalise_living()?;
        for (j, length) in lengths.iter().enumerate() {
            if self.frame.is_alive(j) {
                self.growth.logs[j] += math::ln(*length);
            }
        }
        self.log_volume += math::ln(before / self.frame.height(kernel));
        Some(())
    }

    /// Whether the state has become so small that half the digits of its relative tolerance are
    /// lost in the absolute one.
    pub(super) fn is_to_be_refined(&mut self, step: &Step) -> bool {
        let solver = &self.settings.solver;
        let size = step.x_start.amax();
        self.largest.as_mut().is_some_and(|largest| {
            *largest = largest.max(size);
            let is_small = size < solver.rtol.sqrt() * *largest;
            is_small && solver.atol.largest() > MIN_ABSOLUTE && !step.mode.any_sticks()
        })
    }

    /// The orbit from here on, with an absolute tolerance that has fallen as the state has.
    pub(super) fn refine(
        &mut self,
        at: &Moment,
        t_end: f64,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        let size = at.x.amax();
        let solver = &mut self.settings.solver;
        if let Some(largest) = self.largest.replace(size) {
            let smaller = size / largest;
            solver.atol = solver.atol.map(|atol| (atol * smaller).max(MIN_ABSOLUTE));
        }
        let system = self.tangent.system;
        system.begin(at, t_end, solver, &[])
    }

    fn enter_stick(&mut self, jump: &Saltation) -> Option<()> {
        let size = jump.kick.norm();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let kernel = &jump.kick / size;
        self.project(&kernel, &jump.gradient, |q| *q = &jump.matrix * &*q)
    }
}

/// Whether a map of the state annihilates a direction, to rounding.
fn is_singular(jump: &Saltation) -> bool {
    jump.of_map == 0.0 || jump.determinant.abs() <= MATRIX_ROUNDING * jump.of_map.abs()
}

/// Orthonormal vectors that the map of a jump annihilates. At an impact of little speed, a change
/// of its time has a large effect, beside which all others are rounding. It is scaled to theirs.
fn kernel(jump: &Saltation) -> Option<Vec<Vector>> {
    let size = jump.gradient.norm();
    let normal = &jump.gradient / if size > 0.0 { size } else { 1.0 };
    let along = &jump.matrix * &normal;
    let others = &jump.matrix - &along * normal.transpose();
    let scale = f64::min(1.0, others.amax() / along.amax());
    let scale = if scale > 0.0 { scale } else { 1.0 };
    let svd = (others + along * normal.transpose() * scale).svd(false, true);
    let (values, rows) = (&svd.singular_values, svd.v_t?);
    // A map to a state that does not move has no other values than zero.
    let zero = MATRIX_ROUNDING * values.amax();
    let directions = values.iter().zip(rows.row_iter());
    let mut kernel: Vec<Vector> = Vec::new();
    for (_, row) in directions.filter(|(value, _)| **value <= zero) {
        let scaled = row.transpose();
        let mut direction = &scaled + &normal * (normal.dot(&scaled) * (scale - 1.0));
        for before in &kernel {
            flatten(before, &mut direction);
        }
        kernel.push(&direction / direction.norm());
    }
    Some(kernel)
}

impl Measurement<'_> {
    /// Carries the frame through a map of the state that annihilates directions, such as one that
    /// sets components to constants.
    fn annihilate(&mut self, jump: &Saltation) -> Option<()> {
        let kernel = kernel(jump)?;
        self.collapses += kernel.len();
        self.collapse(&kernel);
        self.frame.change_living(|q| *q = &jump.matrix * &*q);
        let lengths = self.frame.orthonormalise_living()?;
        for (j, length) in lengths.iter().enumerate() {
            if self.frame.is_alive(j) {
                let log = math::ln(*length);
                self.growth.logs[j] += log;
                self.log_volume += log;
            }
        }
        Some(())
    }

    /// A run that begins in stick was on Σ before: nothing across it survives. (The side from which
    /// it came decides the direction of projection, on which no exponent depends.) Nor is there
    /// anything along a discrete state.
    fn begin_on_boundary(&mut self, step: &Step) -> Option<()> {
        let (t, x) = (step.t_start, step.x_start.clone());
        let states = x.len();
        let discrete = (0..states).filter(|&state| self.tangent.system.is_discrete(state));
        let mut gradients: Vec<Vector> = discrete.map(|state| unit(states, state)).collect();
        gradients.extend(self.gradients(step.mode, &Moment { t, x }));
        for gradient in gradients {
            let kernel = &gradient / gradient.norm();
            self.project(&kernel, &gradient, |_| ())?;
        }
        for j in 0..self.frame.len() {
            if self.frame.is_alive(j) {
                self.growth.logs[j] = 0.0;
            }
        }
        self.log_volume = 0.0;
        Some(())
    }

    /// Orthogonalised gradients of the boundaries of sticking contacts.
    fn gradients(&self, mode: Modes, at: &Moment) -> Vec<Vector> {
        let mut across: Vec<Vector> = Vec::new();
        let system = self.tangent.system;
        let normals = system
            .normals(mode, at)
            .into_iter()
            .map(|(_, normal)| normal);
        let kept = system.kept(at).into_iter().map(|(_, gradient)| gradient);
        for mut gradient in normals.chain(kept) {
            for before in &across {
                flatten(before, &mut gradient);
            }
            across.push(gradient);
        }
        across
    }

    /// Projects the surviving vectors onto the boundaries of sticking contacts, from which rounding
    /// moves them. The sliding flow does not contract across a boundary. In a long stick, a vector
    /// that shrinks along it would otherwise become the rounding across it.
    fn stay_on_boundary(&mut self, step: &Step) {
        let gradients = self.gradients(step.mode, &step.end());
        self.frame.change_living(|q| {
            for gradient in &gradients {
                if gradient.dot(q).abs() > ACROSS_BOUNDARY * gradient.norm() * q.norm() {
                    flatten(gradient, q);
                }
            }
        });
    }

    /// Whether an orbit passes boundaries that do not move, and moves by less than its tolerances.
    /// The rounding of its states then decides on which side it is.
    fn is_lost(&mut self, at: &Transition) -> bool {
        let here = at.moment();
        let flow = self.tangent.system.flow(at.from, &here);
        let guards = flow.guards().into_iter();
        let mut guards = guards.filter(|guard| !guard.is_of_jump);
        let moves = guards.any(|guard| flow.guard_gradient(guard.number, &here).1 != 0.0);
        self.narrow.1 += usize::from(!moves && at.kind != TransitionKind::Jump);
        self.narrow.1 >= NARROW_TRANSITIONS
    }

    fn is_at_place(&self, x: &Vector) -> bool {
        let solver = &self.settings.solver;
        let mut parts = x.iter().zip(&self.narrow.0.x).enumerate();
        parts.all(|(i, (a, b))| (a - b).abs() <= solver.allowed(i, a.abs()))
    }

    /// Carries the frame over the last step of an orbit.
    pub(super) fn step(&mut self, step: &Step, orbit: &mut dyn OrbitUnderWay) -> Result<(), Error> {
        let is_stick = step.mode.any_sticks();
        if std::mem::take(&mut self.is_fresh) {
            self.begin_on_boundary(step)
                .ok_or_else(|| singular(step.t_end, &step.x_end))?;
        }
        if is_stick {
            self.stick_time += step.t_end - step.t_start;
        }
        if !(self.is_at_place(&step.x_start) && self.is_at_place(&step.x_end)) {
            self.narrow = (step.end(), 0);
        }
        self.carry(step, orbit)?;
        if !self.is_settling {
            self.growth.tick(step.t_end);
            self.reached = Some(step.end());
        }
        Ok(())
    }

    /// Carries the frame over a step or a part of it.
    ///
    /// Near an equilibrium a step may be so long that the direction of a vector is lost in the
    /// errors of the longer ones. The step is then halved.
    fn carry(&mut self, step: &Step, orbit: &mut dyn OrbitUnderWay) -> Result<(), Error> {
        let images = self.tangent.carried(step, self.frame.columns_mut());
        if self.parts.is_multiple_of(PARTS_PER_CHECK) && self.frame.shadow.is_some() {
            let sum = self.frame.columns_mut().iter().sum::<Vector>();
            let of_sum = self.tangent.carried(step, &[sum]).swap_remove(0);
            if let Some(shadow) = &mut self.frame.shadow {
                shadow.note_rounding(&images, of_sum);
            }
        }
        let before = self.frame.replace(images);
        self.stay_on_boundary(step);
        let error = self.tangent.error();
        let Some(lengths) = self.frame.orthonormalise_resolved(error) else {
            let t = 0.5 * (step.t_start + step.t_end);
            if !(step.t_start < t && t < step.t_end) {
                return Err(singular(step.t_end, &step.x_end));
            }
            self.frame.replace(before);
            let x = orbit.solution()(t);
            let mut second = step.clone();
            let first = second.cut(&Moment { t, x });
            self.carry(&first, orbit)?;
            return self.carry(&second, orbit);
        };
        self.parts += 1;
        let most = self.settings.solver.most_steps;
        if self.parts > most {
            let (name, t, x) = ("most_steps", step.t_end, Point::from(&step.x_end));
            return Err(Error::TooMany { name, most, t, x });
        }
        let is_full = self.frame.len() == self.tangent.system.states();
        let growth = if self.is_settling || !is_full {
            0.0
        } else {
            growth(self.tangent.system, step, &*orbit.solution())
        };
        self.divergence += growth;
        self.book(&lengths, growth);
        Ok(())
    }

    /// Carries the frame through a transition.
    pub(super) fn transition(&mut self, at: &Transition) -> Result<(), Error> {
        if self.is_lost(at) {
            let (t, x) = (self.narrow.0.t, Point::from(&self.narrow.0.x));
            return Err(Error::Shrunk { t, x });
        }
        let enters = at.kind == TransitionKind::StickEntry;
        self.stick_entries += usize::from(enters);
        let cause = self.last.cause_of(self.tangent.system, at);
        let columns = self.frame.columns_mut();
        let Some(jump) = self.tangent.passed(at, cause, columns)? else {
            return Ok(());
        };
        let passed = if enters {
            self.collapses += 1;
            self.enter_stick(&jump)
        } else if at.kind == TransitionKind::Jump && is_singular(&jump) {
            self.annihilate(&jump)
        } else {
            for q in self.frame.columns_mut() {
                *q = &jump.matrix * &*q;
            }
            let lengths = self.frame.orthonormalise();
            lengths.map(|lengths| self.book(&lengths, math::ln(jump.determinant.abs())))
        };
        passed.ok_or_else(|| singular(at.t, &at.x))
    }
}
