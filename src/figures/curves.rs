//! The curves of a figure as a file, so that a published picture can be laid over them.

use crate::text::{csv, distinct};
use plot::{Figure, NumericCurve};

/// Largest file (bytes).
const LARGEST: usize = 100_000;
/// Fraction of its axes by which leaving out a point may move a line: a tenth of a pixel on a
/// screen. It grows until the file is small enough.
const FINEST: f64 = 1e-4;
const COARSER: f64 = 1.3;
/// Digits after the point in scientific notation: some more than a picture shows.
const DIGITS: usize = 5;

/// The curves as CSV with the columns `panel,curve,x,y`. Lines that begin with `#` name the axes of
/// each panel; a row without numbers separates pieces of a curve.
pub(crate) fn table(figure: &Figure) -> String {
    let mut tolerance = FINEST;
    loop {
        let text = lines(&figure.curves(tolerance));
        if text.len() <= LARGEST || tolerance > 1.0 {
            return text;
        }
        tolerance *= COARSER;
    }
}

fn lines(curves: &[NumericCurve]) -> String {
    let axes = curves.iter().map(|one| (&one.panel, &one.axes));
    let mut text = String::new();
    for (panel, [x, y]) in distinct(axes) {
        text += &format!("# {panel}: x is {x}; y is {y}\n");
    }
    let header = ["panel", "curve", "x", "y"].map(str::to_owned);
    let rows = |one: &NumericCurve| -> Vec<[String; 4]> {
        let row = |x, y| [one.panel.clone(), one.name.clone(), x, y];
        let of_piece = |piece: &Vec<(f64, f64)>| {
            let number = |value: f64| format!("{value:.DIGITS$e}");
            let points = piece.iter().map(|&(x, y)| row(number(x), number(y)));
            points.collect::<Vec<_>>()
        };
        let pieces: Vec<Vec<[String; 4]>> = one.pieces.iter().map(of_piece).collect();
        // A row without numbers stands where a curve leaves the panel and comes back.
        pieces.join(&row(String::new(), String::new()))
    };
    let points = curves.iter().flat_map(rows);
    text + &csv(std::iter::once(header).chain(points))
}
