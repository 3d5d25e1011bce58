//! Labels: the targets of properties, and transient Booleans.

use super::scope::Transient;
use super::state::Lowering;
use crate::ast::{Ident, Span};
use crate::token::BUILT_IN_LABELS;
use meliora_base::error::Severity;
use meliora_base::value::Type;
use meliora_model::expr::ExprId;

impl Lowering<'_> {
    /// Returns the named state sets: the given targets of properties, and transient Booleans. A name of
    /// two different sets is a name of neither.
    pub(super) fn labels(&mut self, mut labels: Vec<(String, ExprId)>) -> Vec<(String, ExprId)> {
        for index in 0..self.transients.len() {
            let Transient { variable, instance, element, .. } = &self.transients[index];
            let Ident { name, span } = &variable.name;
            if variable.ty.ty != Type::Bool || instance.is_some() || element.is_some() {
                continue;
            }
            // A label without a value, such as one given by two automata, is not an error until it is
            // used.
            let told = self.lowerer.diagnostics.len();
            let value = self.transient(index, *span);
            self.lowerer.diagnostics.truncate(told);
            match (value, labels.iter().position(|(known, _)| known == name)) {
                (Some(id), None) => labels.push((name.clone(), id)),
                (Some(id), Some(known)) if labels[known].1 != id => {
                    labels.remove(known);
                    self.no_label(name, *span, "a property and this variable have the name");
                }
                _ => {}
            }
        }
        let (built_in, labels) =
            labels.into_iter().partition(|(name, _)| BUILT_IN_LABELS.contains(&name.as_str()));
        let built_in: Vec<(String, ExprId)> = built_in;
        for (name, _) in built_in {
            let property = self.model.properties.iter().find(|property| property.name == name);
            let span = property.map_or(Span::default(), |property| property.span);
            self.no_label(&name, span, "the name has a meaning of its own in properties");
        }
        labels
    }

    /// Warns that a name is not a label of the model.
    fn no_label(&mut self, name: &str, span: Span, reason: &str) {
        let message = format!("\"{name}\" is not a label of the model: {reason}");
        let help = "rename the property or the variable";
        self.warnings.push(self.lowerer.wrong(span, message).severity(Severity::Warning).help(help));
    }
}
