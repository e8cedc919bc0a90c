//! Friction laws that become negative.

use std::collections::HashMap;

use stickslip::dynamics::{Modes, OrbitUnderWay};
use stickslip::error::readable;
use stickslip::{Mode, Side};

use crate::expression::Tape;
use crate::file::System;
use crate::kernel::Combination;

/// Parts of a step at whose ends the laws are evaluated. It is chosen: a step of the highest order
/// is about a quarter of a period of a harmonic.
const PARTS_OF_STEP: u32 = 4;

/// Size of a negative value that may be rounding, relative to the largest of the law so far.
const ROUNDING: f64 = 1e-9;

/// Evaluates the friction laws along an orbit, until one is negative.
pub struct FrictionWatch<'s> {
    system: &'s System,
    tapes: HashMap<Modes, Option<Tape>>,
    /// The states with what inputs hold, and the sizes: room for one evaluation.
    states: Vec<f64>,
    sizes: Vec<f64>,
    largest: Vec<f64>,
    warning: Option<String>,
}

impl<'s> FrictionWatch<'s> {
    /// A watch on a run of this system.
    pub fn new(system: &'s System) -> Self {
        FrictionWatch {
            system,
            tapes: HashMap::new(),
            states: Vec::new(),
            sizes: vec![0.0; system.contacts()],
            largest: vec![0.0; system.contacts()],
            warning: None,
        }
    }

    /// Evaluates the laws in the last step of the orbit, which keep their sides there.
    pub fn step(&mut self, orbit: &mut dyn OrbitUnderWay) {
        if self.warning.is_some() || self.largest.is_empty() {
            return;
        }
        let (system, step) = (self.system, orbit.last_step());
        let tape = self.tapes.entry(step.mode).or_insert_with(|| {
            let bits = |is: &dyn Fn(Mode) -> bool| {
                let all = 0..system.contacts();
                all.fold(0, |bits, i| bits | usize::from(is(step.mode.get(i))) << i)
            };
            system.frictions(Combination {
                above: bits(&|mode| mode == Mode::Slip(Side::Above)),
                held: bits(&|mode| mode == Mode::Stick),
            })
        });
        let Some(tape) = tape else {
            return;
        };
        let solution = orbit.solution();
        for part in 1..=PARTS_OF_STEP {
            let part = f64::from(part) / f64::from(PARTS_OF_STEP);
            let t = step.t_start + part * (step.t_end - step.t_start);
            self.states.clear();
            self.states.extend_from_slice(solution(t).as_slice());
            system.built.switching.extend(t, &mut self.states);
            tape.evaluate(t, &self.states, &mut self.sizes);
            let sizes = self.sizes.iter().enumerate();
            for ((contact, &size), largest) in sizes.zip(&mut self.largest) {
                *largest = largest.max(size.abs());
                if size < -ROUNDING * *largest {
                    self.warning = Some(negative(system, contact, t, size));
                    return;
                }
            }
        }
    }

    /// The warning of the first negative value.
    pub fn warning(self) -> Option<String> {
        self.warning
    }
}

/// The size of the friction of each contact.
fn sizes(system: &System, tape: &Tape, t: f64, x: &[f64]) -> Vec<f64> {
    let mut sizes = vec![0.0; system.contacts()];
    let x = system.built.switching.extended(t, x);
    tape.evaluate(t, &x, &mut sizes);
    sizes
}

/// The warning of a friction law that is negative at a moment, on either side of a boundary there.
pub(crate) fn negative_at(
    system: &System,
    contact: usize,
    (t, x): (f64, &[f64]),
) -> Option<String> {
    [false, true].into_iter().find_map(|is_above| {
        let above = (0..system.contacts()).fold(0, |above, i| {
            let height = system.boundary(i, t, x);
            above | usize::from(height > 0.0 || height == 0.0 && is_above) << i
        });
        let tape = system.frictions(Combination { above, held: 0 })?;
        let size = sizes(system, &tape, t, x)[contact];
        (size < 0.0).then(|| negative(system, contact, t, size))
    })
}

fn negative(system: &System, contact: usize, t: f64, size: f64) -> String {
    format!(
        "the friction of {} is negative at t = {}, {}, and drives the slip: it is a size, \
         0 or more; write max(0, …) where a force can vanish, or take other parameters",
        system.file.contacts[contact].name,
        readable(t),
        readable(size)
    )
}
