//! Orbits of one system from many starts.

use std::cell::RefCell;
use std::ops::ControlFlow;

use super::jumps::Jumps;
use super::run::Run;
use super::{Moment, OrbitProgress, OrbitUnderWay};
use crate::error::Error;
use crate::filippov::{BatchMember, EventFunctions, Integration, Switched};

/// Receives what [`OrbitUnderWay::step`] returns for several orbits, each by the index of its
/// start.
/// An orbit is followed until it ends, fails, or the listener breaks.
pub type Listener<'l> =
    dyn FnMut(usize, Result<OrbitProgress, Error>, &mut dyn OrbitUnderWay) -> ControlFlow<()> + 'l;

/// Follows the orbits one after the other.
pub(super) fn one_by_one<'a>(
    begin: impl Fn(&Moment) -> Result<Box<dyn OrbitUnderWay + 'a>, Error>,
    starts: &[Moment],
    listener: &mut Listener<'_>,
) -> Vec<Result<(), Error>> {
    let follow = |(number, start)| {
        let mut orbit = begin(start)?;
        loop {
            let progress = orbit.step();
            let is_over = matches!(progress, Ok(OrbitProgress::End(_)) | Err(_));
            if listener(number, progress, &mut *orbit).is_break() || is_over {
                return Ok(());
            }
        }
    };
    starts.iter().enumerate().map(follow).collect()
}

/// An orbit of a batch with its listener.
pub(super) struct BatchOrbit<'r, 'l, R> {
    pub(super) number: usize,
    pub(super) run: R,
    pub(super) listener: &'r RefCell<&'r mut Listener<'l>>,
}

impl<'a, S, V, J, const N: usize, const G: usize> BatchMember<'a, S, N, G>
    for BatchOrbit<'_, '_, Run<'a, S, V, J, N, G>>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    type Outcome = Result<(), Error>;

    fn integration(&mut self) -> &mut Integration<'a, S, N, G> {
        self.run.integration()
    }

    fn watches_step(&mut self) -> bool {
        self.run.watches_steps()
    }

    fn go_on(&mut self) -> Option<Result<(), Error>> {
        loop {
            let progress = self.run.go_on()?;
            let is_over = matches!(progress, Ok(OrbitProgress::End(_)) | Err(_));
            let mut listener = self.listener.borrow_mut();
            if listener(self.number, progress, &mut self.run).is_break() || is_over {
                return Some(Ok(()));
            }
        }
    }
}
