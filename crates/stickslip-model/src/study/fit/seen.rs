//! Modes of contacts as the data show them, beside those at the fit.

use std::f64::consts::PI;

use numerics::SplitMix;
use rayon::prelude::*;
use stickslip::dynamics::{Modes, Vector};
use stickslip::math;
use stickslip::scalar::Dual;
use stickslip::{Mode, Scalar, Side};

use super::problem::FitProblem;
use super::record_run::{Place, mode_at};
use super::statistics::{FEWEST_IN_PHASE, normal_deviate};
use super::unknowns::Kind;
use super::{FitError, Modelled};
use crate::file::{Observed, System};
use crate::kernel::{Combination, sides_to_check};

/// Records of simulated noise in which the modes of the fit have to be found back. None of as many
/// fails in one case of 20 where 1 % of all do (the rule of three).
const SIMULATED: u64 = 300;

/// Seed of the simulated noise.
const SEED: u64 = 0x5EE4;

/// Fewest speeds that show modes. Chosen: two phases of more than a few values.
const FEWEST: usize = 2 * (FEWEST_IN_PHASE + 1);

/// Relative difference of slopes that counts as rounding.
const SAME: f64 = 1e-9;

/// Modes in the order of the costs of [`decoded`].
const MODES: [Mode; 3] = [
    Mode::Slip(Side::Below),
    Mode::Stick,
    Mode::Slip(Side::Above),
];

/// A phase of one contact: start, end and mode.
pub type SeenPhase = (f64, f64, Mode);

/// Modes of a contact in a record, seen through one column.
///
/// A column shows the slip `h` of a contact where it, or its rate of change, depends on the states
/// by `h` alone: `y = a h + b(t)`, or `dy/dt = a h + b(t)` with a constant `a`. Modes are those of
/// the shortest description of the slip speeds (Rissanen, *Automatica* 14 (1978) 465). A speed in
/// slip costs the logarithm of the range of speeds, one in stick that of its deviation from zero,
/// and a change that of the number of speeds. Phases of a few rows are left out.
///
/// A column shows modes where its exact values give those of the motion itself. So must each of 300
/// records with simulated noise (a parametric bootstrap). Noise alone then gives another sequence
/// in less than 1 % of all records.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenModes {
    /// Index of the record, from 0.
    pub record: usize,
    /// Index of the contact, from 0.
    pub contact: usize,
    /// Index of the observable, from 0.
    pub observable: usize,
    /// Median standard deviation of the noise of the slip.
    pub sigma: f64,
    /// Phases of the data.
    pub data: Vec<SeenPhase>,
    /// Phases of the fitted motion, from the same rows in the same way.
    pub fit: Vec<SeenPhase>,
}

impl SeenModes {
    /// Whether data and fit have the same sequence of modes.
    pub fn is_same(&self) -> bool {
        modes(&self.data) == modes(&self.fit)
    }

    /// The number of sticks in the data and at the fit.
    pub fn sticks(&self) -> [usize; 2] {
        let count = |of: &[SeenPhase]| of.iter().filter(|phase| phase.2 == Mode::Stick).count();
        [count(&self.data), count(&self.fit)]
    }
}

/// A slip speed that some rows give.
struct Slip {
    from: f64,
    to: f64,
    fit: f64,
    /// Rows, and what a unit of their residuals adds to the speed.
    weights: Vec<(usize, f64)>,
    sigma: f64,
}

impl Slip {
    /// The speed at residuals of the column.
    fn at(&self, residuals: &[f64]) -> f64 {
        let parts = self.weights.iter();
        let parts = parts.map(|&(row, weight)| weight * residuals[row]);
        self.fit + parts.sum::<f64>()
    }
}

/// The fitted motion of a record.
struct Fitted<'a> {
    system: System,
    at: &'a Modelled,
    record: usize,
    times: &'a [f64],
}

/// How a column depends on the slip of a contact.
enum Shows {
    /// Directly, by this slope in each row.
    Slip(Vec<f64>),
    /// The rate of change does, by this slope; with the change up to each row in stick.
    Rate(f64, Vec<f64>),
}

