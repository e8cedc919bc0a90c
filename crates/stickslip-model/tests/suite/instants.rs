//! Several things at one instant: contacts beside jumps, functions that are left at zero, starts
//! and ends at a jump. All have closed forms.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use numerics::SplitMix;
use stickslip::dynamics::{Moment, OrbitUnderWay, Passage, RecordedOrbit, Sampling, Vector};
use stickslip::{AtPileUp, Direction, Ending, Error, Options, math};
use stickslip_model::kernel::follow;
use stickslip_model::study::{jumps_at_start, left_out_at_start};

use crate::run::{METHODS, Run, end, options, simulated_by, system};

fn at(tolerance: f64, method: &str) -> Options {
    Options {
        rtol: tolerance,
        atol: tolerance.into(),
        ..options(method)
    }
}

/// A block with friction that a force presses against a wall.
#[derive(Debug)]
struct Pressed {
    force: f64,
    friction: f64,
    wall: f64,
    restitution: f64,
    speed: f64,
}

impl Pressed {
    fn text(&self) -> String {
        let Pressed {
            force,
            friction,
            wall,
            restitution,
            speed,
        } = self;
        format!(
            "name = \"case\"\n[time]\nend = 1000\n[states]\nx = \"\"\nv = \"\"\n\
             [contacts.floor]\nboundary = \"v\"\nfriction = \"{friction}\"\n\
             [jumps.wall]\nwhen = \"x - {wall}\"\ndirection = \"rising\"\n\
             set = {{ v = \"-{restitution}*v\" }}\n\
             [field]\nx = \"v\"\nv = \"{force} - friction(floor)\"\n\
             [start]\nx = 0\nv = {speed}\n"
        )
    }

    /// Time at which impacts and turns accumulate: each flight takes that part of the speed before
    /// it.
    fn end(&self) -> f64 {
        let (away, back) = (self.force + self.friction, self.force - self.friction);
        let first = (self.speed * self.speed + 2.0 * back * self.wall).sqrt();
        let ratio = self.restitution * (back / away).sqrt();
        let flight = self.restitution * first * (1.0 / away + 1.0 / (away * back).sqrt());
        (first - self.speed) / back + flight / (1.0 - ratio)
    }
}

#[test]
fn impacts_and_turns_of_a_block_with_friction_accumulate_at_the_wall() {
    let mut draw = SplitMix::new(63);
    for number in 0..200 {
        let force = draw.between(0.5, 5.0);
        let case = Pressed {
            force,
            friction: force * draw.between(0.05, 0.9),
            wall: draw.between(0.1, 3.0),
            restitution: draw.between(0.1, 0.9),
            speed: draw.between(0.0, 2.0),
        };
        let tolerance = [1e-8, 1e-10, 1e-12][number % 3];
        let run = Run::of(
            system(&case.text()),
            &at(tolerance, METHODS[number / 3 % 2]),
            None,
        );
        let what = format!("{number}: {case:?}");
        let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
            panic!("{what}: {:?}", run.ended);
        };
        let point = accumulation.unwrap_or_else(|| panic!("{what}: not named"));
        let off = (point.t - case.end()).abs();
        // The error of the run comes on top of that of the extrapolation.
        let allowed = 2.0 * point.uncertainty + 100.0 * tolerance * case.end();
        assert!(off < allowed && allowed < 1e-5, "{what}: {off:e}");
        assert!((point.x.0[0] - case.wall).abs() < 1e-6, "{what}");
    }
}

