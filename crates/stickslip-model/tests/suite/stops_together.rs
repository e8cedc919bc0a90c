//! Stops whose reactions come to pull in one instant: which of them let go, against all sets of
//! stops and against closed forms.

use std::fmt::Write;

use numerics::SplitMix;
use stickslip::nalgebra::{DMatrix, DVector};

use crate::run::{METHODS, Run, options, system};

/// Numbers of random systems, by kind of instant and number of stops.
const SYSTEMS: usize = 50;

/// Least number that decides, so that rounding does not.
const CLEAR: f64 = 1e-2;

/// A body of several coordinates `q` with the inverse `w` of its mass matrix, and a stop for each
/// row of `slopes`, its gap `slopes q`. Each reaction acts along the gradient of its gap.
struct Body {
    slopes: DMatrix<f64>,
    acts: DMatrix<f64>,
    /// Second derivative of each gap by each reaction.
    coupling: DMatrix<f64>,
}

impl Body {
    fn random(random: &mut SplitMix, stops: usize, coordinates: usize) -> Self {
        let mut drawn =
            |rows, columns| DMatrix::from_fn(rows, columns, |_, _| random.between(-1.0, 1.0));
        let root = drawn(coordinates, coordinates);
        let slopes = drawn(stops, coordinates);
        let inverse_mass =
            &root * root.transpose() + DMatrix::identity(coordinates, coordinates) * 0.2;
        let acts = inverse_mass * slopes.transpose();
        Body {
            coupling: &slopes * &acts,
            slopes,
            acts,
        }
    }

    fn stops(&self) -> usize {
        self.slopes.nrows()
    }

    /// The accelerations under which the reactions are these while all stops carry.
    fn loaded(&self, reactions: &DVector<f64>) -> DVector<f64> {
        -&self.acts * reactions
    }

    /// The stops that let go, and the second derivatives of all gaps, where the reactions would be
    /// these if all stops carried: by trying all sets. `None` where rounding would decide, or where
    /// there is not exactly one set.
    fn released(&self, reactions: &DVector<f64>) -> Option<(Vec<bool>, DVector<f64>)> {
        let count = self.stops();
        let free = -&self.coupling * reactions;
        let mut found = Vec::new();
        for set in 0..1_usize << count {
            let carrying: Vec<usize> = (0..count).filter(|i| set & 1 << i == 0).collect();
            let size = carrying.len();
            let matrix =
                DMatrix::from_fn(size, size, |i, j| self.coupling[(carrying[i], carrying[j])]);
            let right = DVector::from_fn(size, |i, _| -free[carrying[i]]);
            let mut all = DVector::zeros(count);
            if size > 0 {
                let forces = matrix.lu().solve(&right)?;
                let forces = carrying.iter().zip(forces.iter());
                forces.for_each(|(i, force)| all[*i] = *force);
            }
            let opening = &free + &self.coupling * &all;
            let decides = |i: usize| match set & 1 << i {
                0 => all[i],
                _ => opening[i],
            };
            if (0..count).any(|i| decides(i).abs() < CLEAR) {
                return None;
            }
            if (0..count).all(|i| decides(i) > 0.0) {
                found.push(((0..count).map(|i| set & 1 << i != 0).collect(), opening));
            }
        }
        let one = found.pop();
        one.filter(|_| found.is_empty())
    }

    /// The system file, with the accelerations as formulas, at rest on all stops.
    fn text(&self, accelerations: &[String]) -> String {
        let coordinates = self.slopes.ncols();
        let mut text = "name = \"body\"\n[states]\n".to_owned();
        let mut line = |of: String| writeln!(text, "{of}").unwrap();
        (0..coordinates).for_each(|i| line(format!("q{i} = \"\"")));
        (0..coordinates).for_each(|i| line(format!("v{i} = \"\"")));
        line("[switches.kick]\nfunction = \"t - 1\"\n[field]".to_owned());
        (0..coordinates).for_each(|i| line(format!("q{i} = \"v{i}\"")));
        (0..coordinates).for_each(|i| line(format!("v{i} = \"{}\"", accelerations[i])));
        for stop in 0..self.stops() {
            let terms = (0..coordinates).map(|i| format!("({})*q{i}", self.slopes[(stop, i)]));
            let gap = terms.collect::<Vec<_>>().join(" + ");
            let acts = (0..coordinates).map(|i| format!("v{i} = \"{}\"", self.acts[(i, stop)]));
            let acts = acts.collect::<Vec<_>>().join(", ");
            line(format!(
                "[stops.s{stop}]\ngap = \"{gap}\"\nacts = {{ {acts} }}"
            ));
            line("restitution = 0.5".to_owned());
        }
        line("[start]".to_owned());
        (0..coordinates).for_each(|i| line(format!("q{i} = 0\nv{i} = 0")));
        (0..self.stops()).for_each(|stop| line(format!("s{stop}.closed = 1")));
        text
    }

    /// The gaps at the end of a run.
    fn gaps(&self, run: &Run) -> DVector<f64> {
        let place = (0..self.slopes.ncols()).map(|i| run.end(&format!("q{i}")));
        &self.slopes * DVector::from_iterator(self.slopes.ncols(), place)
    }
}

