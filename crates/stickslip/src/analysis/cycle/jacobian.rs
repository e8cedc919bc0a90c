//! The derivative of an orbit's equations by the unknowns, as a chain. The equations of a piece
//! depend on the states at its ends, on its duration, and on the time at which it begins.

use super::{OrbitGuess, unit};
use crate::analysis::elimination::{Determinant, Elimination, SparseRow, orthonormal, singular};
use crate::dynamics::Vector;

/// The derivative of one equation.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Row {
    /// Derivatives by the unknowns, other than through the time at which a piece begins.
    pub entries: SparseRow,
    /// The piece, and the derivative by the time at which it begins.
    pub in_time: Option<(usize, f64)>,
}

impl Row {
    /// A row of an equation that does not depend on times at which pieces begin.
    pub fn of(entries: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let entries = entries.into_iter();
        Row {
            entries: entries.filter(|(_, value)| *value != 0.0).collect(),
            in_time: None,
        }
    }
}

/// Integrated part of a segment.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Part {
    /// The segment.
    pub segment: usize,
    /// Share of its duration.
    pub share: f64,
    /// The first of the unknowns that are the state at its beginning.
    pub state: usize,
}

/// The derivative of an orbit's equations.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Jacobian {
    /// Number of components of a state.
    components: usize,
    /// Number of unknowns: the state at the beginning, the durations, the time at the beginning and
    /// the states at the cuts, as in [`OrbitGuess::unknowns`].
    unknowns: usize,
    /// The parts in their order.
    parts: Vec<Part>,
    rows: Vec<Row>,
    /// Pairs of unknowns that the first equations set equal if no state changes, one an equation.
    unchanged: Vec<[usize; 2]>,
}

/// Parts that a row may span without a sum that is carried from one to the next. Sums over fewer
/// parts have as many unknowns as they save. The solution does not depend on it.
const SHORT_SPAN: usize = 2;

impl Jacobian {
    pub(super) fn new(
        outline: &OrbitGuess,
        (parts, rows): (Vec<Part>, Vec<Row>),
        unchanged: Vec<[usize; 2]>,
    ) -> Self {
        let components = outline.begin.x.len();
        let cuts = parts.len() - 1;
        Jacobian {
            components,
            unknowns: components + outline.segments.len() + 1 + components * cuts,
            parts,
            rows,
            unchanged,
        }
    }

    /// Index of the time at the beginning among the unknowns.
    fn time(&self) -> usize {
        self.unknowns - 1 - self.components * (self.parts.len() - 1)
    }

    /// The part before the end of which no equation with a duration is complete.
    fn last_part(&self, segment: usize) -> usize {
        let mut parts = self.parts.iter();
        parts.rposition(|part| part.segment == segment).unwrap_or(0)
    }

    /// Appends one equation, which has given derivatives by the unknowns; those by states at cuts
    /// may be left out, and are zero.
    pub fn with_row(&self, row: &Vector) -> Self {
        let mut other = self.clone();
        other.rows.push(Row::of(row.iter().copied().enumerate()));
        other
    }

    /// Whether all derivatives are finite.
    pub fn is_finite(&self) -> bool {
        let is_finite = |row: &Row| {
            let mut entries = row.entries.iter();
            entries.all(|(_, value)| value.is_finite())
                && row.in_time.is_none_or(|(_, value)| value.is_finite())
        };
        self.rows.iter().all(is_finite)
    }

    /// The times at which the parts begin, from values of the unknowns.
    fn times(&self, x: &Vector) -> Vec<f64> {
        let mut time = x[self.time()];
        let next = |part: &Part| {
            let begins = time;
            time += part.share * x[self.components + part.segment];
            begins
        };
        self.parts.iter().map(next).collect()
    }

    /// Product of the matrix with a vector.
    pub fn times_vector(&self, x: &Vector) -> Vector {
        self.product(x, |value| value)
    }

    /// The product with a vector after each derivative was mapped.
    fn product(&self, x: &Vector, map: fn(f64) -> f64) -> Vector {
        let times = self.times(x);
        let product = |row: &Row| -> f64 {
            let entries = row.entries.iter();
            let entries = entries.map(|&(column, value)| map(value) * x[column]);
            let in_time = row
                .in_time
                .map_or(0.0, |(part, value)| map(value) * times[part]);
            entries.sum::<f64>() + in_time
        };
        Vector::from_iterator(self.rows.len(), self.rows.iter().map(product))
    }

