//! The SVG, as it is written.
//!
//! Texts stay `<text>`, with italics and subscripts. Coordinates are whole units of a hundredth of
//! a px: a curve rounded to whole px is a staircase; rounded to tenths it still shows kinks when
//! enlarged.

use std::cell::RefCell;
use std::fmt::{self, Write};

use super::polyline::Point;
use super::style::{Color, HPos, Pen, Shape, Symbol, Words};
use super::{PlotError, metrics, rich};

/// A place in hundredths of a px.
pub(super) type Units = (i32, i32);

/// Whole units nearest to a length in px.
pub(super) fn units(px: f64) -> i32 {
    (px * 100.0).round() as i32
}

/// The place of a point in px.
pub(super) fn place((x, y): Point) -> Units {
    (units(x), units(y))
}

pub(super) type Drawn = Result<(), PlotError>;

impl From<fmt::Error> for PlotError {
    fn from(error: fmt::Error) -> Self {
        PlotError::Draw(error.to_string())
    }
}

/// A rectangle on the page, px from the upper left corner of the figure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Frame {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// The point at fractions of width (from the left) and height (from below).
    pub(super) fn at(&self, fx: f64, fy: f64) -> Point {
        (
            self.left + fx * self.width(),
            self.bottom - fy * self.height(),
        )
    }
}

/// What a figure is called, for readers who cannot see it.
pub(super) struct Naming<'a> {
    /// Prefix of the ids in the file, unique among figures on one page.
    pub(super) id: &'a str,
    /// Short title.
    pub(super) title: &'a str,
    /// What the picture shows, in words.
    pub(super) description: &'a str,
}

/// Collects SVG elements in a string.
pub(super) struct Canvas {
    out: RefCell<String>,
}

