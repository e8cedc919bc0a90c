//! Warnings about a spectrum: reasons for doubt, automatic choices, and options without effect.

use std::f64::consts::PI;

use stickslip::error::readable;
use stickslip_series::{
    Balance, DataSpectrum, Degree, DimensionReason, Estimator, Neighbourhood, Status,
};

use super::Arguments;
use super::findings::{Findings, numbers, short};
use crate::table::NumberTable;

/// A warning is issued if a larger fraction of the reference points has too few neighbours.
const STARVED_FRACTION: f64 = 0.1;
/// A warning is issued if a larger fraction of the states equals the state before.
const REPEATED_FRACTION: f64 = 0.01;
/// Reference points that cover fewer Theiler windows form one short piece of an orbit. The status
/// `ok` is less reliable there.
const LEAST_WINDOWS: usize = 2;
/// Tolerance for the two ends of a full turn, in mean distances between neighbouring values.
/// Uniformly distributed values exceed it with probability 4e-8 (21 exp(−20)).
const MISSED_ENDS: f64 = 20.0;
/// Maximum tolerance as a fraction of the turn. Ranges of other quantities come as close to a turn
/// by chance.
const MISSED_PART: f64 = 0.01;
/// The two fits disagree if they differ by more than this many standard errors of the difference.
const COMBINED_ERRORS: f64 = 4.0;

/// All warnings, each with its remedy.
pub(super) fn all(findings: &Findings, source: &NumberTable, arguments: &Arguments) -> Vec<String> {
    let spectrum = &findings.spectrum;
    let mut warnings = counting(source);
    // All other warnings would follow from this one.
    if findings.is_noise() {
        warnings.push(
            "Cao's E2 is 1 with any number of delayed values: the next value does not depend on \
                those before, as in noise"
                .into(),
        );
    }
    warnings.extend(starved(spectrum));
    warnings.extend(with_status(spectrum, Status::Unpredictable).map(|which| format!(
        "the maps do not predict the next state (residual ratio {}, 1 is noise), so that {which} \
         none of a deterministic system: give all columns of the state, or for noisy data more \
         --neighbours",
        short(spectrum.residual_ratio)
    )));
    warnings.extend(with_status(spectrum, Status::WithoutZero).map(|which| {
        format!(
            "{which} without a zero beside: the rows follow a flow, which has an exponent 0 along \
             itself, and none is near it: give all columns of the state, more points, or \
             --dimension with more delayed values; of a map this needs no remedy"
        )
    }));
    warnings.extend(with_status(spectrum, Status::Noisy).map(|which| format!(
        "{which} noisy: noise of the size of what the maps leave unpredicted may flatten them by \
         more than two errors: give more --neighbours, values with less noise, or a longer --step"
    )));
    warnings.extend(with_status(spectrum, Status::Undetermined).map(|which| {
        format!(
            "{which} undetermined: at more than 1 % of the reference points the neighbours do not \
         determine the maps that are extrapolated, as where values lie on a grid: give values with \
         more digits, more points, or more --neighbours"
        )
    }));
    warnings.extend(on_a_grid(spectrum, source));
    warnings.extend(unstable(spectrum));
    warnings.extend(disagreements(findings));
    warnings.extend(unbalanced(findings));
    warnings.extend(embedding(findings));
    warnings.extend(short_of_references(spectrum));
    warnings.extend(standing_still(findings, source));
    warnings.extend(source.period().map(|period| format!(
        "every row comes again {period} rows later: the series holds {period} different states, \
         and says nothing of others, however long it is; of a periodic motion take a time step \
         that does not go into the period, of a map this is its cycle"
    )));
    warnings.extend(wrapped(source));
    warnings.extend(source.notes.iter().cloned());
    warnings.extend(without_effect(arguments, findings));
    warnings
}

/// The exponents of a status, with the matching verb form.
fn with_status(spectrum: &DataSpectrum, status: Status) -> Option<String> {
    let exponents = spectrum.exponents.iter();
    let indices = numbers(exponents.map(|exponent| exponent.status == status));
    match &indices[..] {
        [] => None,
        [one] => Some(format!("exponent {one} is")),
        more => Some(format!("exponents {} are", more.join(", "))),
    }
}

