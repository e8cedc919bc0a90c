//! The plotters backend that writes the SVG.
//!
//! plotters' own SVG backend has no dashes and sets text in one font; this one keeps text as
//! `<text>` with italics and subscripts. One backend unit is a hundredth of a px, as plotters
//! rounds coordinates to whole units. A curve rounded to whole px is a staircase, and one rounded
//! to tenths shows kinks when enlarged.

use std::fmt::{self, Write};

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, DrawingBackend, DrawingErrorKind};

use super::color::Color;
use super::marks::{Shape, Symbol, Words};
use super::metrics;
use super::pen::Pen;
use super::rich;

/// Backend units per px.
const UNITS_PER_PX: f64 = 100.0;

/// Whole backend units nearest to a length in px.
pub(super) fn units(px: f64) -> i32 {
    (px * UNITS_PER_PX).round() as i32
}

/// The result of drawing an element of plotters.
pub(super) type Drawn = Result<(), DrawingErrorKind<fmt::Error>>;

/// Converts the result of writing to a string into that of drawing.
pub(super) fn drawn(written: fmt::Result) -> Drawn {
    written.map_err(DrawingErrorKind::DrawingError)
}

/// Collects SVG elements in a string.
pub(super) struct Canvas<'a> {
    size: (u32, u32),
    out: &'a mut String,
}

