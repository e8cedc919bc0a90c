//! The second opinion on the largest exponent: diverging neighbours, and surrogates.

use std::fmt::Write;

use serde_json::{Value, json};

use super::report::short;
use stickslip::analysis::data_spectrum::{Divergence, DivergenceCurve, Statistics, SurrogateTest};

/// The first random number of the surrogates, so that two runs find the same.
pub(super) const SEED: u64 = 19_920_901;

/// Two lines for the terminal.
pub(super) fn divergence_text(divergence: &Divergence) -> String {
    let opinion = |found: Option<(f64, f64)>| match found {
        Some((value, stderr)) => format!("{} ± {}", short(value), short(stderr)),
        None => "none, distances do not grow by a factor of e in a straight line".into(),
    };
    let part = |curve: &DivergenceCurve| match &curve.straight {
        Some(straight) => format!(
            " (scatter over blocks of points alone; straight from t = {} to {})",
            short(curve.points[straight.from].0),
            short(curve.points[straight.to].0)
        ),
        None => String::new(),
    };
    let mut text = String::from("Largest exponent by diverging neighbours, fitting no maps:\n");
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  Rosenstein  {}{}",
        opinion(divergence.by_rosenstein()),
        part(&divergence.rosenstein)
    );
    let _ = writeln!(text, "  Kantz       {}", opinion(divergence.by_kantz()));
    text
}

/// The outcome of the test for the terminal.
pub(super) fn surrogates_text(test: &SurrogateTest) -> String {
    let range = |of: fn(&Statistics) -> f64| {
        let values = test.surrogates.iter().map(of);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        format!(
            "{} to {}",
            short(low),
            short(values.fold(f64::NEG_INFINITY, f64::max))
        )
    };
    let verdict = if test.is_significant() {
        "the series is told from linear noise"
    } else {
        "the series is not told from linear noise: a positive exponent may be the noise's"
    };
    format!(
        "Surrogates (amplitude-adjusted, {}): {verdict}, p = {:.3}; unpredicted part {} against {}, first exponent {} against {}\n",
        test.surrogates.len(),
        test.p,
        short(test.series.residual),
        range(|one| one.residual),
        short(test.series.exponent),
        range(|one| one.exponent),
    )
}

/// For `--json`.
pub(super) fn divergence_json(divergence: &Divergence) -> Value {
    let opinion = |found: Option<(f64, f64)>| {
        found.map(|(value, stderr)| json!({ "exponent": value, "stderr": stderr }))
    };
    let curve = |curve: &DivergenceCurve| {
        json!({
            "radius": curve.radius,
            "references": curve.references,
            "curve": curve.points,
            "straight": curve.straight.as_ref().map(|straight| json!({
                "from": curve.points[straight.from].0,
                "to": curve.points[straight.to].0,
                "slope": straight.slope,
                "stderr": straight.stderr,
                "scatter": straight.scatter,
            })),
        })
    };
    json!({
        "rosenstein": opinion(divergence.by_rosenstein()),
        "kantz": opinion(divergence.by_kantz()),
        "rosenstein_curve": curve(&divergence.rosenstein),
        "kantz_curves": divergence.kantz.iter().map(curve).collect::<Vec<_>>(),
    })
}

/// For `--json`.
pub(super) fn surrogates_json(test: &SurrogateTest) -> Value {
    let statistics =
        |one: &Statistics| json!({ "residual_ratio": one.residual, "exponent": one.exponent });
    json!({
        "p": test.p,
        "is_significant": test.is_significant(),
        "series": statistics(&test.series),
        "surrogates": test.surrogates.iter().map(statistics).collect::<Vec<_>>(),
    })
}
