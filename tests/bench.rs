//! The compiled solver on the benchmark problems: event times against references of thirty digits,
//! and the committed figure of all solvers.

use replication::paper::models::{
    BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Interpretation,
};
use stickslip::{Method, Options};

#[path = "../examples/bench/figure.rs"]
mod figure;
#[path = "../examples/bench/problems.rs"]
mod problems;

use problems::{Event, Problem, System};

/// The times have 30 decimals. They are rounded to doubles, so that errors below half a unit in the
/// last place are not seen.
fn reference(name: &str) -> Vec<(String, f64)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data/references");
    let mut reader = csv::Reader::from_path(format!("{folder}/{name}.csv")).unwrap();
    let records = reader.records().map(Result::unwrap);
    records
        .map(|record| (record[2].to_owned(), record[3].parse().unwrap()))
        .collect()
}

/// Computes the events, which are of the reference's kinds, and returns the errors of their times
/// with the times themselves.
fn errors(name: &str, problem: &Problem, options: &Options) -> Vec<(f64, f64)> {
    let mut events: Vec<Event> = Vec::new();
    problem.solve(options, &mut events).unwrap();
    let wanted = reference(name);
    let kinds = |events: &[(&str, f64)]| -> Vec<String> {
        events.iter().map(|one| one.0.to_owned()).collect()
    };
    let wanted: Vec<(&str, f64)> = wanted.iter().map(|(kind, t)| (&**kind, *t)).collect();
    assert_eq!(kinds(&events), kinds(&wanted), "{name}");
    let pairs = events.iter().zip(&wanted);
    pairs
        .map(|(one, other)| ((one.1 - other.1).abs(), other.1))
        .collect()
}

fn assert_measured(name: &str, found: f64, measured: f64, factor: f64) {
    assert!(found <= factor * measured, "{name}: {found:e}");
    // Otherwise the measured number is outdated, and a multiple of it is not a bound.
    assert!(found >= measured / factor, "{name}: only {found:e}");
}

#[test]
fn slopes_meet_every_reference() {
    // Errors measured at a tolerance of 1e-12. The first problem amplifies errors of its start a
    // thousandfold. With the moving boundary the solution is linear between events, so that one
    // rounding error of a time remains.
    for (name, measured) in [
        ("belt_sensitive", 6.9e-10),
        ("belt_periodic", 1.3e-12),
        ("belt_grazing", 7.7e-13),
        ("decay", 2.9e-13),
        ("forced", 1.6e-12),
        ("moving", 3.6e-15),
        ("bracket", 1.1e-11),
    ] {
        let problem = Problem::named(name).unwrap();
        let errors = errors(name, &problem, &Options::tol(1e-12).method(Method::Dop853));
        let found = errors.iter().map(|one| one.0).fold(0.0, f64::max);
        assert_measured(name, found, measured, 3.0);
    }
}

#[test]
fn series_meet_every_reference_to_the_last_digits() {
    // In units in the last place of each event's own time. One unit means that only the rounding
    // errors of the reference and of ours remain. The first event of `decay`, at 0.24, is a sum of
    // terms with a larger unit than its own. The first problem amplifies rounding errors at random.
    // For starts one unit apart the errors are 1, 19 and 96 with one order of additions, and 49, 69
    // and 101 with another. So the maximum over all these starts is tested.
    for (name, measured) in [
        ("belt_sensitive", 101.0),
        ("belt_periodic", 1.0),
        ("belt_grazing", 1.0),
        ("decay", 2.0),
        ("forced", 1.0),
        ("moving", 1.0),
        ("bracket", 1.0),
    ] {
        let options = Options::tol(1e-15).method(Method::Taylor);
        let worst = neighbouring_starts(Problem::named(name).unwrap())
            .iter()
            .flat_map(|problem| errors(name, problem, &options))
            .map(|(error, t)| error / (t.next_up() - t))
            .fold(0.0, f64::max);
        assert_measured(name, worst, measured, 2.0);
    }
}

/// The problem and, for model 1, the problems whose starts are one unit in the last place away.
fn neighbouring_starts(problem: Problem) -> Vec<Problem> {
    let [x, v] = problem.start[..] else {
        return vec![problem];
    };
    if !matches!(problem.system, System::Belt(_)) {
        return vec![problem];
    }
    let starts = [
        [x, v],
        [x.next_up(), v],
        [x.next_down(), v],
        [x, v.next_up()],
        [x, v.next_down()],
    ];
    let from = |start: [f64; 2]| Problem {
        start: start.into(),
        ..problem.clone()
    };
    starts.into_iter().map(from).collect()
}

#[test]
fn the_parameters_are_those_of_the_paper() {
    let system = |name: &str| Problem::named(name).unwrap().system;
    let forced = ForcedOscillator::default();
    assert_eq!(system("forced"), System::Forced(forced));
    assert_eq!(
        Problem::named("forced").unwrap().t_end,
        100.0 * forced.period()
    );
    let bracket = BlockAndBracket::from_caption(&Caption::FIG11, &Interpretation::exact()).unwrap();
    assert_eq!(system("bracket"), System::Bracket(bracket));
    let belt = BeltOscillator {
        belt_speed: 0.4,
        ..BeltOscillator::default()
    };
    for name in ["belt_sensitive", "belt_periodic", "belt_grazing"] {
        assert_eq!(system(name), System::Belt(belt));
    }
    let unknown = Problem::named("drift").unwrap_err();
    assert!(unknown.contains("'drift'") && unknown.contains("belt_grazing"));
}

#[test]
fn the_committed_figure_is_that_of_the_committed_table() {
    let drawn = figure::draw(include_str!("../report/bench.csv")).unwrap();
    // assert_eq would print both pictures.
    let committed = include_str!("../figures/bench.svg");
    assert!(drawn == committed, "run `make bench-pages`");
    for (table, cause) in [
        ("solver,problem\n", "no column error"),
        (
            "solver,problem,error,median_s,process_s\none,drift,,,\n",
            "'drift'",
        ),
        (
            "solver,problem,error,median_s,process_s\none,decay,x,,\n",
            "'x'",
        ),
    ] {
        let error = figure::draw(table).unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
}
