//! Whether the stated model of Fig. 8 has a stick–slip attractor near the printed parameters.

mod chaos;
mod class;
mod parameter;
mod point;
mod sentence;
mod starts;
mod stick_slip;
mod variants;

use rayon::prelude::*;

pub use chaos::{COUNTED, Chaos, Followed};
pub use class::Class;
pub use parameter::Parameter;
pub use point::Point;
pub use stick_slip::StickSlip;

pub(in crate::report) use starts::starts;
use variants::variants;

use stickslip::error::Error;
use stickslip::math;
use stickslip::models::ForcedOscillator;

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
    /// What starts do with the spring of Eq. (4), where none settles.
    pub chaos: Chaos,
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
/// Sets of parameters looked at.
pub const POINTS: usize = VALUES * Parameter::ALL.len();

impl Scan {
    /// Scans, and calls `tick` after each set of parameters.
    ///
    /// # Errors
    /// Those of [`stickslip::filippov::solve`] except an escape.
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
                let mut model = parameter.scaled(factor);
                let value = *parameter.of(&mut model);
                let point = Point::compute(&model, &starts(&model)?, factor, value)?;
                tick();
                Ok(point)
            })
            .collect::<Result<Vec<Point>, Error>>()?
            .into_iter();
        Ok(Scan {
            variants: variants()?,
            chaos: Chaos::compute(published)?,
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
}
