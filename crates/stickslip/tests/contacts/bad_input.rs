//! Invalid systems of contacts give an error with the reason.

use stickslip::error::ContactFault;
use stickslip::{Contacts, Ending, Error, Method, Options, Scalar, Several, Side, solve};

use super::references::stacked;
use super::two_states::TwoStates;
use crate::fault;

/// Two bodies with contacts that depend on the case.
pub struct InvalidContacts(Case);

#[derive(Clone, Copy)]
pub enum Case {
    /// Both boundaries are equal.
    Coincide,
    /// The gradient of the second boundary function vanishes.
    Flat,
    /// The second boundary function is NaN.
    Undefined,
    /// The second boundary function becomes NaN on the orbit.
    Ends,
    /// Friction drives the second contact apart.
    Repels,
    /// The friction that holds one contact also brakes the other.
    HoldsAll,
    /// A parameter is not allowed.
    Refused,
}

impl Contacts<2, 2> for InvalidContacts {
    fn field<T: Scalar>(&self, sides: &[Side; 2], _t: T, _x: &[T; 2]) -> [T; 2] {
        let second = match self.0 {
            Case::Repels => -1.0,
            _ => 1.0,
        };
        [
            T::constant(-sides[0].sign()),
            T::constant(-second * sides[1].sign()),
        ]
    }
    fn boundaries<T: Scalar>(&self, _t: T, x: &[T; 2]) -> [T; 2] {
        let second = match self.0 {
            Case::Coincide => x[0] * 2.0,
            Case::Flat => x[1] * x[1],
            Case::Undefined => x[1].ln(),
            Case::Ends => x[1].sqrt() + 1.0,
            Case::Repels | Case::HoldsAll | Case::Refused => x[1],
        };
        [x[0], second]
    }
    fn holding<T: Scalar>(&self, sides: &[Side; 2], _held: &[bool; 2], t: T, x: &[T; 2]) -> [T; 2] {
        let factor = if let Case::HoldsAll = self.0 {
            2.0
        } else {
            1.0
        };
        self.field(sides, t, x).map(|rate| rate * factor)
    }
    fn check_parameters(&self) -> Result<(), Error> {
        match self.0 {
            Case::Refused => Err(Error::Parameter {
                name: "case",
                value: 4.0,
                bound: "another one",
            }),
            _ => Ok(()),
        }
    }
}

fn error(case: Case, start: [f64; 2]) -> Error {
    let failure = solve(
        &Several(TwoStates::Invalid(InvalidContacts(case))),
        0.0,
        start,
        2.0,
        &Options::default(),
    )
    .unwrap_err();
    assert_eq!(failure.partial.ending, Ending::Failed);
    failure.error
}

#[test]
fn what_is_no_contact_is_reported() {
    let dependent = error(Case::Coincide, [1.0, 1.0]);
    assert!(
        fault(&dependent)
            == &ContactFault::DependentContacts {
                contacts: vec![0, 1]
            },
        "{dependent}"
    );
    let flat = error(Case::Flat, [1.0, 0.0]);
    assert!(
        fault(&flat) == &ContactFault::DependentContacts { contacts: vec![1] },
        "{flat}"
    );
    let undefined = error(Case::Undefined, [1.0, -1.0]);
    assert!(
        matches!(undefined, Error::StartOutsideDomain { .. }),
        "{undefined}"
    );
    assert!(matches!(
        error(Case::Refused, [1.0, 1.0]),
        Error::Parameter { .. }
    ));
    assert!(matches!(
        error(Case::Repels, [1.0, f64::NAN]),
        Error::StartOutsideDomain { .. }
    ));
}

#[test]
fn a_boundary_that_ends_on_the_way_ends_the_run_there() {
    for options in [
        Options::tol(1e-10),
        Options::tol(1e-10).method(Method::Taylor),
    ] {
        let system = Several(TwoStates::Invalid(InvalidContacts(Case::Ends)));
        let failure = solve(&system, 0.0, [1.5, 0.5], 1.0, &options).unwrap_err();
        let Error::StepCollapse { ref x, .. } = failure.error else {
            panic!("{}", failure.error);
        };
        assert!(x.0[1].abs() < 1e-8 && (x.0[0] - 1.0).abs() < 1e-8, "{x}");
    }
}

#[test]
fn a_future_that_is_not_unique_is_reported_with_what_it_could_be() {
    let repels = error(Case::Repels, [0.0, 0.0]);
    let ContactFault::NoUniqueMode {
        contacts,
        candidates,
    } = fault(&repels)
    else {
        panic!("{repels}");
    };
    assert_eq!((&contacts[..], candidates.len()), (&[0, 1][..], 3));
    assert!(repels.to_string().contains("3 motions"), "{repels}");
}

#[test]
fn static_friction_at_a_contact_that_slips_is_reported() {
    let elsewhere = error(Case::HoldsAll, [0.0, 1.0]);
    assert!(
        fault(&elsewhere)
            == &ContactFault::HoldsElsewhere {
                held: 0,
                slipping: 1
            },
        "{elsewhere}"
    );
}

#[test]
fn static_friction_below_the_kinetic_is_reported_with_the_contact() {
    let mut rig = stacked();
    rig.ratio = 0.5;
    let failure = solve(&Several(&rig), 0.0, [0.0; 6], 5.0, &Options::default()).unwrap_err();
    assert!(
        matches!(
            fault(&failure.error),
            ContactFault::StaticBelowKinetic { contact: 0, ratio } if (ratio - 0.5).abs() < 1e-12
        ),
        "{failure}"
    );
}
