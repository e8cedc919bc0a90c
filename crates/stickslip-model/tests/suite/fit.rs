//! Parameters fitted to records of exact runs.

use numerics::SplitMix;
use stickslip::Options;
use stickslip::dynamics::{Matrix, Vector};
use stickslip::math;
use stickslip_model::file::SystemFile;
use stickslip_model::study::fit::{Fit, FitError, FitRequest, Observable, Record, Unknown, fit};
use stickslip_model::study::least_squares::{LeastSquaresEnd, Loss};

use super::run::{options, parsed};

/// A block on a belt, with friction that falls with the speed.
const BELT: &str = r#"
name = "case"
[states]
x = ""
v = ""
[parameters]
mu = 0.5
fall = 1
speed = 0.3
k = 1
idle = 1
[contacts.belt]
boundary = "v - speed"
friction = "mu/(1 + fall*belt*(v - speed))"
[field]
x = "v"
v = "-k*x - friction(belt)"
[start]
x = 0.2
v = 0.9
"#;

pub fn observable(formula: &str, sigma: Option<f64>) -> Observable {
    Observable {
        name: formula.to_owned(),
        formula: formula.to_owned(),
        sigma,
    }
}

pub fn unknown(name: &str, start: Option<f64>) -> Unknown {
    Unknown {
        name: name.to_owned(),
        start,
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        each: false,
    }
}

pub fn request(
    file: SystemFile,
    unknowns: Vec<Unknown>,
    observables: Vec<Observable>,
) -> FitRequest {
    FitRequest {
        file,
        set: Vec::new(),
        extra: Vec::new(),
        observables,
        records: Vec::new(),
        unknowns,
        loss: Loss::Squares,
        search: 0,
        segments: 0,
        most_evaluations: 200,
        options: options("taylor"),
        interrupt: None,
    }
}

/// Values of formulas along the run of a file at times, which a fit of nothing else reports.
pub fn exact(file: &SystemFile, formulas: &[&str], times: &[f64]) -> Vec<Vec<f64>> {
    let observables = formulas.iter().map(|one| observable(one, None)).collect();
    let free = vec![Unknown {
        bounds: (-1.0, 1.0),
        ..unknown("none", Some(0.5))
    }];
    let mut request = request(file.clone(), free, observables);
    // With one unknown that acts on an added column alone, the model is the run itself.
    request.extra = vec![("none".to_owned(), 0.5)];
    request.observables.push(observable("none", None));
    let columns = vec![vec![0.0; times.len()]; formulas.len() + 1];
    request.records.push(record(times, columns));
    let found = fit(&request).unwrap_or_else(|error| panic!("{error}"));
    let columns = found.columns.into_iter().map(|column| column.model);
    columns.take(formulas.len()).collect()
}

pub fn record(times: &[f64], columns: Vec<Vec<f64>>) -> Record {
    Record {
        name: "record".to_owned(),
        times: times.to_vec(),
        columns,
        set: Vec::new(),
        start: Vec::new(),
        t_start: None,
        inputs: Vec::new(),
    }
}

pub fn times(count: u32, step: f64) -> Vec<f64> {
    (1..=count).map(|k| step * f64::from(k)).collect()
}

/// A normal deviate (Box and Muller).
fn normal(random: &mut SplitMix) -> f64 {
    let (u, v) = (random.between(1e-300, 1.0), random.between(0.0, 1.0));
    (-2.0 * math::ln(u)).sqrt() * math::cos(2.0 * std::f64::consts::PI * v)
}

pub fn noisy(columns: &[Vec<f64>], sigma: f64, seed: u64) -> Vec<Vec<f64>> {
    let random = &mut SplitMix::new(seed);
    let noisy = |column: &Vec<f64>| column.iter().map(|x| x + sigma * normal(random)).collect();
    columns.iter().map(noisy).collect()
}

fn value(found: &Fit, name: &str) -> f64 {
    found
        .values
        .iter()
        .find(|one| one.name == name)
        .unwrap()
        .value
}

fn refused(request: &FitRequest) -> String {
    fit(request).expect_err("it is refused").to_string()
}

#[test]
fn an_exact_record_gives_back_what_made_it() {
    let file = parsed(BELT);
    let times = times(80, 0.31);
    let columns = exact(&file, &["x", "k*x"], &times);
    let unknowns = vec![
        unknown("mu", Some(0.42)),
        unknown("fall", Some(0.8)),
        unknown("speed", Some(0.33)),
        unknown("x", Some(0.1)),
    ];
    let observables = vec![observable("x", None), observable("k*x", None)];
    let mut request = request(file, unknowns, observables);
    request.records.push(record(&times, columns));
    let found = fit(&request).unwrap();
    for (name, truth) in [("mu", 0.5), ("fall", 1.0), ("speed", 0.3), ("x", 0.2)] {
        let off = (value(&found, name) - truth).abs();
        assert!(off < 1e-7, "{name}: {off}, {:?}", found.end);
    }
    assert_ne!(found.end, LeastSquaresEnd::Evaluations);
    let rms = found.columns[0].rms;
    assert!(rms < 1e-8, "{rms}");
}

#[test]
fn the_force_of_a_contact_is_fitted_in_slip_and_in_stick() {
    let file = parsed(BELT);
    let times = times(80, 0.31);
    let columns = exact(&file, &["x", "v", "belt.force"], &times);
    let mut sticks = 0;
    for (k, &force) in columns[2].iter().enumerate() {
        let [x, v] = [0, 1].map(|column: usize| columns[column][k]);
        let slip = v - 0.3;
        let of_motion = match slip.abs() < 1e-9 {
            true => -x,
            false => slip.signum() * 0.5 / (1.0 + slip.abs()),
        };
        sticks += usize::from(slip.abs() < 1e-9);
        assert!(
            (force - of_motion).abs() < 1e-9,
            "{k}: {force} and {of_motion}"
        );
    }
    assert!((10..70).contains(&sticks), "{sticks}");
    // The force jumps where the block sticks. So the sum of squares has steps, and the search
    // begins within the one of the truth.
    let unknowns = vec![unknown("mu", Some(0.4995)), unknown("fall", Some(0.999))];
    let mut request = request(file, unknowns, vec![observable("belt.force", None)]);
    request
        .records
        .push(record(&times, vec![columns[2].clone()]));
    let found = fit(&request).unwrap();
    for (name, truth) in [("mu", 0.5), ("fall", 1.0)] {
        let off = (value(&found, name) - truth).abs();
        assert!(off < 1e-7, "{name}: {off}, {:?}", found.end);
    }
}

