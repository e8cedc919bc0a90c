//! A formula of states, time, parameters and a contact. It has the value that it has in
//! parentheses, or its fault is reported in words.

#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use stickslip::dynamics::Modes;
use stickslip::scalar::Dual;
use stickslip::{Mode, Side};
use stickslip_model::expression::parse_condition;
use stickslip_model::file::{System, SystemFile};

static SYSTEM: LazyLock<System> = LazyLock::new(|| {
    let file = SystemFile::open("forced").expect("a shipped model");
    file.with(&[]).expect("its parameters are in their ranges")
});

fuzz_target!(|text: &str| {
    if let Err(fault) = parse_condition(text) {
        assert!(!fault.to_string().is_empty());
    }
    let formula = match SYSTEM.observed(text, &[]) {
        Ok(formula) => formula,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            return;
        }
    };
    // One more level may be too deep.
    let in_parentheses = SYSTEM.observed(&format!("({text})"), &[]);
    let modes = [
        Mode::Slip(Side::Below),
        Mode::Slip(Side::Above),
        Mode::Stick,
    ];
    let at = [(0.0, [0.0, 0.0]), (1.5, [-0.3, 2.0])];
    for (mode, (t, x)) in modes.into_iter().flat_map(|mode| at.map(|at| (mode, at))) {
        let modes = Modes::new(&[mode]);
        let value: f64 = formula.value(modes, t, &x);
        if let Ok(same) = &in_parentheses {
            let same: f64 = same.value(modes, t, &x);
            assert!(value.to_bits() == same.to_bits() || value.is_nan() && same.is_nan());
        }
        let along = x.map(|x| Dual::new(x, 1.0));
        let _: Dual<f64> = formula.value(modes, t, &along);
    }
});
