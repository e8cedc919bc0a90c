//! The extrapolated estimator: its bias, and the coverage of `ok`.

use super::{henon, lorenz, near, noise, spectrum, statuses, values};
use stickslip::math;
use stickslip_series::{Balance, DataSettings, Degree, Estimator, Neighbourhood, Status};

/// Hénon's map is a polynomial of second degree, so the fitted maps are exact for any size. The sum
/// of the exponents is ln 0.3 at every point, and the bias of the second, 0.02, disappears.
#[test]
fn a_quadratic_map_has_no_bias() {
    let found = spectrum(&henon(10_000), 1.0, &DataSettings::default());
    assert_eq!(statuses(&found), [Status::Ok; 2]);
    near(found.sum.0, math::ln(0.3), 1e-9);
    assert!(found.sum.1 < 1e-9);
    for (exponent, known) in found.exponents.iter().zip([0.4192, -1.6232]) {
        near(exponent.value, known, 2.0 * exponent.stderr);
        assert!(exponent.stderr < 0.005);
    }
    assert!((found.exponents[1].sano_sawada.0 + 1.6232).abs() > 0.02);
    assert_eq!(found.sizes.unwrap().degree, Degree::Quadratic);
}

/// The uncorrected exponents in the result equal those of the other estimator to the last bit.
#[test]
fn the_other_estimator_comes_along() {
    let rows = lorenz(6000);
    let linear = spectrum(&rows, 0.02, &DataSettings::sano_sawada());
    let found = spectrum(&rows, 0.02, &DataSettings::default());
    assert!(linear.sizes.is_none());
    for (a, b) in linear.exponents.iter().zip(&found.exponents) {
        assert_eq!(a.value, b.sano_sawada.0);
        assert_eq!(a.stderr, b.sano_sawada.1);
        assert_eq!((a.value, a.stderr), a.sano_sawada);
        assert_eq!(a.fixed_rank, b.fixed_rank);
    }
}

/// Lorenz' divergence is −41/3 everywhere. The third exponent, −14.572, which the data do not
/// determine, follows from it.
#[test]
fn with_the_divergence_the_exponent_that_the_data_do_not_tell_follows() {
    let found = spectrum(&lorenz(20_000), 0.02, &DataSettings::default());
    assert_eq!(
        statuses(&found),
        [Status::Ok, Status::Ok, Status::Unidentified]
    );
    near(found.exponents[1].value, 0.0, 0.02);
    let Balance::Rest {
        exponents,
        sum,
        stderr,
    } = found.balance(-41.0 / 3.0)
    else {
        panic!("{:?}", found.balance(-41.0 / 3.0));
    };
    assert_eq!(exponents, 1);
    assert!(stderr < 0.04);
    near(sum, -14.572, 2.0 * stderr);
}

#[test]
fn a_wrong_divergence_is_reported() {
    let found = spectrum(&henon(5000), 1.0, &DataSettings::default());
    let agrees = |divergence| match found.balance(divergence) {
        Balance::Whole { agrees, .. } => agrees,
        other => panic!("{other:?}"),
    };
    assert!(agrees(math::ln(0.3)));
    assert!(!agrees(math::ln(0.301)));
    // A circle traversed seven times: all points repeat, and there is no exponent.
    let rows: Vec<[f64; 2]> = (0..3000)
        .map(|i| [f64::from(i % 7), f64::from(i * 3 % 7)])
        .collect();
    let none = spectrum(&rows, 1.0, &DataSettings::default());
    assert_eq!(none.balance(0.0), Balance::Unknown);
    assert!(statuses(&none).iter().all(|&status| status != Status::Ok));
}

