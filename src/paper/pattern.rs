//! Measurements of Fig. 8's motion, with one definition for the listing, its limit and the exact
//! solution.

use super::listing::{Crossing, Instant, LEAST_COMPARED, Motion, Run, Stick, pattern_begin};
use stickslip::{Mode, Phase, Side};

/// Tolerance for two events of an accurate solution to be equal (m, s). It is far above the
/// solver's tolerance and far below the printed digits.
const EVENT_TOLERANCE: f64 = 1e-6;

/// Whether a motion is what the caption of Fig. 8 says. It must have stick phases and repeat after
/// two forcing periods and not after one. `period` is the number of forcing periods after which it
/// first repeats.
pub fn two_periodic(sticks: usize, period: usize) -> bool {
    sticks > 0 && period == 2
}

/// A settled motion, described by its events on Σ.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// Number of forcing periods after which the motion first repeats.
    pub period: usize,
    /// Forcing period (s).
    pub forcing_period: f64,
    /// The stick phases that end within the last [`Pattern::period`] forcing periods, but at least
    /// two periods, in order of time.
    pub sticks: Vec<Stick>,
    /// The crossings without stick within the same time.
    pub crossings: Vec<Crossing>,
    /// The time at which the pattern ends (s): the end of the last stick phase or, without stick,
    /// the last crossing.
    pub end: f64,
}

impl Pattern {
    /// Pattern of a run of the listing. Its period is that of [`Run::motion`]. The first step after
    /// a stick phase is not a crossing but the correction of a wrong side at its release. `None`
    /// unless the motion has settled and reaches Σ.
    pub fn of_listing(run: &Run) -> Option<Pattern> {
        let (Motion::StickSlip { period, .. } | Motion::SlipOnly { period }) = run.motion else {
            return None;
        };
        // A motion that settles without stick may have stuck in its transient.
        let sticks = match run.motion {
            Motion::StickSlip { .. } => run.phases.iter().map(|phase| phase.stick).collect(),
            _ => Vec::new(),
        };
        let crossings = run.crossings.iter().filter(|one| !one.after_exit);
        let crossings = crossings.copied();
        Events::new(sticks, crossings.collect(), run.forcing_period).pattern(period)
    }

    /// Pattern of the phases of an accurate solution, in order of time; a phase ends where the next
    /// begins. The period is the smallest number of forcing periods after which all events on Σ
    /// repeat. Events are entries, exits and crossings. They repeat if they agree within 1e-6 m and
    /// 1e-6 s over at least the last six forcing periods. `None` if nothing repeats within eight.
    /// The first phase and a phase cut off at `t_end` are not complete stick phases.
    pub fn of_phases(phases: &[Phase<2>], t_end: f64, forcing_period: f64) -> Option<Pattern> {
        let complete = |phase: &&Phase<2>| phase.mode == Mode::Stick && phase.t_end != t_end;
        let sticks = phases.iter().skip(1).filter(complete);
        let sticks = sticks.map(Stick::of);
        let crossings = phases.windows(2).filter_map(|pair| {
            let (Mode::Slip(from), Mode::Slip(to)) = (pair[0].mode, pair[1].mode) else {
                return None;
            };
            (from != to).then(|| Crossing {
                at: Instant::of(pair[1].t_start, &pair[1].x_start),
                to,
                after_exit: false,
            })
        });
        let events = Events::new(sticks.collect(), crossings.collect(), forcing_period);
        let period = (1..=Motion::LONGEST_PATTERN).find(|&period| events.repeat_after(period))?;
        events.pattern(period)
    }

    /// The four numbers of Sect. 4.2: the lengths (m) of the two longest stick phases, the longer
    /// first, then their durations (s). They are taken within two forcing periods, or within the
    /// pattern if that is longer. `None` if there are fewer than two phases.
    pub fn stick_numbers(&self) -> Option<[f64; 4]> {
        let mut sticks = self.sticks.clone();
        sticks.sort_by(|one, other| other.length().total_cmp(&one.length()));
        match sticks.as_slice() {
            [first, second, ..] => Some([
                first.length(),
                second.length(),
                first.duration(),
                second.duration(),
            ]),
            _ => None,
        }
    }

    /// [`two_periodic`] of this motion.
    pub fn two_periodic(&self) -> bool {
        two_periodic(self.sticks.len(), self.period)
    }

