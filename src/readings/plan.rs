//! The configurations: readings × integrators × settings of the estimator.

use std::fmt::Display;

use super::settings::{Setting, search_settings, settings_name, spread_settings, with_spread_unit};
use super::table::{ConfigurationRow, Twelve};
use crate::figures::block_and_bracket::{DIVERGED, DT, START, TOLERANCE};
use crate::motion::Criterion;
use crate::paper::claim_id::SpectrumFigure;
use crate::paper::models::{Amplitude, Caption, CaptionOrder, Interpretation, Unloading};
use crate::paper::published::{Claim, Claims};
use crate::text::joined;

/// Integrator of the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// The event-exact solver.
    Exact,
    /// The classical method of order 4 with this step, and Hénon's step onto Σ: the paper's Sect.
    /// 3.
    FourthOrder(f64),
    /// [`crate::paper::in_place`] with this step.
    InPlace(f64),
}

impl Integrator {
    /// Name in the table.
    pub fn name(self) -> String {
        match self {
            Integrator::Exact => "exact".into(),
            Integrator::FourthOrder(h) => format!("fourth-order h={h}"),
            Integrator::InPlace(h) => format!("in-place h={h}"),
        }
    }
}

/// Part of the table whose rows compete.
pub const SEARCH: &str = "search";
/// Part that measures, together with the search's settings, how far the settings alone move the
/// estimate for the recommended reading.
pub const SPREAD: &str = "spread";

/// A reading and an integrator. Their three trajectories serve all settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Interpretation of the equations and of the captions.
    pub reading: Interpretation,
    /// Integrator.
    pub integrator: Integrator,
}

impl Group {
    /// The corrected equations, solved exactly.
    pub fn recommended() -> Group {
        Group {
            reading: Interpretation::exact(),
            integrator: Integrator::Exact,
        }
    }

    /// Whether a row is of this reading and integrator.
    pub fn has(&self, row: &ConfigurationRow) -> bool {
        row.key[1] == reading_name(&self.reading) && row.key[2] == self.integrator.name()
    }
}

/// The complete search.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Start of the series.
    pub from: f64,
    /// Points of the series, at intervals of 0.2.
    pub points: usize,
    /// Random targets for the chance level.
    pub draws: usize,
    /// Readings and integrators.
    pub groups: Vec<Group>,
    /// The published exponents, the largest of each figure first.
    pub published: Exponents,
    /// Values of the published exponents.
    pub target: Twelve,
    /// Settings of the estimator that compete.
    pub search: Vec<Setting>,
    /// Settings that measure the estimator's own spread.
    pub spread: Vec<Setting>,
}

/// Limit on the number of steps of an orbit. It allows for the shortest fixed steps and for some
/// hundred thousand events.
pub const STEP_LIMIT: usize = 3_000_000;
/// Section points of the in-place scheme nearer than this, as a fraction of its extent, count as
/// one. The passes do not end on the section, and a closed motion is sampled at different phases of
/// the pass.
pub const SECTION_TOLERANCE: f64 = 1e-3;
/// Limit on a difference. A missing exponent or one of −∞ counts as much.
pub const DIFFERENCE_CAP: f64 = 3.0;
/// Exponents up to this size pass for zero: more than any that the paper prints for one, and less
/// than its positive one. It is added to the size of a published exponent before a difference is
/// divided by it. Otherwise exponents near zero would dominate.
pub const ZERO_SIZE: f64 = 0.002;
/// A set of smaller correlation dimension is a curve: for a torus, up to 1.1 is estimated.
pub const CURVE_DIMENSION: f64 = 1.2;
/// Version of the table. Increase it whenever the same settings give other rows.
const FORMAT: u32 = 4;
/// First line of every table.
const MARKER: &str = "# stickslip readings";

impl Plan {
    /// All readings, over the time window of the paper.
    ///
    /// # Errors
    /// A message if the table of claims lacks an exponent.
    pub fn full() -> Result<Plan, String> {
        let mut integrators = vec![Integrator::Exact];
        integrators.extend([2e-2, 5e-3].map(Integrator::FourthOrder));
        integrators.extend([0.2, 0.1, 5e-2, 2e-2, 1e-2, 5e-3, 1e-3].map(Integrator::InPlace));
        let (published, target) = published()?;
        Ok(Plan {
            from: START,
            points: 45001,
            draws: 2000,
            groups: groups(&readings(), &integrators),
            published,
            target,
            search: search_settings(),
            spread: with_spread_unit(spread_settings()),
        })
    }

    /// The settings of a group, with their part of the table.
    pub fn settings_of(&self, group: &Group) -> Vec<PartSetting> {
        let recommended = *group == Group::recommended();
        let search = self.search.iter().map(|one| (SEARCH, one.clone()));
        let spread = self.spread.iter().filter(|_| recommended);
        search
            .chain(spread.map(|one| (SPREAD, one.clone())))
            .collect()
    }

