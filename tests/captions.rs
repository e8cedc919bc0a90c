//! The captions of Figs. 10–12 within their rounding: the committed table is what is computed.

use crate::common::NumericComparison;
use numerics::SplitMix;
use replication::captions::{
    CaptionTable, CaptionVariant, DRAWS, HALF_UNIT, caption_spectrum, committed,
};
use replication::figures::block_and_bracket::SETS;

/// As for the other golden files.
const TOLERANCE: f64 = 1e-10;

#[test]
fn the_committed_draws_are_complete_and_within_the_rounding() {
    let table = committed().unwrap();
    for (figure, set) in SETS.iter().enumerate() {
        let rows = table.rows().iter().filter(|row| row.figure == figure);
        let rows: Vec<_> = rows.collect();
        let wanted: Vec<CaptionVariant> = CaptionVariant::all().collect();
        let found: Vec<CaptionVariant> = rows.iter().map(|row| row.variant).collect();
        assert_eq!(found, wanted, "run `make captions`");
        let mut farthest = [0.0_f64; 9];
        for row in rows {
            for (k, far) in farthest.iter_mut().enumerate() {
                *far = far.max((row.numbers[k] - set.caption.numbers[k]).abs());
            }
        }
        for (far, printed) in farthest.into_iter().zip(set.caption.numbers) {
            // Two hundred draws come near the ends of their interval.
            let wanted = if printed == 0.0 {
                0.0..=0.0
            } else {
                0.9 * HALF_UNIT..=HALF_UNIT
            };
            assert!(wanted.contains(&far), "{far}");
        }
        let classes: usize = table.classes(figure).iter().map(|(_, count)| count).sum();
        assert_eq!(classes, DRAWS);
    }
}

#[test]
fn five_draws_come_out_again() {
    let mut random = SplitMix::new(61);
    for _ in 0..5 {
        let figure = random.between(0.0, SETS.len() as f64) as usize;
        let variant = CaptionVariant::Draw(1 + random.between(0.0, DRAWS as f64) as usize);
        let rows = committed().unwrap().rows().iter();
        let mut rows = rows.filter(|row| row.figure == figure && row.variant == variant);
        let golden = CaptionTable::new(vec![rows.next().unwrap().clone()]).csv();
        let found = CaptionTable::new(vec![caption_spectrum(figure, variant).unwrap()]).csv();
        let [golden, found] = [golden, found].map(|text| text.replace(',', " "));
        let compare = NumericComparison {
            tolerance: TOLERANCE,
        };
        assert!(compare.same(&golden, &found), "{golden}\n{found}");
    }
}
