//! Every statement of a dump: each field of the manifest, each root, each cell of `values.csv`, and all
//! of those that other dumps have and this one does not. Each is changed or left out where it belongs,
//! and added where it does not; hashes, sizes and counts are corrected. A dump that is still accepted must
//! be the dump that `export` writes for the options in the manifest, and its bounds must contain the
//! values of an exact computation.

mod fields;
mod roots;
mod values;

use meliora::dump::manifest::{CERTIFICATE, FILE, REGIONS};

use crate::common::prelude::*;
use crate::dumps::shop::{Named, Shop, sealed, text};
use meliora_amount::is_long;

/// A dump in a directory, with the model that it was made from.
struct Place {
    shop: Shop,
    honest: Dump,
    folder: tempfile::TempDir,
}

impl Place {
    fn new(model: &str, preferences: &str, named: Named) -> Self {
        let mut shop = Shop::new(model, preferences);
        let honest = shop.honest(named).unwrap().clone();
        let place = Place { shop, honest, folder: tempfile::tempdir().unwrap() };
        place.put(&place.honest.clone());
        place
    }

    fn put(&self, dump: &Dump) {
        self.put_manifest(&dump.manifest.text().unwrap());
        let files = [(REGIONS, &dump.regions), (CERTIFICATE, dump.certificate.as_ref().unwrap())];
        files.iter().for_each(|(name, diagram)| fs::write(self.path().join(name), text(diagram)).unwrap());
    }

