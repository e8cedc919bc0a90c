//! Inputs: tables with steps and of other programs, pulses whose width is a formula.

use std::ops::ControlFlow;

use stickslip::analysis::Monodromy;
use stickslip::dynamics::{Moment, OrbitProgress, OrbitUnderWay, Vector};
use stickslip::math::exp;
use stickslip::{Method, Options};
use stickslip_model::file::{Source, System, SystemFile};
use stickslip_model::kernel::{follow, ignore};

fn read(name: &str, input: &str, rate: &str) -> Result<System, String> {
    let text = format!(
        "name = \"driven\"\n[parameters]\nw = 0.3\n[states]\nx = \"\"\n\
         [inputs.u]\n{input}\n[field]\nx = \"{rate}\"\n[start]\nx = 0\n"
    );
    let name = name.to_owned();
    let file = SystemFile::parse(Source { name, text }).map_err(|error| error.to_string())?;
    file.with(&[]).map_err(|error| error.to_string())
}

fn end(system: &System, x: f64, t_end: f64, method: Method) -> f64 {
    let options = Options::tol(1e-13).method(method);
    let run = follow(
        system.dynamics(),
        (0.0, &[x]),
        t_end,
        &options,
        &[],
        &mut ignore,
    );
    run.unwrap().x[0]
}

const METHODS: [Method; 2] = [Method::Taylor, Method::Dop853];

#[test]
fn two_points_at_one_time_are_a_step() {
    let table = |times: &str, values: &str| {
        format!("shape = \"table\"\ntimes = {times}\nvalues = {values}")
    };
    let step = read("step", &table("[0, 2, 2, 5]", "[0, 10, 5, 10]"), "u").unwrap();
    // A table of which each piece holds, and one that begins and ends with a step.
    let held = table("[0, 2, 2, 5]", "[3, 10, 5, 7]") + "\nbetween = \"constant\"";
    let held = read("held", &held, "u").unwrap();
    let ends = read("ends", &table("[1, 1, 2, 2]", "[4, 0, 1, 7]"), "u").unwrap();
    for method in METHODS {
        assert!((end(&step, 0.0, 5.0, method) - 32.5).abs() < 1e-12);
        assert!((end(&held, 0.0, 6.0, method) - (6.0 + 15.0 + 7.0)).abs() < 1e-12);
        assert!((end(&ends, 0.0, 3.0, method) - (4.0 + 0.5 + 7.0)).abs() < 1e-12);
    }
    let error = read("three", &table("[0, 2, 2, 2]", "[0, 1, 2, 3]"), "u")
        .err()
        .unwrap();
    assert!(
        error.contains("2 comes before 2, as number 3 and 4 of 4"),
        "{error}"
    );
    assert!(
        error.contains("two points at one time are a step"),
        "{error}"
    );
}

#[test]
fn a_fault_in_a_table_of_many_rows_has_a_short_message() {
    let mut times: Vec<String> = (0..100_000).map(|k| k.to_string()).collect();
    times[70_000] = "7".to_owned();
    let values = vec!["1"; times.len()].join(", ");
    let input = format!(
        "shape = \"table\"\ntimes = [{}]\nvalues = [{values}]",
        times.join(", ")
    );
    let error = read("long.toml", &input, "u").err().unwrap();
    assert!(
        error.contains("69999 comes before 7, as number 70000 and 70001"),
        "{error}"
    );
    assert!(
        error.contains("long.toml:8:9") && error.len() < 600,
        "{error}"
    );
}

