//! A batch of orbits by Taylor series. Orbits of one system that are in the same mode are expanded
//! together, one orbit in each lane.
//!
//! A coefficient is then a vector with one number for each orbit. The lengths and ends of the steps
//! are computed in lanes, too. Everything else is done for each orbit by itself. Each orbit is
//! bit-for-bit the same as when computed alone. Interpreted functions are called for one orbit
//! alone; their recorded operations are then repeated in all lanes.

use pulp::{Arch, NullaryFnOnce};

use super::flow::Flow;
use super::integration::Integration;
use super::options::Options;
use super::recordings::Recordings;
use super::stepper::Stepper;
use super::switched::{Switched, UseFlow};
use super::taylor::{Ends, step_ratio};
use crate::taylor::recorded_calls::LinearNumbers;
use crate::taylor::row::{CoefficientRow, Lanes};
use crate::taylor::series::{Expansion, Series};
use crate::taylor::sweep::{CoefficientRows, MIN_ROWS};

/// Number of orbits that are expanded together: one vector of the widest machines, two of others.
pub(super) const LANES: usize = 8;

/// Fewer orbits than this are expanded one by one, which was measured to take no longer.
const MIN_GROUP: usize = 3;

/// Number of orbits under way at once. Chosen: with so many, one mode nearly always has enough of
/// them to fill the lanes.
const ACTIVE_ORBITS: usize = 4 * LANES;

/// An orbit of a batch.
pub(crate) trait BatchMember<'a, S: Switched<N, G>, const N: usize, const G: usize> {
    /// The result of the orbit.
    type Outcome;

    /// Integration.
    fn integration(&mut self) -> &mut Integration<'a, S, N, G>;

    /// Whether the solution over the next step is needed, not only its end.
    fn watches_step(&mut self) -> bool;

    /// Takes the step that was prepared, if there is one, and continues until the next series is
    /// needed. Returns the outcome if the orbit ends before.
    fn go_on(&mut self) -> Option<Self::Outcome>;
}

/// An orbit under way.
struct ActiveOrbit<M> {
    /// Index of its start.
    number: usize,
    /// Class of its system.
    class: usize,
    member: M,
    /// Whether the solution over the next step is needed.
    watches_step: bool,
}

/// Key that orbits must share to be expanded together: the system's class and what decides the
/// flow.
type GroupKey<K, B> = (usize, K, B);

/// Orbits with the same key that wait for a series.
struct Queue<K, B> {
    key: GroupKey<K, B>,
    members: Vec<usize>,
}

/// Starts of the series of several orbits, each in its lane, and their order.
struct SeriesStarts<const N: usize> {
    t: Lanes<LANES>,
    x: [Lanes<LANES>; N],
    h: Lanes<LANES>,
    order: usize,
}

/// Result of expanding several orbits: the step lengths (relative to the scale of the series) and
/// the states at the steps' ends.
struct PlannedSteps<const N: usize, const G: usize> {
    expansion: Expansion<G>,
    ratios: Lanes<LANES>,
    ends: Ends<LANES, N, G>,
}

/// The lengths and ends of the steps of expanded orbits.
struct StepPlanner<'b, P, const N: usize> {
    begin: &'b SeriesStarts<N>,
    rows: &'b [CoefficientRow<LANES>],
    options: &'b Options,
    /// Chooses the steps by the radii of convergence of the series.
    choose: &'b mut P,
}

impl<P: FnMut(Lanes<LANES>) -> Lanes<LANES>, const N: usize> StepPlanner<'_, P, N> {
    #[inline(always)]
    fn of<const G: usize>(&mut self, expansion: Expansion<G>) -> PlannedSteps<N, G> {
        let SeriesStarts { t, x, h, order } = self.begin;
        let limits = step_ratio(self.rows, &expansion, *order, self.options, (*t, *h), x);
        let ratios = (self.choose)(limits);
        PlannedSteps {
            ends: Ends::of(self.rows, &expansion, *order, ratios),
            expansion,
            ratios,
        }
    }
}

