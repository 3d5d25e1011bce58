//! Comma-separated values.

use ::csv::WriterBuilder;

/// Returns rows as lines, quoted where RFC 4180 requires it; lines end with a line feed.
pub fn lines<R: IntoIterator<Item: AsRef<[u8]>>>(rows: impl IntoIterator<Item = R>) -> String {
    // Without a check of the lengths of rows, writing to memory does not fail.
    let mut out = WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for row in rows {
        let _ = out.write_record(row);
    }
    String::from_utf8_lossy(&out.into_inner().unwrap_or_default()).into_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn cells_are_quoted_where_needed_and_rows_may_differ_in_length() {
        let rows = [vec!["a", "b,c", "say \"d\""], vec!["two\nlines", ""]];
        assert_eq!(super::lines(rows), "a,\"b,c\",\"say \"\"d\"\"\"\n\"two\nlines\",\n");
    }
}
