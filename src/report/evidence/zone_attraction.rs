//! `s4.zone_attracts`: what the wide stick zone of model 2 attracts, and the cycles below the
//! critical friction.

use rayon::prelude::*;

use crate::numbers::not_found;
use crate::paper::models::ForcedOscillator;
use crate::paper::reading::Reading::Exact;
use crate::report::belt_positions;
use crate::report::digits::small;
use crate::report::finding::{Finding, statement};
use crate::report::scan::{ParameterPoint, StickSlip, starts};
use crate::text::joined;
use stickslip::{Error, Fate, Filippov, Side, fate};

/// Number of equidistant positions in the wide zone. The weaker field vanishes at its ends, and the
/// outermost positions are an 800th of the zone from them.
const ZONE_POSITIONS: u32 = 400;
/// Number of equidistant values of friction up to the critical one.
const FRICTION_VALUES: u32 = 25;

/// Forcing periods and stick phases of a stick–slip cycle.
type Cycle = (usize, usize);
/// The distinct cycles at one friction, and the number of starts that lead to them.
type Cycles = (Vec<Cycle>, usize);

/// Model 2 with the mass and the belt's speed of Fig. 7, and the drive of Fig. 8.
fn of_fig07() -> ForcedOscillator {
    ForcedOscillator {
        mass: 1.0,
        belt_speed: 1.0,
        ..ForcedOscillator::default()
    }
}

/// `s4.zone_attracts`: whether the wide stick zone attracts, and whether stick–slip cycles arise
/// below the critical friction.
pub(super) fn attracts() -> Result<Vec<Finding>, Error> {
    let (fig07, fig08) = (of_fig07(), ForcedOscillator::default());
    let sweeps = [Sweep::of("Fig. 7", &fig07)?, Sweep::of("Fig. 8", &fig08)?];
    Ok(statement_findings(zone(&fig07), &sweeps))
}

fn statement_findings((attracting, least_pull): (usize, f64), sweeps: &[Sweep]) -> Vec<Finding> {
    let any = |holds: fn(&Sweep) -> bool| sweeps.iter().any(holds);
    let parts = [
        (
            "at the critical friction both fields face each other on the whole zone",
            attracting == ZONE_POSITIONS as usize,
        ),
        (
            "below it, at some mu0, there are stick–slip cycles",
            any(|sweep| sweep.with_cycles() > 0),
        ),
        (
            "they are what the attraction results in: they exist at all of the values tried",
            any(|sweep| sweep.with_cycles() == sweep.points.len()),
        ),
        (
            "they appear, vanish or change with mu0",
            any(|sweep| sweep.births_and_deaths() + sweep.cycle_changes() > 0),
        ),
    ];
    let each = sweeps.iter().map(|sweep| {
        let (caption, starts, critical) = (sweep.caption, sweep.starts, sweep.at_critical.1);
        let (cycles, values) = (sweep.with_cycles(), sweep.points.len());
        let (births, changes) = (sweep.births_and_deaths(), sweep.cycle_changes());
        format!(
            "with the parameters of {caption}, stick–slip cycles exist at {cycles} of {values} \
             values below it ({starts} starts each); from one value to the next they appear or \
             vanish {births} times and change period or number of sticks {changes} times; in \
             another reading, at the critical friction itself, {critical} starts lead to one"
        )
    });
    let (pull, each) = (small(least_pull), joined(each, "; "));
    let line = format!(
        "at the critical friction {attracting} of {ZONE_POSITIONS} positions in the zone attract, \
         and the weaker field has at least {pull} m/s² there; “strongly” is not tested, for the \
         paper gives no measure; Fig. 7 states no drive, so that of Fig. 8 is used with both; \
         {each}"
    );
    vec![statement(Exact, parts, line)]
}

/// Critical friction (N), Eq. (23).
pub(super) fn critical(model: &ForcedOscillator) -> f64 {
    2.0 * model.k1 / 3.0 * (model.k1 / (3.0 * model.k2)).sqrt()
}

/// Number of attracting positions, and the smallest attraction (m/s²) along the zone, at the
/// critical friction.
fn zone(model: &ForcedOscillator) -> (usize, f64) {
    let model = ForcedOscillator {
        mu0: critical(model),
        ..*model
    };
    let outer = 2.0 * (model.k1 / (3.0 * model.k2)).sqrt();
    let (mut attracting, mut least) = (0, f64::INFINITY);
    for x in belt_positions(outer, ZONE_POSITIONS, model.belt_speed) {
        attracting += usize::from(fate(&model, 0.0, &x) == Fate::Stick);
        for side in [Side::Below, Side::Above] {
            least = least.min(-side.sign() * model.field(side, 0.0, x.as_ref())[1]);
        }
    }
    (attracting, least)
}

