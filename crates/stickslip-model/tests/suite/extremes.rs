//! Minimum and maximum of the states along an orbit.

use stickslip::Options;
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::study::extremes;

#[test]
fn a_maximum_inside_a_step_is_found_to_rounding() {
    // A parabola with its maximum of 2 at 0.3.
    let text = "name = \"parabola\"\n[states]\nx = \"\"\n[field]\nx = \"2*(0.3 - t)\"\n";
    let (name, text) = ("parabola.toml".to_owned(), text.to_owned());
    let file = SystemFile::parse(Source { name, text }).unwrap();
    let system = file.with(&[]).unwrap();
    let (x, options) = ([2.0 - 0.3 * 0.3], Options::default());
    let (ranges, end) = extremes(system.dynamics(), (0.0, &x), 1.0, &options).unwrap();
    let [(lowest, highest)] = ranges[..] else {
        panic!("one state")
    };
    assert!((highest - 2.0).abs() <= 2.0 * f64::EPSILON, "{highest:e}");
    assert_eq!(lowest, end.x[0]);
}