fn starved(spectrum: &DataSpectrum) -> Option<String> {
    let (starved, references) = (spectrum.starved, spectrum.references);
    if starved as f64 / references as f64 <= STARVED_FRACTION {
        return None;
    }
    let remedy = match (spectrum.settings.neighbours, &spectrum.sizes) {
        (Neighbourhood::Ball { min, .. }, Some(sizes)) => {
            let [few, _] = sizes.neighbours;
            format!(
                "there the {few} nearest points, the smaller neighbourhood, reach farther than 1.5 \
                 --eps, on average to {} of the spread: give more points{} (a larger --eps would \
                 take the same ones and only remove this warning)",
                short(sizes.radius[0] / spectrum.spread),
                if few == min {
                    " or fewer --neighbours"
                } else {
                    ""
                }
            )
        }
        (Neighbourhood::Ball { min, max, .. }, None) => format!(
            "the ball held fewer than {min} neighbours and the nearest {min} were taken; mean eps \
                is {} of the spread: give {}",
            short(spectrum.mean_eps / spectrum.spread),
            if max > min {
                "a larger --eps, fewer --neighbours, or more points"
            } else {
                "more points or fewer --neighbours (a larger --eps would take the same neighbours \
                    and only remove this warning)"
            }
        ),
        (Neighbourhood::Nearest(k), _) => format!(
            "there are no {k} neighbours: give fewer --neighbours, a smaller --theiler, or more \
                points"
        ),
    };
    Some(format!(
        "{starved} of {references} reference points are starved: {remedy}"
    ))
}

/// Warning about the first column whose values lie on a grid.
fn on_a_grid(spectrum: &DataSpectrum, source: &NumberTable) -> Option<String> {
    let grid = source.grid()?;
    let step = grid.step.map_or(String::new(), |step| {
        format!(", on a grid of {}", readable(step))
    });
    let annihilated = with_status(spectrum, Status::Annihilated).map_or(String::new(), |which| {
        format!(", and {which} minus infinity, as neighbours that fall on one value look")
    });
    Some(format!(
        "column {} has only {} different values{step}, as rounded ones or those of few \
         bits{annihilated}: the rounding acts as noise of 0.3 of that distance, which stderr \
         does not include; give values with more digits",
        source.names[grid.column], grid.values
    ))
}

fn unstable(spectrum: &DataSpectrum) -> Option<String> {
    let which = with_status(spectrum, Status::Unstable)?;
    let by = match spectrum.settings.estimator {
        Estimator::SanoSawada => "by more than four standard errors",
        Estimator::Extrapolated { .. } => {
            "or from linear maps to quadratic ones, by more than two statistical errors"
        }
    };
    // An option that is in use already is not suggested.
    let affine = if spectrum.settings.affine {
        ""
    } else {
        "--affine, "
    };
    let quadratic = match &spectrum.sizes {
        Some(sizes) if sizes.degree == Degree::Linear => "--degree quadratic, ",
        _ => "",
    };
    Some(format!(
        "{which} unstable, which concerns the estimate: it changes with the size of the \
         neighbourhoods, {by} and 5 %, which is bias: try a smaller --step, fewer --neighbours, \
         {affine}{quadratic}or more points"
    ))
}

/// Warning about a sum of exponents that differs from the divergence.
fn unbalanced(findings: &Findings) -> Option<String> {
    let (divergence, balance) = findings.balance?;
    let Balance::Whole {
        excess,
        stderr,
        agrees: false,
    } = balance
    else {
        return None;
    };
    Some(format!(
        "the exponents add up to {}, which is {} ± {} from the divergence {}: the columns are not \
         the state, --dt is not the time between two lines, or one of the exponents is off: try \
         more points or a smaller --step",
        short(findings.spectrum.sum.0),
        short(excess),
        short(stderr),
        short(divergence)
    ))
}

