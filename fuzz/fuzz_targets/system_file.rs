//! A system file: it is read and followed for some steps, or its fault is reported in words.

#![no_main]

use libfuzzer_sys::fuzz_target;
use stickslip::Options;
use stickslip_model::file::{Source, SystemFile};
use stickslip_model::kernel::{follow, ignore};

fuzz_target!(|text: &str| {
    // Tables of other files are no part of this.
    if text.contains("file") {
        return;
    }
    let source = Source {
        name: "fuzz.toml".to_owned(),
        text: text.to_owned(),
    };
    let file = match SystemFile::parse(source) {
        Ok(file) => file,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            return;
        }
    };
    let Ok(system) = file.with(&[]) else { return };
    let Some(x) = system.start() else { return };
    let options = Options {
        most_steps: 20,
        ..Options::tol(1e-6)
    };
    // A run may fail, with words for it.
    let sections = system.sections();
    let run = follow(
        system.dynamics(),
        (0.0, &x),
        1.0,
        &options,
        &sections,
        &mut ignore,
    );
    if let Err(error) = run {
        assert!(!error.to_string().is_empty());
    }
});