impl<'a> Canvas<'a> {
    /// Opens an SVG of `width` × `height` px on white paper. It has a title and a description for
    /// readers who cannot see it. The id is the prefix of the ids in the file.
    pub(super) fn new(
        out: &'a mut String,
        (width, height): (f64, f64),
        [id, title, description]: [&str; 3],
    ) -> Result<Self, fmt::Error> {
        let size = (units(width).unsigned_abs(), units(height).unsigned_abs());
        let id = escape(id);
        // Without `xml:space` some viewers drop the space at the beginning of a tspan, as in "x₁ =
        // 0".
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {} {}\" role=\"img\" xml:space=\"preserve\" \
             aria-labelledby=\"{id}-title {id}-desc\" font-family=\"{}\">",
            size.0,
            size.1,
            metrics::CSS_FAMILY
        )?;
        writeln!(
            out,
            "<title id=\"{id}-title\">{}</title>",
            escape(&rich::plain(title))
        )?;
        writeln!(
            out,
            "<desc id=\"{id}-desc\">{}</desc>",
            escape(&rich::plain(description))
        )?;
        writeln!(
            out,
            "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
        )?;
        Ok(Self { size, out })
    }

    /// Polylines with these numbers of points, one after the other, in one path.
    pub(super) fn stroke(
        &mut self,
        points: &[BackendCoord],
        lengths: &[usize],
        pen: &Pen,
    ) -> fmt::Result {
        if points.len() < 2 {
            return Ok(());
        }
        self.path(points, lengths, "")?;
        write!(
            self.out,
            " fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
            pen.color.hex(),
            units(pen.width)
        )?;
        let pattern = pen.pattern();
        if !pattern.is_empty() {
            let lengths: Vec<String> = pattern
                .iter()
                .map(|length| units(*length).to_string())
                .collect();
            write!(self.out, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
        }
        if pen.is_round {
            self.out.push_str(" stroke-linecap=\"round\"");
        }
        self.out.push_str("/>\n");
        Ok(())
    }

    /// A marker.
    pub(super) fn symbol(&mut self, (x, y): BackendCoord, symbol: &Symbol) -> fmt::Result {
        let r = units(symbol.size / 2.0);
        let mut fill = symbol.fill.hex();
        let corners = match symbol.shape {
            Shape::Circle => {
                write!(self.out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"")?;
                vec![]
            }
            // Sides and heights are chosen so that the areas look equal to the circle's.
            Shape::Square => {
                let h = units(symbol.size * 0.45);
                vec![(-h, -h), (h, -h), (h, h), (-h, h)]
            }
            Shape::Diamond => {
                let h = units(symbol.size * 0.62);
                vec![(0, -h), (h, 0), (0, h), (-h, 0)]
            }
            Shape::Up | Shape::Down => {
                let (w, tall) = (units(symbol.size * 0.58), units(symbol.size * 0.67));
                let sign = if symbol.shape == Shape::Up { 1 } else { -1 };
                let base = sign * tall / 2;
                vec![(0, -sign * tall), (w, base), (-w, base)]
            }
            Shape::Cross => {
                let h = units(symbol.size * 0.42);
                write!(
                    self.out,
                    "<path d=\"M{} {}l{d} {d}m0 -{d}l-{d} {d}\"",
                    x - h,
                    y - h,
                    d = 2 * h
                )?;
                fill = "none".to_owned();
                vec![]
            }
        };
        if !corners.is_empty() {
            let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
            self.path(&corners, &[corners.len()], "z")?;
        }
        writeln!(
            self.out,
            " fill=\"{fill}\" stroke=\"{}\" stroke-width=\"{}\"/>",
            symbol.edge.hex(),
            units(symbol.edge_width)
        )?;
        Ok(())
    }

    /// A text with markup, at `at`.
    pub(super) fn words(&mut self, at: BackendCoord, words: &Words) -> fmt::Result {
        // Vertical placement is by baseline: viewers disagree about `dominant-baseline`.
        let (h, v) = words.anchor;
        let drop = match v {
            VPos::Top => metrics::CAP_HEIGHT,
            VPos::Center => metrics::CAP_HEIGHT / 2.0,
            VPos::Bottom => 0.0,
        };
        let drop = units(drop * words.size);
        let (x, y) = if words.upwards {
            (at.0 + drop, at.1)
        } else {
            (at.0, at.1 + drop)
        };
        let anchor = match h {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        write!(
            self.out,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"",
            units(words.size),
            words.color.hex()
        )?;
        let runs = rich::parse(&words.markup);
        // A viewer without the font uses another one, but legends and tables need texts of the
        // computed width. The width is given for each run: if it is given for the whole text,
        // viewers stretch each run to it.
        let wide = |run: &rich::Run| match metrics::run_width(run, words.size).map(units) {
            Ok(0) => Ok(String::new()),
            Ok(wide) => Ok(format!(
                " textLength=\"{wide}\" lengthAdjust=\"spacingAndGlyphs\""
            )),
            Err(_) => Err(fmt::Error),
        };
        if let [run] = &runs[..] {
            self.out.push_str(&wide(run)?);
        }
        if words.upwards {
            write!(self.out, " transform=\"rotate(-90 {x} {y})\"")?;
        }
        if words.halo {
            write!(
                self.out,
                " stroke=\"#ffffff\" stroke-width=\"{}\" stroke-linejoin=\"round\" \
                    paint-order=\"stroke\"",
                units(2.6)
            )?;
        }
        self.out.push('>');
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
                self.out.push_str(&text);
            } else {
                write!(self.out, "<tspan{attributes}>{text}</tspan>")?;
            }
        }
        self.out.push_str("</text>\n");
        Ok(())
    }

    /// Rectangles in one path: upper left and lower right corners in turn.
    pub(super) fn tiles(&mut self, corners: &[BackendCoord], color: Color) -> fmt::Result {
        if corners.is_empty() {
            return Ok(());
        }
        self.out.push_str("<path d=\"");
        for pair in corners.chunks_exact(2) {
            let ((x, y), (right, bottom)) = (pair[0], pair[1]);
            let (wide, tall) = (right - x, bottom - y);
            write!(self.out, "M{x} {y}h{wide}v{tall}h{}z", -wide)?;
        }
        // Smoothed edges would let the paper shine through between neighbours.
        writeln!(
            self.out,
            "\" fill=\"{}\" shape-rendering=\"crispEdges\"/>",
            color.hex()
        )
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, corners: &[BackendCoord], color: Color) -> fmt::Result {
        if corners.len() < 3 {
            return Ok(());
        }
        self.path(corners, &[corners.len()], "z")?;
        writeln!(self.out, " fill=\"{}\"/>", color.hex())
    }

    /// A filled rectangle between its upper left and its lower right corner.
    pub(super) fn rect(&mut self, corners: &[BackendCoord], color: Color) -> fmt::Result {
        let &[(x, y), (right, bottom)] = corners else {
            return Ok(());
        };
        let (w, h, color) = (right.abs_diff(x), bottom.abs_diff(y), color.hex());
        writeln!(
            self.out,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{color}\"/>"
        )
    }

    /// Begins a path of several lines: one absolute point, then differences, which are shorter.
    fn path(&mut self, points: &[BackendCoord], lengths: &[usize], end: &str) -> fmt::Result {
        self.out.push_str("<path d=\"");
        let (mut before, mut rest) = ((0, 0), points);
        for (k, &length) in lengths.iter().enumerate() {
            let (line, others) = rest.split_at(length.min(rest.len()));
            rest = others;
            for (i, &(x, y)) in line.iter().enumerate() {
                let (dx, dy) = (x - before.0, y - before.1);
                // A minus sign separates by itself.
                let between = if dy < 0 { "" } else { " " };
                if i == 0 {
                    let move_to = if k == 0 { 'M' } else { 'm' };
                    let between = if k == 0 { " " } else { between };
                    write!(self.out, "{move_to}{dx}{between}{dy}l")?;
                } else if (dx, dy) != (0, 0) {
                    if dx >= 0 && !self.out.ends_with('l') {
                        self.out.push(' ');
                    }
                    write!(self.out, "{dx}{between}{dy}")?;
                }
                before = (x, y);
            }
            // All points in one place: a line of no length keeps the path valid.
            if self.out.ends_with('l') {
                self.out.push_str("0 0");
            }
        }
        write!(self.out, "{end}\"")
    }
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

