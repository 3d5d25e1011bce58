//! The statements of a property file.

use std::ops::Range;

use meliora_base::error::{Limit, Result, SourceFile};

/// Maximum number of statements in a property file.
const MOST_STATEMENTS: usize = 10_000;

/// Keywords that start definitions.
const DEFINITIONS: &[&str] = &["const", "label", "formula"];

/// Returns true if a statement is a definition, not a property.
pub(super) fn is_definition(source: &SourceFile, range: &Range<usize>) -> bool {
    DEFINITIONS.contains(&word(&source.text[range.clone()]))
}

/// Returns the first word of a statement.
pub(super) fn word(text: &str) -> &str {
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default()
}

/// Splits off `"name":` at the beginning; returns the name and the offset of the rest.
pub(super) fn named(text: &str) -> (Option<String>, usize) {
    let found = text.strip_prefix('"').and_then(|rest| {
        let (name, rest) = rest.split_once('"')?;
        let rest = rest.trim_start().strip_prefix(':')?;
        Some((name.to_owned(), text.len() - rest.len()))
    });
    found.map_or((None, 0), |(name, start)| (Some(name), start))
}

/// Returns the ranges of the statements, without preceding comments and, except for definitions,
/// without the semicolon.
///
/// # Errors
/// Too many statements.
pub(super) fn statements(source: &SourceFile) -> Result<Vec<Range<usize>>> {
    let found = split(&source.text);
    if found.len() > MOST_STATEMENTS {
        let what = format!("{} has more than {MOST_STATEMENTS} statements", source.name);
        return Err(Limit::Size { what }.into());
    }
    Ok(found)
}

fn split(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut end, mut depth) = (None, 0usize, 0usize);
    let mut bytes = text.bytes().enumerate().peekable();
    let mut is_definition = false;
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b'/' if bytes.peek().is_some_and(|(_, next)| *next == b'/') => {
                // Skips to the end of the line, which ends a statement as usual.
                while bytes.next_if(|(_, b)| *b != b'\n').is_some() {}
                continue;
            }
            b'"' => {
                start.get_or_insert(at);
                end = at + 1;
                while let Some((at, b)) = bytes.next_if(|(_, b)| *b != b'\n') {
                    end = at + 1;
                    if b == b'"' {
                        break;
                    }
                }
                continue;
            }
            b'\n' if depth == 0 && !is_definition && !goes_on(text, start, end, at) => {}
            b';' => {}
            _ if byte.is_ascii_whitespace() => continue,
            _ => {
                if start.is_none() {
                    start = Some(at);
                    let word = text[at..].split(|c: char| !c.is_alphanumeric()).next();
                    is_definition = word.is_some_and(|word| DEFINITIONS.contains(&word));
                }
                match byte {
                    b'(' | b'[' | b'{' => depth += 1,
                    b')' | b']' | b'}' => depth = depth.saturating_sub(1),
                    _ => {}
                }
                end = at + 1;
                continue;
            }
        }
        if let Some(start) = start.take() {
            let semicolon = if byte == b';' && is_definition { at + 1 } else { end };
            found.push(start..semicolon);
        }
        (depth, is_definition) = (0, false);
    }
    found.extend(start.map(|start| start..end));
    found
}

/// Returns true if a property continues on the next line: only its name is there so far, or an
/// operator stands at the end of this line or the beginning of the next.
fn goes_on(text: &str, start: Option<usize>, end: usize, line_end: usize) -> bool {
    let Some(start) = start else { return true };
    let so_far = &text[start..end];
    let next = text[line_end..].trim_start();
    let operator = |c: char| matches!(c, '&' | '|' | '=' | '<' | '>' | '?' | ':' | '+' | '*' | ',' | '!');
    so_far.ends_with(operator)
        || (next.starts_with(|c: char| operator(c) && c != '!') && !next.starts_with("<<"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "// what is asked\nconst int k = 2;\nlabel \"far\" =\n  x >= k;\n\n\"one\": P>=1 [ F \"far\" ];\n\
        P>0 [ F x=9 ] // the last state\n\"two\":\n  Pmax=? [ F \"far\" ]\nR{\"steps\"}min=? [ F x=9 ]; P<1 [ F\n y=1 ]";

    #[test]
    fn statements_end_with_semicolons_and_properties_with_lines_too() {
        let found: Vec<&str> = split(FILE).into_iter().map(|r| &FILE[r]).collect();
        assert_eq!(
            found,
            [
                "const int k = 2;",
                "label \"far\" =\n  x >= k;",
                "\"one\": P>=1 [ F \"far\" ]",
                "P>0 [ F x=9 ]",
                "\"two\":\n  Pmax=? [ F \"far\" ]",
                "R{\"steps\"}min=? [ F x=9 ]",
                "P<1 [ F\n y=1 ]",
            ]
        );
    }
}
