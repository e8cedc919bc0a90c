//! Delay, dimension and the system's own exponents from one column, for systems with known
//! dimension and spectrum.

use super::{henon, lorenz, near, noise, roessler};
use stickslip::math;
use stickslip_series::{
    DataError, DataSettings, DataSpectrum, DelayReason, DimensionReason, Embedding,
    EmbeddingChoice, EmbeddingSettings, Estimator, NO_FALSE_NEIGHBOURS, Origin, Reversal, Series,
    Status, choose_embedding, data_spectrum, lacks_columns, reversal, unwatched,
};

fn column<const N: usize>(rows: &[[f64; N]], column: usize, dt: f64) -> Series {
    Series::from_rows(rows.iter().map(|row| [row[column]]), dt).unwrap()
}

fn choice(series: &Series) -> EmbeddingChoice {
    choose_embedding(series, &EmbeddingSettings::default(), &unwatched).unwrap()
}

/// Estimates an embedded series as the program does.
fn embedded(series: &Series, embedding: Embedding) -> (DataSpectrum, Reversal) {
    let estimator = DataSettings::default().estimator;
    embedded_by(estimator, series, embedding)
}

fn embedded_by(
    estimator: Estimator,
    series: &Series,
    embedding: Embedding,
) -> (DataSpectrum, Reversal) {
    let vectors = embedding.of(series).unwrap();
    let settings = DataSettings {
        estimator,
        ..DataSettings::default()
    };
    let settings = settings.delayed(embedding.delay, &vectors);
    let spectrum = data_spectrum(&vectors, &settings).unwrap();
    let reversal = reversal(&vectors, &spectrum, &unwatched).unwrap();
    (spectrum, reversal)
}

/// The expected values are the dimensions of the state spaces. Lorenz' and Rössler's attractors
/// have dimensions below 2.1, so that 3 values suffice.
#[test]
fn false_neighbours_vanish_at_the_dimension_of_the_state_space() {
    let logistic: Vec<[f64; 1]> = std::iter::successors(Some(0.3), |x| Some(4.0 * x * (1.0 - x)))
        .take(5000)
        .map(|x| [x])
        .collect();
    for (series, dimension) in [
        (column(&logistic, 0, 1.0), 1),
        (column(&henon(5000), 0, 1.0), 2),
        (column(&lorenz(10_000), 0, 0.02), 3),
        (column(&roessler(10_000), 0, 0.1), 3),
    ] {
        let found = choice(&series);
        assert_eq!(found.embedding.dimension, dimension);
        assert_eq!(found.dimension_reason, DimensionReason::FalseNeighbours);
        assert!(!found.is_noise);
        // Cao's rule detects the end of the change, at the dimension or one above it.
        let cao = found.cao.unwrap();
        assert!((dimension..=dimension + 1).contains(&cao), "{cao}");
        let before = &found.dimensions[..dimension - 1];
        assert!(before.iter().all(|one| one.false_neighbours > 0.04));
    }
}

/// White noise has false neighbours at every dimension, and its values are independent of earlier
/// ones: Cao's E2 is 1.
#[test]
fn noise_has_no_dimension() {
    let rows: Vec<[f64; 1]> = noise().take(10_000).map(|v| [v]).collect();
    let found = choice(&column(&rows, 0, 1.0));
    assert_eq!(found.dimension_reason, DimensionReason::FewestFalse);
    assert!(found.is_noise && found.cao.is_none());
    let always = |one: &f64| *one > NO_FALSE_NEIGHBOURS;
    assert!(
        found
            .dimensions
            .iter()
            .map(|one| one.false_neighbours)
            .all(|part| always(&part))
    );
}

/// A value of a map carries the information of the next one. For Lorenz' x the first minimum is at
/// 0.16 to 0.18 (Fraser and Swinney's method as in Abarbanel, Analysis of Observed Chaotic Data,
/// 1996). For Rössler's x it is at a quarter of its period of 5.86.
#[test]
fn delays_are_those_of_the_literature() {
    let map = choice(&column(&henon(5000), 0, 1.0));
    assert_eq!(
        (map.embedding.delay, map.delay_reason),
        (1, DelayReason::Uncorrelated)
    );
    for (series, from, to) in [
        (column(&lorenz(20_000), 0, 0.02), 0.16, 0.18),
        (column(&roessler(20_000), 0, 0.1), 1.2, 1.7),
    ] {
        let found = choice(&series);
        assert_eq!(found.delay_reason, DelayReason::FirstMinimum);
        let delay = found.embedding.delay as f64 * series.dt();
        assert!((from - 1e-9..=to + 1e-9).contains(&delay), "{delay}");
        // The information decreases up to that delay.
        let curve = &found.information[1..=found.embedding.delay];
        assert!(curve.windows(2).all(|pair| pair[1].1 < pair[0].1));
    }
}

