//! One orbit as the estimator and the verdict on its class need it.

use std::ops::ControlFlow;

use super::plan::{DT, Group, Integrator, Plan};
use crate::error::Error;
use crate::filippov::{AtRepelling, Observer, Options, StepRecord, run};
use crate::models::{BlockAndBracket, Caption};
use crate::orbit::Ending;
use crate::paper::in_place::{InPlace, Lost};
use crate::system::State;

type X = State<f64, 4>;

/// Larger components mean that the orbit has left for good.
const BOUND: f64 = 1e3;
/// Orbits that take more steps of the exact solver are given up.
const MOST_STEPS: usize = 2_000_000;
/// Parts of a step in which a zero of the velocity is looked for.
const PARTS: usize = 4;
/// Halvings that locate it.
const HALVINGS: usize = 40;

/// The series and the returns to `x₂ = 0` from above.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// States 0.2 apart.
    pub series: Vec<[f64; 4]>,
    /// `(x₁, x₃, x₄)` at the returns.
    pub section: Vec<[f64; 3]>,
}

/// What came of an orbit.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It stayed to the end.
    Bounded(Trajectory),
    /// It left for infinity.
    Escaped,
    /// It could not be followed: transitions pile up, the step collapses, or it takes too long.
    Failed,
    /// The time limit of the whole search was reached.
    Interrupted,
}

/// Follows the orbit of a caption.
pub fn follow(group: &Group, caption: &Caption, plan: &Plan, late: &dyn Fn() -> bool) -> Outcome {
    let Ok(system) = BlockAndBracket::from_caption(caption, &group.reading) else {
        return Outcome::Failed;
    };
    let start = State::from(caption.start);
    match group.integrator {
        Integrator::Exact => exact(&system, start, plan, late),
        Integrator::InPlace(h) => in_place(&system, start, h, plan, late),
    }
}

fn exact(system: &BlockAndBracket, start: X, plan: &Plan, late: &dyn Fn() -> bool) -> Outcome {
    let mut watch = Watch {
        from: plan.from,
        points: plan.points,
        steps: 0,
        kept: Trajectory::default(),
        late,
        interrupted: false,
    };
    // Where friction drives the block away from the belt, either side is as good as the other.
    let options = Options::tol(1e-9)
        .escape(BOUND)
        .at_repelling(AtRepelling::GoBelow);
    // A little beyond the last point, so that rounding cannot leave it out.
    let t_end = plan.from + plan.points as f64 * DT;
    let outcome = run(system, 0.0, start, t_end, &options, &mut watch);
    if watch.interrupted {
        return Outcome::Interrupted;
    }
    match outcome {
        Ok(summary) if summary.ending == Ending::EndTime => Outcome::Bounded(watch.kept),
        Ok(_) => Outcome::Failed,
        Err(Error::Escaped { .. }) => Outcome::Escaped,
        Err(_) => Outcome::Failed,
    }
}

struct Watch<'a> {
    from: f64,
    points: usize,
    steps: usize,
    kept: Trajectory,
    late: &'a dyn Fn() -> bool,
    interrupted: bool,
}

impl Observer<4> for Watch<'_> {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        self.steps += 1;
        self.interrupted = self.steps.is_multiple_of(1024) && (self.late)();
        if self.interrupted || self.steps > MOST_STEPS {
            return ControlFlow::Break(());
        }
        while self.kept.series.len() < self.points {
            let due = self.from + self.kept.series.len() as f64 * DT;
            if due > step.t_end {
                break;
            }
            self.kept.series.push(step.dense.at_time(due).into());
        }
        if step.t_start >= self.from {
            self.look_for_returns(step);
        }
        ControlFlow::Continue(())
    }
}

impl Watch<'_> {
    fn look_for_returns(&mut self, step: &StepRecord<4>) {
        let length = step.t_end - step.t_start;
        let time = |k: usize| step.t_start + length * k as f64 / PARTS as f64;
        let mut left = step.x_start[1];
        for k in 0..PARTS {
            let right = if k + 1 == PARTS {
                step.x_end[1]
            } else {
                step.dense.at_time(time(k + 1))[1]
            };
            if left > 0.0 && right <= 0.0 {
                let (mut a, mut b) = (time(k), time(k + 1));
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (a + b);
                    if step.dense.at_time(middle)[1] > 0.0 {
                        a = middle;
                    } else {
                        b = middle;
                    }
                }
                let x = step.dense.at_time(b);
                self.kept.section.push([x[0], x[2], x[3]]);
            }
            left = right;
        }
    }
}

/// Every so many passes are a point, as the listing counts its records; its clock loses a little at every Hénon step.
fn in_place(
    system: &BlockAndBracket,
    start: X,
    h: f64,
    plan: &Plan,
    late: &dyn Fn() -> bool,
) -> Outcome {
    let passes = |t: f64| (t / h).round() as usize;
    let (first, every) = (passes(plan.from), passes(DT).max(1));
    let last = first + (plan.points - 1) * every;
    let mut scheme = InPlace::start(system, start, h, BOUND);
    let mut kept = Trajectory::default();
    for pass in 0..=last {
        if pass >= first && (pass - first).is_multiple_of(every) {
            kept.series.push((*scheme.x()).into());
        }
        if pass.is_multiple_of(1 << 16) && late() {
            return Outcome::Interrupted;
        }
        let before = *scheme.x();
        match scheme.advance() {
            Ok(()) => {}
            Err(Lost::Escaped { .. }) => return Outcome::Escaped,
            Err(Lost::BrokenDown { .. }) => return Outcome::Failed,
        }
        let after = scheme.x();
        if pass >= first && before[1] > 0.0 && after[1] <= 0.0 {
            let x = before + (after - before) * (before[1] / (before[1] - after[1]));
            kept.section.push([x[0], x[2], x[3]]);
        }
    }
    Outcome::Bounded(kept)
}
