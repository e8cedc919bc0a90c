//! Newton's iteration for a periodic orbit with a given sequence of modes.

use super::equations::ShootingEquations;
use super::newton::NewtonEquations;
use super::pieces::Piece;
use super::{
    Cycle, OrbitGuess, SegmentKind, Shooting, ShootingNodes, TOLERANCES, ULPS, closeness, resolved,
    segment_to_cut,
};
use crate::dynamics::{Dynamics, Modes, Moment, Vector};
use crate::filippov::Options;

/// Number of Newton iterations allowed. Chosen: from a guess with one digit, five iterations reach
/// rounding. More are of use where the Jacobian is nearly singular.
const MOST_ITERATIONS: usize = 14;

/// Largest residual that is attributed to rounding, as a fraction of the orbit's extent. Chosen:
/// orbits next to a saddle amplify rounding by up to ten digits.
const LARGEST_ROUNDING: f64 = 1e-6;

/// An iterate is abandoned if it goes this many times as far as orbits of the branch do. Chosen:
/// only iterates that run off go so far.
const FARTHEST: f64 = 100.0;

/// Relative precision to which the velocity closes. It excludes states next to an equilibrium, from
/// which any orbit returns to within the tolerances. Chosen: there the velocities differ by about
/// 1.
const SAME_VELOCITY: f64 = 1e-4;

impl<'a> Shooting<'a> {
    /// Shooting for orbits of a system near an outline, in which all components are states.
    /// `forced` is the period that a drive prescribes there.
    pub fn of(
        system: &'a dyn Dynamics,
        outline: &OrbitGuess,
        forced: Option<f64>,
        options: &'a Options,
    ) -> Self {
        let drive = system.period(&outline.begin.x);
        Shooting {
            system,
            states: system.states(),
            forced: forced.map(|period| match &drive {
                Some((drive, _)) => (period / drive).round(),
                None => period,
            }),
            extent: length(outline.extent, outline, system.states(), options),
            family: 0,
            plane: None,
            options,
            is_finer: false,
            budget: None,
        }
    }

    /// Equations with steps of half the length.
    pub fn finer(&self) -> Self {
        let is_finer = true;
        Shooting { is_finer, ..*self }
    }

    /// The period that a drive prescribes at a state, with its gradient in that.
    pub fn prescribed(&self, x: &Vector) -> Option<(f64, Vector)> {
        let count = self.forced?;
        let drive = self.system.period(x);
        let (period, gradient) = drive.unwrap_or_else(|| (1.0, Vector::zeros(x.len())));
        Some((count * period, gradient * count))
    }

    /// Whether an orbit has the phases of its sequence.
    pub fn is_valid(&self, cycle: &Cycle) -> bool {
        let mut margins = cycle.margins.iter();
        !margins.any(|margin| margin.is_violated(self.options))
    }

    /// [`Shooting::solve`] where the flow map has a derivative; in a family, the orbit nearest to
    /// the guess.
    pub fn nearest(&self, guess: &OrbitGuess, row: Option<(&Vector, f64)>) -> Option<Cycle> {
        let with_family = |family| {
            let found = Shooting { family, ..*self }.solve(guess, row);
            found.filter(Cycle::is_differentiable)
        };
        match with_family(0) {
            Some(found) if found.family > 0 => with_family(found.family).or(Some(found)),
            Some(found) => Some(found),
            None => with_family(1).filter(|found| found.family > 0),
        }
    }

    /// The equations at an orbit that solves them, whether or not another solution is adjacent.
    pub fn evaluated(&self, outline: &OrbitGuess) -> Option<Cycle> {
        let outline = match outline.cut {
            Some(_) => outline.clone(),
            None => self.cut(outline, self.options)?,
        };
        let equations = self.equations(&outline, &outline, self.options)?;
        let sizes = sizes(&equations.pieces);
        let period = outline.period();
        self.cycle(outline, equations, (period, sizes), (0, self.family))
    }

