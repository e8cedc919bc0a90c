//! One orbit as the estimator and the verdict on its class need it.

use std::ops::ControlFlow;

use super::plan::{DT, Group, Integrator, Plan};
use super::scheme;
use crate::turns::Turns;
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum_watched};
use stickslip::error::Error;
use stickslip::filippov::{AtRepelling, Observer, Options, StepRecord, run};
use stickslip::models::{BlockAndBracket, Caption};
use stickslip::orbit::Ending;
use stickslip::system::State;

type X = State<4>;

/// Larger components mean that the orbit has left for good.
pub const BOUND: f64 = 1e3;
/// Orbits that take more steps of the exact solver are given up.
pub const MOST_STEPS: usize = 2_000_000;

/// The series and the returns to `x₂ = 0` from above.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// States 0.2 apart.
    pub series: Vec<[f64; 4]>,
    /// Times and states of the returns.
    pub section: Vec<(f64, [f64; 4])>,
}

/// What came of an orbit.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It stayed to the end: its series, and the class of its motion.
    Bounded(Vec<[f64; 4]>, Class),
    /// It left for infinity.
    Escaped,
    /// It could not be followed: transitions pile up, the step collapses, or it takes too long.
    Failed,
}

/// Follows the orbit of a caption.
pub fn follow(group: &Group, caption: &Caption, plan: &Plan) -> Outcome {
    let Ok(system) = BlockAndBracket::from_caption(caption, &group.reading) else {
        return Outcome::Failed;
    };
    let start = State::from(caption.start);
    match group.integrator {
        Integrator::Exact => exact(&system, start, plan),
        Integrator::InPlace(h) => scheme::follow(&system, start, h, plan),
    }
}

/// Tolerance of the exact solver, as in the figures.
pub const TOLERANCE: f64 = 1e-10;

fn exact(system: &BlockAndBracket, start: X, plan: &Plan) -> Outcome {
    // Where friction drives the block away from the belt, either side is as good as the other.
    let options = Options::tol(TOLERANCE)
        .escape(BOUND)
        .at_repelling(AtRepelling::GoBelow);
    let t_end = plan.from + plan.duration();
    // The spectrum tells nothing of its transient: whether the orbit can be followed at all is found out without it.
    let mut alone = Watch::new(system, &options, plan);
    let stayed = run(system, 0.0, start, t_end, &options, &mut alone);
    match stayed.map_err(Error::from) {
        Ok(summary) if summary.ending == Ending::EndTime => {}
        Ok(_) => return Outcome::Failed,
        Err(Error::Escaped { .. }) => return Outcome::Escaped,
        Err(_) => return Outcome::Failed,
    }
    let settings = SpectrumOptions::over(plan.from, plan.duration()).solver(options);
    let mut watch = Watch::new(system, &options, plan);
    let spectrum = lyapunov_spectrum_watched(system, (0.0, start), &settings, &mut watch);
    match spectrum {
        Ok(spectrum) if spectrum.summary.ending == Ending::EndTime => {
            bounded(watch.kept(), &spectrum.exponents, spectrum.duration)
        }
        // An orbit whose tangent vectors cannot be followed still has a series and a section.
        _ => bounded(alone.kept(), &[], plan.duration()),
    }
}

fn bounded(kept: Trajectory, exponents: &[Exponent], duration: f64) -> Outcome {
    let spectrum = (Of::Flow, exponents, duration);
    let evidence = Evidence::gather(&kept.section, spectrum, &Criterion::default());
    Outcome::Bounded(kept.series, evidence.class())
}

struct Watch<'a> {
    from: f64,
    points: usize,
    steps: usize,
    series: Vec<[f64; 4]>,
    turns: Turns<'a>,
}

impl Observer<4> for Watch<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return ControlFlow::Break(());
        }
        while self.series.len() < self.points {
            // A quotient, not a sum of steps: the last of them is the end itself.
            let due = self.from + self.series.len() as f64 / (1.0 / DT);
            if due > step.t_end {
                break;
            }
            let x = if due == step.t_end {
                step.x_end
            } else {
                step.dense.at_time(due)
            };
            self.series.push(x.into());
        }
        if step.t_start >= self.from {
            self.turns.step(step);
        }
        ControlFlow::Continue(())
    }
}

impl<'a> Watch<'a> {
    fn new(system: &'a BlockAndBracket, options: &Options, plan: &Plan) -> Self {
        Watch {
            from: plan.from,
            points: plan.points,
            steps: 0,
            series: Vec::new(),
            turns: Turns::new(system, options),
        }
    }

    fn kept(self) -> Trajectory {
        Trajectory {
            series: self.series,
            section: self.turns.points,
        }
    }
}
