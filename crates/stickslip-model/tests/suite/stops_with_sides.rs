//! Stops whose reaction depends on the sides of contacts, against closed forms, and random systems
//! against the quadratic programme of their accelerations (Moreau 1966).

use std::fmt::Write;
use std::ops::ControlFlow;

use numerics::{SplitMix, bisect};
use stickslip::dynamics::{Modes, Moment, OrbitProgress, OrbitUnderWay};
use stickslip::{Ending, Mode, Side, math};
use stickslip_model::file::System;
use stickslip_model::kernel::follow;
use stickslip_model::study::Variables;

use super::run::{METHODS, Run, options, system, with};

/// A block of mass 1 on a floor beside a vertical belt, which moves with `A sin(w t) − B`.
const BESIDE_BELT: &str = r#"name = "Block beside a belt"
[states]
h = ""
v = ""
[parameters]
F = 2
A = 0.9
B = 0.4
w = 0.5
[contacts.belt]
boundary = "v - A*sin(w*t) + B"
friction = "F"
[stops.floor]
gap = "h"
acts = { v = 1 }
restitution = 0
[field]
h = "v"
v = "-1 - friction(belt)"
[start]
h = 0
v = 0
floor.closed = 1
[time]
end = 25
"#;

/// A box of mass `m` on a floor. A slider of mass `n` in it is driven along the vertical.
const BOX: &str = r#"name = "Box with a slider"
[states]
x = ""
y = ""
v = ""
u = ""
[parameters]
m = 0.3
n = 0.5
F = 1
P = 1.2
w = 0.5
[contacts.guide]
boundary = "u - v"
friction = "F"
[stops.floor]
gap = "x"
acts = { v = "1/m" }
restitution = 0
[field]
x = "v"
y = "u"
v = "-1 + friction(guide)/m"
u = "-1 + (P*sin(w*t) - friction(guide))/n"
[start]
x = 0
y = 0
v = 0
u = 0
floor.closed = 1
[time]
end = 10
"#;

/// Times of the events of a run of one name.
fn times(run: &Run, name: &str) -> Vec<f64> {
    let all = run.transitions.iter();
    all.filter(|(.., of)| of == name)
        .map(|(t, ..)| *t)
        .collect()
}

fn near(found: &[f64], exact: &[f64], what: &str) {
    let far = |(found, exact): (&f64, &f64)| (found - exact).abs() > 1e-9;
    let is_off = found.len() != exact.len() || found.iter().zip(exact).any(far);
    assert!(!is_off, "{what}: {found:?}, exactly {exact:?}");
}

#[test]
fn a_belt_lifts_a_block_when_it_turns_up_and_holds_it_down_before() {
    let (a, b, w) = (0.9, 0.4, 0.5);
    let turn = math::atan2(b / a, (1.0 - b * b / a / a).sqrt()) / w;
    let height = |t: f64| a / w * (math::cos(w * turn) - math::cos(w * t)) - b * (t - turn);
    let lands = bisect(turn + 1.0, 12.0, |t| height(t) < 0.0);
    let period = 4.0 * std::f64::consts::PI;
    for method in METHODS {
        let run = Run::of(system(BESIDE_BELT), &options(method), None);
        assert_eq!(run.ending(), Ending::EndTime);
        near(
            &times(&run, "floor.lift-off"),
            &[turn, turn + period],
            method,
        );
        near(
            &times(&run, "floor.impact"),
            &[lands, lands + period],
            method,
        );
        // The weight, and friction of the side.
        let moving = system(BESIDE_BELT);
        let mut quantities = moving.quantities(&[]).unwrap();
        for (side, force) in [(Side::Above, 3.0), (Side::Below, -1.0)] {
            let modes = Modes::new(&[Mode::Slip(side)]);
            assert_eq!(quantities.at(&modes, 0.0, &[0.0, 0.0, 1.0]), [force]);
        }
        // A belt that cannot lift the block does not.
        let run = Run::of(with(BESIDE_BELT, &[("F", 0.99)]), &options(method), None);
        let all: Vec<_> = run.transitions.iter().map(|(_, kind, _)| *kind).collect();
        assert!(
            all.len() == 4 && all.iter().all(|kind| *kind == "crossing"),
            "{all:?}"
        );
        assert!(run.end("h").abs() < 1e-12, "{method}: {}", run.end("h"));
    }
}

