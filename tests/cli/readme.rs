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
    for page in pages() {
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