/// Expands several orbits in one mode by the functions of its flow, in the widest vectors of the
/// machine. The width changes no bit. Without a result they are expanded one by one.
///
/// The first rows are an argument because it consists of two references: see [`CoefficientRows`].
struct ByFlow<'a, 'b, F, P, const N: usize, const G: usize> {
    first: &'a [CoefficientRow<LANES>; MIN_ROWS],
    plan: &'a mut StepPlanner<'b, P, N>,
    flow: &'a F,
}

impl<F, P, const N: usize, const G: usize> NullaryFnOnce for ByFlow<'_, '_, F, P, N, G>
where
    F: Flow<N>,
    P: FnMut(Lanes<LANES>) -> Lanes<LANES>,
{
    type Output = Result<Option<PlannedSteps<N, G>>, usize>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let (first, all) = (self.first, self.plan.rows);
        let SeriesStarts { t, x, h, order } = self.plan.begin;
        let into = CoefficientRows { first, all };
        let expansion = self.flow.expand(into, (*t, *h), x, *order)?;
        if expansion.lanes_differ || expansion.value_read || expansion.overflowed {
            return Ok(None);
        }
        Ok(Some(self.plan.of(expansion)))
    }
}

/// Plans the steps of orbits that were expanded by repetition.
struct ByRecording<'a, 'b, P, const N: usize, const G: usize> {
    plan: &'a mut StepPlanner<'b, P, N>,
    expansion: Expansion<G>,
}

impl<P, const N: usize, const G: usize> NullaryFnOnce for ByRecording<'_, '_, P, N, G>
where
    P: FnMut(Lanes<LANES>) -> Lanes<LANES>,
{
    type Output = PlannedSteps<N, G>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.plan.of(self.expansion)
    }
}

/// The orbits of a thread.
struct Batch<'o, S: Switched<N, G>, M, const N: usize, const G: usize> {
    members: Vec<ActiveOrbit<M>>,
    waiting: Vec<Queue<S::Mode, S::Branch>>,
    series: Series<LANES>,
    /// Recorded calls of interpreted functions, by class.
    recordings: Vec<Recordings<S::Mode, S::Branch, N, G>>,
    linear_numbers: LinearNumbers<LANES>,
    options: &'o Options,
}

