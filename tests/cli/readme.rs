//! The pages show the output of the program, nodes of diagrams included, except times and memory. Their links
//! lead to files.
//!
//! A page's blocks are processed in its order. A block ```` ```LANGUAGE file=NAME ```` is written to
//! the file NAME in the folder of the page. A block ```` ```text ```` that starts with
//! `$ meliora …` is run in that folder, which also contains a copy of `models/`. A line `…` in the
//! expected output stands for any number of lines. A block ```` ```sh ```` or ```` ```python ```` that needs other
//! programs says so: ```` ```sh needs=TOOL ````. All others are run: by the tests below, by
//! `python/tests/test_pages.py`, or by `.ci/run`.

use crate::common::prelude::*;

/// The two files named README, and the pages of `docs/`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|file| file.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|e| e == "md"));
    let readmes = ["README.md", "python/README.md"].map(|name| root.join(name));
    readmes.into_iter().chain(pages).collect()
}

/// A block of a page that the test acts on.
enum Block {
    /// A file for the commands that follow.
    File { name: String, text: String },
    /// A command with the lines shown below it.
    Command { arguments: String, output: Vec<String> },
}

/// Returns the blocks between fences: the words after the opening fence, and the text.
fn fenced(page: &str) -> impl Iterator<Item = (&str, &str)> {
    let parts = page.split("\n```").skip(1).step_by(2);
    parts.map(|part| part.split_once('\n').unwrap_or((part, "")))
}

/// Returns the blocks of a page that define a file or start with `$ meliora …`, in their order.
fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (info, body) in fenced(page) {
        let body = format!("{body}\n");
        let name = info.split_whitespace().find_map(|word| word.strip_prefix("file="));
        let run = body.strip_prefix("$ meliora ").filter(|_| info == "text");
        if let Some(name) = name {
            blocks.push(Block::File { name: name.to_owned(), text: body });
        } else if let Some((arguments, output)) = run.and_then(|run| run.split_once('\n')) {
            blocks.push(Block::Command { arguments: arguments.to_owned(), output: stable(output) });
        }
    }
    blocks
}

/// Returns true if `expected` shows the lines of `found`; a line `…` in `expected` stands for any
/// number of lines.
fn shows(expected: &[String], found: &[String]) -> bool {
    let parts: Vec<&[String]> = expected.split(|line| line == "…").collect();
    let [first, middle @ .., last] = parts.as_slice() else { return expected == found };
    let Some(mut rest) = found.strip_prefix(*first) else { return false };
    for part in middle.iter().filter(|part| !part.is_empty()) {
        let Some(start) = rest.windows(part.len()).position(|lines| lines == *part) else { return false };
        rest = &rest[start + part.len()..];
    }
    rest.ends_with(last)
}

/// The lines with the times and the memory of the last ones replaced by `#`. Tables of times are left out with
/// their heading, whose width depends on them; of the table of two engines, the nodes are kept.
fn stable(text: &str) -> Vec<String> {
    let is_number = |c: char| c.is_ascii_digit();
    let is_footer = |line: &str| {
        line.starts_with(is_number)
            && [" in all", " of memory at most"].iter().any(|part| line.contains(part))
    };
    let varies = |line: &&str| {
        let parts = [" ms", " s ", " µs", "Prefer ", " tables "];
        !is_footer(line) && parts.iter().any(|part| line.contains(part))
    };
    let timed = timed_columns(&text.lines().collect::<Vec<_>>());
    let blank = |line: &str| {
        let kept = line.chars().enumerate().filter(|(at, _)| !timed.iter().any(|column| column.contains(at)));
        kept.map(|(_, c)| c).collect::<String>().trim_end().to_owned()
    };
    let shown = |line: &str| match nodes_of_engine(line) {
        Some(nodes) => Some(nodes),
        None if is_footer(line) => Some(without_measures(line)),
        None => (!varies(&line)).then(|| blank(line)),
    };
    text.lines().filter_map(shown).collect()
}

/// The engine and the nodes of a row of the table of two engines: `symbolic: 1,135 nodes`.
fn nodes_of_engine(line: &str) -> Option<String> {
    let engine =
        line.trim_start().split(' ').next().filter(|name| ["symbolic", "explicit"].contains(name))?;
    let nodes = line.rsplit(' ').next().filter(|_| line.contains("s  "))?;
    nodes.starts_with(|c: char| c.is_ascii_digit()).then(|| format!("{engine}: {nodes} nodes"))
}

