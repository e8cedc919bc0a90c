//! A periodic orbit to be computed: its segments, and the moment at which the first one begins.

use super::super::instant::{Cause, LastEvent, guard_of, is_of_contact};
use super::{ULPS, unit};
use crate::dynamics::{
    Comparison, Dynamics, Modes, Moment, RecordedOrbit, Sampling, Transition, Vector,
};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::system::Mode;

/// Transition that ends a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SegmentEnd {
    /// The guard that vanishes.
    pub guard: usize,
    /// The contact to which it belongs; for a jump, its number counted after those of the contacts.
    pub contact: usize,
    /// Whether contact is lost or gained there.
    pub is_of_contact: bool,
    /// Whether the state jumps there.
    pub is_of_jump: bool,
    /// The input and the reading of its clock, where the kink of an input decides the time of the
    /// event: as where a force that switches releases a contact.
    pub at_kink: Option<(usize, f64)>,
    /// The comparisons on which a jump hangs: bit `k` is set where number `k` holds.
    pub choices: u64,
}

impl SegmentEnd {
    /// The event at a transition.
    pub fn of(system: &dyn Dynamics, at: &Transition, Cause { kink, .. }: Cause) -> Self {
        let here = at.moment();
        let guard = guard_of(system, at, here.t);
        SegmentEnd {
            guard: guard.map_or(at.contact, |guard| guard.number),
            contact: at.contact,
            is_of_contact: is_of_contact(at.kind),
            is_of_jump: at.kind == TransitionKind::Jump,
            at_kink: kink.map(|input| (input, system.clock(input, &here).0)),
            choices: match at.kind {
                TransitionKind::Jump => choices(&system.decision(at.contact, &here).comparisons),
                _ => 0,
            },
        }
    }

    /// Whether a comparison holds in the choices of the event; those beyond the last bit do not.
    pub fn holds(&self, comparison: usize) -> bool {
        bit(comparison) & self.choices != 0
    }
}

fn bit(comparison: usize) -> u64 {
    u32::try_from(comparison)
        .ok()
        .and_then(|place| 1_u64.checked_shl(place))
        .unwrap_or(0)
}

/// The comparisons that hold, as bits.
fn choices(comparisons: &[Comparison]) -> u64 {
    let hold = comparisons.iter().filter(|one| one.lead > 0.0);
    hold.fold(0, |bits, one| bits | bit(one.number))
}

/// The state after a transition.
fn after(system: &dyn Dynamics, at: &Transition) -> Vector {
    match at.kind {
        TransitionKind::Jump => system.reset(at.contact, &at.moment()).after,
        _ => at.x.clone(),
    }
}

/// Index of the transition that repeats transition `first` about a period later.
fn recurrence(transitions: &[&Transition], first: usize, period: f64) -> Option<usize> {
    let begin = transitions[first];
    let is_alike = |at: &Transition| {
        (at.kind, at.contact, at.from, at.to) == (begin.kind, begin.contact, begin.from, begin.to)
    };
    let off = |k: usize| (transitions[k].t - begin.t - period).abs();
    (first + 1..transitions.len())
        .filter(|&k| is_alike(transitions[k]) && off(k) < 0.5 * period)
        .min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// A part of a periodic orbit in one mode.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Segment {
    pub mode: Modes,
    /// A moment in the segment, which decides whether contact is lost or kept.
    pub inside: Moment,
    /// Transition that ends the segment; `None` where the orbit has no transition, and in flight.
    pub end: Option<SegmentEnd>,
    pub duration: f64,
    pub kind: SegmentKind,
}

/// Part of an orbit that a segment covers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum SegmentKind {
    /// A phase.
    Phase,
    /// The flight before impacts that accumulate, to its middle: to this share of the time until
    /// the next segment ends.
    Flight { share: f64 },
    /// The rest of that flight, the impacts, the landing, and the phase at rest. The impacts have
    /// no segments of their own: their number is that of the rounding. They occur as in a run.
    Chatter {
        /// The jump that accumulates, counted after the contacts.
        impact: usize,
        /// The jump that follows.
        landing: usize,
    },
}