    /// The stick phases of one pattern.
    pub fn pattern_sticks(&self) -> impl Iterator<Item = &Stick> {
        let from = self.start();
        self.sticks.iter().filter(move |stick| stick.exit.t > from)
    }

    /// The crossings of one pattern.
    pub fn pattern_crossings(&self) -> impl Iterator<Item = &Crossing> {
        let from = self.start();
        self.crossings
            .iter()
            .filter(move |crossing| crossing.at.t > from)
    }

    /// The deflections of Sect. 4.2: the crossings of one pattern at `x1 < 0`. The spring and the
    /// support are symmetric about `x1 = 0`, so this is the left half of the phase plane. A pattern
    /// is the shortest part that repeats, so each deflection is a separate point of the closed
    /// trajectory. The point where the body is released from stick is not a crossing of Σ.
    pub fn deflections(&self) -> Vec<Crossing> {
        let left = |crossing: &&Crossing| crossing.at.x1 < 0.0;
        self.pattern_crossings().filter(left).copied().collect()
    }

    /// Whether another motion is of the same kind. It has the same period and the same numbers of
    /// stick phases and deflections in a pattern.
    pub fn same_motion(&self, other: &Pattern) -> bool {
        let kind = |one: &Pattern| {
            (
                one.pattern_sticks().count(),
                one.period,
                one.deflections().len(),
            )
        };
        kind(self) == kind(other)
    }

    /// The time at which the last pattern begins.
    fn start(&self) -> f64 {
        pattern_begin(self.end, self.period, self.forcing_period)
    }
}

/// An event on Σ.
#[derive(Clone, Copy, PartialEq)]
enum EventKind {
    Entry,
    Exit,
    Crossing(Side),
}

/// All events on Σ up to the end of the last stick phase or, without stick, up to the last
/// crossing.
struct Events {
    sticks: Vec<Stick>,
    crossings: Vec<Crossing>,
    forcing_period: f64,
    end: Option<f64>,
}

impl Events {
    fn new(sticks: Vec<Stick>, crossings: Vec<Crossing>, forcing_period: f64) -> Events {
        let last_exit = sticks.last().map(|stick| stick.exit.t);
        let last_crossing = crossings.last().map(|crossing| crossing.at.t);
        // A motion that has not stuck for longer than any pattern no longer sticks.
        let span = Motion::LONGEST_PATTERN as f64 * forcing_period;
        let current = last_exit.filter(|exit| last_crossing.is_none_or(|last| last - exit <= span));
        Events {
            sticks: if current.is_some() {
                sticks
            } else {
                Vec::new()
            },
            crossings,
            forcing_period,
            end: current.or(last_crossing),
        }
    }

    /// All events in order of time.
    fn ordered(&self) -> Vec<(EventKind, Instant)> {
        let sticks = self.sticks.iter();
        let mut all: Vec<(EventKind, Instant)> = sticks
            .flat_map(|stick| {
                [
                    (EventKind::Entry, stick.entry),
                    (EventKind::Exit, stick.exit),
                ]
            })
            .collect();
        let crossings = self.crossings.iter();
        all.extend(crossings.map(|one| (EventKind::Crossing(one.to), one.at)));
        all.retain(|(_, at)| self.end.is_some_and(|end| at.t <= end));
        all.sort_by(|one, other| one.1.t.total_cmp(&other.1.t));
        all
    }

    /// Whether each of the last events also happened so many forcing periods earlier.
    fn repeat_after(&self, period: usize) -> bool {
        let Some(end) = self.end else { return false };
        let all = self.ordered();
        let since = |periods: usize| {
            let from = pattern_begin(end, periods, self.forcing_period);
            all.iter().filter(|(_, at)| at.t > from).count()
        };
        let compared = since((2 * period).max(LEAST_COMPARED));
        let shift = period as f64 * self.forcing_period;
        let earlier = all.iter().rev().skip(since(period));
        let same = |((kind, at), (was, before)): (&(EventKind, Instant), &(EventKind, Instant))| {
            kind == was
                && (at.x1 - before.x1).abs() <= EVENT_TOLERANCE
                && (at.t - before.t - shift).abs() <= EVENT_TOLERANCE
        };
        let mut pairs = all.iter().rev().zip(earlier).take(compared);
        let enough = pairs.len() == compared;
        enough && pairs.all(same)
    }

