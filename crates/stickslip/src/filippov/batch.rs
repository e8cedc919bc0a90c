//! A batch of orbits by Taylor series. Orbits of one system that are in the same mode are expanded
//! together, one orbit in each lane.
//!
//! A coefficient is then a vector with one number for each orbit. The lengths and ends of the steps
//! are computed in lanes, too. Everything else is done for each orbit by itself. Each orbit is
//! bit-for-bit the same as when computed alone.

use pulp::{Arch, NullaryFnOnce};

use super::ensemble::Start;
use super::flow::Flow;
use super::integration::{Integration, Progress};
use super::observer::Observer;
use super::options::Options;
use super::solve::{Failure, Summary, tell};
use super::stepper::Stepper;
use super::switched::{Switched, UseFlow};
use super::taylor::{Ends, OfFlow, step_ratio};
use crate::error::Error;
use crate::ode::Timed;
use crate::orbit::Ending;
use crate::taylor::pass::{AT_ONCE, Rows};
use crate::taylor::repeated::Repeated;
use crate::taylor::row::{Lanes, Row};
use crate::taylor::series::{Expansion, Series, in_rows};

/// Number of orbits that are expanded together.
const LANES: usize = 8;

/// Fewer orbits than this are expanded one by one, which takes no longer.
const WORTH_IT: usize = 3;

/// Number of orbits under way at once. With so many, some are nearly always in the same mode.
const UNDER_WAY: usize = 32;

type Outcome<const N: usize> = Result<Summary<N>, Failure<Summary<N>>>;

/// An orbit under way.
struct Member<'a, S: Switched<N, G>, O, const N: usize, const G: usize> {
    /// Index of its start.
    number: usize,
    /// The number of the first orbit whose system is equal to this one's.
    class: usize,
    integration: Integration<'a, S, N, G>,
    observer: &'a mut O,
    /// Whether its observer watches the next step.
    is_watched: bool,
    is_stopping: bool,
}

impl<'a, S: Switched<N, G>, O: Observer<N, S::Mode>, const N: usize, const G: usize>
    Member<'a, S, O, N, G>
{
    /// An orbit that needs its first series, or its outcome if it ends before.
    fn begin(
        (number, class): (usize, usize),
        start: &'a Start<S, N>,
        observer: &'a mut O,
        t_end: f64,
        options: &Options,
        mut stepper: Stepper<N, G>,
    ) -> Result<Self, Outcome<N>> {
        stepper.forget();
        let (t, x) = (start.t, start.x);
        let begun =
            Integration::with_stepper(&start.system, (Timed { t, x }, N), t_end, options, stepper);
        let mut member = Member {
            number,
            class,
            integration: begun.map_err(|error| Err(Failure::new(error, Summary::of_none(t, x))))?,
            observer,
            is_watched: true,
            is_stopping: false,
        };
        match member.prepare() {
            None => Ok(member),
            Some(outcome) => Err(outcome),
        }
    }

    /// Continues until the next series is needed, or to the outcome.
    fn prepare(&mut self) -> Option<Outcome<N>> {
        loop {
            let progress = match self.integration.prepare() {
                Ok(true) => return None,
                Ok(false) => self.integration.say(),
                Err(error) => Err(error),
            };
            let outcome = self.tell(progress);
            if outcome.is_some() {
                return outcome;
            }
        }
    }

    /// Takes the step by the series that was expanded, and continues to the next one.
    fn step(&mut self) -> Option<Outcome<N>> {
        let outcome = match self.integration.advance() {
            Ok(false) => None,
            Ok(true) if self.is_watched => self.tell(Ok(Progress::Step)),
            Ok(true) => None,
            Err(error) => self.tell(Err(error)),
        };
        outcome.or_else(|| self.prepare())
    }

    /// Informs the observer. Returns the outcome if the run has ended.
    fn tell(&mut self, progress: Result<Progress<N, S::Mode>, Error>) -> Option<Outcome<N>> {
        let (integration, is_stopping) = (&mut self.integration, &mut self.is_stopping);
        let told =
            progress.and_then(|progress| tell(integration, &progress, self.observer, is_stopping));
        let failed = |error| Failure::new(error, self.integration.summary(Ending::Failed));
        told.map_err(failed).transpose()
    }
}

/// What orbits must share to be expanded together: the system's class and what decides the flow.
type Kind<K, B> = (usize, K, B);

/// Orbits of one kind that wait for a series.
struct Queue<K, B> {
    kind: Kind<K, B>,
    members: Vec<usize>,
}

