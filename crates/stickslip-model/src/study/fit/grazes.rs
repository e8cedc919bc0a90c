//! Grazing impacts between the start of a fit and its result.

use stickslip::dynamics::Vector;

use super::Modelled;
use super::problem::FitProblem;

/// Parts of the way that are looked at. Chosen: two changes in one of them may hide each other.
const PARTS: usize = 8;

/// Halvings of a part after which derivatives are compared, before and after.
const HALVINGS: [u32; 2] = [6, 22];

/// Growth of the derivatives from which a change is a graze. Between these halvings a square root
/// makes them 256 times as large; where the change is regular they stay.
const GROWTH: f64 = 16.0;

/// A part of the way, and the numbers of impacts and the size of the derivatives there, if its run
/// reaches the data.
type Looked = (f64, Option<(Vec<usize>, f64)>);

impl FitProblem<'_> {
    /// The number of grazing impacts found on the straight way between two points; `None` in
    /// parts, which have no single way.
    ///
    /// An impact begins or ends there with no speed, so that the residuals have a square root:
    /// their derivatives are unbounded on one side (Nordmark, *J. Sound Vib.* 145 (1991) 279). An
    /// impact that passes the end of the data leaves them bounded.
    pub(super) fn grazes(&self, from: &Vector, to: &Vector) -> Option<usize> {
        if self.parts.is_some() {
            return None;
        }
        let at = |part: f64| {
            let at = self.modelled(&(from + (to - from) * part)).ok()?;
            Some((impacts(&at), size(&at)))
        };
        let places = (0..=PARTS).map(|k| k as f64 / PARTS as f64);
        let places: Vec<Looked> = places.map(|part| (part, at(part))).collect();
        let is_graze = |pair: &&[Looked]| {
            let [(low, Some(before)), (high, Some(beyond))] = pair else {
                return false;
            };
            if before.0 == beyond.0 {
                return false;
            }
            let (mut low, mut high) = (*low, *high);
            let mut sizes = [before.1, beyond.1];
            let mut first = 0.0_f64;
            for halving in 0..HALVINGS[1] {
                if halving == HALVINGS[0] {
                    first = sizes[0].max(sizes[1]);
                }
                let middle = 0.5 * (low + high);
                match at(middle) {
                    Some((impacts, size)) if impacts == before.0 => {
                        (low, sizes[0]) = (middle, size);
                    }
                    Some((_, size)) => (high, sizes[1]) = (middle, size),
                    None => return false,
                }
            }
            sizes[0].max(sizes[1]) > GROWTH * first
        };
        Some(places.windows(2).filter(is_graze).count())
    }
}

/// Numbers of impacts and other jumps by record.
fn impacts(at: &Modelled) -> Vec<usize> {
    let of = at.phases.iter();
    let of = of.map(|phases| phases.iter().filter(|one| one.2.jump().is_some()).count());
    of.collect()
}

/// Size of the derivatives.
fn size(at: &Modelled) -> f64 {
    at.jacobian.norm()
}
