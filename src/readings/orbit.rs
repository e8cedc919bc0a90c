//! Orbits of the three captions, computed by each integrator.

use std::ops::ControlFlow;

use super::plan::{CURVE_DIMENSION, Group, Integrator, Plan, SECTION_TOLERANCE, STEP_LIMIT};
use super::table::OrbitVerdict;
use crate::figures::block_and_bracket::{DIVERGED, DT, TOLERANCE};
use crate::motion::{Class, Criterion, Evidence, SystemKind};
use crate::numbers::extent;
use crate::orbit_records::{Samples, TurningPoints};
use crate::paper::in_place::{Breakdown, InPlace};
use crate::paper::models::{BlockAndBracket, Caption};
use numerics::PowerLaw;
use stickslip::analysis::{Exponent, Spectrum, SpectrumOptions};
use stickslip::math;
use stickslip::{AtRepelling, Ending, Error, Method, Observer, Options, State, StepRecord, run};

/// An orbit that stays bounded to the end.
#[derive(Clone, Debug)]
pub struct Bounded {
    /// States at intervals of 0.2.
    pub series: Vec<[f64; 4]>,
    /// Class of the motion.
    pub class: Class,
    /// Half the extent of x₁.
    pub amplitude: f64,
    /// Correlation dimension of the returns to `x₂ = 0` from above; NaN if the section closes.
    pub dimension: f64,
}

impl Bounded {
    /// Measures the orbit of a series, with times and states of the returns, and the class.
    pub fn new(series: Vec<[f64; 4]>, section: &[(f64, [f64; 4])], class: Class) -> Bounded {
        let (low, high) = extent(series.iter().map(|x| x[0]));
        let points: Vec<[f64; 4]> = section.iter().map(|(_, x)| *x).collect();
        let dimension = match class {
            Class::Periodic(_) => f64::NAN,
            _ => correlation_dimension(&points),
        };
        Bounded {
            series,
            class,
            amplitude: 0.5 * (high - low),
            dimension,
        }
    }
}

/// Outcome of an orbit.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Stays bounded to the end.
    Bounded(Bounded),
    /// Diverges; the last time within the bound.
    Escaped(f64),
    /// Cannot be integrated: transitions accumulate, the step collapses, or too many steps are
    /// needed.
    Failed,
}

impl Outcome {
    /// The entry in the table.
    pub fn verdict(&self) -> OrbitVerdict {
        match self {
            Outcome::Bounded(motion) => OrbitVerdict::Motion(motion.class),
            Outcome::Escaped(_) => OrbitVerdict::Escaped,
            Outcome::Failed => OrbitVerdict::Failed,
        }
    }
}

/// Computes the orbit of a caption.
pub fn follow(group: &Group, caption: &Caption, plan: &Plan) -> Outcome {
    let Ok(system) = BlockAndBracket::from_caption(caption, &group.reading) else {
        return Outcome::Failed;
    };
    let start = State::from(caption.start);
    match group.integrator {
        Integrator::Exact => solved(&system, start, plan, Method::Dop853),
        Integrator::FourthOrder(step) => solved(&system, start, plan, Method::Rk4 { step }),
        Integrator::InPlace(h) => in_place(&system, start, h, plan),
    }
}

/// Integrates by the library's solver, which locates Σ with Hénon's step.
fn solved(system: &BlockAndBracket, start: State<4>, plan: &Plan, method: Method) -> Outcome {
    // Where friction drives the block away from the belt, either side may be chosen.
    let options = Options::tol(TOLERANCE)
        .method(method)
        .escape(DIVERGED)
        .at_repelling(AtRepelling::GoBelow);
    let t_end = plan.from + plan.duration();
    // The spectrum does not report its transient. A run without it decides whether the orbit can be
    // integrated at all.
    let mut alone = OrbitRecorder::new(system, &options, plan);
    let stayed = run(system, 0.0, start, t_end, &options, &mut alone);
    match stayed.map_err(Error::from) {
        Ok(summary) if summary.ending == Ending::EndTime => {}
        Err(Error::Escaped { t, .. }) => return Outcome::Escaped(t),
        _ => return Outcome::Failed,
    }
    let settings = SpectrumOptions::over(plan.from, plan.duration()).solver(options);
    let mut watch = OrbitRecorder::new(system, &options, plan);
    let spectrum = Spectrum::watched(system, (0.0, start), &settings, &mut watch);
    match spectrum {
        Ok(spectrum) if spectrum.summary.ending == Ending::EndTime => {
            watch.bounded(&spectrum.exponents, spectrum.duration)
        }
        // An orbit whose tangent vectors cannot be integrated still has a series and a section.
        _ => alone.bounded(&[], plan.duration()),
    }
}

struct OrbitRecorder<'a> {
    from: f64,
    steps: usize,
    samples: Samples,
    turns: TurningPoints<'a>,
}