/// Static friction above kinetic friction: the force jumps where a stick ends at its limit.
#[test]
fn a_value_of_a_force_at_the_end_of_a_stick_has_no_standard_errors() {
    let file = parsed(&BELT.replace(
        "friction = \"mu/(1 + fall*belt*(v - speed))\"",
        "friction = \"mu/(1 + fall*belt*(v - speed))\"\nstatic = \"1.5*mu\"",
    ));
    let formulas = ["x", "belt.force"];
    let fine = times(20_000, 0.001);
    let forces = exact(&file, &formulas, &fine).swap_remove(1);
    let jumps = |k: &usize| (forces[k + 1] - forces[*k]).abs() > 0.05;
    let jumps: Vec<usize> = (0..forces.len() - 1).filter(jumps).collect();
    let end = *jumps.iter().find(|&&k| forces[k].abs() > 0.7).unwrap();
    let fit_of = |beside: Option<f64>| {
        let mut times = times(30, 0.31);
        times.retain(|t| jumps.iter().all(|&k| (t - fine[k]).abs() > 0.1));
        times.extend(beside);
        times.sort_by(f64::total_cmp);
        let columns = noisy(&exact(&file, &formulas, &times), 0.004, 7);
        let unknowns = vec![unknown("mu", Some(0.49)), unknown("x", Some(0.21))];
        let observables = formulas.map(|one| observable(one, Some(0.004)));
        let mut request = request(file.clone(), unknowns, observables.to_vec());
        request.records.push(record(&times, columns));
        fit(&request).unwrap()
    };
    let at_end = fit_of(Some(fine[end]));
    let why = at_end.uncertainty.none.clone().unwrap_or_default();
    assert!(why.contains("the value of belt.force at"), "{why}");
    assert!(at_end.values.iter().all(|one| one.std_error.is_none()));
    let without = fit_of(None);
    for (name, truth) in [("mu", 0.5), ("x", 0.2)] {
        let one = without.values.iter().find(|one| one.name == name).unwrap();
        let error = one.std_error;
        let error = error.unwrap_or_else(|| panic!("{:?}", without.uncertainty.none));
        assert!((one.value - truth).abs() < 4.0 * error, "{one:?}");
    }
}

#[test]
fn shipped_systems_give_back_their_parameters() {
    for (name, unknowns) in [
        ("belt", [("mu0", 0.9), ("vp", 1.05), ("k2", 1.1)]),
        ("leine", [("Fs", 0.95), ("gamma", 1.1), ("vd", 1.03)]),
    ] {
        let file = SystemFile::open(name).unwrap();
        let of = |name: &str| {
            let known = file.parameters.iter().find(|one| one.name == name);
            known.map(|one| one.value)
        };
        let known: Vec<_> = unknowns
            .iter()
            .filter_map(|(n, f)| Some((*n, *f, of(n)?)))
            .collect();
        if known.is_empty() {
            continue;
        }
        let times = times(60, 0.1);
        let columns = exact(&file, &["x"], &times);
        let sought = known
            .iter()
            .map(|(n, f, value)| unknown(n, Some(f * value)));
        let mut request = request(file.clone(), sought.collect(), vec![observable("x", None)]);
        request.records.push(record(&times, columns));
        let found = fit(&request).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (n, _, truth) in known {
            let off = (value(&found, n) - truth).abs();
            assert!(off < 1e-6, "{name}, {n}: {off}, {:?}", found.end);
        }
    }
}

#[test]
fn standard_errors_are_the_scatter_of_many_fits() {
    const DRAWS: u64 = 200;
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let exact = exact(&file, &["x"], &times);
    let names = ["mu", "fall", "x"];
    let one = |seed: u64| {
        let unknowns = names.iter().map(|name| unknown(name, None)).collect();
        let mut request = request(file.clone(), unknowns, vec![observable("x", None)]);
        request.options = stickslip::Options::tol(1e-9);
        request
            .records
            .push(record(&times, noisy(&exact, 2e-3, seed)));
        fit(&request).unwrap_or_else(|error| panic!("{seed}: {error}"))
    };
    let all: Vec<Fit> = (0..DRAWS).map(one).collect();
    for (k, truth) in [0.5, 1.0, 0.2].into_iter().enumerate() {
        let count = DRAWS as f64;
        let values = all.iter().map(|fit| fit.values[k].value);
        let mean = values.clone().sum::<f64>() / count;
        let scatter = values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (count - 1.0);
        let errors = all.iter().map(|fit| fit.values[k].std_error.unwrap());
        let square = errors.map(|e| e * e).sum::<f64>() / count;
        // The relative error of a variance from n draws is √(2/n); four of them.
        let ratio = scatter / square;
        let allowed = 4.0 * (2.0 / count).sqrt();
        assert!((ratio - 1.0).abs() < allowed, "{}: {ratio}", names[k]);
        assert!((mean - truth).abs() < 4.0 * (square / count).sqrt() + 0.05 * square.sqrt());
        let inside = all.iter().filter(|fit| {
            let (low, high) = fit.values[k].interval.unwrap();
            (low..=high).contains(&truth)
        });
        // Of 200 intervals at 95 % between 177 and 199 contain the truth, but for one in 1000.
        let inside = inside.count();
        assert!((177..=199).contains(&inside), "{}: {inside}", names[k]);
    }
    // Residuals of a true model have no remainder: 1 % of alarms, of which nine are too many.
    let alarms = all
        .iter()
        .filter(|fit| fit.columns[0].runs.unwrap().is_systematic());
    assert!(alarms.count() < 9);
}

