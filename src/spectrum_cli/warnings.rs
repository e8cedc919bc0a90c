//! What makes a spectrum doubtful.

use std::f64::consts::PI;

use super::balance;
use super::findings::Findings;
use super::read::Table;
use super::report::short;
use stickslip::analysis::data_spectrum::{
    DataExponent, DataSpectrum, Degree, Estimator, Neighbourhood, Sizes, Status,
};

/// With a larger part of the reference points starved there is a warning.
const STARVED: f64 = 0.1;
/// Values that are drawn from an attractor nearly all differ; with fewer different ones than this part they lie on a grid.
const DIFFERENT: f64 = 0.5;
/// With a larger part of the states the same as those before them there is a warning.
const STANDING: f64 = 0.01;
/// Reference points that reach over fewer Theiler windows are one short piece of an orbit, of which `ok` was found to be worth less.
const WINDOWS: usize = 2;
/// Times the mean distance of two values that fill a turn evenly, by which the turn's ends may be missed,
const NEAR_ENDS: f64 = 20.0;
/// but by no more than this part of the turn.
const FARTHEST_END: f64 = 0.01;
/// The two fits disagree where they differ by more than so many standard errors of the difference.
const COMBINED_ERRORS: f64 = 4.0;

/// What makes the spectrum doubtful, each with its remedy.
pub fn warnings(findings: &Findings, source: &Table) -> Vec<String> {
    let spectrum = &findings.spectrum;
    let mut warnings = counting(source);
    // Whatever else there is to say follows from it.
    if findings.is_noise() {
        warnings.push(
            "Cao's E2 is 1 with any number of delayed values: the next value does not depend on those before, as in noise".into(),
        );
    }
    let part = spectrum.starved as f64 / spectrum.references as f64;
    if part > STARVED {
        let remedy = match (spectrum.settings.neighbours, &spectrum.sizes) {
            (Neighbourhood::Ball { min, .. }, Some(sizes)) => {
                let [few, _] = sizes.neighbours;
                format!(
                    "there the {few} nearest points, the smaller neighbourhood, reach farther than 1.5 --eps, on average to {} of the spread: give more \
                     points{} (a larger --eps would take the same ones and only remove this warning)",
                    short(sizes.radius[0] / spectrum.spread),
                    if few == min {
                        " or fewer --neighbours"
                    } else {
                        ""
                    }
                )
            }
            (Neighbourhood::Ball { min, max, .. }, None) => format!(
                "the ball held fewer than {min} neighbours and the nearest {min} were taken; mean eps is {} of the spread: give {}",
                short(spectrum.mean_eps / spectrum.spread),
                if max > min {
                    "a larger --eps, fewer --neighbours, or more points"
                } else {
                    "more points or fewer --neighbours (a larger --eps would take the same neighbours and only remove this warning)"
                }
            ),
            (Neighbourhood::Nearest(k), _) => {
                format!(
                    "there are no {k} neighbours: give fewer --neighbours, a smaller --theiler, or more points"
                )
            }
        };
        warnings.push(format!(
            "{} of {} reference points are starved: {remedy}",
            spectrum.starved, spectrum.references
        ));
    }
    let indices = |status: Status| -> Option<(String, &str)> {
        let with_status = (1..).zip(&spectrum.exponents);
        let found: Vec<String> = with_status
            .filter(|(_, exponent)| exponent.status == status)
            .map(|(i, _): (usize, _)| i.to_string())
            .collect();
        match &found[..] {
            [] => None,
            [one] => Some((format!("exponent {one}"), "is")),
            more => Some((format!("exponents {}", more.join(", ")), "are")),
        }
    };
    if let Some((which, are)) = indices(Status::Unpredictable) {
        warnings.push(format!(
            "the maps do not predict the next state (residual ratio {}, 1 is noise), so that {which} {are} none of a deterministic \
             system: give all columns of the state, or for noisy data more --neighbours",
            short(spectrum.residual_ratio)
        ));
    }
    if let Some((which, are)) = indices(Status::Noisy) {
        warnings.push(format!(
            "{which} {are} noisy: noise of the size of what the maps leave unpredicted may flatten them by more than two errors: give more \
             --neighbours, values with less noise, or a longer --step"
        ));
    }
    if let Some((which, are)) = indices(Status::Undetermined) {
        warnings.push(format!(
            "{which} {are} undetermined: at more than 1 % of the reference points the neighbours do not determine the maps that are \
             extrapolated, as where values lie on a grid: give values with more digits, more points, or more --neighbours"
        ));
    }
    warnings.extend(on_a_grid(source).map(|(name, different)| {
        let annihilated = indices(Status::Annihilated).map_or(String::new(), |(which, are)| {
            format!(", and {which} {are} minus infinity, as neighbours that fall on one value look")
        });
        format!(
            "column {name} has only {different} different values, as rounded ones or those of few bits{annihilated}: stderr knows nothing of \
             what a grid hides; give values with more digits"
        )
    }));
    if let Some((which, are)) = indices(Status::Unstable) {
        let by = match spectrum.settings.estimator {
            Estimator::SanoSawada => "by more than four standard errors",
            Estimator::Extrapolated { .. } => {
                "or from linear maps to quadratic ones, by more than two statistical errors"
            }
        };
        // What is in use already is no remedy.
        let affine = if spectrum.settings.affine {
            ""
        } else {
            "--affine, "
        };
        let is_linear = |sizes: &Sizes| sizes.degree == Degree::Linear;
        let quadratic = if spectrum.sizes.as_ref().is_some_and(is_linear) {
            "--degree quadratic, "
        } else {
            ""
        };
        warnings.push(format!(
            "{which} {are} unstable, which is said of the estimate: it changes with the size of the neighbourhoods, {by} and 5 %, which is bias: try a \
             smaller --step, fewer --neighbours, {affine}{quadratic}or more points"
        ));
    }
    warnings.extend(disagreements(findings));
    let balance = findings.balance.as_ref();
    warnings.extend(
        balance.and_then(|(divergence, balance)| balance::warning(spectrum, *divergence, balance)),
    );
    warnings.extend(
        findings
            .embedded
            .iter()
            .flat_map(|embedded| embedded.warnings()),
    );
    warnings.extend(short_of_references(spectrum));
    warnings.extend(standing_still(findings, source));
    warnings.extend(repeated(source));
    warnings.extend(wrapped(source));
    warnings.extend(source.notes.iter().cloned());
    warnings
}

