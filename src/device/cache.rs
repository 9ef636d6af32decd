//! The binary cache: a build is reused only when everything that could change it is the same.

use super::DeviceInfo;
use crate::picture::{remove_leftovers, write_atomically};
use ocl::core::{self, ProgramInfo, ProgramInfoResult};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

/// Where one build is, or would be, stored.
///
/// The file holds the SHA-256 of the binary, then the binary; whatever does not match is rebuilt.
pub(super) struct Entry {
    path: PathBuf,
}

impl Entry {
    /// The entry of this source, these options, this device and driver, and this version of svetlo.
    ///
    /// `None` when there is no cache folder; an empty `SVETLO_CACHE_DIR` switches the cache off.
    pub fn locate(device: &DeviceInfo, source: &str, options: &str) -> Option<Self> {
        let parts = [
            source,
            options,
            &device.platform,
            &device.platform_version,
            &device.name,
            &device.vendor,
            &device.driver,
            &device.version,
            env!("CARGO_PKG_VERSION"),
        ];
        let mut hash = Sha256::new();
        for part in parts {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
        Some(Self { path: folder()?.join(format!("{}.clbin", hex(&hash.finalize()))) })
    }

    /// The stored binary, if it is there and whole.
    pub fn load(&self) -> Option<Vec<u8>> {
        let bytes = std::fs::read(&self.path).ok()?;
        let (sum, binary) = bytes.split_at_checked(32)?;
        (Sha256::digest(binary).as_slice() == sum).then(|| binary.to_vec())
    }

    /// Stores a built program; a cache that cannot be written only costs time, so failures are silent.
    pub fn store(&self, program: &core::Program) {
        let Ok(ProgramInfoResult::Binaries(binaries)) =
            core::get_program_info(program, ProgramInfo::Binaries)
        else {
            return;
        };
        if let [binary] = binaries.as_slice()
            && !binary.is_empty()
        {
            let _ = self.write(binary);
        }
    }

    fn write(&self, binary: &[u8]) -> std::io::Result<()> {
        let folder = self.path.parent().unwrap_or(&self.path);
        std::fs::create_dir_all(folder)?;
        // Rare enough: only who has built a program is here.
        remove_leftovers(&self.path);
        let whole = |file: &mut BufWriter<File>| {
            file.write_all(&Sha256::digest(binary))?;
            file.write_all(binary)
        };
        write_atomically(&self.path, whole).map_err(std::io::Error::other)
    }
}

/// `SVETLO_CACHE_DIR`, or `svetlo` in the user's cache folder.
fn folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    if let Some(value) = std::env::var_os("SVETLO_CACHE_DIR") {
        return (!value.is_empty()).then(|| PathBuf::from(value));
    }
    set("XDG_CACHE_HOME")
        .or_else(|| set("HOME").map(|home| home.join(".cache")))
        .map(|base| base.join("svetlo"))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
