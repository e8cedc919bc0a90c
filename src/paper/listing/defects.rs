//! The listing's defects, each a switch.

use crate::text::described;

described! {
    /// One defect of Listing 1. What it is, and what a mended run does instead, is in words in
    /// `data/errata.csv`.
    ///
    /// Line numbers are the listing's own. "Printed" says what it does when run literally, "mended"
    /// what this project does instead when the switch is off.
    Defect: &'static str as pub name {
        /// Lines 23, 79, 104 and 117: `xn = x` copies no state.
        ///
        /// Printed: each stage of the Runge–Kutta step overwrites the state the next one adds to
        /// (lines 106, 108, 110), and the closing lines 112–113 add the weighted sum once more:
        /// `h/2 + h/2 + h + h`, so the state moves by about 3h along the field while the clock gets
        /// h. The Hénon step (lines 118–126) does likewise and moves `x1` by 3h′. Four consequences
        /// go with it: a step that crosses `x2 = vp` is not taken back, the Hénon step starts
        /// behind the line (50, 66); that step's clock starts at the step's start although the
        /// state has moved on; the numerator `xn[1]-x[1]` of the time correction at the end of a
        /// stick phase (37) is zero; and with it the correction (38).
        ///
        /// Mended: stages have a state of their own (classical Runge–Kutta in both steps), the
        /// Hénon step starts from the state before the crossing, and the correction at the stick's
        /// end is not zero.
        InPlaceStages = "in_place_stages",
        /// Lines 48, 51, 64, 67 and 83: the forcing is an argument of the step, not of the stage.
        ///
        /// Printed: A sin(ωt) is that of the step's start in all stages of both steps; and where a
        /// stick phase ends, the zone's end is that of the step's end (line 37), although the time
        /// is then corrected (38).
        ///
        /// Mended: each stage of the slip step uses its own time t, t + h/2, t + h/2, t + h; each
        /// stage of the Hénon step the clock it integrates; and the end of a stick phase is where
        /// the line between the gaps at the step's two ends meets zero. That last part shows only
        /// with [`Defect::InPlaceStages`] mended too, for with it the step's start is overwritten.
        FrozenForcing = "frozen_forcing",
        /// Line 33: only the upper end of the stick zone is tested.
        ///
        /// Printed: when the zone moves up faster than the belt, its lower end overtakes the body,
        /// which sticks on outside the zone until the upper end comes back.
        ///
        /// Mended: the lower end is tested too. Which field takes over there is up to
        /// [`Defect::ReversedExitSide`]: the printed rule knows only the zone.
        OneSidedExit = "one_sided_exit",
        /// Lines 42–45: the side after a stick phase.
        ///
        /// Printed: above the belt's speed from the middle zone, below it from the outer ones, the
        /// reverse of what the fields ask at an upper end. The next step crosses back, three steps'
        /// time later.
        ///
        /// Mended: the sign of the spring force s = k2 z³ − k1 z at the zone's end. Where s = μ0
        /// the field above is tangent and, beyond the end, both point up; where s = −μ0 the field
        /// below is, and both point down.
        ReversedExitSide = "reversed_exit_side",
        /// Line 66: `h = x[2]-a` for the Hénon step down to the belt's speed.
        ///
        /// Printed: the step in velocity has the wrong sign and leads away from `x2 = vp`; the
        /// closing `xn[2] = a` (line 68) hides it, but `x1` and the clock have been moved the wrong
        /// way.
        ///
        /// Mended: `a - x[2]`, as on the other side (line 50).
        S2StepSign = "s2_step_sign",
        /// Lines 11–13: `range(0, 4, 2)` and the test of the start.
        ///
        /// Printed: only the upper and the middle zone are looked at, without the forcing at the
        /// start's time; a start in the lower zone, or on the line outside all zones, slips above
        /// (`aft` keeps its 0, and line 63 takes anything but −1 so).
        ///
        /// Mended: all three zones, moved by A sin(ωt0); outside them the side is the spring
        /// force's sign.
        StartUpTest = "start_up_test",
        /// Line 117: `h6 = h*0.166666`.
        ///
        /// Printed: the weights of the Hénon step's closing line sum to 0.999996.
        ///
        /// Mended: 1/6.
        SixthRounded = "sixth_rounded",
    }
}

/// Which defects are present: as printed by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Defects(u8);

impl Defects {
    /// The listing as printed: all of them.
    pub const AS_PRINTED: Defects = Defects((1 << Defect::ALL.len()) - 1);
    /// None of them.
    pub const MENDED: Defects = Defects(0);

    /// All subsets, in the order of [`Defects::number`].
    pub fn subsets() -> impl ExactSizeIterator<Item = Defects> {
        (0..=Defects::AS_PRINTED.0).map(Defects)
    }

    /// Its place among all subsets.
    pub fn number(self) -> usize {
        usize::from(self.0)
    }

    /// Whether a defect is present.
    pub fn has(self, defect: Defect) -> bool {
        self.0 >> defect as u8 & 1 == 1
    }

    /// Those that are present.
    pub fn present(self) -> impl Iterator<Item = Defect> {
        Defect::ALL.into_iter().filter(move |one| self.has(*one))
    }

    /// Whether all of them are among `others`.
    pub fn are_among(self, others: Defects) -> bool {
        self.0 & others.0 == self.0
    }

    /// With one defect mended or put back.
    #[must_use]
    pub fn flipped(self, defect: Defect) -> Self {
        Defects(self.0 ^ 1 << defect as u8)
    }

    /// With each defect in turn mended or put back.
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
