//! Jumps, discrete states and time-dependent inputs from files, compared with closed forms, by both
//! methods.

use std::f64::consts::PI;

use stickslip::analysis::{
    CycleBifurcation, Monodromy, SequenceBifurcation, SpecialPoint, SpectrumOptions, Stop,
    lyapunov_spectrum,
};
use stickslip::dynamics::{DynamicsRef, Matrix, Moment, OrbitProgress, Vector};
use stickslip::nalgebra::{Matrix2, RowVector2, Vector2};
use stickslip::{Ending, Error, Options, math};
use stickslip_model::file::SystemFile;
use stickslip_model::study::{PeriodicSearch, TwoSidedBranch, extremes};

use crate::run::{
    METHODS, Run, SEARCH, branch, branch_through, end, failed, flips, options, orbit, orbit_from,
    real_multipliers, simulated, system, trace_and_determinant, with,
};

const BALL: &str = "name = \"ball\"\n\
                    [states]\n\
                    x = \"m\"\n\
                    v = \"m/s\"\n\
                    [parameters]\n\
                    r = 0.5\n\
                    [field]\n\
                    x = \"v\"\n\
                    v = \"-9.81\"\n\
                    [jumps.bounce]\n\
                    when = \"x\"\n\
                    direction = \"falling\"\n\
                    set = { x = \"0\", v = \"-r*v\" }\n\
                    [start]\n\
                    x = 1\n\
                    v = 0\n\
                    [time]\n\
                    end = 1.3\n";

#[test]
fn a_ball_bounces_at_times_in_geometric_progression() {
    let fall = (2.0_f64 / 9.81).sqrt();
    for method in METHODS {
        let (_, transitions) = simulated(BALL, method, None);
        assert_eq!(transitions.len(), 5, "{method}: {transitions:?}");
        let mut exact = fall;
        for (number, (t, kind, name)) in transitions.iter().enumerate() {
            assert_eq!((*kind, name.as_str()), ("jump", "bounce"));
            assert!(
                (t - exact).abs() < 1e-12,
                "{method}: bounce {number} at {t}"
            );
            exact += 2.0 * fall * math::powi(0.5, number as i32 + 1);
        }
    }
}

#[test]
fn a_ball_that_bounces_without_end_is_reported_where_that_is() {
    // From the first impact on, 2 v/g r/(1 − r).
    let fall = (2.0_f64 / 9.81).sqrt();
    for method in METHODS {
        for r in [0.5, 0.9] {
            let exact = fall + 2.0 * fall * r / (1.0 - r);
            let run = Run::of(with(BALL, &[("r", r)]), &options(method), Some(20.0));
            assert!(run.words().contains("at the accumulation point, t = "));
            let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
                panic!("{method}");
            };
            let t = accumulation.unwrap().t;
            assert!((t - exact).abs() < 1e-10, "{method}, {r}: {t} and {exact}");
        }
    }
}

#[test]
fn what_location_leaves_of_a_height_does_not_displace_later_bounces() {
    let text = BALL.replace("x = \"0\", ", "");
    let exact = 3.0 * (2.0_f64 / 9.81).sqrt();
    for tol in [1e-8, 1e-10, 1e-12, 1e-14] {
        let options = Options {
            rtol: tol,
            atol: tol.into(),
            ..options("taylor")
        };
        let run = Run::of(system(&text), &options, Some(20.0));
        let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
            panic!("{tol}");
        };
        let t = accumulation.unwrap().t;
        assert!((t - exact).abs() < 1e-13, "{tol}: {t} and {exact}");
    }
}

#[test]
fn a_run_ends_at_the_jump_that_says_so() {
    for (ending, count) in [("stop = true", 1), ("count = 3", 3)] {
        let text = BALL.replace("[jumps.bounce]\n", &format!("[jumps.bounce]\n{ending}\n"));
        for method in METHODS {
            let (found, transitions) = simulated(&text, method, None);
            assert_eq!(transitions.len(), count);
            assert!(end(&found, "v") > 0.0, "the state behind the jump");
            assert_eq!(found.ending(), Ending::Stopped);
        }
    }
}

#[test]
fn jumps_that_set_each_other_off_are_a_pile_up() {
    let text = "name = \"loop\"\n\
                [states]\n\
                u = \"\"\n\
                [discrete]\n\
                a = 0\n\
                [field]\n\
                u = \"1\"\n\
                [jumps.up]\n\
                when = \"a - 0.5\"\n\
                direction = \"falling\"\n\
                set = { a = \"1\" }\n\
                [jumps.down]\n\
                when = \"a - 0.5\"\n\
                direction = \"rising\"\n\
                set = { a = \"0\" }\n\
                [jumps.go]\n\
                when = \"u - 1\"\n\
                set = { a = \"1\" }\n\
                [start]\n\
                u = 0\n\
                [time]\n\
                end = 3\n";
    for method in METHODS {
        let words = failed(text, &options(method));
        assert!(
            words.contains("transitions at `up`, `down` within 0e0"),
            "{words}"
        );
    }
}

#[test]
fn what_is_at_one_time_is_done_in_the_order_of_the_file() {
    // Both see u = 1 at the same time. The second one adds to the value set by the first one.
    let text = "name = \"order\"\n[states]\nu = \"\"\n[discrete]\na = 1\n[field]\nu = \"1\"\n\
                [jumps.first]\nwhen = \"u - 1\"\nset = { a = \"2*a\" }\n\
                [jumps.second]\nwhen = \"2*u - 2\"\nset = { a = \"a + 3\" }\n\
                [start]\nu = 0\n[time]\nend = 2\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, None);
        let names: Vec<&str> = transitions.iter().map(|at| at.2.as_str()).collect();
        assert_eq!(names, ["first", "second"], "{method}");
        assert_eq!(end(&found, "a"), 5.0);
    }
}

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

#[test]
fn relays_with_hysteresis_have_their_periods() {
    for method in METHODS {
        let (found, _) = simulated(&relay([-1.0, 1.0]), method, None);
        assert!(end(&found, "u").abs() < 1e-12, "{method}");
        assert!(
            (end(&found, "w") - math::exp(-5.0)).abs() < 1e-12,
            "{method}"
        );
        for (levels, period) in [([-1.0, 1.0], 4.0), ([0.0, 0.2], 0.4)] {
            let (_, transitions) = simulated(&relay(levels), method, 20.0);
            for two in transitions.windows(3) {
                assert!(
                    (two[2].0 - two[0].0 - period).abs() < 1e-12,
                    "{method}: {two:?}"
                );
            }
        }
    }
}

