//! How each statement of the paper is checked: it has no number to be compared with.

/// The check in words; nothing for a claim that is a number.
pub(super) fn check(id: &str) -> Option<&'static str> {
    Some(match id {
        "s2.degenerate_zone" => {
            "zeros of σ at mu0 = 0 in closed form are counted (three), and the intervals where σ < 0 (none)"
        }
        "s2.continuous_zone" => {
            "the intervals where σ < 0 at mu0 = 2/(3√3) are counted (one), and its ends compared with the outer tangent points"
        }
        "fig04.visibility" => {
            "second Lie derivative of the boundary function along the tangent field, by dual numbers, at each of the six points"
        }
        "fig04.no_stick" => "stick phases of the limit cycle are counted over a whole period",
        "fig04.deflection" => {
            "the cycle's left crossing of Σ is nearest to the third tangent point, and the slopes before and after it differ"
        }
        "fig06.friction_law" => {
            "every pair of neighbouring points of all six graphs, 300 on each branch, is compared"
        }
        "fig07a.tangency" => {
            "σ is positive on both sides of each of its three double zeros at mu0 = 0, and negative on both sides of two at mu0 = 2√3/9"
        }
        "fig07b.oscillation" => {
            "σ of the distance to the spring's moving end is zero to rounding along each of the six curves over two periods"
        }
        "fig07c.branches" => {
            "tangent points are counted at mu0 = 0, below, at and above the critical value"
        }
        "fig08.two_periodic" => {
            "the settled sequence of stick phases repeats after two forcing periods and not after one"
        }
        "fig08.exit_at_visible" => {
            "visibility of the tangent point at the end of each stick phase, by the second Lie derivative"
        }
        "fig10.class" | "fig11.class" | "fig12.class" => {
            "section points from t = 3000 to 12000 that differ are counted, and the exponents from the equations, with their errors, tell \
             zero from positive"
        }
        "s5.zero_exponent" | "s5.two_zero_exponents" => {
            "exponents from the equations that are zero within their errors are counted"
        }
        "s5.positive_exponent" => {
            "the first exponent from the equations is above zero by several standard errors"
        }
        "fig08.deflections" => {
            "crossings of Σ without stick at negative positions are counted over a pattern of the settled motion"
        }
        "abstract.accuracy" => {
            "event times by RK4 with one Hénon step against exact ones: their order must be that of RK4 (above 3.5), their error at the \
             printed step below half a unit of the last printed digit"
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::published::{Kind, claims};

    #[test]
    fn every_claim_that_is_no_number_has_a_check() {
        for claim in claims().unwrap() {
            let needs = matches!(claim.kind, Kind::Statement | Kind::Curve);
            assert!(!needs || check(&claim.id).is_some(), "{}", claim.id);
        }
    }
}
