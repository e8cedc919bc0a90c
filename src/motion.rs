//! The class of a motion, decided by its section and its exponents.

use std::fmt;
use std::str::FromStr;

use stickslip::analysis::Exponent;

/// Largest number of distinct points of the section in a periodic motion, as in
/// [`stickslip::analysis::RecurrenceSettings::most_returns`].
const MOST_POINTS: usize = 64;

/// A class of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Closes after this number of turns.
    Periodic(usize),
    /// Fills a torus: it neither closes nor grows, and an exponent besides that along the flow is
    /// zero.
    QuasiPeriodic,
    /// Nearby orbits separate: the first exponent is positive.
    Chaotic,
    /// The evidence does not decide.
    Undecided,
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Class::Periodic(1) => f.write_str("periodic"),
            Class::Periodic(2) => f.write_str("two-periodic"),
            Class::Periodic(turns) => write!(f, "{turns}-periodic"),
            Class::QuasiPeriodic => f.write_str("quasi-periodic"),
            Class::Chaotic => f.write_str("chaotic"),
            Class::Undecided => f.write_str("undecided"),
        }
    }
}

/// A word that names no class.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownClass(pub String);

impl fmt::Display for UnknownClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "'{}' is no class of motion; it must be periodic, two-periodic, 3-periodic, ..., \
             quasi-periodic, chaotic or undecided",
            self.0
        )
    }
}

impl std::error::Error for UnknownClass {}

impl FromStr for Class {
    type Err = UnknownClass;

    /// Parses the output of `Display`.
    fn from_str(text: &str) -> Result<Self, UnknownClass> {
        let unknown = || UnknownClass(text.to_owned());
        match text {
            "periodic" => Ok(Class::Periodic(1)),
            "two-periodic" => Ok(Class::Periodic(2)),
            "quasi-periodic" => Ok(Class::QuasiPeriodic),
            "chaotic" => Ok(Class::Chaotic),
            "undecided" => Ok(Class::Undecided),
            _ => {
                let turns = text.strip_suffix("-periodic").ok_or_else(unknown)?;
                let turns: usize = turns.parse().map_err(|_| unknown())?;
                if turns < 3 {
                    return Err(unknown());
                }
                Ok(Class::Periodic(turns))
            }
        }
    }
}

/// The kind of system to which the exponents belong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemKind {
    /// A flow: the exponent along its direction is zero for any motion.
    Flow,
    /// A map of the section onto itself, without such an exponent.
    ReturnMap,
}

/// The required precision of the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Relative to the section's extent, the distance below which points count as one. Default
    /// 1e-5, for a solver that locates the section.
    pub same: f64,
    /// Largest uncertainty, per unit of time, of an exponent that counts as zero: slower growth
    /// cannot be distinguished from none. Default 1e-3.
    pub resolution: f64,
}

impl Default for Criterion {
    fn default() -> Self {
        Self {
            same: 1e-5,
            resolution: 1e-3,
        }
    }
}

/// The evidence that decides the class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Points of the section.
    pub returns: usize,
    /// Number of distinct points.
    pub distinct: usize,
    /// Whether they repeat in the same order.
    pub repeats: bool,
    /// Mean time between them; infinite with fewer than two.
    pub return_time: f64,
    /// Exponents that are zero within their uncertainty.
    pub zeros: usize,
    /// Number of these with an uncertainty within [`Criterion::resolution`].
    pub resolved_zeros: usize,
    /// Whether the first exponent is positive beyond its uncertainty.
    pub positive: bool,
    /// The kind of system to which the exponents belong.
    pub system: SystemKind,
}

impl Evidence {
    /// Gathers evidence from the points `(t, x)` of the section in order of time, and the exponents
    /// in descending order as measured over `duration`. Without exponents only a periodic motion
    /// can be recognised.
    pub fn gather<const N: usize>(
        section: &[(f64, [f64; N])],
        (system, exponents, duration): (SystemKind, &[Exponent], f64),
        criterion: &Criterion,
    ) -> Self {
        let return_time = match section {
            [(first, _), .., (last, _)] => (last - first) / (section.len() - 1) as f64,
            _ => f64::INFINITY,
        };
        let labels = labels(section, criterion.same);
        let distinct = labels.iter().max().map_or(0, |most| most + 1);
        let zeros = || {
            let uncertainties = exponents.iter().map(|e| (e, e.uncertainty(duration)));
            uncertainties.filter(|(e, uncertainty)| e.value().abs() <= *uncertainty)
        };
        Self {
            returns: section.len(),
            distinct,
            repeats: labels
                .iter()
                .zip(labels.iter().skip(distinct))
                .all(|(a, b)| a == b),
            return_time,
            zeros: zeros().count(),
            resolved_zeros: zeros().filter(|one| one.1 <= criterion.resolution).count(),
            positive: exponents
                .first()
                .is_some_and(|exponent| exponent.value() > exponent.uncertainty(duration)),
            system,
        }
    }

