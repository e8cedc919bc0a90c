//! The functions whose zeros a run locates: sections and jumps, over typed states.

use super::Section;
use super::jumps::Jumps;
use super::typed::View;
use crate::filippov::{Direction, EventFunctions, Strobe, Switched, Velocity};
use crate::ode::Timed;
use crate::scalar::Scalar;
use crate::system::State;

/// An event function of no system's own.
#[derive(Clone, Copy, Debug)]
pub struct NoSection;

impl<const N: usize> EventFunctions<N, 1> for NoSection {
    #[inline(always)]
    fn values<T: Scalar>(&self, _t: T, _x: &[T; N]) -> [T; 1] {
        [T::one()]
    }
}

impl<'a, S, V, J, const N: usize, const G: usize> View<'a, S, V, J, N, G>
where
    S: Switched<N, G>,
    J: Jumps<N>,
{
    pub(super) fn section(&self, section: &Section) -> TypedSection<'a, S, V, J, N, G> {
        let what = match section {
            Section::None => What::Nothing,
            Section::Plane {
                point,
                normal,
                direction,
            } => What::Plane {
                point: self.state(point.as_slice()),
                normal: self.state(normal.as_slice()),
                direction: *direction,
            },
            Section::Strobe(strobe) => What::Strobe(*strobe),
            Section::Turning => What::Turning,
            Section::Own => What::Own,
        };
        self.function(what)
    }

    fn function(&self, what: What<N>) -> TypedSection<'a, S, V, J, N, G> {
        TypedSection {
            system: self.system,
            own: self.own,
            jumps: self.jumps,
            what,
        }
    }

    /// The function of a jump.
    pub(super) fn when(&self, jump: usize) -> TypedSection<'a, S, V, J, N, G> {
        self.function(What::Jump(jump))
    }
}

/// A section over typed states.
pub(super) struct TypedSection<'a, S, V, J, const N: usize, const G: usize> {
    system: &'a S,
    own: &'a V,
    jumps: &'a J,
    what: What<N>,
}

#[derive(Clone, Copy)]
enum What<const N: usize> {
    Nothing,
    Plane {
        point: State<N>,
        normal: State<N>,
        direction: Direction,
    },
    Strobe(Strobe),
    Turning,
    Own,
    Jump(usize),
}

impl<S, V, J, const N: usize, const G: usize> EventFunctions<N, 1>
    for TypedSection<'_, S, V, J, N, G>
where
    S: Switched<N, G>,
    V: EventFunctions<N, 1>,
    J: Jumps<N>,
{
    #[inline(always)]
    fn values<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; 1] {
        match self.what {
            What::Nothing => [T::one()],
            What::Plane { point, normal, .. } => {
                let height = |sum: T, i: usize| sum + (x[i] - point[i]) * normal[i];
                [(0..N).fold(T::zero(), height)]
            }
            What::Strobe(strobe) => strobe.values(t, x),
            What::Turning => {
                let (t_here, x_here) = (t.value(), State::from(x.map(Scalar::value)));
                let mode = self.system.mode_by_side(t_here, &x_here);
                let here = Timed {
                    t: t_here,
                    x: x_here,
                };
                let branch = self.system.branch_of_field(mode, &here);
                let velocity = self.system.with_flow(mode, branch, Velocity(t, x));
                [velocity[0]]
            }
            What::Own => self.own.values(t, x),
            What::Jump(number) => [self.jumps.when(number, t, x)],
        }
    }

    fn direction(&self, number: usize) -> Direction {
        match self.what {
            What::Plane { direction, .. } => direction,
            What::Turning => Direction::Falling,
            What::Nothing | What::Strobe(_) => Direction::Both,
            What::Own => self.own.direction(number),
            What::Jump(number) => self.jumps.direction(number),
        }
    }

    fn is_as_smooth_as_state(&self, number: usize) -> bool {
        match self.what {
            What::Nothing | What::Plane { .. } | What::Turning => true,
            What::Own => self.own.is_as_smooth_as_state(number),
            What::Strobe(_) | What::Jump(_) => false,
        }
    }
}