impl<'a, S, M, const N: usize, const G: usize> Batch<'_, S, M, N, G>
where
    S: Switched<N, G> + 'a,
    M: BatchMember<'a, S, N, G>,
{
    /// Puts an orbit into the queue with its key.
    fn enqueue(&mut self, i: usize) {
        let ActiveOrbit { class, member, .. } = &mut self.members[i];
        let integration = member.integration();
        let key = (*class, integration.mode, integration.branch);
        match self.waiting.iter_mut().find(|queue| queue.key == key) {
            Some(queue) => queue.members.push(i),
            None => self.waiting.push(Queue {
                key,
                members: vec![i],
            }),
        }
    }

    /// Takes the orbits that are expanded next: those with the most frequent key.
    fn next(&mut self) -> Option<Queue<S::Mode, S::Branch>> {
        let waiting = self.waiting.iter_mut().enumerate();
        let (i, queue) = waiting.max_by_key(|(_, queue)| queue.members.len())?;
        let left = queue.members.len().saturating_sub(LANES);
        let (key, members) = (queue.key, queue.members.split_off(left));
        if left == 0 {
            self.waiting.swap_remove(i);
        }
        Some(Queue { key, members })
    }

    /// Expands the orbits' series in lanes. Where that is impossible or does not pay, each step
    /// expands its own.
    fn expand(&mut self, key: GroupKey<S::Mode, S::Branch>, group: &[usize]) {
        for &i in group {
            let orbit = &mut self.members[i];
            orbit.watches_step = orbit.member.watches_step();
        }
        if group.len() < MIN_GROUP {
            return;
        }
        let Some(begin) = self.begin(group) else {
            return;
        };
        let planned = if const { S::INTERPRETED } {
            self.repeat(&begin, key, group)
        } else {
            let (_, mode, branch) = key;
            let system = self.members[group[0]].member.integration().system;
            let by_flow = GroupByFlow {
                begin: &begin,
                batch: self,
                group,
            };
            system.with_flow(mode, branch, by_flow)
        };
        if let Some(planned) = planned {
            self.distribute(&planned, group);
        }
    }

    /// Starts of the orbits' series; `None` where components that do not move differ.
    fn begin(&mut self, group: &[usize]) -> Option<SeriesStarts<N>> {
        let mut begin = SeriesStarts {
            t: [0.0; LANES],
            x: [[0.0; LANES]; N],
            h: [0.0; LANES],
            order: 0,
        };
        for lane in 0..LANES {
            // Lanes without an orbit repeat the first one's work.
            let i = *group.get(lane).unwrap_or(&group[0]);
            let Integration { stepper, run, .. } = self.members[i].member.integration();
            (begin.order, begin.h[lane]) = stepper.series_mut()?.order_and_scale();
            begin.t[lane] = run.at.t;
            for (x, at) in begin.x.iter_mut().zip(&run.at.x) {
                x[lane] = *at;
            }
        }
        let dimension = self.members[group[0]]
            .member
            .integration()
            .system
            .dimension();
        let is_one = |lanes: &Lanes<LANES>| lanes.iter().all(|x| *x == lanes[0]);
        begin.x[dimension..].iter().all(is_one).then_some(begin)
    }

    /// Expands the orbits by a recorded call. `None` if no call serves all of them.
    fn repeat(
        &mut self,
        begin: &SeriesStarts<N>,
        (class, mode, branch): GroupKey<S::Mode, S::Branch>,
        group: &[usize],
    ) -> Option<PlannedSteps<N, G>> {
        let repeated = self.recordings.get(class)?.get(&(mode, branch))?;
        let SeriesStarts { t, x, h, order } = begin;
        let linear_numbers = &mut self.linear_numbers;
        let expansion = self
            .series
            .expand_by(|rows| repeated.expand_again(rows, (*t, *h), x, *order, linear_numbers))?;
        let members = &mut self.members;
        let plan = &mut StepPlanner {
            begin,
            rows: self.series.rows(),
            options: self.options,
            choose: &mut |limits| choose(members, group, limits),
        };
        Some(Arch::new().dispatch(ByRecording { plan, expansion }))
    }

    /// Passes to each orbit what its step needs of the expansion.
    fn distribute(&mut self, planned: &PlannedSteps<N, G>, group: &[usize]) {
        for (lane, &i) in group.iter().enumerate() {
            let orbit = &mut self.members[i];
            let Integration { stepper, run, .. } = orbit.member.integration();
            let is_bare = !orbit.watches_step && run.orders == [0; G];
            let end = is_bare.then(|| planned.ends.clear(lane)).flatten();
            if let Some(stepper) = stepper.series_mut() {
                stepper.expanded(&planned.expansion);
                stepper.take(run, &self.series, (lane, planned.ratios[lane]), end);
            }
        }
    }

    /// Continues an orbit to its next series, with the recorded calls of its class.
    fn go_on(&mut self, i: usize) -> Option<M::Outcome> {
        let ActiveOrbit { class, member, .. } = &mut self.members[i];
        if !const { S::INTERPRETED } {
            return member.go_on();
        }
        if self.recordings.len() <= *class {
            self.recordings.resize_with(*class + 1, Recordings::default);
        }
        let shared = &mut self.recordings[*class];
        std::mem::swap(&mut member.integration().recordings, shared);
        let outcome = member.go_on();
        std::mem::swap(&mut member.integration().recordings, shared);
        outcome
    }
}

/// Chooses the orbits' next steps within the limits that their series give.
fn choose<'a, S, M, const N: usize, const G: usize>(
    members: &mut [ActiveOrbit<M>],
    group: &[usize],
    mut ratios: Lanes<LANES>,
) -> Lanes<LANES>
where
    S: Switched<N, G> + 'a,
    M: BatchMember<'a, S, N, G>,
{
    for (ratio, &i) in ratios.iter_mut().zip(group) {
        let Integration { stepper, run, .. } = members[i].member.integration();
        if let Some(stepper) = stepper.series_mut() {
            *ratio = stepper.plan(run, *ratio);
        }
    }
    ratios
}

