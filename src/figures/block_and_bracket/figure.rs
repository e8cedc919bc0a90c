//! What makes a set of parameters a figure.

use super::{Data, Set, compute, draw, numbers};
use crate::figures::error::FigureError;
use crate::figures::rows::Row;
use crate::figures::spec::FigureSpec;

/// One of Figs. 10, 11 and 12: all that it is beyond what the three share.
pub trait BlockAndBracketFigure {
    /// Its parameters and the words of its picture.
    const SET: Set;
    /// [`FigureSpec::TITLE`].
    const TITLE: &'static str;
    /// [`FigureSpec::ABOUT`].
    const ABOUT: &'static str;
}

impl<F: BlockAndBracketFigure> FigureSpec for F {
    const NAME: &'static str = F::SET.figure.name();
    const TITLE: &'static str = <F as BlockAndBracketFigure>::TITLE;
    const ABOUT: &'static str = <F as BlockAndBracketFigure>::ABOUT;
    type Data = Data;

    fn compute() -> Result<Data, FigureError> {
        compute(&F::SET)
    }

    fn numbers(data: &Data) -> Vec<Row> {
        numbers(&F::SET, data)
    }

    fn draw(data: &Data) -> Result<String, FigureError> {
        draw(&F::SET, data)
    }
}
