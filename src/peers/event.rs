//! Lists of events and the differences between them.

use std::str::FromStr;

use crate::numbers::largest;
use crate::text::described;

described! {
    /// Kind of an event.
    EventKind: &'static str as name {
        /// From slip to slip through Σ.
        Crossing = "crossing",
        /// Stick begins.
        Entry = "entry",
        /// Stick ends.
        Exit = "exit",
    }
}

impl FromStr for EventKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut all = EventKind::ALL.into_iter();
        all.find(|kind| kind.name() == text).ok_or_else(|| {
            format!("'{text}' is no kind of event; there are crossing, entry and exit")
        })
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Kind.
    pub kind: EventKind,
    /// Time.
    pub t: f64,
}

impl FromStr for Event {
    type Err = String;

    /// Format: `crossing@0.953`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, t) = text
            .split_once('@')
            .ok_or_else(|| format!("'{text}' is no event such as crossing@0.953"))?;
        let t: f64 = t.parse().map_err(|_| format!("'{t}' is no time"))?;
        Ok(Event {
            kind: kind.parse()?,
            t,
        })
    }
}

/// Largest error of an event time, or the reason why the lists do not have the same events.
///
/// # Errors
/// A description for the column `note`.
pub fn event_time_error(events: &[Event], reference: &[Event]) -> Result<f64, String> {
    let (found, wanted) = (events.len(), reference.len());
    if found != wanted {
        return Err(format!(
            "failed: {found} events, the reference has {wanted}"
        ));
    }
    let pairs = events.iter().zip(reference);
    if pairs.clone().any(|(one, other)| one.kind != other.kind) {
        return Err("failed: other kinds of events than the reference has".into());
    }
    if pairs.clone().any(|(one, _)| !one.t.is_finite()) {
        return Err("failed: an event time is not a number".into());
    }
    Ok(largest(pairs.map(|(one, other)| (one.t - other.t).abs())))
}

