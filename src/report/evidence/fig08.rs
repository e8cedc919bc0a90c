//! The paper's statements on Fig. 8's motion: its start, its arcs, and that the Appendix's program
//! computes it.

use crate::destination::{Destination, destination};
use crate::figures::rows::Value;
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defects, END, Motion, Run, Sample, Setup, run, run_with};
use crate::paper::models::ForcedOscillator;
use crate::paper::pattern::two_periodic;
use crate::paper::published::Claims;
use crate::paper::reading::Reading::{AsPrinted, Exact};
use crate::paper::{TOLERANCE, bounded};
use crate::report::errata::Proof;
use crate::report::finding::{Finding, as_printed, statement};
use crate::report::scan::{CLOSENESS, PERIODS_FOLLOWED};
use plot::number;
use stickslip::{Error, Filippov, Mode, Side, solve};

/// Forcing periods of the settled motion that are examined: two of the published pattern.
const PERIODS_EXAMINED: f64 = 4.0;

/// Number of the four published numbers that a run of the listing gives to all printed digits.
fn published_digits(claims: &Claims, run: &Run) -> usize {
    let numbers = run.stick_numbers().into_iter().flatten();
    let numbers = ClaimId::STICK_NUMBERS.into_iter().zip(numbers);
    let agrees = |(id, value): &(ClaimId, f64)| claims.of(*id).agrees(*value);
    numbers.filter(agrees).count()
}

/// The program and the stated model from one start on Σ.
#[derive(Debug, PartialEq)]
struct StartResult {
    /// The start (m).
    x1: f64,
    /// Time of the listing's first release (s).
    first_release: f64,
    /// Number of the four published numbers on which the listing settles to all printed digits.
    digits: usize,
    /// Whether the stated model settles on stick–slip of period two.
    model_two_periodic: bool,
}

fn from(claims: &Claims, x1: f64) -> Result<StartResult, Error> {
    let model = ForcedOscillator::default();
    let setup = Setup {
        start: [0.0, x1, model.belt_speed],
        ..Setup::default()
    };
    let (outcome, start) = (run(&setup), (0.0, setup.state()));
    let (period, options) = (model.period(), bounded(TOLERANCE));
    let end = destination(&model, start, period, PERIODS_FOLLOWED, CLOSENESS, &options)?;
    let first = outcome.phases.first();
    Ok(StartResult {
        x1,
        first_release: first.map_or(f64::NAN, |phase| phase.stick.exit.t),
        digits: published_digits(claims, &outcome),
        model_two_periodic: matches!(
            end,
            Destination::Periodic { period, sticks, .. } if two_periodic(sticks, period)
        ),
    })
}

/// `fig08.start`: the caption's start, the third tangent point, and the listing's, which is `T[3]`,
/// the fourth.
pub(super) fn start(claims: &Claims) -> Result<(Vec<Finding>, Proof), Error> {
    let points = Setup::default().tangent_points;
    let (captioned, listed) = (from(claims, points[2])?, from(claims, points[3])?);
    let what = "from the third tangent point the stated model settles on stick–slip of period two";
    let parts = [(what, captioned.model_two_periodic)];
    let what = "the Appendix's program starts at the third tangent point";
    let printed = [(what, Setup::default().start[1] == points[2])];
    let [from_third, from_fourth] = [&captioned, &listed].map(|from| {
        let (x1, release, digits) = (number(from.x1, 4), from.first_release, from.digits);
        format!(
            "from x1 = {x1} m the program releases the body first at {release:.4} s and \
            settles on {digits} of the four published numbers"
        )
    });
    let line = format!(
        "the program starts at T[3], the fourth point; in another reading, with points counted \
         from 0 as in the program, that is the caption's. {from_fourth}; changed to start at the \
         third, {from_third}"
    );
    let shown: [[Value; 3]; 2] =
        [&captioned, &listed].map(|of| [of.x1.into(), of.first_release.into(), of.digits.into()]);
    let apart = captioned.first_release - listed.first_release;
    Ok((
        vec![statement(Exact, parts, line), as_printed(printed)],
        Proof::new("start", shown.into_iter().flatten(), apart.abs() > 1e-3),
    ))
}

