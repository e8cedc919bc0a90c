//! The folder of a sweep.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use output::{place, stage};

use super::block::{Decoded, decode, encode};
use super::error::SweepError;
use super::plan::{MANIFEST, Plan, Share, is_absent};

/// Name of the file that is locked.
const LOCK: &str = "lock";

/// Ending of the names of blocks.
const ENDING: &str = ".block";

/// The content of a block, or what is wrong with it.
pub type BlockContent = Result<Vec<u8>, &'static str>;

/// A folder with blocks of a sweep.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    plan: Plan,
    fingerprint: String,
    // Lock of a folder into which blocks are written. It is held until all results are written. The
    // operating system releases it however the process ends.
    _lock: Option<File>,
}

/// A folder into which the blocks of a share are written.
#[derive(Debug)]
pub struct Writer {
    /// Reads the blocks.
    pub store: Store,
    staging: PathBuf,
}

impl Store {
    /// The sweep in `folder`.
    ///
    /// # Errors
    /// [`SweepError::NoSweep`], [`SweepError::Read`], [`SweepError::BadManifest`].
    pub fn open(folder: &Path) -> Result<Self, SweepError> {
        let Some(plan) = Plan::read(folder)? else {
            return Err(SweepError::NoSweep {
                folder: folder.to_owned(),
            });
        };
        Self::of(folder, plan, None)
    }

    fn of(folder: &Path, plan: Plan, lock: Option<File>) -> Result<Self, SweepError> {
        Ok(Self {
            folder: folder.to_owned(),
            fingerprint: plan.fingerprint(folder)?,
            plan,
            _lock: lock,
        })
    }

