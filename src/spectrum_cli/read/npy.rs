//! An array of numpy.

use std::io::BufRead;

use npyz::{DType, NpyFile, Order, TypeChar};

use super::{MOST, Table, layout::Layout};
use crate::spectrum_cli::error::SpectrumError;

const MARK: &[u8] = b"\x93NUMPY";

/// Whether the source begins as one.
pub(super) fn is_array(source: &mut impl BufRead) -> bool {
    source.fill_buf().is_ok_and(|start| start.starts_with(MARK))
}

/// Rows are states; an array of one dimension is one column.
pub(super) fn read(
    input: String,
    source: impl BufRead,
    wanted: &[String],
    dt: Option<f64>,
) -> Result<Table, SpectrumError> {
    let refused = |cause: String| SpectrumError::Array {
        input: input.clone(),
        cause,
    };
    let file = NpyFile::new(source).map_err(|error| refused(error.to_string()))?;
    let shape = file.shape().to_vec();
    let (rows, count) = match shape[..] {
        [rows] => (rows, 1),
        [rows, count] => (rows, count),
        _ => {
            return Err(refused(format!(
                "its shape is {shape:?}; give one of rows and columns"
            )));
        }
    };
    let numbers = usize::try_from(rows.saturating_mul(count)).unwrap_or(usize::MAX);
    if numbers > MOST {
        return Err(refused(format!(
            "it holds {numbers} numbers, at most {MOST} are read; save fewer columns, or thin the series"
        )));
    }
    let (rows, count) = (rows as usize, count as usize);
    if numbers == 0 {
        return Err(SpectrumError::Empty { input });
    }
    let by_rows = file.order() == Order::C;
    let values = numbers_of(file).map_err(refused)?;
    let at = |row: usize, column: usize| {
        values[if by_rows {
            row * count + column
        } else {
            column * rows + row
        }]
    };
    let layout = Layout::new(&input, count, None, wanted)?;
    let mut chosen = super::Rows::new(&layout);
    for row in 0..rows {
        for &column in &layout.columns {
            let value = at(row, column);
            if !value.is_finite() {
                return Err(refused(format!(
                    "row {}, column {} (counted from 1) is {value}; a series must have no gaps: cut it there or fill the gap",
                    row + 1,
                    column + 1
                )));
            }
            chosen.values.push(value);
        }
    }
    chosen.finish(dt)
}

/// Whatever real numbers they are, as doubles.
fn numbers_of<R: std::io::Read>(file: NpyFile<R>) -> Result<Vec<f64>, String> {
    let dtype = file.dtype();
    let DType::Plain(kind) = &dtype else {
        return Err("it is a structured array; give one of real numbers".to_owned());
    };
    let unknown = format!("its numbers are {}; save it as float64", dtype.descr());
    let read = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::UnexpectedEof => {
            "it ends before its last number; save or copy it once more".to_owned()
        }
        _ => error.to_string(),
    };
    let widened = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 8) => file.into_vec::<f64>().map_err(read)?,
        (TypeChar::Float, 4) => widen(file.into_vec::<f32>().map_err(read)?),
        // The default of numpy for whole numbers; what is above 2⁵³ is rounded.
        (TypeChar::Int, 8) => {
            let numbers = file.into_vec::<i64>().map_err(read)?;
            numbers.into_iter().map(|number| number as f64).collect()
        }
        (TypeChar::Int, 4) => widen(file.into_vec::<i32>().map_err(read)?),
        (TypeChar::Int, 2) => widen(file.into_vec::<i16>().map_err(read)?),
        (TypeChar::Uint, 4) => widen(file.into_vec::<u32>().map_err(read)?),
        (TypeChar::Uint, 2) => widen(file.into_vec::<u16>().map_err(read)?),
        (TypeChar::Uint, 1) => widen(file.into_vec::<u8>().map_err(read)?),
        _ => return Err(unknown),
    };
    Ok(widened)
}

fn widen<T: Into<f64>>(numbers: Vec<T>) -> Vec<f64> {
    numbers.into_iter().map(Into::into).collect()
}