impl Segment {
    /// Whether it can be cut in its middle.
    pub fn is_cuttable(&self) -> bool {
        !matches!(self.kind, SegmentKind::Chatter { .. })
    }
}

/// Impacts that accumulate in a run, and the landing: their places among the transitions.
struct Chatter {
    first: usize,
    landing: usize,
}

impl Chatter {
    /// All in which no contact changes.
    fn all(system: &dyn Dynamics, transitions: &[&Transition]) -> Vec<Self> {
        let rest = |at: &Transition| match at.kind {
            TransitionKind::Jump => system.rest_after(at.contact),
            _ => None,
        };
        let mut all = Vec::new();
        for (landing, at) in transitions.iter().enumerate() {
            let before = transitions[..landing].iter().rev();
            let impacts = before.take_while(|one| {
                rest(one) == Some(at.contact) && (one.from, one.to) == (at.from, at.from)
            });
            let first = landing - impacts.count();
            if at.kind == TransitionKind::Jump && first < landing && at.to == at.from {
                all.push(Chatter { first, landing });
            }
        }
        all
    }
}

/// A periodic orbit to be computed: its segments, and the moment at which the first one begins.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct OrbitGuess {
    pub segments: Vec<Segment>,
    pub begin: Moment,
    /// The states between the segments; `None` before they are computed.
    pub cut: Option<ShootingNodes>,
    /// Largest motion of the run from which it was taken.
    pub extent: f64,
}

/// States on the orbit that are unknowns, too (multiple shooting). Neighbouring orbits then
/// separate only from one such state to the next.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ShootingNodes {
    /// The segment that is also cut in its middle. Near a saddle, neighbouring orbits separate most
    /// in the longest segment.
    pub number: usize,
    /// Starts of the segments after the first, then the middle of the first.
    pub states: Vec<Vector>,
}

