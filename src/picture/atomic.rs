//! Replacing a file whole or not at all.
//!
//! The new content goes to a temporary file in the folder of the target (only there is a rename
//! atomic), is synced to the disk and then renamed over the target. Whatever fails before the
//! rename, the old file is as it was and the temporary file is removed.
//!
//! A process that is killed leaves its temporary file behind. Its writer holds a lock on it, which
//! ends with the process: what nobody holds is a leftover ([`remove_leftovers`]).

use std::{
    fs::{self, File},
    io::{self, BufWriter, ErrorKind},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// What the names of temporary files begin and end with. Not with the target's name: with something
/// added it may exceed what the file system takes.
const NAME: [&str; 2] = [".svetlo-", ".part"];

/// Sweeps of other processes that may take a new file for a leftover before it is locked, one after another.
const SWEEPS: usize = 1000;

/// Writes a file atomically: `write` fills a temporary file, which then replaces `path`.
///
/// A symbolic link stays a link: the file it points to is replaced. The mode of an existing file
/// is kept; a new one gets the usual mode of new files.
///
/// # Errors
/// [`Error::Failed`] with the path, the cause and what to do; the old file is then untouched.
pub fn write_atomically<F>(path: &Path, write: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    replace(path, write).map_err(|cause| Error::Failed(explain(path, &cause)))
}

/// Checks before a long render that `path` can be written: its folder exists and takes a
/// temporary file, and `path` itself is a regular file or not there yet. Leaves nothing behind.
///
/// # Errors
/// [`Error::Input`] with the path, the cause and what to do.
pub fn check_writable(path: &Path) -> Result<()> {
    resolve(path)
        .and_then(|target| temporary(&target))
        .map(drop)
        .map_err(|cause| Error::Input(explain(path, &cause)))
}

/// Removes what killed writers left in the folder of `path`. Files that a living process writes,
/// here or on another machine, stay; so does everything where the file system knows no locks.
pub fn remove_leftovers(path: &Path) {
    let Ok(entries) = fs::read_dir(folder_of(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_ours = name.to_str().is_some_and(|name| name.starts_with(NAME[0]) && name.ends_with(NAME[1]));
        if is_ours && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            lock::remove_abandoned(&entry.path());
        }
    }
}

fn replace<F>(path: &Path, write: F) -> io::Result<()>
where
    F: FnOnce(&mut BufWriter<File>) -> io::Result<()>,
{
    let target = resolve(path)?;
    let (file, temporary) = temporary(&target)?.into_parts();
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    let file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_all()?;
    // The lock ends with the file, so it stays open; other systems refuse to rename an open file.
    let held = cfg!(unix).then_some(file);
    temporary.persist(&target).map_err(|failed| failed.error)?;
    drop(held);
    sync_folder(&target);
    Ok(())
}

/// The file that is really replaced: links followed, and nothing but a regular file or a free name.
///
/// Without this check a rename would turn a device such as `/dev/null` into an ordinary file.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    if path.file_name().is_none() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it names no file"));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => {
            Err(io::Error::new(ErrorKind::InvalidInput, "it is a device or a pipe, not a regular file"))
        }
        Ok(_) => fs::canonicalize(path),
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(path.to_owned()),
        Err(cause) => Err(cause),
    }
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An empty temporary file beside `target`, locked, with the mode the target has or would get.
fn temporary(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(NAME[0]).suffix(NAME[1]);
    // tempfile's private 0600 would make every result unreadable to colleagues.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder_of(target)).map_err(without_path)?;
    // Again where a sweep was quicker; not for ever, for file systems may say anything.
    for _ in 0..SWEEPS {
        if lock::hold(file.as_file()) {
            break;
        }
        file = builder.tempfile_in(folder_of(target)).map_err(without_path)?;
    }
    if let Ok(old) = fs::metadata(target) {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(file)
}

/// Locks that end with their process, however it ends.
#[cfg(unix)]
mod lock {
    use rustix::{
        fs::{FlockOperation::NonBlockingLockExclusive, flock},
        io::Errno,
    };
    use std::{fs, os::unix::fs::MetadataExt, path::Path};

    /// Locks a new file; `false` where another process took it for a leftover in the moment before.
    pub fn hold(file: &fs::File) -> bool {
        // Some file systems have no locks: there nobody takes it.
        flock(file, NonBlockingLockExclusive) != Err(Errno::WOULDBLOCK)
            && file.metadata().is_ok_and(|found| found.nlink() > 0)
    }

    /// Removes a file that nobody has locked.
    pub fn remove_abandoned(path: &Path) {
        // NFS locks only what is open for writing.
        if let Ok(file) = fs::OpenOptions::new().write(true).open(path)
            && flock(&file, NonBlockingLockExclusive).is_ok()
        {
            // Before the lock ends.
            let _ = fs::remove_file(path);
        }
    }
}

/// Without locks nothing is known to be abandoned.
#[cfg(not(unix))]
mod lock {
    use std::{fs::File, path::Path};

    pub fn hold(_: &File) -> bool {
        true
    }

    pub fn remove_abandoned(_: &Path) {}
}

/// `tempfile` adds the random name of its file to the message, which tells the user nothing.
fn without_path(cause: io::Error) -> io::Error {
    match cause.get_ref().and_then(|inner| inner.source()).and_then(|inner| inner.downcast_ref::<io::Error>())
    {
        Some(inner) => inner.raw_os_error().map_or_else(|| inner.kind().into(), io::Error::from_raw_os_error),
        None => cause.kind().into(),
    }
}

/// Makes the rename itself durable. Best effort: the content is already safe, and some file
/// systems cannot sync a folder.
fn sync_folder(target: &Path) {
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
}

fn explain(path: &Path, cause: &io::Error) -> String {
    let folder = folder_of(path).display();
    let advice = match cause.kind() {
        ErrorKind::NotFound => format!("create the folder {folder} first"),
        ErrorKind::NotADirectory => format!("{folder} must be a folder; choose another path"),
        ErrorKind::IsADirectory => "give the path of a file".into(),
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            format!("make the folder {folder} writable or choose another")
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space or choose another disk".into(),
        ErrorKind::FileTooLarge => "raise the file size limit (ulimit -f) or reduce the picture".into(),
        _ => "check the disk or choose another path".into(),
    };
    format!("{}: cannot be written ({cause}); {advice}", path.display())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn replaces_the_whole_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        for content in [&b"first, longer"[..], b"second"] {
            write_atomically(&path, |file| file.write_all(content)).unwrap();
            assert_eq!(fs::read(&path).unwrap(), content);
        }
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        fs::write(&path, b"old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert_eq!(error.exit_code(), 1);
        let text = error.to_string();
        assert!(text.starts_with(&path.display().to_string()), "{text}");
        assert!(text.contains("free some space"), "{text}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_panicking_writer_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        let outcome = std::panic::catch_unwind(|| write_atomically(&path, |_| panic!("injected")));
        assert!(outcome.is_err());
        assert_eq!(entries(folder.path()), 0);
    }

    #[test]
    fn impossible_targets_are_explained_before_and_while_writing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"x").unwrap();
        let missing = folder.path().join("missing/out.exr");
        for (path, advice) in [
            (missing.as_path(), "create the folder"),
            (&file.join("out.exr"), "must be a folder"),
            (folder.path(), "the path of a file"),
            (Path::new("/"), "the path of a file"),
            (Path::new(""), "the path of a file"),
        ] {
            let before = check_writable(path).unwrap_err();
            assert_eq!(before.exit_code(), 2);
            assert!(before.to_string().contains(advice), "{before}");
            let during = write_atomically(path, |_| Ok(())).unwrap_err();
            assert_eq!(during.exit_code(), 1);
            assert!(during.to_string().contains(advice), "{during}");
        }
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn check_writable_leaves_nothing_and_accepts_bare_names() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("out.exr")).unwrap();
        assert_eq!(entries(folder.path()), 0);
        assert_eq!(folder_of(Path::new("out.exr")), Path::new("."));
    }

    #[cfg(unix)]
    #[test]
    fn leftovers_are_removed_and_files_in_work_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        for name in [".svetlo-dead.part", ".svetlo-dead.exr", "svetlo-x.part"] {
            fs::write(folder.path().join(name), b"x").unwrap();
        }
        fs::create_dir(folder.path().join(".svetlo-folder.part")).unwrap();
        write_atomically(&path, |file| {
            assert_eq!(entries(folder.path()), 5);
            // Twice: a sweep must not loosen the lock.
            remove_leftovers(&path);
            remove_leftovers(&path);
            assert_eq!(entries(folder.path()), 4);
            file.write_all(b"whole")
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(entries(folder.path()), 4);
    }

    /// Writers and sweeps at the same time, as of many processes: a lock belongs to an open file, not to a process.
    #[cfg(unix)]
    #[test]
    fn sweeps_never_disturb_writers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        std::thread::scope(|scope| {
            let writers = [b'a', b'b'].map(|byte| {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..100 {
                        write_atomically(path, |file| file.write_all(&[byte; 9])).unwrap();
                        let read = fs::read(path).unwrap();
                        assert!(read == [b'a'; 9] || read == [b'b'; 9], "{read:?}");
                    }
                })
            });
            while writers.iter().any(|writer| !writer.is_finished()) {
                remove_leftovers(&path);
            }
        });
        assert_eq!(entries(folder.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_links_and_modes_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        assert!(
            check_writable(Path::new("/dev/null")).unwrap_err().to_string().contains("not a regular file")
        );

        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
