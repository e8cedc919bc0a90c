//! The record of a run.

use std::fmt;

use stickslip::Mode;

/// How much a pattern is shortened, in forcing periods. What happens exactly a pattern before its
/// end begins the pattern before, and a clock may jitter around that.
const PATTERN_MARGIN: f64 = 0.01;
/// Forcing periods compared at least before a pattern counts as repeating: three of the shortest
/// pattern that is published.
pub(in crate::paper) const LEAST_COMPARED: usize = 6;

/// The time (s) after which what happens belongs to the last `periods` forcing periods.
pub(in crate::paper) fn pattern_begin(end: f64, periods: usize, forcing_period: f64) -> f64 {
    end - (periods as f64 - PATTERN_MARGIN) * forcing_period
}

/// A stick zone: an interval between two neighbouring tangent points in which the body can ride the
/// belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Zone {
    /// `[T2, T1]` of Eq. (24), the listing's `k = 0`.
    Upper,
    /// `[T4, T3]`, the listing's `k = 2`.
    Middle,
    /// `[T6, T5]`, the listing's `k = 4`.
    Lower,
}

/// An end of a stick zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum End {
    /// The end with the larger displacement.
    Upper,
    /// The end with the smaller displacement.
    Lower,
}

impl Zone {
    /// The zone that holds `x1` when the forcing stands at `xs`, both in metres (lines 90–101).
    pub(super) fn holding(x1: f64, tangent_points: &[f64; 6], xs: f64) -> Option<Zone> {
        let [t1, t2, t3, t4, t5, t6] = tangent_points.map(|z| z + xs);
        // In the order of the listing, which matters where zones meet.
        let zones = [
            (Zone::Lower, t6..=t5),
            (Zone::Middle, t4..=t3),
            (Zone::Upper, t2..=t1),
        ];
        let mut zones = zones.into_iter();
        Some(zones.find(|(_, ends)| ends.contains(&x1))?.0)
    }
}

/// The resting positions of both ends, in metres.
///
/// A stick phase can start with no zone: the transition function and the comparison of
/// [`Zone::holding`] round differently at a zone's end. The listing's `k` is then −1, and `T[-1]`
/// is the last tangent point (its neighbour `T[k+1]`, read only with the mended exit test, the
/// first).
pub(super) fn ends(zone: Option<Zone>, tangent_points: &[f64; 6]) -> (f64, f64) {
    let [t1, t2, t3, t4, t5, t6] = *tangent_points;
    match zone {
        Some(Zone::Upper) => (t1, t2),
        Some(Zone::Middle) => (t3, t4),
        Some(Zone::Lower) => (t5, t6),
        None => (t6, t1),
    }
}

/// The way through the belt's speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From slower than the belt to faster.
    Up,
    /// From faster than the belt to slower.
    Down,
}

/// The state after one pass of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The listing's `i`.
    pub step: u64,
    /// Time in seconds. Not `(step + 1)·h`: steps that cross the belt's speed have a length of
    /// their own.
    pub t: f64,
    /// Displacement in metres.
    pub x1: f64,
    /// Velocity in metres per second.
    pub x2: f64,
    /// What the body does from here on.
    pub mode: Mode,
    /// Whether the step is in the window the paper plots.
    pub in_window: bool,
}

/// A moment on the line `x2 = vp`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Time in seconds.
    pub t: f64,
    /// Displacement in metres.
    pub x1: f64,
}

/// A stick phase, from its entry to its exit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stick {
    /// Where it began.
    pub entry: Instant,
    /// Where it ended.
    pub exit: Instant,
}

impl Stick {
    /// Length `|Σu|` in metres.
    pub fn length(&self) -> f64 {
        self.exit.x1 - self.entry.x1
    }

    /// Duration in seconds.
    pub fn duration(&self) -> f64 {
        self.exit.t - self.entry.t
    }
}

/// A stick phase of the listing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StickPhase {
    /// From where to where.
    pub stick: Stick,
    /// The stick zone, or none where rounding put the entry just outside.
    pub zone: Option<Zone>,
    /// The end of the zone it left through.
    pub end: End,
}

