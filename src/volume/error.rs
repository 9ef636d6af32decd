//! Why a volume cannot be had. Every text says where, what is wrong and what would be right.

use std::io;
use std::path::{Path, PathBuf};

/// What sort of problem a [`VolumeError`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeErrorKind {
    /// The file is missing, not a regular file, or the system refused to read it.
    Io,
    /// A header or a compressed stream breaks the rules of its format.
    Malformed,
    /// The file is in order but uses something that is not supported.
    Unsupported,
    /// There are fewer, or more, bytes than the grid needs.
    Length,
    /// The grid does not fit into memory.
    Memory,
    /// The description given beside the file is missing something or does not apply.
    Options,
}

/// A volume file could not be read. The text is `PATH: what is wrong; what would be right`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}; {remedy}", path.display())]
pub struct VolumeError {
    path: PathBuf,
    kind: VolumeErrorKind,
    problem: String,
    remedy: String,
    source: Option<io::Error>,
}

impl VolumeError {
    /// What sort of problem it is.
    pub fn kind(&self) -> VolumeErrorKind {
        self.kind
    }

    /// The file the problem lies in; for a detached header this may be its data file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn new(
        kind: VolumeErrorKind,
        path: &Path,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { path: path.into(), kind, problem: problem.into(), remedy: remedy.into(), source: None }
    }

    pub(super) fn malformed(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(VolumeErrorKind::Malformed, path, problem, remedy)
    }

    pub(super) fn unsupported(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(VolumeErrorKind::Unsupported, path, problem, remedy)
    }

    pub(super) fn length(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(VolumeErrorKind::Length, path, problem, remedy)
    }

    pub(super) fn options(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(VolumeErrorKind::Options, path, problem, remedy)
    }

    pub(super) fn memory(path: &Path, bytes: u64) -> Self {
        let problem = format!("the voxels need {bytes} bytes, which could not be allocated");
        Self::new(VolumeErrorKind::Memory, path, problem, "use a smaller grid or a machine with more memory")
    }

    pub(super) fn grid(path: &Path, error: &GridError) -> Self {
        // The text of a grid error already has both halves.
        let text = error.to_string();
        let (problem, remedy) = text.split_once("; ").unwrap_or((&text, "correct the sizes"));
        Self::malformed(path, problem, remedy)
    }

    pub(super) fn not_a_file(path: &Path) -> Self {
        let remedy = "name one volume file (.nrrd, .nhdr, .nii, .nii.gz, .hdr, .mhd, .mha, .raw, .raw.gz)";
        Self::new(VolumeErrorKind::Io, path, "is not a regular file", remedy)
    }

    pub(super) fn io(path: &Path, source: io::Error) -> Self {
        let (problem, remedy) = match source.kind() {
            io::ErrorKind::NotFound => {
                ("there is no such file".into(), "check the path; it is relative to the file that names it")
            }
            io::ErrorKind::PermissionDenied => {
                ("the system denies reading it".into(), "make it readable for this user")
            }
            _ => (format!("cannot be read ({source})"), "check the file and its disk"),
        };
        Self { source: Some(source), ..Self::new(VolumeErrorKind::Io, path, problem, remedy) }
    }
}

impl From<VolumeError> for crate::Error {
    fn from(error: VolumeError) -> Self {
        Self::Input(error.to_string())
    }
}

/// A grid that cannot exist. The text is `what is wrong; what would be right`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// An extent is 0.
    #[error("a grid of {} voxels is empty; each extent must be at least 1", shape(.0))]
    Empty([usize; 3]),
    /// The number of bytes overflows the address space.
    #[error("a grid of {} voxels is more than memory can address; use smaller extents", shape(.0))]
    TooLarge([usize; 3]),
    /// The number of voxels is not the product of the extents.
    #[error("a grid of {} needs {expected} voxels; {found} were given", shape(.dims))]
    Count {
        /// The extents.
        dims: [usize; 3],
        /// Their product.
        expected: usize,
        /// The voxels given.
        found: usize,
    },
    /// A spacing is 0, negative, infinite or NaN.
    #[error("the spacing {0:?} is unusable; each must be finite and greater than 0")]
    Spacing([f64; 3]),
    /// The voxels could not be allocated.
    #[error("a grid of {} float32 voxels could not be allocated; use smaller extents", shape(.0))]
    Memory([usize; 3]),
}

impl From<GridError> for crate::Error {
    fn from(error: GridError) -> Self {
        Self::Input(error.to_string())
    }
}

/// `WxHxD`, as in the names of headerless raw files.
pub(super) fn shape(dims: &[usize; 3]) -> String {
    let [nx, ny, nz] = dims;
    format!("{nx}x{ny}x{nz}")
}