    /// The product with a vector of the part that is due to changes of the state.
    pub fn changes(&self, x: &Vector) -> Vector {
        let mut changes = self.times_vector(x);
        for (change, [from, to]) in changes.iter_mut().zip(&self.unchanged) {
            *change += x[*to] - x[*from];
        }
        changes
    }

    /// Share of its segment that precedes a part.
    fn share_before(&self, part: usize) -> f64 {
        let segment = self.parts[part].segment;
        let before = self.parts[..part].iter().rev();
        before
            .take_while(|one| one.segment == segment)
            .map(|one| one.share)
            .sum()
    }

    /// The entries of a row that depends on the time at which a part begins. They are by the state
    /// and by the duration of its segment, the latter through that time, too.
    fn with_own_duration(&self, row: &Row, (part, in_time): (usize, f64)) -> SparseRow {
        let duration = self.components + self.parts[part].segment;
        let through_time = (duration, in_time * self.share_before(part));
        let (own, mut others): (SparseRow, SparseRow) = row
            .entries
            .iter()
            .partition(|(column, _)| *column == duration);
        let own = own.iter().chain([&through_time]).map(|(_, value)| value);
        others.push((duration, own.sum()));
        others
    }

    /// The length of each row, with the unknowns in these units.
    pub fn row_lengths(&self, units: &Vector) -> Vector {
        let square = |column: usize| units[column] * units[column];
        let of_entries = |entries: &SparseRow| -> f64 {
            let squares = entries.iter().map(|&(column, v)| v * v * square(column));
            squares.sum()
        };
        // Of the time at the beginning, and of the durations of the segments before each part.
        let mut before = vec![square(self.time())];
        for (pair, known) in self.parts.windows(2).zip(0..) {
            let [part, next] = [pair[0].segment, pair[1].segment];
            let whole = if part == next {
                0.0
            } else {
                square(self.components + part)
            };
            before.push(before[known] + whole);
        }
        let length = |row: &Row| match row.in_time {
            Some((part, in_time)) => {
                let own = of_entries(&self.with_own_duration(row, (part, in_time)));
                (own + in_time * in_time * before[part]).sqrt()
            }
            None => of_entries(&row.entries).sqrt(),
        };
        Vector::from_iterator(self.rows.len(), self.rows.iter().map(length))
    }

    /// The length of each column, with the equations multiplied by these weights.
    pub fn column_lengths(&self, weights: &Vector) -> Vector {
        let mut squares = Vector::zeros(self.unknowns);
        let mut in_times = vec![0.0; self.parts.len()];
        for (row, weight) in self.rows.iter().zip(weights) {
            let own = row.in_time.map(|(part, in_time)| {
                in_times[part] += (weight * in_time) * (weight * in_time);
                self.with_own_duration(row, (part, in_time))
            });
            for &(column, value) in own.as_ref().unwrap_or(&row.entries) {
                squares[column] += (weight * value) * (weight * value);
            }
        }
        // Every part begins later where an earlier segment takes longer.
        let mut later = 0.0;
        let mut parts = self.parts.iter().zip(&in_times).rev().peekable();
        let mut within = 0.0;
        while let Some((part, in_time)) = parts.next() {
            within += in_time;
            if parts
                .peek()
                .is_none_or(|(before, _)| before.segment != part.segment)
            {
                squares[self.components + part.segment] += later;
                later += std::mem::take(&mut within);
            }
        }
        squares[self.time()] += later;
        squares.map(f64::sqrt)
    }

