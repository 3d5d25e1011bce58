//! Runs the `// EXPECT:` lines of the model files under both engines and two variable orders.
//!
//! `models/README.md` describes the lines: `command option=value …: path=value …`.

use crate::common::prelude::*;

/// One expectation: a command, its options, and the values required in its JSON output.
#[derive(Debug)]
struct Expectation {
    line: usize,
    command: String,
    options: Vec<(String, String)>,
    facts: Vec<(String, String)>,
}

impl Expectation {
    fn option(&self, name: &str) -> Option<&str> {
        self.options.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
}

/// The engines and orders that every line is run under.
const CONFIGURATIONS: [(&str, &[&str]); 3] =
    [("symbolic", &["--order", "auto"]), ("symbolic", &["--order", "declared"]), ("explicit", &[])];

#[test]
fn every_expectation_beside_the_models_holds() {
    let mut failures = Vec::new();
    let mut checked = 0;
    for path in models() {
        for expectation in expectations(&std::fs::read_to_string(&path).unwrap()) {
            let fits = |(engine, _): &(&str, _)| expectation.option("engine").is_none_or(|e| e == *engine);
            let fitting = CONFIGURATIONS.into_iter().filter(fits).enumerate();
            // By default, engines and orders of bits take turns.
            for (_, (engine, order)) in fitting.filter(|(at, _)| takes_one_of(3, expectation.line + at)) {
                checked += expectation.facts.len();
                let mut extra = vec!["--engine", engine];
                extra.extend(order);
                failures.extend(failures_of(&path, &expectation, &extra));
            }
        }
    }
    assert!(failures.is_empty(), "{} of {checked} failed:\n{}", failures.len(), failures.join("\n"));
    assert!(checked > 0, "no expectation was found");
}

fn models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut models: Vec<PathBuf> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "prism" || e == "nm" || e == "pm")).collect();
    models.sort();
    models
}

/// Returns the expectations of a file. A comment line that is indented by four or more columns continues
/// the line before.
fn expectations(text: &str) -> Vec<Expectation> {
    let mut joined: Vec<(usize, String)> = Vec::new();
    let mut open = false;
    for (index, line) in text.lines().enumerate() {
        let comment = line.trim().strip_prefix("//").unwrap_or("");
        if let Some(rest) = comment.trim_start().strip_prefix("EXPECT:") {
            joined.push((index + 1, rest.trim().to_owned()));
            open = true;
        } else if open && comment.starts_with("    ") {
            let last = joined.last_mut().unwrap();
            last.1 = format!("{} {}", last.1, comment.trim());
        } else {
            open = false;
        }
    }
    joined.into_iter().map(|(line, text)| parse(line, &text)).collect()
}

fn parse(line: usize, text: &str) -> Expectation {
    let mut words = words(text).into_iter();
    let mut head = Vec::new();
    for word in words.by_ref() {
        match word.strip_suffix(':') {
            Some(last) => {
                head.push(last.to_owned());
                break;
            }
            None => head.push(word),
        }
    }
    let pair = |word: String| match word.split_once('=') {
        Some((name, value)) => (name.to_owned(), value.to_owned()),
        None => (word, String::new()),
    };
    let mut head = head.into_iter();
    let command = head.next().unwrap_or_default();
    Expectation { line, command, options: head.map(pair).collect(), facts: words.map(pair).collect() }
}

/// Words as a shell has them: separated by white space, which quotes keep together.
fn words(text: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    let mut begun = false;
    for c in text.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '"' | '\'') => (quote, begun) = (Some(c), true),
            (None, c) if c.is_whitespace() => {
                if begun {
                    words.push(std::mem::take(&mut word));
                }
                begun = false;
            }
            (_, c) => {
                word.push(c);
                begun = true;
            }
        }
    }
    if begun {
        words.push(word);
    }
    words
}

