//! The quantities the paper publishes, as data.
//!
//! `data/claims.csv` has one row for each: values, sets of exact values, curves and statements.
//! Only the first two can be compared with a number. The others are listed so that a report can
//! name them.

use std::sync::LazyLock;

use super::claim_id::ClaimId;
use crate::numbers::ROUNDING;
use crate::text::described;

/// The table in the repository.
const CLAIMS: &str = include_str!("../../data/claims.csv");
/// Unit of the last printed digit: the paper gives lengths, durations and exponents to four
/// decimals.
pub const LAST_DIGIT: f64 = 1e-4;
/// Half of it: the largest difference that rounding of print explains.
pub const HALF_DIGIT: f64 = 0.5 * LAST_DIGIT;

described! {
    /// Kind of claim in a row of the table.
    ClaimKind: &'static str as pub name {
        /// One number.
        Value = "value",
        /// Several numbers, or a formula for them.
        Set = "set",
        /// A curve of a figure.
        Curve = "curve",
        /// A sentence.
        Statement = "statement",
        /// An identity: it follows from other claims or from a definition. It is listed but not
        /// counted.
        Identity = "identity",
    }
}

described! {
    /// Group in which a claim is counted.
    Group: (&'static str, &'static str) as described {
        /// Follows by algebra from the printed polynomials of Sects. 2 and 4.
        Algebra = ("algebra", "algebra of the printed polynomials"),
        /// A number of the simulation in Fig. 8.
        Number = ("number", "simulated numbers of Fig. 8"),
        /// The class of a motion in Figs. 10–12.
        Class = ("class", "classes of Figs. 10–12"),
        /// A Lyapunov exponent, or the ratio of two.
        Exponent = ("exponent", "exponents of Figs. 10–12, and a ratio of two"),
        /// Printed numbers beside each other: nothing is integrated.
        Print = ("print", "printed numbers beside each other"),
        /// Any other sentence or curve.
        Statement = ("statement", "other sentences and curves"),
    }
}

impl Group {
    /// Name in the table.
    pub fn name(self) -> &'static str {
        self.described().0
    }

    /// Meaning in words.
    pub fn meaning(self) -> &'static str {
        self.described().1
    }
}

impl ClaimKind {
    fn named(name: &str) -> Option<ClaimKind> {
        ClaimKind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// Precision of a published number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Digits {
    /// Printed with so many decimals.
    Decimals(usize),
    /// Known in closed form.
    Exact,
    /// No number.
    None,
}

impl Digits {
    /// Parses the word in the table.
    fn named(text: &str) -> Option<Digits> {
        match text {
            "" => Some(Digits::None),
            "exact" => Some(Digits::Exact),
            _ => {
                let decimals = text.parse().ok().filter(|&n| n <= 17);
                decimals.map(Digits::Decimals)
            }
        }
    }
}

/// One published quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Identifier.
    pub id: ClaimId,
    /// Location in the paper.
    pub location: String,
    /// Kind of the claim.
    pub kind: ClaimKind,
    /// Published value, as printed. Members of a set are separated by `;`.
    pub published: String,
    /// Number of decimals that are printed.
    pub digits: Digits,
    /// Unit, empty where there is none.
    pub unit: String,
    /// The statement in words.
    pub what: String,
    /// The part of the paper in which it is counted.
    pub part: String,
    /// Labels of the corrections that its corrected readings need, separated by spaces.
    pub corrections: String,
    /// Method of the judgement, in words.
    pub check: String,
    /// Group in which it is counted.
    pub group: Group,
    /// The function that judges it, and a test of it: file, `::`, name.
    pub sources: [String; 2],
    /// The published numbers; none for a claim in words.
    values: Vec<f64>,
}

