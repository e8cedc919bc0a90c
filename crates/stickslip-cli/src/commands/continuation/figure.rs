//! The branch over the parameter: extremes of the orbits, periods and largest multipliers.

use plot::{
    BLACK, BLUE, Color, Curve, Dash, Figure, GREEN, Guide, Legend, Markers, ORANGE, PURPLE, Panel,
    Shape, VERMILLION,
};
use stickslip::analysis::{CycleBifurcation, SpecialPoint, Stability, Stop};
use stickslip::math::modulus;
use stickslip_model::file::System;
use stickslip_model::study::{BranchEnd, BranchOrbit, TwoSidedBranch};

use super::super::figures;
use super::super::range::ParameterRange;

/// Computes a value of an orbit.
type ValueOfOrbit = fn(&BranchOrbit) -> f64;

const LARGEST_MULTIPLIER: &str = "largest multiplier";

/// Largest multiplier that is drawn. Those of unstable orbits may have any size. Chosen: the unit
/// circle stays visible.
const LARGEST_DRAWN: f64 = 3.0;

/// Plots the branches. The first is the one through the initial orbit.
pub(super) fn diagram(
    system: &System,
    range: &ParameterRange,
    branches: &[&TwoSidedBranch],
) -> Figure {
    let first = &system.file.states[0];
    let largest: ValueOfOrbit = |at| {
        let sizes = at.orbit.multipliers.iter().map(|one| modulus(*one));
        // For orbits that stick it is zero up to rounding.
        match sizes.fold(0.0, f64::max) {
            largest if largest > LARGEST_DRAWN => f64::NAN,
            largest if largest < 1e-9 => 0.0,
            largest => largest,
        }
    };
    let extent = |which: &str| format!("{which} {}", figures::with_unit(&first.name, &first.unit));
    let period = figures::in_time(system, "period", "");
    // Multipliers are accurate to 1e-6. Maximum and minimum have separate scales, so that the two
    // parts of a closed branch can be distinguished.
    let extents: [(String, ValueOfOrbit); 2] = [
        (extent("greatest"), |at| at.extremes[0].1),
        (extent("least"), |at| at.extremes[0].0),
    ];
    let others: [(String, ValueOfOrbit, f64); 2] = [
        (period, |at| at.orbit.period, 0.0),
        (LARGEST_MULTIPLIER.to_owned(), largest, 1e-6),
    ];
    // The period of a driven system is not informative, unless it varies with the parameter.
    let others = others
        .into_iter()
        .filter(|(_, value, error)| differs(branches, *value, *error))
        .map(|(label, value, _)| (label, value));
    let of_extents = extents.len();
    let rows: Vec<(String, ValueOfOrbit)> = extents.into_iter().chain(others).collect();
    let title = format!("{}: branch of periodic orbits", system.file.name);
    let description = format!(
        "A branch of periodic orbits of {} over {} from {} to {}: least and greatest {}, period, \
         and the largest multiplier up to {LARGEST_DRAWN}; whole lines where it is stable, dotted \
         where neutral, dashed where unstable; marks at folds, flips, branch points, torus \
         bifurcations, changes of its phases, and where it ends in an equilibrium, a homoclinic \
         orbit or rest.",
        system.file.name, range.name, range.low, range.high, first.name
    );
    let height = 90.0 + 160.0 * rows.len() as f64;
    let mut figure = Figure::new("continue", (640.0, height), &title, &description);
    let last = rows.len() - 1;
    let mut in_legend: Vec<Stability> = Vec::new();
    for (k, (label, value)) in rows.into_iter().enumerate() {
        let x = figures::parameter_axis(system, &range.name, ends(range, branches), k == last);
        let ends = branches.iter().flat_map(|branch| {
            let ends = [branch.points.first(), branch.points.last()];
            ends.into_iter().zip(&branch.stops)
        });
        let ends: Vec<(&Stop, (f64, f64))> = ends
            .filter_map(|(end, stop)| Some((stop, end_mark(end?, stop, value, k < of_extents))))
            .collect();
        let of_ends = ends.iter().map(|(_, mark)| mark.1);
        let all = points(branches).map(value).chain(of_ends);
        let is_size = label == LARGEST_MULTIPLIER;
        let mut panel = Panel::new(x, figures::axis(&label, all));
        if is_size {
            panel.add(Guide::horizontal(1.0));
        }
        let runs = branches.iter().flat_map(|one| runs(one, value, is_size));
        for (stability, run) in runs {
            panel.add(curve(run, stability, (k == last).then_some(&mut in_legend)));
        }
        add_special(&mut panel, branches, value, is_size);
        add_ends(&mut panel, &ends);
        if k == last {
            panel = panel.legend(Legend::Below);
        }
        figure = figure.row(if k == last { 1.35 } else { 1.0 }, panel);
    }
    figure
}

