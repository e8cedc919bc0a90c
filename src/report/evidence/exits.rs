//! `fig08.exit_at_visible`: at which of the numbered tangent points stick phases end.

use super::stick_phases::{self, Followed, Stick};
use super::{Evidence, Part, TangentSet, small};
use crate::paper::listing::{End, Zone};
use crate::paper::published::PublishedError;
use stickslip::models::ForcedOscillator;

/// A release is at a tangent point when it is no further from it (m): the solver's tolerance, with room for the time to grow.
const AT: f64 = 1e-9;

/// Ends of stick phases in the stated model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfModel {
    /// How many end at point 1, 2, …, 6 of Eq. (24), moved by the support.
    pub by_number: [usize; 6],
    /// How many end at none of them.
    pub elsewhere: usize,
    /// Largest distance from the nearest of them (m).
    pub largest_distance: f64,
    /// How many end where the field that takes over is visibly tangent when time counts in the
    /// derivative.
    pub visible_in_time: usize,
}

/// Ends of stick phases in the listing: it names the zone and the end that it has tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OfListing {
    /// How many end at point 1, 2, …, 6.
    pub by_number: [usize; 6],
    /// How many in no zone.
    pub without_zone: usize,
    /// Stick phases of no more than ten steps, left out.
    pub chatter: usize,
}

/// Ends of all stick phases from one grid of starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exits {
    /// The stated model.
    pub model: OfModel,
    /// The listing as printed, which tests upper ends only.
    pub listing: OfListing,
    /// The listing with that alone mended.
    pub both_ends_tested: OfListing,
}

impl OfModel {
    /// Ends of stick phases in all.
    pub fn all(&self) -> usize {
        self.by_number.iter().sum::<usize>() + self.elsewhere
    }

    /// Those at points 1, 3 and 5, which the caption of Fig. 4 calls visible.
    pub fn at_visible(&self) -> usize {
        at_odd(&self.by_number)
    }

    /// Those at points 2, 4 and 6, which it calls invisible.
    pub fn at_invisible(&self) -> usize {
        self.by_number.iter().sum::<usize>() - self.at_visible()
    }

    fn of(model: &ForcedOscillator, set: &TangentSet, sticks: &[Stick]) -> OfModel {
        let mut found = OfModel {
            by_number: [0; 6],
            elsewhere: 0,
            largest_distance: 0.0,
            visible_in_time: sticks.iter().filter(|stick| stick.visible).count(),
        };
        for stick in sticks {
            let (number, distance) = set.nearest(model, stick.exit.0, stick.exit.1);
            found.largest_distance = found.largest_distance.max(distance);
            if distance <= AT {
                found.by_number[number - 1] += 1;
            } else {
                found.elsewhere += 1;
            }
        }
        found
    }
}

impl OfListing {
    /// Ends of stick phases in all.
    pub fn all(&self) -> usize {
        self.by_number.iter().sum::<usize>() + self.without_zone
    }

    /// Those at points 1, 3 and 5.
    pub fn at_visible(&self) -> usize {
        at_odd(&self.by_number)
    }

    fn of(followed: &stick_phases::OfListing) -> OfListing {
        let mut found = OfListing {
            by_number: [0; 6],
            without_zone: 0,
            chatter: followed.chatter,
        };
        for phase in &followed.phases {
            let upper = match phase.zone {
                Some(Zone::Upper) => 0,
                Some(Zone::Middle) => 2,
                Some(Zone::Lower) => 4,
                None => {
                    found.without_zone += 1;
                    continue;
                }
            };
            found.by_number[upper + usize::from(phase.end == End::Lower)] += 1;
        }
        found
    }
}

/// Of counts by number those of the odd numbers.
fn at_odd(by_number: &[usize; 6]) -> usize {
    by_number.iter().step_by(2).sum()
}

impl Exits {
    /// The statement, as the listing could only bear it out: it tests the points 1, 3 and 5 and no others.
    pub fn of_listing(&self) -> Part {
        let listing = &self.listing;
        Part {
            what: "every loss of stick of the listing in a zone is at point 1, 3 or 5",
            holds: listing.at_visible() > 0
                && listing.at_visible() + listing.without_zone == listing.all(),
        }
    }

    /// Counts the ends of the stick phases followed.
    ///
    /// # Errors
    /// [`PublishedError`] if the table of claims lacks Eq. (24).
    pub fn compute(followed: &Followed) -> Result<Exits, PublishedError> {
        Ok(Exits {
            model: OfModel::of(
                &ForcedOscillator::default(),
                &TangentSet::published()?,
                &followed.model,
            ),
            listing: OfListing::of(&followed.listing),
            both_ends_tested: OfListing::of(&followed.both_ends_tested),
        })
    }
}

impl Evidence for Exits {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "every loss of stick is at a tangent point of Eq. (24) moved by the support",
                holds: self.model.all() > 0 && self.model.elsewhere == 0,
            },
            Part {
                what: "and it is visible there, the movement of the point counted",
                holds: self.model.all() > 0 && self.model.visible_in_time == self.model.all(),
            },
        ]
    }

    fn line(&self) -> String {
        let model = &self.model;
        let listing = &self.listing;
        let mended = &self.both_ends_tested;
        format!(
            "stated model: {} of {} ends of stick phases are visibly tangent, all within {} m of a point; in another reading, by the points that \
             Fig. 4's caption calls visible at rest, {} are at 1, 3, 5 and {} at 2, 4, 6 (by number {:?}); the listing tests upper ends only, so that {} of \
             its {} are at 1, 3, 5 whatever the motion; with both ends tested {} of {} ({} and {} of no more than ten steps left out)",
            model.visible_in_time,
            model.all(),
            small(model.largest_distance),
            model.at_visible(),
            model.at_invisible(),
            model.by_number,
            listing.at_visible(),
            listing.all(),
            mended.at_visible(),
            mended.all(),
            listing.chatter,
            mended.chatter,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn a_third_of_the_releases_is_at_points_called_invisible() {
        let exits = Exits::compute(&Followed::compute().unwrap()).unwrap();
        assert_eq!((exits.model.all(), exits.model.at_invisible()), (72, 24));
        assert_eq!(exits.model.visible_in_time, exits.model.all());
        assert_eq!(exits.support(), Support::Whole);
        // By construction, until the other end is tested too.
        assert_eq!(exits.listing.at_visible(), exits.listing.all());
        assert!(exits.both_ends_tested.at_visible() < exits.both_ends_tested.all());
    }

    #[test]
    fn a_displaced_point_is_no_place_of_release() {
        let model = ForcedOscillator::default();
        let sticks = stick_phases::of_model(&model).unwrap();
        let mut set = TangentSet::published().unwrap();
        set.0[0] += 1e-6;
        let moved = OfModel::of(&model, &set, &sticks);
        assert!(moved.elsewhere > 0 && moved.by_number[0] == 0);
    }

    #[test]
    fn without_forcing_only_upper_ends_release() {
        // A body that the belt carries up reaches upper ends only, if these stand still.
        let still = ForcedOscillator {
            amplitude: 0.0,
            ..ForcedOscillator::default()
        };
        let sticks = stick_phases::of_model(&still).unwrap();
        let found = OfModel::of(&still, &TangentSet::published().unwrap(), &sticks);
        assert!(found.all() > 0);
        assert_eq!(found.at_visible(), found.all());
    }
}
