//! Published test systems, from files, compared with closed forms, by both methods.

use std::f64::consts::{FRAC_PI_2, PI};

use stickslip::analysis::{AttractorKind, SpectrumOptions, Stop, basin, lyapunov_spectrum};
use stickslip::{Ending, Options, math};
use stickslip_model::study::recurrence;

use crate::run::{
    METHODS, Run, branch, end, failed, options, orbit, simulated, simulated_by, system,
};

/// Options with another tolerance.
fn at(tolerance: f64, method: &str) -> Options {
    Options::tol(tolerance)
        .method(options(method).method)
        .escape(1e6)
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
        let (found, transitions) = simulated(&text, method, None);
        let [(t, kind, _)] = &transitions[..] else {
            panic!("{transitions:?}");
        };
        assert_eq!(*kind, "stick exit");
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
        for tolerance in [1e-12, 1e-5] {
            let (found, transitions) = simulated_by(&text, &at(tolerance, method), 0.5);
            let [(t, kind, _)] = &transitions[..] else {
                panic!("{method}: {transitions:?}");
            };
            assert!(
                *kind == "stick exit" && *t < 1e-15,
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
        let (found, transitions) = simulated(&text, method, 30.0);
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
        let (found, transitions) = simulated(text, method, None);
        let [(t, kind, _)] = &transitions[..] else {
            panic!("{transitions:?}");
        };
        assert_eq!(*kind, "stick exit");
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
        let (_, lost) = simulated(text, method, None);
        let kinds: Vec<&str> = lost.iter().map(|at| at.1).collect();
        assert_eq!(kinds, ["contact loss", "crossing"]);
        assert!((lost[0].0 - 1.046_539_051_912).abs() < 1e-9, "{method}");
        let (at_loss, _) = simulated(text, method, 1.046539051912);
        let (at_turn, _) = simulated(text, method, lost[1].0);
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
        let (found, transitions) = simulated(text, method, None);
        assert_eq!(transitions.len(), 4, "{method}: {transitions:?}");
        // At rest until it is lifted, pushed by 0.5 for one time unit, then braked by 0.5 to rest.
        let mut kinds = transitions.clone();
        kinds.sort_by(|one, other| one.1.cmp(other.1));
        for ((t, kind, _), (at, name)) in kinds.iter().zip([
            (2.0, "contact gain"),
            (1.0, "contact loss"),
            (3.0, "stick entry"),
            (1.0, "stick exit"),
        ]) {
            assert_eq!(*kind, name, "{method}");
            assert!((t - at).abs() < 1e-9, "{method}: {name} at {t}");
        }
        assert!((end(&found, "x") - 0.5).abs() < 1e-9, "{method}");
    }
}

/// A block on a belt sticks until it is lifted, where its friction ends at once from 0.3. The
/// instant is that of the normal force, from any start.
#[test]
fn friction_that_ends_with_contact_does_not_end_before() {
    let text = "name = \"lifted\"\n[states]\nx = \"\"\nv = \"\"\n[contacts.belt]\n\
        boundary = \"v - 0.2\"\nfriction = \"0.3*(1 + belt*(v - 0.2))\"\n\
        normal_force = \"cos(t)\"\n[field]\nx = \"v\"\nv = \"-x - friction(belt)\"\n\
        [start]\nx = START\nv = 0.2\n";
    for start in (0..40).map(|i| -0.3 + 0.003 * f64::from(i)) {
        let text = text.replace("START", &start.to_string());
        for (method, tolerance) in METHODS.into_iter().flat_map(|of| [(of, 1e-12), (of, 1e-9)]) {
            let run = Run::of(system(&text), &at(tolerance, method), Some(2.0));
            let lost = run.transitions.iter().take(2).map(|at| (at.1, at.0));
            for ((kind, t), wanted) in lost.zip(["stick exit", "contact loss"]) {
                assert_eq!(kind, wanted, "{method}, {start}: {:?}", run.transitions);
                assert!((t - FRAC_PI_2).abs() < 1e-9, "{method}, {start}: {t}");
            }
            let touches = run.transitions.iter().any(|at| at.1 == "touch");
            assert!(run.transitions.len() >= 2 && !touches, "{method}, {start}");
        }
    }
}

/// Two beads on rails of their own.
#[test]
fn each_of_several_contacts_has_a_normal_force() {
    let beads = "name = \"beads\"\n[time]\nend = 1.9\n[states]\n\
        ph = \"\"\nw = \"\"\nps = \"\"\nu = \"\"\n\
        [parameters]\ng = 9.81\nR = 5\nmu = 0.05\n[contacts.rail]\nboundary = \"w\"\n\
        friction = \"mu*(g*cos(ph)/R + w^2)\"\nnormal_force = \"g*cos(ph) + R*w^2\"\n\
        [contacts.other]\nboundary = \"u\"\n\
        friction = \"mu*(g*cos(ps)/R + u^2)\"\nnormal_force = \"g*cos(ps) + R*u^2\"\n\
        [field]\nph = \"w\"\nw = \"-g/R*sin(ph) - friction(rail)\"\n\
        ps = \"u\"\nu = \"-g/R*sin(ps) - friction(other)\"\n\
        [start]\nph = 0\nw = \"14/5\"\nps = 0.1\nu = \"14/5\"\n";
    let bead = |start: f64| {
        format!(
            "name = \"bead\"\n[time]\nend = 1.9\n[states]\nph = \"\"\nw = \"\"\n\
             [parameters]\ng = 9.81\nR = 5\nmu = 0.05\n[contacts.rail]\nboundary = \"w\"\n\
             friction = \"mu*(g*cos(ph)/R + w^2)\"\nnormal_force = \"g*cos(ph) + R*w^2\"\n\
             [field]\nph = \"w\"\nw = \"-g/R*sin(ph) - friction(rail)\"\n\
             [start]\nph = {start}\nw = \"14/5\"\n"
        )
    };
    for method in METHODS {
        let (both, _) = simulated(beads, method, None);
        for (start, [angle, rate]) in [(0.0, ["ph", "w"]), (0.1, ["ps", "u"])] {
            let (one, _) = simulated(&bead(start), method, None);
            let off = [
                end(&one, "ph") - end(&both, angle),
                end(&one, "w") - end(&both, rate),
            ];
            assert!(off.iter().all(|off| off.abs() < 1e-9), "{method}: {off:?}");
        }
    }
}

/// Of several contacts, one that sticks by friction that its normal force does not take away.
#[test]
fn friction_that_outlasts_its_normal_force_is_told() {
    let floors = "name = \"floors\"\n[time]\nend = 5\n[states]\n\
        x = \"\"\nv = \"\"\ny = \"\"\nw = \"\"\n\
        [contacts.a]\nboundary = \"v\"\nfriction = 1\nnormal_force = \"(t - 1)*(t - 2)\"\n\
        [contacts.b]\nboundary = \"w\"\nfriction = 1\n\
        [field]\nx = \"v\"\nv = \"0.5 - friction(a)\"\ny = \"w\"\nw = \"0.5 - friction(b)\"\n\
        [start]\nx = 0\nv = 0\ny = 0\nw = 0\n";
    for method in METHODS {
        let words = failed(floors, &options(method));
        assert!(
            words.contains("the normal force of contact `a` vanishes there"),
            "{words}"
        );
        assert!(words.contains("t = 1,"), "{words}");
        // In proportion to it, friction 2 N holds up to N = 1/4.
        let text = floors.replacen("friction = 1\n", "friction = \"2*(t - 1)*(t - 2)\"\n", 1);
        let (found, transitions) = simulated(&text, method, 1.5);
        let leaves = 1.5 - 2.0_f64.sqrt() / 2.0;
        assert!(
            (transitions[0].0 - leaves).abs() < 1e-9,
            "{method}: {transitions:?}"
        );
        // From there a = 1/2 - 2 N up to t = 1, then 1/2.
        let n = |t: f64| t * t * t / 3.0 - 1.5 * t * t + 2.0 * t;
        let at_one = 0.5 * (1.0 - leaves) - 2.0 * (n(1.0) - n(leaves));
        assert!((end(&found, "v") - at_one - 0.25).abs() < 1e-9, "{method}");
        assert_eq!(end(&found, "w"), 0.0);
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
        let to_right = simulated(&with_stop("3", [0.0, 0.0]), method, 1.0).0;
        let exact = 2.0 / 3.0 * (1.0 - math::cos(3.0_f64.sqrt()));
        assert!((end(&to_right, "x") - exact).abs() < 1e-10, "{method}");
        let to_left = simulated(&with_stop("-3", [0.0, 0.0]), method, 1.0).0;
        let exact = -2.0 * (1.0 - math::cos(1.0));
        assert!((end(&to_left, "x") - exact).abs() < 1e-10, "{method}");
        let (held, transitions) = simulated(&with_stop("0.9", [0.0, 0.0]), method, None);
        assert_eq!(
            (end(&held, "x"), transitions),
            (0.0, Vec::new()),
            "{method}"
        );
        // To x = 0, where it comes to rest: half a circle about -1 from -2.
        let (arrived, transitions) = simulated(&with_stop("0", [-2.0, 0.0]), method, 9.0);
        let (t, kind, contact) = transitions.last().unwrap();
        assert_eq!((*kind, contact.as_str()), ("stick entry", "floor"));
        assert!((t - PI).abs() < 1e-8, "{method}: {t}");
        assert!(end(&arrived, "x").abs() < 1e-9, "{method}");
        // Driven from rest there, to either side.
        for sign in [1.0, -1.0] {
            let push = format!("{}*sin(t)", 1.5 * sign);
            let text = with_stop(&push, [0.0, 0.0]);
            let (driven, transitions) = simulated(&text, method, 1.0);
            let (t, kind, contact) = &transitions[0];
            assert_eq!((*kind, contact.as_str()), ("stick exit", "floor"));
            let exact = PI / 2.0 - math::acos(1.0 / 1.5);
            assert!((t - exact).abs() < 1e-10, "{method}: {t}");
            assert!(sign * end(&driven, "x") > 0.0, "{method}");
        }
    }
}

#[test]
fn an_orbit_that_shrinks_to_a_point_of_the_boundary_ends_there() {
    let text = "name = \"focus\"\n[time]\nend = 1e4\n[states]\nx = \"\"\nv = \"\"\n\
        [contacts.line]\nboundary = \"x - 0.3*v\"\n[field]\nx = \"v\"\n\
        v = \"-by_side(line, 1.2, 1.05)*x - by_side(line, 0.2, 0.05)*v\"\n\
        [start]\nx = 0.3\nv = 0\n";
    for method in METHODS {
        let (found, _) = simulated_by(text, &at(1e-10, method), None);
        // Errors of Runge-Kutta steps keep a motion below the tolerance alive, whose crossings are
        // touches.
        let ending = match method {
            "taylor" => Ending::Shrunk,
            _ => Ending::EndTime,
        };
        assert_eq!(found.ending(), ending, "{method}");
        assert!(end(&found, "x").abs() < 1e-8, "{method}");
    }
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
        let held = system(&text);
        let starts = (0..36).map(|k| {
            let [x, v] = [k % 6, k / 6].map(|k| (f64::from(k) + 0.5) / 6.0);
            [0.9 + 0.2 * x, v - 0.5]
        });
        let settings = recurrence(&held, 2000.0);
        let found = basin(held.dynamics(), starts, &settings, &options("taylor")).unwrap();
        let [attractor] = &found.attractors[..] else {
            panic!("k = {k}: {:?}", found.attractors);
        };
        assert_eq!(attractor.kind, AttractorKind::EquilibriumSet, "k = {k}");
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
        let (found, transitions) = simulated_by(&row_of_blocks(32, 16), &at(1e-11, method), None);
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
        let (found, transitions) = simulated_by(&row_of_blocks(1, 0), &at(1e-11, method), None);
        assert!(transitions.is_empty());
        assert!((end(&found, "x0") - 1.05 * math::cos(20.0)).abs() < 1e-9);
    }
    // The analyses accept it, too: both exponents are zero, and so is the multiplier's logarithm.
    let free = system(&row_of_blocks(1, 0));
    let settings = SpectrumOptions::over(200.0, 500.0).solver(options("taylor"));
    let found = lyapunov_spectrum(
        free.dynamics(),
        (0.0, &free.start().unwrap()[..]),
        &settings,
    )
    .unwrap();
    assert_eq!(found.exponents.len(), 2);
    for exponent in &found.exponents {
        assert!(
            exponent.value().abs() < exponent.uncertainty(500.0),
            "{exponent:?}"
        );
    }
    let period = orbit(&free, &options("taylor")).period;
    assert!((period - 2.0 * PI).abs() < 1e-8, "{period}");
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
            let period = orbit(&system(text), &options(method)).period;
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
    let until = |t: f64| end(&simulated(&summed, "taylor", t).0, "q");
    let exact = until(41.0) - until(40.0);
    let driven = system(text);
    for method in METHODS {
        let settings = SpectrumOptions::over(200.0, 100.0).solver(options(method));
        let start = driven.start().unwrap();
        let found = lyapunov_spectrum(driven.dynamics(), (0.0, &start[..]), &settings).unwrap();
        let value = |k: usize| found.exponents[k].value();
        assert!(value(1) < value(0) && value(0) < 0.0, "{method}: {found:?}");
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
        let (found, transitions) = simulated(text, method, None);
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
        let found = branch(&system(text), ("p", 0.0, 0.5), &options(method));
        let Stop::TwoFold {
            parameter,
            uncertainty,
        } = found.stops[0]
        else {
            panic!("{:?}", found.stops);
        };
        let off = (parameter - exact).abs();
        assert!(
            off <= uncertainty && uncertainty < 1e-9,
            "{method}: {off:e} {uncertainty:e}"
        );
    }
}
