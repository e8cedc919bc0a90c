//! The two steps of the listing: Runge–Kutta in time (lines 103–114) and Hénon's in velocity
//! (116–127).
//!
//! As printed, `xn = x` copies no state: every stage moves the state that the next one adds to, and
//! so does the closing sum. As intended, each adds to the step's start.

use stickslip::State;

/// The component that Σ fixes: the velocity.
pub(super) const VELOCITY: usize = 1;

/// A step of `h` in time. In place, the state moves by h/2 + h/2 + h + h.
pub(super) fn in_time<const N: usize>(
    in_place: bool,
    h: f64,
    (t, start): (f64, State<N>),
    field: impl Fn(f64, &State<N>) -> State<N>,
) -> State<N> {
    let half = h / 2.0;
    let from = |x: State<N>| if in_place { x } else { start };
    let k1 = field(t, &start);
    let x = start + k1 * half;
    let k2 = field(t + half, &x);
    let x = from(x) + k2 * half;
    let k3 = field(t + half, &x);
    let x = from(x) + k3 * h;
    let k4 = field(t + h, &x);
    from(x) + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0)
}

/// A step of `h` in velocity with `sixth` for h/6. Returns the time and state after it. `slope` is
/// `dt/dv` and `dx/dv`. In place, the second stage does not move the velocity, and the clock moves
/// only at the end.
pub(super) fn in_velocity<const N: usize>(
    in_place: bool,
    (h, sixth): (f64, f64),
    (t, start): (f64, State<N>),
    slope: impl Fn(f64, &State<N>) -> (f64, State<N>),
) -> (f64, State<N>) {
    let half = h * 0.5;
    let moved = |x: &State<N>, by: f64, k: &State<N>, velocity: f64| {
        let from = if in_place { x } else { &start };
        let mut next = from + k * by;
        next[VELOCITY] = from[VELOCITY] + velocity;
        next
    };
    let unless_in_place = |velocity| if in_place { 0.0 } else { velocity };
    let (t1, k1) = slope(t, &start);
    let x = moved(&start, half, &k1, half);
    let (t2, k2) = slope(t + half * t1, &x);
    let x = moved(&x, half, &k2, unless_in_place(half));
    let (t3, k3) = slope(t + half * t2, &x);
    let x = moved(&x, h, &k3, h);
    let (t4, k4) = slope(t + h * t3, &x);
    let sum = k1 + (k2 + k3) * 2.0 + k4;
    let end = moved(&x, sixth, &sum, unless_in_place(h));
    (t + sixth * (t1 + 2.0 * (t2 + t3) + t4), end)
}
