//! Statistics of residuals, by fits of a constant to given values.

use stickslip::math;
use stickslip_model::study::fit::{Fit, RunsTest, fit};

use super::fit::{observable, record, request, times, unknown};
use super::run::parsed;

/// A constant fitted to columns of as many values, within bounds.
fn constant(columns: Vec<Vec<f64>>, bounds: (f64, f64)) -> Fit {
    let file = parsed("name = \"case\"\n[states]\nx = \"\"\n[field]\nx = \"0\"\n[start]\nx = 0\n");
    let mut unknown = unknown("x", Some(bounds.0.max(-1.0)));
    unknown.bounds = bounds;
    let observables = columns.iter().map(|_| observable("x", None)).collect();
    let mut request = request(file, vec![unknown], observables);
    request
        .records
        .push(record(&times(columns[0].len() as u32, 0.01), columns));
    fit(&request).unwrap_or_else(|error| panic!("{error}"))
}

/// The test of the residuals of a column about its mean.
fn runs(column: Vec<f64>) -> Option<RunsTest> {
    constant(vec![column], (f64::NEG_INFINITY, f64::INFINITY)).columns[0].runs
}

#[test]
fn intervals_have_the_quantiles_of_tables() {
    for (freedom, value) in [
        (1, 12.7062),
        (2, 4.3027),
        (3, 3.1824),
        (5, 2.5706),
        (10, 2.2281),
        (30, 2.0423),
        (1000, 1.9623),
    ] {
        let column = (0..=freedom).map(|k| f64::from(k % 2)).collect();
        let found = constant(vec![column], (f64::NEG_INFINITY, f64::INFINITY));
        let own = found.uncertainty.quantile;
        assert!((own - value).abs() < 1.2e-3, "{freedom}: {own}");
        let one = &found.values[0];
        let half = one.interval.unwrap().1 - one.value;
        assert!((half / one.std_error.unwrap() - own).abs() < 1e-9);
    }
}

#[test]
fn runs_tell_noise_from_a_remainder() {
    let random = &mut numerics::SplitMix::new(5);
    let noise = (0..200).map(|_| random.between(-1.0, 1.0)).collect();
    assert!(!runs(noise).unwrap().is_systematic());
    let slow = (0..200).map(|k| math::sin(0.1 * f64::from(k))).collect();
    assert!(runs(slow).unwrap().p_value < 1e-20);
    // The bound keeps the constant below all values.
    let one_sided = constant(vec![vec![1.0; 40]], (-1.0, 0.0));
    assert!(one_sided.columns[0].runs.unwrap().p_value < 1e-9);
    assert_eq!(runs((0..8).map(f64::from).collect()), None);
}

#[test]
fn a_hundredth_of_the_columns_of_noise_raise_a_false_alarm() {
    let random = &mut numerics::SplitMix::new(6);
    let mut noise = || (0..100).map(|_| random.between(-1.0, 1.0)).collect();
    let columns = (0..2000).map(|_| noise()).collect();
    let found = constant(columns, (f64::NEG_INFINITY, f64::INFINITY));
    let tests = found.columns.iter().map(|column| column.runs.unwrap());
    let alarms = tests.filter(RunsTest::is_systematic).count();
    assert!((5..=40).contains(&alarms), "{alarms}");
}
