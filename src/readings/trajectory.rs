//! One orbit as the estimator and the verdict on its class need it.

use std::ops::ControlFlow;

use super::plan::{DT, Group, Integrator, Plan};
use super::scheme;
use super::verdict::Verdict;
use crate::correlation::correlation_dimension;
use crate::turns::Turns;
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::analysis::{Exponent, SpectrumOptions, lyapunov_spectrum_watched};
use stickslip::error::Error;
use stickslip::filippov::{AtRepelling, Method, Observer, Options, StepRecord, run};
use stickslip::models::{BlockAndBracket, Caption};
use stickslip::orbit::Ending;
use stickslip::system::State;

type X = State<4>;

/// Larger components mean that the orbit has left for good.
pub const BOUND: f64 = 1e3;
/// Orbits that take more steps are given up: the shortest fixed steps, and one for each of some
/// hundred thousand events.
pub const MOST_STEPS: usize = 3_000_000;

/// An orbit that stayed to the end.
#[derive(Clone, Debug)]
pub struct Bounded {
    /// States 0.2 apart.
    pub series: Vec<[f64; 4]>,
    /// Class of the motion.
    pub class: Class,
    /// Half the extent of x₁.
    pub amplitude: f64,
    /// Correlation dimension of the returns to `x₂ = 0` from above; NaN where they close.
    pub dimension: f64,
}

impl Bounded {
    /// From the series, times and states of the returns, and the class.
    pub fn new(series: Vec<[f64; 4]>, section: &[(f64, [f64; 4])], class: Class) -> Bounded {
        let x1 = || series.iter().map(|x| x[0]);
        let amplitude = 0.5 * (x1().fold(f64::MIN, f64::max) - x1().fold(f64::MAX, f64::min));
        let dimension = match class {
            Class::Periodic(_) => f64::NAN,
            _ => {
                let points: Vec<[f64; 4]> = section.iter().map(|(_, x)| *x).collect();
                correlation_dimension(&points)
            }
        };
        Bounded {
            series,
            class,
            amplitude,
            dimension,
        }
    }
}

/// What came of an orbit.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It stayed to the end.
    Bounded(Bounded),
    /// It left for infinity; when it was last within the bound.
    Escaped(f64),
    /// It could not be followed: transitions pile up, the step collapses, or it takes too long.
    Failed,
}

impl Outcome {
    /// As the table has it.
    pub fn verdict(&self) -> Verdict {
        match self {
            Outcome::Bounded(motion) => Verdict::Motion(motion.class),
            Outcome::Escaped(_) => Verdict::Escaped,
            Outcome::Failed => Verdict::Failed,
        }
    }
}

/// Follows the orbit of a caption.
pub fn follow(group: &Group, caption: &Caption, plan: &Plan) -> Outcome {
    let Ok(system) = BlockAndBracket::from_caption(caption, &group.reading) else {
        return Outcome::Failed;
    };
    let start = State::from(caption.start);
    match group.integrator {
        Integrator::Exact => solved(&system, start, plan, Method::Dop853),
        Integrator::FourthOrder(step) => solved(&system, start, plan, Method::Rk4 { step }),
        Integrator::InPlace(h) => scheme::follow(&system, start, h, plan),
    }
}

/// Tolerance of the exact solver, as in the figures.
pub const TOLERANCE: f64 = 1e-10;

/// By the library's solver, which locates Σ by Hénon's step.
fn solved(system: &BlockAndBracket, start: X, plan: &Plan, method: Method) -> Outcome {
    // Where friction drives the block away from the belt, either side is as good as the other.
    let options = Options::tol(TOLERANCE)
        .method(method)
        .escape(BOUND)
        .at_repelling(AtRepelling::GoBelow);
    let t_end = plan.from + plan.duration();
    // The spectrum tells nothing of its transient: whether the orbit can be followed at all is found out without it.
    let mut alone = Watch::new(system, &options, plan);
    let stayed = run(system, 0.0, start, t_end, &options, &mut alone);
    match stayed.map_err(Error::from) {
        Ok(summary) if summary.ending == Ending::EndTime => {}
        Ok(_) => return Outcome::Failed,
        Err(Error::Escaped { t, .. }) => return Outcome::Escaped(t),
        Err(_) => return Outcome::Failed,
    }
    let settings = SpectrumOptions::over(plan.from, plan.duration()).solver(options);
    let mut watch = Watch::new(system, &options, plan);
    let spectrum = lyapunov_spectrum_watched(system, (0.0, start), &settings, &mut watch);
    match spectrum {
        Ok(spectrum) if spectrum.summary.ending == Ending::EndTime => {
            watch.bounded(&spectrum.exponents, spectrum.duration)
        }
        // An orbit whose tangent vectors cannot be followed still has a series and a section.
        _ => alone.bounded(&[], plan.duration()),
    }
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

    fn bounded(self, exponents: &[Exponent], duration: f64) -> Outcome {
        let (section, spectrum) = (self.turns.points, (Of::Flow, exponents, duration));
        let class = Evidence::gather(&section, spectrum, &Criterion::default()).class();
        Outcome::Bounded(Bounded::new(self.series, &section, class))
    }
}
