//! The paper's statements on stick phases, tested on a grid of starts against the set (24) of
//! tangent points.

use super::procedure::LowerEnds;
use super::stick_phases::{GridPhases, ModelPhase, SAMPLES_PER_PERIOD, TangentSet, starts};
use crate::figures::rows::Value;
use crate::numbers::{ROUNDING, largest};
use crate::paper::listing::{Instant, Stick, StickPhase, ZoneEnd};
use crate::paper::models::ForcedOscillator;
use crate::paper::published::HALF_DIGIT;
use crate::paper::reading::Reading::Exact;
use crate::report::digits::small;
use crate::report::errata::Proof;
use crate::report::finding::{Finding, as_printed, statement};

/// Forcing periods within which a body on the belt always meets a tangent point.
const PERIODS_TO_MEETING: f64 = 3.0;

/// `s4.exact_lengths`: whether the set gives lengths and durations of the stick phases from the
/// entry alone. Each exit is the root of `x1 + vp (t − t_entry) = z_k + A sin(ωt)`.
pub(super) fn exact_lengths(grid: &GridPhases) -> Vec<Finding> {
    let off = |stick: Stick| off_prediction(&grid.set, stick);
    let sticks = &grid.model;
    let error = largest(sticks.iter().map(|one| off(one.stick)));
    let settled = grid.of_fig08().len();
    let listing_error = largest(grid.of_fig08().map(off));
    let what = "given where and when it begins, the set gives length and duration of a stick phase \
        of the stated model";
    let parts = [(what, !sticks.is_empty() && error <= ROUNDING)];
    let what = "given where and when it begins, the set gives length and duration of the listing's \
        stick phases, which are the published ones";
    let printed = [(what, settled > 0 && listing_error <= ROUNDING)];
    let (all, error) = (sticks.len(), small(error));
    let line = format!(
        "the equation x1 + vp (t − t_entry) = z_k + A sin(ωt) gives the ends of {all} stick phases \
         of the stated model to within {error} s; in another reading, of Fig. 8's motion, which \
         the listing makes, it misses the ends of {settled} stick phases by up to \
         {listing_error:.3} s"
    );
    vec![statement(Exact, parts, line), as_printed(printed)]
}

/// Difference (s) between the end of a stick phase and the end that the set predicts from its
/// start.
fn off_prediction(set: &TangentSet, stick: Stick) -> f64 {
    let model = ForcedOscillator::default();
    let predicted = set.first_meeting(&model, stick.entry, PERIODS_TO_MEETING * model.period());
    predicted.map_or(f64::INFINITY, |t| (t - stick.exit.t).abs())
}

/// Ends of stick phases: how many at each point, and how many elsewhere.
#[derive(Default)]
struct Exits {
    at: [usize; 6],
    elsewhere: usize,
    /// Largest distance of an end of the stated model from the nearest point (m).
    largest_distance: f64,
}

impl Exits {
    fn of_model(model: &ForcedOscillator, set: &TangentSet, phases: &[ModelPhase]) -> Exits {
        let mut exits = Exits::default();
        for phase in phases {
            let (number, distance) = set.nearest(model, phase.stick.exit);
            exits.largest_distance = exits.largest_distance.max(distance);
            match distance <= ROUNDING {
                true => exits.at[number] += 1,
                false => exits.elsewhere += 1,
            }
        }
        exits
    }

    /// Exits by the zone and the end that the listing reports.
    fn of_listing(phases: &[StickPhase]) -> Exits {
        let mut exits = Exits::default();
        for phase in phases {
            let end = usize::from(phase.end == ZoneEnd::Lower);
            match phase.zone {
                Some(zone) => exits.at[2 * zone as usize + end] += 1,
                None => exits.elsewhere += 1,
            }
        }
        exits
    }

    fn all(&self) -> usize {
        self.at.iter().sum::<usize>() + self.elsewhere
    }

    /// Ends at points 1, 3 and 5, which the caption of Fig. 4 calls visible.
    fn count_at_visible(&self) -> usize {
        self.at.iter().step_by(2).sum()
    }

    /// Ends at points 2, 4 and 6, which it calls invisible.
    fn count_at_invisible(&self) -> usize {
        self.at.iter().skip(1).step_by(2).sum()
    }
}

