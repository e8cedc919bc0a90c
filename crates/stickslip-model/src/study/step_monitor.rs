//! Warnings from the steps of a run: that it is stiff, or that a state is far below its tolerance.

use stickslip::dynamics::Step;
use stickslip::error::readable;
use stickslip::{Options, math};

use crate::file::{Interface, System};

/// Number of steps through whose ends the next one is extrapolated.
const ENDS: usize = 4;

/// A step is smooth if extrapolation misses its end by up to this many tolerances. Where stability
/// limits the steps, their errors are up to one tolerance, of which extrapolation makes fifteen.
/// Where accuracy does, extrapolation, of order 4, misses by far more.
const SMOOTH: f64 = 100.0;

/// A run is stiff after as many smooth steps in a row.
const SMOOTH_STEPS: u32 = 1000;

/// Fewer expected steps than this take no time worth a warning.
const FEW_STEPS: f64 = 1e5;

/// A state is far below its tolerance if it stays within so many of them.
const FAR_BELOW: f64 = 10.0;

/// Watches the steps of a run.
#[derive(Clone, Debug)]
pub struct StepMonitor {
    options: Options,
    t_end: f64,
    /// Times and states at the ends of the last steps, the oldest first.
    ends: Vec<(f64, Vec<f64>)>,
    /// Number of smooth steps in a row, and the time at which they began.
    smooth: (u32, f64),
    is_told: bool,
    /// Minimum and maximum of each state over the steps. A start in stick lies beside its boundary
    /// by rounding, and the first step begins on it.
    extents: Vec<(f64, f64)>,
    /// Whether each state takes discrete values, which no tolerance concerns.
    discrete: Vec<bool>,
    /// Whether jumps end steps: a state may then be near zero at the ends of steps alone.
    has_jumps: bool,
}

impl StepMonitor {
    /// A monitor of a run from a start.
    pub fn new(system: &System, (t, x): (f64, &[f64]), t_end: f64, options: &Options) -> Self {
        StepMonitor {
            has_jumps: !system.file.jumps.is_empty(),
            options: *options,
            t_end,
            ends: vec![(t, x.to_vec())],
            smooth: (0, t),
            is_told: false,
            extents: vec![(f64::INFINITY, f64::NEG_INFINITY); x.len()],
            discrete: system
                .file
                .states
                .iter()
                .map(|state| state.is_discrete)
                .collect(),
        }
    }

    /// Whether a state seems to be far below its tolerance by the ends of steps, where impacts may
    /// have it at zero. The middles of steps then count, too.
    pub fn looks_within(&self) -> bool {
        self.has_jumps && (0..self.extents.len()).any(|state| self.is_below(state))
    }

    /// Takes a state within a step into account.
    pub fn reaches(&mut self, x: &[f64]) {
        for ((low, high), &x) in self.extents.iter_mut().zip(x) {
            (*low, *high) = (low.min(x), high.max(x));
        }
    }

    /// Whether a state moves far below its tolerance.
    fn is_below(&self, state: usize) -> bool {
        let (low, high) = self.extents[state];
        let is_discrete = self.discrete.get(state) == Some(&true);
        !is_discrete
            && low < high
            && low.abs().max(high.abs()) <= FAR_BELOW * self.options.atol.of(state)
    }

    /// Begins anew where something other than the step's own length ended it: an event or a kink.
    pub fn begin_anew(&mut self) {
        self.ends.clear();
    }

    /// Takes a step into account. Returns a warning, once, if the run is stiff. A run is stiff if
    /// stability limits its steps, and error control would allow longer ones. Then a polynomial of
    /// low degree through the ends of the last steps meets the end of this one.
    pub fn step(&mut self, step: &Step, interface: &impl Interface) -> Option<String> {
        let (t, x) = (step.t_end, step.x_end.as_slice());
        let ends = step.x_start.iter().zip(x);
        for ((low, high), (&from, &to)) in self.extents.iter_mut().zip(ends) {
            (*low, *high) = (low.min(from).min(to), high.max(from).max(to));
        }
        let is_bounded = step.t_end - step.t_start >= 0.99 * self.options.longest_step;
        if self.ends.len() < ENDS || is_bounded || !self.meets(t, x) {
            self.smooth = (0, t);
        }
        if self.ends.len() == ENDS {
            self.ends.rotate_left(1);
            let (time, state) = &mut self.ends[ENDS - 1];
            *time = t;
            state.copy_from_slice(x);
        } else {
            self.ends.push((t, x.to_vec()));
        }
        let (count, begin) = &mut self.smooth;
        *count += 1;
        if self.is_told || *count < SMOOTH_STEPS {
            return None;
        }
        let length = (t - *begin) / f64::from(*count);
        let expected = (self.t_end - t) / length;
        if expected < FEW_STEPS {
            return None;
        }
        self.is_told = true;
        Some(format!(
            "the system is stiff at t = {}: the solution is smooth, but stability limits the steps \
             to about {length:.1e}; some {expected:.0e} of them are to come. End the run earlier, \
             replace the fastest state by its equilibrium, or use an implicit solver where \
             nothing switches; {} ends a run that takes too long",
            readable(t),
            interface.name("most_steps"),
        ))
    }

    /// Whether the polynomial through the last ends meets a state to within the tolerance
    /// (Neville's scheme).
    fn meets(&self, t: f64, x: &[f64]) -> bool {
        x.iter().enumerate().all(|(i, &x)| {
            let mut p: [f64; ENDS] = std::array::from_fn(|k| self.ends[k].1[i]);
            for degree in 1..ENDS {
                for k in 0..ENDS - degree {
                    let (from, to) = (self.ends[k].0, self.ends[k + degree].0);
                    p[k] = ((t - from) * p[k + 1] - (t - to) * p[k]) / (to - from);
                }
            }
            let allowed = self.options.allowed(i, x.abs());
            (p[0] - x).abs() <= SMOOTH * allowed
        })
    }

    /// A warning for each state whose whole motion is far below its tolerance.
    pub fn below_tolerance(&self, system: &System, interface: &impl Interface) -> Vec<String> {
        let states = system.file.states.iter().zip(&self.extents).enumerate();
        let below = states.filter_map(|(i, (state, &(low, high)))| {
            let size = low.abs().max(high.abs());
            if !self.is_below(i) {
                return None;
            }
            let wanted = math::log10(self.options.rtol * size).floor() as i32;
            Some(format!(
                "the state {} stays within {size:.1e}, and its absolute tolerance is {:.0e}: its \
                 motion is not resolved; give {} 1e{wanted}, or choose a smaller unit",
                state.name,
                self.options.atol.of(i),
                interface.name("atol"),
            ))
        });
        below.collect()
    }
}