/// Warnings about an embedding.
fn embedding(findings: &Findings) -> Vec<String> {
    let mut warnings = Vec::new();
    let Some(embedded) = &findings.embedded else {
        return warnings;
    };
    let choice = &embedded.choice;
    if choice.dimension_reason == DimensionReason::FewestFalse {
        warnings.push(format!(
            "at least 1 % of the nearest neighbours are false with any number of delayed values up \
             to {}: noise, or more dimensions than that: give a filtered series, more columns, or \
             --dimension",
            choice.dimensions.len()
        ));
    }
    if embedded.is_spurious(0) {
        warnings.push(format!(
            "exponent 1 comes from the embedding, not from the system: try --dimension {}",
            choice.embedding.dimension.saturating_sub(1)
        ));
    }
    warnings
}

/// Warning about states that equal the state before.
fn standing_still(findings: &Findings, source: &NumberTable) -> Option<String> {
    let embedded = findings.embedded.as_ref();
    let reach = embedded.map_or(0, |embedded| embedded.choice.embedding.span());
    let rows: Vec<&[f64]> = source.values.chunks(source.names.len().max(1)).collect();
    let stretches = rows.chunk_by(|one, next| one == next).map(<[_]>::len);
    let states: usize = stretches.map(|rows| rows.saturating_sub(reach + 1)).sum();
    (states as f64 > REPEATED_FRACTION * rows.len() as f64).then(|| {
        format!(
            "{states} states are the same as those before them, as of a system that rests or of \
             values that are held: no distance grows there; leave them out"
        )
    })
}

/// Warning about a column of times or indices. It never recurs, so it is no coordinate of a state.
fn counting(source: &NumberTable) -> Vec<String> {
    let warn = |(column, step): (usize, f64)| {
        let others = source.names.iter().enumerate();
        let others: Vec<&str> = others
            .filter(|(other, _)| *other != column)
            .map(|(_, name)| name.as_str())
            .collect();
        let remedy = match &others[..] {
            [] => "give the columns of the state with --columns".to_owned(),
            others => format!("leave it out with --columns {}", others.join(",")),
        };
        format!(
            "column {} goes on evenly by {} from row to row, as a time or an index does, and is \
                used as part of the state: {remedy}",
            source.names[column],
            short(step)
        )
    };
    source.even_columns().map(warn).collect()
}

/// Exponents without other warnings on which the two linear fits differ. An extrapolated exponent
/// is neither fit, and has an error of its own.
fn disagreements(findings: &Findings) -> Vec<String> {
    let spectrum = &findings.spectrum;
    if spectrum.sizes.is_some() {
        return Vec::new();
    }
    let exponents = spectrum.exponents.iter().enumerate();
    exponents
        .filter_map(|(i, exponent)| {
            let (value, stderr) = exponent.fixed_rank?;
            let difference = value - exponent.value;
            let variance = stderr * stderr + exponent.stderr * exponent.stderr;
            let far = difference * difference > COMBINED_ERRORS * COMBINED_ERRORS * variance;
            (findings.is_ok(i) && far).then(|| {
                format!(
                    "exponent {}: the fit of rank {} gives {} instead of {}; the two disagree: \
                     treat both as uncertain by their difference",
                    i + 1,
                    spectrum.fixed_rank,
                    short(value),
                    short(exponent.value)
                )
            })
        })
        .collect()
}

/// Warning about reference points on too short a piece of an orbit.
fn short_of_references(spectrum: &DataSpectrum) -> Option<String> {
    let (settings, references) = (&spectrum.settings, spectrum.references);
    let chains = settings.step.div_ceil(settings.stride);
    let reach = references.div_ceil(chains).saturating_mul(settings.step);
    let wanted = settings.theiler.unwrap_or(0).saturating_mul(LEAST_WINDOWS);
    (reach < wanted).then(|| {
        format!(
            "the {references} reference points reach over {reach} points, less than \
             {LEAST_WINDOWS} Theiler windows, which are {wanted}: of so short a piece of an orbit \
             even ok is worth less; give {} --references or more",
            wanted.div_ceil(settings.step).saturating_mul(chains)
        )
    })
}

