//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

pub mod block_and_bracket;
pub mod cli;
pub mod fig04;
pub mod fig06;
pub mod fig07;
pub mod fig08;
pub mod locator;

pub mod output;
pub mod rows;

pub use output::FigureError;

use plot::{Axis, Cell, Dash, GREY, Guide, Panel};
use rows::Row;
use stickslip::orbit::Orbit;

/// A figure of the paper: computing, reporting and drawing apart from each other.
pub trait FigureSpec {
    /// Name of the program and stem of its files, such as `fig06`.
    const NAME: &'static str;
    /// One line on what it shows.
    const TITLE: &'static str;
    /// The help text's account of what is drawn and which numbers are reported.
    const ABOUT: &'static str;
    /// Everything the picture and the numbers need.
    type Data;

    /// Computes the data. Never draws.
    ///
    /// # Errors
    /// Whatever the computation can run into, as [`FigureError::Compute`].
    fn compute() -> Result<Self::Data, FigureError>;

    /// The numbers behind the figure.
    fn numbers(data: &Self::Data) -> Vec<Row>;

    /// The picture as SVG. Never computes.
    ///
    /// # Errors
    /// [`FigureError::Plot`].
    fn draw(data: &Self::Data) -> Result<String, FigureError>;

    /// Wraps an error of the computation behind this figure.
    fn failed(source: impl std::error::Error + Send + Sync + 'static) -> FigureError {
        FigureError::Compute {
            figure: Self::NAME,
            source: Box::new(source),
        }
    }
}

/// Points per integration step: an order-8 step is long, and a curve through its ends alone would
/// be polygonal. What cannot be seen is thinned out when the curve is drawn.
const PER_STEP: u32 = 24;

/// Points along the orbit, each point made by `point` from time and state; every step's end is on
/// it, and so is every transition.
fn points<const N: usize, P>(orbit: &Orbit<N>, point: impl Fn(f64, &[f64]) -> P) -> Vec<P> {
    let mut points = vec![point(orbit.t_start, orbit.x_start.as_slice())];
    for step in &orbit.steps {
        for k in 1..PER_STEP {
            let t = step.t_start + f64::from(k) / f64::from(PER_STEP) * (step.t_end - step.t_start);
            points.push(point(t, step.dense.at_time(t).as_slice()));
        }
        points.push(point(step.t_end, step.x_end.as_slice()));
    }
    points
}

/// Time and the first two components.
fn curve3<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64, f64)> {
    points(orbit, |t, x| (t, x[0], x[1]))
}

/// The orbit in the plane of its first two components.
fn phase_plane<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64)> {
    points(orbit, |_, x| (x[0], x[1]))
}

/// Σ in a phase plane: the belt's speed.
fn belt_line(speed: f64) -> Guide {
    let line = Guide::horizontal(speed).color(GREY).width(0.7);
    line.dash(Dash::Dashed)
}

/// An axis with ticks whose texts are made at run time.
pub(crate) fn with_ticks(axis: Axis, ticks: impl IntoIterator<Item = (f64, String)>) -> Axis {
    let ticks: Vec<(f64, String)> = ticks.into_iter().collect();
    let ticks = ticks.iter().map(|(at, text)| (*at, text.as_str()));
    axis.ticks(&ticks.collect::<Vec<_>>())
}

/// Two panels side by side, of one width.
pub(crate) fn pair(left: Panel, right: Panel) -> Vec<(f64, Cell)> {
    vec![(1.0, left.into()), (1.0, right.into())]
}