#[test]
fn a_relay_of_order_six_has_its_half_period() {
    let mut text = "name = \"plant\"\n[states]\n".to_owned();
    for k in 1..=6 {
        text += &format!("x{k} = \"\"\n");
    }
    text += "[discrete]\nu = 1\n[definitions]\n\
             y = \"x6 - 5*x5 - 11*x4 - 5*x3 + 250*x2 + 250*x1\"\n[field]\n";
    for k in 1..=5 {
        text += &format!("x{k} = \"x{}\"\n", k + 1);
    }
    text += "x6 = \"u - 50*x1 - 150*x2 - 195*x3 - 140*x4 - 57*x5 - 12*x6\"\n\
             [jumps.down]\nwhen = \"y - 0.25\"\ndirection = \"rising\"\nset = { u = \"-1\" }\n\
             [jumps.up]\nwhen = \"y + 0.25\"\ndirection = \"falling\"\nset = { u = \"1\" }\n\
             [start]\nx1 = 0\nx2 = 0\nx3 = 0\nx4 = 0\nx5 = 0\nx6 = 0\n[time]\nend = 60\n";
    for method in METHODS {
        let (_, transitions) = simulated(&text, method, None);
        let [.., before, last] = &transitions[..] else {
            panic!("{transitions:?}");
        };
        assert!(
            (last.0 - before.0 - 2.094123077408).abs() < 1e-11,
            "{method}"
        );
    }
}

/// `u' = f(u, name)` with an input of this name.
fn driven(field: &str, input: &str, start: f64, end: &str) -> String {
    format!(
        "name = \"driven\"\n[states]\nu = \"\"\n{input}\n[field]\nu = \"{field}\"\n[start]\n\
         u = {start}\n[time]\nend = \"{end}\"\n"
    )
}

#[test]
fn inputs_kink_at_their_times() {
    let pulse = "[inputs.p]\nshape = \"table\"\ntimes = [0, 1, 1.05]\nvalues = [0, 20, 0]\n\
                 between = \"constant\"";
    let triangle = "[inputs.p]\nshape = \"triangle\"\nperiod = 1";
    let switch = "[switches.p]\nfunction = \"sin(3*t)\"";
    // A spike of width 1e-9, which steps of length one would miss.
    let spike = "[inputs.p]\nshape = \"pulse\"\nperiod = 10\nwidth = 1e-10\nphase = 0.5";
    let saw = "[inputs.p]\nshape = \"sawtooth\"\nperiod = \"pi\"";
    let cases = [
        (driven("-u + p", pulse, 1.0, "2"), 0.51256692889779, 1e-13),
        (
            driven("u - p", triangle, 10.0, "2*pi"),
            5289.669521621,
            1e-8,
        ),
        (
            driven("p", switch, 0.0, "10"),
            // Alternating half waves of length π/3: nine complete ones and the rest of the tenth.
            PI / 3.0 - (10.0 - 9.0 * PI / 3.0),
            1e-12,
        ),
        (driven("1e9*p", spike, 0.0, "10"), 1.0, 1e-6),
        (driven("p", saw, 0.0, "2*pi"), PI, 1e-12),
    ];
    for (text, exact, within) in cases {
        for method in METHODS {
            let (found, _) = simulated(&text, method, None);
            let u = end(&found, "u");
            assert!((u - exact).abs() < within, "{method}: {u} and {exact}");
        }
    }
}

#[test]
fn a_table_is_read_from_the_file_beside_that_of_the_system() {
    let input = "[inputs.p]\nshape = \"table\"\nfile = \"force.csv\"";
    let top = tempfile::tempdir().unwrap();
    let path = top.path().join("system.toml");
    std::fs::write(&path, driven("p", input, 0.0, "3")).unwrap();
    std::fs::write(top.path().join("force.csv"), "t,p\n0,0\n1,2\n2,0\n").unwrap();
    let file = SystemFile::open(path.to_str().unwrap()).unwrap();
    let found = Run::of(file.with(&[]).unwrap(), &options("taylor"), None);
    assert!((end(&found, "u") - 2.0).abs() < 1e-13);
}

#[test]
fn a_force_that_switches_lets_a_block_go_at_that_time() {
    // Friction holds 1 until the force becomes 1.5 at t = 2; then the block moves by t²/4 … .
    let text = "name = \"block\"\n[states]\nx = \"\"\nv = \"\"\n[inputs.force]\nshape = \"table\"\n\
                times = [0, 2, 3]\nvalues = [0.9, 1.5, 0.5]\nbetween = \"constant\"\n\
                [contacts.floor]\nboundary = \"v\"\nfriction = \"1\"\n[field]\nx = \"v\"\n\
                v = \"force - friction(floor)\"\n[start]\nx = 0\nv = 0\n[time]\nend = 6\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, None);
        let kinds: Vec<(f64, &str)> = transitions.iter().map(|at| (at.0, at.1)).collect();
        // It gains the velocity 0.5 by t = 3 and loses it at the rate 0.5 by t = 4.
        let [(t_exit, "stick exit"), (t_entry, "stick entry")] = kinds[..] else {
            panic!("{method}: {kinds:?}");
        };
        assert_eq!(t_exit, 2.0);
        assert!((t_entry - 4.0).abs() < 1e-11, "{method}: {t_entry}");
        assert!((end(&found, "x") - 0.5).abs() < 1e-11, "{method}");
    }
}

/// An undamped oscillator of frequency 1, driven by cos(w t), that hits a wall at 0.
const IMPACTS: &str = include_str!("../data/impacts.toml");

/// Trace of the monodromy matrix of the orbit with one impact per period. Its determinant is r²
/// (Shaw & Holmes 1983).
fn trace_of_impacts(w: f64, r: f64) -> f64 {
    let (period, gain) = (2.0 * PI / w, 1.0 / (1.0 - w * w));
    let (c, s) = (math::cos(period), math::sin(period));
    // x(T) = 0 and v(T) = −v⁺/r are linear in the cosine and sine of the phase, in units of v⁺.
    let matrix = Matrix2::new(
        gain * (1.0 - c),
        gain * w * s,
        gain * s,
        gain * w * (c - 1.0),
    );
    let right = Vector2::new(-s, -1.0 / r - c);
    let phase = matrix.lu().solve(&right).unwrap();
    // The solution with v⁺ < 0, away from the wall.
    let speed = -1.0 / phase.norm();
    let (hit, push) = (-speed / r, phase[0] * speed);
    -2.0 * r * c + s * (1.0 + r) * push / hit
}

