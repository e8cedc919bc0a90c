//! Results of the analysis of a series, in words.

use std::fmt::Write;

use stickslip::error::readable;
use stickslip_series::{
    Balance, DataExponent, DataSpectrum, Divergence, EmbeddingChoice, Estimator, Neighbourhood,
    OK_ERRORS, Origin, Reversal, Statistics, Status, SurrogateTest, status_word,
};

use crate::render::{self, OutputError};
use crate::table::NumberTable;

/// The reliability of the status `ok` was measured on series of at least this many points.
const COUNTED_POINTS: usize = 5000;
/// Unit of exponents.
pub(super) const UNIT: &str =
    "natural logarithms of growth per unit of the time that dt is given in";

/// The spectrum and the results that accompany it.
pub(super) struct Findings {
    /// The spectrum, of the columns or of delayed values.
    pub(super) spectrum: DataSpectrum,
    /// The given divergence and the comparison with the spectrum; `None` for delayed values.
    pub(super) balance: Option<(f64, Balance)>,
    /// The embedding, if the columns were embedded.
    pub(super) embedded: Option<Embedded>,
    /// The largest exponent from diverging neighbours, if there are enough points.
    pub(super) divergence: Option<Divergence>,
    /// The test against surrogates, if requested.
    pub(super) surrogates: Option<SurrogateTest>,
}

/// An embedding and its results.
pub(super) struct Embedded {
    /// Delay and dimension, with the evidence for them.
    pub(super) choice: EmbeddingChoice,
    /// Origins of the exponents: the system or the embedding.
    pub(super) reversal: Reversal,
}

/// Five significant digits or five decimals, whichever is shorter.
pub(super) fn short(v: f64) -> String {
    if v.is_nan() {
        "–".into()
    } else if !v.is_finite() || v == 0.0 {
        format!("{v}")
    } else if (1e-3..1e5).contains(&v.abs()) {
        format!("{v:.5}")
    } else {
        format!("{v:.2e}")
    }
}

/// A value with its standard error.
fn with_error((value, stderr): (f64, f64)) -> String {
    format!("{} ± {}", short(value), short(stderr))
}

/// Numbers, from 1, of the entries that are true, for a list.
pub(super) fn numbers(all: impl IntoIterator<Item = bool>) -> Vec<String> {
    let holding = (1..).zip(all).filter(|(_, holds)| *holds);
    holding.map(|(i, _): (usize, _)| i.to_string()).collect()
}

