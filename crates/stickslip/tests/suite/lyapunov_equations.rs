//! Spectra from equations, compared with eigenvalues, published values and Floquet multipliers.

use std::ops::ControlFlow;

use stickslip::analysis::{Exponent, Spectrum, SpectrumOptions, multipliers};
use stickslip::dynamics::Matrix;
use stickslip::{
    Error, Filippov, Method, Mode, Observer, Options, Scalar, Side, State, Transition,
    TransitionKind, math,
};

use crate::any_system::{
    lyapunov_spectrum, lyapunov_spectrum_watched, monodromy, periodic_orbit, periodic_orbit_forced,
    run,
};
use crate::blocks::Block;
use crate::smooth::{Field, Lorenz, Smooth};
use crate::solver::systems::{coulomb_friction, decaying_friction};

fn values<const N: usize>(spectrum: &Spectrum) -> [f64; N] {
    let values: Vec<f64> = spectrum.exponents.iter().map(Exponent::value).collect();
    values.try_into().unwrap()
}

fn close(found: f64, wanted: f64, tolerance: f64) {
    let off = (found - wanted).abs();
    assert!(
        off <= tolerance,
        "{found} is {off:e} off {wanted}, allowed {tolerance:e}"
    );
}

pub struct Linear<const N: usize>([[f64; N]; N]);
impl<const N: usize> Field<N> for Linear<N> {
    fn at<T: Scalar>(&self, x: &[T; N]) -> [T; N] {
        std::array::from_fn(|i| {
            let row = &self.0[i];
            (0..N).fold(T::constant(0.0), |sum, j| sum + x[j] * row[j])
        })
    }
}

#[test]
fn linear_systems_have_the_real_parts_of_their_eigenvalues() {
    // Blocks with eigenvalues -0.1 ± 2i and -0.5, sheared so that no two eigenvectors are
    // orthogonal.
    let matrix = [[-0.1, 2.0, 0.7], [-2.0, -0.1, -1.3], [0.0, 0.0, -0.5]];
    let turn = std::f64::consts::PI;
    // After 30 turns the frame has converged by exp(-0.4 · 94) = 4e-17. Over whole turns only the
    // integration error remains, 1e-12 relative in each step.
    let settings = SpectrumOptions::over(30.0 * turn, 10.0 * turn).solver(Options::tol(1e-12));
    let start = (0.0, State::from([1.0, 0.0, 0.5]));
    let spectrum = lyapunov_spectrum(&Smooth(Linear(matrix)), start, &settings).unwrap();
    for (found, wanted) in values::<3>(&spectrum).iter().zip([-0.1, -0.1, -0.5]) {
        close(*found, wanted, 1e-10);
    }
    close(spectrum.mean_divergence, -0.7, 1e-14);
    close(spectrum.defect(), 0.0, 1e-11);
    assert_eq!((spectrum.stick_entries, spectrum.stick_fraction), (0, 0.0));
}

/// A driven linear system with eigenvalues -1/2 ± 2i and -8. It stays on the boundary `w = 3x/10 +
/// y/5`, since the contact force is 100.
pub struct Pressed;

