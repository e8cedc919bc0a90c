//! Analyses of systems with stops: starts, equilibria, orbits, branches, exponents and attractors.

use std::f64::consts::PI;

use stickslip::analysis::{
    Attractor, AttractorKind, ContinuationSettings, EdgeKind, EdgeSettings, EdgeState,
    EquilibriumBifurcation, Push, PushSettings, RecurrenceSettings, SpectrumOptions, attractor,
    lyapunov_spectrum, multipliers,
};
use stickslip::dynamics::{Modes, Step, Vector};
use stickslip::{Error, Options, math};
use stickslip_model::study::{ParameterLine, StepMonitor, TwoSidedBranch, Variables};

use super::derivatives::found;
use super::run::{METHODS, Run, branch, options, orbit, system, with};

/// A ball on a table that shakes with the amplitude A; its impacts accumulate once a period.
const TABLE: &str = r#"name = "Ball on a shaken table"
[states]
h = ""
v = ""
[parameters]
A = 1.2
e = 0.5
[field]
h = "v"
v = "-1"
[stops.table]
gap = "h - A*sin(t)"
acts = { v = 1 }
restitution = "e"
[start]
h = 0
v = "A"
[time]
end = 20
period = "2*pi"
"#;

/// A body that a force presses on a wall and lifts once a period, if A exceeds 1.
const LIFTED: &str = r#"name = "Body on a wall"
[states]
x = ""
v = ""
[parameters]
A = 2
[field]
x = "v"
v = "-1 + A*sin(t)"
[stops.wall]
gap = "x"
acts = { v = 1 }
restitution = 0
[start]
x = 0
v = 0
[time]
end = 30
period = "2*pi"
"#;

/// An oscillator that slides on a table; its friction follows the reaction, which never vanishes.
const CARRIED: &str = r#"name = "Oscillator on a table"
[states]
x = ""
u = ""
y = ""
w = ""
[field]
x = "u"
u = "-x - 0.2*u - 0.1*table.force"
y = "w"
w = -1
[stops.table]
gap = "y - 0.6*sin(t)"
acts = { w = 1 }
restitution = 0.5
[start]
x = 0.5
u = 0
y = 0
w = 0.6
[time]
end = 30
period = "2*pi"
"#;

fn numbers(branch: &TwoSidedBranch) -> Vec<f64> {
    branch
        .points
        .iter()
        .map(|one| one.orbit.parameter)
        .collect()
}

#[test]
fn a_start_on_a_stop_is_on_it_and_pushed() {
    for method in METHODS {
        let on = |h: f64, v: f64, g: f64| {
            let text = TABLE
                .replace("A*sin(t)", "0*A")
                .replace("\"-1\"", &format!("\"{g}\""));
            let start = (0.0, vec![h, v, 1.0]);
            Run::from(system(&text), &options(method), (start, 3.0))
        };
        // What is off within the tolerance is removed, and would grow with time.
        let rests = on(1e-12, 1e-12, -1.0);
        assert_eq!(rests.transitions, []);
        assert_eq!([rests.end("h"), rests.end("v")], [0.0, 0.0], "{method}");
        // A reaction that would pull ends at once.
        let lifts = on(0.0, 0.0, 1.0);
        assert_eq!(lifts.transitions.len(), 1);
        assert_eq!(lifts.transitions[0].2, "table.lift-off");
        assert!((lifts.end("h") - 4.5).abs() < 1e-12, "{method}");
        for (h, v, number) in [(1.0, 0.0, 1.0), (0.0, -0.5, -0.5), (-1e-6, 0.0, -1e-6)] {
            let run = on(h, v, -1.0);
            let off = match &run.ended {
                Err(Error::OffStop { off, .. }) => *off,
                other => panic!("{other:?}"),
            };
            assert!((off - number).abs() < 1e-12);
            let words = run.words();
            assert!(
                words.contains("the stop `table` carries at t = 0"),
                "{words}"
            );
        }
    }
}

#[test]
fn a_reaction_that_touches_zero_lifts_nothing() {
    for method in METHODS {
        // Of 1 - A sin t, the least value is within rounding of zero or a little below: the flights
        // are as small.
        for off in [-1e-10, 0.0, 1e-15, 1e-13, 1e-11, 1e-10, 1e-8, 1e-6] {
            let lifted = with(LIFTED, &[("A", 1.0 + off)]);
            let run = Run::of(lifted, &options(method), None);
            assert!(run.ended.is_ok(), "{method}, {off}: {}", run.words());
            assert_eq!(run.end("wall.closed"), 1.0, "{method}, {off}");
            assert!(run.end("x").abs() < 1e-15 && run.end("v").abs() < 1e-15);
        }
    }
}

#[test]
fn a_falling_ball_is_no_equilibrium_and_one_at_rest_is() {
    let text = TABLE
        .replace("A*sin(t)", "0*A")
        .replace("\"-1\"", "\"-A\"")
        .replace("period = \"2*pi\"\n", "")
        .replace("[start]\nh = 0\nv = \"A\"", "[start]\nh = 1\nv = 0");
    let system = system(&text);
    let options = options("taylor");
    let settings = ContinuationSettings::over(0.5, 2.0);
    let along = ParameterLine::new(&system, "A", (0.5, 2.0)).unwrap();
    for at in [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]] {
        let found = along.equilibria(&at, &settings, &options);
        assert!(matches!(found, Err(Error::NotFound { .. })), "{at:?}");
    }
    let found = along
        .equilibria(&[0.0, 0.0, 1.0], &settings, &options)
        .unwrap();
    assert!(found.points.len() > 10);
    for point in &found.points {
        assert_eq!(point.x.as_slice()[..3], [0.0, 0.0, 1.0]);
    }
    let settings = RecurrenceSettings::within(1000.0);
    let reached = attractor(system.dynamics(), [1.0, 0.0, 0.0], &settings, &options).unwrap();
    assert_eq!(reached.kind, AttractorKind::Equilibrium);
    assert_eq!(reached.points[0].x.as_slice(), [0.0, 0.0, 1.0]);
}