    /// The class that the evidence shows.
    pub fn class(&self) -> Class {
        let needed = match self.system {
            SystemKind::Flow => 2,
            SystemKind::ReturnMap => 1,
        };
        // Several turns of each kind, so that a pattern has repeated.
        let closes =
            self.repeats && (1..=MOST_POINTS.min(self.returns / 4)).contains(&self.distinct);
        match (closes, self.positive) {
            (true, false) => Class::Periodic(self.distinct),
            (false, true) => Class::Chaotic,
            (false, false) if self.zeros == needed && self.resolved_zeros == needed => {
                Class::QuasiPeriodic
            }
            _ => Class::Undecided,
        }
    }
}

/// The index of each section point's distinct point, in order of appearance.
fn labels<const N: usize>(section: &[(f64, [f64; N])], same: f64) -> Vec<usize> {
    let extent = (0..N)
        .map(|i| {
            let values = || section.iter().map(|(_, x)| x[i]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max);
    let size = section
        .iter()
        .flat_map(|(_, x)| x.iter())
        .fold(0.0_f64, |size, v| size.max(v.abs()));
    let near = same * extent.max(size);
    let mut distinct: Vec<&[f64; N]> = Vec::new();
    let mut labels = Vec::with_capacity(section.len());
    for (_, x) in section {
        let label = distinct
            .iter()
            .position(|other| (0..N).all(|i| (x[i] - other[i]).abs() <= near));
        labels.push(label.unwrap_or(distinct.len()));
        if label.is_none() {
            distinct.push(x);
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::math;

    /// Points one unit of time apart.
    fn section(points: usize, x: impl Fn(usize) -> f64) -> Vec<(f64, [f64; 2])> {
        (0..points).map(|k| (k as f64, [x(k), 1.0])).collect()
    }

    fn finite(value: f64, std_error: f64) -> Exponent {
        Exponent::Finite { value, std_error }
    }

    fn class(section: &[(f64, [f64; 2])], system: SystemKind, exponents: &[Exponent]) -> Class {
        Evidence::gather(section, (system, exponents, 9000.0), &Criterion::default()).class()
    }

    #[test]
    fn sections_that_close_are_periodic_by_their_number_of_points() {
        let flow = [finite(0.0, 1e-5), finite(-0.01, 1e-4)];
        for (period, name) in [(1, "periodic"), (2, "two-periodic"), (3, "3-periodic")] {
            let closing = section(1000, |k| (k % period) as f64 + 1e-9 * k as f64);
            let found = class(&closing, SystemKind::Flow, &flow);
            assert_eq!(found.to_string(), name);
            assert_eq!(name.parse(), Ok(found));
        }
        // Few points, but in no order.
        let shuffled = section(1000, |k| ((k * k / 7) % 3) as f64);
        assert_eq!(class(&shuffled, SystemKind::Flow, &flow), Class::Undecided);
        // Nothing has repeated yet.
        assert_eq!(
            class(&section(3, |_| 1.0), SystemKind::Flow, &flow),
            Class::Undecided
        );
        assert_eq!(class(&[], SystemKind::Flow, &flow), Class::Undecided);
        // A motion cannot both close and separate.
        let parting = [finite(0.01, 1e-5)];
        assert_eq!(
            class(&section(1000, |_| 1.0), SystemKind::Flow, &parting),
            Class::Undecided
        );
    }

    #[test]
    fn sections_that_do_not_close_are_distinguished_by_their_exponents() {
        let open = section(1000, |k| math::sin(k as f64));
        let flow = |exponents: &[Exponent]| class(&open, SystemKind::Flow, exponents);
        let map = |exponents: &[Exponent]| class(&open, SystemKind::ReturnMap, exponents);
        let (zero, negative) = (finite(1e-5, 1e-5), finite(-0.01, 1e-4));
        assert_eq!(
            flow(&[zero, zero, negative, Exponent::Annihilated]),
            Class::QuasiPeriodic
        );
        assert_eq!(map(&[zero]), Class::QuasiPeriodic);
        // Chaos as slow as the published one counts if its exponent is certain enough; otherwise
        // the class is undecided.
        assert_eq!(
            flow(&[finite(0.0025, 3e-4), zero, negative]),
            Class::Chaotic
        );
        assert_eq!(map(&[finite(0.0025, 3e-4)]), Class::Chaotic);
        assert_eq!(
            flow(&[finite(0.0025, 1e-3), zero, negative]),
            Class::Undecided
        );
        assert_eq!(
            flow(&[finite(1e-5, 1e-3), zero, negative]),
            Class::Undecided
        );
        assert_eq!(map(&[finite(1e-5, 1e-3)]), Class::Undecided);
        // A torus has a second zero; a contracting map that has not closed will close later.
        assert_eq!(flow(&[zero, negative]), Class::Undecided);
        assert_eq!(map(&[negative]), Class::Undecided);
        assert_eq!(flow(&[]), Class::Undecided);
    }

    #[test]
    fn classes_read_back() {
        for class in [
            Class::Periodic(1),
            Class::Periodic(2),
            Class::Periodic(17),
            Class::QuasiPeriodic,
            Class::Chaotic,
            Class::Undecided,
        ] {
            assert_eq!(class.to_string().parse(), Ok(class));
        }
        for wrong in [
            "",
            "-periodic",
            "1-periodic",
            "2-periodic",
            "x-periodic",
            "Chaotic",
        ] {
            assert_eq!(wrong.parse::<Class>(), Err(UnknownClass(wrong.into())));
        }
    }
}
