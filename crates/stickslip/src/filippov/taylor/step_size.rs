//! How far a series reaches within the tolerance.

use crate::filippov::options::Options;
use crate::taylor::inverse;
use crate::taylor::row::{Lanes, Row, lanes, lanes_of, largest, least};
use crate::taylor::series::Expansion;

/// Part of the tolerance that the last coefficients are held to: the steps are long and few, and
/// all of the next ones enlarge what one leaves out.
const SAFETY: f64 = 0.1;

/// Growth of the step from one to the next at most. The series of a polynomial solution ends and
/// would allow any; but over a step that is too long by this factor a guard that bends is known to
/// rounding times its square, and no better are its grazes. One very near the start of a very long
/// step is badly resolved.
pub(in crate::filippov) const GROW_MOST: f64 = 64.0;

/// Longest step in units of the radius of convergence as the terms' own ratio tells it: beyond it a
/// series means nothing, however small its terms.
const FARTHEST: f64 = 0.7;

/// Powers of two by which the ratio of a guard's terms may make a step shorter than the state
/// allows and than the time: a millionth. Terms may grow by rounding alone, where a function's
/// large parts cancel, at any step.
const FINEST: f64 = 20.0;

/// Powers of two by which a guard's last terms may be smaller than its first ones and still tell of
/// how it grows: down to a 256th of a unit in the last place.
const FAINTEST: f64 = -60.0;

/// What the exponent in a number's bits is more than its own.
const BIAS: f64 = 1023.0;

/// Logarithm to base 2 of a normal positive number, up to 0.09 too small: good enough for a root of
/// high order.
#[inline(always)]
fn rough_log2(x: f64) -> f64 {
    /// Half a number's bits hold its exponent, and as much of the rest as this; no more is
    /// converted.
    const MANTISSA: f64 = (1u64 << 20) as f64;
    /// A number whose last bit is worth one: what is put there is added to it, in every lane at
    /// once.
    const WHOLE: f64 = (1u64 << 52) as f64;
    (f64::from_bits(x.abs().to_bits() >> 32 | WHOLE.to_bits()) - WHOLE) / MANTISSA - BIAS
}

/// `2^x` to three parts in a thousand: a step that is longer by that has an error larger by a
/// twelfth. The inverse of [`rough_log2`] would make it four times as large.
#[inline(always)]
fn rough_exp2(x: f64) -> f64 {
    let shifted = (x + BIAS).max(0.0);
    let power = shifted as i32;
    let rest = shifted - f64::from(power);
    f64::from_bits((power as u64) << 52) * (1.0 + rest * (0.66 + 0.34 * rest))
}

/// Bounds a step, lane by lane, by a coefficient of power `k` if it counts: by `longest` of `k`,
/// the lane and the coefficient's logarithm.
#[inline(always)]
fn bound<const L: usize>(
    log: &mut Lanes<L>,
    (k, size): (usize, Lanes<L>),
    counts: impl Fn(f64) -> bool,
    longest: &impl Fn(usize, usize, f64) -> f64,
) {
    *log = lanes(|l| {
        let longest = longest(k, l, rough_log2(size[l]));
        let bounded = least(log[l], longest);
        if counts(size[l]) { bounded } else { log[l] }
    });
}

/// Bounds a step by the coefficients by which it is told how far a series reaches: the last
/// `COUNT`. Of a series in a power of the time these may all be zero; then it is told by those of
/// the upper half, lane by lane. Returns the largest of the last.
#[inline(always)]
fn bound_by_last<const L: usize, const COUNT: usize>(
    log: &mut Lanes<L>,
    (row, p): (&Row<L>, usize),
    counts: impl Fn(f64) -> bool + Copy,
    longest: impl Fn(usize, usize, f64) -> f64,
) -> Lanes<L> {
    let size = |k: usize| lanes_of(row.at(k), f64::abs);
    let mut late = [0.0; L];
    for k in p + 1 - COUNT..=p {
        let here = size(k);
        late = lanes(|l| largest(late[l], here[l]));
        bound(log, (k, here), counts, &longest);
    }
    if late.contains(&0.0) {
        for k in p / 2 + 1..p + 1 - COUNT {
            let here = size(k);
            // Of a polynomial's series all are zero.
            if here != [0.0; L] {
                let counted = lanes(|l| if late[l] == 0.0 { here[l] } else { 0.0 });
                bound(log, (k, counted), counts, &longest);
            }
        }
    }
    late
}

#[inline(always)]
fn is_positive(size: f64) -> bool {
    size > 0.0
}

