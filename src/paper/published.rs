//! The quantities the paper publishes, as data.
//!
//! `data/claims.csv` has one row for each: values, sets of exact values, curves and statements. Only the
//! first two can be compared with a number; the rest is there so that a report can name it.

use std::str::FromStr;

/// The table, as it is in the repository.
const CLAIMS: &str = include_str!("../../data/claims.csv");
/// Largest relative difference from an exact value.
const EXACT_TOLERANCE: f64 = 1e-12;

/// What a row of the table claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One number.
    Value,
    /// Several numbers, or a formula for them.
    Set,
    /// A curve of a figure.
    Curve,
    /// A sentence.
    Statement,
}

impl FromStr for Kind {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "value" => Ok(Kind::Value),
            "set" => Ok(Kind::Set),
            "curve" => Ok(Kind::Curve),
            "statement" => Ok(Kind::Statement),
            _ => Err(()),
        }
    }
}

/// How far a published number can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Digits {
    /// Printed with so many decimals.
    Decimals(usize),
    /// Known in closed form.
    Exact,
    /// No number.
    None,
}

impl FromStr for Digits {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "" => Ok(Digits::None),
            "exact" => Ok(Digits::Exact),
            // f64 has no more than 17 that mean anything.
            _ => text
                .parse()
                .ok()
                .filter(|&n| n <= 17)
                .map(Digits::Decimals)
                .ok_or(()),
        }
    }
}

/// One published quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Its name here, e.g. `fig08.stick_length.1`.
    pub id: String,
    /// Where the paper says it.
    pub place: String,
    /// What sort of claim it is.
    pub kind: Kind,
    /// What is published, as printed; a set has `;` between its members.
    pub published: String,
    /// How many decimals of it are printed.
    pub digits: Digits,
    /// Its unit, empty where there is none.
    pub unit: String,
    /// What it says, in words.
    pub what: String,
}

impl Claim {
    /// The published numbers; none for a claim in words or by a formula.
    pub fn values(&self) -> Vec<f64> {
        if self.digits == Digits::None {
            return Vec::new();
        }
        let parsed: Result<Vec<f64>, _> = self
            .published
            .split(';')
            .map(|text| text.trim().parse())
            .collect();
        parsed.unwrap_or_default()
    }

    /// Whether `value` is the published number, or one of a set.
    ///
    /// Printed decimals: `value` rounded to as many is the printed number, nothing less. Exact: equal up
    /// to a relative difference of 1e-12 (absolute where the exact value is 0). Never true of a claim
    /// without numbers.
    pub fn agrees(&self, value: f64) -> bool {
        self.values()
            .into_iter()
            .any(|published| match self.digits {
                Digits::Decimals(decimals) => format!("{value:.decimals$}")
                    .parse::<f64>()
                    .is_ok_and(|rounded| rounded == published),
                Digits::Exact => {
                    let scale = if published == 0.0 {
                        1.0
                    } else {
                        published.abs()
                    };
                    (value - published).abs() <= EXACT_TOLERANCE * scale
                }
                Digits::None => false,
            })
    }
}

/// Why the table or a row of it cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PublishedError {
    /// The text is not CSV with as many fields in each row as in the first.
    #[error(
        "the table of published values is malformed ({reason}); give every row the fields of the first"
    )]
    Malformed {
        /// What the reader says.
        reason: String,
    },
    /// A field has a value it must not have.
    #[error("row {id:?}: {column} is {value:?}, but must be {allowed}; correct the row")]
    Field {
        /// Name of the row.
        id: String,
        /// The column.
        column: &'static str,
        /// What it holds.
        value: String,
        /// What it may hold.
        allowed: &'static str,
    },
    /// No row has this name.
    #[error("no published value is called {id:?}; see data/claims.csv for the names")]
    Unknown {
        /// The name asked for.
        id: String,
    },
}

/// All published quantities, in the order of the table.
///
/// # Errors
///
/// [`PublishedError`] where the table is malformed.
pub fn claims() -> Result<Vec<Claim>, PublishedError> {
    parse(CLAIMS)
}

/// The published quantity called `id`.
///
/// # Errors
///
/// [`PublishedError::Unknown`] where there is none of that name; others where the table is malformed.
pub fn published(id: &str) -> Result<Claim, PublishedError> {
    claims()?
        .into_iter()
        .find(|claim| claim.id == id)
        .ok_or_else(|| PublishedError::Unknown { id: id.to_owned() })
}

/// Reads a table with the columns `id, where, kind, published, digits, unit, what it says`.
///
/// # Errors
///
/// [`PublishedError`] with the row and the column at fault.
pub fn parse(table: &str) -> Result<Vec<Claim>, PublishedError> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    reader
        .records()
        .map(|record| claim(&record.map_err(malformed)?))
        .collect()
}