    /// The equations eliminated, with unknowns in these units, and multiplied by these weights.
    pub fn eliminated(&self, (units, weights): (&Vector, &Vector)) -> Eliminated {
        let (count, time) = (self.parts.len(), self.time());
        let mut columns = self.unknowns;
        let mut groups: Vec<Vec<usize>> = vec![Vec::new(); count + 1];
        let mut group_of = vec![count; self.unknowns];
        for (number, part) in self.parts.iter().enumerate() {
            let duration = self.components + part.segment;
            let ends = self.last_part(part.segment) == number;
            let states = (part.state..part.state + self.components).filter(|_| number > 0);
            for column in states.chain(ends.then_some(duration)) {
                groups[number].push(column);
                group_of[column] = number;
            }
        }
        groups[count].extend((0..self.components).chain([time]));
        let mut new_column = |groups: &mut Vec<Vec<usize>>, number: usize| {
            groups[number].push(columns);
            columns += 1;
            columns - 1
        };
        let mut times = vec![time];
        let mut rows: Vec<SparseRow> = Vec::with_capacity(self.rows.len() + count);
        let mut sums: Vec<SparseRow> = Vec::new();
        for (number, part) in self.parts.iter().enumerate().take(count - 1) {
            let next = new_column(&mut groups, number + 1);
            let duration = (self.components + part.segment, part.share);
            let unit = units[time];
            let duration = (duration.0, duration.1 * units[duration.0] / unit);
            sums.push(vec![(next, -1.0), (times[number], 1.0), duration]);
            times.push(next);
        }
        for (row, weight) in self.rows.iter().zip(weights) {
            let scaled = |&(column, value): &(usize, f64)| (column, weight * value * units[column]);
            let own: SparseRow = row.entries.iter().map(scaled).collect();
            let in_time = |(part, value)| (times[part], weight * value * units[time]);
            let mut entries = own.clone();
            entries.extend(row.in_time.map(in_time));
            let in_parts = || own.iter().map(|&(column, _)| group_of[column]);
            let in_parts = || in_parts().filter(|&group| group < count);
            let (first, last) = (in_parts().min(), in_parts().max());
            let (Some(first), Some(last)) = (first, last) else {
                rows.push(entries);
                continue;
            };
            if last - first <= SHORT_SPAN || row.in_time.is_some() {
                rows.push(entries);
                continue;
            }
            // The sum of a long row is carried from part to part, so that it takes part in the
            // reflections of each.
            let mut of_parts: Vec<SparseRow> = vec![Vec::new(); count + 1];
            let most = own.iter().map(|(_, value)| value.abs());
            let most = most.fold(f64::MIN_POSITIVE, f64::max);
            for (column, value) in own {
                of_parts[group_of[column]].push((column, value));
            }
            let mut sum: Option<usize> = None;
            for (number, mut entries) in of_parts.drain(first..last).enumerate() {
                let next = new_column(&mut groups, first + number + 1);
                for (_, value) in &mut entries {
                    *value /= most;
                }
                entries.extend(sum.map(|sum| (sum, 1.0)));
                entries.push((next, -1.0));
                sums.push(entries);
                sum = Some(next);
            }
            let mut rest: SparseRow = of_parts.into_iter().flatten().collect();
            rest.extend(sum.map(|sum| (sum, most)));
            rows.push(rest);
        }
        let equations = rows.len();
        rows.extend(sums);
        Eliminated {
            elimination: Elimination::of(&rows, &groups),
            unknowns: [self.unknowns, columns],
            equations: [equations, rows.len()],
        }
    }

    /// Units of the unknowns and weights of the equations that leave them as they are.
    fn unscaled(&self) -> [Vector; 2] {
        [self.unknowns, self.rows.len()].map(|count| Vector::repeat(count, 1.0))
    }

    /// The solution of the equations with these values; `None` where the matrix is singular.
    ///
    /// It is refined until it solves equations of which each entry differs by rounding (Arioli,
    /// Demmel & Duff, *SIAM J. Matrix Anal. Appl.* 10 (1989) 165). Reflections mix rows: without
    /// refinement, entries that are zero would change by the rounding of the largest ones.
    pub fn solve(&self, right: &Vector) -> Option<Vector> {
        // Number of refinements: one or two suffice, and none helps more than these (LAPACK's
        // xGERFS).
        const MOST_REFINEMENTS: usize = 5;
        let [units, weights] = self.unscaled();
        let eliminated = self.eliminated((&units, &weights));
        let solved = |right: &Vector| {
            let right = right
                .clone()
                .resize_vertically(eliminated.equations[1], 0.0);
            let solution = eliminated.elimination.solve(&right)?;
            Some(solution.rows(0, self.unknowns).into_owned())
        };
        let mut best = solved(right)?;
        let (mut residual, mut error) = self.backward_error(&best, right);
        for _ in 0..MOST_REFINEMENTS {
            if error <= f64::EPSILON {
                break;
            }
            let next = &best + solved(&residual)?;
            let (left, smaller) = self.backward_error(&next, right);
            let is_smaller = smaller < error;
            let helps = smaller <= 0.5 * error;
            if is_smaller {
                (best, residual, error) = (next, left, smaller);
            }
            if !helps {
                break;
            }
        }
        best.iter().all(|value| value.is_finite()).then_some(best)
    }

