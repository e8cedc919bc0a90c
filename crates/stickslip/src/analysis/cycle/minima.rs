//! The smallest values of the guards within the phases of a periodic orbit, and at those ends of a
//! phase that belong to another contact.

use numerics::bisect;

use super::margin::{Margin, MarginKind, at_events};
use super::pieces::Piece;
use super::{OrbitGuess, SegmentKind, Shooting, closeness};
use crate::dynamics::{Dynamics, Guard, Moment};
use crate::filippov::{Direction, Options};

/// Samples per step among which the minima of a guard are bracketed. Chosen: the guard's rate is
/// nearly a polynomial of the method's order in a step, and two minima closer than this are rare.
const SAMPLES: usize = 8;

/// Time before the kink of an input at which it has its values before that, as a fraction of the
/// time and of the period. Chosen: four times the rounding of a clock.
const BEFORE_KINK: f64 = 64.0 * f64::EPSILON;

/// Fraction of a step after which a guard has left the zero with which its phase begins: a
/// sixteenth of the distance of samples.
const AFTER_BEGIN: f64 = 1.0 / (16.0 * SAMPLES as f64);

/// A guard within a phase: its value and time derivatives in a step, at a fraction of it.
struct Sample {
    step: usize,
    s: f64,
    jet: [f64; 4],
}

/// The samples at which a guard is least, to a tolerance.
struct Least {
    /// The first and the last of those that follow each other.
    samples: [usize; 2],
    is_at_end: [bool; 2],
    level: f64,
}

impl Least {
    fn of(samples: &[Sample], tolerance: f64) -> Option<Self> {
        let value = |one: &Sample| one.jet[0];
        let least = samples
            .iter()
            .map(value)
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let level = least.1 + tolerance;
        let includes = |one: &&Sample| value(one) <= level;
        let (before, behind) = samples.split_at(least.0);
        let first = least.0 - before.iter().rev().take_while(includes).count();
        let last = least.0 + behind.iter().skip(1).take_while(includes).count();
        Some(Least {
            samples: [first, last],
            is_at_end: [first == 0, last + 1 == samples.len()],
            level,
        })
    }

    fn includes(&self, value: f64) -> bool {
        value <= self.level
    }

    /// The sample in the middle; `None` where they reach an end at which the guard is zero by the
    /// event there.
    fn place(&self, is_zero_at: [bool; 2]) -> Option<usize> {
        let reaches = |end: usize| self.is_at_end[end] && is_zero_at[end];
        let [first, last] = self.samples;
        (!reaches(0) && !reaches(1)).then_some((first + last) / 2)
    }
}

impl Shooting<'_> {
    /// The margins of the orbit to each change of its phases.
    /// `error` is that of its states.
    pub(super) fn margins(
        &self,
        outline: &OrbitGuess,
        pieces: &[Piece],
        error: f64,
    ) -> Vec<Margin> {
        let mut margins = minima((self.system, self.states), outline, pieces, self.options);
        for margin in &mut margins {
            self.refine(outline, pieces, margin);
            margin.error *= error;
        }
        margins.extend(at_events(self.system, outline, pieces, error));
        margins
    }

    /// Computes a minimum by a step that ends there: within a step, the error is larger than at its
    /// ends.
    fn refine(&self, outline: &OrbitGuess, pieces: &[Piece], margin: &mut Margin) {
        let MarginKind::Minimum(guard) = margin.kind else {
            return;
        };
        let (segment, t) = (&outline.segments[margin.part], margin.at.t);
        let steps = pieces[margin.part].steps.iter();
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
}