/// Orbits with the same key, expanded by the functions of its flow.
struct GroupByFlow<'b, 'o, S: Switched<N, G>, M, const N: usize, const G: usize> {
    begin: &'b SeriesStarts<N>,
    batch: &'b mut Batch<'o, S, M, N, G>,
    group: &'b [usize],
}

impl<'a, S, M, const N: usize, const G: usize> UseFlow<N> for GroupByFlow<'_, '_, S, M, N, G>
where
    S: Switched<N, G> + 'a,
    M: BatchMember<'a, S, N, G>,
{
    type Output = Option<PlannedSteps<N, G>>;

    #[inline(always)]
    fn with<F: Flow<N>>(self, flow: &F) -> Self::Output {
        let (begin, options) = (self.begin, self.batch.options);
        let members = &mut self.batch.members;
        let mut choose = |limits| choose(members, self.group, limits);
        self.batch.series.expand_by(|rows| {
            let plan = &mut StepPlanner {
                begin,
                rows: rows.all,
                options,
                choose: &mut choose,
            };
            let first = rows.first;
            Arch::new().dispatch(ByFlow { first, plan, flow })
        })
    }
}

/// Follows the orbit of each start to its outcome, with the bits that it has alone by
/// [`crate::Method::Taylor`]. Each start comes with the class of its system: orbits of one class
/// have equal systems. Outcomes are in the order of the starts.
pub(crate) fn side_by_side<'a, S, M, T, const N: usize, const G: usize>(
    starts: impl ExactSizeIterator<Item = (usize, T)>,
    mut begin: impl FnMut(T, Stepper<N, G>) -> Result<M, M::Outcome>,
    options: &Options,
) -> Vec<M::Outcome>
where
    S: Switched<N, G> + 'a,
    M: BatchMember<'a, S, N, G>,
{
    let mut outcomes: Vec<_> = (0..starts.len()).map(|_| None).collect();
    let mut starts = starts.enumerate();
    // The next orbit that needs its first series. One that ends before has its outcome already.
    let mut next = |outcomes: &mut [Option<_>], mut room: Option<Stepper<N, G>>| {
        starts.find_map(|(number, (class, start))| {
            let stepper = room.take().unwrap_or_else(|| Stepper::new(options));
            let begun = begin(start, stepper).and_then(|mut member| match member.go_on() {
                None => Ok(member),
                Some(outcome) => Err(outcome),
            });
            match begun {
                Ok(member) => Some(ActiveOrbit {
                    number,
                    class,
                    member,
                    watches_step: true,
                }),
                Err(outcome) => {
                    outcomes[number] = Some(outcome);
                    None
                }
            }
        })
    };
    let mut batch = Batch {
        members: Vec::with_capacity(ACTIVE_ORBITS),
        waiting: Vec::new(),
        series: Series::default(),
        recordings: Vec::new(),
        linear_numbers: LinearNumbers::new(),
        options,
    };
    while batch.members.len() < ACTIVE_ORBITS
        && let Some(orbit) = next(&mut outcomes, None)
    {
        batch.members.push(orbit);
    }
    for i in 0..batch.members.len() {
        batch.enqueue(i);
    }
    while let Some(Queue { key, members }) = batch.next() {
        batch.expand(key, &members);
        for i in members {
            let outcome = batch.go_on(i);
            if outcome.is_some() {
                let ActiveOrbit { number, member, .. } = &mut batch.members[i];
                outcomes[*number] = outcome;
                // The next orbit reuses the last one's memory.
                let stepper = &mut member.integration().stepper;
                let mut stepper = std::mem::replace(stepper, Stepper::new(options));
                stepper.forget();
                match next(&mut outcomes, Some(stepper)) {
                    Some(next) => batch.members[i] = next,
                    None => continue,
                }
            }
            batch.enqueue(i);
        }
    }
    outcomes.into_iter().flatten().collect()
}
