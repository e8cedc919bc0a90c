//! Long curves: only what a picture shows of them is kept.

use std::ops::Range;

use super::plot::INVISIBLE;
use super::polyline::{Point, simplify};

/// Width of a cell of the paper, px. An edge that is off by this much differs by less than a
/// quarter where a picture is rendered at twice its size.
const CELL: f64 = 0.12;

/// Longest part of a line that is kept or dropped as a whole, in cells.
const PART: f64 = 16.0;

/// Number of parts that are drawn again where a line would end and begin anew.
const BRIDGE: u32 = 6;

/// Free space of a paper beyond the points, in units of their extent. With it a curve that grows
/// evenly, as over time, needs a new paper only now and then.
const FREE: f64 = 0.5;

/// Number of points from which on a curve is thinned, and that are thinned at once.
const FEW: usize = 1 << 14;

/// Most points that are simplified together: the time may grow with the square.
const PIECE: usize = 256;

/// Points of a curve, thinned while they are recorded. What is drawn already is not kept again, so
/// that time is linear in the points and memory bounded. A part of a line is dropped only if what
/// is kept covers all its cells of a paper, and areas that are full become lines side by side.
/// So no ink is lost, however often a curve is thinned.
#[derive(Clone, Debug)]
pub struct Trace {
    /// A point that is not finite ends a line.
    points: Vec<Point>,
    /// Number of points that are thinned already.
    thinned: usize,
    /// Largest number of points after thinning.
    most: usize,
    /// Size of the plot rectangle, px.
    size: Point,
    /// Cells that the points thinned so far cover.
    paper: Paper,
}

impl Trace {
    /// No points, of a curve that is drawn by a pen of some width in a rectangle of some size, in
    /// px. A curve of few points is kept as it is; of a long one `most` points remain at most.
    pub fn new(size: (f64, f64), pen: f64, most: usize) -> Self {
        let pen = pen / CELL;
        Self {
            points: Vec::new(),
            thinned: 0,
            most,
            size,
            paper: Paper {
                pen,
                ..Paper::default()
            },
        }
    }

    /// Adds a point.
    pub fn push(&mut self, point: (f64, f64)) {
        self.points.push(point);
        if self.points.len() - self.thinned >= self.most.min(FEW) {
            self.thin();
        }
    }

    /// Ends a line: the next point begins another one.
    pub fn lift(&mut self) {
        if self.points.last().is_some_and(|last| !last.0.is_nan()) {
            self.points.push(GAP);
        }
    }

    /// The points; one that is not finite ends a line.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut whole = self.clone();
        if self.thinned > 0 {
            whole.thin();
        }
        whole.points
    }

    /// Thins the points since the last time. Where too many remain, full areas are merged.
    fn thin(&mut self) {
        // The last point begins the part that follows.
        let tip = self.points.last().copied();
        if self.paper.holds(&self.points[self.thinned..]) {
            let rest = self.points.split_off(self.thinned);
            self.paper.thin(&rest, &mut self.points);
        } else {
            self.redraw(&[]);
        }
        if self.points.len() > self.most {
            self.redraw(&[]);
            // With room for more, which would otherwise be too many at once.
            let (full, mut gap) = (self.paper.clone(), 0);
            while self.points.len() > self.most / 4 * 3 && gap < 2 * full.across.cells {
                self.redraw(&full.areas(gap));
                gap = 2 * gap + 8;
            }
        }
        self.thinned = self.points.len();
        self.points.extend(tip);
    }

    /// Draws all lines on a new paper after others.
    fn redraw(&mut self, first: &[Point]) {
        let lines = std::mem::take(&mut self.points);
        self.paper = self.paper.blank(&lines, self.size);
        self.paper.thin(first, &mut self.points);
        self.paper.thin(&lines, &mut self.points);
    }
}

/// Ends a line.
const GAP: Point = (f64::NAN, f64::NAN);

fn is_gap(p: &Point) -> bool {
    !(p.0.is_finite() && p.1.is_finite())
}

