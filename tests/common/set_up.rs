//! Set-ups that many tests share: a model, preferences and a finished analysis.

use super::prelude::*;

/// The checked program of a text without open constants.
#[track_caller]
pub(crate) fn parsed(model: impl Into<String>) -> Program {
    lang::load(&SourceFile::new("m", model.into()), &SourceFile::new("c", "")).unwrap().program
}

/// A model with the preferences of another text.
#[track_caller]
pub(crate) fn task(model: impl Into<String>, wishes: impl Into<String>) -> (Arc<Program>, Arc<Preferences>) {
    let read = lang::load_preferences(&SourceFile::new("p", wishes.into()), parsed(model)).unwrap();
    (Arc::new(read.program), Arc::new(read.preferences))
}

/// The analysis with all its phases.
#[track_caller]
pub(crate) fn finished<E: Engine>(
    engine: &Arc<E>,
    preferences: &Arc<Preferences>,
    options: Options,
) -> Analysis<E> {
    let mut analysis = Analysis::new(engine, preferences, options);
    analysis.run(&mut |_| ()).unwrap();
    analysis
}