    /// Solves the equations near a guess. `row` is the last equation where a parameter is unknown:
    /// the product of the unknowns with it has a given value.
    pub fn solve(&self, guess: &OrbitGuess, row: Option<(&Vector, f64)>) -> Option<Cycle> {
        let by_tolerance = closeness(self.options);
        let farthest = guess.begin.x.amax() + FARTHEST * self.extent;
        let bounded = self.options.escape(self.options.escape.min(farthest));
        let guessed = guess.period();
        let mut outline = match guess.cut {
            Some(_) => guess.clone(),
            None => self.cut(guess, &bounded)?,
        };
        let mut last_residual = f64::INFINITY;
        for iterations in 1..=MOST_ITERATIONS {
            let equations = self.equations(&outline, guess, &bounded)?;
            let unknowns = outline.unknowns();
            let mut jacobian = equations.jacobian.clone();
            let mut right = -&equations.residuals;
            let mut is_on = true;
            if let Some((row, value)) = row {
                let first = unknowns.clone().resize_vertically(row.len(), 0.0);
                let off = value - row.dot(&first);
                is_on = off.abs() <= by_tolerance.min(1e-12) * row.amax();
                jacobian = jacobian.with_row(row);
                let rows = right.len();
                right = right.insert_row(rows, off);
            }
            let wanted = self.closes_to(&equations);
            let closes = equations.largest <= wanted
                && is_on
                && (equations.largest >= 0.5 * last_residual
                    || equations.largest <= f64::EPSILON * wanted);
            let sizes = sizes(&equations.pieces);
            let most = sizes.amax();
            let other = if most > by_tolerance { most } else { 1.0 };
            let scales = sizes.map(|size| if size > by_tolerance { size } else { other });
            let error = by_tolerance.max(ULPS * f64::EPSILON * equations.steps as f64);
            let step = NewtonEquations {
                jacobian,
                right,
                sizes: scales,
                error,
            };
            if closes {
                let family = step.free(self.states);
                return self.cycle(outline, equations, (guessed, sizes), (iterations, family));
            }
            // Next to a saddle nearly all directions seem undetermined; only in families some are.
            let solved = match self.family {
                0 => step.solution(),
                family => step.solution_without((self.states, family)),
            };
            last_residual = equations.largest;
            let step = self.without_rounding(&outline, solved?);
            outline = self.in_period(outline.with(&(unknowns + step)));
            let period = outline.period();
            let is_possible = (period - guessed).abs() < guessed
                && self.lasts(&outline, guessed)
                && outline.begin.x.iter().all(|v| v.is_finite());
            if !is_possible {
                return None;
            }
        }
        None
    }

    /// A change of the unknowns of an orbit, without what rounding adds to discrete states: their
    /// values are isolated.
    pub fn without_rounding(&self, outline: &OrbitGuess, mut change: Vector) -> Vector {
        let by_tolerance = closeness(self.options);
        let n = outline.begin.x.len();
        let first = n + outline.segments.len() + 1;
        let cuts = outline.cut.iter().flat_map(|cut| &cut.states).enumerate();
        let begins = std::iter::once(0).chain(cuts.map(|(number, _)| first + number * n));
        for begin in begins {
            let states = (0..self.states).filter(|&state| self.system.is_discrete(state));
            for state in states {
                let moved = &mut change[begin + state];
                if moved.abs() <= by_tolerance {
                    *moved = 0.0;
                }
            }
        }
        change
    }

    /// The outline of which the longest segment is changed so that it lasts for the period of the
    /// forcing: that is no unknown. It is for iterates, which lack rounding of it. A guess from a
    /// run may lack far more: its segments fit their events, and the next iterate shares the rest.
    fn in_period(&self, mut outline: OrbitGuess) -> OrbitGuess {
        let prescribed = self.prescribed(&outline.begin.x);
        let missing = prescribed.map_or(0.0, |(period, _)| period - outline.period());
        let rounding = ULPS * f64::EPSILON * outline.period();
        let segments = outline.segments.iter_mut();
        let longest = segments.max_by(|a, b| a.duration.total_cmp(&b.duration));
        if let Some(longest) = longest.filter(|_| missing.abs() > rounding) {
            longest.duration += missing;
        }
        outline
    }

    /// Whether no segment of an orbit with a period has a negative duration. Where two segments
    /// vanish at once, the second does so to within the tolerances.
    pub fn lasts(&self, outline: &OrbitGuess, period: f64) -> bool {
        let by_tolerance = closeness(self.options);
        let mut segments = outline.segments.iter();
        segments.all(|one| one.duration >= -by_tolerance * period)
    }

    /// Residual allowed in the equations, in the unit of the states.
    fn closes_to(&self, equations: &ShootingEquations) -> f64 {
        let by_tolerance = closeness(self.options);
        by_tolerance.max(equations.rounding.min(LARGEST_ROUNDING * self.extent))
    }

