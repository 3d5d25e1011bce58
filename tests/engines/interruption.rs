//! Cancellation reaches the inner loops: after it, the progress sink is asked only a few more times.

use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::prelude::*;

/// Stops the work at a question.
struct StopAt {
    question: usize,
    asked: AtomicUsize,
}

impl StopAt {
    fn new(question: usize) -> Arc<Self> {
        Arc::new(StopAt { question, asked: AtomicUsize::new(0) })
    }

    fn asked(&self) -> usize {
        self.asked.load(Ordering::Relaxed)
    }
}

impl ProgressSink for StopAt {
    fn stop(&self) -> Option<Limit> {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed) + 1;
        (asked >= self.question).then_some(Limit::Interrupted)
    }
}

/// One module with many commands, all of them enabled everywhere.
fn many(commands: usize) -> Arc<SourceFile> {
    let mut text = format!("mdp module m x:[0..{commands}];\n");
    for i in 0..commands {
        let _ = writeln!(text, "[] x<{commands}+1 -> (x'={i});");
    }
    SourceFile::new("many", text + "endmodule")
}

fn none() -> Arc<SourceFile> {
    SourceFile::new("constants", "")
}

#[test]
fn reading_a_model_can_be_interrupted_anywhere() {
    let source = many(20_000);
    let counting = StopAt::new(usize::MAX);
    lang::load_with_progress(&source, &none(), &*counting).unwrap();
    let all = counting.asked();
    // Tokens, their parser, and the checks: each asks at least once in two thousand steps.
    assert!(all > 300, "{all} questions");
    for question in [1, 2, all / 8, all / 4, all / 2, all * 3 / 4, all] {
        let sink = StopAt::new(question);
        let stopped = lang::load_with_progress(&source, &none(), &*sink);
        assert!(matches!(stopped, Err(Error::Limit(Limit::Interrupted))), "{question} of {all}");
        assert_eq!(sink.asked(), question, "asked again after the answer");
    }
}

#[test]
fn a_wrong_model_whose_reading_is_interrupted_is_not_called_wrong() {
    let source = SourceFile::new("wrong", many(2_000).text.replace("x'", "y'"));
    assert!(matches!(lang::load(&source, &none()), Err(Error::Input(_))));
    let stopped = lang::load_with_progress(&source, &none(), &*StopAt::new(20));
    assert!(matches!(stopped, Err(Error::Limit(Limit::Interrupted))));
}

/// The engine is not built once a sink says so.
#[track_caller]
fn building_stops(build: impl Fn(Arc<StopAt>) -> Option<Error>) {
    let counting = StopAt::new(usize::MAX);
    assert!(build(counting.clone()).is_none());
    let all = counting.asked();
    assert!(all > 20, "{all} questions");
    for question in [1, 2, all / 4, all / 2] {
        let sink = StopAt::new(question);
        let stopped = build(sink.clone());
        assert!(matches!(stopped, Some(Error::Limit(Limit::Interrupted))), "{question} of {all}");
        assert_eq!(sink.asked(), question, "asked again after the answer");
    }
}

#[test]
fn building_an_engine_for_many_commands_can_be_interrupted_anywhere() {
    let program = Arc::new(lang::load(&many(2_000), &none()).unwrap().program);
    let settings = |sink: Arc<StopAt>| Settings { memory: 64 << 20, sink, ..Settings::default() };
    building_stops(|sink| ExplicitEngine::new(program.clone(), settings(sink)).err());
    building_stops(|sink| SymbolicEngine::new(program.clone(), settings(sink)).err());
}

#[test]
fn the_explicit_engine_asks_while_it_compiles_commands() {
    let program = Arc::new(lang::load(&many(5_000), &none()).unwrap().program);
    let counting = StopAt::new(usize::MAX);
    let settings = Settings { memory: 1, sink: counting.clone(), ..Settings::default() };
    // The memory limit does not allow a single state: all questions come from the preparation.
    assert!(ExplicitEngine::new(program.clone(), settings).is_err());
    assert!(counting.asked() >= 10, "{} questions", counting.asked());
}