/// Orbits that are expanded together: what they share, and each one's lane.
struct Lanewise<'a, F, P, const N: usize> {
    flow: &'a F,
    rows: &'a [Row<LANES>],
    t: Lanes<LANES>,
    x: [Lanes<LANES>; N],
    h: Lanes<LANES>,
    order: usize,
    options: &'a Options,
    /// Chooses the steps by the radii of convergence of the series.
    plan: &'a mut P,
}

/// Result of expanding several orbits: the step lengths (relative to the scale of the series) and
/// the states at the steps' ends.
struct Planned<const N: usize, const G: usize> {
    expansion: Expansion<G>,
    ratios: Lanes<LANES>,
    ends: Ends<LANES, N, G>,
}

/// Expands several orbits in one mode, in the widest vectors of the machine. The width changes no
/// bit. Without a result they are expanded one by one.
///
/// The first rows are an argument because it consists of two references: see [`Rows`].
struct Together<'a, 'b, F, P, const N: usize, const G: usize> {
    first: &'a [Row<LANES>; AT_ONCE],
    of: &'a mut Lanewise<'b, F, P, N>,
}

impl<F, P, const N: usize, const G: usize> NullaryFnOnce for Together<'_, '_, F, P, N, G>
where
    F: Flow<N>,
    P: FnMut(Lanes<LANES>) -> Lanes<LANES>,
{
    type Output = Result<Option<Planned<N, G>>, usize>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let of = self.of;
        let (order, all) = (of.order, of.rows);
        let rows = Rows {
            first: self.first,
            all,
        };
        let (flow, time) = (OfFlow(of.flow), (of.t, of.h));
        let expansion = in_rows(rows, time, &of.x, order, &flow, &mut Repeated::new())?;
        if expansion.divided || expansion.value_read || expansion.overflowed {
            return Ok(None);
        }
        let ratios = (of.plan)(step_ratio(all, &expansion, order, of.options, time, &of.x));
        let ends = Ends::of(all, &expansion, order, ratios);
        Ok(Some(Planned {
            expansion,
            ratios,
            ends,
        }))
    }
}

/// The orbits of a thread.
struct Batch<'a, S: Switched<N, G>, O, const N: usize, const G: usize> {
    members: Vec<Member<'a, S, O, N, G>>,
    waiting: Vec<Queue<S::Mode, S::Branch>>,
    series: Series<LANES>,
    options: &'a Options,
}

impl<'a, S: Switched<N, G>, O: Observer<N, S::Mode>, const N: usize, const G: usize>
    Batch<'a, S, O, N, G>
{
    /// Puts an orbit into the queue of its kind.
    fn wait(&mut self, number: usize) {
        let member = &self.members[number];
        let integration = &member.integration;
        let kind = (member.class, integration.mode, integration.branch);
        match self.waiting.iter_mut().find(|queue| queue.kind == kind) {
            Some(queue) => queue.members.push(number),
            None => self.waiting.push(Queue {
                kind,
                members: vec![number],
            }),
        }
    }

    /// Takes the orbits that are expanded next: those of the most frequent kind.
    fn next(&mut self) -> Option<Vec<usize>> {
        let waiting = self.waiting.iter_mut().enumerate();
        let (i, queue) = waiting.max_by_key(|(_, queue)| queue.members.len())?;
        let left = queue.members.len().saturating_sub(LANES);
        let group = queue.members.split_off(left);
        if left == 0 {
            self.waiting.swap_remove(i);
        }
        Some(group)
    }

    /// Expands the orbits' series in lanes. Where that is impossible or does not pay, each step
    /// expands its own.
    fn expand(&mut self, group: &[usize]) {
        for &number in group {
            let member = &mut self.members[number];
            member.is_watched = member.observer.watches_steps();
        }
        if group.len() < WORTH_IT {
            return;
        }
        let first = &self.members[group[0]].integration;
        let (system, mode, branch) = (first.system, first.mode, first.branch);
        system.with_flow(mode, branch, Grouped { batch: self, group });
    }

    fn expand_with<F: Flow<N>>(&mut self, group: &[usize], flow: &F) {
        let (mut t, mut x, mut h) = ([0.0; LANES], [[0.0; LANES]; N], [0.0; LANES]);
        let mut order = 0;
        for lane in 0..LANES {
            // Lanes without an orbit repeat the first one's work.
            let number = group.get(lane).unwrap_or(&group[0]);
            let integration = &mut self.members[*number].integration;
            let Some(stepper) = integration.stepper.series_mut() else {
                return;
            };
            (order, h[lane]) = stepper.order_and_scale();
            let at = &integration.run.at;
            t[lane] = at.t;
            for (x, at) in x.iter_mut().zip(&at.x) {
                x[lane] = *at;
            }
        }
        let (arch, options, members) = (Arch::new(), self.options, &mut self.members);
        let mut plan = |mut ratios: Lanes<LANES>| {
            for (ratio, &number) in ratios.iter_mut().zip(group) {
                let Integration { stepper, run, .. } = &mut members[number].integration;
                if let Some(stepper) = stepper.series_mut() {
                    *ratio = stepper.plan(run, *ratio);
                }
            }
            ratios
        };
        let planned = self.series.expand_by(|rows| {
            let (first, plan) = (rows.first, &mut plan);
            let of = &mut Lanewise {
                flow,
                rows: rows.all,
                t,
                x,
                h,
                order,
                options,
                plan,
            };
            arch.dispatch(Together { first, of })
        });
        let Some(Planned {
            expansion,
            ratios,
            ends,
        }) = planned
        else {
            return;
        };
        for (lane, &number) in group.iter().enumerate() {
            let member = &mut self.members[number];
            let Integration { stepper, run, .. } = &mut member.integration;
            let is_bare = !member.is_watched && run.orders == [0; G];
            let end = is_bare.then(|| ends.clear(lane)).flatten();
            if let Some(stepper) = stepper.series_mut() {
                let lane = (lane, ratios[lane]);
                stepper.expanded(&expansion);
                stepper.take(run, &self.series, lane, end);
            }
        }
    }
}