impl OrbitGuess {
    /// The orbit from a state over about a period, with the modes of the run. It begins with a
    /// transition and ends with one of the same kind about a period later.
    ///
    /// # Errors
    /// Those of [`crate::solve`]; the reason for an early end of the run; [`Error::NotFound`] where
    /// nothing repeats.
    pub fn of_run(
        system: &dyn Dynamics,
        start: &Moment,
        period: f64,
        options: &Options,
    ) -> Result<Self, Error> {
        // Length of the run in periods: at most one until the first transition, and at most one and
        // a half until it recurs.
        const SPAN: f64 = 2.5;
        let t_end = start.t + SPAN * period;
        let (orbit, ended) =
            RecordedOrbit::solve(system, start, t_end, options, &[], Sampling::Nowhere)?;
        if orbit.end.t < start.t + period {
            return Err(ended.map_or_else(|error| error, |end| end.no_future_error()));
        }
        let motions = orbit.steps.iter().map(|(step, _)| &step.x_end - &start.x);
        let extent = motions.fold(f64::MIN_POSITIVE, |most, motion| most.max(motion.amax()));
        let all: Vec<&Transition> = orbit
            .transitions()
            .filter(|at| at.kind != TransitionKind::Touch)
            .collect();
        let mut last = LastEvent::none();
        let causes = all.iter().map(|at| last.cause_of(system, at));
        let causes: Vec<Cause> = causes.collect();
        let chatter = Chatter::all(system, &all);
        let is_kept = |k: &usize| {
            chatter
                .iter()
                .all(|of| !(of.first..=of.landing).contains(k))
        };
        let places: Vec<usize> = (0..all.len()).filter(is_kept).collect();
        let transitions: Vec<&Transition> = places.iter().map(|&k| all[k]).collect();
        let without_end = |mode: Modes| Segment {
            mode,
            inside: start.clone(),
            end: None,
            duration: period,
            kind: SegmentKind::Phase,
        };
        // A jump in the instant that begins a period waits there for the next one.
        let rounding = ULPS * f64::EPSILON * (start.t.abs() + period);
        let by = start.t + period + rounding;
        if transitions.first().is_none_or(|at| at.t > by) {
            let middle = orbit.at(start.t + 0.5 * period)?;
            let mode = orbit.phases.first().map(|phase| phase.mode);
            return Ok(OrbitGuess {
                segments: mode.map(without_end).into_iter().collect(),
                begin: start.clone(),
                cut: Some(ShootingNodes {
                    number: 0,
                    states: vec![middle],
                }),
                extent,
            });
        }
        // The start may lie off the orbit, so that the first transitions do not recur.
        let recurrence = |first| Some((first, recurrence(&transitions, first, period)?));
        let again = (0..transitions.len()).find_map(recurrence);
        let not_found = ended.err().unwrap_or(Error::NotFound {
            what: "a return of the orbit",
            t: start.t,
            span: SPAN * period,
        });
        let (first, again) = again.ok_or(not_found)?;
        let mut segments = Vec::with_capacity(again - first);
        // States of the run keep the errors of one segment out of the next one.
        let mut begins = Vec::with_capacity(again - first);
        for places in places[first..=again].windows(2) {
            let [from, to] = [places[0], places[1]].map(|place| all[place]);
            let middle = |a: f64, b: f64| {
                let t = 0.5 * (a + b);
                Ok::<_, Error>(Moment { t, x: orbit.at(t)? })
            };
            let mut phase = Segment {
                mode: from.to,
                end: Some(SegmentEnd::of(system, to, causes[places[1]])),
                inside: middle(from.t, to.t)?,
                duration: to.t - from.t,
                kind: SegmentKind::Phase,
            };
            begins.push(after(system, from));
            let within = chatter
                .iter()
                .find(|of| (places[0]..places[1]).contains(&of.landing));
            if let Some(of) = within {
                let [impact, landing] = [of.first, of.landing].map(|place| all[place]);
                let high = middle(from.t, impact.t)?;
                let lasts = high.t - from.t;
                segments.push(Segment {
                    end: None,
                    inside: middle(from.t, high.t)?,
                    duration: lasts,
                    kind: SegmentKind::Flight {
                        share: lasts / phase.duration,
                    },
                    ..phase.clone()
                });
                phase.inside = middle(landing.t, to.t)?;
                phase.duration -= lasts;
                phase.kind = SegmentKind::Chatter {
                    impact: impact.contact,
                    landing: landing.contact,
                };
                begins.push(high.x);
            }
            segments.push(phase);
        }
        let number = segment_to_cut(&segments);
        let middle = segments.get(number).map(|one| one.inside.x.clone());
        Ok(OrbitGuess {
            begin: Moment {
                t: transitions[first].t,
                x: after(system, transitions[first]),
            },
            cut: Some(ShootingNodes {
                number,
                states: begins.into_iter().skip(1).chain(middle).collect(),
            }),
            segments,
            extent,
        })
    }

    /// The sum of the durations.
    pub fn period(&self) -> f64 {
        self.segments.iter().map(|segment| segment.duration).sum()
    }

    /// The unknowns: the state where the first segment begins, the durations, the time there, and
    /// the states at the cuts.
    pub fn unknowns(&self) -> Vector {
        let durations = self.segments.iter().map(|segment| segment.duration);
        let all = self.begin.x.iter().copied().chain(durations);
        let cut = self.cut.iter().flat_map(|cut| &cut.states);
        let cut = cut.flat_map(|x| x.iter().copied());
        let all: Vec<f64> = all.chain([self.begin.t]).chain(cut).collect();
        Vector::from_vec(all)
    }

    /// The vector whose product with the unknowns is the sum of the durations.
    pub fn by_duration(&self) -> Vector {
        let (n, count) = (self.begin.x.len(), self.segments.len());
        let mut row = Vector::zeros(self.unknowns().len());
        row.rows_mut(n, count).fill(1.0);
        row
    }

