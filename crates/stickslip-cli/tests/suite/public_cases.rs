//! Published test systems, from files, compared with closed forms, by both methods.

use std::f64::consts::PI;

use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;
use stickslip::math;

pub const METHODS: [&str; 2] = ["taylor", "dop853"];

/// A transition: time, kind, contact.
pub type Transition = (f64, String, String);

/// The program, in a folder with the system in `text` as `system.toml`.
pub fn program(text: &str) -> (tempfile::TempDir, Command) {
    let top = tempfile::tempdir().unwrap();
    std::fs::write(top.path().join("system.toml"), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(top.path());
    (top, command)
}

/// The results of `stickslip simulate` for the system in `text`, and its transitions without the
/// kinks of inputs.
pub fn simulated(text: &str, method: &str, arguments: &[&str]) -> (Value, Vec<Transition>) {
    let (found, mut transitions) = simulated_with_kinks(text, method, arguments);
    transitions.retain(|(_, kind, _)| kind != "kink" && kind != "switch");
    (found, transitions)
}

/// As [`simulated`], with the kinks.
pub fn simulated_with_kinks(
    text: &str,
    method: &str,
    arguments: &[&str],
) -> (Value, Vec<Transition>) {
    let (top, mut command) = program(text);
    command.args([
        "simulate",
        "system.toml",
        "--json",
        "--out",
        "out",
        "--method",
        method,
    ]);
    let output = command
        .args(arguments)
        .assert()
        .success()
        .get_output()
        .clone();
    let found = serde_json::from_slice(&output.stdout).unwrap();
    let mut table = csv::Reader::from_path(top.path().join("out/transitions.csv")).unwrap();
    let rows = table.records().map(|row| {
        let row = row.unwrap();
        (
            row[0].parse().unwrap(),
            row[1].to_owned(),
            row[2].to_owned(),
        )
    });
    (found, rows.collect())
}

pub fn end(found: &Value, state: &str) -> f64 {
    found["x_end"][state].as_f64().unwrap()
}

/// A block with friction 0.7 on a belt with the speed `belt`.
fn on_belt(belt: &str, start: [f64; 2]) -> String {
    let [x, v] = start;
    format!(
        "name = \"belt\"\n[time]\nend = 3\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\n\
         boundary = \"v - ({belt})\"\nfriction = \"0.7\"\n[field]\nx = \"v\"\n\
         v = \"-x - friction(belt)\"\n[start]\nx = {x}\nv = {v}\n"
    )
}

#[test]
fn a_margin_that_jumps_below_zero_ends_stick_at_the_kink() {
    // The belt brakes until t = 1. Otherwise the spring, stretched by one, would exceed friction.
    let text = on_belt("max(1 - t, 0)", [0.5, 1.0]);
    for method in METHODS {
        let (found, transitions) = simulated(&text, method, &[]);
        let [(t, kind, _)] = &transitions[..] else {
            panic!("{transitions:?}");
        };
        assert_eq!(kind, "stick exit");
        assert!((t - 1.0).abs() < 1e-11, "{method}: {t}");
        let exact = 0.7 + 0.3 * math::cos(2.0);
        assert!((end(&found, "x") - exact).abs() < 1e-10, "{method}");
    }
}

#[test]
fn a_margin_that_jumps_at_the_start_ends_stick_there() {
    // The belt, at rest until t = 0, accelerates more than friction 0.7 allows the block.
    let text = on_belt("max(0, 2*t)", [0.0, 0.0]);
    for method in METHODS {
        for tolerance in ["1e-12", "1e-5"] {
            let end_at = ["--t-end", "0.5", "--tol", tolerance];
            let (found, transitions) = simulated(&text, method, &end_at);
            let [(t, kind, _)] = &transitions[..] else {
                panic!("{method}: {transitions:?}");
            };
            assert!(
                kind == "stick exit" && *t < 1e-15,
                "{method}: {kind} at {t}"
            );
            let exact = 0.7 * (1.0 - math::cos(0.5));
            assert!((end(&found, "x") - exact).abs() < 1e-5, "{method}");
        }
    }
}

#[test]
fn a_margin_that_jumps_and_stays_positive_ends_nothing() {
    // Each jump of the belt's acceleration leaves the force below the friction limit.
    let text = on_belt("0.1*abs(sin(t)) - 0.05", [0.0, -0.05]);
    for method in METHODS {
        let (found, transitions) = simulated(&text, method, &["--t-end", "30"]);
        assert_eq!(transitions, [], "{method}");
        // Nine half waves and the rest of the tenth.
        let ridden = 0.1 * (18.0 + 1.0 - math::cos(30.0 - 9.0 * PI)) - 1.5;
        assert!((end(&found, "x") - ridden).abs() < 1e-10, "{method}");
    }
}

#[test]
fn fields_that_agree_and_lie_along_the_boundary_are_left_once() {
    // A free body beside a boundary that starts to move at t = 1.
    let text = "name = \"free\"\n[time]\nend = 3\n[states]\nx = \"\"\nv = \"\"\n\
        [contacts.wall]\nboundary = \"v - max(t - 1, 0)\"\n[field]\nx = \"v\"\nv = \"0*wall\"\n\
        [start]\nx = 0\nv = 0\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, &[]);
        let [(t, kind, _)] = &transitions[..] else {
            panic!("{transitions:?}");
        };
        assert_eq!(kind, "stick exit");
        assert!((t - 1.0).abs() < 1e-9, "{method}: {t}");
        assert!(end(&found, "x").abs() < 1e-10 && end(&found, "v").abs() < 1e-10);
    }
}