#[test]
fn a_carried_oscillator_has_the_multipliers_and_exponents_of_the_free_one() {
    // Friction adds a force that does not depend on the state.
    let (decay, turn) = (-0.1_f64, (1.0_f64 - 0.01).sqrt());
    let size = math::exp(2.0 * PI * decay);
    for method in METHODS {
        let system = system(CARRIED);
        let found = orbit(&system, &options(method));
        assert!((found.period - 2.0 * PI).abs() < 1e-12);
        let multipliers = multipliers(&found.monodromy);
        for one in &multipliers[..2] {
            assert!(
                (one.norm() - size).abs() < 1e-10,
                "{method}: {multipliers:?}"
            );
            assert!((one.re - size * math::cos(2.0 * PI * turn)).abs() < 1e-10);
        }
        assert!(multipliers[2..].iter().all(|one| one.norm() < 1e-12));
        let settings = SpectrumOptions::over(200.0 * PI, 20.0 * PI).solver(options(method));
        let start = system.start().unwrap();
        let found = lyapunov_spectrum(system.dynamics(), (0.0, &start[..]), &settings).unwrap();
        let values: Vec<f64> = found.exponents.iter().map(|one| one.value()).collect();
        for value in &values[..2] {
            assert!((value - decay).abs() < 5e-3, "{method}: {values:?}");
        }
        assert!(
            (values[0] + values[1] - 2.0 * decay).abs() < 1e-9,
            "{values:?}"
        );
        assert!(values[2..].iter().all(|one| *one == f64::NEG_INFINITY));
    }
}

/// A driven ball that comes to rest once a period, and what decays beside it. The last impacts have
/// speeds of rounding, by which a change of their times has an effect of 1e15 and more.
const BESIDE: &str = r#"name = "Decay beside a ball"
[states]
h = ""
w = ""
z = ""
[field]
h = "w"
w = "-1 + 1.2*sin(t)"
z = "-0.7*z + sin(t)"
[stops.table]
gap = "h"
acts = { w = 1 }
restitution = 0.5
[start]
h = 2
w = 0
z = 1
[time]
period = "2*pi"
end = 30
"#;

/// A ball chatters to rest on a shaken table once a period: nothing of gap and rate is left.
#[test]
fn a_landing_on_a_table_that_moves_annihilates_both_directions() {
    let table = "name = \"table\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nr = 0.1\n\
                 [stops.table]\ngap = \"x - 1.5*sin(t)\"\nacts = { v = 1 }\nrestitution = \"r\"\n\
                 [field]\nx = \"v\"\nv = \"-1 - d*v\"\n[start]\nx = 0.5\nv = 1.5\n";
    for drag in ["0", "0.01"] {
        for r in [0.1, 0.2, 0.3, 0.4, 0.45, 0.5, 0.6] {
            let system = with(&table.replace("d*v", &format!("{drag}*v")), &[("r", r)]);
            let start = system.start().unwrap();
            let settings = SpectrumOptions::over(0.0, 200.0).solver(options("taylor"));
            let found = lyapunov_spectrum(system.dynamics(), (0.0, &start[..]), &settings);
            let found = found.unwrap();
            assert!(found.ended.is_none(), "{r}: {:?}", found.ended);
            let all = found.exponents.iter().map(|one| one.value());
            assert!(
                all.clone().all(|one| one == f64::NEG_INFINITY),
                "{r}: {all:?}"
            );
        }
    }
}

#[test]
fn impacts_of_little_speed_annihilate_no_other_direction() {
    for method in METHODS {
        let system = system(BESIDE);
        let settings = SpectrumOptions::over(60.0 * PI, 20.0 * PI).solver(options(method));
        let start = system.start().unwrap();
        let found = lyapunov_spectrum(system.dynamics(), (0.0, &start[..]), &settings).unwrap();
        let values: Vec<f64> = found.exponents.iter().map(|one| one.value()).collect();
        assert!((values[0] + 0.7).abs() < 1e-6, "{method}: {values:?}");
        assert!(values[1..].iter().all(|one| *one == f64::NEG_INFINITY));
    }
}

/// An oscillator with negative damping; the wall at 1 takes all of its speed and lets go at once.
const EXCITED: &str = r#"name = "Excited oscillator at a wall"
[states]
x = ""
v = ""
[parameters]
d = 0.1
[field]
x = "v"
v = "-x + 2*d*v"
[stops.wall]
gap = "1 - x"
acts = { v = -1 }
restitution = 0
[start]
x = 0.5
v = 0.2
[time]
end = 30
"#;

/// Time of the return of the excited oscillator to the wall, from rest there.
fn time_of_return(d: f64) -> f64 {
    let om = (1.0 - d * d).sqrt();
    let place = |t: f64| math::exp(d * t) * (math::cos(om * t) - d / om * math::sin(om * t)) - 1.0;
    numerics::bisect(1.5 * PI, 2.0 * PI, |t| place(t) >= 0.0)
}