impl FitProblem<'_> {
    /// Modes that the data of records show, by record and contact, at a point.
    pub(super) fn seen(&self, x: &Vector, at: &Modelled) -> Result<Vec<SeenModes>, FitError> {
        let mut found = Vec::new();
        let parts = self.parts.as_ref();
        let continues = |part: usize| parts.is_some_and(|parts| parts.continues(part));
        let runs = self.records.iter().enumerate();
        let runs = runs.filter(|(number, _)| !continues(*number));
        for (record, ((_, run), measured)) in runs.zip(&self.request.records).enumerate() {
            let values = run.local.iter().filter_map(|&(kind, place)| match kind {
                Kind::Parameter(number) => {
                    let parameter = run.system.file.parameters.get(number)?;
                    Some((&*parameter.name, x[place]))
                }
                _ => None,
            });
            let fitted = Fitted {
                system: run.system.with_values(&values.collect::<Vec<_>>())?,
                at,
                record,
                times: &measured.times,
            };
            let observed = self.request.observables.iter();
            let observed = observed.map(|one| fitted.system.observed(&one.formula, &[]));
            let observed = observed.collect::<Result<Vec<_>, _>>()?;
            for contact in 0..fitted.system.contacts() {
                let of_columns = observed.iter().enumerate().filter_map(|(k, observed)| {
                    let data = measured.columns.get(k)?;
                    let noise = *self.sigmas.get(k)?;
                    let seen = fitted.seen(contact, observed, (data, &at.values[record][k], noise));
                    seen.map(|(sigma, data, fit)| SeenModes {
                        record,
                        contact,
                        observable: k,
                        sigma,
                        data,
                        fit,
                    })
                });
                // Less noise shows more.
                found.extend(of_columns.min_by(|one, other| one.sigma.total_cmp(&other.sigma)));
            }
        }
        Ok(found)
    }
}