#[test]
fn without_a_normal_force_there_is_no_friction() {
    // A bead on a circular rail. It slides up, loses contact, turns, and meets the rail again. The
    // law changes its sign with the normal force, which would then push.
    let text = "name = \"bead\"\n[time]\nend = 1.9\n[states]\nph = \"rad\"\nw = \"rad/s\"\n\
        [parameters]\ng = 9.81\nR = 5\nmu = 0.05\n[contacts.rail]\nboundary = \"w\"\n\
        friction = \"mu*(g*cos(ph)/R + w^2)\"\nnormal_force = \"g*cos(ph) + R*w^2\"\n\
        [field]\nph = \"w\"\nw = \"-g/R*sin(ph) - friction(rail)\"\n\
        [start]\nph = 0\nw = \"14/5\"\n";
    for method in METHODS {
        let (_, lost) = simulated(text, method, &[]);
        let kinds: Vec<&str> = lost.iter().map(|(_, kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, ["contact loss", "crossing"]);
        assert!((lost[0].0 - 1.046_539_051_912).abs() < 1e-9, "{method}");
        let turn = lost[1].0.to_string();
        let (at_loss, _) = simulated(text, method, &["--t-end", "1.046539051912"]);
        let (at_turn, _) = simulated(text, method, &["--t-end", &turn]);
        let (ph, w) = (end(&at_loss, "ph"), end(&at_loss, "w"));
        // Without friction energy is conserved.
        let turns_at = math::acos(math::cos(ph) - 5.0 * w * w / (2.0 * 9.81));
        assert!((end(&at_turn, "ph") - turns_at).abs() < 1e-9, "{method}");
    }
}

#[test]
fn a_law_that_does_not_vanish_with_the_normal_force_ends_with_it() {
    // Constant friction 1. The contact is lost at t = 1 and regained at t = 2.
    let text = "name = \"lifted\"\n[time]\nend = 4\n[states]\nx = \"\"\nv = \"\"\n\
        [contacts.floor]\nboundary = \"v\"\nfriction = \"1\"\nnormal_force = \"(t - 1)*(t - 2)\"\n\
        [field]\nx = \"v\"\nv = \"0.5 - friction(floor)\"\n[start]\nx = 0\nv = 0\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, &[]);
        assert_eq!(transitions.len(), 4, "{method}: {transitions:?}");
        // At rest until it is lifted, pushed by 0.5 for one time unit, then braked by 0.5 to rest.
        let mut kinds = transitions.clone();
        kinds.sort_by(|one, other| one.1.cmp(&other.1));
        for ((t, kind, _), (at, name)) in kinds.iter().zip([
            (2.0, "contact gain"),
            (1.0, "contact loss"),
            (3.0, "stick entry"),
            (1.0, "stick exit"),
        ]) {
            assert_eq!(kind, name, "{method}");
            assert!((t - at).abs() < 1e-9, "{method}: {name} at {t}");
        }
        assert!((end(&found, "x") - 0.5).abs() < 1e-9, "{method}");
    }
}

