//! The edge state between two basins of attraction, by bisection and tracking.

use super::is_on_boundary;
use super::return_time::to_chord;
use crate::analysis::attractors::equilibrium::{equilibrium_near, holds};
use crate::analysis::attractors::{Attractor, Attractors, RecurrenceSettings, SOLVER_TOLERANCES};
use crate::analysis::{PeriodicOrbit, multipliers};
use crate::dynamics::{AsDynamics, Components, DynamicsRef, Modes, Moment, OrbitProgress, Vector};
use crate::error::{Error, require};
use crate::filippov::Options;
use crate::math::modulus;

/// Factor by which the two orbits may be too far apart at the end of a span of time before it is
/// halved. Chosen: farther apart, another part of the boundary may lie between them.
const MOST_APART: f64 = 10.0;

/// Factor by which a span of time grows where the orbits have stayed together. Chosen.
const GROWTH: f64 = 1.5;

/// Distance, in allowed distances of the two orbits, within which an equilibrium or a strobe point
/// is that of the track. Chosen: a track is off the boundary by about one.
const SAME_PLACE: f64 = 10.0;

/// Part of the extent of a track within which it has returned. Shooting then has a guess. Chosen.
const RETURN_PART: f64 = 0.02;

/// Longest pattern of strobe points that is sought.
const MOST_RETURNS: usize = 16;

/// Settings of a search for an edge state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeSettings {
    /// Distance to which a bisection goes, as a part of the distance of the first two states.
    /// Default 1e-8.
    pub near: f64,
    /// Distance of the two orbits at which they are bisected again, as such a part. Default 1e-5.
    pub apart: f64,
    /// Time through which the boundary is tracked.
    pub longest: f64,
}

