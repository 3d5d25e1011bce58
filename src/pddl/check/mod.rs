//! From lists to a checked task: sections, types, names and arities.

mod amount;
mod condition;
mod effect;
mod implied;
mod initial;
mod problem;
mod requirements;
mod rules;
mod types;

use std::collections::BTreeSet;
use std::sync::Arc;

use ahash::AHashMap;

use crate::syntax::{Faults, Node};
use crate::task::{Action, Axiom, Domain, Function, Measure, Predicate, Task};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::exact::Ratio;
use requirements::Requirements;
use types::Types;

/// The parts of a task that are under construction, and the names that are known.
#[derive(Default)]
pub(crate) struct Checker {
    faults: Faults,
    types: Types,
    /// The objects as they are declared, and their numbers by small letters.
    objects: Vec<String>,
    object_of: AHashMap<String, u32>,
    predicates: Vec<Predicate>,
    predicate_of: AHashMap<String, usize>,
    actions: Vec<Action>,
    axioms: Vec<Axiom>,
    functions: Vec<Function>,
    /// The functions on which no cost depends so far, each with its declaration.
    unused_functions: Vec<(usize, Node)>,
    measures: BTreeSet<Measure>,
    goal_reward: Option<Ratio>,
    /// The number of `oneof`s around the effect that is read.
    alternatives: usize,
    used: Requirements,
    /// True once an argument of another type has been noted.
    is_noted: bool,
    /// The variables in scope, outermost first.
    scope: Vec<(String, Arc<Domain>)>,
    /// The texts, each with its start in the joined text.
    starts: Vec<(Arc<SourceFile>, usize)>,
}

/// The sections of both parts.
struct Sections<'n> {
    /// The name of the domain, unless it is missing.
    name: Option<&'n Node>,
    domain: &'n [Node],
    problem: &'n [Node],
}

/// Checks the lists of all texts, which together are one domain and one problem.
///
/// # Errors
/// The lists are wrong: as many errors as can be distinguished.
pub(crate) fn check(
    sources: &[Arc<SourceFile>],
    joined: &Arc<SourceFile>,
    nodes: &[Node],
) -> Result<(Task, Vec<Diagnostic>)> {
    let sections = sections(sources, nodes)?;
    let mut checker = Checker::default();
    let mut start = 0;
    for source in sources {
        checker.starts.push((Arc::clone(source), start));
        start += source.text.len() + 1;
    }
    let goals = checker.all(&sections);
    if !checker.faults.errors.is_empty() {
        return Err(Error::Input(checker.faults.errors));
    }
    let mut notes = checker.faults.notes;
    notes.extend(checker.used.notes([sections.domain, sections.problem]));
    let task = Task {
        source: Arc::clone(joined),
        objects: checker.objects,
        predicates: checker.predicates,
        actions: checker.actions,
        axioms: checker.axioms,
        functions: checker.functions,
        initial: goals.initial,
        starts: goals.starts,
        goal: goals.goal,
        preferences: goals.preferences,
        measures: checker.measures,
        goal_reward: checker.goal_reward,
        has_oneof: checker.used.has_oneof(),
    };
    Ok((task, notes))
}

/// Finds the domain and the problem.
fn sections<'n>(sources: &[Arc<SourceFile>], nodes: &'n [Node]) -> Result<Sections<'n>> {
    let (mut domain, mut problem, mut domain_name) = (None, None, None);
    for node in nodes {
        let parts = match node.form() {
            Some(("define", parts)) => parts,
            _ => return Err(node.expected("`(define …)`").into()),
        };
        let Some((name, parts)) = parts.split_first() else {
            return Err(node.wrong("expected `(domain NAME)` or `(problem NAME)` after `define`").into());
        };
        let slot = match name.form() {
            Some(("domain", parts)) => {
                domain_name = parts.first();
                &mut domain
            }
            Some(("problem", _)) => &mut problem,
            _ => return Err(name.expected("`(domain NAME)` or `(problem NAME)`").into()),
        };
        if slot.is_some() {
            let help = "a planning problem is one domain and one problem: two files, or one file with both";
            return Err(name.wrong("this part stands twice").help(help).into());
        }
        *slot = Some(parts);
    }
    let missing = |what: &str, other: &str| {
        let last = sources.last().map_or_else(|| SourceFile::new("", ""), Arc::clone);
        let help =
            format!("give two files, `domain.pddl problem.pddl`, or one file with both; this is the {other}");
        Diagnostic::new(&last, 0..0, format!("the {what} is missing")).help(help)
    };
    match (domain, problem) {
        (Some(domain), Some(problem)) => Ok(Sections { name: domain_name, domain, problem }),
        (None, _) => Err(missing("domain", "problem").into()),
        (_, None) => Err(missing("problem", "domain").into()),
    }
}