    /// A folder for unfinished tables and figures. The next process that computes or merges the
    /// whole sweep removes what a kill leaves there.
    ///
    /// # Errors
    /// [`SweepError::CreateFolder`].
    pub fn staging(&self) -> Result<PathBuf, SweepError> {
        tables(&self.folder)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The plan of the sweep.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Passes the blocks to `each`, in order, one at a time.
    ///
    /// # Errors
    /// Those of `each`; [`SweepError::Damaged`] at a block that is not there or not whole,
    /// [`SweepError::BlockOfOtherSweep`], [`SweepError::Read`].
    pub fn for_each<E: From<SweepError>>(
        &self,
        mut each: impl FnMut(usize, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        for block in 0..self.plan.blocks() {
            each(block, &self.block(block)?)?;
        }
        Ok(())
    }

    /// The content of `block`.
    pub(super) fn block(&self, block: usize) -> Result<Vec<u8>, SweepError> {
        let damaged = |damage: &str| SweepError::Damaged {
            block,
            damage: damage.to_owned(),
            folder: self.folder.clone(),
        };
        let found = self.find(block)?.unwrap_or(Err("not there"));
        found.map_err(damaged)
    }

    /// The content of `block`, or what is wrong with it. `None` if there is no such file.
    ///
    /// # Errors
    /// [`SweepError::BlockOfOtherSweep`], [`SweepError::Read`].
    pub fn find(&self, block: usize) -> Result<Option<BlockContent>, SweepError> {
        let path = self.path(block);
        match fs::read(&path) {
            Ok(bytes) => match decode(&self.fingerprint, block, &bytes) {
                Decoded::Complete(content) => Ok(Some(Ok(content))),
                Decoded::Damaged(damage) => Ok(Some(Err(damage))),
                Decoded::OtherSweep => Err(SweepError::BlockOfOtherSweep { path }),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(source) => Err(SweepError::Read { path, source }),
        }
    }

    /// Checks that every file with the ending of a block has the name of a block of this sweep.
    pub(super) fn check_names(&self) -> Result<(), SweepError> {
        for name in block_names(&self.folder)? {
            let index = name.strip_suffix(ENDING).and_then(|stem| stem.parse().ok());
            let known = index.is_some_and(|index| {
                index < self.plan.blocks() && self.path(index).ends_with(&name)
            });
            if !known {
                return Err(SweepError::BlockOfOtherSweep {
                    path: blocks(&self.folder).join(name),
                });
            }
        }
        Ok(())
    }

    pub(super) fn path(&self, block: usize) -> PathBuf {
        blocks(&self.folder).join(format!("{block:08}{ENDING}"))
    }
}

impl Writer {
    /// Checks that a folder contains no other sweep, before anything is created.
    ///
    /// # Errors
    /// [`SweepError::Differs`], [`SweepError::NoManifest`], [`SweepError::BadManifest`],
    /// [`SweepError::Read`].
    pub fn check(folder: &Path, plan: &Plan) -> Result<(), SweepError> {
        is_free(folder, plan).map(drop)
    }

    /// Prepares the folder for a share of a sweep. No other process may work on that share, and the
    /// manifest must be of this sweep. Unfinished files are removed.
    ///
    /// # Errors
    /// [`SweepError::CreateFolder`], [`SweepError::Write`], [`SweepError::Read`],
    /// [`SweepError::Busy`], [`SweepError::Differs`], [`SweepError::BadManifest`],
    /// [`SweepError::NoManifest`].
    pub fn open(folder: &Path, plan: &Plan, share: Share) -> Result<Self, SweepError> {
        // This check comes first, so that a folder of another sweep is left unchanged.
        let is_new = is_free(folder, plan)?;
        let staging = folder
            .join("work")
            .join(share.to_string().replace('/', "-of-"));
        output::make_folder(&blocks(folder))?;
        output::make_folder(&staging)?;
        let tables = tables(folder)?;
        let unfinished: &[&Path] = if share.is_whole() {
            &[&staging, &tables]
        } else {
            &[&staging]
        };
        let lock = lock(&staging, share, folder, unfinished)?;
        if is_new {
            let path = folder.join(MANIFEST);
            write_once(&path, &staging, &plan.bytes(folder)?)?;
            // Another process may have written the manifest first, with other arguments.
            is_free(folder, plan)?;
        }
        Ok(Self {
            store: Store::of(folder, plan.clone(), Some(lock))?,
            staging,
        })
    }

    /// Removes the blocks of a share, so that it is computed anew.
    ///
    /// # Errors
    /// [`SweepError::Write`].
    pub fn remove_blocks(&self, share: Share) -> Result<(), SweepError> {
        let mut chains = share.chains(&self.store.plan).flatten();
        chains.try_for_each(|block| remove(&self.store.path(block)))
    }

    /// Removes a whole sweep of this command, whatever its arguments, with its manifest.
    ///
    /// # Errors
    /// [`SweepError::Read`], [`SweepError::Write`]; [`SweepError::Differs`] if the sweep is of
    /// another command, [`SweepError::NoManifest`] if nothing says what it is of,
    /// [`SweepError::Busy`] while another process is at work on a share.
    pub fn remove_sweep(folder: &Path, command: &str) -> Result<(), SweepError> {
        let Some(old) = Plan::command_in(folder)? else {
            return is_empty(folder).map(drop);
        };
        if old != command {
            return Err(SweepError::Differs {
                folder: folder.to_owned(),
                what: "the command".to_owned(),
                old: format!("`{old}`"),
                new: format!("`{command}`"),
            });
        }
        let begun = shares_begun(folder)?.into_iter();
        let locks = begun.map(|(share, staging)| lock(&staging, share, folder, &[]));
        let _locks = locks.collect::<Result<Vec<_>, _>>()?;
        for name in block_names(folder)? {
            remove(&blocks(folder).join(name))?;
        }
        // The manifest goes last: a kill before leaves a sweep with fewer blocks.
        remove(&folder.join(MANIFEST))
    }

    /// Writes a block, either completely or not at all. It replaces a previous version.
    ///
    /// # Errors
    /// [`SweepError::Write`].
    pub fn put(&self, block: usize, content: &[u8]) -> Result<(), SweepError> {
        let bytes = encode(&self.store.fingerprint, block, content);
        let path = self.store.path(block);
        write_whole(&path, &self.staging, |file| {
            file.write_all(&bytes).map_err(SweepError::write(&path))
        })
    }
}

/// The folder for unfinished tables, created if missing.
fn tables(folder: &Path) -> Result<PathBuf, SweepError> {
    let tables = folder.join("work").join("tables");
    output::make_folder(&tables)?;
    Ok(tables)
}

fn blocks(folder: &Path) -> PathBuf {
    folder.join("blocks")
}

/// Names of the files in the folder of blocks that have the ending of a block.
fn block_names(folder: &Path) -> Result<Vec<String>, SweepError> {
    let path = blocks(folder);
    let entries = match fs::read_dir(&path) {
        Ok(entries) => entries,
        Err(error) if is_absent(&error) => return Ok(Vec::new()),
        Err(source) => return Err(SweepError::Read { path, source }),
    };
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(SweepError::read(&path))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(ENDING) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// The shares that have begun, each with the folder of its lock.
fn shares_begun(folder: &Path) -> Result<Vec<(Share, PathBuf)>, SweepError> {
    let path = folder.join("work");
    let entries = match fs::read_dir(&path) {
        Err(error) if is_absent(&error) => return Ok(Vec::new()),
        entries => entries.map_err(SweepError::read(&path))?,
    };
    let mut begun = Vec::new();
    for entry in entries {
        let entry = entry.map_err(SweepError::read(&path))?;
        let name = entry.file_name().to_string_lossy().replace("-of-", "/");
        if let Ok(share) = name.parse() {
            begun.push((share, entry.path()));
        }
    }
    Ok(begun)
}

/// Whether there is no sweep in `folder` yet. A sweep that exists must be the wanted one.
fn is_free(folder: &Path, wanted: &Plan) -> Result<bool, SweepError> {
    let there = Plan::read(folder)?;
    let folder = folder.to_owned();
    match there.as_ref().map(|there| there.difference(wanted)) {
        Some(None) => Ok(false),
        Some(Some((what, old, new))) => Err(SweepError::Differs {
            folder,
            what,
            old,
            new,
        }),
        None => is_empty(&folder),
    }
}

/// Checks that a folder without manifest holds no blocks.
fn is_empty(folder: &Path) -> Result<bool, SweepError> {
    match block_names(folder)?.is_empty() {
        true => Ok(true),
        false => Err(SweepError::NoManifest {
            folder: folder.to_owned(),
        }),
    }
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<(), SweepError> {
    match fs::remove_file(path) {
        Err(error) if !is_absent(&error) => Err(SweepError::write(path)(error)),
        _ => Ok(()),
    }
}

/// Tries of a lock, with a pause before each, before another process is said to hold it. A process
/// that was just killed holds it for a moment, and so does a child that has not begun its program.
const LOCK_TRIES: u32 = 10;
const LOCK_PAUSE: std::time::Duration = std::time::Duration::from_millis(1);

/// Acquires the lock of a share. Its holder removes what a killed process has left in the folders
/// for unfinished files.
fn lock(
    staging: &Path,
    share: Share,
    folder: &Path,
    unfinished: &[&Path],
) -> Result<File, SweepError> {
    let path = staging.join(LOCK);
    let file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(SweepError::write(&path))?;
    let mut locked = file.try_lock();
    for _ in 0..LOCK_TRIES {
        if !matches!(locked, Err(TryLockError::WouldBlock)) {
            break;
        }
        std::thread::sleep(LOCK_PAUSE);
        locked = file.try_lock();
    }
    match locked {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(SweepError::Busy {
                share: share.to_string(),
                folder: folder.to_owned(),
            });
        }
        // Some shared file systems have no locks. Two processes on one share then do the same work
        // twice and write the same bytes. Unfinished files must stay, because they may belong to
        // the other process.
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
            return Ok(file);
        }
        Err(TryLockError::Error(source)) => return Err(SweepError::Write { path, source }),
    }
    unfinished.iter().try_for_each(|folder| clear(folder))?;
    Ok(file)
}

/// Removes what a killed process has left unfinished.
fn clear(staging: &Path) -> Result<(), SweepError> {
    let clear = || -> io::Result<()> {
        for entry in fs::read_dir(staging)? {
            let entry = entry?;
            if entry.file_name() != LOCK {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    };
    clear().map_err(SweepError::write(staging))
}

/// Writes a table or another file that may not fit into memory. `content` writes it in parts to a
/// temporary file in `staging`, which is renamed when it is complete. Both folders must exist.
///
/// # Errors Those of `content`; [`SweepError::Write`]. A previous file at `path` then stays.
pub fn write_whole<E: From<SweepError>>(
    path: &Path,
    staging: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let failed = SweepError::write(path);
    let mut of_content = Ok(());
    let staged = stage(staging, |file| {
        of_content = content(file);
        Ok(())
    });
    of_content?;
    let placed = staged.and_then(|file| place(file, path));
    Ok(placed.map_err(failed)?)
}

/// [`write_whole`], except that an existing file stays: the first process to finish has written it.
///
/// # Errors
/// [`SweepError::Write`].
fn write_once(path: &Path, staging: &Path, bytes: &[u8]) -> Result<(), SweepError> {
    let staged = stage(staging, |file| file.write_all(bytes)).map_err(SweepError::write(path))?;
    match staged.persist_noclobber(path) {
        Err(error) if error.error.kind() != ErrorKind::AlreadyExists => {
            Err(SweepError::write(path)(error.error))
        }
        _ => Ok(()),
    }
}
