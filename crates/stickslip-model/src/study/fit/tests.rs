//! Derivatives of residuals against differences of runs.

use stickslip::Options;
use stickslip::analysis::Loss;
use stickslip::error::readable;

use super::problem::FitProblem;
use super::*;
use crate::file::Source;

/// A block on a belt. Starts and the start time are formulas of a parameter, and so is the period
/// of the drive. The record has an offset and a gain.
const BELT: &str = r#"
name = "case"
[time]
start = "0.1*mu"
[states]
x = ""
v = ""
[parameters]
mu = 0.5
more = 0.2
speed = 0.3
T = 3.1
[inputs.push]
shape = "triangle"
period = "T"
[contacts.belt]
boundary = "v - speed"
friction = "mu/(1 + belt*(v - speed))"
static = "mu + more"
[field]
x = "v"
v = "-x + 0.9*push - friction(belt)"
[start]
x = "0.4*mu"
v = 0.9
"#;

fn request(unknowns: &[&str]) -> FitRequest {
    let (name, text) = ("system.toml".to_owned(), BELT.to_owned());
    let times: Vec<f64> = (0..30).map(|k| 0.31 + 0.37 * f64::from(k)).collect();
    let column: Vec<f64> = times
        .iter()
        .map(|t| if *t > 5.0 { 0.2 } else { f64::NAN })
        .collect();
    let record = |t_start, set: &[(String, f64)]| Record {
        name: "record".to_owned(),
        times: times.clone(),
        columns: vec![vec![0.1; 30], column.clone()],
        set: set.to_vec(),
        start: Vec::new(),
        t_start,
    };
    let observable = |name: &str, formula: &str, sigma| Observable {
        name: name.to_owned(),
        formula: formula.to_owned(),
        sigma: Some(sigma),
    };
    FitRequest {
        file: SystemFile::parse(Source { name, text }).unwrap(),
        set: Vec::new(),
        extra: vec![("gain".to_owned(), 1.2), ("off".to_owned(), 0.1)],
        observables: vec![
            observable("x", "gain*x + off*speed", 0.1),
            observable("force", "x*x + push + sin(v)", 2.0),
        ],
        records: vec![
            record(None, &[]),
            record(Some(0.2), &[("more".to_owned(), 0.3)]),
        ],
        unknowns: unknowns
            .iter()
            .map(|name| Unknown {
                name: (*name).to_owned(),
                start: None,
                bounds: (f64::NEG_INFINITY, f64::INFINITY),
                each: *name == "off",
            })
            .collect(),
        loss: Loss::Squares,
        search: 0,
        segments: 0,
        most_evaluations: 100,
        options: Options::tol(1e-12),
        interrupt: None,
    }
}

#[test]
fn derivatives_of_residuals_are_differences_of_runs() {
    const STEP: f64 = 1e-5;
    let names: [&[&str]; 2] = [
        &["mu", "speed", "T", "gain", "off"],
        &["mu", "x", "v", "t0", "gain"],
    ];
    for names in names {
        let request = request(names);
        let problem = FitProblem::new(&request).unwrap();
        let x = problem.unknowns.start();
        let Ok(at) = problem.modelled(&x) else {
            panic!("the run fails");
        };
        assert!(at.lost.is_none(), "{:?}", at.lost);
        // Starts and offsets are separate in both records.
        let shared = names
            .iter()
            .filter(|name| !["x", "v", "t0", "off"].contains(name));
        assert_eq!(x.len(), 2 * names.len() - shared.count());
        for k in 0..x.len() {
            let residuals = |by: f64| {
                let mut x = x.clone();
                x[k] += by * STEP;
                let Ok(at) = problem.modelled(&x) else {
                    panic!("the run fails");
                };
                at.residuals
            };
            let difference = ((residuals(1.0) - residuals(-1.0)) * 8.0
                - (residuals(2.0) - residuals(-2.0)))
                / (12.0 * STEP);
            let off = (&difference - at.jacobian.column(k)).amax();
            let size = difference.amax();
            assert!(size > 1e-3, "{}", problem.unknowns.name(k));
            assert!(
                off < 3e-6 * (1.0 + size),
                "{}: {off} of {size}",
                problem.unknowns.name(k)
            );
        }
    }
}

#[test]
fn records_and_parts_share_a_build() {
    let builds = |records: u32| {
        let mut request = request(&["mu", "x"]);
        for k in 0..records {
            let mut record = request.records[1].clone();
            record.set = vec![("more".to_owned(), 0.31 + 0.01 * f64::from(k))];
            request.records.push(record);
        }
        let problem = FitProblem::new(&request).unwrap();
        problem.in_parts(&problem.unknowns.start(), 3).unwrap();
        problem.base.builds()
    };
    // One with the parameter that is fitted, one without, and those of observables and starts.
    let few = builds(0);
    assert!((2..10).contains(&few), "{few}");
    assert_eq!(builds(20), few);
}

#[test]
fn a_part_without_a_run_is_named() {
    // From 10 on the state escapes within a tenth of the time unit.
    let text = "name = \"case\"\n[states]\nx = \"\"\n[parameters]\na = 1\n[field]\n\
                x = \"-a*x + 0.1*x*x\"\n[start]\nx = 1\n";
    let (name, text) = ("system.toml".to_owned(), text.to_owned());
    let mut request = request(&["a"]);
    request.file = SystemFile::parse(Source { name, text }).unwrap();
    request.extra.clear();
    request.observables = vec![Observable {
        name: "x".to_owned(),
        formula: "x".to_owned(),
        sigma: Some(0.1),
    }];
    request.records.truncate(1);
    request.records[0].columns.truncate(1);
    request.segments = 3;
    let problem = FitProblem::new(&request).unwrap();
    let (parts, mut x) = problem.in_parts(&problem.unknowns.start(), 3).unwrap();
    let mut work = FitWork::of_at_most(20);
    assert!(shooting::matched(&parts, &x, &mut work).is_ok());
    let last = x.len() - 1;
    x[last] = 1e6;
    let Err(error) = shooting::matched(&parts, &x, &mut work) else {
        panic!("the last part runs");
    };
    let FitError::Part { part, cause } = &error else {
        panic!("{error}");
    };
    let times = &request.records[0].times;
    let [from, to] = [times[19], times[29]].map(readable);
    assert_eq!(*part, format!("record: the part from {from} to {to}"));
    assert!(cause.is_some());
    assert!(error.to_string().contains("another number of segments"));
}