    /// The sequence with other unknowns.
    pub fn with(&self, unknowns: &Vector) -> Self {
        let n = self.begin.x.len();
        let mut other = self.clone();
        other.begin.x = unknowns.rows(0, n).into_owned();
        for (k, segment) in other.segments.iter_mut().enumerate() {
            segment.duration = unknowns[n + k];
        }
        let time = n + self.segments.len();
        other.begin.t = unknowns[time];
        let cuts = other.cut.iter_mut().flat_map(|cut| &mut cut.states);
        for (k, x) in cuts.enumerate() {
            *x = unknowns.rows(time + 1 + k * n, n).into_owned();
        }
        other
    }

    /// A direction in the space of the unknowns: that of the parameter, or of a duration.
    pub fn unit(&self, number: usize) -> Vector {
        unit(self.unknowns().len(), number)
    }

    /// The orbit of twice the period that runs through this one twice.
    pub fn twice(&self, system: &dyn Dynamics) -> Self {
        let clock = |input: usize, t: f64| {
            let x = self.begin.x.clone();
            system.clock(input, &Moment { t, x }).0
        };
        let (t, period) = (self.begin.t, self.period());
        let again = |segment: &Segment| {
            let mut segment = segment.clone();
            let kink = segment.end.as_mut().and_then(|end| end.at_kink.as_mut());
            if let Some((input, reading)) = kink {
                *reading += clock(*input, t + period) - clock(*input, t);
            }
            segment
        };
        let segments = match self.segments.as_slice() {
            // Without a transition it stays one segment.
            [only] if only.end.is_none() => vec![Segment {
                duration: 2.0 * only.duration,
                ..only.clone()
            }],
            all => all.iter().cloned().chain(all.iter().map(again)).collect(),
        };
        OrbitGuess {
            segments,
            cut: None,
            ..self.clone()
        }
    }

    /// The modes as [`Modes::cycle`], with the jumps between them.
    pub fn modes(&self) -> Vec<Modes> {
        let modes = self.segments.iter().flat_map(|segment| {
            let until = |number: Option<usize>| {
                segment
                    .mode
                    .until(number.map(|number| number - segment.mode.len()))
            };
            let end = segment.end.filter(|end| end.is_of_jump);
            let [landed, last] = match segment.kind {
                SegmentKind::Flight { .. } => [None; 2],
                SegmentKind::Phase => [None, Some(until(end.map(|end| end.contact)))],
                SegmentKind::Chatter { landing, .. } => {
                    [Some(landing), end.map(|end| end.contact)].map(|number| Some(until(number)))
                }
            };
            landed.into_iter().chain(last)
        });
        Modes::cycle(modes)
    }

    /// Number of segments that the kink of an input ends.
    pub fn kinks(&self) -> usize {
        let ends = self.segments.iter().filter_map(|segment| segment.end);
        ends.filter(|end| end.at_kink.is_some()).count()
    }

    /// The segment before one.
    pub fn before(&self, number: usize) -> &Segment {
        let count = self.segments.len();
        &self.segments[(number + count - 1) % count]
    }

