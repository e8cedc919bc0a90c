//! Minima of MINPACK's standard problems (Moré, Garbow and Hillstrom, *ACM Trans. Math. Softw.* 7
//! (1981) 17), and what the trust region does at bounds, failures and changes.

use std::convert::Infallible;

use super::*;
use stickslip::Scalar;
use stickslip::math::{atan2, cos, exp, sin};
use stickslip::scalar::Dual;

fn unbounded(count: usize) -> LeastSquaresSettings {
    LeastSquaresSettings {
        bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); count],
        loss: Loss::Squares,
        tolerance: 1e-13,
        most_evaluations: 2000,
    }
}

/// Residuals with derivatives on dual numbers.
fn on_duals<'f>(
    of: impl Fn(&[Dual<f64>]) -> Vec<Dual<f64>> + 'f,
) -> impl Fn(&Vector) -> Result<Residuals<()>, Infallible> + 'f {
    move |x| {
        let column = |k: usize| {
            let seeded: Vec<Dual<f64>> = x
                .iter()
                .enumerate()
                .map(|(j, &x)| Dual::new(x, if j == k { 1.0 } else { 0.0 }))
                .collect();
            of(&seeded)
        };
        let columns: Vec<Vec<Dual<f64>>> = (0..x.len()).map(column).collect();
        let rows = columns[0].len();
        Ok(Residuals {
            values: Vector::from_fn(rows, |i, _| columns[0][i].re),
            jacobian: Matrix::from_fn(rows, x.len(), |i, k| columns[k][i].eps),
            piece: (),
            constraints: 0,
        })
    }
}

type Duals<'d> = &'d dyn Fn(&[Dual<f64>]) -> Vec<Dual<f64>>;

/// Osborne's first data.
const OSBORNE_1: [f64; 33] = [
    0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685,
    0.658, 0.628, 0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448,
    0.438, 0.431, 0.424, 0.420, 0.414, 0.411, 0.406,
];

