//! Tangent points and stick zones on the boundary of a contact.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip::{Side, Visibility};
use stickslip_model::study::tangents::{BoundaryLine, LineResults, TangentPoint, ZoneKind};

use super::Start;
use crate::System;
use crate::errors::wrong;
use crate::fields::Fields;

/// Tangent points and zones on the boundary of a contact, along a state, or along the first one
/// that the equation of the boundary leaves free.
#[pyfunction]
pub(crate) fn tangents<'py>(
    py: Python<'py>,
    system: &System,
    start: Start,
    contact: usize,
    along: Option<usize>,
    bounds: Option<(f64, f64)>,
) -> PyResult<Bound<'py, PyDict>> {
    let compiled = &system.compiled;
    let ((t, x), whole) = (start, (f64::NEG_INFINITY, f64::INFINITY));
    let line = BoundaryLine::through(compiled, contact, along, whole, (t, &x)).ok_or_else(|| {
        wrong(
            "there is no line to search along: the boundary must change with one state and leave \
             another one free",
        )
    })?;
    let state = &compiled.file.states[line.along];
    let range = bounds.or(state.range).ok_or_else(|| {
        wrong(format!(
            "the range of {name} is missing: give bounds=(lowest, highest) of {name}",
            name = state.name
        ))
    })?;
    let line = BoundaryLine { range, ..line };
    let found = py.detach(|| line.scan(compiled));
    let fields = Fields::new(py);
    fields.put("along", &state.name)?;
    fields.put("solved", &compiled.file.states[line.solved].name)?;
    let points = || numbered(&found, |on_it| &on_it.points);
    let table = Fields::new(py);
    let side = |point: &TangentPoint| match point.side {
        Side::Below => "below",
        Side::Above => "above",
    };
    let visibility = |point: &TangentPoint| match point.visibility {
        Visibility::Visible => "visible",
        Visibility::Invisible => "invisible",
        Visibility::Degenerate => "degenerate",
    };
    table.texts("side", points().map(|(_, point)| side(point)))?;
    table.texts("visibility", points().map(|(_, point)| visibility(point)))?;
    let states = points().flat_map(|(_, point)| point.x.iter().copied());
    table.array("y", states.collect(), [compiled.states()])?;
    table.integers("branch", points().map(|(branch, _)| branch))?;
    fields.fields("points", table)?;
    let zones = || numbered(&found, |on_it| &on_it.zones);
    let table = Fields::new(py);
    let kind = |kind: ZoneKind| match kind {
        ZoneKind::Stick => "stick",
        ZoneKind::Repelling => "repelling",
    };
    table.texts("kind", zones().map(|(_, zone)| kind(zone.kind)))?;
    table.numbers("low", zones().map(|(_, zone)| zone.from))?;
    table.numbers("high", zones().map(|(_, zone)| zone.to))?;
    table.integers("branch", zones().map(|(branch, _)| branch))?;
    fields.fields("zones", table)?;
    let rates = || numbered(&found, |on_it| &on_it.rates);
    let table = Fields::new(py);
    table.numbers("at", rates().map(|(_, (at, _))| *at))?;
    table.numbers("below", rates().map(|(_, (_, rates))| rates[0]))?;
    table.numbers("above", rates().map(|(_, (_, rates))| rates[1]))?;
    table.integers("branch", rates().map(|(branch, _)| branch))?;
    fields.fields("rates", table)?;
    fields.ended(None)
}

/// Items on the branches of the boundary, with the numbers of the branches.
fn numbered<'a, T: 'a>(
    found: &'a [(BoundaryLine, LineResults)],
    of: impl Fn(&'a LineResults) -> &'a [T],
) -> impl Iterator<Item = (i64, &'a T)> {
    let branches = (0..).zip(found);
    branches.flat_map(move |(k, (_, on_it))| of(on_it).iter().map(move |one| (k, one)))
}
