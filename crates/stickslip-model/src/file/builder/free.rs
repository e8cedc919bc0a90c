//! Parameters that are states.

/// Most parameters that can be states at once.
pub const MOST_FREE: usize = 16;

/// Parameters that are states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Freed {
    /// Indices of the parameters, in order of these states.
    pub parameters: [Option<usize>; MOST_FREE],
}

/// All parameters have their values.
pub(crate) const NONE_FREE: Freed = Freed {
    parameters: [None; MOST_FREE],
};

impl Freed {
    /// Frees the first [`MOST_FREE`] of these parameters.
    pub fn of(parameters: &[usize]) -> Self {
        let mut freed = NONE_FREE;
        for (slot, parameter) in freed.parameters.iter_mut().zip(parameters) {
            *slot = Some(*parameter);
        }
        freed
    }

    /// Number of free parameters.
    pub fn count(&self) -> usize {
        self.parameters.iter().flatten().count()
    }
}

/// Parameters of an expression.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Values of the parameters.
    pub(super) values: &'a [f64],
    /// Parameters that are states instead, after those of the file and in this order.
    free: Freed,
}

impl<'a> Inputs<'a> {
    /// All parameters have fixed values.
    pub fn fixed(values: &'a [f64]) -> Self {
        Self::free(values, NONE_FREE)
    }

    /// Some of the parameters may be states.
    pub fn free(values: &'a [f64], free: Freed) -> Self {
        Inputs { values, free }
    }

    /// Number of parameters that are states.
    pub fn count_free(&self) -> usize {
        self.free.count()
    }

    /// Index of a parameter among those that are states.
    pub(super) fn place(&self, parameter: usize) -> Option<usize> {
        self.free
            .parameters
            .iter()
            .flatten()
            .position(|free| *free == parameter)
    }
}