#[test]
fn an_impacting_orbit_has_its_multipliers() {
    for (w, r) in [(2.5, 0.8), (2.3, 0.6)] {
        for method in METHODS {
            let system = with(IMPACTS, &[("w", w), ("r", r)]);
            let (trace, determinant) = trace_and_determinant(&orbit(&system, &options(method)));
            let exact = trace_of_impacts(w, r);
            assert!(
                (trace - exact).abs() < 1e-9,
                "{method}: {trace} and {exact}"
            );
            assert!(
                (determinant - r * r).abs() < 1e-9,
                "{method}: {determinant}"
            );
        }
    }
}

/// Place where a function of one variable changes its sign.
fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let at_low = f(low);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if f(middle) * at_low > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn the_flip_of_an_impacting_orbit_is_located() {
    let r = 0.8;
    let exact = root(2.5, 2.8, |w| trace_of_impacts(w, r) + 1.0 + r * r);
    for method in METHODS {
        let found = branch(&system(IMPACTS), ("w", 2.4, 2.9), &options(method));
        let [flip] = flips(&found)[..] else {
            panic!("{:?}", found.special);
        };
        let w = flip.parameter;
        assert!((w - exact).abs() < 1e-10, "{method}: {w} and {exact}");
    }
}

/// A buck converter in voltage mode. Its switch closes where a ramp passes the amplified error, and
/// opens with the next ramp.
pub const BUCK: &str = include_str!("../data/buck.toml");

/// Phase at which the switch closes on the orbit of period one, and the trace of its monodromy
/// matrix. The determinant is exp(−T/(R C)).
fn of_buck(input: f64) -> (f64, f64) {
    let period = 400e-6;
    let a = Matrix2::new(-1.0 / (22.0 * 47e-6), 1.0 / 47e-6, -1.0 / 0.02, 0.0);
    let b = Vector2::new(0.0, input / 0.02);
    let inverse = a.try_inverse().unwrap();
    let flow = |t: f64| (a * t).exp();
    let at_close = |close: f64| {
        let driven = inverse * (flow(period - close) - Matrix2::identity()) * b;
        let begin = (Matrix2::identity() - flow(period)).try_inverse().unwrap() * driven;
        flow(close) * begin
    };
    let above = |close: f64| 8.4 * (at_close(close)[0] - 11.3) - 3.8 - 4.4 * close / period;
    let close = root(0.0, period, above);
    let x = at_close(close);
    let rate = 8.4 * (a * x)[0] - 4.4 / period;
    let saltation = Matrix2::identity() + b * RowVector2::new(8.4, 0.0) / rate;
    let monodromy = flow(period - close) * saltation * flow(close);
    (close, monodromy.trace())
}

#[test]
fn a_buck_converter_is_followed_through_its_flip() {
    for method in METHODS {
        let (found, transitions) = simulated(BUCK, method, 0.06);
        assert!(end(&found, "v") > 11.0);
        let closes: Vec<f64> = transitions
            .iter()
            .filter(|at| at.2 == "close")
            .map(|at| at.0)
            .collect();
        let last = closes.last().unwrap() % 400e-6;
        let (close, _) = of_buck(18.0);
        assert!((last - close).abs() < 1e-9, "{method}: {last} and {close}");
    }
    let determinant = math::exp(-400e-6 / (22.0 * 47e-6));
    let exact = root(22.0, 27.0, |input| of_buck(input).1 + 1.0 + determinant);
    let found = branch(&system(BUCK), ("E", 17.0, 27.0), &options("taylor"));
    let [flip] = flips(&found)[..] else {
        panic!("{:?}", found.special);
    };
    let input = flip.parameter;
    assert!((input - exact).abs() < 1e-8, "{input} and {exact}");
}

/// The derivative of the flow by differences.
fn by_differences(of: &DynamicsRef<'_>, start: &[f64], t_end: f64, free: &[usize]) -> Matrix {
    let h = 1e-6;
    let reached = |k: usize, by: f64| {
        let mut x = start.to_vec();
        x[k] += by;
        let at = Moment {
            t: 0.0,
            x: Vector::from_vec(x),
        };
        let mut orbit = of.begin(&at, t_end, &options("taylor"), &[]).unwrap();
        loop {
            if let OrbitProgress::End(summary) = orbit.step().unwrap() {
                break summary.x;
            }
        }
    };
    let column = |&k: &usize| (reached(k, h) - reached(k, -h)) / (2.0 * h);
    Matrix::from_columns(&free.iter().map(column).collect::<Vec<_>>())
}

#[test]
fn derivatives_go_through_jumps_of_each_kind() {
    // A moving wall; a value that is stored when it is read; a relay; a switch by time; a block
    // that sticks to a belt and hits a wall.
    let wall = IMPACTS
        .replace("when = \"x\"", "when = \"x - 0.1*sin(t)\"")
        .replace("v = \"-r*v\"", "v = \"-r*v + (1 + r)*0.1*cos(t)\"");
    let held = "name = \"held\"\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nkept = 0.3\n[field]\n\
                x = \"v\"\nv = \"-x - 0.4*kept + 0.3*cos(t)\"\n[jumps.read]\nwhen = \"v - 0.05\"\n\
                set = { kept = \"x*x + v\" }\n[start]\nx = 1\nv = 0\n";
    let belt = "name = \"belt\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\n\
                boundary = \"v - 0.4\"\nfriction = \"0.5\"\nstatic = \"0.7\"\n[jumps.wall]\n\
                when = \"x - 0.5\"\ndirection = \"rising\"\nset = { v = \"-0.6*v\" }\n[field]\n\
                x = \"v\"\nv = \"-x + 0.2*cos(t) - friction(belt)\"\n[start]\nx = -0.2\nv = 0\n";
    let cases = [
        (belt.to_owned(), vec![-0.2, 0.0], vec![0, 1]),
        (wall, vec![-0.3, 0.0], vec![0, 1]),
        (held.to_owned(), vec![1.0, 0.0, 0.3], vec![0, 1, 2]),
        (relay([-1.0, 1.0]), vec![0.3, 1.0, -1.0], vec![0, 1]),
        (BUCK.to_owned(), vec![12.0, 0.55, 0.0], vec![0, 1]),
    ];
    for (text, start, free) in cases {
        let system = system(&text);
        let t_end = if text.contains("buck") { 0.0031 } else { 9.7 };
        for method in METHODS {
            let found = Monodromy::of(
                system.dynamics(),
                0.0,
                start.as_slice(),
                t_end,
                &options(method),
            );
            let found = found.unwrap().matrix;
            let exact = by_differences(system.dynamics(), &start, t_end, &free);
            for (column, &k) in free.iter().enumerate() {
                let off = (found.column(k) - exact.column(column)).amax();
                assert!(
                    off < 1e-6 * (1.0 + exact.amax()),
                    "{method}: {found} {exact} {text}"
                );
            }
            for k in (0..start.len()).filter(|k| !free.contains(k)) {
                assert_eq!(
                    found.column(k).amax(),
                    0.0,
                    "a discrete state has no neighbours"
                );
            }
        }
    }
}

