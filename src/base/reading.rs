//! Reading of files, and of maps in JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, Visitor};
use sha2::{Digest, Sha256};

use crate::error::{Error, Limit, Result, SourceFile};

/// The maximum size of an input file, in bytes; it stops the reading of endless devices and pipes.
const LARGEST_FILE: u64 = 256 << 20;

impl SourceFile {
    /// Reads a text file; its name is the path.
    ///
    /// # Errors
    /// The file cannot be read, has more than 256 MiB, or is neither UTF-8 nor Latin-1.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        let name = path.display().to_string();
        match File::open(path) {
            Ok(file) => Self::read(name, file),
            Err(e) => Err(Error::reading(path, &e)),
        }
    }

    /// Reads a text to its end.
    ///
    /// # Errors
    /// The text cannot be read, has more than 256 MiB, or is neither UTF-8 nor Latin-1.
    pub fn read(name: impl Into<String>, from: impl Read) -> Result<Arc<Self>> {
        let name = name.into();
        let bytes = bytes(&name, from)?;
        text(name, bytes)
    }
}

/// Opens a regular file that the user has not named: opening a named pipe would wait for a writer.
///
/// # Errors
/// The file cannot be opened, or is of another kind.
pub fn regular(path: &Path) -> io::Result<File> {
    match fs::metadata(path)?.is_file() {
        true => File::open(path),
        false => Err(io::Error::other("this is not a regular file")),
    }
}

/// Reads bytes to their end.
///
/// # Errors
/// They cannot be read, or are more than 256 MiB.
pub fn bytes(name: &str, from: impl Read) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(|e| Error::reading(Path::new(name), &e))?;
    if bytes.len() as u64 > LARGEST_FILE {
        let what = format!("{name} has more than {} MiB", LARGEST_FILE >> 20);
        return Err(Limit::Size { what }.into());
    }
    Ok(bytes)
}

/// Returns the SHA-256 of some bytes in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Returns bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Reads a map and refuses duplicate keys, for which readers differ in the value that they choose.
pub fn each_once<'de, D, T>(deserializer: D) -> Result<BTreeMap<String, T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Once<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Once<T> {
        type Value = BTreeMap<String, T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut map = BTreeMap::new();
            while let Some(key) = entries.next_key::<String>()? {
                if map.contains_key(&key) {
                    return Err(A::Error::custom(format!("`{}` occurs twice", key.escape_debug())));
                }
                map.insert(key, entries.next_value()?);
            }
            Ok(map)
        }
    }
    deserializer.deserialize_map(Once(PhantomData))
}

/// Returns bytes as a text, in UTF-8 or else in Latin-1.
///
/// # Errors
/// They are neither: most of them are not letters, digits or signs of ASCII, or some control the terminal.
pub fn text(name: String, bytes: Vec<u8>) -> Result<Arc<SourceFile>> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(SourceFile::new(name, text)),
        Err(e) => {
            let at = e.utf8_error().valid_up_to();
            let bytes = e.as_bytes();
            let is_shown = |b: &u8| !b.is_ascii_control() || b.is_ascii_whitespace();
            if bytes.iter().all(is_shown) && 2 * bytes.iter().filter(|b| b.is_ascii()).count() > bytes.len() {
                // Each byte is the character with its number.
                let read = |bytes: &[u8]| bytes.iter().copied().map(char::from).collect::<String>();
                return Ok(SourceFile::of_latin1(name, read(bytes), read(&bytes[..at]).len()));
            }
            let message = format!("this is not UTF-8 text: byte {at} is invalid");
            Err(Error::Io { path: name, message })
        }
    }
}
