//! `stickslip map`.

use predicates::str::contains;

use super::common::{folder, program, text};

const MAP: [&str; 8] = [
    "map",
    "basins",
    "--x",
    "vd=1.2:2",
    "--y",
    "d=0.05:0.15",
    "--grid",
    "4x2",
];

#[test]
fn a_map_has_the_known_exponent_of_the_equilibrium() {
    let top = folder();
    program(top.path())
        .args(MAP)
        .args(["--tol", "1e-10", "--out", "map"])
        .assert()
        .success()
        .stdout(contains("8 cells, vd from 1.2 to 2, d from 0.05 to 0.15"))
        .stdout(contains("equilibrium"));
    let svg = text(top.path().join("map/map.svg"));
    roxmltree::Document::parse(&svg).unwrap();
    let mut rows = csv::Reader::from_path(top.path().join("map/map.csv")).unwrap();
    let (mut equilibria, mut cycles) = (0, 0);
    for row in rows.records() {
        let row = row.unwrap();
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let (speed, damping, in_stick, exponent) = (number(0), number(1), number(5), number(6));
        let (std_error, uncertainty) = (number(7), number(8));
        // Measured over 500 units of time; a growth factor of 30 is no growth.
        let least = stickslip::math::ln(30.0) / 500.0;
        assert_eq!(uncertainty, least.max(4.0 * std_error));
        match &row[2] {
            "equilibrium" => {
                equilibria += 1;
                // Half the trace of the Jacobian at the equilibrium: -d + exp(-2 vd).
                let exact = (stickslip::math::exp(-2.0 * speed) - damping) / 2.0;
                assert!(
                    (exponent - exact).abs() < 2e-3 * damping,
                    "{exponent} for {exact}"
                );
                assert!((exponent - exact).abs() < uncertainty);
                assert_eq!((in_stick, &row[4]), (0.0, "-"));
            }
            "periodic" => {
                cycles += 1;
                assert!(exponent.abs() < uncertainty.min(1e-3), "{exponent}");
                assert!(in_stick > 0.0 && in_stick < 0.3);
                assert_eq!(&row[4], "- S");
            }
            other => panic!("{other}"),
        }
    }
    assert!(equilibria > 1 && cycles > 1, "{equilibria} and {cycles}");
}

#[test]
fn undecided_cells_are_no_kind_of_attractor() {
    let top = folder();
    program(top.path())
        .args(MAP)
        .args(["--until", "5", "--duration", "5", "--out", "map"])
        .assert()
        .success()
        .stdout(contains("100.00 %  no attractor: undecided after 5\n"));
    let svg = text(top.path().join("map/map.svg"));
    assert!(svg.contains("undecided after 5"));
    let output = program(top.path())
        .args(MAP)
        .args(["--tol", "1e-10", "--out", "long", "--json"])
        .assert()
        .success();
    let printed = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    // Other programs need the ASCII minus.
    assert!(
        printed.is_ascii() && printed.contains("periodic, - S"),
        "{printed}"
    );
}

#[test]
fn shares_of_a_map_are_merged_to_what_one_run_gives() {
    let top = folder();
    let run = |arguments: &[&str]| {
        program(top.path())
            .args(MAP)
            .args(arguments)
            .assert()
            .success()
    };
    run(&["--out", "single"]);
    run(&["--shard", "1/2", "--out", "a"]);
    run(&["--shard", "2/2", "--out", "b"]);
    program(top.path())
        .args(["merge", "--out", "merged", "b", "a"])
        .assert()
        .success();
    for name in ["map.csv", "map.svg"] {
        let of = |folder: &str| text(top.path().join(folder).join(name));
        assert!(of("merged") == of("single"), "{name}");
    }
}

/// A block that slides to rest within a few steps. Blocks of time do not give the uncertainty of
/// its exponent.
const BLOCK: &str = r#"
name = "Block"
[time]
end = 10
[states]
x = ""
v = ""
[parameters]
mu = 0.5
m = 1
[contacts.floor]
boundary = "v"
friction = "mu"
[field]
x = "v"
v = "-friction(floor)/m"
[start]
x = 0
v = 1
"#;

