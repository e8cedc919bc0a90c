//! Derivatives of a periodic orbit by names of parameters.

use std::ops::ControlFlow;

use stickslip::analysis::{PeriodicDerivatives, PeriodicOrbit, multipliers};
use stickslip::dynamics::{Modes, OrbitProgress, OrbitUnderWay, Phase, Vector};
use stickslip::math::modulus;
use stickslip::nalgebra::Complex;
use stickslip::{Error, Options};

use super::{DerivativeError, NoVariable, START_TIME, Variables, phases_of_period};
use crate::file::{Meaning, System};
use crate::kernel::follow;

/// Relative change of the orbit, or of the parameter, over which multipliers are differenced. It is
/// chosen: the fourth power, which is left, is about the error of a multiplier.
const STEP: f64 = 1e-3;

/// Part of a derivative by which differences over one and two steps may differ. It is chosen: for a
/// smooth multiplier they differ by about the square of the step.
const ROUGH: f64 = 1e-2;

/// Error of a multiplier over the tolerance, relative to the largest entry of the monodromy matrix.
/// It is chosen: the error of derivatives over that of states.
const ERROR_OF_MULTIPLIERS: f64 = 1e3;

/// Part of the predicted change by which the state of a neighbouring orbit may be off. It is
/// chosen: its square is what the prediction leaves.
const OFF_PREDICTION: f64 = 0.3;

/// Reason for which a multiplier has no derivative: reasons for all of one parameter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoMultiplierDerivatives {
    /// A value beside the present one cannot be set.
    #[error("{name} = {value} cannot be set: {why}")]
    Setting {
        /// Name of the parameter.
        name: String,
        /// Value, in words.
        value: String,
        /// The fault.
        why: String,
    },
    /// No orbit with the same phases was found beside.
    #[error("no orbit with the same phases was found at {name} = {value}")]
    NoOrbit {
        /// Name of the parameter.
        name: String,
        /// Value, in words.
        value: String,
    },
    /// Differences over two steps disagree.
    #[error("the multipliers are not smooth in {name} there")]
    NotSmooth {
        /// Name of the parameter.
        name: String,
    },
}

/// Derivatives of a periodic orbit by parameters.
#[derive(Clone, Debug)]
pub struct OrbitSlopes {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Derivatives of the period, the state and its extremes, with times after the origin: exact.
    pub orbit: PeriodicDerivatives,
    /// Derivatives of the multipliers by each parameter, in the order of [`multipliers`]:
    /// differences of exact orbits of fourth order. NaN where there is none.
    pub multipliers: Vec<Vec<Complex<f64>>>,
    /// Reason, for each parameter, for which the multipliers have no derivative.
    pub missing: Vec<Option<NoMultiplierDerivatives>>,
}

/// Parameters by which a periodic orbit is differentiated.
#[derive(Clone, Debug)]
pub struct OrbitVariables {
    names: Vec<String>,
    parameters: Vec<usize>,
}

impl OrbitVariables {
    /// The parameters with these names.
    ///
    /// # Errors
    /// [`NoVariable`] for the first name that is no parameter.
    pub fn named<'n>(
        system: &System,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Result<Self, NoVariable> {
        let names: Vec<&str> = names.into_iter().collect();
        let variables = Variables::named(system, names.iter().copied())?;
        let mut parameters = Vec::new();
        for name in names {
            match system.file.names.get(name) {
                Some(Meaning::Parameter(number)) => parameters.push(number),
                _ => {
                    let what = match name == START_TIME {
                        true => "the time of the start",
                        false => "a state",
                    };
                    return Err(NoVariable::new(format!(
                        "`{name}` is {what}, on which a periodic orbit does not depend: name \
                         parameters"
                    )));
                }
            }
        }
        Ok(OrbitVariables {
            names: variables.names,
            parameters,
        })
    }

