//! Friction laws that are negative, and static limits of coupled contacts.

use std::ops::ControlFlow;

use numerics::SplitMix;
use stickslip::dynamics::{OrbitProgress, Summary};
use stickslip::error::ContactFault;
use stickslip::{Error, Options};
use stickslip_model::file::{Source, System, SystemFile};
use stickslip_model::kernel::follow;
use stickslip_model::study::FrictionWatch;

use crate::run::Run;

fn system(law: &str, set: &[(String, f64)]) -> Result<System, String> {
    let text = format!(
        "name = \"block\"\n[parameters]\nmu = 0.4\n[states]\nx = \"\"\nv = \"\"\n\
         [contacts.floor]\nboundary = \"v\"\n{law}\n\
         [field]\nx = \"v\"\nv = \"cos(t) - x - friction(floor)\"\n[start]\nx = 1\nv = 1\n"
    );
    let name = "block.toml".to_owned();
    let file = SystemFile::parse(Source { name, text }).map_err(|error| error.to_string())?;
    file.with(set).map_err(|error| error.to_string())
}

fn warning(system: &System) -> Option<String> {
    let mut watch = FrictionWatch::new(system);
    let mut watcher = |progress, orbit: &mut dyn stickslip::dynamics::OrbitUnderWay| {
        if let OrbitProgress::Step = progress {
            watch.step(orbit);
        }
        ControlFlow::Continue(())
    };
    let (start, options) = ((0.0, [1.0, 1.0]), Options::default());
    let start = (start.0, &start.1[..]);
    follow(system.dynamics(), start, 6.0, &options, &[], &mut watcher).unwrap();
    watch.warning()
}

/// Frictions that add in slip, of which one does not while the other contact holds: that is refused
/// on arrival, and not followed as if they added.
#[test]
fn static_friction_that_depends_on_another_side_is_refused() {
    let text = |more: &str| {
        format!(
            "name = \"two\"\n[states]\nx = \"\"\nv = \"\"\ny = \"\"\nw = \"\"\n\
             [contacts.a]\nboundary = \"v\"\nfriction = \"1\"\nstatic = \"1.2{more}\"\n\
             [contacts.b]\nboundary = \"w\"\nfriction = \"0.5\"\n\
             [field]\nx = \"v\"\nv = \"-0.1*x - friction(a)\"\ny = \"w\"\n\
             w = \"-0.1*y - friction(b)\"\n[start]\nx = 0.1\nv = 0\ny = 0.2\nw = 0\n\
             [time]\nend = 3\n"
        )
    };
    let options = Options::default();
    let (run, _) = super::run::simulated_by(&text(""), &options, None);
    assert_eq!(run.end("x"), 0.1);
    let words = super::run::failed(&text(" + 0.1*b"), &options);
    assert!(words.contains("side of"), "{words}");
}

#[test]
fn a_constant_below_zero_is_refused_where_it_is_written() {
    for law in [
        "friction = -0.4",
        "friction = \"-mu\"",
        "friction = 0.4\nstatic = \"-0.5\"",
    ] {
        let error = system(law, &[]).err().unwrap();
        assert!(
            error.contains("must not be negative") && error.contains("a size"),
            "{error}"
        );
    }
    let set = [("mu".to_owned(), -1.0)];
    let error = system("friction = \"mu\"", &set).err().unwrap();
    assert!(
        error.contains("the friction of contact `floor` is -1"),
        "{error}"
    );
    assert!(system("friction = 0", &[]).is_ok());
}

#[test]
fn a_law_that_becomes_negative_is_told_once_with_time_and_value() {
    // Negative from t = 2 on.
    let told = warning(&system("friction = \"0.1*(2 - t)\"", &[]).unwrap()).unwrap();
    assert!(
        told.starts_with("the friction of floor is negative at t = "),
        "{told}"
    );
    let mut numbers = told
        .split(['=', ','])
        .skip(1)
        .map(|word| word.trim().parse::<f64>());
    let (t, size) = (
        numbers.next().unwrap().unwrap(),
        numbers.next().unwrap().unwrap(),
    );
    assert!(
        t > 2.0 && t < 4.0 && (size - 0.1 * (2.0 - t)).abs() < 1e-9,
        "{told}"
    );
    for law in ["mu", "mu*max(0, 2 - t)", "mu*(1 + 0.5*sin(20*t))"] {
        let system = system(&format!("friction = \"{law}\""), &[]).unwrap();
        assert_eq!(warning(&system), None, "{law}");
    }
}