/// Bounds a step by the radius of convergence, as the terms' own ratio tells it: the largest of the
/// middle to the largest of the last.
#[inline(always)]
fn bound_by_ratio<const L: usize>(log: &mut Lanes<L>, (row, p): (&Row<L>, usize), late: Lanes<L>) {
    let farthest = rough_log2(FARTHEST);
    // Even or odd series have every other coefficient zero.
    let before = p - p / 2;
    let mut early = [0.0; L];
    for k in before - 3..=before {
        let here = lanes_of(row.at(k), f64::abs);
        early = lanes(|l| largest(early[l], here[l]));
    }
    let both = lanes(|l| least(early[l], late[l]));
    bound(log, (p / 2, both), is_positive, &|k, l, _| {
        (rough_log2(early[l]) - rough_log2(late[l])) * inverse(k) + farthest
    });
}

/// Step length within the tolerance, over that, `h`, which the series is scaled with, at `t`: where
/// the last coefficients, extrapolated by the radius of convergence that they tell, have fallen to
/// the tolerance (Jorba & Zou 2005, Sect. 3.2).
#[inline(always)]
pub(in crate::filippov) fn step_ratio<const L: usize, const N: usize, const G: usize>(
    rows: &[Row<L>],
    expansion: &Expansion<G>,
    p: usize,
    options: &Options,
    (t, h): (Lanes<L>, Lanes<L>),
    x: &[Lanes<L>; N],
) -> Lanes<L> {
    let relative = options.rtol.max(options.atol);
    let tolerance = rough_log2(SAFETY * relative);
    let wanted = tolerance * inverse(p);
    let mut log = [f64::INFINITY; L];
    for (row, x) in rows.iter().zip(x) {
        let scale = |x: f64| rough_log2((options.atol + options.rtol * x.abs()) / relative);
        let scale = lanes_of(*x, scale);
        let late = bound_by_last::<L, 4>(&mut log, (row, p), is_positive, |k, l, newest| {
            (scale[l] - newest) * inverse(k) + wanted
        });
        bound_by_ratio(&mut log, (row, p), late);
    }
    let finest: Lanes<L> = lanes(|l| least(log[l], rough_log2((t[l] / h[l]).abs())) - FINEST);
    log = lanes(|l| least(log[l], rough_log2(GROW_MOST)));
    // What a guard's series leaves out, or that of a comparison, against how far it moves in the
    // step: by any of its first three terms, unless it is flatter than that. What is linear in the
    // state is as good as that.
    let guards = expansion.watched.iter().flatten();
    let guards = guards.filter(|function| !function.is_linear);
    let choices = if expansion.choices_bend {
        expansion.choices_among(rows)
    } else {
        &[]
    };
    for row in guards.map(|function| &rows[function.row]).chain(choices) {
        let sizes = [0, 1, 2].map(|k| lanes_of(row.at(k), f64::abs));
        let first = sizes.map(|size| lanes_of(size, |size| tolerance + rough_log2(size)));
        let moves: Lanes<L> = lanes(|l| sizes[0][l] + sizes[1][l] + sizes[2][l]);
        // One that is no number is as far off as can be.
        let late = bound_by_last::<L, 2>(
            &mut log,
            (row, p),
            |size| size != 0.0,
            |k, l, newest| {
                let against = |j: usize| (first[j][l] - newest) * inverse(k - j);
                // One that does not move has nothing left out.
                if moves[l] != 0.0 {
                    largest(largest(against(0), against(1)), against(2))
                } else {
                    f64::INFINITY
                }
            },
        );
        // One that is small against its first terms may yet grow to more than they are, unless over
        // the whole step it is too small for rounding to tell it from nothing.
        let late = lanes(|l| {
            let over_step = rough_log2(late[l]) + p as f64 * log[l];
            if over_step > rough_log2(moves[l]) + FAINTEST {
                late[l]
            } else {
                0.0
            }
        });
        let mut by_ratio = [f64::INFINITY; L];
        bound_by_ratio(&mut by_ratio, (row, p), late);
        log = lanes(|l| least(log[l], largest(by_ratio[l], finest[l])));
    }
    lanes_of(log, rough_exp2)
}

#[cfg(test)]
mod tests {
    use super::{GROW_MOST, rough_exp2, rough_log2, step_ratio};
    use crate::filippov::options::Options;
    use crate::math;
    use crate::taylor::row::Row;
    use crate::taylor::series::{Expansion, Watched};

    #[test]
    fn coefficients_of_zero_bound_no_step() {
        // A state at rest, near zero or at it, and a guard that is its square: as small as a number
        // can be.
        for x in [0.0, 1e-150, 1e-161, 1.0] {
            let rows = [Row::new(), Row::new()];
            rows[0].set(0, [x]);
            rows[1].set(0, [x * x]);
            let (row, is_linear) = (1, false);
            let expansion = Expansion {
                watched: [Some(Watched { row, is_linear })],
                ..Expansion::default()
            };
            for tol in [1e-15, 1e-12, 0.1] {
                let options = Options::tol(tol);
                let [ratio] = step_ratio(&rows, &expansion, 20, &options, ([1.0], [1.0]), &[[x]]);
                assert!(
                    (ratio / GROW_MOST - 1.0).abs() < 3e-3,
                    "{x:e}, {tol:e}: {ratio}"
                );
            }
        }
    }