/// Slip phases of one motion.
struct SlipSides {
    /// Sides of the slip phases in order of time.
    sides: Vec<Side>,
    /// Largest velocity in S1, and smallest in S2 (m/s).
    highest_in_s1: f64,
    lowest_in_s2: f64,
}

impl SlipSides {
    const EMPTY: SlipSides = SlipSides {
        sides: Vec::new(),
        highest_in_s1: f64::NEG_INFINITY,
        lowest_in_s2: f64::INFINITY,
    };

    /// Number of pairs of successive slip phases on the same side.
    fn repeats(&self) -> usize {
        let pairs = self.sides.windows(2);
        pairs.filter(|pair| pair[0] == pair[1]).count()
    }

    /// Whether the arcs in S1 lie above those in S2.
    fn s1_is_upper(&self) -> bool {
        self.highest_in_s1 > self.lowest_in_s2
    }

    fn take(&mut self, side: Side, velocity: f64) {
        match side {
            Side::Below => self.highest_in_s1 = self.highest_in_s1.max(velocity),
            Side::Above => self.lowest_in_s2 = self.lowest_in_s2.min(velocity),
        }
    }

    fn parts(&self) -> [(&'static str, bool); 2] {
        let alternate = self.sides.len() >= 2 && self.repeats() == 0;
        let what = "those in S1 are the upper arcs, those in S2 the lower";
        [
            ("slip phases lie alternately in S1 and S2", alternate),
            (what, self.s1_is_upper()),
        ]
    }

    fn line(&self, name: &str) -> String {
        let (phases, repeats) = (self.sides.len(), self.repeats());
        let (highest, lowest) = (self.highest_in_s1, self.lowest_in_s2);
        format!(
            "{name}: {phases} slip phases, {repeats} times two on the same side, velocities up to \
                {highest:.4} m/s in S1 and from {lowest:.4} m/s in S2"
        )
    }
}

/// `s4.arcs`: the sides of Σ of the slip phases, and which of them are the upper ones.
pub(super) fn arcs() -> Result<(Vec<Finding>, Proof), Error> {
    let model = ForcedOscillator::default();
    let (exact, listing) = (sides_of_model(&model)?, sides_of_listing());
    let (of_listing, of_model) = (listing.line("listing"), exact.line("stated model"));
    let line = format!(
        "{of_listing}; {of_model}; the belt's speed is {} m/s, so that S1 holds the lower arcs",
        model.belt_speed
    );
    let shown = [&listing, &exact].map(|of| [of.highest_in_s1, of.lowest_in_s2]);
    let holds = !listing.s1_is_upper() && !exact.s1_is_upper();
    Ok((
        vec![
            statement(Exact, exact.parts(), line),
            as_printed(listing.parts()),
        ],
        Proof::new("regions", shown.into_iter().flatten(), holds),
    ))
}

/// Sides of the attractor of the stated model, or of a similar one.
fn sides_of_model<S: Filippov<2>>(system: &S) -> Result<SlipSides, Error> {
    let printed = ForcedOscillator::default();
    let end = END + PERIODS_EXAMINED * printed.period();
    let orbit = solve(
        system,
        0.0,
        Setup::default().state(),
        end,
        &bounded(TOLERANCE),
    )?;
    let settled = orbit.phases.iter().filter(|phase| phase.t_start >= END);
    let mut sides = SlipSides {
        sides: settled.filter_map(|phase| side_of(phase.mode)).collect(),
        ..SlipSides::EMPTY
    };
    for step in orbit.steps.iter().filter(|step| step.t_start >= END) {
        if let Some(side) = side_of(step.mode) {
            let middle = step.dense.at_time(0.5 * (step.t_start + step.t_end));
            sides.take(side, middle[1]);
        }
    }
    Ok(sides)
}

fn side_of(mode: Mode) -> Option<Side> {
    match mode {
        Mode::Stick => None,
        Mode::Slip(side) => Some(side),
    }
}

/// Sides of the listing as printed, in the plotted window.
fn sides_of_listing() -> SlipSides {
    let setup = Setup::default();
    let mut window: Vec<Sample> = Vec::new();
    run_with(&setup, |sample| {
        window.extend(Some(*sample).filter(|one| one.in_window))
    });
    let mut sides = SlipSides::EMPTY;
    for phase in window.chunk_by(|one, next| one.mode == next.mode) {
        let Some(side) = side_of(phase[0].mode) else {
            continue;
        };
        // A single pass only corrects the side after a stick phase.
        if phase.len() > 1 {
            sides.sides.push(side);
        }
        let off_belt = phase.iter().filter(|at| at.x2 != setup.model.belt_speed);
        off_belt.for_each(|at| sides.take(side, at.x2));
    }
    sides
}

/// `s4.found_by_appendix`: what the Appendix's program computes. The result of the program without
/// its defects is shown beside it.
pub(super) fn found_by_appendix(claims: &Claims, defects: Defects) -> Vec<Finding> {
    let [printed, mended] = [defects, Defects::MENDED].map(|of| run(&Setup::with(of)));
    let (digits, all) = (
        published_digits(claims, &printed),
        ClaimId::STICK_NUMBERS.len(),
    );
    let what = "the Appendix's program as printed gives the published trajectory";
    let parts = [(what, printed.motion == Motion::PUBLISHED && digits == all)];
    let (printed, mended) = (printed.motion, mended.motion);
    let line = format!(
        "listing as printed: {printed}, {digits} of {all} published numbers to all digits; with \
            its defects mended: {mended}"
    );
    vec![statement(AsPrinted, parts, line)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::listing::Defect;
    use stickslip::scalar::Scalar;

    #[test]
    fn s1_holds_the_lower_arcs() {
        let (found, misprint) = arcs().unwrap();
        assert_eq!(found[0].parts(), [true, false]);
        assert!(!found[1].parts()[1] && misprint.holds);
        let belt = ForcedOscillator::default();
        let model = sides_of_model(&belt).unwrap();
        assert!(model.highest_in_s1 < belt.belt_speed && belt.belt_speed < model.lowest_in_s2);
    }

    /// Model 2 with S1 above Σ and S2 below, as in Sect. 4.2.
    struct ExchangedRegions(ForcedOscillator);
    impl Filippov<2> for ExchangedRegions {
        fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            self.0.field(side.opposite(), t, x)
        }
        fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
            -self.0.boundary(t, x)
        }
    }