    /// Length of the series.
    pub fn duration(&self) -> f64 {
        (self.points - 1) as f64 / (1.0 / DT)
    }

    /// The lines before the table: the settings that all rows share. What differs between rows is
    /// in the rows; `format` counts changes of the code.
    pub fn heading(&self) -> String {
        let numbers = |list: &[f64]| joined(list, " ");
        let captions = Caption::ALL.iter().map(|caption| {
            let (numbers, start) = (numbers(&caption.numbers), numbers(&caption.start));
            format!("{numbers} from {start}")
        });
        let Criterion { same, resolution } = Criterion::default();
        let common: [(&str, &dyn Display); 16] = [
            ("format", &FORMAT),
            ("search", &"full"),
            ("begin of the series", &self.from),
            ("points of the series", &self.points),
            ("time between points", &DT),
            ("tolerance of the exact solver", &TOLERANCE),
            ("most steps of the solver", &STEP_LIMIT),
            ("bound beyond which an orbit has escaped", &DIVERGED),
            ("equal points of the section, exact", &same),
            ("equal points of the section, in-place", &SECTION_TOLERANCE),
            (
                "dimension below which a section is a curve",
                &CURVE_DIMENSION,
            ),
            (
                "uncertainty up to which an exponent can be zero",
                &resolution,
            ),
            ("captions", &joined(captions, "; ")),
            ("published exponents", &numbers(self.target.as_flattened())),
            ("distance floor", &ZERO_SIZE),
            ("distance cap", &DIFFERENCE_CAP),
        ];
        let line = |(name, value): &(&str, &dyn Display)| format!("# {name} = {value}\n");
        let lines: String = common.iter().map(line).collect();
        format!("{MARKER}\n{lines}")
    }
}

/// The published exponents of Figs. 10–12, the largest first.
pub type Exponents = [[Claim; 4]; 3];

fn published() -> Result<(Exponents, Twelve), String> {
    let claims = Claims::committed()?;
    let ids = SpectrumFigure::ALL.map(SpectrumFigure::exponents);
    let published = ids.map(|four| four.map(|id| claims.of(id).clone()));
    Ok((published, ids.map(|four| four.map(|id| claims.value(id)))))
}

fn groups(readings: &[Interpretation], integrators: &[Integrator]) -> Vec<Group> {
    let with = |&reading: &Interpretation| {
        let group = move |&integrator| Group {
            reading,
            integrator,
        };
        integrators.iter().map(group)
    };
    readings.iter().flat_map(with).collect()
}

/// All signs, clipped or not, with the three consistent pairs of amplitude and unloading. Also the
/// captions' numbers in the order of their heading, with μ0 = 1.
fn readings() -> Vec<Interpretation> {
    let scalings = [
        (Amplitude::Mu0, Unloading::OverMu0),
        (Amplitude::One, Unloading::Plain),
        (Amplitude::Mu0, Unloading::Plain),
    ];
    let signs = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let mut all = Vec::new();
    for (amplitude, unloading) in scalings {
        for (displacement_sign, friction_sign) in signs {
            all.push(Interpretation {
                displacement_sign,
                friction_sign,
                amplitude,
                unloading,
                order: CaptionOrder::Mu0BeforeXi6,
                ..Interpretation::exact()
            });
        }
    }
    all.push(Interpretation {
        unloading: Unloading::Plain,
        order: CaptionOrder::Heading { mu0: 1.0 },
        ..Interpretation::exact()
    });
    let clipped = |reading| [true, false].map(|clipped| Interpretation { clipped, ..reading });
    all.into_iter().flat_map(clipped).collect()
}

/// The name of a reading in the table.
pub fn reading_name(reading: &Interpretation) -> String {
    let sign = |value: f64| if value < 0.0 { '-' } else { '+' };
    let (x3, friction) = (sign(reading.displacement_sign), sign(reading.friction_sign));
    let amplitude = match reading.amplitude {
        Amplitude::Mu0 => "mu0",
        Amplitude::One => "1",
    };
    let unloading = match reading.unloading {
        Unloading::OverMu0 => "xi6/mu0",
        Unloading::Plain => "xi6",
    };
    let contact = match reading.clipped {
        true => "clipped",
        false => "unclipped",
    };
    let order = match reading.order {
        CaptionOrder::Mu0BeforeXi6 => "mu0 before xi6".into(),
        CaptionOrder::Heading { mu0 } => format!("as headed mu0={mu0}"),
    };
    format!("{x3}x3 {friction}T; amplitude {amplitude}; unloading {unloading}; {contact}; {order}")
}

/// Settings of the estimator, with their part of the table.
pub type PartSetting = (&'static str, Setting);

/// The key of a group's row.
pub fn key(group: &Group, (part, settings): &PartSetting) -> [String; 4] {
    let (reading, integrator) = (reading_name(&group.reading), group.integrator.name());
    [part, &*reading, &integrator, &settings_name(settings)].map(str::to_owned)
}