impl Fitted<'_> {
    /// Noise of the slip of a contact, and its phases in the data and at the fit, as far as a
    /// column shows them. `data`, `model` and the noise are of the column.
    fn seen(
        &self,
        contact: usize,
        observed: &Observed,
        column: (&[f64], &[f64], f64),
    ) -> Option<(f64, Vec<SeenPhase>, Vec<SeenPhase>)> {
        let shows = self.shows(contact, observed)?;
        let (data, model, noise) = column;
        let pairs = data.iter().zip(model);
        let residuals: Vec<f64> = pairs.map(|(data, model)| data - model).collect();
        let own = self.own(contact, &self.slips(contact, &shows, column, 1));
        let lasting: f64 = own.iter().map(|phase| phase.1 - phase.0).sum();
        if 2.0 * lasting < self.times.last()? - self.times.first()? {
            return None;
        }
        // Means of more rows have less noise, and show less of short phases.
        let steps = std::iter::successors(Some(1), |step| Some(2 * step));
        steps
            .take_while(|step| *step <= data.len() / FEWEST)
            .find_map(|step| {
                let slips = self.slips(contact, &shows, column, step);
                let all = slips
                    .iter()
                    .flat_map(|slip| [slip.at(&residuals), slip.fit]);
                let range = all.fold(0.0_f64, |range, slip| range.max(slip.abs()));
                let seen = |residuals: &[f64]| {
                    let modes = decoded(&slips, residuals, range);
                    phases(slips.iter().zip(modes))
                };
                let is_own = |phases: &[SeenPhase]| modes(phases) == modes(&own);
                let fit = seen(&vec![0.0; data.len()]);
                if slips.len() < FEWEST || !is_own(&fit) {
                    return None;
                }
                let is_found = |k: u64| {
                    // A deviate takes two random numbers.
                    let random = &mut SplitMix::from_index(SEED, 2 * k * data.len() as u64);
                    let deviates = (0..data.len()).map(|_| noise * normal_deviate(random));
                    is_own(&seen(&deviates.collect::<Vec<f64>>()))
                };
                if !(0..SIMULATED).into_par_iter().all(is_found) {
                    return None;
                }
                let mut sigmas: Vec<f64> = slips.iter().map(|slip| slip.sigma).collect();
                sigmas.sort_by(f64::total_cmp);
                Some((sigmas[sigmas.len() / 2], seen(&residuals), fit))
            })
    }

    /// Phases of the motion itself, in the time of slips.
    fn own(&self, contact: usize, slips: &[Slip]) -> Vec<SeenPhase> {
        let lasting = |slip: &&Slip| {
            let mut around = self.phases().iter().filter(|phase| phase.0 < phase.1);
            let around = around.find(|phase| phase.0 <= slip.from && slip.to <= phase.1)?;
            Some(around.2.get(contact))
        };
        phases(
            slips
                .iter()
                .filter_map(|slip| Some((slip, lasting(&slip)?))),
        )
    }

    /// How a column depends on the slip of a contact, if by it alone.
    fn shows(&self, contact: usize, observed: &Observed) -> Option<Shows> {
        if observed.has_force() {
            return None;
        }
        let points = self.at.points.get(self.record)?;
        let rows = self.times.iter().zip(points);
        let own = rows.clone().map(|(&t, point)| {
            let of = |x: &[Dual<f64>]| observed.value(self.modes(t), t, x);
            slopes(point, of)
        });
        let own: Vec<Vec<f64>> = own.collect();
        let boundary = rows.clone().map(|(&t, point)| {
            slopes(point, |x| {
                self.system.boundary(contact, Dual::constant(t), x)
            })
        });
        let boundary: Vec<Vec<f64>> = boundary.collect();
        let factors = own.iter().zip(&boundary).map(|(own, of)| factor(own, of));
        if let Some(factors) = factors.collect::<Option<Vec<f64>>>() {
            return Some(Shows::Slip(factors));
        }
        // The rate of change of a column that is linear in the states, and has no other part.
        let first = own.first()?;
        let begin = *self.times.first()?;
        let x: Vec<f64> = points.first()?.iter().copied().collect();
        let at = |t: f64| observed.value(self.modes(begin), t, &x);
        let is_moved = |t: &f64| (at(*t) - at(begin)).abs() > SAME * at(begin).abs();
        let is_bent = own.iter().any(|own| factor(own, first) != Some(1.0));
        if is_bent || self.times.iter().any(is_moved) {
            return None;
        }
        let mut slope = None;
        for ((&t, point), of) in rows.zip(&boundary) {
            for above in sides_to_check(self.system.contacts()) {
                let found = factor(&slopes(point, |x| self.rate(first, above, t, x)), of)?;
                let known = *slope.get_or_insert(found);
                if (found - known).abs() > SAME * known.abs() {
                    return None;
                }
            }
        }
        let slope = slope?;
        Some(Shows::Rate(slope, self.carried(contact, (slope, first))?))
    }

    /// The rate of change of a column with these derivatives by the states, on some sides.
    fn rate<T: Scalar>(&self, column: &[f64], above: usize, t: f64, x: &[T]) -> T {
        let of = Combination { above, held: 0 };
        let rates = self.system.field(of, T::constant(t), x);
        let parts = rates.into_iter().zip(column);
        parts.fold(T::zero(), |sum, (rate, part)| sum + rate * *part)
    }

    /// The slips that means of `step` rows show.
    fn slips(
        &self,
        contact: usize,
        shows: &Shows,
        (data, model, noise): (&[f64], &[f64], f64),
        step: usize,
    ) -> Vec<Slip> {
        let rows = (0..self.times.len()).filter(|row| !data[*row].is_nan());
        let rows: Vec<usize> = rows.collect();
        let blocks: Vec<&[usize]> = rows.chunks_exact(step).collect();
        let slip = |(from, to), fit, weights: Vec<(usize, f64)>| {
            let squares: f64 = weights.iter().map(|(_, weight)| weight * weight).sum();
            Slip {
                from,
                to,
                fit,
                weights,
                sigma: noise * squares.sqrt(),
            }
        };
        let span = |one: &[usize], other: &[usize]| {
            Some((self.times[*one.first()?], self.times[*other.last()?]))
        };
        match shows {
            Shows::Slip(slopes) => {
                let means = blocks.into_iter().filter_map(|rows| {
                    let part = 1.0 / rows.len() as f64;
                    let fits = rows.iter().map(|row| part * self.height(contact, *row));
                    let weights = rows.iter().map(|row| (*row, part / slopes[*row]));
                    Some(slip(span(rows, rows)?, fits.sum(), weights.collect()))
                });
                means.collect()
            }
            Shows::Rate(slope, carried) => {
                let pairs = blocks.windows(2).filter_map(|pair| {
                    let &[before, after] = pair else {
                        return None;
                    };
                    let (from, to) = span(before, after)?;
                    let mut jumps = self.phases().iter();
                    if jumps.any(|one| one.2.jump().is_some() && from < one.1 && one.1 <= to) {
                        return None;
                    }
                    let sum = |of: &dyn Fn(usize) -> f64| {
                        let pairs = before.iter().zip(after);
                        pairs.map(|(one, other)| of(*other) - of(*one)).sum::<f64>()
                    };
                    let part = 1.0 / (slope * sum(&|row| self.times[row]));
                    let fit = part * sum(&|row| model[row] - carried[row]);
                    let weights = after.iter().map(|row| (*row, part));
                    let weights = weights.chain(before.iter().map(|row| (*row, -part)));
                    Some(slip((from, to), fit, weights.collect()))
                });
                pairs.collect()
            }
        }
    }

    /// The boundary function of a contact at a row.
    fn height(&self, contact: usize, row: usize) -> f64 {
        let x: Vec<f64> = self.at.points[self.record][row].iter().copied().collect();
        self.system.boundary(contact, self.times[row], &x)
    }

    /// Change of a column from the first row to each if the contact sticks, by Gauss's rule of
    /// three points. `None` where it depends on the states.
    fn carried(&self, contact: usize, (slope, column): (f64, &[f64])) -> Option<Vec<f64>> {
        let points = &self.at.points[self.record];
        let nodes = [(0.0, 8.0), (-0.6_f64.sqrt(), 5.0), (0.6_f64.sqrt(), 5.0)];
        let mut all = vec![0.0];
        for (times, points) in self.times.windows(2).zip(points.windows(2)) {
            let &[from, to] = times else {
                return None;
            };
            let mut sum = 0.0;
            for (place, weight) in nodes {
                let t = 0.5 * (from + to + place * (to - from));
                let at = |point: &Vector| {
                    let x: Vec<f64> = point.iter().copied().collect();
                    let slip = slope * self.system.boundary(contact, t, &x);
                    let carried = self.rate(column, 0, t, &x) - slip;
                    (carried, carried.abs() + slip.abs())
                };
                let ((here, size), (there, _)) = (at(points.first()?), at(points.last()?));
                if (here - there).abs() > SAME * size {
                    return None;
                }
                sum += weight * here;
            }
            all.push(all.last()? + sum / 18.0 * (to - from));
        }
        Some(all)
    }

    fn phases(&self) -> &[(f64, f64, Modes)] {
        &self.at.phases[self.record]
    }

    fn modes(&self, t: f64) -> Modes {
        mode_at(self.phases(), t, Place::Behind)
    }
}