    #[test]
    fn with_the_regions_exchanged_s1_would_hold_the_upper() {
        let found = sides_of_model(&ExchangedRegions(ForcedOscillator::default())).unwrap();
        assert_eq!(found.parts().map(|part| part.1), [true, true]);
    }

    #[test]
    fn the_program_finds_it_and_not_with_its_stages_mended() {
        let agrees = |defects| found_by_appendix(Claims::committed().unwrap(), defects)[0].agrees;
        assert!(agrees(Defects::AS_PRINTED));
        let mended = Defects::AS_PRINTED.flipped(Defect::InPlaceStages);
        assert!(!agrees(mended) && !agrees(Defects::MENDED));
    }

    #[test]
    fn the_listing_settles_on_the_published_numbers_from_its_own_start() {
        let claims = Claims::committed().unwrap();
        let points = Setup::default().tangent_points;
        let [captioned, listed] = [points[2], points[3]].map(|x1| from(claims, x1).unwrap());
        assert_eq!(listed.digits, 4);
        assert!((captioned.first_release - listed.first_release).abs() > 1e-3);
        // Between the zones no body sticks, and the program has no zone to release it from.
        assert_ne!(from(claims, 0.5).unwrap(), captioned);
        assert!(start(claims).unwrap().1.holds);
    }
}
