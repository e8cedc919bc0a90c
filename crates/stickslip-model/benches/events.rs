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

/// The problem of `benches/problems/impact.py`.
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

/// The problem of `benches/problems/buck.py`.
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
        let file = SystemFile::parse(Source { name, text }).expect("is a system");
        let system = file.with(&[]).expect("has all values");
        let both = |text| (String::as_str(text), Direction::Both);
        let sections: Vec<_> = sections.iter().map(both).collect();
        let system = system.with_sections(&sections).expect("are formulas");
        Case { system, x, span }
    }

    /// An oscillator with 16 events at levels of a function.
    fn oscillator(function: &str) -> Self {
        let level = |i: i32| f64::from(i) / 10.0 - 0.75;
        let section = |i: i32| format!("{function} - ({})", level(i));
        let sections: Vec<String> = (0..16).map(section).collect();
        Case::new(OSCILLATOR, &sections, [1.0, 0.0], 1000.0)
    }

    fn named(name: &str) -> Self {
        match name {
            "none" => Case::new(OSCILLATOR, &[], [1.0, 0.0], 1000.0),
            "levels" => Case::oscillator("x"),
            "beyond" => Case::oscillator("x + 3"),
            "products" => Case::oscillator("2*x*v"),
            "far products" => Case::oscillator("2*x*v + 3"),
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
        let dynamics = system.dynamics();
        let ended = follow(dynamics, start, self.span, options, &sections, watcher);
        ended.expect("runs");
        (count, sum)
    }
}

/// Seconds of one run, from as many as fill some milliseconds.
fn timed(case: &Case, options: &Options) -> f64 {
    let begin = Instant::now();
    let mut count = 0;
    while begin.elapsed() < Duration::from_millis(20) {
        black_box(case.run(options));
        count += 1;
    }
    begin.elapsed().as_secs_f64() / f64::from(count)
}

fn main() {
    let methods = [("taylor", Method::Taylor), ("dop853", Method::Dop853)];
    let options = |method| Options::tol(1e-12).method(method);
    let given = std::env::args().skip(1).filter(|arg| arg != "--bench");
    if let [case, name] = &given.collect::<Vec<_>>()[..] {
        let method = methods.iter().find(|(known, _)| known == name);
        let (_, method) = method.unwrap_or_else(|| panic!("no method {name}"));
        println!("{:?}", Case::named(case).run(&options(*method)));
        return;
    }
    for (name, method) in methods {
        let events = ["levels", "beyond", "products", "far products"];
        let names = [
            "none", events[0], events[1], events[2], events[3], "impact", "buck",
        ];
        let cases = names.map(Case::named);
        let options = options(method);
        let mut rounds = names.map(|_| Vec::new());
        for _ in 0..TURNS {
            for (case, times) in cases.iter().zip(&mut rounds) {
                times.push(timed(case, &options));
            }
        }
        let times = rounds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[TURNS / 2]
        });
        println!("{name}: oscillator {:.1} us", 1e6 * times[0]);
        for number in 1..5 {
            let ratio = times[number] / times[0];
            println!("{name}: 16 events {} over none {ratio:.2}", names[number]);
        }
        for number in 5..7 {
            let (events, _) = cases[number].run(&options);
            let each = 1e6 * times[number] / f64::from(events);
            println!("{name}: {} {each:.2} us an event", names[number]);
        }
    }
}