#[test]
fn exponents_of_an_impacting_orbit_are_those_of_its_multipliers() {
    // Next to the flip both multipliers are real.
    let (w, r) = (2.651, 0.8);
    let (half, period) = (0.5 * trace_of_impacts(w, r), 2.0 * PI / w);
    let width = (half * half - r * r).sqrt();
    let exact = [half - width, half + width].map(|of: f64| math::ln(of.abs()) / period);
    for method in METHODS {
        // Whole periods, after the orbit has been reached to 1e-12 or so.
        let impacts = with(IMPACTS, &[("w", w)]);
        let settings = SpectrumOptions::over(500.0 * period, 100.0 * period);
        let settings = settings.solver(options(method));
        let start = impacts.start().unwrap();
        let found = lyapunov_spectrum(impacts.dynamics(), (0.0, &start[..]), &settings).unwrap();
        for (k, exact) in exact.iter().enumerate() {
            let value = found.exponents[k].value();
            assert!(
                (value - exact).abs() < 1e-9,
                "{method}: {value} and {exact}"
            );
        }
    }
}

#[test]
fn the_graze_of_a_wall_is_located_on_the_branch_that_touches_it() {
    // A damped oscillator whose amplitude 1/√((1 − w²)² + (2 ζ w)²) grows to the gap of 0.5.
    let text = "name = \"graze\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nw = 2.5\n[field]\n\
                x = \"v\"\nv = \"-x - 0.1*v + cos(w*t)\"\n[jumps.wall]\nwhen = \"x - 0.5\"\n\
                direction = \"rising\"\nset = { v = \"-0.8*v\" }\n[start]\nx = 0\nv = 0\n\
                [time]\nperiod = \"2*pi/w\"\n";
    let square = |w: f64| (1.0 - w * w) * (1.0 - w * w) + 0.01 * w * w;
    let exact = root(1.2, 2.5, |w| square(w) - 4.0);
    // Orbits without the jump and with it meet at the graze.
    for (start, method) in [2.5, 1.6]
        .into_iter()
        .flat_map(|w| METHODS.map(|method| (w, method)))
    {
        let found = branch(
            &with(text, &[("w", start)]),
            ("w", 1.2, 3.0),
            &options(method),
        );
        let [at] = &changes(&found)[..] else {
            panic!("{start}, {method}: {:?}", found.special);
        };
        let CycleBifurcation::Sequence(change) = &at.what else {
            panic!("{at:?}");
        };
        // The wall is the only jump of a system without contacts.
        assert_eq!(change.bifurcation, SequenceBifurcation::JumpGrazing);
        assert_eq!(change.contacts, [0]);
        let off = (at.parameter - exact).abs();
        assert!(
            off <= at.uncertainty && off < 1e-11,
            "{start}, {method}: {off:e}, {:e}",
            at.uncertainty
        );
    }
}

/// The orbit of amplitude 1/√((1 − w²)² + (0.1 w)²) in closed form, with the wall exactly there: no
/// neighbour on its other side has a like impact.
#[test]
fn an_exact_graze_has_no_monodromy_matrix() {
    let w = 2.5;
    let square: f64 = (1.0 - w * w) * (1.0 - w * w) + 0.01 * w * w;
    let start = [(1.0 - w * w) / square, 0.1 * w * w / square];
    let period = 2.0 * PI / w;
    for (beyond, method) in [0.0, 1e-6]
        .into_iter()
        .flat_map(|x| METHODS.map(|of| (x, of)))
    {
        let gap = square.sqrt().recip() + beyond;
        let system = system(&format!(
            "name = \"graze\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\n\
             v = \"-x - 0.1*v + cos({w}*t)\"\n[jumps.wall]\nwhen = \"x - {gap:?}\"\n\
             direction = \"rising\"\nset = {{ v = \"-0.8*v\" }}\n[start]\nx = 0\nv = 0\n"
        ));
        let dynamics = system.dynamics();
        let flow = Monodromy::of(dynamics, 0.0, &start[..], period, &options(method));
        match beyond > 0.0 {
            true => {
                let determinant = flow.unwrap().matrix.determinant();
                assert!((determinant - math::exp(-0.1 * period)).abs() < 1e-10);
            }
            false => {
                let error = flow.unwrap_err();
                let is_graze = matches!(error, Error::TangentSingular { .. });
                assert!(is_graze, "{method}: {error:?}");
            }
        }
    }
}

/// The changes of the phases on a branch.
fn changes(branch: &TwoSidedBranch) -> Vec<&SpecialPoint> {
    let is_change = |at: &&SpecialPoint| matches!(at.what, CycleBifurcation::Sequence(_));
    branch.special.iter().filter(is_change).collect()
}

/// A map as a jump of a clock: between the jumps the state stays where it is, or all but.
fn clocked([states, start]: [&str; 2], parameters: &str, field: &str, set: &str) -> String {
    format!(
        "name = \"map\"\n[states]\n{states}\n[parameters]\n{parameters}\n[field]\n{field}\n\
         [jumps.map]\nwhen = \"sin(2*pi*(t - 0.3))\"\ndirection = \"rising\"\nset = {{ {set} }}\n\
         [start]\n{start}\n[time]\nperiod = 1\n"
    )
}

