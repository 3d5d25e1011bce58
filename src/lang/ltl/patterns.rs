//! Formulas of the literature: the table of monitors in the documentation is made of them.
//!
//! The patterns are those of M. Dwyer, G. Avrunin and J. Corbett, *Patterns in property
//! specifications for finite-state verification* (1999), where p and the events s and t around it
//! are states, and r and q end and begin a scope. The other formulas are those of K. Etessami and
//! G. Holzmann, *Optimizing Büchi automata* (2000), and of F. Somenzi and R. Bloem, *Efficient Büchi
//! automata from LTL formulae* (2000).

use std::fmt::Write;

use super::parse_formula;
use super::words::Judge;
use meliora_model::error::SourceFile;

/// Patterns with their scopes: globally, before r, after q, between q and r, after q until r.
const PATTERNS: [(&str, [&str; 5]); 11] = [
    (
        "absence",
        [
            "G !p",
            "(F r) => (!p U r)",
            "G (q => G !p)",
            "G ((q & !r & (F r)) => (!p U r))",
            "G ((q & !r) => (!p W r))",
        ],
    ),
    (
        "existence",
        [
            "F p",
            "!r W (p & !r)",
            "(G !q) | (F (q & F p))",
            "G ((q & !r) => (!r W (p & !r)))",
            "G ((q & !r) => (!r U (p & !r)))",
        ],
    ),
    (
        "existence, at most twice",
        [
            "!p W (p W (!p W (p W (G !p))))",
            "(F r) => TWICE<!p U r>",
            "(F q) => (!q U (q & (!p W (p W (!p W (p W (G !p)))))))",
            "G ((q & (F r)) => TWICE<!p U r>)",
            "G (q => TWICE<(!p W r) | (G p)>)",
        ],
    ),
    (
        "universality",
        [
            "G p",
            "(F r) => (p U r)",
            "G (q => G p)",
            "G ((q & !r & (F r)) => (p U r))",
            "G ((q & !r) => (p W r))",
        ],
    ),
    (
        "precedence",
        [
            "!p W s",
            "(F r) => (!p U (s | r))",
            "(G !q) | (F (q & (!p W s)))",
            "G ((q & !r & (F r)) => (!p U (s | r)))",
            "G ((q & !r) => (!p W (s | r)))",
        ],
    ),
    (
        "response",
        [
            "G (p => F s)",
            "(F r) => ((p => (!r U (s & !r))) U r)",
            "G (q => G (p => F s))",
            "G ((q & !r & (F r)) => ((p => (!r U (s & !r))) U r))",
            "G ((q & !r) => ((p => (!r U (s & !r))) W r))",
        ],
    ),
    (
        "precedence, two causes",
        [
            "(F p) => (!p U (s & !p & (X (!p U t))))",
            "(F r) => (!p U (r | (s & !p & (X (!p U t)))))",
            "(G !q) | (!q U (q & ((F p) => (!p U (s & !p & (X (!p U t)))))))",
            "G ((q & (F r)) => (!p U (r | (s & !p & (X (!p U t))))))",
            "G (q => ((F p) => (!p U (r | (s & !p & (X (!p U t)))))))",
        ],
    ),
    (
        "precedence, two effects",
        [
            "(F (s & X F t)) => (!s U p)",
            "(F r) => ((!(s & !r & (X (!r U (t & !r))))) U (r | p))",
            "(G !q) | (!q U (q & ((F (s & X F t)) => (!s U p))))",
            "G ((q & (F r)) => ((!(s & !r & (X (!r U (t & !r))))) U (r | p)))",
            "G (q => (((!(s & !r & (X (!r U (t & !r))))) U (r | p)) | (G (!(s & X F t)))))",
        ],
    ),
    (
        "response, two causes",
        [
            "G ((s & (X F t)) => (X F (t & F p)))",
            "(F r) => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U r)",
            "G (q => (G ((s & (X F t)) => (X (!t U (t & F p))))))",
            "G ((q & (F r)) => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U r))",
            "G (q => (((s & (X (!r U t))) => (X (!r U (t & F p)))) U (r | LATER)))",
        ],
    ),
    (
        "response, two effects",
        [
            "G (p => F (s & X F t))",
            "(F r) => ((p => (!r U (s & !r & (X (!r U t))))) U r)",
            "G (q => G (p => (s & X F t)))",
            "G ((q & (F r)) => ((p => (!r U (s & !r & (X (!r U t))))) U r))",
            "G (q => ((p => (!r U (s & !r & (X (!r U t))))) U (r | (G (p => (s & X F t))))))",
        ],
    ),
    (
        "response, two effects without z",
        [
            "G (p => F (s & !z & (X (!z U t))))",
            "(F r) => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U r)",
            "G (q => G (p => (s & !z & (X (!z U t)))))",
            "G ((q & (F r)) => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U r))",
            "G (q => ((p => (!r U (s & !r & !z & (X ((!r & !z) U t))))) U (r | (G (p => (s & !z & (X (!z U t))))))))",
        ],
    ),
];