/// A direction of the paper.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    origin: f64,
    /// Cells per unit of the data.
    scale: f64,
    cells: usize,
}

impl Edge {
    /// The edge itself if values lie on it and have some size in px, roughly; a new one over them
    /// otherwise.
    fn over(self, values: impl Iterator<Item = f64>, size: f64) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(none, |(low, high), x| (low.min(x), high.max(x)));
        // All points at one place: any scale will do.
        let extent = if high > low { high - low } else { 1.0 };
        let size = size / CELL;
        if self.holds(low) && self.holds(high) && extent * self.scale < 1.25 * size {
            return self;
        }
        let cells = ((1.0 + 2.0 * FREE) * size) as usize + 1;
        Self {
            origin: low - FREE * extent,
            scale: size / extent,
            cells,
        }
    }

    fn place(&self, x: f64) -> f64 {
        (x - self.origin) * self.scale
    }

    fn value(&self, place: f64) -> f64 {
        self.origin + place / self.scale
    }

    fn holds(&self, x: f64) -> bool {
        (0.0..self.cells as f64).contains(&self.place(x))
    }
}

/// A part of the plane in square cells, and which of them are drawn.
#[derive(Clone, Debug, Default)]
struct Paper {
    across: Edge,
    up: Edge,
    /// Width of the pen, in cells.
    pen: f64,
    /// A bit for each cell, in words of a row; those above one another are neighbours, so that a
    /// line in any direction stays in the cache.
    drawn: Vec<u64>,
}

impl Paper {
    /// An empty paper with points on it, which take the size in px.
    fn blank(&self, points: &[Point], size: Point) -> Self {
        let points = || points.iter().filter(|p| !is_gap(p));
        let across = self.across.over(points().map(|p| p.0), size.0);
        let up = self.up.over(points().map(|p| p.1), size.1);
        Self {
            across,
            up,
            pen: self.pen,
            drawn: vec![0; across.cells.div_ceil(64) * up.cells],
        }
    }

    /// Whether all points lie on it.
    fn holds(&self, points: &[Point]) -> bool {
        let mut points = points.iter().filter(|p| !is_gap(p));
        points.all(|p| self.across.holds(p.0) && self.up.holds(p.1))
    }

    fn place(&self, p: Point) -> Point {
        (self.across.place(p.0), self.up.place(p.1))
    }

    /// The cells with their centres on a line, from one place to another: in each row the first of
    /// the columns and that behind the last.
    fn cells(&self, a: Point, b: Point) -> impl Iterator<Item = (usize, Range<usize>)> + use<> {
        // A point has a length, too.
        let dot = if a == b { 0.5 } else { 0.0 };
        let (a, b) = ((a.0 - dot, a.1), (b.0 + dot, b.1));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = (dx * dx + dy * dy).sqrt();
        let (ux, uy) = (dx / length, dy / length);
        let half = 0.5 * self.pen;
        let beyond = half * ux.abs() + 0.5;
        let (low, high) = (a.1.min(b.1) - beyond + 1.0, a.1.max(b.1) + beyond);
        let rows = low as usize..(high as usize).min(self.up.cells);
        // Whole multiples of a small part of a cell are faster to add and to round down.
        let fixed = |x: f64| (x * f64::from(1 << 16)) as i64;
        // A row is cut by both sides of the line and by both ends.
        let flat = |u: f64| if u.abs() < 1e-9 { 1e-9 } else { u };
        let (lean, turn) = (ux / flat(uy), -uy / flat(ux));
        let y = rows.start as f64 + 0.5 - a.1;
        let [mut side, mut end] = [lean, turn].map(|slope| fixed(a.0 + y * slope + 0.5));
        let [lean, turn] = [lean, turn].map(fixed);
        let (wide, long) = (fixed(half / flat(uy).abs()), fixed(length / flat(ux)));
        let last = self.across.cells as i64;
        rows.map(move |row| {
            let from = (side - wide).max(end + long.min(0)).max(0) >> 16;
            let to = ((side + wide).min(end + long.max(0)) >> 16).min(last);
            (side, end) = (side + lean, end + turn);
            (row, from as usize..to.max(from) as usize)
        })
    }

