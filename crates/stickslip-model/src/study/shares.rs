//! Standard errors of the shares of basins of attraction.

/// Standard error of the share of one attractor among independent random starts. `reached` has the
/// number of the attractor of each start.
pub fn error_of_random(reached: &[u32], number: u32) -> f64 {
    let all = reached.len() as f64;
    let share = reached.iter().filter(|&&one| one == number).count() as f64 / all;
    (share * (1.0 - share) / all).sqrt()
}

/// Standard error of the share of one attractor among the starts of a grid, row by row.
///
/// On a grid only the cells that the boundary of a basin cuts are wrong, and as many cells are cut
/// as neighbours differ. Each pair of these has the variance 1/4, by the successive differences of
/// systematic sampling (Wolter, *Introduction to Variance Estimation*, 2007, Ch. 8). Along `n`
/// cells in a row the boundary may be straight: all are then wrong by the same part, which has the
/// variance 1/12. Errors of smooth curves are up to three times less.
pub fn error_of_grid(reached: &[u32], columns: usize, number: u32) -> f64 {
    let (columns, all) = (columns.max(1), reached.len() as f64);
    let rows = reached.len() / columns;
    let is_in = |point: usize| i8::from(reached[point] == number);
    // Of the pairs of a line of points and the line beside it.
    let of_line = |points: &mut dyn Iterator<Item = usize>, beside: usize| {
        let changes: Vec<i8> = points.map(|one| is_in(one + beside) - is_in(one)).collect();
        let runs = changes.chunk_by(|a, b| a == b).filter(|run| run[0] != 0);
        let lengths = runs.map(|run| run.len() as f64);
        lengths.map(|n| (n / 4.0).max(n * n / 12.0)).sum::<f64>()
    };
    let upwards = (1..rows).map(|row| of_line(&mut ((row - 1) * columns..row * columns), columns));
    let sideways =
        (1..columns).map(|column| of_line(&mut (column - 1..rows * columns).step_by(columns), 1));
    // A sum of nothing would be -0.
    let variance = upwards.chain(sideways).fold(0.0, |all, one| all + one);
    variance.sqrt() / all
}