impl Filippov<4> for Pressed {
    fn field<T: Scalar>(&self, side: Side, t: T, &[x, y, z, _]: &[T; 4]) -> [T; 4] {
        let (along, turns) = (-x * 0.5 + y * 2.0 + t.cos(), -y * 0.5 - x * 2.0);
        let across = x - 100.0 * side.sign();
        [
            along,
            turns,
            -z * 8.0 + x,
            along * 0.3 + turns * 0.2 + across,
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, &[x, y, _, w]: &[T; 4]) -> T {
        w - x * 0.3 - y * 0.2
    }
}

#[test]
fn a_long_stick_has_the_exponents_of_the_sliding_flow() {
    let start = (0.0, State::from([1.0, 1.0, 2.0, 0.5]));
    for duration in [100.0, 1000.0] {
        let settings = SpectrumOptions::over(50.0, duration).solver(Options::tol(1e-10));
        let spectrum = lyapunov_spectrum(&Pressed, start, &settings).unwrap();
        assert_eq!((spectrum.stick_entries, spectrum.stick_fraction), (0, 1.0));
        let [first, second, third, last] = spectrum.exponents[..] else {
            panic!("{:?}", spectrum.exponents);
        };
        // Each of the first two rotates with the frame.
        close(first.value(), -0.5, 1.0 / duration);
        close(first.value() + second.value(), -1.0, 1e-6);
        close(third.value(), -8.0, 1e-6);
        assert_eq!(last, Exponent::Annihilated);
        close(spectrum.defect(), 0.0, 1e-6);
    }
}

#[test]
fn the_largest_exponent_is_found_where_the_axes_decouple() {
    let matrix = [[-1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 0.3]];
    // At rest at the origin. The frame converges by exp(-1 · 40) = 4e-18 (from -1 to -2 the
    // slowest).
    let settings = SpectrumOptions::over(40.0, 10.0).solver(Options::tol(1e-12));
    let start = (0.0, [0.0; 3]);
    let spectrum = lyapunov_spectrum(&Smooth(Linear(matrix)), start, &settings).unwrap();
    for (found, wanted) in values::<3>(&spectrum).iter().zip([0.3, -1.0, -2.0]) {
        close(*found, wanted, 1e-10);
    }
}

#[test]
fn a_state_at_rest_does_not_mislead_the_tangent_vectors() {
    // The state allows steps of any length; the vectors do not.
    let matrix = [[-0.3, 1.0], [-1.0, -0.3]];
    let system = Smooth(Linear(matrix));
    let flow = monodromy(&system, 0.0, [0.0; 2], 20.0, &Options::tol(1e-12)).unwrap();
    let decay = math::exp(-6.0);
    let (c, s) = (math::cos(20.0), math::sin(20.0));
    let wanted = Matrix::from_row_slice(2, 2, &[c, s, -s, c]) * decay;
    // About fifty pieces, each within a hundred tolerances.
    close((flow.matrix - wanted).amax(), 0.0, decay * 5e-9);
}

#[test]
fn exponents_of_a_state_at_rest_do_not_drown_in_the_largest() {
    // A step of the state is as long as a block, 50 and more: exp(-50) is below rounding.
    let matrix = [[-1.0, 1.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, -10.0]];
    for transient in [0.0, 500.0] {
        let settings = SpectrumOptions::over(transient, 1000.0).solver(Options::tol(1e-12));
        let start = (0.0, State::from([0.0; 3]));
        let spectrum = lyapunov_spectrum(&Smooth(Linear(matrix)), start, &settings).unwrap();
        // Without a transient, the frame turns towards the directions over a time of one.
        let allowed = if transient > 0.0 { 1e-8 } else { 1e-2 };
        for (found, wanted) in values::<3>(&spectrum).iter().zip([-1.0, -3.0, -10.0]) {
            close(*found, wanted, allowed);
        }
        close(spectrum.defect(), 0.0, 1e-8);
    }
}

#[test]
fn exponents_at_rest_do_not_underflow() {
    // A step of the state is as long as a block: over 5000, exp(-5 t) is below the least number.
    for method in [Method::Taylor, Method::Dop853] {
        let options = Options::tol(1e-10).method(method);
        let settings = SpectrumOptions::over(1e3, 1e5).solver(options);
        let system = Smooth(Linear([[-5.0, 0.0], [0.0, -5.0]]));
        let start = (0.0, State::from([0.0; 2]));
        let spectrum = lyapunov_spectrum(&system, start, &settings).unwrap();
        for found in values::<2>(&spectrum) {
            close(found, -5.0, 1e-7);
        }
        close(spectrum.defect(), 0.0, 1e-7);
    }
}

#[test]
fn a_fast_decay_at_rest_is_measured() {
    let system = Smooth(Linear([[-1.0, 0.0], [0.0, -1000.0]]));
    let settings = SpectrumOptions::over(10.0, 20.0);
    let spectrum = lyapunov_spectrum(&system, (0.0, State::from([0.0; 2])), &settings).unwrap();
    for (found, wanted) in values::<2>(&spectrum).iter().zip([-1.0, -1000.0]) {
        close(*found, wanted, 1e-6 * wanted.abs());
    }
    // As many parts as steps are allowed.
    let few = settings.solver(Options {
        most_steps: 100,
        ..Options::default()
    });
    let spectrum = lyapunov_spectrum(&system, (0.0, State::from([0.0; 2])), &few).unwrap();
    assert!(
        matches!(
            spectrum.ended,
            Some(stickslip::Error::TooMany {
                name: "most_steps",
                ..
            })
        ),
        "{spectrum:?}"
    );
}

#[test]
fn lorenz() {
    let settings = SpectrumOptions::over(50.0, 3000.0);
    let start = (0.0, State::from([1.0, 1.0, 20.0]));
    let spectrum = lyapunov_spectrum(&Smooth(Lorenz), start, &settings).unwrap();
    let [l1, l2, l3] = values(&spectrum);
    // Sprott's values have four digits. The run's own standard error gives the accuracy over 3000
    // time units, and must itself be small.
    let error = spectrum.exponents[0].std_error().unwrap();
    assert!(error < 5e-3, "{error}");
    close(l1, 0.9056, 4.0 * error);
    // Along the flow a vector grows as |f|, which is between 1 and 400 on the attractor.
    close(l2, 0.0, math::ln(400.0) / 3000.0);
    close(l3, -14.5723, 4.0 * error + 1e-3);
    close(spectrum.mean_divergence, -(10.0 + 1.0 + 8.0 / 3.0), 1e-11);
    // The sum is the constant divergence up to the tolerance of 1e-10 per step of about 0.05.
    close(spectrum.defect(), 0.0, 1e-7);
    // Running exponents: of bounded number, in order, the last one being the result.
    assert!((150..=201).contains(&spectrum.convergence.len()));
    assert!(spectrum.convergence.is_sorted_by_key(|entry| entry.elapsed));
    let last = spectrum.convergence.last().unwrap();
    assert_eq!(
        (last.elapsed, &last.exponents[..]),
        (spectrum.duration, &[l1, l2, l3][..])
    );
}

pub struct Roessler;
impl Field<3> for Roessler {
    fn at<T: Scalar>(&self, x: &[T; 3]) -> [T; 3] {
        [-x[1] - x[2], x[0] + x[1] * 0.2, x[2] * (x[0] - 5.7) + 0.2]
    }
}

#[test]
fn roessler() {
    let settings = SpectrumOptions::over(200.0, 40_000.0);
    let start = (0.0, State::from([1.0, 1.0, 0.0]));
    let spectrum = lyapunov_spectrum(&Smooth(Roessler), start, &settings).unwrap();
    let [l1, l2, l3] = values(&spectrum);
    let error = spectrum.exponents[0].std_error().unwrap();
    // The spread over starts is 7e-4. The autocovariances of so few blocks vary up to threefold.
    assert!(error < 3.0 * 7e-4, "{error}");
    // Half a unit of the published digit in addition to two standard errors.
    close(l1, 0.0714, 2.0 * error + 5e-5);
    close(l2, 0.0, math::ln(400.0) / 40_000.0);
    let error = spectrum.exponents[2].std_error().unwrap();
    close(l3, -5.394, 2.0 * error + 5e-4);
    close(spectrum.defect(), 0.0, 1e-7);
}

#[test]
fn a_cycle_across_the_boundary_has_zero_and_the_logarithm_of_its_multiplier() {
    let belt = Block::on_belt(1.0);
    let solver = Options::tol(1e-13);
    let cycle = periodic_orbit(&belt, State::from([-0.27, -0.73]), 7.7, &solver).unwrap();
    let [trivial, multiplier]: [_; 2] = multipliers(&cycle.monodromy).try_into().unwrap();
    close(cycle.period, 7.722_895_6, 5e-8);
    close(multiplier.re, 0.126_289, 5e-7);
    close(trivial.re, 1.0, 1e-10);
    // 15 periods bring the frame within 0.126^15 = 3e-14 of its limit.
    let settings = SpectrumOptions::over(15.0 * cycle.period, 10.0 * cycle.period).solver(solver);
    let spectrum = lyapunov_spectrum(&belt, (0.0, &cycle.x), &settings).unwrap();
    let [along, across] = values(&spectrum);
    close(along, 0.0, 1e-9);
    close(across, math::ln(multiplier.re) / cycle.period, 1e-9);
    // The fields expand on average; the crossings contract.
    assert!(spectrum.mean_divergence > 0.08);
    close(spectrum.defect(), 0.0, 1e-11);
}

#[test]
fn stick_annihilates_one_direction_and_is_counted() {
    // P2: x'' = -x ± 1/(1 + |v|) on a belt of speed 0.2. It sticks once in every period of
    // 9.230770458….
    let belt = decaying_friction();
    let period = 9.230_770_458_082_978;
    let settings = SpectrumOptions::over(5.0 * period, 20.0 * period).solver(Options::tol(1e-12));
    let spectrum = lyapunov_spectrum(&belt, (0.0, State::from([0.04, -0.01])), &settings).unwrap();
    // The direction of the flow, over whole periods.
    close(spectrum.exponents[0].value(), 0.0, 1e-10);
    assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
    assert_eq!(spectrum.exponents[1].std_error(), None);
    let counts = (spectrum.stick_entries, spectrum.collapses);
    assert_eq!((counts, spectrum.annihilated()), ((20, 20), 1));
    close(
        spectrum.stick_fraction,
        1.0 - 4.703_364_997_942_152 / period,
        1e-10,
    );
    close(spectrum.volume_rate, 0.0, 1e-10);
    // A start on Σ gives the same, whatever the phase.
    let start = (0.0, State::from([0.5, 0.2]));
    let settings = SpectrumOptions {
        transient: 0.0,
        ..settings
    };
    let from_stick = lyapunov_spectrum(&belt, start, &settings).unwrap();
    close(from_stick.exponents[0].value(), 0.0, 1e-10);
    assert_eq!(from_stick.exponents[1], Exponent::Annihilated);
}

#[test]
fn sticking_for_good_leaves_positions_neutral() {
    // P1: a block on a floor, x'' = -x - 0.4 sgn x', at rest from t = 4π on.
    let floor = coulomb_friction(0.4, 0.0);
    let settings = SpectrumOptions::over(20.0, 10.0);
    let spectrum = lyapunov_spectrum(&floor, (0.0, State::from([3.0, 0.0])), &settings).unwrap();
    assert_eq!(values(&spectrum), [0.0, f64::NEG_INFINITY]);
    assert_eq!((spectrum.stick_fraction, spectrum.stick_entries), (1.0, 0));
}

#[test]
fn stick_on_the_way_to_an_attractor_without_it_annihilates_nothing() {
    let belt = Block::on_belt(1.0);
    #[derive(Default)]
    struct Sticks {
        entries: usize,
        exits: usize,
    }
    impl Observer<2> for Sticks {
        fn transition(&mut self, at: &Transition<2>) -> ControlFlow<()> {
            self.entries += usize::from(at.kind == TransitionKind::StickEntry);
            self.exits += usize::from(at.kind == TransitionKind::StickExit);
            ControlFlow::Continue(())
        }
    }
    // Starts on Σ in stick and ends on the cycle without stick.
    let start = State::from([0.0, 1.0]);
    let mut sticks_on_the_way = Sticks::default();
    let settings = SpectrumOptions::over(300.0, 77.228_956).solver(Options::tol(1e-12));
    run(
        &belt,
        0.0,
        start,
        5.0,
        &Options::tol(1e-12),
        &mut sticks_on_the_way,
    )
    .unwrap();
    assert_eq!((sticks_on_the_way.entries, sticks_on_the_way.exits), (0, 1));
    let mut sticks = Sticks::default();
    let spectrum = lyapunov_spectrum_watched(&belt, (0.0, start), &settings, &mut sticks).unwrap();
    assert_eq!((spectrum.stick_entries, sticks.entries), (0, 0));
    // All running exponents are finite; the revived direction aligns within one period.
    close(spectrum.exponents[1].value(), -0.267_927_803, 1e-3);
}

/// x' jumps where x changes sign, by a factor that depends on the velocity, so that crossings
/// change areas. Forced, with a double well: chaotic.
pub struct Refracting;
impl Filippov<2> for Refracting {
    fn field<T: Scalar>(&self, side: Side, t: T, x: &[T; 2]) -> [T; 2] {
        let square = x[1] * x[1];
        let factor = square / (square + 1.0) * (0.4 * side.sign()) + 1.0;
        let well = x[0] - x[0] * x[0] * x[0];
        [
            x[1] * factor,
            well - x[1] * 0.2 + (t * 1.2).cos() * 0.4 + 0.03,
        ]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 2]) -> T {
        x[0]
    }
}

