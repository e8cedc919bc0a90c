//! Lists of events and how far one is from another.

use std::str::FromStr;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From slip to slip through Σ.
    Crossing,
    /// Stick begins.
    Entry,
    /// Stick ends.
    Exit,
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "crossing" => Ok(Kind::Crossing),
            "entry" => Ok(Kind::Entry),
            "exit" => Ok(Kind::Exit),
            _ => Err(format!(
                "'{text}' is no kind of event; there are crossing, entry and exit"
            )),
        }
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// What happened.
    pub kind: Kind,
    /// When.
    pub t: f64,
}

impl FromStr for Event {
    type Err = String;

    /// As in `crossing@0.953`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, t) = text
            .split_once('@')
            .ok_or_else(|| format!("'{text}' is no event such as crossing@0.953"))?;
        let t: f64 = t.parse().map_err(|_| format!("'{t}' is no time"))?;
        Ok(Event {
            kind: kind.parse()?,
            t,
        })
    }
}

/// Largest error of an event time; why there is none if the lists are not of the same events.
///
/// # Errors
/// In words, for the column `note`.
pub fn error(events: &[Event], reference: &[Event]) -> Result<f64, String> {
    let kinds = |list: &[Event]| list.iter().map(|event| event.kind).collect::<Vec<_>>();
    if events.len() != reference.len() {
        return Err(format!(
            "failed: {} events, the reference has {}",
            events.len(),
            reference.len()
        ));
    }
    if kinds(events) != kinds(reference) {
        return Err("failed: other kinds of events than the reference has".into());
    }
    // Asked first, because the largest of some numbers may pass over what is none.
    if events.iter().any(|event| !event.t.is_finite()) {
        return Err("failed: an event time is not a number".into());
    }
    let errors = events.iter().zip(reference);
    Ok(errors
        .map(|(one, other)| (one.t - other.t).abs())
        .fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Vec<Event> {
        text.split(';')
            .map(|event| event.parse().unwrap())
            .collect()
    }

    #[test]
    fn the_error_is_that_of_the_worst_event() {
        let reference = list("entry@1;exit@2;crossing@3");
        assert_eq!(
            error(&list("entry@1;exit@2.5;crossing@2.75"), &reference),
            Ok(0.5)
        );
        assert_eq!(error(&reference, &reference), Ok(0.0));
    }

    #[test]
    fn lists_of_other_events_have_no_error() {
        let reference = list("entry@1;exit@2");
        let said = |text: &str| error(&list(text), &reference).unwrap_err();
        assert_eq!(said("entry@1"), "failed: 1 events, the reference has 2");
        assert!(said("entry@1;crossing@2").contains("kinds"));
        assert!(said("entry@1;exit@nan").contains("not a number"));
        assert!(said("entry@nan;exit@2").contains("not a number"));
    }

    #[test]
    fn what_is_no_event_is_refused() {
        for text in ["entry", "entry@", "entry@x", "stick@1", ""] {
            assert!(text.parse::<Event>().is_err(), "{text}");
        }
    }
}
