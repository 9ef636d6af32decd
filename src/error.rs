//! The one error type that reaches `main`, and the exit code of each kind.

/// Why a command ended without success.
///
/// The text is what the user reads: it says where, what, and what would be right.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Error {
    /// The input is wrong: arguments, scene or data. Exit code 2.
    #[error("{0}")]
    Input(String),
    /// It failed while running: device, memory, disk. Exit code 1.
    #[error("{0}")]
    Failed(String),
    /// A comparison or self-test is out of tolerance. Exit code 3.
    #[error("{0}")]
    Tolerance(String),
    /// Interrupted by the user, after the last image was written whole. Exit code 130.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// The documented process exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Input(_) => 2,
            Self::Tolerance(_) => 3,
            Self::Interrupted => 130,
        }
    }
}

/// Result with the crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;
