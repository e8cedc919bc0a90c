//! The listing's defects, each a switch.

/// One defect of Listing 1.
///
/// Line numbers are the listing's own. "Printed" says what it does when run literally, "mended" what this
/// project does instead when the switch is off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Defect {
    /// Lines 23, 79, 104 and 117: `xn = x` copies no state.
    ///
    /// Printed: each stage of the Runge–Kutta step overwrites the state the next one adds to (lines 106,
    /// 108, 110), and the closing lines 112–113 add the weighted sum once more: h/2 + h/2 + h + h, so the
    /// state moves by about 3h along the field while the clock gets h. The Hénon step (lines 118–126) does
    /// likewise and moves `x1` by 3h′. Four consequences go with it: a step that crosses `x2 = vp` is not
    /// taken back, the Hénon step starts behind the line (50, 66); that step's clock starts at the step's
    /// start although the state has moved on; the numerator `xn[1]-x[1]` of the time correction at the
    /// end of a stick phase (37) is zero; and with it the correction (38).
    ///
    /// Mended: stages have a state of their own (classical Runge–Kutta in both steps), the Hénon step
    /// starts from the state before the crossing, and the correction at the stick's end is not zero.
    InPlaceStages,
    /// Lines 48, 51, 64, 67 and 83: the forcing is an argument of the step, not of the stage.
    ///
    /// Printed: A sin(ωt) is that of the step's start in all stages of both steps; and where a stick phase
    /// ends, the zone's end is that of the step's end (line 37), although the time is then corrected (38).
    ///
    /// Mended: each stage of the slip step uses its own time t, t + h/2, t + h/2, t + h; each stage of the
    /// Hénon step the clock it integrates; and the end of a stick phase is where the line between the gaps
    /// at the step's two ends meets zero. That last part shows only with [`Defect::InPlaceStages`] mended
    /// too, for with it the step's start is overwritten.
    FrozenForcing,
    /// Line 33: only the upper end of the stick zone is tested.
    ///
    /// Printed: when the zone moves up faster than the belt, its lower end overtakes the body, which sticks
    /// on outside the zone until the upper end comes back.
    ///
    /// Mended: the lower end is tested too. Which field takes over there is up to
    /// [`Defect::ReversedExitSide`]: the printed rule knows only the zone.
    OneSidedExit,
    /// Lines 42–45: the side after a stick phase.
    ///
    /// Printed: above the belt's speed from the middle zone, below it from the outer ones, the reverse of
    /// what the fields ask at an upper end. The next step crosses back, three steps' time later.
    ///
    /// Mended: the sign of the spring force s = k2 z³ − k1 z at the zone's end. Where s = μ0 the field
    /// above is tangent and, beyond the end, both point up; where s = −μ0 the field below is, and both point
    /// down.
    ReversedExitSide,
    /// Line 66: `h = x[2]-a` for the Hénon step down to the belt's speed.
    ///
    /// Printed: the step in velocity has the wrong sign and leads away from `x2 = vp`; the closing
    /// `xn[2] = a` (line 68) hides it, but `x1` and the clock have been moved the wrong way.
    ///
    /// Mended: `a - x[2]`, as on the other side (line 50).
    S2StepSign,
    /// Lines 11–13: `range(0, 4, 2)` and the test of the start.
    ///
    /// Printed: only the upper and the middle zone are looked at, without the forcing at the start's time;
    /// a start in the lower zone, or on the line outside all zones, slips above (`aft` keeps its 0, and
    /// line 63 takes anything but −1 so).
    ///
    /// Mended: all three zones, moved by A sin(ωt0); outside them the side is the spring force's sign.
    StartUpTest,
    /// Line 117: `h6 = h*0.166666`.
    ///
    /// Printed: the weights of the Hénon step's closing line sum to 0.999996.
    ///
    /// Mended: 1/6.
    SixthRounded,
}

impl Defect {
    /// All defects, in the listing's order of discovery.
    pub const ALL: [Defect; 7] = [
        Defect::InPlaceStages,
        Defect::FrozenForcing,
        Defect::OneSidedExit,
        Defect::ReversedExitSide,
        Defect::S2StepSign,
        Defect::StartUpTest,
        Defect::SixthRounded,
    ];