    /// The sequence without some segments; `begins` has the beginning of each. The kept neighbours
    /// become one segment where no contact changes between them. Otherwise the earlier one ends
    /// with the first event of a contact that changes. `None` where nothing would be left, or where
    /// two contacts change.
    pub fn without(&self, removed: &[usize], begins: &[Moment]) -> Option<Self> {
        let count = self.segments.len();
        let kept: Vec<usize> = (0..count).filter(|k| !removed.contains(k)).collect();
        let mut segments: Vec<Segment> = Vec::with_capacity(kept.len());
        let mut begin = begins[*kept.first()?].clone();
        // A segment that continues in the next kept one, and the index of its beginning.
        let mut merged: Option<(Segment, usize)> = None;
        // Time by which the next kept segment begins earlier, as removed segments follow its event.
        let mut earlier = 0.0;
        for (number, &k) in kept.iter().enumerate() {
            let mut own = self.segments[k].clone();
            let mut first = k;
            if let Some((before, began)) = merged.take() {
                own.duration += before.duration;
                first = began;
            }
            own.duration += std::mem::take(&mut earlier);
            let next = *kept.get(number + 1).unwrap_or(&kept[0]);
            let gap = (k + 1..k + count).map(|at| at % count);
            let gap: Vec<usize> = gap.take_while(|at| *at != next && *at != k).collect();
            let lasts =
                |which: &[usize]| -> f64 { which.iter().map(|&k| self.segments[k].duration).sum() };
            let there = self.segments[next].mode;
            // An orbit with a jump is not the limit of orbits without it.
            let remains = |k: usize| {
                let end = self.segments[k].end;
                let changes = |contact: usize| own.mode.get(contact) != there.get(contact);
                end.filter(|end| end.is_of_jump || changes(end.contact))
            };
            let ends = std::iter::once(k).chain(gap.iter().copied()).enumerate();
            let mut ends = ends.filter_map(|(place, k)| Some((place, remains(k)?)));
            match ends.next() {
                _ if gap.is_empty() => {}
                Some((place, end)) => {
                    if ends.any(|(_, other)| other.contact != end.contact) {
                        return None;
                    }
                    let (before, behind) = gap.split_at(place);
                    own.end = Some(end);
                    own.duration += lasts(before);
                    earlier = lasts(behind);
                    if let (true, Some(&first)) = (next == kept[0], behind.first()) {
                        begin = begins[first].clone();
                    }
                }
                None if own.mode == there => {
                    own.duration += lasts(&gap);
                    merged = Some((own, first));
                    continue;
                }
                None => return None,
            }
            segments.push(own);
        }
        if let Some((last, began)) = merged {
            // It continues in the first segment, or is the only one.
            begin = begins[began].clone();
            match segments.first_mut() {
                Some(first) => first.duration += last.duration,
                None => segments.push(Segment { end: None, ..last }),
            }
        }
        if let Some(first) = segments.first_mut() {
            first.duration += earlier;
        }
        Some(OrbitGuess {
            segments,
            begin,
            cut: None,
            extent: self.extent,
        })
    }

    /// The sequence in which the event that ends a segment precedes the one that begins it, as
    /// where two contacts switch in the same instant. The segment between them has the given
    /// duration. `None` where both events belong to one contact.
    pub fn swapped(&self, number: usize, duration: f64) -> Option<Self> {
        let count = self.segments.len();
        let (before, behind) = ((number + count - 1) % count, (number + 1) % count);
        let [first, second] = [before, number].map(|k| self.segments[k].end);
        let contact = second?.contact;
        if first?.contact == contact {
            return None;
        }
        let mut other = self.clone();
        let mode = self.segments[behind].mode.get(contact);
        other.segments[number].mode = self.segments[before].mode.with(contact, mode);
        (other.segments[before].end, other.segments[number].end) = (second, first);
        other.segments[number].duration = duration;
        Some(other)
    }
}

/// The longest of the segments with the fewest sticking contacts. Very short segments do not count,
/// since they may exist by rounding alone.
pub(super) fn segment_to_cut(segments: &[Segment]) -> usize {
    // Fraction of the longest segment. Chosen: far above what rounding makes, 1e-13.
    const LASTING: f64 = 1e-2;
    let sticks = |one: &Segment| one.mode.iter().filter(|mode| *mode == Mode::Stick).count();
    let cuttable = || {
        segments
            .iter()
            .enumerate()
            .filter(|(_, one)| one.is_cuttable())
    };
    let longest = cuttable().map(|(_, one)| one.duration).fold(0.0, f64::max);
    let lasting = cuttable().filter(|(_, one)| one.duration >= LASTING * longest);
    let best = lasting.min_by(|(_, a), (_, b)| {
        let longer = b.duration.total_cmp(&a.duration);
        sticks(a).cmp(&sticks(b)).then(longer)
    });
    best.map_or(0, |(number, _)| number)
}
