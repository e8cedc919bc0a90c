//! Choices of one of two expressions by a condition.

use std::ops::Range;

use super::super::Formula;
use super::calls::wrong_count;
use super::{BuildResult, Builder, Problem, no_number};
use crate::expression::{Binary, CHOICE, Condition, Expression, ExpressionKind, Id};

/// A choice in an expression.
#[derive(Clone, Debug)]
pub struct Chosen {
    pub test: Condition,
    /// The lead of each comparison, as of [`Builder::leads`].
    pub leads: Vec<Id>,
    /// The choices, by number, of whose branch it is part: that where they hold, or the other one.
    pub within: Vec<(usize, bool)>,
}

impl Builder<'_> {
    /// Adds the choice of one of two expressions, by the sign of a third.
    pub(super) fn choice(
        &mut self,
        formula: &Formula,
        arguments: &[Expression],
        (name, place): (Range<usize>, Range<usize>),
    ) -> BuildResult {
        if !self.chooses {
            return Err(
                Problem::new("a choice can stand only at a jump", name).help(
                    "in fields and laws what switches is a contact, by_side(contact, below, \
                     above), a jump that sets a discrete state, or a switch",
                ),
            );
        }
        let [condition, yes, no] = arguments else {
            let wanted = "a condition, the expression where it holds and the one elsewhere";
            return Err(wrong_count(CHOICE, wanted, arguments.len(), place));
        };
        let ExpressionKind::Condition(condition) = &condition.kind else {
            let place = formula.at(&condition.span);
            return Err(Problem::new("this is a number, not a condition", place)
                .help("a condition compares two numbers, as in v < 0.1"));
        };
        let number = self.choices.len();
        self.choices.push(Chosen {
            test: (**condition).clone(),
            leads: Vec::new(),
            within: self.within.clone(),
        });
        let mut branch = |holds: bool, of: &Expression| {
            self.within.push((number, holds));
            let made = self.expression(formula, of);
            self.within.pop();
            made
        };
        let branches = [branch(true, yes)?, branch(false, no)?];
        let leads = self.leads(formula, condition)?;
        if let Some(choice) = self.choices.get_mut(number) {
            choice.leads = leads;
        }
        self.chosen((formula, condition), branches, &place)
    }

    /// The number whose sign decides each comparison of a condition, in order.
    pub fn leads(&mut self, formula: &Formula, condition: &Condition) -> Result<Vec<Id>, Problem> {
        let numbers = condition.numbers();
        let pairs = numbers.chunks_exact(2);
        let lead = |pair: &[&Expression]| {
            let (larger, smaller) = (
                self.expression(formula, pair[0])?,
                self.expression(formula, pair[1])?,
            );
            let lead = self.graph.binary(Binary::Difference, larger, smaller);
            lead.map_err(|error| no_number(error, formula.at(&pair[0].span)))
        };
        pairs.map(lead).collect()
    }

    /// The first of two numbers where a condition holds, the second elsewhere.
    fn chosen(
        &mut self,
        (formula, condition): (&Formula, &Condition),
        [yes, no]: [Id; 2],
        place: &Range<usize>,
    ) -> BuildResult {
        match condition {
            Condition::Comparison {
                larger,
                smaller,
                with_equal,
            } => {
                // Where equal numbers count, the opposite is asked for.
                let ([more, less], [there, elsewhere]) = match with_equal {
                    false => ([larger, smaller], [yes, no]),
                    true => ([smaller, larger], [no, yes]),
                };
                let (more, less) = (
                    self.expression(formula, more)?,
                    self.expression(formula, less)?,
                );
                let lead = self.graph.binary(Binary::Difference, more, less);
                let made = lead.and_then(|lead| self.graph.chosen(lead, there, elsewhere));
                made.map_err(|error| no_number(error, place.clone()))
            }
            Condition::Not(part) => self.chosen((formula, part), [no, yes], place),
            Condition::All(parts) => parts.iter().rev().try_fold(yes, |yes, part| {
                self.chosen((formula, part), [yes, no], place)
            }),
            Condition::Any(parts) => parts.iter().rev().try_fold(no, |no, part| {
                self.chosen((formula, part), [yes, no], place)
            }),
        }
    }
}
