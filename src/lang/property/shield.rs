//! Shield expressions, the form of tempest: `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`.

use std::ops::Range;
use std::sync::Arc;

use meliora_base::error::{Diagnostic, Result, Severity, SourceFile};

/// The part of a shield expression before its property.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShieldExpression {
    /// The name of the shield.
    pub name: String,
    /// True for `PostSafety`: forbidden actions are replaced by the best one.
    pub post: bool,
    /// True for `lambda`, a factor of the best value of each state; false for `gamma`, a bound.
    pub relative: bool,
    /// The text of the number.
    pub number: String,
}

impl ShieldExpression {
    /// Reads the expression before a property, if there is one; returns also the text of the property, at its place.
    ///
    /// # Errors
    /// The kind of the shield or its comparison is unknown.
    pub fn read(source: &Arc<SourceFile>) -> Result<Option<(Self, Arc<SourceFile>)>> {
        let text = &source.text;
        let start = text.len() - text.trim_start().len();
        let is_expression = text[start..].starts_with('<') && !text[start..].starts_with("<<");
        if !is_expression {
            return Ok(None);
        }
        let form = "`<name, PreSafety, lambda=0.9>`, `PostSafety`, or `gamma` for an absolute threshold";
        let wrong = |place: Range<usize>, message: String| {
            Diagnostic::new(source, place, message).help(format!("the form is {form}"))
        };
        let Some(end) = text[start..].find('>').map(|end| start + end) else {
            return Err(wrong(start..text.len(), "the shield expression has no `>`".to_owned()).into());
        };
        let parts: Vec<&str> = text[start + 1..end].split(',').map(str::trim).collect();
        let place = |part: &str| {
            let at = part.as_ptr() as usize - text.as_ptr() as usize;
            at..at + part.len()
        };
        if let [_, "Optimal", ..] = parts[..] {
            let message = "shields for long-run averages (`Optimal`) are not supported".to_owned();
            return Err(wrong(place(parts[1]), message).severity(Severity::Unsupported).into());
        }
        let [name, kind, comparison] = parts[..] else {
            let message = format!("expected a name, a kind and a comparison, found {} parts", parts.len());
            return Err(wrong(start..end + 1, message).into());
        };
        let post = match kind {
            "PreSafety" => false,
            "PostSafety" => true,
            _ => return Err(wrong(place(kind), format!("unknown kind of shield `{kind}`")).into()),
        };
        let (relative, number) = match comparison.split_once('=').map(|(a, b)| (a.trim(), b.trim())) {
            Some(("lambda", number)) => (true, number),
            Some(("gamma", number)) => (false, number),
            _ => return Err(wrong(place(comparison), format!("unknown comparison `{comparison}`")).into()),
        };
        let rest = " ".repeat(end + 1) + &text[end + 1..];
        let [name, number] = [name, number].map(str::to_owned);
        Ok(Some((ShieldExpression { name, post, relative, number }, SourceFile::new(&source.name, rest))))
    }
}
