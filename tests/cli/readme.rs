//! The output shown in the README is what the program writes, but for times and memory.

use crate::common::{Finished, Scratch, meliora};

/// The blocks of the README that start with `$ meliora …`: the arguments and what is shown.
fn shown() -> Vec<(String, Vec<String>)> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
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
    text.lines().filter(|l| !varies(l)).map(|l| l.trim_end().to_owned()).collect()
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
fn the_readme_shows_what_the_program_writes() {
    let blocks = shown();
    assert!(blocks.len() >= 4, "{blocks:?}");
    let workshop = workshop();
    for (arguments, expected) in blocks {
        let mut command = meliora();
        let finished = Finished::of(command.current_dir(workshop.path(".")).args(split(&arguments)));
        let found = stable(&format!("{}{}", finished.stdout, finished.stderr));
        let trimmed = |lines: Vec<String>| lines.join("\n").trim().to_owned();
        assert_eq!(trimmed(found), trimmed(expected), "meliora {arguments}");
    }
}