#[test]
fn a_velocity_in_stick_passes_a_level_once_at_a_time() {
    let mut draw = SplitMix::new(64);
    for number in 0..150 {
        let (size, rate) = (draw.between(0.1, 0.3), draw.between(1.0, 3.0));
        let (mean, level) = (draw.between(-0.03, 0.03), draw.between(-0.9, 0.9));
        let rises = draw.between(0.0, 1.0) > 0.5;
        let text = format!(
            "name = \"case\"\n[time]\nend = 40\n[states]\nx = \"\"\nv = \"\"\n\
             [contacts.belt]\nboundary = \"v - {size}*sin({rate}*t) - {mean}\"\nfriction = \"5\"\n\
             [discrete]\nn = 0\n\
             [jumps.j]\nwhen = \"v - {}\"\ndirection = \"{}\"\nset = {{ n = \"n + 1\" }}\n\
             [field]\nx = \"v\"\nv = \"-x - friction(belt)\"\n[start]\nx = 0\nv = {mean}\n",
            mean + size * level,
            if rises { "rising" } else { "falling" },
        );
        // sin(rate t) = level.
        let first = match (rises, 0.5 * PI - math::acos(level)) {
            (true, angle) => angle.rem_euclid(TAU) / rate,
            (false, angle) => (PI - angle).rem_euclid(TAU) / rate,
        };
        let times = (0..).map(|k| first + f64::from(k) * TAU / rate);
        let times: Vec<f64> = times.take_while(|t| *t < 40.0).collect();
        let tolerance = [1e-6, 1e-8, 1e-12][number / 2 % 3];
        let method = METHODS[number % 2];
        let (run, jumps) = simulated_by(&text, &at(tolerance, method), None);
        assert_eq!(jumps.len(), times.len(), "{number} {method}:\n{text}");
        assert_eq!(end(&run, "n"), times.len() as f64);
        for ((t, ..), exact) in jumps.iter().zip(&times) {
            assert!(
                (t - exact).abs() < 10.0 * tolerance,
                "{number}: {t} {exact}"
            );
        }
    }
}

/// Systems in which a step ends so near an event that it may be found twice, or not at all. Speeds
/// in stick follow the belt, so their events are counted in closed form; the other counts are those
/// of steps by brute force.
#[test]
fn each_event_happens_once_at_any_tolerance() {
    let files = [
        (include_str!("../data/jumps/drawn-counter.toml"), Some(20)),
        (include_str!("../data/jumps/two-oscillators.toml"), Some(15)),
        (include_str!("../data/jumps/speed-in-stick.toml"), Some(26)),
        (
            include_str!("../data/jumps/slow-speed-in-stick.toml"),
            Some(14),
        ),
        (include_str!("../data/jumps/three-blocks.toml"), None),
    ];
    for (text, count) in files {
        let mut ends: Vec<Vector> = Vec::new();
        for (tolerance, method) in [1e-6, 1e-8, 1e-10]
            .into_iter()
            .flat_map(|tolerance| METHODS.map(|method| (tolerance, method)))
        {
            let (run, found) = simulated_by(text, &at(tolerance, method), None);
            if let Some(count) = count {
                assert_eq!(found.len(), count, "{method} {tolerance}:\n{text}");
            }
            ends.push(run.ended.unwrap().x);
        }
        for end in &ends {
            let off = (end - ends.last().unwrap()).amax();
            assert!(off < 1e-5, "{off:e}:\n{text}");
        }
    }
}

/// Each flight of a mass in a guide with friction takes 0.6 √(7.81/11.81) of the one before it.
#[test]
fn a_mass_in_a_guide_rests_on_the_floor_where_its_impacts_accumulate() {
    const GUIDE: &str = include_str!("../data/jumps/guide.toml");
    let (down, up) = (7.81_f64, 11.81_f64);
    let speed = (2.0 * down * 0.9).sqrt();
    let flight = 0.6 * speed * (1.0 / up + 1.0 / (up * down).sqrt());
    let exact = speed / down + flight / (1.0 - 0.6 * (down / up).sqrt());
    for (tolerance, method) in [(1e-6, "taylor"), (1e-10, "dop853")] {
        let run = Run::of(system(GUIDE), &at(tolerance, method), None);
        let Err(Error::EventPileUp { accumulation, .. }) = run.ended else {
            panic!("{method}: {:?}", run.ended);
        };
        let point = accumulation.unwrap();
        assert!((point.t - exact).abs() < tolerance, "{method}: {}", point.t);
        assert!((point.x.0[0] - 0.1).abs() < 1e-9);
    }
}

#[test]
fn a_jump_whose_function_another_one_moves_on_has_happened() {
    for method in METHODS {
        let text = "name = \"case\"\n[time]\nend = 3\n[states]\nx = \"\"\n[discrete]\nn = 0\n\
                    [jumps.count]\nwhen = \"x - 1\"\ndirection = \"rising\"\n\
                    set = { n = \"n + 1\" }\n\
                    [jumps.push]\nwhen = \"t - 1\"\ndirection = \"rising\"\n\
                    set = { x = \"x + 0.5\" }\n\
                    [field]\nx = \"1\"\n[start]\nx = 0\n";
        let (run, jumps) = simulated_by(text, &options(method), None);
        assert_eq!(jumps.len(), 2, "{jumps:?}");
        assert_eq!(end(&run, "n"), 1.0);
        assert!((end(&run, "x") - 3.5).abs() < 1e-12);
    }
}

