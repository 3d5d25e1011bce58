//! Objects that a domain names without declaring them: some collections leave that to their problems.

use super::types::{Declared, ROOT};
use super::{Checker, Sections};
use crate::syntax::Node;
use meliora_base::error::Severity;

impl Checker {
    /// Declares the objects that actions and rules of the domain name in atoms, and that nothing declares.
    /// They get the types of the parameters that they stand for. A note shows the first one.
    pub(super) fn declare_implied(&mut self, domain: &[Node], predicates: &[Declared]) {
        let declared = self.objects.len();
        let mut first = None;
        // The head of a rule consists of variables, and so do the parameters of an action.
        self.named(domain, ":derived", |checker, parts, _| {
            parts.iter().skip(1).for_each(|body| checker.imply(body, (predicates, declared), &mut first));
        });
        self.named(domain, ":action", |checker, parts, _| {
            let pairs = parts.get(1..).unwrap_or_default().chunks(2);
            let inner = pairs.filter(|pair| matches!(pair[0].word(), Some(":precondition" | ":effect")));
            let inner = inner.filter_map(|pair| pair.get(1));
            inner.for_each(|part| checker.imply(part, (predicates, declared), &mut first));
        });
        if let Some(node) = first {
            let (name, others) = (node.text(), self.objects.len() - declared - 1);
            let also = if others > 0 { format!(" (and {others} more)") } else { String::new() };
            let note = node.wrong(format!("`{name}` is not declared{also}")).severity(Severity::Warning);
            let note = note.label("taken for an object of the type that stands here");
            self.faults.notes.push(note.help("declare it in `:objects` of the problem, or in `:constants`"));
        }
    }

    /// Declares the objects that only facts of `:init` name which no action changes and no rule defines. They have no
    /// type but `object`. A note shows the first one.
    pub(super) fn declare_initial(&mut self, sections: &Sections<'_>, predicates: &[Declared]) {
        let mut changed = Vec::new();
        for node in sections.domain {
            let effects = node.list().unwrap_or_default().windows(2);
            changed.extend(effects.filter(|pair| pair[0].word() == Some(":effect")).map(|pair| &pair[1]));
        }
        let mut is_static: Vec<&str> = predicates.iter().map(|declared| declared.name.as_str()).collect();
        while let Some(node) = changed.pop() {
            let parts = node.list().unwrap_or_default();
            changed.extend(parts);
            is_static.retain(|name| parts.first().is_none_or(|first| first.word() != Some(*name)));
        }
        let mut first = None;
        self.named(sections.problem, ":init", |checker, parts, _| {
            for (name, arguments) in parts.iter().filter_map(Node::form) {
                let unknown =
                    |node: &&Node| node.word().is_some_and(|word| !checker.object_of.contains_key(word));
                let of = vec![ROOT.to_owned()];
                for node in arguments.iter().filter(unknown).cloned().collect::<Vec<_>>() {
                    if is_static.contains(&name) {
                        checker.imply_object(&node, &of, 0, &mut first);
                    }
                }
            }
        });
        if let Some(node) = first {
            let note = node.wrong(format!("`{}` is not declared", node.text())).severity(Severity::Warning);
            let note = note.label("taken for an object of the type `object`");
            self.faults.notes.push(note.help("declare it in `:objects`"));
        }
    }

    /// Declares the objects of the atoms in a condition or an effect.
    fn imply(&mut self, node: &Node, known: (&[Declared], usize), first: &mut Option<Node>) {
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            let parts = node.list().unwrap_or_default();
            let name = node.form().map(|(name, _)| name);
            match known.0.iter().find(|declared| Some(declared.name.as_str()) == name) {
                Some(declared) => {
                    for (argument, of) in parts.iter().skip(1).zip(&declared.parameters) {
                        self.imply_object(argument, of, known.1, first);
                    }
                }
                None => {
                    let variables = usize::from(matches!(name, Some("forall" | "exists")));
                    open.extend(parts.iter().skip(2 * variables).rev());
                }
            }
        }
    }

    fn imply_object(&mut self, node: &Node, of: &[String], declared: usize, first: &mut Option<Node>) {
        let Some(name) = node.word().filter(|name| !name.starts_with('?')) else { return };
        match self.object_of.get(name) {
            Some(&object) if (object as usize) < declared => {}
            Some(&object) => {
                let types = &mut self.types.of_object[object as usize];
                types.extend(of.iter().filter(|name| !types.contains(name)).cloned().collect::<Vec<_>>());
            }
            None => {
                self.add_object(node, of.to_vec());
                first.get_or_insert_with(|| node.clone());
            }
        }
    }
}
