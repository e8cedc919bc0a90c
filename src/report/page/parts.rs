//! Elements shared by the sections of the page.

use maud::{Markup, PreEscaped, html};

use super::super::figures::Picture;
use super::super::ledger::Ledger;

/// Contents of the page.
pub struct Report<'a> {
    /// Claims, figures, matrix, convergence, scan, errata.
    pub ledger: &'a Ledger,
    /// The convergence of the listing for small steps.
    pub convergence: Picture,
    /// Attractors of the stated model as each parameter changes.
    pub scan: Picture,
}

/// Sections in order: anchor and heading.
pub(super) const SECTIONS: [(&str, &str); 9] = [
    ("claims", "Claims"),
    ("cause", "What makes Fig. 8"),
    ("existence", "Does the stated model stick and slip?"),
    ("readings", "How Figs. 10–12 can be read"),
    ("errata", "Errata"),
    ("figures", "Other figures"),
    ("methods", "Methods"),
    ("cite", "How to cite"),
    ("remake", "How this page was made"),
];

/// A section's heading.
pub(super) fn heading(anchor: &str) -> Markup {
    let section = SECTIONS.iter().find(|(name, _)| *name == anchor);
    html! { h2 id=(anchor) { (section.map_or(anchor, |(_, heading)| heading)) } }
}

/// A link to a file of the project; the page stands in `report/`.
pub(super) fn file(path: &str, label: &str) -> Markup {
    html! { a href={ "../" (path) } { (label) } }
}

/// A link to the file of a function, written as `file::name`.
pub(super) fn function(source: &str) -> Markup {
    let (path, name) = source.split_once("::").unwrap_or((source, source));
    file(path, name)
}

/// Symbols that are written in letters and digits: the letters, and what is set.
const SYMBOLS: [(&str, &str); 21] = [
    ("mu", "μ"),
    ("xi", "ξ"),
    ("sigma", "σ"),
    ("delta", "δ"),
    ("omega", "ω"),
    ("lambda", "λ"),
    ("μ", "μ"),
    ("ξ", "ξ"),
    ("λ", "λ"),
    ("c", "c"),
    ("f", "f"),
    ("h", "h"),
    ("k", "k"),
    ("m", "m"),
    ("t", "t"),
    ("x", "x"),
    ("z", "z"),
    ("S", "S"),
    // With a letter for an index.
    ("vp", "v"),
    ("nk", "n"),
    ("ni", "n"),
];

/// Text with symbols set as symbols: `mu0` with its index, `x1^3` with index and power, `sqrt(3)`
/// as a root, `(x + z)^2` with its power, `2e-4` with a power of ten, ` - ` with a minus sign.
pub(super) fn typeset(text: &str) -> Markup {
    let escape = |text: &str| html! { (text) }.into_string();
    let (mut set, mut rest, mut before) = (String::new(), text, ' ');
    while let Some(first) = rest.chars().next() {
        if before == ' ' && rest.starts_with("- ") {
            set.push('−');
            (before, rest) = ('−', &rest[1..]);
            continue;
        }
        if before.is_ascii_digit()
            && let Some((exponent, length)) = power_of_ten(rest)
        {
            // A factor of one is left out.
            let number = |c: char| c.is_ascii_digit() || c == '.';
            match set.strip_suffix('1') {
                Some(other) if !other.ends_with(number) => set.truncate(other.len()),
                _ => set.push('·'),
            }
            set += &html! { "10" sup { (exponent) } }.into_string();
            (before, rest) = (' ', &rest[length..]);
            continue;
        }
        let found = match before.is_alphanumeric() || "_.^\\".contains(before) {
            true => None,
            false => root(rest).or_else(|| symbol(rest)),
        };
        let found = found.or_else(|| {
            let (power, length) = power(rest)?;
            Some((html! { sup { (power) } }.into_string(), length))
        });
        let length = match found {
            Some((markup, length)) => {
                set += &markup;
                length
            }
            None => {
                set += &escape(&rest[..first.len_utf8()]);
                first.len_utf8()
            }
        };
        before = rest[..length].chars().next_back().unwrap_or(' ');
        rest = &rest[length..];
    }
    PreEscaped(set)
}

/// The power at the begin of a text, digits or what is in parentheses, and its length there.
fn power(text: &str) -> Option<(String, usize)> {
    let power = text.strip_prefix('^')?;
    if let Some(inner) = power.strip_prefix('(') {
        let (inner, _) = inner.split_once(')')?;
        return Some((format!("({inner})"), inner.len() + 3));
    }
    let digits = power.find(|c: char| !c.is_ascii_digit());
    let digits = digits.unwrap_or(power.len());
    (digits > 0).then(|| (power[..digits].to_owned(), digits + 1))
}