#[test]
fn a_ball_on_a_rising_floor_comes_to_rest_and_is_thrown_again() {
    // The relative speed halves until it is below a millionth: after twenty bounces.
    let text = "name = \"case\"\n[time]\nend = 200\n[states]\nx = \"\"\nv = \"\"\n\
                [discrete]\na = 1\nu = 10\n\
                [inputs.clock]\nshape = \"sawtooth\"\nperiod = 5\nphase = 0.5\n\
                [jumps.bounce]\nwhen = \"x - 0.3*t\"\ndirection = \"falling\"\n\
                set = { v = \"0.3 - (v - 0.3)/2\", u = \"-(v - 0.3)/2\" }\n\
                [jumps.rest]\nwhen = \"u - 1e-6\"\ndirection = \"falling\"\n\
                set = { v = \"0.3\", a = \"0\", u = \"10\" }\n\
                [jumps.throw]\nwhen = \"clock - 0.5\"\ndirection = \"rising\"\n\
                set = { v = \"1.3\", a = \"1\", x = \"0.3*t\" }\n\
                [field]\nx = \"v\"\nv = \"-a\"\n[start]\nx = \"0\"\nv = \"1.3\"\n";
    for method in METHODS {
        let (_, jumps) = simulated_by(text, &options(method), None);
        for (name, count) in [("bounce", 800), ("rest", 40), ("throw", 40)] {
            let found = jumps.iter().filter(|(_, _, of)| of == name).count();
            assert_eq!(found, count, "{method} {name}");
        }
    }
}

/// A ball that bounces off a floor.
fn ball(floor: f64, restitution: f64, start: (f64, f64), until: f64) -> String {
    let (height, speed) = start;
    format!(
        "name = \"case\"\n[time]\nend = {until}\n[states]\nh = \"\"\nv = \"\"\n\
         [jumps.floor]\nwhen = \"h - {floor}\"\ndirection = \"falling\"\n\
         set = {{ v = \"-{restitution}*v\" }}\n\
         [field]\nh = \"v\"\nv = \"-1\"\n[start]\nh = {height}\nv = {speed}\n"
    )
}

#[test]
fn a_body_that_starts_on_the_floor_and_falls_bounces_at_once() {
    for method in METHODS {
        for (start, jumps) in [
            ((0.0, -1.0), 1),
            ((1e-16, -1.0), 1),
            // A start is rounded.
            ((-1e-17, -1.0), 1),
            ((-1e-17, 1.0), 0),
            ((0.0, 1.0), 0),
            ((-1e-3, -1.0), 0),
            ((-1.0, -1.0), 0),
        ] {
            let (run, found) = simulated_by(&ball(0.0, 0.5, start, 0.9), &options(method), None);
            assert_eq!(found.len(), jumps, "{method} {start:?}: {found:?}");
            if let Some((t, ..)) = found.first() {
                assert!(t.abs() < 1e-12, "{method}: {t}");
                assert!((end(&run, "v") - (0.5 - 0.9)).abs() < 1e-12);
            }
        }
    }
}

/// Jumps of time and of the state at a start: the run does those of the state, and reports the
/// others.
#[test]
fn a_jump_of_time_alone_at_the_start_is_reported_as_done() {
    let text = |start: f64| {
        format!(
            "name = \"case\"\n[states]\nx = \"\"\n[discrete]\nn = 0\nm = 0\n\
             [jumps.beat]\nwhen = \"sin(pi*t)\"\ndirection = \"rising\"\n\
             set = {{ n = \"n + 1\" }}\n\
             [jumps.fall]\nwhen = \"sin(pi*t)\"\ndirection = \"falling\"\n\
             set = {{ n = \"n + 5\" }}\n\
             [jumps.never]\nwhen = \"t - {start}\"\nif = \"x < 0\"\nset = {{ n = \"9\" }}\n\
             [jumps.level]\nwhen = \"x - 1\"\nset = {{ m = \"m + 1\" }}\n\
             [field]\nx = \"1\"\n[start]\nx = 1\n[time]\nstart = {start}\n"
        )
    };
    for method in METHODS {
        for (start, left_out) in [(0.0, "the jump beat is"), (4.0, "beat"), (1.25, "")] {
            let system = system(&text(start));
            let moment = Moment {
                t: start,
                x: Vector::from_vec(system.start().unwrap()),
            };
            assert_eq!(
                jumps_at_start(&system, (start, moment.x.as_slice())),
                Ok(vec![3])
            );
            let mut orbit = RecordedOrbit::new(&moment, Sampling::Nowhere, false);
            let mut watcher = |progress, run: &mut dyn OrbitUnderWay| {
                orbit.take(progress, run);
                ControlFlow::Continue(())
            };
            let (from, options) = ((start, moment.x.as_slice()), options(method));
            let dynamics = system.dynamics();
            let ended = follow(dynamics, from, start + 0.5, &options, &[], &mut watcher);
            let (n, m) = (ended.as_ref().unwrap().x[1], ended.as_ref().unwrap().x[2]);
            assert_eq!((n, m), (0.0, 1.0), "{method} {start}");
            let words = left_out_at_start(&system, &orbit).unwrap_or_default();
            assert_eq!(words.is_empty(), left_out.is_empty(), "{words}");
            assert!(
                words.contains(left_out) && !words.contains("fall"),
                "{words}"
            );
            assert!(!words.contains("never"), "{words}");
        }
    }
}

