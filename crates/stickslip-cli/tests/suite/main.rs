//! Tests of files, systems and commands.

mod against_compiled;
mod bad_files;
mod command_line;
mod continuation;
mod families;
mod hybrid;
mod known_answers;
mod pile_ups;
mod public_cases;
mod model_2_page;
mod recorded;
mod spectrum;
mod spectrum_embedding;
mod tables;
