//! One question for several values of a constant, as a table with commas.
//!
//! `cargo run --example sweep`

use meliora::{Model, Result, Settings};

const DIE: &str = "mdp
    const int N;
    module die
      throws : [0..N] init 0;
      face : [0..6] init 0;
      [throw] face=0 & throws<N -> 1/6: (face'=6) & (throws'=throws+1) + 5/6: (throws'=throws+1);
    endmodule";

fn main() -> Result<()> {
    println!("N,states,lower,upper");
    for n in 1..=6 {
        let explored = Model::parse(DIE, &format!("N={n}"))?.explore(Settings::default())?;
        let answer = explored.reach_where("Pmax=? [ F face=6 ]")?;
        if let Some(value) = answer.value {
            println!("{n},{},{},{}", explored.states().count()?, value.lower, value.upper);
        }
    }
    Ok(())
}
