//! Fig. 6: the friction law of Eq. (2).

use super::rows::Row;
use super::{FigureSpec, side_by_side};
use crate::paper::claim_id::ClaimId;
use crate::paper::reading::Reading::Exact;
use crate::terminal::ProgramError;
use plot::{
    Axis, BLACK, BLUE, Color, Curve, Dash, Figure, GREY, Guide, Legend, Note, Panel, Position,
    VERMILLION,
};

/// `T(v) = sgn(v) μ₀ / (1 + δ|v|)`, Eq. (2), for a unit normal force; at `v = 0` any force in
/// `[-μ₀, μ₀]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient of static friction.
    pub mu0: f64,
    /// Decay of kinetic friction, s/m.
    pub delta: f64,
}

impl Friction {
    /// Coefficient of kinetic friction `μ₀/(1 + δ|v|)` at the relative velocity `v`, m/s.
    fn coefficient(&self, v: f64) -> f64 {
        self.mu0 / (1.0 + self.delta * v.abs())
    }
}

/// One friction law and its graph.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The law.
    pub law: Friction,
    /// `μ₀` in markup.
    pub mu0: &'static str,
    /// `(v, T)` in m/s and N, through the vertical part at `v = 0`.
    pub points: Vec<(f64, f64)>,
}

/// The laws in the figure.
#[derive(Clone, Debug)]
pub struct Data {
    /// `δ = 1` as in the paper, three friction coefficients; the middle one is the paper's.
    pub by_mu0: [Graph; 3],
    /// The paper's friction coefficient, three values of `δ`; the middle one is the paper's.
    pub by_delta: [Graph; 3],
}

/// Largest relative velocity shown, m/s.
const V_MAX: f64 = 3.0;
/// Points per branch.
const SAMPLES: u32 = 300;

/// Fig. 6.
pub const FIG06: FigureSpec<Data> = FigureSpec {
    name: "fig06",
    title: "Fig. 6: friction force against relative velocity, Eq. (2)",
    about: "Draws T(v) = sgn(v) mu0/(1 + delta |v|) with its vertical part |T| <= mu0 at v = 0: \
        (a) for delta = 1 and three friction coefficients, (b) for mu0 = sqrt(3)/9 and three \
        values of delta. Bold lines are the paper's parameters. Reports whether both branches \
        decrease, and T at 1 m/s.",
    compute,
    numbers,
    draw,
};

fn compute() -> Result<Data, ProgramError> {
    let root = 3f64.sqrt();
    let graph = |mu0, text, delta| {
        let law = Friction { mu0, delta };
        let points = sample(&law);
        Graph {
            law,
            mu0: text,
            points,
        }
    };
    Ok(Data {
        by_mu0: [
            graph(root / 18.0, "√3/18", 1.0),
            graph(root / 9.0, "√3/9", 1.0),
            graph(2.0 * root / 9.0, "2√3/9", 1.0),
        ],
        by_delta: [
            graph(root / 9.0, "√3/9", 0.5),
            graph(root / 9.0, "√3/9", 1.0),
            graph(root / 9.0, "√3/9", 3.0),
        ],
    })
}

fn numbers(data: &Data) -> Vec<Row> {
    let graphs = || data.by_mu0.iter().chain(&data.by_delta);
    let decreasing = graphs().all(|graph| decreases(&graph.points));
    let part = ("both branches of T(v) decrease with |v|", decreasing);
    let mut rows = vec![Row::statement(ClaimId::Fig06FrictionLaw, Exact, [part])];
    for (panel, graphs) in [("a", &data.by_mu0), ("b", &data.by_delta)] {
        for (i, graph) in graphs.iter().enumerate() {
            let id = format!("fig06{panel}.force_at_1.{}", i + 1);
            let force = graph.law.coefficient(1.0);
            rows.push(Row::number(id, Exact, force, "N"));
        }
    }
    rows
}

