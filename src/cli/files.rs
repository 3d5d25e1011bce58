//! Files that appear whole or not at all.

use std::fs::Permissions;
use std::io::Write;
use std::path::Path;

use meliora::error::Error;
use tempfile::{Builder, NamedTempFile};

/// Writes a text beside the place where [`persist`] will put it.
///
/// # Errors
/// The folder is not there or takes no files; the disk is full.
pub(super) fn prepare(path: &Path, text: &str) -> Result<NamedTempFile, Error> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = Builder::new();
    let permissions = usual_permissions();
    if let Some(permissions) = permissions {
        builder.permissions(permissions);
    }
    let written = builder.tempfile_in(folder).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        Ok(file)
    });
    written.map_err(|e| Error::writing(path, &e))
}

/// Puts a file in its place.
///
/// # Errors
/// The place takes no file.
pub(super) fn persist(file: NamedTempFile, path: &Path) -> Result<(), Error> {
    file.persist(path).map_err(|e| Error::writing(path, &e.error))?;
    Ok(())
}

/// Those of any other new file; a temporary file would be its owner's alone.
#[cfg(unix)]
fn usual_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

/// Elsewhere, folders decide.
#[cfg(not(unix))]
fn usual_permissions() -> Option<Permissions> {
    None
}
