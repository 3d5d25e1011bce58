//! The table of options in `docs/commands.md`, from the help of the commands.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Arg;

use super::parser;

/// The name and the help of an option, and the commands that have it.
type Row = ((String, String), Vec<String>);

/// Returns how an option is written: `-c`, `--const NAME=VALUE,…`.
fn written(option: &Arg) -> String {
    let long = option.get_long().map(|long| format!("`--{long}`")).unwrap_or_default();
    let short = option.get_short().map(|short| format!("`-{short}`, ")).unwrap_or_default();
    let takes = option.get_action().takes_values();
    let values = option.get_value_names().filter(|_| takes).unwrap_or_default();
    let values: String = values.iter().map(|value| format!(" {value}")).collect();
    format!("{short}{}", long.replacen("` ", "`", 1)).trim_end_matches(", ").to_owned() + &values
}

/// Commands without options that others have, of which the page says so once.
const APART: [&str; 3] = ["generate", "completions", "man"];

/// Returns all options with their commands; those with another help have a row of their own.
fn rows() -> Vec<Row> {
    let mut rows: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    let mut program = parser();
    program.build();
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        for option in command.get_arguments().filter(|a| is_shown(a)) {
            let help = option.get_help().map(|help| help.to_string().replace('\n', " ")).unwrap_or_default();
            let commands = rows.entry((written(option), brief(&help).replace('|', "\\|"))).or_default();
            commands.push(command.get_name().to_owned());
        }
    }
    rows.into_iter().collect()
}

/// Returns the first part of a help text: without its default, and without what follows a semicolon, if this
/// does not separate values such as `html: the page; svg: one picture`.
fn brief(help: &str) -> String {
    let text = help.split(" [default").next().unwrap_or(help).replace(" (repeatable)", "");
    match text.split_once("; ") {
        Some((first, _)) if !first.contains(": ") => first.trim_end_matches(" (repeatable").to_owned(),
        _ => text,
    }
}

/// Returns true for options other than those that all programs have.
fn is_shown(option: &Arg) -> bool {
    let is_of_clap = ["help", "version"].contains(&option.get_id().as_str());
    !option.is_positional() && !option.is_hide_set() && !is_of_clap
}

/// Returns the commands of an option in few words.
fn among(commands: &[String], all: &[String]) -> String {
    let list =
        |names: Vec<&String>| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match Vec::from_iter(all.iter().filter(|name| !commands.contains(name))) {
        others if others.is_empty() => "all".to_owned(),
        others if others.len() < commands.len() => format!("all but {}", list(others)),
        _ => list(commands.iter().collect()),
    }
}

fn table() -> String {
    let all = Vec::from_iter(parser().get_subcommands().map(|command| command.get_name().to_owned()));
    let all = Vec::from_iter(all.into_iter().filter(|name| !APART.contains(&name.as_str())));
    let mut table = String::from("| option | commands | meaning |\n| --- | --- | --- |\n");
    for ((option, help), commands) in rows() {
        table += &format!("| {} | {} | {help} |\n", option.replace('|', "\\|"), among(&commands, &all));
    }
    table
}

#[test]
fn the_page_has_the_options_of_all_commands() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (head, _) = page.split_once("\n## Options\n").unwrap();
    let text = format!("{head}\n## Options\n\n{}", table());
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(&path, &text).unwrap();
    }
    let same = std::fs::read_to_string(&path).unwrap() == text;
    assert!(
        same,
        "docs/commands.md is out of date; `INSTA_UPDATE=always cargo test -p meliora commands_page` writes it"
    );
    for command in parser().get_subcommands() {
        assert!(head.contains(&format!("`meliora {}", command.get_name())), "{}", command.get_name());
    }
}