    /// The derivatives of an orbit of the system. A driven one was found from a time `origin`,
    /// whole periods before. The derivatives of its state are those at that time, so that the state
    /// keeps its phase in the drive.
    ///
    /// # Errors
    /// [`DerivativeError`]; a drive without a formula of its period among them.
    pub fn of_orbit(
        &self,
        system: &System,
        (orbit, origin): (&PeriodicOrbit, f64),
        options: &Options,
    ) -> Result<OrbitSlopes, DerivativeError> {
        let is_forced = system.built.depends_on_time;
        if is_forced {
            self.check_drive(system)?;
        }
        let orbit = &PeriodicOrbit {
            t: if is_forced { origin } else { orbit.t },
            ..orbit.clone()
        };
        let values = self.parameters.iter();
        let values: Vec<f64> = values.map(|&number| system.values[number]).collect();
        let extended = system.with_states_of(&self.parameters)?;
        let found = orbit.derivatives(&extended, &values, is_forced, options)?;
        let base = Base {
            system,
            orbit,
            options,
            multipliers: multipliers(&orbit.monodromy),
            phases: phases(system, orbit, options)?,
            periods: is_forced.then(|| periods(system, orbit)).flatten(),
        };
        let (mut of_multipliers, mut missing) = (Vec::new(), Vec::new());
        for (k, (name, value)) in self.names.iter().zip(values).enumerate() {
            let slopes = ParameterDerivatives {
                name,
                value,
                period: found.period[k],
                x: found.x.column(k).into_owned(),
                step: step(value, &found, k, orbit),
            };
            let (slopes, why) = match base.multiplier_slopes(&slopes) {
                Ok(slopes) => (slopes, None),
                Err(why) => {
                    let none = Complex::new(f64::NAN, f64::NAN);
                    (vec![none; base.multipliers.len()], Some(why))
                }
            };
            of_multipliers.push(slopes);
            missing.push(why);
        }
        Ok(OrbitSlopes {
            names: self.names.clone(),
            orbit: found,
            multipliers: of_multipliers,
            missing,
        })
    }

    /// Refuses a drive without a period, and parameters that change it.
    fn check_drive(&self, system: &System) -> Result<(), DerivativeError> {
        if system.built.period.is_none() {
            return Err(DerivativeError::NoPeriod);
        }
        self.names
            .iter()
            .try_for_each(|name| check_drive(system, name))
    }
}

/// Number of periods of the drive in that of an orbit; none without a drive.
fn periods(system: &System, orbit: &PeriodicOrbit) -> Option<f64> {
    let drive = system.built.period?;
    Some((orbit.period / drive).round())
}

/// Refuses a parameter with which the drive changes its period but the period of the file does not.
fn check_drive(system: &System, name: &str) -> Result<(), DerivativeError> {
    let Ok(number) = system.file.parameter(name) else {
        return Ok(());
    };
    let value = system.values[number];
    let beside = value + STEP * if value == 0.0 { 1.0 } else { value };
    // Beyond the range of the parameter nothing is known.
    match system.with_values(&[(name, beside)]) {
        Ok(other)
            if other.is_periodic() == Some(false)
                || system.inputs_repeat() && !other.inputs_repeat() =>
        {
            let name = name.to_owned();
            Err(DerivativeError::OtherPeriod { name })
        }
        _ => Ok(()),
    }
}

/// The step of a parameter by which orbit, period and parameter change by at most [`STEP`].
fn step(value: f64, found: &PeriodicDerivatives, k: usize, orbit: &PeriodicOrbit) -> f64 {
    let extent = found
        .extremes
        .iter()
        .map(|[low, high]| high.value - low.value);
    let extent = extent.fold(0.0, f64::max);
    let relative = |slope: f64, size: f64| if size > 0.0 { slope.abs() / size } else { 0.0 };
    let of_extremes = found.extremes.iter().flatten().map(|one| one.by[k]);
    let column = found.x.column(k).into_owned();
    let of_state = column.iter().copied().chain(of_extremes);
    let changes = of_state.map(|slope| relative(slope, extent));
    let changes = changes.fold(relative(found.period[k], orbit.period), f64::max);
    let change = changes.max(relative(1.0, value.abs()));
    STEP / if change > 0.0 { change } else { 1.0 }
}

/// Modes of the phases of a periodic orbit.
fn phases(system: &System, orbit: &PeriodicOrbit, options: &Options) -> Result<Vec<Modes>, Error> {
    let mut phases: Vec<Phase> = Vec::new();
    let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
        if let OrbitProgress::PhaseEnd(phase) = progress {
            phases.push(phase);
        }
        ControlFlow::Continue(())
    };
    let (start, t_end) = ((orbit.t, orbit.x.as_slice()), orbit.t + orbit.period);
    follow(system.dynamics(), start, t_end, options, &[], &mut watcher)?;
    Ok(phases_of_period(&**system.dynamics(), &phases).0)
}

