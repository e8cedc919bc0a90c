//! Periodic orbits that are not isolated, in the words of the program.

use predicates::str::contains;

use crate::public_cases::{program, results};

/// Without damping every swing has its own period: a family over the energy.
const PENDULUM: &str = include_str!("../../../stickslip-model/tests/data/pendulum.toml");

#[test]
fn a_family_is_named_with_its_dimension() {
    let one_of = "one of a family of periodic orbits of dimension 1";
    let orbit = ["orbit", "system.toml"];
    let basin = ["basin", "system.toml", "--grid", "2x1", "--tol", "1e-10"];
    let along = ["continue", "system.toml", "--parameter", "g=0.9:1.1"];
    for (arguments, words) in [
        (&orbit[..], one_of.to_owned()),
        (&basin[..], format!("{one_of}, here the one through (")),
        (&along[..], format!("it is {one_of}; at each value")),
    ] {
        let (_top, mut command) = program(PENDULUM);
        command.args(arguments);
        command.assert().success().stdout(contains(words));
    }
    assert_eq!(results(PENDULUM, &orbit)["family_dimension"], 1);
    let found = results(PENDULUM, &basin);
    assert_eq!(found["attractors"][0]["family_dimension"], 1);
}