/// For a sine without noise the borders of the classes alone cause minima, for these periods at 2
/// to 4 points. The autocorrelation, cos(2π lag / period), is negative after a quarter of a period.
#[test]
fn a_clean_sine_has_the_delay_of_its_autocorrelation() {
    for (period, points) in [
        (20.0 * std::f64::consts::PI, 5000),
        (57.3, 5000),
        (100.0, 5000),
        (57.3, 20_000),
        (199.9, 20_000),
        // Lags of half a period and more are not considered.
        (900.0, 5000),
    ] {
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / period;
        let rows = (0..points).map(|i| [math::sin(angle(i))]);
        let found = choice(&Series::from_rows(rows, 1.0).unwrap());
        assert_eq!(found.delay_reason, DelayReason::OnCurve, "{period}");
        let part = found.embedding.delay as f64 / period;
        assert!(
            (part - 0.25).abs() < 0.01 + 1.0 / period,
            "{period}: {part}"
        );
        assert_eq!(found.embedding.dimension, 2, "{period}");
    }
}

/// A densely sampled series has the same minimum as at other steps, although at first neighbours in
/// time are as close as on a curve.
#[test]
fn a_dense_series_keeps_its_minimum() {
    let mut at = [1.0, 1.0, 20.0];
    let field = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let rows: Vec<[f64; 1]> = (0..40_000)
        .map(|_| {
            // Heun's method with steps of 0.001.
            let k = field(at);
            let l = field([
                at[0] + 1e-3 * k[0],
                at[1] + 1e-3 * k[1],
                at[2] + 1e-3 * k[2],
            ]);
            at = std::array::from_fn(|i| at[i] + 5e-4 * (k[i] + l[i]));
            [at[0]]
        })
        .collect();
    let found = choice(&column(&rows[5000..], 0, 0.001));
    assert_eq!(found.delay_reason, DelayReason::FirstMinimum);
    assert!(
        (150..=185).contains(&found.embedding.delay),
        "{:?}",
        found.embedding
    );
}

/// A Gaussian autoregression with φ = 0.9 loses its information without a minimum.
#[test]
fn a_correlation_that_only_decays_ends_at_independence() {
    let mut x = 0.0;
    let rows: Vec<[f64; 1]> = noise()
        .take(10_000)
        .map(|v| {
            x = 0.9 * x + v;
            [x]
        })
        .collect();
    let found = choice(&column(&rows, 0, 1.0));
    assert_eq!(found.delay_reason, DelayReason::Independent);
    // 0.9^{2·10} = 0.12 gives 0.065 nats, 0.9^{2·40} gives 1e-4.
    assert!((10..=40).contains(&found.embedding.delay));
}

/// λ1 = 0.4192. The block error over 10⁴ points is 0.004; four of these errors are allowed.
#[test]
fn henon_by_one_column() {
    let series = column(&henon(10_000), 0, 1.0);
    let (spectrum, reversal) = embedded(&series, choice(&series).embedding);
    near(spectrum.exponents[0].value, 0.4192, 0.016);
    // The sum is ln 0.3 at every point, so that the second exponent has the error of the first.
    near(spectrum.exponents[1].value, -1.6232, 0.016);
    assert_eq!(spectrum.exponents[1].status, Status::Ok);
    assert!(reversal.is_conclusive);
    assert_eq!(reversal.origins, [Origin::System; 2]);
}

/// Four values of Hénon's x give four exponents, two of them due to the embedding. The largest,
/// 0.86, is one of those: as `ok` it would be twice the true exponent. Quadratic maps find the
/// system's two exponents and no others.
#[test]
fn spurious_exponents_of_henon_in_four_dimensions_are_reported() {
    let series = column(&henon(10_000), 0, 1.0);
    let embedding = Embedding {
        delay: 1,
        dimension: 4,
    };
    let (spectrum, reversal) = embedded_by(Estimator::SanoSawada, &series, embedding);
    assert!(spectrum.exponents[0].value > 0.7 && spectrum.exponents[0].status == Status::Ok);
    use Origin::{Spurious, System};
    assert_eq!(reversal.origins, [Spurious, System, Spurious, System]);
    near(spectrum.exponents[1].value, 0.4192, 0.03);
    near(spectrum.exponents[3].value, -1.6227, 0.03);
    // With time reversed, the contraction becomes the expansion.
    near(reversal.reversed[0].0, 1.6227, 0.25);
    near(reversal.reversed[1].0, -0.4192, 0.016);
    let (spectrum, reversal) = embedded(&series, embedding);
    near(spectrum.exponents[0].value, 0.4192, 0.016);
    near(spectrum.exponents[1].value, -1.6232, 0.016);
    assert_eq!(reversal.origins, [System, System, Spurious, Spurious]);
}

