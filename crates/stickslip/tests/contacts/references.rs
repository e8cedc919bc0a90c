//! Event times with 25 digits (`data/contacts.csv`): two blocks on a floor, a block on a block, and
//! three blocks that are pulled.

use stickslip::{Method, Mode, Options, Orbit, Several, Side, State, TransitionKind, solve};

use super::rig::Rig;

/// Two blocks on a floor, joined by a spring and driven; the third one does not move.
fn two_blocks() -> Rig<3> {
    let mut rig = Rig::at_rest();
    rig.spring(1.0, 0, None);
    rig.spring(1.0, 1, None);
    rig.spring(0.5, 0, Some(1));
    (rig.forcing[0], rig.omega) = (1.5, 0.7);
    rig.friction = [0.3, 0.4, 1.0];
    rig
}

/// A block on a block on a floor. At three events, an event at one contact releases the other at
/// the same time.
pub fn stacked() -> Rig<3> {
    let mut rig = Rig::at_rest();
    rig.masses[1] = 0.5;
    rig.spring(1.0, 0, None);
    rig.spring(0.4, 1, None);
    (rig.forcing[0], rig.omega) = (1.0, 0.8);
    rig.friction = [0.2, 0.15, 1.0];
    rig.sits_on[1] = Some(0);
    rig
}

/// Three blocks in a row, pulled at the last.
fn pulled() -> Rig<3> {
    let mut rig = Rig::at_rest();
    for (i, next) in [(0, None), (0, Some(1)), (1, Some(2)), (2, None)] {
        rig.spring(2.0, i, next);
    }
    rig.pull[2] = 2.0 * 0.5;
    rig.friction = [0.5, 0.4, 0.6];
    rig
}

/// The mode of a contact in the table: the sign of its side, 0 where it holds.
fn sign(mode: Mode) -> i32 {
    match mode {
        Mode::Slip(Side::Below) => -1,
        Mode::Slip(Side::Above) => 1,
        Mode::Stick => 0,
    }
}

/// The signs of the first contacts in a column of the table.
fn signs(column: &str) -> Vec<i32> {
    column
        .split(' ')
        .map(|sign| sign.parse().unwrap())
        .collect()
}

/// Compares an orbit with the table: event times within the tolerance at their time, and its end.
fn agrees(
    problem: &str,
    orbit: &Orbit<6, [Mode; 3]>,
    end: &[f64; 6],
    allowed: impl Fn(f64) -> f64,
) {
    let table = include_str!("../data/contacts.csv");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .filter(|row: &Vec<&str>| row[0] == problem)
        .collect();
    let events: Vec<_> = orbit
        .transitions
        .iter()
        .filter(|at| at.kind != TransitionKind::Touch)
        .collect();
    for (row, at) in rows.iter().zip(&events) {
        let t: f64 = row[2].parse().unwrap();
        let (before, after) = (signs(row[4]), signs(row[5]));
        let of = |mode: [Mode; 3]| mode.map(sign)[..before.len()].to_vec();
        let what = format!("{problem}, event {}: {at:?}", row[1]);
        assert_eq!((of(at.from), of(at.to)), (before.clone(), after), "{what}");
        assert_eq!(at.contact + 1, row[3].parse::<usize>().unwrap(), "{what}");
        let off = (at.t - t).abs();
        assert!(off <= allowed(t), "{what}: off by {off:e}");
    }
    assert_eq!(events.len(), rows.len(), "{problem}");
    let off = (orbit.x_end - State::from(*end)).amax();
    assert!(
        off <= 30.0 * allowed(1.0),
        "{problem}: the end is off by {off:e}"
    );
}

fn every_reference(options: &Options, allowed: impl Fn(f64) -> f64 + Copy) {
    let orbit = |rig: Rig<3>, x: [f64; 6], t_end: f64| {
        solve(&Several(rig), 0.0, x, t_end, options).unwrap()
    };
    agrees(
        "P11",
        &orbit(two_blocks(), [1.0, -0.5, 0.0, 0.0, 0.5, 0.0], 30.0),
        &[
            -0.199_261_643_172_225_73,
            0.385_629_192_372_055_05,
            0.0,
            -1.296_567_391_071_457_5,
            -0.547_087_345_615_390_9,
            0.0,
        ],
        allowed,
    );
    agrees(
        "P12",
        &orbit(stacked(), [0.0; 6], 40.0),
        &[
            1.705_310_546_758_702_4,
            1.241_037_523_528_370_3,
            0.0,
            -0.101_553_665_919_499_42,
            -0.883_545_084_694_417_6,
            0.0,
        ],
        allowed,
    );
    let three = orbit(pulled(), [0.0; 6], 20.0);
    let mut end = [0.0; 6];
    end[..3].copy_from_slice(&[
        2.121_809_448_351_372_4,
        4.490_014_173_477_191,
        7.105_132_429_956_624,
    ]);
    end[3..].copy_from_slice(&three.x_end.as_slice()[3..]);
    agrees("P13", &three, &end, allowed);
}

#[test]
fn event_times_by_runge_kutta() {
    every_reference(&Options::tol(1e-13), |_| 1e-11);
}

#[test]
fn event_times_by_taylor() {
    every_reference(&Options::tol(1e-15).method(Method::Taylor), |t| {
        2e-13 * t.max(1.0)
    });
}
