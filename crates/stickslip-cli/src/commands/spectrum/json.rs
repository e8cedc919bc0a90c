//! Results of the analysis of a series, as JSON. JSON has neither infinity nor undefined numbers,
//! so both are `null`; `status` distinguishes them.

use serde_json::{Value, json};
use stickslip_series::{Balance, Divergence, DivergenceCurve, Neighbourhood, Statistics};

use super::findings::{Embedded, Findings, UNIT};
use crate::table::NumberTable;

pub(super) fn fields(findings: &Findings, source: &NumberTable, warnings: &[String]) -> Value {
    let spectrum = &findings.spectrum;
    let exponents = spectrum.exponents.iter().enumerate().map(|(i, exponent)| {
        json!({
            "index": i + 1,
            "exponent": exponent.value,
            "stderr": exponent.stderr,
            "eps_sensitivity": exponent.eps_sensitivity,
            "status": findings.status(i),
            "fixed_rank": exponent.fixed_rank.map(|(value, _)| value),
            "fixed_rank_stderr": exponent.fixed_rank.map(|(_, stderr)| stderr),
            "collapses": exponent.collapses,
            "undetermined": exponent.undetermined,
            "sano_sawada": exponent.sano_sawada.0,
            "sano_sawada_stderr": exponent.sano_sawada.1,
        })
    });
    let directions = spectrum
        .directions
        .iter()
        .map(|direction| json!({ "kind": direction.kind.word(), "slope": direction.slope }));
    let settings = &spectrum.settings;
    let (eps, min, max) = match settings.neighbours {
        Neighbourhood::Ball { eps, min, max } => (Some(eps), min, max),
        Neighbourhood::Nearest(k) => (None, k, k),
    };
    let statistics =
        |one: &Statistics| json!({ "residual_ratio": one.residual, "exponent": one.exponent });
    json!({
        "settings": {
            "estimator": settings.estimator.words(),
            "dt": source.dt,
            "columns": source.names,
            "eps": eps,
            "min_neighbours": min,
            "max_neighbours": max,
            "theiler": settings.theiler,
            "step": settings.step,
            "affine": settings.affine,
            "rank_tolerance": settings.rank_tolerance,
            "ridge": settings.ridge,
            "fixed_rank": settings.fixed_rank,
            "stride": settings.stride,
            "references": settings.references,
        },
        "unit": UNIT,
        "exponents": exponents.collect::<Value>(),
        "sum": spectrum.sum.0,
        "sum_stderr": spectrum.sum.1,
        "balance": findings.balance.as_ref().map(|(_, found)| balance(found)),
        "sizes": spectrum.sizes.as_ref().map(|sizes| json!({
            "degree": sizes.degree.word(),
            "neighbours": sizes.neighbours,
            "radius": sizes.radius,
        })),
        "dimension": spectrum.dimension,
        "directions": directions.collect::<Value>(),
        "neighbourhoods": {
            "spread": spectrum.spread,
            "mean_eps": spectrum.mean_eps,
            "min": spectrum.neighbours.min,
            "median": spectrum.neighbours.median,
            "max": spectrum.neighbours.max,
            "starved": spectrum.starved,
        },
        "residual_ratio": spectrum.residual_ratio,
        "embedding": findings.embedded.as_ref().map(embedding),
        "diverging_neighbours": findings.divergence.as_ref().map(diverging),
        "surrogates": findings.surrogates.as_ref().map(|test| json!({
            "p": test.p,
            "is_significant": test.is_significant(),
            "series": statistics(&test.series),
            "surrogates": test.surrogates.iter().map(statistics).collect::<Value>(),
        })),
        "grid": source.grid().map(|grid| json!({
            "column": source.names[grid.column],
            "values": grid.values,
            "step": grid.step,
        })),
        "warnings": warnings,
        "notes": findings.notes(source),
    })
}

fn balance(balance: &Balance) -> Value {
    match *balance {
        Balance::Whole {
            excess,
            stderr,
            agrees,
        } => json!({ "excess": excess, "stderr": stderr, "agrees": agrees }),
        Balance::Rest {
            exponents,
            sum,
            stderr,
        } => json!({ "others": exponents, "sum_of_others": sum, "stderr": stderr }),
        Balance::Unknown => Value::Null,
    }
}

fn embedding(embedded: &Embedded) -> Value {
    let choice = &embedded.choice;
    let dimensions = choice.dimensions.iter().map(|one| {
        json!({
            "dimension": one.dimension,
            "false_neighbours": one.false_neighbours,
            "cao_e1": one.e1,
            "cao_e2": one.e2,
        })
    });
    let origins = embedded.reversal.origins.iter();
    json!({
        "delay": choice.embedding.delay,
        "delay_reason": choice.delay_reason.words(),
        "dimension": choice.embedding.dimension,
        "dimension_reason": choice.dimension_reason.words(),
        "cao_dimension": choice.cao,
        "mutual_information": choice.information,
        "dimensions": dimensions.collect::<Value>(),
        "reversal_is_conclusive": embedded.reversal.is_conclusive,
        "origins": origins.map(|origin| origin.word()).collect::<Value>(),
    })
}

fn diverging(divergence: &Divergence) -> Value {
    let estimate = |exponent: Option<(f64, f64)>| {
        exponent.map(|(value, stderr)| json!({ "exponent": value, "stderr": stderr }))
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
        "rosenstein": estimate(divergence.by_rosenstein()),
        "kantz": estimate(divergence.by_kantz()),
        "rosenstein_curve": curve(&divergence.rosenstein),
        "kantz_curves": divergence.kantz.iter().map(curve).collect::<Value>(),
    })
}
