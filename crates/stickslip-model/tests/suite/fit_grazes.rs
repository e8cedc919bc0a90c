//! Fits across grazing impacts, where residuals have a square root.

use stickslip_model::file::SystemFile;
use stickslip_model::study::fit::{Fit, fit};

use super::fit::{exact, noisy, observable, record, request, times, unknown};
use super::run::parsed;

/// A driven oscillator that touches a wall at amplitudes of the drive from 0.1058 on.
const WALL: &str = r#"
name = "wall"
[states]
x = ""
v = ""
[parameters]
A = 0.11
[jumps.wall]
when = "x - 1"
direction = "rising"
set = { v = "-0.8*v" }
[field]
x = "v"
v = "A*cos(t) - 0.1*v - x"
[start]
x = 0
v = 0
"#;

fn fitted(file: &SystemFile, name: &str, (start, truth): (f64, f64), times: &[f64]) -> Fit {
    let old = format!("{name} = {truth}\n");
    assert!(file.source.text.contains(&old));
    let columns = exact(file, &["x"], times);
    let unknowns = vec![unknown(name, Some(start))];
    let mut request = request(file.clone(), unknowns, vec![observable("x", Some(0.003))]);
    request
        .records
        .push(record(times, noisy(&columns, 0.003, 1)));
    let found = fit(&request).unwrap();
    assert!(
        (found.values[0].value - truth).abs() < 1e-2 * truth,
        "{:?}",
        found.values
    );
    found
}

#[test]
fn grazing_impacts_on_the_way_are_told() {
    let found = fitted(&parsed(WALL), "A", (0.105, 0.11), &times(240, 0.25));
    let impacts = found.phases[0].iter().filter(|one| one.2.jump().is_some());
    assert_eq!((impacts.count(), found.grazes), (2, Some(2)));
    assert!(found.crossings > 0);
}

/// A bounce that comes into the record at its end has a speed.
#[test]
fn an_impact_that_passes_the_end_of_the_record_is_no_graze() {
    let ball = parsed(
        "name = \"ball\"\n[states]\nx = \"\"\nw = \"\"\n[parameters]\ng = 10\n\
         [jumps.b]\nwhen = \"x\"\ndirection = \"falling\"\nset = { w = \"-0.8*w\" }\n\
         [field]\nx = \"w\"\nw = \"-g\"\n[start]\nx = 5\nw = 0\n",
    );
    // The first bounce is at 1 with the true value, and behind the last time at the start.
    let found = fitted(&ball, "g", (8.5, 10.0), &times(21, 0.05));
    assert!(found.crossings > 0 && found.grazes == Some(0), "{found:?}");
}
