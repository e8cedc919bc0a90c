//! Records of runs.

use std::ops::ControlFlow;

use stickslip::dynamics::{Section, Summary, Transition};
use stickslip::{Method, Options, TransitionKind};
use stickslip_kernels::file::Source;
use stickslip_kernels::file::System;
use stickslip_kernels::file::SystemFile;
use stickslip_kernels::kernel::{Run, Watcher, follow};

/// A transition: kind, contact, time and state.
pub type Event = (TransitionKind, usize, f64, Vec<f64>);

/// The transitions of a run.
#[derive(Default)]
pub struct Events(pub Vec<Event>);

impl Watcher for Events {
    fn transition(&mut self, at: Transition) -> ControlFlow<()> {
        self.0
            .push((at.kind, at.contact, at.t, at.x.as_slice().to_vec()));
        ControlFlow::Continue(())
    }
}

/// A shipped model, or a file.
pub fn open(file: &str) -> System {
    let read = SystemFile::open(file).unwrap_or_else(|error| panic!("{error}"));
    read.with(&[]).unwrap()
}

/// A system from the text of a file.
pub fn read(text: &str) -> System {
    let source = Source {
        name: "test.toml".to_owned(),
        text: text.to_owned(),
    };
    let file = SystemFile::parse(source).unwrap_or_else(|error| panic!("{error}"));
    file.with(&[]).unwrap()
}

/// Both methods with adaptive steps.
pub fn methods() -> [Options; 2] {
    [Method::Taylor, Method::Dop853].map(|method| Options::tol(1e-13).method(method))
}

/// A run from the start in the file.
pub fn run(system: &System, t_end: f64, options: &Options) -> (Summary, Vec<Event>) {
    let x = system.start().expect("the file has a start");
    let run = Run {
        t: system.built.t_start,
        x: &x,
        t_end,
        options,
    };
    let mut events = Events::default();
    let ended = follow(system.dynamics(), &run, &Section::None, &mut events).unwrap();
    (ended, events.0)
}