#[test]
fn standard_problems_have_their_minima() {
    let c = Dual::constant;
    let rosenbrock: Duals<'_> = &|x| vec![(x[1] - x[0] * x[0]) * 10.0, c(1.0) - x[0]];
    let powell: Duals<'_> = &|x| {
        let (b, d) = (x[1] - x[2] * 2.0, x[0] - x[3]);
        vec![
            x[0] + x[1] * 10.0,
            (x[2] - x[3]) * 5.0_f64.sqrt(),
            b * b,
            d * d * 10.0_f64.sqrt(),
        ]
    };
    let helical: Duals<'_> = &|x| {
        let r2 = x[0] * x[0] + x[1] * x[1];
        // The angle in turns, continued over the negative half plane.
        let turn = 2.0 * std::f64::consts::PI;
        let angle = Dual::new(
            atan2(x[1].re, x[0].re) / turn,
            (x[1].eps * x[0].re - x[0].eps * x[1].re) / (r2.re * turn),
        );
        let angle = if x[0].re < 0.0 && x[1].re < 0.0 {
            angle + 1.0
        } else {
            angle
        };
        vec![(x[2] - angle * 10.0) * 10.0, (r2.sqrt() - 1.0) * 10.0, x[2]]
    };
    let box_3d: Duals<'_> = &|x| {
        let at = |i: usize| {
            let t = 0.1 * (i + 1) as f64;
            (x[0] * -t).exp() - (x[1] * -t).exp() - x[2] * (exp(-t) - exp(-10.0 * t))
        };
        (0..10).map(at).collect()
    };
    let brown_dennis: Duals<'_> = &|x| {
        let at = |i: usize| {
            let t = (i + 1) as f64 / 5.0;
            let (a, b) = (x[0] + x[1] * t - exp(t), x[2] + x[3] * sin(t) - cos(t));
            a * a + b * b
        };
        (0..20).map(at).collect()
    };
    let osborne: Duals<'_> = &|x| {
        let at = |(i, y): (usize, &f64)| {
            let t = 10.0 * i as f64;
            c(*y) - (x[0] + x[1] * (x[3] * -t).exp() + x[2] * (x[4] * -t).exp())
        };
        OSBORNE_1.iter().enumerate().map(at).collect()
    };
    let freudenstein: Duals<'_> = &|x| {
        let y = x[1];
        vec![
            x[0] - 13.0 + ((c(5.0) - y) * y - 2.0) * y,
            x[0] - 29.0 + ((y + 1.0) * y - 14.0) * y,
        ]
    };
    let bard_data = [
        0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39,
    ];
    let bard: Duals<'_> = &|x| {
        let at = |(i, y): (usize, &f64)| {
            let (u, v) = ((i + 1) as f64, (15 - i) as f64);
            c(*y) - (x[0] + c(u) / (x[1] * v + x[2] * u.min(v)))
        };
        bard_data.iter().enumerate().map(at).collect()
    };
    let kowalik_data = [
        (0.1957, 4.0),
        (0.1947, 2.0),
        (0.1735, 1.0),
        (0.1600, 0.5),
        (0.0844, 0.25),
        (0.0627, 0.167),
        (0.0456, 0.125),
        (0.0342, 0.1),
        (0.0323, 0.0833),
        (0.0235, 0.0714),
        (0.0246, 0.0625),
    ];
    let kowalik: Duals<'_> = &|x| {
        let at =
            |&(y, u): &(f64, f64)| c(y) - x[0] * (x[1] * u + u * u) / (x[2] * u + x[3] + u * u);
        kowalik_data.iter().map(at).collect()
    };
    // Problem, start, sum of squares at the minimum, and the point where the source gives it.
    type Case<'c> = (&'c str, Duals<'c>, Vec<f64>, f64, Option<Vec<f64>>);
    let cases: [Case<'_>; 9] = [
        (
            "Rosenbrock",
            rosenbrock,
            vec![-1.2, 1.0],
            0.0,
            Some(vec![1.0, 1.0]),
        ),
        ("Powell", powell, vec![3.0, -1.0, 0.0, 1.0], 0.0, None),
        (
            "helical valley",
            helical,
            vec![-1.0, 0.0, 0.0],
            0.0,
            Some(vec![1.0, 0.0, 0.0]),
        ),
        ("box", box_3d, vec![0.0, 10.0, 20.0], 0.0, None),
        (
            "Brown and Dennis",
            brown_dennis,
            vec![25.0, 5.0, -5.0, -1.0],
            85822.2016,
            None,
        ),
        (
            "Osborne 1",
            osborne,
            vec![0.5, 1.5, -1.0, 0.01, 0.02],
            5.46489e-5,
            None,
        ),
        (
            "Freudenstein and Roth",
            freudenstein,
            vec![0.5, -2.0],
            48.9842,
            Some(vec![11.4128, -0.896805]),
        ),
        ("Bard", bard, vec![1.0, 1.0, 1.0], 8.21487e-3, None),
        (
            "Kowalik and Osborne",
            kowalik,
            vec![0.25, 0.39, 0.415, 0.39],
            3.07505e-4,
            None,
        ),
    ];
    for (name, problem, start, sum, point) in cases {
        let start = Vector::from_vec(start);
        let Ok(found) = least_squares(&start, &unbounded(start.len()), on_duals(problem));
        let own = 2.0 * found.cost;
        // The source has six digits.
        let close = (own - sum).abs() <= 5e-6 * sum + 1e-20;
        assert!(close, "{name}: {own} against {sum}, {:?}", found.end);
        assert_ne!(found.end, LeastSquaresEnd::Evaluations, "{name}");
        if let Some(point) = point {
            let off = (&found.x - Vector::from_vec(point)).amax();
            assert!(off < 1e-4, "{name}: {}", found.x);
        }
    }
}

#[test]
fn a_minimum_outside_the_bounds_is_found_on_them() {
    // Rosenbrock's with x ≤ 0.8: then y = x² is the rest's minimum.
    let of = |x: &[Dual<f64>]| vec![(x[1] - x[0] * x[0]) * 10.0, Dual::constant(1.0) - x[0]];
    let mut settings = unbounded(2);
    settings.bounds[0].1 = 0.8;
    let start = Vector::from_vec(vec![-1.2, 1.0]);
    let Ok(found) = least_squares(&start, &settings, on_duals(of));
    assert_eq!(found.x[0], 0.8);
    assert!((found.x[1] - 0.64).abs() < 1e-8, "{}", found.x);
}

