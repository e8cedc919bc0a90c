//! Events near times of the data: the residuals jump where one passes the other.

use crate::study::least_squares::{LeastSquares, LeastSquaresSettings, least_squares};
use stickslip::dynamics::Vector;
use stickslip::error::readable;

use super::Modelled;
use super::directions::Directions;
use super::problem::{FitProblem, Sequence};
use super::record_run::ObservedJump;
use super::uncertainty::JUMP;
use super::work::FitWork;

/// Standard errors of its time within which an event may pass a time of the data. It is chosen:
/// beyond there is one case in 400.
const REACH: f64 = 3.0;

/// Error of the time of an event over the tolerance and the time.
const ERROR_OF_TIME: f64 = 1e3;

/// Most searches on the other side of events, and most steps onto that side. They are chosen: each
/// further one has to lower the cost.
const MOST_SIDES: usize = 8;
const MOST_STEPS: usize = 24;

/// A value of the data that the event beside it may pass.
pub(super) struct Passable<'a> {
    record: usize,
    observable: usize,
    /// Time of the value.
    t: f64,
    jump: &'a ObservedJump,
    /// Standard error of the event's time.
    error: f64,
    /// Index of the residual.
    residual: usize,
    /// Decrease of twice the cost where the event passes.
    gain: f64,
}

impl Passable<'_> {
    /// Standard errors from the event to the value.
    fn away(&self) -> f64 {
        (self.t - self.jump.t).abs() / self.error
    }

    /// The passage in words.
    pub(super) fn describe(&self, problem: &FitProblem<'_>) -> String {
        let record = &problem.records[self.record];
        let number = self.jump.number.map(|jump| record.system.contacts() + jump);
        let event = number.map(|number| format!("`{}`", record.system.contact_name(number)));
        let observable = &problem.request.observables[self.observable].name;
        let [t, at] = [self.t, self.jump.t].map(readable);
        let which = match self.gain > 0.0 {
            true => "is fitted better beyond",
            false => "may be beyond",
        };
        format!(
            "{}: the value of {observable} at {t} {which} the event {} at {at} (± {:.0e}), at \
             which it jumps",
            record.name,
            event.as_deref().unwrap_or("there"),
            self.error,
        )
    }
}

/// The values that an event beside them may pass: within some standard errors of its time, or
/// further where the value is fitted better beyond it. `directions` are the changes of the unknowns
/// by one standard deviation each.
pub(super) fn passable<'a>(
    problem: &FitProblem<'_>,
    at: &'a Modelled,
    directions: &[Vector],
) -> Vec<Passable<'a>> {
    let loss = problem.loss();
    let (mut found, mut residual) = (Vec::new(), 0);
    for (number, (record, jumps)) in problem.records.iter().zip(&at.jumps).enumerate() {
        let error = |jump: &ObservedJump| {
            let along = |direction: &Vector| {
                let parts = jump.slopes.iter().zip(direction);
                parts.map(|(slope, part)| slope * part).sum::<f64>()
            };
            let squares = directions.iter().map(along).map(|change| change * change);
            squares.sum::<f64>().sqrt()
        };
        let errors: Vec<f64> = jumps.iter().map(error).collect();
        for (observable, (column, sigma)) in record.columns.iter().zip(&problem.sigmas).enumerate()
        {
            for (t, _) in record.times.iter().zip(column).filter(|(_, x)| !x.is_nan()) {
                let r = at.residuals[residual];
                let next = jumps.partition_point(|jump| jump.t <= *t);
                // The change of the residual as the event passes the value.
                let sides = [(next.checked_sub(1), -1.0), (Some(next), 1.0)];
                for (beside, sign) in sides {
                    let Some((jump, &error)) = beside.and_then(|k| jumps.get(k).zip(errors.get(k)))
                    else {
                        continue;
                    };
                    let change = jump.changes[observable] / sigma;
                    let gain = 2.0 * (loss.of(r).0 - loss.of(r + sign * change).0);
                    let rounding = ERROR_OF_TIME * problem.tolerance() * t.abs();
                    let reach = (REACH * REACH + gain.max(0.0)).sqrt() * error + rounding;
                    if change.abs() > JUMP && (t - jump.t).abs() <= reach {
                        found.push(Passable {
                            record: number,
                            observable,
                            t: *t,
                            jump,
                            error,
                            residual,
                            gain,
                        });
                    }
                }
                residual += 1;
            }
        }
    }
    found
}

