//! The plane of two parameters three times: attractor, exponent, part of time in stick.

use plot::{
    Axis, BLUE, Cells, Color, Figure, GREEN, GREY, LIGHT_GREY, Legend, ORANGE, PURPLE, Panel, SKY,
    VERMILLION, WHITE,
};

use super::super::exponent::Largest;
use super::super::figures;
use super::found::{Found, Shown};
use super::request::Map;
use crate::output::OutputError;
use stickslip_kernels::file::System;

/// Colours of classes, in the order of their sizes.
const COLOURS: [Color; 6] = [BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION];

/// From pale to dark: how negative an exponent is.
const BLUES: [Color; 4] = [
    Color(200, 224, 242),
    Color(132, 184, 222),
    Color(48, 132, 190),
    Color(0, 76, 130),
];

/// From pale to dark: how positive an exponent is, or how large a part of time.
const REDS: [Color; 4] = [
    Color(252, 226, 184),
    Color(243, 178, 98),
    Color(213, 94, 0),
    Color(128, 48, 0),
];

/// Entries of the legend of attractors; smaller classes have one together.
const MOST: usize = COLOURS.len();

/// The cells of one colour.
struct Layer {
    set: Vec<bool>,
    colour: Color,
    legend: String,
}

pub(super) fn map(found: &Found, map: &Map, system: &System) -> Result<String, OutputError> {
    // All panels share the first one's axis of the second parameter.
    let panel = |label: &str, title: &str, layers: Vec<Layer>| {
        let is_first = label == "(a)";
        let second = &map.plane[1];
        let y = if is_first {
            axis(1, map, system)
        } else {
            Axis::new("", second.low, second.high).bare()
        };
        let mut panel = Panel::new(axis(0, map, system), y)
            .label(label)
            .title(title)
            .legend(Legend::Below);
        let [x, y] = [0, 1].map(|k: usize| (map.plane[k].low, map.plane[k].high));
        for layer in layers {
            let cells = Cells::new(x, y, map.columns.get(), layer.set);
            panel.add(cells.fill(layer.colour).legend(&layer.legend));
        }
        (if is_first { 1.2 } else { 1.0 }, panel.into())
    };
    let panels = vec![
        panel("(a)", "attractor", attractors(found, map.until)),
        panel("(b)", "largest exponent", exponents(&found.cells)),
        panel("(c)", "part of time in stick", sticks(&found.cells)),
    ];
    let title = format!("{}: map of two parameters", system.file.name);
    let classes: Vec<&str> = found
        .classes
        .iter()
        .map(|class| class.name.as_str())
        .collect();
    let description = format!(
        "What the orbit from the start comes to, over {} and {}: {}; its largest Lyapunov exponent; and the part of time in stick.",
        map.plane[0].name,
        map.plane[1].name,
        classes.join("; ")
    );
    let figure = Figure::new("map", (770.0, 440.0), &title, &description).columns(1.0, panels);
    Ok(figure.render()?)
}

fn axis(k: usize, map: &Map, system: &System) -> Axis {
    let range = &map.plane[k];
    let label = figures::parameter_label(system, &range.name);
    Axis::new(&label, range.low, range.high)
}

/// A layer for each kind of attractor, the largest first; behind them those of what is none, each by itself.
fn attractors(found: &Found, until: f64) -> Vec<Layer> {
    let mut order: Vec<usize> = (0..found.classes.len()).collect();
    // A stable sort: equal classes stay in their order.
    order.sort_by(|&one, &other| found.classes[other].cells.cmp(&found.classes[one].cells));
    let (order, none): (Vec<usize>, Vec<usize>) = order
        .into_iter()
        .partition(|&class| found.classes[class].is_attractor);
    let (shown, rest) = order.split_at(order.len().min(MOST));
    let set = |of: &[usize]| {
        let cells = found.cells.iter();
        cells.map(|cell| of.contains(&cell.class)).collect()
    };
    let layer = |class: usize, colour: Color| Layer {
        set: set(&[class]),
        colour,
        // In a figure a minus is as wide as a plus.
        legend: found.classes[class].name.replace('-', "−"),
    };
    let mut layers: Vec<Layer> = shown
        .iter()
        .zip(&COLOURS)
        .map(|(&class, &colour)| layer(class, colour))
        .collect();
    match *rest {
        [] => {}
        [one] => layers.push(layer(one, GREY)),
        _ => layers.push(Layer {
            set: set(rest),
            colour: GREY,
            legend: format!("{} further kinds", rest.len()),
        }),
    }
    layers.extend(none.into_iter().map(|class| {
        let name = &found.classes[class].name;
        Layer {
            set: set(&[class]),
            colour: figures::colour_of_none(name),
            legend: super::super::attractors::since(name, until),
        }
    }));
    layers
}