#[test]
fn what_the_data_do_not_determine_is_named() {
    // Stiffness and a gain: with both, and a friction and speed of the same scale, x only fixes
    // their ratios.
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let columns = exact(&file, &["x"], &times);
    let unknowns = vec![
        unknown("gain", None),
        unknown("unit", None),
        unknown("mu", None),
    ];
    let mut request = request(file, unknowns, vec![observable("gain*unit*x", None)]);
    request.extra = vec![("gain".to_owned(), 0.5), ("unit".to_owned(), 2.0)];
    request
        .records
        .push(record(&times, noisy(&columns, 1e-3, 3)));
    let found = fit(&request).unwrap();
    let [direction] = &found.uncertainty.undetermined[..] else {
        panic!("{:?}", found.uncertainty.undetermined);
    };
    let of = |name: &str| {
        direction
            .iter()
            .find(|(own, _)| own == name)
            .map(|one| one.1)
    };
    // A larger gain is a smaller unit.
    assert!((of("gain").unwrap() + of("unit").unwrap()).abs() < 1e-6);
    assert_eq!(of("mu"), None);
    let error = |k: usize| found.values[k].std_error;
    assert!(error(0).is_none() && error(1).is_none() && error(2).is_some());
    assert!((value(&found, "mu") - 0.5).abs() < 5.0 * error(2).unwrap());
}

#[test]
fn several_records_share_parameters_and_have_starts_of_their_own() {
    let file = parsed(BELT);
    let times = times(50, 0.3);
    let with = |speed: f64, x: f64| {
        let text = BELT.replace("speed = 0.3", &format!("speed = {speed}"));
        exact(
            &parsed(&text.replace("x = 0.2", &format!("x = {x}"))),
            &["x"],
            &times,
        )
    };
    let unknowns = vec![
        unknown("mu", Some(0.45)),
        unknown("x", Some(0.15)),
        Unknown {
            each: true,
            ..unknown("off", Some(0.0))
        },
    ];
    let mut request = request(file, unknowns, vec![observable("x + off", Some(1e-3))]);
    request.extra = vec![("off".to_owned(), 0.0)];
    for (speed, x, off) in [(0.3, 0.2, 0.05), (0.5, 0.1, -0.02)] {
        let mut columns = with(speed, x);
        columns[0].iter_mut().for_each(|x| *x += off);
        // A missing value is no zero.
        columns[0][7] = f64::NAN;
        let mut record = record(&times, columns);
        record.set = vec![("speed".to_owned(), speed)];
        request.records.push(record);
    }
    let found = fit(&request).unwrap();
    for (name, truth) in [
        ("mu", 0.5),
        ("x@1", 0.2),
        ("x@2", 0.1),
        ("off@1", 0.05),
        ("off@2", -0.02),
    ] {
        let off = (value(&found, name) - truth).abs();
        assert!(off < 1e-7, "{name}: {off}");
    }
    assert_eq!(found.columns[0].count, 49);
}

/// A scale of the data changes no parameter of the orbit, and their errors only by rounding.
#[test]
fn an_offset_and_a_gain_of_any_size_change_errors_by_rounding_alone() {
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let signal = noisy(&exact(&file, &["x"], &times), 2e-3, 5).remove(0);
    let fitted = |offset: f64, gain: f64| {
        let names = ["mu", "fall", "gain", "offset"];
        let unknowns = names.map(|name| unknown(name, None)).to_vec();
        let formula = observable("gain*x + offset", None);
        let mut request = request(file.clone(), unknowns, vec![formula]);
        request.set = vec![("mu".to_owned(), 0.55)];
        request.extra = vec![("gain".to_owned(), gain), ("offset".to_owned(), offset)];
        let column = signal.iter().map(|x| offset + gain * x).collect();
        request.records.push(record(&times, vec![column]));
        fit(&request).unwrap()
    };
    let own = fitted(0.0, 1.0);
    for (offset, gain) in [(1e3, 1.0), (-1e3, 10.0), (1e3, 1e6), (1e-6, 1e-6)] {
        let found = fitted(offset, gain);
        for (k, scale) in [1.0, 1.0, gain, gain].into_iter().enumerate() {
            let (one, other) = (&own.values[k], &found.values[k]);
            let [error, scaled] = [one, other].map(|value| value.std_error.unwrap());
            let shift = if k == 3 { offset } else { 0.0 };
            let off = ((other.value - shift) / scale - one.value).abs();
            assert!(
                off < 1e-3 * error,
                "{offset}, {gain}, {}: {off:e}",
                one.name
            );
            assert!(
                (scaled / scale / error - 1.0).abs() < 1e-3,
                "{scaled} {error}"
            );
        }
        let [one, other] = [&own, &found].map(|of| of.columns[0].runs.unwrap());
        assert_eq!(one, other);
    }
}

#[test]
fn bounds_hold_and_robust_losses_pass_over_outliers() {
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let columns = exact(&file, &["x"], &times);
    let mut bounded = request(
        file.clone(),
        vec![unknown("mu", Some(0.4))],
        vec![observable("x", None)],
    );
    bounded.unknowns[0].bounds = (0.1, 0.45);
    bounded.records.push(record(&times, columns.clone()));
    let found = fit(&bounded).unwrap();
    assert!(found.values[0].is_at_bound && found.values[0].value == 0.45);
    assert!(found.values[0].std_error.is_none());
    // The remainder of a value that is held off is systematic.
    assert!(found.columns[0].runs.unwrap().is_systematic());

    let mut with_outliers = noisy(&columns, 1e-3, 8);
    for k in [9, 22, 41] {
        with_outliers[0][k] += 0.3;
    }
    let mut robust = request(
        file,
        vec![unknown("mu", Some(0.45))],
        vec![observable("x", None)],
    );
    robust.records.push(record(&times, with_outliers));
    let squares = fit(&robust).unwrap();
    for loss in [Loss::Huber(1.5), Loss::SoftL1(1.0)] {
        robust.loss = loss;
        let found = fit(&robust).unwrap();
        let off = |fit: &Fit| (fit.values[0].value - 0.5).abs();
        assert!(
            off(&found) < 4.0 * found.values[0].std_error.unwrap(),
            "{loss:?}"
        );
        assert!(found.values[0].std_error < squares.values[0].std_error);
        assert!(
            off(&found) < 0.2 * off(&squares),
            "{} {}",
            off(&found),
            off(&squares)
        );
    }
}

