//! Systems whose orbits can be ended from another thread.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use stickslip::dynamics::{
    Dynamics, DynamicsRef, KinkShift, Listener, Modes, Moment, OrbitProgress, OrbitUnderWay, Phase,
    Reset, Section, SmoothFlow, Solution, Step, Transition, Vector,
};
use stickslip::orbit::Counters;
use stickslip::{Error, Options};

/// Ends the orbits of every system that [`crate::file::System::stoppable`] made with it.
#[derive(Debug, Default)]
pub struct Stop {
    is_raised: AtomicBool,
    /// Bits of the time that the last step has reached. It is kept on request only, because writing
    /// it slows down runs on many threads.
    time: Option<AtomicU64>,
}

impl Stop {
    /// A stop that keeps the time.
    pub fn with_time() -> Self {
        Stop {
            time: Some(AtomicU64::new(f64::NEG_INFINITY.to_bits())),
            ..Stop::default()
        }
    }

    /// Makes every further step fail.
    pub fn raise(&self) {
        self.is_raised.store(true, Ordering::Relaxed);
    }

    /// Whether it was raised.
    pub fn is_raised(&self) -> bool {
        self.is_raised.load(Ordering::Relaxed)
    }

    fn note_time(&self, t: f64) {
        if let Some(time) = &self.time {
            time.store(t.to_bits(), Ordering::Relaxed);
        }
    }

    /// The time that the last step has reached, if it is kept.
    pub fn time(&self) -> f64 {
        let time = self.time.as_ref().map(|time| time.load(Ordering::Relaxed));
        time.map_or(f64::NEG_INFINITY, f64::from_bits)
    }
}

/// The system, with orbits that end when `stop` is raised.
pub(crate) fn stoppable(
    system: DynamicsRef<'static>,
    stop: Option<&Arc<Stop>>,
) -> DynamicsRef<'static> {
    match stop {
        None => system,
        Some(stop) => DynamicsRef::Owned(Box::new(Stoppable {
            system,
            stop: stop.clone(),
        })),
    }
}

struct Stoppable {
    system: DynamicsRef<'static>,
    stop: Arc<Stop>,
}

impl Stoppable {
    fn orbit<'a>(
        &'a self,
        begun: Result<Box<dyn OrbitUnderWay + 'a>, Error>,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        Ok(Box::new(StoppableOrbit {
            orbit: begun?,
            stop: &self.stop,
        }))
    }
}

impl Dynamics for Stoppable {
    fn states(&self) -> usize {
        self.system.states()
    }

    fn contacts(&self) -> usize {
        self.system.contacts()
    }

    fn begin<'a>(
        &'a self,
        start: &Moment,
        t_end: f64,
        options: &Options,
        section: &Section,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.orbit(self.system.begin(start, t_end, options, section))
    }

    fn follow_all(
        &self,
        starts: &[Moment],
        t_end: f64,
        options: &Options,
        section: &Section,
        listener: &mut Listener<'_>,
    ) -> Vec<Result<(), Error>> {
        let listener = &mut |number, progress, orbit: &mut dyn OrbitUnderWay| {
            let stopped = self.stop.is_raised().then(|| stopped(&orbit.now()));
            self.stop.note_time(orbit.t());
            let is_stopped = stopped.is_some();
            match listener(number, stopped.map_or(progress, Err), orbit) {
                ControlFlow::Continue(()) if !is_stopped => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let system = &self.system;
        system.follow_all(starts, t_end, options, section, listener)
    }

    fn begin_in<'a>(
        &'a self,
        mode: (Modes, &Moment),
        start: &Moment,
        t_end: f64,
        options: &Options,
    ) -> Result<Box<dyn OrbitUnderWay + 'a>, Error> {
        self.orbit(self.system.begin_in(mode, start, t_end, options))
    }

    fn flow<'a>(&'a self, mode: Modes, at: &Moment) -> Box<dyn SmoothFlow + 'a> {
        self.system.flow(mode, at)
    }

    fn mode_by_side(&self, at: &Moment) -> Modes {
        self.system.mode_by_side(at)
    }

    fn normals(&self, mode: Modes, at: &Moment) -> Vec<(usize, Vector)> {
        self.system.normals(mode, at)
    }

    fn discontinuity_guard(&self, at: &Transition) -> Option<usize> {
        self.system.discontinuity_guard(at)
    }

    fn is_one_at_a_time(&self, at: &Transition) -> bool {
        self.system.is_one_at_a_time(at)
    }

    fn undecided(&self) -> Modes {
        self.system.undecided()
    }

    fn jumps(&self) -> usize {
        self.system.jumps()
    }

    fn is_discrete(&self, state: usize) -> bool {
        self.system.is_discrete(state)
    }

    fn is_constant_between_jumps(&self, state: usize) -> bool {
        self.system.is_constant_between_jumps(state)
    }

    fn kink(&self, at: &Moment) -> Option<usize> {
        self.system.kink(at)
    }

    fn kink_shifts(&self, step: &Step) -> Vec<KinkShift> {
        self.system.kink_shifts(step)
    }

    fn clock(&self, input: usize, at: &Moment) -> (f64, Vector, f64) {
        self.system.clock(input, at)
    }

    fn reset(&self, number: usize, at: &Moment) -> Reset {
        self.system.reset(number, at)
    }

    fn section_gradient(&self, section: &Section, at: &Moment) -> (Vector, f64) {
        self.system.section_gradient(section, at)
    }
}

/// The error of an orbit that was stopped. The thread that raised the stop expects no result.
fn stopped(at: &Moment) -> Error {
    Error::TooMany {
        name: "most_steps",
        most: 0,
        t: at.t,
        x: (&at.x).into(),
    }
}

struct StoppableOrbit<'a> {
    orbit: Box<dyn OrbitUnderWay + 'a>,
    stop: &'a Stop,
}

impl OrbitUnderWay for StoppableOrbit<'_> {
    fn step(&mut self) -> Result<OrbitProgress, Error> {
        if self.stop.is_raised() {
            return Err(stopped(&self.orbit.now()));
        }
        let progress = self.orbit.step();
        self.stop.note_time(self.orbit.t());
        progress
    }

    fn watch(&mut self, section: &Section) {
        self.orbit.watch(section);
    }

    fn t(&self) -> f64 {
        self.orbit.t()
    }

    fn x(&self) -> &[f64] {
        self.orbit.x()
    }

    fn mode(&self) -> Modes {
        self.orbit.mode()
    }

    fn phase(&self) -> Option<Phase> {
        self.orbit.phase()
    }

    fn counters(&self) -> Counters {
        self.orbit.counters()
    }

    fn last_step(&mut self) -> Step {
        self.orbit.last_step()
    }

    fn solution(&mut self) -> Solution {
        self.orbit.solution()
    }
}
