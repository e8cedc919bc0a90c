//! The examples run.

#[path = "../../examples/ensemble.rs"]
mod ensemble;
#[path = "../../examples/oscillator.rs"]
mod oscillator;
#[path = "../../examples/spectrum.rs"]
mod spectrum;
#[path = "../../examples/sweep.rs"]
mod sweep;
#[path = "../../examples/three_states.rs"]
mod three_states;

#[test]
fn every_example_runs() {
    ensemble::main();
    for example in [
        oscillator::main,
        spectrum::main,
        sweep::main,
        three_states::main,
    ] {
        example().expect("runs");
    }
}