/// A block with friction 1 on a floor, with a stiffer spring beyond `x = 0`.
fn with_stop(push: &str, start: [f64; 2]) -> String {
    let [x, v] = start;
    format!(
        "name = \"stop\"\n[time]\nend = 3\n[states]\nx = \"\"\nv = \"\"\n\
         [contacts.place]\nboundary = \"x\"\n[contacts.floor]\nboundary = \"v\"\nfriction = \"1\"\n\
         [field]\nx = \"v\"\nv = \"-by_side(place, 1, 3)*x + {push} - friction(floor)\"\n\
         [start]\nx = {x}\nv = {v}\n"
    )
}

#[test]
fn a_place_and_its_velocity_that_vanish_together_are_decided_together() {
    for method in METHODS {
        // From x = 0: away from it on either side, or held there.
        let to_right = simulated(&with_stop("3", [0.0, 0.0]), method, &["--t-end", "1"]).0;
        let exact = 2.0 / 3.0 * (1.0 - math::cos(3.0_f64.sqrt()));
        assert!((end(&to_right, "x") - exact).abs() < 1e-10, "{method}");
        let to_left = simulated(&with_stop("-3", [0.0, 0.0]), method, &["--t-end", "1"]).0;
        let exact = -2.0 * (1.0 - math::cos(1.0));
        assert!((end(&to_left, "x") - exact).abs() < 1e-10, "{method}");
        let (held, transitions) = simulated(&with_stop("0.9", [0.0, 0.0]), method, &[]);
        assert_eq!(
            (end(&held, "x"), transitions),
            (0.0, Vec::new()),
            "{method}"
        );
        // To x = 0, where it comes to rest: half a circle about -1 from -2.
        let (arrived, transitions) =
            simulated(&with_stop("0", [-2.0, 0.0]), method, &["--t-end", "9"]);
        let (t, kind, contact) = transitions.last().unwrap();
        assert_eq!((kind.as_str(), contact.as_str()), ("stick entry", "floor"));
        assert!((t - PI).abs() < 1e-8, "{method}: {t}");
        assert!(end(&arrived, "x").abs() < 1e-9, "{method}");
        // Driven from rest there, to either side.
        for sign in [1.0, -1.0] {
            let push = format!("{}*sin(t)", 1.5 * sign);
            let text = with_stop(&push, [0.0, 0.0]);
            let (driven, transitions) = simulated(&text, method, &["--t-end", "1"]);
            let (t, kind, contact) = &transitions[0];
            assert_eq!((kind.as_str(), contact.as_str()), ("stick exit", "floor"));
            let exact = PI / 2.0 - math::acos(1.0 / 1.5);
            assert!((t - exact).abs() < 1e-10, "{method}: {t}");
            assert!(sign * end(&driven, "x") > 0.0, "{method}");
        }
    }
}

#[test]
fn an_orbit_that_shrinks_to_a_point_of_the_boundary_ends_there() {
    let text = "name = \"focus\"\n[time]\nend = 1e6\n[states]\nx = \"\"\nv = \"\"\n\
        [contacts.line]\nboundary = \"x - 0.3*v\"\n[field]\nx = \"v\"\n\
        v = \"-by_side(line, 1.2, 1.05)*x - by_side(line, 0.2, 0.05)*v\"\n\
        [start]\nx = 0.3\nv = 0\n";
    for method in METHODS {
        let (found, _) = simulated(text, method, &["--tol", "1e-10"]);
        assert_eq!(
            found["ending"], "shrunk to a point of the boundary",
            "{method}"
        );
        assert!(end(&found, "x").abs() < 1e-8, "{method}");
    }
}