/// The first column whose values lie on a grid, and how many different ones it has. What repeats
/// itself or stands still is on none.
fn on_a_grid(source: &Table) -> Option<(&str, usize)> {
    if source.period().is_some() {
        return None;
    }
    let columns = source.names.len();
    source.names.iter().enumerate().find_map(|(column, name)| {
        let mut values: Vec<f64> = source
            .values
            .iter()
            .skip(column)
            .step_by(columns)
            .copied()
            .collect();
        values.dedup();
        let rows = values.len();
        values.sort_by(f64::total_cmp);
        values.dedup();
        ((values.len() as f64) < DIFFERENT * rows as f64).then_some((name.as_str(), values.len()))
    })
}

/// States that are the same as the ones before them.
fn standing_still(findings: &Findings, source: &Table) -> Option<String> {
    let embedded = findings.embedded.as_ref();
    let reach = embedded.map_or(0, |embedded| embedded.choice.embedding.span());
    let rows: Vec<&[f64]> = source.values.chunks(source.names.len().max(1)).collect();
    let stretches = rows.chunk_by(|one, next| one == next).map(<[_]>::len);
    let states: usize = stretches.map(|rows| rows.saturating_sub(reach + 1)).sum();
    (states as f64 > STANDING * rows.len() as f64).then(|| {
        format!(
            "{states} states are the same as those before them, as of a system that rests or of values that are held: no distance grows \
             there; leave them out"
        )
    })
}

