//! The models compared with mechanics: power, springs at rest, the limit of friction, other units.

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use replication::paper::models::{
    BeltOscillator, BeltTangency, BlockAndBracket, Caption, ForcedOscillator, Interpretation, Rig,
    Unchecked,
};
use stickslip::{Error, Fate, Filippov, Side, State, Visibility, fate};

/// A rig in physical units with no special values.
pub fn rig() -> Rig {
    Rig {
        mass: 1.7,
        inertia: 0.31,
        arm: 0.4,
        k1: 120.0,
        k2: 45.0,
        k3: 60.0,
        c1: 0.4,
        c2: 0.7,
        gravity: 9.81,
        mu0: 0.6,
        delta: 2.3,
        belt_speed: 0.8,
    }
}

/// The side of a velocity.
fn side_of(velocity: f64, belt_speed: f64) -> Side {
    if velocity < belt_speed {
        Side::Below
    } else {
        Side::Above
    }
}

fn seeded() -> Config {
    Config {
        rng_seed: RngSeed::Fixed(2013),
        failure_persistence: None,
        ..Config::default()
    }
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn what_a_rig_holds_changes_by_what_belt_and_dampers_do(
        x in -0.5..0.5f64, v in -2.0..2.0f64, y in -0.5..0.5f64, w in -2.0..2.0f64,
    ) {
        let r = rig();
        let slip = v - r.belt_speed;
        prop_assume!(slip != 0.0);
        let [dx, dv, dy, dw] = r.field(side_of(v, r.belt_speed), 0.0, &[x, v, y, w]);
        // Of ½mẋ² + ½Jφ̇² + ½k1 x² + ½k2 (x + y)² + ½k3 y², with φ = y/r.
        let gain = r.mass * v * dv
            + r.inertia * w * dw / (r.arm * r.arm)
            + r.k1 * x * dx
            + r.k2 * (x + y) * (dx + dy)
            + r.k3 * y * dy;
        let normal = (r.mass * r.gravity - r.k3 * y - r.c2 * w).max(0.0);
        let friction = r.mu0 * normal * slip.signum() / (1.0 + r.delta * slip.abs());
        let power = -friction * v - r.c1 * (v + w) * (v + w) - r.c2 * w * w;
        // Rounding of terms up to some hundreds.
        prop_assert!((gain - power).abs() < 1e-11, "{gain} {power}");
    }

    #[test]
    fn a_rig_is_its_nondimensional_form_in_other_units(x in prop::array::uniform4(-3.0..3.0f64)) {
        let r = rig();
        let scaled = r.nondimensional();
        let (length, speed) = (r.length_unit(), r.length_unit() / r.time_unit());
        let unit = [length, speed, length, speed];
        let metres: [f64; 4] = std::array::from_fn(|i| x[i] * unit[i]);
        let side = side_of(x[1], scaled.belt_speed);
        prop_assert_eq!(side, side_of(metres[1], r.belt_speed));
        let (wanted, found) = (scaled.field(side, 0.0, &x), r.field(side, 0.0, &metres));
        for i in 0..4 {
            prop_assert!((found[i] * r.time_unit() / unit[i] - wanted[i]).abs() < 1e-12);
        }
        let off = r.boundary(0.0, &metres) / speed - scaled.boundary(0.0, &x);
        prop_assert!(off.abs() < 1e-14);
    }

    /// Lengths and speeds multiplied by μ0, and the decay with speed divided by it.
    #[test]
    fn lengths_in_units_of_friction_are_another_unit_only(
        x in prop::array::uniform4(-3.0..3.0f64)
    ) {
        let caption = Caption::FIG12;
        let reading = Interpretation::scaled_by_friction();
        let scaled = BlockAndBracket::from_caption(&caption, &reading).unwrap();
        let mu0 = caption.numbers[5];
        let mut in_lengths = caption;
        in_lengths.numbers[7] /= mu0;
        in_lengths.numbers[8] *= mu0;
        let exact = BlockAndBracket::from_caption(&in_lengths, &Interpretation::exact()).unwrap();
        let side = side_of(x[1], scaled.belt_speed);
        let small = scaled.field(side, 0.0, &x);
        let large = exact.field(side, 0.0, &x.map(|v| mu0 * v));
        for i in 0..4 {
            prop_assert!((mu0 * small[i] - large[i]).abs() < 1e-12 * (1.0 + large[i].abs()));
        }
    }

    #[test]
    fn as_printed_is_equation_27_to_the_letter(x in prop::array::uniform4(-3.0..3.0f64)) {
        let [xi1, xi2, xi3, xi4, xi5, mu0, xi6, delta, speed] = Caption::FIG10.numbers;
        let literal = Interpretation::as_printed();
        let model = BlockAndBracket::from_caption(&Caption::FIG10, &literal).unwrap();
        let [x1, x2, x3, x4] = x;
        let slip = x2 - speed;
        let friction = slip.signum() * (1.0 - xi6 * x3) * mu0 / (1.0 + delta * slip.abs());
        let wanted = [
            x2,
            -x1 - xi1 * (xi2 * (x2 + x4) - x3 - friction),
            x4,
            xi3 * (-x1 - xi2 * x2 - xi4 * x3 - xi5 * x4),
        ];
        let found = model.field(side_of(x2, speed), 0.0, &x);
        for i in 0..4 {
            prop_assert!((found[i] - wanted[i]).abs() < 1e-13 * (1.0 + wanted[i].abs()));
        }
    }

    #[test]
    fn at_its_support_the_spring_of_a_forced_block_is_at_rest(
        t in 0.0..20.0f64,
        v in -2.0..2.0f64,
    ) {
        let forced = ForcedOscillator::default();
        let slip = v - forced.belt_speed;
        prop_assume!(slip != 0.0);
        let x = [forced.support(t), v];
        let [_, acceleration] = forced.field(side_of(v, forced.belt_speed), t, &x);
        let friction = forced.mu0 * slip.signum() / (1.0 + forced.delta * slip.abs());
        prop_assert!((forced.mass * acceleration + friction).abs() < 1e-14);
    }
}

