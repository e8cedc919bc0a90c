//! Random chains of two to six blocks, some of them on one another. Every mode is the unique
//! solution of its complementarity problem, by enumeration. The energy balances, and no event is
//! missed.

use numerics::SplitMix;
use stickslip::{Contacts, Method, Mode, Options, Orbit, Scalar, Several, Side, State, solve};

use super::rig::Rig;

const B: usize = 6;
const N: usize = 2 * B;

/// A chain with a start, and its number of blocks.
struct Chain {
    rig: Rig<B>,
    x: State<N>,
    blocks: usize,
    /// See [`Chain::responses`].
    responses: [[f64; B]; B],
}

impl Chain {
    fn random(random: &mut SplitMix) -> Self {
        let mut between = |low: f64, high: f64| random.between(low, high);
        let blocks = 2 + (between(0.0, 5.0) as usize).min(4);
        let mut rig = Rig::at_rest();
        let mut x = State::from([0.0; N]);
        for i in 0..blocks {
            rig.masses[i] = between(0.3, 2.0);
            rig.friction[i] = between(0.02, 0.5);
            let stands_on_floor = i == 0 || between(0.0, 1.0) < 0.7;
            rig.sits_on[i] = (!stands_on_floor).then(|| i - 1);
            rig.spring(between(0.1, 1.5), i, None);
            if i > 0 {
                rig.spring(between(0.1, 2.0), i - 1, Some(i));
            }
            x[i] = between(-2.0, 2.0);
            // Some contacts begin at rest.
            x[B + i] = between(-1.0, 2.0).max(0.0);
        }
        let mut chain = Chain {
            rig,
            x,
            blocks,
            responses: [[0.0; B]; B],
        };
        chain.responses = chain.responses();
        chain
    }

    fn orbit(&self, options: &Options) -> Orbit<N, [Mode; B]> {
        solve(&Several(&self.rig), 0.0, self.x, 12.0, options).unwrap()
    }

    /// Acceleration with these friction forces, one for each body.
    fn acceleration(&self, friction: &[f64; B], x: &State<N>) -> [f64; B] {
        let rig = &self.rig;
        std::array::from_fn(|i| {
            let springs: f64 = (0..B).map(|j| rig.stiffness[i][j] * x[j]).sum();
            let above: f64 = (0..B)
                .filter(|&c| rig.sits_on[c] == Some(i))
                .map(|c| friction[c])
                .sum();
            (above - friction[i] - springs) / rig.masses[i]
        })
    }

    /// Velocity of each contact from velocities, or its rate from accelerations.
    fn relative(&self, v: &[f64; B]) -> [f64; B] {
        std::array::from_fn(|c| v[c] - self.rig.sits_on[c].map_or(0.0, |below| v[below]))
    }

    /// Effect of a unit of friction at one contact on all rates: `[rate][force]`.
    fn responses(&self) -> [[f64; B]; B] {
        let rest = State::from([0.0; N]);
        let mut responses = [[0.0; B]; B];
        for force in 0..B {
            let unit = std::array::from_fn(|c| f64::from(u8::from(c == force)));
            let rates = self.relative(&self.acceleration(&unit, &rest));
            for rate in 0..B {
                responses[rate][force] = rates[rate];
            }
        }
        responses
    }

    /// Friction forces and rates of the contacts in a mode. The forces of contacts that hold are
    /// solved for.
    fn forces_and_rates(&self, mode: &[Mode; B], x: &State<N>) -> ([f64; B], [f64; B]) {
        let holds = |c: usize| c < self.blocks && mode[c] == Mode::Stick;
        let mut friction: [f64; B] = std::array::from_fn(|c| match mode[c] {
            Mode::Slip(side) => self.rig.friction[c] * side.sign(),
            Mode::Stick => 0.0,
        });
        let free = self.relative(&self.acceleration(&friction, x));
        // Rows and columns of slipping contacts add nothing.
        let mut matrix = self.responses;
        let mut force: [f64; B] = std::array::from_fn(|c| if holds(c) { -free[c] } else { 0.0 });
        for i in 0..B {
            for j in 0..B {
                if !(holds(i) && holds(j)) {
                    matrix[i][j] = f64::from(u8::from(i == j));
                }
            }
        }
        for k in 0..B {
            for i in 0..B {
                if i != k {
                    let factor = matrix[i][k] / matrix[k][k];
                    for j in 0..B {
                        matrix[i][j] -= factor * matrix[k][j];
                    }
                    force[i] -= factor * force[k];
                }
            }
        }
        let mut rates = free;
        for c in 0..B {
            let added = force[c] / matrix[c][c];
            friction[c] += added;
            for rate in 0..B {
                rates[rate] += self.responses[rate][c] * added;
            }
        }
        (friction, rates)
    }

