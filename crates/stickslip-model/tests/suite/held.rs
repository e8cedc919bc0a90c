//! Values of parameters, periods and flags build nothing, and give what a build with them gives.

use std::sync::Arc;

use numerics::SplitMix;
use stickslip::dynamics::{DynamicsRef, Interrupt, Modes, Moment, OrbitProgress, Vector};
use stickslip::{Error, Mode, Options, Side};
use stickslip_model::file::{MOST_FREE, SettingError, System, SystemFile};
use stickslip_model::kernel::{Combination, sides_to_check};
use stickslip_model::study::ensemble::by_system;
use stickslip_model::study::{AtValue, Diagram, FrictionWatch, Locates};

use crate::hybrid::BUCK;
use crate::recorded::open;
use crate::run::{METHODS, branch, options, parsed, system};
use crate::stops_with_friction::CORNER;

/// Exponents, choices, inputs, a curve, a period and starts that depend on parameters.
const EVERYTHING: &str = r#"
name = "everything"
[states]
x = ""
v = ""
[discrete]
n = 1
[parameters]
k = 1.3
p = 2
q = 1.5
w = 2
d = 0.3
e = 0.8
mu = 0.4
fast = 0.5
[definitions]
slip = "belt*(v - 0.1*k)"
root = "atan2(k, p)*hypot(k, q) + max(k, q) - min(p, q)^q + spring(k*p)"
[curves.spring]
points = [[0, 0], [1, 1.5], [3, 2]]
beyond = "extend"
[contacts.belt]
boundary = "v - 0.1*k"
friction = "mu/(1 + slip)^p + 0*k"
static = "1.2*mu"
[inputs.push]
shape = "pulse"
period = "2*pi/w"
phase = "d/2"
width = "d"
[inputs.ramp]
shape = "sawtooth"
period = "k"
[switches.turn]
function = "sin(w*t) - e"
[jumps.wall]
when = "x - 2*q"
if = "v > fast - k"
set = { v = "-e*v", n = "if(k > 1, n + p, -n)" }
[field]
x = "v"
v = "-k*x^p - x*abs(x)^q/q - root*spring(x*k) + push*d + ramp - turn*e - friction(belt)"
[start]
x = "k/p"
v = "ln(w)"
[time]
start = "d - 0.1"
end = "10*k"
period = "2*pi/w"
"#;

/// A block between a wall and a floor, with masses and restitutions that depend on parameters.
fn corner() -> String {
    let text = CORNER.replace("e = 0.6\n", "e = 0.6\nm = 1.5\n");
    let text = text.replace("acts = { v = -1 }", "acts = { v = \"-1/m\" }");
    let text = text.replace("acts = { u = 1 }", "acts = { u = \"1/m\" }");
    let text = text.replace("restitution = 0.5", "restitution = \"e^2\"");
    let text = text.replace(
        "F*cos(w*t) - friction(sole)",
        "(F*cos(w*t) - friction(sole))/m",
    );
    text.replace("friction(side)\"", "friction(side)/m\"")
}

/// Values by which builds decide.
const SPECIAL: [f64; 9] = [0.0, 1.0, -1.0, 0.5, 2.0, 3.0, -2.0, 1.5, 1e308];

fn settings(file: &SystemFile, random: &mut SplitMix) -> Vec<(String, f64)> {
    let parameters = file.parameters.iter();
    let drawn = parameters.map(|parameter| {
        let value = match (random.uniform(), parameter.range) {
            (part, _) if part < 0.4 => parameter.value,
            (part, _) if part < 0.7 => SPECIAL[(random.uniform() * 9.0) as usize % 9],
            (_, Some((low, high))) if low.is_finite() && high.is_finite() => {
                random.between(low, high)
            }
            _ => parameter.value * random.between(0.5, 1.5),
        };
        (parameter.name.clone(), value)
    });
    drawn.collect()
}

