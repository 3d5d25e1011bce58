//! Formulas of the literature: the table of monitors in the documentation is made of them.
//!
//! The patterns are those of M. Dwyer, G. Avrunin and J. Corbett, *Patterns in property
//! specifications for finite-state verification* (1999), where p and the events s and t around it
//! are states, and r and q end and begin a scope. The other formulas are those of K. Etessami and
//! G. Holzmann, *Optimizing Büchi automata* (2000), and of F. Somenzi and R. Bloem, *Efficient Büchi
//! automata from LTL formulae* (2000).

use std::fmt::Write;

use super::words::Judge;
use crate::ltl::parse_formula;
use meliora_base::error::SourceFile;

/// A formula, and the number of states of Spot's deterministic automaton: a single complete one, with
/// state-based acceptance, as Storm uses it (stormpy 2.0).
type Known = (&'static str, u32);

/// Patterns with their scopes: globally, before r, after q, between q and r, after q until r.
const PATTERNS: [(&str, [Known; 5]); 11] = [
    (
        "absence",
        [
            ("G !p", 2),
            ("(F r) => (!p U r)", 4),
            ("G (q => G !p)", 3),
            ("G ((q & !r & (F r)) => (!p U r))", 4),
            ("G ((q & !r) => (!p W r))", 3),
        ],
    ),
    (
        "existence",
        [
            ("F p", 2),
            ("!r W (p & !r)", 3),
            ("(G !q) | (F (q & F p))", 5),
            ("G ((q & !r) => (!r W (p & !r)))", 3),
            ("G ((q & !r) => (!r U (p & !r)))", 3),
        ],
    ),
    (
        "existence, at most twice",
        [
            ("!p W (p W (!p W (p W (G !p))))", 6),
            ("(F r) => TWICE<!p U r>", 8),
            ("(F q) => (!q U (q & (!p W (p W (!p W (p W (G !p)))))))", 20),
            ("G ((q & (F r)) => TWICE<!p U r>)", 8),
            ("G (q => TWICE<(!p W r) | (G p)>)", 29),
        ],
    ),
    (
        "universality",
        [
            ("G p", 2),
            ("(F r) => (p U r)", 4),
            ("G (q => G p)", 3),
            ("G ((q & !r & (F r)) => (p U r))", 4),
            ("G ((q & !r) => (p W r))", 3),
        ],
    ),
    (
        "precedence",
        [
            ("!p W s", 3),
            ("(F r) => (!p U (s | r))", 5),
            ("(G !q) | (F (q & (!p W s)))", 5),
            ("G ((q & !r & (F r)) => (!p U (s | r)))", 5),
            ("G ((q & !r) => (!p W (s | r)))", 3),
        ],
    ),
    (
        "response",
        [
            ("G (p => F s)", 2),
            ("(F r) => ((p => (!r U (s & !r))) U r)", 6),
            ("G (q => G (p => F s))", 3),
            ("G ((q & !r & (F r)) => ((p => (!r U (s & !r))) U r))", 7),
            ("G ((q & !r) => ((p => (!r U (s & !r))) W r))", 5),
        ],
    ),
    (
        "precedence, two causes",
        [
            ("(F p) => (!p U (s & !p & (X (!p U t))))", 9),
            ("(F r) => (!p U (r | (s & !p & (X (!p U t)))))", 7),
            ("(G !q) | (!q U (q & ((F p) => (!p U (s & !p & (X (!p U t)))))))", 17),
            ("G ((q & (F r)) => (!p U (r | (s & !p & (X (!p U t))))))", 31),
            ("G (q => ((F p) => (!p U (r | (s & !p & (X (!p U t)))))))", 61),
        ],
    ),
    (
        "precedence, two effects",
        [
            ("(F (s & X F t)) => (!s U p)", 7),
            ("(F r) => ((!(s & !r & (X (!r U (t & !r))))) U (r | p))", 9),
            ("(G !q) | (!q U (q & ((F (s & X F t)) => (!s U p))))", 13),
            ("G ((q & (F r)) => ((!(s & !r & (X (!r U (t & !r))))) U (r | p)))", 12),
            ("G (q => (((!(s & !r & (X (!r U (t & !r))))) U (r | p)) | (G (!(s & X F t)))))", 36),
        ],
    ),
    (
        "response, two causes",
        [
            ("G ((s & (X F t)) => (X F (t & F p)))", 4),
            ("(F r) => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U r)", 8),
            ("G (q => (G ((s & (X F t)) => (X (!t U (t & F p))))))", 25),
            ("G ((q & (F r)) => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U r))", 253),
            ("G (q => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U (r | LATER)))", 54),
        ],
    ),
    (
        "response, two effects",
        [
            ("G (p => F (s & X F t))", 9),
            ("(F r) => ((p => (!r U (s & !r & (X (!r U t))))) U r)", 12),
            ("G (q => G (p => (s & X F t)))", 5),
            ("G ((q & (F r)) => ((p => (!r U (s & !r & (X (!r U t))))) U r))", 241),
            ("G (q => ((p => (!r U (s & !r & (X (!r U t))))) U (r | (G (p => (s & X F t))))))", 697),
        ],
    ),
    (
        "response, two effects without z",
        [
            ("G (p => F (s & !z & (X (!z U t))))", 12),
            ("(F r) => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U r)", 12),
            ("G (q => G (p => (s & !z & (X (!z U t)))))", 5),
            ("G ((q & (F r)) => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U r))", 264),
            (
                "G (q => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U (r | (G (p => (s & !z & (X (!z U t))))))))",
                777,
            ),
        ],
    ),
];

/// At most two stretches of p before r; then a formula for the rest.
const TWICE: &str = "((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (REST)))))))))";
/// The response to two causes, without an end.
const LATER: &str = "(G ((s & (X (!r U t))) => (X (!r U (t & F p)))))";

const ETESSAMI_AND_HOLZMANN: [Known; 12] = [
    ("p U (q & G r)", 4),
    ("p U (q & (X (r U s)))", 5),
    ("p U (q & (X (r & F (s & X F (t & X F (u & X F v))))))", 9),
    ("F (p & X G q)", 3),
    ("F (p & X (q & X F r))", 4),
    ("F (q & (X (p U r)))", 3),
    ("(F G q) | (F G p)", 4),
    ("G (p => (q U r))", 3),
    ("F (p & X F (q & X F (r & X F s)))", 5),
    ("(G F p) & (G F q) & (G F r) & (G F s) & (G F t)", 32),
    ("(p U (q U r)) | (q U (r U p)) | (r U (p U q))", 3),
    ("G (p => (q U ((G r) | (G s))))", 10),
];

const SOMENZI_AND_BLOEM: [Known; 27] = [
    ("p U q", 3),
    ("p U (q U r)", 4),
    ("!(p U (q U r))", 4),
    ("(G F p) => (G F q)", 3),
    ("(F p) U (G q)", 3),
    ("(G p) U q", 5),
    ("!((F F p) <=> (F p))", 1),
    ("!((G F p) => (G F q))", 3),
    ("!((G F p) <=> (G F q))", 4),
    ("p R (p | q)", 3),
    ("((X p) U (X q)) | !(X (p U q))", 1),
    ("((X p) U q) | !(X (p U (p & q)))", 5),
    ("(G (p => F q)) & (((X p) U q) | !(X (p U (p & q))))", 7),
    ("(G (p => F q)) & (((X p) U (X q)) | !(X (p U q)))", 2),
    ("G (p => F q)", 2),
    ("!(G (p => (X (q R r))))", 3),
    ("!((G F p) | (F G q))", 3),
    ("G ((F p) & (F q))", 4),
    ("(F p) & (F !p)", 4),
    ("((X q) & r) R (X (((s U p) R r) U (s R r)))", 6),
    ("((G (q | G F r)) & (G (p | G F !r))) | (G q) | (G p)", 12),
    ("((G (q | F G r)) & (G (p | F G !r))) | (G q) | (G p)", 5),
    ("!(((G (q | G F r)) & (G (p | G F !r))) | (G q) | (G p))", 8),
    ("!(((G (q | F G r)) & (G (p | F G !r))) | (G q) | (G p))", 5),
    ("(G (q | X G p)) & (G (r | X G !p))", 5),
    ("G (q | ((X p) & (X !p)))", 3),
    ("(p U p) | (q U p)", 3),
];

/// The number of states of each monitor, and those of Spot's automaton.
fn monitors((text, spot): Known) -> String {
    let text = match text.split_once("TWICE<") {
        Some((before, rest)) => {
            let (rest, after) = rest.split_once('>').unwrap();
            format!("{before}{}{after}", TWICE.replace("REST", rest))
        }
        None => text.replace("LATER", LATER),
    };
    let formula = parse_formula(&SourceFile::new("formula", text.as_str())).unwrap();
    let mut sizes = Judge::new(&formula).unwrap().sizes();
    sizes.sort_unstable();
    let sizes: Vec<String> = sizes.iter().map(usize::to_string).collect();
    format!("{} ({spot})", sizes.join(" · "))
}

/// The tables of the documentation.
fn tables() -> String {
    let mut text = "| pattern | globally | before r | after q | between q and r | after q until r |\n\
        | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for (name, scopes) in PATTERNS {
        let cells = scopes.map(monitors).join(" | ");
        writeln!(text, "| {name} | {cells} |").unwrap();
    }
    for (title, formulas) in
        [("Etessami and Holzmann", &ETESSAMI_AND_HOLZMANN[..]), ("Somenzi and Bloem", &SOMENZI_AND_BLOEM[..])]
    {
        write!(text, "\n| {title} | monitors (Spot) |\n| --- | --- |\n").unwrap();
        for &formula in formulas {
            let (cell, monitors) = (formula.0.replace('|', "\\|"), monitors(formula));
            writeln!(text, "| `{cell}` | {monitors} |").unwrap();
        }
    }
    text
}

#[test]
fn the_documentation_lists_the_monitors_of_known_formulas() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/ltl/tests/patterns.md");
    let tables = tables();
    assert!(std::fs::read_to_string(path).unwrap().contains(&tables), "not in {path}:\n{tables}");
}