impl Findings {
    /// The status of an exponent in a word.
    pub(super) fn status(&self, i: usize) -> &'static str {
        let embedded = self.embedded.as_ref();
        status_word(
            &self.spectrum,
            embedded.map(|embedded| &embedded.reversal),
            i,
        )
    }

    pub(super) fn is_ok(&self, i: usize) -> bool {
        self.status(i) == Status::Ok.word()
    }

    /// Whether the next delayed value is independent of those before.
    pub(super) fn is_noise(&self) -> bool {
        let embedded = self.embedded.as_ref();
        embedded.is_some_and(|embedded| embedded.choice.is_noise)
    }

    /// Whether an exponent that the data determine is due to the embedding.
    pub(super) fn is_spurious(&self, i: usize) -> bool {
        self.status(i) == Origin::Spurious.word()
    }

    /// The spectrum and its evidence, for the terminal.
    pub(super) fn table(&self, source: &NumberTable) -> String {
        let spectrum = &self.spectrum;
        let time = source.time.as_ref();
        let mut text = format!(
            "{}: {} points of ({}), dt = {}{}\n",
            source.input,
            source.rows(),
            source.names.join(", "),
            readable(source.dt),
            time.map_or(String::new(), |name| format!(" from column {name}")),
        );
        if let Some(embedded) = &self.embedded {
            text += &embedded.text(source);
        }
        text.push('\n');
        let by_rank = format!("by rank {}", spectrum.fixed_rank);
        let mut row =
            |index: &str, numbers: [&str; 3], status, fixed: &str, direction, slope: &str| {
                let [exponent, stderr, sensitivity] = numbers;
                let _ = writeln!(
                    text,
                    "{index:>5}  {exponent:>12}  {stderr:>10}  {sensitivity:>15}  {status:<13} \
                    {fixed:>15}  {direction:<10} {slope:>5}"
                );
            };
        let names = ["exponent", "stderr", "eps_sensitivity"];
        row("index", names, "status", &by_rank, "direction", "slope");
        for (i, exponent) in spectrum.exponents.iter().enumerate() {
            let direction = &spectrum.directions[i];
            let fixed = exponent.fixed_rank.map_or(f64::NAN, |(value, _)| value);
            let value = value(exponent, self.is_spurious(i));
            let [stderr, sensitivity] = [exponent.stderr, exponent.eps_sensitivity].map(short);
            let slope = match direction.slope {
                slope if slope.is_nan() => "–".to_owned(),
                slope => format!("{slope:.2}"),
            };
            row(
                &(i + 1).to_string(),
                [&value, &stderr, &sensitivity],
                self.status(i),
                &short(fixed),
                direction.kind.word(),
                &slope,
            );
        }
        let _ = writeln!(
            text,
            "\n\
             {} tangent direction{}: {}; a value in brackets does not belong to the system.\n\
             {}; eps_sensitivity is the change with neighbourhoods of twice the size, a measure of \
             bias.\n\
             Exponents are {UNIT}.",
            spectrum.dimension,
            if spectrum.dimension == 1 { "" } else { "s" },
            self.determined(),
            estimator(spectrum)
        );
        if let Some(embedded) = &self.embedded {
            text += &embedded.origins(spectrum);
        }
        if let Some((divergence, balance)) = &self.balance {
            text += &against_divergence(spectrum, *divergence, balance);
        }
        if let Some(divergence) = &self.divergence {
            text += &by_divergence(divergence);
        }
        for note in self.notes(source) {
            let _ = writeln!(text, "{note}");
        }
        if let Some(test) = &self.surrogates {
            text += &against_surrogates(test);
        }
        let (counts, settings) = (&spectrum.neighbours, &spectrum.settings);
        let _ = writeln!(
            text,
            "{} reference points, {} starved; residual ratio {}; neighbours {} to {}, median {}; \
             mean eps {} ({} of the spread); {}, Theiler window {}, step {}, {}",
            spectrum.references,
            spectrum.starved,
            short(spectrum.residual_ratio),
            counts.min,
            counts.max,
            counts.median,
            short(spectrum.mean_eps),
            short(spectrum.mean_eps / spectrum.spread),
            match settings.neighbours {
                Neighbourhood::Ball { eps, min, max } =>
                    format!("eps {}, neighbours {min}-{max}", readable(eps)),
                Neighbourhood::Nearest(k) => format!("nearest {k}"),
            },
            settings.theiler.unwrap_or(0),
            settings.step,
            if settings.affine { "affine" } else { "linear" },
        );
        if !(0..spectrum.exponents.len()).all(|i| self.is_ok(i)) {
            text += "What the statuses mean: --help\n";
        }
        text
    }

    /// Number of tangent directions with a reliable exponent.
    fn determined(&self) -> String {
        let dimension = self.spectrum.dimension;
        match (0..dimension).filter(|&i| self.is_ok(i)).count() {
            _ if self.is_noise() => "noise has as many as are examined, and no exponent".into(),
            0 => "no exponent is ok".into(),
            1 => "1 exponent is ok".into(),
            ok => format!("{ok} exponents are ok"),
        }
    }

    /// Notes on exponents with the status `ok`: which of them have an uncertain sign, and that the
    /// reliability of `ok` was not measured for so few points.
    pub(super) fn notes(&self, source: &NumberTable) -> Vec<String> {
        let spectrum = &self.spectrum;
        let mut notes = Vec::new();
        let exponents = spectrum.exponents.iter().enumerate();
        let around_zero = numbers(exponents.map(|(i, exponent)| {
            self.is_ok(i) && exponent.value.abs() <= OK_ERRORS * exponent.stderr
        }));
        if !around_zero.is_empty() {
            let plural = if around_zero.len() > 1 { "s" } else { "" };
            notes.push(format!(
                "Zero is within two stderr of exponent{plural} {}: the sign is uncertain, although \
                    the status is ok.",
                around_zero.join(", ")
            ));
        }
        let rows = source.rows();
        let is_any_ok = (0..spectrum.exponents.len()).any(|i| self.is_ok(i));
        if is_any_ok && rows < COUNTED_POINTS && spectrum.sizes.is_some() {
            notes.push(format!(
                "The reliability of ok was measured on series of at least {COUNTED_POINTS} points; \
                    this series has {rows}."
            ));
        }
        notes
    }

    /// Columns `index,exponent,stderr,status` in full precision. An annihilated direction has
    /// `-inf`, and cells without a value are empty.
    pub(super) fn csv(&self) -> Result<String, OutputError> {
        let number = |value: f64| (!value.is_nan()).then_some(value);
        let exponent = |&i: &usize| &self.spectrum.exponents[i];
        let table = render::Table::new()
            .column("index", |i: &usize| i + 1)
            .column("exponent", |i| number(exponent(i).value))
            .column("stderr", |i| number(exponent(i).stderr))
            .column("status", |&i| self.status(i));
        let table = table.csv("spectrum", 0..self.spectrum.exponents.len())?;
        Ok(String::from_utf8_lossy(&table.bytes).into_owned())
    }
}