/// Sums ln|det S| over the crossings.
struct Determinants {
    sum: f64,
    count: usize,
}
impl Observer<2> for Determinants {
    fn transition(&mut self, at: &Transition<2>) -> ControlFlow<()> {
        let (Mode::Slip(from), Mode::Slip(to)) = (at.from, at.to) else {
            return ControlFlow::Break(());
        };
        // The determinant of `I + (f⁺ − f⁻) ∇hᵀ / (∇h·f⁻)` is `∇h·f⁺ / ∇h·f⁻`, by Sylvester.
        let rate = |side| Refracting.field(side, at.t, at.x.as_ref())[0];
        self.sum += math::ln((rate(to) / rate(from)).abs());
        self.count += 1;
        ControlFlow::Continue(())
    }
}

#[test]
fn the_sum_of_the_exponents_is_mean_divergence_and_saltation() {
    let settings = SpectrumOptions::over(200.0, 3000.0).solver(Options::tol(1e-11));
    let mut crossings = Determinants { sum: 0.0, count: 0 };
    let start = (0.0, State::from([1.0, 0.0]));
    let spectrum =
        lyapunov_spectrum_watched(&Refracting, start, &settings, &mut crossings).unwrap();
    assert!(
        spectrum.exponents[0].value() > 0.05,
        "{:?}",
        spectrum.exponents
    );
    assert!(crossings.count > 250, "{}", crossings.count);
    let per_time = crossings.sum / spectrum.duration;
    // About 1e4 steps, each within 1e-11, over 3000 time units, and the quadrature over steps with
    // that accuracy.
    close(
        spectrum.volume_rate,
        spectrum.mean_divergence + per_time,
        1e-12,
    );
    close(spectrum.defect(), 0.0, 1e-8);
}

