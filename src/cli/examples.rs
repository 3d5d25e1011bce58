//! Examples at the end of each command's `--help`: two command lines on the models that come with
//! the program.

use clap::Command;

/// The examples by command.
const EXAMPLES: &[(&str, [&str; 2])] = &[
    (
        "check",
        [
            "meliora check models/robot5x5.prism models/robot5x5.pref",
            "meliora check models/network.prism models/network.pref -c K=5,M=2 --safety prefix --json",
        ],
    ),
    (
        "reach",
        [
            "meliora reach models/robot5x5.prism --target 'r=4 & c=4 & e'",
            "meliora reach models/robot5x5.prism --property 'P>0 [ F b=0 ]'",
        ],
    ),
    ("info", ["meliora info models/robot5x5.prism", "meliora info models/ring.prism -c N=8 --flat"]),
    (
        "strategy",
        [
            "meliora strategy models/robot5x5.prism models/robot5x5.pref --rank 1 --limit 20 --csv states.csv",
            "meliora strategy models/drone.prism models/drone.pref --choose likely",
        ],
    ),
    (
        "simulate",
        [
            "meliora simulate models/robot5x5.prism models/robot5x5.pref",
            "meliora simulate models/robot5x5.prism models/robot5x5.pref --kind spi --scheduler permissive --seed 7",
        ],
    ),
    (
        "values",
        [
            "meliora values models/drone.prism models/drone.pref",
            "meliora values models/robot5x5.prism models/robot5x5.pref --all --levels 2 --csv values.csv",
        ],
    ),
    (
        "report",
        [
            "meliora report models/robot5x5.prism models/robot5x5.pref --out robot.html",
            "meliora report models/fleet.prism models/fleet.pref -c L=3 --grid p1,p2 --out fleet.html",
        ],
    ),
    (
        "export",
        [
            "meliora export models/toy.prism models/toy.pref --out toy.dump",
            "meliora export models/toy.prism models/toy.pref --region 'sasi:*' --format dot --out toy.dump",
        ],
    ),
    (
        "query",
        [
            "meliora query toy.dump 'sasi:1 & !sasi:2' --list 10",
            "meliora query toy.dump reachable --where 's > 1' --count",
        ],
    ),
    (
        "verify",
        [
            "meliora verify toy.dump models/toy.prism models/toy.pref",
            "meliora verify toy.dump models/toy.prism models/toy.pref --json",
        ],
    ),
    (
        "compare",
        [
            "meliora compare models/robot5x5.prism models/robot5x5.pref --scope all",
            "meliora compare models/network.prism models/network.pref -c K=20,M=5",
        ],
    ),
    (
        "generate",
        [
            "meliora generate gridworld --rows 12 --cols 12 --items 6 --seed 7 --out garden",
            "meliora generate gridworld --from-map models/robot5x5.map --out robot",
        ],
    ),
    ("completions", ["meliora completions bash > meliora.bash", "meliora completions zsh > _meliora"]),
    ("man", ["meliora man > meliora.1", "meliora man check > meliora-check.1"]),
];

/// Adds the examples to the command line.
pub(super) fn with_examples(command: Command) -> Command {
    let show = |[first, second]: &[&str; 2]| format!("Examples:\n  {first}\n  {second}");
    EXAMPLES.iter().fold(command, |command, (name, examples)| {
        command.mut_subcommand(*name, |sub| sub.after_help(show(examples)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Splits a command line as a shell does.
    fn words(line: &str) -> Vec<String> {
        let parts = line.split('\'').enumerate();
        let split = |(index, part): (usize, &str)| match index % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect::<Vec<_>>(),
            _ => vec![part.to_owned()],
        };
        parts.flat_map(split).take_while(|word| word != ">").collect()
    }

    #[test]
    fn every_command_has_two_examples_that_it_takes() {
        let command = crate::cli::parser();
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let examples = EXAMPLES.iter().find(|(name, _)| *name == sub.get_name());
            for line in examples.unwrap_or_else(|| panic!("{} has none", sub.get_name())).1 {
                if line.starts_with("meliora") {
                    let parsed = command.clone().try_get_matches_from(words(line));
                    assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
                }
            }
        }
    }
}
