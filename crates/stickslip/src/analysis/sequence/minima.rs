//! The smallest values of the guards within the phases of a periodic orbit, and at their ends where these are another contact's.

use super::margin::{Key, Margin, Site};
use crate::dynamics::{Dynamics, Guard, Moment, Orbit, Step, Transition, Vector};

/// Samples of a step by which the minima of its guards are sought.
const SAMPLES: usize = 8;

/// Part of a step within which two minima are one.
const NEXT_TO: f64 = 1e-6;

/// The smallest values of all guards within the phases, and at their ends where these are another contact's.
pub(super) fn minima(system: &dyn Dynamics, orbit: &Orbit, turns: &[Transition]) -> Vec<Margin> {
    let mut found: Vec<Margin> = Vec::new();
    let last = turns.len().saturating_sub(1);
    // The period is cut in the middle of a phase: what ends with the last step goes on with the first.
    let mut rates = match (orbit.steps.first(), orbit.steps.last()) {
        (Some((first, _)), Some((last, solution))) if first.mode == last.mode => {
            minima_of(system, (last, solution), &[], [None; 2]).rates
        }
        _ => Vec::new(),
    };
    let switched = |t: f64| turns.iter().find(|at| at.t == t).map(|at| at.contact);
    for (step, solution) in &orbit.steps {
        // Before the first transition it is the last part that goes on.
        let passed = turns.iter().filter(|at| at.t <= step.t_start).count();
        let part = passed.checked_sub(1).unwrap_or(last);
        let ends = [step.t_start, step.t_end].map(switched);
        let before = if ends[0].is_some() { &[][..] } else { &rates };
        let of_step = minima_of(system, (step, solution), before, ends);
        rates = of_step.rates;
        for Minimum {
            site,
            guard,
            other,
            at,
            value,
            scale,
        } in of_step.minima
        {
            let same = |margin: &&Margin| margin.key.part == part && margin.key.site == site;
            // At the end of a step rounding may have seen it, and sees it again at the beginning of the next.
            let near = NEXT_TO * (step.t_end - step.t_start);
            let is_near = |margin: &Margin| (margin.at.t - at.t).abs() <= near;
            if found.iter().rfind(same).is_some_and(is_near) {
                continue;
            }
            let contact = guard.contact;
            let turns_at = |t: f64| turns.iter().filter(move |turn| turn.t == t);
            // What another contact's switch lets go, or what switches with it, leaves zero or comes to it.
            let switches = match site {
                Site::Begin(_) => {
                    turns_at(at.t).any(|turn| turn.from.get(contact) != turn.to.get(contact))
                }
                Site::End(_) => turns_at(at.t).any(|turn| turn.contact == contact),
                _ => false,
            };
            if switches {
                continue;
            }
            let count = found.iter().filter(same).count();
            found.push(Margin {
                key: Key { part, site, count },
                value,
                scale,
                by_rounding: 0.0,
                off: 0.0,
                incoming: step.mode,
                contact,
                other,
                at,
                is_contact_function: guard.goes_on,
            });
        }
    }
    found
}

/// The minima of the guards of a step's mode within it, of a step with its solution. `before` has
/// the rates of the guards at the end of the step before, where that is of the same phase; `ends`
/// the contacts with whose transitions a phase begins with the step, and ends with it.
fn minima_of(
    system: &dyn Dynamics,
    (step, solution): (&Step, &dyn Fn(f64) -> Vector),
    before: &[f64],
    ends: [Option<usize>; 2],
) -> OfStep {
    let length = step.t_end - step.t_start;
    let moment = |t: f64| Moment { t, x: solution(t) };
    let place = |s: f64| moment(step.t_start + s * length);
    let middle = moment(0.5 * (step.t_start + step.t_end));
    let flow = system.flow(step.mode, &middle);
    let mut found = Vec::new();
    let mut rates = Vec::new();
    for (k, guard) in flow.guards().into_iter().enumerate() {
        let jet = |s: f64| flow.guard_jet(guard.number, &place(s));
        // A guard may leave zero without a rate where a phase begins.
        let first = usize::from(ends[0].is_some());
        let samples: Vec<_> = (first..=SAMPLES)
            .map(|k| {
                let s = k as f64 / SAMPLES as f64;
                (s, jet(s))
            })
            .collect();
        let sizes = samples.iter().map(|(_, jet)| jet[0].abs());
        let scale = sizes.fold(f64::MIN_POSITIVE, f64::max);
        // A step may end at a minimum, and rounding take its rate there for one of either sign.
        let falls = before.get(k).is_some_and(|rate| *rate < 0.0);
        let minimum = |site, other, s: f64| Minimum {
            site,
            guard,
            other,
            at: place(s),
            value: jet(s)[0],
            scale,
        };
        if falls && samples[0].1[1] >= 0.0 {
            found.push(minimum(Site::Minimum(guard.number), None, 0.0));
        }
        // Where another contact switches it may jump.
        let others = ends.map(|one| one.filter(|one| *one != guard.contact));
        if others[0].is_some() && jet(0.0)[1] > 0.0 {
            found.push(minimum(Site::Begin(guard.number), others[0], 0.0));
        }
        if others[1].is_some() && jet(1.0)[1] < 0.0 {
            found.push(minimum(Site::End(guard.number), others[1], 1.0));
        }
        rates.extend(samples.last().map(|(_, jet)| jet[1]));
        for pair in samples.windows(2) {
            let ((mut a, before), (mut b, behind)) = (pair[0], pair[1]);
            if !(before[1] < 0.0 && behind[1] >= 0.0) {
                continue;
            }
            let mut s = 0.5 * (a + b);
            // Newton's iteration on the rate, held between the samples by bisection.
            for _ in 0..60 {
                let [_, rate, second, _] = jet(s);
                if rate < 0.0 {
                    a = s;
                } else {
                    b = s;
                }
                let newton = s - rate / (second * length);
                let next = if newton > a && newton < b {
                    newton
                } else {
                    0.5 * (a + b)
                };
                if (next - s).abs() <= f64::EPSILON {
                    break;
                }
                s = next;
            }
            found.push(minimum(Site::Minimum(guard.number), None, s));
        }
    }
    OfStep {
        minima: found,
        rates,
    }
}

/// What is found in a step.
struct OfStep {
    minima: Vec<Minimum>,
    /// The rates of the guards at its end.
    rates: Vec<f64>,
}

/// The smallest value of a guard among those around it.
struct Minimum {
    site: Site,
    guard: Guard,
    /// The contact beside whose transition it is.
    other: Option<usize>,
    at: Moment,
    value: f64,
    /// The largest size that the guard has in the step.
    scale: f64,
}
