//! Every failure, with the values that explain it.

use std::fmt;

pub use crate::contact_fault::ContactFault;
use crate::ode::Timed;

/// A state as it appears in a message.
#[derive(Clone, PartialEq)]
pub struct Point(pub Vec<f64>);

impl fmt::Debug for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "(")?;
        for (i, v) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{}", readable(*v))?;
        }
        write!(f, ")")
    }
}

impl<const N: usize> From<&crate::system::State<N>> for Point {
    fn from(x: &crate::system::State<N>) -> Self {
        Point(x.iter().copied().collect())
    }
}

/// The point where infinitely many transitions accumulate, extrapolated from the last of them,
/// whose phases are a geometric series.
#[derive(Clone, Debug, PartialEq)]
pub struct Accumulation {
    /// Time.
    pub t: f64,
    /// Uncertainty of that time by two rounds of transitions and by rounding. It does not include
    /// the errors of earlier steps.
    pub uncertainty: f64,
    /// State.
    pub x: Point,
    /// Mean ratio of successive durations.
    pub ratio: f64,
    /// Whether friction can hold all contacts that pile up there at once.
    pub holds: bool,
}

impl Accumulation {
    /// A pile-up within a span of time, in words; `option` is the name of
    /// [`crate::Options::at_pile_up`].
    pub fn in_words(accumulation: Option<&Accumulation>, span: f64, option: &str) -> String {
        if span == 0.0 {
            return "they set each other off at once, without end; a jump must lead to where \
                    neither it nor another one happens again"
                .to_owned();
        }
        let Some(Accumulation {
            t,
            uncertainty,
            x,
            ratio,
            holds,
        }) = accumulation
        else {
            return "they pile up (Zeno), by no ratio that would tell the accumulation point"
                .to_owned();
        };
        let what_follows = if *holds {
            format!("friction can hold all of them, and by {option} they rest")
        } else {
            "nothing holds all of them at once, and nothing says what follows".to_owned()
        };
        format!(
            "they pile up (Zeno), each phase {ratio:.6} times as long as the one before; at the \
             accumulation point, t = {t:?} ± {uncertainty:.1e}, x = {x}, {what_follows}"
        )
    }
}

