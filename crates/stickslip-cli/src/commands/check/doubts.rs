//! What of a file can be integrated and is hardly meant.

use stickslip::Error;
use stickslip::error::Point;

use super::super::sweeping::check_period;
use super::super::tables::rounded;
use super::super::told::told;
use crate::tangents::{Jumps, Line};
use stickslip_kernels::file::System;

/// A period that is none; friction that pushes the wrong way, and static friction below that in slip: asked on every contact's boundary, next to the
/// start; boundaries of several contacts that vanish together and depend on each other there.
pub(super) fn doubts(system: &System) -> Vec<String> {
    let period = match (system.is_periodic(), check_period(system)) {
        (Some(false), Err(failure)) => Some(failure.to_string()),
        _ => None,
    };
    let contacts = (0..system.contacts()).flat_map(|contact| doubts_of(system, contact));
    let dependent = system.dependent_boundaries();
    let dependent = dependent.map(|(contacts, x)| {
        let (t, contacts) = (system.built.t_start, contacts.to_vec());
        let x = Point(x);
        told(&Error::DependentContacts { t, x, contacts }, system)
    });
    period
        .into_iter()
        .chain(contacts)
        .chain(dependent)
        .collect()
}

fn doubts_of(system: &System, contact: usize) -> Vec<String> {
    let described = &system.file.contacts[contact];
    let Some(start) = system.built.start.as_deref() else {
        return Vec::new();
    };
    let t = system.built.t_start;
    let whole = (f64::NEG_INFINITY, f64::INFINITY);
    let jumps = Line::through(system, contact, None, whole, (t, start))
        .and_then(|line| line.jumps(system, start[line.along]));
    let (Some(_), Some(jumps)) = (&described.friction, jumps) else {
        return Vec::new();
    };
    let Jumps {
        slip,
        holding,
        rounding,
    } = jumps;
    let name = &described.name;
    let mut doubts = Vec::new();
    if slip > rounding {
        doubts.push(format!(
            "the friction of {name} drives the slip: the rate of {} is larger by {} above than below, so that the contact never sticks; is \
             friction({name}) meant with the other sign?",
            described.boundary.text,
            rounded(slip)
        ));
    } else if described.holding.is_some() && holding > slip + rounding {
        doubts.push(format!(
            "static friction of {name} is less than friction in slip: it takes {} of the rate of {}, and in slip {}",
            rounded(-holding),
            described.boundary.text,
            rounded(-slip)
        ));
    }
    doubts
}
