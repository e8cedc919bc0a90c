//! Records of runs.

use std::ops::ControlFlow;

use stickslip::dynamics::{OrbitProgress, OrbitUnderWay, Summary};
use stickslip::{Method, Options, TransitionKind};
use stickslip_model::file::{System, SystemFile};
use stickslip_model::kernel::follow;

/// A transition: kind, contact, time and state.
pub type Event = (TransitionKind, usize, f64, Vec<f64>);

/// A shipped model, or a file.
pub fn open(file: &str) -> System {
    let read = SystemFile::open(file).unwrap_or_else(|error| panic!("{error}"));
    read.with(&[]).unwrap()
}

/// Both methods with adaptive steps.
pub fn methods() -> [Options; 2] {
    [Method::Taylor, Method::Dop853].map(|method| Options::tol(1e-13).method(method))
}

/// A run from the start in the file.
pub fn run(system: &System, t_end: f64, options: &Options) -> (Summary, Vec<Event>) {
    let x = system.start().expect("the file has a start");
    let mut events = Vec::new();
    let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
        if let OrbitProgress::Transition(at) = progress {
            events.push((at.kind, at.contact, at.t, at.x.as_slice().to_vec()));
        }
        ControlFlow::Continue(())
    };
    let (dynamics, start) = (system.dynamics(), (system.built.t_start, &*x));
    let ended = follow(dynamics, start, t_end, options, &[], &mut watcher);
    (ended.unwrap(), events)
}
