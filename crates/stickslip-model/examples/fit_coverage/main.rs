//! Whether the 95 % intervals of fits contain the truth: many records of four systems at three
//! levels of noise.
//!
//! `cargo run --release -p stickslip-model --example fit_coverage -- FOLDER [DRAWS]` writes
//! `coverage.csv` and `README.md`. `DRAWS` is the number of records in each cell.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use numerics::SplitMix;
use rayon::prelude::*;
use stickslip::{Options, math};
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::study::fit::{FitRequest, Observable, Record, Unknown, fit};
use stickslip_model::study::least_squares::Loss;

/// A system, the end of its records, what is measured, and what is fitted. The text has the truth.
struct Case {
    name: &'static str,
    text: &'static str,
    end: f64,
    observe: &'static str,
    unknowns: &'static [&'static str],
}

/// Values in a record.
const VALUES: u32 = 120;

/// Noise over the spread of the signal.
const NOISES: [f64; 3] = [0.001, 0.01, 0.05];

/// Factor of the truth at which a search begins, for parameters.
const BEGINS: f64 = 1.02;

const CASES: [Case; 4] = [
    Case {
        name: "block on a belt, falling friction",
        text: r#"name = "belt"
[states]
x = ""
v = ""
[parameters]
mu = 0.5
fall = 1.0
speed = 0.3
[contacts.belt]
boundary = "v - speed"
friction = "mu/(1 + fall*belt*(v - speed))"
[field]
x = "v"
v = "-x - friction(belt)"
[start]
x = 0.2
v = 0.9
"#,
        end: 25.0,
        observe: "x",
        unknowns: &["mu", "fall", "x"],
    },
    Case {
        name: "Stribeck with static friction",
        text: r#"name = "stribeck"
[states]
x = ""
v = ""
[parameters]
Fs = 1.0
Fk = 0.5
vs = 0.3
speed = 0.2
[contacts.belt]
boundary = "v - speed"
friction = "Fk + (0.9*Fs - Fk)*exp(-belt*(v - speed)/vs)"
static = "Fs"
[field]
x = "v"
v = "-x - 0.05*v - friction(belt)"
[start]
x = 0
v = 0.2
"#,
        end: 30.0,
        observe: "x",
        unknowns: &["Fs", "Fk", "vs"],
    },
    Case {
        name: "two masses",
        text: r#"name = "two"
[states]
x = ""
v = ""
y = ""
w = ""
[parameters]
a = 0.3
b = 0.4
k = 1.3
[contacts.left]
boundary = "v - 0.25"
friction = "a"
[contacts.right]
boundary = "w - 0.25"
friction = "b"
[field]
x = "v"
v = "-x + k*(y - x) - friction(left)"
y = "w"
w = "-y - k*(y - x) - friction(right)"
[start]
x = 0.9
v = 0
y = -0.3
w = 0.4
"#,
        end: 20.0,
        observe: "x + 0.5*y",
        unknowns: &["a", "b", "k"],
    },
    Case {
        name: "impact oscillator",
        text: r#"name = "impact"
[states]
x = ""
v = ""
[parameters]
e = 0.8
k = 2.0
c = 0.05
[jumps.wall]
when = "x - 0.6"
direction = "rising"
set = { v = "-e*v" }
[field]
x = "v"
v = "-k*x - c*v + 0.7*cos(1.9*t)"
[start]
x = 0
v = 0.3
"#,
        end: 20.0,
        observe: "x",
        unknowns: &["e", "k", "c"],
    },
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("give the folder to write to")?;
    let draws: u64 = arguments.next().map_or(Ok(1000), |draws| draws.parse())?;
    let folder = Path::new(&folder);
    let mut csv = "system,noise,records,fits,intervals,without,contained,share\n".to_owned();
    let mut rows = String::new();
    let mut levels = [(0, 0); NOISES.len()];
    for case in &CASES {
        let (times, signal) = case.exact()?;
        let mean = signal.iter().sum::<f64>() / signal.len() as f64;
        let squares: f64 = signal.iter().map(|x| (x - mean) * (x - mean)).sum();
        let spread = (squares / signal.len() as f64).sqrt();
        for (level, noise) in NOISES.into_iter().enumerate() {
            let one = |draw: u64| case.draw(&times, &signal, noise * spread, draw);
            let found: Vec<Option<[usize; 3]>> = (0..draws).into_par_iter().map(one).collect();
            let fits = found.iter().flatten().count();
            let sum = |k: usize| {
                found
                    .iter()
                    .flatten()
                    .map(|counts| counts[k])
                    .sum::<usize>()
            };
            let (intervals, without, contained) = (sum(0), sum(1), sum(2));
            let share = 100.0 * contained as f64 / intervals.max(1) as f64;
            levels[level].0 += contained;
            levels[level].1 += intervals;
            writeln!(
                csv,
                "{},{noise},{draws},{fits},{intervals},{without},{contained},{share:.2}",
                case.name.replace(',', "")
            )?;
            writeln!(
                rows,
                "| {} | {} % | {fits} | {intervals} | {without} | {share:.1} % |",
                case.name,
                100.0 * noise
            )?;
        }
    }
    let mut pooled = String::new();
    for ((contained, intervals), noise) in levels.into_iter().zip(NOISES) {
        let share = 100.0 * contained as f64 / intervals.max(1) as f64;
        writeln!(
            pooled,
            "| {} % | {intervals} | {share:.1} % |",
            100.0 * noise
        )?;
    }
    let page = format!(
        "# Coverage of the intervals of `fit`\n\nMade by `make fit-coverage` with {draws} records \
         a cell, from exact runs with normal noise.\nA record has {VALUES} values. Noise is \
         relative to the spread of the signal, and the search\nbegins 2 % off the truth. An \
         interval should contain the truth in 95 % of the fits. Fits without\nan interval, as \
         where the sequence of phases may change, are counted beside.\n\n\
         | system | noise | fits | intervals | without | contain the truth |\n\
         |---|--:|--:|--:|--:|--:|\n{rows}\n| noise | intervals | contain the truth |\n\
         |--:|--:|--:|\n{pooled}"
    );
    std::fs::write(folder.join("coverage.csv"), csv)?;
    std::fs::write(folder.join("README.md"), page)?;
    Ok(())
}