#[test]
fn a_hop_that_rounding_hides_does_not_lead_through_the_floor() {
    // Its height, half a unit of 1e-18, is nothing beside that of the floor.
    for method in METHODS {
        for restitution in [0.5, 1.0] {
            let text = ball(0.5, restitution, (0.5, 1e-9), 3.0);
            let ended = Run::of(system(&text), &options(method), None).ended;
            assert!(
                matches!(ended, Err(Error::EventPileUp { .. })),
                "{method} {restitution}: {ended:?}"
            );
        }
    }
}

#[test]
fn a_clock_counts_the_same_in_pieces_that_end_at_its_beats() {
    for method in METHODS {
        let (mut x, mut n) = (0.0, 0.0);
        for piece in 0..6 {
            let until = f64::min(f64::from(piece) + 1.0, 5.5);
            let text = format!(
                "name = \"case\"\n[time]\nstart = {piece}\nend = {until}\n[states]\nx = \"\"\n\
                 [discrete]\nn = {n}\n\
                 [jumps.beat]\nwhen = \"sin(2*pi*t)\"\ndirection = \"rising\"\n\
                 set = {{ n = \"n + 1\" }}\n[field]\nx = \"n\"\n[start]\nx = {x}\n"
            );
            let (run, _) = simulated_by(&text, &options(method), None);
            (x, n) = (end(&run, "x"), end(&run, "n"));
        }
        assert_eq!(n, 5.0, "{method}");
        assert!((x - 12.5).abs() < 1e-10, "{method}: {x}");
    }
}

#[test]
fn contact_and_jump_on_one_surface_accumulate_and_rest_where_the_contact_holds() {
    for ratio in [0.5, 0.9, 0.95] {
        let text = format!(
            "name = \"case\"\n[time]\nend = 60\n[states]\nx = \"\"\nv = \"\"\n\
             [contacts.c]\nboundary = \"x\"\n[jumps.j]\nwhen = \"x\"\n\
             set = {{ v = \"{ratio}*v\" }}\n\
             [field]\nx = \"v\"\nv = \"-c\"\n[start]\nx = 1\nv = 0\n"
        );
        // Half an oscillation lasts twice its speed at zero.
        let limit = f64::sqrt(2.0) * (1.0 + 2.0 * ratio / (1.0 - ratio));
        for method in METHODS {
            let stopped = Run::of(system(&text), &options(method), None).ended;
            let Err(Error::EventPileUp {
                contacts,
                accumulation: Some(accumulation),
                ..
            }) = stopped
            else {
                panic!("{method} {ratio}: {stopped:?}");
            };
            assert_eq!(contacts, [0, 1]);
            assert!(accumulation.holds);
            let off = (accumulation.t - limit).abs();
            // The uncertainty contains no errors of steps.
            assert!(
                off <= accumulation.uncertainty + 2e-11,
                "{method} {ratio}: {off:e}"
            );
            let rests = options(method).at_pile_up(AtPileUp::Rest);
            let run = Run::of(system(&text), &rests, None);
            assert_eq!(run.ending(), Ending::EndTime, "{method} {ratio}");
            let (t, kind, name) = run.transitions.last().unwrap();
            assert_eq!((*kind, name.as_str()), ("stick entry", "c"));
            assert!((t - limit).abs() < 2e-11, "{method} {ratio}: {t}");
            assert!(run.end("x").abs() < 1e-12 && run.end("v").abs() < 1e-12);
        }
    }
}

