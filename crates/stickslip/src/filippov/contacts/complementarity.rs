//! Decides which of the contacts at zero hold, and to which side the others leave.
//!
//! A contact holds with a weight of the field above between 0 and 1, or leaves above with weight 1,
//! or below with weight 0. If the rates are affine in the weights, this is a linear complementarity
//! problem with bounds (Pfeiffer & Glocker, *Multibody Dynamics with Unilateral Contacts*, 1996,
//! Ch. 8).

use nalgebra::{DMatrix, DVector};

use super::Contacts;
use super::equations::{has_positive_pivots, principal_minor, solve};
use super::joint::{ContactFlow, CornerFields, NEGLIGIBLE_FRICTION, rates};
use crate::system::{Mode, Side, State, components};

/// Largest number of contacts of which all combinations of outcomes are tried. There are three to
/// that number; chosen so that a decision tries at most 6561.
const MAX_ENUMERATED: usize = 8;

/// Largest number of contacts of which every principal minor is computed. There are two to that
/// number; chosen so that a decision computes at most 65 535.
const MAX_MINORS: usize = 16;

/// Number of changes for each contact after which the least-index method counts as cycling. Chosen:
/// all combinations are tried instead.
const MAX_CHANGES: usize = 64;

/// A rate below this fraction of its summands is rounding. Chosen: some 450 units in the last
/// place. A larger value would hold contacts that leave slowly.
const RATE_ROUNDING: f64 = 1e-13;

/// The outcome of a contact at zero.
pub(super) type ContactOutcome = Mode;

/// Every consistent set of outcomes for the holding contacts of `joint`, in their order; `None` if
/// there are too many to try.
pub(super) fn solutions<S: Contacts<N, M>, const N: usize, const M: usize>(
    joint: &ContactFlow<'_, S, M>,
    modes: &[Mode; M],
    t: f64,
    x: &State<N>,
) -> Option<Vec<[ContactOutcome; M]>> {
    if S::MULTI_AFFINE && joint.count > 1 {
        return combinations(joint.count, |outcomes| {
            is_consistent(joint, modes, outcomes, t, x)
        });
    }
    let problem = RateEquations::new(joint, &joint.affine(t, components(x)));
    if problem.has_one_solution()
        && let Some(consistent) = problem.by_least_index()
    {
        return Some(vec![consistent]);
    }
    combinations(problem.count, |outcomes| problem.is_solved_by(outcomes))
}

/// All sets of so many outcomes that pass; `None` if there are too many to try.
pub(super) fn combinations<const M: usize>(
    count: usize,
    passes: impl Fn(&[ContactOutcome; M]) -> bool,
) -> Option<Vec<[ContactOutcome; M]>> {
    const EACH: [ContactOutcome; 3] = [
        Mode::Stick,
        Mode::Slip(Side::Below),
        Mode::Slip(Side::Above),
    ];
    if count > MAX_ENUMERATED {
        return None;
    }
    let mut consistent = Vec::new();
    for number in 0..3_usize.pow(count as u32) {
        let mut outcomes = [Mode::Stick; M];
        let mut digits = number;
        for outcome in outcomes.iter_mut().take(count) {
            *outcome = EACH[digits % 3];
            digits /= 3;
        }
        if passes(&outcomes) {
            consistent.push(outcomes);
        }
    }
    Some(consistent)
}

/// Whether the outcomes agree with the rates and weights of a multi-affine combination.
fn is_consistent<S: Contacts<N, M>, const N: usize, const M: usize>(
    joint: &ContactFlow<'_, S, M>,
    modes: &[Mode; M],
    outcomes: &[ContactOutcome; M],
    t: f64,
    x: &State<N>,
) -> bool {
    let mut modes = *modes;
    let mut at_rest = [false; M];
    for (index, &contact) in joint.held().iter().enumerate() {
        (modes[contact], at_rest[contact]) = (outcomes[index], true);
    }
    let joint_then = ContactFlow::new(joint.system, &modes).with_static_friction_at(&at_rest);
    let x = components(x);
    let combination = joint_then.combination(t, x);
    let rates = rates(joint.system, (t, 1.0), x, &combination.field);
    // The effect of friction on each rate, as the scale of a rate that has not vanished.
    let slopes = joint.affine(t, x).slopes;
    let size = |i: usize| slopes[i].iter().map(|slope| slope.abs()).sum::<f64>();
    let shares = &combination.shares[..joint_then.count];
    // An iteration that has not converged is no solution.
    let holds = joint_then.held().iter().zip(shares).all(|(&i, share)| {
        (0.0..=1.0).contains(share) && rates[i].abs() <= NEGLIGIBLE_FRICTION * size(i)
    });
    holds
        && joint
            .held()
            .iter()
            .zip(outcomes)
            .all(|(&i, outcome)| match outcome {
                Mode::Stick => true,
                Mode::Slip(side) => rates[i] * side.sign() > 0.0,
            })
}

