//! One engine used by several threads.

use meliora::engine::regions;

use crate::common::prelude::*;

/// A random walk with a store that it fills and empties, and some targets.
fn walk() -> (Arc<Program>, Vec<Predicate>) {
    let text = "mdp module m x : [0..31]; y : [0..31]; z : [0..31]; f : bool;\n\
        [] x<31 -> 0.5: (x'=x+1) + 0.5: (y'=mod(x+y,32));\n\
        [] y>0 & z<31 -> 0.5: (y'=y-1) & (z'=z+1) + 0.5: (x'=max(x-3,0));\n\
        [] z>x -> 0.5: (z'=z-1) & (f'=!f) + 0.5: true;\n\
        [] f & mod(x+z,3)=1 -> (x'=z) & (z'=y);\n\
        endmodule";
    let program = parsed(text);
    let targets = ["x=31 & f", "y=z & x>y", "mod(x*y,7)=3 & z>20", "x=0 & z=31"].map(|text| {
        let source = SourceFile::new("target", text);
        let tree = lang::parse_expression(&source).unwrap();
        lang::lower_target(&program, &source, &tree).unwrap()
    });
    (Arc::new(program), targets.into())
}

/// Settings with which garbage is collected every 2,000 nodes.
fn settings() -> Settings {
    let thresholds = Thresholds { first_collection: 2_000, ..Thresholds::default() };
    Settings { memory: 64 << 20, thresholds, ..Settings::default() }
}

/// The sizes of the four regions of a target.
fn counts(engine: &SymbolicEngine, target: &Predicate) -> [String; 4] {
    let found = regions::regions(engine, &engine.states_where(target).unwrap()).unwrap();
    [found.pmax_one, found.pmax_positive, found.pmin_one, found.pmin_positive]
        .map(|x| engine.count(&x).unwrap().to_string())
}

fn all_counts(engine: &SymbolicEngine, targets: &[Predicate]) -> Vec<[String; 4]> {
    targets.iter().map(|target| counts(engine, target)).collect()
}

#[test]
fn two_threads_that_share_an_engine_find_what_one_finds() {
    let (program, targets) = walk();
    let engine = || SymbolicEngine::new(program.clone(), settings()).unwrap();
    let expected = all_counts(&engine(), &targets);
    assert!(expected.iter().flatten().any(|count| count != "0"), "{expected:?}");
    let shared = engine();
    let found = std::thread::scope(|scope| {
        let run = || all_counts(&shared, &targets);
        [scope.spawn(run), scope.spawn(run)].map(|thread| thread.join().unwrap())
    });
    assert_eq!(found, [expected.clone(), expected]);
}
