//! The cause of Fig. 8's numbers is shown, and would not be shown with another limit.

use super::with;
use replication::paper::listing::{Setup, run};
use replication::paper::pattern::Pattern;
use replication::paper::published::Claims;
use replication::paper::slip_times_three::{InjectedDefects, settled};
use replication::report::cause::{Cause, MotionComparison};
use replication::report::convergence::Convergence;

#[test]
fn all_three_parts_hold() {
    with(|report| {
        let cause = &report.ledger.cause;
        assert!(cause.is_shown(), "{:?}", cause.parts());
        assert!(cause.motion.holds() && cause.first_order() && cause.is_step_error());
        // The difference at the printed step is not rounding: it is far larger than at the finest
        // step.
        let step = cause.step.as_ref().unwrap();
        let largest = step
            .step_difference
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!(largest > 1e-4, "{step:?}");
    });
}

#[test]
fn a_wrong_limit_is_not_approached_and_leaves_no_step_error() {
    let published = Claims::committed().unwrap().published_stick_numbers();
    let printed = Pattern::of_listing(&run(&Setup::default())).unwrap();
    with(|report| {
        let right = &report.ledger.convergence;
        // The published numbers themselves, and each number alone changed by a fifth of its last
        // printed digit.
        let mut wrong = vec![published];
        for i in 0..4 {
            for off in [-2e-5, 2e-5] {
                let mut limit = right.limit;
                limit[i] += off;
                wrong.push(limit);
            }
        }
        for limit in wrong {
            let convergence = Convergence::new(
                limit,
                right.limit_digits,
                right.steps.clone(),
                right.around.clone(),
            );
            let both = report.ledger.injection.both.clone();
            let cause = Cause::new(&printed, both, &convergence, published);
            assert!(!cause.first_order(), "{limit:?}: {:?}", cause.parts());
            assert!(!cause.is_step_error(), "{limit:?}: {:?}", cause.parts());
            assert_eq!(cause.status(), "shown in part");
        }
    });
}

#[test]
fn only_both_defects_make_the_motion_and_the_numbers() {
    let published = Claims::committed().unwrap().published_stick_numbers();
    let printed = Pattern::of_listing(&run(&Setup::default())).unwrap();
    with(|report| {
        let most = MotionComparison::allowed_differences(&report.ledger.convergence);
        let motion = |injected, published| {
            MotionComparison::new(&printed, settled(injected), published, most)
        };
        let both = motion(InjectedDefects::BOTH, published);
        assert!(both.holds(), "{}", both.sentence());
        let twice = InjectedDefects {
            slip: 2.0,
            ..InjectedDefects::BOTH
        };
        for injected in [
            InjectedDefects::SLIP_ALONE,
            InjectedDefects::EXIT_ALONE,
            InjectedDefects::NONE,
            twice,
        ] {
            let without = motion(injected, published);
            assert!(!without.holds(), "{injected:?}: {}", without.sentence());
        }
        // If the third printed decimal were another, the numbers would not agree.
        let mut other = published;
        other[1] += 1e-3;
        assert!(!motion(InjectedDefects::BOTH, other).holds());
    });
}
