//! Long curves: only what a picture shows of them is kept.

use std::collections::VecDeque;

use super::plot::INVISIBLE;
use super::polyline::{Point, simplify};

/// Width of a cell of the grid on which lines are remembered, px. An edge that is off by this much
/// differs by a quarter where a picture is rendered at twice its size.
const CELL: f64 = 0.2;

/// Longest part of a line that is kept or dropped as a whole, in cells.
const PART: f64 = 10.0;

/// Length at the tip of a line that does not count as drawn, in cells: no line ends at itself.
const TIP: f64 = 8.0;

/// Number of parts that are drawn again where a line would end and begin anew.
const BRIDGE: u32 = 6;

/// Factor on the width of a cell where too many points remain.
const COARSER: f64 = 1.5;

/// Free space of a grid beyond the points, in units of their extent. With it a curve that grows
/// evenly, as over time, needs a new grid only now and then.
const FREE: f64 = 1.0;

/// Number of points from which on a curve is thinned, and of those that are simplified together:
/// the time of either may grow with the square.
const FEW: usize = 1 << 14;

/// Points of a curve, thinned while they are recorded. What is drawn already is not kept again, so
/// that time is linear in the points and memory bounded. A part of a line is dropped if cells of a
/// grid that lines have passed before cover it, over the whole width of the pen.
#[derive(Clone, Debug)]
pub struct Trace {
    /// A point that is not a number ends a line.
    points: Vec<Point>,
    /// Number of points that are thinned already, and number at which the rest follows.
    thinned: usize,
    limit: usize,
    /// Largest number of points after thinning.
    most: usize,
    /// Size of the plot rectangle, width of the pen, and of a cell, px.
    size: Point,
    pen: f64,
    cell: f64,
    grid: Grid,
}

impl Trace {
    /// No points, of a curve that is drawn by a pen of some width in a rectangle of some size, in
    /// px. A curve of few points is kept as it is; of a long one `most` points remain at most.
    pub fn new(size: (f64, f64), pen: f64, most: usize) -> Self {
        Self {
            points: Vec::new(),
            thinned: 0,
            limit: most.min(FEW),
            most,
            size,
            pen,
            cell: CELL,
            grid: Grid::default(),
        }
    }

    /// Adds a point.
    pub fn push(&mut self, point: (f64, f64)) {
        self.points.push(point);
        if self.points.len() >= self.limit {
            self.thin();
        }
    }

    /// Ends a line: the next point begins another one.
    pub fn lift(&mut self) {
        if self.points.last().is_some_and(|last| !last.0.is_nan()) {
            self.points.push((f64::NAN, f64::NAN));
        }
    }

    /// The points; one that is not a number ends a line.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut whole = self.clone();
        if self.thinned > 0 {
            whole.thin();
        }
        whole.points
    }

    /// Thins all points on a new grid.
    fn thin_all(&mut self) {
        let all = std::mem::take(&mut self.points);
        self.grid = Grid::over(&all, self.size, self.cell);
        self.grid.thin(&all, self.pen, &mut self.points);
    }

    /// Thins the points since the last time. Where too many remain, all are thinned again, first on
    /// the grid of the present extent, then on coarser ones.
    fn thin(&mut self) {
        // The last point begins the part that follows.
        let tip = self.points.last().copied();
        if self.grid.covers(&self.points[self.thinned..]) {
            let rest = self.points.split_off(self.thinned);
            self.grid.thin(&rest, self.pen, &mut self.points);
        } else {
            self.thin_all();
        }
        if self.points.len() > self.most {
            self.points = self.grid.simplified(&self.points);
            // With room for more, which would otherwise be too many at once.
            let most = self.most / 4 * 3;
            if self.points.len() > most {
                self.thin_all();
            }
            while self.points.len() > most && self.cell < self.size.0 {
                self.cell *= COARSER;
                self.thin_all();
            }
        }
        self.thinned = self.points.len();
        self.limit = self.most.min(FEW).max(2 * self.thinned);
        self.points.extend(tip);
    }
}

/// A part of the plane in square cells, and which of them are drawn.
#[derive(Clone, Debug, Default)]
struct Grid {
    origin: Point,
    /// Cells per unit of the data.
    scale: Point,
    /// Width of a cell, px.
    cell: f64,
    columns: usize,
    rows: usize,
    /// A bit for each cell; a word for each square of 8 × 8 of them, row by row.
    drawn: Vec<u64>,
}