/// Whether a matrix is positive definite after each column is scaled by the strength of friction
/// there. The effects of two contacts on each other differ by the ratio of their strengths.
fn is_definite<const M: usize>(matrix: &[[f64; M]; M], count: usize) -> bool {
    let mut strengths = [0.0; M];
    // Along the couplings, from one contact of every connected group.
    for first in 0..count {
        if strengths[first] != 0.0 {
            continue;
        }
        strengths[first] = 1.0;
        let mut connected = vec![first];
        while let Some(i) = connected.pop() {
            for j in 0..count {
                if strengths[j] == 0.0 && matrix[i][j] * matrix[j][i] > 0.0 {
                    strengths[j] = strengths[i] * matrix[i][j] / matrix[j][i];
                    connected.push(j);
                }
            }
        }
    }
    let mut symmetric = [[0.0; M]; M];
    for i in 0..count {
        for j in 0..count {
            let (here, there) = (matrix[i][j] / strengths[j], matrix[j][i] / strengths[i]);
            symmetric[i][j] = 0.5 * (here + there);
        }
    }
    has_positive_pivots(&symmetric, count)
}

/// Rates at the contacts, in their order, as affine functions of the weights.
struct RateEquations<const M: usize> {
    count: usize,
    rates: [f64; M],
    slopes: [[f64; M]; M],
}

impl<const M: usize> RateEquations<M> {
    fn new<S, const N: usize>(
        joint: &ContactFlow<'_, S, M>,
        affine: &CornerFields<f64, N, M>,
    ) -> Self {
        let mut problem = RateEquations {
            count: joint.count,
            rates: [0.0; M],
            slopes: [[0.0; M]; M],
        };
        for (index, &contact) in joint.held().iter().enumerate() {
            problem.rates[index] = affine.rates[contact];
            problem.slopes[index] = affine.slopes[contact];
        }
        problem
    }

    /// Whether every problem with these slopes has exactly one solution: all principal minors of
    /// their negative are positive (a P-matrix; Samelson, Thrall & Wesler, *Proc. AMS* 9 (1958)
    /// 805). A definite matrix is one, which decides Coulomb friction for any number of contacts.
    fn has_one_solution(&self) -> bool {
        let mut resistance = self.slopes;
        for value in resistance.iter_mut().flatten() {
            *value = -*value;
        }
        let off_diagonal = (0..self.count)
            .flat_map(|i| (0..self.count).map(move |j| (i, j)))
            .any(|(i, j)| i != j && resistance[i][j] != 0.0);
        if !off_diagonal {
            return (0..self.count).all(|i| resistance[i][i] > 0.0);
        }
        if is_definite(&resistance, self.count) {
            return true;
        }
        self.count <= MAX_MINORS
            && (1..1_usize << self.count).all(|set| {
                let chosen: Vec<usize> = (0..self.count).filter(|&i| set >> i & 1 == 1).collect();
                principal_minor(&resistance, &chosen) > 0.0
            })
    }

    /// Weights and rates with these outcomes.
    fn shares_and_rates(&self, outcomes: &[ContactOutcome; M]) -> ([f64; M], [f64; M]) {
        let mut shares = [0.0; M];
        let mut holding = [0; M];
        let mut count = 0;
        for i in 0..self.count {
            match outcomes[i] {
                Mode::Stick => {
                    holding[count] = i;
                    count += 1;
                }
                Mode::Slip(Side::Above) => shares[i] = 1.0,
                Mode::Slip(Side::Below) => {}
            }
        }
        let rate = |shares: &[f64; M], i: usize| {
            (0..self.count).fold(self.rates[i], |rate, j| {
                rate + self.slopes[i][j] * shares[j]
            })
        };
        let (mut matrix, mut right) = ([[0.0; M]; M], [0.0; M]);
        for (row, &i) in holding[..count].iter().enumerate() {
            right[row] = -rate(&shares, i);
            for (column, &j) in holding[..count].iter().enumerate() {
                matrix[row][column] = self.slopes[i][j];
            }
        }
        let problem = (matrix, right);
        solve(&mut matrix, &mut right, count);
        if !right[..count].iter().all(|share| share.is_finite()) {
            // The pivots of contacts that do not affect their own rates vanish.
            let rows = DMatrix::from_fn(count, count, |i, j| problem.0[i][j]);
            let loads = DVector::from_column_slice(&problem.1[..count]);
            if let Some(found) = rows.lu().solve(&loads) {
                right[..count].copy_from_slice(found.as_slice());
            }
        }
        for (row, &i) in holding[..count].iter().enumerate() {
            shares[i] = right[row];
        }
        (
            shares,
            std::array::from_fn(|i| {
                if i < self.count {
                    rate(&shares, i)
                } else {
                    0.0
                }
            }),
        )
    }