/// Asserts the names and the parameters of the special orbits on a branch of one period.
fn has_special(text: &str, along: (&str, f64, f64), step: f64, expected: &[(&str, f64)]) {
    let (system, options) = (system(text), options("taylor"));
    let search = PeriodicSearch {
        periods: Some(1),
        ..SEARCH
    };
    let orbit = orbit_from(&system, 0.0, &search, &options);
    let found = branch_through(&system, &orbit, along, step, &options);
    assert_eq!(found.special.len(), expected.len(), "{:?}", found.special);
    for (at, (what, exact)) in found.special.iter().zip(expected) {
        assert_eq!(at.what.to_string(), *what);
        let off = (at.parameter - exact).abs();
        assert!(
            off <= at.uncertainty && at.uncertainty < 1e-8,
            "{at:?} for {exact}"
        );
    }
}

#[test]
fn maps_written_as_jumps_have_their_folds_flips_and_branch_points() {
    let henon = clocked(
        ["x = \"\"\ny = \"\"", "x = 0.5\ny = 0"],
        "a = 0.3\nb = 0.3",
        "x = \"0\"\ny = \"0\"",
        "x = \"1 - a*x^2 + y\", y = \"b*x\"",
    );
    // With b = 0.3: −(1 − b)²/4 and 3 (1 − b)²/4.
    has_special(
        &henon,
        ("a", -0.2, 0.6),
        0.02,
        &[("fold", -0.1225), ("flip", 0.3675)],
    );
    let logistic = clocked(
        ["x = \"\"", "x = 0.3"],
        "r = 2.8",
        "x = \"-0.05*x\"",
        "x = \"exp(0.05)*r*x*(1 - x)\"",
    );
    has_special(
        &logistic,
        ("r", 0.5, 4.0),
        0.1,
        &[("branch point", 1.0), ("flip", 3.0)],
    );
}

/// The branch at rest flips where the branch of twice the period begins.
#[test]
fn a_driven_system_at_rest_is_followed_through_its_flip() {
    let text = "name = \"mathieu\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\ne = 0.3\nc = 0.1\n\
                [field]\nx = \"v\"\nv = \"-(0.25 + e*cos(t))*x - c*v - x^3\"\n[start]\nx = 0.1\n\
                v = 0\n[time]\nperiod = \"2*pi\"\n";
    let along = ("e", 0.0, 0.5);
    let options = options("taylor");
    let moving = branch(&system(text), along, &options);
    let resting = system(&text.replace("x = 0.1\n", "x = 0\n"));
    let search = PeriodicSearch {
        periods: Some(1),
        transient: Some(0.0),
        ..SEARCH
    };
    let orbit = orbit_from(&resting, 0.0, &search, &options);
    let at_rest = branch_through(&resting, &orbit, along, 0.02, &options);
    // The branch of twice the period ends at the flip of its half, if it begins as one that moves.
    let [begins] = flips(&at_rest)[..] else {
        panic!("{:?}", at_rest.special);
    };
    let Stop::Flip {
        parameter,
        uncertainty,
    } = moving.stops[0]
    else {
        panic!("{:?}", moving.stops);
    };
    // Next to the flip the run has not quite come to rest. At twice the period, the branch at rest
    // meets the one that moves.
    let slow = with(text, &[("e", 0.1)]);
    let through = |periods: u32| {
        let of = PeriodicSearch {
            periods: Some(periods),
            ..SEARCH
        };
        let orbit = orbit_from(&slow, 0.0, &of, &options);
        let branch = branch_through(&slow, &orbit, along, 0.02, &options);
        let at = &branch.special[0];
        (at.what.clone(), (at.parameter, at.uncertainty))
    };
    let [(once, flip), (twice, point)] = [1, 2].map(through);
    assert_eq!(
        [once, twice],
        [CycleBifurcation::Flip, CycleBifurcation::BranchPoint]
    );
    for (other, its) in [(parameter, uncertainty), flip, point] {
        let sum = begins.uncertainty + its;
        let off = (begins.parameter - other).abs();
        assert!(off <= sum && sum < 1e-8, "{begins:?} and {other} ± {its:e}");
    }
    assert_eq!(at_rest.stops, [Stop::Range, Stop::Range]);
}

/// A damped oscillator, driven with a period of 2, with a kick at an event.
fn kicked(input: &str, when: &str) -> String {
    format!(
        "name = \"kicked\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nph = 0\n{input}\n[field]\n\
         x = \"v\"\nv = \"-x - 0.3*v + 0.2*sin(pi*t)\"\n[jumps.kick]\nwhen = \"{when}\"\n\
         direction = \"rising\"\nset = {{ v = \"v + 1\" }}\n[start]\nx = 0.1\nv = 0\n[time]\n\
         period = 2\nend = 20\n"
    )
}

/// Its multipliers have the product exp(−0.4·2π), by Liouville.
#[test]
fn a_driven_system_that_comes_to_rest_has_a_periodic_orbit() {
    let text = "name = \"decays\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\n\
                v = \"-(1 + 0.1*cos(t))*x - 0.4*v\"\n[start]\nx = 1\nv = 0\n[time]\n\
                period = \"2*pi\"\n";
    let decays = system(text);
    for transient in [0.0, 20.0, 200.0] {
        let search = PeriodicSearch {
            transient: Some(transient),
            ..SEARCH
        };
        let found = orbit_from(&decays, 0.0, &search, &options("taylor"));
        let (_, determinant) = trace_and_determinant(&found);
        let off = (determinant - math::exp(-0.8 * PI)).abs();
        assert!(off < 1e-10, "{transient}: {determinant}");
        let (t, x) = (found.t, found.x.as_slice());
        let dynamics = decays.dynamics();
        let (extremes, _) =
            extremes(dynamics, (t, x), t + found.period, &options("taylor")).unwrap();
        let (low, high) = extremes[0];
        assert!(
            low.abs() < 1e-10 && high.abs() < 1e-10,
            "{transient}: {low} {high}"
        );
    }
}

/// The state between kicks is so smooth that a step would last many of their periods.
#[test]
fn a_slow_state_is_kicked_by_a_fast_clock_every_time() {
    let text = "name = \"slow\"\n[states]\nx = \"\"\n[field]\nx = \"-0.001*x\"\n[jumps.kick]\n\
                when = \"sin(2*pi*t)\"\ndirection = \"rising\"\nset = { x = \"x + 1\" }\n\
                [start]\nx = 0\n[time]\nend = 2000.5\n";
    let decay = math::exp(-0.001);
    let exact = (1.0 - math::exp(-2.0)) / (1.0 - decay) * math::exp(-0.0005);
    for method in METHODS {
        let (found, transitions) = simulated(text, method, None);
        assert_eq!(transitions.len(), 2000, "{method}");
        let x = end(&found, "x");
        assert!((x / exact - 1.0).abs() < 1e-11, "{method}: {x}, {exact}");
    }
}

