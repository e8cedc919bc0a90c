//! Time of runs with events, on one thread: an oscillator with 16 reported events over the same
//! with none, and the time per event of an impact oscillator and of a buck converter. With the
//! arguments CASE and METHOD, one run of that case, for a profiler.

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use stickslip::dynamics::{OrbitProgress, OrbitUnderWay};
use stickslip::{Direction, Method, Options};
use stickslip_model::file::{Source, System, SystemFile};
use stickslip_model::kernel::follow;

/// Runs of each kind for a median.
const TURNS: usize = 11;

const OSCILLATOR: &str = "
    name = 'Oscillator'
    [states]
    x = 'm'
    v = 'm/s'
    [field]
    x = 'v'
    v = '-x'
";

const IMPACT: &str = "
    name = 'Impact oscillator'
    [states]
    x = 'm'
    v = 'm/s'
    [jumps.impact]
    when = 'x - 1'
    direction = 'rising'
    set = { v = '-0.7*v' }
    [field]
    x = 'v'
    v = 'cos(0.8*t) - 0.1*v - x'
";

const BUCK: &str = "
    name = 'Buck converter'
    [states]
    v = 'V'
    i = 'A'
    [contacts.comparator]
    boundary = '8.4*(v - 11.3) - 3.8 - 4.4*ramp'
    [inputs.ramp]
    shape = 'sawtooth'
    period = 0.4
    [field]
    v = '(i - v/22)/0.047'
    i = '(12*(1 - comparator) - v)/20'
";

/// A system, its start and the length of a run.
struct Case {
    system: System,
    x: [f64; 2],
    span: f64,
}

impl Case {
    fn new(text: &str, sections: &[String], x: [f64; 2], span: f64) -> Self {
        let (name, text) = ("bench".to_owned(), text.to_owned());
        let file = SystemFile::parse(Source { name, text });
        let file = file.unwrap_or_else(|error| panic!("{error}"));
        let system = file.with(&[]).unwrap_or_else(|error| panic!("{error}"));
        let both: Vec<_> = sections
            .iter()
            .map(|text| (text.as_str(), Direction::Both))
            .collect();
        let system = system.with_sections(&both);
        let system = system.unwrap_or_else(|error| panic!("{error}"));
        Case { system, x, span }
    }

    /// An oscillator with events `function - c` at 16 levels, or none.
    fn oscillator(function: Option<&str>) -> Self {
        let level = |i: i32| f64::from(i) / 10.0 - 0.75;
        let sections = |of: &str| (0..16).map(|i| format!("{of} - ({})", level(i))).collect();
        let sections: Vec<String> = function.map(sections).unwrap_or_default();
        Case::new(OSCILLATOR, &sections, [1.0, 0.0], 1000.0)
    }

    fn named(name: &str) -> Self {
        match name {
            "none" => Case::oscillator(None),
            "levels" => Case::oscillator(Some("x")),
            "products" => Case::oscillator(Some("2*x*v")),
            "sines" => Case::oscillator(Some("sin(2*x)")),
            "beyond" => Case::oscillator(Some("x + 3")),
            "far" => Case::oscillator(Some("x*v + 3")),
            "impact" => Case::new(IMPACT, &[], [0.0, 0.0], 2000.0),
            "buck" => Case::new(BUCK, &[], [12.0, 0.55], 400.0),
            name => panic!("no case {name}"),
        }
    }

    /// Runs it. Returns the number of events, and the sum of their times.
    fn run(&self, options: &Options) -> (u32, f64) {
        let (mut count, mut sum) = (0, 0.0);
        let watcher = &mut |progress: OrbitProgress, _: &mut dyn OrbitUnderWay| {
            let time = match progress {
                OrbitProgress::Passage(at) => at.t,
                OrbitProgress::Transition(at) => at.t,
                _ => return ControlFlow::Continue(()),
            };
            (count, sum) = (count + 1, sum + time);
            ControlFlow::Continue(())
        };
        let (system, start) = (&self.system, (0.0, &self.x[..]));
        let sections = match system.file.sections.is_empty() {
            true => Vec::new(),
            false => system.sections(),
        };
        let ended = follow(
            system.dynamics(),
            start,
            self.span,
            options,
            &sections,
            watcher,
        );
        ended.unwrap_or_else(|error| panic!("{error}"));
        (count, sum)
    }
}

/// Seconds of one run, from as many as fill some milliseconds.
fn timed(mut run: impl FnMut() -> (u32, f64)) -> f64 {
    let begin = Instant::now();
    let mut count = 0;
    while begin.elapsed() < Duration::from_millis(20) {
        black_box(run());
        count += 1;
    }
    begin.elapsed().as_secs_f64() / f64::from(count)
}

fn middle(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() {
    let methods = [("taylor", Method::Taylor), ("dop853", Method::Dop853)];
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|arg| arg != "--bench")
        .collect();
    if let [case, name] = &given[..] {
        let method = methods.iter().find(|(known, _)| known == name);
        let (_, method) = method.unwrap_or_else(|| panic!("no method {name}"));
        let options = Options::tol(1e-12).method(*method);
        println!("{:?}", Case::named(case).run(&options));
        return;
    }
    for (name, method) in methods {
        let options = Options::tol(1e-12).method(method);
        let cases = ["levels", "products", "sines", "beyond", "far"];
        let cases = cases.map(|case| (case, Case::named(case)));
        let none = Case::named("none");
        let mut times = vec![Vec::new(); cases.len() + 1];
        for _ in 0..TURNS {
            times[0].push(timed(|| none.run(&options)));
            for ((_, case), times) in cases.iter().zip(&mut times[1..]) {
                times.push(timed(|| case.run(&options)));
            }
        }
        let times: Vec<f64> = times.into_iter().map(middle).collect();
        println!("{name}: oscillator {:.1} us", 1e6 * times[0]);
        for ((case, _), time) in cases.iter().zip(&times[1..]) {
            println!("{name}: 16 events {case} over none {:.2}", time / times[0]);
        }
        for case in ["impact", "buck"] {
            let run = Case::named(case);
            let times = (0..TURNS).map(|_| timed(|| run.run(&options))).collect();
            let (events, _) = run.run(&options);
            let each = 1e6 * middle(times) / f64::from(events);
            println!("{name}: {case} {each:.2} us an event, of {events}");
        }
    }
}