impl Canvas {
    /// Opens an SVG of `width` × `height` px on white paper.
    pub(super) fn new((width, height): Point, naming: &Naming<'_>) -> Result<Self, PlotError> {
        let mut out = String::new();
        let size = (units(width), units(height));
        let id = escape(naming.id);
        // Without `xml:space` some viewers drop the space at the beginning of a tspan, as in "x₁ = 0".
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {} {}\" role=\"img\" xml:space=\"preserve\" aria-labelledby=\"{id}-title {id}-desc\" font-family=\"{}\">",
            size.0,
            size.1,
            metrics::CSS_FAMILY
        )?;
        writeln!(
            out,
            "<title id=\"{id}-title\">{}</title>",
            escape(&rich::plain(naming.title))
        )?;
        writeln!(
            out,
            "<desc id=\"{id}-desc\">{}</desc>",
            escape(&rich::plain(naming.description))
        )?;
        writeln!(
            out,
            "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
        )?;
        Ok(Self {
            out: RefCell::new(out),
        })
    }

    /// The document; nothing may be drawn afterwards.
    pub(super) fn closed(self) -> String {
        self.out.into_inner() + "</svg>\n"
    }

    /// A polyline, px.
    pub(super) fn stroke(&self, points: &[Point], pen: &Pen) -> Drawn {
        self.path(&placed(points), pen)
    }

    /// A filled polygon, px.
    pub(super) fn fill(&self, corners: &[Point], color: Color) -> Drawn {
        self.area(&placed(corners), color)
    }

    /// The edge of a rectangle.
    pub(super) fn outline(&self, frame: &Frame, pen: &Pen) -> Drawn {
        let Frame {
            left,
            top,
            right,
            bottom,
        } = *frame;
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        // Beyond the beginning, so that all corners are joined alike.
        self.stroke(&[&corners[..], &corners[..2]].concat(), pen)
    }

    /// A polyline.
    pub(super) fn path(&self, points: &[Units], pen: &Pen) -> Drawn {
        if points.len() < 2 {
            return Ok(());
        }
        let out = &mut *self.out.borrow_mut();
        out.push_str("<path d=\"");
        trace(out, points)?;
        write!(
            out,
            "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
            pen.color.hex(),
            units(pen.width)
        )?;
        let pattern = pen.pattern();
        if !pattern.is_empty() {
            let lengths: Vec<String> = pattern
                .iter()
                .map(|length| units(*length).to_string())
                .collect();
            write!(out, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
        }
        out.push_str("/>\n");
        Ok(())
    }

    /// A marker.
    pub(super) fn symbol(&self, (x, y): Units, symbol: &Symbol) -> Drawn {
        let out = &mut *self.out.borrow_mut();
        let r = units(symbol.size / 2.0);
        let polygon = match symbol.shape {
            Shape::Circle => {
                write!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"")?;
                None
            }
            // Sides and heights are chosen so that the areas look equal to the circle's.
            Shape::Square => {
                let h = units(symbol.size * 0.45);
                Some(vec![(-h, -h), (h, -h), (h, h), (-h, h)])
            }
            Shape::Diamond => {
                let h = units(symbol.size * 0.62);
                Some(vec![(0, -h), (h, 0), (0, h), (-h, 0)])
            }
            Shape::Up | Shape::Down => {
                let (w, tall) = (units(symbol.size * 0.58), units(symbol.size * 0.67));
                let sign = if symbol.shape == Shape::Up { 1 } else { -1 };
                Some(vec![
                    (0, -sign * tall),
                    (w, sign * tall / 2),
                    (-w, sign * tall / 2),
                ])
            }
            Shape::Cross => {
                let h = units(symbol.size * 0.42);
                write!(
                    out,
                    "<path d=\"M{} {}l{d} {d}m0 -{d}l-{d} {d}\"",
                    x - h,
                    y - h,
                    d = 2 * h
                )?;
                None
            }
        };
        if let Some(corners) = polygon {
            let corners: Vec<Units> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
            out.push_str("<path d=\"");
            trace(out, &corners)?;
            out.push_str("z\"");
        }
        let fill = if symbol.shape == Shape::Cross {
            "none".to_owned()
        } else {
            symbol.fill.hex()
        };
        writeln!(
            out,
            " fill=\"{fill}\" stroke=\"{}\" stroke-width=\"{}\"/>",
            symbol.edge.hex(),
            units(symbol.edge_width)
        )?;
        Ok(())
    }

    /// A text with markup, px.
    pub(super) fn words(&self, at: Point, words: Words) -> Drawn {
        let out = &mut *self.out.borrow_mut();
        let at = place(at);
        // Vertical placement is by baseline: viewers disagree about `dominant-baseline`.
        let drop = metrics::CAP_HEIGHT * (1.0 - words.v.part());
        let drop = units(drop * words.size);
        let (x, y) = if words.upwards {
            (at.0 + drop, at.1)
        } else {
            (at.0, at.1 + drop)
        };
        let anchor = match words.h {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        write!(
            out,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"",
            units(words.size),
            words.color.hex()
        )?;
        let runs = rich::parse(&words.markup);
        // A viewer without the font sets the text in another; legends and tables hold only what is as wide as computed. Each run has its own
        // width: given for all together, viewers stretch each run to it.
        let wide = |run: &rich::Run| {
            let wide = units(metrics::run_width(run, words.size)?);
            let given = format!(" textLength=\"{wide}\" lengthAdjust=\"spacingAndGlyphs\"");
            Ok::<_, PlotError>(if wide == 0 { String::new() } else { given })
        };
        if let [run] = &runs[..] {
            out.push_str(&wide(run)?);
        }
        if words.upwards {
            write!(out, " transform=\"rotate(-90 {x} {y})\"")?;
        }
        if words.halo {
            write!(
                out,
                " stroke=\"#ffffff\" stroke-width=\"{}\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
                units(2.6)
            )?;
        }
        out.push('>');
        // `dy` moves everything after it, so each run states the difference to the run before it.
        let mut drop_before = 0;
        for run in &runs {
            let drop = units(words.size * run.level.drop());
            let mut attributes = match runs.len() {
                1 => String::new(),
                _ => wide(run)?,
            };
            if run.italic {
                attributes.push_str(" font-style=\"italic\"");
            }
            if run.bold {
                attributes.push_str(" font-weight=\"bold\"");
            }
            if run.level != rich::Level::Base {
                write!(
                    attributes,
                    " font-size=\"{}\"",
                    units(words.size * run.level.scale())
                )?;
            }
            if drop != drop_before {
                write!(attributes, " dy=\"{}\"", drop - drop_before)?;
            }
            drop_before = drop;
            let text = escape(&run.text);
            if attributes.is_empty() {
                out.push_str(&text);
            } else {
                write!(out, "<tspan{attributes}>{text}</tspan>")?;
            }
        }
        out.push_str("</text>\n");
        Ok(())
    }

    /// Rectangles as one area.
    pub(super) fn rects(&self, frames: &[Frame], color: Color) -> Drawn {
        if frames.is_empty() {
            return Ok(());
        }
        let out = &mut *self.out.borrow_mut();
        out.push_str("<path d=\"");
        for frame in frames {
            let ((x, y), (w, h)) = corner_and_size(frame);
            write!(out, "M{x} {y}h{w}v{h}h{}z", -w)?;
        }
        // Smoothed edges would let the paper shine through between neighbours.
        writeln!(
            out,
            "\" fill=\"{}\" shape-rendering=\"crispEdges\"/>",
            color.hex()
        )?;
        Ok(())
    }

    /// A filled polygon.
    pub(super) fn area(&self, corners: &[Units], color: Color) -> Drawn {
        if corners.len() < 3 {
            return Ok(());
        }
        let out = &mut *self.out.borrow_mut();
        out.push_str("<path d=\"");
        trace(out, corners)?;
        writeln!(out, "z\" fill=\"{}\"/>", color.hex())?;
        Ok(())
    }

    /// A filled rectangle.
    pub(super) fn rect(&self, frame: &Frame, color: Color) -> Drawn {
        let ((x, y), (w, h)) = corner_and_size(frame);
        let (out, color) = (&mut *self.out.borrow_mut(), color.hex());
        writeln!(
            out,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{color}\"/>"
        )?;
        Ok(())
    }
}

