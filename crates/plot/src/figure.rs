//! The page: rows of panels.

use plotters::drawing::IntoDrawingArea;

use super::canvas::Canvas;
use super::panel::{Margins, NumericCurve, Panel};
use super::plot::Frame;
use super::table::Table;
use crate::error::PlotError;

/// White border of the page, px.
const BORDER: f64 = 8.0;
/// Space between neighbouring cells, px.
const GAP: f64 = 14.0;
/// Smallest plot rectangle that still shows something, px.
const SMALLEST_PLOT: f64 = 24.0;

/// Content of a cell of the page.
pub enum Cell {
    /// Axes and curves.
    Panel(Box<Panel>),
    /// Text.
    Table(Table),
}

impl From<Panel> for Cell {
    fn from(panel: Panel) -> Self {
        Cell::Panel(Box::new(panel))
    }
}

impl From<Table> for Cell {
    fn from(table: Table) -> Self {
        Cell::Table(table)
    }
}

impl Cell {
    fn margins(&self, width: f64) -> Result<Margins, PlotError> {
        match self {
            Cell::Panel(panel) => panel.margins(width),
            Cell::Table(_) => Ok(Margins::default()),
        }
    }
}

/// Adjacent items, each with its share of the space.
type Shares<T> = Vec<(f64, T)>;

/// A figure of one or more panels.
pub struct Figure {
    id: String,
    title: String,
    description: String,
    size: (f64, f64),
    rows: Shares<Shares<Cell>>,
}

/// A cell of the page with its position and its margins.
struct PlacedCell<'f> {
    frame: Frame,
    margins: Margins,
    cell: &'f Cell,
}

impl PlacedCell<'_> {
    fn is_panel(&self) -> bool {
        matches!(self.cell, Cell::Panel(_))
    }
}

impl Figure {
    /// An empty figure. `id` is unique among figures (`fig06`); `width` and `height` in px. `title`
    /// and `description` are for readers who cannot see the picture and say what it shows.
    pub fn new(id: &str, (width, height): (f64, f64), title: &str, description: &str) -> Self {
        Self {
            id: id.to_owned(),
            title: title.to_owned(),
            description: description.to_owned(),
            size: (width, height),
            rows: Vec::new(),
        }
    }

    /// Adds a row with one cell. `weight` is its share of the height.
    pub fn row(self, weight: f64, cell: impl Into<Cell>) -> Self {
        self.columns(weight, vec![(1.0, cell.into())])
    }

    /// Adds a row of several cells, each with its share of the width.
    pub fn columns(mut self, weight: f64, cells: Vec<(f64, Cell)>) -> Self {
        self.rows.push((weight, cells));
        self
    }

    /// The SVG.
    ///
    /// # Errors
    /// An axis without an interval, a figure too small for its labels.
    pub fn render(&self) -> Result<String, PlotError> {
        let placed = self.layout()?;
        let mut svg = String::new();
        let texts = [&*self.id, &*self.title, &*self.description];
        let canvas = Canvas::new(&mut svg, self.size, texts)
            .map_err(|error| PlotError::Draw(error.to_string()))?;
        let page = canvas.into_drawing_area();
        for place in &placed {
            match place.cell {
                Cell::Panel(panel) => panel.draw(&page, &place.frame, &place.margins)?,
                Cell::Table(table) => table.draw(&page, &place.frame)?,
            }
        }
        page.present()?;
        drop(page);
        Ok(svg)
    }

    /// The curves of all panels as numbers, as far as they lie inside. Points whose absence moves a
    /// line by less than a fraction `tolerance` of its axes are left out.
    pub fn curves(&self, tolerance: f64) -> Vec<NumericCurve> {
        let cells = self.rows.iter().flat_map(|(_, cells)| cells);
        let panels = cells.filter_map(|(_, cell)| match cell {
            Cell::Panel(panel) => Some(panel),
            Cell::Table(_) => None,
        });
        panels.flat_map(|panel| panel.curves(tolerance)).collect()
    }