/// Compares a system whose values were bound with one that was built with them.
fn assert_same(bound: &System, built: &System) {
    let (ones, others) = (&bound.built, &built.built);
    let numbers = |of: &System| {
        let (starts, times) = (of.built.starts.clone(), [of.built.t_start]);
        let all = starts.into_iter().chain(times.map(Some));
        let all = all.chain([of.built.t_end, of.built.period]);
        all.map(|one| one.map(f64::to_bits)).collect::<Vec<_>>()
    };
    assert_eq!(numbers(bound), numbers(built));
    for above in sides_to_check(bound.contacts()) {
        for held in 0..1 << bound.contacts() {
            let of = Combination { above, held };
            assert_eq!(ones.fields.tape(of), others.fields.tape(of));
        }
    }
    assert_eq!(ones.boundaries, others.boundaries);
    assert_eq!(ones.normal_force, others.normal_force);
    assert_eq!(ones.sections, others.sections);
    assert_eq!(ones.switching, others.switching);
    let decided = |of: &System| {
        let built = &of.built;
        [built.has_static, built.frictions_add, built.depends_on_time]
    };
    assert_eq!(decided(bound), decided(built));
}

/// A system without contacts has one field, whichever side is asked for, also with other values.
#[test]
fn a_system_without_contacts_has_the_field_of_both_sides() {
    let text = "name = \"free\"\n[states]\nx = \"\"\n[parameters]\na = 2\n[field]\nx = \"-a*x\"\n";
    let base = system(text);
    for (system, rate) in [
        (base.with_values(&[("a", 3.0)]).unwrap(), -3.0),
        (base, -2.0),
    ] {
        for above in [0, 1] {
            let of = Combination { above, held: 0 };
            assert_eq!(system.field(of, 0.0, &[1.0]), [rate]);
        }
    }
}

/// The tapes, numbers and errors for other values are those of a build with these values, by every
/// bit.
#[test]
fn values_give_what_a_build_with_them_gives() {
    let shipped = ["belt", "forced", "bracket", "leine", "basins", "den-hartog"];
    let shipped = shipped.map(|name| SystemFile::open(name).unwrap());
    let texts = [EVERYTHING, &corner()].map(parsed);
    let random = &mut SplitMix::new(7);
    for file in shipped.iter().chain(&texts) {
        let base = file.with(&[]).unwrap();
        let (mut good, mut bad) = (0, 0);
        for _ in 0..150 {
            let settings = settings(file, random);
            let pairs: Vec<(&str, f64)> = settings.iter().map(|(k, v)| (&**k, *v)).collect();
            // A file that is not the same shares no build.
            let mut fresh = file.clone();
            fresh.description = Some("another file".to_owned());
            match (base.with_values(&pairs), fresh.with(&settings)) {
                (Ok(bound), Ok(built)) => {
                    assert_eq!(built.builds(), 1);
                    assert_same(&bound, &built);
                    good += 1;
                }
                (Err(bound), Err(built)) => {
                    assert_eq!(bound.to_string(), built.to_string());
                    bad += 1;
                }
                _ => panic!("{}: {settings:?}", file.name),
            }
        }
        assert!(good > 10, "{}: {good} systems, {bad} errors", file.name);
    }
}

