//! Eigenvalues that cross the border of stability between two solutions of a branch. Test functions
//! are products over all eigenvalues. They keep their sign where two of these cross at once, and
//! have none beside a neutral one. The number of unstable eigenvalues shows what they hide.

use nalgebra::Complex;

use crate::analysis::cycle::{LocatedZero, SolutionFunction, SolutionsOnLine};

/// Halvings of a step in search of what its ends do not show. Chosen: bifurcations that are nearer
/// to each other count as one.
pub(super) const MOST_HALVINGS: usize = 8;

/// An eigenvalue of a solution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eigenvalue {
    pub value: Complex<f64>,
    /// How far it is beyond the border of stability.
    pub beyond: f64,
    /// Uncertainty of that.
    pub uncertainty: f64,
}

impl Eigenvalue {
    fn is_neutral(&self) -> bool {
        // An uncertainty that is not a number leaves all open.
        let is_known = self.beyond.abs() > self.uncertainty;
        !is_known
    }

    fn is_unstable(&self) -> bool {
        self.beyond > self.uncertainty
    }

    fn is_real(&self) -> bool {
        self.value.im.abs() <= self.uncertainty
    }
}

/// The eigenvalues of a solution.
#[derive(Clone, Debug)]
pub(super) struct Eigenvalues(pub Vec<Eigenvalue>);

/// How eigenvalues cross the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Crossing {
    /// A real one that is positive or zero.
    Positive,
    /// A real one that is negative.
    Negative,
    /// A pair. The number of unstable eigenvalues changes by this.
    Pair(i32),
}

impl Crossing {
    /// Whether both are of one kind, in whatever direction.
    pub fn is_alike(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }
}

impl Eigenvalues {
    /// Number of eigenvalues of a kind.
    fn number(&self, is_counted: impl Fn(&Eigenvalue) -> bool) -> i32 {
        self.0.iter().filter(|one| is_counted(one)).count() as i32
    }

    /// Number of unstable eigenvalues.
    pub fn unstable(&self) -> usize {
        self.0.iter().filter(|one| one.is_unstable()).count()
    }

    /// The neutral eigenvalues.
    pub fn neutral(&self) -> Vec<Complex<f64>> {
        let neutral = self.0.iter().filter(|one| one.is_neutral());
        neutral.map(|one| one.value).collect()
    }

    /// Whether a neutral eigenvalue lets test functions of such crossings vanish anywhere.
    pub fn has_neutral(&self, crossing: Crossing) -> bool {
        self.0.iter().any(|one| {
            one.is_neutral()
                && match crossing {
                    Crossing::Positive => one.is_real() && one.value.re > 0.0,
                    Crossing::Negative => one.is_real() && one.value.re < 0.0,
                    Crossing::Pair(_) => !one.is_real(),
                }
        })
    }

    /// The eigenvalues without the nearest one to each of these, the most unstable ones first.
    fn without(mut self, neutral: &[Complex<f64>]) -> Vec<Eigenvalue> {
        for value in neutral {
            let off = |one: &Eigenvalue| (one.value - value).norm_sqr();
            let all = self.0.iter().enumerate();
            let nearest = all.min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
            if let Some((k, _)) = nearest {
                self.0.remove(k);
            }
        }
        self.0.sort_by(|a, b| b.beyond.total_cmp(&a.beyond));
        self.0
    }

    /// Whether crossings of these kinds change the number of unstable eigenvalues from that of one
    /// solution to that of another one.
    pub fn explains(&self, other: &Eigenvalues, located: &[(f64, Crossing)]) -> bool {
        let between = |is_counted: &dyn Fn(&Eigenvalue) -> bool| {
            other.number(is_counted) - self.number(is_counted)
        };
        // The real ones that cross are as many as test functions that vanish, or fewer.
        let real = |kind: Crossing, is_counted: &dyn Fn(&Eigenvalue) -> bool| {
            let most = located.iter().filter(|one| one.1 == kind).count() as i32;
            between(&|one| one.is_unstable() && one.is_real() && is_counted(one)).clamp(-most, most)
        };
        let pairs = located.iter().map(|one| match one.1 {
            Crossing::Pair(change) => change,
            _ => 0,
        });
        let known = real(Crossing::Positive, &|one| one.value.re >= 0.0)
            + real(Crossing::Negative, &|one| one.value.re < 0.0)
            + pairs.sum::<i32>();
        between(&Eigenvalue::is_unstable) == known
    }
}

/// A place at which eigenvalues cross the border; if it is not resolved, the middle of the step.
pub(super) struct Crossed<S> {
    pub at: LocatedZero<S>,
    pub is_resolved: bool,
    pub crossing: Crossing,
    /// The eigenvalue.
    pub value: Complex<f64>,
}

/// A solution at a place on a line, and its eigenvalues.
pub(super) type OnLine<'s, S> = (f64, &'s S, Eigenvalues);

/// The solutions on a line, with their eigenvalues.
pub(super) trait Spectra: SolutionsOnLine {
    /// The eigenvalues of a solution, with the least uncertainty that they may have.
    fn spectrum(&self, solution: &Self::Solution) -> Option<Eigenvalues>;