/// The logistic map cannot be inverted: the reversed series is unpredictable and is not used. With
/// two values, linear maps give one exponent of 2 ln 2.
#[test]
fn a_map_without_inverse_is_judged_by_the_fit_of_fixed_rank() {
    let rows: Vec<[f64; 1]> = std::iter::successors(Some(0.3), |x| Some(4.0 * x * (1.0 - x)))
        .take(5000)
        .map(|x| [x])
        .collect();
    let embedding = Embedding {
        delay: 1,
        dimension: 2,
    };
    let series = column(&rows, 0, 1.0);
    let (spectrum, reversal) = embedded_by(Estimator::SanoSawada, &series, embedding);
    let ln2 = math::ln(2.0);
    near(spectrum.exponents[0].value, 2.0 * ln2, 0.03);
    near(spectrum.exponents[1].value, ln2, 0.03);
    assert!(!reversal.is_conclusive);
    assert_eq!(reversal.origins, [Origin::Spurious, Origin::System]);
    let (spectrum, reversal) = embedded(&series, embedding);
    near(spectrum.exponents[0].value, ln2, 0.003);
    assert_eq!(reversal.origins, [Origin::System, Origin::Spurious]);
}

/// Two coupled logistic maps, observed by x of one: 0.4146 and 0.3082. Two values determine them;
/// linear maps of full rank do not give them. The maps cannot be inverted, so no test shows that
/// the second is due to the embedding, and it is not.
#[test]
fn a_fit_of_full_rank_alone_calls_no_exponent_spurious() {
    let logistic = |r: f64, x: f64| r * x * (1.0 - x);
    let next = |&(x, y): &(f64, f64)| {
        let (f, g) = (logistic(3.9, x), logistic(3.8, y));
        Some((0.95 * f + 0.05 * g, 0.95 * g + 0.05 * f))
    };
    let states = std::iter::successors(Some((0.3, 0.6)), next).skip(1000);
    let rows: Vec<[f64; 1]> = states.take(5000).map(|(x, _)| [x]).collect();
    let embedding = Embedding {
        delay: 1,
        dimension: 2,
    };
    let (spectrum, reversal) = embedded(&column(&rows, 0, 1.0), embedding);
    assert_eq!(spectrum.dimension, 2);
    assert!(!reversal.is_conclusive);
    let second = &spectrum.exponents[1];
    assert!(second.stderr < 0.02, "{second:?}");
    near(second.value, 0.3082, 2.0 * second.stderr);
    assert!((second.fixed_rank.unwrap().0 - 0.3082).abs() > 0.25 * 0.4146);
    assert_eq!(reversal.origins, [Origin::System, Origin::Unknown]);
}

/// λ1 = 0.9056 and 0.0714. The block errors are 0.03 and 0.003; the bias of finite neighbourhoods
/// is up to 5 %.
#[test]
fn flows_by_one_column() {
    for (series, first, tolerance) in [
        (column(&lorenz(20_000), 0, 0.02), 0.9056, 0.12),
        (column(&roessler(20_000), 0, 0.1), 0.0714, 0.012),
    ] {
        let (spectrum, reversal) = embedded(&series, choice(&series).embedding);
        near(spectrum.exponents[0].value, first, tolerance);
        near(spectrum.exponents[1].value, 0.0, tolerance);
        assert_eq!(reversal.origins[..2], [Origin::System; 2]);
        assert_eq!(spectrum.exponents[2].status, Status::Unidentified);
    }
}

/// A sine with noise of a twentieth of its amplitude: the true exponent is 0. One column as a state
/// gives 47 per unit of time. In bits per period nothing of that remains.
#[test]
fn a_noisy_sine_by_one_column_has_no_positive_exponent() {
    let mut noise = noise();
    let rows: Vec<[f64; 1]> = (0..10_000)
        .map(|i| [math::sin(0.1 * f64::from(i)) + 0.1 * noise.next().unwrap()])
        .collect();
    let series = column(&rows, 0, 0.1);
    let (spectrum, _) = embedded(&series, choice(&series).embedding);
    let first = &spectrum.exponents[0];
    near(first.sano_sawada.0, 0.0, 0.05);
    assert!(first.stderr < 0.1, "{first:?}");
    near(first.value, 0.0, 2.0 * first.stderr);
    assert_ne!(first.status, Status::Ok);
}

