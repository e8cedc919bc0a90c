//! Two-folds reached by sliding and by crossings. No orbit of random systems differs between the
//! two methods.

use numerics::SplitMix;
use stickslip::Visibility::{self, Invisible, Visible};
use stickslip::{
    Approach, AtRepelling, Ending, Filippov, Method, Mode, Options, Orbit, Scalar, Side,
    TransitionKind, TwoFold,
};

use crate::any_system::solve;

/// The normal form of a two-fold (Teixeira 1990): above `(-y, s⁺, V⁺)`, below `(z, V⁻, s⁻)`, Σ at x
/// = 0, the two-fold at 0. It is visible above for s⁺ = −1 and below for s⁻ = −1. Orbits slide
/// where y, z > 0.
pub struct Folds {
    pub s: [f64; 2],
    pub v: [f64; 2],
}

impl Filippov<3> for Folds {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        match side {
            Side::Above => [-x[1], T::constant(self.s[1]), T::constant(self.v[1])],
            Side::Below => [x[2], T::constant(self.v[0]), T::constant(self.s[0])],
        }
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 3]) -> T {
        x[0]
    }
}

/// Random systems of two kinds, in one type so that the solver is compiled once.
pub enum Random {
    /// Quadratic fields with a cubic brake, which keeps orbits bounded. Each side and component has
    /// a constant, three linear and six quadratic coefficients. Σ is the plane x = 0, moved to and
    /// fro.
    Quadratic {
        fields: Box<[[[f64; 10]; 3]; 2]>,
        moved: f64,
        at_rate: f64,
    },
    /// A block on a belt under a load that depends on time, which is the third state. The load may
    /// become a pull: friction then drives.
    Forced {
        force: f64,
        friction: f64,
        load: f64,
        decay: f64,
        belt: f64,
        rate: f64,
    },
}

impl Random {
    fn quadratic(random: &mut SplitMix) -> Self {
        let mut fields = Box::new([[[0.0; 10]; 3]; 2]);
        for coefficient in fields.iter_mut().flatten().flatten() {
            *coefficient = random.between(-1.0, 1.0);
        }
        Random::Quadratic {
            fields,
            moved: 0.0,
            at_rate: 0.0,
        }
    }

    fn moving(random: &mut SplitMix) -> Self {
        let mut system = Random::quadratic(random);
        if let Random::Quadratic { moved, at_rate, .. } = &mut system {
            (*moved, *at_rate) = (random.between(0.05, 0.5), random.between(0.5, 3.0));
        }
        system
    }

    fn forced(random: &mut SplitMix) -> Self {
        Random::Forced {
            force: random.between(0.0, 2.0),
            friction: random.between(0.1, 1.0),
            load: random.between(0.0, 2.0),
            decay: random.between(0.0, 3.0),
            belt: random.between(-1.0, 1.0),
            rate: random.between(0.3, 3.0),
        }
    }
}

impl Filippov<3> for Random {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &[T; 3]) -> [T; 3] {
        match self {
            Random::Quadratic { fields, .. } => {
                let of_side = &fields[usize::from(side == Side::Above)];
                let terms = [
                    x[0],
                    x[1],
                    x[2],
                    x[0] * x[0],
                    x[0] * x[1],
                    x[0] * x[2],
                    x[1] * x[1],
                    x[1] * x[2],
                    x[2] * x[2],
                ];
                std::array::from_fn(|i| {
                    let mut sum = -(x[i] * x[i] * x[i]) + of_side[i][0];
                    for (term, coefficient) in terms.iter().zip(&of_side[i][1..]) {
                        sum = sum + *term * *coefficient;
                    }
                    sum
                })
            }
            Random::Forced {
                force,
                friction,
                load,
                decay,
                belt,
                rate,
            } => {
                // The signed slip velocity, not its modulus: each side's field extends beyond Σ.
                let slip = (x[1] - *belt) * side.sign();
                let normal = x[2].sin() * *load + 1.0;
                let resists = normal / (slip * *decay + 1.0) * (*friction * side.sign());
                let push = x[2].cos() * *force - x[1] * 0.1;
                [x[1], push - x[0] - resists, T::constant(*rate)]
            }
        }
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 3]) -> T {
        match self {
            Random::Quadratic { moved, at_rate, .. } => x[0] - (t * *at_rate).sin() * *moved,
            Random::Forced { belt, .. } => x[1] - *belt,
        }
    }
}