/// Fig. 11 has ξ6 = μ0 k3/k2 = 0.693 and ξ4 = 1 + k3/k2 = 1.980.
#[test]
fn the_numbers_of_a_caption_fit_together() {
    let model = BlockAndBracket::from_caption(&Caption::FIG11, &Interpretation::exact()).unwrap();
    let ratio = model.bracket_stiffness - 1.0;
    assert_abs_diff_eq!(model.unloading, ratio, epsilon = 1e-3);
}

#[test]
fn a_support_is_half_way_out_a_twelfth_of_its_period_on() {
    let forced = ForcedOscillator::default();
    let half = forced.support(forced.period() / 12.0);
    assert_abs_diff_eq!(half, 0.5 * forced.amplitude, epsilon = 1e-15);
}

/// Bodies stick inside the zones and slip outside, and one field is tangent at each end. With
/// friction of √3/9 the tangent points are the two ends of each of the three zones, and no others.
#[test]
fn stick_zones_end_at_the_tangent_points_and_ride_on_the_support() {
    let belt = BeltOscillator::default();
    let forced = ForcedOscillator::default();
    let points = |t: f64| forced.tangent_points(t).unwrap();
    assert_zones(
        &belt,
        0.0,
        0.0,
        &belt.stick_zones().unwrap(),
        &belt.tangent_points().unwrap(),
    );
    for t in [0.0, 0.2, 0.9, 1.5] {
        let zones = forced.stick_zones().unwrap();
        assert_zones(&forced, t, forced.support(t), &zones, &points(t));
    }
}

