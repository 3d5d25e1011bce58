//! Model files of any format, recognised by their content, and the formats that list states one by one.
//!
//! - [`Document`]: a model as it was read, perhaps with files next to it, or an archive.
//! - [`load`]: a model from a text.
//! - [`umb`]: the files of the unified Markov binary format, also for writers.
//!
//! ```
//! use meliora_base::error::SourceFile;
//! use meliora_base::progress::NoProgress;
//! use meliora_formats::Document;
//! use meliora_lang::Given;
//!
//! let none = SourceFile::new("nothing", "");
//! let given = Given { constants: none.clone(), bounds: none };
//! // Transitions in PRISM's explicit format: two states with a choice each.
//! let text = "2 2 2\n0 0 1 1 go\n1 0 1 1 stay\n";
//! let program = Document::new(SourceFile::new("m.tra", text)).load(&given, &NoProgress)?.program;
//! assert_eq!(program.actions, ["go", "stay"]);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod document;
mod table;
pub mod umb;

use std::sync::Arc;

use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::progress::{NoProgress, ProgressSink};
use meliora_lang::names::displayed;
use meliora_lang::{Checked, Given};
use table::Frame;

pub use document::Document;
pub use table::RewardFiles;

/// Reads a model from a text and flattens it: in PRISM's language, in JANI, state by state (Storm's
/// DRN, or PRISM's transitions), or as a planning problem in PDDL. `constants` has the form `K=4,N=3` and may be empty.
///
/// # Errors
/// The text is not a model.
pub fn load(source: &Arc<SourceFile>, constants: &Arc<SourceFile>) -> Result<Checked> {
    load_with_progress(source, constants, &NoProgress)
}

/// Same as [`load`], with a progress sink that can cancel the work.
///
/// # Errors
/// The text is not a model; a limit.
pub fn load_with_progress(
    source: &Arc<SourceFile>,
    constants: &Arc<SourceFile>,
    sink: &dyn ProgressSink,
) -> Result<Checked> {
    load_given(source, &Given::constants_only(constants), sink)
}

/// Same as [`load_with_progress`], with bounds for unbounded integers.
///
/// # Errors
/// See [`load_with_progress`].
pub fn load_given(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
    if meliora_pddl::is_pddl(&source.text) {
        return problem(std::slice::from_ref(source), false, given, sink);
    }
    let frame = Frame { source, given, sink };
    if table::is_drn(source) {
        return table::load_drn(&frame).map(displayed);
    }
    if table::is_tra(source) {
        return table::load_tra(&frame, None, None, &[]).map(displayed);
    }
    meliora_lang::load_given(source, given, sink)
}

/// Reads a planning problem from the texts of its domain and its problem, or from one text with both.
///
/// # Errors
/// The texts are wrong; constants or bounds are given; a limit.
fn problem(
    sources: &[Arc<SourceFile>],
    for_goals: bool,
    given: &Given,
    sink: &dyn ProgressSink,
) -> Result<Checked> {
    for (values, what) in [(&given.constants, "constants"), (&given.bounds, "unbounded integers")] {
        if !values.text.trim().is_empty() {
            let message = format!("a planning problem has no {what}");
            return Err(Diagnostic::new(values, 0..values.text.len(), message).into());
        }
    }
    let load = if for_goals { meliora_pddl::load_for_goals } else { meliora_pddl::load };
    let planned = load(sources, sink)?;
    Ok(displayed(Checked { program: planned.program, warnings: planned.warnings, properties: Vec::new() }))
}
