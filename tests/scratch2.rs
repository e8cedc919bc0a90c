use stickslip::*;
use stickslip::models::*;
use stickslip::analysis::*;
fn main_like() {
    let belt = BeltOscillator::default();
    let o = Options::tol(1e-13);
    let c = periodic_orbit(&belt, State::from([1.2, 0.0]), 7.7, &o).unwrap();
    println!("{c:?} {:?}", planar_multipliers(&c.monodromy));
    let f = ForcedOscillator::default();
    let orb = solve(&f, 0.0, State::from([-0.2, 0.4]), 60.0, &o).unwrap();
    for t in orb.transitions.iter().rev().take(8) { println!("{:?} {} {:?}", t.kind, t.t, t.x.as_slice()); }
    for p in orb.phases.iter().rev().take(5) { println!("{:?} {}", p.mode, p.duration()); }
    println!("period {} {:?}", f.period(), orb.counters);
    let n = 200; let s = std::time::Instant::now();
    let b = BeltOscillator { belt_speed: 0.4, ..Default::default() };
    let o = Options::tol(1e-12);
    let mut calls = 0;
    for _ in 0..n { calls = run(&b, 0.0, State::from([0.5, 1.5]), 30.0, &o, &mut ()).unwrap().counters.field_calls; }
    println!("model1: {:?} per run, {calls} calls", s.elapsed() / n);
    let s = std::time::Instant::now();
    let mut x = [0.5f64, 1.5];
    for _ in 0..n { for _ in 0..calls { let d = b.field(Side::Below, 0.0, &State::from(x)); x = [0.5 + d[0] * 1e-3, 0.2 + d[1] * 1e-3]; } }
    println!("floor {:?} {x:?}", s.elapsed() / n);
}
#[test] fn scratch2() { main_like() }
