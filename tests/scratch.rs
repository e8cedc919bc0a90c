use stickslip::*;
use stickslip::models::BeltOscillator;
use std::f64::consts::PI;

struct P1;
impl Filippov<2> for P1 {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        State::from([x[1], -x[0] - 0.4 * side.sign()])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T { x[1] }
}
struct P2;
impl Filippov<2> for P2 {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        let f = match side { Side::Below => T::constant(1.0) / (-x[1] + 1.2), Side::Above => -(T::constant(1.0) / (x[1] + 0.8)) };
        State::from([x[1], f - x[0]])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T { x[1] - 0.2 }
}
struct P3;
impl Filippov<2> for P3 {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        let w = 2.0 * PI * side.sign();
        State::from([x[0] + x[1] * w, x[1] - x[0] * w])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T { x[0] * x[0] + x[1] * x[1] - 1.0 }
}
struct P4;
impl Filippov<1> for P4 {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &State<T, 1>) -> State<T, 1> {
        State::from([T::constant(if side == Side::Below { 3.0 } else { -1.0 })])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 1>) -> T { x[0] }
}
struct P5 { mu: f64, vp: f64 }
impl Filippov<2> for P5 {
    fn field<T: Scalar>(&self, side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        State::from([x[1], -x[0] - self.mu * side.sign()])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T { x[1] - self.vp }
}
struct P6 { a: f64 }
impl Filippov<1> for P6 {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &State<T, 1>) -> State<T, 1> {
        State::from([T::constant(-side.sign() * self.a)])
    }
    fn boundary<T: Scalar>(&self, t: T, x: &State<T, 1>) -> T { x[0] - t.sin() }
}
struct P7 { c: f64 }
impl Filippov<2> for P7 {
    fn field<T: Scalar>(&self, _side: Side, _t: T, x: &State<T, 2>) -> State<T, 2> {
        State::from([T::constant(1.0), x[0] * 2.0])
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &State<T, 2>) -> T { x[1] - self.c }
}
fn show<const N: usize>(o: &Orbit<N>) {
    for t in &o.transitions { println!("  {:?} t={:.16} x={:?} res={:.2e}", t.kind, t.t, t.x.as_slice(), t.residual); }
    println!("  {:?} {:?} end {:?}", o.ending, o.counters, o.x_end.as_slice());
}
#[test]
fn scratch() {
    let o = Options::tol(1e-13);
    for loc in [Locator::Auto, Locator::Henon, Locator::RootSearch] {
        let o = o.locator(loc);
        println!("P1 {loc:?}"); show(&solve(&P1, 0.0, State::from([3.0, 0.0]), 20.0, &o).unwrap());
        println!("P2"); show(&solve(&P2, 0.0, State::from([0.04, -0.01]), 40.0, &o).unwrap());
        println!("P3"); show(&solve(&P3, 0.0, State::from([(-1f64).exp(), 0.0]), 1.5, &o).unwrap());
        println!("P4"); show(&solve(&P4, 0.0, State::from([-1.0]), 1.5, &o).unwrap());
    }
    println!("P5"); show(&solve(&P5 { mu: 0.7, vp: 0.3 }, 0.0, State::from([0.5, -1.5]), 60.0, &o).unwrap());
    println!("P6"); show(&solve(&P6 { a: 0.6 }, PI / 2.0, State::from([1.0]), 20.0, &o).unwrap());
    println!("   t1 {}", PI - 0.6f64.acos());
    for gap in [1e-4, 1e-8, 1e-10, 0.0, -1e-10] {
        println!("P7 gap {gap}"); show(&solve(&P7 { c: gap }, 0.0, State::from([-1.0, 1.0]), 2.0, &o).unwrap());
    }
    println!("model1"); show(&solve(&BeltOscillator { belt_speed: 0.4, ..Default::default() }, 0.0, State::from([0.5, 1.5]), 30.0, &Options::tol(1e-12)).unwrap());
    println!("fig4");
    show(&solve(&BeltOscillator::default(), 0.0, State::from([0.2, 1.0]), 60.0, &Options::tol(1e-12)).unwrap());
}
