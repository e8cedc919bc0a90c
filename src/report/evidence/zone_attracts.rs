//! `s4.zone_attracts`: whether the wide stick zone attracts, and whether stick–slip cycles arise below the critical friction.

use rayon::prelude::*;

use super::{Evidence, Part, small};
use crate::report::scan::{Class, Point, starts};
use stickslip::error::Error;
use stickslip::filippov::{Fate, fate};
use stickslip::models::ForcedOscillator;
use stickslip::system::{Filippov, Side, State};

/// Places of the zone looked at.
const PLACES: u32 = 400;
/// Values of friction up to the critical one, at equal distances.
const VALUES: u32 = 25;

/// What all starts lead to at one friction amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// μ0 over its critical value.
    pub ratio: f64,
    /// Starts that lead to a periodic motion with stick.
    pub starts: usize,
    /// Forcing periods and stick phases of the stick–slip cycles found, each cycle once.
    pub cycles: Vec<(usize, usize)>,
}

/// A sweep of μ0 below its critical value with the other parameters of one caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Whose parameters.
    pub caption: &'static str,
    /// Starts at each value.
    pub starts: usize,
    /// One for each value, ascending.
    pub points: Vec<SweepPoint>,
    /// At the critical friction itself.
    pub at_critical: SweepPoint,
}

impl Sweep {
    /// Values at which there is a stick–slip cycle.
    pub fn with_cycles(&self) -> usize {
        self.points
            .iter()
            .filter(|point| !point.cycles.is_empty())
            .count()
    }

    /// Neighbouring values of which one has cycles and the other none: there cycles appear or vanish.
    pub fn births_and_deaths(&self) -> usize {
        let has = |point: &SweepPoint| !point.cycles.is_empty();
        self.points
            .windows(2)
            .filter(|pair| has(&pair[0]) != has(&pair[1]))
            .count()
    }

    /// Neighbouring values, both with cycles, whose cycles differ in period or number of stick phases.
    pub fn changes(&self) -> usize {
        let differ = |pair: &&[SweepPoint]| {
            let [one, other] = pair else { return false };
            !one.cycles.is_empty() && !other.cycles.is_empty() && one.cycles != other.cycles
        };
        self.points.windows(2).filter(differ).count()
    }
}

/// The zone at the critical friction, and cycles below it.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneAttracts {
    /// Places looked at between the outer tangent points at the critical friction.
    pub places: usize,
    /// Of these, those where both fields face each other.
    pub attracting: usize,
    /// Least of the two normal components towards Σ over all places (m/s²).
    pub least_pull: f64,
    /// Below the critical friction: parameters of Fig. 7, then of Fig. 8.
    pub sweeps: [Sweep; 2],
}

impl ZoneAttracts {
    /// Looks along the zone and follows all starts.
    ///
    /// # Errors
    /// Those of [`stickslip::solve`] except an escape.
    pub fn compute() -> Result<ZoneAttracts, Error> {
        let fig08 = ForcedOscillator::default();
        let fig07 = ForcedOscillator {
            mass: 1.0,
            belt_speed: 1.0,
            ..fig08
        };
        let (places, attracting, least_pull) = zone(&fig07);
        Ok(ZoneAttracts {
            places,
            attracting,
            least_pull,
            sweeps: [sweep("Fig. 7", &fig07)?, sweep("Fig. 8", &fig08)?],
        })
    }
}

/// Critical friction (N), Eq. (23).
fn critical(model: &ForcedOscillator) -> f64 {
    2.0 * model.k1 / 3.0 * (model.k1 / (3.0 * model.k2)).sqrt()
}

/// Places, attracting ones and the least pull along the zone at the critical friction.
fn zone(model: &ForcedOscillator) -> (usize, usize, f64) {
    let model = ForcedOscillator {
        mu0: critical(model),
        ..*model
    };
    let outer = 2.0 * (model.k1 / (3.0 * model.k2)).sqrt();
    let (mut attracting, mut least) = (0, f64::INFINITY);
    for k in 0..PLACES {
        let part = 2.0 * (f64::from(k) + 0.5) / f64::from(PLACES) - 1.0;
        let x = State::from([outer * part, model.belt_speed]);
        attracting += usize::from(fate(&model, 0.0, &x) == Fate::Stick);
        for side in [Side::Below, Side::Above] {
            least = least.min(-side.sign() * model.field(side, 0.0, x.as_ref())[1]);
        }
    }
    (PLACES as usize, attracting, least)
}

