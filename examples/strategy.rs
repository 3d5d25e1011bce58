//! A program that acts by a strategy: it asks for the permitted actions of its state, takes one, and tells the strategy
//! which state came next.
//!
//! `cargo run --example strategy`

use std::path::Path;

use meliora::planning::explain::Successor;
use meliora::{Choose, Model, Options, Result, Settings, SourceFile, StrategyKind};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

fn main() -> Result<()> {
    let model = Model::open("models/robot5x5.prism", "")?;
    let wishes = SourceFile::open(Path::new("models/robot5x5.pref"))?;
    let mut analysis = model.explore(Settings::default())?.prefer(&wishes, Options::default())?;
    analysis.run(&mut |_| ())?;

    let mut strategy = analysis.strategy_of(StrategyKind::Plan, Choose::First, None)?;
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut state = model.state("")?;
    let mut memory = strategy.start(&state)?;
    for step in 0..40 {
        let at = strategy.explain(&state, memory)?;
        // Of the permitted actions, the strategy picks one that makes progress; none when nothing is left to do.
        let Some(action) = at.pick.map(|pick| &at.actions[pick]) else {
            println!("step {step}: achieved {:?}", analysis.preferences().names(&at.achieved));
            break;
        };
        let next = world(&action.successors, &mut random);
        let gained = if next.improves { ", which is an improvement" } else { "" };
        println!("step {step}: {}{gained}", action.name);
        (state, memory) = (next.state.clone(), next.next);
    }
    Ok(())
}

/// The world: it draws a successor by its probability.
fn world<'a>(successors: &'a [Successor], random: &mut ChaCha8Rng) -> &'a Successor {
    let mut left: f64 = random.random();
    let drawn = successors.iter().find(|next| {
        left -= next.probability;
        left < 0.0
    });
    drawn.unwrap_or(&successors[0])
}
