//! Whether the stated model of Fig. 8 has a stick–slip attractor near the printed parameters.

use rayon::prelude::*;

use crate::analysis::{Destination, destination};
use crate::error::Error;
use crate::filippov::{AtRepelling, Options, TransitionKind, solve};
use crate::math;
use crate::models::ForcedOscillator;
use crate::system::{Mode, State};

/// A parameter of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// m
    Mass,
    /// vp
    BeltSpeed,
    /// μ0
    Mu0,
    /// A
    Amplitude,
    /// ω
    Omega,
    /// k1
    K1,
    /// k2
    K2,
    /// δ
    Delta,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Parameter; 8] = [
        Parameter::Mass,
        Parameter::BeltSpeed,
        Parameter::Mu0,
        Parameter::Amplitude,
        Parameter::Omega,
        Parameter::K1,
        Parameter::K2,
        Parameter::Delta,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Mass => "m",
            Parameter::BeltSpeed => "vp",
            Parameter::Mu0 => "mu0",
            Parameter::Amplitude => "A",
            Parameter::Omega => "omega",
            Parameter::K1 => "k1",
            Parameter::K2 => "k2",
            Parameter::Delta => "delta",
        }
    }

    fn of(self, model: &mut ForcedOscillator) -> &mut f64 {
        match self {
            Parameter::Mass => &mut model.mass,
            Parameter::BeltSpeed => &mut model.belt_speed,
            Parameter::Mu0 => &mut model.mu0,
            Parameter::Amplitude => &mut model.amplitude,
            Parameter::Omega => &mut model.omega,
            Parameter::K1 => &mut model.k1,
            Parameter::K2 => &mut model.k2,
            Parameter::Delta => &mut model.delta,
        }
    }

    /// The printed model with this parameter multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> ForcedOscillator {
        let mut model = ForcedOscillator::default();
        *self.of(&mut model) *= factor;
        model
    }
}

/// What a start leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Out of the spring's reach.
    Escape,
    /// Periodic without stick.
    SlipOnly,
    /// Periodic with stick in each forcing period or with a period other than two.
    StickSlip,
    /// Periodic with stick, repeating after two forcing periods and not after one, as published.
    StickSlipTwo,
    /// Nothing repeats within eight forcing periods.
    Unsettled,
}

impl Class {
    /// All of them, in the order of the table's columns.
    pub const ALL: [Class; 5] = [
        Class::Escape,
        Class::SlipOnly,
        Class::StickSlip,
        Class::StickSlipTwo,
        Class::Unsettled,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Class::Escape => "escapes",
            Class::SlipOnly => "slip_only",
            Class::StickSlip => "stick_slip_other",
            Class::StickSlipTwo => "stick_slip_period_two",
            Class::Unsettled => "unsettled",
        }
    }
}

/// A periodic motion with stick.
#[derive(Clone, Debug, PartialEq)]
pub struct StickSlip {
    /// Forcing periods after which it repeats.
    pub period: usize,
    /// Lengths of its stick phases in one pattern (m), the longest first.
    pub lengths: Vec<f64>,
}

impl StickSlip {
    /// Larger of the relative differences of the two longest stick phases of two forcing periods from `published`; infinite where
    /// there are not two.
    pub fn distance(&self, published: [f64; 2]) -> f64 {
        // A motion of period one has each of its stick phases twice in two periods.
        let twice = if self.period == 1 { 2 } else { 1 };
        let mut all = self
            .lengths
            .iter()
            .flat_map(|&l| std::iter::repeat_n(l, twice));
        match (all.next(), all.next()) {
            (Some(first), Some(second)) => [(first, published[0]), (second, published[1])]
                .map(|(found, wanted)| (found / wanted - 1.0).abs())
                .into_iter()
                .fold(0.0, f64::max),
            _ => f64::INFINITY,
        }
    }
}

/// What becomes of all starts at one set of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Factor that the printed value is multiplied by.
    pub factor: f64,
    /// The value.
    pub value: f64,
    /// How many starts lead to each class, in the order of [`Class::ALL`].
    pub counts: [usize; 5],
    /// The stick–slip motions found, each once.
    pub stick_slip: Vec<StickSlip>,
}

