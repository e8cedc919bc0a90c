//! Test functions of the multipliers: the special orbits between two orbits of a branch.

use super::crossings::{
    Crossed, Crossing, Eigenvalue, Eigenvalues, MOST_HALVINGS, OnLine, Spectra,
};
use super::steps::Continuation;
use super::tangent_line::TangentLine;
use super::{CycleBifurcation, Stop, critical, parameter_of};
use crate::analysis::critical::zero_between;
use crate::analysis::cycle::{
    Cycle, LocatedZero, SAFETY, Shooting, SolutionFunction, SolutionsOnLine, with_last_digits,
};
use crate::analysis::lagrange::weights;
use crate::analysis::multipliers::{eigenvalues, uncertainties};
use crate::analysis::stability::NEUTRAL_DISTANCE;
use crate::dynamics::Vector;
use crate::math::{self, modulus};

/// The orbits on a line of a branch, with their multipliers.
struct Multipliers<'l, 'a> {
    continuation: &'l Continuation<'a>,
    line: &'l TangentLine,
}

impl SolutionsOnLine for Multipliers<'_, '_> {
    type Solution = Cycle;

    fn on(&self, place: f64) -> Option<Cycle> {
        self.line.on(&self.continuation.shooting, place)
    }

    fn finer(&self, place: f64) -> Option<Cycle> {
        self.line.on(&self.continuation.shooting.finer(), place)
    }

    fn parameter(&self, cycle: &Cycle) -> f64 {
        parameter_of(cycle)
    }
}

impl Spectra for Multipliers<'_, '_> {
    /// The multipliers, where the flow map has a derivative. One that is as near to the unit circle
    /// as [`crate::analysis::Stability`] says is neutral.
    fn spectrum(&self, cycle: &Cycle) -> Option<Eigenvalues> {
        let of = critical(cycle, &self.continuation.shooting)?;
        let eigenvalue = |value| Eigenvalue {
            value,
            beyond: modulus(value) - 1.0,
            uncertainty: NEUTRAL_DISTANCE,
        };
        Some(Eigenvalues(of.others.into_iter().map(eigenvalue).collect()))
    }

    /// The multipliers with their uncertainties by half the steps.
    fn known_spectrum(&self, place: f64, cycle: &Cycle) -> Option<Eigenvalues> {
        let mut spectrum = self.resolved_spectrum(place, cycle)?;
        for one in &mut spectrum.0 {
            one.uncertainty = one.uncertainty.max(NEUTRAL_DISTANCE);
        }
        Some(spectrum)
    }

    fn locate(
        &self,
        ends: [(f64, f64); 2],
        function: &SolutionFunction<'_>,
    ) -> Option<LocatedZero> {
        self.continuation.zero(self.line, ends, function)
    }
}

impl Multipliers<'_, '_> {
    /// The multipliers, with their uncertainties by half the steps alone.
    fn resolved_spectrum(&self, place: f64, cycle: &Cycle) -> Option<Eigenvalues> {
        let mut spectrum = self.spectrum(cycle)?;
        let finer = self.finer(place)?;
        let values: Vec<_> = spectrum.0.iter().map(|one| one.value).collect();
        let (others, largest) = (eigenvalues(&finer.monodromy), cycle.monodromy.amax());
        let known = uncertainties(&values, others, largest);
        for (one, known) in spectrum.0.iter_mut().zip(known) {
            one.uncertainty = known;
        }
        Some(spectrum)
    }

    /// Whether a multiplier that would cross like this is neutral at both of two orbits, as far as
    /// integration resolves it. Test functions of folds and branch points are none of multipliers.
    fn remains_neutral(&self, orbits: [(f64, &Cycle); 2], crossing: Crossing) -> bool {
        let is_neutral = |(place, cycle): (f64, &Cycle)| {
            self.spectrum(cycle)
                .is_none_or(|one| one.has_neutral(crossing))
                && self
                    .resolved_spectrum(place, cycle)
                    .is_none_or(|one| one.has_neutral(crossing))
        };
        crossing != Crossing::Positive && orbits.into_iter().all(is_neutral)
    }
}