impl DrawingBackend for Canvas<'_> {
    type ErrorType = fmt::Error;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    /// Closes the document; nothing may be drawn afterwards.
    fn present(&mut self) -> Drawn {
        drawn(self.out.write_str("</svg>\n"))
    }

    /// Shapes are drawn by [`super::elements`], which never ask for single pixels.
    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        let (red, green, blue) = color.rgb;
        drawn(self.rect(&[(x, y), (x + 1, y + 1)], Color(red, green, blue)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(draw: impl FnOnce(&mut Canvas<'_>) -> Drawn) -> String {
        let mut out = String::new();
        let texts = ["f", "A & B", "*x* < 1"];
        let mut canvas = Canvas::new(&mut out, (20.0, 10.0), texts).unwrap();
        draw(&mut canvas).unwrap();
        canvas.present().unwrap();
        out
    }

    fn lower_left(markup: &str) -> Words {
        Words::new(markup, 10.0, (HPos::Left, VPos::Bottom))
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
        let svg = document(|canvas| drawn(canvas.words((50, 50), &lower_left("*x*_1 + 2"))));
        let document = roxmltree::Document::parse(&svg).unwrap();
        let runs = document
            .descendants()
            .filter(|node| node.has_tag_name("tspan"));
        let attributes: Vec<_> = runs
            .map(|run| {
                let [style, size, dy] =
                    ["font-style", "font-size", "dy"].map(|name| run.attribute(name));
                (run.text().unwrap(), style, size, dy)
            })
            .collect();
        assert_eq!(
            attributes,
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
            let svg = document(|canvas| drawn(canvas.words((50, 50), &lower_left(markup))));
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
        let svg = document(|canvas| {
            let points = [(10, 10), (15, 8), (15, 8), (12, 9), (13, 7), (13, 7)];
            drawn(canvas.stroke(&points, &[4, 2], &Pen::default()))
        });
        assert!(svg.contains("d=\"M10 10l5-2-3 1m1-2l0 0\""));
    }
}
