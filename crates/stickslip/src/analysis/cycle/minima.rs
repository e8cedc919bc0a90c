//! The smallest values of the guards within the phases of a periodic orbit, and at those ends of a
//! phase that belong to another contact.

use super::Outline;
use super::margin::{Key, Margin, MarginKind};
use super::pieces::Piece;
use crate::dynamics::{Dynamics, Guard, Moment, SmoothFlow, Step, Vector};

/// Samples per step for locating the minima of its guards.
const SAMPLES: usize = 8;

/// Fraction of a step after which a guard has left zero.
const BEHIND: f64 = 1.0 / 128.0;

/// Fraction of a step within which two minima are one.
const NEXT_TO: f64 = 1e-6;

/// The smallest values of all guards within the segments, and at those ends that belong to another
/// contact.
pub(super) fn minima(system: &dyn Dynamics, outline: &Outline, pieces: &[Piece]) -> Vec<Margin> {
    let mut found: Vec<Margin> = Vec::new();
    let count = outline.segments.len();
    for (part, (segment, piece)) in outline.segments.iter().zip(pieces).enumerate() {
        let flow = system.flow(segment.mode, &segment.inside);
        let neighbours = [outline.before(part), &outline.segments[(part + 1) % count]];
        let bounds = [neighbours[0].end, segment.end].map(|end| Some(end?.contact));
        let last = piece.steps.len().saturating_sub(1);
        // An orbit without transitions continues from its end to its beginning.
        let mut rates = match piece.steps.last() {
            Some((step, solution)) if segment.end.is_none() => {
                minima_of(&*flow, (step, solution), &[], [None; 2]).rates
            }
            _ => Vec::new(),
        };
        let mut scales = vec![f64::MIN_POSITIVE; flow.guards().len()];
        let first = found.len();
        for (number, (step, solution)) in piece.steps.iter().enumerate() {
            let begin = bounds[0].filter(|_| number == 0);
            let ends = [begin, bounds[1].filter(|_| number == last)];
            let of_step = minima_of(&*flow, (step, solution), &rates, ends);
            rates = of_step.rates;
            for (scale, of_step) in scales.iter_mut().zip(&of_step.scales) {
                *scale = of_step.max(*scale);
            }
            for Minimum {
                kind,
                guard,
                other,
                at,
                value,
            } in of_step.minima
            {
                let same = |margin: &&Margin| margin.key.part == part && margin.key.kind == kind;
                // At the end of a step, rounding may have shown it, and show it again at the
                // beginning of the next.
                let near = NEXT_TO * (step.t_end - step.t_start);
                let is_near = |margin: &Margin| (margin.at.t - at.t).abs() <= near;
                if found.iter().rfind(same).is_some_and(is_near) {
                    continue;
                }
                // A guard released by another contact's switch leaves zero, or reaches it.
                let contact = guard.contact;
                let switches =
                    |k: usize| neighbours[k].mode.get(contact) != segment.mode.get(contact);
                let is_of_switch = match kind {
                    MarginKind::Begin(_) => switches(0),
                    MarginKind::End(_) => switches(1),
                    _ => false,
                };
                if is_of_switch {
                    continue;
                }
                let count = found.iter().filter(same).count();
                found.push(Margin {
                    key: Key { part, kind, count },
                    value,
                    scale: f64::MIN_POSITIVE,
                    incoming: segment.mode,
                    contact,
                    other,
                    at,
                    is_contact_function: guard.goes_on,
                    is_of_jump: guard.is_of_jump,
                });
            }
        }
        for margin in &mut found[first..] {
            let number = margin.key.kind.guard();
            let mut guards = flow.guards().into_iter();
            let place = guards.position(|guard| Some(guard.number) == number);
            margin.scale = place.map_or(margin.scale, |place| scales[place]);
        }
    }
    found
}

/// The minima of the mode's guards within a step with its solution. `before` has the rates of the
/// guards at the end of the step before, where that belongs to the same phase. `ends` has the
/// contacts whose transitions begin and end a phase with the step.
fn minima_of(
    flow: &dyn SmoothFlow,
    (step, solution): (&Step, &dyn Fn(f64) -> Vector),
    before: &[f64],
    ends: [Option<usize>; 2],
) -> OfStep {
    let length = step.t_end - step.t_start;
    let moment = |t: f64| Moment { t, x: solution(t) };
    let place = |s: f64| moment(step.t_start + s * length);
    let mut found = Vec::new();
    let (mut rates, mut scales) = (Vec::new(), Vec::new());
    for (k, guard) in flow.guards().into_iter().enumerate() {
        let jet = |s: f64| flow.guard_jet(guard.number, &place(s));
        // The guard with which a phase begins may leave zero with zero rate.
        let leaves = ends[0] == Some(guard.contact);
        let samples: Vec<_> = (0..=SAMPLES)
            .map(|k| match k {
                0 if leaves => BEHIND,
                _ => k as f64 / SAMPLES as f64,
            })
            .map(|s| (s, jet(s)))
            .collect();
        let sizes = samples.iter().map(|(_, jet)| jet[0].abs());
        scales.push(sizes.fold(0.0, f64::max));
        // A step may end at a minimum, where rounding gives its rate either sign.
        let falls = before.get(k).is_some_and(|rate| *rate < 0.0);
        let minimum = |kind, other, s: f64| Minimum {
            kind,
            guard,
            other,
            at: place(s),
            value: jet(s)[0],
        };
        if falls && samples[0].1[1] >= 0.0 && (!guard.is_of_jump || samples[0].1[0] > 0.0) {
            found.push(minimum(MarginKind::Minimum(guard.number), None, 0.0));
        }
        // Where another contact switches, it may jump.
        let others = ends.map(|one| one.filter(|one| *one != guard.contact));
        // A jump does not occur at a zero that its function has passed already.
        let is_before = !guard.is_of_jump || samples[0].1[0] > 0.0;
        if others[0].is_some() && is_before && jet(0.0)[1] > 0.0 {
            found.push(minimum(MarginKind::Begin(guard.number), others[0], 0.0));
        }
        if others[1].is_some() && is_before && jet(1.0)[1] < 0.0 {
            found.push(minimum(MarginKind::End(guard.number), others[1], 1.0));
        }
        rates.extend(samples.last().map(|(_, jet)| jet[1]));
        for pair in samples.windows(2) {
            let ((mut a, before), (mut b, behind)) = (pair[0], pair[1]);
            if !(is_before && before[1] < 0.0 && behind[1] >= 0.0) {
                continue;
            }
            let mut s = 0.5 * (a + b);
            // Newton's iteration on the rate, safeguarded by bisection between the samples.
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
            found.push(minimum(MarginKind::Minimum(guard.number), None, s));
        }
    }
    OfStep {
        minima: found,
        rates,
        scales,
    }
}

/// The minima of a step.
struct OfStep {
    minima: Vec<Minimum>,
    /// The rates of the guards at its end.
    rates: Vec<f64>,
    /// The largest absolute values of the guards in it.
    scales: Vec<f64>,
}

/// A local minimum of a guard.
struct Minimum {
    kind: MarginKind,
    guard: Guard,
    /// The contact at whose transition it is.
    other: Option<usize>,
    at: Moment,
    value: f64,
}
