//! Output and files of commands for systems with jumps, discrete states and inputs.

use crate::public_cases::{program, results};

/// Two values, set by jumps where `u` passes through two levels.
fn relay(levels: [f64; 2]) -> String {
    let [low, high] = levels;
    format!(
        "name = \"relay\"\n[states]\nu = \"\"\nw = \"\"\n[discrete]\nrate = -1\n\
         [field]\nu = \"rate\"\nw = \"-w\"\n[jumps.up]\nwhen = \"u - ({low})\"\n\
         direction = \"falling\"\nset = {{ rate = \"1\" }}\n[jumps.down]\nwhen = \"u - ({high})\"\n\
         direction = \"rising\"\nset = {{ rate = \"-1\" }}\n[start]\nu = {high}\nw = 1\n\
         [time]\nend = 5\n"
    )
}

/// An undamped oscillator of frequency 1, driven by cos(w t), that hits a wall at 0.
const IMPACTS: &str = include_str!("../../../stickslip-model/tests/data/impacts.toml");

/// A buck converter in voltage mode. Its switch closes where a ramp passes the amplified error, and
/// opens with the next ramp.
const BUCK: &str = include_str!("../../../stickslip-model/tests/data/buck.toml");

/// A block, driven by a square wave and a switch by time, that hits a wall.
const MIXED: &str = include_str!("../../../stickslip-model/tests/data/mixed.toml");

/// The program's output.
fn printed(text: &str, arguments: &[&str]) -> (tempfile::TempDir, String) {
    let (top, mut command) = program(text);
    let output = command.args(arguments).args(["--out", "out"]);
    let output = output.assert().success().get_output().clone();
    (top, String::from_utf8(output.stdout).unwrap())
}

#[test]
fn phases_name_the_jumps_that_end_them() {
    let (top, words) = printed(MIXED, &["simulate", "system.toml"]);
    assert!(
        words.contains("× jump wall_right") && words.contains("× switch drive"),
        "{words}"
    );
    let phases = std::fs::read_to_string(top.path().join("out/phases.csv")).unwrap();
    assert!(
        phases.contains("slip above,wall_right,"),
        "which jump ends a phase: {phases}"
    );
    let portrait = std::fs::read_to_string(top.path().join("out/portrait.svg")).unwrap();
    assert!(
        portrait.contains("wall") && portrait.contains("right"),
        "the legend"
    );

    let (_, words) = printed(MIXED, &["orbit", "system.toml"]);
    assert!(words.contains("+(wall_right)"), "{words}");
    let relay = relay([-1.0, 1.0]).replace("[time]", "[ranges]\nu = [-1, 1]\nw = [0, 1]\n[time]");
    let relay = relay.replace("[discrete]", "[parameters]\nlow = 1\n[discrete]");
    let relay = relay.replace("u - (-1)", "u + low");
    for (command, arguments, wanted) in [
        ("orbit", &[][..], "down up"),
        (
            "continue",
            &["--parameter", "low=0.5:1.5"],
            "phases down up",
        ),
        (
            "bifurcation",
            &["--parameter", "low=0.5:1.5", "--values", "3"],
            "periodic, down up",
        ),
        ("basin", &["--grid", "2x2"], "phases down up"),
        (
            "map",
            &[
                "--x",
                "low=0.5:1",
                "--y",
                "other=0:1",
                "--grid",
                "2x2",
                "--duration",
                "10",
            ],
            "periodic, down up",
        ),
    ] {
        let text = relay.replace("low = 1\n", "low = 1\nother = 0\n");
        let (_, words) = printed(&text, &[&[command, "system.toml"], arguments].concat());
        let other = wanted.replace("down up", "up down");
        assert!(
            words.contains(wanted) || words.contains(&other),
            "{command}: {words}"
        );
        assert!(!words.contains('·'), "{command}: {words}");
    }
}

