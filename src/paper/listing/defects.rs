//! The listing's defects, each a switch.

use crate::text::described;

described! {
    /// One defect of Listing 1. `data/errata.csv` describes each defect and what a corrected run
    /// does.
    ///
    /// Line numbers are the listing's. "Printed" describes a literal run. "Mended" describes what
    /// this project does when the switch is off.
    Defect: &'static str as pub name {
        /// Lines 23, 79, 104 and 117: `xn = x` copies no state.
        ///
        /// Printed: each stage of the Runge–Kutta step overwrites the state that the next one adds
        /// to (lines 106, 108, 110). The closing lines 112–113 add the weighted sum once more. The
        /// total is `h/2 + h/2 + h + h`: the state moves by about 3h along the field while the
        /// clock advances by h. The Hénon step (lines 118–126) does likewise and moves `x1` by 3h′.
        /// This has four consequences. A step that crosses `x2 = vp` is not taken back: the Hénon
        /// step starts beyond the line (50, 66). That step's clock starts at the step's start
        /// although the state has moved on. The numerator `xn[1]-x[1]` of the time correction at
        /// the end of a stick phase (37) is zero, and so is the correction (38).
        ///
        /// Mended: stages have their own state (classical Runge–Kutta in both steps). The Hénon
        /// step starts from the state before the crossing. The correction at the end of a stick
        /// phase is not zero.
        InPlaceStages = "in_place_stages",
        /// Lines 48, 51, 64, 67 and 83: the forcing is an argument of the step, not of the stage.
        ///
        /// Printed: all stages of both steps take A sin(ωt) at the step's start. At the end of a
        /// stick phase, the zone's end is taken at the step's end (line 37), although the time is
        /// then corrected (38).
        ///
        /// Mended: each stage of the slip step uses its own time t, t + h/2, t + h/2, t + h. Each
        /// stage of the Hénon step uses the time that it integrates. A stick phase ends where the
        /// line between the gaps at both ends of the step meets zero. The last part has an effect
        /// only if [`Defect::InPlaceStages`] is also mended; otherwise the step's start is
        /// overwritten.
        FrozenForcing = "frozen_forcing",
        /// Line 33: only the upper end of the stick zone is tested.
        ///
        /// Printed: when the zone moves up faster than the belt, its lower end overtakes the body.
        /// The body sticks outside the zone until the upper end comes back.
        ///
        /// Mended: the lower end is tested too. [`Defect::ReversedExitSide`] decides which field
        /// applies after it: the printed rule uses only the zone.
        OneSidedExit = "one_sided_exit",
        /// Lines 42–45: the side after a stick phase.
        ///
        /// Printed: above the belt's speed from the middle zone, below it from the outer ones. This
        /// is the reverse of what the fields require at an upper end. The next step crosses back,
        /// three steps' time later.
        ///
        /// Mended: the sign of the spring force s = k2 z³ − k1 z at the zone's end decides. Where s
        /// = μ0, the field above is tangent; beyond the end, both fields point up. Where s = −μ0,
        /// the field below is tangent; beyond the end, both point down.
        ReversedExitSide = "reversed_exit_side",
        /// Line 66: `h = x[2]-a` for the Hénon step down to the belt's speed.
        ///
        /// Printed: the step in velocity has the wrong sign and leads away from `x2 = vp`. The
        /// closing `xn[2] = a` (line 68) hides it, but `x1` and the clock have moved in the wrong
        /// direction.
        ///
        /// Mended: `a - x[2]`, as on the other side (line 50).
        S2StepSign = "s2_step_sign",
        /// Lines 11–13: `range(0, 4, 2)` and the test of the start.
        ///
        /// Printed: only the upper and the middle zone are tested, without the forcing at the
        /// start's time. A start in the lower zone, or on the line outside all zones, slips above:
        /// `aft` keeps its 0, which line 63 treats as above.
        ///
        /// Mended: all three zones are tested, displaced by A sin(ωt0). Outside them the sign of
        /// the spring force gives the side.
        StartUpTest = "start_up_test",
        /// Line 117: `h6 = h*0.166666`.
        ///
        /// Printed: the weights of the Hénon step's closing line sum to 0.999996.
        ///
        /// Mended: 1/6.
        SixthRounded = "sixth_rounded",
    }
}

/// A set of defects. By default all are present, as in print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Defects(u8);

impl Defects {
    /// The listing as printed: all defects.
    pub const AS_PRINTED: Defects = Defects((1 << Defect::ALL.len()) - 1);
    /// No defects.
    pub const MENDED: Defects = Defects(0);

    /// All subsets, in the order of [`Defects::number`].
    pub fn subsets() -> impl ExactSizeIterator<Item = Defects> {
        (0..=Defects::AS_PRINTED.0).map(Defects)
    }

    /// Index among all subsets.
    pub fn number(self) -> usize {
        usize::from(self.0)
    }

    /// Whether a defect is present.
    pub fn has(self, defect: Defect) -> bool {
        self.0 >> defect as u8 & 1 == 1
    }

    /// The defects that are present.
    pub fn present(self) -> impl Iterator<Item = Defect> {
        Defect::ALL.into_iter().filter(move |one| self.has(*one))
    }

    /// Whether this is a subset of `others`.
    pub fn are_among(self, others: Defects) -> bool {
        self.0 & others.0 == self.0
    }

    /// Defects with one of them switched.
    #[must_use]
    pub fn flipped(self, defect: Defect) -> Self {
        Defects(self.0 ^ 1 << defect as u8)
    }

    /// Defects with each in turn switched.
    pub fn one_flipped(self) -> impl Iterator<Item = (Defect, Defects)> {
        let all = Defect::ALL.into_iter();
        all.map(move |defect| (defect, self.flipped(defect)))
    }
}

impl Default for Defects {
    fn default() -> Self {
        Defects::AS_PRINTED
    }
}
