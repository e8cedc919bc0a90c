//! Systems of known spectrum: series of their states, and their exponents from the equations.

use numerics::SplitMix;
use stickslip::Scalar;
use stickslip::math;
use stickslip::scalar::Dual;

/// Runge–Kutta steps between two points of a flow's series.
const SUBSTEPS: usize = 8;
/// Points discarded as a transient before a series begins.
const TRANSIENT: usize = 3000;

/// A system, as the map from one state of the series to the next.
trait System<const N: usize> {
    /// Time between two states; 1 for a map.
    const DT: f64;
    /// Centre of the box from which starts are drawn; its sides are 0.1.
    const START: [f64; N];

    /// The state after `DT`.
    fn next<T: Scalar>(x: [T; N]) -> [T; N];

    /// Columns of the series for a state.
    fn observe(x: &[f64; N]) -> Vec<f64> {
        x.to_vec()
    }
}

/// The map of a flow over `dt`, by the classical Runge–Kutta method.
fn flow<T: Scalar, const N: usize>(
    field: impl Fn(&[T; N]) -> [T; N],
    mut x: [T; N],
    dt: f64,
) -> [T; N] {
    let h = dt / SUBSTEPS as f64;
    let ahead = |x: &[T; N], k: &[T; N], h: f64| std::array::from_fn(|i| x[i] + k[i] * h);
    for _ in 0..SUBSTEPS {
        let k1 = field(&x);
        let k2 = field(&ahead(&x, &k1, 0.5 * h));
        let k3 = field(&ahead(&x, &k2, 0.5 * h));
        let k4 = field(&ahead(&x, &k3, h));
        x = std::array::from_fn(|i| x[i] + (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * (h / 6.0));
    }
    x
}

struct Henon;

impl System<2> for Henon {
    const DT: f64 = 1.0;
    const START: [f64; 2] = [0.1, 0.1];

    fn next<T: Scalar>([x, y]: [T; 2]) -> [T; 2] {
        [-x * x * 1.4 + y + 1.0, x * 0.3]
    }
}

/// Ikeda's map of a laser in a ring, at 0.9.
struct Ikeda;

impl System<2> for Ikeda {
    const DT: f64 = 1.0;
    const START: [f64; 2] = [0.5, -0.3];

    fn next<T: Scalar>([x, y]: [T; 2]) -> [T; 2] {
        let (sine, cosine) = (-(x * x + y * y + 1.0).recip() * 6.0 + 0.4).sin_cos();
        [
            (x * cosine - y * sine) * 0.9 + 1.0,
            (x * sine + y * cosine) * 0.9,
        ]
    }
}

/// Two logistic maps at 3.9 and 3.8, each coupled to the other with the weight 1/20.
struct Logistic;

impl System<2> for Logistic {
    const DT: f64 = 1.0;
    const START: [f64; 2] = [0.3, 0.6];

    fn next<T: Scalar>([x, y]: [T; 2]) -> [T; 2] {
        let (f, g) = ((-x + 1.0) * x * 3.9, (-y + 1.0) * y * 3.8);
        [f * 0.95 + g * 0.05, g * 0.95 + f * 0.05]
    }
}

fn lorenz<T: Scalar>([x, y, z]: &[T; 3], [sigma, r, b]: [f64; 3]) -> [T; 3] {
    let (x, y, z) = (*x, *y, *z);
    [(y - x) * sigma, x * (-z + r) - y, x * y - z * b]
}

/// The Lorenz system with its original parameters.
struct Lorenz;

impl System<3> for Lorenz {
    const DT: f64 = 0.02;
    const START: [f64; 3] = [1.0, 1.0, 20.0];

    fn next<T: Scalar>(x: [T; 3]) -> [T; 3] {
        flow(|x| lorenz(x, [10.0, 28.0, 8.0 / 3.0]), x, Self::DT)
    }
}

/// The Lorenz system with the parameters of Wolf et al. (1985).
struct LorenzWolf;

impl System<3> for LorenzWolf {
    const DT: f64 = 0.01;
    const START: [f64; 3] = [1.0, 1.0, 40.0];

    fn next<T: Scalar>(x: [T; 3]) -> [T; 3] {
        flow(|x| lorenz(x, [16.0, 45.92, 4.0]), x, Self::DT)
    }
}

struct Roessler;

impl System<3> for Roessler {
    const DT: f64 = 0.1;
    const START: [f64; 3] = [1.0, 1.0, 0.0];

    fn next<T: Scalar>(x: [T; 3]) -> [T; 3] {
        let field = |&[x, y, z]: &[T; 3]| [-y - z, x + y * 0.2, z * (x - 5.7) + 0.2];
        flow(field, x, Self::DT)
    }
}

/// A pendulum with damping 1/2, driven by 1.5 cos(2t/3) (Baker and Gollub): angle, velocity, phase.
/// The angle is written as sine and cosine, which do not jump.
struct Pendulum;

impl System<3> for Pendulum {
    const DT: f64 = 0.1;
    const START: [f64; 3] = [0.2, 0.1, 0.0];

    fn next<T: Scalar>(x: [T; 3]) -> [T; 3] {
        let field = |&[angle, velocity, phase]: &[T; 3]| {
            let torque = phase.cos() * 1.5 - velocity * 0.5 - angle.sin();
            [velocity, torque, T::constant(2.0 / 3.0)]
        };
        flow(field, x, Self::DT)
    }

    fn observe(&[angle, velocity, phase]: &[f64; 3]) -> Vec<f64> {
        vec![
            math::sin(angle),
            math::cos(angle),
            velocity,
            math::sin(phase),
            math::cos(phase),
        ]
    }
}

/// Chua's circuit with its piecewise linear diode, on the double scroll.
struct Chua;

impl System<3> for Chua {
    const DT: f64 = 0.05;
    const START: [f64; 3] = [0.7, 0.0, 0.0];

    fn next<T: Scalar>(x: [T; 3]) -> [T; 3] {
        let field = |&[x, y, z]: &[T; 3]| {
            let (inner, outer) = (-8.0 / 7.0, -5.0 / 7.0);
            let beyond = if x.value() > 1.0 {
                x - 1.0
            } else if x.value() < -1.0 {
                x + 1.0
            } else {
                T::zero()
            };
            let diode = x * inner + beyond * (outer - inner);
            [(y - x - diode) * 15.6, x - y + z, -y * 28.0]
        };
        flow(field, x, Self::DT)
    }
}

/// A system of known spectrum.
pub struct Case {
    /// Name in the table.
    pub name: &'static str,
    /// Time between two points.
    pub dt: f64,
    /// Columns of the series.
    pub columns: usize,
    /// Number of leading columns that are also observed alone. The columns after them belong to the
    /// pendulum's drive and carry no information on the system.
    pub alone: usize,
    /// Exponents, descending: the means of two runs of [`Case::exponents`] over 10⁷ points,
    /// with 0 for a flow's second. Sprott (Chaos and Time-Series Analysis, 2003) gives the same for
    /// Hénon and Lorenz, and for Rössler's first 0.0714.
    pub known: &'static [f64],
    /// The values of this many states on the attractor, row after row, from a start drawn with this
    /// seed.
    pub series: fn(seed: u64, points: usize) -> Vec<f64>,
    /// The exponents from the equations, over this many points.
    pub exponents: fn(seed: u64, points: usize) -> Vec<f64>,
}

/// All systems.
pub fn cases() -> Vec<Case> {
    vec![
        case::<Henon, 2>("Hénon", 2, &[0.4192, -1.6232]),
        case::<Ikeda, 2>("Ikeda", 2, &[0.5076, -0.7184]),
        case::<Logistic, 2>("coupled logistic", 2, &[0.4146, 0.3082]),
        case::<Lorenz, 3>("Lorenz", 3, &[0.9056, 0.0, -14.5723]),
        case::<LorenzWolf, 3>("Lorenz (Wolf)", 3, &[1.5025, 0.0, -22.5025]),
        case::<Roessler, 3>("Rössler", 3, &[0.0715, 0.0, -5.3943]),
        case::<Pendulum, 3>("driven pendulum", 5, &[0.1130, 0.0, -0.6130]),
        case::<Chua, 3>("Chua", 3, &[0.4325, 0.0, -4.2234]),
    ]
}

fn case<S: System<N>, const N: usize>(
    name: &'static str,
    columns: usize,
    known: &'static [f64],
) -> Case {
    Case {
        name,
        dt: S::DT,
        columns,
        alone: N,
        known,
        series: series::<S, N>,
        exponents: exponents::<S, N>,
    }
}

/// A state on the attractor.
fn settled<S: System<N>, const N: usize>(seed: u64) -> [f64; N] {
    let mut random = SplitMix::new(seed);
    let start = S::START.map(|middle| middle + random.between(-0.05, 0.05));
    (0..TRANSIENT).fold(start, |x, _| S::next(x))
}

fn series<S: System<N>, const N: usize>(seed: u64, points: usize) -> Vec<f64> {
    let mut x = settled::<S, N>(seed);
    let mut values = Vec::new();
    for _ in 0..points {
        values.extend(S::observe(&x));
        x = S::next(x);
    }
    values
}

fn exponents<S: System<N>, const N: usize>(seed: u64, points: usize) -> Vec<f64> {
    let mut x = settled::<S, N>(seed);
    // Tangent vectors, each a row.
    let mut tangents: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|k| if i == k { 1.0 } else { 0.0 }));
    let mut sums = [0.0; N];
    for _ in 0..points {
        for tangent in &mut tangents {
            let moved = S::next(std::array::from_fn(|i| Dual::new(x[i], tangent[i])));
            *tangent = moved.map(|v| v.eps);
        }
        x = S::next(x);
        for (i, sum) in sums.iter_mut().enumerate() {
            let (before, rest) = tangents.split_at_mut(i);
            let tangent = &mut rest[0];
            for other in before.iter() {
                let along: f64 = tangent.iter().zip(other).map(|(a, b)| a * b).sum();
                tangent
                    .iter_mut()
                    .zip(other)
                    .for_each(|(a, b)| *a -= along * b);
            }
            let length = tangent.iter().map(|v| v * v).sum::<f64>().sqrt();
            tangent.iter_mut().for_each(|v| *v /= length);
            *sum += math::ln(length);
        }
    }
    // A direction into which nothing is mapped keeps its vector and its position.
    sums.sort_by(|a, b| b.total_cmp(a));
    sums.map(|sum| sum / (points as f64 * S::DT)).to_vec()
}