/// A line whose numbers, with their units, are replaced by `#`, except those of nodes: `2 ms in all: parse 465
/// µs` becomes `# in all: parse #`.
fn without_measures(line: &str) -> String {
    const UNITS: [&str; 10] = ["ns", "µs", "ms", "s", "min", "h", "B", "KiB", "MiB", "GiB"];
    let mut words: Vec<String> = Vec::new();
    let mut rest = line.split(' ').peekable();
    while let Some(word) = rest.next() {
        let is_count = rest.peek() == Some(&"nodes");
        let (word, comma) = word.strip_suffix(',').map_or((word, ""), |word| (word, ","));
        let is_unit = UNITS.contains(&word) && words.last().is_some_and(|last| last == "#");
        if is_unit {
            words.pop();
        }
        let is_number = word.starts_with(|c: char| c.is_ascii_digit()) && !is_count;
        words.push(format!("{}{comma}", if is_unit || is_number { "#" } else { word }));
    }
    words.join(" ")
}

/// The columns of a sweep's table that differ from run to run. The heading has several lines, of which the last one
/// starts with `constants`; cells end where the word in this line ends.
fn timed_columns(lines: &[&str]) -> Vec<std::ops::Range<usize>> {
    let Some(last) = lines.iter().position(|line| line.starts_with("constants ")) else { return Vec::new() };
    let heading = lines[last];
    let varying = ["seconds", "seconds_symbolic", "seconds_explicit", "prefer"];
    let (mut columns, mut start) = (Vec::new(), 0);
    for (at, _) in heading.match_indices(|c: char| c != ' ') {
        let end = at + 1;
        if heading[end..].starts_with(' ') || end == heading.len() {
            let words = lines[..=last].iter().filter_map(|line| line.get(start..end.min(line.len())));
            let words: Vec<&str> = words.map(str::trim).filter(|word| !word.is_empty()).collect();
            if varying.contains(&words.join("_").as_str()) {
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
        // The generator of models stands next to them.
        if file.file_type().unwrap().is_file() {
            std::fs::copy(file.path(), scratch.path("models").join(file.file_name())).unwrap();
        }
    }
    scratch
}

/// Runs a command of a page and requires the output shown.
fn run_shown(page: &Path, workshop: &Scratch, arguments: &str, expected: &[String]) {
    let mut command = executable();
    let finished = Finished::of(command.current_dir(workshop.path(".")).args(split(arguments)));
    let found = stable(&format!("{}{}", finished.stdout, finished.stderr));
    let (found, expected) = (trimmed(&found), trimmed(expected));
    let message = format!("{}: meliora {arguments}", page.display());
    assert!(shows(expected, found), "{message}\n{}\n--- shown:\n{}", found.join("\n"), expected.join("\n"));
}

/// The lines without empty ones at the beginning and the end.
fn trimmed(lines: &[String]) -> &[String] {
    let start = lines.iter().position(|line| !line.is_empty()).unwrap_or(lines.len());
    let end = lines.iter().rposition(|line| !line.is_empty()).map_or(start, |last| last + 1);
    &lines[start..end]
}

#[test]
fn the_pages_show_what_the_program_writes() {
    let mut compared = 0;
    for page in pages() {
        let workshop = workshop();
        let mut unused = Vec::new();
        for block in blocks(&std::fs::read_to_string(&page).unwrap()) {
            match block {
                Block::File { name, text } => {
                    std::fs::write(workshop.path(&name), text).unwrap();
                    unused.push(name);
                }
                Block::Command { arguments, output } => {
                    run_shown(&page, &workshop, &arguments, &output);
                    unused.retain(|name| !split(&arguments).contains(name));
                    compared += 1;
                }
            }
        }
        assert!(unused.is_empty(), "{}: no command reads {unused:?}", page.display());
    }
    assert!(compared >= 13, "{compared} examples");
}

#[test]
fn a_page_defines_files_for_the_commands_that_follow() {
    let file = "# A\n\n```prism file=a.prism\nmdp\n```\n\n```sh\nmake\n```\n";
    let page = &format!("{file}\n```text\n$ meliora info a.prism\nx\n…\n```\n");
    match blocks(page).as_slice() {
        [Block::File { name, text }, Block::Command { arguments, output }] => {
            assert_eq!((name.as_str(), text.as_str()), ("a.prism", "mdp\n"));
            assert_eq!((arguments.as_str(), output.join("|").as_str()), ("info a.prism", "x|…"));
        }
        other => panic!("{} blocks", other.len()),
    }
}

#[test]
fn lines_left_out_are_any_lines_and_all_others_are_compared() {
    let lines = |text: &str| -> Vec<String> { text.split_whitespace().map(str::to_owned).collect() };
    for (expected, found, wanted) in [
        ("a b", "a b", true),
        ("a b", "a b c", false),
        ("a …", "a b c", true),
        ("… c", "a b c", true),
        ("… b", "a b c", false),
        ("a … b … d", "a x b y d", true),
        ("a … b … d", "a y d", false),
        ("a … c b … d", "a b c d", false),
        ("b … a", "a b a", false),
        ("a … a", "a", false),
    ] {
        assert_eq!(shows(&lines(expected), &lines(found)), wanted, "{expected} shows {found}");
    }
}

/// The anchor of a heading, as GitHub forms it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// Returns true if a page has a heading with this anchor.
fn has_heading(page: &Path, wanted: &str) -> bool {
    let text = std::fs::read_to_string(page).unwrap();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).any(|found| found == wanted)
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut followed = 0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = ["CHANGELOG.md", "CONTRIBUTING.md", "benches/tuning.md", "models/README.md"];
    for page in pages().into_iter().chain(others.map(|name| root.join(name))) {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            if link.contains("://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link}", page.display());
            assert!(heading.is_empty() || has_heading(&target, heading), "{}: {link}", page.display());
            followed += 1;
        }
    }
    assert!(followed >= 5, "{followed} links");
}