impl EdgeSettings {
    /// The defaults with this longest time.
    pub fn within(longest: f64) -> Self {
        EdgeSettings {
            near: 1e-8,
            apart: 1e-5,
            longest,
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Option`] with name, value and bound of the first that is not allowed.
    pub fn check(&self) -> Result<(), Error> {
        let is_allowed = self.longest > 0.0 && self.longest.is_finite();
        require(is_allowed, "longest", self.longest, "positive and finite")?;
        let is_allowed = self.apart > 0.0 && self.apart < 0.1;
        require(
            is_allowed,
            "apart",
            self.apart,
            "positive and less than 0.1",
        )?;
        let is_allowed = self.near > 0.0 && self.near < self.apart;
        require(
            is_allowed,
            "near",
            self.near,
            "positive and less than apart",
        )
    }
}

/// Limit of the motion on the boundary of a basin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeKind {
    /// An equilibrium that is not stable.
    Equilibrium,
    /// A periodic orbit that is not stable.
    Periodic {
        /// Period.
        period: f64,
    },
    /// Neither was found in the time of the track.
    Undecided,
}

/// The state between two basins to which the motion on their boundary leads.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeState {
    /// Kind of motion.
    pub kind: EdgeKind,
    /// The equilibrium, a state on the periodic orbit, or the last state of the track.
    pub x: Vector,
    /// Number of unstable directions: eigenvalues with positive real parts, or multipliers outside
    /// the unit circle. It is 1 for a saddle whose stable manifold is the boundary. 0 if undecided.
    pub unstable: usize,
    /// The track along the boundary, from the first bisection on.
    pub track: Vec<Moment>,
    /// Number of bisections.
    pub bisections: usize,
    /// The attractors of states on both sides of the boundary. The second need not be that of the
    /// second state, if a third basin lies between.
    pub beside: [Attractor; 2],
}

impl EdgeState {
    /// The edge state between the basins of two states, which must lead to different attractors.
    ///
    /// The segment between them is bisected to a state on the boundary of the first one's basin.
    /// Two orbits from both sides of it follow the boundary until they are apart, and the segment
    /// between them is bisected again. In the time of the settings the track comes to an attractor
    /// of the motion within the boundary (Skufca, Yorke & Eckhardt, *Physical Review Letters* 96
    /// (2006) 174101). An equilibrium or a periodic orbit there is refined by Newton's iteration.
    ///
    /// If the segment crosses several boundaries, bisection ends at one of them, and the track is
    /// on the boundary between the first basin and whatever lies behind. In a system with a drive,
    /// states are compared at whole periods of it.
    ///
    /// ```
    /// use stickslip::analysis::{EdgeKind, EdgeSettings, EdgeState, RecurrenceSettings};
    /// use stickslip::{Filippov, Options, Scalar, Side};
    ///
    /// /// u = x - y²/3 has the rate u - u³, and y decays: x = y²/3 is the boundary of two basins.
    /// struct Wells;
    /// impl Filippov<2> for Wells {
    ///     fn field<T: Scalar>(&self, _side: Side, _t: T, &[x, y]: &[T; 2]) -> [T; 2] {
    ///         let u = x - y * y / T::constant(3.0);
    ///         [u - u * u * u - y * y * (2.0 / 3.0), -y]
    ///     }
    ///     fn boundary<T: Scalar>(&self, _t: T, _x: &[T; 2]) -> T {
    ///         T::constant(-1.0)
    ///     }
    /// }
    /// let (within, options) = (RecurrenceSettings::within(200.0), Options::default());
    /// let how = EdgeSettings::within(50.0);
    /// let found = EdgeState::between(&Wells, [0.0, 1.0], [1.0, 1.0], &how, &within, &options)?;
    /// assert!(found.kind == EdgeKind::Equilibrium && found.unstable == 1);
    /// assert!(found.x.amax() < 1e-12);
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that is not allowed, and for two states that lead to the
    /// same attractor, with their distance. Those of [`crate::analysis::Attractor::of_any`].
    pub fn between<Kind>(
        system: &impl AsDynamics<Kind>,
        one: impl Components,
        other: impl Components,
        how: &EdgeSettings,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<EdgeState, Error> {
        how.check()?;
        let (one, other) = (one.vector(), other.vector());
        let dynamics = system.dynamics();
        let system: DynamicsRef<'_> = DynamicsRef::Borrowed(&*dynamics);
        let home = Attractor::of_any(&system, &one, settings, options)?;
        let beyond = Attractor::of_any(&system, &other, settings, options)?;
        let mut distinct = Attractors::new(&system, settings, options);
        let number = distinct.number(home.clone());
        let scale = (&other - &one).norm();
        let bound = "between states that lead to different attractors";
        require(
            distinct.number(beyond.clone()) != number,
            "distance",
            scale,
            bound,
        )?;
        let mut tracking = Tracking {
            system: &system,
            settings,
            options,
            distinct,
            home: number,
            beside: [home, beyond],
            near: how.near * scale,
            apart: how.apart * scale,
            bisections: 0,
            track: Vec::new(),
        };
        let found = tracking.follow(how.longest, [one, other])?;
        let (kind, x, unstable) = found;
        Ok(EdgeState {
            kind,
            x,
            unstable,
            track: tracking.track,
            bisections: tracking.bisections,
            beside: tracking.beside,
        })
    }
}

/// Kind, state, and number of unstable directions.
type Found = (EdgeKind, Vector, usize);

/// The two states between which the boundary lies, followed in time.
struct Tracking<'a> {
    system: &'a DynamicsRef<'a>,
    settings: &'a RecurrenceSettings,
    options: &'a Options,
    distinct: Attractors<'a>,
    /// Number of the attractor of the first state.
    home: usize,
    beside: [Attractor; 2],
    near: f64,
    apart: f64,
    bisections: usize,
    track: Vec<Moment>,
}

impl Tracking<'_> {
    fn follow(&mut self, longest: f64, pair: [Vector; 2]) -> Result<Found, Error> {
        let drive = self.settings.forcing;
        let mut pair = self.bisect(pair)?;
        let mut span = drive.unwrap_or(1e-3 * longest);
        let mut t = 0.0;
        let mut next_attempt = 0.0;
        let system = self.system;
        let middle = |[one, other]: &[Vector; 2]| system.opened((one + other) * 0.5);
        self.track.push(Moment {
            t,
            x: middle(&pair),
        });
        while t < longest {
            let mut ends = Vec::new();
            let mut steps = Vec::new();
            for x in &pair {
                steps.clear();
                ends.extend(self.run(x, span, &mut steps)?);
            }
            let distance = match ends.as_slice() {
                [(one, _), (other, _)] => (other - one).norm(),
                _ => f64::INFINITY,
            };
            if drive.is_none() && distance > MOST_APART * self.apart {
                span *= 0.5;
                if t + span == t || span < f64::EPSILON * longest {
                    break;
                }
                continue;
            }
            let (Ok([one, other]), modes) = (
                <[Vector; 2]>::try_from(ends.iter().map(|end| end.0.clone()).collect::<Vec<_>>()),
                ends.iter().map(|end| end.1).collect::<Vec<_>>(),
            ) else {
                break;
            };
            let from = t;
            t += span;
            pair = [one, other];
            if drive.is_none() {
                let inside = steps.into_iter().filter(|at: &Moment| at.t < span);
                self.track.extend(inside.map(|at| Moment {
                    t: from + at.t,
                    x: at.x,
                }));
                span *= if distance > self.apart { 1.0 } else { GROWTH };
            }
            if distance > self.apart {
                pair = self.bisect(pair)?;
            }
            let at = Moment {
                t,
                x: middle(&pair),
            };
            self.track.push(at.clone());
            let found = match drive {
                Some(period) => self.strobe_pattern(&at, period)?,
                None => match self.equilibrium(&at, &modes) {
                    Some(found) => Some(found),
                    None if t >= next_attempt => {
                        let (found, later) = self.cycle(&at)?;
                        next_attempt = t + later;
                        found
                    }
                    None => None,
                },
            };
            if let Some(found) = found {
                return Ok(found);
            }
        }
        let last = self
            .track
            .last()
            .map_or_else(|| middle(&pair), |at| at.x.clone());
        Ok((EdgeKind::Undecided, last, 0))
    }

    /// The orbit from a state through a span of time: end and mode there, if it goes so far. States
    /// inside its steps are added.
    fn run(
        &self,
        x: &Vector,
        span: f64,
        states: &mut Vec<Moment>,
    ) -> Result<Option<(Vector, Modes)>, Error> {
        let start = Moment {
            t: 0.0,
            x: x.clone(),
        };
        let mut orbit = match self.system.begin(&start, span, self.options, &[]) {
            Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
            begun => match begun {
                Ok(orbit) => orbit,
                Err(_) => return Ok(None),
            },
        };
        loop {
            match orbit.step() {
                Ok(OrbitProgress::Step) => {
                    let (step, solution) = (orbit.last_step(), orbit.solution());
                    let length = step.t_end - step.t_start;
                    let inside = (1..4).map(|k| step.t_start + 0.25 * f64::from(k) * length);
                    states.extend(inside.map(|t| Moment { t, x: solution(t) }));
                    states.push(step.end());
                }
                Ok(OrbitProgress::End(end)) => {
                    let mode = orbit.mode();
                    return Ok((end.t >= span).then_some((end.x, mode)));
                }
                Ok(_) => {}
                Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
                Err(_) => return Ok(None),
            }
        }
    }

    /// Two states near each other on both sides of the boundary.
    fn bisect(&mut self, pair: [Vector; 2]) -> Result<[Vector; 2], Error> {
        // Between a state on a stop and one in front of it there is none that carries.
        let [mut one, mut other] = pair.map(|x| self.system.opened(x));
        self.bisections += 1;
        while (&other - &one).norm() > self.near {
            let middle = (&one + &other) * 0.5;
            if middle == one || middle == other {
                break;
            }
            let reached = Attractor::of_any(self.system, &middle, self.settings, self.options)?;
            if self.distinct.number(reached.clone()) == self.home {
                one = middle;
            } else {
                other = middle;
                if !is_on_boundary(&reached.kind) {
                    self.beside[1] = reached;
                }
            }
        }
        Ok([one, other])
    }

    /// The equilibrium at which the track is, if it is at one that is not stable.
    fn equilibrium(&self, at: &Moment, modes: &[Modes]) -> Option<Found> {
        let states = self.system.states();
        modes.iter().find_map(|&mode| {
            let found = equilibrium_near(&**self.system, mode, 0.0, &at.x, states)?;
            if (&found.x - &at.x).norm() > SAME_PLACE * self.apart {
                return None;
            }
            let there = Moment { t: 0.0, x: found.x };
            let values = multipliers(&found.jacobian);
            let unstable = values.iter().filter(|value| value.re > 0.0).count();
            let is_edge = unstable > 0 && holds(&**self.system, mode, &there);
            is_edge.then_some((EdgeKind::Equilibrium, there.x, unstable))
        })
    }

    /// The periodic orbit on which the track is, if it has returned, and the time to the next
    /// attempt.
    fn cycle(&self, at: &Moment) -> Result<(Option<Found>, f64), Error> {
        let extent = |k: usize| {
            let each = self.track.iter().map(|one| one.x[k]);
            let (low, high) = each.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            (high - low) * (high - low)
        };
        let extent = (0..at.x.len()).map(extent).sum::<f64>().sqrt();
        let mut nearest: Option<(f64, f64)> = None;
        let mut has_left = false;
        for (later, earlier) in self.track.iter().rev().zip(self.track.iter().rev().skip(1)) {
            let distance = to_chord(&at.x, &(earlier.x.clone(), later.x.clone()));
            has_left |= distance > 5.0 * RETURN_PART * extent;
            if !has_left {
                continue;
            }
            let is_near = distance <= RETURN_PART * extent;
            match nearest {
                None if is_near => nearest = Some((distance, at.t - 0.5 * (earlier.t + later.t))),
                Some((least, _)) if distance < least => {
                    nearest = Some((distance, at.t - 0.5 * (earlier.t + later.t)));
                }
                Some(_) if !is_near => break,
                _ => {}
            }
        }
        let Some((_, period)) = nearest else {
            return Ok((None, 0.0));
        };
        let found = match PeriodicOrbit::near(self.system, &at.x, period, self.options) {
            Ok(found) => found,
            Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
            Err(_) => return Ok((None, period)),
        };
        let unstable = unstable(&found.monodromy, self.options);
        let is_edge = (&found.x - &at.x).norm() <= RETURN_PART * extent && unstable > 0;
        let kind = EdgeKind::Periodic {
            period: found.period,
        };
        Ok((is_edge.then_some((kind, found.x, unstable)), period))
    }

    /// The periodic orbit at whose strobe points the track is.
    fn strobe_pattern(&self, at: &Moment, drive: f64) -> Result<Option<Found>, Error> {
        let before = self.track.iter().rev().skip(1).take(MOST_RETURNS);
        let is_same = |one: &Moment| (&one.x - &at.x).norm() <= SAME_PLACE * self.apart;
        let Some(returns) = before.clone().position(is_same) else {
            return Ok(None);
        };
        let period = (returns + 1) as f64 * drive;
        let found = match PeriodicOrbit::near_forced(self.system, 0.0, &at.x, period, self.options)
        {
            Ok(found) => found,
            Err(interrupted @ Error::Interrupted { .. }) => return Err(interrupted),
            Err(_) => return Ok(None),
        };
        let unstable = unstable(&found.monodromy, self.options);
        let is_edge = (&found.x - &at.x).norm() <= SAME_PLACE * self.apart && unstable > 0;
        let kind = EdgeKind::Periodic {
            period: found.period,
        };
        Ok(is_edge.then_some((kind, found.x, unstable)))
    }
}

/// Number of multipliers outside the unit circle by more than the error of two that meet on it.
fn unstable(monodromy: &crate::dynamics::Matrix, options: &Options) -> usize {
    let error = SOLVER_TOLERANCES * options.coarsest();
    let values = multipliers(monodromy);
    let outside = values
        .iter()
        .filter(|value| modulus(**value) > 1.0 + error.sqrt());
    outside.count()
}
