//! Kinds of motion that a start can lead to.

/// What a start leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Out of the spring's reach.
    Escape,
    /// Periodic without stick.
    SlipOnly,
    /// Periodic with stick in each forcing period or with a period other than two.
    StickSlip,
    /// Periodic with stick, repeating after two forcing periods and not after one, as published.
    StickSlipTwo,
    /// Nothing repeats within eight forcing periods.
    Unsettled,
}

impl Class {
    /// All of them, in the order of the table's columns.
    pub const ALL: [Class; 5] = [
        Class::Escape,
        Class::SlipOnly,
        Class::StickSlip,
        Class::StickSlipTwo,
        Class::Unsettled,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Class::Escape => "escapes",
            Class::SlipOnly => "slip_only",
            Class::StickSlip => "stick_slip_other",
            Class::StickSlipTwo => "stick_slip_period_two",
            Class::Unsettled => "unsettled",
        }
    }
}
