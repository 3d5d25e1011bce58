//! From the text to the tree: checks the shape of the document, and reports several errors per run.

mod composition;
mod expr;
mod filter;
pub(super) mod model;
mod nested;
mod path;
pub(super) mod property;
pub(super) mod reader;
pub(super) mod record;
pub(super) mod types;

use std::sync::Arc;

use meliora_base::error::{Result, SourceFile};
use meliora_base::progress::ProgressSink;
use model::Model;
use reader::Reader;
use record::Read;

/// Parses the tree of a model.
///
/// # Errors
/// The text is not JSON, is not a model, or uses unsupported constructs.
pub(super) fn model(source: &Arc<SourceFile>, sink: &dyn ProgressSink) -> Result<Model> {
    let document = reader::document(source)?;
    let mut reader = Reader::new(source, sink);
    let model = Model::read(&mut reader, document.root(), "the model").map(Model::with_assignments_of_edges);
    let model = model.and_then(|model| model.with_flat_system(&mut reader));
    reader.finish(model)
}