/// A relay with hysteresis, and a block on a belt, in units of time in which they are fast.
#[test]
fn an_orbit_is_found_by_default_on_a_short_time_scale() {
    let room = |tau: f64| {
        format!(
            "name = \"room\"\n[states]\nT = \"\"\n[parameters]\n[discrete]\nh = 1\n[field]\n\
             T = \"(5 + 30*h - T)/{tau}\"\n[jumps.on]\nwhen = \"T - 19\"\n\
             direction = \"falling\"\nset = {{ h = \"1\" }}\n[jumps.off]\nwhen = \"T - 21\"\n\
             direction = \"rising\"\nset = {{ h = \"0\" }}\n[start]\nT = 19\n"
        )
    };
    let tau = 2e-4;
    let exact = tau * (math::ln(16.0 / 14.0) + math::ln(16.0 / 14.0));
    let period = orbit(&system(&room(tau)), &options("taylor")).period;
    assert!(
        (period / exact - 1.0).abs() < 1e-12,
        "{period:e}, {exact:e}"
    );

    let block = |w: f64| {
        format!(
            "name = \"block\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\n[field]\nx = \"v\"\n\
             v = \"-{w}^2*x - friction(belt)\"\n[contacts.belt]\nboundary = \"v - 0.2*{w}\"\n\
             friction = \"0.4*{w}^2/(1 + 3*belt*(v - 0.2*{w})/{w})\"\n[start]\nx = 0\nv = 0\n"
        )
    };
    let [slow, fast] = [1.0, 1e4].map(|w| orbit(&system(&block(w)), &options("taylor")));
    let (period, shorter) = (slow.period, fast.period);
    assert!(
        (1e4 * shorter / period - 1.0).abs() < 1e-10,
        "{shorter:e}, {period}"
    );
    for one in [slow, fast] {
        assert_eq!(one.family, 0);
        assert!(real_multipliers(&one)[1].abs() < 1.0);
    }
}

#[test]
fn a_kick_by_the_clock_changes_no_multiplier() {
    // In each period the flow contracts areas by exp(−0.6), whatever kicks it at a fixed time.
    let square = "[inputs.d]\nshape = \"square\"\nperiod = 2\nphase = \"ph\"";
    let switch = "[switches.d]\nfunction = \"sin(pi*(t - 0.1))\"";
    for text in [
        kicked(square, "d"),
        kicked(switch, "d"),
        kicked("", "sin(pi*(t - 0.1)) + 0.3"),
    ] {
        let system = system(&text);
        for start in [0.0, 0.5, 33.3] {
            let found = orbit_from(&system, start, &SEARCH, &options("taylor"));
            let (_, determinant) = trace_and_determinant(&found);
            let off = (determinant - math::exp(-0.6)).abs();
            assert!(off < 1e-9, "{start}: {determinant} {text}");
        }
    }
}

#[test]
fn an_escapement_keeps_its_clock_going() {
    // By the flow alone: it returns to x = a after the time in which it loses the velocity of the
    // kick there. At a = 0 that is a turn, with the multiplier exp(−0.1 T).
    let flow = |t: f64| (Matrix2::new(0.0, 1.0, -1.0, -0.2) * t).exp();
    let kept = |a: f64, t: f64| {
        let flow = flow(t);
        let speed = (a - flow[(0, 0)] * a) / flow[(0, 1)];
        flow[(1, 0)] * a + flow[(1, 1)] * speed - speed + 0.5
    };
    let turn = 2.0 * PI / 0.99_f64.sqrt();
    let earlier = root(5.8, 6.25, |t| kept(-0.3, t));
    for (at, period) in [("x", turn), ("x + 0.3", earlier)] {
        let text = format!(
            "name = \"escapement\"\n[states]\nx = \"\"\nv = \"\"\n[field]\nx = \"v\"\n\
             v = \"-x - 0.2*v\"\n[jumps.kick]\nwhen = \"{at}\"\ndirection = \"rising\"\n\
             set = {{ v = \"v + 0.5\" }}\n[start]\nx = 0.1\nv = 2\n"
        );
        let found = orbit(&system(&text), &options("taylor"));
        assert!((found.period - period).abs() < 1e-11, "{found:?}");
        if at == "x" {
            let multiplier = real_multipliers(&found)[1];
            assert!(
                (multiplier - math::exp(-0.1 * turn)).abs() < 1e-9,
                "{found:?}"
            );
        }
    }
}

#[test]
fn a_clock_goes_on_where_nothing_moves() {
    let text = "name = \"settled\"\n[states]\nu = \"\"\n[discrete]\ns = 0\n[field]\nu = \"-u\"\n\
                [inputs.clock]\nshape = \"square\"\nperiod = 1\n[jumps.sample]\nwhen = \"clock\"\n\
                direction = \"rising\"\nset = { s = \"u\" }\n[start]\nu = 1\n[time]\nend = 200\n";
    for method in METHODS {
        let (_, transitions) = simulated(text, method, None);
        assert_eq!(transitions.len(), 200, "{method}");
    }
}

#[test]
fn switches_that_touch_zero_or_stay_there_end() {
    for (function, exact) in [
        ("exp(-100*t)", 20.0),
        ("max(sin(t), 0)", 20.0),
        ("1 - cos(t)", 20.0),
        ("cos(t) - 1", -20.0),
        ("(t - 5)^3", 10.0),
        ("abs(t - 5) - 1", 16.0),
    ] {
        let switch = format!("[switches.p]\nfunction = \"{function}\"");
        let (found, _) = simulated(&driven("p", &switch, 0.0, "20"), "taylor", None);
        let u = end(&found, "u");
        assert!((u - exact).abs() < 1e-11, "{function}: {u}");
    }
}

/// A block, driven by a square wave and a switch by time, that hits a wall.
const MIXED: &str = include_str!("../data/mixed.toml");