/// A part of a branch of one stability, which is listed once in the legend.
pub(super) fn curve(
    points: Vec<(f64, f64)>,
    stability: Stability,
    legend: Option<&mut Vec<Stability>>,
) -> Curve {
    let (color, dash) = match stability {
        Stability::Stable => (BLUE, Dash::Solid),
        Stability::Neutral => (BLUE, Dash::Dotted),
        Stability::Unstable => (VERMILLION, Dash::Dashed),
    };
    let curve = Curve::new(points).color(color).dash(dash).width(1.4);
    match legend.filter(|listed| !listed.contains(&stability)) {
        Some(listed) => {
            listed.push(stability);
            curve.legend(&stability.to_string())
        }
        None => curve,
    }
}

/// Labels of special orbits, in the order of the legend.
const SPECIAL: [&str; 6] = [
    "fold",
    "branch point",
    "flip",
    "Neimark–Sacker",
    "change of phases",
    "unresolved crossing",
];

/// Adds the markers of the special orbits to the panel of a value.
fn add_special(
    panel: &mut Panel,
    branches: &[&TwoSidedBranch],
    value: ValueOfOrbit,
    is_size: bool,
) {
    for name in SPECIAL {
        let there = branches.iter().flat_map(|branch| {
            let special = branch.special.iter();
            special.filter_map(move |at| Some((mark(&at.what)?, branch, at)))
        });
        let there: Vec<_> = there.filter(|(mark, ..)| mark.0 == name).collect();
        if let Some(&((_, color, shape), ..)) = there.first() {
            let points = there
                .iter()
                .map(|(_, branch, at)| place(branch, at, value, is_size));
            let markers = Markers::new(points).shape(shape).color(color).size(6.0);
            panel.add(markers.legend(name));
        }
    }
}

/// Adds the markers of the ends of branches.
fn add_ends(panel: &mut Panel, ends: &[(&Stop, (f64, f64))]) {
    for (number, (name, shape)) in ENDS.into_iter().enumerate() {
        let there = ends.iter().filter(|end| mark_of_end(end.0) == Some(number));
        let points: Vec<(f64, f64)> = there.map(|(_, mark)| *mark).collect();
        if !points.is_empty() {
            let markers = Markers::new(points).shape(shape).color(BLACK).open();
            panel.add(markers.size(7.0).legend(name));
        }
    }
}

/// Label and marker of a special orbit, as in the legend. Ends have marks of their own.
fn mark(kind: &CycleBifurcation) -> Option<(&'static str, Color, Shape)> {
    Some(match kind {
        CycleBifurcation::Fold => (SPECIAL[0], BLACK, Shape::Circle),
        CycleBifurcation::BranchPoint => (SPECIAL[1], PURPLE, Shape::Up),
        CycleBifurcation::Flip => (SPECIAL[2], GREEN, Shape::Diamond),
        CycleBifurcation::NeimarkSacker { .. } => (SPECIAL[3], VERMILLION, Shape::Down),
        CycleBifurcation::Sequence(_) => (SPECIAL[4], ORANGE, Shape::Square),
        CycleBifurcation::Unresolved { .. } => (SPECIAL[5], BLACK, Shape::Diamond),
        CycleBifurcation::Homoclinic { .. } | CycleBifurcation::TwoFold => return None,
    })
}

/// Labels and markers of ends of a branch, in the order of the legend.
const ENDS: [(&str, Shape); 6] = [
    ("Hopf bifurcation", Shape::Circle),
    ("homoclinic end", Shape::Square),
    ("boundary equilibrium", Shape::Down),
    ("rest", Shape::Diamond),
    ("two-fold", Shape::Up),
    ("flip of the half", Shape::Cross),
];

/// Index in [`ENDS`] of the marker of an end, if it has one.
fn mark_of_end(stop: &Stop) -> Option<usize> {
    match stop {
        Stop::Equilibrium { .. } => Some(0),
        Stop::Homoclinic { .. } => Some(1),
        Stop::BoundaryEquilibrium { .. } => Some(2),
        Stop::HeldByFriction => Some(3),
        Stop::TwoFold { .. } => Some(4),
        Stop::Flip { .. } => Some(5),
        _ => None,
    }
}