/// A block on a belt with a static limit, driven by a measured force with steps.
const ON_STEPS: &str = r#"
name = "driven"
[states]
x = ""
v = ""
[parameters]
mu = 0.4
st = 0.15
vp = 0.3
k = 1
[contacts.belt]
boundary = "v - vp"
friction = "mu/(1 + 0.8*belt*(v - vp))"
static = "mu + st"
[inputs.u]
shape = "table"
times = [0, 1, 1, 2.7, 3.1, 6, 6, 9, 12, 15, 20]
values = [0, 0.3, 0.8, -0.2, 0.5, 0.1, -0.6, 0.4, 0.2, -0.3, 0]
[field]
x = "v"
v = "-k*x - 0.05*v - friction(belt) + 0.5*u"
[start]
x = 0.2
v = 0.9
"#;

#[test]
fn robust_fits_end_at_minima_where_the_sequence_of_phases_changes_on_the_way() {
    let formulas = ["1.15*x + 0.03", "x + 2*v"];
    let truth = ON_STEPS.replace("mu = 0.4", "mu = 0.45");
    let truth = truth
        .replace("st = 0.15", "st = 0.2")
        .replace("k = 1\n", "k = 1.1\n");
    let other = truth.replace("vp = 0.3", "vp = 0.5");
    let other = other
        .replace("x = 0.2", "x = 0.1")
        .replace("v = 0.9", "v = 0.5");
    let times = times(60, 0.33);
    let [one, two] = [truth, other].map(|text| exact(&parsed(&text), &formulas, &times));
    let observables = [("gain*x + off", 0.003), ("x + 2*v", 0.01)];
    for seed in 1..=4 {
        let record_of = |columns: &[Vec<f64>], number: u64| {
            let columns = columns.iter().zip(observables).zip(0..);
            let columns = columns.map(|((column, (_, sigma)), k)| {
                noisy(
                    std::slice::from_ref(column),
                    sigma,
                    100 * seed + 10 * number + k,
                )
                .remove(0)
            });
            record(&times, columns.collect())
        };
        let unknowns = ["mu", "st", "k", "gain", "off", "x"].map(|name| Unknown {
            each: name == "off",
            ..unknown(name, None)
        });
        let observables = observables.map(|(formula, sigma)| observable(formula, Some(sigma)));
        let mut request = request(parsed(ON_STEPS), unknowns.into(), observables.into());
        request.extra = vec![("off".to_owned(), 0.02), ("gain".to_owned(), 1.1)];
        request.records = vec![record_of(&one, 1), record_of(&two, 2)];
        request.records[1].set = vec![("vp".to_owned(), 0.5)];
        request.records[1].start = vec![("x".to_owned(), 0.1), ("v".to_owned(), 0.5)];
        for loss in [Loss::Huber(1.0), Loss::SoftL1(1.0), Loss::SoftL1(0.3)] {
            request.loss = loss;
            let found = fit(&request).unwrap();
            assert_ne!(found.end, LeastSquaresEnd::Change, "{seed} {loss:?}");
            for (name, wanted) in [("mu", 0.45), ("st", 0.2), ("k", 1.1), ("gain", 1.15)] {
                let one = found.values.iter().find(|one| one.name == name).unwrap();
                let off = (one.value - wanted).abs() / one.std_error.unwrap();
                assert!(off < 4.5, "{name} of {seed} with {loss:?}: {off}");
            }
        }
    }
}

#[test]
fn a_search_finds_the_minimum_among_several() {
    // Of a linear oscillator the frequency has many minima.
    let file = parsed(
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nw = 2\n[field]\nx = \"v\"\n\
         v = \"-w^2*x\"\n[start]\nx = 1\nv = 0\n",
    );
    let times = times(40, 0.25);
    let columns = exact(&file, &["x"], &times);
    let mut request = request(
        file,
        vec![unknown("w", Some(6.0))],
        vec![observable("x", Some(0.1))],
    );
    request.unknowns[0].bounds = (0.5, 7.0);
    request.records.push(record(&times, columns));
    let local = fit(&request).unwrap();
    assert!((value(&local, "w") - 2.0).abs() > 0.1);
    request.search = 40;
    let found = fit(&request).unwrap();
    assert!((value(&found, "w") - 2.0).abs() < 1e-8);
    assert!(!found.others.is_empty());
    assert!(found.others.iter().all(|other| other.cost > found.cost));
}

#[test]
fn a_static_limit_that_may_not_be_reached_has_no_standard_error() {
    // A pull that ends at 1: a block of static friction 1 - 1e-4 slips, one of 1 + 1e-4 does not.
    let file = parsed(
        "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nlimit = 0.9999\n\
         slip = 0.5\n[contacts.floor]\nboundary = \"v\"\nfriction = \"slip\"\nstatic = \"limit\"\n\
         [field]\nx = \"v\"\nv = \"sin(t) - friction(floor)\"\n[start]\nx = 0\nv = 0\n",
    );
    let times = times(40, 0.07);
    let signal = exact(&file, &["x"], &times);
    let mut without = 0;
    for seed in 1..=8 {
        let columns = noisy(&signal, 0.1, seed);
        let unknowns = vec![unknown("limit", None)];
        let mut request = request(file.clone(), unknowns, vec![observable("x", None)]);
        request.records.push(record(&times, columns));
        let found = fit(&request).unwrap();
        let limit = &found.values[0];
        match (found.uncertainty.none, limit.std_error) {
            (Some(why), None) => {
                let is_told = why.contains("jumps") || why.contains("sequence of phases changes");
                assert!(is_told, "{why}");
                without += 1;
            }
            // Without effect, as the block never moves.
            (None, None) => assert!(limit.value > 1.0, "{}", limit.value),
            // The block slips within a whole standard error.
            (_, Some(error)) => assert!(limit.value + error < 1.0, "{} {error}", limit.value),
        }
    }
    assert!(without >= 4, "{without}");
}

