//! States of many bits on a small stack: the engine brings what its recursions need.

use std::sync::Arc;

use meliora::engine::SymbolicEngine;
use meliora::engine::{Algebra, Engine, Settings};
use meliora::error::SourceFile;
use meliora::lang;

/// A row of lamps, each of which may light once the one before it is lit.
fn lamps(count: usize) -> String {
    let mut text = "mdp module row\n".to_owned();
    for i in 0..count {
        text += &format!("a{i} : bool;\n");
    }
    text += "[] !a0 -> (a0'=true);\n";
    for i in 1..count {
        text += &format!("[] a{} & !a{i} -> (a{i}'=true);\n", i - 1);
    }
    text + "endmodule"
}

#[test]
fn hundreds_of_bits_need_no_large_stack_of_the_caller() {
    let work = || {
        let none = SourceFile::new("constants", "");
        let program = Arc::new(lang::load(&SourceFile::new("lamps", lamps(500)), &none).unwrap().program);
        let settings = Settings { memory: 64 << 20, ..Settings::default() };
        let engine = SymbolicEngine::new(program.clone(), settings).unwrap();
        let all = engine.all_states();
        assert_eq!(engine.count(&all).unwrap(), 501u32.into());
        let last = engine.deadlock_states();
        assert_eq!(engine.count(&last).unwrap(), 1u32.into());
        let found = engine.almost_surely_reach(&last, &engine.all_choices()).unwrap();
        assert!(engine.same(&found.states, &all).unwrap());
    };
    std::thread::Builder::new().stack_size(128 << 10).spawn(work).unwrap().join().unwrap();
}