fn draw(data: &Data) -> Result<Figure, ProgramError> {
    let mut a = panel("(a)", "*δ* = 1 s/m");
    for (graph, (color, dash)) in data.by_mu0.iter().zip(LINES) {
        a.add(curve(graph, color, dash).legend(&format!("*μ*_0 = {}", graph.mu0)));
    }
    let [_, paper, _] = &data.by_mu0;
    let sticking = Note::new(Position::Fraction(0.76, 0.2), "sticking: |*T*| ≤ *μ*_0");
    a.add(sticking.arrow((0.0, -0.4 * paper.law.mu0)));
    let mut b = panel("(b)", &format!("*μ*_0 = {}", paper.mu0));
    for (graph, (color, dash)) in data.by_delta.iter().zip(LINES) {
        b.add(curve(graph, color, dash).legend(&format!("*δ* = {} s/m", graph.law.delta)));
    }
    for panel in [&mut a, &mut b] {
        // Drawn again on top: all graphs share the vertical part, where dashes of the others would
        // show.
        panel.add(curve(paper, LINES[1].0, LINES[1].1).name("the paper's parameters"));
    }
    let title = "Friction force against relative velocity";
    let description = "Two panels with the friction force T between −0.5 and 0.5 N against the \
        relative velocity v between −3 and 3 m/s. Every curve is odd: it rises vertically from −μ0 \
        to μ0 at v = 0, and its magnitude falls as the speed grows. Panel a: δ = 1 and three \
        values of μ0; larger μ0 stretches the curve. Panel b: μ0 = √3/9 and δ = 0.5, 1, 3; larger \
        δ makes it fall faster. Bold: the paper's parameters.";
    let figure = Figure::new(FIG06.name, (680.0, 310.0), title, description);
    Ok(figure.columns(1.0, side_by_side(a, b)))
}

/// The paper's parameters are the bold solid line in the middle.
const LINES: [(Color, Dash); 3] = [
    (BLUE, Dash::Dashed),
    (BLACK, Dash::Solid),
    (VERMILLION, Dash::DashDot),
];

fn panel(label: &str, title: &str) -> Panel {
    Panel::new(
        Axis::new("*v*, m/s", -V_MAX, V_MAX).step(1.0).minor(2),
        Axis::new("*T*(*v*), N", -0.5, 0.5).step(0.25).minor(5),
    )
    .label(label)
    .title(title)
    .legend(Legend::UpperLeft)
    .with(Guide::horizontal(0.0).color(GREY).dash(Dash::Dotted))
}

fn curve(graph: &Graph, color: Color, dash: Dash) -> Curve {
    let width = if dash == Dash::Solid { 2.4 } else { 1.4 };
    let curve = Curve::new(graph.points.iter().copied());
    curve.color(color).dash(dash).width(width)
}

/// The graph from left to right, with both ends of the vertical part at `v = 0`.
fn sample(law: &Friction) -> Vec<(f64, f64)> {
    let speed = |i: u32| V_MAX * f64::from(i) / f64::from(SAMPLES);
    let right = (0..=SAMPLES).map(|i| (speed(i), law.coefficient(speed(i))));
    let left = right.clone().rev().map(|(v, force)| (-v, -force));
    left.chain(right).collect()
}

/// Whether the force decreases with the velocity on either side of the vertical part.
fn decreases(points: &[(f64, f64)]) -> bool {
    let mut rising = points.windows(2).filter(|pair| pair[0].0 < pair[1].0);
    rising.all(|pair| pair[1].1 < pair[0].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(delta: f64) -> Friction {
        Friction { mu0: 0.2, delta }
    }

    #[test]
    fn half_the_friction_is_left_at_the_speed_one_over_delta() {
        assert_eq!(law(4.0).coefficient(0.25), 0.1);
    }

    #[test]
    fn the_vertical_part_spans_both_signs() {
        let points = sample(&law(4.0));
        let at_rest: Vec<f64> = points.iter().filter(|p| p.0 == 0.0).map(|p| p.1).collect();
        assert_eq!(at_rest, [-0.2, 0.2]);
        assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn constant_friction_does_not_count_as_decreasing() {
        assert!(!decreases(&sample(&law(0.0))) && decreases(&sample(&law(0.1))));
    }
}