/// The smallest values of all guards within the segments, and at those ends that belong to another
/// contact. Their errors are per error of the states, whose number is given.
fn minima(
    (system, states): (&dyn Dynamics, usize),
    outline: &OrbitGuess,
    pieces: &[Piece],
    options: &Options,
) -> Vec<Margin> {
    let mut margins: Vec<Margin> = Vec::new();
    let count = outline.segments.len();
    for (part, (segment, piece)) in outline.segments.iter().zip(pieces).enumerate() {
        let flow = system.flow(segment.mode, &segment.inside);
        let neighbours = [outline.before(part), &outline.segments[(part + 1) % count]];
        let mut ends = [neighbours[0].end, segment.end].map(|end| Some(end?.contact));
        if let SegmentKind::Chatter { landing, .. } = segment.kind {
            ends[0] = Some(landing);
        }
        let length = |step: usize| piece.steps[step].0.t_end - piece.steps[step].0.t_start;
        // Where an input kinks, a guard may jump: its values before that are those of the step. A
        // step that ends there by rounding has none.
        let end = |step: usize| {
            let at = piece.steps[step].0.end();
            let early = BEFORE_KINK * (at.t.abs() + outline.period()) / length(step);
            match system.kink(&at) {
                Some(_) => (early < AFTER_BEGIN).then_some((step, 1.0 - early)),
                None => Some((step, 1.0)),
            }
        };
        let steps: Vec<(usize, f64)> = (piece.phase..piece.steps.len()).filter_map(end).collect();
        let moment = |step: usize, s: f64| {
            let (step, solution) = &piece.steps[step];
            let t = step.t_start + s * (step.t_end - step.t_start);
            Moment { t, x: solution(t) }
        };
        let is_conditional = |guard: &Guard| {
            let decision = || system.decision(guard.contact, &piece.begin);
            guard.is_of_jump
                && !guard.is_watched
                && decision().comparisons.iter().any(|one| one.is_of_condition)
        };
        for guard in flow.guards() {
            let is_conditional = is_conditional(&guard);
            if !guard.is_watched && !is_conditional {
                continue;
            }
            let (number, contact) = (guard.number, guard.contact);
            let jet = |step, s| flow.guard_jet(number, &moment(step, s));
            let sample = |(step, s)| Sample {
                step,
                s,
                jet: jet(step, s),
            };
            // The guard with which the phase begins may leave zero at zero rate.
            let leaves_zero = ends[0] == Some(contact);
            let begins = if leaves_zero { AFTER_BEGIN } else { 0.0 };
            let mut places = Vec::new();
            for (number, &(step, end)) in steps.iter().enumerate() {
                let is_smooth = number > 0 && steps[number - 1] == (step - 1, 1.0);
                let begin = if number == 0 { begins } else { 0.0 };
                places.extend((!is_smooth).then_some((step, begin)));
                places.extend((1..SAMPLES).map(|k| (step, k as f64 / SAMPLES as f64)));
                places.push((step, end));
            }
            let mut samples: Vec<Sample> = places.into_iter().map(sample).collect();
            // A rate that is zero to within the tolerances has no sign. So a minimum at a zero of
            // another contact's velocity is one minimum, on whichever side rounding puts it.
            let rates = samples.iter().map(|one| one.jet[1].abs());
            let still = closeness(options) * rates.fold(0.0, f64::max);
            let falls = |one: &Sample| one.jet[1] < -still;
            let between = |a: &Sample, b: &Sample| (if a.step == b.step { a.s } else { 0.0 }, b.s);
            let is_kink = |a: &Sample, b: &Sample| a.step != b.step && b.s == 0.0;
            // Between two samples a guard may turn twice. Its rate then has an extremum there.
            let turns_twice = |a: &Sample, b: &Sample| {
                let sign = if falls(a) { -1.0 } else { 1.0 };
                let may_turn =
                    falls(a) == falls(b) && sign * a.jet[2] < 0.0 && sign * b.jet[2] > 0.0;
                (may_turn && !is_kink(a, b)).then(|| {
                    let second = |s: f64| {
                        let [.., second, third] = jet(b.step, s);
                        [sign * second, sign * third]
                    };
                    sample((b.step, rising_zero(between(a, b), length(b.step), second)))
                })
            };
            for k in (1..samples.len()).rev() {
                let extreme = turns_twice(&samples[k - 1], &samples[k]);
                if let Some(extreme) = extreme.filter(|one| falls(one) != falls(&samples[k])) {
                    samples.insert(k, extreme);
                }
            }
            let ([begin, ..], [.., end]) = (&samples[..], &samples[..]) else {
                continue;
            };
            let last = samples.len() - 1;
            let mut places = Vec::new();
            // A jump occurs at a zero of its function only after this was positive in the phase. A
            // state at which a gap or a reaction is below zero is none of the system.
            let positive = samples.iter().position(|one| one.jet[0] > 0.0);
            let occurs_at_once = !guard.is_of_jump || guard.is_condition;
            let may_vanish =
                |by: usize| occurs_at_once || positive.is_some_and(|first| first <= by);
            // Where another contact switches, the rate may jump. A guard that this switch releases
            // leaves zero there, or comes to it.
            let by_other = |k: usize| {
                let is_held = neighbours[k].mode.get(contact) == segment.mode.get(contact);
                ends[k].filter(|other| is_held && *other != contact)
            };
            if let Some(other) = by_other(0)
                && may_vanish(0)
                && begin.jet[1] > still
            {
                places.push((MarginKind::Begin(number), Some(other), (begin.step, 0.0)));
            }
            if let Some(other) = by_other(1)
                && may_vanish(last - 1)
                && falls(end)
            {
                places.push((MarginKind::End(number), Some(other), (end.step, end.s)));
            }
            let sizes = samples.iter().map(|sample| sample.jet[0].abs());
            let scale = sizes.fold(f64::MIN_POSITIVE, f64::max);
            let minimum = MarginKind::Minimum(number);
            // What the kink of an input ends may end before that.
            let own = segment.end.filter(|end| end.contact == contact);
            if let Some((input, _)) = own.and_then(|end| end.at_kink)
                && falls(end)
            {
                let before = flow.guards().into_iter().map(|guard| guard.contact + 1);
                let of_input = before.fold(system.contacts(), usize::max) + input;
                places.push((MarginKind::End(number), Some(of_input), (end.step, end.s)));
            }
            // At a kink, the lower side.
            let lowest = |a: &Sample, b: &Sample| {
                let rise = (b.jet[0] - a.jet[0]) / (closeness(options) * scale);
                let (rises, drops) = (rise > 1.0, rise < -1.0);
                let is_lowest = (falls(a) || drops) && (!falls(b) || rises);
                let lower = if rises { a } else { b };
                is_lowest.then_some((lower.step, lower.s))
            };
            // An orbit without transitions continues from its end to its beginning.
            if segment.end.is_none()
                && count == 1
                && may_vanish(last)
                && let Some(place) = lowest(end, begin)
            {
                places.push((minimum, None, place));
            }
            for (k, (a, b)) in samples.iter().zip(&samples[1..]).enumerate() {
                if is_kink(a, b) {
                    let place = lowest(a, b).filter(|_| may_vanish(k));
                    places.extend(place.map(|place| (minimum, None, place)));
                } else if may_vanish(k) && falls(a) && !falls(b) {
                    let rate = |s: f64| {
                        let [_, rate, second, _] = jet(b.step, s);
                        [rate, second]
                    };
                    let s = rising_zero(between(a, b), length(b.step), rate);
                    places.push((minimum, None, (b.step, s)));
                }
            }
            let is_own_zero = [leaves_zero, own.is_some_and(|end| end.at_kink.is_none())];
            // A constant has no minimum, but a least value. Its size may be that of its terms.
            let plateau = guard.is_condition.then(|| {
                let at = moment(begin.step, begin.s);
                let (by_state, _) = flow.guard_gradient(number, &at);
                let scale = scale.max(by_state.abs().dot(&at.x.abs()));
                let least = Least::of(&samples, closeness(options) * scale)?;
                let is_marked = places
                    .iter()
                    .any(|&(_, _, (step, s))| least.includes(flow.guard(number, &moment(step, s))));
                let place = least.place(is_own_zero).filter(|_| !is_marked)?;
                let at = (samples[place].step, samples[place].s);
                Some(((minimum, None, at), scale))
            });
            if is_conditional {
                let both = system.map(contact, &piece.begin).direction == Direction::Both;
                let passes = |a: f64, b: f64| a > 0.0 && b <= 0.0 || both && a < 0.0 && b >= 0.0;
                let at = |(a, b): (&Sample, &Sample)| {
                    let is_below = |s: f64| (jet(b.step, s)[0] <= 0.0) == (b.jet[0] <= 0.0);
                    let s = match is_kink(a, b) {
                        true => 0.0,
                        false => bisect(between(a, b).0, b.s, is_below),
                    };
                    moment(b.step, s)
                };
                // The last zero may be the event that ends the phase.
                let inner = last + usize::from(ends[1] != Some(contact));
                let pairs = samples[..inner].iter().zip(&samples[1..inner]);
                let within = pairs.filter(|(a, b)| passes(a.jet[0], b.jet[0])).map(at);
                // It may pass through zero in the event before the phase.
                let earlier = &pieces[(part + count - 1) % count].end;
                let at_begin = passes(flow.guard(number, earlier), begin.jet[0]) && !leaves_zero;
                let at_begin = at_begin.then(|| moment(begin.step, begin.s));
                let zeros: Vec<Moment> = at_begin.into_iter().chain(within).collect();
                // A minimum below zero counts where the zero before it would be an event.
                let happens = |at: &Moment| system.decision(contact, at).happens;
                places.retain(|(.., (step, s))| {
                    let at = moment(*step, *s);
                    let before = zeros.iter().rev().find(|zero| zero.t <= at.t);
                    match flow.guard(number, &at) > 0.0 {
                        true => happens(&at),
                        false => before.map_or_else(|| happens(&at), happens),
                    }
                });
                let passed = zeros.into_iter().filter_map(|at| {
                    let decision = system.decision(contact, &at);
                    let all = decision.comparisons.into_iter();
                    let deciding = all.filter(|one| one.is_of_condition && one.decides);
                    let least = deciding.min_by(|a, b| a.lead.abs().total_cmp(&b.lead.abs()))?;
                    let sign = if decision.happens { -1.0 } else { 1.0 };
                    Some(Margin {
                        part,
                        kind: MarginKind::Passed(number),
                        value: sign * least.lead.abs(),
                        scale: least.size,
                        error: least.slope,
                        incoming: segment.mode,
                        contact,
                        other: None,
                        at,
                        is_contact_function: false,
                        is_of_jump: true,
                        is_reaction: false,
                    })
                });
                margins.extend(passed);
            }
            let places = places.into_iter().map(|place| (place, scale));
            for ((kind, other, (step, s)), scale) in places.chain(plateau.flatten()) {
                let at = moment(step, s);
                let (by_state, _) = flow.guard_gradient(number, &at);
                margins.push(Margin {
                    part,
                    kind,
                    value: flow.guard(number, &at),
                    scale,
                    error: by_state.rows(0, states).norm(),
                    incoming: segment.mode,
                    contact,
                    other,
                    at,
                    is_contact_function: guard.continues_phase,
                    is_of_jump: guard.is_of_jump,
                    is_reaction: guard.is_reaction,
                });
            }
        }
    }
    margins
}

/// Fraction of the step at which a function with this time derivative rises through zero between
/// two others: Newton's iteration, safeguarded by bisection.
fn rising_zero((mut a, mut b): (f64, f64), length: f64, jet: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut s = 0.5 * (a + b);
    for _ in 0..60 {
        let [value, rate] = jet(s);
        if value < 0.0 {
            a = s;
        } else {
            b = s;
        }
        let newton = s - value / (rate * length);
        let is_between = newton > a && newton < b;
        let next = if is_between { newton } else { 0.5 * (a + b) };
        if (next - s).abs() <= f64::EPSILON {
            break;
        }
        s = next;
    }
    s
}