#[test]
fn crossings_without_end_are_limited() {
    // Both fields rotate about the point (0.75, 0.6) and grow: a focus on the boundary.
    let text = "name = \"ocean\"\n\
        [time]\n\
        end = 60\n\
        [states]\n\
        T = \"\"\n\
        S = \"\"\n\
        [contacts.mixing]\n\
        boundary = \"S - 0.8*T\"\n\
        [field]\n\
        T = \"1 - T - by_side(mixing, 0, 1)*T\"\n\
        S = \"0.5*(1 - S) - by_side(mixing, 0, 1)*S\"\n\
        [start]\n\
        T = 0.9\n\
        S = 0.6\n";
    let (_top, mut command) = program(text);
    command.args(["simulate", "system.toml", "--most-events", "2000"]);
    command
        .assert()
        .code(1)
        .stdout(contains("2000 × crossing"))
        .stderr(contains("more than 2000 transitions by t = "));
    let (_top, mut command) = program(text);
    command.args(["simulate", "system.toml", "--most-steps", "100"]);
    command
        .assert()
        .code(1)
        .stderr(contains("more than 100 steps by t = "));
}

/// From springs of 1e6 on, points beside the ends of the set are reported: README, "what can hide".
#[test]
fn a_block_that_friction_holds_rests_on_one_set() {
    for (k, c) in [("100", "0"), ("1000", "30"), ("1e4", "0"), ("3", "0.1")] {
        let text = format!(
            "name = \"held\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nk = {k}\nc = {c}\n\
             [contacts.floor]\nboundary = \"v\"\nfriction = \"0.3\"\n[field]\nx = \"v\"\n\
             v = \"k*(1 - x) - c*v - friction(floor)\"\n[start]\nx = 1\nv = 0\n"
        );
        let (_top, mut command) = program(&text);
        command.args(["basin", "system.toml", "--json", "--grid", "6x6"]);
        command.args(["--x", "x=0.9:1.1", "--y", "v=-0.5:0.5"]);
        let output = command.assert().success().get_output().stdout.clone();
        let found: Value = serde_json::from_slice(&output).unwrap();
        let attractors = found["attractors"].as_array().unwrap();
        assert_eq!(attractors.len(), 1, "k = {k}: {attractors:?}");
        let motion = attractors[0]["motion"].as_str().unwrap();
        assert!(motion.starts_with("set of equilibria"), "k = {k}: {motion}");
    }
}

/// Blocks on springs of stiffness 1, from 1.05, 1.15, 1.25, …; the first ones have friction with
/// the floor.
fn row_of_blocks(count: usize, rubbing: usize) -> String {
    let each = |line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let contact = |k| format!("[contacts.c{k}]\nboundary = \"v{k}\"\nfriction = \"0.3\"\n");
    let rate = |k| match k < rubbing {
        true => format!("x{k} = \"v{k}\"\nv{k} = \"-x{k} - friction(c{k})\"\n"),
        false => format!("x{k} = \"v{k}\"\nv{k} = \"-x{k}\"\n"),
    };
    format!(
        "name = \"row\"\n[states]\n{}[start]\n{}[time]\nend = 20\n{}[field]\n{}",
        each(&|k| format!("x{k} = \"m\"\nv{k} = \"m/s\"\n")),
        each(&|k| format!("x{k} = {}\nv{k} = 0\n", 1.05 + 0.1 * k as f64)),
        (0..rubbing).map(contact).collect::<String>(),
        each(&rate)
    )
}

