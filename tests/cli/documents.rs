//! What README and `docs/` say: their commands work as written, and their links lead somewhere.
//!
//! The commands of a document run in its order in one folder: lines of `sh` blocks that start with `svetlo `, `cp `,
//! `parallel ` or `sbatch `. A `toml` block that opens with `# NAME.toml` is that file, and so is a `bash` block that has
//! `# NAME.sbatch` below its first line. Pictures are made small, and long measurements short; nothing else is changed.
//! Slurm is a function that runs the tasks of a job one after another; and where GNU parallel
//! is missing, what it would run at once, too.

use crate::support::{Folder, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A step of a document.
#[derive(Debug, PartialEq)]
enum Step {
    File { name: String, text: String },
    Command(String),
}

fn steps(document: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else { continue };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        match language {
            "sh" => steps.extend(block.iter().filter_map(|line| command(line)).map(Step::Command)),
            "toml" => steps.extend(file(&block, 0, ".toml")),
            "bash" => steps.extend(file(&block, 1, ".sbatch")),
            _ => {}
        }
    }
    steps
}

fn command(line: &str) -> Option<String> {
    let known = ["svetlo ", "cp ", "parallel ", "sbatch "].iter().any(|start| line.starts_with(start));
    known.then(|| line.split(" #").next().unwrap_or(line).trim().to_owned())
}

/// The file whose name is in line `at` of a block.
fn file(block: &[&str], at: usize, extension: &str) -> Option<Step> {
    let name = block.get(at)?.strip_prefix("# ")?.split([':', ' ']).next()?;
    name.ends_with(extension).then(|| Step::File { name: name.into(), text: block.join("\n") + "\n" })
}

/// The command with small pictures and short measurements.
fn quick(command: &str) -> String {
    let without = |option: &str| match command.split_once(option) {
        Some((before, after)) => format!("{before}{}", after.find(' ').map_or("", |end| &after[end..])),
        None => command.to_owned(),
    };
    let small = "--set image.width=16 --set image.height=16";
    // Options go before what other programs add to the end.
    let render =
        |command: &str, more: &str| command.replace("svetlo render ", &format!("svetlo render {more} "));
    match command.split("svetlo ").nth(1).and_then(|rest| rest.split(' ').next()) {
        // Light in the volume takes the longest.
        Some("render") if command.contains("hybrid") => {
            let turntable = if command.contains("brain") { " --set camera.turntable.frames=2" } else { "" };
            let light = "--set method.iterations=1 --set method.coarsening=4";
            format!("{command} {small} --samples 1 {light}{turntable}")
        }
        Some("render") if command.contains("--part") => {
            render(&without(" --samples "), &format!("{small} --samples 8"))
        }
        Some("render") => render(&without(" --samples "), &format!("{small} --samples 1")),
        Some("ladder") => {
            let coarse = "--set volume.dims=[16,16,16] --set volume.spacing=0.0625";
            format!("{} {small} {coarse} --time 100ms --no-selftest", without(" --time "))
        }
        // Those of the project run for minutes: tests/bench runs smaller ones.
        Some("bench") if command.contains(" configs/") => format!("{command} --list"),
        Some("bench") => format!("{command} --no-selftest"),
        Some("selftest") => format!("{command} --only layout"),
        _ => command.to_owned(),
    }
}

/// A suite that takes seconds.
fn short(suite: &str) -> String {
    suite
        .replace("image.width=48", "image.width=12")
        .replace("image.height=48", "image.height=12")
        .replace("60s", "1s")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// `sbatch [--parsable] [--dependency=…] SCRIPT` as far as the documents use it.
const SLURM: &str = r#"sbatch() {
    for script; do :; done
    tasks=$(sed -n 's/^#SBATCH --array=\([0-9]*\)-\([0-9]*\)$/\1 \2/p' "$script")
    for task in $(seq ${tasks:-1 1}); do
        SLURM_ARRAY_TASK_ID=$task sh -e "$script" >&2 || return 1
    done
    echo 17
}
"#;

/// What GNU parallel would run of a command, one after another; other commands as they are.
fn one_by_one(command: &str) -> String {
    let Some(("parallel", (template, arguments))) =
        command.split_once(' ').and_then(|(program, rest)| Some((program, rest.split_once(" ::: ")?)))
    else {
        return command.into();
    };
    let start = template.find("svetlo ").unwrap_or(0);
    let runs = arguments.split(' ').map(|argument| template[start..].replace("{}", argument));
    runs.collect::<Vec<_>>().join(" && ")
}

