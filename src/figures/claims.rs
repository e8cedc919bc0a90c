//! Rows against what the paper publishes.

use super::rows::{Row, Value};
use crate::paper::published::published;

impl Row {
    /// Set against the claim called `id` of `data/claims.csv`: a number agrees when, rounded to the published digits, it is the
    /// published one (or one of a published set), a word or count when it is the published text. The row stays
    /// without comparison when there is no such claim, which the tests do not let pass.
    #[must_use]
    pub fn against(self, id: &str) -> Self {
        let Ok(claim) = published(id) else {
            return self;
        };
        let agrees = match &self.value {
            Value::Number(value) => claim.agrees(*value),
            Value::Count(_) | Value::Word(_) => self.value.to_string() == claim.published,
        };
        self.published(&claim.published, agrees)
    }

    /// Set against member `k`, counted from 1, of the published set called `id`.
    #[must_use]
    pub fn member_of(self, id: &str, k: usize) -> Self {
        let member = published(id)
            .ok()
            .and_then(|claim| claim.values().get(k.wrapping_sub(1)).copied());
        let (Some(member), Value::Number(value)) = (member, &self.value) else {
            return self;
        };
        let scale = if member == 0.0 { 1.0 } else { member.abs() };
        let agrees = (value - member).abs() <= 1e-12 * scale;
        self.published(&format!("{member:?}"), agrees)
    }

    /// Whether a statement of the paper holds, as decided by computation.
    pub fn statement(id: &str, reading: &str, holds: bool) -> Self {
        let word = if holds { "holds" } else { "fails" };
        Row::word(id, reading, word).published("holds", holds)
    }
}
