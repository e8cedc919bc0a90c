//! The elimination against dense decompositions of the same matrices, and on chains whose
//! multipliers are known.

use numerics::SplitMix;

use super::*;

/// A number between -1 and 1.
fn drawn(random: &mut SplitMix) -> f64 {
    2.0 * random.uniform() - 1.0
}

/// A chain of so many links between states of so many components, closed by random equations, with
/// its groups; the first state comes last.
fn chain(links: usize, states: usize, random: &mut SplitMix) -> (Vec<SparseRow>, Vec<Vec<usize>>) {
    let state = |k: usize| k * states..(k + 1) * states;
    let mut rows = Vec::new();
    for link in 0..links {
        for i in state(link + 1) {
            let mut row: SparseRow = state(link).map(|j| (j, drawn(random))).collect();
            row.push((i, -1.0));
            rows.push(row);
        }
    }
    for _ in 0..states {
        let ends = state(0).chain(state(links));
        rows.push(ends.map(|j| (j, drawn(random))).collect());
    }
    let groups = (1..=links).chain([0]).map(|k| state(k).collect());
    (rows, groups.collect())
}

fn dense(rows: &[SparseRow], columns: usize) -> Matrix {
    let mut matrix = Matrix::zeros(rows.len(), columns);
    for (i, row) in rows.iter().enumerate() {
        for &(j, value) in row {
            matrix[(i, j)] += value;
        }
    }
    matrix
}

#[test]
fn solutions_are_those_of_the_dense_matrix() {
    let random = &mut SplitMix::new(65);
    for (links, states) in [(1, 1), (1, 4), (2, 3), (5, 2), (9, 5)] {
        let (rows, groups) = chain(links, states, random);
        let matrix = dense(&rows, rows.len());
        let right = Vector::from_fn(rows.len(), |_, _| drawn(random));
        let found = Elimination::of(&rows, &groups);
        let lu = matrix.clone().lu();
        let scale = lu.try_inverse().unwrap().amax() * right.amax() * rows.len() as f64;
        let exact = matrix.clone().lu().solve(&right).unwrap();
        let off = (found.solve(&right).unwrap() - &exact).amax();
        assert!(off <= 1e-14 * scale, "{links} {states}: {off:e}");
        let exact = matrix.transpose().lu().solve(&right).unwrap();
        let off = (found.solve_transposed_regularised(&right).unwrap() - exact).amax();
        assert!(off <= 1e-14 * scale, "{links} {states}: {off:e}");
        // With a 1 at one component of the first state, the others make the equations' residual
        // least: it is orthogonal to their columns.
        let mut scaled = matrix.clone();
        for mut row in scaled.row_iter_mut() {
            let length = row.norm();
            row /= length;
        }
        let others = scaled.columns(states, links * states);
        for (free, solution) in found.fundamental().unwrap().iter().enumerate() {
            let first = Vector::from_fn(states, |i, _| solution[i]);
            let unit = Vector::from_fn(states, |i, _| f64::from(u8::from(i == free)));
            assert_eq!(first, unit);
            let slope = others.tr_mul(&(&scaled * solution)).amax();
            assert!(slope <= 1e-14 * scale.max(solution.amax()), "{slope:e}");
        }
    }
}

#[test]
fn determinants_are_those_of_the_dense_matrix() {
    let random = &mut SplitMix::new(66);
    for (links, states) in [(1, 1), (1, 3), (2, 2), (3, 3), (7, 2)] {
        for _ in 0..8 {
            let (rows, groups) = chain(links, states, random);
            let exact = dense(&rows, rows.len()).determinant();
            let found = Elimination::of(&rows, &groups).determinant();
            let off = (found.over_power(0) / exact - 1.0).abs();
            assert!(off < 1e-10, "{links} {states}: {found:?} {exact}");
        }
    }
}

/// The 20th power of 10^100 and of 10^-100: beyond the range of numbers, and below it.
#[test]
fn determinants_have_any_size() {
    for (entry, exponent, mantissa) in [
        (1e100, 6643, 1.810251033812138),
        (1e-100, -6644, 1.1048191453249867),
    ] {
        let rows: Vec<SparseRow> = (0..20).map(|k| vec![(k, entry)]).collect();
        let groups: Vec<Vec<usize>> = (0..20).map(|k| vec![k]).collect();
        let found = Elimination::of(&rows, &groups).determinant();
        assert_eq!(found.exponent, exponent, "{found:?}");
        let off = found.over_power(exponent) / mantissa - 1.0;
        assert!(off.abs() < 1e-14, "{found:?}");
    }
}