/// A ball that bounces at 1, 2 and 2.5, as the truth has it, and data at these times: the residual
/// of the velocity jumps as a bounce passes its time.
#[test]
fn where_an_event_passes_a_data_time_there_is_no_standard_error() {
    let file = parsed(
        "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 10\ne = 0.5\n\
         [jumps.b]\nwhen = \"h\"\ndirection = \"falling\"\nset = { w = \"-e*w\" }\n\
         [field]\nh = \"w\"\nw = \"-g\"\n[start]\nh = 5\nw = 0\n",
    );
    let fitted = |times: &[f64], formulas: &[&str], start: [f64; 2]| {
        let signal = exact(&file, formulas, times);
        let of = |name: &str, start: f64| unknown(name, Some(start));
        let unknowns = vec![of("g", start[0]), of("e", start[1]), of("h", 5.0)];
        let observed = formulas.iter().map(|one| observable(one, Some(0.01)));
        let mut request = request(file.clone(), unknowns, observed.collect());
        request.records.push(record(times, noisy(&signal, 0.01, 3)));
        fit(&request).unwrap()
    };
    let at_bounces: Vec<f64> = (1..30).map(|k| 0.1 * f64::from(k)).collect();
    let found = fitted(&at_bounces, &["h", "w"], [9.9, 0.51]);
    let none = found.uncertainty.none.unwrap_or_default();
    assert!(
        none.contains("beyond the event `b` at"),
        "{none} {:?}",
        found.values
    );
    assert!(found.values.iter().all(|one| one.std_error.is_none()));
    // Bounces between the times of the data move no residual by a jump.
    let apart: Vec<f64> = at_bounces.iter().map(|t| t - 0.04).collect();
    for formulas in [&["h", "w"][..], &["h"]] {
        let found = fitted(&apart, formulas, [9.99, 0.501]);
        assert_eq!(found.uncertainty.none, None, "{:?}", found.values);
        let truth = [10.0, 0.5, 5.0];
        for (one, truth) in found.values.iter().zip(truth) {
            let error = one.std_error.unwrap();
            assert!((one.value - truth).abs() < 4.0 * error, "{one:?}");
        }
    }
}

/// On an orbit of another frequency the best gain is about zero, and no search leads away from it.
#[test]
fn a_gain_is_found_where_the_orbit_is_far_from_that_of_the_data() {
    let text = "name = \"case\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = 1\n\
                [field]\nx = \"v\"\nv = \"-k*x\"\n[start]\nx = 1\nv = 0\n";
    let times = times(199, 0.1);
    let root = f64::sqrt(1.3);
    let signal: Vec<f64> = times.iter().map(|t| math::cos(root * t)).collect();
    for start in [0.95, 1.68, 1.69] {
        let unknowns = ["k", "gain"].map(|name| unknown(name, None)).to_vec();
        let mut request = request(parsed(text), unknowns, vec![observable("gain*x", None)]);
        request.set = vec![("k".to_owned(), start)];
        request.extra = vec![("gain".to_owned(), 1.0)];
        let columns = noisy(std::slice::from_ref(&signal), 0.01, 9);
        request.records.push(record(&times, columns));
        let found = fit(&request).unwrap();
        let [k, gain] = ["k", "gain"].map(|name| value(&found, name));
        assert!(
            (k - 1.3).abs() < 1e-3 && (gain - 1.0).abs() < 1e-2,
            "{start}: {k} {gain}"
        );
    }
}

/// The rounding of a quotient of states is judged by what each of them contributes.
/// Offsets and scales enter linearly: where they begin does not count.
#[test]
fn calibration_is_found_from_afar() {
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let exact = exact(&file, &["x"], &times);
    for seed in 0..20 {
        let random = &mut SplitMix::new(seed);
        let (gain, off) = (random.between(0.5, 2.0), random.between(-1.0, 1.0));
        let sigma = 0.005 * gain;
        let column = exact[0].iter().map(|x| gain * x + off).collect();
        let columns = noisy(&[column], sigma, seed);
        let sign = if seed % 2 == 0 { 1e3 } else { -1e3 };
        let unknowns = vec![
            unknown("mu", Some(0.5 + 0.05 * random.between(-1.0, 1.0))),
            unknown("gain", Some(-gain)),
            unknown("off", Some(off + sign * sigma)),
        ];
        let mut request = request(
            file.clone(),
            unknowns,
            vec![observable("gain*x + off", None)],
        );
        request.extra = vec![("gain".to_owned(), 1.0), ("off".to_owned(), 0.0)];
        request.records.push(record(&times, columns));
        let found = fit(&request).unwrap();
        for (name, truth) in [("mu", 0.5), ("gain", gain), ("off", off)] {
            let one = found.values.iter().find(|one| one.name == name).unwrap();
            let error = one.std_error.unwrap();
            assert!((one.value - truth).abs() < 5.0 * error, "{seed}: {one:?}");
        }
    }
}

#[test]
fn exact_data_of_a_quotient_leave_no_systematic_remainder() {
    let file = parsed(BELT);
    let (times, formula) = (times(60, 0.05), "x/hypot(x, v)");
    let columns = exact(&file, &[formula], &times);
    let unknowns = vec![unknown("mu", None)];
    let mut request = request(file, unknowns, vec![observable(formula, None)]);
    request.set = vec![("mu".to_owned(), 0.52)];
    request.options.rtol = 1e-7;
    request.options.atol = 1e-7.into();
    request.records.push(record(&times, columns));
    let found = fit(&request).unwrap();
    assert_eq!(found.columns[0].runs, None);
}

