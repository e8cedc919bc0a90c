//! Clips polylines to the plot rectangle, and drops points that make no visible difference.

/// A point in data units or px, depending on the function.
pub(super) type Point = (f64, f64);

/// An axis-parallel rectangle, `x.0 < x.1`, `y.0 < y.1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) x: (f64, f64),
    pub(super) y: (f64, f64),
}

impl Bounds {
    /// Whether the point is inside or on the border.
    pub(super) fn contains(&self, (x, y): Point) -> bool {
        self.x.0 <= x && x <= self.x.1 && self.y.0 <= y && y <= self.y.1
    }

    /// The part of the segment inside the rectangle (Liang and Barsky), as parameters 0 ≤ s ≤ e ≤ 1
    /// along it.
    fn segment(&self, a: Point, b: Point) -> Option<(f64, f64)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        let sides = [
            (-dx, a.0 - self.x.0),
            (dx, self.x.1 - a.0),
            (-dy, a.1 - self.y.0),
            (dy, self.y.1 - a.1),
        ];
        for (rate, room) in sides {
            if rate == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if rate < 0.0 {
                start = start.max(room / rate);
            } else {
                end = end.min(room / rate);
            }
        }
        (start <= end).then_some((start, end))
    }
}

/// The pieces of a polyline inside the rectangle. A point that is not finite ends a piece.
pub(super) fn clip_line(points: &[Point], bounds: &Bounds) -> Vec<Vec<Point>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<Point> = Vec::new();
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let finite = a.0.is_finite() && a.1.is_finite() && b.0.is_finite() && b.1.is_finite();
        let Some((start, end)) = finite.then(|| bounds.segment(a, b)).flatten() else {
            close(&mut piece, &mut pieces);
            continue;
        };
        let at = |s: f64| (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
        if piece.is_empty() || start > 0.0 {
            close(&mut piece, &mut pieces);
            piece.push(if start > 0.0 { at(start) } else { a });
        }
        piece.push(if end < 1.0 { at(end) } else { b });
        if end < 1.0 {
            close(&mut piece, &mut pieces);
        }
    }
    close(&mut piece, &mut pieces);
    pieces
}

fn close(piece: &mut Vec<Point>, pieces: &mut Vec<Vec<Point>>) {
    if piece.len() > 1 {
        pieces.push(std::mem::take(piece));
    } else {
        piece.clear();
    }
}

/// The part of a closed polygon inside the rectangle (Sutherland and Hodgman). Where the polygon
/// leaves and returns, the result runs along the border, which a fill does not show.
pub(super) fn clip_area(points: &[Point], bounds: &Bounds) -> Vec<Point> {
    // One half-plane after the other: which coordinate, its limit, and which side is kept.
    let sides = [
        (true, bounds.x.0, 1.0),
        (true, bounds.x.1, -1.0),
        (false, bounds.y.0, 1.0),
        (false, bounds.y.1, -1.0),
    ];
    let mut polygon: Vec<Point> = points
        .iter()
        .copied()
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .collect();
    for (horizontal, limit, sign) in sides {
        let depth = |p: Point| sign * (if horizontal { p.0 } else { p.1 } - limit);
        let mut kept = Vec::with_capacity(polygon.len());
        for i in 0..polygon.len() {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (da, db) = (depth(a), depth(b));
            if da >= 0.0 {
                kept.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let s = da / (da - db);
                kept.push((a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1)));
            }
        }
        polygon = kept;
    }
    polygon
}

/// Points of a piece of a long line. In the worst case a piece takes this many squared steps, some
/// seconds.
const POINTS_PER_PIECE: usize = 1 << 16;

/// Drops points whose absence moves the line by less than `tolerance` (Ramer, Douglas and Peucker;
/// without recursion, so a long orbit cannot exhaust the stack). `scale` turns data units into
/// those of the tolerance. The ends of pieces of a long line are kept. So the time grows with the
/// square of a piece, not of the line. This matters where every split leaves nearly all points on
/// one side, as in a spiral.
pub(super) fn simplify(points: &[Point], scale: Point, tolerance: f64) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    let last = points.len() - 1;
    keep[last] = true;
    let mut open = Vec::new();
    for first in (0..last).step_by(POINTS_PER_PIECE) {
        keep[first] = true;
        open.push((first, last.min(first + POINTS_PER_PIECE)));
    }
    while let Some((first, last)) = open.pop() {
        let mut farthest = (0.0, first);
        for i in first + 1..last {
            let d = distance_squared(points[i], points[first], points[last], scale);
            if d > farthest.0 {
                farthest = (d, i);
            }
        }
        if farthest.0 > tolerance * tolerance {
            keep[farthest.1] = true;
            open.push((first, farthest.1));
            open.push((farthest.1, last));
        }
    }
    points
        .iter()
        .zip(keep)
        .filter_map(|(p, kept)| kept.then_some(*p))
        .collect()
}