#[test]
fn kinks_of_inputs_are_in_the_table_of_transitions() {
    for method in METHODS {
        let transitions = Run::of(system(MIXED), &options(method), None).transitions;
        let of = |name: &str| {
            let of = transitions.iter().filter(|at| at.2 == name);
            of.map(|at| (at.0, at.1)).collect::<Vec<_>>()
        };
        let (gusts, drives) = (of("gust"), of("drive"));
        for (k, (t, kind)) in (1..).zip(&gusts) {
            let exact = PI / 1.2 * f64::from(k);
            assert!(*kind == "kink" && (t - exact).abs() < 1e-12, "{gusts:?}");
        }
        for (k, (t, kind)) in (1..).zip(&drives) {
            let exact = PI / 3.6 * f64::from(k);
            assert!(*kind == "switch" && (t - exact).abs() < 1e-12, "{drives:?}");
        }
        assert_eq!((gusts.len(), drives.len()), (7, 22));
        assert!(of("wall_right").iter().all(|at| at.1 == "jump"));
        assert!(
            transitions.windows(2).all(|two| two[0].0 <= two[1].0),
            "in order of time"
        );
    }
}

#[test]
fn a_function_that_is_no_number_is_named() {
    let jump = "name = \"log\"\n[states]\nx = \"\"\n[field]\nx = \"-1\"\n[jumps.deep]\n\
                when = \"ln(x) + 50\"\nset = { x = \"1\" }\n[start]\nx = 1\n[time]\nend = 3\n";
    let switch = "[switches.late]\nfunction = \"ln(2 - t)\"";
    let set = jump
        .replace("ln(x) + 50", "x")
        .replace("x = \"1\"", "x = \"ln(x - 1)\"");
    for (text, words) in [
        (
            jump.to_owned(),
            "the function of the jump `deep` is not a number",
        ),
        (
            driven("late", switch, 0.0, "3"),
            "the function of the switch `late` is not a number at t = 2",
        ),
        (
            set,
            "the state that is set by the jump `deep` is not a number",
        ),
    ] {
        for method in METHODS {
            let reported = failed(&text, &options(method));
            assert!(reported.contains(words), "{method}: {reported}");
        }
    }
}

#[test]
fn a_pole_is_no_zero() {
    let text = "name = \"pole\"\n\
                [states]\n\
                x = \"\"\n\
                [field]\n\
                x = \"-1\"\n\
                [jumps.pole]\n\
                when = \"1/(x - 0.1234567)\"\n\
                set = { x = \"5\" }\n\
                [start]\n\
                x = 1\n\
                [time]\n\
                end = 3\n\
                [section]\n\
                function = \"1/(x - 0.7654321)\"\n";
    for method in METHODS {
        let (found, transitions) = simulated(text, method, None);
        assert!(transitions.is_empty(), "{transitions:?}");
        assert!(found.passages.is_empty(), "{method}");
        assert!((end(&found, "x") + 2.0).abs() < 1e-14, "{method}");
    }
}

#[test]
fn derivatives_by_a_parameter_go_with_the_kinks_that_it_moves() {
    let by = |input: &str| {
        format!(
            "name = \"moved\"\n\
             [states]\n\
             x = \"\"\n\
             v = \"\"\n\
             [parameters]\n\
             p = 0.3\n\
             {input}\n\
             [field]\n\
             x = \"v\"\n\
             v = \"-x - 0.3*v + (1 + 0.2*x)*d + 0.1*p\"\n\
             [start]\n\
             x = 0.1\n\
             v = 0\n\
             [jumps.wall]\n\
             when = \"x - 1\"\n\
             set = {{ v = \"-0.5*v\" }}\n"
        )
    };
    let inputs = [
        "[inputs.d]\nshape = \"square\"\nperiod = 2\nphase = \"p\"",
        "[inputs.d]\nshape = \"pulse\"\nperiod = \"1 + p\"\nwidth = 0.3",
        "[inputs.d]\nshape = \"triangle\"\nperiod = \"1 + p\"\nphase = \"p*p\"",
        "[inputs.d]\nshape = \"sawtooth\"\nperiod = \"1 + p\"",
        "[switches.d]\nfunction = \"sin(2*t) - p\"",
        "[time]\nperiod = \"2 + p\"\n[inputs.d]\nshape = \"square\"\nperiod = \"2 + p\"",
        "[time]\nperiod = \"2 + p\"\n[inputs.d]\nshape = \"table\"\ntimes = [1, 2, 3]\n\
         values = [0, 2, 1]\nbetween = \"constant\"",
    ];
    for input in inputs {
        let system = system(&by(input)).with_states_of(&[0]).unwrap();
        let start = [0.1, 0.0, 0.3];
        for method in METHODS {
            let found = Monodromy::of(&system, 0.0, start.as_slice(), 6.1, &options(method));
            let found = found.unwrap().matrix;
            let exact = by_differences(&system, &start, 6.1, &[0, 1, 2]);
            let off = (&found - &exact).amax();
            assert!(off < 1e-7, "{method}: {input} {found} {exact}");
        }
    }
}

#[test]
fn a_fold_along_the_phase_of_a_drive_is_located() {
    // Two orbits of u' = 0.05 + q(t + p) s(t) − u², one of them stable, meet where the drive is too
    // weak.
    let text = "name = \"drive\"\n[states]\nu = \"\"\n[parameters]\np = 0\n[inputs.q]\n\
                shape = \"square\"\nperiod = 2\nphase = \"p\"\n[field]\n\
                u = \"q*sin(pi*t) - 0.4 - u^2\"\n[start]\nu = 0.5\n[time]\nperiod = 2\n";
    let file = system(text);
    let system = file.with_states_of(&[0]).unwrap();
    // The highest state after a period, by the runs alone.
    let highest = |p: f64| {
        let gain = |u: f64| {
            let at = Moment {
                t: 0.3,
                x: Vector::from_vec(vec![u, p]),
            };
            let mut orbit = system.begin(&at, 2.3, &options("taylor"), &[]).unwrap();
            loop {
                if let OrbitProgress::End(summary) = orbit.step().unwrap() {
                    break summary.x[0] - u;
                }
            }
        };
        let (mut low, mut high) = (-0.5, 0.7);
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if gain(a) > gain(b) {
                high = b;
            } else {
                low = a;
            }
        }
        gain(0.5 * (low + high))
    };
    let exact = root(0.0, 0.2, highest);
    let begin = orbit_from(&file, 0.3, &SEARCH, &options("taylor"));
    let along = ("p", -0.1, 0.4);
    let found = branch_through(&file, &begin, along, 0.02, &options("taylor"));
    let folds = found
        .special
        .iter()
        .filter(|at| at.what == CycleBifurcation::Fold);
    let folds: Vec<f64> = folds.map(|at| at.parameter).collect();
    let nearest = folds.iter().map(|p| (p - exact).abs()).fold(1.0, f64::min);
    assert!(nearest < 1e-9, "{folds:?} and {exact}");
}