/// Times and velocities of a ball dropped from 1 that keeps 0.8 of its velocity, in closed form.
/// They are those behind or before each bounce, and at `further` times between.
fn bounces(g: f64, further: &[f64], is_after: impl Fn(usize) -> bool) -> (Vec<f64>, Vec<f64>) {
    let fall = (2.0 / g).sqrt();
    let (mut t, mut v) = (fall, g * fall);
    let mut rows = Vec::new();
    let of_fall = further.iter().filter(|time| **time < fall);
    rows.extend(of_fall.map(|time| (*time, -g * time)));
    for k in 0..6 {
        let before = -v;
        v *= 0.8;
        rows.push((t, if is_after(k) { v } else { before }));
        let end = t + 2.0 * v / g;
        let inside = further.iter().filter(|time| t < **time && **time < end);
        rows.extend(inside.map(|time| (*time, v - g * (time - t))));
        t = end;
    }
    rows.sort_by(|one, other| one.0.total_cmp(&other.0));
    rows.into_iter().unzip()
}

#[test]
fn values_at_the_times_of_impacts_are_fitted_on_both_sides_and_have_no_standard_error() {
    let file = parsed(
        "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 9.81\ne = 0.8\n\
         [jumps.b]\nwhen = \"h\"\ndirection = \"falling\"\nset = { w = \"-e*w\" }\n\
         [field]\nh = \"w\"\nw = \"-g\"\n[start]\nh = 1\nw = 0\n",
    );
    let grid: Vec<f64> = (0..24).map(|k| 0.05 + 0.1 * f64::from(k)).collect();
    let grid = &grid[..];
    // A bounce that is early or late by 1 % leaves values by 6 off, which each side would explain.
    for (further, start, is_given, seed) in [
        (grid, 10.5, true, 1),
        (grid, 10.0, true, 2),
        (grid, 9.6, true, 3),
        (grid, 10.5, false, 4),
        (&grid[..0], 10.0, true, 5),
        (&grid[..0], 10.5, false, 6),
    ] {
        let (times, exact) = bounces(9.81, further, |_| true);
        let sigma = is_given.then_some(0.01);
        let unknowns = vec![unknown("g", Some(start))];
        let mut request = request(file.clone(), unknowns, vec![observable("w", sigma)]);
        request.most_evaluations = 500;
        request
            .records
            .push(record(&times, noisy(&[exact], 0.01, seed)));
        let found = fit(&request).unwrap();
        let one = &found.values[0];
        let off = (one.value - 9.81).abs();
        assert!(off < 0.03, "{start}, {is_given}: {}", one.value);
        assert_eq!(one.std_error, None);
        let why = found.uncertainty.none.unwrap();
        let said = ["record: the value of w at ", "beyond the event `b` at "];
        assert!(said.iter().all(|said| why.contains(said)), "{why}");
    }
    // Values of both sides leave the truth alone, which no search finds from afar: it is said.
    let (times, exact) = bounces(9.81, grid, |k| k % 2 == 0);
    for start in [9.5, 10.0, 10.5] {
        let unknowns = vec![unknown("g", Some(start))];
        let mut request = request(file.clone(), unknowns, vec![observable("w", Some(0.01))]);
        request
            .records
            .push(record(&times, noisy(std::slice::from_ref(&exact), 0.01, 7)));
        let found = fit(&request).unwrap();
        assert!(found.uncertainty.none.is_some(), "{:?}", found.values);
    }
}

/// An impact after the last value may pass it, too.
#[test]
fn an_impact_beyond_the_last_value_is_an_event_beside_it() {
    let file = parsed(
        "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 9.81\n\
         [jumps.b]\nwhen = \"h\"\ndirection = \"falling\"\nset = { w = \"-0.8*w\" }\n\
         [field]\nh = \"w\"\nw = \"-g\"\n[start]\nh = 1\nw = 0\n",
    );
    let fall = (2.0_f64 / 9.81).sqrt();
    // A standard error of 0.01 in g moves the fall by 2.3e-4.
    for (before, is_near) in [(4e-4, true), (4e-3, false)] {
        let mut times: Vec<f64> = (1..9).map(|k| 0.05 * f64::from(k)).collect();
        times.push(fall - before);
        let exact: Vec<f64> = times.iter().map(|t| -9.81 * t).collect();
        let unknowns = vec![unknown("g", Some(9.8))];
        let mut request = request(file.clone(), unknowns, vec![observable("w", Some(0.01))]);
        request
            .records
            .push(record(&times, noisy(&[exact], 0.002, 9)));
        let found = fit(&request).unwrap();
        assert_eq!(
            found.uncertainty.none.is_some(),
            is_near,
            "{:?}",
            found.uncertainty
        );
    }
}

#[test]
fn what_cannot_be_fitted_is_refused_with_the_remedy() {
    let file = parsed(BELT);
    let times = times(20, 0.25);
    let columns = exact(&file, &["x"], &times);
    let base = || {
        let mut base = request(
            file.clone(),
            vec![unknown("mu", None)],
            vec![observable("x", None)],
        );
        base.records.push(record(&times, columns.clone()));
        base
    };
    type Change = fn(&mut FitRequest);
    let cases: [(Change, &str); 14] = [
        (
            |r| r.unknowns[0].name = "nu".into(),
            "`nu` is neither a parameter nor a state",
        ),
        (
            |r| r.unknowns[0].name = "idle".into(),
            "`idle` has no effect on what is observed",
        ),
        (|r| r.unknowns[0].bounds = (0.6, 1.0), "outside its bounds"),
        (|r| r.unknowns[0].bounds = (1.0, 0.6), "contain nothing"),
        (
            |r| r.records[0].times[3] = 0.1,
            "in row 4, does not come after",
        ),
        (
            |r| r.records[0].times[0] = -1.0,
            "is before the start of the run at 0",
        ),
        (|r| r.records[0].columns[0][2..].fill(f64::NAN), "2 values"),
        (
            |r| r.records[0].columns[0].fill(f64::NAN),
            "there are no data",
        ),
        (
            |r| r.observables[0].formula = "y".into(),
            "unknown name `y`",
        ),
        (|r| r.observables[0].sigma = Some(0.0), "must be positive"),
        (|r| r.search = 5, "has no bounds to search within"),
        (
            |r| r.records[0].set = vec![("mu".into(), 0.4)],
            "`mu` is set to 0.4 in this record and fitted for all",
        ),
        (
            |r| r.segments = 11,
            "11 segments need 2 rows with a value each, and there are 20: take at most 10",
        ),
        (
            |r| r.extra = vec![("x".into(), 1.0)],
            "`x` is the name of a state already",
        ),
    ];
    for (change, said) in cases {
        let mut request = base();
        if said == "2 values" {
            request.unknowns.push(unknown("x", None));
        }
        change(&mut request);
        let words = refused(&request);
        assert!(words.contains(said), "{said}: {words}");
    }
    // A run that escapes before the data.
    let escaping = parsed(
        "name = \"case\"\n[states]\nx = \"\"\n[parameters]\na = 1\n[field]\nx = \"a*x*x\"\n\
         [start]\nx = 1\n",
    );
    let mut request = request(
        escaping,
        vec![unknown("a", None)],
        vec![observable("x", None)],
    );
    request.records.push(record(&times, columns.clone()));
    assert!(matches!(fit(&request), Err(FitError::Start { .. })));
    // A value from which the run reaches the data is found past those that fail.
    let table = parsed(&BELT.replace(
        "[contacts.belt]",
        "[inputs.push]\nshape = \"table\"\ntimes = [0, 1, 2]\nvalues = [0, 1, 0]\n[contacts.belt]",
    ).replace("-k*x", "-k*x + push"));
    let mut request = base();
    request.file = table;
    assert!(refused(&request).contains("leaves the table of an input, which covers 0 to 2"));
}

