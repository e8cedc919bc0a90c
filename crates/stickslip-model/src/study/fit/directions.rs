//! Directions of the unknowns, by what the data say about them.

use crate::study::least_squares::null_space;
use stickslip::dynamics::{Matrix, Vector};
use stickslip::math::product;
use stickslip::nalgebra::{QR, SVD};

/// Error of derivatives over the tolerance of a step: some hundred times that of states, times ten.
pub(super) const ERROR_OF_DERIVATIVES: f64 = 1e3;

/// Changes of the unknowns along the singular vectors of scaled derivatives.
pub(super) struct Directions {
    /// Those that the data determine, by one standard deviation of the residuals each.
    pub(super) determined: Vec<Vector>,
    /// Those that the data do not determine, of any length.
    pub(super) open: Vec<Vector>,
}

impl Directions {
    /// The directions for derivatives of residuals by some unknowns, computed to a tolerance. The
    /// last residuals are mismatches of parts, which are to vanish.
    ///
    /// # Errors
    /// Words, where there are none.
    pub(super) fn of(
        jacobian: &Matrix,
        mismatches: usize,
        tolerance: f64,
    ) -> Result<Self, &'static str> {
        if jacobian.iter().any(|slope| !slope.is_finite()) {
            return Err("the run has no derivatives there");
        }
        let norms = jacobian.column_iter().map(|column| column.norm());
        let norms = norms.map(|norm| if norm > 0.0 { norm } else { 1.0 });
        let scales = Vector::from_iterator(jacobian.ncols(), norms);
        let mut columns = jacobian.clone();
        for (mut column, scale) in columns.column_iter_mut().zip(&scales) {
            column /= *scale;
        }
        let data = jacobian.nrows() - mismatches;
        // Parts that meet leave these directions.
        let basis = null_space(&columns.rows_range(data..).into_owned());
        let of_data = product(&columns.rows(0, data), &basis);
        if of_data.is_empty() {
            return Err("the parts leave nothing to the data");
        }
        let svd = SVD::new(QR::new(of_data).r(), false, true);
        let right = svd.v_t.ok_or("its derivatives have no singular values")?;
        let least = svd.singular_values.amax()
            * (ERROR_OF_DERIVATIVES * tolerance + f64::EPSILON * jacobian.nrows() as f64);
        let mut found = Directions {
            determined: Vec::new(),
            open: Vec::new(),
        };
        let rows = product(&right, &basis.transpose());
        for (s, row) in svd.singular_values.iter().zip(rows.row_iter()) {
            let along = row.transpose().component_div(&scales);
            match *s > least {
                true => found.determined.push(along / *s),
                false => found.open.push(along),
            }
        }
        Ok(found)
    }
}
