//! Systems of several contacts: the trait that a user implements, and how contacts hold and release
//! together.

mod complementarity;
mod decision;
mod equations;
mod joint;
mod switched;

use crate::error::Error;
use crate::scalar::Scalar;
use crate::system::Side;

/// A system of `M` contacts: a smooth field for every combination of sides, and a boundary for each
/// contact.
///
/// The two functions are all that is needed, as with [`crate::Filippov`], which is simpler for one
/// contact. Contacts that hold at the same time slide on the intersection of their boundaries. The
/// sliding field is the multi-affine combination of the fields of all sides that is tangent to each
/// boundary (Alexander & Seidman, *Houston J. Math.* 24 (1998) 545; Dieci & Lopez, *Numer. Math.*
/// 117 (2011) 779; Jeffrey, *SIAM J. Appl. Dyn. Syst.* 13 (2014) 1082). If frictions add, this is
/// Coulomb's law: each contact's force is what holding takes, up to its limit.
///
/// The complementarity problem of all contacts at zero decides which of them hold after an event.
/// If it has no solution, or more than one, the run ends with an error.
///
/// [`crate::AtRepelling`] applies to systems of one boundary only. Only these end at two-folds and
/// may lose their normal force ([`crate::Filippov::contact`]). Friction that couples contacts in
/// other ways than Coulomb's is decided for at most eight contacts at zero together. Contacts whose
/// weight or rate vanishes are decided by the next derivative, one after the other.
///
/// Wrap it in [`Several`] for [`crate::solve`] and everything else that takes a system.
///
/// ```
/// use stickslip::{Contacts, Mode, Options, Scalar, Several, Side, solve};
///
/// /// Two blocks on a rough floor, joined by a spring. States: x₁, x₂, v₁, v₂.
/// struct TwoBlocks;
/// impl Contacts<4, 2> for TwoBlocks {
///     #[inline(always)]
///     fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, x: &[T; 4]) -> [T; 4] {
///         let pull = (x[1] - x[0]) * 0.5;
///         [
///             x[2],
///             x[3],
///             -x[0] + pull - 0.3 * sides[0].sign(),
///             -x[1] - pull - 0.4 * sides[1].sign(),
///         ]
///     }
///     #[inline(always)]
///     fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 4]) -> [T; 2] {
///         [x[2], x[3]]
///     }
/// }
///
/// let orbit = solve(&Several(TwoBlocks), 0.0, [3.0, 0.0, 0.0, 0.0], 30.0, &Options::default())?;
/// assert_eq!(orbit.phases[0].mode, [Mode::Slip(Side::Below), Mode::Slip(Side::Above)]);
/// // Friction brings both to rest.
/// assert_eq!(orbit.phases.last().unwrap().mode, [Mode::Stick; 2]);
/// # Ok::<(), stickslip::Error>(())
/// ```
pub trait Contacts<const N: usize, const M: usize> {
    /// Whether friction at one contact depends on the side of another. If not, an evaluation on an
    /// intersection takes one call of the field more than there are holding contacts; every event
    /// checks this. If so, each Newton step takes two to their number.
    const MULTI_AFFINE: bool = false;

    /// Whether the functions are interpreted, as [`crate::Filippov::INTERPRETED`].
    const INTERPRETED: bool = false;

    /// The vector field at time `t` and state `x` with every contact on its side: dx/dt.
    fn field<T: Scalar>(&self, sides: &[Side; M], t: T, x: &[T; N]) -> [T; N];

