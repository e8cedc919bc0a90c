//! The listing's defects that cause the four numbers of Fig. 8, by runs of all subsets.

use rayon::prelude::*;

use super::digits::{Agreement, agreement};
use crate::paper::claim_id::ClaimId;
use crate::paper::listing::{Defect, Defects, Motion, Setup, run};
use crate::paper::published::Claims;
use crate::text::joined;

/// Number of subsets of the defects.
pub const SUBSETS: usize = 1 << Defect::ALL.len();

/// One run of the listing, compared with the four published numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedRun {
    /// Step (s).
    pub h: f64,
    /// The defects it has.
    pub present: Defects,
    /// Lengths of the two stick phases (m), then their durations (s).
    pub numbers: Option<[f64; 4]>,
    /// Class of the settled motion.
    pub motion: Motion,
    /// Agreement of the numbers with the published ones.
    pub digits: Option<[Agreement; 4]>,
}

impl ComparedRun {
    /// Runs the listing with these defects and this step.
    pub(super) fn run(claims: &Claims, present: Defects, h: f64) -> ComparedRun {
        let outcome = run(&Setup {
            h,
            ..Setup::with(present)
        });
        let numbers = outcome.stick_numbers();
        ComparedRun {
            h,
            present,
            numbers,
            motion: outcome.motion,
            digits: numbers.map(|numbers| four_digits(claims, &numbers)),
        }
    }

    /// Whether all four numbers have all printed digits.
    pub fn gives_digits(&self) -> bool {
        let complete = |digits: [Agreement; 4]| digits.iter().all(|one| one.complete());
        self.digits.is_some_and(complete)
    }

    /// Whether the motion is of the published kind.
    pub fn gives_class(&self) -> bool {
        self.motion == Motion::PUBLISHED
    }
}

/// All subsets.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// One run for each subset, in the order of [`Defects::subsets`].
    pub runs: Vec<ComparedRun>,
}

/// A property of a run.
pub type Property = fn(&ComparedRun) -> bool;

impl Matrix {
    /// Runs all subsets and calls `tick` after each.
    pub fn compute(claims: &Claims, tick: &(dyn Fn() + Sync)) -> Matrix {
        let subsets: Vec<Defects> = Defects::subsets().collect();
        let runs = subsets.into_par_iter().map(|defects| {
            let cell = ComparedRun::run(claims, defects, Setup::default().h);
            tick();
            cell
        });
        Matrix {
            runs: runs.collect(),
        }
    }

    /// The run with these defects.
    pub fn with(&self, defects: Defects) -> &ComparedRun {
        &self.runs[defects.number()]
    }

    /// The run with one defect mended and all others present.
    pub fn mended(&self, defect: Defect) -> &ComparedRun {
        self.with(Defects::AS_PRINTED.flipped(defect))
    }

    /// The runs that are shown: with all defects, with none, with each alone, and with each mended.
    pub fn named(&self) -> Vec<(String, &ComparedRun)> {
        let (printed, mended) = (Defects::AS_PRINTED, Defects::MENDED);
        let mut named = vec![
            ("as printed".to_owned(), self.with(printed)),
            ("all mended".to_owned(), self.with(mended)),
        ];
        for (what, defects) in [("only ", mended), ("mended: ", printed)] {
            let each = defects.one_flipped();
            named.extend(each.map(|(one, defects)| {
                let name = format!("{what}{}", one.name());
                (name, self.with(defects))
            }));
        }
        named
    }

    /// The runs that have a property.
    pub fn having(&self, property: Property) -> impl Iterator<Item = &ComparedRun> {
        self.runs.iter().filter(move |cell| property(cell))
    }

    /// Defects without which no run has the property; empty if no run has it at all.
    pub fn necessary(&self, property: Property) -> Vec<Defect> {
        let nowhere = self.having(property).next().is_none();
        let everywhere = |defect: &Defect| {
            let mut having = self.having(property);
            having.all(|cell| cell.present.has(*defect))
        };
        let candidates = Defect::ALL.into_iter().filter(|_| !nowhere);
        candidates.filter(everywhere).collect()
    }

    /// Runs with the property such that no proper subset of their defects has it, the smallest
    /// first.
    pub fn minimal(&self, property: Property) -> Vec<&ComparedRun> {
        let is_least = |cell: &&ComparedRun| {
            let mut others = self.having(property);
            !others.any(|one| one != *cell && one.present.are_among(cell.present))
        };
        let mut minimal: Vec<&ComparedRun> = self.having(property).filter(is_least).collect();
        minimal.sort_by_key(|cell| cell.present.present().count());
        minimal
    }

    /// Defects that have no effect on the property, whatever others are present.
    pub fn irrelevant(&self, property: Property) -> Vec<Defect> {
        let idle = |defect: &Defect| {
            let mut having = self.having(property);
            having.all(|cell| property(self.with(cell.present.flipped(*defect))))
        };
        Defect::ALL.into_iter().filter(idle).collect()
    }

    /// The results in words.
    pub fn sentence(&self) -> String {
        let what = "the four published numbers to all printed digits";
        let digits = self.about(what, ComparedRun::gives_digits);
        let motion = self.about("the published kind of motion", ComparedRun::gives_class);
        format!(
            "Of all {SUBSETS} subsets of the defects, run in the listing at its printed step, \
                {digits}; {motion}."
        )
    }

    fn about(&self, what: &str, property: Property) -> String {
        let count = self.having(property).count();
        if count == 0 {
            return format!("none gives {what}");
        }
        let necessary = self.necessary(property);
        let named = list(necessary.iter().copied());
        let conditions = match &self.minimal(property)[..] {
            [only] if only.present.present().eq(necessary) => {
                let with = |cell: &&ComparedRun| only.present.are_among(cell.present);
                let with = self.runs.iter().filter(with);
                let (all, lost) = (
                    with.clone().count(),
                    with.filter(|cell| !property(cell)).count(),
                );
                let others = match lost {
                    0 => "sufficient, whatever others are present".to_owned(),
                    _ => format!(
                        "sufficient by themselves (with others added, {lost} of the {all} subsets \
                            that contain them lose it)"
                    ),
                };
                format!("{named} are necessary and together {others}")
            }
            several => {
                let sets = several.iter();
                let sets = sets.map(|cell| format!("{{{}}}", list(cell.present.present())));
                let needed = match &*named {
                    "" => "no defect is necessary".to_owned(),
                    named => format!("{named} are necessary"),
                };
                let sets = joined(sets, " or ");
                format!("{needed}, and each of the smallest sets {sets} is sufficient")
            }
        };
        let idle = match &*list(self.irrelevant(property)) {
            "" => String::new(),
            idle => format!(", and {idle} have no influence"),
        };
        format!("{count} give {what}: {conditions}{idle}")
    }
}

/// Names with commas between them.
fn list(defects: impl IntoIterator<Item = Defect>) -> String {
    joined(defects.into_iter().map(Defect::name), ", ")
}

/// Agreement of four numbers with the published ones of Fig. 8.
pub fn four_digits(claims: &Claims, numbers: &[f64; 4]) -> [Agreement; 4] {
    let nothing = Agreement {
        agreeing: 0,
        printed: 1,
    };
    let of = |i| agreement(claims.of(ClaimId::STICK_NUMBERS[i]), numbers[i]).unwrap_or(nothing);
    std::array::from_fn(of)
}