#[test]
fn singular_equations_have_no_solution_but_a_direction() {
    // Two states that are equal, twice.
    let rows = vec![vec![(0, 1.0), (1, -1.0)], vec![(0, 2.0), (1, -2.0)]];
    let found = Elimination::of(&rows, &[vec![1], vec![0]]);
    assert!(found.determinant().over_power(0).abs() <= 4.0 * f64::EPSILON);
    let right = Vector::from_vec(vec![1.0, 0.0]);
    assert!(found.solve(&right).is_none());
    let solutions = found.fundamental().unwrap();
    let off = (&solutions[0] - Vector::from_vec(vec![1.0, 1.0])).amax();
    // A dozen roundings of half a unit each, of terms up to 1.4 times as large as the result.
    assert!(off <= 8.0 * f64::EPSILON, "{off:e}");
    let direction = found.solve_regularised(&right).unwrap();
    let ratio = direction[0] / direction[1];
    assert!(
        (ratio - 1.0).abs() < 1e-15 && direction[0].abs() > 1e14,
        "{direction}"
    );
    // Too few equations.
    let fewer = Elimination::of(&rows[..1], &[vec![1], vec![0]]);
    assert!(fewer.solve(&Vector::from_vec(vec![1.0])).is_none());
    let one = &fewer.fundamental().unwrap()[0];
    let off = (one - Vector::from_vec(vec![1.0, 1.0])).amax();
    assert!(off <= f64::EPSILON, "{off:e}");
}

#[test]
fn singular_values_are_those_of_the_dense_matrix() {
    let random = &mut SplitMix::new(67);
    for (rows, columns) in [(1, 1), (5, 2), (9, 4), (30, 6)] {
        let matrix = Matrix::from_fn(rows, columns, |_, j| {
            drawn(random) * crate::math::powi(0.01, j as i32)
        });
        let all: Vec<Vector> = matrix.column_iter().map(|one| one.into_owned()).collect();
        let found = singular(&all);
        let mut exact: Vec<f64> = matrix
            .clone()
            .svd(false, false)
            .singular_values
            .iter()
            .copied()
            .collect();
        exact.sort_by(f64::total_cmp);
        for ((value, vector), exact) in found.iter().zip(exact) {
            assert!((value / exact - 1.0).abs() < 1e-10, "{value:e} {exact:e}");
            assert!((vector.norm() - 1.0).abs() < 1e-14);
            let length = (&matrix * vector).norm();
            assert!((length / value - 1.0).abs() < 1e-12, "{length:e} {value:e}");
        }
    }
}

/// The links of 64 loops: in each, the components along axes that turn from loop to loop grow by
/// the 64th root of a multiplier.
fn loops(multipliers: &[f64], random: &mut SplitMix) -> Vec<Matrix> {
    const LOOPS: usize = 64;
    let n = multipliers.len();
    let axes: Vec<Matrix> = (0..LOOPS)
        .map(|_| Matrix::from_fn(n, n, |_, _| drawn(random)).qr().q())
        .collect();
    let root = |multiplier: f64| crate::math::exp(crate::math::ln(multiplier) / LOOPS as f64);
    let growth = Vector::from_iterator(n, multipliers.iter().map(|&one| root(one)));
    let link =
        |k: usize| &axes[(k + 1) % LOOPS] * Matrix::from_diagonal(&growth) * axes[k].transpose();
    (0..LOOPS).map(link).collect()
}

/// The equations of a closed chain of links: each maps a state to the next one, and the last to a
/// multiple of the first. With the groups of its columns.
fn closed(links: &[Matrix], multiple: f64) -> (Vec<SparseRow>, Vec<Vec<usize>>) {
    let (count, n) = (links.len(), links[0].nrows());
    let state = |k: usize| (k % count) * n;
    let mut rows: Vec<SparseRow> = Vec::new();
    for (k, link) in links.iter().enumerate() {
        let by_next = if k + 1 == count { -multiple } else { -1.0 };
        for i in 0..n {
            let mut row: SparseRow = (0..n).map(|j| (state(k) + j, link[(i, j)])).collect();
            row.push((state(k + 1) + i, by_next));
            rows.push(row);
        }
    }
    let groups = (1..count).chain([0]);
    (
        rows,
        groups.map(|k| (state(k)..state(k) + n).collect()).collect(),
    )
}

/// The solution has the residual and the error of that of the dense matrix, for an orbit of 64
/// loops with multipliers from 1e-30 to 1e8. The chain closes with a multiple of its start where
/// that is a multiplier, to nine digits: the product of the links has an error of 1e-8 instead.
#[test]
fn multipliers_far_apart_leave_the_residual_of_the_dense_matrix() {
    let random = &mut SplitMix::new(68);
    let multipliers = [1e8, 3.0, 1e-3, 1e-30];
    let links = loops(&multipliers, random);
    let (rows, groups) = closed(&links, 1.0);
    let count = rows.len();
    let matrix = dense(&rows, count);
    let exact = Vector::from_fn(count, |_, _| drawn(random));
    let right = &matrix * &exact;
    let found = Elimination::of(&rows, &groups).solve(&right).unwrap();
    let other = matrix.clone().lu().solve(&right).unwrap();
    let residual = |x: &Vector| (&matrix * x - &right).amax();
    let error = |x: &Vector| (x - &exact).amax();
    let [own, others] = [&found, &other].map(|x| (residual(x), error(x)));
    assert!(
        own.0 <= 4.0 * others.0.max(f64::EPSILON),
        "{own:?} {others:?}"
    );
    assert!(own.1 <= 4.0 * others.1, "{own:?} {others:?}");
    for multiplier in &multipliers[..3] {
        let signs = [-1e-9, 1e-9].map(|off| {
            let (rows, groups) = closed(&links, multiplier * (1.0 + off));
            Elimination::of(&rows, &groups).determinant().over_power(0)
        });
        assert!(signs[0] * signs[1] < 0.0, "{multiplier:e}: {signs:?}");
    }
}