/// Warning about columns whose values fill a full turn and jump by more than half of it. Wrapping
/// an angle separates neighbours.
fn wrapped(source: &NumberTable) -> Option<String> {
    const TURNS: [(f64, &str); 2] = [(2.0 * PI, "2π"), (360.0, "360")];
    let gap = (MISSED_ENDS / source.rows() as f64).min(MISSED_PART);
    source.names.iter().enumerate().find_map(|(column, name)| {
        let (low, high) = source.range(column);
        let fills = |turn: f64| (1.0 - gap..=1.0).contains(&((high - low) / turn));
        let (_, turn) = TURNS.iter().find(|(turn, _)| fills(*turn))?;
        let values = || source.column(column);
        let mut pairs = values().zip(values().skip(1));
        pairs.find(|(one, next)| (*one - *next).abs() > 0.5 * (high - low))?;
        Some(format!(
            "column {name} fills a whole turn of {turn}, as an angle does that is taken back by a \
             turn: neighbours on either side of the jump are torn apart, and ok is worth nothing: \
             give the angle's sine and cosine instead"
        ))
    })
}

/// Options without effect, each with an option that would have one.
fn without_effect(arguments: &Arguments, findings: &Findings) -> Vec<String> {
    let spectrum = &findings.spectrum;
    let mut notes = Vec::new();
    // If minimum and maximum are equal, the neighbours are that many nearest points, in the
    // extrapolation and in Eq. (25), and the radius has no effect on them. With a range of numbers,
    // the radius decides how many neighbours there are and where chains begin.
    if let (Some(_), Neighbourhood::Ball { min, max, .. }) =
        (arguments.eps, spectrum.settings.neighbours)
        && min == max
    {
        let range = format!(
            "a range such as --neighbours {min}-{}",
            max.saturating_mul(2)
        );
        notes.push(match spectrum.sizes {
            Some(_) => format!(
                "--eps changes no extrapolated exponent, which comes from nearest points, however \
                 far; it only says which points are called starved: give other --neighbours than \
                 {min}, or --estimator sano-sawada with {range}"
            ),
            None => format!(
                "--eps changes no neighbour where the fewest and the most are both {min}; it only \
                 says which points are called starved: give {range}"
            ),
        });
    }
    let is_delayed = findings.embedded.is_some();
    if let Some(delay) = arguments.delay.filter(|_| !is_delayed) {
        notes.push(if arguments.dimension == Some(1) {
            format!(
                "--delay {delay} changes nothing with --dimension 1, which takes the columns as \
                 they are: give --dimension 2 or more, or leave it out"
            )
        } else {
            format!(
                "--delay {delay} changes nothing, as less than 1 % of the nearest neighbours are \
                 false without delayed values: give --dimension 2 or more, or leave it out"
            )
        });
    }
    let there = spectrum.references;
    if let Some(asked) = arguments.references.filter(|&asked| asked > there) {
        notes.push(format!(
            "--references {asked} changes nothing: there are {there}, and all are used"
        ));
    }
    let is_extrapolated = spectrum.sizes.is_some();
    let idle = [
        (
            arguments.degree.is_some() && !is_extrapolated,
            "--degree changes nothing where nothing is extrapolated: the maps of Eqs. (25) and \
                (26) are linear",
        ),
        (
            arguments.ridge > 0.0 && is_extrapolated,
            "--ridge changes no extrapolated exponent, only the fits of Eq. (25) beside it: give \
                --estimator sano-sawada, or leave it out",
        ),
        (
            arguments.affine && is_delayed,
            "--affine changes nothing with delayed values, whose maps are affine anyway",
        ),
        (
            arguments.divergence.is_some() && is_delayed,
            "--divergence changes nothing with delayed values, some of whose exponents may be none \
                of the system's",
        ),
    ];
    notes.extend(
        idle.iter()
            .filter(|(is_idle, _)| *is_idle)
            .map(|(_, note)| (*note).to_owned()),
    );
    notes
}
