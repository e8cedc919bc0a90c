//! The files that the program ships for the paper's models have the orbits of the models.

use replication::paper::models::{
    BeltOscillator, BlockAndBracket, Caption, ForcedOscillator, Reading,
};
use stickslip::dynamics::Section;
use stickslip::{Filippov, Method, Options, State, solve};
use stickslip_kernels::file::SystemFile;
use stickslip_kernels::kernel::{Run, follow};

/// Followed through crossings and sticks, to rounding.
fn assert_same<S: Filippov<N>, const N: usize>(name: &str, model: &S, t_end: f64) {
    let file = SystemFile::open(name).unwrap().with(&[]).unwrap();
    let x = &file.start().unwrap()[..];
    for method in [Method::Taylor, Method::Dop853] {
        let options = &Options::tol(1e-13).method(method);
        let orbit = solve(model, 0.0, State::from_fn(|i, _| x[i]), t_end, options).unwrap();
        assert!(orbit.transitions.len() >= 4, "{name}");
        let t = 0.0;
        let run = Run {
            t,
            x,
            t_end,
            options,
        };
        let end = follow(file.dynamics(), &run, &Section::None, &mut ()).unwrap();
        let apart = end.x.iter().zip(&orbit.x_end).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 1e-12, "{name}, {method:?}");
    }
}

#[test]
fn the_three_files_are_the_three_models() {
    assert_same("belt", &BeltOscillator::default(), 50.0);
    assert_same("forced", &ForcedOscillator::default(), 10.0);
    let bracket = BlockAndBracket::from_caption(&Caption::FIG11, &Reading::exact()).unwrap();
    assert_same("bracket", &bracket, 130.0);
}
