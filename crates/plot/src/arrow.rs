//! Arrows.

use super::pen::Pen;
use super::plot::{Drawn, Sheet};
use super::polyline::Point;

/// Length of an arrow head, px.
const HEAD_LENGTH: f64 = 6.5;
/// Half of its width, px.
const HEAD_HALF_WIDTH: f64 = 2.4;

/// A line from `from` to `to` with a head at `to`.
pub(super) fn single(sheet: &Sheet<'_, '_>, from: Point, to: Point, pen: &Pen) -> Drawn {
    let Some(neck) = neck(from, to) else {
        return Ok(());
    };
    sheet.stroke(&[from, neck], pen)?;
    head(sheet, neck, to, pen)
}

/// A line with heads at both ends. Where there is no room for two heads, they point at each other
/// from outside.
pub(super) fn double(sheet: &Sheet<'_, '_>, a: Point, b: Point, pen: &Pen) -> Drawn {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = crate::math::hypot(dx, dy);
    if length == 0.0 {
        return Ok(());
    }
    let (ux, uy) = (dx / length, dy / length);
    if length < 2.6 * HEAD_LENGTH {
        let out = 2.2 * HEAD_LENGTH;
        single(sheet, (a.0 - out * ux, a.1 - out * uy), a, pen)?;
        return single(sheet, (b.0 + out * ux, b.1 + out * uy), b, pen);
    }
    let near_a = (a.0 + HEAD_LENGTH * ux, a.1 + HEAD_LENGTH * uy);
    let near_b = (b.0 - HEAD_LENGTH * ux, b.1 - HEAD_LENGTH * uy);
    sheet.stroke(&[near_a, near_b], pen)?;
    head(sheet, near_a, a, pen)?;
    head(sheet, near_b, b, pen)
}

/// End of the line and start of the head.
fn neck(from: Point, to: Point) -> Option<Point> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = crate::math::hypot(dx, dy);
    (length > 0.0).then(|| {
        let s = HEAD_LENGTH.min(length) / length;
        (to.0 - s * dx, to.1 - s * dy)
    })
}

fn head(sheet: &Sheet<'_, '_>, neck: Point, tip: Point, pen: &Pen) -> Drawn {
    let (dx, dy) = (tip.0 - neck.0, tip.1 - neck.1);
    let half = HEAD_HALF_WIDTH / crate::math::hypot(dx, dy);
    let corners = [
        tip,
        (neck.0 - half * dy, neck.1 + half * dx),
        (neck.0 + half * dy, neck.1 - half * dx),
    ];
    sheet.fill(&corners, pen.color)
}
