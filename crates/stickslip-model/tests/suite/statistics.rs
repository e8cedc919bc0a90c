//! Statistics of residuals.

use stickslip::math;
use stickslip_model::study::fit::{quantile, runs_test};

#[test]
fn quantiles_are_those_of_tables() {
    for (freedom, value) in [
        (1, 12.7062),
        (2, 4.3027),
        (3, 3.1824),
        (5, 2.5706),
        (10, 2.2281),
        (30, 2.0423),
        (1000, 1.9623),
    ] {
        let own = quantile(Some(freedom));
        assert!((own - value).abs() < 1.2e-3, "{freedom}: {own}");
    }
}

#[test]
fn runs_tell_noise_from_a_remainder() {
    let noise: Vec<f64> = {
        let random = &mut numerics::SplitMix::new(5);
        (0..200).map(|_| random.between(-1.0, 1.0)).collect()
    };
    assert!(!runs_test(&noise).unwrap().is_systematic());
    let slow: Vec<f64> = (0..200).map(|k| math::sin(0.1 * f64::from(k))).collect();
    assert!(runs_test(&slow).unwrap().p_value < 1e-20);
    let one_sided = vec![1.0; 40];
    assert!(runs_test(&one_sided).unwrap().p_value < 1e-9);
    assert_eq!(runs_test(&[1.0; 8]), None);
    // In 2000 series of noise there are about 20 false alarms.
    let random = &mut numerics::SplitMix::new(6);
    let alarms = (0..2000).filter(|_| {
        let noise: Vec<f64> = (0..100).map(|_| random.between(-1.0, 1.0)).collect();
        runs_test(&noise).unwrap().is_systematic()
    });
    let alarms = alarms.count();
    assert!((5..=40).contains(&alarms), "{alarms}");
}
