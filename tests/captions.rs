//! The captions of Figs. 10–12 within their rounding: the committed table is what is computed.

use crate::common::NumericComparison;
use numerics::SplitMix;
use replication::captions::{
    CaptionSpectrum, CaptionTable, CaptionVariant, DRAWS, HALF_UNIT, caption_spectrum, committed,
};
use replication::figures::block_and_bracket::SETS;
use replication::motion::Class;

/// Tolerance of the golden files.
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
    }
}

#[test]
fn the_class_of_a_draw_is_that_of_its_exponents() {
    let table = committed().unwrap();
    for row in table.rows() {
        let zeros: Vec<usize> = (0..4).filter(|&k| row.is_zero(k)).collect();
        let is_positive = row.exponents[0] > 0.0 && !row.is_zero(0);
        match row.class {
            Class::Periodic(_) => assert_eq!(zeros, [0]),
            Class::QuasiPeriodic => assert_eq!(zeros, [0, 1]),
            Class::Chaotic => assert!(is_positive && zeros.contains(&1)),
            // A section that does not close, without a growth that is beyond its uncertainty.
            Class::Undecided => assert!(!is_positive),
        }
    }
}

#[test]
fn two_draws_of_fig_11_are_locked_and_slower_locking_passes_for_a_torus() {
    let table = committed().unwrap();
    let share = |figure, class| {
        let classes = table.classes(figure);
        let found = classes.iter().find(|one| one.0 == class);
        found.map_or(0, |one| one.1)
    };
    assert_eq!(share(0, Class::Periodic(1)), DRAWS);
    assert_eq!(share(1, Class::QuasiPeriodic), 197);
    assert_eq!(share(2, Class::Chaotic), 198);
    let slowest = table.slowest_unseen(1).unwrap();
    assert!((1e-3..1.1e-3).contains(&slowest), "{slowest}");
    assert_eq!(
        (table.slowest_unseen(0), table.slowest_unseen(2)),
        (None, None)
    );
    let locked = |row: &&CaptionSpectrum| row.figure == 1 && row.class == Class::Undecided;
    let locked = table.rows().iter().filter(locked);
    let decays = locked.map(|row| -row.exponents[1]);
    assert_eq!(decays.filter(|decay| *decay > slowest).count(), 2);
}

/// The range of an exponent that is zero by theorem, and of every one of a chaotic orbit, is no
/// effect of the captions: the draws scatter no more than their statistical errors say.
#[test]
fn ranges_that_are_called_scatter_are_within_the_statistical_errors() {
    let table = committed().unwrap();
    let zeros = [0, 1, 2].map(|figure| table.zero_by_theorem(figure).unwrap());
    assert_eq!(zeros, [0, 0, 1]);
    let scattered = |figure: usize, k: usize| {
        let is_draw = |row: &&CaptionSpectrum| {
            row.figure == figure && matches!(row.variant, CaptionVariant::Draw(_))
        };
        let draws = || table.rows().iter().filter(is_draw);
        let mean =
            |of: &dyn Fn(&CaptionSpectrum) -> f64| draws().map(of).sum::<f64>() / DRAWS as f64;
        let centre = mean(&|row| row.exponents[k]);
        let off = |row: &CaptionSpectrum| row.exponents[k] - centre;
        let spread = mean(&|row| off(row) * off(row)).sqrt();
        spread <= mean(&|row| row.std_errors[k])
    };
    for (figure, k) in [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2)] {
        assert!(scattered(figure, k), "figure {figure}, exponent {k}");
    }
    // That of Fig. 10's second exponent is an effect.
    assert!(!scattered(0, 1));
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
