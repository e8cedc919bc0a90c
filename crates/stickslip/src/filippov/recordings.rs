//! Recorded calls of a system's interpreted functions, flow by flow.

use crate::taylor::recorded_calls::RecordedCalls;

/// Largest number of flows that are kept. Chosen: more than most orbits visit; it bounds the
/// memory.
const MAX_FLOWS: usize = 64;

/// The recorded calls of each flow, by mode and branch. A flow depends on nothing else, so that its
/// recordings serve every later phase, and every other orbit.
#[derive(Debug)]
pub(crate) struct Recordings<K, B, const N: usize, const G: usize> {
    flows: Vec<((K, B), RecordedCalls<N, G>)>,
    /// Index of the flow that is replaced next.
    oldest: usize,
}

impl<K, B, const N: usize, const G: usize> Default for Recordings<K, B, N, G> {
    fn default() -> Self {
        Recordings {
            flows: Vec::new(),
            oldest: 0,
        }
    }
}

impl<K: PartialEq, B: PartialEq, const N: usize, const G: usize> Recordings<K, B, N, G> {
    fn index(&self, flow: &(K, B)) -> Option<usize> {
        self.flows.iter().position(|(known, _)| known == flow)
    }

    /// The recorded calls of a flow, if there are any.
    pub(super) fn get(&self, flow: &(K, B)) -> Option<&RecordedCalls<N, G>> {
        self.index(flow).map(|index| &self.flows[index].1)
    }

    /// The recorded calls of a flow, to be added to.
    pub(super) fn get_or_insert(&mut self, flow: (K, B)) -> &mut RecordedCalls<N, G> {
        let index = self.index(&flow).unwrap_or_else(|| {
            let new = (flow, RecordedCalls::default());
            if self.flows.len() < MAX_FLOWS {
                self.flows.push(new);
                return self.flows.len() - 1;
            }
            let index = self.oldest;
            self.oldest = (index + 1) % MAX_FLOWS;
            self.flows[index] = new;
            index
        });
        &mut self.flows[index].1
    }
}