/// Derivatives of a function by the states.
fn slopes(point: &Vector, of: impl Fn(&[Dual<f64>]) -> Dual<f64>) -> Vec<f64> {
    let along = |state: usize| {
        let seeded = point.iter().enumerate();
        let seed = |k: usize| if k == state { 1.0 } else { 0.0 };
        let seeded: Vec<Dual<f64>> = seeded.map(|(k, x)| Dual::new(*x, seed(k))).collect();
        of(&seeded).eps
    };
    (0..point.len()).map(along).collect()
}

/// The factor other than zero by which one vector is another, if it is.
fn factor(own: &[f64], of: &[f64]) -> Option<f64> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let factor = product(own, of) / product(of, of);
    let largest = own.iter().fold(0.0_f64, |most, one| most.max(one.abs()));
    let mut pairs = own.iter().zip(of);
    let is_same = pairs.all(|(own, of)| (own - factor * of).abs() <= SAME * largest);
    (is_same && factor != 0.0 && factor.is_finite()).then_some(factor)
}

/// The modes of the shortest description of slips of this range (Viterbi, *IEEE Trans. Inf. Theory*
/// 13 (1967) 260).
fn decoded(slips: &[Slip], residuals: &[f64], range: f64) -> Vec<Mode> {
    let change = math::ln(slips.len() as f64);
    let mut costs = [0.0; MODES.len()];
    let mut before = Vec::with_capacity(slips.len());
    for slip in slips {
        let slipping = math::ln((range / slip.sigma).max(1.0));
        let off = slip.at(residuals) / slip.sigma;
        let squares = |off: f64| 0.5 * off * off;
        let own = [
            slipping + squares(off.max(0.0)),
            0.5 * math::ln(2.0 * PI) + squares(off),
            slipping + squares(off.min(0.0)),
        ];
        let best = |mode: usize| {
            let by = (0..MODES.len()).map(|from| {
                let cost = if from == mode { 0.0 } else { change };
                (costs[from] + cost, from)
            });
            let first = (costs[mode], mode);
            by.fold(
                first,
                |one, other| if other.0 < one.0 { other } else { one },
            )
        };
        let found = [0, 1, 2].map(best);
        before.push(found.map(|(_, from)| from));
        costs = [0, 1, 2].map(|mode: usize| found[mode].0 + own[mode]);
    }
    let mut mode =
        (0..MODES.len()).fold(1, |best, k| if costs[k] < costs[best] { k } else { best });
    let mut modes: Vec<Mode> = before
        .iter()
        .rev()
        .map(|from| {
            let now = MODES[mode];
            mode = from[mode];
            now
        })
        .collect();
    modes.reverse();
    modes
}

/// Successive equal modes as phases, without those of a few rows.
fn phases<'a>(slips: impl Iterator<Item = (&'a Slip, Mode)>) -> Vec<SeenPhase> {
    let mut all: Vec<(SeenPhase, usize)> = Vec::new();
    for (slip, mode) in slips {
        match all.last_mut().filter(|(last, _)| last.2 == mode) {
            Some((last, count)) => (last.1, *count) = (slip.to, *count + 1),
            None => all.push(((slip.from, slip.to, mode), 1)),
        }
    }
    let mut phases: Vec<SeenPhase> = Vec::new();
    for (phase, _) in all
        .into_iter()
        .filter(|(_, count)| *count > FEWEST_IN_PHASE)
    {
        match phases.last_mut().filter(|last| last.2 == phase.2) {
            Some(last) => last.1 = phase.1,
            None => phases.push(phase),
        }
    }
    phases
}

fn modes(of: &[SeenPhase]) -> Vec<Mode> {
    of.iter().map(|phase| phase.2).collect()
}