/// Returns a message for each fact of an expectation that does not hold.
fn failures_of(path: &Path, expectation: &Expectation, extra: &[&str]) -> Vec<String> {
    let finished = run(path, expectation, extra);
    let at = format!("{}:{} [{}]", path.display(), expectation.line, extra.join(" "));
    let Ok(report) = serde_json::from_str::<Json>(&finished.stdout) else {
        return vec![format!("{at}: no JSON: {finished:?}")];
    };
    let mut failures = Vec::new();
    for (key, value) in &expectation.facts {
        if key == "error" {
            let message = report["message"].as_str().unwrap_or_default();
            if finished.status != 3 || !message.contains(value.as_str()) {
                failures.push(format!("{at}: no error with `{value}`: {finished:?}"));
            }
            continue;
        }
        let found = look_up(&report, key).map_or_else(|| "missing".to_owned(), show);
        if !same(&found, value) {
            failures.push(format!("{at}: {key} is {found}, not {value} ({})", finished.stderr));
        }
    }
    failures
}

/// Lists of names are equal in any order; numbers are not.
fn same(found: &str, expected: &str) -> bool {
    let is_number = |word: &str| word.chars().all(|c| c.is_ascii_digit());
    let sorted = |text: &str| {
        let mut words: Vec<String> = text.split(',').map(str::to_owned).collect();
        if !words.iter().all(|w| is_number(w)) {
            words.sort();
        }
        words
    };
    sorted(found) == sorted(expected)
}

fn run(path: &Path, expectation: &Expectation, extra: &[&str]) -> Finished {
    let mut command = executable();
    command.arg(&expectation.command).arg(path).args(["--json", "-q"]).args(extra);
    let folder = path.parent().unwrap();
    let mut scratch = None;
    if let Some(name) = expectation.option("prefs") {
        let prefs = match expectation.option("empty") {
            None => folder.join(name),
            Some(empty) => {
                let text = with_empty(&std::fs::read_to_string(folder.join(name)).unwrap(), empty);
                let scratch = scratch.insert(Scratch::new(&[("changed.pref", &text)]));
                scratch.path("changed.pref")
            }
        };
        command.arg(prefs);
    }
    for (name, value) in &expectation.options {
        match name.as_str() {
            "prefs" | "empty" | "engine" => {}
            "const" | "scope" | "safety" | "target" | "property" | "max-level" => {
                command.arg(format!("--{name}")).arg(value);
            }
            other => panic!("{}: unknown option `{other}`", expectation.line),
        }
    }
    Finished::of(&mut command)
}

/// A preference file with another value of nothing (the `empty` statement).
fn with_empty(text: &str, empty: &str) -> String {
    let kept = text.lines().filter(|l| !l.trim_start().starts_with("empty"));
    format!("{}\nempty = {empty};\n", kept.collect::<Vec<_>>().join("\n"))
}

/// A step of a path is a key, an index, an objective's name, or a class's members joined by `+`.
fn look_up<'a>(value: &'a Json, path: &str) -> Option<&'a Json> {
    path.split('.').try_fold(value, |value, step| match value {
        Json::Array(list) => match step.parse::<usize>() {
            Ok(index) => list.get(index),
            Err(_) => list.iter().find(|entry| name(entry) == step),
        },
        _ => value.get(step),
    })
}

fn name(entry: &Json) -> String {
    match &entry["most_preferred"] {
        Json::Array(members) if members.is_empty() => "nothing".to_owned(),
        Json::Array(members) => members.iter().filter_map(Json::as_str).collect::<Vec<_>>().join("+"),
        _ => entry["name"].as_str().unwrap_or_default().to_owned(),
    }
}

/// A value as the lines write it: lists joined by commas, `-` for the empty list.
fn show(value: &Json) -> String {
    match value {
        Json::Array(list) if list.is_empty() => "-".to_owned(),
        Json::Array(list) => list.iter().map(show).collect::<Vec<_>>().join(","),
        Json::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[test]
fn quoted_words_and_continued_lines_are_read() {
    let text =
        "// EXPECT: reach target=\"x=1 | y=2\" scope=all: a.b=1\n//     c=2,3\n// no more\n//     d=4\n";
    let read = expectations(text);
    assert_eq!(read.len(), 1);
    assert_eq!(read[0].option("target"), Some("x=1 | y=2"));
    assert_eq!(read[0].facts, [("a.b".into(), "1".into()), ("c".into(), "2,3".into())]);
}