/// Every failure of the library's computations.
///
/// With the feature `serde` it is written to a file in words, and read as [`Error::Recorded`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A model parameter is not allowed.
    #[error("parameter {name} = {} is not allowed: it must be {bound}", readable(*value))]
    Parameter {
        /// Name as in the model's struct.
        name: &'static str,
        /// Value given.
        value: f64,
        /// Allowed values, in words.
        bound: &'static str,
    },
    /// A setting of the solver is not allowed.
    #[error("option {name} = {} is not allowed: it must be {bound}", readable(*value))]
    Option {
        /// Name as in [`crate::Options`].
        name: &'static str,
        /// Value given.
        value: f64,
        /// Allowed values, in words.
        bound: &'static str,
    },
    /// The states and their absolute tolerances are not as many.
    #[error(
        "atol has {given} values, and there are {states} states: give one for each, in their \
            order, or one number for all"
    )]
    Tolerances {
        /// Number of values given.
        given: usize,
        /// Number of states.
        states: usize,
    },
    /// The end time does not lie after the start, or one of them is not a number.
    #[error(
        "cannot integrate from t = {t0} to t = {t_end}: both must be finite and the end later than \
            the start", t0 = readable(*t0), t_end = readable(*t_end)
    )]
    Interval {
        /// Start time.
        t0: f64,
        /// End time.
        t_end: f64,
    },
    /// The start lies where the system is not defined.
    #[error(
        "cannot start at t = {t}, x = {x}: {what}; start elsewhere, or look for a parameter that \
            is not a number", t = readable(*t)
    )]
    StartOutsideDomain {
        /// Start time.
        t: f64,
        /// Start state.
        x: Point,
        /// Function, in words.
        what: &'static str,
    },
    /// The state lies behind a stop, at a start or after a jump.
    #[error(
        "the gap of the stop {number} is {} at t = {t}, x = {x}, but must not be negative; start \
            in front of the stop, or let no jump lead behind it", readable(*gap), t = readable(*t)
    )]
    BehindStop {
        /// Number of the stop's impact, counted from the contacts through the jumps.
        number: usize,
        /// Gap of the stop.
        gap: f64,
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// The gap of a stop is not continuous along the orbit, and negative behind the place.
    #[error(
        "the gap of the stop {number} jumps to or from {} at t = {t}, x = {x}; a gap must be \
            continuous wherever the orbit comes: atan2 jumps where its second number is negative \
            and its first changes sign", readable(*gap), t = readable(*t)
    )]
    GapJumps {
        /// Number of the stop's impact, counted from the contacts through the jumps.
        number: usize,
        /// Gap of the stop near the place.
        gap: f64,
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// A stop carries at a start, and the state is not on it.
    #[error(
        "the stop {number} carries at t = {t}, x = {x}, but its gap or the rate of that is {} and \
            not zero; start on the stop, or with its discrete state at 0", readable(*off),
            t = readable(*t)
    )]
    OffStop {
        /// Number of the jump with this function, counted from the contacts through the jumps.
        number: usize,
        /// The gap, or its rate.
        off: f64,
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// The function of a jump or of a switch, or what a jump sets, is not a number.
    #[error(
        "{what} with number {number} is not a number at t = {t}, x = {x}; write it so that it is \
            defined wherever the orbit comes", t = readable(*t)
    )]
    Undefined {
        /// Undefined quantity, in words.
        what: &'static str,
        /// Number, counted from the contacts through the jumps to the inputs.
        number: usize,
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// The state became infinite or not a number.
    #[error(
        "the state stopped being finite after t = {t}, x = {x}; the field may have a pole there, \
            or the step of {step:?}, if it is fixed, may be too long", t = readable(*t)
    )]
    NonFinite {
        /// Last good time.
        t: f64,
        /// Last good state.
        x: Point,
        /// Step tried.
        step: f64,
    },
    /// The adaptive step shrank to rounding: the solution cannot be continued to the tolerance.
    #[error(
        "the step collapsed to {step:e} at t = {t}, x = {x}: the solution has a singularity there, \
            the field or the boundary or contact function is not defined beyond or overflows \
            inside, or rtol = {rtol:e}, atol = {atol:e} cannot be met; look at the system there, \
            loosen the tolerances or set an escape bound", t = readable(*t)
    )]
    StepCollapse {
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
        /// Step length that was too small.
        step: f64,
        /// Relative tolerance.
        rtol: f64,
        /// Absolute tolerance.
        atol: f64,
    },
    /// The orbit reaches a place where the field is not Lipschitz. The rate of a component vanishes
    /// as a power below 1 of its distance, and the solution beyond is not unique.
    #[error(
        "the field is not Lipschitz at t = {t}, x = {x}: its slope grows without bound on the last \
            part of the way, as of √x at 0, and no solution is the only one beyond; end the run \
            before, or write what follows as a contact", t = readable(*t)
    )]
    NotLipschitz {
        /// Time at which the orbit comes there.
        t: f64,
        /// State there.
        x: Point,
    },
    /// The field is a root of the distance from a boundary that the rules do not cover. The
    /// boundary is that of one of several contacts, or rounding does not leave the distance at
    /// zero.
    #[error(
        "the field is a root of the distance from a boundary reached at t = {t}, x = {x}, as \
            √|v| is: such a law is followed where its contact is the only one and its boundary is \
            one state, or that less a constant; make the relative velocity a state of its own, or \
            write a law with a finite slope at zero", t = readable(*t)
    )]
    RootAtBoundary {
        /// Time at which the boundary is reached.
        t: f64,
        /// State there.
        x: Point,
    },
    /// The next step is below the rounding of times, and would not move the time.
    #[error(
        "a step of {step:e} does not move the time at t = {t}, x = {x}, since times there are \
            rounded to {rounding:e}: {}begin the run nearer to time zero",
        bound.map_or_else(String::new, |name| format!("raise {name} above that, or ")),
        t = readable(*t)
    )]
    TimeRounding {
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
        /// Step length that was too small.
        step: f64,
        /// Rounding of a time there.
        rounding: f64,
        /// Name of the setting that bounds the step, as in [`crate::Options`]. Without one, the
        /// state moves by more than the tolerance within the rounding.
        bound: Option<&'static str>,
    },
    /// A run needs more steps than are allowed, however long its steps may be.
    #[error(
        "longest_step = {} takes more than {most_steps} steps to t = {}: give at least {}, end the \
            run earlier, or raise most_steps",
        readable(*longest_step), readable(*t_end), readable(*least)
    )]
    TooShortSteps {
        /// Longest step of the run.
        longest_step: f64,
        /// Least allowed value of it.
        least: f64,
        /// The most steps that are allowed.
        most_steps: u64,
        /// End of the run.
        t_end: f64,
    },
    /// A run is longer than allowed.
    #[error(
        "more than {most} {} by t = {t}, x = {x}: end the run earlier, or raise {name} if it is to \
            be that long",
        if *name == "most_events" { "transitions" } else { "steps" }, t = readable(*t)
    )]
    TooMany {
        /// Name as in [`crate::Options`].
        name: &'static str,
        /// The most that are allowed.
        most: u64,
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
    },
    /// The flag of [`crate::dynamics::Interrupt`] was raised.
    #[error(
        "the run was interrupted at t = {t}, x = {x}; start it again for a result",
        t = readable(*t)
    )]
    Interrupted {
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
    },
    /// A run goes on from the end of a run of another system.
    #[error(
        "the run that ended at t = {t} is of another system, with other states, contacts or jumps; \
            go on with the system and the options of that run"
    )]
    Memory {
        /// Time at which it ended.
        t: f64,
    },
    /// Transitions pile up (Zeno): infinitely many of them in finite time.
    #[error(
        "{count} transitions at contacts {contacts:?} within {span:e} before t = {t}, x = {x}: {}",
        Accumulation::in_words(accumulation.as_deref(), *span, "Options::at_pile_up"),
        t = readable(*t)
    )]
    EventPileUp {
        /// Transitions counted.
        count: usize,
        /// Time within which they happened.
        span: f64,
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
        /// The contacts at which they happen, counted from 0; the jumps follow them.
        contacts: Vec<usize>,
        /// Accumulation point, if the transitions are a geometric series.
        accumulation: Option<Box<Accumulation>>,
    },
    /// A field with comparisons ([`crate::Scalar::exceeds`] and what uses it) reverses where they
    /// change, and holds the orbit there as a discontinuity boundary does. Only rounding moves the
    /// orbit from one reversal to the next.
    #[error(
        "the field reversed {count} times within {span:e} before t = {t}, x = {x}: comparisons \
            in it hold the orbit where they come out otherwise; write the difference of what they \
            compare as the boundary function, with a side for each branch", t = readable(*t)
    )]
    BranchPileUp {
        /// Steps that ended where a comparison reverses the field.
        count: usize,
        /// Time within which they ended.
        span: f64,
        /// Time reached.
        t: f64,
        /// State reached.
        x: Point,
    },
    /// A component of the state passed the bound set in the options.
    #[error(
        "the orbit escaped: |x| > {bound} at t = {t}, x = {x}; raise the escape bound to follow it \
            further", t = readable(*t), bound = readable(*bound)
    )]
    Escaped {
        /// Time.
        t: f64,
        /// State.
        x: Point,
        /// The bound.
        bound: f64,
    },
    /// The motion at one or several contacts cannot continue.
    #[error("{}", fault.words(*t, x))]
    Contacts {
        /// Time.
        t: f64,
        /// State.
        x: Point,
        /// The fault.
        fault: ContactFault,
    },
    /// The orbit does not cover the time asked for.
    #[error(
        "t = {t:?} lies outside the orbit, which covers {from:?} to {to:?}; ask within it, or \
            integrate further"
    )]
    OutsideOrbit {
        /// Time asked for.
        t: f64,
        /// First time of the orbit.
        from: f64,
        /// Last time of the orbit.
        to: f64,
    },
    /// An iteration did not converge.
    #[error(
        "{what} did not converge in {iterations} iterations: residual {residual:e}, wanted \
            {wanted:e}; start nearer to the solution"
    )]
    NotConverged {
        /// Object of the search.
        what: &'static str,
        /// Iterations made.
        iterations: usize,
        /// Residual that remains.
        residual: f64,
        /// Residual that was required.
        wanted: f64,
    },
    /// A search failed on which the computation relies.
    #[error(
        "{what} was not found {}t = {t}", match *span > 0.0 {
            true => format!("within {} time units after ", readable(*span)),
            false => "at ".to_owned(),
        }, t = readable(*t)
    )]
    NotFound {
        /// Object of the search.
        what: &'static str,
        /// Time at which the search began.
        t: f64,
        /// Span of time that it followed; 0 where it followed no orbit.
        span: f64,
    },
    /// The orbit reached a repelling part of Σ, or a two-fold, so that the analysis cannot continue
    /// along it.
    #[error(
        "the orbit has no unique future after t = {t}, x = {x}: both fields lead away from the \
            boundary, or both are tangent to it (a two-fold); choose one with `at_repelling`, or \
            start elsewhere", t = readable(*t)
    )]
    NoUniqueFuture {
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// The orbit has shrunk to a point of Σ, so that nothing can be measured along it.
    #[error(
        "the orbit shrinks to the point x = {x} of the boundary, about which it goes round without \
            end (t = {t}); start elsewhere, or change a parameter", t = readable(*t)
    )]
    Shrunk {
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// A jump, a terminal event or an observer stops the orbit before the analysis has run along it
    /// for as long as it should.
    #[error(
        "the orbit stops at t = {t}, x = {x}, before the end of the time that was asked for; give \
            a shorter time, or a system that goes on there", t = readable(*t)
    )]
    Stopped {
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// The derivative of the flow does not exist or is singular.
    #[error(
        "the derivative of the flow is singular at t = {t}, x = {x}: the orbit grazes the boundary \
            or a section there, or passes along it, or two contacts come to zero in the same \
            instant, or events accumulate there, or the field has no derivative; change the start, \
            the section or a parameter a little", t = readable(*t)
    )]
    TangentSingular {
        /// Time.
        t: f64,
        /// State.
        x: Point,
    },
    /// A jump sets off another one, at which the field changes: tangent vectors have no image.
    #[error(
        "jump {jump} follows another one in the same instant at t = {t}, x = {x}, and the field \
            changes at it, so that the derivative of the flow is singular; let one jump set what \
            both set, or the second one happen later", t = readable(*t)
    )]
    ChainedJumps {
        /// Time.
        t: f64,
        /// State before the second jump.
        x: Point,
        /// The second jump; the jumps are counted after the contacts.
        jump: usize,
    },
    /// Two events come at one instant, and what follows depends on their order.
    #[error(
        "two events come at one instant, t = {t}, x = {x}, and their order decides what follows: \
            the flow has no derivative there; change the start, the time of an input or a \
            parameter a little", t = readable(*t)
    )]
    SimultaneousEvents {
        /// Time.
        t: f64,
        /// State before them.
        x: Point,
    },
    /// A comparison that decides what a jump does is between equal numbers. The orbit is at the
    /// edge of two branches, as at a graze, where tangent vectors have no image.
    #[error(
        "jump {jump} chooses between equal numbers at t = {t}, x = {x}, so that the derivative of \
            the flow is singular, as at a graze; change the start or a parameter a little",
        t = readable(*t)
    )]
    TiedChoice {
        /// Time.
        t: f64,
        /// State before the jump.
        x: Point,
        /// The jump, counted after the contacts.
        jump: usize,
    },
    /// A failure of an earlier run, in the words that were recorded of it.
    #[error("{words}")]
    Recorded {
        /// The words.
        words: String,
    },
}