#[test]
fn the_force_between_box_and_slider_lifts_the_box() {
    let (m, n, p, w) = (0.3, 0.5, 1.2, 0.5);
    let lifts = math::atan2(0.8, (p * p - 0.64_f64).sqrt()) / w;
    let rise = |t: f64| {
        let back = (math::sin(w * t) - math::sin(w * lifts)) / w;
        let drive = p / w * (math::cos(w * lifts) * (t - lifts) - back);
        drive / (m + n) - 0.5 * (t - lifts) * (t - lifts)
    };
    let lands = bisect(lifts + 1.0, 12.0, |t| rise(t) < 0.0);
    assert!(lands < 10.0);
    for method in METHODS {
        let run = Run::of(system(BOX), &options(method), None);
        assert_eq!(run.ending(), Ending::EndTime);
        near(&times(&run, "floor.lift-off"), &[lifts], method);
        near(&times(&run, "floor.impact"), &[lands], method);
        let run = Run::of(system(BOX), &options(method), Some(8.0));
        near(&[run.end("x"), run.end("y")], &[rise(8.0); 2], method);
    }
    let boxed = system(BOX);
    let mut quantities = boxed.quantities(&[("of_guide", "guide.force")]).unwrap();
    let t = 1.3;
    let drive = p * math::sin(w * t);
    for (mode, force) in [
        (Mode::Stick, drive - n),
        (Mode::Slip(Side::Above), 1.0),
        (Mode::Slip(Side::Below), -1.0),
    ] {
        let found = quantities.at(&Modes::new(&[mode]), t, &[0.0, 0.0, 0.0, 0.0, 1.0]);
        near(&found, &[m - force, force], "forces");
    }
}

#[test]
fn a_lift_off_in_stick_has_derivatives() {
    // The drive is as large as the weight: P sin(w t) = m + n.
    let (p, weight, w): (f64, f64, f64) = (1.2, 0.8, 0.5);
    let slope = w * (p * p - weight * weight).sqrt();
    let exact = [-weight / p / slope, 1.0 / slope, 0.0];
    let boxed = system(BOX);
    let variables = Variables::named(&boxed, ["P", "m", "F"]).unwrap();
    let start = boxed.start().unwrap();
    for method in METHODS {
        let of = ((0.0, &start[..]), 5.0);
        let found = variables.along(&boxed, of, (&[5.0], &[]), &options(method));
        let found = found.unwrap();
        near(found.transitions[0].t.as_slice(), &exact, method);
        // Both move as one, by their drive and weight.
        let state = &found.states[0];
        let by = [0, 1].map(|variable| state[(0, variable)] - state[(1, variable)]);
        near(&by, &[0.0; 2], method);
    }
}

#[test]
fn a_slider_that_slips_pulls_no_more_than_its_friction() {
    for method in METHODS {
        // The box weighs more than friction can lift.
        let heavy = with(BOX, &[("m", 1.0), ("F", 0.9), ("P", 3.0)]);
        let run = Run::of(heavy, &options(method), Some(4.0));
        assert!(times(&run, "floor.lift-off").is_empty());
        let slips = math::atan2(1.4, (9.0 - 1.96_f64).sqrt()) / 0.5;
        near(&times(&run, "guide")[..1], &[slips], method);
        // A slider that is thrown up lifts a light box as long as it slips.
        let text = BOX.replace("u = 0\nfloor", "u = 2\nfloor");
        let light = with(&text, &[("P", 0.0)]);
        let run = Run::of(light, &options(method), Some(2.5));
        near(&times(&run, "floor.lift-off"), &[0.0], method);
        // They slip until v = u, by 1/m and 1/n, and fall together from where they are.
        let sticks = 2.0 / (1.0 / 0.3 + 1.0 / 0.5);
        near(&times(&run, "guide")[..1], &[sticks], method);
        let rise = 0.5 / 0.3 * sticks * sticks - 0.5 * sticks * sticks;
        let speed = (1.0 / 0.3 - 1.0) * sticks;
        let lands = sticks + speed + (speed * speed + 2.0 * rise).sqrt();
        near(&times(&run, "floor.impact"), &[lands], method);
    }
}

