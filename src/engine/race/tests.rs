//! Races of ways that count to a number.

use std::time::Instant;

use super::*;
use meliora_base::progress::{CancellationToken, NoProgress};

/// The numbers of ways that run at once.
const THREADS: [usize; 4] = [1, 2, 3, 8];

fn rules(threads: usize) -> Rules {
    Rules { threads, alone: 4, turn: 8, lead: 2, memory: 7 }
}

/// Three ways, of which the last one is the least likely.
const SHARES: [Share; 3] =
    [Share { weight: 2, late: 0 }, Share { weight: 2, late: 0 }, Share { weight: 1, late: 0 }];

/// Takes some steps.
fn work(lane: &Lane, steps: u64) -> Result<()> {
    for _ in 0..steps {
        if let Some(limit) = lane.stop() {
            return Err(limit.into());
        }
        lane.advance(1);
    }
    Ok(())
}

/// Lets three ways race.
fn run<T: Send>(threads: usize, run: Run<'_, T>) -> Result<T> {
    race(rules(threads), &SHARES, &NoProgress, &|_| Arc::new(NoProgress), run)
}

#[test]
fn each_way_is_the_first_to_end_once() {
    for threads in THREADS {
        for first in 0..3 {
            let found = run(threads, &|lane| {
                let steps = if lane.way == first { 100 } else { u64::MAX };
                work(lane, steps).map(|()| Some(lane.way))
            });
            assert_eq!(found.unwrap(), first, "{threads}");
        }
    }
}

/// Another way began in its place, and allocated its tables.
#[test]
fn no_way_begins_after_the_first_has_ended() {
    for threads in THREADS {
        for _ in 0..20 {
            let begun = Mutex::new(Vec::new());
            let found = run(threads, &|lane| {
                lock(&begun).push(lane.way);
                work(lane, 2).map(|()| Some(lane.way))
            });
            assert_eq!(found.unwrap(), 0);
            assert_eq!(*lock(&begun), [0], "{threads}");
        }
    }
}

#[test]
fn with_one_thread_every_run_takes_the_same_turns() {
    let turns = || {
        let turns = Mutex::new(Vec::new());
        let found = run(1, &|lane| {
            for step in 0..[1000, 300, 400][lane.way] {
                lock(&turns).push(lane.way);
                work(lane, 1)?;
                if step == 100 {
                    lane.knows_all_states(None);
                }
            }
            Ok(Some(lane.way))
        });
        (found.unwrap(), lock(&turns).clone())
    };
    let first = turns();
    assert!((0..3).all(|way| first.1.contains(&way)));
    assert_eq!(turns(), first);
}

/// Every order allocated its tables after the first turns, and most questions end soon after these.
#[test]
fn a_late_way_begins_after_the_others_have_had_their_steps() {
    let mut shares = SHARES;
    shares[2].late = 30;
    let spent = Mutex::new([0; 3]);
    let found = race(rules(1), &shares, &NoProgress, &|_| Arc::new(NoProgress), &|lane| {
        if lane.way == 2 {
            return Ok(Some(*lock(&spent)));
        }
        for _ in 0..1000 {
            work(lane, 1)?;
            lock(&spent)[lane.way] += 1;
        }
        Ok(None)
    });
    let [first, second, _] = found.unwrap();
    assert!((60..80).contains(&first) && (60..80).contains(&second), "{first}, {second}");
}

#[test]
fn a_way_without_an_answer_leaves_the_others() {
    for threads in THREADS {
        for without in 0..3 {
            let found = run(threads, &|lane| {
                work(lane, if lane.way == without { 20 } else { 100 })?;
                Ok((lane.way != without).then_some(lane.way))
            });
            assert_ne!(found.unwrap(), without);
        }
    }
}

#[test]
fn a_way_that_is_out_of_memory_leaves_the_others_and_the_last_begins_again() {
    let full = |way: usize| -> Error { Limit::Memory { what: way.to_string() }.into() };
    for threads in THREADS {
        for fits in 0..3 {
            let found = run(threads, &|lane| {
                work(lane, 50)?;
                if lane.way == fits { Ok(Some(lane.way)) } else { Err(full(lane.way)) }
            });
            assert_eq!(found.unwrap(), fits);
            // None fits its share; the last one to leave fits all.
            let found = run(threads, &|lane| {
                if lane.is_last {
                    return Ok(Some(lane.way));
                }
                work(lane, if lane.way == fits { 500 } else { 50 })?;
                Err(full(lane.way))
            });
            assert!(threads > 1 || found.as_ref().is_ok_and(|&way| way == fits));
            assert!(found.is_ok());
        }
        let found: Result<()> = run(threads, &|lane| Err(full(lane.way)));
        assert!(matches!(found, Err(Error::Limit(Limit::Memory { .. }))));
    }
}

#[test]
fn a_way_that_panics_ends_all() {
    for threads in THREADS {
        for panics in 0..3 {
            let raced = || -> Result<()> {
                run(threads, &|lane| {
                    work(lane, if lane.way == panics { 60 } else { u64::MAX })?;
                    std::panic::panic_any(lane.way)
                })
            };
            let panic = catch_unwind(raced).unwrap_err();
            assert_eq!(panic.downcast_ref(), Some(&panics));
        }
    }
}