impl Observer<4> for OrbitRecorder<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.steps += 1;
        if self.steps > STEP_LIMIT {
            return ControlFlow::Break(());
        }
        self.samples.step(step);
        if step.t_start >= self.from {
            self.turns.step(step);
        }
        ControlFlow::Continue(())
    }
}

impl<'a> OrbitRecorder<'a> {
    fn new(system: &'a BlockAndBracket, options: &Options, plan: &Plan) -> Self {
        OrbitRecorder {
            from: plan.from,
            steps: 0,
            samples: Samples::new(plan.from, DT, plan.points),
            turns: TurningPoints::new(system, options),
        }
    }

    fn bounded(self, exponents: &[Exponent], duration: f64) -> Outcome {
        let (section, spectrum) = (self.turns.points, (SystemKind::Flow, exponents, duration));
        let class = Evidence::gather(&section, spectrum, &Criterion::default()).class();
        Outcome::Bounded(Bounded::new(self.samples.states, &section, class))
    }
}

/// A return to `x₂ = 0` from above between two states, by linear interpolation.
fn crossing(before: &State<4>, after: &State<4>) -> Option<State<4>> {
    let falls = before[1] > 0.0 && after[1] <= 0.0;
    falls.then(|| before + (after - before) * (before[1] / (before[1] - after[1])))
}

/// Runs the scheme. One of several passes is a point, as the listing counts its records.
fn in_place(system: &BlockAndBracket, start: State<4>, h: f64, plan: &Plan) -> Outcome {
    let steps = |t: f64| (t / h).round() as usize;
    let (first, every) = (steps(plan.from), steps(DT).max(1));
    let last = first + (plan.points - 1) * every;
    let mut scheme = InPlace::start(system, start, h, DIVERGED);
    let (mut series, mut section) = (Vec::new(), Vec::new());
    for pass in 0..=last {
        if pass >= first && (pass - first).is_multiple_of(every) {
            series.push(scheme.x.into());
        }
        let before = scheme.x;
        match scheme.advance() {
            Ok(()) => {}
            Err(Breakdown::Escaped { t }) => return Outcome::Escaped(t),
            Err(Breakdown::NotFinite { .. }) => return Outcome::Failed,
        }
        if let Some(at) = crossing(&before, &scheme.x).filter(|_| pass >= first) {
            section.push((scheme.t, at.into()));
        }
    }
    let criterion = Criterion {
        same: SECTION_TOLERANCE,
        ..Criterion::default()
    };
    let closing = Evidence::gather(&section, (SystemKind::ReturnMap, &[], 1.0), &criterion).class();
    let mut motion = Bounded::new(series, &section, closing);
    motion.class = match closing {
        Class::Undecided if motion.dimension < CURVE_DIMENSION => Class::QuasiPeriodic,
        Class::Undecided if motion.dimension >= CURVE_DIMENSION => Class::Chaotic,
        closing => closing,
    };
    Outcome::Bounded(motion)
}

/// Range of C(r) in which the slope is taken: beyond the scatter of the few nearest pairs, and well
/// within the set.
const FITTED_SHARES: (f64, f64) = (2e-3, 2e-2);
/// Radii at which it is measured: a dozen per decade average out the scatter.
const FITTED_RADII: u32 = 12;

/// The correlation dimension (Grassberger & Procaccia 1983): the slope of ln C(r). C is the
/// fraction of pairs of points nearer than r in every component.
fn correlation_dimension<const N: usize>(points: &[[f64; N]]) -> f64 {
    let mut distances = Vec::with_capacity(points.len() * points.len().saturating_sub(1) / 2);
    for (i, one) in points.iter().enumerate() {
        for other in &points[i + 1..] {
            let apart = one.iter().zip(other).map(|(a, b)| (a - b).abs());
            distances.push(apart.fold(0.0, f64::max));
        }
    }
    distances.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * distances.len() as f64) as usize;
        distances.get(index).copied().unwrap_or(f64::NAN)
    };
    let ratio = FITTED_SHARES.1 / FITTED_SHARES.0;
    let shares = (0..FITTED_RADII).map(|k| f64::from(k) / f64::from(FITTED_RADII - 1));
    let shares = shares.map(|part| FITTED_SHARES.0 * math::pow(ratio, part));
    PowerLaw::through(shares.map(|share| (at(share), share))).exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dimension_of_a_filled_square_is_two() {
        // A low-discrepancy sequence.
        let square: Vec<[f64; 2]> = (1..1200)
            .map(|k| {
                [
                    (0.754_877_67 * f64::from(k)).fract(),
                    (0.569_840_29 * f64::from(k)).fract(),
                ]
            })
            .collect();
        let dimension = correlation_dimension(&square);
        assert!((dimension - 2.0).abs() < 0.3, "{dimension}");
    }
}