impl Checker {
    /// Checks all sections in an order in which names are declared before they are used.
    fn all(&mut self, sections: &Sections<'_>) -> problem::Goals {
        let both = || sections.domain.iter().chain(sections.problem);
        for node in both() {
            self.refuse_section(node);
        }
        self.note_other_domain(sections);
        self.named(sections.domain, ":types", |c, parts, _| c.declare_types(parts));
        self.named(sections.domain, ":constants", |c, parts, _| c.declare_objects(parts));
        self.named(sections.problem, ":objects", |c, parts, _| c.declare_objects(parts));
        let mut declared = Vec::new();
        self.named(sections.domain, ":predicates", |c, parts, _| c.read_predicates(parts, &mut declared));
        self.declare_implied(sections.domain, &declared);
        self.declare_initial(sections, &declared);
        self.add_predicates(declared);
        self.named(sections.domain, ":functions", |c, parts, _| c.declare_functions(parts));
        self.named(sections.domain, ":derived", |c, parts, _| c.declare_derived(parts));
        self.named(sections.domain, ":action", |c, parts, node| c.action(parts, node));
        self.named(sections.domain, ":derived", |c, parts, node| c.derived(parts, node));
        for (_, node) in std::mem::take(&mut self.unused_functions) {
            let note = node.wrong("no cost depends on this function").severity(Severity::Warning);
            self.faults.notes.push(note.label("not used"));
        }
        self.goals(sections.problem)
    }

    /// Calls a function for each section with a name.
    fn named(&mut self, nodes: &[Node], name: &str, mut then: impl FnMut(&mut Self, &[Node], &Node)) {
        for node in nodes {
            if let Some((found, parts)) = node.form()
                && found == name
            {
                then(self, parts, node);
            }
        }
    }

    /// Notes that a problem names another domain than the one that is given.
    fn note_other_domain(&mut self, sections: &Sections<'_>) {
        let named = sections.problem.iter().find_map(|node| match node.form() {
            Some((":domain", [name])) => Some(name),
            _ => None,
        });
        let (Some(named), Some(given)) = (named, sections.name) else { return };
        if named.word() != given.word() {
            let message = format!("the problem is for the domain `{}`", named.text());
            let note = named.wrong(message).severity(Severity::Warning);
            let note = note.label(format!("the domain that is given is `{}`", given.text()));
            self.faults.notes.push(note.help("check that the two files belong together"));
        }
    }

    /// Reports a section that is not supported, or that is none.
    fn refuse_section(&mut self, node: &Node) {
        const KNOWN: [&str; 15] = [
            ":requirements",
            ":types",
            ":constants",
            ":predicates",
            ":functions",
            ":action",
            ":derived",
            ":domain",
            ":objects",
            ":init",
            ":goal",
            ":goal-reward",
            ":metric",
            ":length",
            ":allocation",
        ];
        let Some((name, _)) = node.form() else {
            self.faults.report::<()>(node.expected("a section such as `(:action …)`"));
            return;
        };
        let (message, help) = match name {
            known if KNOWN.contains(&known) => return,
            ":constraints" => (
                "`:constraints` on whole paths are not supported".to_owned(),
                "a requirement `G condition` in a preference file, or `--require`, keeps a condition on all paths",
            ),
            ":durative-action" => ("actions with a duration are not supported".to_owned(), "write `:action`"),
            ":process" | ":event" => {
                (format!("`{name}` is not supported: problems have no time"), "write `:action`")
            }
            ":fairness" => (
                "`:fairness` of some actions is not supported: all outcomes are fair".to_owned(),
                "leave it out: an action that is taken again and again has each of its outcomes again and again",
            ),
            ":observe" | ":sensing" | ":sensor" => {
                (format!("`{name}` is not supported: all facts are observed"), "write `:action`")
            }
            ":hidden" => (
                "`:hidden` is not supported: all facts of the initial states are known".to_owned(),
                "write the facts into `:init`, where `oneof` lists several initial states",
            ),
            _ => {
                let help = format!("the sections are `{}`", KNOWN.join("`, `"));
                self.faults.report::<()>(node.wrong(format!("unknown section `{name}`")).help(help));
                return;
            }
        };
        self.faults.report::<()>(node.wrong(message).help(help));
    }

    /// Returns the place of a node in the joined text.
    fn joined(&self, node: &Node) -> std::ops::Range<usize> {
        let start = self.starts.iter().find(|(source, _)| Arc::ptr_eq(source, &node.source));
        let start = start.map_or(0, |(_, start)| *start);
        node.span.start + start..node.span.end + start
    }

    fn report<T>(&mut self, wrong: Diagnostic) -> Option<T> {
        self.faults.report(wrong)
    }
}
