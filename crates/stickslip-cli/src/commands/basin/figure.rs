//! The plane of starts, coloured by attractor.

use plot::{
    BLUE, Cells, Color, Figure, GREEN, GREY, Legend, Markers, ORANGE, PURPLE, Panel, SKY,
    VERMILLION,
};

use super::super::{attractors, figures};
use super::found::{Attracting, Found};
use super::request::Basin;
use super::starts::Points;
use crate::output::OutputError;
use stickslip_kernels::file::System;
use stickslip_kernels::kernel::Motion;

/// Colours of attractors, in the order of their shares.
const COLOURS: [Color; 6] = [BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILLION];

/// Entries of the legend; attractors of smaller shares have one together.
const MOST: usize = COLOURS.len();

/// One entry of the legend and the attractors that it is for.
struct Class {
    numbers: Vec<usize>,
    colour: Color,
    legend: String,
}

pub(super) fn basin(found: &Found, basin: &Basin, system: &System) -> Result<String, OutputError> {
    let axis = |k: usize| {
        let range = &basin.plane[k];
        let state = &system.file.states[range.state];
        let label = match (state.unit.as_str(), system.file.time.unit.as_deref()) {
            ("" | "1", None | Some("" | "1")) => {
                format!("{}, dimensionless", figures::symbol(&state.name))
            }
            (unit, _) => figures::with_unit(&state.name, unit),
        };
        plot::Axis::new(&label, range.low, range.high)
    };
    let mut panel = Panel::new(axis(0), axis(1)).legend(Legend::Below);
    let classes = classes(&found.attractors, basin.until);
    for class in &classes {
        let is_in = |number: &u32| class.numbers.contains(&(*number as usize));
        match basin.points {
            Points::Grid { columns, .. } => {
                let [x, y] = basin.plane.map(|range| (range.low, range.high));
                let set = found.reached.iter().map(is_in);
                let cells = Cells::new(x, y, columns.get(), set).fill(class.colour);
                panel.add(cells.legend(&class.legend));
            }
            Points::Random { .. } => {
                let points = found.reached.iter().enumerate().filter(|one| is_in(one.1));
                let points = points.map(|(index, _)| basin.points.at(index, &basin.plane).into());
                let markers = Markers::new(points).color(class.colour).size(2.4);
                panel.add(markers.legend(&class.legend));
            }
        }
    }
    let title = format!("{}: basins of attraction", system.file.name);
    let shown: Vec<&str> = classes.iter().map(|class| class.legend.as_str()).collect();
    let description = format!(
        "The plane of starts, coloured by where they lead: {}.",
        shown.join("; ")
    );
    let height = 440.0 + 16.0 * classes.len() as f64;
    let figure = Figure::new("basin", (520.0, height), &title, &description).row(1.0, panel);
    Ok(figure.render()?)
}

/// Attractors by share, the largest first; behind them what is none, each kind of it by itself.
fn classes(attractors: &[Attracting], until: f64) -> Vec<Class> {
    let mut order: Vec<usize> = (0..attractors.len()).collect();
    // A stable sort: equal shares stay in the order of their numbers.
    order.sort_by(|&one, &other| attractors[other].starts.cmp(&attractors[one].starts));
    let (order, none): (Vec<usize>, Vec<usize>) = order
        .into_iter()
        .partition(|&number| attractors[number].number.is_some());
    let (shown, rest) = order.split_at(order.len().min(MOST));
    let class = |number: usize, colour: Color| {
        let one = &attractors[number];
        Class {
            numbers: vec![number],
            colour,
            legend: legend(&one.outcome, one.share, until),
        }
    };
    let mut classes: Vec<Class> = shown
        .iter()
        .zip(&COLOURS)
        .map(|(&number, &colour)| class(number, colour))
        .collect();
    match *rest {
        [] => {}
        [one] => classes.push(class(one, GREY)),
        _ => {
            let share: f64 = rest.iter().map(|&number| attractors[number].share).sum();
            classes.push(Class {
                numbers: rest.to_vec(),
                colour: GREY,
                legend: format!("{} further attractors, {:.2} %", rest.len(), 100.0 * share),
            });
        }
    }
    classes.extend(none.into_iter().map(|number| {
        let word = attractors[number].outcome.motion.word();
        class(number, figures::colour_of_none(word))
    }));
    classes
}

/// What an attractor is called in the legend.
fn legend(outcome: &stickslip_kernels::kernel::Outcome, share: f64, until: f64) -> String {
    let word = outcome.motion.word();
    let percent = 100.0 * share;
    match outcome.motion {
        Motion::Periodic { period, .. } => {
            let phases = attractors::sequence(outcome);
            // Long sequences would be wider than the figure.
            let phases = if phases.len() > 24 {
                format!("{} phases", outcome.phases.len())
            } else {
                phases.replace('-', "−")
            };
            // Plain text, so that it is as wide as computed in every viewer.
            format!("{word}, period {period:.4}, {phases}: {percent:.2} %")
        }
        _ => format!("{}: {percent:.2} %", attractors::since(word, until)),
    }
}