#[test]
fn as_many_states_and_contacts_as_a_file_can_have_move_as_each_does_alone() {
    for method in METHODS {
        let (found, transitions) = simulated(&row_of_blocks(32, 16), method, &["--tol", "1e-11"]);
        for k in 0..32 {
            let mut place = 1.05 + 0.1 * k as f64;
            let mut wanted = place * math::cos(20.0);
            if k < 16 {
                // Each half turn reduces the amplitude by 0.6, until friction holds the spring.
                let mut turns = 0;
                while place.abs() > 0.3 + 1e-9 {
                    place = -(place - 0.6 * place.signum());
                    turns += 1;
                }
                wanted = place;
                let own = transitions.iter().filter(|at| at.2 == format!("c{k}"));
                let entry = own.clone().find(|at| at.1 == "stick entry").unwrap();
                assert!(
                    (entry.0 - PI * f64::from(turns)).abs() < 1e-8,
                    "{k}: {entry:?}"
                );
                assert_eq!(own.count(), turns as usize);
            }
            let off = end(&found, &format!("x{k}")) - wanted;
            assert!(off.abs() < 1e-8, "{method} x{k}: {off:e}");
        }
    }
}

#[test]
fn a_system_without_contacts_is_smooth() {
    for method in METHODS {
        let (found, transitions) = simulated(&row_of_blocks(1, 0), method, &["--tol", "1e-11"]);
        assert!(transitions.is_empty());
        assert!((end(&found, "x0") - 1.05 * math::cos(20.0)).abs() < 1e-9);
    }
    // The analyses accept it, too: both exponents are zero, and so is the multiplier's logarithm.
    let (_top, mut command) = program(&row_of_blocks(1, 0));
    command.args(["lyapunov", "system.toml", "--duration", "500", "--json"]);
    let output = command.assert().success().get_output().stdout.clone();
    let found: Value = serde_json::from_slice(&output).unwrap();
    let exponents = found["exponents"].as_array().unwrap();
    assert_eq!(exponents.len(), 2);
    for exponent in exponents {
        let of = |key: &str| exponent[key].as_f64().unwrap();
        assert!(of("value").abs() < of("uncertainty"), "{exponent}");
    }
    let (_top, mut command) = program(&row_of_blocks(1, 0));
    let orbit = ["orbit", "system.toml"];
    let reported = contains("6.28318530");
    command.args(orbit).assert().success().stdout(reported);
    // Without a boundary there is nothing to report.
    let (_top, mut command) = program(&row_of_blocks(1, 0));
    let reported = contains("has no contact");
    command
        .args(["tangents", "system.toml"])
        .assert()
        .code(2)
        .stderr(reported);
}