/// `fig08.exit_at_visible`: the tangent points at which stick phases end.
pub(super) fn exit_at_visible(grid: &GridPhases) -> Vec<Finding> {
    let sticks = &grid.model;
    let model = Exits::of_model(&ForcedOscillator::default(), &grid.set, sticks);
    let listing = Exits::of_listing(&grid.listing.phases);
    let mended = Exits::of_listing(&grid.both_ends_tested.phases);
    let visible = sticks.iter().filter(|stick| stick.visible).count();
    let all = model.all();
    let parts = [
        (
            "every loss of stick is at a tangent point of Eq. (24) moved by the support",
            all > 0 && model.elsewhere == 0,
        ),
        (
            "each is visible, the movement of the point included",
            all > 0 && visible == all,
        ),
    ];
    let what = "every loss of stick of the listing in a zone is at point 1, 3 or 5";
    let printed = [(
        what,
        listing.count_at_visible() > 0 && listing.count_at_invisible() == 0,
    )];
    let (odd, even, at) = (
        model.count_at_visible(),
        model.count_at_invisible(),
        model.at,
    );
    let distance = small(model.largest_distance);
    let (of_listing, all_of_listing) = (listing.count_at_visible(), listing.all());
    let (of_mended, all_of_mended) = (mended.count_at_visible(), mended.all());
    let [chatter, more] = [&grid.listing, &grid.both_ends_tested].map(|of| of.chatter);
    let line = format!(
        "stated model: {visible} of {all} ends of stick phases are visibly tangent, all within \
         {distance} m of a point. In another reading, by the points that Fig. 4's caption calls \
         visible at rest, {odd} are at 1, 3, 5 and {even} at 2, 4, 6 (by number {at:?}). The \
         listing tests upper ends only: {of_listing} of its {all_of_listing} are at 1, 3, 5 \
         whatever the motion; with both ends tested, {of_mended} of {all_of_mended} (phases of at \
         most ten steps left out: {chatter} and {more})"
    );
    // The listing tests only the points 1, 3 and 5.
    vec![
        statement(Exact, parts, line),
        as_printed(printed).by_construction(),
    ]
}

/// Stick phases and the tangent points that move past them.
#[derive(Debug, Default)]
struct Meetings {
    phases: usize,
    /// Phases in which a tangent point is met and passed before the release.
    passing: usize,
    /// Largest distance of a release from the nearest displaced tangent point (m).
    largest_distance: f64,
    /// Fraction of the stick time in which the body lies in no zone between tangent points.
    outside_zones: f64,
}

/// Meetings of the body with the tangent points: between start and end it moves uniformly.
fn meetings(
    model: &ForcedOscillator,
    set: &TangentSet,
    sticks: impl Iterator<Item = Stick>,
) -> Meetings {
    let mut meetings = Meetings::default();
    let (mut time, mut outside) = (0.0, 0.0);
    for stick in sticks {
        meetings.phases += 1;
        let distance = set.nearest(model, stick.exit).1;
        meetings.largest_distance = meetings.largest_distance.max(distance);
        let duration = stick.duration();
        let samples = (duration / model.period() * SAMPLES_PER_PERIOD)
            .ceil()
            .max(2.0);
        let (mut first, mut passes, mut samples_outside) = (None, false, 0.0);
        for k in 0..samples as u32 {
            // At the middle of each part: start and end themselves lie on tangent points.
            let part = (f64::from(k) + 0.5) / samples;
            let at = Instant {
                t: stick.entry.t + part * duration,
                x1: stick.entry.x1 + part * stick.length(),
            };
            let above = set.gaps(model, at).map(|gap| gap > 0.0);
            passes |= *first.get_or_insert(above) != above;
            let in_zone = above.chunks_exact(2).any(|zone| !zone[0] && zone[1]);
            samples_outside += f64::from(u8::from(!in_zone));
        }
        meetings.passing += usize::from(passes);
        time += duration;
        outside += duration * samples_outside / samples;
    }
    meetings.outside_zones = if time > 0.0 { outside / time } else { 0.0 };
    meetings
}

