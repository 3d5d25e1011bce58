//! Objects that a domain names without declaring them: some collections leave that to their problems.

use ahash::AHashMap;

use super::Checker;
use crate::syntax::Node;
use meliora_base::error::Severity;

/// The types of the parameters of each predicate.
type Parameters = AHashMap<String, Vec<Vec<String>>>;

impl Checker {
    /// Declares the objects that actions and rules of the domain name in atoms, and that nothing declares.
    /// They get the types of the parameters that they stand for. A note shows the first one.
    pub(super) fn declare_implied(&mut self, domain: &[Node]) {
        let faults = self.faults.errors.len();
        let mut parameters = Parameters::default();
        self.named(domain, ":predicates", |checker, parts, _| {
            for (name, rest) in parts.iter().filter_map(Node::form) {
                let types = checker.typed_list(rest).into_iter().map(|(_, of)| checker.type_names(of));
                parameters.insert(name.to_owned(), types.collect());
            }
        });
        // Faults in this section are reported when predicates are declared.
        self.faults.errors.truncate(faults);
        let declared = self.objects.len();
        let mut first = None;
        for section in [":derived", ":action"] {
            self.named(domain, section, |checker, parts, _| {
                parts.iter().for_each(|part| checker.imply(part, (&parameters, declared), &mut first));
            });
        }
        if let Some(node) = first {
            let (name, others) = (node.text(), self.objects.len() - declared - 1);
            let also = if others > 0 { format!(" (and {others} more)") } else { String::new() };
            let note = node.wrong(format!("`{name}` is not declared{also}")).severity(Severity::Warning);
            let note = note.label("taken for an object of the type that stands here");
            self.faults.notes.push(note.help("declare it in `:objects` of the problem, or in `:constants`"));
        }
        self.types.known.clear();
    }

    /// Declares the objects of the atoms in a condition or an effect.
    fn imply(&mut self, node: &Node, known: (&Parameters, usize), first: &mut Option<Node>) {
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            let parts = node.list().unwrap_or_default();
            match node.form().and_then(|(name, rest)| Some((known.0.get(name)?, rest))) {
                Some((types, arguments)) => {
                    for (argument, of) in arguments.iter().zip(types) {
                        self.imply_object(argument, of, known.1, first);
                    }
                }
                None => open.extend(parts.iter().rev()),
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
