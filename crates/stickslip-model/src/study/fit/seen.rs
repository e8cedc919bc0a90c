//! Modes of contacts as the data show them, beside those at the fit.

use std::f64::consts::{PI, SQRT_2};

use stickslip::dynamics::{Modes, Vector};
use stickslip::math;
use stickslip::scalar::Dual;
use stickslip::{Mode, Scalar, Side};

use super::problem::FitProblem;
use super::record_run::{Place, mode_at};
use super::statistics::FEWEST_IN_PHASE;
use super::unknowns::Kind;
use super::{FitError, Modelled};
use crate::file::{Observed, System};
use crate::kernel::{Combination, sides_to_check};

/// Part of the values of the fit whose mode is seen right, from which a column shows modes. Chosen:
/// near the end of a slip its speed is below the noise.
const LEAST_RIGHT: f64 = 0.9;

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
/// and a change that of the number of speeds.
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
        let modes = |of: &[SeenPhase]| of.iter().map(|phase| phase.2).collect::<Vec<_>>();
        modes(&self.data) == modes(&self.fit)
    }

    /// The number of sticks in the data and at the fit.
    pub fn sticks(&self) -> [usize; 2] {
        let count = |of: &[SeenPhase]| of.iter().filter(|phase| phase.2 == Mode::Stick).count();
        [count(&self.data), count(&self.fit)]
    }
}

