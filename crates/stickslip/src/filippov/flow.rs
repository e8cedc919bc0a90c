//! The smooth flow of one mode, and the guards that end the mode.

use crate::dual::{Dual, Dual3};
use crate::interval::Interval;
use crate::ode::{Linear, Timed};
use crate::scalar::Scalar;
use crate::system::{Filippov, Mode, Side, State, components};
use crate::taylor::row::Lanes;
use crate::taylor::series::{Expansion, Functions, in_rows};
use crate::taylor::sweep::CoefficientRows;

/// Rate of the boundary function along the vector `f` at `(t, x)`: `∂h/∂t + ∇h·f`. It is the normal
/// component of the field relative to a moving Σ, and the first Lie derivative where `f` is a field
/// of the system.
#[inline(always)]
pub(crate) fn normal_component<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    t: T,
    x: &[T; N],
    f: &[T; N],
) -> T {
    let mut along = [Dual::zero(); N];
    for i in 0..N {
        along[i] = Dual::new(x[i], f[i]);
    }
    system.boundary(Dual::new(t, T::one()), &along).eps
}

/// Filippov's sliding field on Σ: the convex combination of the two fields ([`Filippov::holding`])
/// that is tangent to Σ. It is `f₁ + λ (f₂ − f₁)` with `λ = a₁/(a₁ − a₂)`, where `a₁` and `a₂` are
/// the fields' normal components (Filippov 1988, Sect. 4).
///
/// Components that both fields share come out exactly as they are. Where both normal components
/// vanish (a two-fold) or agree, every combination is as tangent as any other; the mean is taken.
#[inline(always)]
pub fn sliding_field<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    t: T,
    x: &[T; N],
) -> [T; N] {
    sliding(system, t, x).0
}

/// A loop over the components of a state. The first four are written out, since the compiler does
/// not unroll a long body. It must know at compile time where the coefficients of a series are.
macro_rules! for_each_state {
    ($i:ident in $n:ident, $body:block) => {
        for_each_state!(@ $i, $n, $body, 0, 1, 2, 3);
        if const { $n > 4 } {
            for $i in 4..$n $body
        }
    };
    (@ $i:ident, $n:ident, $body:block, $($k:literal),*) => {
        $(if const { $k < $n } {
            let $i: usize = $k;
            $body
        })*
    };
}

/// The sliding field, and the two normal components that it is computed from.
#[inline(always)]
fn sliding<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    t: T,
    x: &[T; N],
) -> ([T; N], [T; 2]) {
    let below = system.holding(Side::Below, t, x);
    let above = system.holding(Side::Above, t, x);
    let a1 = normal_component(system, t, x, &below);
    let a2 = normal_component(system, t, x, &above);
    let mut field = below;
    let mut weight = None;
    for_each_state!(i in N, {
        let (below, above) = (below[i], above[i]);
        if !below.is_same(above) {
            field[i] = if below.is_same(a1) && above.is_same(a2) {
                // Where Σ is a level of one component, the sides' velocities across it cancel
                // exactly.
                T::zero()
            } else {
                let weight = *weight.get_or_insert_with(|| a1.divided_or(a1 - a2, 0.5));
                below + weight * (above - below)
            };
        }
    });
    (field, [a1, a2])
}

/// Number of guards of one contact: at most two of a mode's own, and one that all modes share.
pub(crate) const GUARDS: usize = 3;

/// The guard that all modes share: the contact function, times its present sign.
pub(crate) const CONTACT: usize = 2;

/// The contact function times its present sign. Without one it is a constant, which is not
/// searched.
#[inline(always)]
fn contact_guard<S: Filippov<N>, T: Scalar, const N: usize>(
    system: &S,
    t: T,
    x: &[T; N],
    sign: f64,
) -> T {
    match system.contact(t, x) {
        Some(contact) => contact * sign,
        None => T::one(),
    }
}

/// Margin of [`is_positive`] relative to the width of the range. The box contains the dense output,
/// from which the solution differs by less than a thousandth of a step's motion at the loosest
/// tolerance.
const DENSE_MARGIN: f64 = 1e-3;