/// `s4.until_tangent`: whether a body in stick moves at the belt's speed until it meets the next
/// tangent point. `sticks_of_fig08` is the number of stick phases of the motion on which the stated
/// model settles from the start of Fig. 8.
pub(super) fn until_tangent(grid: &GridPhases, sticks_of_fig08: usize) -> Vec<Finding> {
    let met = |sticks: &mut dyn Iterator<Item = Stick>| {
        meetings(&ForcedOscillator::default(), &grid.set, sticks)
    };
    let sticks = grid.model.iter();
    let model = met(&mut sticks.clone().map(|one| one.stick));
    let fig08 = met(&mut grid.of_fig08());
    let listing = met(&mut grid.listing.sticks());
    let both_ends = met(&mut grid.both_ends_tested.sticks());
    let speed_error = largest(sticks.map(|one| one.speed_error));
    let holds_in_the_model = model.phases > 0
        && speed_error <= ROUNDING
        && model.passing == 0
        && model.largest_distance <= ROUNDING;
    let what = "the body of Fig. 8 in the stated model sticks and moves at the belt's speed until \
        the next tangent point is met";
    let parts = [(what, sticks_of_fig08 > 0 && holds_in_the_model)];
    let what = "the body of Fig. 8's motion, which the program makes, does so";
    let printed = [(what, fig08.phases > 0 && fig08.passing == 0)];
    let [of_fig08, of_listing, of_mended] = [&fig08, &listing, &both_ends].map(|of| {
        let outside = 100.0 * of.outside_zones;
        (
            format!("{} of {}", of.passing, of.phases),
            format!("{outside:.0} %"),
        )
    });
    let holds = if holds_in_the_model { "holds" } else { "fails" };
    let (starts, speed_error) = (starts().len(), small(speed_error));
    let (phases, passing) = (model.phases, model.passing);
    let distance = small(model.largest_distance);
    let line = format!(
        "the paragraph of Sect. 4.2 speaks of Fig. 8's motion. From its start the stated model \
         settles on {sticks_of_fig08} stick phases. Of the listing's, {} pass a tangent point \
         before they end, and the body is outside all zones for {} of its time in stick. Over the \
         first ten forcing periods from {starts} starts, without phases of at most ten steps, it \
         is {} and {}; with both ends of the zone tested it is {} and {}. In another reading, of \
         any stick phase of the stated model, the sentence {holds}: {phases} phases, velocity off \
         the belt's by at most {speed_error} m/s, {passing} pass a tangent point before they end, \
         and each ends within {distance} m of one",
        of_fig08.0, of_fig08.1, of_listing.0, of_listing.1, of_mended.0, of_mended.1,
    );
    vec![statement(Exact, parts, line), as_printed(printed)]
}

/// The misprint of Sect. 4.2: durations minus lengths over the belt's speed (s).
pub(super) fn durations(grid: &GridPhases, published: [f64; 4]) -> Proof {
    let belt = ForcedOscillator::default().belt_speed;
    let excess = |four: [f64; 4]| [four[2] - four[0] / belt, four[3] - four[1] / belt];
    let published = excess(published);
    let listing = excess(grid.fig08.stick_numbers().unwrap_or([f64::NAN; 4]));
    // Half a unit of the last printed digit in both numbers.
    let rounding = HALF_DIGIT + HALF_DIGIT / belt;
    let off = |stick: Stick| (stick.duration() - stick.length() / belt).abs();
    let of_model = largest(grid.model.iter().map(|phase| off(phase.stick)));
    let sticks = grid.model.len();
    let [first, second] = [0, 1].map(|k| [published[k], listing[k]]);
    let seconds = [first[0], first[1], second[0], second[1], rounding].map(Value::from);
    let shown = seconds.into_iter().chain([sticks.into(), of_model.into()]);
    let longer = published.iter().chain(&listing).all(|one| *one > rounding);
    let holds = longer && sticks > 0 && of_model <= ROUNDING;
    Proof::new("durations", shown, holds)
}

