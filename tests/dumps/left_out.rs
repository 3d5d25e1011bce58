//! A choice that is left out of every set of a dump, so that the sets fit each other.

use meliora::dump::manifest::{CERTIFICATE, FILE, File, REGIONS};

use super::shop::{Shop, sealed, text};
use crate::common::prelude::*;

/// The function without the members that have these bits.
fn without(diagram: &mut Diagram, from: Edge, level: u32, bits: &[(&str, bool)]) -> Edge {
    let Some(name) = diagram.variables.get(level as usize) else { return Edge::FALSE };
    let fixed = bits.iter().find(|(bit, _)| bit == name).map(|(_, value)| *value);
    let (mut then, mut otherwise) = diagram.cofactors(from, level);
    if fixed != Some(false) {
        then = without(diagram, then, level + 1, bits);
    }
    if fixed != Some(true) {
        otherwise = without(diagram, otherwise, level + 1, bits);
    }
    if then == otherwise { then } else { diagram.push(level, then, otherwise).unwrap() }
}

/// Round after round something improves on the last, and a detour leads there, too.
const RING: &str = "mdp module m s:[0..4];
      [go] s=0 -> 0.5:(s'=1) + 0.5:(s'=3); [go] s=1 -> 0.5:(s'=2) + 0.5:(s'=3); [go] s=2 -> 0.5:(s'=0) + 0.5:(s'=3);
      [detour] s=0 -> 0.5:(s'=4) + 0.5:(s'=3); [on] s=4 -> 0.5:(s'=1) + 0.5:(s'=3); [stay] true -> true;
    endmodule";
const RING_PREFERENCES: &str =
    "objective A = F s=0; objective A1 = F s=0; objective B = F s=1; objective B1 = F s=1;
    objective C = F s=2; objective C1 = F s=2; objective Z = F s=3; objective W = F s=4;
    prefer B > A1; prefer C > B1; prefer A > C1;";

/// Against the class of state 0, state 4 is taken out of the unbounded level, of its layers and of its
/// strategy; so is the detour in state 0. Each set fits the others, and something that is permitted is
/// said not to be.
#[test]
fn a_choice_left_out_everywhere_is_missed() {
    const AGAINST: &str = "spi:unbounded@A+A1+Z";
    let mut shop = Shop::new(RING, RING_PREFERENCES);
    let named = ("all".to_owned(), Safety::Prefix, None, String::new());
    let mut dump = shop.honest(named).unwrap().clone();
    let detour = dump.manifest.choices.numbers.iter().find(|n| n.name == "detour").unwrap().number;
    let order = dump.manifest.choices.order.clone();
    let bit = |(position, name): (usize, &'static str)| (name, 4 >> position & 1 == 1);
    let away: Vec<(&str, bool)> = ["s.0", "s.1", "s.2"].into_iter().enumerate().map(bit).collect();
    let width = order.len();
    let number =
        order.iter().enumerate().map(|(k, name)| (name.as_str(), detour >> (width - 1 - k) & 1 == 1));
    let chosen: Vec<_> = [("s.0", false), ("s.1", false), ("s.2", false)].into_iter().chain(number).collect();
    let offset = width as u32;
    let (file, diagram) = (dump.manifest.certificate.as_mut().unwrap(), dump.certificate.as_mut().unwrap());
    let layers = format!("layers:{AGAINST}:");
    for root in &mut file.roots {
        if root.name == AGAINST || root.name.starts_with(&layers) {
            root.node = without(diagram, root.node, offset, &away);
        } else if root.name == format!("strategy:{AGAINST}") {
            let rest = without(diagram, root.node, 0, &away);
            root.node = without(diagram, rest, 0, &chosen);
        }
    }
    let (file, diagram) = (&mut dump.manifest.regions, &mut dump.regions);
    let root = file.roots.iter_mut().find(|r| r.name == "strategy:spi:unbounded").unwrap();
    root.node = without(diagram, root.node, 0, &chosen);
    let scratch = tempfile::tempdir().unwrap();
    let forged = sealed(dump);
    let count = |file: &File, name: &str| file.root(name).unwrap().count.clone();
    assert_eq!(count(&forged.manifest.regions, "strategy:spi:unbounded"), "6");
    assert_eq!(count(forged.manifest.certificate.as_ref().unwrap(), AGAINST), "2");
    let [regions, certificate] = [text(&forged.regions), text(forged.certificate.as_ref().unwrap())];
    for (name, text) in
        [(FILE, &forged.manifest.text().unwrap()), (REGIONS, &regions), (CERTIFICATE, &certificate)]
    {
        fs::write(scratch.path().join(name), text).unwrap();
    }
    assert!(shop.verify(scratch.path()).is_none());
}