/// Margin of [`is_positive`] relative to the size of the values, for bounds that are not rounded
/// outward. Chosen: it covers four million roundings and hides no guard that matters.
const ROUNDING_MARGIN: f64 = 1e-9;

/// Whether a range of values lies above zero by more than the error of the dense output and
/// rounding.
#[inline(always)]
pub(super) fn is_positive(range: Interval) -> bool {
    range.low > DENSE_MARGIN * (range.high - range.low) && range.low > ROUNDING_MARGIN * range.high
}

/// A smooth flow that lasts while all its guards are positive.
pub trait Flow<const N: usize> {
    /// Whether one guard costs as much as all of them, so that all are evaluated together.
    const TOGETHER: bool = false;
    /// Whether the user's functions are interpreted.
    const INTERPRETED: bool;
    /// The indices of the guards, [`CONTACT`] among them.
    fn guards(&self) -> &'static [usize];
    /// Number of components of the state in which derivatives are taken; [`Filippov::dimension`].
    fn dimension(&self) -> usize;
    /// Number of calls of the user's field in one evaluation.
    fn field_calls(&self) -> u64;
    /// dx/dt.
    fn field<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; N];
    /// Guard `i`: positive while the mode holds, zero where it ends.
    fn guard<T: Scalar>(&self, i: usize, t: T, x: &[T; N]) -> T;
    /// Positive where the fields of both sides lead towards the boundary along which the mode
    /// slides, and zero without one. Where it is negative, the fields lead apart, and the guards
    /// may be positive again. With several, it is so if the others are held.
    fn attraction<T: Scalar>(&self, t: T, x: &[T; N]) -> T;
    /// Whether the friction of one of several holding contacts is none at a place, beside that at
    /// another.
    fn friction_vanishes(&self, _from: &Timed<N>, _at: &Timed<N>) -> bool {
        false
    }
    /// Whether all guards may stay positive at a two-fold, as where several contacts hold.
    fn may_hide_two_fold(&self) -> bool {
        false
    }
    /// The field and all `G` guards. A guard that does not exist is constant.
    fn field_and_guards<T: Scalar, const G: usize>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]);

    /// The series of the solution and of the `G` guards; see [`in_rows`].
    #[inline(always)]
    fn expand<const L: usize, const G: usize>(
        &self,
        into: CoefficientRows<'_, L>,
        time: (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        order: usize,
    ) -> Result<Expansion<G>, usize> {
        in_rows(into, time, x, order, &OfFlow { flow: self, x })
    }

    /// Projects `x` onto the manifold of the flow, from which rounding has moved it.
    fn settle(&self, t: f64, x: State<N>) -> State<N>;
    /// Projects `x` onto the boundary where guard `i` has become zero.
    fn land(&self, i: usize, t: f64, x: State<N>) -> State<N>;

    /// Range of guard `i` over a range of times and states, if the guard's branches are decided
    /// there.
    #[inline(always)]
    fn range(&self, i: usize, t: Interval, x: &[Interval; N]) -> Option<Interval> {
        Interval::decided(|| self.guard(i, t, x))
    }

    /// Whether guard `i` certainly stays positive over a range of times and states. `false` proves
    /// nothing.
    #[inline(always)]
    fn is_clear(&self, i: usize, t: Interval, x: &[Interval; N]) -> bool {
        self.range(i, t, x).is_some_and(is_positive)
    }

    /// Marks the guards of `G` that certainly stay positive. A guard that does not exist does.
    #[inline(always)]
    fn are_clear<const G: usize>(&self, t: Interval, x: &[Interval; N]) -> [bool; G] {
        if Self::TOGETHER {
            let guards = Interval::decided(|| self.field_and_guards(t, x).1);
            return guards.map_or([false; G], |guards| guards.map(is_positive));
        }
        let mut clear = [true; G];
        for &i in self.guards() {
            clear[i] = self.is_clear(i, t, x);
        }
        clear
    }

    /// dx/dt at a state.
    #[inline(always)]
    fn velocity(&self, t: f64, x: &State<N>) -> State<N> {
        self.field(t, components(x)).into()
    }

    /// Guard `i` at a state, compiled once.
    #[inline(never)]
    fn guard_at(&self, i: usize, t: f64, x: &State<N>) -> f64 {
        self.guard(i, t, components(x))
    }

    /// All `G` guards at a state.
    fn guards_at<const G: usize>(&self, t: f64, x: &State<N>) -> [f64; G] {
        self.field_and_guards(t, components(x)).1
    }

    /// Rate of guard `i` along the vector `f`.
    fn rate<T: Scalar>(&self, i: usize, t: T, x: &[T; N], f: &[T; N]) -> T {
        let along: [_; N] = std::array::from_fn(|j| Dual::new(x[j], f[j]));
        self.guard(i, Dual::new(t, T::one()), &along).eps
    }

    /// Slope of time and state with guard `i` as independent variable: `(1, f)/rate`.
    fn henon_slope(&self, i: usize, at: &Timed<N>) -> Timed<N> {
        let x = components(&at.x);
        let f = self.field(at.t, x);
        let per_guard = 1.0 / self.rate(i, at.t, x, &f);
        Timed {
            t: per_guard,
            x: State::from([0.0; N]).add_scaled(per_guard, &State::from(f)),
        }
    }

    /// The solution through `(t, x)` with its first three time derivatives; see [`flow_path`].
    fn path(&self, t: f64, x: &State<N>) -> (Dual3<f64>, [Dual3<f64>; N]) {
        flow_path(t, components(x), |t, x| self.field(t, x))
    }

    /// Value and first three time derivatives of guard `i` along the flow.
    fn jet(&self, i: usize, t: f64, x: &State<N>) -> [f64; 4] {
        let path = self.path(t, x);
        let g = self.guard(i, path.0, &path.1);
        [g.re, g.v1, g.v2, g.v3]
    }

    /// Jets of all `G` guards.
    fn jets<const G: usize>(&self, t: f64, x: &State<N>) -> [[f64; 4]; G] {
        let path = self.path(t, x);
        let guards = self.field_and_guards(path.0, &path.1).1;
        guards.map(|g| [g.re, g.v1, g.v2, g.v3])
    }
}