impl Point {
    /// Of the stick–slip motions the one nearest to the published lengths that `allowed` lets pass, and its distance.
    pub fn nearest(
        &self,
        published: [f64; 2],
        allowed: impl Fn(&StickSlip) -> bool,
    ) -> Option<(&StickSlip, f64)> {
        self.stick_slip
            .iter()
            .filter(|motion| allowed(motion))
            .map(|motion| (motion, motion.distance(published)))
            .min_by(|one, other| one.1.total_cmp(&other.1))
    }
}

/// One parameter over a factor of two either way.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Which.
    pub parameter: Parameter,
    /// In ascending order.
    pub points: Vec<Point>,
}

/// The scan of starts and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Starts at each set of parameters.
    pub starts: usize,
    /// Published lengths of the two stick phases (m).
    pub published: [f64; 2],
    /// One line for each parameter.
    pub lines: Vec<Line>,
    /// The printed parameters under other readings of the equations, by name.
    pub variants: Vec<(&'static str, Point)>,
}

/// A motion found by the scan, and where.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// The parameter that was changed.
    pub parameter: Parameter,
    /// The point.
    pub point: &'a Point,
    /// The motion.
    pub motion: &'a StickSlip,
    /// Larger relative difference of its two lengths from the published ones.
    pub distance: f64,
}

/// Values of a parameter, the printed one in the middle.
const VALUES: usize = 33;
/// Positions of the starts, in units of √(k1/k2), beyond which the spring drives bodies away; symmetrical.
const POSITIONS: usize = 9;
/// Their outermost.
const REACH: f64 = 1.2;
/// Velocities of the starts (m/s); the belt's speed comes on top.
const VELOCITIES: [f64; 4] = [-1.6, -0.8, 0.0, 1.2];
/// Forcing periods that a start is followed over.
const FOLLOWED: usize = 60;
/// States a pattern apart that are this near count as equal.
const CLOSENESS: f64 = 1e-5;
/// Stick phases whose lengths differ by no more are the same (m).
const SAME_LENGTH: f64 = 1e-4;
/// Beyond 10 m or 10 m/s the softening spring drives the body away for good.
const ESCAPE: f64 = 10.0;
const TOLERANCE: f64 = 1e-9;

/// Sets of parameters looked at.
pub const POINTS: usize = VALUES * Parameter::ALL.len();

impl Scan {
    /// Scans, and calls `tick` after each set of parameters.
    ///
    /// # Errors
    /// Those of [`solve`] except an escape.
    pub fn compute(published: [f64; 2], tick: &(dyn Fn() + Sync)) -> Result<Scan, Error> {
        let middle = (VALUES / 2) as f64;
        let jobs: Vec<(Parameter, f64)> = Parameter::ALL
            .into_iter()
            .flat_map(|parameter| {
                (0..VALUES).map(move |k| {
                    let factor = math::pow(2.0, (k as f64 - middle) / middle);
                    (parameter, factor)
                })
            })
            .collect();
        let mut points = jobs
            .par_iter()
            .map(|&(parameter, factor)| {
                let mut model = parameter.scaled(factor).checked()?;
                let value = *parameter.of(&mut model);
                let point = point(&model, &starts(&model)?, factor, value)?;
                tick();
                Ok(point)
            })
            .collect::<Result<Vec<Point>, Error>>()?
            .into_iter();
        Ok(Scan {
            variants: variants()?,
            starts: starts(&ForcedOscillator::default())?.len(),
            published,
            lines: Parameter::ALL
                .into_iter()
                .map(|parameter| Line {
                    parameter,
                    points: points.by_ref().take(VALUES).collect(),
                })
                .collect(),
        })
    }

    /// The point with the printed parameters.
    pub fn printed(&self) -> Option<&Point> {
        self.lines.first()?.points.get(VALUES / 2)
    }

