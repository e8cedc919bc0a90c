//! Step size from the decay of a series' coefficients.

use crate::filippov::options::Options;
use crate::taylor::inverse;
use crate::taylor::row::{CoefficientRow, Lanes, lanes, lanes_of, largest, least};
use crate::taylor::series::Expansion;

/// Part of the tolerance that bounds the last coefficients. Chosen: steps are long and few, and
/// every later step amplifies the truncation error. A step is longer by 12 % with ten times it.
const TAIL_SAFETY: f64 = 0.1;

/// Largest growth from one step to the next. The series of a polynomial solution terminates and
/// would allow any step. Chosen: a step that is too long by this factor multiplies the rounding
/// error of a curved guard by its square.
pub(in crate::filippov) const MAX_GROWTH: f64 = 64.0;

/// Longest step in units of the radius of convergence, which is estimated from the ratio of the
/// terms. Chosen: a series is meaningless beyond the radius, and the estimate may be too large.
const RADIUS_PART: f64 = 0.7;

/// Power of two by which the ratio of a guard's terms may shorten the step below what state and
/// time allow. Chosen, a factor of a million: where large parts of a function cancel, its terms may
/// grow by rounding at any step.
const RATIO_REACH_LOG2: f64 = 20.0;

/// A guard's last terms indicate its growth if they exceed the first ones times this power of two.
/// It is a 256th of a unit in the last place; smaller terms do not change a value.
const SIGNIFICANT_LOG2: f64 = -60.0;

/// Exponent bias of a double.
const EXPONENT_BIAS: f64 = 1023.0;

/// Logarithm to base 2 of a normal positive number, up to 0.09 too small. This is accurate enough
/// for a root of high order.
#[inline(always)]
fn rough_log2(x: f64) -> f64 {
    /// The conversion uses half of a number's bits: the exponent and this much of the mantissa.
    const MANTISSA: f64 = (1u64 << 20) as f64;
    /// A number whose last bit is worth one. Bits placed there are added to it, in every lane at
    /// once.
    const UNIT_LAST_BIT: f64 = (1u64 << 52) as f64;
    (f64::from_bits(x.abs().to_bits() >> 32 | UNIT_LAST_BIT.to_bits()) - UNIT_LAST_BIT) / MANTISSA
        - EXPONENT_BIAS
}

/// `2^x` to 0.3 %. A step that is longer by this has an error larger by a twelfth. The inverse of
/// [`rough_log2`] would make the error four times as large.
#[inline(always)]
fn rough_exp2(x: f64) -> f64 {
    let shifted = (x + EXPONENT_BIAS).max(0.0);
    let power = shifted as i32;
    let fraction = shifted - f64::from(power);
    f64::from_bits((power as u64) << 52) * (1.0 + fraction * (0.66 + 0.34 * fraction))
}

/// Bounds a step, lane by lane, by a coefficient of power `k` if it counts. `longest` gives the
/// bound from `k`, the lane and the logarithm of the coefficient.
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

