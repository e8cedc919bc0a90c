//! What is tried: readings × integrators × settings of the estimator.

use crate::analysis::data_spectrum::{DataSettings, Neighbourhood};
use crate::models::{Amplitude, CaptionOrder, Reading, Unloading};

/// How the equations are integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// The event-exact solver at tolerance 1e-9.
    Exact,
    /// [`crate::paper::in_place`] with this step.
    InPlace(f64),
}

impl Integrator {
    /// Name in the table.
    pub fn name(self) -> String {
        match self {
            Integrator::Exact => "exact".into(),
            Integrator::InPlace(h) => format!("in-place h={h}"),
        }
    }
}

/// Why a configuration is in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// It competes.
    Search,
    /// It measures how far the settings alone move the estimate, for the recommended reading.
    Spread,
}

impl Part {
    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Part::Search => "search",
            Part::Spread => "spread",
        }
    }
}

/// A reading and an integrator, whose three trajectories serve all settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Form of the equations and of the captions.
    pub reading: Reading,
    /// Integrator.
    pub integrator: Integrator,
}

/// The whole search.
#[derive(Clone, Debug)]
pub struct Plan {
    /// `full` or `quick`.
    pub name: &'static str,
    /// Begin of the series.
    pub from: f64,
    /// Points of the series, 0.2 apart.
    pub points: usize,
    /// Random targets for the chance level.
    pub draws: usize,
    /// What is integrated.
    pub groups: Vec<Group>,
    search: Vec<DataSettings>,
    spread: Vec<DataSettings>,
}

/// Time between two points of the series, as in the paper.
pub const DT: f64 = 0.2;
/// Most reference points per estimate; they are spread `d` points apart.
const REFERENCES: usize = 8000;
/// Fewer of them for the large neighbourhoods, for time.
const FEW_REFERENCES: usize = 3000;
/// Most neighbours in a ball of a tenth of the spread.
const MANY: usize = 400;

impl Plan {
    /// The window of the paper, all readings.
    pub fn full() -> Plan {
        Plan {
            name: "full",
            from: 3000.0,
            points: 45001,
            draws: 2000,
            groups: groups(
                &readings(),
                &[
                    Integrator::Exact,
                    Integrator::InPlace(2e-2),
                    Integrator::InPlace(1e-2),
                    Integrator::InPlace(5e-3),
                ],
            ),
            search: search_settings(),
            spread: spread_settings(),
        }
    }

    /// A short series and a few configurations, for a check within seconds.
    pub fn quick() -> Plan {
        Plan {
            name: "quick",
            from: 300.0,
            points: 3001,
            draws: 50,
            groups: groups(
                &[Reading::exact(), Reading::as_printed()],
                &[Integrator::Exact, Integrator::InPlace(1e-2)],
            ),
            search: vec![settings(0.1, 40, 1, false), settings(0.2, 40, 3, true)],
            spread: vec![settings(0.1, 40, 3, false), settings(0.2, 80, 2, false)],
        }
    }

    /// The settings of a group, with the part they belong to.
    pub fn settings_of(&self, group: &Group) -> Vec<(Part, DataSettings)> {
        let recommended =
            group.reading == Reading::exact() && group.integrator == Integrator::Exact;
        let spread = if recommended { &self.spread[..] } else { &[] };
        let of = |part, list: &[DataSettings]| -> Vec<(Part, DataSettings)> {
            list.iter().map(|one| (part, one.clone())).collect()
        };
        let mut all = of(Part::Search, &self.search);
        all.extend(of(Part::Spread, spread));
        all
    }

    /// First line of the table: tables of other plans are not continued.
    pub fn heading(&self) -> String {
        format!(
            "# stickslip {} readings: {} search, t from {}, {} points at dt = {DT}",
            env!("CARGO_PKG_VERSION"),
            self.name,
            self.from,
            self.points
        )
    }
}

fn groups(readings: &[Reading], integrators: &[Integrator]) -> Vec<Group> {
    readings
        .iter()
        .flat_map(|&reading| {
            integrators.iter().map(move |&integrator| Group {
                reading,
                integrator,
            })
        })
        .collect()
}

