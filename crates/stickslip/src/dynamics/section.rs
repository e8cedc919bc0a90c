//! The functions whose zeros a run locates: sections and jumps, over typed states.

use super::Section;
use super::jumps::Jumps;
use super::view::View;
use crate::filippov::{Direction, EventFunctions, Plane, Strobe, Switched, Velocity};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::State;

/// An event function of no system's own.
#[derive(Clone, Copy, Debug)]
pub struct NoSection;

impl<const N: usize> EventFunctions<N> for NoSection {
    fn count(&self) -> usize {
        0
    }

    #[inline(always)]
    fn value<T: Scalar>(&self, _number: usize, _t: T, _x: &[T; N]) -> T {
        T::one()
    }
}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    /// The functions of sections.
    pub(super) fn sections(&self, sections: &[Section]) -> TypedFunctions<'a, S, V, J, N, G> {
        let kind = |section: &Section| match section {
            Section::Plane {
                point,
                normal,
                direction,
            } => FunctionKind::Plane(Plane {
                point: self.state(point.as_slice()),
                normal: self.state(normal.as_slice()),
                direction: *direction,
            }),
            Section::Strobe { first, period } => FunctionKind::Strobe(Strobe {
                first: *first,
                period: *period,
            }),
            Section::MaximaOfFirstState => FunctionKind::Turning,
            Section::OfSystem(number) => FunctionKind::Own(*number),
        };
        self.functions(sections.iter().map(kind).collect())
    }

    /// The functions of the first `count` jumps.
    pub(super) fn functions_of_jumps(&self, count: usize) -> TypedFunctions<'a, S, V, J, N, G> {
        let kind = |jump: usize| match self.jumps.is_searched(jump) {
            true => FunctionKind::Jump(jump),
            false => FunctionKind::Never,
        };
        self.functions((0..count).map(kind).collect())
    }

    fn functions(&self, kinds: Vec<FunctionKind<N>>) -> TypedFunctions<'a, S, V, J, N, G> {
        TypedFunctions {
            system: self.system,
            own: self.own,
            jumps: self.jumps,
            kinds,
        }
    }
}

/// The functions of sections or jumps over typed states.
pub(super) struct TypedFunctions<'a, S, V, J, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    jumps: &'a J,
    kinds: Vec<FunctionKind<N>>,
}

#[derive(Clone, Copy)]
enum FunctionKind<const N: usize> {
    Plane(Plane<N>),
    Strobe(Strobe),
    Turning,
    Own(usize),
    Jump(usize),
    /// A function without a zero.
    Never,
}

impl<S, V, J, const N: usize, const G: usize> EventFunctions<N>
    for TypedFunctions<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N>,
    J: Jumps<N>,
{
    fn count(&self) -> usize {
        self.kinds.len()
    }

    #[inline(always)]
    fn value<T: Scalar>(&self, number: usize, t: T, x: &[T; N]) -> T {
        match &self.kinds[number] {
            FunctionKind::Plane(plane) => plane.value(0, t, x),
            FunctionKind::Strobe(strobe) => strobe.value(0, t, x),
            FunctionKind::Turning => {
                let here = Timed {
                    t: t.value(),
                    x: State::from(x.map(Scalar::value)),
                };
                let mode = self.system.mode_by_side(here.t, &here.x);
                let branch = self.system.branch_of_field(mode, &here);
                let velocity = self.system.with_flow(mode, branch, Velocity(t, x));
                velocity[0]
            }
            FunctionKind::Own(own) => self.own.value(*own, t, x),
            FunctionKind::Jump(jump) => self.jumps.when(*jump, t, x),
            FunctionKind::Never => T::one(),
        }
    }

    fn direction(&self, number: usize) -> Direction {
        match &self.kinds[number] {
            FunctionKind::Plane(plane) => plane.direction,
            FunctionKind::Turning => Direction::Falling,
            FunctionKind::Strobe(_) | FunctionKind::Never => Direction::Both,
            FunctionKind::Own(own) => self.own.direction(*own),
            FunctionKind::Jump(jump) => self.jumps.direction(*jump),
        }
    }

    fn is_as_smooth_as_state(&self, number: usize) -> bool {
        match &self.kinds[number] {
            FunctionKind::Plane(_) | FunctionKind::Turning | FunctionKind::Never => true,
            FunctionKind::Own(own) => self.own.is_as_smooth_as_state(*own),
            FunctionKind::Jump(jump) => self.jumps.is_as_smooth_as_state(*jump),
            FunctionKind::Strobe(_) => false,
        }
    }
    fn is_affine(&self, number: usize) -> bool {
        match &self.kinds[number] {
            FunctionKind::Plane(_) => true,
            FunctionKind::Own(own) => self.own.is_affine(*own),
            FunctionKind::Jump(jump) => self.jumps.is_affine(*jump),
            FunctionKind::Turning | FunctionKind::Never | FunctionKind::Strobe(_) => false,
        }
    }
}
