//! Computations that Ctrl-C ends.
//!
//! An analysis runs on threads of its own, on a system whose orbits end when they are told to. The
//! thread that Python called on looks for signals meanwhile.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use stickslip::Error;
use stickslip::Options;
use stickslip::dynamics::{
    Dynamics, DynamicsRef, Happening, KinkShift, Modes, Moment, OrbitUnderWay, Phase, Reset,
    Section, SmoothFlow, Solution, Step, Transition, Vector,
};
use stickslip::orbit::Counters;

/// How often a computation looks whether it is interrupted.
const LOOK: Duration = Duration::from_millis(50);

/// Whether a computation is to end.
#[derive(Default)]
pub(crate) struct Interrupt(AtomicBool);

impl Interrupt {
    pub(crate) fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// A system whose orbits end when the computation is to.
    pub(crate) fn guarded<'a>(&'a self, system: &'a dyn Dynamics) -> DynamicsRef<'a> {
        DynamicsRef::Owned(Box::new(Guarded {
            system,
            interrupt: self,
        }))
    }
}

/// Computes without the interpreter's lock, on as many threads as are given, 0 for all. The pool of
/// threads ends with the computation, so that a process can fork afterwards.
pub(crate) fn computed<T: Send>(
    py: Python<'_>,
    workers: usize,
    compute: impl FnOnce(&Interrupt) -> T + Send,
) -> PyResult<T> {
    let interrupt = Interrupt::default();
    let builder = rayon::ThreadPoolBuilder::new().num_threads(workers);
    let pool = builder.build().map_err(|error| {
        pyo3::exceptions::PyRuntimeError::new_err(format!("cannot start threads: {error}"))
    })?;
    let mut raised = None;
    let outcome = py.detach(|| {
        std::thread::scope(|scope| {
            let interrupt = &interrupt;
            let (done, wait) = channel();
            let computation = scope.spawn(move || {
                let outcome = pool.install(|| compute(interrupt));
                // Whoever waits sees the end of the thread, too.
                let _ = done.send(());
                outcome
            });
            while let Err(RecvTimeoutError::Timeout) = wait.recv_timeout(LOOK) {
                if raised.is_none()
                    && let Err(error) = Python::attach(|py| py.check_signals())
                {
                    raised = Some(error);
                    interrupt.0.store(true, Ordering::Relaxed);
                }
            }
            computation.join()
        })
    });
    match (raised, outcome) {
        (Some(error), _) => Err(error),
        (None, Ok(outcome)) => Ok(outcome),
        // A panic of the computation is one of this call.
        (None, Err(panic)) => std::panic::resume_unwind(panic),
    }
}

struct Guarded<'a> {
    system: &'a dyn Dynamics,
    interrupt: &'a Interrupt,
}

impl<'a> Guarded<'a> {
    fn orbit<'b>(
        &'b self,
        begun: Result<Box<dyn OrbitUnderWay + 'b>, Error>,
    ) -> Result<Box<dyn OrbitUnderWay + 'b>, Error> {
        let interrupt = self.interrupt;
        Ok(Box::new(GuardedOrbit {
            orbit: begun?,
            interrupt,
        }))
    }
}

impl Dynamics for Guarded<'_> {
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

    fn jumps_at(&self, at: &Transition) -> Option<usize> {
        self.system.jumps_at(at)
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

struct GuardedOrbit<'a> {
    orbit: Box<dyn OrbitUnderWay + 'a>,
    interrupt: &'a Interrupt,
}

impl OrbitUnderWay for GuardedOrbit<'_> {
    fn step(&mut self) -> Result<Happening, Error> {
        if self.interrupt.is_raised() {
            // Nobody is told of it: `computed` raises what has interrupted it.
            let Moment { t, x } = self.orbit.now();
            return Err(Error::TooMany {
                name: "most_steps",
                most: 0,
                t,
                x: (&x).into(),
            });
        }
        self.orbit.step()
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