#[test]
fn footers_keep_their_phases() {
    let footer =
        "1 min 2 ms in all: parse 465 µs, build 0 ns\n1,135 nodes at most, 10.4 MiB of memory at most";
    assert_eq!(stable(footer), ["# # in all: parse #, build #", "1,135 nodes at most, # of memory at most"]);
}

#[test]
fn nodes_of_two_engines_are_compared_though_their_times_are_not() {
    let table = "          build   total   tables   nodes\n  symbolic  9 ms   86 ms  2.5 MiB  15,871\n  \
                 explicit  9 ms  627 µs    1 KiB       0\n";
    assert_eq!(stable(table), ["symbolic: 15,871 nodes", "explicit: 0 nodes"]);
}

#[test]
fn times_of_sweeps_are_left_out_and_nothing_else() {
    let table = "constants      states     seconds  peak_nodes      status\n\
                 N=2                17       0.003         495        done\n";
    let found =
        ["constants      states  peak_nodes      status", "N=2                17         495        done"];
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

/// Returns who runs a block, or the reason for which nobody does.
fn runner(page: &str, info: &str, body: &str) -> Result<&'static str, String> {
    let read =
        |name: &str| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap();
    let has_line = |start: &str| body.lines().any(|line| line.starts_with(start));
    let named_by = |file: &str| read(file).contains(page.trim_start_matches("./"));
    match info {
        _ if info.contains(" needs=") => Ok("needs other programs"),
        // Its commands need collections of models, other model checkers, and hours.
        "sh" if page == "docs/benchmarks.md" => Ok("needs other programs"),
        "sh" if has_line("meliora ") => Ok("the_shell_scripts_of_the_pages_run"),
        "sh" if page.ends_with("README.md") && named_by(".ci/run") => Ok(".ci/run"),
        "python" if named_by("python/tests/test_pages.py") => Ok("test_pages.py"),
        "text" if body.starts_with("$ meliora ") => Ok("the_pages_show_what_the_program_writes"),
        "sh" | "python" | "py" => Err("nothing runs it".to_owned()),
        _ if has_line("$ ") || has_line("meliora ") => Err(format!("commands in a block `{info}`")),
        _ => Ok("no commands"),
    }
}

/// The page on Python had two blocks, and that on sweeps one, that nothing ran and that did not say so.
#[test]
fn every_command_block_is_run_or_says_what_it_needs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut counts = std::collections::BTreeMap::new();
    for path in pages() {
        let text = std::fs::read_to_string(&path).unwrap();
        let page = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
        for (info, body) in fenced(&text) {
            let who = runner(&page, info, body).unwrap_or_else(|why| panic!("{page}: {why}\n{body}"));
            *counts.entry(who).or_insert(0) += 1;
            if who == "needs other programs" {
                println!("not run: {page}: {info}");
            }
        }
    }
    println!("{counts:?}");
    assert!(["the_pages_show_what_the_program_writes", ".ci/run"].iter().all(|who| counts[who] > 0));
}

/// The documentation had 57,000 words, and said many facts twice.
#[test]
fn the_pages_stay_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let words = |path: &Path| std::fs::read_to_string(path).unwrap().split_whitespace().count();
    let docs: usize =
        pages().iter().filter(|path| path.starts_with(root.join("docs"))).map(|path| words(path)).sum();
    let readme = words(&root.join("README.md"));
    assert!(docs <= 32_200 && readme <= 900, "{docs} words in docs, {readme} in the README");
}

#[test]
fn a_block_that_nothing_runs_is_noticed() {
    let page = "docs/limits.md";
    for (info, body) in
        [("sh", "ls"), ("python", "import meliora"), ("", "$ meliora check"), ("bash", "meliora check")]
    {
        assert!(runner(page, info, body).is_err(), "{info}: {body}");
    }
    assert!(runner(page, "sh needs=parallel", "parallel meliora").is_ok());
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
