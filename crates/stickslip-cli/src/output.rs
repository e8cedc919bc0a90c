//! Files that are either complete or not there.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file to be written.
#[derive(Clone, Debug)]
pub struct Artifact {
    /// Name inside the output folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Artifact {
    /// A file of text.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        Artifact {
            name: name.into(),
            bytes: text.into().into_bytes(),
        }
    }

    /// A table with a heading, as CSV. Numbers are written so that they read back to the last bit.
    ///
    /// # Errors
    /// [`OutputError::Csv`] where a row has not as many fields as the heading.
    pub fn csv(
        name: impl Into<String>,
        heading: &[String],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Result<Self, OutputError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(heading)?;
        for row in rows {
            writer.write_record(&row)?;
        }
        let bytes = writer.into_inner().map_err(|error| error.into_error());
        let bytes = bytes.map_err(|error| OutputError::Csv(error.into()))?;
        let name = name.into();
        Ok(Artifact { name, bytes })
    }
}

/// Failure of making or writing files.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder cannot be made.
    #[error("cannot create folder {}: {source}; choose another with --out", path.display())]
    CreateDir {
        /// The folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error(
        "cannot write {}: {source}; check that the folder is writable and the disk not full, or choose another with --out",
        path.display()
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The rows do not fit into a CSV file.
    #[error("cannot put the rows into CSV: {0}")]
    Csv(#[from] csv::Error),
    /// The drawing failed.
    #[error(transparent)]
    Plot(#[from] plot::PlotError),
    /// `--png` was asked of a program built without it.
    #[error(
        "this program was built without PNG output; rebuild it with `cargo build --release -p stickslip-cli --features png`"
    )]
    PngNotBuilt,
    /// The SVG cannot be turned into a PNG.
    #[error("cannot render the SVG as PNG: {0}")]
    Png(String),
}

/// Writes all files into `folder`, which is made if it is missing, and returns their paths. Each gets a temporary name first and is
/// renamed when all are on disk, so that a reader never sees half of one.
///
/// # Errors
/// [`OutputError::CreateDir`], [`OutputError::Write`]; temporary files are removed.
pub fn write_all(folder: &Path, artifacts: &[Artifact]) -> Result<Vec<PathBuf>, OutputError> {
    std::fs::create_dir_all(folder).map_err(|source| OutputError::CreateDir {
        path: folder.to_owned(),
        // The system says no more than that something of this name exists.
        source: if folder.is_file() {
            std::io::Error::new(source.kind(), "it is a file, not a folder")
        } else {
            source
        },
    })?;
    let mut staged = Vec::with_capacity(artifacts.len());
    for artifact in artifacts {
        let path = folder.join(&artifact.name);
        let file = stage(folder, &artifact.bytes).map_err(|source| OutputError::Write {
            path: path.clone(),
            source,
        })?;
        staged.push((path, file));
    }
    let mut written = Vec::with_capacity(staged.len());
    for (path, file) in staged {
        file.persist(&path).map_err(|error| OutputError::Write {
            path: path.clone(),
            source: error.error,
        })?;
        written.push(path);
    }
    Ok(written)
}

fn stage(folder: &Path, bytes: &[u8]) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; results are to be read by everyone the umask lets.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Pixels of a PNG per px of the figure.
#[cfg(feature = "png")]
const ZOOM: f32 = 2.0;

/// Renders an SVG at twice its nominal size, with the embedded font only, so that it looks the same everywhere.
///
/// # Errors
/// [`OutputError::Png`] if the SVG cannot be read or encoded; [`OutputError::PngNotBuilt`] in a program without the feature `png`.
#[cfg(feature = "png")]
pub fn png(svg: &str) -> Result<Vec<u8>, OutputError> {
    use resvg::{tiny_skia, usvg};

    let mut options = usvg::Options::default();
    for (_, face) in &plot::FACES {
        options.fontdb_mut().load_font_data(face.to_vec());
    }
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| OutputError::Png(e.to_string()))?;
    let size = tree.size();
    let (width, height) = (size.width() * ZOOM, size.height() * ZOOM);
    let mut pixmap = tiny_skia::Pixmap::new(width.round() as u32, height.round() as u32)
        .ok_or_else(|| OutputError::Png(format!("no room for {width} x {height} pixels")))?;
    let zoom = tiny_skia::Transform::from_scale(ZOOM, ZOOM);
    resvg::render(&tree, zoom, &mut pixmap.as_mut());
    pixmap
        .encode_png()
        .map_err(|e| OutputError::Png(e.to_string()))
}

/// Says that this program cannot make PNG files.
///
/// # Errors
/// Always [`OutputError::PngNotBuilt`].
#[cfg(not(feature = "png"))]
pub fn png(_svg: &str) -> Result<Vec<u8>, OutputError> {
    Err(OutputError::PngNotBuilt)
}
