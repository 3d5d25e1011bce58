//! A line of machines that wear, break and are repaired by one team, with a buffer behind each: many parts that
//! move one at a time.

use std::fmt::Write;

/// Returns the model.
pub(crate) fn factory(machines: usize) -> String {
    let mut text = format!("mdp module team at : [0..{machines}] init 0;");
    for i in 1..=machines {
        let _ = write!(text, " [call{i}] at=0 -> (at'={i}); [fix{i}] at={i} -> (at'=0);");
    }
    text += " endmodule ";
    for i in 1..=machines {
        let next = if i == machines { "ship".to_owned() } else { format!("take{}", i + 1) };
        let _ = write!(
            text,
            "module machine{i} s{i} : [0..3] init 0; w{i} : [0..3] init 0; b{i} : [0..1] init 0;
               [take{i}] s{i}=0 -> (s{i}'=1);
               [work{i}] s{i}=1 & w{i}<3 -> 0.9: (s{i}'=2) + 0.08: (s{i}'=2) & (w{i}'=w{i}+1) + 0.02: (s{i}'=3);
               [work{i}] s{i}=1 & w{i}=3 -> 0.5: (s{i}'=2) + 0.5: (s{i}'=3);
               [put{i}] s{i}=2 & b{i}=0 -> (s{i}'=0) & (b{i}'=1);
               [call{i}] s{i}=3 -> true;
               [fix{i}] s{i}=3 -> 0.7: (s{i}'=0) & (w{i}'=0) + 0.3: true;
               [{next}] b{i}=1 -> (b{i}'=0);
             endmodule "
        );
    }
    let broken = (1..=machines).map(|i| format!("s{i}=3")).collect::<Vec<_>>().join(" & ");
    text + "module out shipped : [0..2] init 0; [ship] shipped<2 -> (shipped'=shipped+1); endmodule "
        + &format!("label \"order\" = shipped=2; label \"allbroken\" = {broken};")
}

/// Objectives over states: two that are always possible, and two that may be lost.
pub(crate) const PREFERENCES: &str = "objective Order = F \"order\"; objective Collapse = F \"allbroken\";
    objective Worn = F w2=3; objective Full = F (b1=1 & b2=1); prefer Full > Order; prefer Worn > Order;";

/// Objectives over paths.
pub(crate) const OVER_PATHS: &str = "objective Order = F \"order\"; objective Safe = G !\"allbroken\";
    objective Fresh = (F \"order\") & (G w1<2); prefer Fresh > Order; prefer Safe > Order;";
