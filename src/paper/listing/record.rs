//! The record of a run.

use std::fmt;

use stickslip::{Mode, Phase, Side, State};

/// Amount by which a pattern is shortened, in forcing periods. An event exactly one pattern before
/// the end belongs to the previous pattern, and its time may jitter.
const PATTERN_MARGIN: f64 = 0.01;
/// Minimum number of forcing periods compared before a pattern counts as repeating: three times the
/// published pattern.
pub(in crate::paper) const LEAST_COMPARED: usize = 6;

/// The time (s) at which the last `periods` forcing periods begin.
pub(in crate::paper) fn pattern_begin(end: f64, periods: usize, forcing_period: f64) -> f64 {
    end - (periods as f64 - PATTERN_MARGIN) * forcing_period
}

/// A stick zone: an interval between two neighbouring tangent points in which the body can ride the
/// belt. In this order their ends follow each other among the tangent points.
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
pub enum ZoneEnd {
    /// The end with the larger displacement.
    Upper,
    /// The end with the smaller displacement.
    Lower,
}

impl Zone {
    /// The zone that contains `x1` at the forcing `xs`, both in metres (lines 90–101).
    pub(super) fn holding(x1: f64, tangent_points: &[f64; 6], xs: f64) -> Option<Zone> {
        // In the order of the listing. The order matters where zones meet.
        let mut zones = [Zone::Lower, Zone::Middle, Zone::Upper].into_iter();
        zones.find(|zone| {
            let (upper, lower) = ends(Some(*zone), tangent_points);
            (lower + xs..=upper + xs).contains(&x1)
        })
    }
}

/// Positions of both ends without forcing, in metres.
///
/// A stick phase can start in no zone: at a zone's end, the transition function and
/// [`Zone::holding`] may round differently. The listing's `k` is then −1, and `T[-1]` is the last
/// tangent point. Its neighbour `T[k+1]`, read only with the mended exit test, is the first.
pub(super) fn ends(zone: Option<Zone>, tangent_points: &[f64; 6]) -> (f64, f64) {
    let (upper, lower) = zone.map_or((5, 0), |zone| (2 * zone as usize, 2 * zone as usize + 1));
    (tangent_points[upper], tangent_points[lower])
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
    /// Mode from here on.
    pub mode: Mode,
    /// Whether the step is in the window the paper plots.
    pub in_window: bool,
}

/// A time and a position on the line `x2 = vp`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Time in seconds.
    pub t: f64,
    /// Displacement in metres.
    pub x1: f64,
}

impl Instant {
    /// The time and the position of a state.
    pub(crate) fn of(t: f64, x: &State<2>) -> Instant {
        Instant { t, x1: x[0] }
    }
}

/// A stick phase, from its entry to its exit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stick {
    /// Instant at which it began.
    pub entry: Instant,
    /// Instant at which it ended.
    pub exit: Instant,
}

impl Stick {
    /// The stick of a phase of an accurate solution.
    pub(crate) fn of(phase: &Phase<2>) -> Stick {
        Stick {
            entry: Instant::of(phase.t_start, &phase.x_start),
            exit: Instant::of(phase.t_end, &phase.x_end),
        }
    }

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
    /// Entry and exit.
    pub stick: Stick,
    /// The stick zone; `None` where rounding put the entry just outside.
    pub zone: Option<Zone>,
    /// The end of the zone at which the phase ended.
    pub end: ZoneEnd,
}

/// A passage through the belt's speed without sticking (the paper's Σc).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Time and position.
    pub at: Instant,
    /// The side to which it leads.
    pub to: Side,
    /// Whether it is the first step after a stick phase. Then it is not a crossing of the motion
    /// but the correction of a wrong side from
    /// [`Defect::ReversedExitSide`](super::Defect::ReversedExitSide).
    pub after_exit: bool,
}

/// The motion that a run settled on, decided from the run itself.
///
/// The states at whole multiples of the forcing period are compared. A pattern of `p` periods
/// repeats if each of the last `max(2p, 6)` states is near the one `p` periods earlier. Near means
/// within twenty steps' travel (`20·h`, in metres and metres per second). The steps do not divide
/// the forcing period, so a periodic motion repeats only to within the travel of some steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// Periodic with stick phases.
    StickSlip {
        /// Stick phases in one pattern.
        sticks: usize,
        /// Length of the pattern in forcing periods: the smallest that repeats.
        period: usize,
    },
    /// Periodic, without stick.
    SlipOnly {
        /// Length of the pattern in forcing periods: the smallest that repeats.
        period: usize,
    },
    /// The clock stalls. Over the second half of the passes it advanced by less than a tenth of its
    /// steps. The corrections at the ends of stick and slip phases cancel the steps.
    Stalled {
        /// Time at which it stalls, in seconds.
        t: f64,
    },
    /// The body moved so far out that the softening spring drives it away for good.
    Escaped {
        /// Time, in seconds.
        t: f64,
    },
    /// The state is no longer finite: a Hénon step divided by an acceleration of zero.
    BrokenDown {
        /// Time of the last finite state, in seconds.
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
    /// Longest pattern searched for, in forcing periods. The paper's run has 38 periods.
    pub const LONGEST_PATTERN: usize = 8;

    /// The motion of Fig. 8 by Sect. 4.2: two stick phases in two forcing periods.
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
    /// The stick phase in which the run ended, if any: entry and zone.
    pub unfinished: Option<(Instant, Option<Zone>)>,
    /// The crossings without stick, in order.
    pub crossings: Vec<Crossing>,
    /// The motion that the run settled on.
    pub motion: Motion,
    /// Forcing period in seconds.
    pub forcing_period: f64,
}

impl Run {
    /// The stick phases of the last complete pattern, in order of time. Empty unless the motion is
    /// [`Motion::StickSlip`].
    pub fn settled_phases(&self) -> &[StickPhase] {
        let Motion::StickSlip { period, .. } = self.motion else {
            return &[];
        };
        self.phases_in_last(period)
    }

    /// The complete phases that ended within so many forcing periods before the end of the last
    /// one.
    pub(super) fn phases_in_last(&self, periods: usize) -> &[StickPhase] {
        let end = self.phases.last().map_or(0.0, |last| last.stick.exit.t);
        let from = pattern_begin(end, periods, self.forcing_period);
        let before = |phase: &StickPhase| phase.stick.exit.t <= from;
        let first = self.phases.iter().rposition(before);
        &self.phases[first.map_or(0, |index| index + 1)..]
    }
}