    /// Divides the page. Panels in a column get the same margins, so that their frames line up.
    fn layout(&self) -> Result<Vec<PlacedCell<'_>>, PlotError> {
        let (width, height) = self.size;
        let mut placed = Vec::new();
        for (row, ends) in subdivide(&self.rows, height) {
            placed.append(&mut place_row(row, width, ends)?);
        }
        line_up(&mut placed);
        for place in &placed {
            let width = place.frame.width() - place.margins.left - place.margins.right;
            let height = place.frame.height() - place.margins.top - place.margins.bottom;
            if !(width >= SMALLEST_PLOT && height >= SMALLEST_PLOT) {
                return Err(PlotError::NoRoom {
                    figure: self.id.clone(),
                    width,
                    height,
                });
            }
        }
        Ok(placed)
    }
}

/// Start and end of each item along an edge of the page.
fn subdivide<T>(shares: &[(f64, T)], edge: f64) -> impl Iterator<Item = (&T, (f64, f64))> {
    let weights: f64 = shares.iter().map(|(weight, _)| weight).sum();
    let room = edge - 2.0 * BORDER - GAP * shares.len().saturating_sub(1) as f64;
    let mut next = BORDER;
    shares.iter().map(move |(weight, thing)| {
        let ends = (next, next + room * weight / weights);
        next = ends.1 + GAP;
        (thing, ends)
    })
}

fn place_row(
    cells: &[(f64, Cell)],
    width: f64,
    (top, bottom): (f64, f64),
) -> Result<Vec<PlacedCell<'_>>, PlotError> {
    let mut placed = Vec::new();
    for (cell, (left, right)) in subdivide(cells, width) {
        placed.push(PlacedCell {
            frame: Frame::between((left, top), (right, bottom)),
            margins: cell.margins(right - left)?,
            cell,
        });
    }
    // Frames in a row begin and end at the same height.
    let above = placed.iter().map(|p| p.margins.top).fold(0.0, f64::max);
    let below = placed.iter().map(|p| p.margins.bottom).fold(0.0, f64::max);
    for place in placed.iter_mut().filter(|p| p.is_panel()) {
        place.margins.top = above;
        place.margins.bottom = below;
    }
    Ok(placed)
}