/// The results of a command for the system in `text`.
pub fn results(text: &str, arguments: &[&str]) -> Value {
    let (_top, mut command) = program(text);
    let output = command.args(arguments).arg("--json").assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

/// A block on a belt with other people's smooth models in place of the contact (C6).
#[test]
fn smooth_models_of_friction_have_cycles_of_their_own() {
    let arctan = "name = \"arctan\"\n[states]\nx = \"\"\nv = \"\"\n[definitions]\n\
                  g = \"v - 0.2\"\n[field]\nx = \"v\"\n\
                  v = \"-x - 2/pi*atan(1000*g)/(1 + 3*abs(g))\"\n[start]\nx = 0\nv = 0\n";
    let lugre = "name = \"LuGre\"\n[states]\nx = \"\"\nv = \"\"\nz = \"\"\n[definitions]\n\
                 g = \"v - 0.2\"\nrate = \"g - 100*abs(g)*(1 + 3*abs(g))*z\"\n[field]\nx = \"v\"\n\
                 v = \"-x - 100*z - 20*rate\"\nz = \"rate\"\n[start]\nx = 0\nv = 0\nz = 0\n";
    // By an implicit method of order 5 with a tolerance of 1e-12.
    for (text, exact) in [(arctan, 11.298_150_66), (lugre, 11.013_411_14)] {
        for method in METHODS {
            let found = results(text, &["orbit", "system.toml", "--method", method]);
            let period = found["period"].as_f64().unwrap();
            assert!((period - exact).abs() < 1e-8, "{method}: {period}");
        }
    }
}

/// A driven Hopf oscillator without contacts (C18): the sum of its exponents is the mean of the
/// divergence, integrated here as a third state.
#[test]
fn a_driven_smooth_oscillator_has_two_negative_exponents() {
    let text = "name = \"driven\"\n[states]\nx = \"\"\ny = \"\"\n[definitions]\nr = \"x^2 + y^2\"\n\
                w = \"2*pi\"\n[field]\nx = \"x + w*y - r*x - 3*sin(w*t)\"\n\
                y = \"-w*x + y - r*y\"\n[start]\nx = 0\ny = 0.1\n[time]\nperiod = 1\n";
    let summed = text
        .replace("[definitions]", "q = \"\"\n[definitions]")
        .replace("[start]", "q = \"2 - 4*r\"\n[start]\nq = 0");
    let until = |end: &str| {
        let (found, _) = simulated(&summed, "taylor", &["--t-end", end]);
        self::end(&found, "q")
    };
    let exact = until("41") - until("40");
    for method in METHODS {
        let lyapunov = [
            "lyapunov",
            "system.toml",
            "--duration",
            "100",
            "--method",
            method,
        ];
        let found = results(text, &lyapunov);
        let value = |k: usize| found["exponents"][k]["value"].as_f64().unwrap();
        assert!(value(1) < value(0) && value(0) < 0.0, "{method}: {found}");
        let sum = value(0) + value(1);
        assert!((sum - exact).abs() < 1e-9, "{method}: {sum} and {exact}");
    }
}

/// An integrator of `2 cos t` between limits of one: it waits at a limit until its input turns.
#[test]
fn an_integrator_stays_at_its_limits() {
    let text = "name = \"limits\"\n[states]\nu = \"\"\n[discrete]\nat = 0\n[definitions]\n\
                e = \"2*cos(t)\"\n[field]\nu = \"(1 - abs(at))*e\"\n\
                [jumps.high]\nwhen = \"u - 1\"\ndirection = \"rising\"\nset = { at = \"1\" }\n\
                [jumps.low]\nwhen = \"u + 1\"\ndirection = \"falling\"\nset = { at = \"-1\" }\n\
                [jumps.turn]\nwhen = \"e\"\nset = { at = \"0\" }\n[start]\nu = 0\n\
                [time]\nend = 6\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, &[]);
        let exact = [
            (PI / 6.0, "high"),
            (PI / 2.0, "turn"),
            (PI, "low"),
            (1.5 * PI, "turn"),
        ];
        assert_eq!(transitions.len(), exact.len(), "{transitions:?}");
        for ((t, _, name), (expected, jump)) in transitions.iter().zip(exact) {
            assert!((t - expected).abs() < 1e-11, "{method}: {name} at {t}");
            assert_eq!(name, jump);
        }
        let exact = 1.0 + 2.0 * math::sin(6.0);
        assert!((end(&found, "u") - exact).abs() < 1e-11, "{method}");
    }
}

/// Crossing cycles about a two-fold (C24). Above the boundary the field is tangent to it where `p =
/// sin(x) + x^2`, below where `x = 1/10`. At one parameter both are at the same position.
#[test]
fn crossing_cycles_shrink_to_a_two_fold_at_a_known_parameter() {
    let text = r#"
name = "two-fold"
[states]
x = ""
y = ""
[parameters]
p = 0.3
[contacts.edge]
boundary = "y"
[definitions]
above = "by_side(edge, 0, 1)"
[field]
x = "2*above - 1"
y = "above*(p - sin(x) - x^2) - (1 - above)*(x - 0.1)"
[start]
x = -0.9
y = 0.05
"#;
    let exact = math::sin(0.1) + 0.01;
    for method in METHODS {
        let (_top, mut command) = program(text);
        command.args(["continue", "system.toml", "--parameter", "p=0:0.5"]);
        command.args(["--method", method, "--tol", "1e-12", "--json"]);
        let output = command.assert().success().get_output().stdout.clone();
        let found: Value = serde_json::from_slice(&output).unwrap();
        let end = &found["ends"][0];
        assert_eq!(end["stop"], "two-fold", "{found:#}");
        let reported = |key: &str| end["two_fold"][key].as_f64().unwrap();
        let off = (reported("parameter") - exact).abs();
        let uncertainty = reported("uncertainty");
        assert!(
            off <= uncertainty && uncertainty < 1e-9,
            "{method}: {off:e} {uncertainty:e}"
        );
    }
}
