//! Fig. 4: orbits of model 1 and the limit cycle that they settle on.

mod compute;
mod draw;

use super::FigureSpec;
use crate::figures::rows::Row;
use crate::paper::claim_id::ClaimId;
use crate::paper::reading::Reading::Exact;
use crate::text::joined;
use compute::compute;
pub use compute::{Cycle, Data};
use draw::draw;
use stickslip::Visibility;

/// Fig. 4.
pub const FIG04: FigureSpec<Data> = FigureSpec {
    name: "fig04",
    title: "Orbits of the belt oscillator and its limit cycle (Fig. 4)",
    about: "Panel (a): phase plane of model 1, Eq. (3), for mu0 = 1/(3√3) and vp = 1: orbits \
        from the six tangent points and two further starts, all numbered, dashed where they \
        stick; the limit cycle, stick zones as grey bars, visible tangent points filled. Panel \
        (b): the kink where the cycle crosses the belt's speed near the third tangent point. \
        Numbers: tangent points and their kinds, the cycle's crossings, period, Floquet \
        multiplier and number of stick phases.",
    compute,
    numbers,
    draw,
};

fn numbers(data: &Data) -> Vec<Row> {
    let positions: Vec<f64> = data
        .tangents
        .iter()
        .map(|tangent| tangent.position)
        .collect();
    let mut rows = Row::members(ClaimId::Eq12CriticalPoints, Exact, &data.stationary, "m");
    for (id, values, unit) in [
        (ClaimId::Eq13CriticalMu0, &data.critical_mu0, "N"),
        (ClaimId::Eq16TangentPoints, &positions, "m"),
    ] {
        rows.extend(Row::members(id, Exact, values, unit));
    }
    rows.extend((1..).zip(&data.tangents).map(|(k, tangent): (usize, _)| {
        let name = format!("{}.{k}", ClaimId::Fig04Visibility);
        Row::word(name, Exact, kind(tangent.visibility))
    }));
    rows.extend(limit_cycle(data));
    rows.extend(statements(data));
    rows
}

/// The name of a kind in the caption.
pub(crate) fn kind(visibility: Visibility) -> &'static str {
    match visibility {
        Visibility::Visible => "visible",
        Visibility::Invisible => "invisible",
        Visibility::Degenerate => "degenerate",
    }
}

fn limit_cycle(data: &Data) -> Vec<Row> {
    let cycle = &data.cycle;
    let number = |name: &str, value, unit| {
        Row::number(format!("fig04.limit_cycle.{name}"), Exact, value, unit)
    };
    vec![
        number("crossing.left", cycle.left, "m"),
        number("crossing.right", cycle.right, "m"),
        number("period", cycle.period, "s"),
        number("multiplier", cycle.multiplier, "1"),
        number("kink.below", cycle.kink[0], "m/s²"),
        number("kink.above", cycle.kink[1], "m/s²"),
        Row::count("fig04.sticks_per_period", Exact, cycle.sticks),
        Row::count("fig04.orbits", Exact, data.orbits.len()),
        Row::count("fig04.orbits_that_stick", Exact, data.sticking()),
    ]
}

impl Data {
    /// Number of orbits with a stick phase.
    pub fn sticking(&self) -> usize {
        self.sticks.iter().filter(|&&sticks| sticks).count()
    }

    /// The numbers of the tangent points of each kind, as in the caption.
    pub(super) fn kinds(&self) -> String {
        let listed = |wanted| {
            let numbered = (1..).zip(&self.tangents);
            let of_kind = numbered.filter(|(_, tangent)| tangent.visibility == wanted);
            let numbers = of_kind.map(|(k, _): (usize, _)| k);
            format!("{} {}", kind(wanted), joined(numbers, ","))
        };
        let (visible, invisible) = (Visibility::Visible, Visibility::Invisible);
        format!("{}; {}", listed(visible), listed(invisible))
    }
}

/// The statements of the caption, decided by the numbers.
fn statements(data: &Data) -> Vec<Row> {
    let distance = |k: usize| (data.tangents[k].position - data.cycle.left).abs();
    let nearest = (0..data.tangents.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let [below, above] = data.cycle.kink;
    let deflection = [
        (
            "the cycle's left crossing of Σ is nearest to the third tangent point",
            nearest == Some(2),
        ),
        ("the slope of the orbit jumps there", below != above),
    ];
    vec![
        Row::word(ClaimId::Fig04Visibility, Exact, &data.kinds()),
        Row::statement(ClaimId::Fig04Deflection, Exact, deflection),
    ]
}
