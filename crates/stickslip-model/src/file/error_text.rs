//! Errors of the library in words for users of a file or of Python. Contacts have their names, and
//! options are written as the interface writes them.

use stickslip::Error;
use stickslip::error::{Accumulation, ContactFault, Point, readable};

use super::System;
use crate::study::negative_at;

/// Words of an interface for options and errors.
pub trait Interface {
    /// An option of the library, such as `longest_step`, by its name here.
    fn name(&self, option: &str) -> String;
    /// An option with one of several words.
    fn choice(&self, option: &str, words: &[&str]) -> String;
    /// An option with a number.
    fn value(&self, option: &str, value: f64) -> String;
    /// Advice for a Newton iteration that did not converge, after "start nearer to the solution".
    fn nearer(&self) -> &'static str;

    /// An error in words, with the names of the system's contacts if it is known. Friction that is
    /// negative at the place of the error is likely its cause, and is told.
    fn words(&self, error: &Error, system: Option<&System>) -> String {
        let words = self.words_of_error(error, system);
        let negative = system.zip(error.place()).and_then(|(system, (t, x))| {
            (0..system.contacts()).find_map(|at| negative_at(system, at, (t, &x.0)))
        });
        match negative {
            Some(negative) => format!("{words}; {negative}"),
            None => words,
        }
    }

    /// An error in words, without its cause.
    fn words_of_error(&self, error: &Error, system: Option<&System>) -> String {
        let name = |contact: usize| match system.map(|system| system.contact_name(contact)) {
            Some(name) if !name.is_empty() => format!("`{name}`"),
            _ => contact.to_string(),
        };
        let at = |t: &f64, x: &Point| format!("at t = {}, x = {x}", readable(*t));
        if let Error::StartOutsideDomain { t, x, .. }
        | Error::NonFinite { t, x, .. }
        | Error::StepCollapse { t, x, .. } = error
            && let Some(why) = system.and_then(|system| system.without_reaction(*t, &x.0))
        {
            return format!("the orbit cannot go on {}: {why}", at(t, x));
        }
        match error {
            Error::Option { name, value, bound } => format!(
                "{} is not allowed: it must be {bound}",
                self.value(name, *value)
            ),
            Error::EventPileUp {
                count,
                span,
                t,
                x,
                contacts,
                accumulation,
            } => {
                let rest = self.choice("at_pile_up", &["rest"]);
                let is_held = accumulation.as_ref().is_none_or(|at| at.holds);
                let is_jump = |&at: &usize| system.is_some_and(|system| at >= system.contacts());
                let help = match !is_held && contacts.iter().any(is_jump) {
                    true => {
                        "; jumps hold nothing: what comes to rest needs a stop there, \
                         [stops.NAME], or a contact"
                    }
                    false => "",
                };
                format!(
                    "{count} transitions at {} within {span:e} before t = {}, x = {x}: {}{help}",
                    names(contacts, &name),
                    readable(*t),
                    Accumulation::in_words(accumulation.as_deref(), *span, &rest)
                )
            }
            Error::Contacts { t, x, fault } => contacts_in_words(self, fault, (&name, &at(t, x))),
            Error::StartOutsideDomain { t, x, .. } => {
                match system.and_then(|system| system.undefined_in_field(*t, &x.0)) {
                    Some(part) => format!(
                        "cannot start {}: {part}; start elsewhere, or change the formula or a \
                         parameter in it",
                        at(t, x)
                    ),
                    None => error.to_string(),
                }
            }
            Error::NonFinite { t, x, .. } | Error::StepCollapse { t, x, .. } => {
                match system.and_then(|system| {
                    let here = system.undefined_in_field(*t, &x.0);
                    here.or_else(|| system.undefined_ahead(*t, &x.0))
                }) {
                    Some(part) => format!(
                        "the orbit cannot go on {}: just there, {part}; end the run before, or \
                         change the formula or a parameter in it",
                        at(t, x)
                    ),
                    None => match system.and_then(|one| one.friction_without_force(*t, &x.0)) {
                        Some(why) => format!(
                            "the orbit cannot go on {}: {why}; with several contacts, write \
                             friction in proportion to its normal force",
                            at(t, x)
                        ),
                        None => error.to_string(),
                    },
                }
            }
            Error::Undefined { what, number, t, x } => {
                let part = system.and_then(|system| system.undefined_in_event(*number, *t, &x.0));
                let part = part.map_or_else(String::new, |part| format!(": {part}"));
                format!(
                    "{what} {} is not a number {}{part}; write it so that it is defined wherever \
                     the orbit comes, as by max(…, 0) under a root, or end the run before",
                    name(*number),
                    at(t, x)
                )
            }
            Error::BehindStop { number, .. }
            | Error::GapJumps { number, .. }
            | Error::OffStop { number, .. } => {
                let numbered = format!("the stop {number} ");
                // The event belongs to the stop, and its name continues that of the stop.
                let event = name(*number);
                let stop = event
                    .rsplit_once('.')
                    .map_or(event.clone(), |(stop, _)| format!("{stop}`"));
                let named = format!("the stop {stop} ");
                error.to_string().replacen(&numbered, &named, 1)
            }
            Error::NotConverged { .. } => format!("{error}, {}", self.nearer()),
            Error::Escaped { .. } => format!("{error} ({})", self.name("escape")),
            Error::ChainedJumps { jump, .. } | Error::TiedChoice { jump, .. } => {
                let number = format!("jump {jump} ");
                let named = format!("the jump {} ", name(*jump));
                error.to_string().replacen(&number, &named, 1)
            }
            Error::TooShortSteps { longest_step, .. } => {
                let given = format!("longest_step = {}", readable(*longest_step));
                let text = error.to_string();
                let text = text.replace(&given, &self.value("longest_step", *longest_step));
                text.replace("most_steps", &self.name("most_steps"))
            }
            Error::TooMany { name, .. }
            | Error::TimeRounding {
                bound: Some(name), ..
            } => error.to_string().replace(name, &self.name(name)),
            Error::NoUniqueFuture { t, x } => format!(
                "the orbit has no unique future after t = {}, x = {x}: both fields lead away from \
                 the boundary; choose one with {}, or start elsewhere",
                readable(*t),
                self.choice("at_repelling", &["below", "above"])
            ),
            other => other.to_string(),
        }
    }
}