#[test]
fn a_law_that_is_zero_without_a_normal_force_is_not_negative() {
    let law = "friction = \"0.1*(2 - t)\"\nnormal_force = \"2 - t\"";
    assert_eq!(warning(&system(law, &[]).unwrap()), None);
}

/// A block of mass `m` and load `b` on one of mass 1 and load `a`, on a floor.
struct Stacked {
    m: f64,
    loads: [f64; 2],
    kinetic: [f64; 2],
    limits: [f64; 2],
}

/// Floor, then the contact between the blocks: -1 and 1 for the sides, 0 for stick.
type Sides = [i8; 2];

impl Stacked {
    fn random(draw: &mut SplitMix) -> Self {
        let kinetic = [draw.between(0.2, 0.6), draw.between(0.1, 0.4)];
        Stacked {
            m: draw.between(0.2, 2.0),
            loads: [draw.between(-0.6, 0.6), draw.between(-0.6, 0.6)],
            kinetic,
            limits: kinetic.map(|force| force * draw.between(1.0, 1.6)),
        }
    }

    fn text(&self, speed: f64) -> String {
        let Stacked {
            m,
            loads: [a, b],
            kinetic,
            limits,
        } = self;
        format!(
            "name = \"stacked\"\n[time]\nend = 1\n[states]\nv1 = \"\"\nv2 = \"\"\n\
             [contacts.floor]\nboundary = \"v1\"\nfriction = {}\nstatic = {}\n\
             [contacts.between]\nboundary = \"v2 - v1\"\nfriction = {}\nstatic = {}\n[field]\n\
             v1 = \"{a} - friction(floor) + friction(between)\"\n\
             v2 = \"({b} - friction(between))/{m}\"\n[start]\nv1 = {speed}\nv2 = {speed}\n",
            kinetic[0], limits[0], kinetic[1], limits[1]
        )
    }

    /// The accelerations with these sides and the margin by which they are consistent: of forces in
    /// stick below the static limits, and of rates in slip with kinetic friction.
    fn motion(&self, [floor, between]: Sides) -> ([f64; 2], f64) {
        let [a, b] = self.loads;
        let [on_floor, above] = [floor, between].map(f64::from);
        let (v1, force) = match [floor, between] {
            [0, 0] => (0.0, b),
            [0, _] => (0.0, above * self.kinetic[1]),
            [_, 0] => {
                let v1 = (a + b - on_floor * self.kinetic[0]) / (1.0 + self.m);
                (v1, b - self.m * v1)
            }
            _ => {
                let force = above * self.kinetic[1];
                (a + force - on_floor * self.kinetic[0], force)
            }
        };
        let v2 = if between == 0 {
            v1
        } else {
            (b - force) / self.m
        };
        let of_floor = match floor {
            0 => self.limits[0] - (a + force).abs(),
            _ => on_floor * v1,
        };
        let of_between = match between {
            0 => self.limits[1] - force.abs(),
            _ => above * (v2 - v1),
        };
        ([v1, v2], of_floor.min(of_between))
    }

    /// The consistent motions of which none has a contact that could stick as well; `None` where
    /// one is nearly consistent.
    fn motions(&self) -> Option<Vec<Sides>> {
        let all = || (-1..=1).flat_map(|floor| (-1..=1).map(move |between| [floor, between]));
        if all().any(|sides| self.motion(sides).1.abs() < 1e-3) {
            return None;
        }
        let agrees = |sides: Sides| self.motion(sides).1 > 0.0;
        let sticks_more = |sides: Sides| {
            (0..2).any(|i| {
                let mut more = sides;
                more[i] = 0;
                more != sides && agrees(more)
            })
        };
        Some(
            all()
                .filter(|&sides| agrees(sides) && !sticks_more(sides))
                .collect(),
        )
    }
}