#[track_caller]
fn follow(document: &str, least: usize) {
    let folder = Folder::new();
    std::os::unix::fs::symlink(root().join("configs"), folder.path("configs")).unwrap();
    std::fs::create_dir(folder.path("docs")).unwrap();
    std::fs::create_dir(folder.path("bin")).unwrap();
    let binary = folder.svetlo(&[""; 0]).get_program().to_owned();
    std::os::unix::fs::symlink(binary, folder.path("bin/svetlo")).unwrap();
    let path = format!("{}:{}", folder.path("bin").display(), std::env::var("PATH").unwrap_or_default());
    let has_parallel =
        Command::new("parallel").arg("--version").output().is_ok_and(|ran| ran.status.success());
    let steps = steps(&std::fs::read_to_string(root().join(document)).unwrap());
    assert!(steps.len() >= least, "{steps:?}");
    for step in steps {
        match step {
            Step::File { name, text } if name.ends_with(".sbatch") => {
                let lines: Vec<String> = text.lines().map(quick).collect();
                folder.write(&name, lines.join("\n") + "\n");
            }
            Step::File { name, text } => folder.write(&name, short(&text)),
            Step::Command(command) => {
                let command = if has_parallel { command } else { one_by_one(&command) };
                let line = format!("{SLURM}{}", quick(&command));
                let mut shell = Command::new("sh");
                let ran = run(shell.args(["-c", &line]).env("PATH", &path).current_dir(folder.path("")));
                // A machine that is busier than before is slower, which a baseline shows.
                let slower = command.contains("--baseline") && ran.code == Some(3);
                assert!(ran.code == Some(0) || slower, "{document}: {command}: {:?}: {}", ran.code, ran.err);
            }
        }
    }
}

#[test]
fn the_commands_of_the_readme_work() {
    follow("README.md", 9);
}

#[test]
fn the_commands_of_the_guide_work() {
    follow("docs/guide.md", 20);
}

#[test]
fn the_commands_of_the_gallery_work() {
    follow("docs/gallery.md", 8);
}

#[test]
fn every_document_is_followed() {
    let known = ["gallery.md", "guide.md"];
    let entries = std::fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.retain(|name| name.ends_with(".md"));
    names.sort();
    assert_eq!(names, known);
}

/// Targets of the links and pictures of a document that are files.
fn targets(text: &str) -> Vec<String> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    links.filter(|link| !link.starts_with("http")).map(str::to_owned).collect()
}

/// The anchors of a document's headings.
fn anchors(text: &str) -> Vec<String> {
    let heading =
        |line: &str| line.starts_with('#').then(|| line.trim_start_matches('#').trim().to_lowercase());
    let anchor = |heading: String| {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    text.lines().filter_map(heading).map(anchor).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut count = 0;
    for document in ["README.md", "CONTRIBUTING.md", "docs/guide.md", "docs/gallery.md"] {
        let path = root().join(document);
        let text = std::fs::read_to_string(&path).unwrap();
        for target in targets(&text) {
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let there: PathBuf =
                if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(there.exists(), "{document}: {target}");
            if !anchor.is_empty() {
                let anchors = anchors(&std::fs::read_to_string(there).unwrap());
                assert!(anchors.iter().any(|known| known == anchor), "{document}: {target}: {anchors:?}");
            }
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

#[test]
fn documents_are_read_as_they_are_meant() {
    let text = "# T\n```sh\nls\nsvetlo devices    # all\ncp a b\n```\n```toml\n# a.toml: a scene\nx = 1\n```\n\
                ```toml\nx = 1\n```\n```text\nsvetlo no\n```\n";
    let file = Step::File { name: "a.toml".into(), text: "# a.toml: a scene\nx = 1\n".into() };
    assert_eq!(steps(text), [Step::Command("svetlo devices".into()), Step::Command("cp a b".into()), file]);
    assert_eq!(
        quick("svetlo render a.toml --samples 64 -o b.exr"),
        "svetlo render --set image.width=16 --set image.height=16 --samples 1 a.toml -o b.exr"
    );
    let part = "parallel svetlo render a.toml --part {}/2 --samples 99 ::: 1 2";
    let small = "parallel svetlo render --set image.width=16 --set image.height=16 --samples 8 a.toml --part {}/2 ::: 1 2";
    assert_eq!(one_by_one("cp a b"), "cp a b");
    assert_eq!(
        one_by_one("parallel --joblog l svetlo merge {}.exr -o b{}.exr ::: 1 2"),
        "svetlo merge 1.exr -o b1.exr && svetlo merge 2.exr -o b2.exr"
    );
    assert_eq!((quick(part), quick("#!/bin/sh")), (small.into(), "#!/bin/sh".into()));
    assert_eq!(targets("[a](b.md#c) ![](d.png) [e](https://f)"), ["b.md#c", "d.png"]);
    assert_eq!(anchors("## The image, *here*\ntext"), ["the-image-here"]);
}
