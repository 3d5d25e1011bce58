//! Comma-separated values.

use ::csv::{Writer, WriterBuilder};

/// Returns rows as lines, quoted where RFC 4180 requires it; lines end with a line feed.
pub fn lines<R: IntoIterator<Item: AsRef<[u8]>>>(rows: impl IntoIterator<Item = R>) -> String {
    let mut lines = Lines::default();
    rows.into_iter().for_each(|row| lines.push(row));
    lines.text()
}

/// Lines that are written row by row.
pub struct Lines(Writer<Vec<u8>>);

impl Default for Lines {
    fn default() -> Self {
        Lines(WriterBuilder::new().flexible(true).from_writer(Vec::new()))
    }
}

impl Lines {
    /// Adds a row.
    pub fn push<R: IntoIterator<Item: AsRef<[u8]>>>(&mut self, row: R) {
        // Without a check of the lengths of rows, writing to memory does not fail.
        let _ = self.0.write_record(row);
    }

    /// Returns all lines.
    pub fn text(self) -> String {
        let bytes = self.0.into_inner().unwrap_or_default();
        String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned())
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn cells_are_quoted_where_needed_and_rows_may_differ_in_length() {
        let rows = [vec!["a", "b,c", "say \"d\""], vec!["two\nlines", ""]];
        assert_eq!(super::lines(rows), "a,\"b,c\",\"say \"\"d\"\"\"\n\"two\nlines\",\n");
    }
}
