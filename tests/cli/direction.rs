//! `reach` with a property about the initial states: all valuations may answer before the states are known.

use serde_json::{Value as Json, json};

use crate::common::{Finished, Scratch, meliora};

/// A register that takes 2^30 - 1 steps to return to its first state, and can be left at any time.
pub(crate) const REGISTER: &str = "mdp\nmodule m\n done : bool; b : [0..1073741823] init 1;\n\
    [] !done -> (b'=mod(2*b, 1073741824) + (mod(floor(b/536870912) + floor(b/64), 2) = 1 ? 1 : 0));\n\
    [] !done -> (done'=true);\nendmodule\n";

fn asked(property: &str, more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", REGISTER)]);
    Finished::of(meliora().args(["reach", &scratch.show("m.prism"), "--property", property]).args(more))
}

#[test]
fn a_property_is_decided_before_the_states_are_known() {
    let cases = [
        ("Pmax>=1 [ F done ]", true, json!({"pmax_one": "all"})),
        ("E [ F done ]", true, json!({"pmax_positive": "all"})),
        ("P>0 [ F done ]", false, json!({"pmin_positive": "none"})),
        ("Pmax>=1 [ G !done ]", true, Json::Null),
    ];
    for (property, holds, initial) in cases {
        let found = asked(property, &["--json"]).expect(i32::from(!holds)).json();
        assert_eq!(found["holds"], holds, "{property}: {found}");
        assert_eq!(found["properties"][0]["holds"], holds);
        assert_eq!((&found["over_all_valuations"], &found["counts"]), (&json!(true), &Json::Null));
        assert_eq!((&found["pmax_one"], &found["engine"]), (&Json::Null, &json!("symbolic")));
        let shares = initial.as_object().into_iter().flatten();
        shares.for_each(|(region, share)| assert_eq!(found["initial"][region], *share, "{property}"));
    }
}

#[test]
fn the_text_says_that_the_states_are_not_counted() {
    let text = asked("Pmax>=1 [ F done ]", &[]).expect(0).stdout;
    assert!(text.contains("The property was decided over all combinations of values"), "{text}");
    assert!(text.contains("The property holds in all initial states."), "{text}");
}

#[test]
fn states_that_are_soon_known_are_counted() {
    let small = REGISTER.replace("b'=", "b'=0*");
    let scratch = Scratch::new(&[("m.prism", &small)]);
    let given = ["reach", &scratch.show("m.prism"), "--property", "Pmax>=1 [ F done ]", "--json"];
    let found = Finished::of(meliora().args(given)).expect(0).json();
    assert_eq!((&found["counts"]["states"], &found["pmax_one"]), (&json!("4"), &json!("4")));
    assert!(found.get("over_all_valuations").is_none());
}
