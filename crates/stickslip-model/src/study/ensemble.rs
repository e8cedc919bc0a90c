//! Orbits from many starts, each with its own values of some parameters.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::file::{SettingError, System};

/// Bounds of the number of orbits that a thread takes at once. Chosen: enough to fill the lanes of
/// vectors, and few enough that no thread waits long for the others.
const FEWEST_AT_ONCE: usize = 16;
const MOST_AT_ONCE: usize = 128;

/// Parts into which the share of a thread is cut.
const PARTS_PER_THREAD: usize = 4;

/// Follows many orbits on all threads, block by block. Orbits of a block have the same values of
/// the named parameters and so one system.
///
/// `values` has a row for each orbit, and `block` returns what it finds of the orbits with these
/// numbers, in their order. It receives the error of values that the system cannot have, so that
/// these orbits keep the others. Returns what was found of all orbits, in the order of the rows.
pub fn by_system<T: Send>(
    system: &System,
    names: &[String],
    values: &[Vec<f64>],
    block: impl Fn(Result<&System, SettingError>, &[usize]) -> Vec<T> + Sync,
) -> Vec<T> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
    for (number, row) in values.iter().enumerate() {
        let bits = row.iter().map(|value| value.to_bits()).collect();
        let group = *known.entry(bits).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(number);
    }
    let parts = PARTS_PER_THREAD * rayon::current_num_threads();
    let size = (values.len() / parts).clamp(FEWEST_AT_ONCE, MOST_AT_ONCE);
    let blocks: Vec<&[usize]> = groups.iter().flat_map(|group| group.chunks(size)).collect();
    let followed = blocks.par_iter().with_max_len(1).map(|numbers| {
        let given = numbers.first().map_or(&[][..], |&number| &values[number]);
        if names.is_empty() {
            return block(Ok(system), numbers);
        }
        let names = names.iter().map(String::as_str);
        let pairs: Vec<(&str, f64)> = names.zip(given.iter().copied()).collect();
        match system.with_values(&pairs) {
            Ok(system) => block(Ok(&system), numbers),
            Err(error) => block(Err(error), numbers),
        }
    });
    let followed: Vec<Vec<T>> = followed.collect();
    let numbers = blocks.into_iter().flatten().copied();
    let mut numbered: Vec<(usize, T)> = numbers.zip(followed.into_iter().flatten()).collect();
    numbered.sort_by_key(|(number, _)| *number);
    numbered.into_iter().map(|(_, found)| found).collect()
}
