//! Properties behind golden numbers, by routes that do not lead through the code that made them.

use std::ops::ControlFlow;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use replication::figures::block_and_bracket::TOLERANCE;
use replication::paper::models::{
    BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Interpretation,
};
use stickslip::{
    Filippov, Mode, Observer, Options, Orbit, Side, State, StepRecord, math, run, solve,
};

/// A number of `golden/FIGURE.snap`.
fn golden(figure: &str, reading: &str, id: &str) -> f64 {
    let path = format!("{}/golden/{figure}.snap", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let rows = text.lines().map(|line| line.split_whitespace());
    let mut values = rows.filter_map(|mut row| {
        (row.next() == Some(id) && row.next() == Some(reading)).then(|| row.next())?
    });
    values
        .next()
        .unwrap_or_else(|| panic!("{id}"))
        .parse()
        .unwrap()
}

/// The position of the next crossing of Σ upwards after one at a position, and the time between.
fn next_upward_crossing(model: &BeltOscillator, x1: f64) -> (f64, f64) {
    let start = State::from([x1, model.belt_speed]);
    let orbit = solve(model, 0.0, start, 12.0, &Options::tol(1e-13)).unwrap();
    let crossings = orbit.transitions.iter();
    let mut upward = crossings.filter(|at| at.to == Mode::Slip(Side::Above));
    let next = upward.next().unwrap();
    (next.x[0], next.t)
}

/// The multiplier is the derivative of the map from one upward crossing to the next: a difference
/// quotient of order four, since the map is smooth there.
#[test]
fn the_cycle_of_fig_4_is_a_fixed_point_of_its_return_map_with_the_multiplier_as_slope() {
    let of = |id: &str| golden("fig04", "exact", &format!("fig04.limit_cycle.{id}"));
    let model = BeltOscillator::default();
    let left = of("crossing.left");
    let (again, period) = next_upward_crossing(&model, left);
    assert_abs_diff_eq!(again, left, epsilon = 1e-12);
    assert_abs_diff_eq!(period, of("period"), epsilon = 1e-11);
    let difference = |h: f64| {
        let [low, high] = [-h, h].map(|by| next_upward_crossing(&model, left + by).0);
        (high - low) / (2.0 * h)
    };
    let h = 2e-4;
    let slope = (4.0 * difference(h) - difference(2.0 * h)) / 3.0;
    assert_abs_diff_eq!(slope, 0.126_289_492, epsilon = 1e-9);
    assert_abs_diff_eq!(slope, of("multiplier"), epsilon = 1e-9);
}

/// Times and positions of the last events of `data/references/forced.csv`, which have thirty
/// digits. By then the orbit has settled to seventeen: the multipliers are below 0.67, and a
/// hundred periods have passed.
fn last_references() -> Vec<(f64, f64)> {
    let mut reader = csv::Reader::from_reader(&include_bytes!("../data/references/forced.csv")[..]);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let number = |row: &csv::StringRecord, k: usize| row[k].parse().unwrap();
    let crossings = rows.iter().filter(|row| &row[2] == "crossing");
    let crossings: Vec<_> = crossings
        .map(|row| (number(row, 3), number(row, 4)))
        .collect();
    crossings[crossings.len() - 3..].to_vec()
}

#[test]
fn the_exact_motion_of_fig_8_crosses_where_thirty_digits_say() {
    let of = |id: &str| golden("fig08", "exact", &format!("fig08.{id}"));
    let [right, left, again] = last_references()[..] else {
        panic!("three crossings");
    };
    assert!(left.1 < 0.0 && right.1 > 0.0);
    assert_abs_diff_eq!(of("crossing.left"), left.1, epsilon = 1e-11);
    assert_abs_diff_eq!(of("crossing.right"), right.1, epsilon = 1e-11);
    // Between the downward crossing on the right and the upward one on the left it is slower than
    // the belt. The times have an error of rounding at 164 s.
    assert_abs_diff_eq!(of("slip_duration.below"), left.0 - right.0, epsilon = 1e-11);
    assert_abs_diff_eq!(of("slip_duration.above"), again.0 - left.0, epsilon = 1e-11);
}

/// ∫ div f dt along the slip phases of an orbit of model 2, by Simpson's rule. The divergence is
/// −∂T/∂x₂/m, in closed form.
fn divergence(model: &ForcedOscillator, orbit: &Orbit<2>) -> f64 {
    const PARTS: u32 = 4000;
    let rate = |t: f64| {
        let slip = (orbit.at(t).unwrap()[1] - model.belt_speed).abs();
        let root = 1.0 + model.delta * slip;
        model.mu0 * model.delta / (root * root) / model.mass
    };
    let phases = orbit.phases.iter().map(|phase| {
        let h = (phase.t_end - phase.t_start) / f64::from(PARTS);
        let weight = |k: u32| match k {
            0 | PARTS => 1.0,
            _ if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let at = |k: u32| rate(phase.t_start + h * f64::from(k));
        (0..=PARTS).map(|k| weight(k) * at(k)).sum::<f64>() * h / 3.0
    });
    phases.sum()
}

/// Liouville: the product of the multipliers is exp ∫ div f dt, times at each crossing the ratio of
/// the accelerations after and before it.
#[test]
fn the_multipliers_of_fig_8_have_liouville_s_product() {
    let of = |id: &str| golden("fig08", "exact", &format!("fig08.{id}"));
    let model = ForcedOscillator::default();
    let [_, left, _] = last_references()[..] else {
        panic!("three crossings");
    };
    let (period, time) = (model.period(), left.0.rem_euclid(model.period()));
    // From a moment after the crossing, so that the crossings of one period lie inside.
    let start = State::from([left.1, model.belt_speed]);
    let orbit = solve(&model, time, start, time + 0.1, &Options::tol(1e-13)).unwrap();
    let start = (orbit.t_end, orbit.x_end);
    let orbit = solve(
        &model,
        start.0,
        start.1,
        start.0 + period,
        &Options::tol(1e-13),
    )
    .unwrap();
    assert_abs_diff_eq!((orbit.x_end - start.1).amax(), 0.0, epsilon = 1e-11);
    let ratios = orbit.transitions.iter().map(|at| {
        let (Mode::Slip(before), Mode::Slip(after)) = (at.from, at.to) else {
            panic!("{at:?}");
        };
        let [before, after] = [before, after].map(|side| model.field(side, at.t, at.x.as_ref())[1]);
        after / before
    });
    let ratios: Vec<f64> = ratios.collect();
    assert_eq!(ratios.len(), 2);
    let product = math::exp(divergence(&model, &orbit)) * ratios.iter().product::<f64>();
    let moduli = of("multiplier.modulus.1") * of("multiplier.modulus.2");
    assert_relative_eq!(product, moduli, max_relative = 1e-9);
}

/// States of an orbit at equal intervals.
struct States {
    from: f64,
    every: f64,
    states: Vec<State<4>>,
}

impl Observer<4> for States {
    fn step(&mut self, step: &StepRecord<4>) -> ControlFlow<()> {
        loop {
            let t = self.from + self.every * self.states.len() as f64;
            if t > step.t_end {
                return ControlFlow::Continue(());
            }
            self.states.push(step.dense.at_time(t));
        }
    }
}

/// λ1 of Fig. 12 by two neighbouring orbits (Benettin, Galgani & Strelcyn, 1976): no derivative, no
/// saltation. A companion starts beside the orbit at each multiple of a short time; the distance it
/// gains there gives the growth, and its direction the next companion.
#[test]
fn two_neighbouring_orbits_separate_with_the_first_exponent_of_fig_12() {
    const DISTANCE: f64 = 1e-6;
    const EVERY: f64 = 1.0;
    let (from, to) = (3000.0, 12_000.0);
    let model = BlockAndBracket::from_caption(&Caption::FIG12, &Interpretation::exact()).unwrap();
    let options = Options::tol(TOLERANCE);
    let mut orbit = States {
        from,
        every: EVERY,
        states: Vec::new(),
    };
    let start = State::from(Caption::FIG12.start);
    // In the same parts as the golden spectrum, so that the chaotic orbit is the same.
    let settled = run(&model, 0.0, start, from, &options, &mut ()).unwrap();
    let blocks = options.longest_step((to - from) / 20.0);
    run(&model, settled.t, settled.x, to, &blocks, &mut orbit).unwrap();
    let mut direction = State::from([0.5; 4]);
    let mut growth = 0.0;
    for pair in orbit.states.windows(2) {
        let companion = pair[0] + direction * DISTANCE;
        let end = run(&model, 0.0, companion, EVERY, &options, &mut ()).unwrap();
        let apart = end.x - pair[1];
        growth += math::ln(apart.norm() / DISTANCE);
        direction = apart / apart.norm();
    }
    let exponent = growth / (EVERY * (orbit.states.len() - 1) as f64);
    let published = 0.0025;
    let wanted = golden("fig12", "corrected/equations", "fig12.lambda.1");
    // The first direction settles within a factor of a hundred: ln(100)/9000.
    assert_abs_diff_eq!(exponent, wanted, epsilon = 5e-4);
    assert!(exponent > 4.0 * published, "{exponent}");
}
