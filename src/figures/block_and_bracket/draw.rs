//! The picture of Figs. 10, 11 and 12.

use super::Set;
use super::against_equations::{compare, worth};
use super::compute::{Data, END, Literal, START};
use crate::figures::error::FigureError;
use crate::paper::claim_id::ClaimId;
use crate::paper::published::{Claims, PublishedError};
use plot::*;
use stickslip::analysis::Exponent;
use stickslip::analysis::data_spectrum::Status;
use stickslip::analysis::motion::Class;

const COLOURS: [Color; 4] = [BLUE, VERMILLION, GREEN, PURPLE];
/// Margin around a curve, as a fraction of its extent.
const MARGIN: f64 = 0.06;
/// Running exponents before this part of the time still swing; they may leave the panel.
const SETTLED: f64 = 0.12;
/// Width of the curves from data, px.
const BROAD: f64 = 4.5;

/// What the picture shows, for readers who cannot see it.
fn description(set: &Set, data: &Data) -> String {
    let exact = &data.exact;
    let exponents: Vec<String> = exact
        .spectrum
        .exponents
        .iter()
        .map(|exponent| four(exponent.value()))
        .collect();
    format!(
        "{} From the equations these come to {}; of {} section points {} are distinct, and the motion is {}.",
        set.description,
        exponents.join(", "),
        exact.evidence.returns,
        exact.evidence.distinct,
        exact.class
    )
}

pub(super) fn draw(set: &Set, data: &Data) -> Result<String, FigureError> {
    Figure::new(
        set.figure.name(),
        (880.0, 690.0),
        set.title,
        &description(set, data),
    )
    .columns(
        0.6,
        vec![
            (1.0, block(set, data).into()),
            (1.0, bracket(set, data).into()),
        ],
    )
    .columns(
        0.4,
        vec![(1.0, running(data).into()), (1.0, table(set, data)?.into())],
    )
    .render()
    .map_err(Into::into)
}

/// An interval that holds all values, with a margin.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    let margin = MARGIN * (high - low);
    (low - margin, high + margin)
}

fn axis(label: &str, (low, high): (f64, f64)) -> Axis {
    Axis::new(label, low, high).minor(5)
}

fn width(data: &Data) -> f64 {
    match data.exact.class {
        Class::Periodic(_) => 1.4,
        _ => 0.5,
    }
}

fn block(set: &Set, data: &Data) -> Panel {
    let belt = data.model.belt_speed;
    let curve = || data.curve.iter();
    let mut panel = Panel::new(
        axis("*x*_1", range(curve().map(|x| x[0]))),
        axis("*x*_2", range(curve().map(|x| x[1]).chain([belt]))),
    )
    .label("(a)")
    .title(&format!(
        "block, corrected equations, *t* = {} … {END}",
        END - set.shown
    ))
    .legend(Legend::Below);
    panel.add(
        Guide::horizontal(belt)
            .color(GREY)
            .width(0.7)
            .dash(Dash::Dashed)
            .legend("Σ: *x*_2 = *v*_p"),
    );
    let points = curve().map(|x| (x[0], x[1]));
    panel.add(Curve::new(points).color(BLUE).width(width(data)));
    if matches!(data.exact.class, Class::Periodic(_)) {
        let turns = data.turns.iter().map(|x| (x[0], x[1]));
        panel.add(Markers::new(turns).open().legend("section point"));
    }
    panel
}

fn bracket(set: &Set, data: &Data) -> Panel {
    let curve = || data.curve.iter();
    let (low, high) = range(curve().map(|x| x[2]));
    let mut panel = Panel::new(
        axis("*x*_3", (low, high)),
        axis("*x*_4", range(curve().map(|x| x[3]))),
    )
    .label("(b)")
    .title(&format!(
        "bracket, corrected equations, *t* = {} … {END}",
        END - set.shown
    ))
    .legend(Legend::Below);
    // Only where the bracket's velocity does not act on the contact is the border upright.
    let lift = 1.0 / data.model.unloading;
    if data.model.unloading_rate == 0.0 && lift > low && lift < high {
        panel.add(
            Band::x(lift, high)
                .fill(LIGHT_GREY)
                .legend("no contact, *N* = 0"),
        );
    }
    let points = curve().map(|x| (x[2], x[3]));
    panel.add(Curve::new(points).color(VERMILLION).width(width(data)));
    panel
}

