//! Coalitions of players, in preference files and in properties.

use std::sync::Arc;

use crate::ast::{Ident, Span};
use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_model::Program;

/// Returns a coalition as an entry per player of a game.
///
/// # Errors
/// The model is not a game, or a name is not that of a player.
pub(crate) fn coalition(
    program: &Program,
    source: &Arc<SourceFile>,
    names: &[Ident],
    span: Span,
) -> Result<Vec<bool>> {
    let Some(players) = &program.players else {
        let diagnostic = Diagnostic::new(source, span.range(), "only a game has players");
        return Err(diagnostic.help("a game begins with `smg`").into());
    };
    let words: Vec<&str> = names.iter().map(|name| name.name.as_str()).collect();
    players.named(&words).map_err(|at| {
        let Ident { name, span } = &names[at];
        let message = format!("unknown player `{name}`");
        let help = format!("the players are {}", players.names());
        Diagnostic::new(source, span.range(), message).label("not declared").help(help).into()
    })
}

/// Returns the coalition of a list of players such as `p1,p3`, as an entry per player of a game.
///
/// # Errors
/// The model is not a game, or a name is not that of a player.
pub fn parse_coalition(program: &Program, source: &Arc<SourceFile>) -> Result<Vec<bool>> {
    let (mut names, mut at) = (Vec::new(), 0);
    for word in source.text.split(',') {
        let start = at + (word.len() - word.trim_start().len());
        let span = Span::new(start, start + word.trim().len());
        names.push(Ident { name: word.trim().to_owned(), span });
        at += word.len() + 1;
    }
    coalition(program, source, &names, Span::new(0, source.text.len()))
}