#[test]
fn a_plane_of_starts_leaves_discrete_states_where_the_file_has_them() {
    let one = "name = \"one\"\n\
               [states]\n\
               u = \"\"\n\
               [discrete]\n\
               heating = 1\n\
               [field]\n\
               u = \"40*heating - u\"\n\
               [jumps.off]\n\
               when = \"u - 21\"\n\
               direction = \"rising\"\n\
               set = { heating = \"0\" }\n\
               [jumps.on]\n\
               when = \"u - 19\"\n\
               direction = \"falling\"\n\
               set = { heating = \"1\" }\n\
               [start]\n\
               u = 15\n\
               [ranges]\n\
               u = [0, 20]\n\
               heating = [0, 1]\n";
    let (_top, mut command) = program(one);
    let failed = command.args(["basin", "system.toml"]).assert().failure();
    let reported = String::from_utf8(failed.get_output().stderr.clone()).unwrap();
    assert!(
        reported.contains("the system has 1") && reported.contains("--y heating=LOW:HIGH"),
        "{reported}"
    );
    let two = one
        .replace("[discrete]", "w = \"\"\n[discrete]")
        .replace("[jumps.off]", "w = \"-w\"\n[jumps.off]")
        .replace("u = 15", "u = 15\nw = 0")
        .replace("u = [0, 20]", "u = [0, 20]\nw = [0, 1]");
    let starts = |text: &str, arguments: &[&str]| -> Vec<[f64; 3]> {
        let command = [&["basin", "system.toml", "--grid", "2x2"], arguments].concat();
        let (top, _) = printed(text, &command);
        let mut rows = csv::Reader::from_path(top.path().join("out/basin.csv")).unwrap();
        assert_eq!(rows.headers().unwrap().iter().next(), Some("u"));
        let rows = rows.records().map(|row| {
            let row = row.unwrap();
            [0, 1, 2].map(|k| row[k].parse().unwrap())
        });
        rows.collect()
    };
    let wanted = [
        [5.0, 0.25, 1.0],
        [15.0, 0.25, 1.0],
        [5.0, 0.75, 1.0],
        [15.0, 0.75, 1.0],
    ];
    assert_eq!(starts(&two, &[]), wanted);
    // Values that the plane replaces need no start, and a discrete state has its own.
    let without = two.replace("[start]\nu = 15\nw = 0\n", "");
    assert_eq!(starts(&without, &[]), wanted);
    let off = starts(&without, &["--start", "heating=0"]);
    assert_eq!(off, wanted.map(|[u, w, _]| [u, w, 0.0]));
    // Whole values of a discrete state are the middles of two cells.
    let both = starts(&two, &["--y", "heating=-0.5:1.5"]);
    let heating: Vec<f64> = both.iter().map(|row| row[2]).collect();
    assert_eq!(heating, [0.0, 0.0, 1.0, 1.0]);
}

/// The orbit at the end of the range is the one that a run comes to.
#[test]
fn branches_begin_at_flips_of_orbits_with_jumps() {
    let cases = [
        (IMPACTS, "w=2.5:2.66", "w=2.66", "v"),
        (BUCK, "E=18:25", "E=25", "v"),
    ];
    for (text, range, set, state) in cases {
        let arguments = [
            "continue",
            "system.toml",
            "--parameter",
            range,
            "--branches",
        ];
        let found = results(text, &arguments);
        let [branch] = found["branches"].as_array().unwrap().as_slice() else {
            panic!("{:#}", found["branches"]);
        };
        assert_eq!(branch["stop"], "range", "{branch:#}");
        assert_eq!(branch["special"], serde_json::json!([]));
        let (top, _) = printed(text, &arguments);
        let mut table = csv::Reader::from_path(top.path().join("out/branch.csv")).unwrap();
        let names = table.headers().unwrap().clone();
        let last = table.records().last().unwrap().unwrap();
        let alone = results(text, &["orbit", "system.toml", "--set", set]);
        assert_eq!(alone["periods_of_drive"], 2);
        for (end, of) in ["low", "high"].into_iter().zip([0, 1]) {
            let name = format!("{state}_{end}");
            let column = names.iter().position(|one| one == name).unwrap();
            let extreme = alone["extremes"][state][of].as_f64().unwrap();
            let off = last[column].parse::<f64>().unwrap() - extreme;
            assert!(&last[0] == "1" && off.abs() < 1e-8, "{set}: {name} {off:e}");
        }
        let special = std::fs::read_to_string(top.path().join("out/special.csv")).unwrap();
        assert!(special.starts_with("branch,branches,behind,"), "{special}");
        assert!(special.contains("\n0,1,"), "{special}");
    }
}