#[test]
fn tables_are_read_as_other_programs_write_them() {
    let folder = std::env::temp_dir().join(format!("stickslip-inputs-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let name = folder.join("system.toml");
    for content in [
        "t,u\n0,0\n2,10\n2,5\n5,10\n",
        "\u{feff}t;u\r\n0;0\r\n2;10\r\n2;5\r\n5;10\r\n",
        "# made by hand\n0,0\t0,0\n2,0\t10,0\n2,0\t5,0\n5,0\t10,0\n",
        "% t u\n  0.0   0.0D0\n  2.0   1.0d+1\n  2.0   5.0\n  5.0   10\n",
        "t;u;remark\n0,0;0,0;1\n2,0;1e1;1\n2,0;5,0;1\n5,0;10,0;1\n",
    ] {
        std::fs::write(folder.join("u.dat"), content).unwrap();
        let table = "shape = \"table\"\nfile = \"u.dat\"";
        let system =
            read(name.to_str().unwrap(), table, "u").unwrap_or_else(|error| panic!("{error}"));
        assert!(
            (end(&system, 0.0, 5.0, Method::Taylor) - 32.5).abs() < 1e-12,
            "{content:?}"
        );
    }
    std::fs::remove_dir_all(folder).unwrap();
}

const PULSE: &str = "shape = \"pulse\"\nperiod = 2\nwidth = \"w\"";

#[test]
fn a_width_may_be_a_formula_of_parameters() {
    // x' = u - x: the periodic orbit begins at (e^(wT) - 1)/(e^T - 1).
    let system = read("pulse", PULSE, "u - x").unwrap();
    for w in [0.01_f64, 0.3, 0.5, 0.99] {
        let x = (exp(2.0 * w) - 1.0) / (exp(2.0) - 1.0);
        let system = system.with_values(&[("w", w)]).unwrap();
        for method in METHODS {
            assert!((end(&system, x, 20.0, method) - x).abs() < 1e-12, "{w}");
        }
    }
    for (width, value) in [
        ("w - 1", "-0.7"),
        ("2*w + 1", "1.6"),
        ("0", "0"),
        ("1", "1"),
    ] {
        let input = PULSE.replace("width = \"w\"", &format!("width = \"{width}\""));
        let error = read("pulse", &input, "u - x").err().unwrap();
        let wanted = format!("the width {value} is not between 0 and 1");
        assert!(
            error.contains(&wanted) && error.contains("part of the period"),
            "{error}"
        );
    }
    let error = read("pulse", &PULSE.replace("\"w\"", "\"w*x\""), "u - x")
        .err()
        .unwrap();
    assert!(
        error.contains("the width of an input cannot depend on a state"),
        "{error}"
    );
    assert!(system.with_values(&[("w", 1.5)]).is_err());
}

#[test]
fn derivatives_by_a_width_go_with_the_kink_that_it_moves() {
    // x(T) = x e^(-T) + e^((w - 1)T) - e^(-T), with the parameter as a second state.
    let system = read("pulse", PULSE, "u - x")
        .unwrap()
        .with_states_of(&[0])
        .unwrap();
    for method in METHODS {
        let options = Options::tol(1e-13).method(method);
        for (w, t) in [(0.3_f64, 2.0_f64), (0.5, 2.0), (0.7, 3.9)] {
            let start = [0.2, w];
            let found = Monodromy::of(&system, 0.0, start.as_slice(), t, &options)
                .unwrap()
                .matrix;
            // All falls before t.
            let falls = (0..2)
                .map(|k| 2.0 * (w + f64::from(k)))
                .filter(|fall| *fall < t);
            let by_width: f64 = falls.map(|fall| 2.0 * exp(fall - t)).sum();
            assert!((found[(0, 0)] - exp(-t)).abs() < 1e-11, "{found}");
            assert!(
                (found[(0, 1)] - by_width).abs() < 1e-11,
                "{w} {found} {by_width}"
            );
        }
        // Beyond its bounds a width has no value, and a run does not begin.
        let at = Moment {
            t: 0.0,
            x: Vector::from_vec(vec![0.2, 1.2]),
        };
        let begun = system.begin(&at, 2.0, &options, &[]);
        assert!(begun.is_err());
    }
}

#[test]
fn the_kinks_of_a_pulse_are_at_its_width() {
    let system = read("pulse", PULSE, "u - x")
        .unwrap()
        .with_states_of(&[0])
        .unwrap();
    let mut kinks = Vec::new();
    let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
        if let OrbitProgress::Kink(at) = progress {
            kinks.push(at.t);
        }
        ControlFlow::Continue(())
    };
    let start = (0.0, &[0.2, 0.3][..]);
    follow(&system, start, 5.0, &Options::default(), &[], &mut watcher).unwrap();
    assert_eq!(kinks, [0.6, 2.0, 2.6, 4.0, 4.6]);
}