#[test]
fn what_comes_to_rest_at_once_is_read_again() {
    let top = folder();
    std::fs::write(top.path().join("block.toml"), BLOCK).unwrap();
    let run = |arguments: &[&str]| {
        program(top.path())
            .args(arguments)
            .assert()
            .success()
            .stdout(contains("set of equilibria"))
    };
    let diagram = ["bifurcation", "block.toml", "--parameter", "mu=0.2:0.5"];
    run(&[&diagram[..], &["--values", "4", "--out", "diagram"]].concat());
    let map = ["map", "block.toml", "--x", "mu=0.2:0.5", "--y", "m=1:2"];
    run(&[&map[..], &["--grid", "2x2", "--out", "map"]].concat());
}

/// A pendulum that hangs at rest while its pivot moves up and down.
const HANGING: &str = r#"
name = "hanging"
[time]
period = "pi"
[states]
x = ""
v = ""
[parameters]
p = 0.1
c = 0.2
[field]
x = "v"
v = "-(1 + p*cos(2*t))*sin(x) - c*v"
[start]
x = 0
v = 0
"#;

/// The pendulum, driven at twice its own frequency, hangs stably up to `p = 2 c`, to first order.
/// Its exponents are `-c/2 +- p/4`. Beyond, it swings.
#[test]
fn an_unstable_orbit_is_no_attractor_of_a_map() {
    let top = folder();
    std::fs::write(top.path().join("hanging.toml"), HANGING).unwrap();
    program(top.path())
        .args([
            "map",
            "hanging.toml",
            "--x",
            "p=0.1:0.9",
            "--y",
            "c=0.1:0.3",
        ])
        .args(["--grid", "4x2", "--out", "map"])
        .assert()
        .success();
    let mut rows = csv::Reader::from_path(top.path().join("map/map.csv")).unwrap();
    let (mut hanging, mut swinging) = (0, 0);
    for row in rows.records() {
        let row = row.unwrap();
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let (p, c, exponent) = (number(0), number(1), number(6));
        let at_rest = 0.25 * p - 0.5 * c;
        assert_eq!(&row[2], "periodic");
        if at_rest < 0.0 {
            hanging += 1;
            assert!(
                (exponent - at_rest).abs() < 0.02,
                "{exponent} for {at_rest}"
            );
        } else {
            swinging += 1;
            assert!(exponent < -0.25 * c, "{exponent} at p = {p}, c = {c}");
        }
    }
    assert!(hanging > 0 && swinging > 0, "{hanging} and {swinging}");
}

/// The manifest is read again, too.
#[test]
fn shares_without_an_escape_bound_are_merged() {
    let top = folder();
    program(top.path())
        .args(MAP)
        .args(["--until", "5", "--duration", "5", "--escape", "inf"])
        .args(["--shard", "1/1", "--out", "a"])
        .assert()
        .success();
    program(top.path())
        .args(["merge", "--out", "merged", "a"])
        .assert()
        .success();
    program(top.path())
        .args(MAP)
        .args(["--escape", "nan"])
        .assert()
        .failure()
        .stderr(contains("--escape"));
}

#[test]
fn wrong_maps_are_reported() {
    let top = folder();
    for (x, y, message) in [
        ("x=0:1", "d=0:1", "there is no parameter `x`"),
        ("vd=0:1", "vd=0:1", "a map has two parameters"),
        ("vd=0:1", "mud=-1:1", "not allowed"),
        ("vd=1:1", "d=0:1", "from 1 to 1 is no range"),
    ] {
        program(top.path())
            .args(["map", "basins", "--x", x, "--y", y])
            .assert()
            .code(2)
            .stderr(contains(message));
    }
    assert_eq!(std::fs::read_dir(top.path()).unwrap().count(), 0);
}
