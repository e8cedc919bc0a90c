//! Records with inputs of their own.

use stickslip_model::study::fit::{Record, fit};

use super::fit::{exact, observable, record, request, times, unknown};
use super::run::parsed;

const TIMES: &str = "[0, 3, 6, 20]";
const VALUES: &str = "[0, 1, -1, 0.5]";

/// A driven oscillator whose input has a table with these words.
fn driven(times: &str, values: &str, more: &str) -> String {
    format!(
        "name = \"driven\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 1\nc = 0.2\n\
         [inputs.u]\nshape = \"table\"\ntimes = {times}\nvalues = {values}\n{more}\n\
         [inputs.saw]\nshape = \"sawtooth\"\nperiod = \"2\"\n\
         [field]\nx = \"v\"\nv = \"u - c*v - k*x\"\n[start]\nx = 0.1\nv = 0\n"
    )
}

fn own_input(times: &[f64], columns: Vec<Vec<f64>>, points: (&[f64], &[f64])) -> Record {
    Record {
        inputs: vec![("u".to_owned(), points.0.to_vec(), points.1.to_vec())],
        ..record(times, columns)
    }
}

/// Two records with two inputs give back the parameters, with lines between the points and with
/// constant values.
#[test]
fn each_record_has_its_own_input() {
    let times = times(60, 0.3);
    for more in ["", "between = \"constant\""] {
        let file = parsed(&driven(TIMES, VALUES, more));
        let other = parsed(&driven("[0, 1, 1, 20]", "[2, -1, 0.5, 0]", more));
        let [first, second] = [&file, &other].map(|file| exact(file, &["x"], &times));
        let own = own_input(
            &times,
            second.clone(),
            (&[0.0, 1.0, 1.0, 20.0], &[2.0, -1.0, 0.5, 0.0]),
        );
        let fitted = |second: Record| {
            let unknowns = vec![unknown("k", Some(1.2)), unknown("c", Some(0.3))];
            let mut request = request(file.clone(), unknowns, vec![observable("x", Some(1e-3))]);
            request.records = vec![record(&times, first.clone()), second];
            fit(&request).unwrap()
        };
        let found = fitted(own);
        for (one, truth) in found.values.iter().zip([1.0, 0.2]) {
            assert!((one.value - truth).abs() < 1e-8, "{more}: {one:?}");
        }
        let without = fitted(record(&times, second));
        assert!(without.cost > 1e3, "{more}: {}", without.cost);
    }
}

/// Parts of a record have its input, too.
#[test]
fn parts_have_the_input_of_their_record() {
    let times = times(60, 0.3);
    let other = parsed(&driven("[0, 1, 20]", "[2, -1, 0]", ""));
    let columns = exact(&other, &["x"], &times);
    let unknowns = vec![unknown("k", Some(1.2)), unknown("c", Some(0.3))];
    let file = parsed(&driven(TIMES, VALUES, ""));
    let mut request = request(file, unknowns, vec![observable("x", Some(1e-3))]);
    request.segments = 3;
    let own = own_input(&times, columns, (&[0.0, 1.0, 20.0], &[2.0, -1.0, 0.0]));
    request.records.push(own);
    let found = fit(&request).unwrap();
    assert!(
        (found.values[0].value - 1.0).abs() < 1e-6,
        "{:?}",
        found.values
    );
    assert!(found.mismatch.is_none());
}

#[test]
fn wrong_inputs_of_a_record_are_told_with_the_remedy() {
    let rows = times(60, 0.3);
    let refused = |name: &str, times: &[f64], values: &[f64]| {
        let file = parsed(&driven(TIMES, VALUES, ""));
        let mut request = request(file, vec![unknown("k", None)], vec![observable("x", None)]);
        request.records.push(Record {
            inputs: vec![(name.to_owned(), times.to_vec(), values.to_vec())],
            ..record(&rows, vec![vec![0.0; rows.len()]])
        });
        fit(&request).expect_err("it is refused").to_string()
    };
    for (name, times, values, said) in [
        (
            "w",
            vec![0.0, 20.0],
            vec![0.0, 1.0],
            "there is no input `w`",
        ),
        (
            "k",
            vec![0.0, 20.0],
            vec![0.0, 1.0],
            "there is no input `k`",
        ),
        (
            "saw",
            vec![0.0, 20.0],
            vec![0.0, 1.0],
            "the input `saw` is no table",
        ),
        ("u", vec![0.0, 20.0], vec![0.0], "2 times and 1 values"),
        ("u", vec![0.0], vec![0.0], "a table of 1 points"),
        (
            "u",
            vec![1.0, 0.0],
            vec![0.0, 1.0],
            "the times are not in order",
        ),
        (
            "u",
            vec![0.0, 20.0],
            vec![0.0, f64::NAN],
            "a point of the table has NaN",
        ),
        (
            "u",
            vec![0.0, 5.0],
            vec![0.0, 1.0],
            "record: the run from 0 to 18",
        ),
    ] {
        let told = refused(name, &times, &values);
        assert!(told.contains(said), "{told}");
    }
}