impl Grid {
    /// An empty grid over points and some space around them, which take the size in px.
    fn over(points: &[Point], size: Point, cell: f64) -> Self {
        let finite = points.iter().filter(|p| p.0.is_finite() && p.1.is_finite());
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (x, y) = finite.fold((none, none), |(x, y), p| {
            ((x.0.min(p.0), x.1.max(p.0)), (y.0.min(p.1), y.1.max(p.1)))
        });
        let axis = |(low, high): (f64, f64), size: f64| {
            // All points at one place: any scale will do.
            let extent = if high > low { high - low } else { 1.0 };
            let cells = (1.0 + 2.0 * FREE) * size / cell;
            (
                low - FREE * extent,
                size / cell / extent,
                (cells as usize + 1).next_multiple_of(8),
            )
        };
        let ((left, across, columns), (below, up, rows)) = (axis(x, size.0), axis(y, size.1));
        Grid {
            origin: (left, below),
            scale: (across, up),
            cell,
            columns,
            rows,
            drawn: vec![0; columns / 8 * (rows / 8)],
        }
    }

    /// Whether all points lie on the grid.
    fn covers(&self, points: &[Point]) -> bool {
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        points.iter().map(|&p| self.place(p)).all(|(x, y)| {
            x.is_nan() || y.is_nan() || 0.0 <= x && x < columns && 0.0 <= y && y < rows
        })
    }

    /// A point in units of cells.
    fn place(&self, p: Point) -> Point {
        let (x, y) = (p.0 - self.origin.0, p.1 - self.origin.1);
        (x * self.scale.0, y * self.scale.1)
    }

    /// Word and bit of a cell. There is space around all lines.
    fn bit(&self, column: usize, row: usize) -> (usize, u64) {
        let word = (row / 8).wrapping_mul(self.columns / 8) + column / 8;
        (word, 1 << (row % 8 * 8 + column % 8))
    }

    fn is_drawn(&self, (x, y): Point) -> bool {
        let (word, bit) = self.bit(x as usize, y as usize);
        self.drawn.get(word).is_some_and(|cells| cells & bit != 0)
    }

    /// From a line to half a cell from the edge of the pen, across it, in cells; nothing for a line
    /// without length.
    fn across(&self, (dx, dy): Point, pen: f64) -> Point {
        let length = (dx * dx + dy * dy).sqrt();
        let half = (0.5 * pen / self.cell - 0.5).max(0.0);
        match length > 0.0 {
            true => (-dy / length * half, dx / length * half),
            false => (0.0, 0.0),
        }
    }

    /// Marks the cells that a line covers.
    fn mark(&mut self, from: Point, to: Point, pen: f64) {
        let (a, b) = (self.place(from), self.place(to));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        if dx.is_nan() || dy.is_nan() {
            return;
        }
        // An even number of steps comes by the middle, where lines are compared.
        let along = 2.0 * (0.5 * (dx * dx + dy * dy).sqrt()).ceil().max(1.0);
        let (nx, ny) = self.across((dx, dy), pen);
        let wide = (nx * nx + ny * ny).sqrt().ceil().max(1.0);
        // Whole multiples of a small part of a cell are faster to add and to round down.
        let fixed = |(x, y): Point| [x, y].map(|x| (x * f64::from(1 << 20)) as i64);
        let ([mut x, mut y], [ax, ay]) =
            (fixed((a.0 - nx, a.1 - ny)), fixed((dx / along, dy / along)));
        let [ox, oy] = fixed((nx / wide, ny / wide));
        for _ in 0..=along as usize {
            let (mut column, mut row) = (x, y);
            for _ in 0..=2 * wide as usize {
                let (word, bit) = self.bit((column >> 20) as usize, (row >> 20) as usize);
                if let Some(cells) = self.drawn.get_mut(word) {
                    *cells |= bit;
                }
                (column, row) = (column + ox, row + oy);
            }
            (x, y) = (x + ax, y + ay);
        }
    }

    /// Lines without the points that make no difference.
    fn simplified(&self, points: &[Point]) -> Vec<Point> {
        let per_unit = (self.scale.0 * self.cell, self.scale.1 * self.cell);
        let lines = points.split(|p| p.0.is_nan() || p.1.is_nan());
        let lines = lines.filter(|line| !line.is_empty()).flat_map(|line| {
            let pieces = line.chunks(FEW);
            let pieces = pieces.map(|piece| simplify(piece, per_unit, INVISIBLE));
            let mut line = pieces.collect::<Vec<_>>().concat();
            line.push((f64::NAN, f64::NAN));
            line
        });
        lines.collect()
    }

