//! Recorded calls of a system's interpreted functions, flow by flow.

use crate::taylor::repeated::Repeated;

/// Maximum number of flows that are kept, more than most orbits visit.
const MOST_FLOWS: usize = 64;

/// The recorded calls of each flow, by mode and branch. A flow depends on nothing else, so that its
/// recordings serve every later phase, and every other orbit.
#[derive(Debug)]
pub(crate) struct Recordings<K, B, const N: usize, const G: usize> {
    flows: Vec<((K, B), Repeated<N, G>)>,
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
    fn place(&self, flow: &(K, B)) -> Option<usize> {
        self.flows.iter().position(|(known, _)| known == flow)
    }

    /// The recorded calls of a flow, if there are any.
    pub(super) fn known(&self, flow: &(K, B)) -> Option<&Repeated<N, G>> {
        self.place(flow).map(|place| &self.flows[place].1)
    }

    /// The recorded calls of a flow, to be added to.
    pub(super) fn of(&mut self, flow: (K, B)) -> &mut Repeated<N, G> {
        let place = self.place(&flow).unwrap_or_else(|| {
            let new = (flow, Repeated::default());
            if self.flows.len() < MOST_FLOWS {
                self.flows.push(new);
                return self.flows.len() - 1;
            }
            let place = self.oldest;
            self.oldest = (place + 1) % MOST_FLOWS;
            self.flows[place] = new;
            place
        });
        &mut self.flows[place].1
    }
}
