//! Paths that are no files: folders, pipes, devices, loops of links, files that may not be read, and odd names.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc;
use svetlo::picture::{Environment, read_picture};
use svetlo::scene::{Surface, SurfaceMaterial, SurfaceShape};
use svetlo::volume::{Components, RawOptions};
use tempfile::TempDir;

type Reader = (&'static str, fn(&Path) -> Result<(), String>);

/// All that opens what a user names, and how such a file is called.
const READERS: [Reader; 9] = [
    ("nrrd", volume),
    ("nii.gz", volume),
    ("mhd", volume),
    ("raw", volume),
    ("dat", volume),
    ("nrrd", |path| Components::read(path).map(drop).map_err(|error| error.to_string())),
    ("exr", |path| Environment::read(path).map(drop).map_err(|error| error.to_string())),
    ("png", |path| read_picture(path).map(drop).map_err(|error| error.to_string())),
    ("ply", mesh),
];

fn volume(path: &Path) -> Result<(), String> {
    svetlo::volume::read(path, &RawOptions::default()).map(drop).map_err(|error| error.to_string())
}

fn mesh(path: &Path) -> Result<(), String> {
    let shape =
        SurfaceShape::Mesh { path: path.into(), scale: 1.0, translate: glam::DVec3::ZERO, smooth: false };
    let mirror = SurfaceMaterial::Mirror { color: [1.0; 3] };
    svetlo::surfaces::load(&[Surface { shape, material: 0 }], &[mirror]).map(drop).map_err(|e| e.to_string())
}

/// Every reader refuses what `make` puts at a path, soon, and names the path.
fn refused(make: impl Fn(&Path), needles: &[&str]) {
    for (end, read) in READERS {
        let folder = TempDir::new().unwrap();
        let path: PathBuf = folder.path().join(format!("x.{end}"));
        make(&path);
        let (answer, answers) = mpsc::channel();
        let given = path.clone();
        std::thread::spawn(move || answer.send(read(&given)));
        let error = answers.recv_timeout(crate::HANGS).expect("an answer in time").expect_err(end);
        assert!(error.contains(&path.display().to_string()), "{error}");
        assert!(needles.iter().any(|needle| error.contains(needle)), "{end}: none of {needles:?} in {error}");
    }
}

#[test]
fn what_is_no_file() {
    let no_file = ["not a regular file", "it is a folder"];
    refused(|path| std::fs::create_dir(path).unwrap(), &no_file);
    refused(|path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success()), &no_file);
    refused(|path| symlink("/dev/zero", path).unwrap(), &no_file);
    refused(|path| symlink("/dev/null", path).unwrap(), &no_file);
}

#[test]
fn links_that_lead_nowhere() {
    refused(|path| symlink(path, path).unwrap(), &["symbolic link", "Too many levels"]);
    refused(|path| symlink("nothing", path).unwrap(), &["no such file", "No such file"]);
}

#[test]
fn files_that_may_not_be_read() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x");
    let lock = |path: &Path| {
        std::fs::write(path, "text").unwrap();
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o000)).unwrap();
    };
    lock(&path);
    if std::fs::read(&path).is_ok() {
        return; // Root may read everything.
    }
    refused(lock, &["denie", "denied"]);
}

/// Names are bytes; messages show them as well as they can.
#[test]
fn names_that_are_no_text() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(OsStr::from_bytes(b"vol\xff_2x1x1_uint8.raw"));
    std::fs::write(&path, [1, 2]).unwrap();
    volume(&path).unwrap();
    std::fs::write(&path, [1]).unwrap();
    assert!(volume(&path).unwrap_err().contains("vol\u{fffd}_2x1x1_uint8.raw: expected 2 bytes"));
}