    /// Adds the parts of lines that are not drawn yet, and marks them.
    fn thin(&mut self, points: &[Point], pen: f64, kept: &mut Vec<Point>) {
        for line in points.split(|p| p.0.is_nan() || p.1.is_nan()) {
            self.thin_line(line, pen, kept);
        }
    }

    fn thin_line(&mut self, line: &[Point], pen: f64, kept: &mut Vec<Point>) {
        let Some((&first, rest)) = line.split_first() else {
            return;
        };
        // Parts that are kept, but not marked yet, with their lengths in cells.
        let mut tip: VecDeque<(Point, Point, f64)> = VecDeque::new();
        let mut tip_length = 0.0;
        // Number of parts since the last new one, with the number of points and the last of them
        // up to there, while the line goes on over parts that are drawn already.
        let mut open: Option<(u32, usize, Point)> = None;
        let (mut from, begin) = (first, kept.len());
        for (k, &to) in rest.iter().enumerate() {
            let (a, b) = (self.place(from), self.place(to));
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length = (dx * dx + dy * dy).sqrt();
            if length < 1.0 && k + 1 < rest.len() {
                continue;
            }
            let count = (length / PART).ceil().max(1.0);
            let (nx, ny) = self.across((dx, dy), pen);
            let at = |s: f64| (from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1));
            for part in 0..count as usize {
                let [s, middle, e] = [0.0, 0.5, 1.0].map(|k| (part as f64 + k) / count);
                let across = [0.0, 1.0, -1.0].map(|o| (o * nx, o * ny));
                let is_new = [s, middle, e].iter().any(|k| {
                    let (x, y) = (a.0 + k * dx, a.1 + k * dy);
                    across.iter().any(|o| !self.is_drawn((x + o.0, y + o.1)))
                });
                if !is_new && open.is_none() && tip.is_empty() {
                    continue;
                }
                let (start, end) = (at(s), if e == 1.0 { to } else { at(e) });
                match (&open, kept.last_mut()) {
                    // A straight line needs no point between its ends.
                    (Some(_), Some(last)) if s > 0.0 => *last = end,
                    (Some(_), _) => kept.push(end),
                    (None, _) if is_new => kept.extend([start, end]),
                    _ => {}
                }
                open = match open {
                    _ if is_new => Some((0, kept.len(), end)),
                    Some((gap, ..)) if gap == BRIDGE => {
                        lift(&mut open, kept);
                        None
                    }
                    Some((gap, count, last)) => Some((gap + 1, count, last)),
                    None => None,
                };
                if is_new {
                    tip.push_back((start, end, length / count));
                    tip_length += length / count;
                }
                while let Some(&(start, end, length)) = tip.front()
                    && (!is_new || tip_length - length > TIP)
                {
                    self.mark(start, end, pen);
                    tip_length -= length;
                    tip.pop_front();
                }
            }
            from = to;
        }
        lift(&mut open, kept);
        tip.iter()
            .for_each(|&(start, end, _)| self.mark(start, end, pen));
        // A line without length is a point.
        if kept.len() == begin && !self.is_drawn(self.place(first)) {
            self.mark(first, first, pen);
            kept.extend([first, first]);
        }
        if kept.last().is_some_and(|last| !last.0.is_nan()) {
            kept.push((f64::NAN, f64::NAN));
        }
    }
}

