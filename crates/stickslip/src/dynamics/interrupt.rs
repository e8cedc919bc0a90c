//! Ends orbits from another thread.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A flag that ends orbits, and the time that they have reached.
///
/// Another thread may raise it while an analysis runs. Every orbit of a system made with it
/// ([`super::Typed::interrupted_by`]) then fails at its next step with
/// [`crate::Error::Interrupted`].
#[derive(Debug, Default)]
pub struct Interrupt {
    is_raised: AtomicBool,
    /// Bits of the time that the last step has reached. It is kept on request only, because writing
    /// it slows down runs on many threads.
    time: Option<AtomicU64>,
}

impl Interrupt {
    /// A flag that keeps the time.
    pub fn with_time() -> Self {
        Interrupt {
            time: Some(AtomicU64::new(f64::NEG_INFINITY.to_bits())),
            ..Interrupt::default()
        }
    }

    /// Makes every further step fail.
    pub fn raise(&self) {
        self.is_raised.store(true, Ordering::Relaxed);
    }

    /// Whether it was raised.
    pub fn is_raised(&self) -> bool {
        self.is_raised.load(Ordering::Relaxed)
    }

    /// The time that the last step has reached; −∞ before the first, or if the time is not kept.
    pub fn time(&self) -> f64 {
        let time = self.time.as_ref().map(|time| time.load(Ordering::Relaxed));
        time.map_or(f64::NEG_INFINITY, f64::from_bits)
    }

    pub(super) fn note_time(&self, t: f64) {
        if let Some(time) = &self.time {
            time.store(t.to_bits(), Ordering::Relaxed);
        }
    }
}
