//! What of an image is known from its point.

/// Where the components of images come from: of delayed values, a delay ahead, all but the last are values of the point itself, and only the
/// last is to be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Images<const N: usize> {
    /// The column that holds a component already.
    pub(crate) known: [Option<usize>; N],
    /// The components that are to be fitted come first.
    order: [usize; N],
    fitted: usize,
}

impl<const N: usize> Images<N> {
    /// Of points whose images come `step` later. A component is known if its column is another one so much earlier, at all points.
    pub(crate) fn of(points: &[[f64; N]], step: usize) -> Self {
        let later = points.get(step..).unwrap_or_default();
        let is_column = |component: usize, column: usize| {
            let mut pairs = points.iter().zip(later);
            column != component && pairs.all(|(a, b)| a[column] == b[component])
        };
        let known: [Option<usize>; N] =
            std::array::from_fn(|component| (0..N).find(|&column| is_column(component, column)));
        let mut order: [usize; N] = std::array::from_fn(|component| component);
        order.sort_by_key(|&component| known[component].is_some());
        Self {
            known,
            order,
            fitted: known.iter().filter(|column| column.is_none()).count(),
        }
    }

    /// Components that are to be fitted.
    pub(crate) fn fitted(&self) -> &[usize] {
        &self.order[..self.fitted]
    }
}