fn malformed(error: csv::Error) -> PublishedError {
    PublishedError::Malformed {
        reason: error.to_string(),
    }
}

fn claim(record: &csv::StringRecord) -> Result<Claim, PublishedError> {
    let fields: Vec<&str> = record.iter().collect();
    let [id, place, kind, published, digits, unit, what] = fields.as_slice() else {
        return Err(PublishedError::Malformed {
            reason: format!("a row has {} fields, the table has 7 columns", record.len()),
        });
    };
    let wrong = |column, value: &str, allowed| PublishedError::Field {
        id: (*id).to_owned(),
        column,
        value: value.to_owned(),
        allowed,
    };
    let claim = Claim {
        id: (*id).to_owned(),
        place: (*place).to_owned(),
        kind: kind
            .parse()
            .map_err(|()| wrong("kind", kind, "value, set, curve or statement"))?,
        published: (*published).to_owned(),
        digits: digits.parse().map_err(|()| {
            wrong(
                "digits",
                digits,
                "a number of decimals up to 17, `exact` or empty",
            )
        })?,
        unit: (*unit).to_owned(),
        what: (*what).to_owned(),
    };
    if claim.kind == Kind::Value && claim.values().len() != 1 {
        return Err(wrong(
            "published",
            published,
            "one number, with its digits, for a value",
        ));
    }
    Ok(claim)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "id,where,kind,published,digits,unit,what it says\n";

    fn one(row: &str) -> Claim {
        parse(&format!("{HEADER}{row}")).unwrap().remove(0)
    }

    #[test]
    fn printed_decimals_are_compared_by_rounding() {
        let claim = one("a,Fig. 1,value,0.4697,4,m,a length");
        assert!(claim.agrees(0.46965001));
        assert!(claim.agrees(0.46974999));
        assert!(!claim.agrees(0.46964999));
        assert!(!claim.agrees(0.46975001));
        assert!(!claim.agrees(f64::NAN));
    }

    #[test]
    fn a_sign_in_print_is_a_sign() {
        assert!(one("a,Fig. 1,value,+0.0025,4,1/t,x").agrees(0.00249));
        // Rounded, a small number of either sign is the printed "-0.0000".
        let zero = one("a,Fig. 1,value,-0.0000,4,1/t,x");
        assert!(zero.agrees(-0.00004) && zero.agrees(0.00004) && !zero.agrees(0.00006));
    }

    #[test]
    fn an_exact_set_holds_its_members_only() {
        let set = one("a,Eq. (1),set,0;0.5;-0.5,exact,m,x");
        assert!(set.agrees(0.0) && set.agrees(-0.5) && set.agrees(0.5 * (1.0 + 1e-13)));
        assert!(!set.agrees(0.5 * (1.0 + 1e-11)) && !set.agrees(0.25));
    }

    #[test]
    fn words_agree_with_no_number() {
        assert!(!one("a,Fig. 1,statement,2,,,two of them").agrees(2.0));
    }

    #[test]
    fn malformed_tables_are_typed_errors() {
        let parse_row = |row: &str| parse(&format!("{HEADER}{row}"));
        assert!(matches!(
            parse_row("a,b,value"),
            Err(PublishedError::Malformed { .. })
        ));
        assert!(matches!(
            parse("id,kind\na,value\n"),
            Err(PublishedError::Malformed { .. })
        ));
        for (row, expected) in [
            ("a,b,number,1,4,m,x", "kind"),
            ("a,b,value,1,four,m,x", "digits"),
            ("a,b,value,1,99,m,x", "digits"),
            ("a,b,value,one,4,m,x", "published"),
        ] {
            match parse_row(row) {
                Err(PublishedError::Field { column, .. }) => assert_eq!(column, expected),
                other => panic!("{row}: {other:?}"),
            }
        }
    }

    #[test]
    fn the_table_in_the_repository_is_sound() {
        let all = claims().unwrap();
        let mut ids: Vec<&str> = all.iter().map(|claim| claim.id.as_str()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), all.len(), "a name occurs twice");
        for claim in &all {
            assert!(
                claim.digits == Digits::None || !claim.values().is_empty(),
                "{}: {:?} has digits but no numbers",
                claim.id,
                claim.published
            );
        }
        assert_eq!(
            published("fig08.stick_length.1").unwrap().values(),
            [0.4697]
        );
        assert!(matches!(
            published("fig99"),
            Err(PublishedError::Unknown { .. })
        ));
    }
}
