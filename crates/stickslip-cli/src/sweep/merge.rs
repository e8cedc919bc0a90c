//! Joins the shares of a sweep that were computed in separate folders.

use std::path::Path;

use super::error::SweepError;
use super::plan::Share;
use super::store::{Store, Writer};

/// Maximum number of ranges of missing blocks that an error lists.
const MOST_LISTED_RANGES: usize = 12;

/// Result of joining shares.
#[derive(Debug)]
pub struct Merged {
    /// The folder with all blocks.
    pub store: Store,
    /// Number of blocks that several folders contain, with the same bytes.
    pub repeated: usize,
}

/// Joins the blocks of the sweep whose shares are in `folders`, in the folder `out`, which may be
/// one of them. Everything is checked before anything is written.
///
/// # Errors
/// [`SweepError::NoSweep`] for a folder without one. [`SweepError::ShareOfOtherSweep`] for a share
/// of another sweep. [`SweepError::BlockOfOtherSweep`] for a block of another one.
/// [`SweepError::Gaps`]. [`SweepError::Overlap`]. [`SweepError::Differs`] if `out` holds another
/// sweep. Errors of files.
pub fn merge(out: &Path, folders: &[impl AsRef<Path>]) -> Result<Merged, SweepError> {
    let sources = folders
        .iter()
        .map(|folder| Store::open(folder.as_ref()))
        .collect::<Result<Vec<_>, _>>()?;
    let Some(first) = sources.first() else {
        return Err(SweepError::NoSweep {
            folder: out.to_owned(),
        });
    };
    for source in &sources {
        same_sweep(first, source)?;
        source.check_names()?;
    }
    let (mut missing, mut damaged, mut repeated) = (Vec::new(), Vec::new(), 0);
    let mut picked = Vec::with_capacity(first.plan().blocks());
    for block in 0..first.plan().blocks() {
        match pick(&sources, block)? {
            Ok((source, copies)) => {
                picked.push(source);
                repeated += usize::from(copies > 1);
            }
            Err(there) => {
                missing.push(block);
                damaged.extend(there);
            }
        }
    }
    if !missing.is_empty() {
        return Err(SweepError::Gaps {
            missing: missing.len(),
            total: first.plan().blocks(),
            which: ranges(&missing),
            damaged: if damaged.is_empty() {
                String::new()
            } else {
                format!(" ({})", damaged.join(", "))
            },
        });
    }
    let writer = Writer::open(out, first.plan(), Share::WHOLE)?;
    for (block, source) in picked.into_iter().enumerate() {
        let content = source.block(block)?;
        match writer.store.find(block)? {
            Some(Ok(there)) if there == content => {}
            Some(Ok(_)) => {
                return Err(SweepError::Overlap {
                    block,
                    one: out.to_owned(),
                    other: source.folder().to_owned(),
                });
            }
            Some(Err(_)) | None => writer.put(block, &content)?,
        }
    }
    let store = writer.store;
    Ok(Merged { store, repeated })
}

fn same_sweep(first: &Store, second: &Store) -> Result<(), SweepError> {
    match first.plan().difference(second.plan()) {
        None => Ok(()),
        Some((what, one, two)) => Err(SweepError::ShareOfOtherSweep {
            first: first.folder().to_owned(),
            second: second.folder().to_owned(),
            what,
            one,
            two,
        }),
    }
}

/// The first folder with a complete block, and the number of such folders. If there is none, the
/// damaged blocks.
type Picked<'a> = Result<(&'a Store, usize), Vec<String>>;

fn pick(sources: &[Store], block: usize) -> Result<Picked<'_>, SweepError> {
    let (mut complete, mut damaged) = (Vec::new(), Vec::new());
    for source in sources {
        match source.find(block)? {
            Some(Ok(content)) => complete.push((source, content)),
            Some(Err(damage)) => {
                damaged.push(format!("{} is {damage}", source.path(block).display()));
            }
            None => {}
        }
    }
    let Some((first, content)) = complete.first() else {
        return Ok(Err(damaged));
    };
    match complete.iter().find(|(_, other)| other != content) {
        None => Ok(Ok((first, complete.len()))),
        Some((other, _)) => Err(SweepError::Overlap {
            block,
            one: other.folder().to_owned(),
            other: first.folder().to_owned(),
        }),
    }
}

/// Ascending indices as text: `0-3, 7`.
fn ranges(blocks: &[usize]) -> String {
    let runs: Vec<&[usize]> = blocks.chunk_by(|one, next| one + 1 == *next).collect();
    let name = |run: &&[usize]| match run {
        [first, .., last] => format!("{first}-{last}"),
        [one] => one.to_string(),
        [] => String::new(),
    };
    let named: Vec<String> = runs.iter().take(MOST_LISTED_RANGES).map(name).collect();
    let rest: usize = runs
        .iter()
        .skip(MOST_LISTED_RANGES)
        .map(|run| run.len())
        .sum();
    if rest == 0 {
        named.join(", ")
    } else {
        format!("{} and {rest} more", named.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_blocks_are_told_as_ranges() {
        assert_eq!(ranges(&[0, 1, 2, 3, 7, 9, 10]), "0-3, 7, 9-10");
        let odd: Vec<usize> = (0..15).map(|k| 2 * k + 1).collect();
        assert_eq!(
            ranges(&odd),
            "1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23 and 3 more"
        );
    }
}