/// At most two stretches of p before r; then a formula for the rest.
const TWICE: &str = "((!p & !r) U (r | ((p & !r) U (r | ((!p & !r) U (r | ((p & !r) U (r | (REST)))))))))";
/// The response to two causes, without an end.
const LATER: &str = "(G ((s & (X (!r U t))) => (X (!r U (t & F p)))))";

const ETESSAMI_AND_HOLZMANN: [&str; 12] = [
    "p U (q & G r)",
    "p U (q & (X (r U s)))",
    "p U (q & (X (r & F (s & X F (t & X F (u & X F v))))))",
    "F (p & X G q)",
    "F (p & X (q & X F r))",
    "F (q & (X (p U r)))",
    "(F G q) | (F G p)",
    "G (p => (q U r))",
    "F (p & X F (q & X F (r & X F s)))",
    "(G F p) & (G F q) & (G F r) & (G F s) & (G F t)",
    "(p U (q U r)) | (q U (r U p)) | (r U (p U q))",
    "G (p => (q U ((G r) | (G s))))",
];

const SOMENZI_AND_BLOEM: [&str; 27] = [
    "p U q",
    "p U (q U r)",
    "!(p U (q U r))",
    "(G F p) => (G F q)",
    "(F p) U (G q)",
    "(G p) U q",
    "!((F F p) <=> (F p))",
    "!((G F p) => (G F q))",
    "!((G F p) <=> (G F q))",
    "p R (p | q)",
    "((X p) U (X q)) | !(X (p U q))",
    "((X p) U q) | !(X (p U (p & q)))",
    "(G (p => F q)) & (((X p) U q) | !(X (p U (p & q))))",
    "(G (p => F q)) & (((X p) U (X q)) | !(X (p U q)))",
    "G (p => F q)",
    "!(G (p => (X (q R r))))",
    "!((G F p) | (F G q))",
    "G ((F p) & (F q))",
    "(F p) & (F !p)",
    "((X q) & r) R (X (((s U p) R r) U (s R r)))",
    "((G (q | G F r)) & (G (p | G F !r))) | (G q) | (G p)",
    "((G (q | F G r)) & (G (p | F G !r))) | (G q) | (G p)",
    "!(((G (q | G F r)) & (G (p | G F !r))) | (G q) | (G p))",
    "!(((G (q | F G r)) & (G (p | F G !r))) | (G q) | (G p))",
    "(G (q | X G p)) & (G (r | X G !p))",
    "G (q | ((X p) & (X !p)))",
    "(p U p) | (q U p)",
];

/// The number of states of each monitor.
fn monitors(text: &str) -> String {
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
    match sizes.len() {
        0 => "–".to_owned(),
        _ => sizes.iter().map(usize::to_string).collect::<Vec<_>>().join(" · "),
    }
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
        write!(text, "\n| {title} | states of the monitors |\n| --- | --- |\n").unwrap();
        for formula in formulas {
            let (cell, monitors) = (formula.replace('|', "\\|"), monitors(formula));
            writeln!(text, "| `{cell}` | {monitors} |").unwrap();
        }
    }
    text
}

#[test]
fn the_documentation_lists_the_monitors_of_known_formulas() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/benchmarks.md");
    let tables = tables();
    assert!(std::fs::read_to_string(path).unwrap().contains(&tables), "not in {path}:\n{tables}");
}