#[test]
fn a_plastic_impact_that_lets_go_leaves_no_direction() {
    let d = 0.1;
    let exact = time_of_return(d);
    for method in METHODS {
        let system = system(EXCITED);
        let run = Run::of(system, &options(method), None);
        let names: Vec<&str> = run.transitions.iter().map(|at| at.2.as_str()).collect();
        assert!(names.len() > 2 && names.iter().all(|name| *name == "wall.impact"));
        for pair in run.transitions.windows(2) {
            assert!((pair[1].0 - pair[0].0 - exact).abs() < 1e-11, "{method}");
        }
        let found = orbit(&run.system, &options(method));
        assert!(
            (found.period - exact).abs() < 1e-11,
            "{method}: {}",
            found.period
        );
        assert_eq!(found.family, 0);
        // Along the flow it is 1; gap and rate are annihilated, whatever moves.
        let all = multipliers(&found.monodromy);
        assert!((all[0].re - 1.0).abs() < 1e-9, "{method}: {all:?}");
        assert!(all[1..].iter().all(|one| one.norm() < 1e-9), "{all:?}");
        // The state after the impact follows its time alone, and so does the next one.
        let by = ["x", "v", "d"];
        let variables = Variables::named(&run.system, by).unwrap();
        let start = run.system.start().unwrap();
        let of = ((0.0, &start[..]), 25.0);
        let along = variables.along(&run.system, of, (&[25.0], &[]), &options(method));
        let along = along.unwrap();
        assert!(along.lost.is_none(), "{:?}", along.lost);
        let impacts: Vec<_> = along.transitions.iter().map(|at| at.t.clone()).collect();
        for (k, slopes) in impacts.iter().enumerate().skip(1) {
            assert!((slopes[0] - impacts[0][0]).abs() < 1e-9, "{method}, {k}");
            assert!((slopes[1] - impacts[0][1]).abs() < 1e-9, "{method}, {k}");
            let step = 1e-5;
            let by_d = (time_of_return(d + step) - time_of_return(d - step)) / (2.0 * step);
            let longer = slopes[2] - impacts[k - 1][2];
            assert!(
                (longer - by_d).abs() < 1e-7,
                "{method}, {k}: {longer}, {by_d}"
            );
        }
    }
}

#[test]
fn a_plastic_impact_carries_or_lets_go_as_the_reaction_pushes_or_pulls() {
    // In a period it meets the wall twice: where the force pulls it back at once, and where it
    // presses.
    let text = "name = \"driven\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nF = 1\n\
                [field]\nx = \"v\"\nv = \"-x - 0.1*v + F*cos(0.5*t)\"\n[stops.wall]\n\
                gap = \"0.3 - x\"\nacts = { v = -1 }\nrestitution = 0\n[start]\nx = 0\nv = 0\n\
                [time]\nend = 20\nperiod = \"4*pi\"\n";
    for method in METHODS {
        let driven = system(text);
        let found = orbit(&driven, &options(method));
        assert!((found.period - 4.0 * PI).abs() < 1e-12);
        assert_eq!(found.family, 0);
        let all = multipliers(&found.monodromy);
        assert!(all.iter().all(|one| one.norm() < 1e-9), "{all:?}");
        // It lifts off where F cos(t/2) = 0.3 on the way down, once in two impacts.
        let lifts = 2.0 * math::acos(0.3);
        let run = Run::of(driven, &options(method), Some(40.0 * PI));
        let times = |name: &str| {
            let of = run.transitions.iter().filter(|at| at.2 == name);
            of.map(|at| at.0).collect::<Vec<f64>>()
        };
        let (impacts, lift_offs) = (times("wall.impact"), times("wall.lift-off"));
        assert!(lift_offs.len() == 10 && impacts.len().abs_diff(20) <= 1);
        for t in lift_offs {
            let within = (t - lifts).rem_euclid(4.0 * PI);
            assert!(within.min(4.0 * PI - within) < 1e-10, "{method}: {t}");
        }
    }
}

