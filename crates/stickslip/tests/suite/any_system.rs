//! All systems of the tests as one type for each number of states. The solver is compiled once for
//! that type and not for every system. Functions with the library's names compute orbits and
//! spectra.

use stickslip::analysis::{Monodromy, PeriodicOrbit, Spectrum, SpectrumOptions};
use stickslip::dynamics::Components;
use stickslip::{Error, Failure, IntoState, Observer, Options, Orbit, Summary, analysis};

use crate::blocks::{Block, Bracket};
use crate::compiled::{Compiled, traced};
use crate::constant_fields::ConstantFields;
use crate::corners::{CornerOfBoundary, CornerOfField, Creep, EqualInStick, Weaker};
use crate::den_hartog::DenHartog;
use crate::endings::{Line, Plane, Wave};
use crate::ensemble::{self, CompiledBlock, Edge};
use crate::flat::{Driven, Narrow, Square};
use crate::grazes;
use crate::lyapunov_equations::{Fork, FromSupport, Linear, Pressed, Refracting, Rider, Roessler};
use crate::pulses::{Overflowing, Pushed, Slippery, Spike};
use crate::sections::EventSet;
use crate::smooth::{Lorenz, Smooth};
use crate::solver::systems::{
    BlowUp, Breathing, Ceiling, ComesToRest, Dip, Floor, Ledge, MovingLine, Pair, Parabola,
    Reversed, Spiral, StaticFriction, TurningLine, TwiceRound, TwoFold, Wall, Window, Zeno,
};
use crate::taylor::{
    Bilinear, Brink, Cup, Dent, Gate, Kink, Knee, Pit, Push, Ramp, Rectified, SoftStop, Steep,
    Steepening, Turn, UndefinedAfterOne, Valley,
};
use crate::two_folds::{Folds, Random};

/// `typed!(Name, n: Variant(Type), …)`: the type `Name` of the systems of `n` states that branch on
/// values.
macro_rules! typed {
    ($(#[$derived:meta])* $any:ident, $n:literal: $($name:ident($system:ty)),* $(,)?) => {
        $(#[$derived])*
        pub enum $any {
            $($name($system)),*
        }

        impl stickslip::Filippov<$n> for $any {
            #[inline(never)]
            fn field<T: stickslip::Scalar>(
                &self,
                side: stickslip::Side,
                t: T,
                x: &[T; $n],
            ) -> [T; $n] {
                match self {
                    $($any::$name(system) => system.field(side, t, x)),*
                }
            }
            #[inline(never)]
            fn boundary<T: stickslip::Scalar>(&self, t: T, x: &[T; $n]) -> T {
                match self {
                    $($any::$name(system) => system.boundary(t, x)),*
                }
            }
        }

        $(impl $crate::compiled::Compiled<$n> for $system {
            type Any<'a> = $any;
            fn any(&self) -> $any {
                $any::$name(*self)
            }
            fn dynamics(&self) -> stickslip::dynamics::DynamicsRef<'_> {
                use stickslip::dynamics::{DynamicsRef, Typed};
                let owned = Typed::<$any, $any, _, _, _, $n, 3>::new(self.any());
                DynamicsRef::Owned(Box::new(owned))
            }
        })*
    };
}

traced!(
    1:
    BlowUp, Breathing, Cup, Dent, Fork, Knee, ConstantFields, MovingLine, Push, Rectified, Rider,
    Spike,
    Line, Square, Steep, Steepening, TurningLine, UndefinedAfterOne, Wall, Window,
);

typed!(Any1, 1: Brink(Brink), ComesToRest(ComesToRest), Valley(Valley), Wave(Wave));

traced!(
    2:
    Block, Ceiling, CornerOfBoundary, CornerOfField, Creep, DenHartog, Dip, Driven,
    EqualInStick, Floor, FromSupport, Ledge, Smooth<Linear<2>>, Overflowing,
    Parabola, Pit, Plane, Pushed, Ramp, Refracting, Reversed<Block>,
    grazes::Shaken, SoftStop, grazes::AtRest, Spiral, Slippery, StaticFriction, Turn, TwoFold, Zeno,
);

typed!(
    #[derive(Clone, Copy, PartialEq)]
    Oscillator, 2:
    Belt(CompiledBlock), Bilinear(Bilinear), Edge(Edge), Gate(Gate), Kink(Kink),
    Steep(ensemble::Steep),
);

traced!(
    3:
    Folds, Random, Smooth<Linear<3>>, Smooth<Lorenz>, Narrow, Smooth<Roessler>, TwiceRound,
);

traced!(
    4:
    Bracket, Pair, Pressed, Weaker,
);

pub fn solve<S: Compiled<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
) -> Result<Orbit<N>, Failure<Orbit<N>>> {
    stickslip::solve(&system.any(), t0, x0.into_state(), t_end, options)
}

pub fn solve_with_events<S: Compiled<N>, const N: usize, const E: usize>(
    system: &S,
    events: &EventSet<E>,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
) -> Result<Orbit<N>, Failure<Orbit<N>>> {
    stickslip::solve_with_events(&system.any(), events, t0, x0.into_state(), t_end, options)
}

pub fn run<S: Compiled<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: impl IntoState<N>,
    t_end: f64,
    options: &Options,
    observer: &mut dyn Observer<N>,
) -> Result<Summary<N>, Failure<Summary<N>>> {
    stickslip::run(&system.any(), t0, x0.into_state(), t_end, options, observer)
}

pub fn monodromy<S: Compiled<N>, const N: usize>(
    system: &S,
    t0: f64,
    x0: impl Components,
    t_end: f64,
    options: &Options,
) -> Result<Monodromy, Error> {
    analysis::Monodromy::of(&system.dynamics(), t0, x0, t_end, options)
}

pub fn periodic_orbit<S: Compiled<N>, const N: usize>(
    system: &S,
    x: impl Components,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    analysis::PeriodicOrbit::near(&system.dynamics(), x, period, options)
}

pub fn find_periodic_orbit<S: Compiled<N>, const N: usize>(
    system: &S,
    x0: impl Components,
    transient: f64,
    longest: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    analysis::PeriodicOrbit::approached(&system.dynamics(), x0, transient, longest, options)
}

pub fn periodic_orbit_forced<S: Compiled<N>, const N: usize>(
    system: &S,
    t: f64,
    x: impl Components,
    period: f64,
    options: &Options,
) -> Result<PeriodicOrbit, Error> {
    analysis::PeriodicOrbit::near_forced(&system.dynamics(), t, x, period, options)
}

pub fn lyapunov_spectrum<S: Compiled<N>, const N: usize>(
    system: &S,
    start: (f64, impl Components),
    settings: &SpectrumOptions,
) -> Result<Spectrum, Error> {
    analysis::lyapunov_spectrum(&system.dynamics(), start, settings)
}

pub fn lyapunov_spectrum_watched<S: Compiled<N>, const N: usize>(
    system: &S,
    start: (f64, impl Components),
    settings: &SpectrumOptions,
    watcher: &mut impl Observer<N>,
) -> Result<Spectrum, Error> {
    analysis::Spectrum::watched(&system.any(), start, settings, watcher)
}