/// A slip speed that two rows, or one, give.
struct Slip {
    from: f64,
    to: f64,
    data: f64,
    fit: f64,
    sigma: f64,
    /// The mode of the fit in all of that time, if there is one.
    mode: Option<Mode>,
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
    /// The rate of change does, by this slope; with the derivatives of the column by the states.
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
        // Fewer rows show a rate of change better.
        let most = match shows {
            Shows::Slip(_) => 1,
            Shows::Rate(..) => self.times.len() / FEWEST,
        };
        let steps = std::iter::successors(Some(1), |step| Some(2 * step));
        steps.take_while(|step| *step <= most).find_map(|step| {
            let slips = self.slips(contact, &shows, column, step);
            let all = slips.iter().flat_map(|slip| [slip.data, slip.fit]);
            let range = all.fold(0.0_f64, |range, slip| range.max(slip.abs()));
            let seen = |of: fn(&Slip) -> f64| decoded(&slips, of, range);
            let fit = seen(|slip| slip.fit);
            let known = slips.iter().zip(&fit);
            let known = known.filter_map(|(slip, seen)| Some((slip.mode?, *seen)));
            let known: Vec<(Mode, Mode)> = known.collect();
            if slips.len() < FEWEST || 2 * known.len() < slips.len() || !are_seen(&known) {
                return None;
            }
            let mut sigmas: Vec<f64> = slips.iter().map(|slip| slip.sigma).collect();
            sigmas.sort_by(f64::total_cmp);
            let data = phases(&slips, &seen(|slip| slip.data));
            Some((sigmas[sigmas.len() / 2], data, phases(&slips, &fit)))
        })
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
        slope.map(|slope| Shows::Rate(slope, first.clone()))
    }

    /// The rate of change of a column with these derivatives by the states, on some sides.
    fn rate<T: Scalar>(&self, column: &[f64], above: usize, t: f64, x: &[T]) -> T {
        let of = Combination { above, held: 0 };
        let rates = self.system.field(of, T::constant(t), x);
        let parts = rates.into_iter().zip(column);
        parts.fold(T::zero(), |sum, (rate, part)| sum + rate * *part)
    }

    /// The slips that every `step`-th row shows.
    fn slips(
        &self,
        contact: usize,
        shows: &Shows,
        (data, model, noise): (&[f64], &[f64], f64),
        step: usize,
    ) -> Vec<Slip> {
        let points = &self.at.points[self.record];
        let phases = &self.at.phases[self.record];
        let rows = (0..self.times.len()).filter(|row| !data[*row].is_nan());
        let rows: Vec<usize> = rows.step_by(step).collect();
        let height = |t: f64, row: usize| {
            let x: Vec<f64> = points[row].iter().copied().collect();
            self.system.boundary(contact, t, &x)
        };
        let lasting = |from: f64, to: f64| {
            let mut around = phases.iter().filter(|phase| phase.0 < phase.1);
            let around = around.find(|phase| phase.0 <= from && to <= phase.1)?;
            Some(around.2.get(contact))
        };
        match shows {
            Shows::Slip(slopes) => rows
                .into_iter()
                .map(|row| {
                    let t = self.times[row];
                    let fit = height(t, row);
                    Slip {
                        from: t,
                        to: t,
                        data: fit + (data[row] - model[row]) / slopes[row],
                        fit,
                        sigma: noise / slopes[row].abs(),
                        mode: lasting(t, t),
                    }
                })
                .collect(),
            Shows::Rate(slope, column) => {
                let pairs = rows.windows(2).filter_map(|pair| {
                    let &[one, other] = pair else {
                        return None;
                    };
                    let (from, to) = (self.times[one], self.times[other]);
                    let mut jumps = phases.iter().filter(|phase| phase.2.jump().is_some());
                    if jumps.any(|phase| from < phase.1 && phase.1 <= to) {
                        return None;
                    }
                    let carried = self.carried(contact, (*slope, column), (one, other))?;
                    let time = slope * (to - from);
                    let of = |values: &[f64]| (values[other] - values[one] - carried) / time;
                    Some(Slip {
                        from,
                        to,
                        data: of(data),
                        fit: of(model),
                        sigma: noise * SQRT_2 / time.abs(),
                        mode: lasting(from, to),
                    })
                });
                pairs.collect()
            }
        }
    }

    /// Change of a column between two rows if the contact sticks, by Gauss's rule of three points.
    /// `None` where it depends on the states.
    fn carried(
        &self,
        contact: usize,
        (slope, column): (f64, &[f64]),
        (one, other): (usize, usize),
    ) -> Option<f64> {
        let (from, to) = (self.times[one], self.times[other]);
        let points = &self.at.points[self.record];
        let nodes = [(0.0, 8.0), (-0.6_f64.sqrt(), 5.0), (0.6_f64.sqrt(), 5.0)];
        let mut sum = 0.0;
        for (place, weight) in nodes {
            let t = 0.5 * (from + to + place * (to - from));
            let [(here, size), (there, _)] = [one, other].map(|row| {
                let x: Vec<f64> = points[row].iter().copied().collect();
                let slip = slope * self.system.boundary(contact, t, &x);
                let carried = self.rate(column, 0, t, &x) - slip;
                (carried, carried.abs() + slip.abs())
            });
            if (here - there).abs() > SAME * size {
                return None;
            }
            sum += weight * here;
        }
        Some(sum / 18.0 * (to - from))
    }

    fn modes(&self, t: f64) -> Modes {
        mode_at(&self.at.phases[self.record], t, Place::Behind)
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

/// Whether modes are seen as they are: most of them, and each phase of more than a few. Pairs have
/// the mode and that seen.
fn are_seen(known: &[(Mode, Mode)]) -> bool {
    let right = |of: &[(Mode, Mode)]| of.iter().filter(|(mode, seen)| mode == seen).count() as f64;
    let mut phases = known.chunk_by(|one, next| one.0 == next.0);
    right(known) >= LEAST_RIGHT * known.len() as f64
        && phases.all(|of| of.len() < FEWEST_IN_PHASE || 2.0 * right(of) > of.len() as f64)
}

/// The modes of the shortest description of slips of this range (Viterbi, *IEEE Trans. Inf. Theory*
/// 13 (1967) 260).
fn decoded(slips: &[Slip], of: fn(&Slip) -> f64, range: f64) -> Vec<Mode> {
    let change = math::ln(slips.len() as f64);
    let mut costs = [0.0; MODES.len()];
    let mut before = Vec::with_capacity(slips.len());
    for slip in slips {
        let slipping = math::ln((range / slip.sigma).max(1.0));
        let off = of(slip) / slip.sigma;
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

/// Successive equal modes as phases.
fn phases(slips: &[Slip], modes: &[Mode]) -> Vec<SeenPhase> {
    let mut phases: Vec<SeenPhase> = Vec::new();
    for (slip, mode) in slips.iter().zip(modes) {
        match phases.last_mut().filter(|last| last.2 == *mode) {
            Some(last) => last.1 = slip.to,
            None => phases.push((slip.from, slip.to, *mode)),
        }
    }
    phases
}