/// A time or an index makes every point its own: it is no coordinate of a state.
fn counting(source: &Table) -> Vec<String> {
    let warn = |(column, step): (usize, f64)| {
        let others = source.names.iter().enumerate();
        let others: Vec<&str> = others
            .filter(|(other, _)| *other != column)
            .map(|(_, name)| name.as_str())
            .collect();
        let remedy = if others.is_empty() {
            "give the columns of the state with --columns".to_owned()
        } else {
            format!("leave it out with --columns {}", others.join(","))
        };
        format!(
            "column {} goes on evenly by {} from row to row, as a time or an index does, and is used as part of the state: {remedy}",
            source.names[column],
            short(step)
        )
    };
    source.even_columns().map(warn).collect()
}

/// Exponents that nothing else speaks against, but on which the two linear fits differ. One that is extrapolated is neither of them, and
/// its error is its own.
fn disagreements(findings: &Findings) -> Vec<String> {
    let spectrum = &findings.spectrum;
    if spectrum.sizes.is_some() {
        return Vec::new();
    }
    let warn = |(i, exponent): (usize, &DataExponent)| {
        let (value, stderr) = exponent.fixed_rank?;
        let difference = value - exponent.value;
        let variance = stderr * stderr + exponent.stderr * exponent.stderr;
        let far = difference * difference > COMBINED_ERRORS * COMBINED_ERRORS * variance;
        (findings.status(i - 1) == Status::Ok.word() && far).then(|| {
            format!(
                "exponent {i}: the fit of rank {} gives {} instead of {}; the two disagree: treat both as uncertain by their \
                 difference",
                spectrum.fixed_rank,
                short(value),
                short(exponent.value)
            )
        })
    };
    (1..).zip(&spectrum.exponents).filter_map(warn).collect()
}

/// Reference points that lie on too short a piece of an orbit.
fn short_of_references(spectrum: &DataSpectrum) -> Option<String> {
    let settings = &spectrum.settings;
    let chains = settings.step.div_ceil(settings.stride);
    let reach = spectrum
        .references
        .div_ceil(chains)
        .saturating_mul(settings.step);
    let wanted = settings.theiler.unwrap_or(0).saturating_mul(WINDOWS);
    (reach < wanted).then(|| {
        format!(
            "the {} reference points reach over {reach} points, less than {WINDOWS} Theiler windows, which are {wanted}: of so short a piece of an \
             orbit even ok is worth less; give {} --references or more",
            spectrum.references,
            wanted.div_ceil(settings.step).saturating_mul(chains)
        )
    })
}

/// Every row that was read comes again.
fn repeated(source: &Table) -> Option<String> {
    source.period().map(|period| {
        format!(
            "every row comes again {period} rows later: the series holds {period} different states, between which it tells nothing, however \
             long it is; of a periodic motion take a time step that does not go into the period, of a map this is its cycle"
        )
    })
}

/// Columns whose values fill a whole turn and jump by more than half of it: an angle that is taken back by a turn tears neighbours apart.
fn wrapped(source: &Table) -> Option<String> {
    const TURNS: [(f64, &str); 2] = [(2.0 * PI, "2π"), (360.0, "360")];
    let rows = source.values.len() / source.names.len().max(1);
    source.names.iter().enumerate().find_map(|(column, name)| {
        let values = || source.values.iter().skip(column).step_by(source.names.len());
        let low = values().copied().fold(f64::INFINITY, f64::min);
        let high = values().copied().fold(f64::NEG_INFINITY, f64::max);
        // Of so many values the least and the largest are about so near the ends of the turn.
        let gap = (NEAR_ENDS / rows as f64).min(FARTHEST_END);
        let (_, turn) = TURNS
            .iter()
            .find(|(turn, _)| (1.0 - gap..=1.0).contains(&((high - low) / turn)))?;
        let mut pairs = values().zip(values().skip(1));
        pairs.find(|(one, next)| (*one - *next).abs() > 0.5 * (high - low))?;
        Some(format!(
            "column {name} fills a whole turn of {turn}, as an angle does that is taken back by a turn: neighbours on either side of the jump are torn \
             apart, and ok is worth nothing: give the angle's sine and cosine instead"
        ))
    })
}