/// A forced oscillator relative to its support: the same motion in `(z, z')`, `z = x − A sin ωt`,
/// where the boundary moves.
pub struct FromSupport(Block);
impl FromSupport {
    fn velocity<T: Scalar>(&self, t: T) -> T {
        (t * self.0.omega).cos() * (self.0.amplitude * self.0.omega)
    }
    fn outside<T: Scalar>(&self, t: T, z: &[T; 2]) -> [T; 2] {
        let support = (t * self.0.omega).sin() * self.0.amplitude;
        [z[0] + support, z[1] + self.velocity(t)]
    }
}
impl Filippov<2> for FromSupport {
    fn field<T: Scalar>(&self, side: Side, t: T, z: &[T; 2]) -> [T; 2] {
        let f = self.0.field(side, t, &self.outside(t, z));
        let omega = self.0.omega;
        let acceleration = (t * omega).sin() * (-self.0.amplitude * omega * omega);
        [f[0] - self.velocity(t), f[1] - acceleration]
    }
    fn boundary<T: Scalar>(&self, t: T, z: &[T; 2]) -> T {
        self.0.boundary(t, &self.outside(t, z))
    }
}

#[test]
fn a_moving_boundary_gives_the_floquet_exponents_too() {
    let model = Block::shaken();
    let period = model.period();
    let solver = Options::tol(1e-13);
    let settled = run(
        &model,
        0.0,
        State::from([0.0, 0.0]),
        60.0 * period,
        &solver,
        &mut (),
    );
    let x = settled.unwrap().x;
    let orbit = periodic_orbit_forced(&model, 0.0, x, period, &solver).unwrap();
    let found = multipliers(&orbit.monodromy);
    let [a, b] = [0, 1].map(|k| found[k].re.abs());
    close(period, 1.648_53, 5e-6);
    close(a.max(b), 0.6639, 5e-5);
    close(a.min(b), 0.5638, 5e-5);
    let wanted = [a.max(b), a.min(b)].map(|m| math::ln(m) / period);
    // 200 periods bring the frame within (0.5638/0.6639)^200 = 6e-15 of its limit.
    let settings = SpectrumOptions::over(200.0 * period, 20.0 * period).solver(solver);
    let fixed = lyapunov_spectrum(&model, (0.0, &orbit.x), &settings).unwrap();
    let velocity = model.amplitude * model.omega;
    let start = (0.0, [orbit.x[0], orbit.x[1] - velocity]);
    let moving = lyapunov_spectrum(&FromSupport(model), start, &settings).unwrap();
    for spectrum in [&fixed, &moving] {
        for (found, wanted) in values::<2>(spectrum).iter().zip(wanted) {
            close(*found, wanted, 1e-9);
        }
        close(spectrum.defect(), 0.0, 1e-10);
    }
}

