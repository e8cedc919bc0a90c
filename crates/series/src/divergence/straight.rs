//! The straight part of a divergence curve.

use super::BLOCKS;

/// A factor of e in logarithms, the time scale of an exponent. A straight part rises by at least
/// this much. It ends this much below the level of saturation, above which folding bends the curve.
const E_FOLD: f64 = 1.0;
/// Fewest points of a straight part, three more than a line has parameters.
const FEWEST_POINTS: usize = 5;
/// Least fraction of the whole rise that a straight part has. A shorter piece may be straight by
/// coincidence, and its growth is that of a few places only.
const LEAST_RISE: f64 = 0.5;
/// Largest scatter of a straight part about its line, as a fraction of the rise. Chosen.
const LARGEST_SCATTER: f64 = 0.05;

/// The part of a curve from which an exponent is taken. Of all parts that end before the curve
/// levels off, it has the smallest scatter about its least-squares line, relative to its rise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightPart {
    /// Index of its first point.
    pub from: usize,
    /// Index of its last point.
    pub to: usize,
    /// The slope, per unit of time: the exponent.
    pub slope: f64,
    /// Standard error of the slope, from those of eight blocks of points over the same part.
    pub stderr: f64,
    /// Root mean square distance of the points from the line, as a fraction of its rise.
    pub scatter: f64,
}

impl StraightPart {
    /// First and last point of the line, to be drawn with the curve `points` that it belongs to.
    pub fn line(&self, points: &[(f64, f64)]) -> Option<[(f64, f64); 2]> {
        let (first, last) = (points.get(self.from)?, points.get(self.to)?);
        let inside = &points[self.from..=self.to];
        let count = inside.len() as f64;
        let t = inside.iter().map(|point| point.0).sum::<f64>() / count;
        let mean = inside.iter().map(|point| point.1).sum::<f64>() / count;
        Some([first, last].map(|end| (end.0, mean + self.slope * (end.0 - t))))
    }
}

/// Selects the straight part of `curve`, which has one value per time step. `blocks` holds the same
/// for parts of the data, and `level` is where the curve levels off.
pub(crate) fn straight_part(
    curve: &[f64],
    blocks: &[[f64; BLOCKS]],
    level: f64,
    dt: f64,
) -> Option<StraightPart> {
    let top = level - E_FOLD;
    let end = curve
        .iter()
        .position(|v| v.is_nan() || *v >= top)
        .unwrap_or(curve.len());
    let curve = &curve[..end];
    let highest = curve.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = curve
        .first()
        .map_or(E_FOLD, |first| E_FOLD.max(LEAST_RISE * (highest - first)));
    let mut best: Option<(f64, usize, usize)> = None;
    for from in 0..curve.len() {
        let mut sums = Sums::default();
        for (k, v) in curve.iter().enumerate().skip(from) {
            sums.add((k - from) as f64, v - curve[from]);
            if k - from + 1 < FEWEST_POINTS {
                continue;
            }
            let (slope, rest) = sums.line();
            let rise = slope * (k - from) as f64;
            if rise < least {
                continue;
            }
            let scatter = rest / rise;
            if scatter < LARGEST_SCATTER && best.is_none_or(|best| scatter < best.0) {
                best = Some((scatter, from, k));
            }
        }
    }
    let (scatter, from, to) = best?;
    let slope = |values: &mut dyn Iterator<Item = f64>| {
        let mut sums = Sums::default();
        values.enumerate().for_each(|(k, v)| sums.add(k as f64, v));
        sums.line().0 / dt
    };
    let all = slope(&mut curve[from..=to].iter().copied());
    let parts: [f64; BLOCKS] =
        std::array::from_fn(|b| slope(&mut blocks[from..=to].iter().map(|row| row[b])));
    let mean = parts.iter().sum::<f64>() / BLOCKS as f64;
    let squares: f64 = parts.iter().map(|part| (part - mean) * (part - mean)).sum();
    Some(StraightPart {
        from,
        to,
        slope: all,
        stderr: (squares / (BLOCKS - 1) as f64 / BLOCKS as f64).sqrt(),
        scatter,
    })
}

/// Sums for a line of least squares.
#[derive(Default)]
struct Sums {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Sums {
    fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Slope, and root mean square of the residuals per degree of freedom.
    fn line(&self) -> (f64, f64) {
        let xx = self.xx - self.x * self.x / self.n;
        let xy = self.xy - self.x * self.y / self.n;
        let yy = self.yy - self.y * self.y / self.n;
        let slope = xy / xx;
        let rest = (yy - slope * xy).max(0.0);
        (slope, (rest / (self.n - 2.0)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A transient, a line of slope 0.5 per point with a wiggle, and a plateau at 0.
    fn curve() -> Vec<f64> {
        let transient = [-9.0, -7.5, -6.8];
        let line = (0..11).map(|k| -6.5 + 0.5 * f64::from(k) + 0.01 * f64::from(k % 2));
        let plateau = [-1.2, -0.7, -0.3, -0.1, 0.0, 0.0, 0.0];
        transient.into_iter().chain(line).chain(plateau).collect()
    }

    #[test]
    fn the_straight_part_leaves_out_transient_and_saturation() {
        let curve = curve();
        let blocks: Vec<[f64; BLOCKS]> = curve.iter().map(|&v| [v; BLOCKS]).collect();
        let found = straight_part(&curve, &blocks, 0.0, 0.1).unwrap();
        assert!(
            found.from >= 2 && found.to <= 14 && found.to - found.from > 7,
            "{found:?}"
        );
        assert!((found.slope - 5.0).abs() < 0.1, "{found:?}");
        assert!(found.stderr < 1e-12);
        let times: Vec<(f64, f64)> = (0..).map(|k| 0.1 * f64::from(k)).zip(curve).collect();
        let [first, last] = found.line(&times).unwrap();
        assert!(((last.1 - first.1) / (last.0 - first.0) - found.slope).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_grow_by_a_factor_of_e_has_no_straight_part() {
        let none = |curve: &[f64]| {
            let blocks = vec![[0.0; BLOCKS]; curve.len()];
            straight_part(curve, &blocks, 0.0, 1.0).is_none()
        };
        assert!(none(&[-3.0; 30]));
        assert!(none(&[]));
        // As far apart as any two points from the start.
        assert!(none(&[-4.0, -0.1, 0.0, 0.0, 0.0, 0.0, 0.0]));
        assert!(none(&[f64::NAN; 10]));
    }
}