fn running(data: &Data) -> Panel {
    let convergence = &data.exact.spectrum.convergence;
    let end = END - START;
    let settled = convergence
        .iter()
        .filter(|at| at.elapsed > SETTLED * end)
        .flat_map(|at| at.exponents);
    let reliable: Vec<usize> = (0..data.from_data.exponents.len().min(4))
        .filter(|&i| data.from_data.exponents[i].status == Status::Ok)
        .collect();
    let by_data = data
        .from_data
        .convergence
        .iter()
        .filter(|at| at.t > SETTLED * end)
        .flat_map(|at| reliable.iter().map(|&i| at.exponents[i]));
    let mut panel = Panel::new(
        Axis::new("*t* − 3000", 0.0, end).step(3000.0).minor(3),
        axis(
            "*λ*, running means",
            range(settled.chain(by_data).chain([0.0])),
        ),
    )
    .label("(c)")
    .title(&format!("exponents{}", annihilated(data)))
    .legend(Legend::Below);
    panel.add(Guide::horizontal(0.0).color(GREY).width(0.6));
    // Broad and pale, under the equations' curves: where both agree, both are seen.
    for &i in &reliable {
        let rows = data.from_data.convergence.iter();
        let points = rows.map(|at| (at.t, at.exponents[i]));
        panel.add(
            Curve::new(points)
                .color(COLOURS[i].pale())
                .width(BROAD)
                .legend(&format!("*λ*_{}, data", i + 1)),
        );
    }
    for (i, exponent) in data.exact.spectrum.exponents.iter().enumerate() {
        if *exponent == Exponent::Annihilated {
            continue;
        }
        let points = convergence.iter().map(|at| (at.elapsed, at.exponents[i]));
        panel.add(
            Curve::new(points)
                .color(COLOURS[i])
                .legend(&format!("*λ*_{}, equations", i + 1)),
        );
    }
    panel
}

/// What the running means cannot show: the exponents that the equations give as −∞.
fn annihilated(data: &Data) -> String {
    let exponents = data.exact.spectrum.exponents.iter().enumerate();
    exponents
        .filter(|(_, exponent)| **exponent == Exponent::Annihilated)
        .map(|(i, _)| format!("; *λ*_{} = −∞", i + 1))
        .collect()
}

/// Four decimals, as published.
fn four(value: f64) -> String {
    if value == f64::NEG_INFINITY {
        "−∞".into()
    } else if value.is_nan() {
        "–".into()
    } else {
        number(value, 4)
    }
}

fn table(set: &Set, data: &Data) -> Result<Table, PublishedError> {
    let claims = Claims::committed()?;
    let said = |id: ClaimId| claims.of(id).published.clone();
    let mut table = Table::new(["", "published", "from equations", "from data"])
        .title("**(d)**  per unit of *t*; in brackets: unidentified");
    let comparisons = compare(&data.from_data, &data.exact.spectrum.exponents);
    for i in 0..4 {
        let printed = said(set.figure.exponents()[i]).replace('-', "−");
        let exponent = &data.exact.spectrum.exponents[i];
        let equations = match exponent.std_error() {
            Some(error) => format!("{} ± {}", four(exponent.value()), four(error)),
            None => four(exponent.value()),
        };
        let by_data = data
            .from_data
            .exponents
            .get(i)
            .map_or_else(String::new, |e| {
                let value = four(e.value);
                match e.status {
                    Status::Unidentified => format!("({value})"),
                    Status::Starved
                    | Status::Undetermined
                    | Status::Noisy
                    | Status::Unstable
                    | Status::Unpredictable => {
                        format!("{value} {}", e.status.word())
                    }
                    Status::Ok => match worth(&data.from_data, i, &comparisons) {
                        "ok" => value,
                        word => format!("{value} {word}"),
                    },
                    Status::Annihilated => value,
                }
            });
        table = table.row([format!("*λ*_{}", i + 1), printed, equations, by_data]);
    }
    let exact = &data.exact;
    let evidence = &exact.evidence;
    let blank = String::new;
    let literal = match &data.literal {
        Literal::Diverges(t) => format!("beyond 1000 at *t* = {}", number(*t, 1)),
        Literal::Bounded(measured) => format!("{}", measured.class),
    };
    let rows = [
        ("class", said(set.figure.class()), exact.class.to_string()),
        (
            "section points",
            blank(),
            format!("{} of {}", evidence.distinct, evidence.returns),
        ),
        (
            "stick, % of time",
            blank(),
            number(100.0 * exact.spectrum.stick_fraction, 2),
        ),
        (
            "least *N*/*mg*, not clipped",
            blank(),
            number(exact.least_force, 3),
        ),
        (
            "losses of contact",
            blank(),
            exact.contact_losses.to_string(),
        ),
        ("signs as printed", blank(), literal),
    ];
    for (name, printed, found) in rows {
        table = table.row([name.to_owned(), printed, found, blank()]);
    }
    Ok(table)
}
