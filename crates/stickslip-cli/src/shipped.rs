//! The models that come with the program.

/// Names and files, in the order in which they are listed.
const SHIPPED: [(&str, &str); 6] = [
    ("belt", include_str!("../systems/belt.toml")),
    ("forced", include_str!("../systems/forced.toml")),
    ("bracket", include_str!("../systems/bracket.toml")),
    ("leine", include_str!("../systems/leine.toml")),
    ("basins", include_str!("../systems/basins.toml")),
    ("den-hartog", include_str!("../systems/den-hartog.toml")),
];

/// The file of a shipped model.
pub fn named(name: &str) -> Option<&'static str> {
    SHIPPED
        .iter()
        .find(|(known, _)| *known == name)
        .map(|&(_, text)| text)
}

/// The names of all shipped models.
pub fn names() -> Vec<&'static str> {
    SHIPPED.iter().map(|&(name, _)| name).collect()
}