#[test]
fn a_belt_that_rests_holds_a_block_at_the_limit_of_friction() {
    // The block converges to the very place where friction just holds it while the belt rests.
    let text = "name = \"case\"\n[time]\nend = 200\n[states]\nx = \"\"\nv = \"\"\n\
                [contacts.belt]\nboundary = \"v - max(sin(pi*t/1.7),0)\"\nfriction = \"1.4\"\n\
                [field]\nx = \"v\"\nv = \"- x - friction(belt)\"\n[start]\nx = 0.1\nv = 0.2\n";
    let mut all = Vec::new();
    for method in METHODS {
        let run = Run::of(system(text), &options(method), None);
        assert_eq!(run.ending(), Ending::EndTime, "{method}");
        let of = |kind: &str| -> Vec<f64> {
            let all = run.transitions.iter().filter(|(_, one, _)| *one == kind);
            all.map(|(t, ..)| *t).collect()
        };
        let (entries, exits) = (of("stick entry"), of("stick exit"));
        for (sticks, (from, to)) in [(0.85641, 3.4), (4.9415, 5.1), (8.4980, 10.2)]
            .iter()
            .enumerate()
        {
            assert!(
                (entries[sticks] - from).abs() < 1e-4,
                "{method}: {entries:?}"
            );
            assert!((exits[sticks] - to).abs() < 1e-4, "{method}: {exits:?}");
        }
        // A stick begins where the block comes to the belt's speed, and each ends.
        assert!(
            entries.len().abs_diff(exits.len()) <= 1 && entries.len() > 40,
            "{method}"
        );
        all.push((entries, exits));
    }
    // Near its limit a block slips or sticks by a millionth; until then both methods agree.
    let [one, other] = &all[..] else { panic!() };
    for (one, other) in [(&one.0, &other.0), (&one.1, &other.1)] {
        for (one, other) in one.iter().zip(other).take(8) {
            assert!((one - other).abs() < 1e-7, "{one} {other}");
        }
    }
}

/// A slide that reaches a two-fold, at t = 11.15393805 from x1 = −0.90679811, with or without a
/// second contact.
fn slide_to_two_fold(boundaries: &str, far: &str, x1: f64) -> String {
    format!(
        "name = \"case\"\n[time]\nstart = 8\nend = 15\n[states]\nx0 = \"\"\nx1 = \"\"\nx2 = \"\"\n\
         [contacts.c0]\nboundary = \"0.3503*x0 + 0.1885*x1 + 0.9389*x2 - 0.5884 - \
         0.3616*sin(1.091*t)\"\n{boundaries}[field]\n\
         x0 = \"-0.2541*x0^3 + 1.289*x0 - 0.4222*x2 - 1 + by_side(c0, -0.7373*x1, 0.9362) + \
         0.5266 + 0.9882\"\n\
         x1 = \"-0.048*x1^3 - 1.273*x2 + by_side(c0, 0.8001*x0, 0.005601) - 0.1235 - 0.4681\"\n\
         x2 = \"-0.3981*x2^3 + 0.5316*x0 + 0.5118*x1 + 0.01729*x2*sin(x2) + 0.5479 - 0.1936 - \
         1.915 + 0.3*cos(1){far}\"\n\
         [start]\nx0 = 2.6404544259281932\nx1 = {x1:?}\nx2 = 0.07076052537829378\n"
    )
}

#[test]
fn a_slide_ends_at_a_two_fold_however_many_contacts_there_are() {
    const X1: f64 = -0.9067981121029407;
    let second = "[contacts.far]\nboundary = \"x0 + 100\"\n";
    let end = |(boundaries, far): (&str, &str), x1, options: Options| {
        let text = slide_to_two_fold(boundaries, far, x1);
        let ended = Run::of(system(&text), &options, None).ended.unwrap();
        let is_two_fold = matches!(ended.ending, Ending::TwoFold(_));
        assert!(is_two_fold, "{x1} {options:?}: {ended:?}");
        ended.t
    };
    let at = |tolerance, method: &str| Options {
        rtol: tolerance,
        atol: tolerance.into(),
        ..options(method)
    };
    for contacts in [("", ""), (second, " + 0*far")] {
        for x1 in [X1, X1 - 1e-3, X1 - 3e-4, X1 + 4e-4, X1 + 1e-3] {
            let exact = end(contacts, x1, at(1e-13, "taylor"));
            assert!(x1 != X1 || (exact - 11.15393805).abs() < 1e-8, "{exact}");
            for method in METHODS {
                for tol in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13] {
                    let t = end(contacts, x1, at(tol, method));
                    // No step resolves the last 5e-7, nor a touch of ten tolerances.
                    let off = (t - exact).abs();
                    assert!(off < 1e-6 + 300.0 * tol, "{method} {tol}: {off:e}");
                }
            }
        }
    }
}

