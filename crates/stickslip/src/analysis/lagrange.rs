//! Lagrange's polynomials.

/// The weights of values at given nodes in the interpolating polynomial at another point.
pub(super) fn weights(places: &[f64], at: f64) -> Vec<f64> {
    let weight = |(k, place): (usize, &f64)| {
        let others = places.iter().enumerate().filter(|(other, _)| *other != k);
        others
            .map(|(_, other)| (at - other) / (place - other))
            .product()
    };
    places.iter().enumerate().map(weight).collect()
}
