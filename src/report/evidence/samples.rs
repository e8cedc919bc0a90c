//! `s5.samples`: whether number of states, time span and dimension of the published series fit each other.

use super::{Evidence, Part};
use crate::figures::block_and_bracket::Data;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::{Claims, PublishedError};

/// The published series: so many elements over a span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// States.
    pub states: f64,
    /// Components of each.
    pub components: f64,
    /// Begin and end.
    pub span: (f64, f64),
}

/// The series as published and as computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// What is printed.
    pub published: Series,
    /// Time between two states that follows.
    pub interval: f64,
    /// States taken from the solver's orbits over the same span every 0.2, for Figs. 10, 11, 12.
    pub taken: Vec<usize>,
    /// Components of a state of the solver's.
    pub components: usize,
}

impl Samples {
    /// From the figures' own series.
    ///
    /// # Errors
    /// [`PublishedError`] if the table of claims has no such series.
    pub fn compute(figures: &[&Data]) -> Result<Samples, PublishedError> {
        let values = Claims::committed()?.of(ClaimId::S5Samples).values();
        let value = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        let published = Series {
            states: value(0),
            components: value(1),
            span: (value(2), value(3)),
        };
        Ok(Samples {
            published,
            interval: interval(&published),
            taken: figures.iter().map(|data| data.samples).collect(),
            components: figures
                .first()
                .and_then(|data| data.curve.first())
                .map_or(0, |state| state.len()),
        })
    }
}

fn interval(published: &Series) -> f64 {
    (published.span.1 - published.span.0) / (published.states - 1.0)
}

impl Evidence for Samples {
    fn parts(&self) -> Vec<Part> {
        let counted = |taken: &usize| *taken as f64 == self.published.states;
        vec![
            Part {
                what: "sampled every 0.2 over that span, first and last included, the orbits give so many states",
                holds: !self.taken.is_empty() && self.taken.iter().all(counted),
            },
            Part {
                what: "a state has so many components",
                holds: self.components as f64 == self.published.components,
            },
        ]
    }

    fn line(&self) -> String {
        format!(
            "{} states over {} time units are {} apart; sampled so, the solver's orbits give {:?} states of {} components",
            self.published.states,
            self.published.span.1 - self.published.span.0,
            self.interval,
            self.taken,
            self.components
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::evidence::Support;

    #[test]
    fn a_misprinted_number_of_states_is_seen() {
        let printed = Samples::compute(&[]).unwrap();
        let with = |states: f64| {
            let published = Series {
                states,
                ..printed.published
            };
            Samples {
                published,
                interval: interval(&published),
                taken: vec![45_001; 3],
                components: 4,
            }
        };
        assert_eq!(with(printed.published.states).support(), Support::Whole);
        assert_eq!(with(printed.published.states).interval, 0.2);
        assert_eq!(with(45_010.0).support(), Support::InPart);
    }
}
