//! Parameters of [`AsDynamics`](super::AsDynamics), which keep its implementations apart. No code
//! names them: they are inferred.

/// A [`Filippov`](crate::Filippov) system of `N` states.
pub struct OneContact<const N: usize>;

/// [`Several`](crate::Several) contacts: `M` of them, and `N` states.
pub struct SeveralContacts<const N: usize, const M: usize>;

/// A [`Dynamics`](super::Dynamics).
pub struct AtRunTime;

/// [`WithJumps`](super::WithJumps) of a [`Filippov`](crate::Filippov) system of `N` states.
pub struct OneContactAndJumps<const N: usize>;

/// [`WithJumps`](super::WithJumps) of [`Several`](crate::Several) contacts.
pub struct SeveralContactsAndJumps<const N: usize, const M: usize>;
