//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

pub mod block_and_bracket;
pub mod cli;
pub(crate) mod curves;
pub mod fig04;
pub mod fig06;
pub mod fig07;
pub mod fig08;
pub mod locator;
pub mod rows;

use crate::numbers::not_found;
use crate::terminal::ProgramError;
use plot::{Cell, Dash, Figure, GREY, Guide, Panel};
use rows::Row;
use stickslip::scalar::Dual;
use stickslip::{Error, Filippov, Mode, Orbit, Scalar, Side, Transition, TransitionKind};

/// A figure of the paper. Computing, reporting and drawing are separate.
pub struct FigureSpec<D> {
    /// Name of the program and stem of its files, such as `fig06`.
    pub name: &'static str,
    /// A one-line title.
    pub title: &'static str,
    /// Help text: what is drawn and which numbers are reported.
    pub about: &'static str,
    compute: fn() -> Result<D, ProgramError>,
    /// The numbers behind the figure.
    pub numbers: fn(&D) -> Vec<Row>,
    /// The picture. It never computes.
    pub draw: fn(&D) -> Result<Figure, ProgramError>,
}

impl<D> FigureSpec<D> {
    /// Computes the data. It never draws.
    ///
    /// # Errors
    /// The error of the computation, with the figure's name.
    pub fn compute(&self) -> Result<D, ProgramError> {
        (self.compute)().map_err(|error| format!("cannot compute {}: {error}", self.name).into())
    }
}

/// Points per integration step. A step of order 8 is long, and a curve through its ends alone would
/// be polygonal. Drawing thins out invisible points.
const POINTS_PER_STEP: u32 = 24;

/// Time, position and velocity along the orbit, with every step's end and every transition.
fn time_curve(orbit: &Orbit<2>) -> Vec<(f64, f64, f64)> {
    let mut points = vec![(orbit.t_start, orbit.x_start[0], orbit.x_start[1])];
    for step in &orbit.steps {
        for k in 1..POINTS_PER_STEP {
            let t = step.t_start
                + f64::from(k) / f64::from(POINTS_PER_STEP) * (step.t_end - step.t_start);
            let x = step.dense.at_time(t);
            points.push((t, x[0], x[1]));
        }
        points.push((step.t_end, step.x_end[0], step.x_end[1]));
    }
    points
}

/// The orbit in the phase plane.
fn phase_plane(orbit: &Orbit<2>) -> Vec<(f64, f64)> {
    let points = time_curve(orbit).into_iter();
    points.map(|(_, x1, x2)| (x1, x2)).collect()
}

/// The normal components of both fields at a point of Σ: below, above.
pub(crate) fn normals<S: Filippov<2>, T: Scalar>(system: &S, t: T, x: &[T; 2]) -> [T; 2] {
    let of = |side| {
        let field = system.field(side, t, x);
        let along = std::array::from_fn(|i| Dual::new(x[i], field[i]));
        system.boundary(Dual::new(t, T::one()), &along).eps
    };
    [Side::Below, Side::Above].map(of)
}

/// The first crossing of Σ to a side, in an orbit that starts at time 0.
fn crossing(orbit: &Orbit<2>, to: Side) -> Result<&Transition<2>, Error> {
    let is = |at: &&Transition<2>| at.kind == TransitionKind::Crossing && at.to == Mode::Slip(to);
    let first = orbit.transitions.iter().find(is);
    first.ok_or_else(|| not_found("a crossing of Σ", 0.0, orbit.t_end))
}

/// Σ in a phase plane: the belt's speed.
fn belt_line(speed: f64) -> Guide {
    let line = Guide::horizontal(speed).color(GREY).width(0.7);
    line.dash(Dash::Dashed)
}

/// Two panels side by side, of equal width.
pub(crate) fn side_by_side(left: Panel, right: Panel) -> Vec<(f64, Cell)> {
    vec![(1.0, left.into()), (1.0, right.into())]
}