fn assert_zones<S: Filippov<2>>(
    system: &S,
    t: f64,
    support: f64,
    zones: &[(f64, f64)],
    points: &[BeltTangency],
) {
    // The boundary function vanishes there.
    let speed = -system.boundary(t, &[0.0, 0.0]);
    let fate_at = |z: f64| fate(system, t, &State::from([z + support, speed]));
    assert_eq!((zones.len(), points.len()), (3, 6));
    let visible = points
        .iter()
        .filter(|at| at.visibility == Visibility::Visible);
    assert_eq!(visible.count(), 3);
    for &(low, high) in zones {
        assert!(low < high);
        let little = 1e-6 * (high - low);
        for inside in [low + little, 0.5 * (low + high), high - little] {
            assert_eq!(fate_at(inside), Fate::Stick, "{inside}");
        }
        for outside in [low - little, high + little] {
            assert_ne!(fate_at(outside), Fate::Stick, "{outside}");
        }
    }
    let ends = zones.iter().flat_map(|&(low, high)| [high, low]);
    for (end, point) in ends.zip(points) {
        assert_abs_diff_eq!(point.position, end + support, epsilon = 1e-14);
        let [_, across] = system.field(point.side, t, &[point.position, speed]);
        assert_abs_diff_eq!(across, 0.0, epsilon = 1e-13);
        let [_, across] = system.field(point.side.opposite(), t, &[point.position, speed]);
        assert!(across.abs() > 0.3, "{across}");
    }
}

#[test]
fn a_system_whose_parameters_are_not_asked_for_can_lose_contact() {
    let lifted = [0.0, 0.0, 1.0, 0.0];
    let r = Rig { mu0: -0.6, ..rig() };
    assert!(r.checked().is_err());
    // The spring k3 lifts with 60 N; the weight is 16.7 N.
    let left = Unchecked(r).contact(0.0, &lifted).unwrap();
    assert_abs_diff_eq!(left, 1.7 * 9.81 - 60.0, epsilon = 1e-13);
}

/// Asserts that a set of parameters is refused.
fn assert_refused<S: std::fmt::Debug>(checked: Result<S, Error>, parameter: &str, bad: f64) {
    let error = checked.unwrap_err();
    let named = matches!(error, Error::Parameter { name, .. } if name == parameter);
    assert!(named, "{parameter} = {bad}: {error}");
    let message = error.to_string();
    assert!(
        message.contains(&bad.to_string()) && message.contains("must be"),
        "{message}"
    );
}

#[test]
fn parameters_out_of_range() {
    type Change<S> = (&'static str, fn(&mut S, f64));
    let belt = BeltOscillator::default();
    let forced = ForcedOscillator::default();
    let not_negative_on_belt: [Change<BeltOscillator>; 4] = [
        ("mass", |belt, bad| belt.mass = bad),
        ("mu0", |belt, bad| belt.mu0 = bad),
        ("delta", |belt, bad| belt.delta = bad),
        ("belt_speed", |belt, bad| belt.belt_speed = bad),
    ];
    let not_negative_when_forced: [Change<ForcedOscillator>; 5] = [
        ("mass", |forced, bad| forced.mass = bad),
        ("mu0", |forced, bad| forced.mu0 = bad),
        ("delta", |forced, bad| forced.delta = bad),
        ("belt_speed", |forced, bad| forced.belt_speed = bad),
        ("omega", |forced, bad| forced.omega = bad),
    ];
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        for (name, change) in not_negative_on_belt {
            let mut changed = belt;
            change(&mut changed, bad);
            assert_refused(changed.checked(), name, bad);
        }
        for (name, change) in not_negative_when_forced {
            let mut changed = forced;
            change(&mut changed, bad);
            assert_refused(changed.checked(), name, bad);
        }
    }
    assert_refused(BeltOscillator { mass: 0.0, ..belt }.checked(), "mass", 0.0);
    for bad in [f64::NAN, f64::NEG_INFINITY] {
        assert_refused(BeltOscillator { k1: bad, ..belt }.checked(), "k1", bad);
        assert_refused(BeltOscillator { k2: bad, ..belt }.checked(), "k2", bad);
        let shaken = ForcedOscillator {
            amplitude: bad,
            ..forced
        };
        assert_refused(shaken.checked(), "amplitude", bad);
    }
    assert_eq!(belt.checked(), Ok(belt));
    assert_eq!(forced.checked(), Ok(forced));
}