fn methods() -> [Options; 2] {
    [
        Options::tol(1e-11),
        Options::tol(1e-13).method(Method::Taylor),
    ]
}

const SLIDING: [(Visibility, Visibility, Folds); 4] = [
    (
        Invisible,
        Invisible,
        Folds {
            s: [1.0, 1.0],
            v: [-3.0, -3.0],
        },
    ),
    (
        Visible,
        Visible,
        Folds {
            s: [-1.0, -1.0],
            v: [-3.0, -3.0],
        },
    ),
    (
        Visible,
        Invisible,
        Folds {
            s: [-1.0, 1.0],
            v: [-3.0, -1.0],
        },
    ),
    (
        Invisible,
        Visible,
        Folds {
            s: [1.0, -1.0],
            v: [-1.0, -3.0],
        },
    ),
];

#[test]
fn sliding_orbits_end_at_a_two_fold_that_is_reported_with_its_kind() {
    for options in methods() {
        for (below, above, folds) in SLIDING {
            // On the line y = z both decrease at the same rate, (V⁻ + s⁺)/2 = (V⁺ + s⁻)/2.
            let start = -1.5 * 0.5 * (folds.v[0] + folds.s[1]);
            let orbit = solve(&folds, 0.0, [0.0, start, start], 5.0, &options).expect("runs");
            let expected = TwoFold {
                below,
                above,
                approach: Approach::Sliding,
            };
            assert_eq!(orbit.ending, Ending::TwoFold(expected), "{options:?}");
            assert_eq!((orbit.phases.len(), orbit.transitions.len()), (1, 0));
            assert!((orbit.t_end - 1.5).abs() < 1e-6, "{}", orbit.t_end);
            assert!(orbit.x_end.amax() < 1e-6, "{}", orbit.x_end);
            assert_eq!(orbit.phases[0].t_end, orbit.t_end);
        }
    }
}

#[test]
fn where_the_fields_agree_there_is_no_two_fold() {
    // Both fields are (z, -1, -1) where y + z = 0: an orbit that slides up to it continues
    // unchanged.
    let folds = Folds {
        s: [-1.0, -1.0],
        v: [-1.0, -1.0],
    };
    for options in methods() {
        let orbit = solve(&folds, 0.0, [0.0, 1.5, 1.5], 5.0, &options).expect("runs");
        assert_eq!(orbit.ending, Ending::Repelling);
        assert!((orbit.t_end - 1.5).abs() < 1e-9, "{}", orbit.t_end);
    }
}

#[test]
fn an_open_set_of_sliding_orbits_ends_there_at_the_same_time_by_both_methods() {
    // Both eigenvalues of the sliding flow are negative, and its slow direction lies where orbits
    // slide.
    let (below, above, folds) = &SLIDING[0];
    let ends = |start: [f64; 3]| {
        methods().map(|options| {
            let orbit = solve(folds, 0.0, start, 9.0, &options).expect("runs");
            let expected = TwoFold {
                below: *below,
                above: *above,
                approach: Approach::Sliding,
            };
            assert_eq!(orbit.ending, Ending::TwoFold(expected), "{start:?}");
            orbit.t_end
        })
    };
    for y in [0.3, 0.7, 1.0, 1.6] {
        let [by_runge_kutta, by_taylor] = ends([0.0, y, 1.0]);
        assert!(
            (by_runge_kutta - by_taylor).abs() < 1e-6,
            "{by_runge_kutta} {by_taylor}"
        );
    }
}

#[test]
fn who_wants_to_goes_on_to_a_side_that_is_visible() {
    let (_, _, folds) = &SLIDING[1];
    for options in methods() {
        for (choice, side) in [
            (AtRepelling::GoBelow, Side::Below),
            (AtRepelling::GoAbove, Side::Above),
        ] {
            let options = options.at_repelling(choice);
            // At rate 2.
            let orbit = solve(folds, 0.0, [0.0, 3.0, 3.0], 3.0, &options).expect("runs");
            assert_eq!(orbit.ending, Ending::EndTime);
            let exit = orbit.transitions[0];
            assert_eq!(
                (exit.kind, exit.to),
                (TransitionKind::StickExit, Mode::Slip(side))
            );
            assert!((exit.t - 1.5).abs() < 1e-6);
            // From the two-fold above: y = -t, x = t²/2; below z = -t, x = -t²/2.
            let after = 3.0 - exit.t;
            assert!((orbit.x_end[0] - 0.5 * after * after * side.sign()).abs() < 1e-5);
        }
    }
}