    /// The eigenvalues of the solution at a place, with their uncertainties.
    fn known_spectrum(&self, _place: f64, solution: &Self::Solution) -> Option<Eigenvalues> {
        self.spectrum(solution)
    }

    /// The zero of a function between two places, given with its values there.
    fn locate(
        &self,
        ends: [(f64, f64); 2],
        function: &SolutionFunction<'_, Self::Solution>,
    ) -> Option<LocatedZero<Self::Solution>> {
        self.zero(ends, function)
    }

    /// A solution before the last one with as many neutral eigenvalues as one a step farther, if
    /// the last one has more of them: an eigenvalue crosses the border there.
    fn before_neutral(
        &self,
        length: f64,
        [last, next]: [&Eigenvalues; 2],
    ) -> Option<(f64, Self::Solution)> {
        // Distances, as fractions of the step. Chosen: on a short one few eigenvalues cross.
        const BEFORE: [f64; 3] = [1e-3, 1e-2, 1e-1];
        let wanted = next.neutral().len();
        if last.neutral().len() <= wanted {
            return None;
        }
        BEFORE.into_iter().find_map(|part| {
            let solution = self.on(-part * length)?;
            let has_as_many = self.spectrum(&solution)?.neutral().len() == wanted;
            has_as_many.then_some((-part * length, solution))
        })
    }

    /// The crossings between two solutions that the located ones do not explain.
    fn hidden(
        &self,
        [a, b]: [&OnLine<'_, Self::Solution>; 2],
        located: &[(f64, Crossing)],
        halvings: usize,
    ) -> Vec<Crossed<Self::Solution>> {
        let is_between = |(s, _): &&(f64, Crossing)| (a.0..=b.0).contains(s);
        let between: Vec<_> = located.iter().filter(is_between).copied().collect();
        let is_same = a.2.neutral().len() == b.2.neutral().len();
        if !is_same || a.2.explains(&b.2, &between) {
            return Vec::new();
        }
        if a.2.unstable() != b.2.unstable() {
            return self.crossings([a, b], &between);
        }
        // They cross in both directions.
        let middle = 0.5 * (a.0 + b.0);
        let solution = (halvings > 0).then(|| self.on(middle)).flatten();
        let Some(solution) = &solution else {
            return Vec::new();
        };
        let Some(spectrum) = self.known_spectrum(middle, solution) else {
            return Vec::new();
        };
        let middle = (middle, solution, spectrum);
        let parts = [[a, &middle], [&middle, b]];
        let parts = parts.map(|part| self.hidden(part, located, halvings - 1));
        parts.into_iter().flatten().collect()
    }

    /// The crossings between two solutions with equally many neutral eigenvalues, which remain
    /// neutral, but for located ones. Each is the zero of how far an eigenvalue is beyond the
    /// border, by the number of that in their order.
    fn crossings(
        &self,
        [a, b]: [&OnLine<'_, Self::Solution>; 2],
        located: &[(f64, Crossing)],
    ) -> Vec<Crossed<Self::Solution>> {
        let neutral = a.2.neutral();
        let [before, after] = [a, b].map(|one| one.2.clone().without(&neutral));
        let [from, to] = [a, b].map(|one| one.2.unstable());
        let sign = if from < to { 1 } else { -1 };
        let mut found: Vec<Crossed<Self::Solution>> = Vec::new();
        let mut number = from.min(to);
        while number < from.max(to) {
            let one = |solution: &Self::Solution| {
                let others = self.spectrum(solution)?.without(&neutral);
                others.get(number).copied()
            };
            let beyond = |solution: &Self::Solution| Some(one(solution)?.beyond);
            let (Some(begin), Some(end)) = (before.get(number), after.get(number)) else {
                break;
            };
            let at = self.locate([(a.0, begin.beyond), (b.0, end.beyond)], &beyond);
            let there = at.as_ref().and_then(|at| one(&at.solution));
            let there = there.unwrap_or(*end);
            let crossing = match there.is_real() {
                true if there.value.re < -there.uncertainty => Crossing::Negative,
                true => Crossing::Positive,
                false => Crossing::Pair(2 * sign),
            };
            number += if there.is_real() { 1 } else { 2 };
            let is_resolved = at.is_some();
            let at = at.unwrap_or_else(|| {
                let [from, to] = [a, b].map(|one| self.parameter(one.1));
                LocatedZero {
                    s: 0.5 * (a.0 + b.0),
                    parameter: 0.5 * (from + to),
                    solution: b.1.clone(),
                    uncertainty: 0.5 * (to - from).abs(),
                }
            });
            found.push(Crossed {
                at,
                is_resolved,
                crossing,
                value: there.value,
            });
        }
        // Each located one is the nearest of its kind.
        for (s, crossing) in located {
            let off = |one: &Crossed<Self::Solution>| match one.is_resolved {
                true => (one.at.s - s).abs(),
                false => f64::INFINITY,
            };
            let alike = found.iter().enumerate();
            let alike = alike.filter(|(_, one)| one.crossing.is_alike(*crossing));
            if let Some((k, _)) = alike.min_by(|a, b| off(a.1).total_cmp(&off(b.1))) {
                found.remove(k);
            }
        }
        found
    }
}