/// A slide along `z = 0` whose sides lead apart from `x = y = 0` on, while others hold. The fields
/// of its sides have equal weights, so that `x = y = 1 - t`.
fn slide_beside_holding(contacts: &str, z: &str, others: &str) -> String {
    let names = ["z", "w", "u"].map(|name| format!("{name} = 0\n"));
    format!(
        "name = \"case\"\n[time]\nend = 3\n[states]\nx = \"\"\ny = \"\"\nz = \"\"\nw = \"\"\n\
         u = \"\"\n{contacts}[field]\nx = \"-1 + 0.3*s\"\ny = \"-1 - 0.2*s\"\nz = \"{z}\"\n{others}\
         [start]\nx = 1\ny = 1\n{}",
        names.concat()
    )
}

#[test]
fn a_slide_ends_at_a_two_fold_while_other_contacts_hold() {
    let contact = |(name, state)| format!("[contacts.{name}]\nboundary = \"{state}\"\n");
    let [s, f, g] = [("s", "z"), ("f", "w"), ("g", "u")].map(contact);
    let apart = "-x*(1 + s)/2 + y*(1 - s)/2";
    let one = "w = \"0.1 - 0.3*f\"\nu = \"0\"\n";
    let two = "w = \"0.1 - 0.3*f\"\nu = \"0.2*f - 0.4*g\"\n";
    let moved = "w = \"0.1 - 0.3*f + 0.2*s\"\nu = \"0\"\n";
    // Friction of each acts on the other: the effect of both is singular at x = 0.2*0.4.
    let both = ("-x*s + 0.2*f", "w = \"0.4*s - f\"\nu = \"0\"\n");
    let cases = [
        (format!("{s}{f}"), apart, one, 1.0),
        (format!("{f}{s}"), apart, one, 1.0),
        (format!("{f}{s}{g}"), apart, two, 1.0),
        (format!("{s}{f}"), apart, moved, 1.0),
        (format!("{f}{s}"), apart, moved, 1.0),
        (format!("{s}{f}"), both.0, both.1, 0.92),
        (format!("{f}{s}"), both.0, both.1, 0.92),
    ];
    for (contacts, z, others, t) in cases {
        let text = slide_beside_holding(&contacts, z, others);
        for method in METHODS {
            for tolerance in [1e-6, 1e-9, 1e-12] {
                let run = Run::of(system(&text), &at(tolerance, method), None);
                let ended = run.ended.unwrap();
                let is_two_fold = matches!(ended.ending, Ending::TwoFold(_));
                assert!(is_two_fold, "{method} {tolerance} {text}: {ended:?}");
                // No step resolves the last 5e-7.
                let off = (ended.t - t).abs();
                assert!(
                    off < 1e-6 + 300.0 * tolerance,
                    "{method} {tolerance} {text}: {off:e}"
                );
            }
        }
    }
}

#[test]
fn watched_functions_change_no_bit_and_are_found_as_alone() {
    let belt = "name = \"case\"\n[time]\nend = 40\n[states]\nx = \"\"\nv = \"\"\n\
                [contacts.belt]\nboundary = \"v - 0.3\"\nfriction = \"1/(1 + abs(v - 0.3))\"\n\
                [field]\nx = \"v\"\nv = \"- x + 0.2*cos(1.7*t) - friction(belt)\"\n\
                [start]\nx = 0.5\nv = 0.1\n";
    let bounce = ball(0.0, 0.9, (1.0, 0.0), 12.0).replace("h = \"v\"", "h = \"v + 0*h\"");
    for (text, sections) in [
        (
            belt,
            ["x - 0.4", "v", "x*x + v*v - 0.3", "sin(3*t)", "x - 2"],
        ),
        (
            bounce.as_str(),
            ["h - 0.3", "v", "h*v - 0.1", "sin(3*t)", "h - 2"],
        ),
    ] {
        let sections = sections.map(|function| (function, Direction::Both));
        for method in METHODS {
            let run = |sections: &[_]| {
                let watched = system(text).with_sections(sections).unwrap();
                Run::of(watched, &options(method), None)
            };
            let (all, none) = (run(&sections), run(&[]));
            assert_eq!(all.transitions, none.transitions);
            let end = |run: &Run| {
                let ended = run.ended.as_ref().unwrap();
                (ended.ending, ended.t, ended.x.clone())
            };
            assert_eq!(end(&all), end(&none));
            assert!(none.passages.is_empty() && all.passages.len() > 20);
            assert!(all.passages.is_sorted_by(|one, other| one.t <= other.t));
            for (number, section) in sections.iter().enumerate() {
                let alone = run(std::slice::from_ref(section)).passages;
                let found = all.passages.iter().filter(|at| at.number == number);
                let found: Vec<_> = found
                    .cloned()
                    .map(|at| Passage { number: 0, ..at })
                    .collect();
                assert_eq!(found, alone, "{method} {section:?}");
            }
        }
    }
}