/// Linear maps are also extrapolated if requested or if the series is short.
#[test]
fn short_series_get_linear_maps() {
    let degree = |degree| DataSettings {
        estimator: Estimator::Extrapolated { degree },
        ..DataSettings::default()
    };
    let of = |points, settings| spectrum(&henon(points), 1.0, &settings).sizes.unwrap();
    assert_eq!(of(5000, degree(None)).neighbours, [15, 30]);
    assert_eq!(of(500, degree(None)).degree, Degree::Linear);
    assert_eq!(
        of(500, degree(Some(Degree::Quadratic))).degree,
        Degree::Quadratic
    );
    let linear = of(5000, degree(Some(Degree::Linear)));
    assert_eq!(
        (linear.degree, linear.neighbours),
        (Degree::Linear, [12, 24])
    );
    let many = DataSettings {
        neighbours: Neighbourhood::Nearest(40),
        ..DataSettings::default()
    };
    assert_eq!(of(5000, many).neighbours, [40, 80]);
    // Extrapolated linear maps have less bias than those at the smaller size, and an error that
    // reflects the uncertainty.
    let found = spectrum(&henon(5000), 1.0, &degree(Some(Degree::Linear)));
    assert!(found.exponents[1].stderr > 2.0 * found.exponents[1].sano_sawada.1);
}

/// For one column of Hénon's map, linear maps give a second exponent that is 0.1 off, many times
/// its scatter. Two sizes show less than half of that; quadratic maps reveal it. The first exponent
/// is right and stays `ok`.
#[test]
fn linear_maps_that_hide_their_bias_are_revealed_by_quadratic_ones() {
    let rows = henon(10_000);
    for points in [5000, 10_000] {
        let delayed = rows[..points]
            .windows(2)
            .map(|pair| [pair[0][0], pair[1][0]]);
        let delayed: Vec<[f64; 2]> = delayed.collect();
        let by = |degree| {
            let settings = DataSettings {
                estimator: Estimator::Extrapolated {
                    degree: Some(degree),
                },
                neighbours: Neighbourhood::Nearest(40),
                affine: true,
                ..DataSettings::default()
            };
            spectrum(&delayed, 1.0, &settings)
        };
        let (linear, quadratic) = (by(Degree::Linear), by(Degree::Quadratic));
        let [first, second] = &linear.exponents[..] else {
            panic!("{linear:?}");
        };
        assert_eq!(first.status, Status::Ok);
        assert!(first.stderr < 0.03, "{first:?}");
        near(first.value, 0.4192, 2.0 * first.stderr);
        // The bias exists, the sizes show little of it, and the error covers it.
        let bias = (second.value + 1.6232).abs();
        assert!(bias > 0.05 && second.eps_sensitivity.abs() < 0.4 * bias);
        assert!(bias <= 2.0 * second.stderr, "{second:?}");
        assert!((linear.sum.0 - math::ln(0.3)).abs() <= 2.0 * linear.sum.1);
        // Quadratic maps need no comparison.
        assert_eq!(statuses(&quadratic), [Status::Ok; 2]);
        assert!(quadratic.exponents[1].stderr < 0.02);
    }
}

/// The second exponent belongs to a direction in which neighbours are closer, so noise covers it
/// first.
#[test]
fn noise_takes_the_ok_from_what_it_covers() {
    let with = |size: f64| {
        let mut noise = noise();
        let rows: Vec<[f64; 2]> = henon(10_000)
            .iter()
            .map(|row| row.map(|v| v + size * noise.next().unwrap()))
            .collect();
        spectrum(&rows, 1.0, &DataSettings::default())
    };
    for (size, wanted) in [
        (0.0, [Status::Ok, Status::Ok]),
        (5e-4, [Status::Ok, Status::Noisy]),
        (2e-3, [Status::Noisy, Status::Noisy]),
    ] {
        let found = with(size);
        assert_eq!(statuses(&found), wanted, "{size}");
        let first = &found.exponents[0];
        assert!(first.stderr < 0.02, "{first:?}");
        near(first.value, 0.4192, 2.0 * first.stderr);
    }
}

#[test]
fn a_factor_and_the_number_of_threads_change_nothing() {
    let rows = lorenz(6000);
    let settings = DataSettings {
        affine: true,
        step: 3,
        ..DataSettings::default()
    };
    let plain = spectrum(&rows, 0.02, &settings);
    let scaled: Vec<[f64; 3]> = rows.iter().map(|row| row.map(|v| v * 1024.0)).collect();
    assert_eq!(
        format!("{:?}", values(&plain)),
        format!("{:?}", values(&spectrum(&scaled, 0.02, &settings)))
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let alone = pool.unwrap().install(|| spectrum(&rows, 0.02, &settings));
    assert_eq!(format!("{alone:?}"), format!("{plain:?}"));
}
