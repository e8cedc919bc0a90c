//! Errors of drawings.

/// Failure of a drawing, with the values that explain it and a remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// An axis whose ends do not make an interval.
    #[error("axis '{label}' runs from {min:?} to {max:?}: its length must be positive and finite")]
    Axis {
        /// The axis label.
        label: String,
        /// Lower end, in the unit of the axis.
        min: f64,
        /// Upper end, in the unit of the axis.
        max: f64,
    },
    /// The labels of a panel leave no room for its content.
    #[error(
        "a panel of {figure} is only {width:.0} x {height:.0} px large once its labels are placed; \
         enlarge the figure"
    )]
    NoRoom {
        /// Name of the figure.
        figure: String,
        /// Width left for the plot rectangle, px.
        width: f64,
        /// Height left for the plot rectangle, px.
        height: f64,
    },
    /// The drawing library failed.
    #[error("cannot draw: {0}")]
    Draw(String),
}
