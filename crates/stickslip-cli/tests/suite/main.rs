//! Tests of files, systems and commands.

mod command_line;
mod continuation;
mod families;
mod fit;
mod hybrid;
mod long_runs;
mod model_2_page;
mod public_cases;
mod spectrum;
mod spectrum_embedding;
mod starts;
