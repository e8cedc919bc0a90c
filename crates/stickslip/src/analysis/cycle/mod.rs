//! Periodic orbits as segments with a given sequence of modes.
//!
//! Each segment ends where its own event function vanishes. The unknowns are the state and the time
//! at which the first segment begins, and the durations. The equations are that the orbit closes
//! and that the event functions vanish (Thota & Dankowicz 2008; Dankowicz & Schilder 2013). The
//! sequence does not react to the guards. So the orbit continues smoothly where it touches a
//! boundary, and a change of its phases is the zero of a margin along the branch.

mod equations;
mod margin;
mod minima;
mod name;
mod newton;
mod path;
mod pieces;
mod shooting;

use crate::dynamics::{Dynamics, Matrix, Modes, Moment, Orbit, Transition, Vector};
use crate::error::Error;
use crate::filippov::{Options, TransitionKind};
use crate::system::Mode;
pub(super) use margin::{Margin, MarginKind};
pub(super) use name::describe;
pub use name::{SequenceBifurcation, SequenceChange};
pub(super) use path::{Function, Path, Zero, at_least};
pub(super) use shooting::{Extra, Shooting};

/// What ends a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Event {
    /// The guard that vanishes.
    pub guard: usize,
    /// The contact to which it belongs; for a jump, its number counted after those of the contacts.
    pub contact: usize,
    /// Whether contact is lost or gained there.
    pub is_of_contact: bool,
    /// Whether the state jumps there.
    pub is_of_jump: bool,
    /// Set where the kink of an input decides the time of the event instead of its own function, as
    /// where a switching force releases a contact: the input, and the reading of its clock.
    pub at_kink: Option<(usize, f64)>,
}

/// A part of a periodic orbit in one mode.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Segment {
    pub mode: Modes,
    /// A moment inside it, which decides whether contact is lost or kept.
    pub inside: Moment,
    /// Its end; `None` where the orbit has no transition.
    pub end: Option<Event>,
    pub duration: f64,
}

/// A periodic orbit to be computed: its segments, and where the first of them begins.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Outline {
    pub segments: Vec<Segment>,
    pub begin: Moment,
    /// Where it is cut; `None` before a choice is made.
    pub cut: Option<Cut>,
    /// Extent of the run from which it was taken.
    pub extent: f64,
}

/// States on the orbit that are unknowns as well (multiple shooting), so that neighbours separate
/// only between one and the next.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cut {
    /// A segment that is also cut in its middle: near a saddle, neighbours separate most in the
    /// longest one.
    pub number: usize,
    /// Where each segment after the first begins, and after these the middle of that one.
    pub states: Vec<Vector>,
}