    fn pattern(self, period: usize) -> Option<Pattern> {
        let end = self.end?;
        let from = pattern_begin(end, period.max(2), self.forcing_period);
        let within = |t: f64| t > from && t <= end;
        let Events {
            mut sticks,
            mut crossings,
            forcing_period,
            ..
        } = self;
        sticks.retain(|stick| within(stick.exit.t));
        crossings.retain(|crossing| within(crossing.at.t));
        Some(Pattern {
            period,
            forcing_period,
            sticks,
            crossings,
            end,
        })
    }
}

impl Run {
    /// The numbers of [`Pattern::stick_numbers`]. `None` unless the motion is [`Motion::StickSlip`]
    /// with two such phases.
    pub fn stick_numbers(&self) -> Option<[f64; 4]> {
        Pattern::of_listing(self)?.stick_numbers()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::State;

    /// Phases of a motion that repeats after so many periods of length one. Each has a stick phase
    /// of the given length, a crossing upwards at -0.2 and one downwards at 0.3.
    fn motion(lengths: &[f64], periods: usize) -> Vec<Phase<2>> {
        let mut phases: Vec<Phase<2>> = Vec::new();
        let mut add = |mode, t: f64, x1: f64| {
            let x = State::from([x1, 1.0]);
            if let Some(last) = phases.last_mut() {
                (last.t_end, last.x_end) = (t, x);
            }
            phases.push(Phase {
                mode,
                t_start: t,
                t_end: t,
                x_start: x,
                x_end: x,
            });
        };
        for k in 0..periods {
            let t = k as f64;
            let length = lengths[k % lengths.len()];
            add(Mode::Slip(Side::Below), t, 0.3);
            add(Mode::Slip(Side::Above), t + 0.1, -0.2);
            add(Mode::Slip(Side::Below), t + 0.2, 0.3);
            if length > 0.0 {
                add(Mode::Stick, t + 0.3, 0.0);
                add(Mode::Slip(Side::Above), t + 0.3 + length, length);
            } else {
                add(Mode::Slip(Side::Above), t + 0.3, -0.1);
            }
        }
        phases
    }

    #[test]
    fn the_period_is_the_shortest_that_repeats() {
        for (lengths, period) in [
            (&[0.4][..], 1),
            (&[0.4, 0.1], 2),
            (&[0.4, 0.4, 0.1], 3),
            (&[0.4, 0.4], 1),
            (&[0.0], 1),
            (&[0.0, 0.3], 2),
        ] {
            let pattern = Pattern::of_phases(&motion(lengths, 20), 20.0, 1.0).unwrap();
            assert_eq!(pattern.period, period, "{lengths:?}");
            let sticks = lengths.iter().any(|&l| l > 0.0);
            assert_eq!(pattern.two_periodic(), sticks && period == 2);
        }
        // Nothing repeats in lengths that are all different, nor in too short a motion.
        let growing: Vec<f64> = (0..20).map(|k| 0.01 * f64::from(k + 1)).collect();
        assert_eq!(Pattern::of_phases(&motion(&growing, 20), 20.0, 1.0), None);
        assert_eq!(Pattern::of_phases(&motion(&[0.4, 0.1], 5), 5.0, 1.0), None);
        assert_eq!(Pattern::of_phases(&[], 0.0, 1.0), None);
    }

    #[test]
    fn numbers_and_deflections_are_those_of_the_pattern() {
        let two = Pattern::of_phases(&motion(&[0.1, 0.4], 20), 20.0, 1.0).unwrap();
        let numbers = two.stick_numbers().unwrap();
        for (found, wanted) in numbers.into_iter().zip([0.4, 0.1, 0.4, 0.1]) {
            assert!((found - wanted).abs() < 1e-12, "{numbers:?}");
        }
        assert_eq!(two.deflections().len(), 2);
        // With a period of one, the stick phase occurs twice in two periods; the crossing is one
        // point.
        let one = Pattern::of_phases(&motion(&[0.4], 20), 20.0, 1.0).unwrap();
        assert_eq!((one.sticks.len(), one.pattern_sticks().count()), (2, 1));
        assert_eq!(one.deflections().len(), 1);
        assert!(one.stick_numbers().is_some() && !one.same_motion(&two));
        let none = Pattern::of_phases(&motion(&[0.0], 20), 20.0, 1.0).unwrap();
        assert_eq!((none.stick_numbers(), none.deflections().len()), (None, 2));
    }
}