/// Position of the marker at the end of a branch. An equilibrium lies between the minimum and the
/// maximum of a state on the last orbit.
fn end_mark(end: &BranchOrbit, stop: &Stop, value: ValueOfOrbit, is_extent: bool) -> (f64, f64) {
    let (least, greatest) = end.extremes[0];
    let height = match stop {
        Stop::Equilibrium { .. } | Stop::BoundaryEquilibrium { .. } | Stop::TwoFold { .. }
            if is_extent =>
        {
            0.5 * (least + greatest)
        }
        _ => value(end),
    };
    let bifurcation = BranchEnd::from(stop).bifurcation;
    (
        bifurcation.map_or(end.orbit.parameter, |at| at.parameter),
        height,
    )
}

/// The orbits of all branches.
fn points<'b>(branches: &'b [&TwoSidedBranch]) -> impl Iterator<Item = &'b BranchOrbit> {
    branches.iter().flat_map(|branch| &branch.points)
}

/// The part of the range that the branches cover, with a margin.
fn ends(range: &ParameterRange, branches: &[&TwoSidedBranch]) -> (f64, f64) {
    let parameters = points(branches).map(|at| at.orbit.parameter);
    let (low, high) = figures::extremes(parameters);
    if low >= high {
        return (range.low, range.high);
    }
    let room = 0.03 * (high - low);
    ((low - room).max(range.low), (high + room).min(range.high))
}

/// Position of a special orbit on the curve of a value, between its neighbours. If a multiplier
/// changes the stability, its size is 1 there.
fn place(
    branch: &TwoSidedBranch,
    at: &SpecialPoint,
    value: ValueOfOrbit,
    is_size: bool,
) -> (f64, f64) {
    let stability = |k: usize| branch.points.get(k).map(|point| point.orbit.stability());
    let changes = at.behind.checked_sub(1).and_then(stability) != stability(at.behind);
    if is_size && changes && !matches!(at.what, CycleBifurcation::Sequence(_)) {
        return (at.parameter, 1.0);
    }
    let orbit = |k: usize| {
        branch
            .points
            .get(k)
            .map(|point| (point.orbit.parameter, value(point)))
    };
    let before = at.behind.checked_sub(1).and_then(orbit);
    let height = match (before, orbit(at.behind)) {
        (Some(a), Some(b)) => {
            let [from, to] = [a.0, b.0].map(|parameter| (parameter - at.parameter).abs());
            // A fold lies beyond both neighbours: there the parameter is quadratic along the
            // branch.
            let is_fold = matches!(at.what, CycleBifurcation::Fold);
            let [from, to] = [from, to].map(|way| if is_fold { way.sqrt() } else { way });
            let part = if from + to > 0.0 {
                from / (from + to)
            } else {
                0.5
            };
            a.1 + part * (b.1 - a.1)
        }
        (one, other) => one.or(other).map_or(f64::NAN, |one| one.1),
    };
    (at.parameter, height)
}

/// Splits the branch into pieces of equal stability. Neighbouring pieces share the special orbit
/// between them, so that the curve has no gap.
fn runs(
    branch: &TwoSidedBranch,
    value: ValueOfOrbit,
    is_size: bool,
) -> Vec<(Stability, Vec<(f64, f64)>)> {
    let mut runs: Vec<(Stability, Vec<(f64, f64)>)> = Vec::new();
    for (k, at) in branch.points.iter().enumerate() {
        let here = (at.orbit.parameter, value(at));
        let stability = at.orbit.stability();
        let special = branch.special.iter().filter(|at| at.behind == k);
        let between: Vec<_> = special
            .map(|at| place(branch, at, value, is_size))
            .collect();
        match runs.last_mut() {
            Some(run) => {
                run.1.extend(between);
                if run.0 == stability {
                    run.1.push(here);
                } else {
                    let joint = run.1.last().copied();
                    runs.push((stability, joint.into_iter().chain([here]).collect()));
                }
            }
            None => runs.push((stability, vec![here])),
        }
    }
    runs
}

/// Whether a value varies by more than rounding and its error.
fn differs(branches: &[&TwoSidedBranch], value: ValueOfOrbit, error: f64) -> bool {
    let (low, high) = figures::extremes(points(branches).map(value));
    high - low > error + 1e-9 * high.abs()
}