#[test]
fn the_committed_intervals_contain_the_truth_as_often_as_they_should() {
    let table = include_str!("../../examples/fit_coverage/coverage.csv");
    let mut pooled = std::collections::BTreeMap::<&str, [f64; 2]>::new();
    for row in table.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        assert_eq!((number(2), number(3)), (1000.0, 1000.0), "{row}");
        let share = number(6) / number(4);
        assert!((0.925..=0.975).contains(&share), "{row}");
        let of_level = pooled.entry(cells[1]).or_default();
        *of_level = [of_level[0] + number(6), of_level[1] + number(4)];
    }
    assert_eq!(pooled.len(), 3);
    for (noise, [contained, intervals]) in pooled {
        let share = contained / intervals;
        assert!((0.94..=0.96).contains(&share), "{noise}: {share}");
    }
}

#[test]
fn parts_have_a_value_each_and_pass_over_outliers() {
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let exact = exact(&file, &["x"], &times);
    let mut columns = noisy(&exact, 0.002, 3);
    // No value in the middle third, and outliers at both ends.
    columns[0][20..40].fill(f64::NAN);
    for row in [3, 11, 44, 52] {
        columns[0][row] += 0.5;
    }
    let mut wanted = request(
        file,
        vec![unknown("mu", Some(0.55)), unknown("fall", Some(1.2))],
        vec![observable("x", None)],
    );
    wanted.records.push(record(&times, columns));
    wanted.segments = 5;
    let off = |request: &FitRequest| {
        let found = fit(request).unwrap();
        assert!(found.values.len() == 2 && found.columns[0].count == 40);
        (value(&found, "mu") - 0.5).abs() + (value(&found, "fall") - 1.0).abs()
    };
    let squares = off(&wanted);
    wanted.loss = Loss::Huber(1.345);
    let robust = off(&wanted);
    assert!(
        robust < 0.03 && robust < 0.2 * squares,
        "{robust} {squares}"
    );
}

/// A block on a belt. Starts and the start time are formulas of a parameter, and so is the period
/// of the drive.
const DRIVEN: &str = r#"
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

/// Two records of [`DRIVEN`] with an offset and a gain, at the values with which a fit of these
/// unknowns begins.
fn two_records(names: &[&str]) -> FitRequest {
    // Many before the first stick, which forgets the start.
    let early = (0..14).map(|k| 0.31 + 0.03 * f64::from(k));
    let all = early.chain((0..26).map(|k| 0.8 + 0.41 * f64::from(k)));
    let times: Vec<f64> = all.collect();
    let late = |t: &f64| if *t > 0.6 { 0.2 } else { f64::NAN };
    let columns = vec![vec![0.1; 40], times.iter().map(late).collect()];
    let unknowns = names.iter().map(|name| {
        // Starts that are fitted do not move with the parameter of their formulas.
        let start = match *name {
            "x" => Some(0.2),
            "t0" => Some(0.15),
            _ => None,
        };
        Unknown {
            each: *name == "off",
            ..unknown(name, start)
        }
    });
    let observables = vec![
        observable("gain*x + off*speed", Some(1e-6)),
        observable("x*x + push + sin(v)", Some(2e-5)),
    ];
    let mut request = request(parsed(DRIVEN), unknowns.collect(), observables);
    request.options = Options::tol(1e-12);
    request.extra = vec![("gain".to_owned(), 1.2), ("off".to_owned(), 0.1)];
    let one = record(&times, columns);
    let other = Record {
        t_start: Some(0.2),
        set: vec![("more".to_owned(), 0.3)],
        ..one.clone()
    };
    request.records = vec![one, other];
    request.most_evaluations = 1;
    request
}