#[test]
fn robust_losses_pass_over_an_outlier() {
    // A line through ten points, one of which is far off.
    let of = |x: &[Dual<f64>]| -> Vec<Dual<f64>> {
        let point = |k: usize| {
            let t = k as f64;
            let y = 2.0 * t + 1.0 + if k == 7 { 50.0 } else { 0.01 * sin(t) };
            x[0] * t + x[1] - y
        };
        (0..10).map(point).collect()
    };
    let start = Vector::from_vec(vec![0.0, 0.0]);
    for loss in [Loss::SoftL1(0.02), Loss::Huber(0.02)] {
        let settings = LeastSquaresSettings {
            loss,
            ..unbounded(2)
        };
        let Ok(found) = least_squares(&start, &settings, on_duals(of));
        assert!((found.x[0] - 2.0).abs() < 0.01, "{loss:?}: {}", found.x);
    }
    let Ok(squares) = least_squares(&start, &unbounded(2), on_duals(of));
    assert!((squares.x[0] - 2.0).abs() > 0.5, "{}", squares.x);
}

#[test]
fn robust_losses_have_the_minima_that_scipy_finds() {
    // An exponential with three outliers, and the minima of SciPy 1.17's `least_squares` with
    // `loss`, `f_scale`, `x_scale="jac"` and tolerances of 1e-15.
    let of = |x: &[Dual<f64>]| -> Vec<Dual<f64>> {
        let point = |k: usize| {
            let t = k as f64;
            let outlier = match k {
                3 => 4.0,
                9 => -2.0,
                15 => 1.5,
                _ => 0.0,
            };
            let y = 3.0 * exp(-0.2 * t) + 0.5 + 0.02 * sin(7.0 * t * t) + outlier;
            (x[0] * (x[1] * -t).exp() + x[2] - y) * 50.0
        };
        (0..20).map(point).collect()
    };
    let cases = [
        (
            Loss::Huber(1.0),
            374.85725199587745,
            [2.99394410, 0.20269838, 0.51596101],
        ),
        (
            Loss::Huber(0.3),
            113.81317141578474,
            [2.98766551, 0.20172426, 0.51800305],
        ),
        (
            Loss::Huber(5.0),
            1830.2310255988857,
            [3.00327195, 0.20357059, 0.52066569],
        ),
        (
            Loss::SoftL1(1.0),
            372.9546896083649,
            [2.99359824, 0.20278448, 0.51723701],
        ),
        (
            Loss::SoftL1(0.3),
            113.39738876673594,
            [2.98978297, 0.20237117, 0.51882931],
        ),
        (
            Loss::SoftL1(5.0),
            1794.4744286257342,
            [3.00349409, 0.20359588, 0.52085582],
        ),
    ];
    for (loss, cost, minimum) in cases {
        for start in [[1.0, 1.0, 0.0], [3.0, 0.2, 0.5], [3.0, 0.05, 0.0]] {
            let settings = LeastSquaresSettings {
                loss,
                ..unbounded(3)
            };
            let start = Vector::from_vec(start.to_vec());
            let Ok(found) = least_squares(&start, &settings, on_duals(of));
            let off = (&found.x - Vector::from_vec(minimum.to_vec())).amax();
            assert!(off < 1e-6, "{loss:?} from {start}: {off}, {:?}", found.end);
            assert!((found.cost - cost).abs() < 1e-11 * cost, "{}", found.cost);
            assert!(found.evaluations < 100, "{}", found.evaluations);
        }
    }
}

#[test]
fn the_end_at_a_jump_is_a_minimum_along_it() {
    // Beyond x + y/2 = 1, on the way to (3, 3), all residuals jump. The point of the line next to
    // (3, 3) is (0.2, 1.6).
    let of = |x: &Vector| {
        let is_beyond = x[0] + 0.5 * x[1] > 1.0;
        Ok::<_, Infallible>(Residuals {
            values: Vector::from_vec(vec![
                x[0] - 3.0,
                x[1] - 3.0,
                if is_beyond { 9.0 } else { 0.5 },
            ]),
            jacobian: Matrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
            piece: is_beyond,
            constraints: 0,
        })
    };
    for start in [[-2.0, -1.0], [0.9, -2.0], [-3.0, 6.0]] {
        let start = Vector::from_vec(start.to_vec());
        let Ok(found) = least_squares(&start, &unbounded(2), of);
        let off = (&found.x - Vector::from_vec(vec![0.2, 1.6])).amax();
        assert!(
            off < 0.05,
            "{start} {} {:?} {}",
            found.x,
            found.end,
            found.evaluations
        );
        assert_eq!(found.end, LeastSquaresEnd::Change);
        assert!(found.jumps > 0);
        // With too few evaluations to look along the line, it is no minimum.
        let settings = LeastSquaresSettings {
            most_evaluations: 40,
            ..unbounded(2)
        };
        let Ok(short) = least_squares(&start, &settings, of);
        assert_eq!(short.end, LeastSquaresEnd::Evaluations);
    }
}

