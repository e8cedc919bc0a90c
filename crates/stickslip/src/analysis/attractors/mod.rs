//! The attractor that an orbit reaches, detected by recurrence.

mod attractor;
mod by_shooting;
mod distinct;
pub(super) mod equilibrium;
mod history;
mod recurrence;
mod recurrent;
mod search;
mod tolerance;
mod trap;

pub(super) use attractor::shifts;
pub use attractor::{Attractor, AttractorKind};
pub use distinct::Attractors;
pub(super) use tolerance::SOLVER_TOLERANCES;

use std::ops::ControlFlow;

use crate::dynamics::{
    AsDynamics, Components, Dynamics, Modes, Moment, OrbitUnderWay, Section, Vector, Watching,
};
use crate::error::{Error, require};
use crate::filippov::Options;
use crate::system::Mode;
use search::Search;

/// Criterion by which an orbit has reached an attractor.
///
/// Points of the section repeat with lag `p` if each of the last `p` is near the one `p` before.
/// The remaining distance to the pattern must be small as well, so that slowly creeping points are
/// no pattern. It is estimated from the ratio of two differences `p` apart. The shortest such `p`
/// is taken. One exact return to a point is enough, since its future is the same. The transitions
/// since the previous point must agree, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecurrenceSettings {
    /// Time after which the attractor counts as undecided.
    pub longest: f64,
    /// Fraction of a component's size within which two states are the same. Some hundred tolerances
    /// of the solver are added to it. Default 1e-6.
    pub closeness: f64,
    /// Longest pattern that is sought, in returns. Default 64.
    pub most_returns: usize,
    /// The period of the forcing, in a system that depends on time. The section is then a strobe,
    /// unless the user gives one. Default `None`.
    pub forcing: Option<f64>,
    /// Number of section points kept of an orbit that does not close, and required to call it
    /// recurrent. Default 400.
    pub kept: usize,
}

impl RecurrenceSettings {
    /// The defaults with this longest time.
    pub fn within(longest: f64) -> Self {
        RecurrenceSettings {
            longest,
            closeness: 1e-6,
            most_returns: 64,
            forcing: None,
            kept: 400,
        }
    }