/// Highest point of the flight from the wall.
fn apex(amplitude: f64) -> f64 {
    let lift = math::atan(1.0 / (amplitude * amplitude - 1.0).sqrt());
    let speed = |t: f64| lift - t + amplitude * (math::cos(lift) - math::cos(t));
    let (mut low, mut high) = (PI / 2.0, 2.0 * PI);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if speed(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let t = low;
    let flown = t - lift;
    -0.5 * flown * flown + amplitude * (flown * math::cos(lift) - math::sin(t) + 1.0 / amplitude)
}

#[test]
fn a_branch_with_rest_ends_where_the_reaction_stays() {
    for method in METHODS {
        let lifted = system(LIFTED);
        let found = branch(&lifted, ("A", 0.8, 2.2), &options(method));
        let all = numbers(&found);
        assert!(all.len() > 30, "{method}");
        assert!((all[0] - 1.0).abs() < 1e-9, "{method}: {}", all[0]);
        assert_eq!(all.last(), Some(&2.2));
        for point in found.points.iter().skip(1) {
            let (_, high) = point.extremes[0];
            let exact = apex(point.orbit.parameter);
            assert!(
                (high - exact).abs() < 1e-9,
                "{method}: {high}, exactly {exact}"
            );
            assert!(point.orbit.multipliers.iter().all(|one| one.norm() < 1e-9));
        }
    }
}

#[test]
fn a_branch_passes_impacts_that_accumulate() {
    let table = system(TABLE);
    let options = options("taylor");
    let found = branch(&table, ("A", 0.9, 1.4), &options);
    let all = numbers(&found);
    // Below 1 the table does not throw the ball.
    assert!((all[0] - 1.0).abs() < 1e-6, "{}", all[0]);
    assert_eq!(all.last(), Some(&1.4));
    for point in &found.points {
        let orbit = &point.orbit;
        let phases = table.sequence(&orbit.sequence);
        assert_eq!(phases, "table.lift-off table.landing");
        let here = with(TABLE, &[("A", orbit.parameter)]);
        let start = (orbit.t, orbit.x.as_slice()[..3].to_vec());
        // The orbit begins as the table throws the ball, and the run ends just behind that. At
        // A = 1 rounding decides the time.
        let run = Run::from(here, &options, (start.clone(), orbit.t + 2.0 * PI + 1e-9));
        let states = if orbit.parameter > 1.0 + 1e-6 { 3 } else { 2 };
        for (state, before) in ["h", "v", "table.closed"][..states].iter().zip(&start.1) {
            let after = run.end(state);
            assert!(
                (after - before).abs() < 1e-8,
                "{state} at {}: {after} and {before}",
                orbit.parameter
            );
        }
    }
}

#[test]
fn chatter_is_no_period_and_a_start_behind_a_stop_no_end() {
    let table = system(TABLE);
    let settings = RecurrenceSettings {
        forcing: Some(2.0 * PI),
        ..RecurrenceSettings::within(2000.0)
    };
    let reach = |x: [f64; 3]| {
        Attractor::of_any(table.dynamics(), x, &settings, &options("taylor")).unwrap()
    };
    for h in [0.5, 2.0, 3.0] {
        let AttractorKind::Periodic { period, .. } = reach([h, 0.0, 0.0]).kind else {
            panic!("{h}");
        };
        assert!((period - 2.0 * PI).abs() < 1e-9);
    }
    let behind = reach([-0.5, 0.0, 0.0]).kind;
    assert!(matches!(
        behind,
        AttractorKind::Failure(Error::BehindStop { .. })
    ));
}

/// A body on a table, both driven so that it stays on it; the field depends on its velocity. The
/// state y decays by itself, and a jump kicks it.
fn carried_with_drag(gap: &str, field: &str, kick: &str) -> String {
    let kick = match kick {
        "" => String::new(),
        when => format!("[jumps.kick]\nwhen = \"{when}\"\nset = {{ y = \"y + 1\" }}\n"),
    };
    format!(
        "name = \"carried\"\n[states]\nx = \"\"\nv = \"\"\ny = \"\"\n[stops.table]\n\
         gap = \"{gap}\"\n\
         acts = {{ v = 1 }}\nrestitution = 0.9\n{kick}[field]\nx = \"v\"\nv = \"{field}\"\n\
         y = \"-y\"\n[start]\nx = 0\nv = 0.5\ny = 0\n[time]\nend = 200\nperiod = \"2*pi\"\n"
    )
}

#[test]
fn a_landing_leaves_neither_gap_nor_rate_where_drag_acts() {
    let size = math::exp(-2.0 * PI);
    for kick in ["", "sin(3*t)"] {
        let text = carried_with_drag("x - 0.5*sin(t)", "-1 - 0.3*v", kick);
        for method in METHODS {
            let found = orbit(&system(&text), &options(method));
            let multipliers = multipliers(&found.monodromy);
            assert!(
                (multipliers[0].re - size).abs() < 1e-11,
                "{method}: {multipliers:?}"
            );
            assert!(multipliers[1..].iter().all(|one| one.norm() < 1e-12));
            let run = Run::of(system(&text), &options(method), Some(2000.0));
            let gap = run.end("x") - 0.5 * math::sin(2000.0);
            let rate = run.end("v") - 0.5 * math::cos(2000.0);
            assert!(
                gap.abs() < 1e-11 && rate.abs() < 1e-11,
                "{method}: {gap:e}, {rate:e}"
            );
        }
    }
}

#[test]
fn what_carries_is_not_hit_by_the_events_of_others() {
    let table = "x - 5*sin(t) - 3*sin(2.3*t)";
    let text = carried_with_drag(table, "-200 - 30*sin(x) - 0.3*v", "sin(3*t)");
    let text = text.replace("v = 0.5\n", "v = 11.9\n");
    let beside = "name = \"two\"\n[states]\nx = \"\"\nv = \"\"\nh = \"\"\nw = \"\"\n[stops.table]\n\
                  gap = \"x - 0.5*sin(t)\"\nacts = { v = 1 }\nrestitution = 0.9\n[stops.floor]\n\
                  gap = \"h\"\nacts = { w = 1 }\nrestitution = 0.95\n[field]\nx = \"v\"\n\
                  v = \"-1 - x^3\"\nh = \"w\"\nw = -1\n[start]\nx = 0\nv = 0.5\nh = 3\nw = 0\n\
                  [time]\nend = 80\n";
    for method in METHODS {
        for tolerance in [1e-12, 1e-9, 1e-7] {
            for text in [&text, beside] {
                let options = Options {
                    rtol: tolerance,
                    atol: tolerance.into(),
                    ..options(method)
                };
                let run = Run::of(system(text), &options, None);
                assert!(run.ended.is_ok(), "{}", run.words());
                let of_table = run
                    .transitions
                    .iter()
                    .filter(|at| at.2.starts_with("table"));
                let names: Vec<&str> = of_table.map(|at| at.2.as_str()).collect();
                assert_eq!(names, ["table.landing"], "{method}, {tolerance:e}");
            }
        }
    }
}

#[test]
fn equilibria_end_where_a_gap_or_a_reaction_vanishes() {
    let text = "name = \"held\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nq = 1\n[stops.wall]\n\
                gap = \"x\"\nacts = { v = 1 }\nrestitution = 0.5\n[field]\nx = \"v\"\n\
                v = \"-0.5*v - (x - q)\"\n[start]\nx = 1\nv = 0\n[time]\nend = 50\n";
    let (settings, options) = (ContinuationSettings::over(-1.0, 1.0), options("taylor"));
    let ends = |q: f64, start: [f64; 3]| {
        let held = with(text, &[("q", q)]);
        let along = ParameterLine::new(&held, "q", (-1.0, 1.0)).unwrap();
        let found = along.equilibria(&start, &settings, &options).unwrap();
        for one in &found.special {
            let EquilibriumBifurcation::Boundary { contact, .. } = one.what else {
                panic!("{one:?}");
            };
            assert_eq!(held.surface(contact), "the stop wall");
        }
        let at = found.special.iter().map(|one| one.parameter);
        let all = found.points.iter().map(|one| one.parameter);
        (all.collect::<Vec<f64>>(), at.collect::<Vec<f64>>())
    };
    let (open, at) = ends(1.0, [1.0, 0.0, 0.0]);
    assert!(open.iter().all(|q| *q > 0.0) && at.len() == 1 && at[0].abs() < 1e-12);
    let (closed, at) = ends(-0.5, [0.0, 0.0, 1.0]);
    assert!(closed.iter().all(|q| *q < 0.0) && at.len() == 1 && at[0].abs() < 1e-12);
}

#[test]
fn sides_of_contacts_that_cancel_do_not_hide_that_a_reaction_depends_on_them() {
    let text = "name = \"sides\"\n[states]\nv = \"\"\nu = \"\"\nh = \"\"\nw = \"\"\n[contacts.a]\n\
                boundary = \"v\"\nfriction = 0.1\n[contacts.b]\nboundary = \"u\"\nfriction = 0.1\n\
                [stops.floor]\ngap = \"h\"\nacts = { w = 1 }\nrestitution = 0\n[field]\n\
                v = \"1 - friction(a)\"\nu = \"-1 - friction(b)\"\nh = \"w\"\nw = \"-1 + a - b\"\n\
                [time]\nend = 3\n";
    let file = stickslip_model::file::SystemFile::parse(stickslip_model::file::Source {
        name: "system.toml".to_owned(),
        text: text.to_owned(),
    });
    let made = file.and_then(|file| {
        file.with(&[]).map_err(|error| match error {
            stickslip_model::file::SettingError::File(error) => error,
            other => panic!("{other}"),
        })
    });
    let error = made.err().unwrap().to_string();
    assert!(
        error.contains("depends on the side of a contact"),
        "{error}"
    );
}

#[test]
fn a_condition_does_not_hide_impacts_that_accumulate() {
    let text = "name = \"bounces\"\n[states]\nx = \"\"\nv = \"\"\n[jumps.a]\nwhen = \"x - 0.5\"\n\
                direction = \"falling\"\nif = \"v < 0\"\nset = { v = \"-0.9*v\" }\n[field]\n\
                x = \"v\"\n\
                v = \"-x\"\n[start]\nx = -1\nv = 0\n[time]\nend = 40\n";
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        assert!(
            matches!(run.ended, Err(Error::EventPileUp { .. })),
            "{:?}",
            run.ended
        );
    }
}