    fn is_drawn(&self, a: Point, b: Point) -> bool {
        let rows = self.up.cells;
        self.cells(a, b).all(|(row, columns)| {
            bits(columns).all(|(word, bits)| self.drawn[word * rows + row] & bits == bits)
        })
    }

    fn mark(&mut self, a: Point, b: Point) {
        let rows = self.up.cells;
        for (row, columns) in self.cells(a, b) {
            bits(columns).for_each(|(word, bits)| self.drawn[word * rows + row] |= bits);
        }
    }

    /// Lines side by side in the areas that are full, apart from their rims. Where up to some
    /// number of cells are missing between two that are drawn, an area counts as full.
    fn areas(&self, gap: usize) -> Vec<Point> {
        let (words, wide) = (self.across.cells.div_ceil(64), self.pen.max(1.0) as usize);
        let mut lines = Vec::new();
        // Neighbours overlap by a cell.
        for low in (0..self.up.cells.saturating_sub(wide)).step_by((wide - 1).max(1)) {
            let is_full = |k: usize| {
                let rows = self.drawn[k * self.up.cells + low..][..wide].iter();
                match gap {
                    0 => rows.fold(u64::MAX, |all, row| all & row),
                    _ => rows.fold(0, |all, row| all | row),
                }
            };
            let y = self.up.value(low as f64 + 0.5 * wide as f64);
            let mut line = |from: usize, to: usize| {
                if to - from > 2 * wide {
                    let rim = 0.5 * self.pen;
                    let ends = [from as f64 + rim, to as f64 - rim].map(|x| self.across.value(x));
                    lines.extend([(ends[0], y), (ends[1], y), GAP]);
                }
            };
            let (mut from, mut to) = (0, 0);
            for k in 0..words {
                let (full, mut at) = (is_full(k), 0);
                while full >> at != 0 {
                    let begin = at + (full >> at).trailing_zeros();
                    let count = (full >> begin).trailing_ones();
                    at = begin + count;
                    let [begin, end] = [begin, at].map(|bit| 64 * k + bit as usize);
                    if begin > to + gap {
                        line(from, to);
                        from = begin;
                    }
                    to = end;
                    if at == 64 {
                        break;
                    }
                }
            }
            line(from, to);
        }
        lines
    }

    /// Adds the parts of lines that are not drawn yet, and marks them.
    fn thin(&mut self, points: &[Point], kept: &mut Vec<Point>) {
        let mut new = Vec::new();
        for line in points.split(is_gap) {
            self.thin_line(line, &mut new);
        }
        let scale = (self.across.scale * CELL, self.up.scale * CELL);
        for line in new.split(is_gap).filter(|line| !line.is_empty()) {
            for piece in line.chunks(PIECE) {
                kept.extend(simplify(piece, scale, INVISIBLE));
            }
            kept.push(GAP);
        }
    }

