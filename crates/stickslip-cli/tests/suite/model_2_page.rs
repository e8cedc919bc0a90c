//! The page on the paper's model 2 agrees with the golden files of the program's figures.

use serde_json::Value;

/// Published shares of starts that end on the fixed point, by the belt's speed. Each is from 5000
/// random starts (Stender & Hoffmann, *Nonlinear Dyn.* 107 (2022) 1451). The library's tests read
/// the same table.
const PUBLISHED: &str = include_str!("../../../stickslip/tests/data/shares.csv");

/// Number of random starts of a published share.
const STARTS: f64 = 5000.0;

fn golden(name: &str) -> Value {
    let path = format!("{}/../../golden/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The belt's speed and the share of the fixed point.
fn share(basin: &Value) -> (f64, f64) {
    let attractors = basin["attractors"].as_array().unwrap().iter();
    let fixed = attractors.filter(|one| one["motion"] == "equilibrium");
    let share = fixed.fold(0.0, |sum, one| sum + one["share"].as_f64().unwrap());
    (basin["system"]["parameters"]["vd"].as_f64().unwrap(), share)
}

#[test]
fn the_shares_beside_the_published_ones() {
    let shares = golden("shares.json");
    let mut found: Vec<(f64, f64)> = shares.as_array().unwrap().iter().map(share).collect();
    found.push(share(&golden("basins.json")));
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rows = csv::Reader::from_reader(PUBLISHED.as_bytes());
    let published: Vec<(f64, f64)> = rows.deserialize().map(Result::unwrap).collect();
    assert_eq!(found.len(), published.len());
    let mut table = "| belt speed | published, of 5000 random starts | here, of a grid | off by, \
        in standard errors |\n\
        |--:|--:|--:|--:|\n"
        .to_owned();
    for ((speed, share), (published_at, published)) in found.into_iter().zip(published) {
        assert_eq!(speed, published_at);
        let error = (share * (1.0 - share) / STARTS).sqrt();
        let off = if error > 0.0 {
            (share - published) / error
        } else {
            0.0
        };
        assert!(
            off.abs() <= 3.0,
            "at {speed}: {share}, published {published}, {off} standard errors"
        );
        // If all starts go one way there is no standard error, and no difference is allowed.
        assert!(
            error > 0.0 || share == published,
            "at {speed}: {share}, published {published}"
        );
        table += &format!("| {speed} | {published} | {share:.4} | {off:+.1} |\n");
    }
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/model-2.md");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(
        page.contains(&table),
        "the page has another table than\n\n{table}"
    );
}