/// Orbits of one kind, with the flow that expands them.
struct Grouped<'b, 'a, S: Switched<N, G>, O, const N: usize, const G: usize> {
    batch: &'b mut Batch<'a, S, O, N, G>,
    group: &'b [usize],
}

impl<S: Switched<N, G>, O: Observer<N, S::Mode>, const N: usize, const G: usize> UseFlow<N>
    for Grouped<'_, '_, S, O, N, G>
{
    type Output = ();

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) {
        self.batch.expand_with(self.group, flow);
    }
}

/// Runs every start with its observer, as [`crate::run`] does with [`crate::Method::Taylor`].
/// Outcomes are in the order of the starts.
pub(super) fn side_by_side<S, O, const N: usize, const G: usize>(
    starts: &[Start<S, N>],
    observers: &mut [O],
    t_end: f64,
    options: &Options,
) -> Vec<Outcome<N>>
where
    S: Switched<N, G> + PartialEq,
    O: Observer<N, S::Mode>,
{
    let mut outcomes: Vec<_> = starts.iter().map(|_| None).collect();
    let classes = classes(starts);
    let mut waiting = starts.iter().zip(observers).zip(classes).enumerate();
    // The next orbit that needs its first series. One that ends before has its outcome already.
    let mut next = |outcomes: &mut [Option<_>], mut room: Option<Stepper<N, G>>| {
        waiting.find_map(|(number, ((start, observer), class))| {
            let stepper = room.take().unwrap_or_else(|| Stepper::new(options));
            match Member::begin((number, class), start, observer, t_end, options, stepper) {
                Ok(member) => Some(member),
                Err(outcome) => {
                    outcomes[number] = Some(outcome);
                    None
                }
            }
        })
    };
    let mut batch = Batch {
        members: Vec::with_capacity(UNDER_WAY),
        waiting: Vec::new(),
        series: Series::default(),
        options,
    };
    while batch.members.len() < UNDER_WAY
        && let Some(member) = next(&mut outcomes, None)
    {
        batch.members.push(member);
    }
    for i in 0..batch.members.len() {
        batch.wait(i);
    }
    while let Some(group) = batch.next() {
        batch.expand(&group);
        for i in group {
            let member = &mut batch.members[i];
            let outcome = member.step();
            if outcome.is_some() {
                outcomes[member.number] = outcome;
                // The next orbit reuses the last one's memory.
                let stepper = &mut member.integration.stepper;
                let stepper = std::mem::replace(stepper, Stepper::new(options));
                match next(&mut outcomes, Some(stepper)) {
                    Some(next) => *member = next,
                    None => continue,
                }
            }
            batch.wait(i);
        }
    }
    outcomes.into_iter().flatten().collect()
}

/// For every start, the first start with an equal system.
fn classes<S: PartialEq, const N: usize>(starts: &[Start<S, N>]) -> Vec<usize> {
    let mut firsts: Vec<usize> = Vec::new();
    let class = |(number, start): (usize, &Start<S, N>)| {
        let known = firsts
            .iter()
            .copied()
            .find(|&first| starts[first].system == start.system);
        known.unwrap_or_else(|| {
            firsts.push(number);
            number
        })
    };
    starts.iter().enumerate().map(class).collect()
}