    #[test]
    fn what_was_and_is_no_more_bounds_no_step() {
        // Of a polynomial whose highest power is as small as a number can be.
        for least in [5e-324, 1e-300, 1.0] {
            let row = Row::new();
            row.set(0, [1.0]);
            row.set(8, [least]);
            let options = Options::tol(1e-12);
            let expansion = Expansion::<0>::default();
            let [ratio] = step_ratio(&[row], &expansion, 20, &options, ([1.0], [1.0]), &[[1.0]]);
            assert!((ratio / GROW_MOST - 1.0).abs() < 3e-3, "{least:e}: {ratio}");
        }
    }

    #[test]
    fn a_guard_whose_newest_coefficient_is_no_number_allows_next_to_no_step() {
        let rows = [Row::new(), Row::new()];
        rows[0].set(0, [1.0]);
        for k in 0..=19 {
            rows[1].set(k, [math::powi(0.5, k as i32)]);
        }
        let (row, is_linear) = (1, false);
        let expansion = Expansion {
            watched: [Some(Watched { row, is_linear })],
            ..Expansion::default()
        };
        let ratio = || {
            step_ratio(
                &rows,
                &expansion,
                20,
                &Options::tol(1e-10),
                ([1.0], [1.0]),
                &[[1.0]],
            )[0]
        };
        rows[1].set(20, [math::powi(0.5, 20)]);
        assert!((0.1..2.0).contains(&ratio()), "{}", ratio());
        rows[1].set(20, [f64::NAN]);
        assert!(ratio() < 1e-10, "{}", ratio());
    }

    #[test]
    fn a_guard_that_is_tiny_and_grows_bounds_the_step_of_a_state_whose_series_ends() {
        let rows = [Row::new(), Row::new()];
        rows[0].set(0, [1.0]);
        rows[0].set(1, [1.0]);
        rows[1].set(0, [1.0]);
        // Of exp(200 t) times 1e-40.
        let mut c = 1e-40;
        for k in 1..=20 {
            c *= 200.0 / k as f64;
            rows[1].set(k, [c]);
        }
        let (row, is_linear) = (1, false);
        let expansion = Expansion {
            watched: [Some(Watched { row, is_linear })],
            ..Expansion::default()
        };
        let (options, time) = (Options::tol(1e-10), ([1.0], [1.0]));
        let [ratio] = step_ratio(&rows, &expansion, 20, &options, time, &[[1.0]]);
        assert!((0.01..0.1).contains(&ratio), "{ratio}");
    }

    /// Coefficients of `1/(1 + t^m)`, lane by lane with `m`.
    fn in_powers<const L: usize>(m: [usize; L], p: usize) -> Row<L> {
        let row = Row::new();
        for k in 0..=p {
            let sign = |m: usize| if (k / m).is_multiple_of(2) { 1.0 } else { -1.0 };
            row.set(
                k,
                m.map(|m| if k.is_multiple_of(m) { sign(m) } else { 0.0 }),
            );
        }
        row
    }

    /// The same of a state with that series, or of one at rest and a guard with it.
    fn ratio_in_powers<const L: usize>(m: [usize; L], p: usize, of_guard: bool) -> [f64; L] {
        let at_rest = Row::new();
        at_rest.set(0, [1.0; L]);
        let rows = if of_guard {
            [at_rest, in_powers(m, p)]
        } else {
            [in_powers(m, p), at_rest]
        };
        let (row, is_linear) = (1, !of_guard);
        let expansion = Expansion {
            watched: [Some(Watched { row, is_linear })],
            ..Expansion::default()
        };
        step_ratio(
            &rows,
            &expansion,
            p,
            &Options::tol(1e-8),
            ([1.0; L], [1.0; L]),
            &[[1.0; L]],
        )
    }

    #[test]
    fn a_series_in_a_power_of_the_time_reaches_no_farther_than_it_converges() {
        for of_guard in [false, true] {
            for p in 12..=24 {
                let ratios = [1, 2, 3, 4, 5, 6].map(|m| ratio_in_powers([m], p, of_guard)[0]);
                assert!(
                    ratios.iter().all(|&r| r < 1.0),
                    "{p} {of_guard}: {ratios:?}"
                );
                // What is beside it in another lane changes nothing.
                let together = ratio_in_powers([1, 2, 3, 4, 5, 6], p, of_guard);
                assert_eq!(together, ratios, "{p} {of_guard}");
            }
        }
    }

    #[test]
    fn rough_powers_and_logarithms_are_as_good_as_said() {
        for i in -4000..4000 {
            let x = f64::from(i) / 40.0;
            let exact = math::exp(x * std::f64::consts::LN_2);
            assert!((rough_exp2(x) / exact - 1.0).abs() < 3e-3, "{x}");
            let short = x - rough_log2(exact);
            assert!((-1e-12..0.09).contains(&short), "{x}: {short}");
        }
        assert_eq!(rough_exp2(-2000.0), 0.0);
    }
}