    fn thin_line(&mut self, line: &[Point], kept: &mut Vec<Point>) {
        let Some((&first, rest)) = line.split_first() else {
            return;
        };
        // While the line goes on over drawn parts: their number since the last new one, the number
        // of points up to there, and the last of them.
        let mut open: Option<(u32, usize, Point)> = None;
        let (mut from, begin) = (first, kept.len());
        for (k, &to) in rest.iter().enumerate() {
            let (a, b) = (self.place(from), self.place(to));
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length = (dx * dx + dy * dy).sqrt();
            if length < 1.0 && k + 1 < rest.len() {
                continue;
            }
            if open.is_none() && self.is_drawn(a, b) {
                from = to;
                continue;
            }
            let count = (length / PART).ceil().max(1.0);
            let along =
                |(a, b): (Point, Point), s: f64| (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
            for part in 0..count as usize {
                let [s, e] = [0.0, 1.0].map(|k| (part as f64 + k) / count);
                let [start, end] = [s, e].map(|s| along((a, b), s));
                let is_new = !self.is_drawn(start, end);
                if !is_new && open.is_none() {
                    continue;
                }
                if is_new {
                    self.mark(start, end);
                }
                let end = if e == 1.0 { to } else { along((from, to), e) };
                match (&open, kept.last_mut()) {
                    // A straight line needs no point between its ends.
                    (Some(_), Some(last)) if s > 0.0 => *last = end,
                    (Some(_), _) => kept.push(end),
                    (None, _) => kept.extend([along((from, to), s), end]),
                }
                open = match open {
                    _ if is_new => Some((0, kept.len(), end)),
                    Some((BRIDGE, ..)) => {
                        lift(&mut open, kept);
                        None
                    }
                    Some((gap, count, last)) => Some((gap + 1, count, last)),
                    None => None,
                };
            }
            from = to;
        }
        lift(&mut open, kept);
        // A line without length is a point.
        let at = self.place(first);
        if kept.len() == begin && !self.is_drawn(at, at) {
            self.mark(at, at);
            kept.extend([first, first, GAP]);
        }
    }
}

/// The words of some bits in a row, with those that are set.
fn bits(cells: Range<usize>) -> impl Iterator<Item = (usize, u64)> {
    let words = match cells.is_empty() {
        true => 0..0,
        false => cells.start / 64..(cells.end - 1) / 64 + 1,
    };
    words.map(move |word| {
        let from = cells.start.saturating_sub(64 * word);
        let to = (cells.end - 64 * word).min(64);
        (word, u64::MAX << from & u64::MAX >> (64 - to))
    })
}

/// Ends a line behind its last new part.
fn lift(open: &mut Option<(u32, usize, Point)>, kept: &mut Vec<Point>) {
    if let Some((_, count, last)) = open.take() {
        kept.truncate(count - 1);
        kept.extend([last, GAP]);
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

    /// Duffing's oscillator in a chaotic motion up to some time, x'' = x - x³ - 0.15x' + 0.3 cos t.
    fn duffing(end: usize) -> Vec<Point> {
        let rate = |t: f64, (x, v): Point| (v, x - x * x * x - 0.15 * v + 0.3 * libm::cos(t));
        let h = 0.1;
        let mut at = (1.0, 0.0);
        let step = |k: usize| {
            let (t, by) = (k as f64 * h, |k: Point, h: f64| {
                (at.0 + h * k.0, at.1 + h * k.1)
            });
            let a = rate(t, at);
            let b = rate(t + 0.5 * h, by(a, 0.5 * h));
            let c = rate(t + 0.5 * h, by(b, 0.5 * h));
            let d = rate(t + h, by(c, h));
            at = by(
                (
                    a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0,
                    a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1,
                ),
                h / 6.0,
            );
            (100.0 + 56.0 * at.0, 80.0 + 62.0 * at.1)
        };
        (0..10 * end).map(step).collect()
    }

    #[test]
    fn a_thinned_curve_looks_the_same() {
        for (name, points, most) in [
            ("area", lissajous(120, 200), 20_000),
            ("time", oscillation(800), 10_000),
            ("spiral", spiral(300), 10_000),
            ("chaos", duffing(5000), 20_000),
            ("long chaos", duffing(20_000), 20_000),
            ("little room", duffing(20_000), 5_000),
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
    fn more_points_never_take_ink_away() {
        let points = duffing(20_000);
        let mut trace = Trace::new(SIZE, PEN, 20_000);
        let mut before = vec![0; 4 * (SIZE.0 * SIZE.1) as usize];
        for part in points.chunks(50_000) {
            part.iter().for_each(|&point| trace.push(point));
            let now = picture(&trace.points());
            let lost = before.iter().zip(&now);
            let lost = lost.filter(|(before, now)| **before > **now + 4).count();
            assert!(1000 * lost <= now.len(), "{lost} of {}", now.len());
            before = now;
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
