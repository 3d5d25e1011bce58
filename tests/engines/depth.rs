//! States of many bits on a small stack: the engine brings what its recursions need.

use meliora::model::value::Value;

use crate::common::prelude::*;

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
        let engine = SymbolicEngine::new(program(lamps(500)), settings()).unwrap();
        let all = engine.all_states();
        assert_eq!(engine.count(&all).unwrap(), 501u32.into());
        let last = engine.deadlock_states();
        assert_eq!(engine.count(&last).unwrap(), 1u32.into());
        let found = engine.almost_surely_reach(&last, &engine.all_choices()).unwrap();
        assert!(engine.same(&found.states, &all).unwrap());
    };
    on_a_stack_of(128 << 10, work);
}

/// A counter whose guard, update and probability each nest thousands of operators.
fn nested() -> String {
    let conditions: String = (0..4_900).map(|i| format!("x={} ? {} : (", i % 3, i % 3)).collect();
    let chain = format!("{conditions}3{}", ")".repeat(4_900));
    let sum = format!("{}x{}", "(x+".repeat(9_000), ")".repeat(9_000));
    let share = format!("{}x/4{}", "(0*x+".repeat(4_900), ")".repeat(4_900));
    format!(
        "mdp module m x : [0..3]; [a] {sum}<27000 -> {share} : (x'={chain}) + 1-{share} : (x'=x+1); endmodule"
    )
}

#[test]
fn expressions_of_thousands_of_operators_need_no_large_stack_of_the_caller() {
    fn reached<E: Engine>(engine: &E, program: &Program) {
        assert_eq!(engine.count(&engine.all_states()).unwrap(), 4u32.into());
        let guard = program.commands[0].guard;
        assert_eq!(program.pool.eval(guard, &[2]).unwrap(), Value::Bool(true));
        let share = program.commands[0].branches[0].probability;
        assert_eq!(program.pool.eval_exact(share, &[2]).unwrap().to_string(), "1/2");
    }
    on_a_stack_of(512 << 10, || {
        let program = program(nested());
        reached(&ExplicitEngine::new(program.clone(), settings()).unwrap(), &program);
        reached(&SymbolicEngine::new(program.clone(), settings()).unwrap(), &program);
    });
}

fn program(text: String) -> Arc<Program> {
    Arc::new(parsed(text))
}

fn settings() -> Settings {
    Settings { memory: 64 << 20, ..Settings::default() }
}

fn on_a_stack_of(bytes: usize, work: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(bytes).spawn(work).unwrap().join().unwrap();
}
