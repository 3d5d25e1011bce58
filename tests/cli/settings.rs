//! The answer does not depend on the order of the variables, the threads, the memory (and with it
//! the operation cache and the collection of garbage), the engine or the run.

use serde_json::{Map, Value};

use crate::cli::models::{MODELS, given};
use crate::common::prelude::*;

/// The settings that every model is asked under; FILE is an order that nobody would choose.
const SETTINGS: &[&str] = &[
    "--engine auto",
    "--engine symbolic",
    "--engine symbolic",
    "--order declared",
    "--order FILE",
    "--engine symbolic --threads 2",
    "--engine symbolic --memory 3MiB",
    "--order FILE --threads 2 --memory 4MiB",
    "--order FILE --threads 2 --memory 24MiB",
    "--engine explicit",
    "--engine explicit --memory 64MiB --threads 2",
];

/// Parts of a report that are about the work and not about the answer.
const ABOUT_THE_WORK: &[&str] = &["time", "memory", "engine", "engine_reason", "order", "nodes"];

/// Returns the report of a command without the fields about the work, such as times and memory.
fn answer(command: &str, options: &[&str]) -> Map<String, Value> {
    let mut run = executable();
    run.args(command.split(' ')).args(options).args(["--json", "--quiet"]);
    let Value::Object(mut report) = Finished::of(&mut run).expect(0).json() else { panic!("no object") };
    ABOUT_THE_WORK.iter().for_each(|key| {
        report.remove(*key);
    });
    report
}

/// All bits from the least significant ones of all variables up to the most significant ones.
fn scattered(model: &str, constants: &str) -> String {
    let mut run = executable();
    run.args(["info", model, "--json", "--quiet"]).args(constants.split_whitespace());
    let info = Finished::of(&mut run).expect(0).json();
    let mut bits: Vec<String> =
        info["order"].as_array().unwrap().iter().map(|b| b.as_str().unwrap().to_owned()).collect();
    bits.reverse();
    bits.sort_by_key(|b| b.rsplit_once('.').map_or(0, |(_, k)| k.parse().unwrap_or(0)));
    bits.join(" ")
}

fn same_under_all_settings(name: &str, constants: &str) {
    let (model, preferences) = (format!("models/{name}.prism"), format!("models/{name}.pref"));
    let scratch = Scratch::new(&[("order", &scattered(&model, constants))]);
    let order = scratch.show("order");
    let commands = [
        format!("check {model} {preferences}"),
        format!("check {model} {preferences} --scope all --safety transition"),
        format!("check {model} {preferences} --safety prefix"),
        format!("simulate {model} {preferences} --kind spi --runs 20 --steps 30"),
        format!("strategy {model} {preferences}"),
    ];
    for (number, command) in commands.iter().enumerate() {
        let mut expected = None;
        // By default, every command has two settings after the first, and all commands of a model have all of them.
        for (at, settings) in SETTINGS.iter().enumerate() {
            if at > 0 && !takes(at + number) {
                continue;
            }
            let settings = settings.replace("FILE", &order);
            let options: Vec<&str> = constants.split_whitespace().chain(settings.split(' ')).collect();
            let found = answer(command, &options);
            match &expected {
                None => expected = Some(found),
                Some(expected) => assert_eq!(&found, expected, "{command} {settings}"),
            }
        }
    }
}

macro_rules! models {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                let constants = MODELS.iter().find(|(name, _)| *name == stringify!($name)).unwrap().1;
                same_under_all_settings(stringify!($name), &given(constants));
            }
        )*

        #[test]
        fn every_model_has_a_test() {
            assert_eq!([$(stringify!($name)),*], MODELS.map(|(name, _)| name));
        }
    };
}

models! {
    chain counter courier drone fleet hospital lake lateral lateral_prefix line network patrol pond rescue ring robot5x5 scramble
    toy
}