/// The layers that have cells.
fn filled(layers: Vec<Layer>) -> Vec<Layer> {
    let is_filled = |layer: &Layer| layer.set.contains(&true);
    layers.into_iter().filter(is_filled).collect()
}

fn exponents(cells: &[Shown]) -> Vec<Layer> {
    let finite = |cell: &Shown| match cell.largest {
        Largest::Finite { value, .. } if !cell.largest.is_zero() => Some(value),
        _ => None,
    };
    let layer = |is_in: &dyn Fn(&Shown) -> bool, colour, legend: String| Layer {
        set: cells.iter().map(is_in).collect(),
        colour,
        legend,
    };
    let mut layers = vec![layer(
        &|cell| cell.largest == Largest::Annihilated,
        PURPLE,
        "−∞: stick takes all".to_owned(),
    )];
    // The most negative first.
    for (sign, colours) in [(-1.0, BLUES), (1.0, REDS)] {
        let values = || cells.iter().filter_map(finite).map(move |v| sign * v);
        let most = values().fold(0.0, f64::max);
        let mut of_sign = Vec::new();
        for (k, colour) in colours.into_iter().enumerate() {
            let [low, high] = [k, k + 1].map(|k| most * k as f64 / colours.len() as f64);
            let is_last = k + 1 == colours.len();
            let is_in = |cell: &Shown| {
                let value = finite(cell).map(|value| sign * value);
                // The largest is in the last, whatever rounding does to its end.
                value.is_some_and(|value| value > low && (value <= high || is_last))
            };
            let ends = if sign < 0.0 {
                [-high, -low]
            } else {
                [low, high]
            };
            let [from, to] = ends.map(|end| plot::number(end, decimals(most)));
            of_sign.push(layer(&is_in, colour, format!("{from} to {to}")));
        }
        if sign < 0.0 {
            of_sign.reverse();
            layers.extend(of_sign);
            layers.push(layer(
                &|cell| cell.largest.is_zero(),
                LIGHT_GREY,
                "0 within its error".to_owned(),
            ));
        } else {
            layers.extend(of_sign);
        }
    }
    layers.push(layer(
        &|cell| cell.largest == Largest::Unmeasured,
        WHITE,
        "no attractor".to_owned(),
    ));
    filled(layers)
}

/// Decimal places that tell the quarters of a value apart.
fn decimals(most: f64) -> usize {
    let mut decimals = 1;
    let mut unit = 0.1;
    while decimals < 9 && unit > most / 40.0 {
        unit /= 10.0;
        decimals += 1;
    }
    decimals
}

fn sticks(cells: &[Shown]) -> Vec<Layer> {
    let layer = |is_in: &dyn Fn(f64) -> bool, colour, legend: &str| Layer {
        set: cells
            .iter()
            .map(|cell| cell.in_stick.is_some_and(is_in))
            .collect(),
        colour,
        legend: legend.to_owned(),
    };
    let [first, second, third, fourth] = REDS;
    filled(vec![
        layer(&|part| part <= 0.0, LIGHT_GREY, "no stick"),
        layer(&|part| part > 0.0 && part <= 0.25, first, "up to 25 %"),
        layer(&|part| part > 0.25 && part <= 0.5, second, "25 to 50 %"),
        layer(&|part| part > 0.5 && part <= 0.75, third, "50 to 75 %"),
        layer(&|part| part > 0.75 && part < 1.0, fourth, "75 to 100 %"),
        layer(&|part| part >= 1.0, SKY, "always in stick"),
        Layer {
            set: cells.iter().map(|cell| cell.in_stick.is_none()).collect(),
            colour: WHITE,
            legend: "no attractor".to_owned(),
        },
    ])
}
