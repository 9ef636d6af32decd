//! The command on files: exit codes, both reports, difference pictures.

use clap::Parser;

use super::*;
use crate::{
    metrics::test_pictures::noisy,
    picture::{read_exr, read_png, write_exr},
};

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: CompareArgs,
}

/// Writes two noisy pictures and runs the command on them with more arguments.
fn run_with(folder: &Path, more: &[&str]) -> (Result<()>, String) {
    let (image, reference) = (folder.join("a.exr"), folder.join("b.exr"));
    write_exr(&image, &noisy(5, 20, 1.0, 0.2, 16)).unwrap();
    write_exr(&reference, &noisy(6, 20, 1.0, 0.2, 256)).unwrap();
    let files = [Path::new("compare"), &image, &reference].map(|path| path.as_os_str().to_owned());
    let args = Cli::try_parse_from(files.into_iter().chain(more.iter().map(Into::into))).unwrap().args;
    let mut out = Vec::new();
    let outcome = run_to(&args, &mut out);
    (outcome, String::from_utf8(out).unwrap())
}

#[test]
fn the_table_names_every_metric() {
    let folder = tempfile::tempdir().unwrap();
    let (outcome, text) = run_with(folder.path(), &[]);
    outcome.unwrap();
    for word in ["MSE", "RMSE", "relMSE", "MAPE", "PSNR, P = ", "bias", "− both noises", "5 % expected"] {
        assert!(text.contains(word), "{word} in\n{text}");
    }
}

#[test]
fn json_is_all_of_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let (outcome, text) = run_with(folder.path(), &["--json", "--max-rmse", "10"]);
    outcome.unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(value["mse"]["high"].as_f64().unwrap() > value["mse"]["value"].as_f64().unwrap());
    assert_eq!(value["corrected"][0]["removed"], "reference");
    assert_eq!(value["thresholds"]["max_rmse"], 10.0);
    assert_eq!(value["violations"].as_array().unwrap().len(), 0);
}

#[test]
fn violations_come_together_with_exit_code_3() {
    let folder = tempfile::tempdir().unwrap();
    let (outcome, text) = run_with(folder.path(), &["--max-rmse", "1e-9", "--min-psnr", "200", "--json"]);
    let error = outcome.unwrap_err();
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("RMSE") && error.to_string().contains("PSNR"), "{error}");
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["violations"].as_array().unwrap().len(), 2);
}

#[test]
fn difference_pictures_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("d.exr"), folder.path().join("d.PNG"));
    run_with(folder.path(), &["--diff", exr.to_str().unwrap()]).0.unwrap();
    assert_eq!(read_exr(&exr).unwrap().channels.len(), 3);
    let (outcome, text) = run_with(folder.path(), &["--diff", png.to_str().unwrap()]);
    outcome.unwrap();
    assert!(text.contains("red +"), "{text}");
    assert_eq!(read_png(&png).unwrap().width, 20);
}

#[test]
fn wrong_input_is_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let (outcome, _) = run_with(folder.path(), &["--diff", "/nowhere/d.exr"]);
    assert_eq!(outcome.unwrap_err().exit_code(), 2);
    for bad in [["--max-rmse", "nan"], ["--max-bias=-1", "--json"], ["--min-psnr", "inf"]] {
        assert!(Cli::try_parse_from(["compare", "a", "b"].into_iter().chain(bad)).is_err(), "{bad:?}");
    }
}
