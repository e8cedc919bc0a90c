//! Interpretations by which the captions of Figs. 10–12 become a system.

use super::BlockAndBracket;
use stickslip::{Error, Filippov};

/// Nine numbers and a start, as a caption gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caption {
    /// The column headed `ξ1,…,7, δ, vp`.
    pub numbers: [f64; 9],
    /// Start `(x₁, x₂, x₃, x₄)` at `t = 0`.
    pub start: [f64; 4],
}

impl Caption {
    /// Captions of Figs. 10, 11 and 12.
    pub const ALL: [Caption; 3] = [Caption::FIG10, Caption::FIG11, Caption::FIG12];
    /// Fig. 10, "two-periodic".
    pub const FIG10: Caption = Caption {
        numbers: [0.237, 0.0, 0.613, 1.888, 0.0, 1.300, 1.115, 0.330, 0.930],
        start: [0.0, -0.1, 0.0, -0.1],
    };
    /// Fig. 11, quasi-periodic.
    pub const FIG11: Caption = Caption {
        numbers: [0.413, 0.0, 1.069, 1.980, 0.0, 0.707, 0.693, 0.101, 0.707],
        start: [0.0, 0.0, 0.0, -0.1],
    };
    /// Fig. 12, chaotic.
    pub const FIG12: Caption = Caption {
        numbers: [0.222, 0.0, 0.575, 3.333, 0.0, 2.900, 6.766, 0.976, 0.689],
        start: [0.0, -0.1, 0.0, -0.1],
    };
}

/// Meaning of the nine numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CaptionOrder {
    /// ξ1 … ξ5, μ0, ξ6, δ, vp, with ξ7 = 0. The numbers show it, not the heading. ξ2 = ξ5 = 0 means
    /// no dampers, and so ξ7 = 0. The ratio of the seventh number to the sixth is ξ4 − 1 = k3/k2 in
    /// Figs. 11 and 12 to all digits, as ξ6/μ0 must be. (In Fig. 10 it is 0.858 instead of 0.888.)
    Mu0BeforeXi6,
    /// ξ1 … ξ7, δ, vp, as in the heading. Then μ0 is not given and has to be supplied.
    Heading {
        /// Static friction.
        mu0: f64,
    },
}

/// Amplitude of the friction force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amplitude {
    /// μ0, with lengths in units of `mg/k2`.
    Mu0,
    /// 1, with lengths in units of `μ0 mg/k2`. Then ξ6 and ξ7 as defined are the effects on the
    /// normal force.
    One,
}

/// Terms of ξ6 and ξ7 in the normal force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unloading {
    /// `N/mg = 1 − (ξ6 x₃ + ξ7 x₄)/μ0`, because `ξ6 = μ0 k3/k2` and `ξ7 = μ0 ω c2/k2` already
    /// include the factor μ0.
    OverMu0,
    /// `N/mg = 1 − ξ6 x₃ − ξ7 x₄`, the `y` of Eq. (28) as printed.
    Plain,
}

/// An interpretation of Eq. (27)–(28) and of the captions of Figs. 10–12. It is data, so that all
/// interpretations run through the same code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpretation {
    /// Sign of `x₃` in the second row of Eq. (27), 1 or −1.
    pub displacement_sign: f64,
    /// Sign of `T` there, 1 or −1.
    pub friction_sign: f64,
    /// Amplitude of friction.
    pub amplitude: Amplitude,
    /// Unloading of the contact by the bracket.
    pub unloading: Unloading,
    /// Whether the normal force is clipped at zero.
    pub clipped: bool,
    /// Meaning of the nine numbers.
    pub order: CaptionOrder,
}

impl Interpretation {
    /// The equations that the mechanics of Fig. 9 require: see [`BlockAndBracket`].
    pub fn exact() -> Self {
        Interpretation {
            displacement_sign: 1.0,
            friction_sign: 1.0,
            amplitude: Amplitude::Mu0,
            unloading: Unloading::OverMu0,
            clipped: true,
            order: CaptionOrder::Mu0BeforeXi6,
        }
    }

    /// Eq. (27) and (28) taken literally: `−x₃ − T` in the second row, `T = sgn(v) y μₖ` with `y =
    /// 1 − ξ6 x₃ − ξ7 x₄`, without clipping. The captions' heading has no μ0, so their numbers are
    /// taken as in [`Interpretation::exact`].
    pub fn as_printed() -> Self {
        Interpretation {
            displacement_sign: -1.0,
            friction_sign: -1.0,
            unloading: Unloading::Plain,
            clipped: false,
            ..Interpretation::exact()
        }
    }

    /// The corrected equations with lengths in units of `μ0 mg/k2`.
    pub fn scaled_by_friction() -> Self {
        Interpretation {
            amplitude: Amplitude::One,
            unloading: Unloading::Plain,
            ..Interpretation::exact()
        }
    }
}

impl BlockAndBracket {
    /// The system that a caption describes under a reading.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first parameter that is not allowed.
    pub fn from_caption(caption: &Caption, reading: &Interpretation) -> Result<Self, Error> {
        let [xi1, xi2, xi3, xi4, xi5, sixth, seventh, delta, belt_speed] = caption.numbers;
        let (mu0, xi6, xi7) = match reading.order {
            CaptionOrder::Mu0BeforeXi6 => (sixth, seventh, 0.0),
            CaptionOrder::Heading { mu0 } => (mu0, sixth, seventh),
        };
        let over = match reading.unloading {
            Unloading::OverMu0 => super::positive("mu0", mu0)?,
            Unloading::Plain => 1.0,
        };
        BlockAndBracket {
            coupling: xi1,
            coupling_damping: xi2,
            mobility: xi3,
            bracket_stiffness: xi4,
            bracket_damping: xi5,
            mu0: match reading.amplitude {
                Amplitude::Mu0 => mu0,
                Amplitude::One => 1.0,
            },
            unloading: xi6 / over,
            unloading_rate: xi7 / over,
            delta,
            belt_speed,
            displacement_sign: reading.displacement_sign,
            friction_sign: reading.friction_sign,
            clipped: reading.clipped,
        }
        .checked()
    }
}