    /// The boundary functions h₁ … h_M. Contact `i` is below if the `i`-th is negative, above if it
    /// is positive, and may hold if it is zero. They may depend on time.
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; M];

    /// The fields whose combination holds the contacts in `held`, with static friction at these. A
    /// contact sticks as long as they can hold it, and then slips by [`Contacts::field`]. A contact
    /// that is not in `held` has its friction of [`Contacts::field`] here, too. By default the
    /// friction of slip holds.
    ///
    /// ```
    /// use stickslip::{Contacts, Mode, Options, Scalar, Several, Side, solve};
    ///
    /// /// Two blocks on a belt of speed 0.2, joined by a spring. Friction is 1 and 0.9 at rest and
    /// /// 0.6 of that in slip.
    /// struct OnBelt;
    /// impl OnBelt {
    ///     fn with<T: Scalar>(friction: [f64; 2], sides: &[Side; 2], x: &[T; 4]) -> [T; 4] {
    ///         let pull = (x[1] - x[0]) * 0.5;
    ///         [
    ///             x[2],
    ///             x[3],
    ///             -x[0] + pull - friction[0] * sides[0].sign(),
    ///             -x[1] - pull - friction[1] * sides[1].sign(),
    ///         ]
    ///     }
    /// }
    /// impl Contacts<4, 2> for OnBelt {
    ///     fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, x: &[T; 4]) -> [T; 4] {
    ///         OnBelt::with([0.6, 0.54], sides, x)
    ///     }
    ///     fn holding<T: Scalar>(
    ///         &self,
    ///         sides: &[Side; 2],
    ///         held: &[bool; 2],
    ///         _t: T,
    ///         x: &[T; 4],
    ///     ) -> [T; 4] {
    ///         let friction = [if held[0] { 1.0 } else { 0.6 }, if held[1] { 0.9 } else { 0.54 }];
    ///         OnBelt::with(friction, sides, x)
    ///     }
    ///     fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 4]) -> [T; 2] {
    ///         [x[2] - 0.2, x[3] - 0.2]
    ///     }
    /// }
    /// let orbit = solve(&Several(OnBelt), 0.0, [0.0, 0.1, 0.2, 0.2], 20.0, &Options::default())?;
    /// assert_eq!(orbit.phases[0].mode, [Mode::Stick; 2]);
    /// println!("contact 0 sticks in {:?}", orbit.sticks_of(0));
    /// # Ok::<(), stickslip::Error>(())
    /// ```
    #[inline(always)]
    fn holding<T: Scalar>(&self, sides: &[Side; M], _held: &[bool; M], t: T, x: &[T; N]) -> [T; N] {
        self.field(sides, t, x)
    }

    /// Checks the parameters, as [`crate::Filippov::check_parameters`].
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first parameter that is not allowed.
    fn check_parameters(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Number of components of the state that move, as [`crate::Filippov::dimension`].
    #[inline(always)]
    fn dimension(&self) -> usize {
        N
    }

    /// Period of the drive, as [`crate::Filippov::period`].
    #[inline(always)]
    fn period<T: Scalar>(&self, _x: &[T; N]) -> Option<T> {
        None
    }

    /// Whether the frictions of contacts are known to add, in slip and while contacts hold. Then
    /// that need not be checked at every event.
    fn frictions_add(&self) -> bool {
        false
    }

    /// Whether [`Contacts::holding`] may differ from [`Contacts::field`]. If not, what static
    /// friction must obey need not be checked at every event.
    fn has_static_friction(&self) -> bool {
        true
    }

    /// Number of contacts that exist: the first ones. The boundary functions of those beyond, in a
    /// type with more room than the system needs, are positive constants.
    #[inline(always)]
    fn contacts(&self) -> usize {
        M
    }
}

impl<const N: usize, const M: usize, S: Contacts<N, M>> Contacts<N, M> for &S {
    const MULTI_AFFINE: bool = S::MULTI_AFFINE;
    const INTERPRETED: bool = S::INTERPRETED;

    #[inline(always)]
    fn field<T: Scalar>(&self, sides: &[Side; M], t: T, x: &[T; N]) -> [T; N] {
        (**self).field(sides, t, x)
    }
    #[inline(always)]
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; M] {
        (**self).boundaries(t, x)
    }
    #[inline(always)]
    fn holding<T: Scalar>(&self, sides: &[Side; M], held: &[bool; M], t: T, x: &[T; N]) -> [T; N] {
        (**self).holding(sides, held, t, x)
    }
    fn check_parameters(&self) -> Result<(), Error> {
        (**self).check_parameters()
    }
    #[inline(always)]
    fn dimension(&self) -> usize {
        (**self).dimension()
    }
    fn period<T: Scalar>(&self, x: &[T; N]) -> Option<T> {
        (**self).period(x)
    }
    #[inline(always)]
    fn contacts(&self) -> usize {
        (**self).contacts()
    }
    fn frictions_add(&self) -> bool {
        (**self).frictions_add()
    }
    fn has_static_friction(&self) -> bool {
        (**self).has_static_friction()
    }
}

/// A system of several contacts (1 to 64), for [`crate::solve`], [`crate::run`] and the analyses.
/// Modes are `[Mode; M]`, one for each contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Several<S>(pub S);
