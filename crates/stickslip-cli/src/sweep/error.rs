//! Errors of sweeps on disk.

use std::io;
use std::path::{Path, PathBuf};

use output::WriteError;

/// Error of the computation of a block.
pub type BlockError = Box<dyn std::error::Error + Send + Sync>;

/// An error of a sweep. Blocks that are complete stay on disk, and the same command resumes from
/// them.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A folder cannot be created.
    #[error("cannot create the folder {}: {source}; choose another with --out", path.display())]
    CreateFolder {
        /// The folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {source}; finished blocks are on disk, and the same command resumes \
        from them", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Blocks have no manifest.
    #[error("{} has blocks but no manifest.json, so nothing says what they are of; put the \
        manifest back, or choose another folder", folder.display())]
    NoManifest {
        /// The folder of the sweep.
        folder: PathBuf,
    },
    /// A manifest that cannot be read.
    #[error("{} cannot be read ({reason}); put the right one back, delete the folder, or choose \
        another with --out", path.display())]
    BadManifest {
        /// The file.
        path: PathBuf,
        /// The fault.
        reason: String,
    },
    /// The folder holds another sweep.
    #[error("{} holds another sweep: {what} was {old} there and is {new} now; old and new blocks \
        are not mixed: give the old value to resume it, begin anew with --fresh (of another \
        command delete the folder), or choose another with --out", folder.display())]
    Differs {
        /// The folder of the sweep.
        folder: PathBuf,
        /// The argument, or the line of the system.
        what: String,
        /// Value in the folder.
        old: String,
        /// Value now.
        new: String,
    },
    /// A block that belongs to another sweep.
    #[error(
        "{} is a block of another sweep; move it away, and repeat the same command",
        path.display()
    )]
    BlockOfOtherSweep {
        /// The file.
        path: PathBuf,
    },
    /// A block that is damaged.
    #[error("block {block} in {} is {damage}; the same command recomputes it", folder.display())]
    Damaged {
        /// Index.
        block: usize,
        /// The fault.
        damage: String,
        /// The folder of the sweep.
        folder: PathBuf,
    },
    /// Another process computes the same share.
    #[error("another process computes share {share} in {}; wait for it to end, or choose another \
        folder with --out", folder.display())]
    Busy {
        /// The share.
        share: String,
        /// The folder of the sweep.
        folder: PathBuf,
    },
    /// No share of this number.
    #[error("`{text}` is no share; write I/N with 1 <= I <= N, such as 3/8")]
    Share {
        /// Text given.
        text: String,
    },
    /// The threads cannot be started.
    #[error("cannot start the threads: {reason}; give a smaller number with --threads")]
    Threads {
        /// The cause.
        reason: String,
    },
    /// The computation of a block failed.
    #[error("block {block}: {source}")]
    Block {
        /// Index of the block.
        block: usize,
        /// The cause.
        source: BlockError,
    },
    /// A share of another sweep among those to merge.
    #[error("{} and {} are shares of two sweeps: {what} is {one} in the first and {two} in the \
        second; merge shares of one sweep", first.display(), second.display())]
    ShareOfOtherSweep {
        /// The folder that was given first.
        first: PathBuf,
        /// The folder that does not belong to it.
        second: PathBuf,
        /// The argument, or the line of the system.
        what: String,
        /// Value in the first.
        one: String,
        /// Value in the second.
        two: String,
    },
    /// Nothing to merge.
    #[error("{} holds no sweep: there is no manifest.json in it; give the folders that the shares \
        were computed into", folder.display())]
    NoSweep {
        /// The folder that was given.
        folder: PathBuf,
    },
    /// Blocks that no share has.
    #[error(
        "{missing} of {total} blocks are missing: {which}{damaged}; compute them with the command \
            and the --shard that they are of, then merge again"
    )]
    Gaps {
        /// Number of missing blocks.
        missing: usize,
        /// Number of all blocks.
        total: usize,
        /// Missing blocks, as ranges.
        which: String,
        /// Damaged ones among them, as text; empty if none are.
        damaged: String,
    },
    /// Two shares have the same block with different content.
    #[error("block {block} in {} is not the one in {}; one of the two was not made by this program \
        on these arguments: find out which, and delete it", one.display(), other.display())]
    Overlap {
        /// Index.
        block: usize,
        /// A folder that has it.
        one: PathBuf,
        /// A folder that has it with different content.
        other: PathBuf,
    },
}

impl SweepError {
    /// Whether the command line is at fault, rather than the data or the machine.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Share { .. }
                | Self::Differs { .. }
                | Self::NoSweep { .. }
                | Self::ShareOfOtherSweep { .. }
        )
    }

    pub(super) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Read { path, source }
    }

    pub(super) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }
}

impl From<WriteError> for SweepError {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Folder { path, source } => Self::CreateFolder { path, source },
            WriteError::File { path, source } => Self::Write { path, source },
        }
    }
}