/// The solution through `(t, x)` as third-order dual numbers in time: `x`, `ẋ`, `ẍ`, `x⃛`. Each
/// pass through the field adds one correct derivative.
pub(crate) fn flow_path<T: Scalar, const N: usize>(
    t: T,
    x: &[T; N],
    field: impl Fn(Dual3<T>, &[Dual3<T>; N]) -> [Dual3<T>; N],
) -> (Dual3<T>, [Dual3<T>; N]) {
    let zero = T::zero();
    let time = Dual3::new(t, T::one(), zero, zero);
    let mut path = x.map(|v| Dual3::new(v, zero, zero, zero));
    for _ in 0..3 {
        let slope = field(time, &path);
        path = std::array::from_fn(|i| Dual3::new(x[i], slope[i].re, slope[i].v1, slope[i].v2));
    }
    (time, path)
}

/// The field of a flow and its guards, along solutions from a state. Components that do not move
/// are constants in it; they are the same in all lanes.
pub(super) struct OfFlow<'a, F: ?Sized, const L: usize, const N: usize> {
    pub flow: &'a F,
    pub x: &'a [Lanes<L>; N],
}

impl<F: Flow<N> + ?Sized, const L: usize, const N: usize, const G: usize> Functions<N, G>
    for OfFlow<'_, F, L, N>
{
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "the loop vanishes where all move"
    )]
    fn at<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        let mut x = *x;
        for i in self.flow.dimension()..N {
            x[i] = T::constant(self.x[i][0]);
        }
        self.flow.field_and_guards(t, &x)
    }

    #[inline(always)]
    fn at_held<T: Scalar>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        self.flow.field_and_guards(t, x)
    }

    #[inline(always)]
    fn dimension(&self) -> usize {
        self.flow.dimension()
    }
}