#[test]
fn a_stick_that_a_kink_ends_is_part_of_an_orbit() {
    // The force is 0.9 below the friction limit, except for a fifth of each half period.
    let text = "name = \"pushed\"\n\
                [states]\n\
                x = \"\"\n\
                v = \"\"\n\
                [parameters]\n\
                h = 1.5\n\
                [inputs.one]\n\
                shape = \"pulse\"\n\
                period = 10\n\
                width = 0.2\n\
                [inputs.two]\n\
                shape = \"pulse\"\n\
                period = 10\n\
                width = 0.2\n\
                phase = 0.5\n\
                [contacts.floor]\n\
                boundary = \"v\"\n\
                friction = \"1\"\n\
                [field]\n\
                x = \"v\"\n\
                v = \"h*(one - two) - 0.1*x - friction(floor)\"\n\
                [start]\n\
                x = 0\n\
                v = 0\n\
                [time]\n\
                period = 10\n";
    let pushed = system(text);
    let found = orbit_from(&pushed, 7.5, &SEARCH, &options("taylor"));
    let (x, t) = ([found.x[0], found.x[1]], found.t);
    // Its derivative by differences, in a time in which it begins at 0.
    let shifted = text
        .replace("width = 0.2\nphase = 0.5", "width = 0.2\nphase = 0.25")
        .replacen("width = 0.2\n[", "width = 0.2\nphase = 0.75\n[", 1);
    assert!((t / 10.0).fract() == 0.75, "{t}");
    let exact = by_differences(system(&shifted).dynamics(), &x, 10.0, &[0, 1]);
    let (trace, _) = trace_and_determinant(&found);
    assert!((trace - exact.trace()).abs() < 1e-7, "{found:?} {exact}");
    let branch = branch(&pushed, ("h", 1.4, 1.6), &options("taylor"));
    let last = branch.points.last().unwrap();
    let parameter = last.orbit.parameter;
    let there = with(text, &[("h", parameter)]);
    let alone = orbit(&there, &options("taylor"));
    let (t, x) = (alone.t, alone.x.as_slice());
    let (alone, _) = extremes(
        there.dynamics(),
        (t, x),
        t + alone.period,
        &options("taylor"),
    )
    .unwrap();
    let off = last.extremes[0].1 - alone[0].1;
    assert!(parameter > 1.59 && off.abs() < 1e-9, "{parameter} {off:e}");
}

/// The logistic map as a jump of a clock, by the drive and by a state that measures time.
const LOGISTIC: &str = "name = \"logistic\"\n\
                        [states]\n\
                        x = \"\"\n\
                        [parameters]\n\
                        r = 2.95\n\
                        [jumps.map]\n\
                        when = \"sin(2*pi*(t - 0.3))\"\n\
                        direction = \"rising\"\n\
                        set = { x = \"exp(0.05)*r*x*(1 - x)\" }\n\
                        [field]\n\
                        x = \"-0.05*x\"\n\
                        [start]\n\
                        x = 0.3\n\
                        [time]\n\
                        period = 1\n";

/// Its multiplier is 2 − r: each run alternates about the orbit.
#[test]
fn an_orbit_about_which_runs_alternate_has_its_shortest_period() {
    let clock = LOGISTIC
        .replace("[parameters]", "clock = \"\"\n[parameters]")
        .replace("when = \"sin(2*pi*(t - 0.3))\"", "when = \"clock - 1\"")
        .replace("set = { x", "set = { clock = \"0\", x")
        .replace("[start]", "clock = \"1\"\n[start]\nclock = 0.5")
        .replace("[time]\nperiod = 1\n", "");
    for (text, trivial) in [(LOGISTIC, 0), (clock.as_str(), 1)] {
        for r in [2.8, 2.95] {
            let found = orbit(&with(text, &[("r", r)]), &options("taylor"));
            let multiplier = real_multipliers(&found)[trivial];
            assert!((found.period - 1.0).abs() < 1e-9, "{r}: {}", found.period);
            assert!((multiplier - 2.0 + r).abs() < 1e-7, "{r}: {multiplier}");
        }
    }
    // Behind the flip, the orbit of twice the period is one.
    let found = orbit(&with(LOGISTIC, &[("r", 3.01)]), &options("taylor"));
    assert!((found.period - 2.0).abs() < 1e-9, "{}", found.period);
}

#[test]
fn a_branch_passes_from_stick_to_a_jump_in_both_directions() {
    // A block on a belt with a stop. On a fast belt it comes to the stop before it sticks.
    let text = "name = \"stop\"\n[states]\nx = \"\"\nv = \"\"\n[parameters]\nvp = 0.4\n\
                [definitions]\nslip = \"belt*(v - vp)\"\n[contacts.belt]\nboundary = \"v - vp\"\n\
                friction = \"0.25 + 0.25*exp(-(slip/0.3)^2)\"\n[jumps.stop]\nwhen = \"x - 0.45\"\n\
                direction = \"rising\"\nset = { v = \"-0.7*v\" }\n[field]\nx = \"v\"\n\
                v = \"-x - 0.02*v - friction(belt)\"\n[start]\nx = 0\nv = 0\n";
    let places = |begun: f64, method: &str| {
        let found = branch(
            &with(text, &[("vp", begun)]),
            ("vp", 0.6, 0.68),
            &options(method),
        );
        let special = found.special.iter();
        special
            .map(|at| (at.what.to_string(), at.parameter))
            .collect::<Vec<_>>()
    };
    for method in METHODS {
        // Below the change the orbit sticks; there are two kinds of orbits from 0.6455 to 0.6645.
        let [from_stick, from_jump] = [0.62, 0.65].map(|begun| places(begun, method));
        let names: Vec<&str> = from_stick.iter().map(|at| at.0.as_str()).collect();
        assert_eq!(
            names,
            ["coincidence", "fold", "fold"],
            "{method}: {from_stick:?}"
        );
        assert_eq!(from_stick.len(), from_jump.len(), "{method}: {from_jump:?}");
        for (one, other) in from_stick.iter().zip(&from_jump) {
            assert_eq!(one.0, other.0);
            assert!(
                (one.1 - other.1).abs() < 1e-9,
                "{method}: {one:?} and {other:?}"
            );
        }
    }
}
