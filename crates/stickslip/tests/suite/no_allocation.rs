//! A run without recording allocates nothing, however long it is.

use std::ops::ControlFlow;

use stickslip::{Locator, Method, Observer, Options, State, StepRecord, Transition, run};

use crate::blocks::Block;
use crate::compiled::Compiled;

/// Counts and stores nothing.
#[derive(Default)]
struct Count {
    steps: u64,
    transitions: u64,
}

impl Observer<2> for Count {
    fn step(&mut self, _: &StepRecord<2>) -> ControlFlow<()> {
        self.steps += 1;
        ControlFlow::Continue(())
    }
    fn transition(&mut self, _: &Transition<2>) -> ControlFlow<()> {
        self.transitions += 1;
        ControlFlow::Continue(())
    }
}

fn allocations(system: &impl Compiled<2>, t_end: f64, options: &Options) -> (u64, Count) {
    let (system, mut count) = (system.any(), Count::default());
    let info = allocation_counter::measure(|| {
        let start = State::from([0.1, 0.2]);
        run(&system, 0.0, start, t_end, options, &mut count).expect("runs");
    });
    (info.count_total, count)
}

#[test]
fn no_allocation_in_a_run_of_any_length() {
    // The counter counts.
    assert_eq!(
        allocation_counter::measure(|| drop(std::hint::black_box(Box::new(1.0)))).count_total,
        1
    );
    let belt = Block {
        mu0: 0.5,
        ..Block::on_belt(0.2)
    };
    let fixed = Method::Rk4 { step: 0.01 };
    for locator in [Locator::Auto, Locator::Henon, Locator::RootSearch] {
        for options in
            [Options::default(), Options::default().method(fixed)].map(|o| o.locator(locator))
        {
            let (short, few) = allocations(&belt, 100.0, &options);
            let (long, many) = allocations(&belt, 1000.0, &options);
            assert_eq!((short, long), (0, 0));
            assert!(few.transitions >= 8 && many.transitions > 9 * few.transitions);
            assert!(many.steps > 9 * few.steps);
            assert_eq!(allocations(&Block::shaken(), 5.0, &options).0, 0);
        }
    }
}