    /// The residual of a solution, and the least fraction by which entries of the equations must
    /// change so that it solves them (Oettli & Prager, *Numer. Math.* 6 (1964) 405). Equations in
    /// which all terms are rounding may change by that fraction of their largest possible term
    /// (Arioli, Demmel & Duff).
    fn backward_error(&self, x: &Vector, right: &Vector) -> (Vector, f64) {
        // Terms below this multiple of the rounding of the largest ones are rounding themselves.
        const ROUNDING: f64 = 1e3 * f64::EPSILON;
        let residual = right - self.times_vector(x);
        let terms = self.product(&x.abs(), f64::abs) + right.abs();
        let largest = self.product(&Vector::repeat(x.len(), x.amax()), f64::abs);
        let error = |k: usize| {
            let least = ROUNDING * x.len() as f64 * (largest[k] + right[k].abs());
            let size = if terms[k] > least {
                terms[k]
            } else {
                terms[k] + largest[k]
            };
            residual[k].abs() / size.max(f64::MIN_POSITIVE)
        };
        // A residual that is not a number is no solution.
        let worse = |most: f64, error: f64| if error <= most { most } else { error };
        let error = (0..right.len()).map(error).fold(0.0, worse);
        (residual, error)
    }

    /// The solution of the equations of which the last has the value 1, and the others 0.
    pub fn tangent(&self) -> Option<Vector> {
        let count = self.rows.len();
        self.solve(&unit(count, count - 1))
    }

    /// The determinant.
    pub fn determinant(&self) -> Determinant {
        let [units, weights] = self.unscaled();
        let eliminated = self.eliminated((&units, &weights));
        let found = eliminated.elimination.determinant();
        // Each further unknown has the coefficient -1 in the equation that determines it.
        let further = eliminated.unknowns[1] - eliminated.unknowns[0];
        if further.is_multiple_of(2) {
            found
        } else {
            found.negated()
        }
    }

    /// The directions along which the equations change least, as [`Eliminated::least_determined`].
    pub fn least_determined(&self) -> Option<Vec<(f64, Vector)>> {
        let [units, weights] = self.unscaled();
        let scales = (&units, &weights);
        self.eliminated(scales).least_determined(self, scales)
    }
}

/// The eliminated equations in units and with weights, extended by the times at which the parts
/// begin and by the sums of long rows.
pub(crate) struct Eliminated {
    elimination: Elimination,
    /// Numbers of unknowns and of equations, before and after the extension.
    unknowns: [usize; 2],
    equations: [usize; 2],
}

impl Eliminated {
    /// The solution; of a singular matrix, that of one which differs by rounding.
    pub fn solve(&self, right: &Vector) -> Option<Vector> {
        let right = right.clone().resize_vertically(self.equations[1], 0.0);
        let solution = self.elimination.solve_regularised(&right)?;
        Some(solution.rows(0, self.unknowns[0]).into_owned())
    }

    /// The solution of the transposed equations, likewise.
    pub fn solve_transposed(&self, right: &Vector) -> Option<Vector> {
        let right = right.clone().resize_vertically(self.unknowns[1], 0.0);
        let solution = self.elimination.solve_transposed_regularised(&right)?;
        Some(solution.rows(0, self.equations[0]).into_owned())
    }

    /// The directions along which the equations change least, one for each component of the state
    /// and the time at the beginning: the lengths of the changes, rising, and unit vectors. Units
    /// and weights are those of the elimination.
    ///
    /// They span the directions that change all equations least for a given change of the
    /// beginning. A direction that changes none is one of these.
    pub fn least_determined(
        &self,
        jacobian: &Jacobian,
        (units, weights): (&Vector, &Vector),
    ) -> Option<Vec<(f64, Vector)>> {
        let solutions = self.elimination.fundamental()?;
        let own = solutions.iter().map(|x| x.rows(0, units.len()).into());
        let basis = orthonormal(&own.collect::<Vec<Vector>>());
        let image = |x: &Vector| {
            let product = jacobian.times_vector(&x.component_mul(units));
            product.component_mul(weights)
        };
        let images: Vec<Vector> = basis.iter().map(image).collect();
        let of_basis = |(length, parts): (f64, Vector)| {
            let mut direction = Vector::zeros(units.len());
            for (part, vector) in parts.iter().zip(&basis) {
                direction.axpy(*part, vector, 1.0);
            }
            (length, direction)
        };
        Some(singular(&images).into_iter().map(of_basis).collect())
    }
}

#[cfg(test)]
mod tests;
