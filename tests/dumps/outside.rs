//! Names of any characters, in every format that is written: no target is broken, and names that are
//! read back are the same.

use meliora::advanced::escape::{dot, first_word, is_shown, line, lines, quoted, unword, word};
use meliora::advanced::{csv, json};
use meliora::dump::dddmp;
use meliora::output::Style;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::dumps::exchange::{index, none, two_states, words};

/// Characters with a meaning in some target.
const SPECIAL: &str = " \t\n\r\u{b}\u{1b}\u{7f}\u{85}\u{9b}\u{a0}\u{202e}\u{2028}\u{2066}\u{3000}\u{feff}\u{fdd0}\
    \u{fdd1}\u{e0041}'\"`\\%[](){}<>=+-@,;:|/&#.015eEé_xaN";

fn name() -> impl Strategy<Value = String> {
    let special = prop::sample::select(SPECIAL.chars().collect::<Vec<_>>());
    let character = prop_oneof![4 => special, 1 => any::<char>()];
    prop::collection::vec(character, 1..12).prop_map(|characters| characters.into_iter().collect())
}

/// The action of the only choice of a model.
fn action_of(text: &str) -> Option<String> {
    let model = Document::new(SourceFile::new("m", text)).load(&none(), &NoProgress).unwrap();
    assert_eq!(model.program.commands.len(), 1, "{text:?}");
    model.program.actions.first().cloned()
}

/// A string of DOT without its quotes and escapes; `None` if it ends before.
fn undotted(string: &str) -> Option<String> {
    let (mut out, mut inside) = (String::new(), string.strip_prefix('"')?.strip_suffix('"')?.chars());
    while let Some(c) = inside.next() {
        match c {
            '"' => return None,
            '\\' => out.push(match inside.next()? {
                'n' => '\n',
                c => c,
            }),
            c => out.push(c),
        }
    }
    Some(out)
}

proptest! {
    #![proptest_config(meliora_amount::random(2000))]

    #[test]
    fn words_are_read_back(name in name()) {
        let word = word(&name);
        prop_assert!(!word.is_empty() && word.chars().all(|c| is_shown(c) && !c.is_whitespace()), "{word:?}");
        prop_assert_eq!(unword(&word), name.as_str());
    }

    #[test]
    fn actions_of_explicit_formats_are_read_back(name in name()) {
        let (word, shown) = (word(&name), Some(line(&name).into_owned()));
        let drn = format!("@type: MDP\n@reward_models\nr\n@model\nstate 0 [1] init\n\taction {word} [0.5]\n\t\t0 : 1\n");
        prop_assert_eq!(action_of(&drn), shown.clone());
        prop_assert_eq!(action_of(&format!("1 1 1\n0 0 0 1 {word}\n")), shown);
    }

    /// Labels and reward models became letters, digits and `_`.
    #[test]
    fn labels_and_rewards_of_explicit_formats_are_read_back(name in name()) {
        let shown = line(&name).into_owned();
        let (word, label) = (first_word(&name), quoted(&shown));
        let drn = format!("@type: MDP\n@reward_models\n{word}\n@model\nstate 0 [1] init {label}\n\taction a [0.5]\n\t\t0 : 1\n");
        let model = Document::new(SourceFile::new("m", drn)).load(&none(), &NoProgress).unwrap().program;
        prop_assert_eq!(model.rewards[0].name.as_ref(), Some(&shown));
        prop_assert_eq!(&model.labels[0].0, &shown);
        let lab = SourceFile::new("m.lab", format!("0=\"init\" 1={label}\n0: 0 1\n"));
        let tra = Document::new(SourceFile::new("m", "1 1 1\n0 0 0 1 a\n")).with_beside([None, Some(lab)]);
        prop_assert_eq!(&tra.load(&none(), &NoProgress).unwrap().program.labels[0].0, &shown);
    }

    #[test]
    fn actions_of_archives_are_displayed(name in name()) {
        let index = index("", "").replace("choice-actions\": 0", "choice-actions\": 1");
        let mapping = words(&[0, name.len() as u64]);
        let folder = "actions/choices";
        let [mapping_path, strings] = ["string-mapping.bin", "strings.bin"].map(|file| format!("{folder}/{file}"));
        let model = two_states(&index, &[(&mapping_path, &mapping), (&strings, name.as_bytes())]).unwrap();
        prop_assert_eq!(&model.program.actions, &[line(&name).into_owned()]);
        prop_assert_eq!(model.warnings.len(), usize::from(!name.chars().all(is_shown)));
    }

    #[test]
    fn names_of_diagrams_are_read_back(first in name(), second in name()) {
        let variables = vec![first.clone(), format!("{first}{second}")];
        let mut diagram = Diagram { variables, ..Diagram::default() };
        let root = diagram.push(1, Edge::TRUE, Edge::FALSE).unwrap();
        diagram.roots.push(root);
        let mut text = Vec::new();
        dddmp::write(&diagram, &mut text).unwrap();
        prop_assert_eq!(dddmp::read("d", &text[..]).unwrap(), diagram);
    }

    #[test]
    fn cells_are_read_back_and_not_run(name in name()) {
        let written = csv::lines([[name.as_str(), "x"]]);
        let mut reader = ::csv::ReaderBuilder::new().has_headers(false).from_reader(written.as_bytes());
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        prop_assert_eq!((rows.len(), rows[0].len()), (1, 2));
        let cell = &rows[0][0];
        prop_assert_eq!(csv::text(cell), line(&name));
        let number = |c: char| c.is_ascii_digit() || "+-./eEinf".contains(c);
        prop_assert!(!cell.starts_with(['=', '+', '-', '@']) || cell.chars().all(number), "{cell:?}");
        prop_assert!(cell.chars().all(is_shown));
    }

    #[test]
    fn json_is_read_back_and_displayed(name in name()) {
        for text in [json::pretty(&[&name]).unwrap(), json::compact(&[&name]).unwrap()] {
            prop_assert!(text.chars().all(|c| c == '\n' || is_shown(c)), "{text:?}");
            prop_assert_eq!(serde_json::from_str::<[String; 1]>(&text).unwrap(), [name.clone()]);
        }
    }

    #[test]
    fn strings_of_dot_end_where_they_should(name in name()) {
        prop_assert_eq!(undotted(&dot(&name)), Some(lines(&name).into_owned()));
    }

    #[test]
    fn nothing_but_colours_reaches_a_terminal(name in name(), color: bool) {
        let style = Style { color, width: None };
        let text = style.finished(&(style.bad("error") + &name));
        let colours = ["1;31", "0", "1", "2", "32", "1;33"].map(|code| format!("\u{1b}[{code}m"));
        let plain = colours.iter().fold(text, |text, colour| text.replace(colour, ""));
        prop_assert!(plain.chars().all(|c| c == '\n' || is_shown(c)), "{plain:?}");
        prop_assert!(color || plain.ends_with(&*lines(&name)));
    }
}
