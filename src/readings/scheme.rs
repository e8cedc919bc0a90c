//! An orbit of the in-place scheme, and how fast a neighbour of it leaves.
//!
//! The scheme has no tangent flow: it is a map with jumps, and its clock loses a little at every Hénon step. So the growth is
//! measured with two runs of the same scheme (Benettin, Galgani & Strelcyn, *Phys. Rev. A* 14 (1976) 2338), compared where both
//! return to the section. The difference of their clocks and of their phases within a pass does not count there; what is
//! measured is the first exponent of the return map.
//!
//! That is done at two distances, since the scheme meets Σ by whole passes and what it does there depends on what is left of the
//! pass: neighbours can part up to a distance of about `h` and no further, which is no chaos that anybody would see.
//! Where near and far neighbours give different classes the motion is undecided.

use super::plan::{DT, Plan};
use super::trajectory::{BOUND, Outcome, Trajectory};
use crate::paper::in_place::{InPlace, Lost};
use stickslip::analysis::motion::{Class, Criterion, Evidence, Of};
use stickslip::analysis::{Exponent, Growth, SpectrumOptions};
use stickslip::math;
use stickslip::models::BlockAndBracket;
use stickslip::system::State;

type Scheme<'a> = InPlace<&'a BlockAndBracket, 4>;

/// Distance at which the near neighbour starts after every return: far above rounding, far below what a pass covers.
pub const NEAR: f64 = 1e-8;
/// And the far neighbour, in steps `h`: beyond the scatter that comes from where in a pass Σ is met.
pub const FAR: f64 = 4.0;
/// Points of the section nearer than this, as a fraction of its extent, count as one: the passes do not hit it, and a
/// motion that closes is met at another phase of the pass every time.
pub const SAME: f64 = 1e-3;
/// A neighbour that needs so many times as many passes to return has lost its orbit.
const OVERDUE: usize = 8;

/// A return to `x₂ = 0` from above between two states.
fn crossing(before: &State<4>, after: &State<4>) -> Option<State<4>> {
    let falls = before[1] > 0.0 && after[1] <= 0.0;
    falls.then(|| before + (after - before) * (before[1] / (before[1] - after[1])))
}

/// The neighbouring run and what has been found with it.
struct Neighbour<'a> {
    /// Distance at which it starts.
    apart: f64,
    /// As it was started at the last return; `None` once it is lost or cannot be told from the orbit.
    scheme: Option<Scheme<'a>>,
    /// Once measuring has begun, with the time it has come to.
    growth: Option<(Growth<1>, f64)>,
}

impl<'a> Neighbour<'a> {
    fn start(base: &Scheme<'a>, apart: f64) -> Self {
        // It differs in all that can differ on the section.
        let all = State::from([1.0, 0.0, 1.0, 1.0]);
        Neighbour {
            apart,
            scheme: Some(base.displaced(&(all * (apart / all.norm())))),
            growth: None,
        }
    }

    fn begin_measuring(&mut self, t: f64, duration: f64) {
        let settings = SpectrumOptions::over(0.0, duration);
        self.growth = Some((Growth::new(t, &settings), t));
    }

    /// Goes on until the neighbour returns, and starts it again from `base`, in the direction it has been found in.
    fn follow(&mut self, base: &Scheme<'a>, at: &State<4>, passes: usize) {
        let Some(mut scheme) = self.scheme.take() else {
            return;
        };
        for _ in 0..passes * OVERDUE {
            let before = *scheme.x();
            if scheme.advance().is_err() {
                return;
            }
            let Some(there) = crossing(&before, scheme.x()) else {
                continue;
            };
            let apart = there - at;
            let distance = apart.norm();
            if let Some((growth, measured_to)) = &mut self.growth {
                growth.logs[0] += math::ln(distance / self.apart);
                growth.tick(base.t());
                *measured_to = base.t();
            }
            if distance > 0.0 {
                self.scheme = Some(base.displaced(&(apart * (self.apart / distance))));
            }
            return;
        }
    }

    /// The first exponent of the return map, per unit of the scheme's clock, and the time it was measured for; none if the
    /// neighbour was lost.
    fn exponent(self) -> Option<(Exponent, f64)> {
        let (growth, measured_to) = self.growth?;
        let together = growth.logs[0] == f64::NEG_INFINITY;
        if self.scheme.is_none() && !together {
            return None;
        }
        let (duration, [exponent], _) = growth.finish(measured_to);
        Some((exponent, duration))
    }
}

/// Follows the scheme. Every so many passes are a point, as the listing counts its records.
pub fn follow(system: &BlockAndBracket, start: State<4>, h: f64, plan: &Plan) -> Outcome {
    let passes = |t: f64| (t / h).round() as usize;
    let (first, every) = (passes(plan.from), passes(DT).max(1));
    let last = first + (plan.points - 1) * every;
    let mut scheme = InPlace::start(system, start, h, BOUND);
    let mut kept = Trajectory::default();
    let mut neighbours: Vec<Neighbour> = Vec::new();
    let mut returned = 0;
    for pass in 0..=last {
        if pass >= first && (pass - first).is_multiple_of(every) {
            kept.series.push((*scheme.x()).into());
        }
        let before = *scheme.x();
        match scheme.advance() {
            Ok(()) => {}
            Err(Lost::Escaped { .. }) => return Outcome::Escaped,
            Err(Lost::BrokenDown { .. }) => return Outcome::Failed,
        }
        let Some(at) = crossing(&before, scheme.x()) else {
            continue;
        };
        if pass >= first {
            kept.section.push((scheme.t(), at.into()));
        }
        for one in &mut neighbours {
            one.follow(&scheme, &at, pass + 1 - returned);
        }
        // From half of the transient on, so that they have turned into the direction that parts fastest.
        if neighbours.is_empty() && pass >= first / 2 {
            neighbours = [NEAR, FAR * h]
                .map(|apart| Neighbour::start(&scheme, apart))
                .into();
        }
        if pass >= first {
            for one in neighbours.iter_mut().filter(|one| one.growth.is_none()) {
                one.begin_measuring(scheme.t(), plan.duration());
            }
        }
        returned = pass + 1;
    }
    let mut classes = neighbours.into_iter().map(|one| class(&kept, one));
    let class = match (classes.next(), classes.next()) {
        (Some(near), Some(far)) if near == far => near,
        _ => Class::Undecided,
    };
    Outcome::Bounded(kept.series, class)
}

/// The class by one neighbour.
fn class(kept: &Trajectory, neighbour: Neighbour) -> Class {
    let criterion = Criterion {
        same: SAME,
        ..Criterion::default()
    };
    let found = neighbour.exponent();
    let (exponents, duration) =
        found.map_or((vec![], 1.0), |(one, duration)| (vec![one], duration));
    let spectrum = (Of::ReturnMap, &exponents[..], duration);
    Evidence::gather(&kept.section, spectrum, &criterion).class()
}
