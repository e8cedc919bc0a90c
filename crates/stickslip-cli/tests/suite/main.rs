//! Tests of files, systems and commands.

mod against_compiled;
mod bad_files;
mod blocks;
mod command_line;
mod continuation;
mod families;
mod hybrid;
mod known_answers;
mod long_runs;
mod model_2_page;
mod pile_ups;
mod places_on_branches;
mod public_cases;
mod random_hybrid;
mod recorded;
mod side_by_side;
mod spectrum;
mod spectrum_embedding;
mod tables;