#[test]
fn crossings_that_spiral_in_end_at_the_two_fold() {
    // A turn of two crossings halves this start, which lies on the stable direction of the return
    // map. Rounding errors double.
    let folds = Folds {
        s: [1.0, 1.0],
        v: [-1.125, -1.0],
    };
    let size = 1e-4;
    for mut options in methods() {
        (options.pile_up_count, options.pile_up_span) = (20, 1e-3);
        let orbit = solve(&folds, 0.0, [0.0, -0.75 * size, size], 1.0, &options).expect("runs");
        let expected = TwoFold {
            below: Invisible,
            above: Invisible,
            approach: Approach::Crossings,
        };
        assert_eq!(orbit.ending, Ending::TwoFold(expected));
        // Flights last -2y above and -2z below: 1.5 and 1 sizes in the first turn.
        assert!((orbit.t_end - 5.0 * size).abs() < 1e-6, "{}", orbit.t_end);
    }
}

/// The course of an orbit: its transitions, and its end.
fn course(orbit: &Orbit<3>) -> Vec<(TransitionKind, Mode)> {
    let changes = orbit
        .transitions
        .iter()
        .filter(|at| at.kind != TransitionKind::Touch);
    changes.map(|at| (at.kind, at.to)).collect()
}

/// Outcomes of random orbits.
#[derive(Debug, Default)]
struct Counts {
    to_the_end: usize,
    two_folds: usize,
    sticks: usize,
}

/// Every orbit has the same course with both methods.
fn same_way(systems: usize, make: fn(&mut SplitMix) -> Random) -> Counts {
    let mut random = SplitMix::new(2013);
    let mut counts = Counts::default();
    for number in 0..systems {
        let system = make(&mut random);
        let start = std::array::from_fn(|_| random.between(-1.0, 1.0));
        let [by_runge_kutta, by_taylor] = methods().map(|options| {
            solve(&system, 0.0, start, 8.0, &options)
                .unwrap_or_else(|failure| panic!("{number}: {options:?}: {}", failure.error))
        });
        let what = format!(
            "{number}: {:?} at {} and {:?} at {}",
            by_runge_kutta.ending, by_runge_kutta.t_end, by_taylor.ending, by_taylor.t_end
        );
        assert_eq!(by_runge_kutta.ending, by_taylor.ending, "{what}");
        assert_eq!(course(&by_runge_kutta), course(&by_taylor), "{what}");
        assert!(
            (by_runge_kutta.t_end - by_taylor.t_end).abs() < 1e-6,
            "{what}"
        );
        counts.to_the_end += usize::from(by_runge_kutta.ending == Ending::EndTime);
        counts.two_folds += usize::from(matches!(by_runge_kutta.ending, Ending::TwoFold(_)));
        counts.sticks += course(&by_runge_kutta)
            .iter()
            .filter(|(kind, _)| *kind == TransitionKind::StickEntry)
            .count();
    }
    counts
}

// Nearly all run to the end, many stick, and some end at two-folds. Otherwise nothing would be
// tested.

#[test]
fn random_quadratic_fields_go_the_same_way_by_both_methods() {
    let counts = same_way(3000, Random::quadratic);
    assert!(
        counts.to_the_end > 2950 && counts.two_folds >= 3 && counts.sticks > 1000,
        "{counts:?}"
    );
}

#[test]
fn random_fields_with_a_moving_boundary_go_the_same_way_by_both_methods() {
    let counts = same_way(2000, Random::moving);
    assert!(
        counts.to_the_end > 1950 && counts.two_folds >= 1 && counts.sticks > 1000,
        "{counts:?}"
    );
}

#[test]
fn random_forced_friction_goes_the_same_way_by_both_methods() {
    // Where the load vanishes a stick has ended before, unless nothing pushes.
    let counts = same_way(2000, Random::forced);
    assert!(
        counts.to_the_end > 1950 && counts.sticks > 1000,
        "{counts:?}"
    );
}
