//! A batch of orbits by Taylor series: series of the same shape are expanded together, one orbit to a lane.
//!
//! One orbit's series is a chain of operations that wait for each other. Several orbits have several chains, and the machine
//! works on all of them in the time of one. What follows an expansion is each orbit's own, as it is alone, and every lane has
//! the bits that it would have alone.

use super::ensemble::Start;
use super::integration::{Integration, Progress};
use super::observer::Observer;
use super::options::Options;
use super::solve::{Failure, Summary, tell};
use super::stepper::Stepper;
use super::taylor::TaylorStepper;
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::system::Filippov;
use crate::taylor::series::Series;
use crate::taylor::tape::{Numbers, Tape};

/// Orbits that are expanded together.
const LANES: usize = 8;

/// Orbits under way at once: enough that some of them are nearly always alike.
const UNDER_WAY: usize = 32;

type Outcome<const N: usize> = Result<Summary<N>, Failure<Summary<N>>>;

/// An orbit under way.
struct Member<'a, S, O, const N: usize> {
    /// Its place among the starts.
    number: usize,
    integration: Integration<'a, S, N>,
    observer: &'a mut O,
    is_stopping: bool,
}

impl<'a, S: Filippov<N>, O: Observer<N>, const N: usize> Member<'a, S, O, N> {
    /// An orbit at its first series, or its outcome if that comes before.
    fn begin(
        number: usize,
        start: &'a Start<S, N>,
        observer: &'a mut O,
        t_end: f64,
        options: &Options,
        mut stepper: Stepper<N>,
    ) -> Result<Self, Outcome<N>> {
        stepper.forget();
        let (t, x) = (start.t, start.x);
        let begun =
            Integration::with_stepper(&start.system, Timed { t, x }, t_end, options, stepper);
        let mut member = Member {
            number,
            integration: begun.map_err(|error| Err(Failure::new(error, Summary::of_none(t, x))))?,
            observer,
            is_stopping: false,
        };
        match member.prepare() {
            None => Ok(member),
            Some(outcome) => Err(outcome),
        }
    }

    /// Goes on to where the next series is needed, or to the outcome.
    fn prepare(&mut self) -> Option<Outcome<N>> {
        loop {
            let progress = match self.integration.prepare() {
                Ok(None) => return None,
                Ok(Some(progress)) => Ok(progress),
                Err(error) => Err(error),
            };
            let outcome = self.tell(progress);
            if outcome.is_some() {
                return outcome;
            }
        }
    }

    /// A step on the series that was expanded, and on to the next.
    fn step(&mut self) -> Option<Outcome<N>> {
        let outcome = match self.integration.advance() {
            Ok(false) => None,
            Ok(true) => self.tell(Ok(Progress::Step)),
            Err(error) => self.tell(Err(error)),
        };
        outcome.or_else(|| self.prepare())
    }

    /// Tells the observer; the outcome, where the run has come to it.
    fn tell(&mut self, progress: Result<Progress<N>, Error>) -> Option<Outcome<N>> {
        let (integration, is_stopping) = (&self.integration, &mut self.is_stopping);
        let told =
            progress.and_then(|progress| tell(integration, &progress, self.observer, is_stopping));
        let failed = |error| Failure::new(error, integration.summary(Ending::Failed));
        told.map_err(failed).transpose()
    }
}

/// What the orbits of a thread share.
struct Lanes {
    /// A tape of every shape that was met.
    shapes: Vec<Tape>,
    /// The members that wait for a series, by the shape of their tapes.
    waiting: Vec<Vec<usize>>,
    series: Series<LANES>,
    numbers: Numbers<LANES>,
}