fn placed(points: &[Point]) -> Vec<Units> {
    points.iter().copied().map(place).collect()
}

/// The upper left corner of a rectangle, and its width and height.
fn corner_and_size(frame: &Frame) -> (Units, Units) {
    let (x, y) = place((frame.left, frame.top));
    let (right, bottom) = place((frame.right, frame.bottom));
    ((x, y), (right - x, bottom - y))
}

/// Path data: one absolute point, then differences, which are shorter.
fn trace(out: &mut String, points: &[Units]) -> fmt::Result {
    let mut before: Option<Units> = None;
    for &(x, y) in points {
        match before {
            None => write!(out, "M{x} {y}l")?,
            Some((x0, y0)) if (x, y) != (x0, y0) => {
                // A minus sign separates by itself.
                let (dx, dy) = (x - x0, y - y0);
                let is_apart = out.ends_with('l') || dx < 0;
                let first = if is_apart { "" } else { " " };
                let second = if dy < 0 { "" } else { " " };
                write!(out, "{first}{dx}{second}{dy}")?;
            }
            Some(_) => {}
        }
        before = Some((x, y));
    }
    // All points in one place: a line of no length keeps the path valid.
    if out.ends_with('l') {
        out.push_str("0 0");
    }
    Ok(())
}

/// Text as XML character data or attribute value.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(draw: impl FnOnce(&Canvas) -> Drawn) -> String {
        let naming = Naming {
            id: "f",
            title: "A & B",
            description: "*x* < 1",
        };
        let canvas = Canvas::new((20.0, 10.0), &naming).unwrap();
        draw(&canvas).unwrap();
        canvas.closed()
    }

    #[test]
    fn the_document_is_named_and_escaped() {
        let svg = document(|_| Ok(()));
        let document = roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("role"), Some("img"));
        assert_eq!(root.attribute("viewBox"), Some("0 0 2000 1000"));
        assert!(svg.contains("<title id=\"f-title\">A &amp; B</title>"));
        assert!(svg.contains("x &lt; 1"));
    }

    #[test]
    fn subscripts_return_to_the_line() {
        let svg = document(|canvas| canvas.words((0.5, 0.5), Words::new("*x*_1 + 2", 10.0)));
        let document = roxmltree::Document::parse(&svg).unwrap();
        let runs = document
            .descendants()
            .filter(|node| node.has_tag_name("tspan"));
        let told: Vec<_> = runs
            .map(|run| {
                let [style, size, dy] =
                    ["font-style", "font-size", "dy"].map(|name| run.attribute(name));
                (run.text().unwrap(), style, size, dy)
            })
            .collect();
        assert_eq!(
            told,
            [
                ("x", Some("italic"), None, None),
                ("1", None, Some("720"), Some("240")),
                (" + 2", None, None, Some("-240")),
            ]
        );
    }

    #[test]
    fn a_text_is_as_wide_as_computed_in_any_font() {
        let given = |markup: &str| -> Vec<i32> {
            let svg = document(|canvas| canvas.words((0.5, 0.5), Words::new(markup, 10.0)));
            let lengths = svg.split(" textLength=\"").skip(1);
            let digits = lengths.map(|rest| rest.split('"').next().unwrap());
            digits.map(|wide| wide.parse().unwrap()).collect()
        };
        let wide = |markup: &str| units(metrics::width(markup, 10.0).unwrap());
        assert_eq!(given("x + 2"), [wide("x + 2")]);
        assert_eq!(given("*x*_1 + 2"), [wide("*x*"), wide("_1"), wide(" + 2")]);
    }

    #[test]
    fn paths_use_differences() {
        let svg =
            document(|canvas| canvas.path(&[(10, 10), (15, 8), (15, 8), (12, 9)], &Pen::default()));
        assert!(svg.contains("d=\"M10 10l5-2-3 1\""));
    }
}