    /// The stick–slip motion nearest to the published lengths among those that `allowed` lets pass.
    pub fn nearest(&self, allowed: impl Fn(&StickSlip) -> bool) -> Option<Found<'_>> {
        let of_line = |line: &'_ Line| -> Option<(Parameter, usize, f64)> {
            let of_point = |(k, point): (usize, &Point)| {
                let (_, distance) = point.nearest(self.published, &allowed)?;
                Some((line.parameter, k, distance))
            };
            let all = line.points.iter().enumerate().filter_map(of_point);
            all.min_by(|one, other| one.2.total_cmp(&other.2))
        };
        let (parameter, k, _) = self
            .lines
            .iter()
            .filter_map(of_line)
            .min_by(|one, other| one.2.total_cmp(&other.2))?;
        let line = self.lines.iter().find(|line| line.parameter == parameter)?;
        let point = line.points.get(k)?;
        let (motion, distance) = point.nearest(self.published, &allowed)?;
        Some(Found {
            parameter,
            point,
            motion,
            distance,
        })
    }

    /// For each parameter the factors at which stick–slip of period two is found.
    pub fn period_two(&self) -> Vec<(Parameter, Vec<f64>)> {
        let has = |point: &&Point| point.stick_slip.iter().any(|motion| motion.period == 2);
        let factors = |line: &Line| line.points.iter().filter(has).map(|p| p.factor).collect();
        self.lines
            .iter()
            .map(|line| (line.parameter, factors(line)))
            .collect()
    }

    /// The answer in words.
    pub fn sentence(&self) -> String {
        let Some(printed) = self.printed() else {
            return "Nothing was scanned.".into();
        };
        let [escape, slip_only, other, two, unsettled] = printed.counts;
        let mut text = format!(
            "At the printed parameters {} of {} starts lead to a stick–slip motion ({slip_only} slip only, {escape} escape, {unsettled} \
             unsettled).",
            other + two,
            self.starts
        );
        let ranges: Vec<String> = self
            .period_two()
            .into_iter()
            .filter_map(|(parameter, factors)| {
                let (first, last) = (factors.first()?, factors.last()?);
                Some(format!(
                    "{} (at {} of {VALUES} factors, from {first:.3} to {last:.3})",
                    parameter.name(),
                    factors.len()
                ))
            })
            .collect();
        text += &if ranges.is_empty() {
            " Changing one parameter by up to a factor of two, no stick–slip of period two appears."
                .to_owned()
        } else {
            format!(
                " Changing one parameter by up to a factor of two ({VALUES} factors, {:.1} % apart; narrower windows would be missed), stick–slip of \
                 period two appears for {}.",
                100.0 * (math::pow(4.0, 1.0 / (VALUES - 1) as f64) - 1.0),
                ranges.join(", ")
            )
        };
        for (what, found) in [
            ("of period two", self.nearest(|motion| motion.period == 2)),
            ("of any period", self.nearest(|_| true)),
        ] {
            if let Some(found) = found {
                let lengths: Vec<String> = found
                    .motion
                    .lengths
                    .iter()
                    .take(2)
                    .map(|l| format!("{l:.4}"))
                    .collect();
                let off = if found.distance.is_finite() {
                    format!("off by {:.0} %", 100.0 * found.distance)
                } else {
                    "where two are published".to_owned()
                };
                text += &format!(
                    " Nearest {what}: {} x {:.3}, period {}, stick phases in it {}, the longest {} m, {off}.",
                    found.parameter.name(),
                    found.point.factor,
                    found.motion.period,
                    found.motion.lengths.len(),
                    lengths.join(" and "),
                );
            }
        }
        text
    }
}

/// Starts: a grid, points on the belt, and the ends of the stick zones, of which one is the paper's start.
fn starts(model: &ForcedOscillator) -> Result<Vec<State<f64, 2>>, Error> {
    let unit = (model.k1 / model.k2).sqrt();
    let speeds = || VELOCITIES.into_iter().chain([model.belt_speed]);
    let middle = (POSITIONS / 2) as f64;
    let mut all: Vec<State<f64, 2>> = (0..POSITIONS)
        .map(|k| unit * REACH * (k as f64 - middle) / middle)
        .flat_map(|x1| speeds().map(move |x2| State::from([x1, x2])))
        .collect();
    for (lower, upper) in model.stick_zones()? {
        all.extend([lower, upper].map(|z| State::from([z, model.belt_speed])));
    }
    Ok(all)
}