#[test]
fn reactions_that_vanish_at_once_open_the_stop_that_pulls() {
    // A ball on another one on a floor; from t = 1 on a force lifts the upper one.
    let text = "name = \"stack\"\n[states]\nx = \"\"\nu = \"\"\ny = \"\"\nv = \"\"\n[inputs.on]\n\
                shape = \"table\"\ntimes = [1, 1]\nvalues = [0, 1]\nbetween = \"constant\"\n\
                [stops.floor]\ngap = \"x\"\nacts = { u = 1 }\nrestitution = 0.5\n[stops.pair]\n\
                gap = \"y - x\"\nacts = { u = -1, v = 1 }\nrestitution = 0.5\n[field]\nx = \"u\"\n\
                u = -5\ny = \"v\"\nv = \"-5 + 15*on\"\n[start]\nx = 0\nu = 0\ny = 0\nv = 0\n\
                [time]\nend = 2\n";
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        assert!(run.ended.is_ok(), "{}", run.words());
        let state = ["x", "y", "floor.closed", "pair.closed"].map(|name| run.end(name));
        for (found, exact) in state.into_iter().zip([0.0, 5.0, 1.0, 0.0]) {
            assert!((found - exact).abs() < 1e-9, "{method}: {state:?}");
        }
    }
}

#[test]
fn a_start_at_which_a_jump_is_undefined_is_no_end_of_a_sweep() {
    let text = "name = \"root\"\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nn = 0\n[jumps.j]\n\
                when = \"sqrt(x + 1) - 2\"\nset = { n = \"n + 1\" }\n[field]\nx = \"v\"\n\
                v = \"-x - 0.1*v\"\n[start]\nx = 0.5\nv = 0\n[time]\nend = 5\n";
    let (system, settings) = (system(text), RecurrenceSettings::within(2000.0));
    let reach = |x: f64| {
        let start = [x, 0.0, 0.0];
        Attractor::of_any(system.dynamics(), start, &settings, &options("taylor")).unwrap()
    };
    assert_eq!(reach(0.5).kind, AttractorKind::Equilibrium);
    let outside = reach(-1.5).kind;
    assert!(
        matches!(outside, AttractorKind::Failure(Error::Undefined { .. })),
        "{outside:?}"
    );
}