impl Continuation<'_> {
    /// Continues to an orbit on the line, and records the special orbits before it, by their
    /// multipliers. Returns the reason if the branch ends before that orbit.
    pub(super) fn follow(
        &mut self,
        line: &TangentLine,
        next: Cycle,
        onward: Option<TangentLine>,
    ) -> Option<Stop> {
        // Where a function is exactly zero at the last orbit, it is taken so far before that, as a
        // fraction of the step.
        const BEFORE: f64 = 1e-3;
        // Distance at which a fold and a branch point are one, as a fraction of the step. Chosen:
        // each is located at least ten times as precisely.
        const SAME_POINT: f64 = 0.1;
        let shooting = self.shooting;
        let of = |cycle: &Cycle| critical(cycle, &shooting);
        let length = line.place(&next);
        let (units, across) = (self.branch.units.clone(), line.across());
        let heading = |cycle: &Cycle| Some(line.continued(&shooting, &units, cycle)?.heading());
        // Zero where another branch crosses this one (Keller 1977).
        let determinant = |cycle: &Cycle| cycle.jacobian.with_row(across).determinant();
        let size = determinant(&self.branch.last).exponent;
        let border = |cycle: &Cycle| Some(determinant(cycle).over_power(size));
        let minus_one = |cycle: &Cycle| Some(of(cycle)?.minus_one);
        let circle = |cycle: &Cycle| of(cycle)?.circle;
        let functions: [&SolutionFunction<'_>; 4] = [&heading, &border, &minus_one, &circle];
        let mut zeros = Vec::new();
        // In a family there are several tangents everywhere, without a fold or a branch point. At a
        // flip of the half, the branch turns and meets that of the half run through twice.
        let flip = self.flip_of_half(line, &next);
        let has_one_tangent = shooting.family == 0 && flip.is_none();
        let first = if has_one_tangent { 0 } else { 2 };
        // Where two branches meet, the equations leave the tangent undetermined. The rate there is
        // that of the parabola through both orbits with the tangent at the other one.
        let chord = (parameter_of(&next) - self.parameter()) / length;
        let is_undetermined = self.begins_on_other && self.branch.points.len() == 1;
        // At a change of the phases with a multiplier 1, rounding decides the sign of the first two
        // functions.
        let change = self.branch.special.last().filter(|one| {
            let is_change = matches!(one.what, CycleBifurcation::Sequence(_));
            is_change && one.behind + 1 == self.branch.points.len()
        });
        let is_of_change = |zero: &LocatedZero| {
            change.is_some_and(|change| {
                let off = (zero.parameter - change.parameter).abs();
                off <= zero.uncertainty + change.uncertainty
            })
        };
        // Beyond a flip of the half, the orbits are those before it, begun at the other half.
        let end = flip.as_ref().map_or(&next, |flip| &flip.solution);
        let place_of_end = line.place(end);
        let multipliers = Multipliers {
            continuation: self,
            line,
        };
        let spectra = [&self.branch.last, end].map(|one| multipliers.spectrum(one));
        let earlier = match &spectra {
            [Some(last), Some(next)] if !is_undetermined => {
                multipliers.before_neutral(length, [last, next])
            }
            _ => None,
        };
        let [own, spectrum] = spectra;
        let ((begins, begin), own) = match &earlier {
            Some((s, cycle)) => ((*s, cycle), multipliers.spectrum(cycle)),
            None => ((0.0, &self.branch.last), own),
        };
        let spectra = [own, spectrum];
        let begin_of_step = begin;
        // Those between there and the last orbit were recorded in the step before.
        let special = self.branch.special.iter();
        let recorded = special
            .filter(|one| earlier.is_some() && one.behind + 1 == self.branch.points.len())
            .filter_map(|one| crossing_of(&one.what));
        let recorded: Vec<Crossing> = recorded.collect();
        let mut located: Vec<(f64, Crossing)> = recorded.iter().map(|one| (0.0, *one)).collect();
        for (kind, function) in functions.into_iter().enumerate().skip(first) {
            let Some(b) = function(end) else {
                continue;
            };
            let crossing = [Crossing::Positive, Crossing::Positive, Crossing::Negative];
            let crossing = crossing.get(kind).copied().unwrap_or(Crossing::Pair(0));
            let is_recorded = recorded.iter().any(|one| one.is_alike(crossing));
            if is_recorded {
                continue;
            }
            let at = |begin: f64, function: &SolutionFunction<'_>| {
                Some((begin, function(&line.on(&shooting, begin)?)?))
            };
            let begin = match kind {
                0 if is_undetermined => Some((0.0, 2.0 * chord - b)),
                // The determinant has its simple zero at the meeting, too.
                1 if is_undetermined => at(0.5 * length, &border),
                0 | 1 if earlier.is_none() => match function(&self.branch.last) {
                    Some(0.0) => at(-BEFORE * length, function),
                    value => value.map(|a| (0.0, a)),
                },
                _ => function(begin).map(|a| (begins, a)),
            };
            let Some((begin, a)) = begin else {
                continue;
            };
            let orbits = [(begins, begin_of_step), (place_of_end, end)];
            if a * b >= 0.0 || multipliers.remains_neutral(orbits, crossing) {
                continue;
            }
            let ends = [(begin, a), (place_of_end, b)];
            let zero = match kind {
                1 => self.meeting(line, ends, function),
                _ => self.zero(line, ends, function),
            };
            let Some(zero) = zero else {
                continue;
            };
            // A zero that is less certain than its distance to both orbits belongs to a tangent
            // that is undetermined.
            let off = |one: &Cycle| (parameter_of(one) - zero.parameter).abs();
            let from_last = off(&self.branch.last);
            let farthest = if is_undetermined {
                from_last
            } else {
                from_last.max(off(&next))
            };
            let is_resolved = zero.uncertainty < farthest;
            let what = match kind {
                0 => CycleBifurcation::Fold,
                1 => CycleBifurcation::BranchPoint,
                2 => CycleBifurcation::Flip,
                _ => match of(&zero.solution) {
                    // Two real ones that meet at -1 are a pair to rounding.
                    Some(of) if math::sin(of.angle) > NEUTRAL_DISTANCE => {
                        CycleBifurcation::NeimarkSacker { angle: of.angle }
                    }
                    _ => continue,
                },
            };
            let crossing = match crossing {
                Crossing::Pair(_) => Crossing::Pair(if a < b { 2 } else { -2 }),
                real => real,
            };
            located.push((zero.s, crossing));
            if (kind == 0 && !is_resolved) || (kind < 2 && is_of_change(&zero)) {
                continue;
            }
            zeros.push((zero, what));
        }
        if let [Some(a), Some(b)] = &spectra
            && flip.is_none()
            && !is_undetermined
            && !a.explains(b, &located)
            && let Some(a) = multipliers.known_spectrum(begins, begin)
            && let Some(b) = multipliers.known_spectrum(length, &next)
        {
            // Test functions of multipliers that remain neutral have no zeros.
            let orbits = [(begins, begin), (length, &next)];
            let is_neutral = |crossing| multipliers.remains_neutral(orbits, crossing);
            located.retain(|(_, crossing)| !is_neutral(*crossing));
            zeros.retain(|(_, what)| !crossing_of(what).is_some_and(is_neutral));
            let ends = [&(begins, begin, a), &(length, &next, b)];
            let hidden = multipliers.hidden(ends, &located, MOST_HALVINGS);
            let turns = [begin, &next].map(heading);
            let turns = matches!(turns, [Some(a), Some(b)] if a * b < 0.0);
            zeros.extend(hidden.into_iter().map(|one| named(one, ends, turns)));
        }
        zeros.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
        let index = |kind: &CycleBifurcation| zeros.iter().position(|(_, what)| what == kind);
        let meets = [CycleBifurcation::Fold, CycleBifurcation::BranchPoint];
        let meets = meets.each_ref().map(index);
        let back = (meets != [None, None]).then(|| self.back_at(&next));
        let is_same_way = |part: f64| {
            let has_turned = meets[0].is_some_and(|fold| zeros[fold].0.s < part * length);
            let there = if has_turned {
                onward.as_ref()
            } else {
                Some(line)
            };
            self.goes_on_as_first(there)
        };
        if back.flatten().is_some_and(is_same_way) {
            let first = self.branch.first.clone();
            self.take(first);
            return Some(Stop::Closed);
        }
        // A branch that leaves another one to one side turns there.
        if let [Some(fold), Some(point)] = meets
            && (zeros[fold].0.s - zeros[point].0.s).abs() <= SAME_POINT * length
        {
            let is_better = zeros[fold].0.uncertainty < zeros[point].0.uncertainty;
            let (kept, other) = if is_better {
                (fold, point)
            } else {
                (point, fold)
            };
            zeros[kept].1 = CycleBifurcation::BranchPoint;
            zeros.remove(other);
        }
        if let Some(flip) = &flip {
            zeros.retain(|(zero, _)| zero.s < flip.s);
        }
        for (zero, what) in zeros {
            self.record_special(what, zero, line.clone(), None);
        }
        if let Some(flip) = flip {
            return Some(Stop::Flip {
                parameter: flip.parameter,
                uncertainty: self.with_last_digits(flip.parameter, flip.uncertainty),
            });
        }
        self.take(next);
        self.branch.line = onward;
        None
    }

    /// Zero at which both halves become the same orbit, between the last orbit and another one on a
    /// line: their difference passes through zero.
    fn flip_of_half(&self, line: &TangentLine, next: &Cycle) -> Option<LocatedZero> {
        // Largest difference at the nearest orbit that can be computed, as a fraction of the
        // difference at the ends. Chosen: Newton's matrix is singular at the flip.
        const LARGEST_LEFT: f64 = 0.2;
        let last = &self.branch.last;
        let [before, behind] = [last.halves()?, next.halves()?];
        let is_resolved = before.amax() > last.closes_to && behind.amax() > next.closes_to;
        if before.len() != behind.len() {
            return None;
        }
        let direction = behind.normalize();
        // An orbit of equal halves is one of the other branch.
        let part = |one: &Cycle| {
            let halves = one
                .halves()
                .filter(|halves| halves.amax() > one.closes_to)?;
            Some(halves.dot(&direction))
        };
        let (a, b) = (part(last)?, part(next)?);
        if !is_resolved || a >= 0.0 {
            return None;
        }
        let ends = [(0.0, a), (line.place(next), b)];
        let zero = self.meeting(line, ends, &part)?;
        let left = zero.solution.halves()?.norm();
        (left <= LARGEST_LEFT * before.norm().max(behind.norm())).then_some(zero)
    }

    /// Part of the way from the last orbit to another one at which the branch passes its first
    /// orbit, if it does.
    fn back_at(&self, next: &Cycle) -> Option<f64> {
        // Distance by which a straight line between them may miss it, as a fraction of its length.
        // Chosen: the branch bends little in a step.
        const LARGEST_MISS: f64 = 0.1;
        let off = [&self.branch.last, next].map(|one| self.offset_from_first(one));
        let [Some(before), Some(behind)] = off else {
            return None;
        };
        let between = &behind - &before;
        let part = -before.dot(&between) / between.norm_squared();
        let miss = (&before + &between * part).norm();
        let is_near = miss <= LARGEST_MISS * between.norm();
        let is_back = self.branch.points.len() > 3 && (0.0..=1.0).contains(&part) && is_near;
        is_back.then_some(part)
    }

    /// Zero of a function on a line, between two places at which it has different signs. The
    /// parameter is that of the orbit there or, if that is more precise, follows from orbits around
    /// it: next to a multiplier of 1, the closing error exceeds rounding.
    pub(super) fn zero(
        &self,
        line: &TangentLine,
        [a, b]: [(f64, f64); 2],
        function: &SolutionFunction<'_>,
    ) -> Option<LocatedZero> {
        // Number of tolerances, relative to the parameter or the range. Chosen: in most cases the
        // zero itself is more precise, and the orbits around it need not be computed.
        const PRECISE: f64 = 100.0;
        // Part of the range that is resolved in any case.
        const RESOLVED: f64 = 1e-6;
        let width = self.branch.units.width;
        let size = width.max(self.parameter().abs());
        let precise = (PRECISE * self.shooting.options.rtol * size).min(RESOLVED * width);
        let direct = line.orbits(&self.shooting).zero([a, b], function);
        if direct
            .as_ref()
            .is_some_and(|zero| zero.uncertainty <= precise)
        {
            return direct;
        }
        let rough = direct.as_ref().map_or(secant(a, b), |zero| zero.s);
        let interpolated = self.interpolated_from_afar(line, (b.0 - a.0, rough), function, precise);
        let interpolated = interpolated.map(|(zero, _)| zero);
        let (Some(direct), Some(interpolated)) = (&direct, &interpolated) else {
            return direct.or(interpolated);
        };
        let is_better =
            interpolated.uncertainty < direct.uncertainty || direct.uncertainty.is_nan();
        let best = if is_better { interpolated } else { direct };
        Some(LocatedZero {
            parameter: best.parameter,
            uncertainty: best.uncertainty,
            solution: direct.solution.clone(),
            ..*direct
        })
    }

    /// [`Continuation::zero`] where another branch meets this one. Newton's matrix is singular
    /// there, so that place and orbit are those of the polynomial through orbits around it.
    fn meeting(
        &self,
        line: &TangentLine,
        [a, b]: [(f64, f64); 2],
        function: &SolutionFunction<'_>,
    ) -> Option<LocatedZero> {
        let direct = line.orbits(&self.shooting).zero([a, b], function);
        let rough = direct.as_ref().map_or(secant(a, b), |zero| zero.s);
        match self.interpolated_from_afar(line, (b.0 - a.0, rough), function, 0.0) {
            Some((mut zero, at_zero)) => {
                zero.solution = at_zero.unwrap_or(zero.solution);
                Some(zero)
            }
            None => direct,
        }
    }

    /// [`Continuation::interpolated`], with the parameter from orbits ever farther away, as long as
    /// that makes it more precise and it is not precise enough. Next to a multiplier of 1, the
    /// closing errors of orbits fall with their distance. The error of the polynomial rises with
    /// it, so that nothing farther away helps where that one decides.
    fn interpolated_from_afar(
        &self,
        line: &TangentLine,
        (mut length, rough): (f64, f64),
        function: &SolutionFunction<'_>,
        precise: f64,
    ) -> Option<(LocatedZero, Option<Cycle>)> {
        let (mut best, mut of_polynomial, at_zero) =
            self.interpolated(line, length, rough, function)?;
        while best.uncertainty > precise && 2.0 * of_polynomial < best.uncertainty {
            length *= 2.0;
            match self.interpolated(line, length, best.s, function) {
                Some((wider, of_wider, _)) if wider.uncertainty < best.uncertainty => {
                    (best.parameter, best.uncertainty) = (wider.parameter, wider.uncertainty);
                    of_polynomial = of_wider;
                }
                _ => break,
            }
        }
        Some((best, at_zero))
    }

    /// Zero of a function near a place, by a polynomial through orbits around it; the part of the
    /// uncertainty that is the polynomial's; and the orbit there. Where another branch crosses this
    /// one, Newton's matrix is singular, and no orbit can be computed close to it.
    fn interpolated(
        &self,
        line: &TangentLine,
        length: f64,
        rough: f64,
        function: &SolutionFunction<'_>,
    ) -> Option<(LocatedZero, f64, Option<Cycle>)> {
        // Distance of the nodes, as a fraction of that between the last two orbits. Chosen:
        // shorter, the closing errors would decide; longer, the degree of the polynomial.
        const SPACING: f64 = 0.05;
        const NODES_EACH_SIDE: i32 = 4;
        // Some orbits may not be computed: at least as many nodes as for degree four.
        const FEWEST_NODES: usize = 5;
        let node = |s: f64, shooting: &Shooting<'_>| {
            let cycle = line.on(shooting, s)?;
            let value = function(&cycle)?;
            Some(Node { s, value, cycle })
        };
        let places = (-NODES_EACH_SIDE..=NODES_EACH_SIDE).filter(|k| *k != 0);
        let places = places.map(|k| rough + SPACING * length * f64::from(k));
        let finer = self.shooting.finer();
        // An orbit that half the steps do not find has an unknown error.
        let both = |s: f64| Some((node(s, &self.shooting)?, node(s, &finer)?));
        let (nodes, finer): (Vec<Node>, Vec<Node>) = places.filter_map(both).unzip();
        let all: Vec<&Node> = nodes.iter().collect();
        if nodes.len() < FEWEST_NODES {
            return None;
        }
        let (s, parameter) = zero_of_polynomial(&all)?;
        // Without the farthest nodes, the result differs by the polynomial's error; without the
        // nearest, by rounding.
        let mut sizes: Vec<f64> = nodes.iter().map(|one| one.value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let apart: Vec<&Node> = all
            .iter()
            .copied()
            .filter(|one| one.value.abs() > sizes[1])
            .collect();
        let fewer = [&all[1..nodes.len() - 1], &apart].map(zero_of_polynomial);
        let off =
            |other: Option<(f64, f64)>| other.map_or(f64::NAN, |(_, p)| (parameter - p).abs());
        // Next to a multiplier of 1, what an orbit leaves open is amplified, and has either sign.
        // So the effects of half the steps at the single nodes are added.
        let effects = finer.iter().enumerate().map(|(k, other)| {
            let mut changed = all.clone();
            changed[k] = other;
            off(zero_of_polynomial(&changed))
        });
        let of_steps = SAFETY * effects.sum::<f64>();
        let nearest = nodes.iter().find(|one| one.value.abs() == sizes[0])?;
        let (of_polynomial, of_rounding) = (off(fewer[0]), off(fewer[1]));
        let at_zero = self.interpolated_orbit(&all, s);
        let zero = LocatedZero {
            s,
            parameter,
            solution: nearest.cycle.clone(),
            uncertainty: of_polynomial + of_rounding + of_steps,
        };
        Some((zero, of_polynomial, at_zero))
    }

    /// The orbit at a place, by the polynomial through the unknowns of the nodes: Newton's method
    /// cannot compute it where its matrix is singular.
    fn interpolated_orbit(&self, nodes: &[&Node], s: f64) -> Option<Cycle> {
        let places: Vec<f64> = nodes.iter().map(|node| node.s).collect();
        let outline = &nodes.first()?.cycle.outline;
        let mut unknowns = Vector::zeros(outline.unknowns().len());
        for (weight, node) in weights(&places, s).into_iter().zip(nodes) {
            let of_node = node.cycle.outline.unknowns();
            if of_node.len() != unknowns.len() {
                return None;
            }
            unknowns += of_node * weight;
        }
        self.shooting.evaluated(&outline.with(&unknowns))
    }

    /// An uncertainty, with what rounding leaves of a parameter's last digits. Where it
    /// is NaN, the place lies in the last step.
    pub(super) fn with_last_digits(&self, parameter: f64, uncertainty: f64) -> f64 {
        let step = (self.parameter() - parameter_of(&self.branch.before)).abs();
        let of_rounding = (self.branch.units.width, self.branch.last.steps);
        with_last_digits((parameter, uncertainty), step, of_rounding)
    }
}