    fn put_manifest(&self, manifest: &str) {
        fs::write(self.path().join(FILE), manifest).unwrap();
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Judges the dump in the directory: returns true if it is refused. An accepted dump must be true.
    #[track_caller]
    fn is_refused(&mut self, what: &str) -> bool {
        let Some(dump) = self.shop.verify(self.folder.path()) else { return true };
        let shown = || Manifest::text(&dump.manifest).unwrap();
        assert!(self.shop.is_harmless(&dump), "{what}: accepted: {}", shown());
        false
    }

    /// Judges an edited dump.
    #[track_caller]
    fn is_edit_refused(&mut self, what: &str, edit: impl FnOnce(&mut Dump)) -> bool {
        let mut dump = self.honest.clone();
        edit(&mut dump);
        self.put(&sealed(dump));
        self.is_refused(what)
    }
}

/// Two choices of one label, deadlocks, patterns of bits that are no values, constants of three kinds, and two
/// levels.
const STEPS: &str = "mdp const int K; const double p = 1/3; const bool sure = true;
    module m x:[0..K] init 0; b:bool;
      [safe] x=0 & !b -> (x'=1); [try] x=0 & !b -> 1/2:(x'=2) + 1/2:(x'=3);
      [go] x=0 & !b -> 1/2:(x'=3) + 1/2:(x'=1)&(b'=true); [go] x=3 & !b -> p:(x'=4) + 1-p:(b'=true);
      [] x=1 | x=2 & !b | x=3 & b -> true;
    endmodule";
const WISHES: &str =
    "objective A = F x=1; objective B = F (x=2 & !b); objective C = F x=3; objective D = F x=4;
    prefer B, C > A; prefer D > C;";
const COIN: &str = "mdp module m x:[0..4] init 0;
      [go] x=0 -> 0.5:(x'=1) + 0.5:(x'=2); [back] x=1 -> (x'=0); [on] x=1 -> (x'=3); [stay] x=2 | x=3 -> true;
      [slip] x=3 -> (x'=4); endmodule";
const PATHS: &str = "objective A = (G F x=0) | (F G x=2); objective B = F x=3; prefer B > A; require G x!=4;";
/// Formulas that are owed after each step, or must last, alone and joined; and a requirement over two steps.
const NESTED: &str = "objective A = (x!=3 U (G x=2)) & (F x=2); objective B = G (x=1 => F (x=0 & G F x=2));
    prefer A > B; require G (x=0 => X x!=1);";
/// The opponent decides how long it takes, and can weaken in a state of its own.
const GAME: &str = "smg player us m, [go], [risk] endplayer player them [wind], [drop] endplayer
    module m at:[0..6];
      [] at=0 -> (at'=1); [go] at=0 -> 0.5:(at'=2) + 0.5:(at'=3);
      [wind] at=2 -> (at'=4); [wind] at=2 -> 0.5:(at'=4) + 0.5:(at'=2);
      [risk] at=3 -> 0.5:(at'=5) + 0.5:(at'=1); [drop] at=5 -> (at'=6); [] at=1 | at=3 | at=4 -> true;
    endmodule";
const SIDES: &str =
    "objective A = F at=1; objective B = F at=4; objective C = F (at=3 | at=5); prefer B > A; prefer C > A;";
const CHAIN: &str = "dtmc module m s:[0..3] init 0;
      [] s<3 -> 1/2:(s'=mod(s+1,3)) + 1/2:(s'=3); [] s=3 -> true; endmodule";
const ROUND: &str =
    "objective A = F s=0; objective B = F s=1; objective C = F s=2; prefer A > B > C; empty = gain;";

/// Each step of a cycle improves on the last.
const RING: &str = "mdp module m s:[0..3];
      [go] s<3 -> 0.5:(s'=mod(s+1,3)) + 0.5:(s'=3); [stay] s=3 -> true; endmodule";
const BETTER: &str = "objective A = F s=0; objective A1 = F s=0; objective B = F s=1; objective B1 = F s=1;
    objective C = F s=2; objective C1 = F s=2; prefer B > A1; prefer C > B1; prefer A > C1;";

/// The dumps whose statements are tested: for each safety mode, of temporal objectives with a
/// requirement, with cut levels, of games, of a chain, and with levels that do not end.
fn places() -> Vec<Place> {
    let named =
        |scope: &str, safety, cut, constants: &str| (scope.to_owned(), safety, cut, constants.to_owned());
    vec![
        Place::new(STEPS, WISHES, named("reachable", Safety::Action, None, "K=4")),
        Place::new(STEPS, WISHES, named("all", Safety::Transition, None, "K=4")),
        Place::new(STEPS, WISHES, named("reachable", Safety::Prefix, Some(1), "K=4")),
        Place::new(COIN, PATHS, named("reachable", Safety::Action, None, "")),
        Place::new(COIN, NESTED, named("all", Safety::Prefix, None, "")),
        Place::new(GAME, SIDES, named("reachable", Safety::Action, None, "")),
        Place::new(GAME, &format!("coalition them; {SIDES}"), named("all", Safety::Prefix, None, "")),
        Place::new(CHAIN, ROUND, named("reachable", Safety::Action, None, "")),
        Place::new(RING, BETTER, named("all", Safety::Transition, None, "")),
    ]
}

/// One of this many statements is edited. All would take minutes: each edit is a run of `verify`.
fn each() -> usize {
    if is_long() { 3 } else { 15 }
}

/// The number of statements that are edited of `all`, at least.
fn least(all: usize) -> usize {
    all / each()
}

/// The statements of one kind that were edited, the edits, and how many of these were refused.
#[derive(Default)]
struct Tally {
    statements: usize,
    edits: usize,
    refused: usize,
}

/// The tallies by kind, and the kinds that `docs/dumps.md` names with the code that proves them.
struct Counts {
    by_kind: BTreeMap<String, Tally>,
    documented: Vec<String>,
    /// The number of statements, tested or not.
    seen: usize,
}

impl Counts {
    fn new() -> Self {
        let page = fs::read_to_string("docs/dumps.md").unwrap();
        let rows = page.lines().filter(|line| line.starts_with("| `"));
        let names = |row: &str| -> Vec<String> {
            let first = row.split(" | ").next().unwrap().trim_start_matches("| ");
            first.split('`').skip(1).step_by(2).map(str::to_owned).collect()
        };
        // The last column names a file of the checker.
        let is_proved =
            |row: &&str| row.contains("| `certify/") || row.contains("| nothing") || row.contains("| `dump/");
        let documented = rows.filter(is_proved).flat_map(names).collect();
        Counts { by_kind: BTreeMap::new(), documented, seen: 0 }
    }

    /// Returns true if the page names a kind, or a part of the manifest that contains it.
    fn names(&self, kind: &str) -> bool {
        self.documented.iter().any(|name| {
            let rest = kind.strip_prefix(name.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        })
    }

    /// Returns whether the next statement, of a kind that the page names, is tested.
    #[track_caller]
    fn takes(&mut self, kind: &str) -> bool {
        assert!(kind.is_empty() || self.names(kind), "docs/dumps.md does not name `{kind}`");
        self.takes_more()
    }

    /// Returns whether the next statement, of any kind, is tested.
    fn takes_more(&mut self) -> bool {
        self.seen += 1;
        self.seen.is_multiple_of(each())
    }

    /// Records the edits of a statement: whether each was refused.
    #[track_caller]
    fn record(&mut self, kind: &str, refused: &[bool]) {
        assert!(self.names(kind), "docs/dumps.md does not name `{kind}`");
        self.add(kind, refused);
    }

    /// Records the edits that add something, which may be of a kind that no dump has.
    fn record_more(&mut self, kind: &str, refused: &[bool]) {
        let kind = if self.names(kind) { kind } else { "a set that no dump has" };
        self.add(kind, refused);
    }

    fn add(&mut self, kind: &str, refused: &[bool]) {
        let tally = self.by_kind.entry(kind.to_owned()).or_default();
        tally.statements += 1;
        tally.edits += refused.len();
        tally.refused += refused.iter().filter(|refused| **refused).count();
    }

    /// Prints the table; returns the numbers of statements, of edits, and of refused ones.
    fn close(&self) -> [usize; 3] {
        let mut sums = [0; 3];
        println!("| {:34} | statements | edits | refused |", "kind");
        for (kind, Tally { statements, edits, refused }) in &self.by_kind {
            println!("| {kind:34} | {statements:10} | {edits:5} | {refused:7} |");
            sums.iter_mut().zip([statements, edits, refused]).for_each(|(sum, more)| *sum += more);
        }
        println!("{} statements, {} edits, {} refused, the others true", sums[0], sums[1], sums[2]);
        sums
    }
}