    /// The size below which the rate of a contact is rounding.
    fn floor(&self, i: usize, shares: &[f64; M]) -> f64 {
        let terms = self.slopes[i].iter().zip(shares).take(self.count);
        let size = terms.fold(self.rates[i].abs(), |size, (slope, share)| {
            size + (slope * share).abs()
        });
        RATE_ROUNDING * size
    }

    /// The outcome that is consistent for a contact, given the others; its own if that is
    /// consistent. Within rounding it holds, and higher derivatives decide. A missing weight is
    /// compared with the rate of the contact in slip, so that rounding does not release and hold it
    /// in turns.
    fn wanted(
        &self,
        i: usize,
        outcome: ContactOutcome,
        shares: &[f64; M],
        rate: f64,
    ) -> ContactOutcome {
        let floor = self.floor(i, shares);
        let effect = |j: usize| self.slopes[j][i].abs();
        let strength = match effect(i) {
            0.0 => (0..self.count).map(effect).fold(0.0, f64::max),
            own => own,
        };
        let most = floor / strength;
        match outcome {
            Mode::Stick if shares[i] < -most => Mode::Slip(Side::Below),
            Mode::Stick if shares[i] - 1.0 > most => Mode::Slip(Side::Above),
            Mode::Slip(side) if rate * side.sign() < floor => Mode::Stick,
            _ => outcome,
        }
    }

    /// The solution by changing one contact at a time, the first that is inconsistent (Murty's
    /// least-index method; with bounds Júdice & Pires, *J. Oper. Res. Soc.* 43 (1992) 1087).
    fn by_least_index(&self) -> Option<[ContactOutcome; M]> {
        let mut outcomes = [Mode::Stick; M];
        for _ in 0..MAX_CHANGES * self.count {
            let (shares, rates) = self.shares_and_rates(&outcomes);
            let change = (0..self.count)
                .map(|i| (i, self.wanted(i, outcomes[i], &shares, rates[i])))
                .find(|&(i, wanted)| wanted != outcomes[i]);
            match change {
                Some((i, wanted)) => outcomes[i] = wanted,
                None => return Some(outcomes),
            }
        }
        None
    }

