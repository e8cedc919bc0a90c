//! Several contacts with jumps, from functions in Rust.

use approx::assert_relative_eq;
use stickslip::analysis::Monodromy;
use stickslip::dynamics::{AsDynamics, Jumps, Moment, OrbitEvent, RecordedOrbit, Sampling};
use stickslip::dynamics::{Vector, WithJumps};
use stickslip::{
    Contacts, Direction, Method, Mode, Options, Scalar, Several, Side, TransitionKind,
};

/// Two blocks that slide on a floor. States: positions, then velocities.
struct Sliding;

impl Contacts<4, 2> for Sliding {
    fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, x: &[T; 4]) -> [T; 4] {
        let [first, second] = sides.map(|side| T::constant(side.sign()));
        [x[2], x[3], -first, second * -0.5]
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 4]) -> [T; 2] {
        [x[2], x[3]]
    }
}

/// A wall at 1, from which the first block comes back with half its speed.
struct Wall;

impl Jumps<4> for Wall {
    fn count(&self) -> usize {
        1
    }
    fn direction(&self, _: usize) -> Direction {
        Direction::Falling
    }
    fn when<T: Scalar>(&self, _: usize, _t: T, x: &[T; 4]) -> T {
        -x[0] + 1.0
    }
    fn set<T: Scalar>(&self, _: usize, _t: T, x: &[T; 4]) -> [T; 4] {
        [T::one(), x[1], x[2] * -0.5, x[3]]
    }
}

/// The speed at the wall is √(v² − 2(1 − x)) from x and v. Friction stops the block a quarter of
/// half its square behind it, at 3/4 from v = 2. The other block stops at t = 2.
#[test]
fn a_block_comes_back_from_a_wall_and_sticks() {
    let blocks = WithJumps {
        system: Several(Sliding),
        jumps: Wall,
    };
    let start = Moment {
        t: 0.0,
        x: vec![0.0, 0.0, 2.0, 1.0].into(),
    };
    for options in [Method::Taylor, Method::Dop853].map(|method| Options {
        method,
        ..Options::tol(1e-12)
    }) {
        let sampling = Sampling::Nowhere;
        let system = blocks.dynamics();
        let (orbit, ended) =
            RecordedOrbit::solve(&*system, &start, 3.0, &options, &[], sampling).expect("begins");
        ended.expect("ends");
        let root = 2.0_f64.sqrt();
        let known = [2.0 - root, 2.0 - root / 2.0, 2.0];
        let times: Vec<f64> = orbit.events.iter().map(OrbitEvent::t).collect();
        assert_eq!(times.len(), known.len(), "{times:?}");
        for (t, known) in times.iter().zip(known) {
            assert_relative_eq!(*t, known, epsilon = 1e-11);
        }
        let first = orbit.transitions().next().expect("a jump");
        assert_eq!(first.kind, TransitionKind::Jump);
        assert_relative_eq!(orbit.events[0].before()[2], root, epsilon = 1e-11);
        assert_relative_eq!(orbit.events[0].after()[2], -root / 2.0, epsilon = 1e-11);
        let last = orbit.phases.last().expect("phases").mode;
        assert_eq!([last.get(0), last.get(1)], [Mode::Stick; 2]);
        let end = Vector::from_column_slice(&[0.75, 1.0, 0.0, 0.0]);
        assert_relative_eq!(orbit.end.x, end, epsilon = 1e-11);

        let map = Monodromy::of(&blocks, 0.0, &start.x, 3.0, &options).expect("a derivative");
        let known = [-0.25, 0.0, -0.5, 0.0, 0.0, 1.0, 0.0, 2.0];
        for (column, known) in known.iter().enumerate() {
            let (row, column) = (column / 4, column % 4);
            assert_relative_eq!(map.matrix[(row, column)], *known, epsilon = 1e-10);
        }
    }
}