#[test]
fn a_period_that_a_parameter_changes_is_written_with_it() {
    let text = "name = \"driven\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nom = 0.8\n[field]\n\
                x = \"v\"\nv = \"-x - 0.3*v + 0.5*cos(om*t)\"\n[time]\nend = 9\nperiod = PERIOD\n";
    let constant = system(&text.replace("PERIOD", "7.853981633974483"));
    let refused = ParameterLine::new(&constant, "om", (0.5, 1.5))
        .err()
        .unwrap();
    let words = refused.to_string();
    assert!(
        words.contains("write the period as a formula of `om`"),
        "{words}"
    );
    let formula = system(&text.replace("PERIOD", "\"2*pi/om\""));
    assert!(ParameterLine::new(&formula, "om", (0.5, 1.5)).is_ok());
}

#[test]
fn a_ball_whose_steps_end_at_impacts_is_not_below_its_tolerance() {
    struct Names;
    impl stickslip_model::file::Interface for Names {
        fn name(&self, option: &str) -> String {
            option.to_owned()
        }
        fn choice(&self, option: &str, _: &[&str]) -> String {
            option.to_owned()
        }
        fn value(&self, option: &str, _: f64) -> String {
            option.to_owned()
        }
        fn nearer(&self) -> &'static str {
            ""
        }
    }
    let table = system(TABLE);
    let start = [0.0, 1.0, 0.0];
    let mut monitor = StepMonitor::new(&table, (0.0, &start), 1.0, &options("taylor"));
    let end = |h: f64| Vector::from_column_slice(&[h, -0.5, 0.0]);
    let step = Step {
        mode: Modes::new(&[]),
        t_start: 0.0,
        t_end: 0.5,
        x_start: Vector::from_column_slice(&start),
        x_end: end(1e-17),
    };
    monitor.step(&step, &Names);
    assert!(monitor.looks_within());
    assert_eq!(monitor.below_tolerance(&table, &Names).len(), 1);
    monitor.reaches(end(0.1).as_slice());
    assert!(monitor.below_tolerance(&table, &Names).is_empty());
}

/// A block that slides on a table after the impacts of its fall have accumulated.
const FALLS: &str = r#"name = "Falling block"
[states]
x = ""
u = ""
h = ""
w = ""
[parameters]
r = 0.5
[field]
x = "u"
u = "-friction(sole)"
h = "w"
w = -10
[contacts.sole]
boundary = "u"
friction = "0.1*floor.force"
[stops.floor]
gap = "h"
acts = { w = 1 }
restitution = "r"
[start]
x = 0
u = 5
h = 5
w = 0
[time]
end = 4
"#;