/// A flow of interpreted functions, as work gets it from [`UseFlow::use_flow`]. The functions take
/// longer than a call, so that each is compiled once for each type of number and not at each use.
///
/// [`UseFlow::use_flow`]: super::switched::UseFlow::use_flow
pub(crate) struct Called<'f, F>(pub &'f F);

impl<F: Flow<N>, const N: usize> Flow<N> for Called<'_, F> {
    const TOGETHER: bool = F::TOGETHER;
    const INTERPRETED: bool = F::INTERPRETED;

    fn guards(&self) -> &'static [usize] {
        self.0.guards()
    }
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn field_calls(&self) -> u64 {
        self.0.field_calls()
    }
    #[inline(never)]
    fn field<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; N] {
        self.0.field(t, x)
    }
    #[inline(never)]
    fn guard<T: Scalar>(&self, i: usize, t: T, x: &[T; N]) -> T {
        self.0.guard(i, t, x)
    }
    #[inline(never)]
    fn attraction<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        self.0.attraction(t, x)
    }

    fn friction_vanishes(&self, from: &Timed<N>, at: &Timed<N>) -> bool {
        self.0.friction_vanishes(from, at)
    }

    fn may_hide_two_fold(&self) -> bool {
        self.0.may_hide_two_fold()
    }
    #[inline(never)]
    fn field_and_guards<T: Scalar, const G: usize>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        self.0.field_and_guards(t, x)
    }
    fn settle(&self, t: f64, x: State<N>) -> State<N> {
        self.0.settle(t, x)
    }
    fn land(&self, i: usize, t: f64, x: State<N>) -> State<N> {
        self.0.land(i, t, x)
    }
}

/// The flow of one contact in a mode. A slip ends where the boundary function, guard 0, reaches
/// zero. Stick, which is sliding on Σ, ends where either field stops pushing towards Σ: guard 0 is
/// the normal component of the field below, guard 1 minus that of the field above.
///
/// The mode is a value and not a type, so that the solver is compiled once for all of them.
pub(crate) struct OneContactFlow<'a, S> {
    pub system: &'a S,
    pub mode: Mode,
    /// Sign of the contact function.
    pub contact: f64,
}

/// The side that a body in stick is released to when guard `i` fails.
pub(crate) fn side_of_guard(i: usize) -> Side {
    if i == 0 { Side::Below } else { Side::Above }
}