impl Lanes {
    /// Lets a member wait for others of its shape.
    fn wait<S, O, const N: usize>(&mut self, members: &mut [Member<'_, S, O, N>], number: usize) {
        let Some(series) = members[number].integration.stepper.series_mut() else {
            return;
        };
        let tape = series.tape_mut();
        let shape = match tape.shape {
            Some(shape) => shape,
            None => self.shape(tape),
        };
        tape.shape = Some(shape);
        self.waiting[shape].push(number);
    }

    fn shape(&mut self, tape: &Tape) -> usize {
        let known = self.shapes.iter().position(|shape| shape.is_alike(tape));
        known.unwrap_or_else(|| {
            self.shapes.push(tape.clone());
            self.waiting.push(Vec::new());
            self.shapes.len() - 1
        })
    }

    /// Takes the members that are expanded next: of the shape that most wait with.
    fn next(&mut self) -> Vec<usize> {
        match self.waiting.iter_mut().max_by_key(|members| members.len()) {
            Some(members) => members.split_off(members.len().saturating_sub(LANES)),
            None => Vec::new(),
        }
    }

    fn expand<S, O, const N: usize>(
        &mut self,
        members: &mut [Member<'_, S, O, N>],
        group: &[usize],
    ) {
        if let [one] = *group {
            let integration = &mut members[one].integration;
            return integration.stepper.expand(&integration.run);
        }
        let lanes: [Option<(&TaylorStepper<N>, Timed<N>)>; LANES] = std::array::from_fn(|lane| {
            let integration = &members[*group.get(lane)?].integration;
            Some((integration.stepper.series()?, integration.run.at))
        });
        let Some(first) = lanes[0] else { return };
        // Lanes without an orbit do the first one's work again.
        let lanes = lanes.map(|lane| lane.unwrap_or(first));
        let tapes = lanes.map(|(stepper, _)| stepper.tape());
        let times = lanes.map(|(_, at)| at.t);
        let scales = lanes.map(|(stepper, _)| stepper.order_and_scale().1);
        let order = first.0.order_and_scale().0;
        let x: [[f64; LANES]; N] = std::array::from_fn(|i| lanes.map(|(_, at)| at.x[i]));
        self.numbers.gather(tapes.map(|tape| &tape.numbers));
        self.series.fit(tapes[0]);
        self.series
            .expand_all(tapes[0], &self.numbers, (&times, &x), &scales, order);
        for (lane, &number) in group.iter().enumerate() {
            if let Some(stepper) = members[number].integration.stepper.series_mut() {
                stepper.take_lane(&self.series, lane);
            }
        }
    }
}

/// Runs every start with its observer, as [`crate::run`] does by [`crate::Method::Taylor`]; the outcomes are in the order of
/// the starts.
pub(super) fn side_by_side<S: Filippov<N>, O: Observer<N>, const N: usize>(
    starts: &[Start<S, N>],
    observers: &mut [O],
    t_end: f64,
    options: &Options,
) -> Vec<Outcome<N>> {
    let mut outcomes: Vec<_> = starts.iter().map(|_| None).collect();
    let mut waiting = starts.iter().zip(observers).enumerate();
    // The next orbit at its first series; one that ends before has its outcome.
    let mut next = |outcomes: &mut [Option<_>], mut room: Option<Stepper<N>>| {
        waiting.find_map(|(number, (start, observer))| {
            let stepper = room.take().unwrap_or_else(|| Stepper::new(options));
            match Member::begin(number, start, observer, t_end, options, stepper) {
                Ok(member) => Some(member),
                Err(outcome) => {
                    outcomes[number] = Some(outcome);
                    None
                }
            }
        })
    };
    let mut lanes = Lanes {
        shapes: Vec::new(),
        waiting: Vec::new(),
        series: Series::new(),
        numbers: Numbers::default(),
    };
    let mut members = Vec::with_capacity(UNDER_WAY);
    while members.len() < UNDER_WAY
        && let Some(member) = next(&mut outcomes, None)
    {
        members.push(member);
    }
    for i in 0..members.len() {
        lanes.wait(&mut members, i);
    }
    loop {
        let group = lanes.next();
        if group.is_empty() {
            break;
        }
        lanes.expand(&mut members, &group);
        for i in group {
            let outcome = members[i].step();
            if outcome.is_some() {
                outcomes[members[i].number] = outcome;
                // The room that the last orbit took is the next one's.
                let stepper = &mut members[i].integration.stepper;
                let stepper = std::mem::replace(stepper, Stepper::new(options));
                match next(&mut outcomes, Some(stepper)) {
                    Some(member) => members[i] = member,
                    None => continue,
                }
            }
            lanes.wait(&mut members, i);
        }
    }
    outcomes.into_iter().flatten().collect()
}
