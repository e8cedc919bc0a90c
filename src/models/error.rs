//! Parameters outside their range.

/// A parameter that makes no sense in the model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}, but it must be {bound}; {remedy}")]
pub struct ParameterError {
    /// Symbol of the parameter, such as `mu0`.
    pub name: &'static str,
    /// The value that was given.
    pub value: f64,
    /// The range it must lie in, in words.
    pub bound: &'static str,
    /// What to do instead.
    pub remedy: &'static str,
}

/// Refuses values that are not finite and positive.
pub(super) fn positive(
    name: &'static str,
    value: f64,
    remedy: &'static str,
) -> Result<f64, ParameterError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(ParameterError {
        name,
        value,
        bound: "finite and greater than 0",
        remedy,
    })
}

/// Refuses values that are not finite or below zero.
pub(super) fn not_negative(
    name: &'static str,
    value: f64,
    remedy: &'static str,
) -> Result<f64, ParameterError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(ParameterError {
        name,
        value,
        bound: "finite and not negative",
        remedy,
    })
}
