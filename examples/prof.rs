use stickslip::*;
use stickslip::models::*;
fn main() {
    let n = 20000;
    let b = std::hint::black_box(BeltOscillator { belt_speed: 0.4, ..Default::default() });
    let o = Options::tol(1e-12);
    let s = std::time::Instant::now();
    let mut calls = 0;
    for _ in 0..n { calls = run(&b, 0.0, State::from([0.5, 1.5]), 30.0, &o, &mut ()).unwrap().counters.field_calls; }
    let run_time = s.elapsed() / n;
    let s = std::time::Instant::now();
    let mut x = [0.5f64, 1.5];
    for _ in 0..n { for _ in 0..calls { let d = b.field(Side::Below, 0.0, &State::from(x)); x = [0.5 + d[0] * 1e-3, 0.2 + d[1] * 1e-3]; } }
    let fl = s.elapsed() / n;
    println!("run {:?} floor {:?} ratio {:.3} calls {calls} {x:?}", run_time, fl, run_time.as_secs_f64() / fl.as_secs_f64());
}