#[test]
fn stick_to_a_moving_boundary_annihilates_as_stick_to_a_fixed_one() {
    let model = Block {
        mass: 1.0,
        k2: 0.0,
        mu0: 1.0,
        belt_speed: 0.2,
        amplitude: 0.8,
        omega: 1.3,
        ..Block::shaken()
    };
    let period = model.period();
    let settings =
        SpectrumOptions::over(100.0 * period, 100.0 * period).solver(Options::tol(1e-12));
    let start = State::from([0.3, 0.0]);
    let fixed = lyapunov_spectrum(&model, (0.0, start), &settings).unwrap();
    let velocity = model.amplitude * model.omega;
    let seen = start - State::from([0.0, velocity]);
    let moving = lyapunov_spectrum(&FromSupport(model), (0.0, seen), &settings).unwrap();
    assert!(fixed.stick_entries >= 50, "{}", fixed.stick_entries);
    assert_eq!(moving.stick_entries, fixed.stick_entries);
    for spectrum in [&fixed, &moving] {
        assert_eq!(spectrum.exponents[1], Exponent::Annihilated);
        // There is no zero exponent: time drives the system, and no shift along the orbit is free.
        assert!(spectrum.exponents[0].value() < -0.05);
        close(spectrum.defect(), 0.0, 1e-9);
    }
    // Both descriptions have the same tangent vectors at equal times, so that not even end effects
    // differ.
    close(
        moving.exponents[0].value(),
        fixed.exponents[0].value(),
        1e-9,
    );
    close(moving.stick_fraction, fixed.stick_fraction, 1e-9);
}

