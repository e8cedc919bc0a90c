//! NumPy arrays.

use std::io::{BufRead, Cursor, Error, ErrorKind, Read};

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::rows::Rows;
use super::{MOST_VALUES, NumberTable, TableError};

/// Longest header that is read, in bytes: as in NumPy (`max_header_size`).
const LONGEST_HEADER: usize = 10_000;

/// Deepest brackets within brackets in a header. Those of an array of numbers are two deep, those
/// of a structured array four. The reader of headers takes twice the time for each further one.
const DEEPEST_HEADER: usize = 4;

/// Whether the source begins like a NumPy array.
pub(super) fn is_array(source: &mut impl BufRead) -> bool {
    let start = source.fill_buf();
    start.is_ok_and(|start| start.starts_with(b"\x93NUMPY"))
}

/// Reads an array. Rows are states; a one-dimensional array is one column.
pub(super) fn read(
    input: String,
    mut source: impl BufRead,
    wanted: &[String],
    dt: Option<f64>,
) -> Result<NumberTable, TableError> {
    let refused = |cause: String| TableError::File(format!("{input} is a .npy array, but {cause}"));
    let header = header_of(&mut source).map_err(refused)?;
    let whole = Cursor::new(header).chain(source);
    let file = NpyFile::new(whole).map_err(|error| refused(error.to_string()))?;
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
    if numbers > MOST_VALUES {
        return Err(refused(format!(
            "it holds {numbers} numbers, at most {MOST_VALUES} are read; save fewer columns, or \
             thin the series"
        )));
    }
    if numbers == 0 {
        return Err(TableError::empty(&input));
    }
    let (rows, count) = (rows as usize, count as usize);
    let strides = match file.order() {
        Order::C => (count, 1),
        Order::Fortran => (1, rows),
    };
    let values = numbers_of(file).map_err(refused)?;
    let mut chosen = Rows::new(&input, count, None, wanted)?;
    for row in 0..rows {
        for &column in &chosen.columns {
            let value = values[row * strides.0 + column * strides.1];
            if !value.is_finite() {
                return Err(refused(format!(
                    "row {}, column {} (counted from 1) is {value}; a series must have no gaps: \
                        cut it there or fill the gap",
                    row + 1,
                    column + 1
                )));
            }
            chosen.values.push(value);
        }
    }
    chosen.finish(dt)
}

/// The bytes down to the end of the header.
fn header_of(source: &mut impl Read) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut take = |count: usize, bytes: &mut Vec<u8>| {
        let read = source.by_ref().take(count as u64).read_to_end(bytes);
        match read.map_err(|error| error.to_string())? {
            found if found == count => Ok(()),
            _ => Err("it ends within its header; save or copy it once more".to_owned()),
        }
    };
    // Six bytes of a mark and two of a version, which says how long the length is.
    take(8, &mut bytes)?;
    let size_of_length = if bytes[6] == 1 { 2 } else { 4 };
    take(size_of_length, &mut bytes)?;
    let digits = bytes[8..].iter().rev();
    let length = digits.fold(0, |sum, byte| sum * 256 + usize::from(*byte));
    if length > LONGEST_HEADER {
        return Err(format!(
            "its header has {length} bytes, at most {LONGEST_HEADER} are read; save an array of \
             numbers"
        ));
    }
    let begin = bytes.len();
    take(length, &mut bytes)?;
    let (mut depth, mut deepest) = (0_usize, 0);
    for byte in &bytes[begin..] {
        match byte {
            b'{' | b'[' | b'(' => depth += 1,
            b'}' | b']' | b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    if deepest > DEEPEST_HEADER {
        return Err(format!(
            "its header has brackets {deepest} deep, at most {DEEPEST_HEADER} are read; save an \
             array of numbers"
        ));
    }
    Ok(bytes)
}

/// Converts real numbers of any type to doubles.
fn numbers_of<R: Read>(file: NpyFile<R>) -> Result<Vec<f64>, String> {
    let dtype = file.dtype();
    let DType::Plain(kind) = &dtype else {
        return Err("it is a structured array; give one of real numbers".to_owned());
    };
    match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 8) => widened(file, |v: f64| v),
        (TypeChar::Float, 4) => widened(file, |v: f32| v.into()),
        // NumPy's default for integers; those above 2⁵³ are rounded.
        (TypeChar::Int, 8) => widened(file, |v: i64| v as f64),
        (TypeChar::Int, 4) => widened(file, |v: i32| v.into()),
        (TypeChar::Int, 2) => widened(file, |v: i16| v.into()),
        (TypeChar::Uint, 4) => widened(file, |v: u32| v.into()),
        (TypeChar::Uint, 2) => widened(file, |v: u16| v.into()),
        (TypeChar::Uint, 1) => widened(file, |v: u8| v.into()),
        _ => {
            let numbers = dtype.descr();
            Err(format!("its numbers are {numbers}; save it as float64"))
        }
    }
}

fn widened<R: Read, T: Deserialize>(
    file: NpyFile<R>,
    widen: impl Fn(T) -> f64,
) -> Result<Vec<f64>, String> {
    let cause = |error: Error| match error.kind() {
        ErrorKind::UnexpectedEof => {
            "it ends before its last number; save or copy it once more".to_owned()
        }
        _ => error.to_string(),
    };
    let numbers = file.into_vec::<T>().map_err(cause)?;
    Ok(numbers.into_iter().map(widen).collect())
}