/// A ball that comes to rest on a floor: the reaction, impulses and a formula in all tables.
#[test]
fn reactions_impulses_and_formulas_are_in_the_tables() {
    let ball = "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[parameters]\ng = 10\nr = 0.5\n\
                [stops.floor]\ngap = \"h\"\nacts = { w = 1 }\nrestitution = \"r\"\n[field]\n\
                h = \"w\"\nw = \"-g\"\n[start]\nh = 5\nw = 0\n[time]\nend = 5\n";
    let (top, mut command) = program(ball);
    command.args(["simulate", "system.toml", "--out", "out", "--json"]);
    command.args([
        "--observe",
        "load = floor.force/g",
        "--observe",
        "energy=g*h + w^2/2",
    ]);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let read = |name: &str| std::fs::read_to_string(top.path().join("out").join(name)).unwrap();
    let rows = |text: String| -> Vec<Vec<String>> {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect();
        text.lines().map(cells).collect()
    };
    let steps = rows(read("steps.csv"));
    let heading = "t,h,w,floor.closed,floor.force,load,energy";
    assert_eq!(steps[0].join(","), heading);
    let number = |cell: &String| cell.parse::<f64>().unwrap();
    for row in &steps[1..] {
        let row: Vec<f64> = row.iter().map(number).collect();
        assert_eq!([row[4], row[5]], [10.0 * row[3], row[3]], "{row:?}");
        assert_eq!(row[6], 10.0 * row[1] + row[2] * row[2] / 2.0);
    }
    assert!(steps.last().unwrap()[4] == "10.0", "{:?}", steps.last());
    let transitions = rows(read("transitions.csv"));
    let column = transitions[0]
        .iter()
        .position(|name| name == "floor.impulse")
        .unwrap();
    for (row, impulse) in transitions[1..].iter().zip([15.0, 7.5, 3.75]) {
        assert!((number(&row[column]) - impulse).abs() < 1e-11, "{row:?}");
    }
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let first = &json["transitions"][0]["floor.impulse"];
    assert!((first.as_f64().unwrap() - 15.0).abs() < 1e-11, "{first}");
    let history = read("history.svg");
    assert!(history.contains("floor.force") && history.contains("energy"));
    for (formula, message) in [
        ("load", "write a name and a formula"),
        ("h = 1", "the name `h` is taken already"),
        ("load = floor.forces", "did you mean `floor.force`?"),
    ] {
        let (_top, mut command) = program(ball);
        command.args(["simulate", "system.toml", "--observe", formula]);
        let output = command.output().unwrap();
        let words = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && words.contains(message),
            "{words}"
        );
    }
}

/// What `check` says of a start is what a run from there does. A ball below a floor falls for ever,
/// whatever its velocity, since only a fall through the floor is a bounce; behind a stop no run
/// begins.
#[test]
fn check_says_what_a_start_behind_the_surface_of_a_jump_will_do() {
    let file = |rest: &str, h: &str, w: &str| {
        format!(
            "name = \"ball\"\n[states]\nh = \"\"\nw = \"\"\n[field]\nh = \"w\"\nw = \"-10\"\n\
             [start]\nh = {h}\nw = {w}\n[time]\nend = 0.5\n{rest}"
        )
    };
    let bounce = "[jumps.bounce]\nwhen = \"h\"\ndirection = \"falling\"\nset = { w = \"-w/2\" }\n";
    let floor = "[stops.floor]\ngap = \"h\"\nacts = { w = 1 }\nrestitution = 0.5\n";
    let end = "[jumps.below]\nwhen = \"h\"\ndirection = \"falling\"\nstop = true\n";
    let run = |text: &str, name: &str| {
        let (_top, mut command) = program(text);
        command.args([name, "system.toml", "--json"]);
        let output = command.output().unwrap();
        let words = String::from_utf8(output.stderr).unwrap();
        match output.status.success() {
            true => Ok(serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()),
            false => Err(words),
        }
    };
    for (rest, h, w, doubt) in [
        (
            bounce,
            "-1",
            "0",
            "the jump bounce happens where h falls through zero",
        ),
        (
            bounce,
            "-1",
            "-1",
            "the jump bounce happens where h falls through zero",
        ),
        (bounce, "1", "0", ""),
        (
            end,
            "-1",
            "0",
            "the jump below happens where h falls through zero",
        ),
        (floor, "-1", "0", "a run does not begin at the start"),
        (floor, "1", "0", ""),
        (floor, "0", "0", ""),
    ] {
        let text = file(rest, h, w);
        let found = run(&text, "check").unwrap();
        let doubtful = found["doubtful"].as_array().unwrap();
        let case = format!("{rest} from {h}, {w}: {doubtful:?}");
        assert_eq!(doubtful.len(), usize::from(!doubt.is_empty()), "{case}");
        let said = doubtful.first().map_or("", |one| one.as_str().unwrap());
        assert!(said.starts_with(doubt), "{case}");
        match run(&text, "simulate") {
            // Nothing happens, or the ball meets the floor.
            Ok(done) => {
                let happened = !done["transitions"].as_array().unwrap().is_empty();
                assert_eq!(happened, h != "-1", "{case}: {done}");
            }
            Err(words) => {
                let why = said.strip_prefix("a run does not begin at the start: ");
                assert!(words.contains(why.unwrap()), "{case}: {words}");
            }
        }
    }
}

