//! Atoms of planning problems in expressions: `at(robot,kitchen)`, `hand-free` or `near(l1-1,l2-1)`.

use std::sync::Arc;

use crate::ast::{BinaryOp, Expr, Node, NodeKind};
use meliora_base::error::SourceFile;
use meliora_model::planning::Planning;

/// Returns an expression with a label in place of each atom. An atom looks like a name, a call or, with
/// hyphens, like differences of such; its text tells it.
pub(crate) fn as_labels(expression: &Expr, source: &Arc<SourceFile>, planning: &Planning) -> Expr {
    let mut nodes: Vec<Node> = Vec::with_capacity(expression.nodes.len());
    // The first node of each operand.
    let mut starts: Vec<usize> = Vec::new();
    for node in &expression.nodes {
        let operands = starts.len() - node.kind.operands().min(starts.len());
        let start = starts.get(operands).copied().unwrap_or(nodes.len());
        starts.truncate(operands);
        starts.push(start);
        let text = source.text.get(node.span.range()).unwrap_or_default();
        let may_be =
            matches!(node.kind, NodeKind::Name(_) | NodeKind::Call(..) | NodeKind::Binary(BinaryOp::Sub));
        if may_be && planning.named(text).is_some() {
            nodes.truncate(start);
            nodes.push(Node { kind: NodeKind::Label(text.into()), span: node.span });
        } else {
            nodes.push(node.clone());
        }
    }
    Expr { nodes }
}
