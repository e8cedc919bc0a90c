//! Systems from files have the same orbits as the same systems compiled.

use stickslip::{Contacts, Counters, Filippov, Scalar, Several, Side, State, solve};
use stickslip_model::file::System;

use super::blocks::Block;
use super::recorded::{Event, methods, open, run};
use super::run::system as read;

/// Difference allowed for rounding.
const ALLOWED: f64 = 1e-12;

fn assert_same(name: &str, file: &[Event], compiled: &[Event]) {
    assert!(
        compiled.len() >= 4,
        "{name}: only {} transitions",
        compiled.len()
    );
    assert_eq!(file.len(), compiled.len(), "{name}");
    for (k, (one, other)) in file.iter().zip(compiled).enumerate() {
        assert_eq!((one.0, one.1), (other.0, other.1), "{name}, transition {k}");
        let near = |a: f64, b: f64| (a - b).abs() <= ALLOWED * b.abs().max(1.0);
        let states = one.3.iter().zip(&other.3);
        let all = near(one.2, other.2) && states.clone().all(|(&a, &b)| near(a, b));
        assert!(
            all,
            "{name}, transition {k}: {one:?} from the file, {other:?} compiled"
        );
    }
}

fn compare<S: Filippov<N>, const N: usize>(name: &str, file: &System, system: &S, t_end: f64) {
    let start = file.start().unwrap();
    for options in methods() {
        let x = State::<N>::from_fn(|i, _| start[i]);
        let orbit = solve(system, 0.0, x, t_end, &options).unwrap();
        let compiled: Vec<Event> = orbit
            .transitions
            .iter()
            .map(|at| (at.kind, at.contact, at.t, at.x.as_slice().to_vec()))
            .collect();
        let (ended, events) = run(file, t_end, &options);
        assert_same(name, &events, &compiled);
        let far = ended.x.iter().zip(&orbit.x_end).map(|(a, b)| (a - b).abs());
        assert!(far.fold(0.0, f64::max) <= ALLOWED, "{name}");
    }
}

#[test]
fn the_three_benchmark_problems() {
    compare("leine", &open("leine"), &Block::LEINE, 50.0);
    compare("basins", &open("basins"), &Block::BASINS, 60.0);
    compare("den-hartog", &open("den-hartog"), &Block::DEN_HARTOG, 60.0);
}

/// Two blocks on a belt, joined by a spring. Static friction is 1 and 0.9, kinetic friction 0.6 of
/// that.
struct TwoBlocks;

impl TwoBlocks {
    fn with<T: Scalar>(friction: [f64; 2], sides: &[Side; 2], x: &[T; 4]) -> [T; 4] {
        let pull = (x[1] - x[0]) * 0.5;
        [
            x[2],
            x[3],
            -x[0] + pull - friction[0] * sides[0].sign(),
            -x[1] - pull - friction[1] * sides[1].sign(),
        ]
    }
}

impl Contacts<4, 2> for TwoBlocks {
    fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, x: &[T; 4]) -> [T; 4] {
        TwoBlocks::with([0.6, 0.54], sides, x)
    }
    fn holding<T: Scalar>(&self, sides: &[Side; 2], held: &[bool; 2], _t: T, x: &[T; 4]) -> [T; 4] {
        let friction = [
            if held[0] { 1.0 } else { 0.6 },
            if held[1] { 0.9 } else { 0.54 },
        ];
        TwoBlocks::with(friction, sides, x)
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 4]) -> [T; 2] {
        [x[2] - 0.2, x[3] - 0.2]
    }
}

/// [`TwoBlocks`] as a file.
pub const TWO_BLOCKS: &str = r#"
name = "Two blocks on a belt"
[states]
x1 = "m"
x2 = "m"
v1 = "m/s"
v2 = "m/s"
[definitions]
pull = "(x2 - x1)*0.5"
[contacts.first]
boundary = "v1 - 0.2"
friction = "0.6"
static = "1"
[contacts.second]
boundary = "v2 - 0.2"
friction = "0.54"
static = "0.9"
[field]
x1 = "v1"
x2 = "v2"
v1 = "-x1 + pull - friction(first)"
v2 = "-x2 - pull - friction(second)"
[start]
x1 = 0
x2 = 0.1
v1 = 0.2
v2 = 0.2
"#;

#[test]
fn two_contacts_with_static_friction() {
    let file = read(TWO_BLOCKS);
    for options in methods() {
        let start = State::from([0.0, 0.1, 0.2, 0.2]);
        let orbit = solve(&Several(TwoBlocks), 0.0, start, 40.0, &options).unwrap();
        let compiled: Vec<Event> = orbit
            .transitions
            .iter()
            .map(|at| (at.kind, at.contact, at.t, at.x.as_slice().to_vec()))
            .collect();
        let (_, events) = run(&file, 40.0, &options);
        assert_same("two blocks", &events, &compiled);
    }
}

#[test]
fn one_contact_has_the_same_bits() {
    let file = open("leine");
    let start = file.start().unwrap();
    for options in methods() {
        let orbit = solve(
            &Block::LEINE,
            0.0,
            State::from([start[0], start[1]]),
            20.0,
            &options,
        )
        .unwrap();
        let (ended, _) = run(&file, 20.0, &options);
        assert_eq!(ended.x.as_slice(), orbit.x_end.as_slice());
        // A recorder of the whole orbit needs the dense output of every step, which calls the
        // field.
        let of = |counters: Counters| (counters.steps, counters.rejected, counters.locations);
        assert_eq!(of(ended.counters), of(orbit.counters));
    }
}