#[test]
fn two_jumps_of_one_function_happen_at_every_tooth() {
    for order in [["reset", "twin"], ["twin", "reset"]] {
        let set = |name: &str| match name {
            "reset" => "v = \"0*v\"",
            _ => "n = \"n + 1\"",
        };
        let jumps = order.map(|name| {
            format!(
                "[jumps.{name}]\nwhen = \"v - 0.3\"\ndirection = \"rising\"\nset = {{ {} }}\n",
                set(name)
            )
        });
        let text = format!(
            "name = \"case\"\n[time]\nend = 1.95\n[states]\nv = \"\"\n[discrete]\nn = 0\n\
            {}[field]\n\
             v = \"1\"\n[start]\nv = 0\n",
            jumps.concat()
        );
        for method in METHODS {
            let (run, jumps) = simulated_by(&text, &options(method), None);
            assert_eq!(
                (end(&run, "n"), jumps.len()),
                (6.0, 12),
                "{method} {order:?}: {jumps:?}"
            );
        }
    }
}

#[test]
fn a_jump_far_from_its_zero_waits_for_the_kink_of_no_input() {
    // The input multiplies nothing; the function is -0.1 where it steps.
    let text = "name = \"case\"\n[time]\nend = 0.55\n[states]\nv = \"\"\n[discrete]\nn = 0\n\
                [inputs.u]\nshape = \"table\"\ntimes = [0, 0.5, 0.5, 1]\nvalues = [0, 0, 1, 1]\n\
                [jumps.reset]\nwhen = \"v - 0.3\"\nset = { v = \"0*v\" }\n\
                [jumps.twin]\nwhen = \"v - 0.3\"\nset = { n = \"n + 1\" }\n\
                [field]\nv = \"1 + 0*u\"\n[start]\nv = 0\n";
    for method in METHODS {
        let (run, _) = simulated_by(text, &options(method), None);
        assert_eq!(end(&run, "n"), 1.0, "{method}");
    }
}

#[test]
fn a_function_that_has_left_its_zero_is_carried_through_it_by_another_jump() {
    let text = "name = \"case\"\n[time]\nend = 2\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nn = 0\n\
                [jumps.wall]\nwhen = \"x - 0.6\"\ndirection = \"rising\"\n\
                set = { v = \"-0.5*v\" }\n\
                [jumps.level]\nwhen = \"v - 0.133\"\nset = { n = \"n + 1\" }\n\
                [field]\nx = \"v\"\nv = \"1\"\n[start]\nx = 0\nv = 0\n";
    let wall = f64::sqrt(1.2);
    for method in METHODS {
        let (run, jumps) = simulated_by(text, &options(method), None);
        assert_eq!(end(&run, "n"), 3.0, "{method}: {jumps:?}");
        let times = [0.133, wall, wall, 1.5 * wall + 0.133];
        for ((t, ..), wanted) in jumps.iter().zip(times) {
            assert!((t - wanted).abs() < 1e-11, "{method}: {jumps:?}");
        }
    }
}