/// A sweep of μ0 below its critical value with the other parameters of one caption.
struct Sweep {
    caption: &'static str,
    /// Starts at each value.
    starts: usize,
    /// Cycles at each value, ascending, including the critical friction.
    points: Vec<Cycles>,
    at_critical: Cycles,
}

impl Sweep {
    fn of(caption: &'static str, model: &ForcedOscillator) -> Result<Sweep, Error> {
        let at = |k: u32| -> Result<Cycles, Error> {
            let ratio = f64::from(k) / f64::from(FRICTION_VALUES);
            let mu0 = ratio * critical(model);
            let model = ForcedOscillator { mu0, ..*model };
            let point = ParameterPoint::compute(&model, &starts(&model)?, ratio, mu0)?;
            let cycle = |motion: &StickSlip| (motion.period, motion.lengths.len());
            let mut cycles: Vec<Cycle> = point.stick_slip.iter().map(cycle).collect();
            cycles.sort_unstable();
            Ok((cycles, point.sticking()))
        };
        let points = (1..=FRICTION_VALUES).into_par_iter().map(at);
        let mut points = points.collect::<Result<Vec<Cycles>, Error>>()?;
        let at_critical = points.pop();
        Ok(Sweep {
            caption,
            starts: starts(model)?.len(),
            at_critical: at_critical.ok_or_else(|| not_found("a value of friction", 0.0, 0.0))?,
            points,
        })
    }

    /// Number of values with a stick–slip cycle.
    fn with_cycles(&self) -> usize {
        let with = self.points.iter().filter(|(cycles, _)| !cycles.is_empty());
        with.count()
    }

    fn neighbours(&self, are: fn(&[Cycle], &[Cycle]) -> bool) -> usize {
        let pairs = self.points.windows(2);
        pairs.filter(|pair| are(&pair[0].0, &pair[1].0)).count()
    }

    /// Number of neighbouring values of which one has cycles and the other has none: there cycles
    /// appear or vanish.
    fn births_and_deaths(&self) -> usize {
        self.neighbours(|one, other| one.is_empty() != other.is_empty())
    }

    /// Number of neighbouring values, both with cycles, whose cycles differ in period or number of
    /// stick phases.
    fn cycle_changes(&self) -> usize {
        self.neighbours(|one, other| !one.is_empty() && !other.is_empty() && one != other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::State;

    #[test]
    fn friction_that_drives_attracts_nowhere() {
        let model = ForcedOscillator::default();
        let (attracting, pull) = zone(&model);
        assert!(attracting == ZONE_POSITIONS as usize && pull > 0.0);
        let driving = ForcedOscillator {
            mu0: -critical(&model),
            ..model
        };
        let x = State::from([0.3, model.belt_speed]);
        assert_eq!(fate(&driving, 0.0, &x), Fate::Repelling);
    }

    #[test]
    fn cycles_arise_below_the_critical_friction_and_not_at_it() {
        let (fig07, fig08) = (of_fig07(), ForcedOscillator::default());
        let of_fig08 = Sweep::of("Fig. 8", &fig08).unwrap();
        assert!(of_fig08.with_cycles() > 0 && of_fig08.at_critical.0.is_empty());
        let of_fig07 = Sweep::of("Fig. 7", &fig07).unwrap();
        assert_eq!(of_fig07.with_cycles(), 0);
        // Without the parameters of Fig. 8 only the zone remains.
        let alone = statement_findings(zone(&fig07), &[of_fig07]);
        assert_eq!(alone[0].parts(), [true, false, false, false]);
        let both = statement_findings(zone(&fig07), &[of_fig08])[0].parts();
        assert!(both[1] && both.contains(&false), "{both:?}");
    }

    #[test]
    fn changes_are_between_neighbours_that_both_have_cycles() {
        let sweep = |points: &[&[Cycle]]| Sweep {
            caption: "a test",
            starts: 1,
            points: points.iter().map(|cycles| (cycles.to_vec(), 1)).collect(),
            at_critical: (Vec::new(), 0),
        };
        let same = sweep(&[&[(1, 1)], &[(1, 1)], &[]]);
        let found = (
            same.with_cycles(),
            same.cycle_changes(),
            same.births_and_deaths(),
        );
        assert_eq!(found, (2, 0, 1));
        assert_eq!(sweep(&[&[(1, 1)], &[(2, 2)]]).cycle_changes(), 1);
    }
}
