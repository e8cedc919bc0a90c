//! Tests of expressions and of systems from files.

mod against_compiled;
mod bad_files;
mod blocks;
mod branches;
mod derivatives;
mod extremes;
mod fit;
mod friction;
mod hybrid;
mod inputs;
mod instants;
mod known_answers;
mod long_formulas;
mod orbits;
mod parse;
mod pile_ups;
mod public_cases;
mod random_hybrid;
mod recorded;
mod references;
mod resume;
mod run;
mod side_by_side;
mod sizes;
mod special_orbits;
mod tape;
