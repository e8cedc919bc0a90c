//! What a figure consists of.

use super::error::FigureError;
use super::rows::Row;

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