/// The estimator, and what its error includes.
fn estimator(spectrum: &DataSpectrum) -> String {
    let Some(sizes) = &spectrum.sizes else {
        let why = match spectrum.settings.estimator {
            Estimator::SanoSawada => "",
            Estimator::Extrapolated { .. } => {
                " (no direction is tangent, and nothing to extrapolate)"
            }
        };
        return format!("Sano-Sawada, Eqs. (25) and (26){why}: stderr is statistical only");
    };
    let tangent = spectrum.exponents.iter().take(spectrum.dimension);
    let uncorrected: Vec<String> = tangent
        .map(|exponent| short(exponent.sano_sawada.0))
        .collect();
    let ([few, many], [smaller, larger]) = (sizes.neighbours, sizes.radius.map(short));
    format!(
        "Extrapolated to size zero from {} maps of {few} and {many} neighbours, mean distance \
         {smaller} and {larger}; by Sano-Sawada, Eqs. (25) and (26), no correction: {}.\n\
         stderr holds scatter over time and extrapolation",
        sizes.degree.word(),
        uncorrected.join(", ")
    )
}

fn value(exponent: &DataExponent, is_spurious: bool) -> String {
    let value = short(exponent.value);
    match exponent.status {
        Status::Unidentified if exponent.value.is_nan() => value,
        Status::Unidentified => format!("({value})"),
        _ if is_spurious => format!("({value})"),
        _ => value,
    }
}

impl Embedded {
    /// Whether exponent `i` is due to the embedding and not to the system.
    pub(super) fn is_spurious(&self, i: usize) -> bool {
        self.reversal.origins.get(i) == Some(&Origin::Spurious)
    }

    /// Describes the embedding of the series and its reasons.
    fn text(&self, source: &NumberTable) -> String {
        let choice = &self.choice;
        // A bare number could be read as a value.
        let column = |name: &String| match name.parse::<usize>() {
            Ok(_) => format!("column {name}"),
            Err(_) => name.clone(),
        };
        let columns: Vec<String> = source.names.iter().map(column).collect();
        let cao = match choice.cao {
            Some(dimension) => dimension.to_string(),
            None => format!("none up to {}", choice.dimensions.len()),
        };
        format!(
            "embedded: {} values of {} with a delay of {} points ({}); dimension: {}; by Cao's \
                method {cao}\n",
            choice.embedding.dimension,
            columns.join(" and of "),
            choice.embedding.delay,
            choice.delay_reason.words(),
            choice.dimension_reason.words(),
        )
    }