    /// Sets the period of the forcing.
    #[must_use]
    pub fn forced(self, period: f64) -> Self {
        RecurrenceSettings {
            forcing: Some(period),
            ..self
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Option`] with name, value and bound of the first that is not allowed.
    pub fn check(&self) -> Result<(), Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let finite = "positive and finite";
        require(positive(self.longest), "longest", self.longest, finite)?;
        let near = self.closeness > 0.0 && self.closeness < 0.1;
        let near_bound = "positive and less than 0.1";
        require(near, "closeness", self.closeness, near_bound)?;
        let most = self.most_returns as f64;
        require(self.most_returns > 0, "most_returns", most, "at least 1")?;
        let kept = self.kept as f64;
        require(self.kept >= 16, "kept", kept, "at least 16")?;
        let forcing = self.forcing.unwrap_or(1.0);
        require(positive(forcing), "forcing", forcing, finite)
    }
}

/// The attractor that the orbit from `x0` at time 0 reaches. It needs neither a list of attractors
/// nor a section. Its points are the transitions of the orbit or the strobe of the forcing. For an
/// orbit that meets no boundary for long, they are the extrema of the first state.
///
/// A slipping orbit may be certain to converge to an equilibrium while still far away. A quadratic
/// Lyapunov function, whose decay is proved with intervals, shows that.
///
/// Recognising attractors by recurrence goes back to Datseris & Wagemakers, *Chaos* 32 (2022)
/// 023104; here events replace their grid.
///
/// # Errors
/// Those of [`crate::Integration::new`]; [`Error::Option`] for a setting that is not allowed. A
/// later failure is an [`AttractorKind`].
///
/// ```
#[doc = include_str!("../../../examples/common/belt.rs")]
/// use stickslip::Options;
/// use stickslip::analysis::{AttractorKind, RecurrenceSettings, attractor};
///
/// let belt = Belt { speed: 0.2 };
/// let settings = RecurrenceSettings::within(500.0);
/// let found = attractor(&belt, [0.5, 0.1], &settings, &Options::default())?;
/// assert!(matches!(found.kind, AttractorKind::Periodic { .. }));
/// for phase in &found.phases {
///     println!("{:?} for {}", phase.mode, phase.duration());
/// }
/// # Ok::<(), stickslip::Error>(())
/// ```
pub fn attractor<Kind>(
    system: &impl AsDynamics<Kind>,
    x0: impl Components,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Attractor, Error> {
    attractor_of(&*system.dynamics(), x0.vector(), settings, options)
}

impl Attractor {
    /// [`attractor`] for one start of many: a start outside the domain of the field, behind a stop
    /// or beyond the escape bound is also an [`AttractorKind`].
    ///
    /// # Errors
    /// The other errors of [`attractor`].
    pub fn of_any<Kind>(
        system: &impl AsDynamics<Kind>,
        x0: impl Components,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Attractor, Error> {
        let (system, x0) = (system.dynamics(), x0.vector());
        let found = attractor_of(&*system, x0.clone(), settings, options);
        found.or_else(|error| without_run(error, &*system, x0))
    }
}

impl Attractor {
    /// [`Attractor::of_any`] for several starts.
    ///
    /// With [`crate::Method::Taylor`], the orbits of a system from formulas are computed side by
    /// side in vectors, in a fraction of the time. Each is bit-for-bit the same as alone.
    ///
    /// # Errors
    /// Those of [`Attractor::of_any`], for the first start that fails.
    pub fn of_all<Kind>(
        system: &impl AsDynamics<Kind>,
        starts: impl IntoIterator<Item = impl Components>,
        settings: &RecurrenceSettings,
        options: &Options,
    ) -> Result<Vec<Attractor>, Error> {
        let starts: Vec<Vector> = starts.into_iter().map(Components::vector).collect();
        let go_on = &mut || ControlFlow::Continue(());
        let outcomes = attractors_of(&*system.dynamics(), &starts, settings, options, go_on)?;
        outcomes.into_iter().flatten().collect()
    }
}

/// The outcome of a start from which no run can begin, unless that is an error.
fn without_run(error: Error, system: &dyn Dynamics, x: Vector) -> Result<Attractor, Error> {
    let kind = match error {
        Error::Escaped { .. } => AttractorKind::Escape,
        Error::StartOutsideDomain { .. }
        | Error::BehindStop { .. }
        | Error::OffStop { .. }
        | Error::Undefined { .. } => AttractorKind::Failure(error),
        error => return Err(error),
    };
    Ok(Attractor {
        kind,
        period_uncertainty: 0.0,
        family: None,
        points: Vec::new(),
        phases: Vec::new(),
        transitions: Vec::new(),
        in_stick: 0.0,
        steps: 0,
        // No run has begun in which this could be an error.
        mode: Modes::new(&vec![Mode::Stick; system.contacts()]),
        t: 0.0,
        x,
    })
}

/// [`Attractor::of_all`] with a callback after each start. The callback may stop the
/// computation; a start that has no outcome yet is then left out.
pub(super) fn attractors_of(
    system: &dyn Dynamics,
    starts: &[Vector],
    settings: &RecurrenceSettings,
    options: &Options,
    after_each: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Vec<Option<Result<Attractor, Error>>>, Error> {
    settings.check()?;
    let (section, options) = section(settings, options);
    let at_zero = |x: &Vector| Moment {
        t: 0.0,
        x: x.clone(),
    };
    let moments: Vec<Moment> = starts.iter().map(at_zero).collect();
    let sections = section.as_slice();
    let search = |x| Search::new(system, x, sections, settings, &options);
    let mut searches: Vec<Search<'_>> = starts.iter().map(search).collect();
    let mut outcomes: Vec<_> = starts.iter().map(|_| None).collect();
    let mut is_enough = false;
    let listener = &mut |number: usize, progress, orbit: &mut dyn OrbitUnderWay| {
        if is_enough {
            return ControlFlow::Break(());
        }
        let Some(attractor) = searches[number].record(progress, orbit) else {
            return ControlFlow::Continue(());
        };
        is_enough = after_each().is_break();
        if !is_enough {
            outcomes[number] = Some(Ok(attractor));
        }
        ControlFlow::Break(())
    };
    let watching = Watching {
        sections,
        solutions: false,
    };
    let begun = system.follow_all(&moments, settings.longest, &options, watching, listener);
    for ((outcome, begun), x) in outcomes.iter_mut().zip(begun).zip(starts) {
        if let Err(error) = begun
            && !is_enough
        {
            *outcome = Some(without_run(error, system, x.clone()));
            is_enough = after_each().is_break();
        }
    }
    Ok(outcomes)
}

/// [`attractor`] without the types of the system and the start.
pub(super) fn attractor_of(
    system: &dyn Dynamics,
    x0: Vector,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Attractor, Error> {
    let (section, options) = section(settings, options);
    let start = Moment { t: 0.0, x: x0 };
    seek(system, section.as_slice(), start, settings, &options)
}

/// The section that gives the points of the orbits, and the options for it.
fn section(settings: &RecurrenceSettings, options: &Options) -> (Option<Section>, Options) {
    match settings.forcing {
        Some(period) => {
            // A step must not pass over two strobe times.
            let longest = options.longest_step.min(0.5 * period);
            let strobe = Section::Strobe { first: 0.0, period };
            (Some(strobe), options.longest_step(longest))
        }
        None => (None, *options),
    }
}

fn seek(
    system: &dyn Dynamics,
    sections: &[Section],
    start: Moment,
    settings: &RecurrenceSettings,
    options: &Options,
) -> Result<Attractor, Error> {
    settings.check()?;
    let t_end = start.t + settings.longest;
    let mut orbit = system.begin(&start, t_end, options, sections)?;
    let mut search = Search::new(system, &start.x, sections, settings, options);
    loop {
        let progress = orbit.step();
        if let Some(attractor) = search.record(progress, &mut *orbit) {
            return Ok(attractor);
        }
    }
}