    /// State and mode of an orbit at a time that may differ by whole periods.
    pub fn place(&self, cycle: &Cycle, t: f64) -> Option<(Moment, Modes)> {
        // At a transition, to rounding, the next phase counts.
        let rounding = 64.0 * f64::EPSILON * (t.abs() + cycle.period);
        let since = |at: &Moment| {
            let time = (t - at.t).rem_euclid(cycle.period);
            if cycle.period - time <= rounding {
                0.0
            } else {
                time
            }
        };
        let begins = cycle.begins.iter().zip(&cycle.outline.segments);
        let last = begins.min_by(|(a, _), (b, _)| since(a).total_cmp(&since(b)));
        let (begin, segment) = last?;
        let piece = self.piece(segment, begin.clone(), since(begin), self.options)?;
        Some((piece.end, segment.mode))
    }

    fn cycle(
        &self,
        outline: OrbitGuess,
        equations: ShootingEquations,
        (guessed, sizes): (f64, Vector),
        (iterations, family): (usize, usize),
    ) -> Option<Cycle> {
        let (by_tolerance, extent) = (closeness(self.options), sizes.amax());
        let prescribed = self.prescribed(&outline.begin.x);
        let period = prescribed.map_or(outline.period(), |(period, _)| period);
        let [start, end] = &equations.velocities;
        let is_near = (period - guessed).abs() <= 0.3 * guessed;
        let within = SAME_VELOCITY.max(TOLERANCES * by_tolerance) * start.norm();
        let has_events = outline.segments.iter().any(|one| one.end.is_some());
        let is_same = self.forced.is_some() || has_events || (end - start).norm() <= within;
        // An orbit without extent is an equilibrium, unless it is that of a driven system.
        let is_point = self.forced.is_none() && extent <= by_tolerance;
        if !is_near || !is_same || is_point {
            return None;
        }
        let closes_to = self.closes_to(&equations);
        let margins = self.margins(&outline, &equations.pieces, closes_to);
        let flights = equations.pieces.windows(2).enumerate();
        let flights = flights.filter_map(|(number, pair)| match outline.segments[number].kind {
            SegmentKind::Flight { .. } => {
                let (_, impact) = pair[1].jumps.first()?;
                Some((number, impact.t - pair[0].begin.t))
            }
            _ => None,
        });
        Some(Cycle {
            flights: flights.collect(),
            anchor: equations.anchor,
            begins: equations
                .pieces
                .iter()
                .map(|one| one.begin.clone())
                .collect(),
            period,
            jacobian: equations.jacobian,
            monodromy: equations.monodromy,
            margins,
            extent: length(extent, &outline, self.states, self.options),
            ranges: sizes.rows(0, self.states).into_owned(),
            outline,
            closes_to,
            steps: equations.steps,
            iterations,
            family,
        })
    }

    /// The outline with the states between its segments and in the middle of one of them.
    fn cut(&self, outline: &OrbitGuess, options: &Options) -> Option<OrbitGuess> {
        let number = segment_to_cut(&outline.segments);
        let mut at = outline.begin.clone();
        let mut states = Vec::with_capacity(outline.segments.len());
        let mut middle = at.x.clone();
        for (k, segment) in outline.segments.iter().enumerate() {
            if k > 0 {
                states.push(at.x.clone());
            }
            if k == number {
                let half = self.piece(segment, at.clone(), 0.5 * segment.duration, options)?;
                middle = half.end.x;
            }
            at = self.piece(segment, at, segment.duration, options)?.end;
            if let Some(end) = segment.end.filter(|end| end.is_of_jump) {
                at.x = self.system.map(end.contact, &at).after;
            }
        }
        states.push(middle);
        Some(OrbitGuess {
            cut: Some(ShootingNodes { number, states }),
            ..outline.clone()
        })
    }
}

/// The unit of length of an orbit: its extent or, where it does not move, the size of its state.
/// For an orbit at zero it is 1. A length that is not [`resolved`] counts as zero.
fn length(extent: f64, outline: &OrbitGuess, states: usize, options: &Options) -> f64 {
    let least = resolved(options.coarsest());
    let size = outline.begin.x.rows(0, states).amax();
    let mut lengths = [extent, size].into_iter();
    lengths.find(|one| *one > least).unwrap_or(1.0)
}

/// The range of the components, at the ends of steps.
fn sizes(pieces: &[Piece]) -> Vector {
    let ends = pieces.iter().flat_map(|piece| &piece.steps);
    let mut ends = ends.map(|(step, _)| &step.x_end);
    let Some(first) = ends.next() else {
        return pieces
            .first()
            .map_or(Vector::zeros(0), |one| one.begin.x.abs() * 0.0);
    };
    let begin = &pieces[0].begin.x;
    let (mut low, mut high) = (first.inf(begin), first.sup(begin));
    for x in ends {
        (low, high) = (low.inf(x), high.sup(x));
    }
    high - low
}