impl Outline {
    /// The orbit from a state for about a period, with the modes of the run. It begins with the
    /// first transition, and ends with one of the same kind about a period later.
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
        const SPAN: f64 = 2.5;
        let (orbit, failed) = Orbit::begun(system, start, start.t + SPAN * period, options)?;
        if orbit.end.t < start.t + period {
            return Err(failed.unwrap_or_else(|| orbit.end.goes_no_further()));
        }
        let ways = orbit.steps.iter().map(|(step, _)| &step.x_end - &start.x);
        let extent = ways.fold(f64::MIN_POSITIVE, |most, way| most.max(way.amax()));
        let turns = orbit.transitions.iter();
        let turns: Vec<&Transition> = turns
            .filter(|at| at.kind != TransitionKind::Touch)
            .collect();
        let event = |at: &Transition| {
            let here = at.moment();
            let is_of_jump = at.kind == TransitionKind::Jump;
            let flow = system.flow(at.from, &here);
            let kink = system.kink(&here);
            let of_contact = flow.guards().into_iter().filter(|guard| {
                guard.contact == at.contact && guard.goes_on == is_of_contact(at.kind)
            });
            let value = |number: usize| flow.guard(number, &here).abs();
            let least = of_contact.min_by(|a, b| value(a.number).total_cmp(&value(b.number)));
            Event {
                guard: least.map_or(at.contact, |guard| guard.number),
                contact: at.contact,
                is_of_contact: is_of_contact(at.kind),
                is_of_jump,
                at_kink: kink.map(|input| (input, system.clock(input, &here).0)),
            }
        };
        // The state after a transition.
        let behind = |at: &Transition| match at.kind {
            TransitionKind::Jump => system.reset(at.contact, &at.moment()).after,
            _ => at.x.clone(),
        };
        let whole = |mode: Modes| Segment {
            mode,
            inside: start.clone(),
            end: None,
            duration: period,
        };
        if turns.first().is_none_or(|at| at.t > start.t + period) {
            let middle = orbit.at(start.t + 0.5 * period)?;
            let mode = orbit.phases.first().map(|phase| phase.mode);
            return Ok(Outline {
                segments: mode.map(whole).into_iter().collect(),
                begin: start.clone(),
                cut: Some(Cut {
                    number: 0,
                    states: vec![middle],
                }),
                extent,
            });
        }
        // The first that recurs: the start may lie off the orbit.
        let comes_again = |first: usize| {
            let begin = turns[first];
            let is_alike = |at: &Transition| {
                (at.kind, at.contact, at.from, at.to)
                    == (begin.kind, begin.contact, begin.from, begin.to)
            };
            let off = |k: usize| (turns[k].t - begin.t - period).abs();
            let again = (first + 1..turns.len())
                .filter(|&k| is_alike(turns[k]) && off(k) < 0.5 * period)
                .min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
            Some((first, again))
        };
        let again = (0..turns.len()).find_map(comes_again);
        let not_found = failed.unwrap_or(Error::NotFound {
            what: "a return of the orbit",
            t: start.t,
            span: SPAN * period,
        });
        let (first, again) = again.ok_or(not_found)?;
        let mut segments = Vec::with_capacity(again - first);
        for pair in turns[first..=again].windows(2) {
            let t = 0.5 * (pair[0].t + pair[1].t);
            let inside = Moment { t, x: orbit.at(t)? };
            segments.push(Segment {
                mode: pair[0].to,
                end: Some(event(pair[1])),
                inside,
                duration: pair[1].t - pair[0].t,
            });
        }
        // With the run's own states, its errors do not grow from one segment to the next.
        let number = to_cut(&segments);
        let begins = turns[first + 1..again].iter().map(|at| behind(at));
        let middle = segments.get(number).map(|one| one.inside.x.clone());
        Ok(Outline {
            begin: Moment {
                t: turns[first].t,
                x: behind(turns[first]),
            },
            cut: Some(Cut {
                number,
                states: begins.chain(middle).collect(),
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

    /// The same sequence with other unknowns.
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

    /// The orbit traversed twice.
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
            // Without a transition it remains one segment.
            [only] if only.end.is_none() => vec![Segment {
                duration: 2.0 * only.duration,
                ..only.clone()
            }],
            all => all.iter().cloned().chain(all.iter().map(again)).collect(),
        };
        Outline {
            segments,
            cut: None,
            ..self.clone()
        }
    }

    /// The modes as [`Modes::cycle`], with the jumps between them.
    pub fn modes(&self) -> Vec<Modes> {
        let modes = self.segments.iter().map(|segment| {
            let end = segment.end.filter(|end| end.is_of_jump);
            segment
                .mode
                .until(end.map(|end| end.contact - segment.mode.len()))
        });
        Modes::cycle(modes)
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
        // What continues in the next kept segment, and its beginning.
        let mut open: Option<(Segment, usize)> = None;
        // Time by which the next kept segment begins earlier, without what is removed behind its
        // event.
        let mut earlier = 0.0;
        for (number, &k) in kept.iter().enumerate() {
            let mut own = self.segments[k].clone();
            let mut first = k;
            if let Some((open, began)) = open.take() {
                own.duration += open.duration;
                first = began;
            }
            own.duration += std::mem::take(&mut earlier);
            let next = *kept.get(number + 1).unwrap_or(&kept[0]);
            let gone = (k + 1..k + count).map(|at| at % count);
            let gone: Vec<usize> = gone.take_while(|at| *at != next && *at != k).collect();
            let lasts =
                |gone: &[usize]| -> f64 { gone.iter().map(|&k| self.segments[k].duration).sum() };
            let there = self.segments[next].mode;
            let changes = |k: usize| {
                let end = self.segments[k].end;
                end.filter(|end| own.mode.get(end.contact) != there.get(end.contact))
            };
            let between = || std::iter::once(k).chain(gone.iter().copied());
            // No orbit without a jump is adjacent to one with it.
            let jumps = |k: usize| self.segments[k].end.is_some_and(|end| end.is_of_jump);
            if !gone.is_empty() && between().any(jumps) {
                return None;
            }
            let ends = between().enumerate();
            let mut ends = ends.filter_map(|(place, k)| Some((place, changes(k)?)));
            match ends.next() {
                _ if gone.is_empty() => {}
                Some((place, end)) => {
                    if ends.any(|(_, other)| other.contact != end.contact) {
                        return None;
                    }
                    let (before, behind) = gone.split_at(place);
                    own.end = Some(end);
                    own.duration += lasts(before);
                    earlier = lasts(behind);
                    if let (true, Some(&first)) = (next == kept[0], behind.first()) {
                        begin = begins[first].clone();
                    }
                }
                None if own.mode == there => {
                    own.duration += lasts(&gone);
                    open = Some((own, first));
                    continue;
                }
                None => return None,
            }
            segments.push(own);
        }
        if let Some((open, began)) = open {
            // It continues in the first one, or in itself.
            begin = begins[began].clone();
            match segments.first_mut() {
                Some(first) => first.duration += open.duration,
                None => segments.push(Segment { end: None, ..open }),
            }
        }
        if let Some(first) = segments.first_mut() {
            first.duration += earlier;
        }
        Some(Outline {
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

/// The longest of the segments with the fewest sticking contacts; a shorter one may exist by
/// rounding alone.
fn to_cut(segments: &[Segment]) -> usize {
    const SHORT: f64 = 1e-2;
    let sticks = |one: &Segment| one.mode.iter().filter(|mode| *mode == Mode::Stick).count();
    let longest = segments.iter().map(|one| one.duration).fold(0.0, f64::max);
    let lasting = segments.iter().enumerate();
    let lasting = lasting.filter(|(_, one)| one.duration >= SHORT * longest);
    let best = lasting.min_by(|(_, a), (_, b)| {
        let longer = b.duration.total_cmp(&a.duration);
        sticks(a).cmp(&sticks(b)).then(longer)
    });
    best.map_or(0, |(number, _)| number)
}

/// A vector of this length with a 1 at a place.
pub(crate) fn unit(count: usize, place: usize) -> Vector {
    Vector::from_fn(count, |i, _| f64::from(u8::from(i == place)))
}

/// Whether a transition is a loss or gain of contact.
fn is_of_contact(kind: TransitionKind) -> bool {
    matches!(
        kind,
        TransitionKind::ContactLoss | TransitionKind::ContactGain
    )
}

/// A computed periodic orbit.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cycle {
    pub outline: Outline,
    /// Where each segment begins.
    pub begins: Vec<Moment>,
    pub period: f64,
    /// The derivative of the equations by the unknowns.
    pub jacobian: Matrix,
    /// The derivative of the flow map of the states over the period from the cut, with saltation at
    /// every event; in an autonomous system, transverse to the flow.
    pub monodromy: Matrix,
    /// The margins to each change of its phases.
    pub margins: Vec<Margin>,
    /// The largest range of a component.
    pub extent: f64,
    /// Where it is cut: the middle of the longest of the segments with the fewest sticking
    /// contacts.
    pub anchor: Moment,
    /// Residual allowed in its equations, in units of length.
    pub closes_to: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Dimension of the family of orbits to which it belongs.
    pub family: usize,
}

impl Cycle {
    /// Whether the cut segment has become much shorter than another one.
    pub fn is_badly_cut(&self) -> bool {
        const MUCH: f64 = 0.3;
        let durations = || self.outline.segments.iter().map(|one| one.duration);
        let longest = durations().fold(0.0, f64::max);
        let cut = self.outline.cut.as_ref();
        cut.is_none_or(|cut| durations().nth(cut.number) < Some(MUCH * longest))
    }

    /// The difference between the two halves of the orbit, where they have the same phases: of the
    /// states at which these begin and, in units of the states, of the times.
    pub fn halves(&self) -> Option<Vector> {
        let outline = &self.outline;
        if let ([_], Some(cut)) = (outline.segments.as_slice(), &outline.cut) {
            let half = cut.states.first()? - &outline.begin.x;
            return outline.segments[0].end.is_none().then_some(half);
        }
        let half = outline.segments.len() / 2;
        let (one, other) = outline.segments.split_at(half);
        // The clock of a kink has gone on in the second half.
        let event = |one: &Segment| {
            let end = one.end?;
            Some((end.guard, end.contact, end.at_kink.map(|kink| kink.0)))
        };
        let is_alike = |(a, b): (&Segment, &Segment)| (a.mode, event(a)) == (b.mode, event(b));
        if half == 0 || one.len() != other.len() || !one.iter().zip(other).all(is_alike) {
            return None;
        }
        let by_time = self.extent / self.period;
        let parts = self.begins.iter().zip(self.begins.get(half..)?);
        let parts = parts.take(half).flat_map(|(one, other)| {
            let later = other.t - one.t - 0.5 * self.period;
            let apart = (&other.x - &one.x).push(later * by_time);
            apart.iter().copied().collect::<Vec<f64>>()
        });
        Some(Vector::from_vec(parts.collect()))
    }

    /// The margin of the same kind as one of a nearby orbit, at about the same time.
    pub fn margin_like(&self, other: &Margin) -> Option<&Margin> {
        other.like(&self.margins, self.period)
    }

    /// The margin nearest to zero among those near some segments of another orbit.
    pub fn margin_about(&self, other: &Cycle, numbers: &[usize]) -> Option<&Margin> {
        const NEXT_TO: f64 = 1e-2;
        let about = self.margins.iter().filter(|margin| {
            let is_about = |&k: &usize| {
                let lasts = other.outline.segments[k].duration;
                let middle = other.begins[k].t + 0.5 * lasts;
                let way = (margin.at.t - middle) / other.period;
                (way - way.round()).abs() <= lasts / other.period + NEXT_TO
            };
            margin.kind != MarginKind::Duration && numbers.iter().any(is_about)
        });
        let off = |margin: &Margin| margin.relative().abs();
        about.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}