impl Case {
    fn file(&self) -> Result<SystemFile, Box<dyn Error>> {
        let (name, text) = (self.name.to_owned(), self.text.to_owned());
        Ok(SystemFile::parse(Source { name, text })?)
    }

    fn request(&self, times: &[f64], column: Vec<f64>) -> Result<FitRequest, Box<dyn Error>> {
        Ok(FitRequest {
            file: self.file()?,
            set: Vec::new(),
            extra: Vec::new(),
            observables: vec![Observable {
                name: "signal".to_owned(),
                formula: self.observe.to_owned(),
                sigma: None,
            }],
            records: vec![Record {
                name: self.name.to_owned(),
                times: times.to_vec(),
                columns: vec![column],
                set: Vec::new(),
                start: Vec::new(),
                t_start: None,
                inputs: Vec::new(),
            }],
            unknowns: Vec::new(),
            loss: Loss::Squares,
            search: 0,
            segments: 0,
            most_evaluations: 200,
            options: Options::tol(1e-9),
            interrupt: None,
        })
    }

    fn unknown(&self, name: &str, start: Option<f64>) -> Unknown {
        Unknown {
            name: name.to_owned(),
            start,
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            each: false,
        }
    }

    /// Times, and the signal without noise.
    fn exact(&self) -> Result<(Vec<f64>, Vec<f64>), Box<dyn Error>> {
        let step = self.end / f64::from(VALUES);
        let times: Vec<f64> = (1..=VALUES).map(|k| step * f64::from(k)).collect();
        // The model of a fit of an offset that belongs to nothing else.
        let mut request = self.request(&times, vec![0.0; times.len()])?;
        request.extra = vec![("none".to_owned(), 0.0)];
        request.unknowns = vec![self.unknown("none", None)];
        request.observables.push(Observable {
            name: "none".to_owned(),
            formula: "none".to_owned(),
            sigma: None,
        });
        request.records[0].columns.push(vec![0.0; times.len()]);
        let found = fit(&request)?;
        let signal = found.columns.into_iter().next().map(|column| column.model);
        Ok((times, signal.unwrap_or_default()))
    }

    /// Fits a record: intervals, values without one, and intervals that contain the truth.
    fn draw(&self, times: &[f64], signal: &[f64], sigma: f64, draw: u64) -> Option<[usize; 3]> {
        let random = &mut SplitMix::new(1 + draw);
        let normal = |random: &mut SplitMix| {
            let (u, v) = (random.between(1e-300, 1.0), random.between(0.0, 1.0));
            (-2.0 * math::ln(u)).sqrt() * math::cos(2.0 * std::f64::consts::PI * v)
        };
        let noisy = signal.iter().map(|x| x + sigma * normal(random)).collect();
        let mut request = self.request(times, noisy).ok()?;
        let system = request.file.with(&[]).ok()?;
        let truth = |name: &str| {
            let parameters = request.file.parameters.iter().zip(&system.values);
            let mut found = parameters.filter(|(one, _)| one.name == name);
            let states = request.file.states.iter().zip(&system.built.starts);
            let mut starts = states.filter(|(one, _)| one.name == name);
            let parameter = found.next().map(|(_, value)| *value);
            parameter.or_else(|| starts.next().and_then(|(_, value)| *value))
        };
        let truths: Vec<f64> = self
            .unknowns
            .iter()
            .filter_map(|name| truth(name))
            .collect();
        let unknowns = self.unknowns.iter().zip(&truths);
        request.unknowns = unknowns
            .map(|(name, truth)| self.unknown(name, Some(BEGINS * truth)))
            .collect();
        let found = fit(&request).ok()?;
        let mut counts = [0; 3];
        for (one, truth) in found.values.iter().zip(&truths) {
            match one.interval {
                None => counts[1] += 1,
                Some((low, high)) => {
                    counts[0] += 1;
                    counts[2] += usize::from((low..=high).contains(truth));
                }
            }
        }
        Some(counts)
    }
}
