//! Where a branch ends.

use super::Stop;
use super::corrector::OnBranch;
use super::rest::hopf;
use super::walk::{Walk, at_parameter};
use crate::filippov::Switched;
use crate::ode::Timed;

/// An orbit of less than this part of the widest one's extent is about to be an equilibrium.
const SMALL: f64 = 0.04;

impl<S: Switched<N, G>, const N: usize, const G: usize> Walk<'_, S, N, G> {
    /// Whether the next orbit lies outside the range; the last one is then that at its end.
    pub(super) fn leaves_range(&mut self, next: &OnBranch<N, S::Mode>) -> Option<Stop> {
        let (low, high) = self.settings.range;
        let (here, there) = (self.parameter(), next.circuit.anchor.x[N - 1]);
        if (low..=high).contains(&there) {
            return None;
        }
        let end = there.clamp(low, high);
        let part = ((end - here) / (there - here)).clamp(0.0, 1.0);
        let (a, b) = (&self.last.circuit, &next.circuit);
        let at = Timed {
            t: b.anchor.t,
            x: a.anchor.x + (b.anchor.x - a.anchor.x) * part,
        };
        let found = self
            .corrector
            .orbit(&at_parameter(at, b.period, end), 0.0)
            .filter(|found| found.circuit.sequence() == a.sequence());
        if let Some(found) = found
            && part > 0.0
        {
            self.take(found);
        }
        Some(Stop::Range)
    }

    /// Whether the orbit is about to be an equilibrium.
    pub(super) fn shrinks(&self) -> Option<Stop> {
        let extent = self.last.circuit.extent;
        if extent >= SMALL * self.widest || extent >= self.before.circuit.extent {
            return None;
        }
        let (parameter, frequency) = hopf(self.corrector.system, &self.last, self.width)?;
        Some(Stop::Equilibrium {
            parameter,
            frequency,
        })
    }
}
