//! Warnings about a system that can run, but is probably not what was meant.

use stickslip::error::{ContactFault, Point, readable};
use stickslip::{Direction, Error};

use super::at_start::{jumps_at_start, left_out};
use super::friction::negative_at;
use super::tangents::{BoundaryLine, RateJumps};
use crate::file::{Interface, System};

/// Warnings about a system. They concern friction that is negative at the start or in the wrong
/// direction, and static friction below that in slip. Friction is evaluated on the boundary of
/// every contact, next to the start. Others concern jumps that cannot happen soon after the start
/// or that a run counts as done there, and runs that end at their start. Boundaries of several
/// contacts that vanish together and are dependent there have one, too. Without a start only these
/// are checked.
pub fn warnings(
    system: &System,
    start: Option<(f64, &[f64])>,
    interface: &impl Interface,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(start) = start {
        let contacts = 0..system.contacts();
        warnings.extend(contacts.filter_map(|contact| {
            let negative = negative_at(system, contact, start);
            negative.or_else(|| warning_of_contact(system, contact, start))
        }));
        let (done, error) = match jumps_at_start(system, start) {
            Ok(done) => (done, None),
            Err(error) => (Vec::new(), Some(error)),
        };
        // A run starts at a stop or in front of it, or not at all.
        let all = system.file.jumps.iter().enumerate();
        let jumps = all.filter_map(|(jump, of)| of.of_stop.is_none().then_some(jump));
        let jumps = jumps.filter(|jump| !done.contains(jump));
        let jumps: Vec<usize> = jumps.collect();
        let counters = jumps.iter();
        warnings.extend(counters.filter_map(|&jump| warning_of_counter(system, jump, start)));
        let jumps = jumps.into_iter();
        warnings.extend(jumps.filter_map(|jump| warning_of_jump(system, jump, start)));
        warnings.extend(left_out(system, start, &done));
        warnings.extend(error.map(|error| {
            let words = interface.words(&error, Some(system));
            format!("a run does not begin at the start: {words}")
        }));
    }
    if let Some((contacts, x)) = system.dependent_boundaries() {
        let (t, x) = (system.built.t_start, Point(x));
        let fault = ContactFault::DependentContacts { contacts };
        let error = Error::Contacts { t, x, fault };
        warnings.push(interface.words(&error, Some(system)));
    }
    warnings
}

fn warning_of_contact(
    system: &System,
    contact: usize,
    (t, start): (f64, &[f64]),
) -> Option<String> {
    let described = &system.file.contacts[contact];
    described.friction.as_ref()?;
    let range = (f64::NEG_INFINITY, f64::INFINITY);
    let line = match system.states() {
        // The boundary is a point.
        1 => BoundaryLine {
            contact,
            along: 0,
            solved: 0,
            range,
            t,
            x: start.to_vec(),
            path: Vec::new(),
        },
        _ => BoundaryLine::through(system, contact, None, range, (t, start))?,
    };
    let RateJumps {
        slip,
        holding,
        rounding,
    } = line.jumps(system, start[line.along])?;
    let (name, boundary) = (&described.name, &described.boundary.text);
    if slip > rounding {
        return Some(format!(
            "the friction of {name} drives the slip: the rate of {boundary} is larger by {} above \
             than below, so that the contact never sticks; is friction({name}) meant with the \
             other sign?",
            readable(slip)
        ));
    }
    let is_less = described.holding.is_some() && holding > slip + rounding;
    is_less.then(|| {
        format!(
            "static friction of {name} is less than friction in slip: it takes {} of the rate of \
             {boundary}, and in slip {}",
            readable(-holding),
            readable(-slip)
        )
    })
}

/// A jump whose function has a discrete state alone and is zero at a whole number of it, as
/// `n - 3`. The function stands at zero there, and changes sign only with the next number.
fn warning_of_counter(system: &System, number: usize, (t, x): (f64, &[f64])) -> Option<String> {
    let (described, switching) = (&system.file.jumps[number], &system.built.switching);
    let jump = &switching.jumps[number];
    let is_discrete = |state: usize| system.file.states[state].is_discrete;
    let mut values = vec![0.0; switching.room()];
    let mut height = |t: f64, x: &[f64]| {
        jump.when
            .evaluate(t, &switching.extended(t, x), &mut values[..1]);
        values[0]
    };
    let here = height(t, x);
    let moved = x.iter().enumerate().map(|(k, x)| match is_discrete(k) {
        true => *x,
        false => *x + 1.0 / (1.0 + k as f64),
    });
    let moved: Vec<f64> = moved.collect();
    if height(t + 1.0, &moved) != here {
        return None;
    }
    let mut states = (0..x.len()).filter(|&state| is_discrete(state));
    states.find_map(|state| {
        let mut at = |value: f64| {
            let mut x = x.to_vec();
            x[state] = value;
            height(t, &x)
        };
        let whole = (x[state] - here / (at(x[state] + 1.0) - here)).round();
        let is_zero = whole.is_finite() && at(whole) == 0.0 && at(whole + 1.0) != 0.0;
        let (name, state) = (&described.name, &system.file.states[state].name);
        is_zero.then(|| {
            format!(
                "the jump {name} does not occur where {state} becomes {whole}: its function {} is \
                 zero there, and changes sign only as {state} goes on; write a function that is \
                 zero between two values of {state}",
                described.when.text
            )
        })
    })
}

/// A jump of one direction whose function is past zero at the start, such as that of a heater which
/// is off in a room that is already too cold. Functions of time alone pass zero by themselves. A
/// jump has had its effect where it changes nothing at the start, nor a second time elsewhere. One
/// that reverses a velocity leaves a state at rest as it is by chance.
fn warning_of_jump(system: &System, number: usize, (t, x): (f64, &[f64])) -> Option<String> {
    let (described, switching) = (&system.file.jumps[number], &system.built.switching);
    let jump = &switching.jumps[number];
    let (extended, mut values) = (switching.extended(t, x), vec![0.0; switching.room()]);
    let mut height = |x: &[f64]| {
        jump.when.evaluate(t, x, &mut values[..1]);
        values[0]
    };
    let here = height(&extended);
    let (is_past, passes, side, back) = match jump.direction {
        Direction::Rising => (here > 0.0, "rises", "positive", "negative"),
        Direction::Falling => (here < 0.0, "falls", "negative", "positive"),
        Direction::Both => return None,
    };
    // Another state, at different distances in all components.
    let mut other = extended.clone();
    let moved = other.iter_mut().take(x.len()).enumerate();
    moved.for_each(|(k, x)| *x += 1.0 / (1.0 + k as f64));
    let is_of_time = height(&other) == here;
    let after = |from: &[f64]| {
        let mut x = from.to_vec();
        switching.after(number, t, &mut x);
        x
    };
    let is_done = || {
        let once = after(&other);
        after(&extended)[..x.len()] == *x && after(&once)[..x.len()] == once[..x.len()]
    };
    if !is_past || is_of_time || described.most.is_none() && is_done() {
        return None;
    }
    Some(format!(
        "the jump {} happens where {} {passes} through zero, and at the start that is already \
         {side} ({}): nothing happens until it has been {back}; start on the other side, or with \
         the state behind the jump",
        described.name,
        described.when.text,
        readable(here)
    ))
}