/// Ends a line behind its last new part.
fn lift(open: &mut Option<(u32, usize, Point)>, kept: &mut Vec<Point>) {
    if let Some((_, count, last)) = open.take() {
        kept.truncate(count - 1);
        kept.extend([last, (f64::NAN, f64::NAN)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Point = (200.0, 160.0);
    const PEN: f64 = 1.2;

    /// Samples of a pixel across, where pictures are compared at twice their size.
    const SAMPLES: usize = 4;

    /// Share of the samples of each pixel that lines cover which are drawn by the pen.
    fn picture(points: &[Point]) -> Vec<u8> {
        let (width, height) = (2 * SIZE.0 as usize, 2 * SIZE.1 as usize);
        let scale = 2.0 * SAMPLES as f64;
        let (columns, rows) = (width * SAMPLES, height * SAMPLES);
        let mut drawn = vec![false; columns * rows];
        let r = 0.5 * PEN * scale;
        for ends in points.windows(2) {
            let [(ax, ay), (bx, by)] = [0, 1].map(|k| (ends[k].0 * scale, ends[k].1 * scale));
            let (dx, dy) = (bx - ax, by - ay);
            let length = crate::math::hypot(dx, dy);
            if length.is_nan() {
                continue;
            }
            let count = (0.5 * length).ceil();
            for k in 0..=count as usize {
                let s = k as f64 / count.max(1.0);
                let (x, y) = (ax + s * dx, ay + s * dy);
                for row in (y - r).max(0.0) as usize..=((y + r) as usize).min(rows - 1) {
                    let up = row as f64 + 0.5 - y;
                    let left = (r * r - up * up).max(0.0).sqrt();
                    let (from, to) = ((x - left).max(0.0), (x + left).min(columns as f64));
                    drawn[row * columns + from as usize..row * columns + to as usize].fill(true);
                }
            }
        }
        let mut shares = vec![0; width * height];
        for (k, _) in drawn.iter().enumerate().filter(|(_, is_drawn)| **is_drawn) {
            let (column, row) = (k % columns / SAMPLES, k / columns / SAMPLES);
            shares[row * width + column] += 1;
        }
        shares
    }

    /// Thousandths of the pixels that differ by more than a quarter.
    fn difference(one: &[Point], other: &[Point]) -> f64 {
        let quarter = (SAMPLES * SAMPLES / 4) as u8;
        let (one, other) = (picture(one), picture(other));
        let pairs = one.iter().zip(&other);
        let differ = pairs.filter(|(a, b)| a.abs_diff(**b) > quarter).count();
        1e3 * differ as f64 / one.len() as f64
    }

    fn thinned(points: &[Point], most: usize) -> Vec<Point> {
        let mut trace = Trace::new(SIZE, PEN, most);
        points.iter().for_each(|&point| trace.push(point));
        trace.points()
    }

    /// A figure of Lissajous that fills an area, one turn in as many points.
    fn lissajous(turns: usize, points: usize) -> Vec<Point> {
        let at = |k: usize| {
            let t = k as f64 / points as f64 * std::f64::consts::TAU;
            (
                100.0 + 96.0 * libm::sin(t),
                80.0 + 76.0 * libm::sin(1.618 * t),
            )
        };
        (0..turns * points).map(at).collect()
    }

    /// An oscillation over time, of which `turns` are on the whole width.
    fn oscillation(turns: usize) -> Vec<Point> {
        let all = 24 * turns;
        let at = |k: usize| {
            let part = k as f64 / all as f64;
            let height = 60.0 + 16.0 * libm::sin(11.0 * part);
            let t = k as f64 / 24.0 * std::f64::consts::TAU;
            (199.0 * part + 0.5, 80.0 + height * libm::sin(t))
        };
        (0..=all).map(at).collect()
    }

    /// A slow spiral to a cycle, which it passes many times at once.
    fn spiral(turns: usize) -> Vec<Point> {
        let at = |k: usize| {
            let t = k as f64 / 60.0 * std::f64::consts::TAU;
            let r = 40.0 + 35.0 * libm::exp(-t / 100.0);
            (100.0 + r * libm::cos(t), 80.0 + r * libm::sin(t))
        };
        (0..60 * turns).map(at).collect()
    }

    #[test]
    fn few_points_are_kept_as_they_are() {
        let points = lissajous(10, 100);
        assert_eq!(thinned(&points, 1001), points);
    }

    #[test]
    fn a_thinned_curve_looks_the_same() {
        for (name, points, most) in [
            ("area", lissajous(120, 200), 20_000),
            ("time", oscillation(800), 10_000),
            ("spiral", spiral(300), 10_000),
        ] {
            let kept = thinned(&points, most);
            let off = difference(&points, &kept);
            assert!(
                kept.len() < points.len() && kept.len() <= most + 1,
                "{name}"
            );
            println!("{name}: {} of {}, {off}", kept.len(), points.len());
            assert!(off <= 1.0, "{name}: {off} thousandths");
        }
    }

    #[test]
    fn points_and_gaps_are_kept() {
        let mut trace = Trace::new(SIZE, PEN, 100);
        for k in 0..1000 {
            let x = f64::from(k / 100);
            trace.push((x, 0.0));
            trace.push((x, 0.0));
            trace.lift();
        }
        let points = trace.points();
        for k in 0..10 {
            let at = (f64::from(k), 0.0);
            let dots = points.windows(2).filter(|two| **two == [at, at]).count();
            assert_eq!(dots, 1, "{points:?}");
        }
    }
}
