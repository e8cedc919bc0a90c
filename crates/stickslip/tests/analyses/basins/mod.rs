//! Basins in numbers, against closed forms.

mod boundaries;
mod shares;
mod thresholds;

use stickslip_model::file::System;

/// A system of one or two states from its rates, which may have the parameter p.
fn system(rates: &[(&str, &str)], p: f64) -> System {
    let mut text = "name = \"of rates\"\n".to_owned();
    if rates.iter().any(|(_, rate)| rate.contains("(t)")) {
        text += "[time]\nperiod = \"2*pi\"\n";
    }
    text += &format!("[parameters]\np = {p:?}\n[states]\n");
    for (name, _) in rates {
        text += &format!("{name} = \"\"\n");
    }
    text += "[field]\n";
    for (name, rate) in rates {
        text += &format!("{name} = \"{rate}\"\n");
    }
    crate::lyapunov_jumps::system(&text)
}

/// Equilibria at (-1, 0) and (1, 0) with the boundary x = y²/3 between their basins: u = x - y²/3
/// has the rate u - u³, and y decays.
const WELLS: [(&str, &str); 2] = [("x", "(x - y^2/3) - (x - y^2/3)^3 - 2/3*y^2"), ("y", "-y")];