    /// The name used in tables: that of the field in [`Defects`].
    pub fn name(self) -> &'static str {
        match self {
            Defect::InPlaceStages => "in_place_stages",
            Defect::FrozenForcing => "frozen_forcing",
            Defect::OneSidedExit => "one_sided_exit",
            Defect::ReversedExitSide => "reversed_exit_side",
            Defect::S2StepSign => "s2_step_sign",
            Defect::StartUpTest => "start_up_test",
            Defect::SixthRounded => "sixth_rounded",
        }
    }

    /// The lines of the listing it sits in.
    pub fn lines(self) -> &'static str {
        match self {
            Defect::InPlaceStages => "23, 37-38, 50, 66, 79, 104-113, 117-126",
            Defect::FrozenForcing => "37, 48, 51, 64, 67, 83",
            Defect::OneSidedExit => "33",
            Defect::ReversedExitSide => "42-45",
            Defect::S2StepSign => "66",
            Defect::StartUpTest => "11-13",
            Defect::SixthRounded => "117",
        }
    }

    /// One sentence for a report.
    pub fn description(self) -> &'static str {
        match self {
            Defect::InPlaceStages => {
                "the stages of both steps overwrite the state they start from, so a slip step moves it by about 3h"
            }
            Defect::FrozenForcing => "the forcing is that of the step's start in every stage",
            Defect::OneSidedExit => "only the upper end of the stick zone is tested",
            Defect::ReversedExitSide => {
                "after a stick phase slip starts on the side the fields do not lead to"
            }
            Defect::S2StepSign => "the Hénon step from above has the wrong sign",
            Defect::StartUpTest => "the test of the start leaves out the third stick zone",
            Defect::SixthRounded => "1/6 is written 0.166666 in the Hénon step",
        }
    }
}

/// Which defects a run has: `true` is as printed, `false` mended. See [`Defect`] for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Defects {
    /// [`Defect::InPlaceStages`].
    pub in_place_stages: bool,
    /// [`Defect::FrozenForcing`].
    pub frozen_forcing: bool,
    /// [`Defect::OneSidedExit`].
    pub one_sided_exit: bool,
    /// [`Defect::ReversedExitSide`].
    pub reversed_exit_side: bool,
    /// [`Defect::S2StepSign`].
    pub s2_step_sign: bool,
    /// [`Defect::StartUpTest`].
    pub start_up_test: bool,
    /// [`Defect::SixthRounded`].
    pub sixth_rounded: bool,
}

impl Defects {
    /// The listing as printed.
    pub const AS_PRINTED: Defects = Defects::all(true);
    /// The listing with every defect mended.
    pub const MENDED: Defects = Defects::all(false);

    const fn all(present: bool) -> Self {
        Defects {
            in_place_stages: present,
            frozen_forcing: present,
            one_sided_exit: present,
            reversed_exit_side: present,
            s2_step_sign: present,
            start_up_test: present,
            sixth_rounded: present,
        }
    }

    /// Whether `defect` is present.
    pub fn has(&self, defect: Defect) -> bool {
        match defect {
            Defect::InPlaceStages => self.in_place_stages,
            Defect::FrozenForcing => self.frozen_forcing,
            Defect::OneSidedExit => self.one_sided_exit,
            Defect::ReversedExitSide => self.reversed_exit_side,
            Defect::S2StepSign => self.s2_step_sign,
            Defect::StartUpTest => self.start_up_test,
            Defect::SixthRounded => self.sixth_rounded,
        }
    }

    /// The same switches with `defect` the other way.
    #[must_use]
    pub fn flipped(mut self, defect: Defect) -> Self {
        let switch = match defect {
            Defect::InPlaceStages => &mut self.in_place_stages,
            Defect::FrozenForcing => &mut self.frozen_forcing,
            Defect::OneSidedExit => &mut self.one_sided_exit,
            Defect::ReversedExitSide => &mut self.reversed_exit_side,
            Defect::S2StepSign => &mut self.s2_step_sign,
            Defect::StartUpTest => &mut self.start_up_test,
            Defect::SixthRounded => &mut self.sixth_rounded,
        };
        *switch = !*switch;
        self
    }

    /// Every defect with the switches that differ from these in it alone.
    ///
    /// From [`Defects::AS_PRINTED`] this walks over the single mends, from [`Defects::MENDED`] over the
    /// single defects.
    pub fn one_flipped(self) -> impl Iterator<Item = (Defect, Defects)> {
        Defect::ALL
            .into_iter()
            .map(move |defect| (defect, self.flipped(defect)))
    }
}

impl Default for Defects {
    /// [`Defects::AS_PRINTED`].
    fn default() -> Self {
        Defects::AS_PRINTED
    }
}