/// A passage through the belt's speed without sticking (the paper's Σc).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Where.
    pub at: Instant,
    /// Which way.
    pub direction: Direction,
    /// Whether it is the first step after a stick phase: no crossing of the motion, but the wrong
    /// side of [`Defect::ReversedExitSide`](super::Defect::ReversedExitSide) put right.
    pub after_exit: bool,
}

/// The motion a run settled on, decided from the run itself.
///
/// The states at whole multiples of the forcing period are compared: a pattern of `p` periods has
/// repeated when, over the last `max(2p, 6)` of them, each is within twenty steps' way (`20·h`, in
/// metres and metres per second) of the one `p` periods earlier. The steps do not fit the forcing
/// period, so a periodic motion is met with an error of some steps' way and no closer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// Periodic with stick phases.
    StickSlip {
        /// Stick phases in one pattern.
        sticks: usize,
        /// Length of the pattern in forcing periods, the smallest that repeats.
        period: usize,
    },
    /// Periodic, without stick.
    SlipOnly {
        /// Length of the pattern in forcing periods, the smallest that repeats.
        period: usize,
    },
    /// The clock stands: over the second half of the passes it gained less than a tenth of what its
    /// steps give, because the corrections at the ends of stick and slip phases take back what the
    /// steps add.
    Stalled {
        /// Where it stands, in seconds.
        t: f64,
    },
    /// The body went so far out that the softening spring drives it away for good.
    Escaped {
        /// When, in seconds.
        t: f64,
    },
    /// The state stopped being a number: a Hénon step divided by an acceleration of zero.
    BrokenDown {
        /// The last time with a state, in seconds.
        t: f64,
    },
    /// No pattern of up to [`Motion::LONGEST_PATTERN`] forcing periods repeats at the end of the
    /// run.
    NotSettled,
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Motion::StickSlip { sticks, period } => {
                let plural = if *period == 1 { "" } else { "s" };
                write!(
                    f,
                    "stick–slip, {sticks} stick phases in {period} forcing period{plural}"
                )
            }
            Motion::SlipOnly { period } => write!(f, "slip only, period {period}"),
            Motion::Stalled { t } => write!(f, "hangs: the clock stands at {t:.4} s"),
            Motion::Escaped { t } => write!(f, "escapes at {t:.4} s"),
            Motion::BrokenDown { t } => write!(f, "breaks down at {t:.4} s"),
            Motion::NotSettled => f.write_str("no pattern repeats"),
        }
    }
}

impl Motion {
    /// Patterns longer than this many forcing periods are not looked for: the paper's run has 38
    /// periods.
    pub const LONGEST_PATTERN: usize = 8;

    /// What Sect. 4.2 says of Fig. 8: two stick phases in two forcing periods.
    pub const PUBLISHED: Motion = Motion::StickSlip {
        sticks: 2,
        period: 2,
    };
}

/// The outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The complete stick phases, in order.
    pub phases: Vec<StickPhase>,
    /// The stick phase the run ended in, if it did: entry and zone.
    pub unfinished: Option<(Instant, Option<Zone>)>,
    /// The crossings without stick, in order.
    pub crossings: Vec<Crossing>,
    /// The motion the run settled on.
    pub motion: Motion,
    /// Forcing period in seconds.
    pub forcing_period: f64,
}

impl Run {
    /// The stick phases of the last complete pattern, in order of time; none unless the motion is
    /// [`Motion::StickSlip`].
    pub fn settled_phases(&self) -> &[StickPhase] {
        let Motion::StickSlip { period, .. } = self.motion else {
            return &[];
        };
        self.phases_in_last(period)
    }

    /// The complete phases that ended within so many forcing periods before the last one's end.
    pub(super) fn phases_in_last(&self, periods: usize) -> &[StickPhase] {
        let end = self.phases.last().map_or(0.0, |last| last.stick.exit.t);
        let from = pattern_begin(end, periods, self.forcing_period);
        let before = |phase: &StickPhase| phase.stick.exit.t <= from;
        let first = self.phases.iter().rposition(before);
        &self.phases[first.map_or(0, |index| index + 1)..]
    }
}
