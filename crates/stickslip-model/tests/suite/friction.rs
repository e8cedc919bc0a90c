//! Friction laws that are negative.

use std::ops::ControlFlow;

use stickslip::Options;
use stickslip::dynamics::OrbitProgress;
use stickslip_model::file::{Source, System, SystemFile};
use stickslip_model::kernel::follow;
use stickslip_model::study::FrictionWatch;

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
