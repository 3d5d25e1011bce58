//! The order of the variables that `auto` finds in the structure of a program.

use meliora::advanced::symbolic::{Bit, order};

use crate::common::prelude::*;

fn program(text: &str) -> Program {
    parsed(text)
}

/// The bits in the order of `auto`.
fn bits(text: &str) -> Vec<String> {
    let program = program(text);
    let name = |bit: &Bit| format!("{}.{}", program.variables[bit.variable.index()].name, bit.index);
    order::auto(&program).iter().map(name).collect()
}

/// The variables in the order of `auto`, by their most significant bits.
fn auto(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for bit in bits(text) {
        let name = bit.split('.').next().unwrap().to_owned();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn reason(text: &str) -> String {
    order::from_structure(&program(text)).why
}

#[test]
fn what_every_step_moves_stands_above_flags_and_places() {
    let text = "mdp module robot picked : bool; x : [0..9]; battery : [0..9] init 9;\n\
        [go] battery>0 & x<9 -> (x'=x+1) & (battery'=battery-1);\n\
        [wait] battery>0 -> (battery'=battery-1);\n\
        [pick] x=5 -> (picked'=true);\n\
        endmodule";
    assert_eq!(auto(text), ["battery", "picked", "x"]);
}

#[test]
fn what_is_assigned_stands_above_what_is_counted() {
    let text = "mdp module unit done : [0..9]; s : [0..2];\n\
        [take] s=0 & done<9 -> (s'=1);\n\
        [test] s=1 -> 1/2: (s'=0) + 1/2: (s'=2);\n\
        [work] s=2 -> (s'=0) & (done'=done+1);\n\
        endmodule";
    assert_eq!(auto(text), ["s", "done"]);
    assert_eq!(reason(text), "counters below the other variables");
}

/// A grid with other names than the generator's.
const MEADOW: &str = "mdp module cow wide : [0..7]; tall : [0..3]; mood : bool;\n\
    [a] wide<7 & !(wide=3 & tall=2) -> (wide'=wide+1);\n\
    [b] wide>0 -> (wide'=wide-1);\n\
    [c] tall<3 -> (tall'=tall+1) & (mood'=true);\n\
    [d] tall>0 -> (tall'=tall-1);\n\
    endmodule";

#[test]
fn places_tested_together_stand_side_by_side_bit_by_bit() {
    assert_eq!(bits(MEADOW), ["mood.0", "wide.2", "wide.1", "tall.1", "wide.0", "tall.0"]);
    assert_eq!(reason(MEADOW), "wide and tall bit by bit, since guards test them together");
}

#[test]
fn worlds_that_know_nothing_of_each_other_stand_one_after_the_other() {
    let text = format!(
        "{MEADOW} module horse = cow [wide=far, tall=high, mood=hunger, a=a2, b=b2, c=c2, d=d2] endmodule"
    );
    let mut both = bits(MEADOW);
    both.extend(["hunger.0", "far.2", "far.1", "high.1", "far.0", "high.0"].map(str::to_owned));
    assert_eq!(bits(&text), both);
}

#[test]
fn worlds_that_move_together_stay_as_declared() {
    let text = format!("{MEADOW} module horse = cow [wide=far, tall=high, mood=hunger] endmodule");
    assert_eq!(auto(&text), ["wide", "tall", "mood", "far", "high", "hunger"]);
    assert_eq!(reason(&text), "as declared");
}

/// A ring of flags, each of which copies the one before it; declared as listed.
fn flags(declared: &[usize]) -> String {
    let mut text = "mdp module network\n".to_owned();
    for v in declared {
        text += &format!("f{v} : bool;\n");
    }
    for v in declared {
        let before = v.checked_sub(1).unwrap_or(declared.len() - 1);
        text += &format!("[] f{v} != f{before} -> (f{v}'=f{before});\n");
    }
    text + "endmodule init true endinit\n"
}

#[test]
fn flags_of_the_same_commands_come_close_to_each_other() {
    let text = flags(&[0, 6, 3, 9, 1, 7, 4, 10, 2, 8, 5, 11]);
    let found = auto(&text);
    let place = |v: usize| found.iter().position(|name| *name == format!("f{v}")).unwrap();
    let span: usize = (0..12).map(|v| place(v).abs_diff(place((v + 11) % 12))).sum();
    // No order of a ring of n flags has a span below 2 (n - 1): two paths connect the ends.
    assert_eq!(span, 22);
    assert!(reason(&text).contains("add up to 22 places instead of 64"), "{}", reason(&text));
}

#[test]
fn flags_in_a_good_order_stay_as_declared() {
    let text = flags(&[0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(auto(&text), ["f0", "f1", "f2", "f3", "f4", "f5", "f6", "f7"]);
    assert_eq!(reason(&text), "as declared");
}

#[test]
fn networks_with_an_integer_keep_their_flags_as_declared() {
    let declared = [0, 6, 3, 9, 1, 7, 4, 10, 2, 8, 5, 11];
    let text = flags(&declared).replace("f0 : bool;", "n : [0..2]; f0 : bool;");
    let flags: Vec<String> = auto(&text).into_iter().filter(|name| name != "n").collect();
    assert_eq!(flags, declared.map(|v| format!("f{v}")));
}