/// How multipliers cross the unit circle at a special orbit.
fn crossing_of(what: &CycleBifurcation) -> Option<Crossing> {
    match what {
        CycleBifurcation::Fold | CycleBifurcation::BranchPoint => Some(Crossing::Positive),
        CycleBifurcation::Flip => Some(Crossing::Negative),
        CycleBifurcation::NeimarkSacker { .. } => Some(Crossing::Pair(0)),
        _ => None,
    }
}

/// The special orbit at which multipliers cross between two orbits.
fn named(
    one: Crossed<Cycle>,
    ends: [&OnLine<'_, Cycle>; 2],
    turns: bool,
) -> (LocatedZero, CycleBifurcation) {
    let [before, after] = ends.map(|end| end.2.unstable());
    let what = match one.crossing {
        _ if !one.is_resolved => CycleBifurcation::Unresolved { before, after },
        Crossing::Positive if turns => CycleBifurcation::Fold,
        Crossing::Positive => CycleBifurcation::BranchPoint,
        Crossing::Negative => CycleBifurcation::Flip,
        Crossing::Pair(_) => CycleBifurcation::NeimarkSacker {
            angle: math::atan2(one.value.im.abs(), one.value.re),
        },
    };
    (one.at, what)
}

/// The place where a straight line through two values is zero.
fn secant(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1)
}

/// An orbit on a line, and the value of a function there.
struct Node {
    s: f64,
    value: f64,
    cycle: Cycle,
}

/// Zero of the polynomial through a function's nodes between two of them, and the parameter there.
fn zero_of_polynomial(nodes: &[&Node]) -> Option<(f64, f64)> {
    let places: Vec<f64> = nodes.iter().map(|node| node.s).collect();
    let at = |s: f64, of: fn(&Node) -> f64| -> f64 {
        let terms = weights(&places, s).into_iter().zip(nodes);
        terms.map(|(weight, node)| weight * of(node)).sum()
    };
    let mut pairs = nodes.windows(2);
    let ends = pairs.find(|two| two[0].value * two[1].value < 0.0)?;
    let [a, b] = [ends[0], ends[1]].map(|node| (node.s, node.value));
    let s = zero_between(a, b, |s| Some(at(s, |node| node.value)))?;
    Some((s, at(s, |node| parameter_of(&node.cycle))))
}