/// A fault of contacts in words, with their names and the place of the run.
fn contacts_in_words(
    interface: &(impl Interface + ?Sized),
    fault: &ContactFault,
    (name, at): (&dyn Fn(usize) -> String, &str),
) -> String {
    let names = |contacts: &[usize]| names(contacts, name);
    match fault {
        ContactFault::NoUniqueMode {
            contacts,
            candidates,
        } => {
            let motions = match candidates.len() {
                0 => "no motion that follows is consistent with the friction at all of them"
                    .to_owned(),
                count => {
                    let motions = candidates.join(" or ");
                    let motions = motions.replace("Slip(Below)", "slip below");
                    let motions = motions.replace("Slip(Above)", "slip above");
                    let motions = motions.replace("Stick", "stick");
                    format!("{count} motions that follow are consistent: {motions}")
                }
            };
            format!(
                "the contacts {} stand at zero {}, and {motions}; friction there may push \
                 apart, or one contact's force act on another too strongly: look at the field \
                 with each of them on either side ({} has no effect with several contacts)",
                names(contacts),
                at,
                interface.name("at_repelling")
            )
        }
        ContactFault::TooManyContacts { contacts } => format!(
            "the contacts {} stand at zero together {}: more than eight are too many to try \
             where friction at one does not resist all of them as Coulomb's does; move their \
             boundaries apart, or write their friction without coupling",
            names(contacts),
            at
        ),
        ContactFault::DependentContacts { contacts } => format!(
            "the boundaries of the contacts {} have gradients {} that are zero or depend on \
             each other; each contact needs a boundary of its own",
            names(contacts),
            at
        ),
        ContactFault::StaticBelowKinetic { contact, ratio } => format!(
            "the static friction of the contact {} {} is {} times the kinetic; it must be at \
             least as large: raise it, or lower friction in slip where the slip begins",
            name(*contact),
            at,
            readable(*ratio)
        ),
        ContactFault::HoldsElsewhere { held, slipping } => format!(
            "with the contact {} at rest {}, its static friction changes the friction of the \
             contact {}, which slips; only contacts at rest have static friction",
            name(*held),
            at,
            name(*slipping)
        ),
        ContactFault::NotAdditive { pair } => format!(
            "the friction of the contacts {} and {} does not add {}: what one does depends on \
             the side of the other; each contact's friction must depend on its own side only",
            name(pair.0),
            name(pair.1),
            at
        ),
        other => format!("{other:?} {at}"),
    }
}

/// The names of contacts, in a row.
fn names(contacts: &[usize], name: &dyn Fn(usize) -> String) -> String {
    let names: Vec<String> = contacts.iter().map(|&contact| name(contact)).collect();
    names.join(", ")
}