/// All signs, clipped or not, with the three ways in which amplitude and unloading make sense together; and the captions' numbers
/// in the order of their heading, with μ0 = 1.
fn readings() -> Vec<Reading> {
    let scalings = [
        (Amplitude::Mu0, Unloading::OverMu0),
        (Amplitude::One, Unloading::Plain),
        (Amplitude::Mu0, Unloading::Plain),
    ];
    let mut all = Vec::new();
    for (amplitude, unloading) in scalings {
        for (displacement_sign, friction_sign) in
            [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
        {
            for clipped in [true, false] {
                all.push(Reading {
                    displacement_sign,
                    friction_sign,
                    amplitude,
                    unloading,
                    clipped,
                    order: CaptionOrder::Mu0BeforeXi6,
                });
            }
        }
    }
    for clipped in [true, false] {
        all.push(Reading {
            unloading: Unloading::Plain,
            clipped,
            order: CaptionOrder::Heading { mu0: 1.0 },
            ..Reading::exact()
        });
    }
    all
}

/// The name of a reading in the table.
pub fn reading_name(reading: &Reading) -> String {
    let sign = |value: f64| if value < 0.0 { '-' } else { '+' };
    let amplitude = match reading.amplitude {
        Amplitude::Mu0 => "mu0",
        Amplitude::One => "1",
    };
    let unloading = match reading.unloading {
        Unloading::OverMu0 => "xi6/mu0",
        Unloading::Plain => "xi6",
    };
    let contact = if reading.clipped {
        "clipped"
    } else {
        "unclipped"
    };
    let order = match reading.order {
        CaptionOrder::Mu0BeforeXi6 => "mu0 before xi6".into(),
        CaptionOrder::Heading { mu0 } => format!("as headed mu0={mu0}"),
    };
    format!(
        "{}x3 {}T; amplitude {amplitude}; unloading {unloading}; {contact}; {order}",
        sign(reading.displacement_sign),
        sign(reading.friction_sign),
    )
}

/// The estimator's settings that the whole search ranks first for all three figures together, classes before exponents; the
/// reading is then [`crate::models::Reading::exact`], solved exactly. The figures show what it gives.
pub(crate) fn best_common() -> DataSettings {
    settings(0.1, MANY, 1, false)
}

fn settings(eps: f64, max: usize, step: usize, affine: bool) -> DataSettings {
    let references = if max >= MANY {
        FEW_REFERENCES
    } else {
        REFERENCES
    };
    DataSettings {
        neighbours: Neighbourhood::Ball { eps, min: 12, max },
        step,
        affine,
        stride: step,
        references: Some(references),
        ..DataSettings::default()
    }
}

fn search_settings() -> Vec<DataSettings> {
    let ridge = |ridge, settings| DataSettings { ridge, ..settings };
    vec![
        settings(0.02, 40, 1, false),
        settings(0.02, 40, 1, true),
        settings(0.02, 40, 5, false),
        settings(0.05, 100, 1, true),
        settings(0.05, 100, 3, false),
        settings(0.05, 100, 3, true),
        ridge(1e-6, settings(0.05, 100, 3, false)),
        ridge(1e-3, settings(0.05, 100, 3, true)),
        settings(0.1, MANY, 1, false),
        settings(0.1, MANY, 3, true),
        ridge(1e-2, settings(0.1, MANY, 3, true)),
        DataSettings {
            references: Some(1000),
            ..settings(0.02, 40, 1, false)
        },
    ]
}

fn spread_settings() -> Vec<DataSettings> {
    let mut all = Vec::new();
    for (eps, few, many) in [(0.01, 20, 40), (0.03, 40, 100), (0.1, 100, MANY)] {
        for max in [few, many] {
            for step in [1, 3, 5] {
                for ridge in [0.0, 1e-3] {
                    all.push(DataSettings {
                        ridge,
                        ..settings(eps, max, step, true)
                    });
                }
            }
        }
    }
    all
}

/// The name of settings in the table.
pub fn settings_name(settings: &DataSettings) -> String {
    let neighbours = match settings.neighbours {
        Neighbourhood::Ball { eps, min, max } => format!("eps={eps} neighbours={min}-{max}"),
        Neighbourhood::Nearest(k) => format!("nearest={k}"),
    };
    let fit = if settings.affine { "affine" } else { "linear" };
    let references = settings.references.unwrap_or(0);
    format!(
        "{neighbours} d={} {fit} ridge={:e} references={references}",
        settings.step, settings.ridge
    )
}