#[test]
fn constraints_count_as_squares_under_any_loss() {
    // One value, at 3 by a residual that counts as a square, and at 0 by one that the loss holds.
    let both = |constraints: usize| {
        move |x: &Vector| {
            Ok::<_, Infallible>(Residuals {
                values: Vector::from_vec(vec![x[0], x[0] - 3.0]),
                jacobian: Matrix::from_element(2, 1, 1.0),
                piece: (),
                constraints,
            })
        }
    };
    let settings = LeastSquaresSettings {
        loss: Loss::Huber(0.5),
        ..unbounded(1)
    };
    let start = Vector::from_element(1, 1.0);
    // The force of the first is 0.5 there: x - 3 = -0.5.
    let Ok(found) = least_squares(&start, &settings, both(1));
    // The search ends where the cost stays to thirteen digits.
    assert!((found.x[0] - 2.5).abs() < 1e-6, "{}", found.x);
    assert!((found.cost - (0.125 + 0.5 * (2.5 - 0.25))).abs() < 1e-12);
    let Ok(found) = least_squares(&start, &settings, both(2));
    assert!((found.x[0] - 1.5).abs() < 1e-12, "{}", found.x);
}

#[test]
fn without_residuals_the_start_is_a_minimum() {
    let none = |x: &Vector| {
        Ok::<_, Infallible>(Residuals {
            values: Vector::zeros(0),
            jacobian: Matrix::zeros(0, x.len()),
            piece: (),
            constraints: 0,
        })
    };
    let start = Vector::from_element(1, 1.0);
    let Ok(found) = least_squares(&start, &unbounded(1), none);
    assert_eq!((found.x, found.cost), (start, 0.0));
}

#[test]
fn failures_shorten_steps_and_are_counted() {
    // The logarithm has no value where the first step of the residual's line leads.
    let of = |x: &Vector| match x[0] > 0.0 {
        true => Ok(Residuals {
            values: Vector::from_vec(vec![stickslip::math::ln(x[0])]),
            jacobian: Matrix::from_element(1, 1, 1.0 / x[0]),
            piece: (),
            constraints: 0,
        }),
        false => Err("no logarithm"),
    };
    let far = Vector::from_element(1, 4.0);
    let found = least_squares(&far, &unbounded(1), of).unwrap();
    assert!((found.x[0] - 1.0).abs() < 1e-12);
    assert!(found.failures > 0);
    let none = Vector::from_element(1, -1.0);
    assert_eq!(least_squares(&none, &unbounded(1), of), Err("no logarithm"));
}

/// Residuals of one variable in two pieces, with the change at 1.
fn in_pieces(
    of: impl Fn(f64) -> [f64; 4],
) -> impl Fn(&Vector) -> Result<Residuals<bool>, Infallible> {
    move |x| {
        let [a, b, of_a, of_b] = of(x[0]);
        Ok(Residuals {
            values: Vector::from_vec(vec![a, b]),
            jacobian: Matrix::from_column_slice(2, 1, &[of_a, of_b]),
            piece: x[0] > 1.0,
            constraints: 0,
        })
    }
}

#[test]
fn a_minimum_on_a_kink_is_one_and_a_jump_is_counted() {
    // The cost falls to 1 from both sides, at once.
    let kink = in_pieces(|x| {
        if x > 1.0 {
            [1.0 + 3.0 * (x - 1.0), 0.5, 3.0, 0.0]
        } else {
            [2.0 - x, 0.5, -1.0, 0.0]
        }
    });
    let start = Vector::from_element(1, -2.0);
    let Ok(found) = least_squares(&start, &unbounded(1), kink);
    assert!(
        (found.x[0] - 1.0).abs() < 1e-6,
        "{} {:?}",
        found.x,
        found.end
    );
    assert_eq!(found.jumps, 0);
    // Beyond 1 the residual is 5 larger.
    let jump = in_pieces(|x| {
        let more = if x > 1.0 { 5.0 } else { 0.0 };
        [3.0 - x + more, 0.5, -1.0, 0.0]
    });
    let Ok(found) = least_squares(&start, &unbounded(1), jump);
    assert!(found.x[0] <= 1.0 && found.x[0] > 1.0 - 1e-6 || found.x[0] > 7.0);
    assert!(found.jumps > 0 || found.x[0] > 7.0, "{found:?}");
}