/// A parameter, its derivatives and the step of its differences.
struct ParameterDerivatives<'n> {
    name: &'n str,
    value: f64,
    period: f64,
    x: Vector,
    step: f64,
}

/// The orbit beside which others are sought.
struct Base<'s> {
    system: &'s System,
    orbit: &'s PeriodicOrbit,
    options: &'s Options,
    multipliers: Vec<Complex<f64>>,
    phases: Vec<Modes>,
    /// Number of periods of the drive, where there is one.
    periods: Option<f64>,
}

impl Base<'_> {
    /// Derivatives of the multipliers: `(8 (m₁ − m₋₁) − (m₂ − m₋₂)) / 12h`.
    fn multiplier_slopes(
        &self,
        of: &ParameterDerivatives<'_>,
    ) -> Result<Vec<Complex<f64>>, NoMultiplierDerivatives> {
        let mut all = Vec::new();
        for by in [1.0, -1.0, 2.0, -2.0] {
            all.push(self.multipliers_at(of, by * of.step)?);
        }
        let size = self.orbit.monodromy.amax().max(1.0);
        let tolerance = self.options.coarsest().max(f64::EPSILON);
        let noise = ERROR_OF_MULTIPLIERS * tolerance * size / of.step;
        let slopes = (0..self.multipliers.len()).map(|k| {
            let near = (all[0][k] - all[1][k]) / (2.0 * of.step);
            let far = (all[2][k] - all[3][k]) / (4.0 * of.step);
            let is_smooth = modulus(near - far) <= ROUGH * modulus(near) + noise;
            is_smooth.then_some((near * 4.0 - far) / 3.0)
        });
        let slopes: Option<Vec<Complex<f64>>> = slopes.collect();
        slopes.ok_or_else(|| NoMultiplierDerivatives::NotSmooth {
            name: of.name.to_owned(),
        })
    }

    /// The multipliers of the orbit with another value of a parameter, each nearest to one of this.
    fn multipliers_at(
        &self,
        of: &ParameterDerivatives<'_>,
        by: f64,
    ) -> Result<Vec<Complex<f64>>, NoMultiplierDerivatives> {
        let value = of.value + by;
        let (name, words) = (of.name.to_owned(), format!("{value}"));
        let system = match self.system.with_values(&[(of.name, value)]) {
            Ok(system) => system,
            Err(error) => {
                let why = error.to_string();
                let value = words;
                return Err(NoMultiplierDerivatives::Setting { name, value, why });
            }
        };
        let none = || NoMultiplierDerivatives::NoOrbit { name, value: words };
        let predicted = &self.orbit.x + &of.x * by;
        // The period of a drive is exact: its prediction is off by the square of the step.
        let drive = self
            .periods
            .and_then(|count| Some(count * system.built.period?));
        let period = drive.unwrap_or(self.orbit.period + of.period * by);
        let (dynamics, options) = (system.dynamics(), self.options);
        let found = match drive {
            Some(_) => PeriodicOrbit::near_forced(
                dynamics,
                self.orbit.t,
                predicted.clone(),
                period,
                options,
            ),
            None => PeriodicOrbit::near(dynamics, predicted.clone(), period, options),
        };
        let Ok(found) = found else {
            return Err(none());
        };
        let change = (&of.x * by).norm() + STEP * self.orbit.x.norm();
        let is_near = (&found.x - &predicted).norm() <= OFF_PREDICTION * change
            && (found.period - period).abs() <= OFF_PREDICTION * STEP * period;
        let phases = phases(&system, &found, options);
        if !is_near || !phases.is_ok_and(|phases| phases == self.phases) {
            return Err(none());
        }
        let mut others = multipliers(&found.monodromy);
        let nearest = self.multipliers.iter().map(|own| {
            let off = others.iter().map(|other| modulus(other - own)).enumerate();
            let nearest = off.min_by(|a, b| a.1.total_cmp(&b.1));
            nearest.map(|(k, _)| others.swap_remove(k))
        });
        let nearest: Option<Vec<Complex<f64>>> = nearest.collect();
        nearest.ok_or_else(none)
    }
}