/// Other values share one build, except those by which it is decided.
#[test]
fn values_by_which_nothing_is_decided_share_a_build() {
    for text in [EVERYTHING, &corner()] {
        let system = system(text);
        for parameter in &system.file.parameters {
            for k in 0..20 {
                let value = parameter.value * (1.003 + 0.001 * f64::from(k));
                let there = system.with_values(&[(&parameter.name, value)]).unwrap();
                assert_eq!(there.builds(), system.builds());
            }
        }
        // Exponents cease to be integers.
        assert!(system.builds() < 6, "{}", system.builds());
    }
    let system = system(EVERYTHING);
    for (k, value) in [(1, 1.0), (2, 0.0), (2, 1.0), (2, 0.0)] {
        system.with_values(&[("e", value)]).unwrap();
        assert_eq!(system.builds(), 1 + k, "{value}");
    }
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn described(error: &Error, _: &System) -> String {
    error.to_string()
}

/// Changes are located along the parameter as a state, which is another build.
#[test]
fn no_value_of_a_diagram_builds_its_system() {
    for (locates, builds) in [(Locates::Nothing, 1), (Locates::default(), 2)] {
        let system = open("belt");
        let options = options("taylor");
        let diagram = Diagram {
            system: &system,
            parameter: "vp",
            until: 400.0,
            duration: None,
            locates,
            values: 200,
            options: &options,
        };
        let mut last: Option<AtValue> = None;
        for k in 0..200 {
            let start = |here: &System| Ok::<_, Failure>(here.start().unwrap());
            let value = 0.15 + 0.0005 * f64::from(k);
            let found = diagram.at(value, last.as_ref(), start, &described);
            let (at, changes) = found.unwrap();
            assert!(
                changes.is_empty() && at.reached.kind.is_attractor(),
                "{value}"
            );
            last = Some(at);
        }
        assert_eq!(system.builds(), builds);
    }
}

#[test]
fn maps_ensembles_branches_and_flags_build_nothing() {
    let system = open("belt");
    let pair =
        |x: f64, y: f64| system.with_values(&[("mu0", 0.3 + 0.001 * x), ("vp", 0.2 + 0.001 * y)]);
    for (x, y) in (0..20).flat_map(|x| (0..20).map(move |y| (x, y))) {
        pair(f64::from(x), f64::from(y)).unwrap();
    }
    let values: Vec<Vec<f64>> = (0..300).map(|k| vec![0.2 + 0.001 * f64::from(k)]).collect();
    let block = |here: Result<&System, SettingError>, numbers: &[usize]| {
        let here = here.unwrap();
        numbers.iter().map(|_| here.values.clone()).collect()
    };
    let followed: Vec<Vec<f64>> = by_system(&system, &["vp".to_owned()], &values, block);
    assert_eq!(followed.len(), 300);
    let flagged = system.interrupted_by(Arc::default()).unwrap();
    let flag = Arc::new(Interrupt::default());
    pair(3.3, 4.4).unwrap().interrupted_by(flag).unwrap();
    assert_eq!((system.builds(), flagged.builds()), (1, 1));
    // The check of a file is its build.
    let set = [("vp".to_owned(), 0.4)];
    assert_eq!(system.file.with(&set).unwrap().builds(), 1);
    // A branch has the parameter as a state, which is another build.
    let found = branch(&system, ("vp", 0.9, 1.1), &options("taylor"));
    assert!(found.points.len() > 5, "{}", found.points.len());
    system
        .with_states_of(&[system.file.parameter("vp").unwrap()])
        .unwrap();
    assert_eq!(system.builds(), 2);
}

#[test]
fn a_period_is_read_without_a_build() {
    let system = system(EVERYTHING);
    for w in [2.5, 1.1, 7.0] {
        let period = system.with_values(&[("w", w)]).unwrap().built.period;
        assert!((period.unwrap() - 2.0 * std::f64::consts::PI / w).abs() < 1e-15);
    }
    assert_eq!(system.builds(), 1);
}

/// Times and first states at all reports of a run.
fn reports(
    system: &DynamicsRef<'_>,
    (start, t_end): (&Moment, f64),
    states: usize,
    options: &Options,
) -> Vec<(f64, Vec<f64>)> {
    let mut reports = Vec::new();
    let mut run = system.begin(start, t_end, options, &[]).unwrap();
    loop {
        let progress = run.step();
        reports.push((run.t(), run.x()[..states].to_vec()));
        if let Ok(OrbitProgress::End(_)) | Err(_) = progress {
            return reports;
        }
    }
}

/// Where an orbit with parameters among its states is not the orbit with their values, bit for bit.
fn differences(
    system: &System,
    free: &[usize],
    ((t, x), t_end): ((f64, &[f64]), f64),
) -> Vec<String> {
    let along = system.with_states_of(free).unwrap();
    let at = |parameters: &[usize]| {
        let values = parameters.iter().map(|&number| system.values[number]);
        let x = Vector::from_vec(x.iter().copied().chain(values).collect());
        Moment { t, x }
    };
    let difference = |method: &&str| {
        let of = |dynamics, start: &Moment| {
            let options = options(method);
            reports(dynamics, (start, t_end), x.len(), &options)
        };
        let (alone, within) = (of(system.dynamics(), &at(&[])), of(&along, &at(free)));
        assert!(alone.len() > 10, "{}", alone.len());
        let first = (0..alone.len()).find(|&k| alone.get(k) != within.get(k))?;
        let [one, other] = [&alone, &within].map(|all| all.get(first));
        let name = &system.file.name;
        Some(format!(
            "{name} {free:?} {method} {first}: {one:?} {other:?}"
        ))
    };
    METHODS.iter().filter_map(difference).collect()
}

#[test]
fn an_orbit_beside_free_parameters_has_the_bits_of_the_orbit_alone() {
    let corner = corner();
    let given = [EVERYTHING, &corner, BUCK].map(system);
    let shipped = ["belt", "forced", "bracket", "leine", "basins", "den-hartog"].map(open);
    let mut all = Vec::new();
    for system in given.iter().chain(&shipped) {
        // A power has another formula where its exponent is free.
        let is_exponent = |number: usize| {
            let name = &*system.file.parameters[number].name;
            system.file.name == "everything" && ["p", "q"].contains(&name)
        };
        let free: Vec<usize> = (0..system.values.len())
            .filter(|&number| !is_exponent(number))
            .collect();
        let many = free[..free.len().min(MOST_FREE)].to_vec();
        for free in free.iter().map(|&number| vec![number]).chain([many]) {
            let start = (system.built.t_start, &*system.start().unwrap());
            let t_end = system.built.t_end.unwrap_or(20.0).min(20.0);
            all.extend(differences(system, &free, (start, t_end)));
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn an_orbit_of_a_branch_has_the_bits_of_the_orbit_alone() {
    for (file, range) in [
        ("belt", ("vp", 0.9, 1.1)),
        ("den-hartog", ("O", 0.6, 0.8)),
        ("den-hartog", ("S", 0.1, 0.3)),
    ] {
        let system = open(file);
        let found = branch(&system, range, &options("taylor"));
        for point in found.points.iter().step_by(5) {
            let orbit = &point.orbit;
            let here = system.with_values(&[(range.0, orbit.parameter)]).unwrap();
            let free = here.file.parameter(range.0).unwrap();
            let start = (orbit.t, orbit.x.as_slice());
            let all = differences(&here, &[free], (start, orbit.t + orbit.period));
            assert!(all.is_empty(), "{}", all.join("\n"));
        }
    }
}

/// A gap's rate has a factor on each side of a contact. It is one rate while the two are equal.
#[test]
fn factors_that_are_equal_are_one_as_long_as_they_are() {
    let text = r#"
name = "sides"
[states]
x = ""
v = ""
u = ""
[parameters]
a = 2
b = 2
[contacts.belt]
boundary = "u - 0.3"
friction = 0.1
[stops.wall]
gap = "x"
acts = { v = 1 }
restitution = 0.5
[field]
x = "by_side(belt, a, b)*v"
v = "-1"
u = "-u - friction(belt)"
"#;
    let system = system(text);
    let error = |a: f64, b: f64| system.with_values(&[("a", a), ("b", b)]).err();
    assert!(error(3.0, 3.0).is_none());
    assert_eq!(system.builds(), 1);
    let error = error(3.0, 4.0).unwrap().to_string();
    assert!(
        error.contains("depends on the side of a contact"),
        "{error}"
    );
}

/// Friction laws, reactions and formulas beside a system are built once for all of its values.
#[test]
fn what_is_observed_is_built_once() {
    let system = system(&corner());
    let observed = [("power", "m*wall.force*v"), ("height", "y/m")];
    let modes = Modes::new(&[Mode::Slip(Side::Below), Mode::Slip(Side::Above)]);
    let mut builds = Vec::new();
    for k in 0..10 {
        let m = 1.1 + 0.1 * f64::from(k);
        let here = system.with_values(&[("m", m)]).unwrap();
        let (x, closed) = ([0.5, 0.0, 0.0, 0.0], [1.0, 1.0]);
        let x = [&x[..], &closed[..]].concat();
        let values = here.quantities(&observed).unwrap().at(&modes, 0.0, &x);
        // The wall carries the drive, and the floor the weight, of a mass each.
        let wanted = [0.5, m];
        assert!((values[0] - wanted[0]).abs() < 1e-12, "{values:?}");
        assert!((values[1] - wanted[1]).abs() < 1e-12, "{values:?}");
        assert_eq!(values[3], 0.0);
        let formula = here.observed("x*F", &[0]).unwrap();
        assert_eq!(formula.value(modes, 0.0, &[&x[..], &[3.0]].concat()), 1.5);
        let mut watch = FrictionWatch::new(&here);
        let x = Vector::from_column_slice(&[0.0, 1.0, 0.2, 0.1, 0.0, 0.0]);
        let from = &Moment { t: 0.0, x };
        let mut orbit = here
            .dynamics()
            .begin(from, 0.5, &options("dop853"), &[])
            .unwrap();
        while !matches!(orbit.step().unwrap(), OrbitProgress::End(_)) {
            watch.step(&mut *orbit);
        }
        builds.push(system.builds());
    }
    assert!(builds[0] > 5 && builds[1..] == builds[..9], "{builds:?}");
}
