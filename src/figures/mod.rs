//! The paper's figures: `compute() -> data`, `numbers(&data)`, `draw(&data)`.

pub mod block_and_bracket;
pub mod cli;
pub mod fig04;
pub mod fig06;
pub mod fig07;
pub mod fig08;
pub mod locator;
pub mod rows;

use crate::numbers::not_found;
use crate::paper::published::PublishedError;
use output::{PngError, WriteError};
use plot::{Cell, Dash, GREY, Guide, Panel};
use rows::Row;
use stickslip::filippov::normal_component;
use stickslip::{Error, Filippov, Mode, Orbit, Scalar, Side, Transition, TransitionKind};

/// Error of a computation.
pub(crate) type ComputeError = Box<dyn std::error::Error + Send + Sync>;

/// A figure of the paper. Computing, reporting and drawing are separate.
pub struct FigureSpec<D> {
    /// Name of the program and stem of its files, such as `fig06`.
    pub name: &'static str,
    /// A one-line title.
    pub title: &'static str,
    /// Help text: what is drawn and which numbers are reported.
    pub about: &'static str,
    compute: fn() -> Result<D, ComputeError>,
    /// The numbers behind the figure.
    pub numbers: fn(&D) -> Vec<Row>,
    /// The picture as SVG. It never computes.
    pub draw: fn(&D) -> Result<String, FigureError>,
}

impl<D> FigureSpec<D> {
    /// Computes the data. It never draws.
    ///
    /// # Errors
    /// The error of the computation, as [`FigureError::Compute`].
    pub fn compute(&self) -> Result<D, FigureError> {
        (self.compute)().map_err(|source| FigureError::Compute {
            figure: self.name,
            source,
        })
    }
}

/// Failure of a figure program.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The computation behind the figure failed.
    #[error("cannot compute {figure}: {source}")]
    Compute {
        /// Name of the figure, such as `fig06`.
        figure: &'static str,
        /// Error of the solver or of the listing.
        source: ComputeError,
    },
    /// The table of published values is malformed.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// The figure cannot be drawn.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// A file or its folder cannot be written.
    #[error("{0}; check the disk, or choose another folder with --out-dir")]
    Write(#[from] WriteError),
    /// `--png` was given to a program built without it.
    #[error(
        "this program was built without PNG output; rebuild it with `cargo build -p \
            stickslip-replication --profile figures --no-default-features --features png`"
    )]
    PngNotBuilt,
    /// The SVG cannot be rendered.
    #[error(transparent)]
    Png(#[from] PngError),
}

/// Points per integration step. A step of order 8 is long, and a curve through its ends alone would
/// be polygonal. Drawing thins out invisible points.
const POINTS_PER_STEP: u32 = 24;

/// Points along the orbit, computed by `point` from time and state. They include every step's end
/// and every transition.
fn points<const N: usize, P>(orbit: &Orbit<N>, point: impl Fn(f64, &[f64]) -> P) -> Vec<P> {
    let mut points = vec![point(orbit.t_start, orbit.x_start.as_slice())];
    for step in &orbit.steps {
        for k in 1..POINTS_PER_STEP {
            let t = step.t_start
                + f64::from(k) / f64::from(POINTS_PER_STEP) * (step.t_end - step.t_start);
            points.push(point(t, step.dense.at_time(t).as_slice()));
        }
        points.push(point(step.t_end, step.x_end.as_slice()));
    }
    points
}

/// Time and the first two components.
fn time_curve<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64, f64)> {
    points(orbit, |t, x| (t, x[0], x[1]))
}

/// The orbit in the plane of its first two components.
fn phase_plane<const N: usize>(orbit: &Orbit<N>) -> Vec<(f64, f64)> {
    points(orbit, |_, x| (x[0], x[1]))
}

/// The normal components of both fields at a point of Σ: below, above.
pub(crate) fn normals<S: Filippov<2>, T: Scalar>(system: &S, t: T, x: &[T; 2]) -> [T; 2] {
    let of = |side| normal_component(system, t, x, &system.field(side, t, x));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_error_names_the_option_that_helps() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = output::write_all(&file.path().join("sub"), &[]).unwrap_err();
        let error = FigureError::from(error);
        assert!(error.to_string().contains("--out-dir"));
    }
}