    fn is_solved_by(&self, outcomes: &[ContactOutcome; M]) -> bool {
        let (shares, rates) = self.shares_and_rates(outcomes);
        (0..self.count).all(|i| match outcomes[i] {
            _ if !(shares[i].is_finite() && rates[i].is_finite()) => false,
            Mode::Stick => self.wanted(i, Mode::Stick, &shares, rates[i]) == Mode::Stick,
            Mode::Slip(side) => rates[i] * side.sign() > self.floor(i, &shares),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STICK: ContactOutcome = Mode::Stick;
    const BELOW: ContactOutcome = Mode::Slip(Side::Below);
    const ABOVE: ContactOutcome = Mode::Slip(Side::Above);

    /// Rates without weights, and what each weight takes off them.
    fn problem<const M: usize>(rates: [f64; M], resistance: [[f64; M]; M]) -> RateEquations<M> {
        RateEquations {
            count: M,
            rates,
            slopes: resistance.map(|row| row.map(|value| -value)),
        }
    }

    /// Contacts in a row with the same entry on the diagonal, beside it, and below that.
    fn row<const M: usize>(diagonal: f64, beside: f64, below: f64) -> RateEquations<M> {
        let entry = |i: usize, j: usize| match i.wrapping_sub(j) {
            0 => diagonal,
            1 => below,
            usize::MAX => beside,
            _ => 0.0,
        };
        let line = |i: usize| std::array::from_fn(|j| entry(i, j));
        problem([0.0; M], std::array::from_fn(line))
    }

    #[test]
    fn one_solution_follows_from_positive_principal_minors_alone() {
        for (resistance, has_one) in [
            // Without coupling.
            ([[1.0, 0.0], [0.0, 2.0]], true),
            ([[1.0, 0.0], [0.0, 0.0]], false),
            ([[1.0, 0.0], [0.0, -1.0]], false),
            // Definite, and not definite with minors of 1.
            ([[2.0, 1.0], [1.0, 2.0]], true),
            ([[1.0, 3.0], [0.0, 1.0]], true),
            // A minor of −3, of 0, and two of 0 beside one of 1.
            ([[1.0, 2.0], [2.0, 1.0]], false),
            ([[1.0, 1.0], [1.0, 1.0]], false),
            ([[0.0, 1.0], [-1.0, 0.0]], false),
        ] {
            let found = problem([0.0; 2], resistance).has_one_solution();
            assert_eq!(found, has_one, "{resistance:?}");
        }
        // Too many for minors: only a definite matrix is known to have one.
        assert!(row::<17>(2.0, -1.0, -1.0).has_one_solution());
        assert!(row::<16>(1.0, 3.0, 0.0).has_one_solution());
        assert!(!row::<17>(1.0, 3.0, 0.0).has_one_solution());
    }

    #[test]
    fn strengths_of_friction_leave_a_matrix_definite() {
        // [[1, 1/2], [1/2, 1]] and a chain of three, with columns of other strengths.
        assert!(is_definite(&[[1.0, 50.0], [0.5, 100.0]], 2));
        let chain = [[2.0, -10.0, 0.0], [-1.0, 20.0, -0.1], [0.0, -10.0, 0.2]];
        assert!(is_definite(&chain, 3));
        assert!(!is_definite(&[[1.0, 200.0], [2.0, 100.0]], 2));
        // Singular to rounding, and not quite.
        assert!(!is_definite(&[[1.0, 1.0], [1.0, 1.0 + 1e-13]], 2));
        assert!(is_definite(&[[1.0, 1.0], [1.0, 1.0 + 1e-11]], 2));
    }

    /// The solutions by trying all outcomes.
    fn enumerated<const M: usize>(problem: &RateEquations<M>) -> Vec<[ContactOutcome; M]> {
        combinations(M, |outcomes| problem.is_solved_by(outcomes)).unwrap()
    }

    #[test]
    fn both_methods_find_the_solution_of_two_coupled_contacts() {
        for (rates, outcomes) in [
            ([1.5, 1.5], [STICK, STICK]),
            ([5.0, 1.5], [ABOVE, STICK]),
            ([-1.0, 2.5], [BELOW, ABOVE]),
            // Below at first, with the other held at 11/6.
            ([0.5, 3.0], [BELOW, ABOVE]),
            // Below at first, and held again once the other leaves.
            ([1.5, 4.0], [STICK, ABOVE]),
        ] {
            let problem = problem(rates, [[2.0, 1.0], [1.0, 2.0]]);
            assert_eq!(problem.by_least_index(), Some(outcomes), "{rates:?}");
            assert_eq!(enumerated(&problem), [outcomes], "{rates:?}");
        }
    }

    #[test]
    fn weights_and_rates_within_rounding_hold() {
        let resistance = [[2.0, 1.0], [1.0, 2.0]];
        // The weights, the second of which is not near an end.
        for (weight, outcome) in [
            (-1e-14, STICK),
            (-1e-13, BELOW),
            (1.0 + 1e-13, STICK),
            (1.0 + 1e-12, ABOVE),
        ] {
            let problem = problem([2.0 * weight + 0.3, weight + 0.6], resistance);
            let outcomes = [outcome, STICK];
            assert_eq!(problem.by_least_index(), Some(outcomes), "{weight}");
            assert_eq!(enumerated(&problem), [outcomes], "{weight}");
        }
        // A slip whose rate is rounding beside its terms.
        let problem = problem([0.3 - 1e-14, 0.6], resistance);
        assert!(!problem.is_solved_by(&[BELOW, STICK]));
        let weights = [0.0, 0.3];
        for (rate, wanted) in [(-1e-14, STICK), (-1e-12, BELOW), (1e-12, STICK)] {
            assert_eq!(problem.wanted(0, BELOW, &weights, rate), wanted, "{rate}");
            assert_eq!(
                problem.wanted(0, ABOVE, &weights, -rate) == STICK,
                wanted == STICK
            );
        }
    }

    #[test]
    fn contacts_that_act_on_each_other_alone_are_solved_with_pivots() {
        let across = [[0.0, 1.0], [-1.0, 0.0]];
        // Weights of 1/2, and of −1 and 1/2 if both held.
        assert_eq!(enumerated(&problem([0.5, -0.5], across)), [[STICK, STICK]]);
        assert_eq!(enumerated(&problem([0.5, 1.0], across)), [[BELOW, ABOVE]]);
        // What nothing acts on leaves.
        let apart = problem([0.5, 0.5], [[0.0, 0.0], [0.0, 1.0]]);
        assert_eq!(enumerated(&apart), [[ABOVE, STICK]]);
    }

    #[test]
    fn eight_contacts_are_enumerated_and_nine_are_not() {
        assert_eq!(combinations::<8>(8, |_| false), Some(Vec::new()));
        assert_eq!(combinations::<9>(9, |_| false), None);
    }
}
