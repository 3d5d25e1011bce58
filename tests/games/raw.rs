//! Small games as plain vectors, as texts, and solved by enumerating all memoryless strategies of both
//! sides.

use std::fmt::Write;

use crate::common::prelude::*;

/// A game: for each state whether the opponent chooses there, and the successors of each choice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Raw {
    pub(crate) theirs: Vec<bool>,
    pub(crate) choices: Vec<Vec<Vec<usize>>>,
}

/// The states from which something is won, as one entry per state.
pub(crate) type Won = Vec<bool>;

/// The states from which a side can enforce that the target is reached, surely and possibly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Enforced {
    pub(crate) surely: Won,
    pub(crate) possibly: Won,
}

impl Raw {
    pub(crate) fn len(&self) -> usize {
        self.choices.len()
    }

    /// Returns the text of the game over one global variable: each side has a module.
    pub(crate) fn text(&self) -> String {
        let last = self.len() - 1;
        let mut modules = ["module mine\n".to_owned(), "module yours\n".to_owned()];
        for (s, choices) in self.choices.iter().enumerate() {
            for successors in choices {
                let of = |t: &usize| format!("1/{}:(x'={t})", successors.len());
                let branches = successors.iter().map(of).collect::<Vec<_>>().join(" + ");
                let _ = writeln!(modules[usize::from(self.theirs[s])], " [] x={s} -> {branches};");
            }
        }
        let [mine, yours] = modules;
        format!(
            "smg\nplayer us mine endplayer\nplayer them yours endplayer\nglobal x : [0..{last}] init 0;\n\
             {mine}endmodule\n{yours}endmodule\n"
        )
    }

    /// Returns the text of the game over two variables in one module; the choices are labelled.
    pub(crate) fn labelled_text(&self) -> String {
        let last = self.len().div_ceil(2) - 1;
        let (mut commands, mut names) = (String::new(), [Vec::new(), Vec::new()]);
        for (s, choices) in self.choices.iter().enumerate() {
            let theirs = usize::from(self.theirs[s]);
            for (k, successors) in choices.iter().enumerate() {
                let name = format!("{}{k}", ["u", "t"][theirs]);
                let of = |t: &usize| format!("1/{}:(h'={})&(l'={})", successors.len(), t / 2, t % 2);
                let branches = successors.iter().map(of).collect::<Vec<_>>().join(" + ");
                let _ = writeln!(commands, " [{name}] h={} & l={} -> {branches};", s / 2, s % 2);
                if !names[theirs].contains(&name) {
                    names[theirs].push(name);
                }
            }
        }
        let [mine, yours] =
            names.map(|all| all.into_iter().map(|name| format!("[{name}]")).collect::<Vec<_>>().join(", "));
        format!(
            "smg\nplayer us {mine} endplayer\nplayer them {yours} endplayer\nmodule m\n h : [0..{last}] init 0;\n \
             l : [0..1] init 0;\n{commands}endmodule\n"
        )
    }

    /// Returns what each side can enforce: we, and the opponent. Panics if a strategy of one side that
    /// beats each strategy of the other is missing though no single one of these beats all.
    pub(crate) fn enforced(&self, target: &[bool]) -> [Enforced; 2] {
        self.enforced_by(|picks| self.outcome(picks, target))
    }

    /// Returns what each side can enforce, from the outcome of each pair of strategies.
    pub(crate) fn enforced_by(&self, outcome: impl Fn(&[usize]) -> Enforced) -> [Enforced; 2] {
        let [ours, theirs] = [false, true].map(|side| self.strategies(side));
        let outcomes: Vec<Vec<Enforced>> = ours
            .iter()
            .map(|mine| theirs.iter().map(|yours| outcome(&joined(mine, yours))).collect())
            .collect();
        [false, true].map(|side| {
            let of = |a: usize, b: usize| if side { &outcomes[b][a] } else { &outcomes[a][b] };
            let sizes = if side { [theirs.len(), ours.len()] } else { [ours.len(), theirs.len()] };
            let enforced = |won: fn(&Enforced) -> &Won| {
                let one = |s: usize| {
                    let strategy = (0..sizes[0]).any(|a| (0..sizes[1]).all(|b| won(of(a, b))[s]));
                    let answer = (0..sizes[1]).all(|b| (0..sizes[0]).any(|a| won(of(a, b))[s]));
                    assert_eq!(strategy, answer, "not determined in {s}: {self:?}");
                    strategy
                };
                (0..self.len()).map(one).collect()
            };
            Enforced { surely: enforced(|o| &o.surely), possibly: enforced(|o| &o.possibly) }
        })
    }

    /// The number of pairs of strategies.
    pub(crate) fn pairs(&self) -> usize {
        self.choices.iter().map(|choices| choices.len().max(1)).product()
    }

    /// All strategies of a side; states of the other side have no choice in them.
    fn strategies(&self, theirs: bool) -> Vec<Vec<Option<usize>>> {
        let mut all = vec![Vec::new()];
        for (s, choices) in self.choices.iter().enumerate() {
            let options: Vec<Option<usize>> = match self.theirs[s] == theirs {
                true => (0..choices.len()).map(Some).collect(),
                false => vec![None],
            };
            let longer = |prefix: &Vec<Option<usize>>| -> Vec<_> {
                let with = |option: &Option<usize>| [prefix.clone(), vec![*option]].concat();
                options.iter().map(with).collect()
            };
            all = all.iter().flat_map(longer).collect();
        }
        all
    }

    /// The states from which the Markov chain of two strategies reaches the target.
    fn outcome(&self, picks: &[usize], target: &[bool]) -> Enforced {
        let next = |s: usize| -> &[usize] { &self.choices[s][picks[s]] };
        let possibly = backwards(self.len(), target, next);
        let never: Won = possibly.iter().map(|&p| !p).collect();
        // A path that has reached the target cannot fail any more.
        let onwards = |s: usize| if target[s] { &[][..] } else { next(s) };
        let failing = backwards(self.len(), &never, onwards);
        Enforced { surely: failing.into_iter().map(|f| !f).collect(), possibly }
    }
}

fn joined(mine: &[Option<usize>], yours: &[Option<usize>]) -> Vec<usize> {
    mine.iter().zip(yours).map(|(a, b)| a.or(*b).unwrap_or(0)).collect()
}

/// The states from which a state of the target is reached.
fn backwards<'a>(n: usize, target: &[bool], next: impl Fn(usize) -> &'a [usize]) -> Won {
    let mut found = target.to_vec();
    loop {
        let more: Won = (0..n).map(|s| found[s] || next(s).iter().any(|&t| found[t])).collect();
        if more == found {
            return found;
        }
        found = more;
    }
}

/// Reads a game.
pub(crate) fn program(text: &str) -> Program {
    parsed(text)
}

/// Reads a game and preferences.
pub(crate) fn loaded(text: &str, preferences: &str) -> (Arc<Program>, Arc<Preferences>) {
    let program = program(text);
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("preferences", preferences), program).unwrap();
    (Arc::new(program), Arc::new(preferences))
}
