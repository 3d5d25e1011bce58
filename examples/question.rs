//! Questions about paths: the states from which a target is reached, a bound, and a number.
//!
//! `cargo run --example question`

use meliora::{Model, Result, Settings};

const DIE: &str = "mdp
    module die
      throws : [0..3] init 0;
      face : [0..6] init 0;
      [throw] face=0 & throws<3 -> 1/6: (face'=6) & (throws'=throws+1) + 5/6: (throws'=throws+1);
      [stop] face=0 & throws>0 -> (face'=1);
    endmodule
    label \"six\" = face=6;";

fn main() -> Result<()> {
    let explored = Model::parse(DIE, "")?.explore(Settings::default())?;

    let target = explored.states_where("\"six\"")?;
    let regions = explored.reach(&target)?;
    println!(
        "six is possible in {} of {} states",
        regions.pmax_positive.count()?,
        explored.states().count()?
    );

    for question in ["P>0.4 [ F \"six\" ]", "Pmax>=1 [ F \"six\" ]", "Pmax=? [ F \"six\" ]"] {
        let answer = explored.reach_where(question)?;
        match (answer.holds, answer.value) {
            (Some(holds), _) => println!("{question}: {holds}"),
            (None, Some(value)) => println!("{question}: between {} and {}", value.lower, value.upper),
            (None, None) => println!("{question}: the regions answer this"),
        }
    }
    Ok(())
}
