//! Writes the files that follow from the types of the reports: their schemas, the table of `docs/json.md` and the
//! types of the Python package. `INSTA_UPDATE=always` writes them again.

use std::fs;
use std::path::{Path, PathBuf};

use super::python_types::python_types;
use super::schema::schemas;
use super::tables::with_table;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Checks that a file has this text, or writes it.
fn has(file: &str, text: &str) {
    let path = root().join(file);
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        fs::write(&path, text).unwrap();
    }
    let same = fs::read_to_string(&path).is_ok_and(|written| written == text);
    assert!(
        same,
        "{file} is out of date; `INSTA_UPDATE=always cargo test -p meliora-report schema` writes it"
    );
}

#[test]
fn the_files_have_the_schemas_of_the_reports() {
    let schemas = schemas();
    for (name, schema) in &schemas {
        has(&format!("docs/schema/{name}.json"), &format!("{schema:#}\n"));
    }
    assert_eq!(fs::read_dir(root().join("docs/schema")).unwrap().count(), schemas.len());
}

#[test]
fn the_page_names_the_fields_of_the_schemas() {
    let page = fs::read_to_string(root().join("docs/json.md")).unwrap();
    has("docs/json.md", &with_table(&page, &schemas()));
}

#[test]
fn the_python_package_has_the_types_of_the_schemas() {
    has("python/lib/meliora/reports.py", &python_types(&schemas()));
}