/// From rest, and where the floor is reached while the blocks stick to each other.
#[test]
fn static_limits_of_coupled_contacts_hold_what_they_can() {
    let mut draw = SplitMix::new(26);
    let (mut ambiguous, mut kept, mut torn, mut arrivals) = (0, 0, 0, 0);
    for number in 0..400 {
        let blocks = Stacked::random(&mut draw);
        let Some(motions) = blocks.motions() else {
            continue;
        };
        let options = crate::run::options(crate::run::METHODS[number % 2]);
        let ends =
            |speed: f64| Run::of(crate::run::system(&blocks.text(speed)), &options, None).ended;
        let is_refused = |run: &Result<_, Error>| {
            matches!(
                run,
                Err(Error::Contacts {
                    fault: ContactFault::NoUniqueMode { .. },
                    ..
                })
            )
        };
        let check = |run: Result<Summary, Error>, speed: f64, from: f64, sides: Sides| {
            let (rates, _) = blocks.motion(sides);
            let run = run.unwrap();
            for (v, rate) in run.x.iter().zip(rates) {
                let off = v - (speed + rate * (1.0 - from));
                assert!(off.abs() < 1e-9, "{number} {sides:?} {motions:?}: {off:e}");
            }
        };
        let from_rest = ends(0.0);
        match &motions[..] {
            [one] => check(from_rest, 0.0, 0.0, *one),
            several if several.contains(&[0, 0]) => check(from_rest, 0.0, 0.0, [0, 0]),
            several => {
                ambiguous += 1;
                assert!(
                    is_refused(&from_rest),
                    "{number} {several:?}: {from_rest:?}"
                );
            }
        }
        // Together to the floor's zero, from below.
        let ([rate, _], _) = blocks.motion([-1, 0]);
        let (t, force) = (0.1 / rate, blocks.loads[1] - blocks.m * rate);
        if !(0.0 < t && t < 0.9) || force.abs() > blocks.limits[1] - 1e-3 {
            continue;
        }
        let together: Vec<Sides> = motions
            .iter()
            .copied()
            .filter(|sides| sides[1] == 0)
            .collect();
        arrivals += 1;
        let arrived = ends(-0.1);
        match (&together[..], &motions[..]) {
            ([one], _) => {
                kept += 1;
                check(arrived, 0.0, t, *one);
            }
            ([], [one]) => {
                torn += 1;
                check(arrived, 0.0, t, *one);
            }
            _ => assert!(is_refused(&arrived), "{number} {motions:?}: {arrived:?}"),
        }
    }
    assert!(
        ambiguous > 0 && kept > 20 && torn > 0 && arrivals > 40,
        "{ambiguous} {kept} {torn} {arrivals}"
    );
}

/// Masses in a row, each on the next. A growing force pulls the last, and all contacts bear it.
/// With equal limits any of them may slip first. With different ones the weakest does.
#[test]
fn limits_that_are_reached_together_have_no_unique_motion() {
    let row = |limits: &[f64]| {
        let count = limits.len();
        let states = (0..count).map(|i| format!("v{i} = \"\"\n"));
        let contacts = limits.iter().enumerate().map(|(i, limit)| {
            let boundary = match i {
                0 => "v0".to_owned(),
                _ => format!("v{i} - v{}", i - 1),
            };
            format!("[contacts.c{i}]\nboundary = \"{boundary}\"\nfriction = 1\nstatic = {limit}\n")
        });
        let rates = (0..count).map(|i| {
            let pull = match i + 1 {
                next if next < count => format!("friction(c{next})"),
                _ => "1.49 + 0.1*t".to_owned(),
            };
            format!("v{i} = \"{pull} - friction(c{i})\"\n")
        });
        let starts = (0..count).map(|i| format!("v{i} = 0\n"));
        format!(
            "name = \"row\"\n[time]\nend = 0.5\n[states]\n{}{}[field]\n{}[start]\n{}",
            states.collect::<String>(),
            contacts.collect::<String>(),
            rates.collect::<String>(),
            starts.collect::<String>()
        )
    };
    let run = |limits: &[f64], method| {
        Run::of(
            crate::run::system(&row(limits)),
            &crate::run::options(method),
            None,
        )
    };
    for method in crate::run::METHODS {
        for count in [2, 3, 5] {
            let tied = run(&vec![1.5; count], method).ended;
            let Err(Error::Contacts { t, fault, .. }) = &tied else {
                panic!("{method} {count}: {tied:?}");
            };
            assert!(
                matches!(fault, ContactFault::NoUniqueMode { .. }),
                "{fault:?}"
            );
            assert!((t - 0.1).abs() < 1e-9, "{t}");
        }
        // The last is the weakest: it slips alone, at 1.499.
        let apart = run(&[1.5, 1.5, 1.499], method);
        let exits: Vec<_> = apart.transitions.iter().collect();
        let [(t, "stick exit", contact)] = exits[..] else {
            panic!("{exits:?}");
        };
        assert!((t - 0.09).abs() < 1e-9 && contact == "c2", "{t} {contact}");
    }
}