impl<S: Filippov<N>, const N: usize> Flow<N> for OneContactFlow<'_, S> {
    const INTERPRETED: bool = S::INTERPRETED;

    #[inline(always)]
    fn guards(&self) -> &'static [usize] {
        match self.mode {
            Mode::Slip(_) => &[0, CONTACT],
            Mode::Stick => &[0, 1, CONTACT],
        }
    }

    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    #[inline(always)]
    fn field_calls(&self) -> u64 {
        match self.mode {
            Mode::Slip(_) => 1,
            Mode::Stick => 2,
        }
    }

    #[inline(always)]
    fn field<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; N] {
        match self.mode {
            Mode::Slip(side) => self.system.field(side, t, x),
            Mode::Stick => sliding_field(self.system, t, x),
        }
    }

    #[inline(always)]
    fn guard<T: Scalar>(&self, i: usize, t: T, x: &[T; N]) -> T {
        if i == CONTACT {
            return contact_guard(self.system, t, x, self.contact);
        }
        match self.mode {
            Mode::Slip(side) => self.system.boundary(t, x) * side.sign(),
            Mode::Stick => {
                let side = side_of_guard(i);
                let f = self.system.holding(side, t, x);
                normal_component(self.system, t, x, &f) * -side.sign()
            }
        }
    }

    #[inline(always)]
    fn field_and_guards<T: Scalar, const G: usize>(&self, t: T, x: &[T; N]) -> ([T; N], [T; G]) {
        let mut guards = [T::one(); G];
        let field = match self.mode {
            Mode::Slip(_) => {
                guards[0] = self.guard(0, t, x);
                self.field(t, x)
            }
            Mode::Stick => {
                let (field, [a1, a2]) = sliding(self.system, t, x);
                (guards[0], guards[1]) = (a1, -a2);
                field
            }
        };
        guards[CONTACT] = contact_guard(self.system, t, x, self.contact);
        (field, guards)
    }

    /// Expands the flow, with a copy of the code for each mode. The mode is a constant of the copy,
    /// so that the compiler knows where the coefficients are.
    #[inline(always)]
    fn expand<const L: usize, const G: usize>(
        &self,
        into: CoefficientRows<'_, L>,
        time: (Lanes<L>, Lanes<L>),
        x: &[Lanes<L>; N],
        order: usize,
    ) -> Result<Expansion<G>, usize> {
        macro_rules! in_mode {
            ($mode:expr) => {{
                let flow = Self {
                    mode: $mode,
                    ..*self
                };
                in_rows(into, time, x, order, &OfFlow { flow: &flow, x })
            }};
        }
        match self.mode {
            Mode::Slip(Side::Below) => in_mode!(Mode::Slip(Side::Below)),
            Mode::Slip(Side::Above) => in_mode!(Mode::Slip(Side::Above)),
            Mode::Stick => in_mode!(Mode::Stick),
        }
    }

    fn attraction<T: Scalar>(&self, t: T, x: &[T; N]) -> T {
        match self.mode {
            Mode::Slip(_) => T::zero(),
            Mode::Stick => self.guard(0, t, x) + self.guard(1, t, x),
        }
    }

    fn settle(&self, t: f64, x: State<N>) -> State<N> {
        match self.mode {
            Mode::Slip(_) => x,
            Mode::Stick => project(self.system, t, x),
        }
    }

    fn land(&self, i: usize, t: f64, x: State<N>) -> State<N> {
        match self.mode {
            Mode::Slip(_) if i == CONTACT => x,
            Mode::Slip(_) | Mode::Stick => project(self.system, t, x),
        }
    }
}

/// Gradient of a function in the first `dimension` components of the state, and its time
/// derivative.
pub(crate) fn gradient<const N: usize>(
    function: impl Fn(Dual<f64>, &[Dual<f64>; N]) -> Dual<f64>,
    at: &Timed<N>,
    dimension: usize,
) -> (State<N>, f64) {
    let along = |direction: usize| {
        let (t, x) = seeded(at, direction);
        function(t, &x).eps
    };
    let slope = |k, _| if k < dimension { along(k) } else { 0.0 };
    (State::from_fn(slope), along(N))
}

/// Time and state with the derivative 1 in one direction; direction `N` is time.
#[inline(always)]
pub(crate) fn seeded<const N: usize>(
    at: &Timed<N>,
    direction: usize,
) -> (Dual<f64>, [Dual<f64>; N]) {
    let seed = |of: usize| f64::from(u8::from(of == direction));
    let x = std::array::from_fn(|i| Dual::new(at.x[i], seed(i)));
    (Dual::new(at.t, seed(N)), x)
}

/// Gradient of the boundary function in the state, and its time derivative.
pub(super) fn boundary_gradient<S: Filippov<N>, const N: usize>(
    system: &S,
    t: f64,
    x: &State<N>,
) -> (State<N>, f64) {
    let at = Timed { t, x: *x };
    gradient(|t, x| system.boundary(t, x), &at, system.dimension())
}

/// One Newton step from `x` onto Σ along the gradient of the boundary function.
pub(crate) fn project<S: Filippov<N>, const N: usize>(system: &S, t: f64, x: State<N>) -> State<N> {
    let h = system.boundary(t, components(&x));
    if h == 0.0 {
        return x;
    }
    let (gradient, _) = boundary_gradient(system, t, &x);
    let length: f64 = gradient.norm_squared();
    if length > 0.0 && h.is_finite() {
        x.add_scaled(-h / length, &gradient)
    } else {
        x
    }
}