impl Claim {
    /// Parses a row.
    ///
    /// # Errors
    /// A message with the column that is wrong.
    pub(crate) fn of_record(record: &csv::StringRecord) -> Result<Claim, String> {
        if record.len() != 13 {
            let fields = record.len();
            let row = &record[0];
            return Err(format!("row {row:?} has {fields} fields, but must have 13"));
        }
        let text = |column: usize| record[column].to_owned();
        let (id, published) = (&record[0], &record[3]);
        let wrong = |column: &str, value: &str, allowed: &str| {
            format!("row {id:?}: {column} is {value:?}, but must be {allowed}")
        };
        let kinds = "value, set, curve, statement or identity";
        let kind = ClaimKind::named(&record[2]).ok_or_else(|| wrong("kind", &record[2], kinds))?;
        let allowed = "a number of decimals up to 17, `exact` or empty";
        let digits = Digits::named(&record[4]);
        let digits = digits.ok_or_else(|| wrong("digits", &record[4], allowed))?;
        let numbers = "numbers with `;` between them";
        let parsed = published.split(';').map(|text| text.trim().parse());
        let parsed = parsed.filter(|_| digits != Digits::None);
        let values = parsed.collect::<Result<Vec<f64>, _>>();
        let values = values.map_err(|_| wrong("published", published, numbers))?;
        if kind == ClaimKind::Value && values.len() != 1 {
            let allowed = "one number, with its digits, for a value";
            return Err(wrong("published", published, allowed));
        }
        let group = Group::ALL.into_iter().find(|one| one.name() == &record[10]);
        let groups = "algebra, number, class, exponent, print or statement";
        let list = "src/paper/claim_id.rs";
        let unknown = || format!("{id:?} is none of the claims in {list}; add it there");
        Ok(Claim {
            id: ClaimId::named(id).ok_or_else(unknown)?,
            location: text(1),
            kind,
            published: text(3),
            digits,
            unit: text(5),
            what: text(6),
            part: text(7),
            corrections: text(8),
            check: text(9),
            group: group.ok_or_else(|| wrong("group", &record[10], groups))?,
            sources: [text(11), text(12)],
            values,
        })
    }

    /// The published numbers; none for a claim in words.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether `value` is the published number, or one of a set. See [`Claim::agrees_with`].
    pub fn agrees(&self, value: f64) -> bool {
        let mut all = self.values.iter();
        all.any(|published| self.agrees_with(*published, value))
    }

    /// Whether `value` equals `published`, one of the claim's numbers.
    ///
    /// Printed decimals: `value` rounded to as many decimals is the printed number. Exact: equal up
    /// to a relative difference of 1e-12 (absolute where the exact value is 0). Always false for a
    /// claim without numbers.
    pub fn agrees_with(&self, published: f64, value: f64) -> bool {
        match self.digits {
            Digits::Decimals(decimals) => format!("{value:.decimals$}")
                .parse::<f64>()
                .is_ok_and(|rounded| rounded == published),
            Digits::Exact => (value - published).abs() <= ROUNDING * scale(published),
            Digits::None => false,
        }
    }
}

/// The unit of differences from an exact number: its size, or 1 for zero.
pub(crate) fn scale(published: f64) -> f64 {
    match published {
        0.0 => 1.0,
        other => other.abs(),
    }
}

/// The whole table: a claim for every [`ClaimId`].
#[derive(Debug, Clone, PartialEq)]
pub struct Claims {
    /// Claims in the order of [`ClaimId::ALL`].
    all: Vec<Claim>,
}

