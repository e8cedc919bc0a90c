//! Errors of commands, in words for users who do not program. Contacts have their names, and
//! options are written as on the command line.

use stickslip::Error;
use stickslip::error::{Point, piled_up, readable};
use stickslip_kernels::file::{FileError, SettingError, System};
use stickslip_series::DataError;

use crate::render::OutputError;
use crate::sweep::SweepError;
use crate::table::TableError;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Setting(#[from] SettingError),
    #[error("{0}")]
    Usage(String),
    /// The attractor is not of the kind that was searched.
    #[error("{0}")]
    NoPeriodicOrbit(String),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Table(#[from] TableError),
    #[error(transparent)]
    Series(DataError),
    #[error("{}", in_words_by_number(.0))]
    Computation(#[from] Error),
    /// As [`Failure::Computation`], with the names of the system's contacts.
    #[error("{words}")]
    OfSystem { error: Error, words: String },
}

impl Failure {
    /// Whether the command line or the file is at fault, rather than the computation or the
    /// machine.
    pub(crate) fn is_usage(&self) -> bool {
        match self {
            Failure::File(_) | Failure::Setting(_) | Failure::Usage(_) => true,
            Failure::Sweep(error) => error.is_usage(),
            Failure::Table(error) => matches!(error, TableError::Request(_)),
            Failure::Output(_) | Failure::NoPeriodicOrbit(_) | Failure::Series(_) => false,
            Failure::Computation(error) | Failure::OfSystem { error, .. } => {
                matches!(error, Error::Option { .. } | Error::Interval { .. })
            }
        }
    }

    /// Replaces numbers of contacts by their names.
    pub(crate) fn of(self, system: &System) -> Self {
        match self {
            Failure::Computation(error) => Failure::OfSystem {
                words: in_words(&error, system),
                error,
            },
            other => other,
        }
    }
}

/// An error of the library in words.
pub(crate) fn in_words(error: &Error, system: &System) -> String {
    with_names(error, &|contact| match system.contact_name(contact) {
        name if name.is_empty() => contact.to_string(),
        name => format!("`{name}`"),
    })
}

/// As [`in_words`], but for an unknown system, with contacts by number.
fn in_words_by_number(error: &Error) -> String {
    with_names(error, &|contact| contact.to_string())
}

fn with_names(error: &Error, name: &dyn Fn(usize) -> String) -> String {
    let names = |contacts: &[usize]| {
        let names: Vec<String> = contacts.iter().map(|&contact| name(contact)).collect();
        names.join(", ")
    };
    let at = |t: &f64, x: &Point| format!("at t = {}, x = {x}", readable(*t));
    match error {
        Error::Option {
            name: option,
            value,
            bound,
        } => format!(
            "{} {} is not allowed: it must be {bound}",
            as_given(option),
            readable(*value)
        ),
        Error::EventPileUp {
            count,
            span,
            t,
            x,
            contacts,
            accumulation,
        } => format!(
            "{count} transitions at {} within {span:e} before t = {}, x = {x}: {}",
            names(contacts),
            readable(*t),
            piled_up(accumulation.as_deref(), *span, "--at-pile-up rest")
        ),
        Error::NoUniqueMode {
            t,
            x,
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
                "the contacts {} stand at zero {}, and {motions}; friction there may push apart, \
                 or one contact's force act on another too strongly: look at the field with each \
                 of them on either side (--at-repelling has no effect with several contacts)",
                names(contacts),
                at(t, x)
            )
        }
        Error::TooManyContacts { t, x, contacts } => format!(
            "the contacts {} stand at zero together {}: more than eight are too many to try where \
             friction at one does not resist all of them as Coulomb's does; move their boundaries \
             apart, or write their friction without coupling",
            names(contacts),
            at(t, x)
        ),
        Error::DependentContacts { t, x, contacts } => format!(
            "the boundaries of the contacts {} have gradients {} that are zero or depend on each \
             other; each contact needs a boundary of its own",
            names(contacts),
            at(t, x)
        ),
        Error::StaticBelowKinetic {
            t,
            x,
            contact,
            ratio,
        } => format!(
            "the static friction of the contact {} {} is {} times the kinetic; it must be at least \
                as large",
            name(*contact),
            at(t, x),
            readable(*ratio)
        ),
        Error::HoldsElsewhere {
            t,
            x,
            held,
            slipping,
        } => format!(
            "with the contact {} at rest {}, its static friction changes the friction of the \
             contact {}, which slips; only contacts at rest have static friction",
            name(*held),
            at(t, x),
            name(*slipping)
        ),
        Error::NotAdditive { t, x, pair } => format!(
            "the friction of the contacts {} and {} does not add {}: what one does depends on the \
             side of the other; in a file each contact's friction must depend on its own side only",
            name(pair.0),
            name(pair.1),
            at(t, x)
        ),
        Error::Undefined { what, number, t, x } => format!(
            "{what} {} is not a number {}; write it so that it is defined wherever the orbit \
             comes, as by max(…, 0) under a root, or end the run before",
            name(*number),
            at(t, x)
        ),
        Error::NotConverged { .. } => format!(
            "{error}, after a longer --transient or by another --start; the motion may also be \
             quasi-periodic or chaotic, which `stickslip lyapunov` tells"
        ),
        Error::Escaped { .. } => format!("{error} (--escape)"),
        Error::TooMany { name, .. } => format!("{error} (--{})", name.replace('_', "-")),
        Error::NoUniqueFuture { t, x } => format!(
            "the orbit has no unique future after t = {}, x = {x}: both fields lead away from the \
             boundary; choose one with --at-repelling below or above, or start elsewhere",
            readable(*t)
        ),
        other => other.to_string(),
    }
}

/// Name of a setting of the library on the command line.
fn as_given(option: &str) -> String {
    let known = [
        ("rtol", "--tol"),
        ("longest", "--until"),
        ("most_points", "--points"),
        ("range", "--parameter"),
    ];
    match known.iter().find(|(name, _)| *name == option) {
        Some((_, given)) => (*given).to_owned(),
        None => format!("--{}", option.replace('_', "-")),
    }
}