/// A ball that chatters to rest on a shaken table once a period.
const CHATTER: &str = "name = \"table\"\n[states]\nh = \"\"\nv = \"\"\n[field]\nh = \"v\"\n\
    v = \"-1\"\n[stops.table]\ngap = \"h - 1.2*sin(t)\"\nacts = { v = 1 }\nrestitution = 0.5\n\
    [start]\nh = 0\nv = \"1.2\"\n[time]\nperiod = \"2*pi\"\n";

#[test]
fn an_exponent_that_is_not_finite_has_its_cause() {
    let (_, words) = printed(CHATTER, &["lyapunov", "system.toml", "--duration", "40"]);
    for wanted in [
        "λ1           -∞ (rest on a stop annihilates the direction)",
        "λ2           -∞ (rest on a stop annihilates the direction)",
        "λ3           -∞ (discrete states take isolated values",
    ] {
        assert!(words.contains(wanted), "{wanted}: {words}");
    }
}

#[test]
fn an_orbit_has_discrete_states_with_the_values_of_jumps() {
    // Free flight between impacts: nothing but jumps may move the state of the stop.
    let text = CHATTER
        .replace("h - 1.2*sin(t)", "h + 0.3")
        .replace("v = \"-1\"", "v = \"-h - 0.1*v + cos(2.8*t)\"");
    let text = text.replace("2*pi", "2*pi/2.8").replace("0.5", "0.6");
    let text = text.replace("h = 0\nv = \"1.2\"", "h = 0.2\nv = 0");
    let (_, words) = printed(&text, &["orbit", "system.toml"]);
    assert!(
        words.contains("table.closed from 0 to 0, at first 0\n"),
        "{words}"
    );
}

#[test]
fn a_jump_at_a_value_of_a_counter_is_warned_of() {
    let counter = |when: &str| {
        format!(
            "name = \"counter\"\n[states]\nx = \"\"\n[discrete]\nn = 0\n[field]\nx = 1\n\
             [jumps.tick]\nwhen = \"x - 1\"\ndirection = \"rising\"\n\
             set = {{ x = 0, n = \"n + 1\" }}\n[jumps.last]\nwhen = \"{when}\"\n\
             direction = \"rising\"\nstop = true\n[start]\nx = 0\n"
        )
    };
    for (when, is_meant) in [
        ("n - 3", false),
        ("2*n - 6", false),
        ("n - 2.5", true),
        ("n - 3 + 0.1*x", true),
        ("x - 3 + n", true),
    ] {
        let (_top, mut command) = program(&counter(when));
        let output = command.args(["check", "system.toml"]).output().unwrap();
        let words = String::from_utf8(output.stdout).unwrap();
        let warned = words.contains("the jump last does not occur where n becomes 3");
        assert_eq!(warned, !is_meant, "{when}: {words}");
    }
}