/// The stick phases of the stated model that end at a lower end.
pub(super) fn lower_ends(grid: &GridPhases) -> LowerEnds {
    let exits = Exits::of_model(&ForcedOscillator::default(), &grid.set, &grid.model);
    LowerEnds {
        missed: exits.count_at_invisible(),
        all: exits.all(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::stick_phases::of_model;
    use super::*;
    use crate::paper::published::Claims;
    use crate::report::evidence::settled_sticks;
    use std::sync::LazyLock;

    /// Computed once for all tests, since it takes seconds.
    static GRID: LazyLock<GridPhases> = LazyLock::new(|| GridPhases::compute(claims()).unwrap());

    fn claims() -> &'static Claims {
        Claims::committed().unwrap()
    }

    #[test]
    fn the_set_gives_the_stated_models_phases_and_not_the_listings() {
        let grid = &*GRID;
        let found = exact_lengths(grid);
        assert!(found[0].agrees && !found[1].agrees);
        let off = grid
            .of_fig08()
            .map(|stick| off_prediction(&grid.set, stick));
        assert!(largest(off) > 0.01);
    }

    #[test]
    fn another_belt_speed_spoils_the_prediction() {
        let model = ForcedOscillator::default();
        let slower = ForcedOscillator {
            belt_speed: 0.39,
            ..model
        };
        let set = TangentSet::published(claims());
        let sticks = of_model(&model).unwrap();
        let off = sticks.iter().map(|phase| phase.stick).filter(|stick| {
            let t = set.first_meeting(&slower, stick.entry, PERIODS_TO_MEETING * model.period());
            t.is_none_or(|t| (t - stick.exit.t).abs() > ROUNDING)
        });
        assert!(off.count() > sticks.len() / 2);
    }

    #[test]
    fn a_third_of_the_releases_is_at_points_called_invisible() {
        let grid = &*GRID;
        let model = ForcedOscillator::default();
        let exits = Exits::of_model(&model, &grid.set, &grid.model);
        assert_eq!((exits.all(), exits.count_at_invisible()), (72, 24));
        let found = exit_at_visible(grid);
        assert!(found[0].agrees && found[1].agrees && !found[1].is_evidence());
        // This holds by construction, unless the other end is tested too.
        let listing = Exits::of_listing(&grid.listing.phases);
        assert_eq!(listing.count_at_visible(), listing.all());
        let mended = Exits::of_listing(&grid.both_ends_tested.phases);
        assert!(mended.count_at_visible() < mended.all());
    }

    #[test]
    fn a_displaced_point_is_no_place_of_release() {
        let model = ForcedOscillator::default();
        let sticks = of_model(&model).unwrap();
        let mut set = TangentSet::published(claims());
        set.0[0] += 1e-6;
        let moved = Exits::of_model(&model, &set, &sticks);
        assert!(moved.elsewhere > 0 && moved.at[0] == 0);
    }

    #[test]
    fn without_forcing_only_upper_ends_release() {
        // A body that the belt carries up reaches only upper ends if these are at rest.
        let still = ForcedOscillator {
            amplitude: 0.0,
            ..ForcedOscillator::default()
        };
        let sticks = of_model(&still).unwrap();
        let found = Exits::of_model(&still, &TangentSet::published(claims()), &sticks);
        assert!(found.all() > 0);
        assert_eq!(found.count_at_visible(), found.all());
    }

    #[test]
    fn the_stated_model_stops_at_the_next_tangent_point_and_the_listing_does_not() {
        let grid = &*GRID;
        let found = until_tangent(grid, settled_sticks().unwrap());
        assert!(!found[0].agrees && !found[1].agrees);
        assert!(until_tangent(grid, 1)[0].agrees);
        // With both ends tested, the listing comes nearer to that.
        let (model, set) = (ForcedOscillator::default(), &grid.set);
        let listing = meetings(&model, set, grid.listing.sticks());
        let mended = meetings(&model, set, grid.both_ends_tested.sticks());
        assert!(listing.passing > 0 && listing.outside_zones > 0.1);
        assert!(
            mended.outside_zones < 0.1 * listing.outside_zones,
            "{mended:?}"
        );
        // A displaced point is not met.
        let displaced = TangentSet(set.0.map(|z| z + 1e-6));
        let sticks = grid.model.iter().map(|one| one.stick);
        assert!(meetings(&model, &displaced, sticks).largest_distance > ROUNDING);
    }

    #[test]
    fn lengths_of_another_belt_would_be_its_way() {
        let grid = &*GRID;
        assert!(durations(grid, claims().published_stick_numbers()).holds);
        let belt = ForcedOscillator::default().belt_speed;
        assert!(!durations(grid, [0.4, 0.2, 0.4 / belt, 0.2 / belt]).holds);
    }
}
