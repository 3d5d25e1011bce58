//! The order of the variables that `auto` finds in the structure of a program.

use meliora::engine::symbolic::order;
use meliora::error::SourceFile;
use meliora::lang;

/// The variables in the order of `auto`, by their most significant bits.
fn auto(text: &str) -> Vec<String> {
    let none = SourceFile::new("constants", "");
    let program = lang::load(&SourceFile::new("m", text), &none).unwrap().program;
    let mut names: Vec<String> = Vec::new();
    for bit in order::auto(&program) {
        let name = &program.variables[bit.variable.index()].name;
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// A bus and stations with a mode, a clock and a counter, all of which know the action `time`.
fn stations(count: usize, tick: &str) -> String {
    let mut text = format!(
        "mdp module bus b : [0..2]; y : [0..9]; [time] y<9 -> (y'=y+1); [hit] b<2 -> (b'=b+1); endmodule\n\
         module station1 s1 : [0..3]; x1 : [0..9]; k1 : [0..3];\n\
         [{tick}] x1<9 -> (x1'=x1+1); [hit] k1<3 -> (k1'=k1+1) & (s1'=1); [time] s1=2 -> (s1'=0);\n\
         endmodule\n"
    );
    for i in 2..=count {
        text += &format!("module station{i} = station1 [s1=s{i}, x1=x{i}, k1=k{i}, own1=own{i}] endmodule\n");
    }
    text
}

#[test]
fn clocks_of_copies_stand_side_by_side() {
    assert_eq!(auto(&stations(3, "time")), "s1 s2 s3 b y x1 x2 x3 k1 k2 k3".split(' ').collect::<Vec<_>>());
}

#[test]
fn two_copies_stay_as_declared() {
    assert_eq!(auto(&stations(2, "time")), "b y s1 x1 k1 s2 x2 k2".split(' ').collect::<Vec<_>>());
}

#[test]
fn counters_that_advance_one_by_one_are_no_clocks() {
    let text = stations(3, "own1").replace("(k1'=k1+1) & (s1'=1)", "(k1'=0)");
    assert_eq!(auto(&text), "b y s1 x1 k1 s2 x2 k2 s3 x3 k3".split(' ').collect::<Vec<_>>());
}

#[test]
fn modules_of_different_ranges_are_no_copies() {
    let module = |i: usize| {
        format!("module m{i} s{i} : [0..{i}]; x{i} : [0..9]; [time] x{i}<9 -> (x{i}'=x{i}+1); endmodule ")
    };
    let text = format!("mdp {}{}{}", module(1), module(2), module(3));
    assert_eq!(auto(&text), "s1 x1 s2 x2 s3 x3".split(' ').collect::<Vec<_>>());
}

#[test]
fn the_flags_of_one_module_stand_above_and_its_counters_below() {
    let text = "mdp module robot battery : [0..9] init 9; x : [0..9]; picked : bool;\n\
        [go] battery>0 & x<9 -> (x'=x+1) & (battery'=battery-1);\n\
        [pick] x=5 -> (picked'=true);\n\
        endmodule";
    assert_eq!(auto(text), ["picked", "x", "battery"]);
}
