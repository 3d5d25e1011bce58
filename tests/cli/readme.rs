//! The output shown in the README and in `docs/` is what the program writes, but for times and memory, and their
//! links lead somewhere.

use std::path::{Path, PathBuf};

use crate::common::{Finished, Scratch, meliora};

/// The README and the pages of `docs/`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|file| file.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|e| e == "md"));
    [root.join("README.md")].into_iter().chain(pages).collect()
}

/// The blocks of a page that start with `$ meliora …`: the arguments and what is shown.
fn shown(page: &Path) -> Vec<(String, Vec<String>)> {
    let text = std::fs::read_to_string(page).unwrap();
    let mut blocks = Vec::new();
    for block in text.split("```text\n").skip(1) {
        let block = block.split("```").next().unwrap();
        if let Some((command, output)) = block.split_once('\n')
            && let Some(arguments) = command.strip_prefix("$ meliora ")
        {
            blocks.push((arguments.to_owned(), stable(output)));
        }
    }
    blocks
}

/// The lines that do not speak of times or memory; the heading of a table of these is as wide as they.
fn stable(text: &str) -> Vec<String> {
    let varies = |line: &&str| {
        let parts = [" in all", " at most", " ms", " s ", " µs", "Prefer ", " tables "];
        parts.iter().any(|part| line.contains(part))
    };
    let timed = timed_columns(text.lines().next().unwrap_or_default());
    let blank = |line: &str| {
        let kept = line.chars().enumerate().filter(|(at, _)| !timed.iter().any(|column| column.contains(at)));
        kept.map(|(_, c)| c).collect::<String>().trim_end().to_owned()
    };
    text.lines().filter(|l| !varies(l)).map(blank).collect()
}

/// The columns of a sweep's table that differ from run to run, by the heading of the table: cells end where the
/// word above them ends.
fn timed_columns(heading: &str) -> Vec<std::ops::Range<usize>> {
    if !heading.starts_with("constants ") {
        return Vec::new();
    }
    let varying = ["seconds", "seconds_symbolic", "seconds_explicit", "prefer", "peak_nodes"];
    let (mut columns, mut start) = (Vec::new(), 0);
    for (at, _) in heading.match_indices(|c: char| c != ' ') {
        let end = at + 1;
        if heading[end..].starts_with(' ') || end == heading.len() {
            if varying.contains(&heading[start..end].trim()) {
                columns.push(start..end);
            }
            start = end;
        }
    }
    columns
}

/// Arguments as a shell would split them; single quotes keep blanks.
fn split(arguments: &str) -> Vec<String> {
    let parts = arguments.split('\'').enumerate();
    parts
        .flat_map(|(index, part)| match index % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect::<Vec<_>>(),
            _ => vec![part.to_owned()],
        })
        .collect()
}

/// A folder with the models, so that what a command writes lies there and not among the sources.
fn workshop() -> Scratch {
    let scratch = Scratch::new(&[]);
    std::fs::create_dir(scratch.path("models")).unwrap();
    for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/models")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), scratch.path("models").join(file.file_name())).unwrap();
    }
    scratch
}

#[test]
fn the_pages_show_what_the_program_writes() {
    let mut compared = 0;
    for page in pages() {
        let workshop = workshop();
        for (arguments, expected) in shown(&page) {
            let mut command = meliora();
            let finished = Finished::of(command.current_dir(workshop.path(".")).args(split(&arguments)));
            let found = stable(&format!("{}{}", finished.stdout, finished.stderr));
            let trimmed = |lines: Vec<String>| lines.join("\n").trim().to_owned();
            assert_eq!(trimmed(found), trimmed(expected), "{}: meliora {arguments}", page.display());
            compared += 1;
        }
    }
    assert!(compared >= 13, "{compared} examples");
}

#[test]
fn links_to_other_files_lead_to_files() {
    let mut followed = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = ["CHANGELOG.md", "CONTRIBUTING.md", "models/README.md", "python/README.md"];
    for page in pages().into_iter().chain(others.map(|name| root.join(name))) {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split([')', '#']).next().unwrap()) {
            if !link.is_empty() && !link.contains("://") {
                assert!(page.parent().unwrap().join(link).exists(), "{}: {link}", page.display());
                followed += 1;
            }
        }
    }
    assert!(followed >= 5, "{followed} links");
}

#[test]
fn times_of_sweeps_are_left_out_and_nothing_else() {
    let table = "constants      states     seconds  peak_nodes      status\n\
                 N=2                17       0.003         495        done\n";
    let found = ["constants      states      status", "N=2                17        done"];
    assert_eq!(stable(table), found);
    assert_eq!(stable("states     seconds\n17       0.003"), ["states     seconds", "17       0.003"]);
}

#[test]
fn the_readme_shows_the_model_that_it_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let readme = read("README.md");
    for (name, language) in [("models/drone.prism", "prism"), ("models/drone.pref", "text")] {
        let text = read(name);
        let text = text.split("\n\n").next().unwrap().trim_end();
        assert!(
            readme.contains(&format!("```{language}\n{text}\n```")),
            "{name} is not what the README shows"
        );
    }
}

/// The shell scripts of `docs/` that use the command, each run by `sh` as one job of a Slurm array would be.
#[cfg(unix)]
#[test]
fn the_shell_scripts_of_the_pages_run() {
    let program = Path::new(env!("CARGO_BIN_EXE_meliora")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut run = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        let scripts = text.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
        for script in scripts.filter(|script| script.lines().any(|line| line.starts_with("meliora "))) {
            let workshop = workshop();
            let mut shell = std::process::Command::new("sh");
            shell.args(["-e", "-c", script]).current_dir(workshop.path(".")).env("PATH", &path);
            shell.env("SLURM_ARRAY_TASK_ID", "1").env("SLURM_ARRAY_TASK_COUNT", "8");
            let output = shell.output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && stderr.is_empty(), "{}: {script}\n{stderr}", page.display());
            run += 1;
        }
    }
    assert!(run >= 2, "{run} scripts");
}
