//! Tapes compute what the expressions say, with few operations and registers.

use stickslip_model::expression::Binary::*;
use stickslip_model::expression::{Function, Graph, Id, Tape, TooLarge};

fn value<const OUTPUTS: usize>(tape: &Tape, t: f64, x: &[f64]) -> [f64; OUTPUTS] {
    let mut out = [f64::NAN; OUTPUTS];
    tape.evaluate(t, x, &mut out);
    out
}

#[test]
fn what_is_shared_is_made_once_and_what_is_constant_not_at_all() {
    let mut graph = Graph::new();
    let (x, v) = (graph.state(0), graph.state(1));
    let product = graph.binary(Product, x, v).unwrap();
    let again = graph.binary(Product, v, x).unwrap();
    assert_eq!(product, again);
    let two = graph.constant(2.0).unwrap();
    let three = graph.constant(3.0).unwrap();
    let six = graph.binary(Product, two, three).unwrap();
    let first = graph.binary(Sum, product, six).unwrap();
    let second = graph.binary(Quotient, six, again).unwrap();
    let tape = Tape::new(&graph, &[first, second, six, v], 2).unwrap();
    assert_eq!(tape.operations(), 3);
    assert_eq!(value(&tape, 0.0, &[2.0, 5.0]), [16.0, 0.6, 6.0, 5.0]);
}

#[test]
fn sine_and_cosine_are_made_together_in_either_order() {
    for (first, second) in [
        (Function::Sin, Function::Cos),
        (Function::Cos, Function::Sin),
    ] {
        let mut graph = Graph::new();
        let (t, x) = (graph.time(), graph.state(0));
        let angle = graph.binary(Product, t, x).unwrap();
        let one = graph.call(first, angle).unwrap();
        let between = graph.binary(Sum, one, x).unwrap();
        let other = graph.call(second, angle).unwrap();
        let both = graph.binary(Product, between, other).unwrap();
        let tape = Tape::new(&graph, &[both], 1).unwrap();
        assert_eq!(tape.operations(), 4);
        let (t, x) = (0.7, 1.3);
        let wanted = (first.of(t * x) + x) * second.of(t * x);
        assert_eq!(value(&tape, t, &[x]), [wanted]);
    }
}

#[test]
fn registers_are_used_again() {
    let mut graph = Graph::new();
    let x = graph.state(0);
    let mut sum = x;
    for k in 1..500 {
        let c = graph.constant(f64::from(k)).unwrap();
        let shifted = graph.binary(Sum, x, c).unwrap();
        let sine = graph.call(Function::Sin, shifted).unwrap();
        sum = graph.binary(Sum, sum, sine).unwrap();
    }
    let tape = Tape::new(&graph, &[sum], 1).unwrap();
    assert!(tape.registers() <= 5, "{}", tape.registers());
    let wanted = (1..500).fold(0.3, |sum, k| sum + Function::Sin.of(0.3 + f64::from(k)));
    assert_eq!(value(&tape, 0.0, &[0.3]), [wanted]);
}

#[test]
fn many_numbers_at_once_are_held_and_too_many_refused() {
    let chain = |count: usize| {
        let mut graph = Graph::new();
        let x = graph.state(0);
        let parts: Vec<Id> = (0..count)
            .map(|k| {
                let c = graph.constant(k as f64 + 0.5).unwrap();
                graph.binary(Product, x, c).unwrap()
            })
            .collect();
        let mut sum = x;
        for &part in parts.iter().rev() {
            sum = graph.binary(Sum, sum, part).unwrap();
        }
        Tape::new(&graph, &[sum], 1)
    };
    for count in [5, 30, 60] {
        let tape = chain(count).unwrap();
        let wanted = (0..count)
            .rev()
            .fold(2.0, |sum, k| sum + 2.0 * (k as f64 + 0.5));
        assert_eq!(value(&tape, 0.0, &[2.0]), [wanted]);
    }
    assert!(chain(100).is_ok());
    assert_eq!(chain(1200), Err(TooLarge));
}

#[test]
fn powers_choose_the_cheapest_way() {
    let mut graph = Graph::new();
    let x = graph.state(0);
    let mut power = |p: f64| {
        let p = graph.constant(p).unwrap();
        graph.binary(Power, x, p).unwrap()
    };
    let roots = [power(3.0), power(0.5), power(-1.0), power(1.5), power(0.0)];
    let tape = Tape::new(&graph, &roots, 1).unwrap();
    let x = 1.7f64;
    let wanted = [
        x * (x * x),
        x.sqrt(),
        1.0 / x,
        stickslip::math::pow(x, 1.5),
        1.0,
    ];
    assert_eq!(value(&tape, 0.0, &[x]), wanted);
}

#[test]
fn what_is_no_number_is_refused_where_it_is_made() {
    let mut graph = Graph::new();
    let (zero, x) = (graph.constant(0.0).unwrap(), graph.state(0));
    let minus = graph.constant(-2.0).unwrap();
    assert!(graph.binary(Quotient, zero, zero).is_err());
    assert!(graph.binary(Quotient, x, zero).is_err());
    assert!(graph.call(Function::Ln, zero).is_err());
    assert!(graph.call(Function::Sqrt, minus).is_err());
    assert!(graph.constant(f64::NAN).is_err());
    assert_eq!(graph.binary(Product, x, zero), Ok(zero));
}