#[test]
fn derivatives_know_when_impacts_accumulate() {
    // The impacts accumulate at T = (1 + 2 r/(1 - r)) sqrt(2 h/g), and the block then slows down by
    // 1: dT/dh = 0.3, and dT/dr = 8.
    let system = system(FALLS);
    for method in METHODS {
        let names = ["r", "h", "u", "w"];
        let found = found(&system, &names, &[4.0], method);
        assert!(found.lost.is_none(), "{:?}", found.lost);
        let landing = found.transitions.last().unwrap();
        for (column, [time, x, u]) in [[8.0, 8.0, 8.0], [0.3, 0.3, 0.3], [0.0, 4.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            let own = &found.states[0];
            for (found, wanted) in [
                (landing.t[column], time),
                (own[(0, column)], x),
                (own[(1, column)], u),
                (own[(2, column)], 0.0),
                (own[(3, column)], 0.0),
            ] {
                let off = (found - wanted).abs();
                assert!(
                    off < 1e-6,
                    "{method}, {}: {found} for {wanted}",
                    names[column]
                );
            }
        }
    }
}

/// The last impacts follow each other in less than the rounding of their time.
#[test]
fn derivatives_know_when_impacts_accumulate_at_any_restitution() {
    for (height, r) in [
        (0.3, 0.3),
        (0.3, 0.51),
        (0.7, 0.6),
        (0.2, 0.8),
        (0.01, 0.95),
    ] {
        let text = FALLS.replace("h = 5", &format!("h = {height}"));
        let system = with(&text, &[("r", r)]);
        let fall = (height / 5.0_f64).sqrt();
        let end = fall * (1.0 + r) / (1.0 - r);
        let wanted = [2.0 * fall / ((1.0 - r) * (1.0 - r)), end / (2.0 * height)];
        for method in METHODS {
            let found = found(&system, &["r", "h"], &[4.0], method);
            assert!(found.lost.is_none(), "{:?}", found.lost);
            let landing = found.transitions.last().unwrap();
            for (column, time) in wanted.into_iter().enumerate() {
                let own = &found.states[0];
                for (found, wanted) in [
                    (landing.t[column], time),
                    (own[(0, column)], (4.0 - end) * time),
                    (own[(1, column)], time),
                ] {
                    let off = (found - wanted).abs() / wanted;
                    assert!(off < 1e-8, "{method}, {height}, {r}: {found} for {wanted}");
                }
            }
        }
    }
}

/// A ball with the fall time 1 whose bounces are a jump: the impact `n` is at
/// `1 + 2 (r + … + r^(n - 1))`. The height of the last flights is below the tolerance.
#[test]
fn impacts_of_a_jump_that_accumulate_are_no_grazes() {
    const BALL: &str = r#"name = "Ball"
[states]
h = ""
w = ""
[parameters]
r = 0.6
[field]
h = "w"
w = -10
[jumps.bounce]
when = "h"
direction = "falling"
set = { w = "-r*w" }
[start]
h = 5
w = 0
[time]
end = 4
"#;
    let system = system(BALL);
    let r: f64 = 0.6;
    for method in METHODS {
        let found = found(&system, &["r", "h"], &[4.0 - 1e-7], method);
        // What location by Dop853 leaves of the last gaps counts as another jump's.
        let is_chained = matches!(found.lost, Some(Error::ChainedJumps { .. }));
        let rows = found.transitions.iter();
        let known = rows.take_while(|at| at.t[0].is_finite()).count();
        match method {
            "taylor" => assert!(found.lost.is_none() && known > 30, "{:?}", found.lost),
            _ => assert!(is_chained && known > 10, "{:?}", found.lost),
        }
        let (mut time, mut slope) = (1.0, 0.0);
        for (n, at) in (1..).zip(&found.transitions[..known]) {
            for (found, wanted) in [(at.at, time), (at.t[0], slope), (at.t[1], 0.1 * time)] {
                let off = (found - wanted).abs();
                assert!(off < 1e-7, "{method}, impact {n}: {found} for {wanted}");
            }
            time += 2.0 * math::powi(r, n);
            slope += 2.0 * f64::from(n) * math::powi(r, n - 1);
        }
    }
}

/// An oscillator that beats against a wall: without impacts, its amplitude is the distance of the
/// wall where `A² = (1 - w²)² + (2 z w)²`. An orbit with impacts ends there.
#[test]
fn a_branch_of_impacts_ends_where_its_orbit_grazes_the_stop() {
    const BEATS: &str = r#"name = "Impact oscillator"
[states]
x = ""
v = ""
[parameters]
A = 0.6
w = 0.8
z = 0.1
[stops.wall]
gap = "1 - x"
acts = { v = -1 }
restitution = 0.8
[field]
x = "v"
v = "-2*z*v - x + A*cos(w*t)"
[start]
x = 0
v = 0
[time]
end = 100
period = "2*pi/w"
"#;
    for (z, method) in [(0.1, "taylor"), (0.1, "dop853"), (0.15, "taylor")] {
        let system = with(BEATS, &[("z", z)]);
        let branch = branch(&system, ("A", 0.3, 0.7), &options(method));
        let exact = (0.36_f64 * 0.36 + 4.0 * z * z * 0.64).sqrt();
        let graze = &branch.special[0];
        assert_eq!(graze.what.to_string(), "grazing of a jump", "{method}, {z}");
        let (off, uncertainty) = ((graze.parameter - exact).abs(), graze.uncertainty);
        assert!(
            off <= uncertainty && uncertainty < 1e-6,
            "{method}, {z}: {off:e} {uncertainty:e}"
        );
    }
}

#[test]
fn a_restitution_of_zero_leaves_no_speed_by_its_derivative() {
    let plastic = with(FALLS, &[("r", 0.0)]);
    for method in METHODS {
        let found = found(&plastic, &["r", "h"], &[4.0], method);
        let own = &found.states[0];
        assert_eq!(
            [own[(2, 0)], own[(3, 0)], own[(2, 1)], own[(3, 1)]],
            [0.0; 4]
        );
        // The block lands with the first impact: dT/dh = 1/10. With a small r it is in flight for
        // 2 r longer.
        assert!(
            (own[(1, 0)] - 2.0).abs() < 1e-9,
            "{method}: {}",
            own[(1, 0)]
        );
        assert!(
            (own[(1, 1)] - 0.1).abs() < 1e-9,
            "{method}: {}",
            own[(1, 1)]
        );
    }
}

#[test]
fn what_no_stop_acts_on_moves_through_landings_as_if_there_were_none() {
    let text = r#"name = "Beside a ball"
[states]
x = ""
v = ""
c = ""
y = ""
u = ""
[field]
x = "v"
v = "-100*x"
c = 1000
y = "u"
u = -1
[stops.table]
gap = "y - 1.2*sin(t)"
acts = { u = 1 }
restitution = 0.4
[start]
x = 1
v = 0
c = 0
y = 0.5
u = 0
[time]
end = 60
"#;
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        let landings = run.transitions.iter();
        let landings = landings.filter(|(_, _, what)| what == "table.landing");
        assert!(landings.count() > 5, "{method}");
        assert!(
            (run.end("c") - 6e4).abs() < 1e-8,
            "{method}: {}",
            run.end("c")
        );
        let exact = math::cos(600.0);
        assert!(
            (run.end("x") - exact).abs() < 1e-8,
            "{method}: {}",
            run.end("x") - exact
        );
    }
}

#[test]
fn a_body_lifts_off_however_light_it_is() {
    let text = |m: &str| {
        TABLE
            .replace("v = 1 }", &format!("v = \"1/{m}\" }}"))
            .replace("end = 20", "end = 8.5")
    };
    let thrown = |m: &str| Run::of(system(&text(m)), &options("taylor"), None);
    let heavy = thrown("1");
    assert!(
        heavy
            .transitions
            .iter()
            .any(|(_, _, what)| what == "table.lift-off")
    );
    for m in ["1e-20", "1e-13", "1e20"] {
        let other = thrown(m);
        assert_eq!(other.transitions.len(), heavy.transitions.len(), "{m}");
        assert!((other.end("h") - heavy.end("h")).abs() < 1e-9, "{m}");
    }
}

