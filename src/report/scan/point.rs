//! The attractors of all starts at one set of parameters.

use crate::destination::{Destination, destination};
use crate::figures::block_and_bracket::DIVERGED;
use crate::numbers::largest;
use crate::paper::models::{ForcedOscillator, Unchecked};
use crate::paper::pattern::two_periodic;
use crate::paper::published::LAST_DIGIT;
use crate::paper::{ESCAPE, SETTLING_TOLERANCE};
use crate::report::stick_exits;
use crate::text::described;
use stickslip::dynamics::{Components, Vector};
use stickslip::{AtRepelling, Error, Options, State, solve};

described! {
    /// Class of the motion from a start.
    StartClass: &'static str as pub name {
        /// Out of the spring's reach.
        Escape = "escapes",
        /// Periodic without stick.
        SlipOnly = "slip_only",
        /// Periodic with stick in each forcing period or with a period other than two.
        StickSlip = "stick_slip_other",
        /// Periodic with stick, repeating after two forcing periods and not after one, as
        /// published.
        StickSlipTwo = "stick_slip_period_two",
        /// Nothing repeats within eight forcing periods.
        Unsettled = "unsettled",
    }
}

/// Number of positions of the starts, symmetric about 0. The unit is √(k1/k2), beyond which the
/// spring drives bodies away.
const POSITIONS: usize = 9;
/// The outermost position, a little beyond the outer tangent points.
const OUTERMOST: f64 = 1.2;
/// Velocities of the starts (m/s), besides the belt's speed.
const VELOCITIES: [f64; 4] = [-1.6, -0.8, 0.0, 1.2];

/// Starts: a grid, points on the belt, and the ends of the stick zones, one of which is the paper's
/// start.
pub(in crate::report) fn starts(model: &ForcedOscillator) -> Result<Vec<State<2>>, Error> {
    let unit = (model.k1 / model.k2).sqrt();
    let speeds = || VELOCITIES.into_iter().chain([model.belt_speed]);
    let middle = (POSITIONS / 2) as f64;
    let mut all: Vec<State<2>> = (0..POSITIONS)
        .map(|k| unit * OUTERMOST * (k as f64 - middle) / middle)
        .flat_map(|x1| speeds().map(move |x2| State::from([x1, x2])))
        .collect();
    for (lower, upper) in model.stick_zones()? {
        all.extend([lower, upper].map(|z| State::from([z, model.belt_speed])));
    }
    Ok(all)
}

/// The printed model with the spring of Eq. (4), the opposite of Eq. (17)'s.
pub(super) fn double_well() -> ForcedOscillator {
    let printed = ForcedOscillator::default();
    ForcedOscillator {
        k1: -printed.k1,
        k2: -printed.k2,
        ..printed
    }
}

/// A periodic motion with stick.
#[derive(Clone, Debug, PartialEq)]
pub struct StickSlip {
    /// Number of forcing periods after which it repeats.
    pub period: usize,
    /// Lengths of its stick phases in one pattern (m), the longest first.
    pub lengths: Vec<f64>,
}

impl StickSlip {
    /// The larger of the relative differences of the two longest stick phases of two forcing
    /// periods from `published`; infinite if there are fewer than two.
    pub fn distance(&self, published: [f64; 2]) -> f64 {
        // A motion of period one has each of its stick phases twice in two periods.
        let twice = if self.period == 1 { 2 } else { 1 };
        let lengths = self.lengths.iter();
        let mut all = lengths.flat_map(|&l| std::iter::repeat_n(l, twice));
        match (all.next(), all.next()) {
            (Some(first), Some(second)) => {
                let pairs = [(first, published[0]), (second, published[1])];
                largest(pairs.map(|(length, published)| (length / published - 1.0).abs()))
            }
            _ => f64::INFINITY,
        }
    }

    /// Whether two starts lead to the same motion: its lengths agree in the printed digits.
    pub(super) fn is_same(&self, other: &StickSlip) -> bool {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= LAST_DIGIT;
        self.period == other.period
            && self.lengths.len() == other.lengths.len()
            && self.lengths.iter().zip(&other.lengths).all(near)
    }
}

/// Forcing periods over which a start is integrated: 1.5 times the length of the listing's run.
pub(in crate::report) const PERIODS_FOLLOWED: usize = 60;
/// Largest difference of equal states one pattern apart: a tenth of a printed digit.
pub(in crate::report) const CLOSENESS: f64 = LAST_DIGIT / 10.0;

