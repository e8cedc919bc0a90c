//! Settings of the estimator: those of the search, and those that a reader of Eq. (25) could
//! choose.

use crate::text::joined;
use stickslip_series::{DataSettings, Neighbourhood};

/// Unit of the radius of a ball of neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// The signal's spread `√Σ var`.
    Spread,
    /// The variables' own unit.
    Absolute,
    /// The range of each column, which is scaled by it.
    Ranges,
}

/// Settings of the estimator, with the unit of the radius of balls.
pub type Setting = (Unit, DataSettings);

/// Maximum number of neighbours in a ball of a tenth of the spread.
const MAX_NEIGHBOURS: usize = 400;

/// Reference points from the whole series, so far apart that each map begins where the previous one
/// ends. The search varies the neighbourhoods itself and needs no second estimate of each.
pub fn everywhere(step: usize) -> DataSettings {
    DataSettings {
        step,
        stride: step,
        references: None,
        sensitivity: false,
        ..DataSettings::sano_sawada()
    }
}

/// Settings with 12 to `max` neighbours in a ball of radius `eps`.
pub fn settings(eps: f64, max: usize, step: usize, affine: bool) -> DataSettings {
    DataSettings {
        neighbours: ball(eps, 12, max),
        step,
        affine,
        ..everywhere(step)
    }
}

/// Settings with radii in units of the spread.
pub fn with_spread_unit(settings: Vec<DataSettings>) -> Vec<Setting> {
    let all = settings.into_iter();
    all.map(|one| (Unit::Spread, one)).collect()
}

/// The settings that compete.
pub fn search_settings() -> Vec<Setting> {
    let ridge = |ridge, settings| DataSettings { ridge, ..settings };
    let mut all = with_spread_unit(vec![
        settings(0.02, 40, 5, false),
        settings(0.05, 100, 1, true),
        ridge(1e-6, settings(0.05, 100, 3, false)),
        ridge(1e-3, settings(0.05, 100, 3, true)),
        settings(0.1, MAX_NEIGHBOURS, 1, false),
        settings(0.1, MAX_NEIGHBOURS, 3, true),
        ridge(1e-2, settings(0.1, MAX_NEIGHBOURS, 3, true)),
        // A thousand reference points: λ2 of Fig. 10 looks like a transient of that length.
        settings(0.02, 40, 45, false),
        // Consecutive reference points: all of them, and the first thousand.
        DataSettings {
            stride: 1,
            ..settings(0.05, 100, 3, false)
        },
        DataSettings {
            references: Some(1000),
            ..settings(0.1, MAX_NEIGHBOURS, 1, false)
        },
    ]);
    all.extend([
        (Unit::Absolute, settings(0.2, MAX_NEIGHBOURS, 1, true)),
        (Unit::Absolute, settings(0.05, 100, 3, false)),
        (Unit::Ranges, settings(0.1, MAX_NEIGHBOURS, 3, true)),
    ]);
    all
}

/// The name of settings in the table.
pub fn settings_name((unit, settings): &Setting) -> String {
    let unit = match unit {
        Unit::Spread => "",
        Unit::Absolute => " absolute",
        Unit::Ranges => " of ranges",
    };
    let neighbours = match settings.neighbours {
        Neighbourhood::Ball { eps, min, max } => format!("eps={eps}{unit} neighbours={min}-{max}"),
        Neighbourhood::Nearest(k) => format!("nearest={k}"),
    };
    let fit = if settings.affine { "affine" } else { "linear" };
    let or = |value: Option<usize>, none: &str| value.map_or(none.to_owned(), |v| v.to_string());
    let DataSettings {
        step,
        stride,
        ridge,
        rank_tolerance,
        ..
    } = settings;
    let [theiler, rank] = [settings.theiler, settings.fixed_rank].map(|one| or(one, "auto"));
    let references = or(settings.references, "all");
    format!(
        "{neighbours} d={step} stride={stride} {fit} ridge={ridge:e} theiler={theiler} rank={rank} \
            rank-tolerance={rank_tolerance:e} references={references}"
    )
}

/// Neighbourhoods by count and by radius, none so small that it starves. A radius is a fraction of
/// the signal's spread.
const NEIGHBOURHOODS: [Neighbourhood; 5] = [
    Neighbourhood::Nearest(12),
    Neighbourhood::Nearest(40),
    Neighbourhood::Nearest(120),
    ball(0.1, 12, MAX_NEIGHBOURS),
    ball(0.2, 40, 2 * MAX_NEIGHBOURS),
];

const fn ball(eps: f64, min: usize, max: usize) -> Neighbourhood {
    Neighbourhood::Ball { eps, min, max }
}

/// `d` of Eq. (25).
const STEPS: [usize; 3] = [1, 3, 5];
/// Regularization of the inverse in Eq. (25).
const RIDGES: [f64; 2] = [0.0, 1e-3];

/// Reasonable choices of a reader of Eq. (25): all combinations of neighbourhoods, steps and
/// regularization, with affine maps and reference points from the whole series.
pub fn spread_settings() -> Vec<DataSettings> {
    let of = |neighbours: Neighbourhood, step, ridge| DataSettings {
        neighbours,
        ridge,
        affine: true,
        ..everywhere(step)
    };
    let steps = |neighbours| {
        let ridges = move |step| RIDGES.map(move |ridge| of(neighbours, step, ridge));
        STEPS.into_iter().flat_map(ridges)
    };
    NEIGHBOURHOODS.into_iter().flat_map(steps).collect()
}

/// The settings of [`spread_settings`] in words.
pub fn spread_in_words() -> String {
    let (mut nearest, mut balls) = (Vec::new(), Vec::new());
    for one in NEIGHBOURHOODS {
        match one {
            Neighbourhood::Nearest(k) => nearest.push(k),
            Neighbourhood::Ball { eps, min, max } => {
                balls.push(format!("eps {eps} with {min} to {max}"));
            }
        }
    }
    let (nearest, balls) = (joined(nearest, ", "), joined(balls, ", "));
    let (steps, ridges) = (joined(STEPS, ", "), joined(RIDGES, ", "));
    format!("the nearest {nearest} neighbours or {balls}; d = {steps}; ridge {ridges}; affine maps")
}