    /// Margin by which a mode is consistent at the contacts in `at_zero`; negative if it is not.
    fn margin(&self, mode: &[Mode; B], at_zero: &[usize], x: &State<N>) -> f64 {
        let (forces, rates) = self.forces_and_rates(mode, x);
        at_zero
            .iter()
            .map(|&c| match mode[c] {
                Mode::Stick => self.rig.friction[c] - forces[c].abs(),
                Mode::Slip(side) => rates[c] * side.sign(),
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn energy(&self, x: &State<N>) -> f64 {
        let kinetic: f64 = (0..B)
            .map(|i| self.rig.masses[i] * x[B + i] * x[B + i])
            .sum();
        let elastic: f64 = (0..B)
            .flat_map(|i| (0..B).map(move |j| (i, j)))
            .map(|(i, j)| x[i] * self.rig.stiffness[i][j] * x[j])
            .sum();
        0.5 * (kinetic + elastic)
    }

    fn velocities(&self, x: &State<N>) -> [f64; B] {
        self.relative(&std::array::from_fn(|i| x[B + i]))
    }

    /// Asserts that every reported mode is consistent, and no other one clearly is.
    fn modes_are_unique(&self, orbit: &Orbit<N, [Mode; B]>) {
        const ROUNDING: f64 = 1e-7;
        // At the start, with up to all blocks at rest, and after every event.
        let start = (orbit.x_start, orbit.phases[0].mode, None);
        let changes = orbit
            .transitions
            .iter()
            .map(|at| (at.x, at.to, Some(at.contact)));
        for at in std::iter::once(start).chain(changes) {
            let (x, to, contact) = at;
            let h = self.velocities(&x);
            let at_zero: Vec<usize> = (0..self.blocks)
                .filter(|&c| to[c] == Mode::Stick || Some(c) == contact || h[c].abs() < 1e-9)
                .collect();
            let margin = self.margin(&to, &at_zero, &x);
            assert!(margin > -ROUNDING, "{margin:e} at {at:?} of {:?}", self.rig);
            const EACH: [Mode; 3] = [
                Mode::Stick,
                Mode::Slip(Side::Below),
                Mode::Slip(Side::Above),
            ];
            for number in 0..3_usize.pow(at_zero.len() as u32) {
                let (mut mode, mut rest) = (to, number);
                for &c in &at_zero {
                    mode[c] = EACH[rest % 3];
                    rest /= 3;
                }
                let margin = self.margin(&mode, &at_zero, &x);
                assert!(
                    mode == to || margin < ROUNDING,
                    "{mode:?} as well ({margin:e}) at {at:?} of {:?}",
                    self.rig
                );
            }
        }
    }

    /// Asserts that no event is missed. At 100 points of each step, slipping contacts slip to their
    /// side, and sticking ones can hold.
    fn nothing_is_missed(&self, orbit: &Orbit<N, [Mode; B]>) {
        for step in &orbit.steps {
            for k in 0..=100 {
                let t = step.t_start + f64::from(k) / 100.0 * (step.t_end - step.t_start);
                let x = step.dense.at_time(t);
                let h = self.velocities(&x);
                let (forces, _) = self.forces_and_rates(&step.mode, &x);
                for c in 0..self.blocks {
                    let left = match step.mode[c] {
                        Mode::Slip(side) => h[c] * side.sign(),
                        Mode::Stick => self.rig.friction[c] - forces[c].abs(),
                    };
                    // The dense output may err by some hundred tolerances.
                    assert!(
                        left > -1e-8,
                        "{left:e} at contact {c}, t = {t}: {:?}",
                        self.rig
                    );
                }
            }
        }
    }

    /// Asserts that the energy loss is the work of friction, by quadrature over the dense output.
    fn energy_balances(&self, orbit: &Orbit<N, [Mode; B]>) {
        const GAUSS: [(f64, f64); 5] = [
            (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
            (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        ];
        let mut work = 0.0;
        for step in &orbit.steps {
            // Steps are too long for five points: each is divided into eight parts.
            let part = (step.t_end - step.t_start) / 8.0;
            for k in 0..8 {
                let middle = step.t_start + (f64::from(k) + 0.5) * part;
                for (node, weight) in GAUSS {
                    let x = step.dense.at_time(middle + 0.5 * node * part);
                    let h = self.velocities(&x);
                    let power: f64 = (0..B)
                        .filter(|&c| step.mode[c] != Mode::Stick)
                        .map(|c| self.rig.friction[c] * h[c].abs())
                        .sum();
                    work += 0.5 * weight * part * power;
                }
            }
        }
        let off = self.energy(&self.x) - self.energy(&orbit.x_end) - work;
        assert!(off.abs() < 1e-8, "{off:e}: {:?}", self.rig);
    }
}

fn check(seed: u64, count: usize, options: &Options) {
    let mut random = SplitMix::new(seed);
    for number in 0..count {
        let chain = Chain::random(&mut random);
        let orbit = chain.orbit(options);
        chain.modes_are_unique(&orbit);
        // The other checks take longer and add less: for every tenth orbit.
        if number % 10 == 0 {
            chain.nothing_is_missed(&orbit);
            chain.energy_balances(&orbit);
        }
    }
}

fn by_runge_kutta(count: usize) {
    check(2013, count, &Options::tol(1e-11));
}

fn by_taylor(count: usize) {
    check(73, count, &Options::tol(1e-12).method(Method::Taylor));
}

#[test]
fn modes_energy_and_events_of_five_hundred_random_chains_by_runge_kutta() {
    by_runge_kutta(500);
}

#[test]
fn modes_energy_and_events_of_five_hundred_random_chains_by_taylor() {
    by_taylor(500);
}

#[test]
#[ignore = "takes minutes; make random runs it"]
fn modes_energy_and_events_of_ten_thousand_random_chains_by_runge_kutta() {
    by_runge_kutta(10_000);
}

#[test]
#[ignore = "takes minutes; make random runs it"]
fn modes_energy_and_events_of_ten_thousand_random_chains_by_taylor() {
    by_taylor(10_000);
}

/// A chain whose frictions are known to add and to be no larger at rest, so that no event checks
/// it.
struct Known<'a>(&'a Rig<B>);

impl Contacts<N, B> for Known<'_> {
    fn field<T: Scalar>(&self, sides: &[Side; B], t: T, x: &[T; N]) -> [T; N] {
        self.0.field(sides, t, x)
    }
    fn boundaries<T: Scalar>(&self, t: T, x: &[T; N]) -> [T; B] {
        self.0.boundaries(t, x)
    }
    fn frictions_add(&self) -> bool {
        true
    }
    fn has_static_friction(&self) -> bool {
        false
    }
}

#[test]
fn what_is_known_of_the_friction_saves_checks_and_changes_no_bit() {
    let mut random = SplitMix::new(1967);
    let options = Options::tol(1e-10);
    let mut events = 0;
    for _ in 0..200 {
        let chain = Chain::random(&mut random);
        let (orbit, start) = (chain.orbit(&options), chain.x);
        let known = solve(&Several(Known(&chain.rig)), 0.0, start, 12.0, &options).unwrap();
        assert_eq!(
            (&known.transitions, known.x_end),
            (&orbit.transitions, orbit.x_end)
        );
        events += orbit.transitions.len();
    }
    assert!(events > 1_000, "{events}");
}
