//! Faults of commands whose partner is not ready: both engines report them.

use crate::common::prelude::*;

/// Builds both engines for a model whose second module has this command, while the command of the
/// first module is not enabled. Both report a fault that contains `expected`, or none.
fn check(command: &str, expected: Option<&str>) {
    let text = format!(
        "mdp module first ready : bool init false; [a] ready -> true; endmodule\n\
         module second low : bool init true; x : [0..2] init 0; [a] {command}; endmodule"
    );
    let program = Arc::new(parsed(text));
    let settings = Settings { scope: Scope::Reachable, memory: 16 << 20, ..Settings::default() };
    let explicit = ExplicitEngine::new(program.clone(), settings.clone()).err();
    let symbolic = SymbolicEngine::new(program, settings).err();
    for (engine, error) in [("explicit", explicit), ("symbolic", symbolic)] {
        match (error, expected) {
            (None, None) => {}
            (Some(Error::Input(found)), Some(expected)) => {
                assert!(found[0].message.contains(expected), "{engine}: {command}: {}", found[0].message);
            }
            (error, _) => panic!("{engine}: {command}: {error:?}"),
        }
    }
}

#[test]
fn a_guard_may_overflow_in_the_initial_state() {
    let overflow = Some("does not fit a 64-bit integer");
    // Each product of two bounds is once the only one that is too large.
    let product = |x: &str, y: &str| format!("({x}) * ({y}) > 0 -> true");
    let (least, most) = ("low ? -4000000000 : 1", "low ? 4000000000 : -1");
    for (x, y) in [(least, least), (least, most), (most, least), (most, most)] {
        check(&product(x, y), overflow);
    }
    check(&product("low ? -2 : 1", "low ? 2 : -1"), None);
    let sum = |high: &str| format!("(low ? {high} : 1) + (low ? {high} : 1) > 0 -> true");
    check(&sum("9000000000000000000"), overflow);
    check(&sum("-9000000000000000000"), overflow);
    check(&sum("2"), None);
}

#[test]
fn probabilities_that_depend_on_the_state_may_not_sum_to_1() {
    check("x<2 -> x/2:(x'=1) + 0.5: true", Some("give 0.5"));
    check("x<2 -> (1-x)/2:(x'=1) + 0.5: true", None);
    check("x<2 -> 0.25:(x'=1) + 0.5: true", Some("0.75"));
}
