//! The mode that follows a point of Σ: pure functions of mode and fate.

use super::flow::GUARDS;
use super::observer::TransitionKind;
use super::options::AtRepelling;
use super::rules::{Departure, Fate};
use crate::system::{Mode, Side};

/// The mode that follows, and how many derivatives of each guard vanish at the start. `None` if Σ
/// repels and no side was chosen.
pub(super) fn next_mode(
    departure: Departure,
    at_repelling: AtRepelling,
) -> Option<(Mode, [usize; GUARDS])> {
    let orders = departure.orders;
    match (departure.fate, at_repelling) {
        (Fate::Slip(side), _) => Some((Mode::Slip(side), orders)),
        (Fate::Stick, _) => Some((Mode::Stick, orders)),
        (Fate::Repelling, AtRepelling::Stop) => None,
        (Fate::Repelling, AtRepelling::GoBelow) => {
            Some((Mode::Slip(Side::Below), [orders[0] + 1, 0, 0]))
        }
        (Fate::Repelling, AtRepelling::GoAbove) => {
            Some((Mode::Slip(Side::Above), [orders[1] + 1, 0, 0]))
        }
    }
}

/// The kind of a change of mode.
pub(super) fn kind(from: Mode, to: Mode) -> TransitionKind {
    match (from, to) {
        (Mode::Slip(before), Mode::Slip(after)) if before != after => TransitionKind::Crossing,
        (Mode::Slip(_), Mode::Stick) => TransitionKind::StickEntry,
        (Mode::Stick, Mode::Slip(_)) => TransitionKind::StickExit,
        _ => TransitionKind::Touch,
    }
}