/// The attractors of all starts at one set of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterPoint {
    /// Factor by which the printed value is multiplied.
    pub factor: f64,
    /// The value.
    pub value: f64,
    /// Number of starts in each class, in the order of [`StartClass::ALL`].
    pub counts: [usize; 5],
    /// The distinct stick–slip motions.
    pub stick_slip: Vec<StickSlip>,
}

impl ParameterPoint {
    /// Integrates all starts in a model with `value` for one parameter, `factor` times the printed
    /// one.
    ///
    /// # Errors
    /// Those of [`solve`] except an escape.
    pub(in crate::report) fn compute(
        model: &ForcedOscillator,
        starts: &[State<2>],
        factor: f64,
        value: f64,
    ) -> Result<ParameterPoint, Error> {
        // A spring that pulls back for large stretches lets no body escape at any speed.
        let pushes_out = model.k2 > 0.0;
        let options = Options::tol(SETTLING_TOLERANCE)
            .escape(if pushes_out { ESCAPE } else { DIVERGED })
            .at_repelling(AtRepelling::GoAbove);
        let mut counts = [0; 5];
        let mut stick_slip: Vec<StickSlip> = Vec::new();
        for &x in starts {
            let end = settled(model, x, &options)?;
            let class = match end {
                Destination::Escapes { .. } => StartClass::Escape,
                Destination::Unsettled => StartClass::Unsettled,
                Destination::Periodic { sticks: 0, .. } => StartClass::SlipOnly,
                Destination::Periodic { period, x, sticks } => {
                    let motion = StickSlip {
                        period,
                        lengths: lengths(model, &x, period, &options)?,
                    };
                    if !stick_slip.iter().any(|other| other.is_same(&motion)) {
                        stick_slip.push(motion);
                    }
                    if two_periodic(sticks, period) {
                        StartClass::StickSlipTwo
                    } else {
                        StartClass::StickSlip
                    }
                }
            };
            counts[class as usize] += 1;
        }
        Ok(ParameterPoint {
            factor,
            value,
            counts,
            stick_slip,
        })
    }

    /// Number of starts that lead to stick–slip.
    pub fn sticking(&self) -> usize {
        let [_, _, other, two, _] = self.counts;
        other + two
    }

    /// The stick–slip motion nearest to the published lengths among those that `allowed` accepts,
    /// and its distance.
    pub fn nearest(
        &self,
        published: [f64; 2],
        allowed: impl Fn(&StickSlip) -> bool,
    ) -> Option<(&StickSlip, f64)> {
        let motions = self.stick_slip.iter().filter(|motion| allowed(motion));
        let distances = motions.map(|motion| (motion, motion.distance(published)));
        distances.min_by(|one, other| one.1.total_cmp(&other.1))
    }
}

/// The attractor of a start. A motion with stick is integrated further: slow convergence to a
/// motion of half the period can look like twice the period.
fn settled(model: &ForcedOscillator, x: State<2>, options: &Options) -> Result<Destination, Error> {
    // Friction of the other sign is among the variants.
    let (system, period) = (Unchecked(model), model.period());
    let follow = |x: &Vector, periods, closeness| {
        destination(&system, (0.0, x), period, periods, closeness, options)
    };
    match follow(&x.vector(), PERIODS_FOLLOWED, CLOSENESS)? {
        Destination::Periodic { sticks, x, .. } if sticks > 0 => {
            follow(&x, 4 * PERIODS_FOLLOWED, 0.1 * CLOSENESS)
        }
        end => Ok(end),
    }
}

/// Lengths of the stick phases that end within one pattern of a periodic motion (m), the longest
/// first.
fn lengths(
    model: &ForcedOscillator,
    x: &Vector,
    period: usize,
    options: &Options,
) -> Result<Vec<f64>, Error> {
    let pattern = period as f64 * model.period();
    // A phase in progress when the first pattern begins is complete in the second.
    let orbit = solve(&Unchecked(model), 0.0, x, 2.0 * pattern, options)?;
    let exits = stick_exits(&orbit).filter(|(at, ..)| at.t > pattern);
    let mut lengths: Vec<f64> = exits.map(|(.., phase)| phase.displacement()[0]).collect();
    lengths.sort_by(|one, other| other.total_cmp(one));
    Ok(lengths)
}