    /// Describes the origins of the exponents: the system or the embedding.
    fn origins(&self, spectrum: &DataSpectrum) -> String {
        let [system, spurious, unknown] =
            [Origin::System, Origin::Spurious, Origin::Unknown].map(|origin| {
                let all = self.reversal.origins.iter();
                numbers(all.map(|one| *one == origin)).join(", ")
            });
        if system.is_empty() && spurious.is_empty() {
            return "Which exponents are the system's and which the embedding's is not determined.\n"
                .into();
        }
        let reversed = if self.reversal.is_conclusive {
            " and by time reversal"
        } else {
            "; the reversed series does not reproduce the first exponent, so it is not conclusive"
        };
        let or_none = |list: String| match list.as_str() {
            "" => "none".to_owned(),
            _ => list,
        };
        let unknown = match unknown.as_str() {
            "" => String::new(),
            which => format!("; not determined: {which}"),
        };
        format!(
            "The system's exponents: {}; the embedding's own: {}{unknown} (by the fit of rank \
                {}{reversed}).\n",
            or_none(system),
            or_none(spurious),
            spectrum.fixed_rank
        )
    }
}

/// Comparison of a spectrum with a known divergence.
fn against_divergence(spectrum: &DataSpectrum, divergence: f64, balance: &Balance) -> String {
    let divergence = short(divergence);
    match *balance {
        Balance::Whole { agrees, .. } => {
            let as_does = if agrees { "as does" } else { "unlike" };
            let sum = with_error(spectrum.sum);
            format!("The exponents add up to {sum}, {as_does} the divergence {divergence}.\n")
        }
        Balance::Rest {
            exponents,
            sum,
            stderr,
        } => {
            let (which, must) = match exponents {
                1 => ("exponent".to_owned(), "be"),
                more => (format!("{more} exponents"), "add up to"),
            };
            let sum = with_error((sum, stderr));
            format!(
                "With the divergence {divergence} the {which} that the data do not determine must \
                    {must} {sum}.\n"
            )
        }
        Balance::Unknown => {
            "The exponents have no sum to compare with the divergence.\n".to_owned()
        }
    }
}

/// The largest exponent from diverging neighbours.
fn by_divergence(divergence: &Divergence) -> String {
    let estimate = |exponent: Option<(f64, f64)>| {
        exponent.map_or(
            "none, distances do not grow by a factor of e in a straight line".into(),
            with_error,
        )
    };
    let curve = &divergence.rosenstein;
    let part = curve.straight.as_ref().map_or(String::new(), |straight| {
        let [from, to] = [straight.from, straight.to].map(|at| short(curve.points[at].0));
        format!(" (scatter over blocks of points alone; straight from t = {from} to {to})")
    });
    format!(
        "Largest exponent from diverging neighbours, without maps:\n  \
            Rosenstein  {}{part}\n  \
            Kantz       {}\n",
        estimate(divergence.by_rosenstein()),
        estimate(divergence.by_kantz())
    )
}

/// The outcome of the test against surrogates.
fn against_surrogates(test: &SurrogateTest) -> String {
    let range = |of: fn(&Statistics) -> f64| {
        let values = test.surrogates.iter().map(of);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        format!("{} to {}", short(low), short(high))
    };
    let verdict = if test.is_significant() {
        "the series differs from linear noise"
    } else {
        "the series does not differ from linear noise: a positive exponent may come from noise"
    };
    format!(
        "Surrogates (amplitude-adjusted, {}): {verdict}, p = {:.3}; unpredicted part {} against \
            {}, first exponent {} against {}\n",
        test.surrogates.len(),
        test.p,
        short(test.series.residual),
        range(|one| one.residual),
        short(test.series.exponent),
        range(|one| one.exponent),
    )
}