/// Squared distance of `p` from the segment `a b` after scaling.
fn distance_squared(p: Point, a: Point, b: Point, scale: Point) -> f64 {
    let (bx, by) = ((b.0 - a.0) * scale.0, (b.1 - a.1) * scale.1);
    let (px, py) = ((p.0 - a.0) * scale.0, (p.1 - a.1) * scale.1);
    let length_squared = bx * bx + by * by;
    let s = if length_squared > 0.0 {
        ((px * bx + py * by) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (ex, ey) = (px - s * bx, py - s * by);
    ex * ex + ey * ey
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: Bounds = Bounds {
        x: (0.0, 1.0),
        y: (0.0, 1.0),
    };

    #[test]
    fn a_line_through_the_rectangle_is_cut_at_its_borders() {
        let pieces = clip_line(&[(-1.0, 0.5), (2.0, 0.5)], &UNIT);
        assert_eq!(pieces.len(), 1);
        let (start, end) = (pieces[0][0], pieces[0][1]);
        assert!(start.0.abs() < 1e-15 && (end.0 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_line_that_leaves_and_returns_makes_two_pieces() {
        let pieces = clip_line(&[(0.2, 0.5), (0.5, 3.0), (0.8, 0.5)], &UNIT);
        assert_eq!(pieces.len(), 2);
    }

    #[test]
    fn a_gap_splits_the_line() {
        let gap = [
            (0.0, 0.0),
            (0.1, 0.1),
            (f64::NAN, 0.0),
            (0.5, 0.5),
            (0.6, 0.6),
        ];
        assert_eq!(clip_line(&gap, &UNIT).len(), 2);
    }

    #[test]
    fn a_polygon_around_the_rectangle_becomes_the_rectangle() {
        let around = [(-1.0, -1.0), (2.0, -1.0), (2.0, 2.0), (-1.0, 2.0)];
        let cut = clip_area(&around, &UNIT);
        assert_eq!(cut.len(), 4);
        assert!(cut.iter().all(|p| UNIT.contains(*p)));
    }

    #[test]
    fn a_straight_line_needs_only_its_ends() {
        let line: Vec<Point> = (0..100)
            .map(|i| (f64::from(i), 2.0 * f64::from(i)))
            .collect();
        assert_eq!(
            simplify(&line, (1.0, 1.0), 0.01),
            vec![(0.0, 0.0), (99.0, 198.0)]
        );
    }

    #[test]
    fn a_long_line_is_thinned_in_pieces() {
        let length = 2 * POINTS_PER_PIECE + 2;
        let line: Vec<Point> = (0..length).map(|i| (i as f64, 0.0)).collect();
        let ends = [0, POINTS_PER_PIECE, 2 * POINTS_PER_PIECE, length - 1].map(|i| line[i]);
        assert_eq!(simplify(&line, (1.0, 1.0), 0.01), ends);
    }

    #[test]
    fn a_closed_loop_is_not_collapsed() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        assert_eq!(simplify(&square, (1.0, 1.0), 0.01).len(), 5);
    }

    proptest! {
        #[test]
        fn clipped_points_are_inside(
            points in prop::collection::vec((-3.0..3.0, -3.0..3.0), 2..40),
        ) {
            let room = Bounds { x: (-1e-12, 1.0 + 1e-12), y: (-1e-12, 1.0 + 1e-12) };
            for piece in clip_line(&points, &UNIT) {
                prop_assert!(piece.iter().all(|p| room.contains(*p)));
            }
            prop_assert!(clip_area(&points, &UNIT).iter().all(|p| room.contains(*p)));
        }

        #[test]
        fn thinning_keeps_every_point_within_tolerance(
            points in prop::collection::vec((-3.0..3.0, -3.0..3.0), 2..60)
        ) {
            let kept = simplify(&points, (1.0, 1.0), 0.5);
            for p in &points {
                let nearest = kept
                    .windows(2)
                    .map(|w| distance_squared(*p, w[0], w[1], (1.0, 1.0)))
                    .fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= 0.25 + 1e-12);
            }
        }
    }
}