/// Bounds a step by the last `COUNT` coefficients and returns the largest of them. A series in a
/// power of the time may have zeros in all these places. Then the coefficients of the upper half
/// decide, lane by lane.
#[inline(always)]
fn bound_by_last<const L: usize, const COUNT: usize>(
    log: &mut Lanes<L>,
    (row, p): (&CoefficientRow<L>, usize),
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
            // For the series of a polynomial all are zero.
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

/// Bounds a step by the radius of convergence. It is estimated from the ratio of the largest middle
/// coefficient to the largest of the last ones.
#[inline(always)]
fn bound_by_ratio<const L: usize>(
    log: &mut Lanes<L>,
    (row, p): (&CoefficientRow<L>, usize),
    late: Lanes<L>,
) {
    let radius_part = rough_log2(RADIUS_PART);
    // In even or odd series every other coefficient is zero.
    let before = p - p / 2;
    let mut early = [0.0; L];
    for k in before - 3..=before {
        let here = lanes_of(row.at(k), f64::abs);
        early = lanes(|l| largest(early[l], here[l]));
    }
    let both = lanes(|l| least(early[l], late[l]));
    bound(log, (p / 2, both), is_positive, &|k, l, _| {
        (rough_log2(early[l]) - rough_log2(late[l])) * inverse(k) + radius_part
    });
}

/// Step length within the tolerance at time `t`, over the length `h` that scales the series. The
/// last coefficients, extrapolated with the estimated radius of convergence, fall to the tolerance
/// there (Jorba & Zou 2005, Sect. 3.2).
#[inline(always)]
pub(in crate::filippov) fn step_ratio<const L: usize, const N: usize, const G: usize>(
    rows: &[CoefficientRow<L>],
    expansion: &Expansion<G>,
    p: usize,
    options: &Options,
    (t, h): (Lanes<L>, Lanes<L>),
    x: &[Lanes<L>; N],
) -> Lanes<L> {
    let relative = options.finest();
    let tolerance = rough_log2(TAIL_SAFETY * relative);
    let wanted = tolerance * inverse(p);
    let mut log = [f64::INFINITY; L];
    for (i, (row, x)) in rows.iter().zip(x).enumerate() {
        let scale = |x: f64| rough_log2(options.allowed(i, x.abs()) / relative);
        let scale = lanes_of(*x, scale);
        let late = bound_by_last::<L, 4>(&mut log, (row, p), is_positive, |k, l, newest| {
            (scale[l] - newest) * inverse(k) + wanted
        });
        bound_by_ratio(&mut log, (row, p), late);
    }
    let shortest: Lanes<L> =
        lanes(|l| least(log[l], rough_log2((t[l] / h[l]).abs())) - RATIO_REACH_LOG2);
    log = lanes(|l| least(log[l], rough_log2(MAX_GROWTH)));
    // The truncation error of a guard or a comparison is compared with its change over the step.
    // Any of its first three terms may give that change, unless it is flatter. A function that is
    // linear in the state is as accurate as the state.
    let guards = expansion.watched.iter().flatten();
    let guards = guards.filter(|function| !function.is_linear);
    let choices = if expansion.choices_nonlinear {
        expansion.choices_among(rows)
    } else {
        &[]
    };
    for row in guards.map(|function| &rows[function.row]).chain(choices) {
        let sizes = [0, 1, 2].map(|k| lanes_of(row.at(k), f64::abs));
        let first = sizes.map(|size| lanes_of(size, |size| tolerance + rough_log2(size)));
        let moves: Lanes<L> = lanes(|l| sizes[0][l] + sizes[1][l] + sizes[2][l]);
        // NaN counts as the largest possible error.
        let late = bound_by_last::<L, 2>(
            &mut log,
            (row, p),
            |size| size != 0.0,
            |k, l, newest| {
                let against = |j: usize| (first[j][l] - newest) * inverse(k - j);
                // A function that does not change has no truncation error.
                if moves[l] != 0.0 {
                    largest(largest(against(0), against(1)), against(2))
                } else {
                    f64::INFINITY
                }
            },
        );
        // Last terms that are small against the first ones may still grow beyond them. They do not
        // count if they stay below rounding over the whole step.
        let late = lanes(|l| {
            let over_step = rough_log2(late[l]) + p as f64 * log[l];
            if over_step > rough_log2(moves[l]) + SIGNIFICANT_LOG2 {
                late[l]
            } else {
                0.0
            }
        });
        let mut by_ratio = [f64::INFINITY; L];
        bound_by_ratio(&mut by_ratio, (row, p), late);
        log = lanes(|l| least(log[l], largest(by_ratio[l], shortest[l])));
    }
    lanes_of(log, rough_exp2)
}

#[cfg(test)]
mod tests {
    use super::{MAX_GROWTH, rough_exp2, rough_log2, step_ratio};
    use crate::filippov::options::Options;
    use crate::math;
    use crate::taylor::row::CoefficientRow;
    use crate::taylor::series::{Expansion, WatchedRow};

    #[test]
    fn coefficients_of_zero_bound_no_step() {
        // A state at equilibrium at or near zero, and a guard that is its square: smallest possible
        // numbers.
        for x in [0.0, 1e-150, 1e-161, 1.0] {
            let rows = [CoefficientRow::new(), CoefficientRow::new()];
            rows[0].set(0, [x]);
            rows[1].set(0, [x * x]);
            let (row, is_linear) = (1, false);
            let expansion = Expansion {
                watched: [Some(WatchedRow { row, is_linear })],
                ..Expansion::default()
            };
            for tol in [1e-15, 1e-12, 0.1] {
                let options = Options::tol(tol);
                let [ratio] = step_ratio(&rows, &expansion, 20, &options, ([1.0], [1.0]), &[[x]]);
                assert!(
                    (ratio / MAX_GROWTH - 1.0).abs() < 3e-3,
                    "{x:e}, {tol:e}: {ratio}"
                );
            }
        }
    }

    #[test]
    fn what_was_and_is_no_more_bounds_no_step() {
        // A polynomial whose highest coefficient is the smallest possible number.
        for least in [5e-324, 1e-300, 1.0] {
            let row = CoefficientRow::new();
            row.set(0, [1.0]);
            row.set(8, [least]);
            let options = Options::tol(1e-12);
            let expansion = Expansion::<0>::default();
            let [ratio] = step_ratio(&[row], &expansion, 20, &options, ([1.0], [1.0]), &[[1.0]]);
            assert!(
                (ratio / MAX_GROWTH - 1.0).abs() < 3e-3,
                "{least:e}: {ratio}"
            );
        }
    }

    #[test]
    fn a_guard_whose_newest_coefficient_is_no_number_allows_next_to_no_step() {
        let rows = [CoefficientRow::new(), CoefficientRow::new()];
        rows[0].set(0, [1.0]);
        for k in 0..=19 {
            rows[1].set(k, [math::powi(0.5, k as i32)]);
        }
        let (row, is_linear) = (1, false);
        let expansion = Expansion {
            watched: [Some(WatchedRow { row, is_linear })],
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
        let rows = [CoefficientRow::new(), CoefficientRow::new()];
        rows[0].set(0, [1.0]);
        rows[0].set(1, [1.0]);
        rows[1].set(0, [1.0]);
        // For exp(200 t) times 1e-40.
        let mut c = 1e-40;
        for k in 1..=20 {
            c *= 200.0 / k as f64;
            rows[1].set(k, [c]);
        }
        let (row, is_linear) = (1, false);
        let expansion = Expansion {
            watched: [Some(WatchedRow { row, is_linear })],
            ..Expansion::default()
        };
        let (options, time) = (Options::tol(1e-10), ([1.0], [1.0]));
        let [ratio] = step_ratio(&rows, &expansion, 20, &options, time, &[[1.0]]);
        assert!((0.01..0.1).contains(&ratio), "{ratio}");
    }

    /// Coefficients of `1/(1 + t^m)`, with a different `m` in each lane.
    fn in_powers<const L: usize>(m: [usize; L], p: usize) -> CoefficientRow<L> {
        let row = CoefficientRow::new();
        for k in 0..=p {
            let sign = |m: usize| if (k / m).is_multiple_of(2) { 1.0 } else { -1.0 };
            row.set(
                k,
                m.map(|m| if k.is_multiple_of(m) { sign(m) } else { 0.0 }),
            );
        }
        row
    }

    /// Ratio for a state with that series, or for a constant state and a guard with that series.
    fn ratio_in_powers<const L: usize>(m: [usize; L], p: usize, of_guard: bool) -> [f64; L] {
        let at_rest = CoefficientRow::new();
        at_rest.set(0, [1.0; L]);
        let rows = if of_guard {
            [at_rest, in_powers(m, p)]
        } else {
            [in_powers(m, p), at_rest]
        };
        let (row, is_linear) = (1, !of_guard);
        let expansion = Expansion {
            watched: [Some(WatchedRow { row, is_linear })],
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
                // The neighbouring lanes have no effect.
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