/// The lowest minimum that is found beyond events near values that are fitted better there.
///
/// From a minimum, the search goes on without these values, and from there with all of them, also
/// with the events stepped across the values.
pub(super) fn beyond_events(
    problem: &FitProblem<'_>,
    mut best: LeastSquares<Sequence>,
    settings: &LeastSquaresSettings,
    work: &mut FitWork,
) -> LeastSquares<Sequence> {
    for _ in 0..MOST_SIDES {
        let here = beyond(problem, &best.x, work);
        let Some(wrong) = here.and_then(|at| better_beyond(problem, &at)) else {
            break;
        };
        let Some(settings) = work.settings_left(settings) else {
            break;
        };
        let without = least_squares(&best.x, &settings, |x| {
            let mut at = problem.residuals(x)?;
            for &(row, ..) in &wrong {
                at.values[row] = 0.0;
                at.jacobian.row_mut(row).fill(0.0);
            }
            Ok::<_, super::record_run::Failed>(at)
        });
        let Ok(without) = without else {
            break;
        };
        work.add(&without);
        let start = stepped(problem, without.x, work);
        let Some(settings) = work.settings_left(&settings) else {
            break;
        };
        let Ok(again) = least_squares(&start, &settings, |x| problem.residuals(x)) else {
            break;
        };
        work.add(&again);
        // A search that is cut off there reports so: the minimum before it is one of a wrong side.
        if again.cost.is_nan() || again.cost >= best.cost {
            break;
        }
        best = again;
    }
    best
}

/// The point of lowest cost on a way on which events step across values that are fitted better
/// beyond them, the furthest first.
fn stepped(problem: &FitProblem<'_>, mut x: Vector, work: &mut FitWork) -> Vector {
    let (mut lowest, mut best) = (f64::INFINITY, x.clone());
    for _ in 0..=MOST_STEPS {
        let Some(at) = beyond(problem, &x, work) else {
            break;
        };
        let has_slopes = at.jacobian.iter().all(|slope| slope.is_finite());
        let cost = problem.cost_of_data(&at.residuals);
        if has_slopes && cost < lowest {
            (lowest, best) = (cost, x.clone());
        }
        let wrong = better_beyond(problem, &at).into_iter().flatten();
        let Some((_, _, step)) = wrong.max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        x += step;
        for (x, (low, high)) in x.iter_mut().zip(problem.unknowns.bounds()) {
            *x = x.clamp(low, high);
        }
    }
    best
}

/// Everything at a point, with events until after the data: an evaluation. None where it fails, no
/// evaluation is left, or no observable jumps.
fn beyond(problem: &FitProblem<'_>, x: &Vector, work: &mut FitWork) -> Option<Modelled> {
    if !problem.may_jump() || work.left() == 0 {
        return None;
    }
    work.evaluations += 1;
    problem.modelled_beyond(x).ok()
}

/// The residuals of values that are fitted better beyond an event. Each comes with the standard
/// errors of the event's time to there, and with the likeliest step of the unknowns that takes it
/// there. None where there are no such values.
fn better_beyond(problem: &FitProblem<'_>, at: &Modelled) -> Option<Vec<(usize, f64, Vector)>> {
    let directions = Directions::of(&at.jacobian, problem.mismatches(), problem.tolerance());
    let directions = directions.ok()?.determined;
    let all = passable(problem, at, &directions);
    let wrong = all
        .into_iter()
        .filter(|one| one.gain > 0.0 && one.error > 0.0);
    let steps = wrong.map(|one| {
        let slopes = Vector::from_column_slice(&one.jump.slopes);
        let way = one.t - one.jump.t;
        let past = ERROR_OF_TIME * problem.tolerance() * one.t.abs();
        let way = way + past.copysign(way);
        let mut step = Vector::zeros(slopes.len());
        for direction in &directions {
            step += direction * (direction.dot(&slopes) * way / (one.error * one.error));
        }
        (one.residual, one.away(), step)
    });
    let steps: Vec<_> = steps.collect();
    (!steps.is_empty()).then_some(steps)
}
