//! Reference event times: files in data/references with their generator beside them.

use super::error::PeersError;
use super::event::Event;
use super::problem::Problem;

/// Reads the file of a problem: `problem,event,kind,t,…`. Times have 30 decimals there; the nearest doubles are kept, so that
/// an error below half a unit in the last place of a time cannot be told.
///
/// # Errors
/// [`PeersError::Reference`] with the line that is not as it should be.
pub fn reference(problem: &Problem) -> Result<Vec<Event>, PeersError> {
    parse(problem.name, problem.reference)
}

fn parse(problem: &'static str, text: &str) -> Result<Vec<Event>, PeersError> {
    let mut events = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        let wrong = |cause: String| PeersError::Reference {
            problem,
            line: index + 1,
            cause,
        };
        let cells: Vec<&str> = line.split(',').collect();
        let [name, number, kind, t, ..] = cells[..] else {
            return Err(wrong(format!("'{line}' has fewer than four cells")));
        };
        if name != problem || number != index.to_string() {
            return Err(wrong(format!(
                "'{name},{number}' where {problem},{index} is due"
            )));
        }
        let t: f64 = t.parse().map_err(|_| wrong(format!("'{t}' is no time")))?;
        events.push(Event {
            kind: kind.parse().map_err(wrong)?,
            t,
        });
    }
    let rising = events.windows(2).all(|pair| pair[0].t < pair[1].t);
    if events.is_empty() || !rising {
        let cause = "there are no events, or their times do not rise".into();
        return Err(PeersError::Reference {
            problem,
            line: 1,
            cause,
        });
    }
    Ok(events)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::event::error;
    use crate::peers::problem::{System, problems};
    use stickslip::filippov::{Method, Options};

    /// Every problem's error is below its bound.
    fn assert_meets(options: &Options, allowed: [(&str, f64); 7]) {
        let problems = problems().unwrap();
        assert_eq!(problems.len(), allowed.len());
        for (problem, (name, tolerance)) in problems.iter().zip(allowed) {
            assert_eq!(problem.name, name);
            let mut events = Vec::new();
            problem.solve(options, &mut events).unwrap();
            let error = error(&events, &reference(problem).unwrap()).unwrap();
            assert!(error < tolerance, "{name}: {error:e}");
        }
    }

    #[test]
    fn slopes_meet_every_reference() {
        // What 1e-12 gives, with room for a factor of 3: the first problem amplifies errors of its start a thousandfold, the
        // third leaves Σ at a tangent, where time is the root of what is known.
        let allowed = [
            ("belt_sensitive", 2e-9),
            ("belt_periodic", 1e-10),
            ("belt_grazing", 1e-10),
            ("decay", 1e-10),
            ("forced", 1e-10),
            ("moving", 1e-13),
            ("bracket", 1e-9),
        ];
        assert_meets(&Options::tol(1e-12), allowed);
    }

    #[test]
    fn series_meet_every_reference_to_the_last_digits() {
        // The forced problem's last times are 600, where a unit in the last place is 1.1e-13.
        let allowed = [
            ("belt_sensitive", 5e-13),
            ("belt_periodic", 1e-14),
            ("belt_grazing", 1e-14),
            ("decay", 1e-14),
            ("forced", 3e-14),
            ("moving", 1e-14),
            ("bracket", 1e-14),
        ];
        assert_meets(&Options::tol(1e-15).method(Method::Taylor), allowed);
    }

    /// Fields of a model by their names.
    macro_rules! fields {
        ($model:ident: $($field:ident),*) => {
            vec![$((stringify!($field), $model.$field)),*]
        };
    }

    /// The numbers that the other programs read are those of our models, to the last bit.
    #[test]
    fn the_problems_for_others_are_ours() {
        let text = include_str!("../../data/references/problems.json");
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        let problems = problems().unwrap();
        assert_eq!(json.as_object().unwrap().len(), problems.len());
        for problem in problems {
            let theirs = &json[problem.name];
            let number = |name: &str| theirs["parameters"][name].as_f64().unwrap();
            assert_eq!(theirs["t_start"].as_f64().unwrap(), problem.t_start);
            assert_eq!(theirs["t_end"].as_f64().unwrap(), problem.t_end);
            let (start, ours): (Vec<f64>, Vec<(&str, f64)>) = match problem.system {
                System::Belt(m, start) => (
                    start.into(),
                    fields!(m: mass, k1, k2, mu0, delta, belt_speed),
                ),
                System::Forced(m, start) => (
                    start.into(),
                    fields!(m: mass, k1, k2, mu0, delta, belt_speed, amplitude, omega),
                ),
                System::Moving(m, start) => (start.into(), fields!(m: speed)),
                System::Bracket(m, start) => (
                    start.into(),
                    fields!(
                        m: coupling, coupling_damping, mobility, bracket_stiffness, bracket_damping, mu0,
                        unloading, unloading_rate, delta, belt_speed
                    ),
                ),
            };
            for (i, value) in start.iter().enumerate() {
                assert_eq!(
                    theirs["start"][i].as_f64().unwrap(),
                    *value,
                    "{}",
                    problem.name
                );
            }
            for (name, value) in &ours {
                assert_eq!(number(name), *value, "{} {name}", problem.name);
            }
            assert_eq!(theirs["parameters"].as_object().unwrap().len(), ours.len());
        }
    }

    #[test]
    fn a_damaged_file_is_refused_with_its_line() {
        let head = "problem,event,kind,t,x1\n";
        for (rest, line) in [
            ("p,1,entry,1.0,0\np,3,exit,2.0,0\n", "line 3"),
            ("p,1,entry,one,0\n", "line 2"),
            ("p,1,stick,1.0,0\n", "line 2"),
            ("p,1\n", "line 2"),
            ("p,1,entry,2.0,0\np,2,exit,1.0,0\n", "line 1"),
            ("", "line 1"),
        ] {
            let error = parse("p", &format!("{head}{rest}"))
                .unwrap_err()
                .to_string();
            assert!(
                error.contains(line) && error.contains("generate.py"),
                "{error}"
            );
        }
    }
}
