//! The owning types for programs that embed the library.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use meliora::engine::Selection;
use meliora::output::page::{Picture, order_svg};
use meliora::output::{Report, Style};
use meliora::planning::Phase;
use meliora::projections::Plane;
use meliora::{Ask, Drawing, Event, Options, Properties, Reached};

use crate::common::prelude::*;

const TOY: &str = "mdp
    const int last;
    module toy
      s : [0..last] init 0;
      lost : bool init false;
      [a] s=0 -> 1/2: (s'=1) + 1/2: (s'=5);
      [b] s=0 -> 1/2: (s'=2) + 1/2: (s'=3);
      [c] s=0 -> 1/2: (s'=3) + 1/2: (s'=4);
      [a] s=5 -> (s'=1);
    endmodule
    label \"middle\" = s=2 | s=3;";

fn wishes() -> Arc<SourceFile> {
    let text = "objective First  = F (s=1 | s=5);
        objective Second = F (s=2 | s=4);
        objective Third  = F (s=3);
        prefer Second, Third > First;";
    SourceFile::new("toy.pref", text)
}

fn toy() -> Model {
    Model::parse(TOY, "last=5").unwrap()
}

fn stored(storage: Storage) -> Settings {
    Settings { storage, memory: 64 << 20, ..Settings::default() }
}

const BOTH: [Storage; 2] = [Storage::Symbolic, Storage::Explicit];

#[test]
fn targets_and_preferences_that_come_later_explore_nothing_again() {
    for storage in BOTH {
        let explored = toy().explore(stored(storage)).unwrap();
        assert_eq!(explored.engine().storage(), storage);
        let middle = explored.states_where("\"middle\"").unwrap();
        assert_eq!(middle.count().unwrap(), Count::from(2u32));
        let reached = explored.reach(&middle).unwrap();
        assert_eq!(reached.pmax_one.list(9).unwrap(), [[0, 0], [2, 0], [3, 0]]);
        assert!(middle.is_subset(&reached.pmin_one).unwrap());

        let mut one = explored.prefer(&wishes(), Options::default()).unwrap();
        let other = SourceFile::new("other.pref", "objective Fifth = F (s=5 & !lost);");
        let mut other = explored.prefer(&other, Options::default()).unwrap();
        one.run(&mut |_| ()).unwrap();
        other.run(&mut |_| ()).unwrap();
        assert!(one.engine().shares(explored.engine()) && other.engine().shares(explored.engine()));
        let start = explored.initial().list(1).unwrap().concat();
        assert_eq!(one.rank(Kind::Sasi, &start).unwrap(), Rank::Finite(1));
        assert_eq!(other.rank(Kind::Spi, &start).unwrap(), Rank::Finite(1));
        assert_eq!(one.level_states(Kind::Sasi)[0], one.region("sasi:1").unwrap());
        assert_eq!(one.region_names().iter().filter(|name| name.starts_with("target:")).count(), 3);
        // Regions of one exploration go together, whatever they come of.
        let fifth = other.region("target:Fifth").unwrap();
        assert!(fifth.is_subset(&one.region("target:First").unwrap()).unwrap());
    }
}

#[test]
fn a_strategy_outlives_what_it_was_made_of() {
    for storage in BOTH {
        let model = toy();
        let start = model.state("s=0").unwrap();
        let mut strategy = {
            let mut analysis =
                model.explore(stored(storage)).unwrap().prefer(&wishes(), Options::default()).unwrap();
            assert!(matches!(analysis.strategy(Kind::Sasi), Err(Error::Usage(_))));
            analysis.run(&mut |_| ()).unwrap();
            analysis.strategy(Kind::Sasi).unwrap()
        };
        assert_eq!(strategy.permitted(&start).unwrap(), ["b", "c"]);
        let setup = Setup { scheduler: Scheduler::Permissive, runs: 20, steps: 50, seed: 1 };
        let tally = Simulation::new(&mut strategy, setup).run(&start).unwrap();
        assert_eq!((tally.runs, tally.fewer_than(1)), (20, 0));
    }
}

#[test]
fn sets_know_where_they_are_from() {
    for storage in BOTH {
        let model = toy();
        let (one, other) = (model.explore(stored(storage)).unwrap(), model.explore(stored(storage)).unwrap());
        assert!(matches!(one.states().union(&other.states()), Err(Error::ForeignSet)));
        assert!(matches!(one.reach(&other.initial()), Err(Error::ForeignSet)));
        assert_ne!(one.initial(), other.initial());
        assert_eq!(one.initial(), one.states_where("s = 0").unwrap());
        assert_eq!(one.initial().complement().unwrap().complement().unwrap(), one.initial());
        assert_eq!(one.initial().to_string(), "{s=0,lost=false}");
        let shown = "{s=0,lost=false; s=1,lost=false; s=2,lost=false; … and 3 more}";
        assert_eq!(one.states().to_string(), shown);
        assert!(one.states().contains(&[5, 0]).unwrap() && !one.states().contains(&[5, 1]).unwrap());
        assert!(!one.states().contains(&[5]).unwrap() && one.singleton(&[5]).is_err());
        assert_eq!(one.singleton(&[5, 1]).unwrap().count().unwrap(), Count::ZERO);
    }
}

#[test]
fn a_condition_of_another_program_is_refused() {
    let explored = toy().explore(Settings::default()).unwrap();
    let other = Model::parse(TOY, "last=5").unwrap();
    for of in [other.program(), explored.program()] {
        let source = SourceFile::new("condition", "s = 2");
        let condition = lang::lower_target(of, &source, &lang::parse_expression(&source).unwrap()).unwrap();
        for condition in [condition, of.predicate(of.initial)] {
            let found = explored.engine().states_where(&condition);
            assert_eq!(matches!(found, Err(Error::Usage(_))), !Arc::ptr_eq(of, explored.program()));
        }
    }
}

#[test]
fn errors_have_their_places() {
    let explored = toy().explore(Settings::default()).unwrap();
    let place = |error: Error| match error {
        Error::Input(wrong) => wrong[0].position(),
        other => panic!("{other}"),
    };
    assert_eq!(place(Model::parse("mdp\nmodule", "").unwrap_err()), (2, 7));
    assert_eq!(place(Model::parse(TOY, "first=5").unwrap_err()), (1, 1));
    assert_eq!(place(explored.states_where("s = t").unwrap_err()), (1, 5));
    assert!(matches!(Model::open("no/such/file.prism", ""), Err(Error::Io { .. })));
}

#[test]
fn states_are_values_by_name() {
    let model = toy();
    let state = model.state("s=3,lost=true").unwrap();
    let values: Vec<String> = model.values(&state).map(|(name, value)| format!("{name}:{value}")).collect();
    assert_eq!(values, ["s:3", "lost:true"]);
}

#[test]
fn an_analysis_has_reports_and_pictures() {
    for storage in BOTH {
        let explored = toy().explore(stored(storage)).unwrap();
        let mut analysis = explored.prefer(&wishes(), Options::default()).unwrap();
        analysis.run(&mut |_| ()).unwrap();
        let prefix = Options { safety: Safety::Prefix, max_level: None };
        let other = analysis.with_options(prefix);
        assert_eq!((other.options(), other.result().counts.is_none()), (prefix, true));
        let report = analysis.report("toy.pref").unwrap();
        let header = &report.header;
        assert_eq!((header.preferences.as_deref(), header.engine), (Some("toy.pref"), Some(storage.name())));
        assert_eq!(report.initial[0].sasi.as_ref().map(|plan| plan.rank), Some(Rank::Finite(1)));
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(
            (json["schema"].as_str(), json["empty"].as_str()),
            (Some("meliora.check/1"), Some("bottom"))
        );
        assert!(report.text(Style { color: false, width: None }).contains("one improvement over "));
        assert!(analysis.draw("toy.pref", Drawing::Svg(Picture::Hasse), None).unwrap().starts_with("<svg"));
        assert!(analysis.draw("toy.pref", Drawing::Dot, None).unwrap().starts_with("digraph"));
        let map = analysis.draw("toy.pref", Drawing::Svg(Picture::Sasi), Some("s"));
        match storage {
            Storage::Symbolic => assert!(map.unwrap().contains("</svg>")),
            Storage::Explicit => assert!(matches!(map, Err(Error::Usage(_)))),
        }
        let wrong = analysis.draw("toy.pref", Drawing::Html, Some("nowhere"));
        assert!(matches!(wrong, Err(Error::Input(_))));
    }
}

#[test]
fn members_are_listed_and_drawn() {
    for storage in BOTH {
        for scope in [Scope::Reachable, Scope::All] {
            let explored = toy().explore(Settings { scope, ..stored(storage) }).unwrap();
            let states = explored.states_where("s != 2").unwrap();
            let all: Vec<State> = states.listing().unwrap().map(Result::unwrap).collect();
            assert_eq!(all, states.list(usize::MAX).unwrap());
            assert!(states.is_small());
            for size in 0..=all.len() {
                let mut drawn = states.sample(size, 3).unwrap();
                assert_eq!(drawn, states.sample(size, 3).unwrap());
                drawn.sort();
                drawn.dedup();
                assert_eq!((drawn.len(), drawn.iter().all(|s| all.contains(s))), (size, true));
            }
            assert!(matches!(states.sample(all.len() + 1, 3), Err(Error::Usage(_))));
            let none = explored.states_where("false").unwrap();
            assert_eq!((none.sample(0, 0).unwrap().len(), none.listing().unwrap().count()), (0, 0));
        }
    }
}

#[test]
fn every_member_is_drawn_about_as_often() {
    for storage in BOTH {
        let explored = toy().explore(stored(storage)).unwrap();
        let (mut times, states) = ([0; 6], explored.states());
        (0..600).for_each(|seed| times[states.sample(1, seed).unwrap()[0][0] as usize] += 1);
        assert!(times.iter().all(|n| (60..140).contains(n)), "{times:?}");
    }
}

#[test]
fn sets_lie_over_planes() {
    let text = "mdp module m
        r : [-1..1] init 0; c : [2..5] init 2; b : [0..2] init 0; on : bool init false;
        [] true -> (r'=r); endmodule";
    let model = Model::parse(text, "").unwrap();
    let [r, c, b] = ["r", "c", "b"].map(|name| model.program().variable(name).unwrap());
    for storage in BOTH {
        let explored = model.explore(Settings { scope: Scope::All, ..stored(storage) }).unwrap();
        let states = explored.states_where("r + c = 3 & on | b = 2 & r = 1 & c = 5").unwrap();
        let plane = Plane { row: Some(r), column: c };
        let marks = |fixed: &[_]| {
            let projection = states.projection(plane, fixed).unwrap();
            assert_eq!((projection.rows, projection.columns), (3, 4));
            let row = |cells: &[bool]| cells.iter().map(|&c| if c { '#' } else { '.' }).collect::<String>();
            projection.cells.chunks(4).map(row).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(marks(&[]), "..#. .#.. #..#");
        assert_eq!(marks(&[(b, 1)]), "..#. .#.. #...");
        assert_eq!(marks(&[(b, 7)]), ".... .... ....");
        let column = states.projection(Plane { row: None, column: r }, &[(c, 5)]).unwrap();
        assert_eq!((column.rows, column.cells), (1, vec![false, false, true]));
        let slice = explored.slice(&[(b, 2), (c, 5)]).unwrap();
        assert_eq!(slice, explored.states_where("b = 2 & c = 5").unwrap());
        assert_eq!(
            states.slice(&[(b, 2)]).unwrap(),
            states.intersection(&explored.slice(&[(b, 2)]).unwrap()).unwrap()
        );
        let (one, other) = (explored.states_where("r = 0").unwrap(), explored.states_where("c = 2").unwrap());
        let apart = explored.states_where("(r = 0) != (c = 2)").unwrap();
        assert_eq!(one.symmetric_difference(&other).unwrap(), apart);
    }
}

#[test]
fn planes_that_are_too_large_are_refused() {
    let text = "mdp module m x : [0..100000]; y : [0..100000]; [] true -> true; endmodule";
    let model = Model::parse(text, "").unwrap();
    let plane = Plane { row: model.program().variable("x"), column: model.program().variable("y").unwrap() };
    let explored = model.explore(Settings::default()).unwrap();
    assert!(matches!(explored.states().projection(plane, &[]), Err(Error::Limit(Limit::Size { .. }))));
}

#[test]
fn every_play_can_be_seen() {
    let mut analysis =
        toy().explore(Settings::default()).unwrap().prefer(&wishes(), Options::default()).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    let first = analysis.region("sasi:1").unwrap();
    assert!(first.is_subset(&analysis.exploration().states()).unwrap());
    let mut strategy = analysis.strategy(Kind::Sasi).unwrap();
    let memory = |state: [i64; 2]| analysis.strategy(Kind::Sasi).unwrap().start(&state).unwrap();
    assert!(!strategy.knows(memory([0, 0])) && strategy.knows(memory([3, 0])));
    assert_eq!(strategy.permitted(&[0, 0]).unwrap(), ["b", "c"]);
    assert!(strategy.knows(memory([0, 0])));
    assert!(strategy.is_state(&[5, 0]).unwrap() && !strategy.is_state(&[5, 1]).unwrap());
    let setup = Setup { scheduler: Scheduler::Permissive, runs: 20, steps: 50, seed: 1 };
    let mut seen = Vec::new();
    let tally =
        Simulation::new(&mut strategy, setup).run_each(&[0, 0], &mut |run| seen.push(run.clone())).unwrap();
    assert_eq!(tally, Simulation::new(&mut strategy, setup).run(&[0, 0]).unwrap());
    assert_eq!((seen.len(), seen[0].run, &seen[0]), (20, 1, &tally.trace));
    assert!(seen.iter().all(|run| run.turns.iter().filter(|turn| turn.improves).count() == 1));
}

#[test]
fn preferences_say_much_without_a_model() {
    let outline = lang::outline_preferences(&wishes()).unwrap();
    assert_eq!(outline.objectives[0], ("First".to_owned(), "F (s=1 | s=5)".to_owned()));
    assert!(outline.order.strictly(2, 0) && !outline.order.strictly(2, 1));
    assert!(order_svg(&outline).starts_with("<svg"));
    for (text, line) in [
        ("objective A = F x=1;\nprefer A > B;", 2),
        ("objective A = F x=1;\nobjective A = F x=2;", 2),
        ("objective A = F x=1;\nobjective B = F x=1;\nprefer A > B;\nprefer B > A;", 3),
        ("empty = gain;", 1),
    ] {
        match lang::outline_preferences(&SourceFile::new("p", text)) {
            Err(Error::Input(wrong)) => assert_eq!(wrong[0].position().0, line, "{text}"),
            other => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn properties_about_numbers_have_values() {
    let text = "mdp module m x : [0..3] init 0; [a] x=0 -> 1/2: (x'=1) + 1/2: (x'=2); [b] x=0 -> (x'=2);\n\
         [on] x=1 -> (x'=3); [stay] x>1 -> true; endmodule rewards \"cost\" [a] true : 2; [b] true : 7; endrewards";
    for storage in BOTH {
        let explored = Model::parse(text, "").unwrap().explore(stored(storage)).unwrap();
        let ask = |question: &str| {
            let found = explored.reach_where(question).unwrap();
            (found.holds, found.value.map(|value| (value.lower, value.upper)))
        };
        assert_eq!(ask("Pmax=? [ F x=1 ]"), (None, Some((0.5, 0.5))));
        assert_eq!(ask("Pmin=? [ F x=1 ]"), (None, Some((0.0, 0.0))));
        assert_eq!(ask("P>=0.25 [ F x=1 ]"), (Some(false), Some((0.0, 0.0))));
        assert_eq!(ask("P<=0.5 [ F x=1 ]"), (Some(true), Some((0.5, 0.5))));
        assert_eq!(ask("R{\"cost\"}min=? [ F x>1 ]"), (None, Some((2.0, 2.0))));
        assert_eq!(ask("R{\"cost\"}max=? [ F x=2 | x=3 ]"), (None, Some((7.0, 7.0))));
        assert_eq!(ask("R{\"cost\"}max=? [ F x=3 ]"), (None, Some((f64::INFINITY, f64::INFINITY))));
        // A temporal formula has monitors.
        assert_eq!(ask("Pmax=? [ (G (x!=1 | X x=2)) & (F x=2) ]"), (None, Some((1.0, 1.0))));
        assert_eq!(ask("Pmax>=1 [ F x=2 ]"), (Some(true), None));
        assert_eq!(ask("x=1"), (None, None));
        let wide = explored.reach_within("Pmax=? [ F x=1 ]", 0.5).unwrap().value.unwrap();
        assert!(wide.lower <= 0.5 && 0.5 <= wide.upper);
        assert!(matches!(explored.reach_where("R{\"tolls\"}min=? [ F x=1 ]"), Err(Error::Input(_))));
        assert!(matches!(explored.reach_where("P=? [ F x=1 ]"), Err(Error::Input(_))));
    }
}

#[test]
fn a_report_says_that_objectives_judge_whole_paths() {
    let report = |text: &str| {
        let preferences = SourceFile::new("w.pref", text);
        let explored = toy().explore(Settings::default()).unwrap();
        let analysis = explored.prefer(&preferences, Options::default()).unwrap();
        serde_json::to_value(analysis.report("w.pref").unwrap()).unwrap()
    };
    assert_eq!(report("objective A = G s<4;")["history"], "play");
    assert_eq!(report("objective A = F s=4;").get("history"), None);
}

#[test]
fn preferences_that_prefer_nothing_have_a_warning() {
    let warnings = |text: &str| {
        let explored = toy().explore(Settings::default()).unwrap();
        let analysis = explored.prefer(&SourceFile::new("w.pref", text), Options::default()).unwrap();
        let outline = lang::outline_preferences(&SourceFile::new("w.pref", text)).unwrap();
        assert_eq!(outline.warnings(), analysis.preferences().warnings());
        outline.warnings()
    };
    let [warning] = &warnings("objective A = F s=4; objective B = F s=3;")[..] else { panic!("one warning") };
    assert!(warning.starts_with("prefers no objective to another: only gaining"), "{warning}");
    assert_eq!(warnings("objective A = F s=4; objective B = F s=3; prefer A > B;"), [""; 0]);
}

#[test]
fn the_first_of_several_ways_answers_a_whole_question() {
    let expected = toy().explore(Settings::default()).unwrap().reach_where("P>=1 [ F s=3 ]").unwrap();
    let of = |found: &Reached| found.regions.clone().map(|states| states.list(9).unwrap());
    for threads in [1, 3] {
        let settings = Settings { threads, memory: 64 << 20, ..Settings::default() };
        let found = toy().ask_by_any(settings.clone(), &|explored| explored.reach_where("P>=1 [ F s=3 ]"));
        assert_eq!(of(&found.unwrap()), of(&expected));
        let stopping = toy().reach_stopping_by_any("P>=1 [ F s=3 ]", settings.clone()).unwrap();
        assert_eq!(stopping.holds, expected.holds);
        let wrong = toy().ask_by_any(settings, &|explored| explored.reach_where("P>=1 [ F q=3 ]"));
        assert!(matches!(wrong, Err(Error::Input(_))));
    }
}

#[test]
fn a_whole_analysis_by_any_way_is_that_of_one() {
    let mut expected =
        toy().explore(Settings::default()).unwrap().prefer(&wishes(), Options::default()).unwrap();
    expected.run(&mut |_| ()).unwrap();
    for threads in [1, 3] {
        let settings = Settings { threads, memory: 64 << 20, ..Settings::default() };
        let phases = Mutex::new(Vec::new());
        let listen = |event: Event<'_>| {
            if let Event::Finished(phase, _) = event {
                phases.lock().unwrap().push(phase);
            }
        };
        let (found, limit) = toy().check_by_any(&wishes(), Options::default(), settings, &listen).unwrap();
        assert!(limit.is_none());
        assert_eq!(format!("{:?}", found.result()), format!("{:?}", expected.result()));
        assert_eq!(phases.into_inner().unwrap(), Phase::ALL);
    }
}

/// A sink that ends the work while it is true, and counts how often a way would end the others.
#[derive(Default)]
struct Switch(AtomicBool, AtomicUsize);

impl ProgressSink for Switch {
    fn stop(&self) -> Option<Limit> {
        self.0.load(Relaxed).then_some(Limit::Interrupted)
    }

    fn settle(&self) -> Option<u64> {
        self.1.fetch_add(1, Relaxed);
        None
    }
}

#[test]
fn an_analysis_by_any_way_that_a_limit_ends_can_be_continued() {
    // Each phase asks the sink, since there are 10,000 states.
    let text = "mdp module m x : [0..9999]; [] x<9999 -> 0.5: (x'=x+1) + 0.5: true; [] x<9999 -> (x'=x+1); endmodule";
    let model = Model::parse(text, "").unwrap();
    let wishes =
        SourceFile::new("w.pref", "objective Far = F x=9999; objective Near = F x=9; prefer Far > Near;");
    for threads in [1, 3] {
        let sink = Arc::new(Switch::default());
        let settings =
            Settings { threads, memory: 64 << 20, sink: Arc::clone(&sink) as _, ..Settings::default() };
        let listen = |event: Event<'_>| {
            if let Event::Finished(Phase::Counts, _) = event {
                sink.0.store(true, Relaxed);
            }
        };
        let found = model.check_by_any(&wishes, Options::default(), settings, &listen);
        let (mut analysis, limit) = found.unwrap();
        assert!(matches!(limit, Some(Limit::Interrupted)));
        assert!(analysis.is_done(Phase::Counts) && !analysis.is_done(Phase::Spi));
        sink.0.store(false, Relaxed);
        analysis.run(&mut |_| ()).unwrap();
        assert!(analysis.is_done(Phase::Spi));
    }
}

#[test]
fn the_last_numbers_end_the_other_ways() {
    let model = "mdp module m x : [0..2]; [] x=0 -> 0.5:(x'=1) + 0.5:(x'=2); endmodule";
    let [number, other, sum] = ["Pmax=? [ F x=1 ]", "Pmax=? [ F x=2 ]", "Pmax=? [ F x=1 ] + 1"];
    let filter = ["filter(print, Pmax=? [ F x=1 ])"];
    for (texts, settled) in [(&[number][..], 1), (&[number, other], 2), (&[number, sum], 1), (&filter, 1)] {
        let sink = Arc::new(Switch::default());
        let settings = Settings { sink: Arc::clone(&sink) as _, ..Settings::default() };
        let ask = Ask { engine: Selection { is_open: false, ..Selection::open() }, ..Ask::default() };
        Model::parse(model, "").unwrap().ask(Properties::Texts(texts), &ask, settings).unwrap();
        assert_eq!(sink.1.load(Relaxed), settled, "{texts:?}");
    }
}
