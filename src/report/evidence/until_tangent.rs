//! `s4.until_tangent`: whether a body in stick moves at the belt's speed until the next tangent point is met.

use super::stick_phases::Followed;
use super::{Evidence, EvidenceError, Part, TangentSet, small};
use crate::paper::listing::{Setup, StickPhase, run};
use crate::paper::slip_times_three::{Injected, settled};
use stickslip::models::ForcedOscillator;

/// Moments in a forcing period at which it is seen which tangent points have been passed.
const MOMENTS: f64 = 2000.0;
/// Distances and times within this are none (m, s, m/s): the solver's tolerance, with room for it to grow.
const NONE: f64 = 1e-9;

/// Stick phases against the tangent points that move past them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Meetings {
    /// Stick phases looked at.
    pub phases: usize,
    /// Those in which a tangent point is met and passed before the release.
    pub passing: usize,
    /// Largest distance of a release from the nearest moved tangent point (m).
    pub largest_distance: f64,
    /// Part of the time in stick in which the body lies in no zone between tangent points.
    pub outside_zones: f64,
}

/// What stick phases do until they end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UntilTangent {
    /// The stated model.
    pub model: Meetings,
    /// Largest difference of its body's velocity from the belt's in stick (m/s).
    pub largest_speed_error: f64,
    /// Stick phases of its settled motion from the start of Fig. 8.
    pub sticks_of_fig08: usize,
    /// Fig. 8's motion: the settled one of the listing as printed.
    pub fig08: Meetings,
    /// The listing as printed, from the same starts as the model.
    pub listing: Meetings,
}

impl UntilTangent {
    /// Whether each stick phase of the stated model, of whatever motion, ends at the next tangent
    /// point.
    pub fn holds_in_the_model(&self) -> bool {
        self.model.phases > 0
            && self.largest_speed_error <= NONE
            && self.model.passing == 0
            && self.model.largest_distance <= NONE
    }

    /// Looks at the stick phases followed.
    ///
    /// # Errors
    /// [`EvidenceError`] if the listing cannot run or the table of claims lacks Eq. (24).
    pub fn compute(followed: &Followed) -> Result<UntilTangent, EvidenceError> {
        let (model, set) = (ForcedOscillator::default(), TangentSet::published()?);
        let sticks = &followed.model;
        Ok(UntilTangent {
            model: meetings(&model, &set, sticks.iter().map(|one| (one.entry, one.exit))),
            largest_speed_error: sticks.iter().map(|one| one.speed_error).fold(0.0, f64::max),
            sticks_of_fig08: settled(Injected::NONE)?.sticks_of_one().count(),
            fig08: meetings(&model, &set, ends(run(&Setup::default())?.settled_phases())),
            listing: meetings(&model, &set, ends(&followed.listing.phases)),
        })
    }
}

/// Begins and ends of the listing's stick phases.
fn ends(phases: &[StickPhase]) -> impl Iterator<Item = ((f64, f64), (f64, f64))> {
    let ends = |one: &StickPhase| ((one.entry.t, one.entry.x1), (one.exit.t, one.exit.x1));
    phases.iter().map(ends)
}

/// `phases` as time and position at begin and end; in between the body is taken to move evenly.
fn meetings(
    model: &ForcedOscillator,
    set: &TangentSet,
    phases: impl Iterator<Item = ((f64, f64), (f64, f64))>,
) -> Meetings {
    let mut found = Meetings::default();
    let (mut time, mut outside) = (0.0, 0.0);
    for (entry, exit) in phases {
        found.phases += 1;
        let distance = set.nearest(model, exit.0, exit.1).1;
        found.largest_distance = found.largest_distance.max(distance);
        let duration = exit.0 - entry.0;
        let places = (duration / model.period() * MOMENTS).ceil().max(2.0);
        let (mut first, mut passes, mut places_outside) = (None, false, 0.0);
        for k in 0..places as u32 {
            // Amid each part, so that neither begin nor end, which lie on tangent points, is looked at.
            let part = (f64::from(k) + 0.5) / places;
            let t = entry.0 + part * duration;
            let x1 = entry.1 + part * (exit.1 - entry.1);
            let sides = set.gaps(model, t, x1).map(|gap| gap > 0.0);
            passes |= *first.get_or_insert(sides) != sides;
            places_outside += f64::from(u8::from(!TangentSet::in_zone(sides)));
        }
        found.passing += usize::from(passes);
        time += duration;
        outside += duration * places_outside / places;
    }
    found.outside_zones = if time > 0.0 { outside / time } else { 0.0 };
    found
}

impl Evidence for UntilTangent {
    fn parts(&self) -> Vec<Part> {
        vec![Part {
            what: "the body of Fig. 8 in the stated model sticks and moves at the belt's speed until the next tangent point is met",
            holds: self.sticks_of_fig08 > 0 && self.holds_in_the_model(),
        }]
    }

    fn as_printed(&self) -> Vec<Part> {
        vec![Part {
            what: "the body of Fig. 8's motion, which the program makes, does so",
            holds: self.fig08.phases > 0 && self.fig08.passing == 0,
        }]
    }

    fn line(&self) -> String {
        let (model, fig08, listing) = (&self.model, &self.fig08, &self.listing);
        let percent = |of: &Meetings| 100.0 * of.outside_zones;
        format!(
            "judged by Fig. 8's motion, of which the sentence speaks; from its start the stated model settles on {} stick phases; of those of the \
             listing {} of {} pass a tangent point, and the body is in no zone for {:.0} % of the time in stick (on its first ten forcing periods from \
             {} starts, phases of ten steps and less left out: {} of {}, and {:.0} %). In another reading, of any stick phase of the stated model, it {}: \
             {} phases, velocity off the belt's by at most {} m/s, {} of them pass a tangent point before they end, and the end is within {} m of one",
            self.sticks_of_fig08,
            fig08.passing,
            fig08.phases,
            percent(fig08),
            super::grid::starts().len(),
            listing.passing,
            listing.phases,
            percent(listing),
            if self.holds_in_the_model() {
                "holds"
            } else {
                "fails"
            },
            model.phases,
            small(self.largest_speed_error),
            model.passing,
            small(model.largest_distance),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn the_stated_model_stops_at_the_next_tangent_point_and_the_listing_does_not() {
        let followed = Followed::compute().unwrap();
        let found = UntilTangent::compute(&followed).unwrap();
        assert_eq!(found.support(), Support::Nothing);
        assert!(found.holds_in_the_model() && found.sticks_of_fig08 == 0);
        assert!(!found.as_printed()[0].holds && found.fig08.passing > 0);
        let sticking = UntilTangent {
            sticks_of_fig08: 1,
            ..found
        };
        assert_eq!(sticking.support(), Support::Whole);
        assert!(found.listing.passing > 0 && found.listing.outside_zones > 0.1);
        // With both ends tested it comes nearer to that.
        let (model, set) = (
            ForcedOscillator::default(),
            TangentSet::published().unwrap(),
        );
        let mended = meetings(&model, &set, ends(&followed.both_ends_tested.phases));
        assert!(
            mended.outside_zones < 0.1 * found.listing.outside_zones,
            "{mended:?}"
        );
        // A displaced point is not met.
        let displaced = TangentSet(set.0.map(|z| z + 1e-6));
        let sticks = followed.model.iter().map(|one| (one.entry, one.exit));
        assert!(meetings(&model, &displaced, sticks).largest_distance > NONE);
    }
}