/// Gives panels whose cells begin (or end) at the same abscissa the same left (or right) margin.
fn line_up(placed: &mut [PlacedCell<'_>]) {
    let mut panels: Vec<&mut PlacedCell<'_>> = placed.iter_mut().filter(|p| p.is_panel()).collect();
    let cells: Vec<(Frame, Margins)> = panels.iter().map(|p| (p.frame, p.margins)).collect();
    for place in &mut panels {
        for (frame, margins) in &cells {
            if (frame.left - place.frame.left).abs() < 0.5 {
                place.margins.left = place.margins.left.max(margins.left);
            }
            if (frame.right - place.frame.right).abs() < 0.5 {
                place.margins.right = place.margins.right.max(margins.right);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::*;

    fn unit() -> Panel {
        Panel::new(Axis::new("*x*", 0.0, 1.0), Axis::new("*y*", 0.0, 1.0))
    }

    fn figure() -> Figure {
        Figure::new("test", (400.0, 300.0), "A title", "A description")
    }

    /// Path data of the plot frames: the only paths here with more than a few points.
    fn frames(svg: &str) -> Vec<String> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let is_frame = |d: &&str| d.matches(['-', ' ']).count() > 6 && d.starts_with('M');
        document
            .descendants()
            .filter_map(|node| node.attribute("d"))
            .filter(is_frame)
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn every_layer_draws_something_well_formed() {
        let line = [(0.1, 0.1), (0.9, 0.8)];
        let curve = Curve::new(line).color(BLUE).dash(Dash::Dotted);
        let region = Region::between(line, [(0.1, 0.0), (0.9, 0.0)]).fill(SKY);
        let cells = Cells::new((0.0, 0.5), (0.0, 0.5), 2, [true, false, false, true]);
        let markers = Markers::new(line).shape(Shape::Up).color(GREEN);
        let note = Note::new(Position::Fraction(0.5, 0.5), "there").leader((0.9, 0.9));
        let dimension = Dimension::new((0.2, 0.2), (0.8, 0.2), "0.6 m").shift(9.0);
        let inset = Inset::new((0.5, 0.5), (0.9, 0.9), unit().title("detail"));
        let panels: Vec<(Panel, &str)> = vec![
            (unit().with(Band::x(0.2, 0.3)), "<rect"),
            (unit().with(Band::y(0.2, 0.3)), "<rect"),
            (unit().with(Band::bar((0.2, 0.3), 0.5, 6.0)), "<rect"),
            (unit().with(curve), "stroke-dasharray"),
            (unit().with(region), "#56b4e9"),
            (unit().with(cells.fill(PURPLE)), "#cc79a7"),
            (
                unit().with(Guide::vertical(0.5).label("*t*_0", 0.5)),
                "t</tspan>",
            ),
            (unit().with(Guide::horizontal(0.5).color(ORANGE)), "#e69f00"),
            (unit().with(markers.label(1, "end", (5.0, 5.0))), ">end<"),
            (
                unit().with(Note::new((0.5, 0.5), "here").arrow((0.9, 0.9))),
                ">here<",
            ),
            (unit().with(note), "#737373"),
            (unit().with(dimension), ">0.6 m<"),
            (unit().with(inset), ">detail<"),
        ];
        for (panel, trace) in panels {
            let svg = figure().row(1.0, panel).render().unwrap();
            roxmltree::Document::parse(&svg).unwrap();
            let rects = if trace == "<rect" { 1 } else { 0 };
            assert!(svg.matches(trace).count() > rects, "no {trace} in {svg}");
        }
    }

    #[test]
    fn what_lies_outside_the_axes_is_not_drawn() {
        let empty = figure().row(1.0, unit()).render().unwrap();
        let far = [(2.0, 2.0), (1e6, 3.0)];
        let panel = unit()
            .with(Curve::new(far))
            .with(Markers::new(far).label(0, "far", (5.0, 5.0)))
            .with(Band::rect((2.0, 3.0), (0.0, 1.0)))
            .with(Region::between(far, [(2.0, 4.0), (1e6, 5.0)]))
            .with(Cells::new((2.0, 3.0), (0.0, 1.0), 1, [true]));
        assert_eq!(figure().row(1.0, panel).render().unwrap(), empty);
    }

    #[test]
    fn legends_list_what_has_a_legend() {
        for place in [Legend::UpperLeft, Legend::UpperMiddle, Legend::Below] {
            let panel = unit()
                .legend(place)
                .with(Curve::new([(0.0, 0.0), (1.0, 1.0)]).legend("line"))
                .with(Guide::horizontal(0.5))
                .with(Markers::new([(0.5, 0.5)]).legend("point"))
                .with(Band::x(0.1, 0.2).legend("area"))
                .with(Cells::new((0.0, 1.0), (0.0, 1.0), 1, [true]).legend("cells"));
            let svg = figure().row(1.0, panel).render().unwrap();
            for text in ["line", "point", "area", "cells"] {
                assert_eq!(svg.matches(&format!(">{text}<")).count(), 1, "{place:?}");
            }
        }
    }

    #[test]
    fn a_legend_counts_what_it_has_no_room_for() {
        for (place, named) in [(Legend::UpperLeft, 5..6), (Legend::Below, 12..150)] {
            let mut panel = unit().legend(place);
            for k in 0..300 {
                panel.add(Markers::new([(0.5, 0.5)]).legend(&format!("j{k}")));
            }
            let svg = figure().row(1.0, panel).render().unwrap();
            let count = svg.matches(">j").count();
            assert!(named.contains(&count), "{count}");
            let document = roxmltree::Document::parse(&svg).unwrap();
            let number = |node: &roxmltree::Node<'_, '_>, name: &str| -> f64 {
                node.attribute(name).unwrap().parse().unwrap()
            };
            let text = format!("and {} more", 300 - count);
            let is_counted = |node: &roxmltree::Node<'_, '_>| node.text() == Some(&text);
            let counted = document.descendants().find(is_counted).unwrap();
            let right = number(&counted, "x") + number(&counted, "textLength");
            // The frame of a legend inside is the last rectangle.
            let frame = document
                .descendants()
                .rfind(|node| node.has_tag_name("rect"));
            let edge = match place {
                Legend::Below => 39_200.0,
                _ => frame.map_or(0.0, |node| number(&node, "x") + number(&node, "width")),
            };
            assert!(right <= edge, "{place:?}: {right} beyond {edge}");
        }
    }

    #[test]
    fn a_figure_of_millions_of_points_is_small() {
        let point = |k: u32| {
            let t = f64::from(k) * 0.3;
            (libm::sin(t), libm::sin(1.618 * t))
        };
        let axis = || Axis::new("", -1.1, 1.1);
        let panel = Panel::new(axis(), axis())
            .with(Curve::new((0..300_000).map(point)))
            .with(Markers::new((0..100_000).map(point)));
        let svg = Figure::new("long", (560.0, 480.0), "t", "d").row(1.0, panel);
        let length = svg.render().unwrap().len();
        assert!(length < 1_000_000, "{length}");
    }

    #[test]
    fn panels_under_one_another_line_up() {
        let wide = Panel::new(Axis::new("", 0.0, 1.0), Axis::new("", 0.0, 1e6));
        let narrow = Panel::new(Axis::new("", 0.0, 1.0), Axis::new("", 0.0, 1.0).bare());
        let svg = figure().row(1.0, wide).row(1.0, narrow).render().unwrap();
        let left_ends: Vec<String> = frames(&svg)
            .iter()
            .filter_map(|d| d.split(' ').next().map(str::to_owned))
            .collect();
        assert_eq!(left_ends.len(), 2);
        assert_eq!(left_ends[0], left_ends[1]);
    }

    #[test]
    fn tables_stand_beside_panels() {
        let table = Table::new(["quantity", "value"])
            .title("**Stick**")
            .row(["*ℓ*_1", "0.4697"]);
        let svg = figure()
            .columns(1.0, vec![(1.0, unit().into()), (1.0, table.into())])
            .render()
            .unwrap();
        assert!(svg.contains(">0.4697<"));
    }

    #[test]
    fn curves_are_exported_as_values_without_points_that_do_not_show() {
        let x = Axis::decades("*h*_1, s", (-3.0, 0.0));
        let panel = Panel::new(x, Axis::new("*y*, m", 0.0, 1.0))
            .label("(b)")
            .with(Curve::new([(-2.0, 0.2), (-1.0, 0.4), (0.0, 0.6)]).legend("*λ*_1"))
            .with(Markers::new([(-2.0, 0.2)]))
            .with(Curve::new([(-1.0, 0.5), (-1.0, 1.5), (-1.0, 0.5)]));
        let figure = figure().row(1.0, panel);
        let [line, outside] = &figure.curves(1e-6)[..] else {
            panic!("two curves");
        };
        assert_eq!((&*line.panel, &*line.name), ("b", "λ1"));
        assert_eq!(line.axes, ["h1, s", "y, m"]);
        assert_eq!(line.pieces, [[(0.01, 0.2), (1.0, 0.6)]]);
        assert_eq!((&*outside.name, outside.pieces.len()), ("curve 2", 2));
        assert_eq!(outside.pieces[0], [(0.1, 0.5), (0.1, 1.0)]);
    }

    #[test]
    fn an_axis_of_huge_numbers_leaves_room() {
        let y = Axis::new("*x*", -5e215, 1.05e217);
        let panel = Panel::new(Axis::new("", 0.0, 1e-30), y);
        let svg = figure().row(1.0, panel).render().unwrap();
        assert!(svg.len() < 10_000, "{svg}");
    }

    #[test]
    fn a_page_without_room_is_refused() {
        let error = Figure::new("tiny", (60.0, 60.0), "t", "d")
            .row(1.0, unit())
            .render()
            .unwrap_err();
        assert!(matches!(error, PlotError::NoRoom { .. }));
        assert!(error.to_string().contains("tiny"));
    }

    #[test]
    fn an_axis_without_an_interval_is_refused() {
        for (min, max) in [(1.0, f64::NAN), (-1e308, 1e308)] {
            let panel = Panel::new(Axis::new("*t*", min, max), Axis::new("", 0.0, 1.0));
            let error = figure().row(1.0, panel).render().unwrap_err();
            assert!(matches!(error, PlotError::Axis { .. }));
        }
    }
}
