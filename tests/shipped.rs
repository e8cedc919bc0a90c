//! The files that the program ships for the paper's models have the orbits of the models.

use replication::paper::models::{
    BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Reading,
};
use std::ops::ControlFlow;

use stickslip::dynamics::{OrbitProgress, OrbitUnderWay, Section};
use stickslip::{Filippov, Method, Options, State, solve};
use stickslip_kernels::file::SystemFile;
use stickslip_kernels::kernel::follow;

/// Largest difference, relative to values above 1.
fn apart(file: &[f64], model: &[f64]) -> f64 {
    let each = file.iter().zip(model);
    each.map(|(a, b)| (a - b).abs() / b.abs().max(1.0))
        .fold(0.0, f64::max)
}

/// Compares every transition and the end, to rounding.
fn assert_same<S: Filippov<N>, const N: usize>(name: &str, model: &S, t_end: f64) {
    let file = SystemFile::open(name).unwrap().with(&[]).unwrap();
    let x = &file.start().unwrap()[..];
    for method in [Method::Taylor, Method::Dop853] {
        let options = &Options::tol(1e-13).method(method);
        let orbit = solve(model, 0.0, State::from_fn(|i, _| x[i]), t_end, options).unwrap();
        assert!(orbit.transitions.len() >= 4, "{name}");
        let mut seen = Vec::new();
        let mut watcher = |progress, _: &mut dyn OrbitUnderWay| {
            if let OrbitProgress::Transition(at) = progress {
                seen.push(at);
            }
            ControlFlow::Continue(())
        };
        let (dynamics, none) = (file.dynamics(), &Section::None);
        let end = follow(dynamics, (0.0, x), t_end, options, none, &mut watcher);
        let end = end.unwrap();
        assert_eq!(seen.len(), orbit.transitions.len(), "{name}, {method:?}");
        for (file, model) in seen.iter().zip(&orbit.transitions) {
            let what = format!("{name}, {method:?}: {file:?}, {model:?}");
            assert_eq!(
                (file.kind, file.contact),
                (model.kind, model.contact),
                "{what}"
            );
            assert!(apart(&[file.t], &[model.t]) <= 1e-12, "{what}");
            assert!(
                apart(file.x.as_slice(), model.x.as_slice()) <= 1e-12,
                "{what}"
            );
        }
        let off = apart(end.x.as_slice(), orbit.x_end.as_slice());
        assert!(off <= 1e-12, "{name}, {method:?}: {off:e}");
    }
}

#[test]
fn the_three_files_are_the_three_models() {
    assert_same("belt", &BeltOscillator::default(), 50.0);
    assert_same("forced", &ForcedOscillator::default(), 10.0);
    let bracket = BlockAndBracket::from_caption(&Caption::FIG11, &Reading::exact()).unwrap();
    assert_same("bracket", &bracket, 130.0);
}
