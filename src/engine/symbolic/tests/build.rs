//! Tests of the states that are known before their engine.

use std::sync::Arc;

use crate::engine::{Algebra, Engine};
use crate::settings::Settings;
use crate::symbolic::{Explored, Thresholds};
use meliora_base::error::SourceFile;
use meliora_lang as lang;

/// Modules side by side, as many as are given, that draw a new value in every step.
fn drawing(modules: usize) -> Explored {
    let module = |i: usize| {
        format!(
            "module m{i} x{i} : [0..9]; [] true -> 0.5: (x{i}'=0) + 0.5: (x{i}'=min(x{i}+1, 9)); endmodule "
        )
    };
    let text = format!("mdp {}", (0..modules).map(module).collect::<String>());
    let source = SourceFile::new("m", text);
    let program = Arc::new(lang::load(&source, &SourceFile::new("constants", "")).unwrap().program);
    let thresholds = Thresholds { cache: 1 << 10, ..Thresholds::default() };
    let settings = Settings { thresholds, ..Settings::default() };
    Explored::new(program, settings).unwrap()
}

#[test]
fn only_an_engine_has_a_large_operation_cache() {
    let explored = drawing(5);
    let before = explored.draft.store.usage().bytes;
    let engine = explored.engine().unwrap();
    assert!(engine.usage().bytes > 2 * before, "{before}");
    assert_eq!(engine.count(&engine.all_states()).unwrap(), 100_000u32.into());
}