#[test]
fn covariances_where_a_fit_begins_are_those_of_differences_of_runs() {
    const STEP: f64 = 1e-5;
    const BY_STATES: &str = "x*x + push + sin(v)";
    let cases: [(&[&str], &str); 3] = [
        (&["mu", "speed", "T", "gain", "off"], BY_STATES),
        // A velocity as well would leave a start that moves along its orbit.
        (&["mu", "x", "t0", "gain"], BY_STATES),
        // The law in slip, and in stick what the drive and the spring ask for.
        (
            &["mu", "speed", "T", "gain", "off"],
            "belt.force + x*belt.force",
        ),
    ];
    for (names, second) in cases {
        let mut at_start = two_records(names);
        at_start.observables[1] = observable(second, Some(2e-5));
        // With the data of the model itself, no value is fitted better beyond an event.
        for column in fit(&at_start).unwrap().columns {
            let record = &mut at_start.records[column.record];
            let data = record.columns[column.observable]
                .iter_mut()
                .zip(column.model);
            data.filter(|(data, _)| !data.is_nan())
                .for_each(|(data, model)| *data = model);
        }
        let begun = fit(&at_start).unwrap();
        // Residuals over deviations, for each record.
        let residuals = |found: &Fit, number: usize| {
            let own = found.columns.iter().filter(|one| one.record == number);
            let all = own.flat_map(|one| one.residuals.iter().map(|r| r / one.sigma));
            Vector::from_vec(all.filter(|r| !r.is_nan()).collect())
        };
        let rows = [0, 1].map(|number| residuals(&begun, number).len());
        let count = begun.values.len();
        let mut slopes = Matrix::zeros(rows[0] + rows[1], count);
        for (k, one) in begun.values.iter().enumerate() {
            assert_eq!(one.value, one.start);
            let (name, of_record) = match one.name.split_once('@') {
                Some((name, number)) => (name, Some(number.parse::<usize>().unwrap() - 1)),
                None => (&*one.name, None),
            };
            let runs = [2.0, 1.0, -1.0, -2.0].map(|by| {
                let mut beside = at_start.clone();
                let mut unknowns = beside.unknowns.iter_mut();
                let changed = unknowns.find(|known| known.name == name).unwrap();
                changed.start = Some(one.start + by * STEP);
                fit(&beside).unwrap()
            });
            for number in 0..2 {
                let at = runs.each_ref().map(|run| residuals(run, number));
                let difference = ((&at[1] - &at[2]) * 8.0 - (&at[0] - &at[3])) / (12.0 * STEP);
                if of_record.is_none_or(|of| of == number) {
                    let mut column = slopes.column_mut(k);
                    column
                        .rows_mut(number * rows[0], rows[number])
                        .copy_from(&difference);
                }
            }
        }
        let one = &begun.uncertainty.covariance * slopes.transpose() * slopes;
        let off = (one - Matrix::identity(count, count)).amax();
        assert!(off < 1e-4, "{names:?}: {off}");
    }
}

#[test]
fn the_most_evaluations_are_those_of_all_stages() {
    let file = parsed(BELT);
    let times = times(60, 0.25);
    let columns = noisy(&exact(&file, &["x"], &times), 0.01, 4);
    let mut wanted = request(
        file,
        vec![unknown("mu", Some(0.6)), unknown("fall", Some(1.5))],
        vec![observable("x", None)],
    );
    wanted.records.push(record(&times, columns));
    let whole = fit(&wanted).unwrap();
    assert_ne!(whole.end, LeastSquaresEnd::Evaluations);
    for most in [3, whole.evaluations - 1] {
        wanted.most_evaluations = most;
        let found = fit(&wanted).unwrap();
        assert_eq!(found.evaluations, most);
        assert_eq!(found.end, LeastSquaresEnd::Evaluations);
    }
    // Parts begin with a run for each of their candidates.
    (wanted.segments, wanted.most_evaluations) = (4, 60);
    let found = fit(&wanted).unwrap();
    assert!(found.evaluations <= 61, "{}", found.evaluations);
}

/// A driven block between two wells, chaotic at these values: its largest exponent is 0.14.
const CHAOTIC: &str = r#"
name = "case"
[time]
period = "2*pi"
[states]
x = ""
v = ""
[parameters]
a = 1.0
mu = 0.05
c = 0.2
force = 0.4
[contacts.guide]
boundary = "v"
friction = "mu"
[field]
x = "v"
v = "a*x - x^3 - c*v + force*cos(t) - friction(guide)"
[start]
x = 0.5
v = 0.1
"#;

/// Numbers of chaotic records of so many periods whose parameters are found within 2 %, from 20 %
/// off: by multiple and by single shooting.
fn found_of_chaotic(records: u64, periods: u32) -> [usize; 2] {
    let times: Vec<f64> = times(10 * periods, 0.2 * std::f64::consts::PI);
    let truths = [("a", 1.0), ("c", 0.2), ("force", 0.4)];
    let is_found = |record_number: u64, segments: usize| {
        let random = &mut SplitMix::new(100 + record_number);
        let start = [random.between(-1.0, 1.0), random.between(-0.5, 0.5)];
        let text = CHAOTIC.replace("x = 0.5", &format!("x = {}", start[0]));
        let file = parsed(&text.replace("v = 0.1", &format!("v = {}", start[1])));
        let columns = exact(&file, &["x"], &times);
        let off = |random: &mut SplitMix| {
            if random.between(0.0, 1.0) < 0.5 {
                0.8
            } else {
                1.2
            }
        };
        let mut unknowns: Vec<Unknown> = truths
            .iter()
            .map(|(name, truth)| unknown(name, Some(off(random) * truth)))
            .collect();
        unknowns.push(unknown("x", Some(off(random) * start[0])));
        unknowns.push(unknown("v", Some(off(random) * start[1])));
        let mut request = request(file, unknowns, vec![observable("x", None)]);
        request.options = stickslip::Options::tol(1e-10);
        (request.segments, request.most_evaluations) = (segments, 500);
        let sigma = 0.01;
        request
            .records
            .push(record(&times, noisy(&columns, sigma, record_number)));
        let Ok(found) = fit(&request) else {
            return false;
        };
        // Starts of parts are no results.
        assert_eq!(found.values.len(), 5);
        assert_eq!(found.uncertainty.covariance.shape(), (5, 5));
        let near = |(name, truth): &(&str, f64)| (value(&found, name) / truth - 1.0).abs() < 0.02;
        truths.iter().all(near)
    };
    [periods as usize, 0].map(|segments| (0..records).filter(|k| is_found(*k, segments)).count())
}

#[test]
fn multiple_shooting_finds_chaotic_records() {
    let [multiple, single] = found_of_chaotic(3, 15);
    assert!(
        multiple >= 2 && single < multiple,
        "{multiple} and {single} of 3"
    );
}

/// Some minutes: `make shooting`. It fails: 73 are found.
#[test]
#[ignore = "it takes minutes; make shooting runs it"]
fn multiple_shooting_finds_90_of_100_chaotic_records() {
    let [multiple, single] = found_of_chaotic(100, 50);
    println!("{multiple} and {single} of 100 records");
    assert!(
        multiple >= 90 && single < 50,
        "{multiple} and {single} of 100"
    );
}