impl Claims {
    /// The table in the repository.
    ///
    /// # Errors
    /// As [`Claims::parse`].
    pub fn committed() -> Result<&'static Claims, String> {
        static COMMITTED: LazyLock<Result<Claims, String>> =
            LazyLock::new(|| Claims::parse(CLAIMS));
        COMMITTED.as_ref().map_err(Clone::clone)
    }

    /// Reads a table with the columns of [`Claim`].
    ///
    /// # Errors
    /// A message with the row and the column that are wrong, or with a name that is unknown,
    /// duplicated or missing.
    pub fn parse(table: &str) -> Result<Claims, String> {
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let rows = reader
            .records()
            .map(|record| Claim::of_record(&record.map_err(|error| error.to_string())?))
            .collect::<Result<Vec<Claim>, String>>()
            .map_err(|cause| format!("data/claims.csv: {cause}; correct the row"))?;
        let all = ClaimId::ALL
            .iter()
            .map(|id| {
                let of: Vec<&Claim> = rows.iter().filter(|claim| claim.id == *id).collect();
                match of[..] {
                    [claim] => Ok(claim.clone()),
                    _ => Err(format!(
                        "data/claims.csv has {} rows {id}; give it one",
                        of.len()
                    )),
                }
            })
            .collect::<Result<_, _>>()?;
        Ok(Claims { all })
    }

    /// The claim with this identifier.
    pub fn of(&self, id: ClaimId) -> &Claim {
        // `parse` has stored all claims in the order of the variants.
        &self.all[id as usize]
    }

    /// The number that a claim publishes; NaN if it publishes none or several.
    pub fn value(&self, id: ClaimId) -> f64 {
        match self.of(id).values() {
            [value] => *value,
            _ => f64::NAN,
        }
    }

    /// The four numbers of Fig. 8: lengths of the two stick phases (m), then their durations (s).
    pub fn published_stick_numbers(&self) -> [f64; 4] {
        ClaimId::STICK_NUMBERS.map(|id| self.value(id))
    }

    /// All of them, in the order of the table.
    pub fn iter(&self) -> std::slice::Iter<'_, Claim> {
        self.all.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The claim of a row; the name is added here.
    fn one(rest: &str) -> Claim {
        row(&format!("eq12.critical_points,{rest}")).unwrap()
    }

    fn row(row: &str) -> Result<Claim, String> {
        let fields = row.split(',').chain(["", "", "", "statement", "", ""]);
        Claim::of_record(&fields.collect())
    }

    #[test]
    fn printed_decimals_are_compared_by_rounding() {
        let claim = one("Fig. 1,value,0.4697,4,m,a length");
        assert!(claim.agrees(0.46965001));
        assert!(claim.agrees(0.46974999));
        assert!(!claim.agrees(0.46964999));
        assert!(!claim.agrees(0.46975001));
        assert!(!claim.agrees(f64::NAN));
    }

    #[test]
    fn a_sign_in_print_is_a_sign() {
        assert!(one("Fig. 1,value,+0.0025,4,1/t,x").agrees(0.00249));
        // Rounded, a small number of either sign is the printed "-0.0000".
        let zero = one("Fig. 1,value,-0.0000,4,1/t,x");
        assert!(zero.agrees(-0.00004) && zero.agrees(0.00004) && !zero.agrees(0.00006));
    }

    #[test]
    fn an_exact_set_holds_its_members_only() {
        let set = one("Eq. (1),set,0;0.5;-0.5,exact,m,x");
        assert!(set.agrees(0.0) && set.agrees(-0.5) && set.agrees(0.5 * (1.0 + 1e-13)));
        assert!(!set.agrees(0.5 * (1.0 + 1e-11)) && !set.agrees(0.25));
        assert!(!set.agrees_with(0.5, -0.5));
    }

    #[test]
    fn words_agree_with_no_number() {
        assert!(!one("Fig. 1,statement,2,,,two of them").agrees(2.0));
    }

    #[test]
    fn malformed_rows_are_refused_with_their_column() {
        assert!(row("a,b,value").unwrap_err().contains("9 fields"));
        for (rest, expected) in [
            ("b,number,1,4,m,x", "kind"),
            ("b,value,1,four,m,x", "digits"),
            ("b,value,1,99,m,x", "digits"),
            ("b,value,one,4,m,x", "published"),
            ("b,value,1;2,4,m,x", "published"),
            ("b,set,1;two,4,m,x", "published"),
        ] {
            let error = row(&format!("eq12.critical_points,{rest}")).unwrap_err();
            assert!(error.contains(&format!(": {expected} is ")), "{error}");
        }
    }

    #[test]
    fn the_table_has_every_claim_once_and_no_other() {
        let claims = Claims::committed().unwrap();
        assert_eq!(claims.iter().count(), ClaimId::ALL.len());
        for (claim, id) in claims.iter().zip(ClaimId::ALL) {
            assert_eq!(claims.of(id), claim);
            assert_eq!(claim.id, id);
        }
        assert_eq!(claims.value(ClaimId::Fig08StickLength1), 0.4697);
        let one_line = CLAIMS.lines().nth(1).unwrap();
        let without = CLAIMS.replacen(one_line, "", 1);
        let id = ClaimId::Eq12CriticalPoints;
        for (table, rows) in [(without, 0), (format!("{CLAIMS}{one_line}\n"), 2)] {
            let not_once = Claims::parse(&table).unwrap_err();
            assert!(
                not_once.contains(&format!("has {rows} rows {id};")),
                "{not_once}"
            );
        }
        let stranger = one_line.replacen("eq12.", "eq99.", 1);
        let unknown = Claims::parse(&format!("{CLAIMS}{stranger}\n")).unwrap_err();
        assert!(unknown.contains("none of the claims"), "{unknown}");
    }
}
