//! Files of an analysis: dumps, and states one by one.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use meliora::commands::explicit_files::{ExplicitFiles, ExplicitFormat};
use pyo3::prelude::*;

use crate::analysis::Analysis;
use crate::errors::usage;
use crate::options::{count, named};
use crate::worker::Call;

#[pymethods]
impl Analysis {
    /// Writes all regions and strategies as decision diagrams into a folder, with a certificate, as
    /// `meliora export` does. `Dump` reads them, and `verify` checks them. An older dump is replaced.
    ///
    /// Raises:
    ///     OSError: The folder contains something else, or cannot be written.
    #[pyo3(signature = (folder, *, timeout=None, progress=None))]
    fn export(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        if folder.as_os_str().is_empty() {
            return Err(usage("the dump needs the name of a folder"));
        }
        let source = Arc::clone(&self.origin.preferences.get().source);
        let call = Call::new(timeout, progress)?;
        self.handle.call(py, &call, "export", move |analysis| analysis.export(&source, &folder))
    }

    /// Returns the states one by one for other programs, as `meliora export --format` writes them: the content of each
    /// file by its name.
    ///
    /// Args:
    ///     format: "explicit" (PRISM's `.tra`, `.sta`, `.lab`), "drn" (Storm) or "umb".
    ///     strategy: The strategy whose induced model is written, such as "sasi" or "plan:progress", with a table of its
    ///         actions; None for the model itself.
    ///     objective: The objective of the strategy "achieve".
    ///     limit: Maximum number of states.
    ///     timeout, progress: As in `Model.explore`.
    ///
    /// Raises:
    ///     TooLarge: There are more than `limit` states.
    #[pyo3(signature = (format="drn", strategy=None, *, objective=None, limit=1_000_000, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn explicit_files(
        &self,
        py: Python<'_>,
        format: &str,
        strategy: Option<&str>,
        objective: Option<String>,
        limit: i128,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<BTreeMap<String, Cow<'static, [u8]>>> {
        let wrong = |wrong: String| usage(format!("strategy={strategy:?}: {wrong}"));
        let files = ExplicitFiles {
            format: named("format", format, ExplicitFormat::ALL, ExplicitFormat::name)?,
            strategy: strategy.map(str::parse).transpose().map_err(wrong)?,
            objective,
            limit: count("limit", limit)?,
        };
        let call = Call::new(timeout, progress)?;
        let found = self.handle.call(py, &call, "export", move |analysis| {
            let program = analysis.program();
            files.refuse_game(program)?;
            let graph = files.graph(analysis, program)?;
            let contents = files.contents(&graph, analysis, program, None)?;
            Ok(files.names().into_iter().zip(contents).collect::<Vec<_>>())
        })?;
        Ok(found.into_iter().map(|(name, content)| (name, Cow::Owned(content))).collect())
    }
}