#[test]
fn constraints_are_zero_at_the_minimum() {
    // The point of the parabola y = x² next to (3, 0) has 2x³ + x = 3: it is (1, 1).
    let of = |x: &Vector| {
        Ok::<_, Infallible>(Residuals {
            values: Vector::from_vec(vec![x[0] - 3.0, x[1], x[1] - x[0] * x[0]]),
            jacobian: Matrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, -2.0 * x[0], 1.0]),
            piece: (),
            constraints: 1,
        })
    };
    for start in [[0.0, 0.0], [5.0, -3.0], [2.0, 40.0]] {
        let start = Vector::from_vec(start.to_vec());
        let Ok(found) = constrained_least_squares(&start, &unbounded(2), of);
        let off = (&found.x - Vector::from_vec(vec![1.0, 1.0])).amax();
        assert!(off < 1e-6, "{start}: {}, {:?}", found.x, found.end);
        assert!(found.at.values[2].abs() < 1e-9);
    }
    // With x ≤ 0.8 it is (0.8, 0.64).
    let mut settings = unbounded(2);
    settings.bounds[0].1 = 0.8;
    let start = Vector::from_vec(vec![-0.5, 2.0]);
    let Ok(found) = constrained_least_squares(&start, &settings, of);
    assert!((found.x[0] - 0.8).abs() < 1e-12, "{}", found.x);
    assert!((found.x[1] - 0.64).abs() < 1e-8, "{}", found.x);
}

#[test]
fn a_chaotic_series_is_followed_by_its_parameter() {
    // Each value of a logistic map is an unknown, and the map a constraint. No single orbit of 60
    // values can be followed from its start: errors double each time.
    const COUNT: usize = 60;
    let truth = 3.9;
    let mut exact = vec![0.3];
    for k in 1..COUNT {
        let x: f64 = exact[k - 1];
        exact.push(truth * x * (1.0 - x));
    }
    let random = &mut numerics::SplitMix::new(7);
    let data: Vec<f64> = exact
        .iter()
        .map(|x| x + random.between(-0.01, 0.01))
        .collect();
    let of = |x: &Vector| {
        let mut values = Vector::zeros(2 * COUNT - 1);
        let mut jacobian = Matrix::zeros(2 * COUNT - 1, COUNT + 1);
        for k in 0..COUNT {
            values[k] = (x[k] - data[k]) / 0.006;
            jacobian[(k, k)] = 1.0 / 0.006;
        }
        for k in 1..COUNT {
            let (row, before) = (COUNT + k - 1, x[k - 1]);
            values[row] = x[COUNT] * before * (1.0 - before) - x[k];
            jacobian[(row, k - 1)] = x[COUNT] * (1.0 - 2.0 * before);
            jacobian[(row, k)] = -1.0;
            jacobian[(row, COUNT)] = before * (1.0 - before);
        }
        Ok::<_, Infallible>(Residuals {
            values,
            jacobian,
            piece: (),
            constraints: COUNT - 1,
        })
    };
    let start = Vector::from_iterator(COUNT + 1, data.iter().copied().chain([3.2]));
    let Ok(found) = constrained_least_squares(&start, &unbounded(COUNT + 1), of);
    assert!(
        (found.x[COUNT] - truth).abs() < 1e-3,
        "{} {:?}",
        found.x[COUNT],
        found.end
    );
    let gaps = found.at.values.rows(COUNT, COUNT - 1).amax();
    assert!(gaps < 1e-9, "{gaps}");
    assert!(found.evaluations < 60, "{}", found.evaluations);
}

#[test]
fn a_null_space_is_that_of_its_matrix() {
    let matrix = Matrix::from_row_slice(2, 4, &[1.0, 2.0, 0.0, -1.0, 0.0, 1.0, 3.0, 1.0]);
    let found = null_space(&matrix);
    assert_eq!(found.shape(), (4, 2));
    assert!((&matrix * &found).amax() < 1e-14);
    let identity = found.tr_mul(&found);
    assert!((identity - Matrix::identity(2, 2)).amax() < 1e-14);
    assert_eq!(null_space(&Matrix::zeros(0, 3)), Matrix::identity(3, 3));
}