#[cfg(feature = "serde")]
impl serde::Serialize for Error {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Error {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let words = String::deserialize(deserializer)?;
        Ok(Error::Recorded { words })
    }
}

/// Checks a setting of the solver or of an analysis.
pub(crate) fn require(
    is_allowed: bool,
    name: &'static str,
    value: f64,
    bound: &'static str,
) -> Result<(), Error> {
    if is_allowed {
        return Ok(());
    }
    Err(Error::Option { name, value, bound })
}

/// Significant digits of a number in a message. Rounding errors stay behind them.
const READABLE_DIGITS: usize = 12;

/// A number for messages, headings and text tables, with twelve significant digits at most. Very
/// large and very small ones have an exponent; zero has no sign.
pub fn readable(value: f64) -> String {
    let digits = READABLE_DIGITS - 1;
    let rounded: f64 = format!("{value:.digits$e}").parse().unwrap_or(value);
    if rounded == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

impl Error {
    /// The fault of contacts at a place of a run.
    pub(crate) fn at_contacts<const N: usize>(at: &Timed<N>, fault: ContactFault) -> Self {
        let (t, x) = (at.t, Point::from(&at.x));
        Error::Contacts { t, x, fault }
    }

    /// Time and state of the failure of a run.
    pub fn place(&self) -> Option<(f64, Point)> {
        let mut error = self.clone();
        error.place_mut().map(|(t, x)| (*t, x.clone()))
    }

    fn place_mut(&mut self) -> Option<(&mut f64, &mut Point)> {
        match self {
            Error::StartOutsideDomain { t, x, .. }
            | Error::Undefined { t, x, .. }
            | Error::BehindStop { t, x, .. }
            | Error::GapJumps { t, x, .. }
            | Error::OffStop { t, x, .. }
            | Error::NonFinite { t, x, .. }
            | Error::StepCollapse { t, x, .. }
            | Error::NotLipschitz { t, x }
            | Error::RootAtBoundary { t, x }
            | Error::TimeRounding { t, x, .. }
            | Error::TooMany { t, x, .. }
            | Error::Interrupted { t, x }
            | Error::EventPileUp { t, x, .. }
            | Error::BranchPileUp { t, x, .. }
            | Error::Escaped { t, x, .. }
            | Error::Contacts { t, x, .. }
            | Error::NoUniqueFuture { t, x }
            | Error::Shrunk { t, x }
            | Error::Stopped { t, x }
            | Error::ChainedJumps { t, x, .. }
            | Error::SimultaneousEvents { t, x }
            | Error::TiedChoice { t, x, .. }
            | Error::TangentSingular { t, x } => Some((t, x)),
            _ => None,
        }
    }

    /// The error with states cut to so many components. Further ones only fill up a type.
    pub(crate) fn truncated(mut self, states: usize) -> Self {
        if let Error::EventPileUp {
            accumulation: Some(accumulation),
            ..
        } = &mut self
        {
            accumulation.x.0.truncate(states);
        }
        if let Some((_, x)) = self.place_mut() {
            x.0.truncate(states);
        }
        self
    }
}
