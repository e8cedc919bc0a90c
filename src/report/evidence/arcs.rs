//! `s4.arcs`: on which sides of Σ the slip phases lie, and which of them are the upper ones.

use super::grid::{ESCAPE, TOLERANCE};
use super::{Evidence, EvidenceError, Part};
use crate::paper::listing::{self, Defects, Params, Setup, run_with};
use stickslip::error::Error;
use stickslip::filippov::{Options, solve};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Filippov, Mode, Side, State};

/// End of the run that lets the motion settle (s), the listing's own.
const SETTLED: f64 = 63.3;
/// Forcing periods looked at after that.
const SHOWN: f64 = 4.0;

/// Slip phases of one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// Sides of the slip phases in order of time.
    pub sides: Vec<Side>,
    /// Largest velocity reached in S1 (m/s).
    pub highest_in_s1: f64,
    /// Least velocity reached in S2 (m/s).
    pub lowest_in_s2: f64,
}

impl Sides {
    const NONE: Sides = Sides {
        sides: Vec::new(),
        highest_in_s1: f64::NEG_INFINITY,
        lowest_in_s2: f64::INFINITY,
    };

    /// Pairs of slip phases, one after the other, that lie on the same side.
    pub fn repeats(&self) -> usize {
        self.sides
            .windows(2)
            .filter(|pair| pair[0] == pair[1])
            .count()
    }

    /// Whether the arcs in S1 lie above those in S2.
    pub fn s1_is_upper(&self) -> bool {
        self.highest_in_s1 > self.lowest_in_s2
    }

    fn alternate(&self) -> bool {
        self.sides.len() >= 2 && self.repeats() == 0
    }

    fn take(&mut self, side: Side, velocity: f64) {
        match side {
            Side::Below => self.highest_in_s1 = self.highest_in_s1.max(velocity),
            Side::Above => self.lowest_in_s2 = self.lowest_in_s2.min(velocity),
        }
    }
}

/// Slip phases of the stated model's attractor and of the listing's settled motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Arcs {
    /// The belt's speed (m/s).
    pub belt_speed: f64,
    /// The stated model.
    pub model: Sides,
    /// The listing as printed, in the plotted window; the single steps on the wrong side after a stick phase left out.
    pub listing: Sides,
}

impl Arcs {
    /// Follows both.
    ///
    /// # Errors
    /// [`EvidenceError`] of the run that fails.
    pub fn compute() -> Result<Arcs, EvidenceError> {
        let model = ForcedOscillator::default();
        Ok(Arcs {
            belt_speed: model.belt_speed,
            model: of_model(&model)?,
            listing: of_listing(Defects::AS_PRINTED)?,
        })
    }
}

fn of_model<S: Filippov<2>>(system: &S) -> Result<Sides, Error> {
    let printed = ForcedOscillator::default();
    let x = State::from([Params::default().x1, printed.belt_speed]);
    let end = SETTLED + SHOWN * printed.period();
    let options = Options::tol(TOLERANCE).escape(ESCAPE);
    let orbit = solve(system, 0.0, x, end, &options)?;
    let mut found = Sides::NONE;
    for phase in orbit.phases.iter().filter(|phase| phase.t_start >= SETTLED) {
        if let Mode::Slip(side) = phase.mode {
            found.sides.push(side);
        }
    }
    for step in orbit.steps.iter().filter(|step| step.t_start >= SETTLED) {
        if let Mode::Slip(side) = step.mode {
            let middle = step.dense.at_time(0.5 * (step.t_start + step.t_end));
            found.take(side, middle[1]);
        }
    }
    Ok(found)
}

fn of_listing(defects: Defects) -> Result<Sides, EvidenceError> {
    let setup = Setup {
        defects,
        ..Setup::default()
    };
    let mut found = Sides::NONE;
    // Side of the slip phase under way, and the passes it has lasted.
    let mut under_way: Option<(Side, u32)> = None;
    let belt_speed = setup.params.belt_speed;
    run_with(&setup, |sample| {
        if !sample.in_window {
            return;
        }
        let side = match sample.mode {
            listing::Mode::Stick => None,
            listing::Mode::Below => Some(Side::Below),
            listing::Mode::Above => Some(Side::Above),
        };
        match (side, &mut under_way) {
            (Some(side), Some((known, passes))) if side == *known => {
                *passes += 1;
                // A phase counts from its second pass: the first may only mend the side after a stick phase.
                if *passes == 2 {
                    found.sides.push(side);
                }
            }
            (Some(side), _) => under_way = Some((side, 1)),
            (None, _) => under_way = None,
        }
        if let Some(side) = side
            && sample.x2 != belt_speed
        {
            found.take(side, sample.x2);
        }
    })?;
    Ok(found)
}

impl Evidence for Arcs {
    fn parts(&self) -> Vec<Part> {
        vec![
            Part {
                what: "slip phases lie alternately in S1 and S2",
                holds: self.model.alternate(),
            },
            Part {
                what: "those in S1 are the upper arcs, those in S2 the lower",
                holds: self.model.s1_is_upper(),
            },
        ]
    }

    fn as_printed(&self) -> Vec<Part> {
        vec![
            Part {
                what: "slip phases lie alternately in S1 and S2",
                holds: self.listing.alternate(),
            },
            Part {
                what: "those in S1 are the upper arcs, those in S2 the lower",
                holds: self.listing.s1_is_upper(),
            },
        ]
    }

    fn line(&self) -> String {
        let of = |name: &str, one: &Sides| {
            format!(
                "{name}: {} slip phases, {} times two on the same side, velocities up to {:.4} m/s in S1 and from {:.4} m/s in S2",
                one.sides.len(),
                one.repeats(),
                one.highest_in_s1,
                one.lowest_in_s2
            )
        };
        format!(
            "{}; {}; the belt's speed is {} m/s, so that S1 holds the lower arcs",
            of("listing", &self.listing),
            of("stated model", &self.model),
            self.belt_speed
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;
    use stickslip::scalar::Scalar;

    #[test]
    fn s1_holds_the_lower_arcs() {
        let found = Arcs::compute().unwrap();
        assert!(
            !found.parts()[1].holds && !found.as_printed()[1].holds,
            "{found:?}"
        );
        assert_eq!(found.support(), Support::InPart, "{found:?}");
        assert!(found.model.highest_in_s1 < found.belt_speed);
        assert!(found.listing.lowest_in_s2 > found.belt_speed);
    }

    /// Model 2 with S1 above Σ and S2 below, as Sect. 4.2 has it.
    struct Exchanged(ForcedOscillator);
    impl Filippov<2> for Exchanged {
        fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
            self.0.field(side.opposite(), t, x)
        }
        fn boundary<T: Scalar>(&self, t: T, x: &[T; 2]) -> T {
            -self.0.boundary(t, x)
        }
    }

    #[test]
    fn with_the_regions_exchanged_s1_would_hold_the_upper() {
        let found = of_model(&Exchanged(ForcedOscillator::default())).unwrap();
        assert!(found.s1_is_upper() && found.alternate());
    }
}