/// Reads the file of a problem: `problem,event,kind,t,…`. It has times to 30 decimals. They are
/// rounded to doubles, so that errors below half a unit in the last place are not seen.
pub(super) fn parse(problem: &str, text: &str) -> Result<Vec<Event>, String> {
    let wrong = |line: usize, cause: String| {
        let remedy = format!("run data/references/generate.py {problem}");
        format!("reference of {problem}, line {line}: {cause}; {remedy}")
    };
    let mut events: Vec<Event> = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        let wrong = |cause: String| wrong(index + 1, cause);
        let cells: Vec<&str> = line.split(',').collect();
        let [name, number, kind, t, ..] = cells[..] else {
            return Err(wrong(format!("'{line}' has fewer than four cells")));
        };
        if name != problem || number != index.to_string() {
            let cause = format!("'{name},{number}' where {problem},{index} is due");
            return Err(wrong(cause));
        }
        events.push(format!("{kind}@{t}").parse().map_err(wrong)?);
    }
    if events.is_empty() || !events.is_sorted_by(|one, other| one.t < other.t) {
        let cause = "there are no events, or their times do not rise";
        return Err(wrong(1, cause.into()));
    }
    Ok(events)
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::peers::problem::{Problem, SOLVERS, System, problems};
    use stickslip::filippov::{Method, Options};

    #[test]
    fn every_solver_meets_every_reference() {
        for problem in problems().unwrap() {
            let reference = problem.reference().unwrap();
            for solver in SOLVERS {
                let mut events = Vec::new();
                let ready = solver.ready(&problem).unwrap();
                ready.solve(&solver.options(1e-12), &mut events).unwrap();
                let (solver, problem) = (solver.name, problem.name);
                let error = event_time_error(&events, &reference).unwrap();
                assert!(error < 1e-8, "{solver} on {problem}: {error:e}");
            }
        }
    }

    /// Our events and the reference's, for every problem.
    fn solved(options: &Options) -> Vec<(Problem, Vec<Event>, Vec<Event>)> {
        let problems = problems().unwrap();
        let solve = |problem: Problem| {
            let mut events = Vec::new();
            problem.solve(options, &mut events).unwrap();
            let reference = problem.reference().unwrap();
            (problem, events, reference)
        };
        problems.into_iter().map(solve).collect()
    }

    #[test]
    fn slopes_meet_every_reference() {
        // Errors measured at a tolerance of 1e-12. The first problem amplifies errors of its start
        // a thousandfold. With the moving boundary the solution is linear between events, so that
        // one rounding error of a time remains.
        let measured = [
            ("belt_sensitive", 6.9e-10),
            ("belt_periodic", 1.3e-12),
            ("belt_grazing", 7.7e-13),
            ("decay", 2.9e-13),
            ("forced", 1.6e-12),
            ("moving", 3.6e-15),
            ("bracket", 1.1e-11),
        ];
        let solved = solved(&Options::tol(1e-12));
        assert_eq!(solved.len(), measured.len());
        for ((problem, events, reference), (name, measured)) in solved.iter().zip(measured) {
            assert_eq!(problem.name, name);
            let found = event_time_error(events, reference).unwrap();
            assert!(found < 3.0 * measured, "{name}: {found:e}");
            // Otherwise the number above is outdated, and three times it is not a bound.
            assert!(found > measured / 3.0, "{name}: only {found:e}");
        }
    }

    #[test]
    fn series_meet_every_reference_to_the_last_digits() {
        // In units in the last place of each event's own time. One unit means that only the
        // rounding errors of the reference and of ours remain. The first event of `decay`, at 0.24,
        // is a sum of terms with a larger unit than its own. The first problem amplifies rounding
        // errors at random. For starts one unit apart the errors are 1, 19 and 96 with one order of
        // additions, and 49, 69 and 101 with another. So the maximum over all these starts is
        // tested.
        let measured = [
            ("belt_sensitive", 101.0),
            ("belt_periodic", 1.0),
            ("belt_grazing", 1.0),
            ("decay", 2.0),
            ("forced", 1.0),
            ("moving", 1.0),
            ("bracket", 1.0),
        ];
        let options = Options::tol(1e-15).method(Method::Taylor);
        let problems = problems().unwrap();
        assert_eq!(problems.len(), measured.len());
        for (problem, (name, measured)) in problems.into_iter().zip(measured) {
            assert_eq!(problem.name, name);
            let reference = problem.reference().unwrap();
            let worst = neighbouring_starts(&problem).into_iter().map(|problem| {
                let mut events = Vec::new();
                problem.solve(&options, &mut events).unwrap();
                // The events are the same.
                event_time_error(&events, &reference).unwrap();
                let units = events.iter().zip(&reference).map(|(one, other)| {
                    let unit = other.t.next_up() - other.t;
                    (one.t - other.t).abs() / unit
                });
                units.fold(0.0, f64::max)
            });
            let worst = worst.fold(0.0, f64::max);
            assert!(worst <= 2.0 * measured, "{name}: {worst} units");
            assert!(worst >= 0.5 * measured, "{name}: only {worst} units");
        }
    }

    /// The problem and, for model 1, the problems whose starts are one unit in the last place away.
    fn neighbouring_starts(problem: &Problem) -> Vec<Problem> {
        let System::Belt(system, [x, v]) = problem.system else {
            return vec![*problem];
        };
        let starts = [
            [x, v],
            [x.next_up(), v],
            [x.next_down(), v],
            [x, v.next_up()],
            [x, v.next_down()],
        ];
        let from = |start| Problem {
            system: System::Belt(system, start),
            ..*problem
        };
        starts.into_iter().map(from).collect()
    }

    /// Fields of a model by name.
    macro_rules! fields {
        ($model:ident: $($field:ident),*) => {
            vec![$((stringify!($field), $model.$field)),*]
        };
    }

    /// The numbers that the other programs read equal those of our models to the last bit.
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
                        m: coupling, coupling_damping, mobility, bracket_stiffness, bracket_damping,
                        mu0, unloading, unloading_rate, delta, belt_speed
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
            let error = parse("p", &format!("{head}{rest}")).unwrap_err();
            assert!(
                error.contains(line) && error.contains("generate.py"),
                "{error}"
            );
        }
    }

    fn list(text: &str) -> Vec<Event> {
        text.split(';')
            .map(|event| event.parse().unwrap())
            .collect()
    }

    #[test]
    fn the_error_is_that_of_the_worst_event() {
        let reference = list("entry@1;exit@2;crossing@3");
        assert_eq!(
            event_time_error(&list("entry@1;exit@2.5;crossing@2.75"), &reference),
            Ok(0.5)
        );
        assert_eq!(event_time_error(&reference, &reference), Ok(0.0));
    }

    #[test]
    fn lists_of_other_events_have_no_error() {
        let reference = list("entry@1;exit@2");
        let said = |text: &str| event_time_error(&list(text), &reference).unwrap_err();
        assert_eq!(said("entry@1"), "failed: 1 events, the reference has 2");
        assert!(said("entry@1;crossing@2").contains("kinds"));
        assert!(said("entry@1;exit@nan").contains("not a number"));
        assert!(said("entry@nan;exit@2").contains("not a number"));
    }

    #[test]
    fn what_is_no_event_is_refused() {
        for text in ["entry", "entry@", "entry@x", "stick@1", ""] {
            assert!(text.parse::<Event>().is_err(), "{text}");
        }
    }
}