/// A driven block with friction in front of a wall.
const DRIVEN: &str = r#"name = "Block in front of a wall"
[states]
x = ""
v = ""
[parameters]
F = 0.9
mu = 0.05
[stops.wall]
gap = "0.4 - x"
acts = { v = -1 }
restitution = 0.6
[contacts.sole]
boundary = "v"
friction = "mu"
[field]
x = "v"
v = "-x - 0.1*v + F*cos(1.3*t) - friction(sole)"
[start]
x = 0.1
v = 0
[time]
end = 20
period = "2*pi/1.3"
"#;

/// The block on a floor that carries it, with the friction of that reaction.
fn on_a_floor() -> String {
    DRIVEN
        .replace("[parameters]", "y = \"\"\nu = \"\"\n[parameters]")
        .replace(
            "[contacts.sole]",
            "[stops.floor]\ngap = \"y\"\nacts = { u = 1 }\nrestitution = 0.3\n[contacts.sole]",
        )
        .replace("\"mu\"", "\"mu*floor.force\"")
        .replace(
            "[start]",
            "y = \"u\"\nu = -1\n[start]\ny = 0\nu = 0\nfloor.closed = 1",
        )
}

#[test]
fn a_floor_that_carries_changes_no_derivative_at_the_impacts_of_a_wall() {
    let texts = [DRIVEN.to_owned(), on_a_floor()];
    for method in METHODS {
        let names = ["F", "mu", "x", "v"];
        let [free, carried] = texts.each_ref().map(|text| {
            let found = found(&system(text), &names, &[19.0], method);
            assert!(found.lost.is_none(), "{:?}", found.lost);
            found.states[0].rows(0, 2).into_owned()
        });
        let impacts = Run::of(system(DRIVEN), &options(method), Some(19.0));
        let impacts = impacts
            .transitions
            .iter()
            .filter(|at| at.2.starts_with("wall"));
        assert!(impacts.count() >= 3, "{method}");
        let off = (&free - &carried).amax();
        assert!(off < 1e-8 * free.amax(), "{method}: {free} {carried}");
        // Against differences of runs.
        let end = |h: f64| {
            let run = Run::of(
                with(&texts[1], &[("F", 0.9 + h)]),
                &options(method),
                Some(19.0),
            );
            [run.end("x"), run.end("v")]
        };
        let (above, below) = (end(1e-5), end(-1e-5));
        for (row, name) in ["x", "v"].into_iter().enumerate() {
            let by_runs = (above[row] - below[row]) / 2e-5;
            let off = (carried[(row, 0)] - by_runs).abs();
            assert!(off < 1e-5 * free.amax(), "{method}, {name}: {by_runs}");
        }
        let [free, carried] = texts.each_ref().map(|text| {
            let found = orbit(&system(text), &options(method));
            let mut found = multipliers(&found.monodromy);
            found.sort_by(|a, b| (b.norm(), b.im).partial_cmp(&(a.norm(), a.im)).unwrap());
            found
        });
        for (free, carried) in free.iter().zip(&carried) {
            assert!((free - carried).norm() < 1e-8, "{method}: {free} {carried}");
        }
        assert!(
            carried[2..].iter().all(|one| one.norm() < 1e-8),
            "{carried:?}"
        );
    }
}

/// Two wells; a wall in front of one of them holds a body.
const WELLS: &str = r#"name = "Wells"
[states]
x = ""
v = ""
[field]
x = "v"
v = "x - x^3 - 0.2*v"
[stops.wall]
gap = "0.5 - x"
acts = { v = -1 }
restitution = 0.6
[start]
x = 0
v = 0.3
"#;

#[test]
fn a_body_at_rest_on_a_stop_is_pushed_off_it() {
    let system = system(WELLS);
    let (within, options) = (RecurrenceSettings::within(1000.0), options("taylor"));
    let how = PushSettings::up_to(2.0);
    // The wall gives back 0.6 of a push against it.
    let directions = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    let rest = [0.5, 0.0, 1.0];
    let found = Push::least(system.dynamics(), rest, directions, &how, &within, &options);
    let [against, off] = found.unwrap().try_into().unwrap();
    let [against, off] = [against, off].map(|push: Option<Push>| push.unwrap().size);
    assert!((off / against - 0.6).abs() < 1e-7, "{off} and {against}");

    // A start cannot lie behind the wall, and one in front of it comes back.
    let into = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let near = [0.5 - 0.125, 0.0, 0.0];
    let found = Push::least(system.dynamics(), near, into, &how, &within, &options).unwrap();
    let [Some(into), Some(off)] = &found[..] else {
        panic!("{found:?}");
    };
    assert!(into.ends_at_stop && !off.ends_at_stop);
    assert!((into.size - 0.125).abs() < 1e-8, "{}", into.size);
    assert!((off.size - 0.375).abs() < 1e-7, "{}", off.size);

    // The edge between both basins is the saddle.
    let how = EdgeSettings::within(200.0);
    let edge = EdgeState::between(
        system.dynamics(),
        [-1.0, 0.0, 0.0],
        rest,
        &how,
        &within,
        &options,
    );
    let edge = edge.unwrap();
    assert_eq!(edge.kind, EdgeKind::Equilibrium);
    assert!(edge.x.as_slice()[0].abs() < 1e-9, "{:?}", edge.x);
}