#[test]
fn sides_that_cancel_where_all_are_equal_decide_a_reaction_all_the_same() {
    // The reaction is 1 − a + b: of signs that oppose, one pair lifts and the other one presses.
    let text = |up: f64| {
        format!(
            "name = \"sides\"\n[states]\nv = \"\"\nu = \"\"\nh = \"\"\nw = \"\"\n[contacts.a]\n\
             boundary = \"v\"\nfriction = 0.1\n[contacts.b]\nboundary = \"u\"\nfriction = 0.1\n\
             [stops.floor]\ngap = \"h\"\nacts = {{ w = 1 }}\nrestitution = 0\n[field]\n\
             v = \"{up} - friction(a)\"\nu = \"-{up} - friction(b)\"\nh = \"w\"\n\
             w = \"-1 + a - b\"\n[start]\nv = 0\nu = 0\nh = 0\nw = 0\n[time]\nend = 3\n"
        )
    };
    for method in METHODS {
        let run = Run::of(system(&text(1.0)), &options(method), None);
        near(&[run.end("h")], &[4.5], method);
        let pressed = system(&text(-1.0));
        let mut quantities = pressed.quantities(&[]).unwrap();
        let modes = Modes::new(&[Mode::Slip(Side::Below), Mode::Slip(Side::Above)]);
        let state = [0.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(quantities.at(&modes, 0.0, &state), [3.0]);
        let run = Run::of(pressed, &options(method), None);
        assert_eq!(run.end("h"), 0.0);
    }
}

/// Bodies on a line above a floor, each with stops against the one below. Each may have a slider
/// inside, and a belt beside it.
struct Tower {
    masses: Vec<f64>,
    gravity: f64,
    restitutions: Vec<f64>,
    /// Friction between a body, or one of the sliders behind them, and another or a belt.
    frictions: Vec<Friction>,
    /// Body of each slider; masses of sliders follow those of bodies.
    sliders: Vec<usize>,
    /// Amplitude and frequency of the drive of each mass.
    drives: Vec<[f64; 2]>,
    start: Vec<f64>,
}

struct Friction {
    limit: f64,
    mass: usize,
    against: Against,
}

#[derive(Clone, Copy)]
enum Against {
    Mass(usize),
    /// Mean speed, amplitude and frequency.
    Belt([f64; 3]),
}

impl Tower {
    fn random(random: &mut SplitMix) -> Self {
        let mut a = |low: f64, high: f64| random.between(low, high);
        let bodies = 1 + a(0.0, 1.999) as usize;
        let mut sliders = Vec::new();
        let mut frictions = Vec::new();
        for body in 0..bodies {
            if a(0.0, 1.0) < 0.6 {
                let mass = bodies + sliders.len();
                sliders.push(body);
                let against = Against::Mass(body);
                let limit = a(0.2, 2.5);
                frictions.push(Friction {
                    limit,
                    mass,
                    against,
                });
            }
            if a(0.0, 1.0) < 0.4 || body + 1 == bodies && frictions.is_empty() {
                let against = Against::Belt([a(-0.4, 0.4), a(0.1, 0.8), a(0.5, 2.0)]);
                let (limit, mass) = (a(0.2, 2.5), body);
                frictions.push(Friction {
                    limit,
                    mass,
                    against,
                });
            }
        }
        let count = bodies + sliders.len();
        let masses = (0..count).map(|_| a(0.4, 1.5)).collect();
        let is_driven = a(0.0, 1.0) < 0.7;
        let drives = (0..count).map(|_| match is_driven {
            true => [a(-1.5, 1.5), a(0.5, 3.0)],
            false => [0.0, 1.0],
        });
        let drives = drives.collect();
        let mut place = a(0.0, 0.4);
        let mut places = Vec::new();
        for _ in 0..bodies {
            places.push(place);
            place += a(0.05, 0.5);
        }
        places.extend(sliders.iter().map(|_| 0.0));
        let speeds: Vec<f64> = (0..count).map(|_| a(-1.0, 1.0)).collect();
        Tower {
            masses,
            gravity: a(0.3, 1.5),
            restitutions: (0..bodies).map(|_| a(-0.3, 0.8).max(0.0)).collect(),
            frictions,
            sliders,
            drives,
            start: [places, speeds].concat(),
        }
    }

    fn bodies(&self) -> usize {
        self.masses.len() - self.sliders.len()
    }

    fn text(&self) -> String {
        let count = self.masses.len();
        let mut text = "name = \"tower\"\n[states]\n".to_owned();
        let mut line = |of: std::fmt::Arguments<'_>| writeln!(text, "{of}").unwrap();
        for letter in ["x", "v"] {
            (0..count).for_each(|i| line(format_args!("{letter}{i} = \"\"")));
        }
        let mut forces: Vec<String> = vec![String::new(); count];
        for (number, friction) in self.frictions.iter().enumerate() {
            let Friction {
                limit,
                mass,
                against,
            } = friction;
            let other = match against {
                Against::Mass(other) => {
                    forces[*other] += &format!(" + friction(c{number})");
                    format!("v{other}")
                }
                Against::Belt([mean, size, pace]) => format!("({mean} + {size}*sin({pace}*t))"),
            };
            forces[*mass] += &format!(" - friction(c{number})");
            line(format_args!(
                "[contacts.c{number}]\nboundary = \"v{mass} - {other}\""
            ));
            line(format_args!("friction = {limit}"));
        }
        for (number, restitution) in self.restitutions.iter().enumerate() {
            let own = format!("v{number} = \"1/{}\"", self.masses[number]);
            let (gap, acts) = match number.checked_sub(1) {
                None => (format!("x{number}"), own),
                Some(below) => (
                    format!("x{number} - x{below}"),
                    format!("{own}, v{below} = \"-1/{}\"", self.masses[below]),
                ),
            };
            line(format_args!(
                "[stops.s{number}]\ngap = \"{gap}\"\nacts = {{ {acts} }}"
            ));
            line(format_args!("restitution = {restitution}"));
        }
        line(format_args!("[field]"));
        (0..count).for_each(|i| line(format_args!("x{i} = \"v{i}\"")));
        for (i, force) in forces.iter().enumerate() {
            let ([size, pace], mass) = (self.drives[i], self.masses[i]);
            let gravity = self.gravity;
            line(format_args!(
                "v{i} = \"-{gravity} + ({size}*sin({pace}*t){force})/{mass}\""
            ));
        }
        line(format_args!("[start]"));
        for (i, value) in self.start.iter().enumerate() {
            let letter = if i < count { "x" } else { "v" };
            line(format_args!("{letter}{} = {value}", i % count));
        }
        text
    }

    fn gaps(&self, of: &[f64]) -> Vec<f64> {
        let below = std::iter::once(&0.0).chain(of);
        of.iter()
            .zip(below)
            .take(self.bodies())
            .map(|(x, below)| x - below)
            .collect()
    }

    /// Accelerations of all masses just after a moment, by Gauss–Seidel steps for the forces of
    /// contacts at zero and of stops that touch. `None` where rounding decides which these are.
    fn accelerations(&self, t: f64, x: &[f64]) -> Option<Vec<f64>> {
        const ZERO: f64 = 1e-10;
        const CLEAR: f64 = 1e-6;
        const REST: f64 = 1e-14;
        let count = self.masses.len();
        let (places, speeds) = (&x[..count], &x[count..2 * count]);
        let drive = |i: usize| self.drives[i][0] * math::sin(self.drives[i][1] * t);
        let mut found: Vec<f64> = (0..count)
            .map(|i| drive(i) / self.masses[i] - self.gravity)
            .collect();
        // Each force: the masses that it pushes, the acceleration that it opposes, and its limits.
        let mut forces = Vec::new();
        for Friction {
            limit,
            mass,
            against,
        } in &self.frictions
        {
            let (other, [speed, rate]) = match *against {
                Against::Mass(other) => (Some(other), [speeds[other], 0.0]),
                Against::Belt([mean, size, w]) => {
                    let speed = mean + size * math::sin(w * t);
                    (None, [speed, size * w * math::cos(w * t)])
                }
            };
            let slip = speeds[*mass] - speed;
            let limits = match slip.abs() {
                small if small < ZERO => [-limit, *limit],
                large if large > CLEAR => [-limit * slip.signum(); 2],
                _ => return None,
            };
            forces.push((*mass, other, rate, limits));
        }
        for (stop, (gap, rate)) in self
            .gaps(places)
            .into_iter()
            .zip(self.gaps(speeds))
            .enumerate()
        {
            // Impacts that accumulate are as slow as one likes.
            let (carries, touches) = (x[2 * count + stop] > 0.5, gap.abs() + rate.abs() < REST);
            if !carries && !touches {
                if gap < CLEAR && rate < CLEAR {
                    return None;
                }
                continue;
            }
            forces.push((stop, stop.checked_sub(1), 0.0, [0.0, f64::INFINITY]));
        }
        let mut values = vec![0.0; forces.len()];
        for _ in 0..20_000 {
            let mut moved = 0.0_f64;
            for ((mass, other, rate, [least, most]), value) in forces.iter().zip(&mut values) {
                let inverse = |i: usize| 1.0 / self.masses[i];
                let relative = found[*mass] - other.map_or(*rate, |other| found[other]);
                let effect = inverse(*mass) + other.map_or(0.0, inverse);
                let new = (*value - relative / effect).max(*least).min(*most);
                let change = new - std::mem::replace(value, new);
                moved = moved.max(change.abs());
                found[*mass] += change * inverse(*mass);
                if let Some(other) = *other {
                    found[other] -= change * inverse(other);
                }
            }
            if moved < 1e-14 {
                return Some(found);
            }
        }
        None
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let count = self.masses.len();
        let of = |(i, mass): (usize, &f64)| {
            mass * (0.5 * x[count + i] * x[count + i] + self.gravity * x[i])
        };
        self.masses.iter().enumerate().map(of).sum()
    }

    fn loses_energy(&self) -> bool {
        let mut frictions = self.frictions.iter();
        self.drives[0][0] == 0.0 && frictions.all(|one| matches!(one.against, Against::Mass(_)))
    }
}

/// Events of a run, the number of accelerations that were compared, lift-offs and how it ended.
struct Followed {
    events: Vec<(String, f64)>,
    compared: usize,
    lift_offs: usize,
    ended: String,
}

/// Follows a tower, whose gaps stay closed or open, and whose accelerations are those of the
/// quadratic programme.
fn followed(tower: &Tower, of: &System, method: &str, seed: u64) -> Followed {
    let options = options(method);
    let start = of.start().unwrap();
    let count = tower.masses.len();
    let mut found = Followed {
        events: Vec::new(),
        compared: 0,
        lift_offs: 0,
        ended: String::new(),
    };
    let mut energy = tower.energy(&start);
    let mut wrong = Vec::new();
    let mut watcher = |progress, orbit: &mut dyn OrbitUnderWay| {
        if let OrbitProgress::Transition(at) = &progress {
            // Rounding decides how many impacts a series has before its landing.
            let name = of.contact_name(at.contact);
            let is_again = |(other, t): &(String, f64)| *other == name && at.t - t < 1e-9;
            if name.ends_with("lift-off") && !found.events.iter().any(is_again) {
                found.events.push((name, at.t));
                found.lift_offs += 1;
            }
        }
        let OrbitProgress::Step = progress else {
            return ControlFlow::Continue(());
        };
        let step = orbit.last_step();
        let size = step.x_end.amax().max(1.0);
        let least = -10.0 * (options.atol.largest() + options.rtol * size);
        let gaps = tower.gaps(step.x_end.as_slice());
        if let Some(stop) = gaps.iter().position(|gap| *gap < least) {
            wrong.push(format!("gap {stop} is {:e} at {}", gaps[stop], step.t_end));
        }
        let now = tower.energy(step.x_end.as_slice());
        if tower.loses_energy() && now > energy + 1e-10 {
            wrong.push(format!(
                "energy rises by {:e} at {}",
                now - energy,
                step.t_end
            ));
        }
        energy = now;
        // Between the landings of one instant, rounding decides which stops touch.
        if step.t_end - step.t_start < 1e-6 {
            return ControlFlow::Continue(());
        }
        let (t, x) = (step.t_start, step.x_start.clone());
        let Some(exact) = tower.accelerations(t, x.as_slice()) else {
            return ControlFlow::Continue(());
        };
        let at = Moment { t, x };
        let velocity = of.dynamics().flow(step.mode, &at).velocity(&at);
        let off = (0..count).map(|i| (velocity[count + i] - exact[i]).abs());
        let off = off.fold(0.0, f64::max);
        found.compared += 1;
        if off.is_nan() || off > 1e-8 {
            let (mode, a) = (step.mode, velocity.as_slice());
            wrong.push(format!(
                "{mode:?} at {t}, {:?}: {a:?}, exactly {exact:?}",
                at.x.as_slice()
            ));
        }
        ControlFlow::Continue(())
    };
    let ended = follow(
        of.dynamics(),
        (0.0, &start),
        8.0,
        &options,
        &[],
        &mut watcher,
    );
    found.ended = match ended {
        Ok(_) => "end time".to_owned(),
        Err(error) => format!("{error:?}")
            .split(' ')
            .next()
            .unwrap_or_default()
            .to_owned(),
    };
    let events = &found.events;
    assert!(
        wrong.is_empty(),
        "seed {seed}, {method}: {:#?}\n{events:?}\n{}",
        &wrong[..1],
        tower.text()
    );
    found
}

#[test]
fn random_towers_have_the_accelerations_of_their_quadratic_programme() {
    // STICKSLIP_DRAWS=10000 draws more.
    let draws = std::env::var("STICKSLIP_DRAWS").ok();
    let draws = draws.and_then(|draws| draws.parse().ok()).unwrap_or(300);
    let (mut compared, mut lift_offs, mut refused) = (0, 0, Vec::new());
    for seed in 0..draws {
        let tower = Tower::random(&mut SplitMix::new(seed));
        let of = system(&tower.text());
        let both = METHODS.map(|method| followed(&tower, &of, method, seed));
        for (found, method) in both.iter().zip(METHODS) {
            compared += found.compared;
            lift_offs += found.lift_offs;
            if found.ended != "end time" {
                refused.push(format!(
                    "seed {seed}, {method}: {}\n{}",
                    found.ended,
                    tower.text()
                ));
            }
        }
        let [one, other] = both.map(|found| found.events);
        let apart =
            |(a, b): (&(String, f64), &(String, f64))| a.0 != b.0 || (a.1 - b.1).abs() > 1e-6;
        let first = one.iter().zip(&other).take(12).position(apart);
        assert!(
            first.is_none(),
            "seed {seed}: {one:?}\n{other:?}\n{}",
            tower.text()
        );
    }
    println!(
        "{compared} compared, {lift_offs} lift-offs, {} refused",
        refused.len()
    );
    assert!(refused.len() as u64 * 50 <= draws, "{}", refused.join("\n"));
    assert!(
        compared as u64 > 20 * draws && lift_offs as u64 > draws,
        "{compared}, {lift_offs}"
    );
}