#[test]
fn a_ball_that_touches_the_next_one_passes_the_blow_on() {
    let text = "name = \"case\"\n[time]\nend = 3\n[states]\nx1 = \"\"\nx2 = \"\"\nx3 = \"\"\n\
                v1 = \"\"\nv2 = \"\"\nv3 = \"\"\n\
                [jumps.first]\nwhen = \"x1 - x2\"\ndirection = \"rising\"\n\
                set = { v1 = \"v2\", v2 = \"v1\" }\n\
                [jumps.second]\nwhen = \"x2 - x3\"\ndirection = \"rising\"\n\
                set = { v2 = \"v3\", v3 = \"v2\" }\n\
                [field]\nx1 = \"v1\"\nx2 = \"v2\"\nx3 = \"v3\"\nv1 = \"0\"\nv2 = \"0\"\n\
                v3 = \"0\"\n\
                [start]\nx1 = -1\nx2 = 0\nx3 = 0\nv1 = 1\nv2 = 0\nv3 = 0\n";
    for method in METHODS {
        let (run, jumps) = simulated_by(text, &options(method), None);
        assert_eq!(jumps.len(), 2, "{method}: {jumps:?}");
        assert!((end(&run, "x3") - 2.0).abs() < 1e-11, "{method}");
        assert_eq!(
            (end(&run, "v1"), end(&run, "v2"), end(&run, "v3")),
            (0.0, 0.0, 1.0)
        );
    }
}

#[test]
fn a_jump_on_the_surface_of_a_contact_happens_as_the_contact_sticks() {
    // The jump leaves the state on the surface, where the contact sticks.
    let mut draw = SplitMix::new(163);
    for _ in 0..40 {
        let (u, w, p) = (
            draw.between(-0.4, 0.4),
            draw.between(0.5, 3.0),
            draw.between(0.0, 6.0),
        );
        let text = format!(
            "name = \"case\"\n[time]\nend = 1.5\n[states]\nx = \"\"\nv = \"\"\n[discrete]\nn = 0\n\
             [contacts.c]\nboundary = \"v - {u}\"\nfriction = \"0.65\"\n\
             [jumps.j]\nwhen = \"v - {u}\"\nset = {{ n = \"n + 1\" }}\n[field]\nx = \"v\"\n\
             v = \"0.1*sin({w}*t + {p}) - 0.5*x - friction(c)\"\n[start]\nx = 0.1\nv = {}\n",
            u - 0.2
        );
        for method in METHODS {
            let (run, all) = simulated_by(&text, &options(method), None);
            let jumps = all.iter().filter(|(_, _, name)| name == "j").count();
            assert_eq!(jumps, 1, "{method}: {text}");
            assert_eq!(end(&run, "n"), 1.0, "{method}: {text}");
        }
    }
}

#[test]
fn jumps_that_accumulate_on_a_moving_function_end_the_run_there() {
    // At v = -s, where s = 1 - t, the jump leads to v = r s, and the next one comes after
    // (1 + r) s / 4.
    for ratio in [0.03, 0.5, 0.9, -0.5] {
        let text = format!(
            "name = \"case\"\n[time]\nend = 2\n[states]\nv = \"\"\n[jumps.j]\n\
             when = \"v - (t - 1)\"\ndirection = \"falling\"\nset = {{ v = \"-({ratio})*v\" }}\n\
             [field]\nv = \"-3\"\n[start]\nv = 0\n"
        );
        for method in METHODS {
            let ended = Run::of(system(&text), &options(method), None).ended;
            let Err(Error::EventPileUp {
                accumulation: Some(accumulation),
                ..
            }) = &ended
            else {
                panic!("{method} {ratio}: {ended:?}");
            };
            assert!((accumulation.t - 1.0).abs() < 1e-11, "{method}: {ended:?}");
        }
    }
}

#[test]
fn a_jump_at_the_kink_of_an_input_sees_the_value_behind_it() {
    for (start, rate, when) in [
        ("0", "n", "t - 1"),
        ("0", "n", "u - 0.5"),
        ("0", "1", "x - 1"),
        ("-1", "1", "x"),
    ] {
        let text = format!(
            "name = \"case\"\n[time]\nend = 2\n[states]\nx = \"\"\n[discrete]\nn = 0\n\
             [inputs.u]\nshape = \"table\"\ntimes = [0, 1, 1, 3]\nvalues = [0, 0, 1, 1]\n\
             [jumps.read]\nwhen = \"{when}\"\ndirection = \"rising\"\n\
             set = {{ n = \"u + 0.25\" }}\n\
             [field]\nx = \"{rate} + 0*u\"\n[start]\nx = {start}\n"
        );
        for method in METHODS {
            let (run, _) = simulated_by(&text, &options(method), None);
            assert_eq!(end(&run, "n"), 1.25, "{method} {when}");
        }
    }
}