fn sweep(caption: &'static str, model: &ForcedOscillator) -> Result<Sweep, Error> {
    let mut points = (1..=VALUES)
        .into_par_iter()
        .map(|k| {
            let ratio = f64::from(k) / f64::from(VALUES);
            let mu0 = ratio * critical(model);
            let model = ForcedOscillator { mu0, ..*model };
            let found = Point::compute(&model, &starts(&model)?, ratio, mu0)?;
            let mut cycles: Vec<(usize, usize)> = found
                .stick_slip
                .iter()
                .map(|motion| (motion.period, motion.lengths.len()))
                .collect();
            cycles.sort_unstable();
            Ok(SweepPoint {
                ratio,
                starts: found.counts[Class::StickSlip as usize]
                    + found.counts[Class::StickSlipTwo as usize],
                cycles,
            })
        })
        .collect::<Result<Vec<SweepPoint>, Error>>()?;
    let at_critical = points.pop().ok_or(Error::NotFound {
        what: "a value of friction",
        t: 0.0,
        span: 0.0,
    })?;
    Ok(Sweep {
        caption,
        starts: starts(model)?.len(),
        points,
        at_critical,
    })
}

impl Evidence for ZoneAttracts {
    fn parts(&self) -> Vec<Part> {
        let prevail = |sweep: &Sweep| 2 * sweep.with_cycles() > sweep.points.len();
        let bifurcates = |sweep: &Sweep| sweep.births_and_deaths() + sweep.changes() > 0;
        vec![
            Part {
                what: "at the critical friction both fields face each other on the whole zone",
                holds: self.places > 0 && self.attracting == self.places,
            },
            Part {
                what: "below it, at some mu0, there are stick–slip cycles",
                holds: self.sweeps.iter().any(|sweep| sweep.with_cycles() > 0),
            },
            Part {
                what: "they are what the attraction results in: at most of the values tried",
                holds: self.sweeps.iter().any(prevail),
            },
            Part {
                what: "they appear, vanish or change with mu0",
                holds: self.sweeps.iter().any(bifurcates),
            },
        ]
    }

    fn line(&self) -> String {
        let sweeps: Vec<String> = self
            .sweeps
            .iter()
            .map(|sweep| {
                format!(
                    "with the parameters of {} stick–slip cycles at {} of {} values below it ({} starts each), which between neighbours \
                     appear or vanish {} times and change period or number of sticks {} times; at the critical friction itself, which is \
                     another reading of the sentence, {} starts lead to one",
                    sweep.caption,
                    sweep.with_cycles(),
                    sweep.points.len(),
                    sweep.starts,
                    sweep.births_and_deaths(),
                    sweep.changes(),
                    sweep.at_critical.starts
                )
            })
            .collect();
        format!(
            "at the critical friction {} of {} places of the zone attract, the weaker field by {} m/s² where it is weakest; “strongly” is not tested, \
             for the paper gives no measure; {}",
            self.attracting,
            self.places,
            small(self.least_pull),
            sweeps.join("; ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_that_drives_attracts_nowhere() {
        let model = ForcedOscillator::default();
        let (places, attracting, pull) = zone(&model);
        assert!(attracting == places && pull > 0.0);
        let driving = ForcedOscillator {
            mu0: -critical(&model),
            ..model
        };
        let x = State::from([0.3, model.belt_speed]);
        assert_eq!(fate(&driving, 0.0, &x), Fate::Repelling);
    }

    #[test]
    fn cycles_arise_below_the_critical_friction_and_not_at_it() {
        let found = ZoneAttracts::compute().unwrap();
        assert_eq!(
            found.support(),
            crate::report::evidence::Support::InPart,
            "{}",
            found.line()
        );
        let [fig07, fig08] = &found.sweeps;
        assert_eq!(fig07.with_cycles(), 0);
        assert!(fig08.with_cycles() > 0 && fig08.at_critical.cycles.is_empty());
        // Without the parameters of Fig. 8 nothing would be left of it but the zone.
        let fig07_alone = ZoneAttracts {
            sweeps: [fig07.clone(), fig07.clone()],
            ..found.clone()
        };
        assert_eq!(
            fig07_alone.parts().iter().filter(|part| part.holds).count(),
            1
        );
    }

    #[test]
    fn changes_are_between_neighbours_that_both_have_cycles() {
        let point = |cycles: &[(usize, usize)]| SweepPoint {
            ratio: 0.5,
            starts: cycles.len(),
            cycles: cycles.to_vec(),
        };
        let sweep = |points| Sweep {
            caption: "a test",
            starts: 1,
            points,
            at_critical: point(&[]),
        };
        let same = sweep(vec![point(&[(1, 1)]), point(&[(1, 1)]), point(&[])]);
        assert_eq!(
            (same.with_cycles(), same.changes(), same.births_and_deaths()),
            (2, 0, 1)
        );
        let other = sweep(vec![point(&[(1, 1)]), point(&[(2, 2)])]);
        assert_eq!(other.changes(), 1);
    }
}