/// Lift-offs of a run by name, and whether nothing else has happened.
fn lift_offs(run: &Run) -> (Vec<String>, bool) {
    let mut events = run
        .transitions
        .iter()
        .filter(|(_, kind, _)| *kind != "switch");
    let mut lifted: Vec<String> = Vec::new();
    let all = events.all(|(t, _, name)| {
        lifted.push(name.clone());
        (t - 1.0).abs() < 1e-12 && name.ends_with(".lift-off")
    });
    lifted.sort();
    (lifted, all)
}

/// Which reactions come to pull, and how.
#[derive(Clone, Copy, Debug)]
enum Instant {
    /// At once.
    Kick,
    /// All vanish in the same instant.
    Together,
}

/// The stops of random bodies that let go are those of the only set after which no reaction pulls
/// and no gap closes, and each has one event.
#[test]
fn as_many_stops_let_go_as_must() {
    let mut random = SplitMix::new(67);
    for (instant, stops) in [
        (Instant::Kick, 2),
        (Instant::Kick, 3),
        (Instant::Together, 2),
        (Instant::Together, 3),
    ] {
        let (mut systems, mut fewer, mut more) = (0, 0, 0);
        while systems < SYSTEMS {
            let body = Body::random(&mut random, stops, stops + systems % 2);
            let mut drawn = |low, high| DVector::from_fn(stops, |_, _| random.between(low, high));
            let before = drawn(0.5, 2.0);
            let after = match instant {
                Instant::Kick => drawn(-2.0, 2.0),
                Instant::Together => -&before,
            };
            let pulling = after.iter().filter(|force| **force < 0.0).count();
            let Some((open, opening)) = body.released(&after) else {
                continue;
            };
            if pulling == 0 {
                continue;
            }
            systems += 1;
            let released = open.iter().filter(|open| **open).count();
            fewer += usize::from(released < pulling);
            more += usize::from(released > pulling);
            let [before, after] = [before, after].map(|reactions| body.loaded(&reactions));
            let formulas = (0..before.len()).map(|i| match instant {
                Instant::Kick => {
                    let (mean, half) = (0.5 * (after[i] + before[i]), 0.5 * (after[i] - before[i]));
                    format!("{mean} + ({half})*kick")
                }
                Instant::Together => format!("({})*(t - 1)", after[i]),
            });
            let text = body.text(&formulas.collect::<Vec<_>>());
            let names = (0..stops).filter(|stop| open[*stop]);
            let names: Vec<String> = names.map(|stop| format!("s{stop}.lift-off")).collect();
            for method in METHODS {
                let run = Run::of(system(&text), &options(method), Some(1.5));
                let (lifted, is_all) = lift_offs(&run);
                assert!(run.ended.is_ok(), "{method}: {}\n{text}", run.words());
                assert!(
                    is_all && lifted == names,
                    "{method}: {:?}\n{names:?}\n{text}",
                    run.transitions
                );
                let gaps = body.gaps(&run);
                let part = match instant {
                    Instant::Kick => 0.5 * 0.25,
                    Instant::Together => 0.125 / 6.0,
                };
                for stop in 0..stops {
                    let exact = if open[stop] {
                        part * opening[stop]
                    } else {
                        0.0
                    };
                    assert!(
                        (gaps[stop] - exact).abs() < 1e-10,
                        "{method}: {gaps} {exact}\n{text}"
                    );
                    let closed = run.end(&format!("s{stop}.closed"));
                    assert_eq!(closed, f64::from(u8::from(!open[stop])), "{method}\n{text}");
                }
            }
        }
        println!("{instant:?}, {stops}: fewer {fewer}, more {more}");
        // Both kinds occur: a stop that would pull is kept, and one that would push lets go.
        assert!(fewer > 2, "{instant:?}, {stops}: {fewer}");
        let can_be_more = matches!(instant, Instant::Kick);
        assert!(!can_be_more || more > 2, "{instant:?}, {stops}: {more}");
    }
}

/// Two stops that pull at once, of which one lets go. The reactions would be −1 and −3. Without the
/// second, the first is 5/4, and the second gap opens with 21/8.
const PAIR: &str = r#"name = "pair"
[states]
x = ""
y = ""
v = ""
w = ""
[switches.kick]
function = "t - 1"
[field]
x = "v"
y = "w"
v = "-1.75 - 0.75*kick"
w = "1.75 + 2.75*kick"
[stops.first]
gap = "x"
acts = { v = 2, w = -1.5 }
restitution = 0.5
[stops.second]
gap = "y"
acts = { v = -1.5, w = 2 }
restitution = 0.5
[start]
x = 0
y = 0
v = 0
w = 0
first.closed = 1
second.closed = 1
"#;

#[test]
fn of_two_stops_that_pull_one_lets_go() {
    for method in METHODS {
        let run = Run::of(system(PAIR), &options(method), Some(3.0));
        let (lifted, is_all) = lift_offs(&run);
        assert!(is_all, "{method}: {:?}", run.transitions);
        assert_eq!(lifted, ["second.lift-off"], "{method}");
        let (x, y) = (run.end("x"), run.end("y"));
        assert_eq!(x, 0.0, "{method}");
        assert!((y - 0.5 * 2.625 * 4.0).abs() < 1e-11, "{method}: {y}");
    }
}