/// The model as Eq. (17) prints it, with friction that drives slip on (it has the sign of a negative `mu0` here; where a
/// start could go either way it goes up), and with the spring of Eq. (4), the opposite of Eq. (17)'s.
fn variants() -> Result<Vec<(&'static str, Point)>, Error> {
    let printed = ForcedOscillator::default();
    let starts = starts(&printed)?;
    let reversed = ForcedOscillator {
        mu0: -printed.mu0,
        ..printed
    };
    let double_well = ForcedOscillator {
        k1: -printed.k1,
        k2: -printed.k2,
        ..printed
    };
    Ok(vec![
        (
            "+T as Eq. (17) prints it",
            point(&reversed, &starts, 1.0, reversed.mu0)?,
        ),
        (
            "spring of Eq. (4)",
            point(&double_well, &starts, 1.0, double_well.k1)?,
        ),
    ])
}

fn point(
    model: &ForcedOscillator,
    starts: &[State<f64, 2>],
    factor: f64,
    value: f64,
) -> Result<Point, Error> {
    // A spring that pulls back for large stretches lets nobody go, however fast.
    let pushes_out = model.k2 > 0.0;
    let options = Options::tol(TOLERANCE)
        .escape(if pushes_out { ESCAPE } else { 100.0 * ESCAPE })
        .at_repelling(AtRepelling::GoAbove);
    let mut counts = [0; 5];
    let mut stick_slip: Vec<StickSlip> = Vec::new();
    for &x in starts {
        let end = settled(model, x, &options)?;
        let class = match end {
            Destination::Escapes { .. } => Class::Escape,
            Destination::Unsettled => Class::Unsettled,
            Destination::Periodic { sticks: 0, .. } => Class::SlipOnly,
            Destination::Periodic { period, x, .. } => {
                let motion = StickSlip {
                    period,
                    lengths: lengths(model, &x, period, &options)?,
                };
                if !stick_slip.iter().any(|known| same(known, &motion)) {
                    stick_slip.push(motion);
                }
                if period == 2 {
                    Class::StickSlipTwo
                } else {
                    Class::StickSlip
                }
            }
        };
        counts[class as usize] += 1;
    }
    Ok(Point {
        factor,
        value,
        counts,
        stick_slip,
    })
}

/// Where a start ends up. A motion with stick is followed on, for one that comes near its neighbour of half the period slowly is
/// easily taken for one of twice the period.
fn settled(
    model: &ForcedOscillator,
    x: State<f64, 2>,
    options: &Options,
) -> Result<Destination<2>, Error> {
    let follow = |x, periods, closeness| {
        destination(model, (0.0, x), model.period(), periods, closeness, options)
    };
    match follow(x, FOLLOWED, CLOSENESS)? {
        Destination::Periodic { sticks, x, .. } if sticks > 0 => {
            follow(x, 4 * FOLLOWED, 0.1 * CLOSENESS)
        }
        end => Ok(end),
    }
}

fn same(one: &StickSlip, other: &StickSlip) -> bool {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_LENGTH;
    one.period == other.period
        && one.lengths.len() == other.lengths.len()
        && one.lengths.iter().zip(&other.lengths).all(near)
}

/// Lengths of the stick phases that end within one pattern of a periodic motion (m), the longest first.
fn lengths(
    model: &ForcedOscillator,
    x: &State<f64, 2>,
    period: usize,
    options: &Options,
) -> Result<Vec<f64>, Error> {
    let pattern = period as f64 * model.period();
    // A phase that has begun when the first pattern begins is whole in the second.
    let orbit = solve(model, 0.0, *x, 2.0 * pattern, options)?;
    let exits = orbit
        .transitions
        .iter()
        .filter(|at| at.kind == TransitionKind::StickExit);
    let ends: Vec<f64> = exits.map(|at| at.t).filter(|&t| t > pattern).collect();
    let mut lengths: Vec<f64> = orbit
        .phases
        .iter()
        .filter(|phase| phase.mode == Mode::Stick && ends.contains(&phase.t_end))
        .map(|phase| phase.displacement()[0])
        .collect();
    lengths.sort_by(|one, other| other.total_cmp(one));
    Ok(lengths)
}
