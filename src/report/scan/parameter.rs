//! The parameters that are changed.

use stickslip::models::ForcedOscillator;

/// A parameter of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// m
    Mass,
    /// vp
    BeltSpeed,
    /// μ0
    Mu0,
    /// A
    Amplitude,
    /// ω
    Omega,
    /// k1
    K1,
    /// k2
    K2,
    /// δ
    Delta,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Parameter; 8] = [
        Parameter::Mass,
        Parameter::BeltSpeed,
        Parameter::Mu0,
        Parameter::Amplitude,
        Parameter::Omega,
        Parameter::K1,
        Parameter::K2,
        Parameter::Delta,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Mass => "m",
            Parameter::BeltSpeed => "vp",
            Parameter::Mu0 => "mu0",
            Parameter::Amplitude => "A",
            Parameter::Omega => "omega",
            Parameter::K1 => "k1",
            Parameter::K2 => "k2",
            Parameter::Delta => "delta",
        }
    }

    /// Its place in a model.
    pub(super) fn of(self, model: &mut ForcedOscillator) -> &mut f64 {
        match self {
            Parameter::Mass => &mut model.mass,
            Parameter::BeltSpeed => &mut model.belt_speed,
            Parameter::Mu0 => &mut model.mu0,
            Parameter::Amplitude => &mut model.amplitude,
            Parameter::Omega => &mut model.omega,
            Parameter::K1 => &mut model.k1,
            Parameter::K2 => &mut model.k2,
            Parameter::Delta => &mut model.delta,
        }
    }

    /// The printed model with this parameter multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> ForcedOscillator {
        let mut model = ForcedOscillator::default();
        *self.of(&mut model) *= factor;
        model
    }
}