/// All exponents of two frequencies are 0, so differences between the fits do not identify spurious
/// ones. For eight pairs, one or both exponents were wrongly called spurious.
#[test]
fn both_exponents_of_two_frequencies_are_the_system_s() {
    for ratio in [2.0, 3.0, 5.0, 7.0] {
        let value = |i: i32| {
            let t = 0.21 * f64::from(i);
            [math::sin(t) + 0.7 * math::sin(t * f64::sqrt(ratio))]
        };
        let series = Series::from_rows((0..10_000).map(value), 1.0).unwrap();
        let (spectrum, reversal) = embedded(&series, choice(&series).embedding);
        assert_eq!(spectrum.dimension, 2);
        assert_eq!(reversal.origins[..2], [Origin::System; 2], "{ratio}");
    }
}

/// The complete state has no false neighbours. Lorenz' x and y alone have some, and so do Rössler's
/// x and z.
#[test]
fn missing_columns_are_noticed() {
    let (lorenz, roessler) = (lorenz(10_000), roessler(10_000));
    let lacks = |series: Series| lacks_columns(&series, None).unwrap();
    assert!(!lacks(Series::from_rows(henon(5000), 1.0).unwrap()));
    assert!(!lacks(Series::from_rows(lorenz.clone(), 0.02).unwrap()));
    assert!(!lacks(Series::from_rows(roessler.clone(), 0.1).unwrap()));
    let two = |rows: &[[f64; 3]], a: usize, b: usize, dt| {
        Series::from_rows(rows.iter().map(|row| [row[a], row[b]]), dt).unwrap()
    };
    assert!(lacks(two(&lorenz, 0, 1, 0.02)));
    assert!(lacks(two(&roessler, 0, 2, 0.1)));
    // Two columns with delayed values of each.
    let found = choice(&two(&lorenz, 0, 1, 0.02));
    assert_eq!(found.dimension_reason, DimensionReason::FalseNeighbours);
    assert_eq!(found.embedding.dimension, 2);
}

#[test]
fn what_is_given_is_kept_and_what_cannot_be_is_refused() {
    let series = column(&henon(2000), 0, 1.0);
    let with = |delay, dimension| {
        let settings = EmbeddingSettings {
            delay,
            dimension,
            theiler: None,
        };
        choose_embedding(&series, &settings, &unwatched)
    };
    let given = with(Some(3), Some(5)).unwrap();
    assert_eq!((given.embedding.delay, given.embedding.dimension), (3, 5));
    assert_eq!(given.delay_reason, DelayReason::Given);
    assert_eq!(given.dimension_reason, DimensionReason::Given);
    for (delay, dimension, name) in [
        (Some(0), None, "delay"),
        (None, Some(0), "dimension"),
        (None, Some(11), "dimension"),
        // A tenth of the points do not determine a dimension.
        (Some(201), None, "delay"),
        (Some(usize::MAX), None, "delay"),
    ] {
        let error = with(delay, dimension).unwrap_err();
        let says = matches!(error, DataError::Setting { name: found, .. } if found == name);
        assert!(says, "{error}");
    }
    for delay in [200, 201] {
        let given = with(Some(delay), (delay > 200).then_some(2)).unwrap();
        assert_eq!(given.embedding.delay, delay);
    }
    let error = with(Some(usize::MAX), Some(2)).unwrap_err();
    assert!(
        matches!(error, DataError::Span { rows: 2000, .. }),
        "{error}"
    );
    // If windows and series leave nothing to compare, the result is no dimension and not an error.
    let wide = EmbeddingSettings {
        theiler: Some(usize::MAX),
        ..EmbeddingSettings::default()
    };
    let none = choose_embedding(&series, &wide, &unwatched).unwrap();
    assert!(none.dimensions.is_empty());
    let short = Series::from_rows([[1.0], [2.0], [3.0]], 1.0).unwrap();
    assert_eq!(choice(&short).embedding.dimension, 1);
    let constant = Series::from_rows([[1.0]; 50], 1.0).unwrap();
    let error = choose_embedding(&constant, &EmbeddingSettings::default(), &unwatched).unwrap_err();
    assert_eq!(error, DataError::Constant { rows: 50 });
}

#[test]
fn the_number_of_threads_changes_no_bit_of_an_embedding() {
    let series = column(&lorenz(4000), 0, 0.02);
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let found = choice(&series);
            let (spectrum, reversal) = embedded(&series, found.embedding);
            format!("{found:?} {spectrum:?} {reversal:?}")
        })
    });
    assert_eq!(one, two);
}