/// The exponent of a number in scientific notation, from its `e` on, and its length there.
fn power_of_ten(text: &str) -> Option<(String, usize)> {
    let exponent = text.strip_prefix('e')?;
    let unsigned = exponent.strip_prefix(['-', '−']).unwrap_or(exponent);
    let digits = unsigned.find(|c: char| !c.is_ascii_digit());
    let digits = digits.unwrap_or(unsigned.len());
    let sign = if unsigned.len() < exponent.len() {
        "−"
    } else {
        ""
    };
    let ends = !unsigned[digits..].starts_with(char::is_alphanumeric);
    let length = text.len() - unsigned.len() + digits;
    (digits > 0 && ends).then(|| (format!("{sign}{}", &unsigned[..digits]), length))
}

/// The square root at the begin of a text, and its length there.
fn root(text: &str) -> Option<(String, usize)> {
    let (inner, _) = text.strip_prefix("sqrt(")?.split_once(')')?;
    let length = "sqrt()".len() + inner.len();
    let inner = match inner.chars().all(char::is_alphanumeric) {
        true => inner.to_owned(),
        false => format!("({inner})"),
    };
    Some((format!("√{}", typeset(&inner).into_string()), length))
}

/// The symbol at the begin of a text, and its length there.
fn symbol(text: &str) -> Option<(String, usize)> {
    let end = |from: usize, is: fn(char) -> bool| {
        let other = text[from..].find(|c| !is(c));
        other.map_or(text.len(), |length| from + length)
    };
    let letters = end(0, char::is_alphabetic);
    let (name, set) = SYMBOLS.iter().find(|(name, _)| *name == &text[..letters])?;
    let digits = end(letters, |c| c.is_ascii_digit());
    let mut length = digits;
    let index = match *name {
        "vp" | "nk" | "ni" => &name[name.len() - 1..],
        _ if text[letters..].starts_with('_') => {
            length = end(letters + 1, char::is_alphanumeric);
            &text[letters + 1..length]
        }
        _ if text[digits..].starts_with(",0") && digits > letters => {
            length += 2;
            &text[letters..length]
        }
        _ => &text[letters..digits],
    };
    let power = power(&text[length..]);
    // A single letter without index and power is a word or set by the text itself.
    if index.is_empty() && power.is_none() && name == set {
        return None;
    }
    let power_length = power.as_ref().map_or(0, |(_, length)| *length);
    if text[length + power_length..].starts_with(char::is_alphanumeric) {
        return None;
    }
    let markup = html! {
        i { (set) } @if !index.is_empty() { sub { (index) } }
        @if let Some((power, _)) = &power { sup { (power) } }
    };
    Some((markup.into_string(), length + power_length))
}

/// The head of a table.
pub(super) fn columns(names: &[&str]) -> Markup {
    html! { thead { tr { @for name in names { th scope="col" { (name) } } } } }
}

#[cfg(test)]
mod tests {
    use super::typeset;

    #[test]
    fn symbols_are_set_and_words_are_not() {
        for (text, expected) in [
            ("mu0 <", "<i>μ</i><sub>0</sub> &lt;"),
            (
                "x1^3 − x1",
                "<i>x</i><sub>1</sub><sup>3</sup> − <i>x</i><sub>1</sub>",
            ),
            (
                "h2 = x1,0^(k)",
                "<i>h</i><sub>2</sub> = <i>x</i><sub>1,0</sub><sup>(k)</sup>",
            ),
            (
                "vp, nk > ni",
                "<i>v</i><sub>p</sub>, <i>n</i><sub>k</sub> &gt; <i>n</i><sub>i</sub>",
            ),
            ("λ1 of sigma", "<i>λ</i><sub>1</sub> of <i>σ</i>"),
            (
                "(k2 z^3 - z)^2/m^2",
                "(<i>k</i><sub>2</sub> <i>z</i><sup>3</sup> − z)<sup>2</sup>/<i>m</i><sup>2</sup>",
            ),
            (
                "z_k at t_entry",
                "<i>z</i><sub>k</sub> at <i>t</i><sub>entry</sub>",
            ),
            (
                "2 sqrt(3)/9, sqrt(x1 + 1)",
                "2 √3/9, √(<i>x</i><sub>1</sub> + 1)",
            ),
            (
                "RK4, fig10.lambda.1, C5, x, k, 2e4a",
                "RK4, fig10.lambda.1, C5, x, k, 2e4a",
            ),
            (
                "h = 1e-4, −2.50e−16 to 1.1e3, 21e-4",
                "h = 10<sup>−4</sup>, −2.50·10<sup>−16</sup> to 1.1·10<sup>3</sup>, \
                 21·10<sup>−4</sup>",
            ),
        ] {
            assert_eq!(typeset(text).into_string(), expected, "{text}");
        }
    }
}