/// P6: x' = ±a towards the moving boundary x = sin t.
pub struct Rider;
impl Filippov<1> for Rider {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(-0.9 * side.sign())]
    }
    fn boundary<T: Scalar>(&self, t: T, x: &[T; 1]) -> T {
        x[0] - t.sin()
    }
}

#[test]
fn one_dimension_has_nothing_left_after_stick() {
    let settings = SpectrumOptions::over(0.0, 50.0);
    let spectrum = lyapunov_spectrum(&Rider, (0.0, State::from([2.0])), &settings).unwrap();
    assert_eq!(spectrum.exponents, [Exponent::Annihilated]);
    assert!(spectrum.stick_entries > 5);
    assert_eq!(spectrum.sum(), 0.0);
    close(spectrum.defect(), 0.0, 1e-15);
}

/// Both fields point away from zero.
pub struct Fork;
impl Filippov<1> for Fork {
    fn field<T: Scalar>(&self, side: Side, _t: T, _x: &[T; 1]) -> [T; 1] {
        [T::constant(side.sign())]
    }
    fn boundary<T: Scalar>(&self, _t: T, x: &[T; 1]) -> T {
        x[0]
    }
}

#[test]
fn settings_and_orbits_without_a_future_are_refused() {
    let belt = Block::on_belt(1.0);
    let start = (0.0, State::from([0.5, 0.5]));
    let good = SpectrumOptions::over(1.0, 1.0);
    let bad = [
        (
            "transient",
            SpectrumOptions {
                transient: -1.0,
                ..good
            },
        ),
        (
            "duration",
            SpectrumOptions {
                duration: 0.0,
                ..good
            },
        ),
        (
            "duration",
            SpectrumOptions {
                duration: f64::NAN,
                ..good
            },
        ),
        ("blocks", good.blocks(1)),
        ("samples", good.samples(0)),
        ("rtol", good.solver(Options::tol(1.0))),
    ];
    for (name, settings) in bad {
        let error = lyapunov_spectrum(&belt, start, &settings).unwrap_err();
        assert!(
            matches!(error, Error::Option { name: found, .. } if found == name),
            "{error}"
        );
    }
    let error = lyapunov_spectrum(&Fork, (0.0, State::from([0.0])), &good).unwrap_err();
    assert!(matches!(error, Error::NoUniqueFuture { .. }), "{error}");
    assert!(error.to_string().contains("at_repelling"));
}