#[test]
fn an_error_of_the_first_to_end_is_the_answer() {
    for first in 0..3 {
        let found: Result<()> = run(1, &|lane| {
            work(lane, if lane.way == first { 60 } else { 600 })?;
            Err(Error::Usage(lane.way.to_string()))
        });
        assert!(matches!(found, Err(Error::Usage(way)) if way == first.to_string()));
    }
}

#[test]
fn the_first_to_know_all_states_leads() {
    for first in 0..3 {
        let places = Mutex::new([None; 3]);
        let found = run(1, &|lane| {
            for step in 0..400 {
                work(lane, 1)?;
                if step == if lane.way == first { 40 } else { 100 } {
                    lock(&places)[lane.way] = Some(lane.knows_all_states(None));
                }
            }
            Ok(Some(lane.way))
        });
        let places = *lock(&places);
        assert!(places[found.unwrap()].is_some());
        assert!(matches!(places[first], Some(Place::First)), "{places:?}");
        assert!(places.iter().filter(|place| **place == Some(Place::First)).count() == 1);
    }
}

/// Diagrams that knew all states had 128 times their exploration alone, though lists would have answered in a small part
/// of that.
#[test]
fn the_first_way_follows_a_leader_that_has_taken_the_steps_in_which_it_is_likely_to_end() {
    for (likely, first) in [(None, 2), (Some(60), 0)] {
        for threads in THREADS {
            let rules = Rules { lead: 20, ..rules(threads) };
            let sinks = |_| Arc::new(NoProgress) as _;
            let found = race(rules, &SHARES, &NoProgress, &sinks, &|lane| {
                if lane.way == 2 {
                    work(lane, 10)?;
                    lane.knows_all_states(likely);
                }
                work(lane, [60, u64::MAX, 180][lane.way])?;
                Ok(Some(lane.way))
            });
            assert!(threads > 1 || found.as_ref().is_ok_and(|&way| way == first), "{likely:?}: {found:?}");
            assert!(found.is_ok());
        }
    }
}

#[test]
fn a_limit_of_the_whole_work_ends_all_ways_soon() {
    for threads in THREADS {
        let sink = Arc::new(CancellationToken::default());
        let ended = Mutex::new(None);
        let found: Result<()> = race(rules(threads), &SHARES, &*sink, &|_| Arc::clone(&sink) as _, &|lane| {
            work(lane, 200)?;
            lock(&ended).get_or_insert_with(Instant::now);
            sink.cancel();
            work(lane, u64::MAX).map(|()| None)
        });
        assert!(matches!(found, Err(Error::Limit(Limit::Interrupted))));
        let took = lock(&ended).unwrap().elapsed();
        assert!(took < Duration::from_millis(200), "{took:?}");
    }
}

/// A second leader began the report of the first one anew, after that one had ended with the answer.
#[test]
fn no_other_way_leads_once_the_leader_has_the_answer() {
    let ended = |has_answer| {
        let way = |phase| Way { phase, has_answer, weight: 1, spent: 4, missed: 0 };
        let ways = vec![way(Phase::Ended), Way { has_answer: false, ..way(Phase::Runs) }];
        State { rules: rules(2), ways, leader: Some((0, 8)), likely: None }
    };
    assert_eq!(ended(true).lead(1, None), None);
    assert!(ended(false).lead(1, None).is_some());
}

#[test]
fn a_way_that_settles_the_race_goes_on_alone_with_all_memory() {
    for threads in THREADS {
        for end in [Ok(7), Err(Limit::Memory { what: "full".to_owned() })] {
            let begun = Mutex::new(Vec::new());
            let found = run(threads, &|lane| {
                lock(&begun).push(lane.way);
                let steps = if lane.way == 1 { 30 } else { u64::MAX };
                work(lane, steps)?;
                assert_eq!([lane.settle(), lane.settle()], [Some(7); 2]);
                let before = lock(&begun).len();
                work(lane, 1000)?;
                assert_eq!(lock(&begun).len(), before, "{threads}");
                end.clone().map(Some).map_err(Error::from)
            });
            // Nobody begins again.
            assert_eq!(lock(&begun).iter().filter(|&&way| way == 1).count(), 1);
            match end {
                Ok(answer) => assert_eq!(found.unwrap(), answer),
                Err(limit) => assert_eq!(found.unwrap_err().to_string(), Error::from(limit).to_string()),
            }
        }
    }
}

/// A way that is late is told to end, and has no memory to give.
#[test]
fn one_way_settles_a_race() {
    for threads in THREADS {
        let settled = Mutex::new(Vec::new());
        let found = run(threads, &|lane| {
            work(lane, 20)?;
            lock(&settled).extend(lane.settle().map(|_| lane.way));
            work(lane, 100).map(|()| Some(lane.way))
        });
        assert_eq!(*lock(&settled), [found.unwrap()], "{threads}");
    }
}
